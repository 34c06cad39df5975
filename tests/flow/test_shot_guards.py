"""Every guard of the YADE flow, provoked: what would falsify a run is refused before it or caught after."""

import pytest
from shot_cases import S390, SCRIPTS, shot_flow

from glue import solvers
from glue.flow.impacts import read_impacts

pytestmark = pytest.mark.solver

E = ("--restitution", "0.6")
OWN = "[shots]\ndiameter_m = 0.001\ndensity_kg_m3 = 7800.0\nE_Pa = {E}\nnu = 0.3\n"


def test_too_large_a_step_is_refused(tmp_path):
    run = shot_flow(tmp_path, *E, "--dt-over-P", "5.5")
    assert run.failed and run.report["kind"] == "input" and "must lie in (0, 1.5]" in run.report["cause"]


def test_a_step_too_large_for_the_contact_alone_is_refused(tmp_path):
    """1.4 P is within the range for steps, but fast shots leave it too few per contact."""
    run = shot_flow(tmp_path, *E, "--dt-over-P", "1.45", shots=OWN.format(E="21e9"), speed=70.0)
    assert run.failed and run.report["kind"] == "input"
    assert "the shortest contact lasts" in run.report["cause"] or "overlap" in run.report["cause"]


def test_unguarded_a_too_large_step_is_caught_while_it_runs(tmp_path):
    run = shot_flow(tmp_path, "--restitution", "0.94", "--dt-over-P", "12", "--unguarded")
    assert run.failed and run.report["status"] == "failed" and run.report["kind"] == "check"
    assert "time step is too large" in run.report["cause"] and run.report["cause"] in run.log
    assert not (run.out / "impacts.csv").exists()
    read_impacts(run.out / "impacts.csv.part", allow_truncated=True)


@pytest.mark.parametrize("e", ["0.97", "0", "1.01"])
def test_a_restitution_that_the_contact_law_cannot_give_is_refused(tmp_path, e):
    run = shot_flow(tmp_path, "--restitution", e)
    assert run.failed and run.report["kind"] == "input" and "must lie in (0," in run.report["cause"]


def test_a_softened_shot_is_refused(tmp_path):
    run = shot_flow(tmp_path, *E, shots=OWN.format(E="2.1e9"))
    assert run.failed and run.report["kind"] == "input"
    assert "radius" in run.report["cause"]


def test_with_mixed_sizes_the_step_follows_the_smallest(tmp_path):
    """Three per cent of the mass in shots of a fifth of the size: a step for the large ones would resolve none of theirs."""
    small = '[[shots]]\ngrade = "S390"\nmass_fraction = 0.97\n' + "[[shots]]\ndiameter_m = 0.0002\n"
    small += "density_kg_m3 = 7800.0\nE_Pa = 210e9\nnu = 0.3\nmass_fraction = 0.03\n"
    run = shot_flow(tmp_path, *E, shots=small, flow=0.02, exposure=0.003)
    (tmp_path / "alone").mkdir()
    alone = shot_flow(tmp_path / "alone", *E, shots=S390, exposure=0.001)
    assert not run.failed and run.report["dt_s"] == pytest.approx(alone.report["dt_s"] / 5.0, rel=0.01)
    tiny = run.impacts[run.impacts["diameter_m"] < 3e-4]
    tiny = tiny[tiny["collisions_before"] == 0]
    e = -tiny["vz_out_m_s"] / tiny["vz_in_m_s"]
    assert len(e) > 20 and abs(e - 0.6).max() < 0.012


INSIDE = """
import sys
sys.path[:0] = [{scripts!r}, {root!r}]
sys.argv = ["shot_flow.py"]
import session
session.close_listeners()
from pathlib import Path
import numpy as np
from contact_model import O, look_for_partners
from flight import FlowFailed
from flow_run import FlowRun
from glue.flow.arrivals import COLUMNS
from glue.flow.restitution import RestitutionLaw
from glue.flow.surface import TargetSurface
from glue.scene.reader import read_scene
from run_plan import plan_run
import contact_model, leaps

scene = read_scene(Path({root!r}) / "glue/scene/examples/al2024-s390.toml")
arrivals = np.zeros(20, COLUMNS)
arrivals["shot_id"] = np.arange(20)
arrivals["time_s"] = .005 * np.arange(20)
arrivals["z_m"], arrivals["vz_m_s"] = .1, -60.0
arrivals["diameter_m"], arrivals["density_kg_m3"] = 1e-3, 7800.0
run = FlowRun(scene, plan_run(scene, RestitutionLaw(.6), 1.0), arrivals, TargetSurface(), Path("out"), {{}})
{sabotage}
report = {{}}
try:
    run.run(report)
    print("ended well")
except FlowFailed as e:
    print("caught:", e)
"""
SABOTAGE = {
    "a softened target lets shots through": (
        "for m in O.materials: m.young *= 1e-4",
        ("passes through", "contact stiffness", "below the target", "met the target", "radius"),
    ),
    "a contact that the collider never sees": (
        "put = run.mover.bodies.put\n"
        "def hidden(shot, now):\n"
        "    put(shot, now)\n"
        "    O.bodies[shot.body].mask = 1 << 20\n"
        "run.mover.bodies.put = hidden",
        ("YADE found no contact",),
    ),
    "a shot that something pushed in free flight": (
        "put = run.mover.bodies.put\n"
        "def pushed(shot, now):\n"
        "    put(shot, now)\n"
        "    O.bodies[shot.body].state.vel += contact_model.O.bodies[0].state.pos + (1e-3, 0, 0)\n"
        "run.mover.bodies.put = pushed\n"
        "run.logger.after_step = lambda: False",
        ("changed its velocity without a logged contact", "YADE found no contact"),
    ),
    "a shot that was forgotten": (
        "run.mover.forecast.renew = lambda *a: None",
        ("below the target's surface",),
    ),
    "two shots that fly through each other": (
        "i = np.arange(20)\n"  # each odd shot 1.2 mm behind an even one, and faster
        "arrivals['time_s'] = .005 * (i // 2) + i % 2 * 2e-5\n"
        "arrivals['vz_m_s'] = -58.5 - 1.5 * (i % 2)\n"
        "run.stream.steps = np.ceil((arrivals['time_s'] - 2.1e-5) / run.plan.dt_s).astype(int)\n"
        "run.mover.fleet.touches = lambda *a: []",
        ("fly through each other", "leaves a contact"),  # the audit, or the target that both strike at once
    ),
    "a contact that gains energy": (
        "begin = run.logger._begin\n"
        "def gain(*a):\n"
        "    c = begin(*a); c.phys.betan = -.05; return c\n"
        "run.logger._begin = gain",
        ("speed", "kinetic energy rises", "leaves a contact"),
    ),
    "nothing at all": ("", ("ended well",)),
}


@pytest.mark.parametrize("case", SABOTAGE)
def test_what_goes_wrong_inside_is_caught(tmp_path, case):
    sabotage, words = SABOTAGE[case]
    script = tmp_path / "sabotaged.py"
    script.write_text(INSIDE.format(scripts=str(SCRIPTS), root=str(SCRIPTS.parent), sabotage=sabotage))
    solvers.run_yade(script, [], cwd=tmp_path, log=tmp_path / "log.txt")
    log = (tmp_path / "log.txt").read_text()
    assert ("ended well" in log) == (not sabotage)
    assert any(word in log for word in words), log[-500:]
