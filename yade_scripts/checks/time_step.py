"""Does the time step resolve the contact, and is one that does not refused?

Uncorrected ``en`` = .6 at growing steps shows what the correction has to mend (its drift) and what it cannot
(the spread over sub-step phases, half of which is the limit below); the guards must stop what lies beyond.

    yade -n -x yade_scripts/checks/time_step.py [--json FILE]
"""

import dataclasses
import sys
from pathlib import Path

sys.path.insert(0, str(Path(sys.argv[0]).resolve().parent))  # __file__ is that of yade itself

from rows import SCRIPTS, Rows

from contact_model import Solid, measure_rebounds, p_wave_step_s
from glue.errors import InputError
from glue.flow.restitution import RestitutionLaw
from glue.scene.reader import read_scene
from run_plan import plan_run

STEEL = Solid(E_Pa=210e9, nu=0.3, density_kg_m3=7800.0)
ALUMINIUM = Solid(E_Pa=73.1e9, nu=0.33, density_kg_m3=2780.0)
P = p_wave_step_s(1e-3, STEEL)
SCENE = read_scene(SCRIPTS.parent / "glue" / "scene" / "examples" / "al2024-s390.toml")


def refused(restitution=0.34, dt_over_P=1.0, **shots) -> str:
    """The reason for which a run is refused, empty when it is not."""
    scene = dataclasses.replace(SCENE, media=(dataclasses.replace(SCENE.shots, **shots),))
    try:
        plan_run(scene, RestitutionLaw(restitution), dt_over_P)
    except InputError as e:
        return "; ".join(e.problems)
    return ""


rows = Rows("time step of the contact")
rows.near("P-wave step of 1 mm steel [s]", P, 9.64e-8, 0.001)
for dt_over_P, drift, spread in ((0.1, 0.001, 0.002), (0.3, 0.003, 0.006), (1.0, 0.01, 0.02)):
    e = [
        r.restitution
        for r in measure_rebounds(
            STEEL,
            ALUMINIUM,
            pair="target",
            en=0.6,
            speed_m_s=60.0,
            diameter_m=1e-3,
            dt_s=dt_over_P * P,
            phases=16,
        )
    ]
    mean = sum(e) / len(e)
    rows.below(
        f"dt {dt_over_P} P: drift of the mean rebound, en .6", abs(mean / 0.6 - 1), drift, f"mean {mean:.4f}"
    )
    rows.below(
        f"dt {dt_over_P} P: half spread over the mean",
        0.5 * (max(e) - min(e)) / mean,
        spread,
        f"{min(e):.4f}-{max(e):.4f}",
    )
small = SCENE.shots.diameter_m * (1 - 2.5 * 0.1)
mixed = dataclasses.replace(
    SCENE, media=(dataclasses.replace(SCENE.shots, size="distribution", size_cv=0.1),)
)
rows.near(
    "mixed sizes: the step follows the smallest shot [s]",
    plan_run(mixed, RestitutionLaw(0.34), 1.0).dt_s,
    p_wave_step_s(small, STEEL),
    1e-12,
)
rows.true("the working step is accepted", not refused())
for name, wrong in {
    "dt 2 P": dict(dt_over_P=2.0),
    "dt 0": dict(dt_over_P=0.0),
    "restitution 0": dict(restitution=0.0),
    "restitution .97": dict(restitution=0.97),
    "a softened shot, E / 1000": dict(E_Pa=210e6),
    "sizes down to nothing, cv .4": dict(size="distribution", size_cv=0.4),
}.items():
    reason = refused(**wrong)
    rows.true(f"refused before the run: {name}", bool(reason), reason[:90])
rows.finish()
