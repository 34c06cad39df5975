"""The cells that need YADE's contact, many in one process: run by ``cells_contact.py`` inside ``yade``.

    yade -n -x tests/extremes/contact_rig.py JOBS

JOBS: JSON, a list of {"id", "scene" (text of a scene file), "e", "dt_over_P", "phases"}.  Each is planned as a run
is (``run_plan.plan_run``), which refuses or gives the contacts that it would use; those are measured with shots thrown
at the target and at each other, at sub-step phases that the plan did not use.  One line "cell {...}" each, as it is done.
"""

import json
import sys
import tempfile
import traceback
from pathlib import Path

ROOT = Path(sys.argv[0]).resolve().parents[2]  # __file__ is that of yade itself
sys.path[:0] = [str(ROOT / "yade_scripts"), str(ROOT)]

import session

session.close_listeners()

from contact_model import measure_rebounds
from glue.errors import InputError
from glue.flow.restitution import RestitutionLaw
from glue.scene import sizes
from glue.scene.reader import read_scene
from glue.theory import hertz
from run_plan import plan_run, solid


def measure(job: dict, folder: Path) -> dict:
    """Rebounds of the planned contacts, beside Hertz's elastic impact of the same bodies."""
    path = folder / "scene.toml"
    path.write_text(job["scene"])
    scene = read_scene(path)
    plan = plan_run(scene, RestitutionLaw(job["e"]), job["dt_over_P"])
    speed, d = scene.nozzle.normal_speed_m_s, sizes.mean_m(scene.shots)
    shot, target = solid(scene.shots), solid(scene.target.material)
    rig = dict(shot=shot, target=target, diameter_m=d, dt_s=plan.dt_s, phases=job["phases"])
    found = {"steps": plan.shortest_contact_steps, "dt_s": plan.dt_s}
    closing = scene.nozzle.speed_m_s * (1.0 + job["e"]) * 2.0 / 3.0
    for pair, law, v in (("target", plan.laws[0], speed), ("shot", plan.laws[1], closing)):
        got = measure_rebounds(pair=pair, en=law.en, speed_m_s=v, **rig)
        # two equal shots: half the radius, half the mass, which is the impact of a shot half as large on a plane
        other, r = (target, 0.5 * d) if pair == "target" else (shot, 0.5 * d)
        modulus = hertz.effective_modulus_Pa(shot.E_Pa, shot.nu, other.E_Pa, other.nu)
        exact = hertz.impact(r, shot.density_kg_m3, v, modulus)
        found[pair] = {
            "e": [g.restitution for g in got],
            "force_N": [g.peak_force_N for g in got],
            "duration_s": [g.duration_s for g in got],
            "hertz_force_N": exact.force_N,
            "hertz_duration_s": exact.contact_time_s,
        }
    return found


jobs = json.loads(Path(sys.argv[1]).read_text())
with tempfile.TemporaryDirectory() as name:
    for job in jobs:
        try:
            answer = {"found": measure(job, Path(name))}
        except InputError as problem:
            answer = {"refused": str(problem)}
        except Exception:
            answer = {"error": traceback.format_exc()[-600:]}
        print("cell " + json.dumps({"id": job["id"], **answer}), flush=True)
