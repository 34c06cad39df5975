"""Does every rebound follow the law: by its own speed, its own shot, and by what struck the spot before?

Single shots, far apart in time and place, through the whole run (arrivals, contacts, log): 1 mm steel at 5 to
100 m/s and its mixture with smaller steel and with glass, under e = .6 (v/60)^-1/4; then shots one after the other
on one spot, under a law that hardens.  Sub-step phases are random, and at one P-wave step a single rebound
scatters by 1 % (checks/time_step.py): means over each group are held to .5 %.

    yade -n -x yade_scripts/checks/restitution_law.py [--json FILE]
"""

import dataclasses
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(sys.argv[0]).resolve().parent))  # __file__ is that of yade itself

from rows import SCRIPTS, Rows

import numpy as np

from flow_run import FlowRun
from glue.flow.arrivals import COLUMNS
from glue.flow.impacts import read_impacts
from glue.flow.restitution import RestitutionLaw
from glue.flow.surface import TargetSurface
from glue.scene.model import SpotHardening
from glue.scene.reader import read_scene
from run_plan import plan_run

SCENE = read_scene(SCRIPTS.parent / "glue" / "scene" / "examples" / "al2024-s390.toml")
STEEL = dataclasses.replace(SCENE.shots, mass_fraction=0.4)
SMALL = dataclasses.replace(STEEL, diameter_m=0.6e-3, mass_fraction=0.3)
GLASS = dataclasses.replace(
    STEEL, diameter_m=0.8e-3, density_kg_m3=2500.0, E_Pa=70e9, nu=0.22, mass_fraction=0.3
)
ALL = dataclasses.replace(SCENE, media=(STEEL, SMALL, GLASS))
LAW = RestitutionLaw(0.6, speed_m_s=60.0, exponent=0.25)
HARDENING = RestitutionLaw(0.4, hardening=SpotHardening(saturated=0.7, hits=2.0), spot_radius_m=0.25e-3)


def impacts(scene, law, *, speeds, media, place):
    """The impacts of one shot of each speed [m/s] and medium at ``place`` (n, 2) [m], straight down, .1 s apart."""
    arrivals = np.zeros(len(speeds), COLUMNS)
    arrivals["shot_id"] = np.arange(len(speeds))
    arrivals["time_s"] = 0.1 * np.arange(len(speeds))
    arrivals["x_m"], arrivals["y_m"], arrivals["z_m"] = *place.T, scene.nozzle.stand_off_m
    arrivals["vz_m_s"] = -speeds
    arrivals["medium"] = media
    arrivals["diameter_m"] = [scene.media[m].diameter_m for m in media]
    arrivals["density_kg_m3"] = [scene.media[m].density_kg_m3 for m in media]
    with tempfile.TemporaryDirectory() as folder:
        FlowRun(scene, plan_run(scene, law, 1.0), arrivals, TargetSurface(), Path(folder), {}).run({})
        log = read_impacts(Path(folder) / "impacts.csv")[0]
    return log[np.unique(log["shot_id"], return_index=True)[1]]  # the first of each shot


rows = Rows("restitution by contact, dt 1.0 P")
rng = np.random.default_rng(7)
count = 90
apart = rng.uniform(-8e-3, 8e-3, (count, 2))
for name, scene, medium in (
    ("1 mm steel", SCENE, 0),
    ("1 mm steel of a mixture", ALL, 0),
    ("0.6 mm steel of a mixture", ALL, 1),
    ("0.8 mm glass of a mixture", ALL, 2),
):
    speeds = np.repeat((5.0, 20.0, 100.0) if medium == 0 else (20.0, 60.0, 100.0), count // 3) * rng.uniform(
        0.98, 1.02, count
    )
    log = impacts(scene, LAW, speeds=speeds, media=np.full(count, medium), place=apart)
    off = -log["vz_out_m_s"] / log["vz_in_m_s"] / np.array([LAW.at(v) for v in speeds]) - 1.0
    for k in range(3):
        group = off[k * count // 3 : (k + 1) * count // 3]
        about = float(speeds[k * count // 3])
        rows.below(
            f"{name}, about {about:.0f} m/s (e {LAW.at(about):.2f}): mean off the law",
            abs(group.mean()),
            0.005,
            f"{group.mean():+.4f}, single ones {group.min():+.3f}..{group.max():+.3f}",
        )

hits, spots = 6, 20
centres = np.stack(np.meshgrid(np.linspace(-4e-3, 4e-3, 5), np.linspace(-3e-3, 3e-3, 4)), -1).reshape(-1, 2)
place = np.tile(centres, (hits, 1)) + rng.uniform(-8e-5, 8e-5, (hits * spots, 2))
log = impacts(
    SCENE, HARDENING, speeds=np.full(len(place), 60.0), media=np.zeros(len(place), int), place=place
)
e = (-log["vz_out_m_s"] / log["vz_in_m_s"]).reshape(hits, spots)
for n in range(hits):
    rows.near(
        f"hardening spot, {n} earlier impacts",
        e[n].mean(),
        HARDENING.at_spot(HARDENING.e, n),
        0.005,
        f"{spots} spots",
    )
rows.finish()
