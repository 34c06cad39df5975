"""YADE really runs: the stream, its log, its guards, and the checks."""

import json
import os
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from glue import solvers
from glue.errors import InputError, SolverFailed
from glue.flow.arrivals import read_arrivals
from glue.flow.dem import run_dem
from glue.flow.impacts import read_impacts
from glue.scene.reader import read_scene

pytestmark = pytest.mark.solver

SCRIPTS = Path(__file__).parents[2] / "yade_scripts"
SCENE = """
schema = 1
name = "short"
seed = 3
exposure_time_s = 0.006
[shots]
grade = "S390"
{shots}
[nozzle]
speed_m_s = 60.0
mass_flow_kg_s = 0.083333
jet_diameter_m = 0.020
stand_off_m = {stand_off}
impact_angle_deg = {angle}
[target]
material = "al2024-t351"
window_m = [0.004, 0.004]
"""


def write_scene(folder, *, angle=90.0, stand_off=0.05, shots=""):
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "scene.toml"
    path.write_text(SCENE.format(angle=angle, stand_off=stand_off, shots=shots))
    return path


def run(folder, **scene):
    path = write_scene(folder, **scene)
    return run_dem(read_scene(path), path, folder / "flow", shot_target_restitution=0.6)


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    return run(tmp_path_factory.mktemp("a dense stream"))  # a space in the path on purpose


def test_every_shot_is_accounted_for(short):
    info = short.info
    arrivals, _ = read_arrivals(short.arrivals_path)
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
    arrivals, _ = read_arrivals(short.arrivals_path)
    free = short.impacts[short.impacts["collisions_before"] == 0]
    came = arrivals[free["shot_id"]]
    for column in ("vx", "vy", "vz"):
        assert (free[f"{column}_in_m_s"] == came[f"{column}_m_s"]).all()
    assert (free["x_m"] == came["x_m"]).all() and (free["y_m"] == came["y_m"]).all()
    assert free["time_s"] == pytest.approx(came["time_s"] + (0.05 - 0.0005) / 60.0, abs=1e-15)


def test_same_seed_same_bytes(short, tmp_path):
    again = run(tmp_path)
    assert again.impacts_path.read_bytes() == short.impacts_path.read_bytes()


def test_leaps_give_what_plain_stepping_gives(short, tmp_path):
    """Same arrivals, every step made.  Only rounding may differ: 2e4 additions per flight against a few.

    It moves a shot by some 1e-14 m, which each collision magnifies a hundred times and a glancing one more:
    in this short stream that must leave the same impacts of the same shots, within a micrometre.
    """
    args = ["--restitution", "0.6", "--plain", "--arrivals", str(short.arrivals_path)]
    failed, report, _ = shot_flow(tmp_path, *args)
    assert not failed and report["stepping"] == "plain" and report["executed_steps"] == report["steps"]
    assert short.info["executed_steps"] < 0.2 * report["steps"] and short.info["stepping"].startswith("leaps")
    plain, _ = read_impacts(tmp_path / "out" / "impacts.csv")
    leaps = short.impacts
    for column in ("shot_id", "collisions_before"):
        assert (plain[column] == leaps[column]).all()
    free = leaps["collisions_before"] == 0
    assert 20 < (~free).sum() and 50 < free.sum()
    for column in ("time_s", "x_m", "y_m", "vx_in_m_s", "vz_in_m_s"):
        assert (plain[column][free] == leaps[column][free]).all()
    assert np.abs(plain["vz_out_m_s"] - leaps["vz_out_m_s"])[free].max() < 1e-6
    off = np.hypot(plain["x_m"] - leaps["x_m"], plain["y_m"] - leaps["y_m"])[~free]
    assert off.max() < 1e-6 and np.median(off) < 1e-9


def test_mixed_sizes_and_oblique(tmp_path):
    result = run(tmp_path, angle=45.0, shots='size = "distribution"')
    diameters = result.impacts["diameter_m"]
    assert diameters.std() > 0.03 * diameters.mean() and result.info["status"] == "ok"
    assert result.info["dt_s"] < 9e-8  # of the smallest shot
    first = result.impacts[result.impacts["collisions_before"] == 0]
    loss = first["vx_in_m_s"] - first["vx_out_m_s"]
    push = first["vz_out_m_s"] - first["vz_in_m_s"]
    assert loss / push == pytest.approx(0.2, rel=0.01), "full sliding at 45 degrees: Coulomb"
    assert (first["wy_out_rad_s"] > 0).all(), "a shot flying along +x rolls forwards"


def shot_flow(folder, *args, scene=None):
    out = folder / "out"
    log = folder / "log.txt"
    scene = scene or write_scene(folder)
    failed = None
    try:
        solvers.run_yade(SCRIPTS / "shot_flow.py", [str(scene), str(out), *args], cwd=folder, log=log)
    except SolverFailed as e:
        failed = e
    report = out / "flow.json"
    return (
        failed,
        json.loads(report.read_text()) if out.is_dir() and report.exists() else None,
        log.read_text(),
    )


def test_too_large_a_step_is_refused_and_caught(tmp_path):
    failed, report, log = shot_flow(tmp_path / "refused", "--restitution", "0.6", "--dt-over-P", "5.5")
    assert failed and report["kind"] == "input" and "must lie in (0, 1.5]" in report["cause"]
    # past the guards before the run, those of the run must stop it: kinetic energy rises without limit
    failed, report, log = shot_flow(
        tmp_path / "caught", "--restitution", "0.94", "--dt-over-P", "12", "--unguarded"
    )
    assert failed and report["status"] == "failed" and report["kind"] == "check"
    assert "time step is too large" in report["cause"] and report["cause"] in log
    out = tmp_path / "caught" / "out"
    assert not (out / "impacts.csv").exists()
    read_impacts(out / "impacts.csv.part", allow_truncated=True)


@pytest.mark.parametrize(
    "args, words",
    [
        ([], "give its value with --restitution"),
        (["--restitution", "0.97"], "(0, 0.94] or exactly 1"),
        (["--restitution", "nan"], "(0, 0.94] or exactly 1"),
        (["--restitution", "0.6", "--exposure", "0"], "no shot leaves the nozzle"),
        (["--restitution", "0.6", "--accuracy", "fine"], "fine"),
    ],
)
def test_bad_input_is_refused(tmp_path, args, words):
    failed, report, log = shot_flow(tmp_path, *args)
    assert failed and report["kind"] == "input" and words in report["cause"]
    assert "Traceback" not in log


def test_unwritable_place_and_stale_results(tmp_path):
    (tmp_path / "out").write_text("a file where the folder should go")
    failed, report, log = shot_flow(tmp_path, "--restitution", "0.6")
    assert failed and report is None and "cannot be written" in log and "Traceback" not in log
    (tmp_path / "out").unlink()
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "impacts.csv").write_text("# of an older run")
    failed, report, log = shot_flow(tmp_path, "--restitution", "2")
    assert failed and report["kind"] == "input" and not (tmp_path / "out" / "impacts.csv").exists()


def test_a_single_shot(tmp_path):
    failed, report, _ = shot_flow(tmp_path, "--restitution", "0.94", "--exposure", "0.00005")
    rows, _ = read_impacts(tmp_path / "out" / "impacts.csv")
    assert not failed and report["arrived"] == len(rows) == 1
    assert rows["vz_out_m_s"][0] == pytest.approx(0.94 * 60.0, rel=0.005)


def test_arrivals_of_another_scene_are_refused(short, tmp_path):
    failed, report, _ = shot_flow(
        tmp_path,
        "--restitution",
        "0.6",
        "--arrivals",
        str(short.arrivals_path),
        scene=write_scene(tmp_path, angle=80.0),
    )
    assert failed and "another scene" in report["cause"]


def test_nozzle_too_near_is_refused(tmp_path):
    path = write_scene(tmp_path, angle=20.0, stand_off=0.03)
    with pytest.raises(InputError, match="raise stand_off_m"):
        run_dem(read_scene(path), path, tmp_path / "flow", shot_target_restitution=0.6)


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
    scene = write_scene(tmp_path)
    scene.write_text(scene.read_text().replace("exposure_time_s = 0.006", "exposure_time_s = 5.0"))
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
