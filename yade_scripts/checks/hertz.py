"""Elastic impact on the target against Hertz: peak force and duration, exact in closed form.

1 mm steel on 2024 aluminium, E* = 60.520 GPa.  Also numbers worked out beforehand, so that an error in
the shared closed form cannot hide one in the simulation.

    yade -n -x yade_scripts/checks/hertz.py [--json FILE]
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(sys.argv[0]).resolve().parent))  # __file__ is that of yade itself

from rows import Rows

from contact_model import Solid, contact_modulus_Pa, measure_rebounds, p_wave_step_s
from glue.theory import hertz

STEEL = Solid(E_Pa=210e9, nu=0.3, density_kg_m3=7800.0)
ALUMINIUM = Solid(E_Pa=73.1e9, nu=0.33, density_kg_m3=2780.0)
KNOWN = {1.0: (3.36768, 4.4616e-6), 0.1: (0.212486, 7.0712e-6)}  # m/s: N, s

rows = Rows("elastic impact against Hertz, dt .05 P")
for speed in (0.1, 1.0, 60.0, 300.0):
    (got,) = measure_rebounds(
        STEEL,
        ALUMINIUM,
        pair="target",
        en=1.0,
        speed_m_s=speed,
        diameter_m=1e-3,
        dt_s=0.05 * p_wave_step_s(1e-3, STEEL),
        phases=1,
    )
    exact = hertz.impact(0.5e-3, STEEL.density_kg_m3, speed, contact_modulus_Pa(STEEL, ALUMINIUM))
    rows.near(f"peak force [N], {speed:g} m/s", got.peak_force_N, exact.force_N, 0.005)
    rows.near(f"duration [s], {speed:g} m/s", got.duration_s, exact.contact_time_s, 0.005)
    if speed in KNOWN:
        force, duration = KNOWN[speed]
        rows.near(f"peak force [N], {speed:g} m/s, known value", got.peak_force_N, force, 0.005)
        rows.near(f"duration [s], {speed:g} m/s, known value", got.duration_s, duration, 0.005)
rows.finish()
