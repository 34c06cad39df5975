"""YADE really runs: the stream and its log, bad input, what a stopped run leaves, and the checks."""

import json
import os
import signal
import subprocess
import time

import numpy as np
import pytest
from shot_cases import SCRIPTS, shot_flow, write_scene

from glue import solvers
from glue.flow.impacts import read_impacts

pytestmark = pytest.mark.solver

E = ("--restitution", "0.6")


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    return shot_flow(tmp_path_factory.mktemp("a dense stream"), *E)  # a space in the path on purpose


def test_every_shot_is_accounted_for(short):
    info, arrivals = short.report, short.arrivals
    assert info["status"] == "ok" and all(row["passed"] for row in info["checks"])
    assert info["arrived"] == len(arrivals) == sum(info["dropped"].values()) + info["in_flight"]
    struck = len(set(short.impacts["shot_id"]))
    assert struck + info["shots_that_never_struck"] == len(arrivals) > 90
    assert info["impacts"] == len(short.impacts) >= struck
    assert short.impacts["collisions_before"].sum() > 0, "a dense stream without a collision"


def test_log_is_in_order_and_physical(short):
    rows = short.impacts
    assert (rows["impact_id"] == np.arange(len(rows))).all() and (np.diff(rows["time_s"]) >= 0).all()
    assert (rows["vz_in_m_s"] < 0).all() and (rows["vz_out_m_s"] > 0).all()
    assert (rows["z_m"] == 0).all() and (rows["nz"] == 1).all() and (rows["nx"] == 0).all()
    head_on = rows[rows["collisions_before"] == 0]
    # corrected en: the mean rebound of the run itself, spread .6 % over n impacts
    e = head_on["vz_out_m_s"] / 60.0
    assert e.mean() == pytest.approx(0.6, abs=3 * 0.005 / np.sqrt(len(e)))
    # 1.967e-6 s is Hertz's elastic duration at 60 m/s; the dashpot lengthens it by 5 %
    assert head_on["duration_s"] == pytest.approx(2.07e-6, rel=0.02)
    # elastic peak is 458.3 N; elastic part and dashpot together stay below it
    assert 380 < head_on["peak_force_N"].min() and head_on["peak_force_N"].max() < 458.3


def test_uncollided_shots_carry_the_nozzles_velocity_exactly(short):
    free = short.impacts[short.impacts["collisions_before"] == 0]
    came = short.arrivals[free["shot_id"]]
    for column in ("vx", "vy", "vz"):
        assert (free[f"{column}_in_m_s"] == came[f"{column}_m_s"]).all()
    assert (free["x_m"] == came["x_m"]).all() and (free["y_m"] == came["y_m"]).all()
    assert free["time_s"] == pytest.approx(came["time_s"] + (0.05 - 0.0005) / 60.0, abs=1e-15)


def test_same_seed_same_bytes(short, tmp_path):
    again = shot_flow(tmp_path, *E)
    assert (again.out / "impacts.csv").read_bytes() == (short.out / "impacts.csv").read_bytes()


@pytest.mark.parametrize("stride", ["question after every step", "at its best"])
def test_leaps_give_what_plain_stepping_gives(short, tmp_path, stride):
    """Same arrivals, every step made.  Only rounding may differ: 2e4 additions per flight against a few.

    It moves a shot by some 1e-14 m, which each collision magnifies a hundred times and a glancing one more:
    in this short stream that must leave the same impacts of the same shots, within a micrometre.
    """
    # dashpots per contact make plain stepping ask after every step; sizes of no spread leave them as they were
    law = tmp_path / "law.json"
    every = stride != "at its best"
    law.write_text(json.dumps({"e": 0.6, "speed_m_s": 60.0, "exponent": 0.2 if every else 0.0}))
    plain = shot_flow(tmp_path, "--law", str(law), "--plain", "--arrivals", str(short.out / "arrivals.csv"))
    assert not plain.failed and plain.report["stepping"] == "plain"
    assert plain.report["executed_steps"] == plain.report["steps"]
    if every:
        (tmp_path / "leaps").mkdir()
        ours = shot_flow(tmp_path / "leaps", "--law", str(law))
    else:
        ours = short
    assert ours.report["executed_steps"] < 0.1 * plain.report["steps"]
    assert ours.report["stepping"].startswith("leaps")
    rows, leaps = plain.impacts, ours.impacts
    leaps = leaps[
        leaps["time_s"] < plain.report["simulated_s"]
    ]  # plain stepping waits less long for stragglers
    for column in ("shot_id", "collisions_before"):
        assert (rows[column] == leaps[column]).all()
    free = leaps["collisions_before"] == 0
    assert 20 < (~free).sum() and 50 < free.sum()
    for column in ("time_s", "x_m", "y_m", "vx_in_m_s", "vz_in_m_s"):
        assert (rows[column][free] == leaps[column][free]).all()
    assert np.abs(rows["vz_out_m_s"] - leaps["vz_out_m_s"])[free].max() < 1e-6
    assert rows["peak_force_N"][free] == pytest.approx(leaps["peak_force_N"][free], rel=1e-6)
    off = np.hypot(rows["x_m"] - leaps["x_m"], rows["y_m"] - leaps["y_m"])[~free]
    assert off.max() < 1e-6 and np.median(off) < 1e-9


@pytest.mark.parametrize(
    "args, words",
    [
        ([], "give its value with --restitution"),
        (["--restitution", "0.97"], "(0, 0.94] or be exactly 1"),
        (["--restitution", "nan"], "must be a finite number"),
        (["--restitution", "0.6", "--exposure", "0"], "no shot leaves the nozzle"),
        (["--restitution", "0.6", "--accuracy", "fine"], "fine"),
        (["--law", "nowhere.json"], "cannot be read as a restitution law"),
        (["--restitution", "0.6", "--surface", "nowhere.npz"], "cannot be read as a target surface"),
    ],
)
def test_bad_input_is_refused(tmp_path, args, words):
    run = shot_flow(tmp_path, *args)
    assert run.failed and run.report["kind"] == "input" and words in run.report["cause"]
    assert "Traceback" not in run.log


def test_unwritable_place_and_stale_results(tmp_path):
    (tmp_path / "out").write_text("a file where the folder should go")
    run = shot_flow(tmp_path, *E)
    assert run.failed and run.report is None and "cannot be written" in run.log and "Traceback" not in run.log
    (tmp_path / "out").unlink()
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "impacts.csv").write_text("# of an older run")
    run = shot_flow(tmp_path, "--restitution", "2")
    assert run.failed and run.report["kind"] == "input" and not (tmp_path / "out" / "impacts.csv").exists()


def test_a_single_shot(tmp_path):
    run = shot_flow(tmp_path, "--restitution", "0.94", "--exposure", "0.00005")
    assert not run.failed and run.report["arrived"] == len(run.impacts) == 1
    assert run.impacts["vz_out_m_s"][0] == pytest.approx(0.94 * 60.0, rel=0.005)


def test_arrivals_of_another_scene_are_refused(short, tmp_path):
    run = shot_flow(tmp_path, *E, "--arrivals", str(short.out / "arrivals.csv"), angle=80.0)
    assert run.failed and "another scene" in run.report["cause"]


def test_nozzle_too_near_is_refused(tmp_path):
    run = shot_flow(tmp_path, *E, angle=20.0, stand_off=0.03)
    assert run.failed and run.report["kind"] == "input" and "stand_off_m" in run.report["cause"]


def test_yades_own_folder_goes_with_it(tmp_path):
    script = tmp_path / "scratch.py"
    script.write_text(
        f"import sys\nsys.path[:0] = [{str(SCRIPTS)!r}, {str(SCRIPTS.parent)!r}]\nimport session\n"
        "scratch = session.remove_scratch_at_exit()\nassert scratch.is_dir()\nprint('scratch', scratch)\n"
    )
    solvers.run_yade(script, [], cwd=tmp_path, log=tmp_path / "log.txt")
    (line,) = [t for t in (tmp_path / "log.txt").read_text().splitlines() if t.startswith("scratch ")]
    assert not os.path.exists(line.removeprefix("scratch "))


def test_no_listening_socket_is_left(tmp_path):
    script = tmp_path / "sockets.py"
    script.write_text(
        f"import sys\nsys.path[:0] = [{str(SCRIPTS)!r}, {str(SCRIPTS.parent)!r}]\nimport session\n"
        "print('before', len(session.listening_sockets()))\nimport shot_flow\n"
        "print('after', len(session.listening_sockets()))\n"
    )
    solvers.run_yade(script, [], cwd=tmp_path, log=tmp_path / "log.txt")
    text = (tmp_path / "log.txt").read_text()
    assert "before 2" in text and "after 0" in text


def test_a_stopped_run_keeps_its_log_as_part(tmp_path):
    scene = write_scene(tmp_path, exposure=5.0)
    out = tmp_path / "out"
    child = subprocess.Popen(
        [
            solvers.find_yade(),
            "-n",
            "-x",
            str(SCRIPTS / "shot_flow.py"),
            str(scene),
            str(out),
            "--restitution",
            "0.6",
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        stdin=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": str(SCRIPTS.parent)},
    )
    try:
        begun = time.monotonic()
        for line in child.stdout:
            if line.startswith("progress") or time.monotonic() - begun > 60:
                break
        child.send_signal(signal.SIGTERM)
        assert child.wait(30) != 0
    finally:
        child.kill()
    assert not (out / "impacts.csv").exists()
    rows, _ = read_impacts(out / "impacts.csv.part", allow_truncated=True)
    assert len(rows) > 0
    assert json.loads((out / "flow.json").read_text())["kind"] == "stopped"


@pytest.mark.parametrize(
    "check", sorted(p.stem for p in (SCRIPTS / "checks").glob("*.py") if p.stem != "rows")
)
def test_checks_pass(check, tmp_path):
    solvers.run_yade(
        SCRIPTS / "checks" / f"{check}.py",
        ["--json", str(tmp_path / "rows.json")],
        cwd=tmp_path,
        log=tmp_path / "log.txt",
    )
    rows = json.loads((tmp_path / "rows.json").read_text())["rows"]
    assert len(rows) >= 10 and all(r["passed"] for r in rows)
    assert f"{len(rows)}/{len(rows)} passed" in (tmp_path / "log.txt").read_text()


def test_softened_contacts_rebound_as_asked_and_tell_no_force(tmp_path):
    """Restitution is calibrated for the softer contact too; it lasts longer by 10^(2/5); its force is no number to keep."""
    found = []
    for scale in (1.0, 0.1):
        scene = write_scene(tmp_path / f"{scale:g}", more=f"[accuracy]\nflow_stiffness_scale = {scale:g}\n")
        run = shot_flow(tmp_path / f"{scale:g}", "--restitution", "0.4", scene=scene)
        assert not run.failed, run.log
        found.append(run.impacts[run.impacts["collisions_before"] == 0])
    stiff, soft = found
    for log in found:
        e = -log["vz_out_m_s"] / log["vz_in_m_s"]
        assert e.mean() == pytest.approx(0.4, abs=0.005)
    assert np.median(soft["duration_s"]) / np.median(stiff["duration_s"]) == pytest.approx(10**0.4, rel=0.05)
    assert np.isfinite(stiff["peak_force_N"]).all() and np.isnan(soft["peak_force_N"]).all()
