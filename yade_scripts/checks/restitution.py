"""Is the rebound the one that was asked for?  Over speed, size, restitution; on the target and between shots.

At a small step (.1 P) the contact law itself is tested: its restitution is the given one.  At the working
step (1.0 P) the corrected ``en`` is: its mean over sub-step phases is the wanted one.  The phases here are
other ones than those of the correction.

    yade -n -x yade_scripts/checks/restitution.py [--json FILE]
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(sys.argv[0]).resolve().parent))  # __file__ is that of yade itself

from rows import Rows

from contact_model import Solid, calibrate, measure_rebounds, p_wave_step_s

STEEL = Solid(E_Pa=210e9, nu=0.3, density_kg_m3=7800.0)
ALUMINIUM = Solid(E_Pa=73.1e9, nu=0.33, density_kg_m3=2780.0)

rows = Rows("restitution of the contact law")
for diameter in (0.05e-3, 1e-3, 5e-3):
    fine = 0.1 * p_wave_step_s(diameter, STEEL)
    for speed in (1.0, 60.0, 300.0):
        for e in (0.3, 0.6, 0.9):
            got = measure_rebounds(
                STEEL,
                ALUMINIUM,
                pair="target",
                en=e,
                speed_m_s=speed,
                diameter_m=diameter,
                dt_s=fine,
                phases=2,
            )
            rows.near(
                f"dt .1 P, on target, {diameter * 1e3:g} mm, {speed:g} m/s, e {e}",
                sum(r.restitution for r in got) / len(got),
                e,
                0.005,
            )
for e in (0.3, 0.6, 0.9):
    got = measure_rebounds(
        STEEL,
        ALUMINIUM,
        pair="shot",
        en=e,
        speed_m_s=60.0,
        diameter_m=1e-3,
        dt_s=0.1 * p_wave_step_s(1e-3, STEEL),
        phases=2,
    )
    rows.near(
        f"dt .1 P, shot on shot, 1 mm, 60 m/s, e {e}", sum(r.restitution for r in got) / len(got), e, 0.005
    )

for pair in ("target", "shot"):
    for e in (0.1, 0.34, 0.6, 0.8, 0.94, 1.0):
        rig = dict(
            shot=STEEL,
            target=ALUMINIUM,
            pair=pair,
            speed_m_s=60.0,
            diameter_m=1e-3,
            dt_s=p_wave_step_s(1e-3, STEEL),
        )
        found = calibrate(e, **rig)
        got = [r.restitution for r in measure_rebounds(en=found.en, phases=11, **rig)]
        where = "on target" if pair == "target" else "shot on shot"
        rows.near(
            f"dt 1 P, {where}, corrected, mean of 11 phases, e {e}",
            sum(got) / len(got),
            e,
            0.005,
            f"en {found.en:.4f}, spread {min(got):.4f}-{max(got):.4f}",
        )
rows.finish()
