"""Pulses: the fed time is the integral of p, and shots even in it are spread by p."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from glue.flow.pulse import fed_time_s, times_when_fed_s
from glue.scene.model import Pulse

PULSES = [
    Pulse("pulsed", 40.0, duty=0.3),
    Pulse("sinusoidal", 40.0, amplitude=0.5),
    Pulse("sinusoidal", 40.0, amplitude=1.0),
]


def flow(pulse, t):
    """p(t) as the scene defines it."""
    if pulse.pattern == "pulsed":
        return 1.0 / pulse.duty if t * pulse.frequency_Hz % 1.0 < pulse.duty else 0.0
    return 1.0 + pulse.amplitude * math.sin(2.0 * math.pi * pulse.frequency_Hz * t)


@pytest.mark.parametrize("pulse", PULSES)
def test_fed_time_is_the_integral_of_the_flow(pulse):
    for end in (0.003, 0.0075, 0.0249, 0.031):
        jumps = [x for k in range(3) for x in (k / 40.0, (k + pulse.duty) / 40.0) if 0.0 < x < end]
        ends = [0.0, *jumps, end]
        exact = sum(quad(lambda t: flow(pulse, t), a, b)[0] for a, b in pairwise(ends))
        assert fed_time_s(pulse, end) == pytest.approx(exact, rel=1e-10)
        assert fed_time_s(pulse, np.array([end]))[0] == pytest.approx(exact, rel=1e-10)
    assert fed_time_s(pulse, 1.0) == pytest.approx(1.0, rel=1e-12)  # mean 1 over whole periods


@pytest.mark.parametrize("pulse", PULSES)
def test_times_lead_back_to_what_was_fed(pulse):
    fed = np.linspace(0.0, 0.1, 4001)[:-1]
    times = times_when_fed_s(pulse, fed)
    assert np.all(np.diff(times) >= 0.0)
    assert np.abs(fed_time_s(pulse, times) - fed).max() < 1e-14
    assert all(flow(pulse, t) > 0.0 for t in times + 1e-12)


def test_steady_flow_is_left_as_it_is():
    fed = np.array([0.1, 0.2])
    assert fed_time_s(None, 0.7) == 0.7 and times_when_fed_s(None, fed) is fed
