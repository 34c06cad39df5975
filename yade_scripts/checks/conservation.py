"""A short dense stream, simulated and logged as any run: what must be conserved is, what must be exact is.

10 kg/min of 1 mm steel at 60 m/s for 4 ms: elastic and frictionless, then as it is (e .6 on the target, .8
between shots, friction .2), normal and oblique.

    yade -n -x yade_scripts/checks/conservation.py [--json FILE]
"""

import tempfile
import sys
from pathlib import Path

sys.path.insert(0, str(Path(sys.argv[0]).resolve().parent))  # __file__ is that of yade itself

from rows import Rows

import numpy as np

import shot_flow
from glue.flow.arrivals import read_arrivals
from glue.flow.impacts import read_impacts

SCENE = """
schema = 1
name = "conservation"
seed = 5
exposure_time_s = 0.004
[shots]
grade = "S390"
[nozzle]
speed_m_s = 60.0
mass_flow_kg_s = 0.16667
jet_diameter_m = 0.020
stand_off_m = 0.03
impact_angle_deg = {angle}
[target]
material = "al2024-t351"
window_m = [0.004, 0.004]
[restitution]
shot_target = {e_target}
shot_shot = {e_shot}
[friction]
shot_target = {friction}
shot_shot = {friction}
"""


def simulate(folder: Path, *options: str, **values):
    """Run the case; returns (report, arrivals, impacts)."""
    (folder / "scene.toml").write_text(SCENE.format(**values))
    report = {}
    shot_flow.run(shot_flow.parse([str(folder / "scene.toml"), str(folder), *options]), report)
    return report, read_arrivals(folder / "arrivals.csv")[0], read_impacts(folder / "impacts.csv")[0]


rows = Rows("conservation in a dense stream, dt 1.0 P")
cases = {
    "elastic": dict(angle=90.0, e_target=1.0, e_shot=1.0, friction=0.0),
    "real": dict(angle=90.0, e_target=0.6, e_shot=0.8, friction=0.2),
    "real, 45 degrees": dict(angle=45.0, e_target=0.6, e_shot=0.8, friction=0.2),
}
for case, values in cases.items():
    with tempfile.TemporaryDirectory() as folder:
        report, arrivals, impacts = simulate(Path(folder), **values)
    for row in report["checks"]:
        rows.true(f"{case}: {row['name']}", row["passed"], f"{row['value']:.6g}, limit {row['limit']:.6g}")
    if case == "elastic":
        left = next(r["value"] for r in report["checks"] if r["name"].startswith("kinetic energy left"))
        rows.near(
            "elastic: kinetic energy left over fed",
            left,
            1.0,
            0.001,
            f"{report['shot_shot_collisions']} collisions",
        )

    free = impacts[impacts["collisions_before"] == 0]
    came = arrivals[np.searchsorted(arrivals["shot_id"], free["shot_id"])]
    rows.below(
        f"{case}: share of shots that collided before they struck", 1.0 - len(free) / len(impacts), 0.9
    )
    exact = all((free[f"v{c}_in_m_s"] == came[f"v{c}_m_s"]).all() for c in "xyz")
    rows.true(
        f"{case}: logged velocity of those that did not, exact",
        exact,
        f"{len(free)} of {len(impacts)} impacts",
    )
    flight = (came["z_m"] - 0.5 * came["diameter_m"]) / -came["vz_m_s"]
    rows.below(
        f"{case}: their moment of touch, off [s]",
        np.abs(free["time_s"] - came["time_s"] - flight).max(),
        1e-17,
    )
    off = np.hypot(free["x_m"] - came["x_m"] - came["vx_m_s"] * flight, free["y_m"] - came["y_m"])
    rows.below(f"{case}: their place of touch, off [m]", off.max(), 1e-16)
    if values["friction"] == 0.0:
        rows.below(
            "elastic: their loss or gain of speed", np.abs(free["vz_out_m_s"] / 60.0 - 1.0).max(), 0.005
        )
    slide = np.hypot(*(impacts[f"v{c}_out_m_s"] - impacts[f"v{c}_in_m_s"] for c in "xy"))
    push = impacts["vz_out_m_s"] - impacts["vz_in_m_s"]
    rows.below(
        f"{case}: sideways over normal impulse, over friction",
        (slide / push).max(),
        1.01 * values["friction"] + 1e-12,
    )

with tempfile.TemporaryDirectory() as folder:
    plain = simulate(Path(folder), "--plain", **cases["real"])[2]
    leaps = simulate(Path(folder), **cases["real"])[2]
same = len(plain) == len(leaps) and all(
    (plain[c] == leaps[c]).all() for c in ("shot_id", "collisions_before")
)
rows.true("leaps over free flight: same impacts of the same shots as without", same, f"{len(plain)} impacts")
if same:
    first = leaps["collisions_before"] == 0
    rows.true(
        "leaps: shots that met no other strike at the same bits",
        (plain["time_s"] == leaps["time_s"])[first].all(),
    )
    moved = np.hypot(plain["x_m"] - leaps["x_m"], plain["y_m"] - leaps["y_m"])
    rows.below(
        "leaps: impacts moved by at most [m]", moved.max(), 1e-6, "rounding, magnified by each collision"
    )
rows.finish()
