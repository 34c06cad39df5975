"""The closed uniaxial response against the rate equations integrated by another method."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from glue.scene.laws import CombinedHardening, HardeningTable, JohnsonCook
from glue.theory.cyclic import uniaxial_stress_Pa

E = 73.1e9
LAW = CombinedHardening(270e6, 80e6, 12.0, ((130e6, 300.0), (60e6, 12.0)))


def test_monotonic_follows_the_flow_curve():
    strains = np.linspace(0.001, 0.1, 30)
    stress = np.array(uniaxial_stress_Pa(E, LAW, strains))
    plastic = strains - stress / E
    yielded = plastic > 1e-9
    assert yielded.sum() > 20
    assert stress[yielded] == pytest.approx([LAW.flow_stress_Pa(p) for p in plastic[yielded]], rel=1e-9)


def test_reversals_against_the_rate_equations():
    """dX = g (X_s nu - X) dp, dp from consistency; integrated with tight tolerance along +-1.5 % strain."""

    def rates(_, y, nu):
        p, x1, x2, strain = y
        (s1, g1), (s2, g2) = LAW.backstresses
        d1, d2 = g1 * (s1 * nu - x1), g2 * (s2 * nu - x2)
        slope = LAW.Q_Pa * LAW.b * np.exp(-LAW.b * p) + nu * (d1 + d2)  # nu d sigma / dp
        return [1.0, d1, d2, nu * (1.0 + slope / E)]

    state, expected = [0.0, 0.0, 0.0], []
    for goal in (0.015, -0.015, 0.015):
        nu = np.sign(goal)
        p, x1, x2 = state
        plastic = 0.0 if not expected else expected[-1][1]
        stress = nu * (LAW.R0_Pa + LAW.Q_Pa * (1 - np.exp(-LAW.b * p))) + x1 + x2
        start = [p, x1, x2, plastic + stress / E]

        def reached(_, y, nu, goal=goal):
            return y[3] - goal

        reached.terminal = True
        end = solve_ivp(rates, (0, 1), start, args=(nu,), events=reached, rtol=1e-11, atol=1e-14).y[:, -1]
        state = end[:3].tolist()
        stress = nu * (LAW.R0_Pa + LAW.Q_Pa * (1 - np.exp(-LAW.b * end[0]))) + end[1] + end[2]
        expected.append((stress, goal - stress / E))
    got = uniaxial_stress_Pa(E, LAW, [0.015, -0.015, 0.015])
    assert got == pytest.approx([stress for stress, _ in expected], abs=1e3)  # 1e-3 MPa


@pytest.mark.parametrize(
    "law", [JohnsonCook(300e6, 500e6, 0.5, saturation_Pa=380e6), HardeningTable((0.0, 0.01, 0.1), (300e6, 350e6, 380e6))]
)
def test_isotropic_laws_cycle_on_their_curve(law):
    """Where it flows, |stress| is the flow stress at the accumulated plastic strain, in both directions."""
    strains = [*np.linspace(0, 0.02, 21)[1:], *np.linspace(0.02, -0.02, 41)[1:]]
    stress = np.array(uniaxial_stress_Pa(70e9, law, strains))
    plastic = np.array(strains) - stress / 70e9
    p = np.cumsum(np.abs(np.diff(plastic, prepend=0.0)))
    flowing = np.abs(np.diff(p, prepend=0.0)) > 1e-6
    assert 40 < flowing.sum() < 60
    assert np.abs(stress[flowing]) == pytest.approx([law.flow_stress_Pa(v) for v in p[flowing]], rel=1e-9)
    assert stress[19] > 0.0 > stress[-1]
