"""A whole design with stand-ins for the runs: restart, verdicts, files, exit codes."""

from __future__ import annotations

import dataclasses
import json
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from made_up import AXES, GOALS, TARGETS, VARY, evaluation, refused  # noqa: E402

from glue import cli  # noqa: E402
from glue.errors import InputError, NotConverged, SolverFailed  # noqa: E402
from glue.scene.reader import read_scene  # noqa: E402
from glue.study import pipeline  # noqa: E402
from glue.study.design import confirm, design, evaluate  # noqa: E402
from glue.study.design.axes import read_axes  # noqa: E402
from glue.study.design.goals import read_goals  # noqa: E402
from glue.study.design.problem import claim, read_problem  # noqa: E402
from glue.study.design.text import design_text  # noqa: E402

SCENE = "al2024-s390"


@pytest.fixture
def runs(monkeypatch):
    """Stand-ins for the solvers; ``runs.ran``: numbers of evaluations and seeds of re-runs; ``runs.weak``: stress of both."""

    class Runs:
        ran: list[int] = []
        strength, again = 290e6, 290e6

    found = Runs()
    found.ran = []

    def fast(problem, number, values, folder, progress=None):
        found.ran.append(number)
        return refused(number) if number == 3 else evaluation(number, values, strength=found.strength)

    def finer(problem, values, folder, preset, seed, progress=None):
        found.ran.append(seed)
        return evaluation(seed, values, strength=found.again)

    monkeypatch.setattr(design, "_evaluate", fast)
    monkeypatch.setattr(confirm, "rerun", finer)
    monkeypatch.setattr(design, "cores", lambda: 1)  # other processes would not have the stand-ins
    monkeypatch.setattr(design, "solve_window", lambda *_: "made up")
    return found


def problem():
    return read_problem(SCENE, GOALS, AXES)


def test_a_design_is_found_confirmed_and_written(runs, tmp_path):
    result = design.design(problem(), tmp_path / "d", evaluations=24)
    assert result.verdict == "confirmed" and result.succeeded and sorted(runs.ran)[-3:] == [7002, 7003, 7004]
    told = json.loads((tmp_path / "d" / "design.json").read_text())
    assert told["verdict"] == "confirmed" and told["evaluations"]["refused"] == 1 and told["cannot_be_met"] == []
    assert told["winner"]["number"] == result.winner.number and told["confirmations"][0]["holds"]
    scene = read_scene(tmp_path / "d" / "winner.toml")
    assert scene.nozzle.speed_m_s == result.winner.values["nozzle.speed_m_s"] and scene.seed == 1
    text = design_text(result)
    assert "Verdict: confirmed" in text and "Trade front" in text and "met by 3 of 3 runs" in text


def test_a_winner_at_an_end_of_the_window_is_told(runs, tmp_path):
    low, log, _ = AXES
    assert [low.end_at(v) for v in (20.0, 21.0, 60.0, 99.0)] == ["low", "low", "", "high"]
    assert [log.end_at(v) for v in (0.00519, 0.0055, 0.05)] == ["low", "", "high"]
    assert read_axes(["shots.grade=S110,S230"])[0].end_at("S110") == ""
    result = design.design(problem(), tmp_path / "d", evaluations=24, preset=None)
    values = {**result.winner.values, "nozzle.speed_m_s": 20.0, "exposure_time_s": 5.0, "nozzle.mass_flow_kg_s": 0.01}
    result = dataclasses.replace(result, winner=evaluation(99, values))
    assert result.at_ends == {"nozzle.speed_m_s": "low"}
    assert "nozzle.speed_m_s is at the low end of its range" in design_text(result)


def test_a_target_judged_without_an_interval_is_told(runs, tmp_path):
    result = design.design(problem(), tmp_path / "d", evaluations=24)
    assert result.without_interval == [] and "without an interval" not in design_text(result)
    stress = GOALS.targets[1]
    held = result.confirmations[-1]
    rerun = held.runs[0]
    unsure = {**rerun.readings, stress.quantity.path: rerun.reading(stress.quantity)._replace(half=None, half_all=None)}
    again = dataclasses.replace(held, runs=(dataclasses.replace(rerun, readings=unsure), *held.runs[1:]))
    result = dataclasses.replace(result, confirmations=[again])
    assert again.holds(GOALS.targets) and result.without_interval == [stress]
    text = design_text(result)
    assert "max_compressive <= -250 MPa was judged without an interval: none is known" in text
    assert "no interval known" in text and design.as_dict(result)["judged_without_interval"] == [str(stress)]


def test_nothing_is_run_twice_and_more_evaluations_add(runs, tmp_path):
    design.design(problem(), tmp_path / "d", evaluations=16, preset=None)
    assert sorted(runs.ran) == list(range(16))
    runs.ran.clear()
    design.design(problem(), tmp_path / "d", evaluations=16, preset=None)
    assert runs.ran == []
    design.design(problem(), tmp_path / "d", evaluations=18, preset=None)
    assert sorted(runs.ran) == [16, 17]


def test_a_kill_in_the_middle_costs_no_evaluation(runs, tmp_path, monkeypatch):
    fast = design._evaluate

    def dies(problem, number, *rest, **more):
        if number == 9:
            raise KeyboardInterrupt
        return fast(problem, number, *rest, **more)

    monkeypatch.setattr(design, "_evaluate", dies)
    with pytest.raises(KeyboardInterrupt):
        design.design(problem(), tmp_path / "d", evaluations=16, preset=None)
    monkeypatch.setattr(design, "_evaluate", fast)
    result = design.design(problem(), tmp_path / "d", evaluations=16, preset=None)
    assert sorted(runs.ran) == list(range(16)) and len(result.evaluations) == 16


def test_a_solver_that_failed_is_told_apart_and_tried_again(runs, tmp_path, monkeypatch):
    fast = design._evaluate

    def killed(problem, number, values, *rest, **more):
        if number == 5:
            return dataclasses.replace(refused(number, "killed, out of memory"), values=values, state="failed")
        return fast(problem, number, values, *rest, **more)

    monkeypatch.setattr(design, "_evaluate", killed)
    result = design.design(problem(), tmp_path / "d", evaluations=16, preset=None)
    told = json.loads((tmp_path / "d" / "design.json").read_text())["evaluations"]
    assert (told["count"], told["refused"], told["failed"]) == (16, 1, 1)
    assert "1 refused, 1 failed (the same command tries them again)" in design_text(result)
    assert "failed" in (tmp_path / "d" / "evaluations.csv").read_text()
    monkeypatch.setattr(design, "_evaluate", fast)
    runs.ran.clear()
    again = design.design(problem(), tmp_path / "d", evaluations=16, preset=None)
    assert runs.ran == [5] and [e.values for e in again.evaluations] == [e.values for e in result.evaluations]
    assert again.evaluations[5].state == "done"


@pytest.mark.parametrize(("error", "state"), [(InputError("too dense"), "refused"), (SolverFailed("killed"), "failed"),
                                              (NotConverged("drifts"), "failed")])  # fmt: skip
def test_only_bad_input_is_refused_for_good(monkeypatch, tmp_path, error, state):
    def run(*_, **__):
        raise error

    monkeypatch.setattr(pipeline, "run", run)
    found = evaluate.rerun(problem(), {"nozzle.speed_m_s": 50.0}, tmp_path / "r", "fast", 7)
    assert (found.state, found.cause) == (state, str(error))


def test_targets_out_of_reach_are_told_with_the_nearest(runs, tmp_path):
    runs.strength = 200e6
    result = design.design(problem(), tmp_path / "d", evaluations=16)
    told = json.loads((tmp_path / "d" / "design.json").read_text())
    assert result.verdict == "infeasible" and told["winner"] is None and told["nearest"]["number"] >= 0
    assert told["cannot_be_met"][0].startswith("max_compressive <= -250 MPa: cannot be met in this window; nearest -200 MPa")
    assert not (tmp_path / "d" / "winner.toml").exists() and "cannot be met" in design_text(result)


def test_a_proposal_that_does_not_hold_is_told(runs, tmp_path):
    runs.again = 230e6  # the finer models find less stress, everywhere
    result = design.design(problem(), tmp_path / "d", evaluations=16)
    assert result.verdict == "not confirmed" and not result.succeeded
    assert "missed, beyond the interval by" in design_text(result)


def test_another_problem_s_folder_is_refused(tmp_path):
    claim(tmp_path / "d", problem())
    claim(tmp_path / "d", problem())
    other = read_problem(SCENE, read_goals(["coverage>=0.9"], ["Sa"]), AXES)
    with pytest.raises(InputError, match="holds another design(.|\n)*targets"):
        claim(tmp_path / "d", other)
    (tmp_path / "own.txt").write_text("mine")
    with pytest.raises(InputError, match="is not empty and no design"):
        claim(tmp_path, problem())


def test_axes_that_do_not_fit_the_scene_are_told_at_once():
    axes = read_axes(["nozzle.speed=20:40", "exposure_time_s=1:1e5", "shots.grade=S390,S999",
                      "nozzle.mass_flow_kg_s=0.005:0.05", "seed=1:9:int"])  # fmt: skip
    with pytest.raises(InputError) as told:
        read_problem(SCENE, GOALS, axes)
    said = "\n".join(told.value.problems)
    assert 'nozzle.speed = 20.0: unknown key; did you mean "speed_m_s"?' in said
    assert "exposure_time_s = 100000.0: 100000.0 is out of range" in said and "allowed 1e-6..3600 s" in said
    assert 'shots.grade = S999: no shot grade "S999"' in said
    assert "--vary seed: cannot be varied" in said
    assert "mass_flow" not in said.replace("mass_flow_kg_s, jet", "").replace("mass_flow_pattern", "")


@pytest.mark.parametrize("own", ["seed=1:9:int", "schema=1,2", "name=a,b", "accuracy.preset=fast,balanced",
                                 "accuracy=fast,balanced", "models.flow=event,dem", "models=event,dem"])  # fmt: skip
def test_what_the_confirmation_sets_itself_cannot_be_varied(own):
    key = own.split("=")[0]
    with pytest.raises(InputError, match=rf"--vary {key}: cannot be varied: .*; allowed: other keys of the scene"):
        read_problem(SCENE, GOALS, read_axes([VARY[0], own]))


def test_a_scene_that_says_an_intensity_has_no_speed_to_vary():
    with pytest.raises(InputError, match="the scene says an intensity"):
        read_problem("al2024-s230-8a", GOALS, read_axes(["nozzle.speed_m_s=20:40"]))


def test_the_command(runs, tmp_path, capsys):
    words = ["design", SCENE, "--minimise", "Sa", "--evaluations", "12", "--out", str(tmp_path / "d")]
    words += [w for t in TARGETS for w in ("--target", t)] + [w for v in VARY for w in ("--vary", v)]
    assert cli.main(words) == 0
    said = capsys.readouterr()
    assert "Proposed setting" in said.out and "front.png" in said.out and "12 evaluations, best Sa" in said.err
    assert (tmp_path / "d" / "front.png").stat().st_size > 10_000
    runs.strength = 200e6
    words[words.index("--out") + 1] = str(tmp_path / "e")
    assert cli.main([*words, "--json"]) == 4
    said = capsys.readouterr()
    assert json.loads(said.out)["verdict"] == "infeasible" and "no setting of the window surely meets all targets" in said.err


def test_the_command_tells_all_that_is_wrong(capsys):
    assert cli.main(["design", SCENE, "--target", "coverag>=1", "--minimise", "Sa", "--vary", "a=2:1"]) == 2
    said = capsys.readouterr().err
    assert "did you mean coverage?" in said and "the ends must be rising" in said
    words = ["--confirm", "best", "--evaluations", "0", "--jobs", "0"]
    assert cli.main(["design", SCENE, "--minimise", "Sa", "--vary", VARY[0], *words]) == 2
    said = capsys.readouterr().err
    assert "--confirm best" in said and "--evaluations 0" in said and "--jobs 0" in said
