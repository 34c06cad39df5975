"""A run killed with -9 leaves a readable log, and continued gives the bytes of one that was never stopped."""

import json
import os
import signal
import subprocess
import time

import pytest
from shot_cases import SCRIPTS, shot_flow, write_scene

from glue import solvers
from glue.flow.impacts import read_impacts

pytestmark = pytest.mark.solver

LAW = {"e": 0.5, "speed_m_s": 60.0, "exponent": 0.2, "spot_radius_m": 3e-4}
HARDENING = {"saturated": 0.7, "hits": 3.0}
DRAG = "[air_drag]\ngas_density_kg_m3 = 5.0\n"  # four times air: a flight sees many kicks

BAR = '[target.surface]\nkind = "cylinder"\nradius_m = 0.02\naxis = "y"\n'


def start(scene, out, *args):
    return subprocess.Popen(
        [solvers.find_yade(), "-n", "-x", "-j1", str(SCRIPTS / "shot_flow.py"), str(scene), str(out), *args],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        stdin=subprocess.DEVNULL,
        text=True,
        env={**os.environ, "PYTHONPATH": str(SCRIPTS.parent), "OMP_NUM_THREADS": "1"},
    )


def logged(out) -> bool:
    part = out / "impacts.csv.part"
    return part.exists() and sum(not line.startswith("#") for line in part.read_text().splitlines()) > 1


def kill_after_checkpoint(child, out, number):
    """SIGKILL once the checkpoint has been written ``number`` times and an impact is in the log (a busy machine is slow)."""
    file, seen, deadline = out / "flow.checkpoint.npz", set(), time.monotonic() + 60.0
    while (len(seen) < number or not logged(out)) and time.monotonic() < deadline and child.poll() is None:
        if file.exists():
            seen.add(file.stat().st_mtime_ns)
        time.sleep(0.005)
    child.send_signal(signal.SIGKILL)
    assert child.wait(30) == -signal.SIGKILL and len(seen) >= number
    child.stdout.close()


@pytest.mark.parametrize(
    "case, changes", {"plane": {}, "drag": {"more": DRAG}, "bar": {"target": BAR}}.items()
)
def test_killed_twice_and_continued_is_as_never_stopped(tmp_path, case, changes):
    law = tmp_path / "law.json"
    law.write_text(json.dumps({**LAW, "hardening": HARDENING}))
    args = ("--law", str(law), "--checkpoint", "0.02")
    scene = write_scene(tmp_path, exposure=0.1, **changes)
    (tmp_path / "whole").mkdir()
    whole = shot_flow(tmp_path / "whole", "--law", str(law), scene=scene)
    assert not whole.failed, whole.log
    out = tmp_path / "out"
    kill_after_checkpoint(start(scene, out, *args), out, 1)
    rows, _ = read_impacts(out / "impacts.csv.part", allow_truncated=True)
    assert 0 < len(rows) < len(whole.impacts) and not (out / "impacts.csv").exists()
    kill_after_checkpoint(start(scene, out, *args, "--continue"), out, 2)
    again = shot_flow(tmp_path, *args, "--continue", scene=scene)
    assert not again.failed, again.log
    assert (out / "impacts.csv").read_bytes() == (whole.out / "impacts.csv").read_bytes()
    assert not (out / "flow.checkpoint.npz").exists()
    for key in (
        "impacts",
        "arrived",
        "dropped",
        "shot_shot_collisions",
        "executed_steps",
        "mass_fed_kg",
        "top_speed_m_s",
    ):
        assert again.report[key] == whole.report[key], key
    assert whole.report["shot_shot_collisions"] > 50 and whole.report["impacts"] > 500


def test_a_checkpoint_of_another_run_is_refused(tmp_path):
    scene = write_scene(tmp_path, exposure=0.2)
    out = tmp_path / "out"
    kill_after_checkpoint(start(scene, out, "--restitution", "0.6", "--checkpoint", "0.02"), out, 1)
    other = shot_flow(tmp_path, "--restitution", "0.5", "--continue", scene=scene)
    assert other.report["kind"] == "input" and "another restitution" in other.report["cause"]
    log = out / "impacts.csv.part"
    log.write_bytes(log.read_bytes()[:200])
    cut = shot_flow(tmp_path, "--restitution", "0.6", "--continue", scene=scene)
    assert (
        cut.report["kind"] == "input" and "does not begin as the log to be continued" in cut.report["cause"]
    )
    (out / "flow.checkpoint.npz").write_bytes(b"PK")
    broken = shot_flow(tmp_path, "--restitution", "0.6", "--continue", scene=scene)
    assert broken.report["kind"] == "input" and "cannot be read as a checkpoint" in broken.report["cause"]


def test_continue_without_a_checkpoint_begins_anew(tmp_path):
    run = shot_flow(tmp_path, "--restitution", "0.6", "--continue", exposure=0.001)
    assert not run.failed and run.report["status"] == "ok" and len(run.impacts) > 0
