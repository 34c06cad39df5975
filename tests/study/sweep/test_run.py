"""Running a study of stub stages: what is computed and what is not, failures, refusals, the tables."""

from __future__ import annotations

import fcntl
import json
import re
import threading

import pytest

from glue import cli_study
from glue.errors import InputError, InUse, NotConverged, SolverFailed
from glue.report.study_page import write_study_report
from glue.solvers import Finished
from glue.study.sweep import cluster, records, run, worker
from glue.study.sweep.run import exit_code, run_study


def test_every_run_is_a_run_directory_and_a_row(sweep):
    ran = sweep.go()
    assert len(ran) == 18 and len({name for _, name in ran}) == 6
    rows = sweep.rows()
    assert [row["run"] for row in rows] == sorted(p.name for p in (sweep.out / "runs").iterdir())
    assert [row["nozzle.mass_flow_kg_s"] for row in rows] == ["0.01"] * 2 + ["0.02"] * 2 + ["0.03"] * 2
    assert [row["nozzle.speed_m_s"] for row in rows] == ["40.0", "60.0"] * 3
    assert [float(row["coverage.final"]) for row in rows] == pytest.approx([0.1, 0.1, 0.2, 0.2, 0.3, 0.3])
    assert {(row["state"], row["cause"], row["coverage.final.u95"], row["coverage.time_98_s"]) for row in rows} == {("done", "", "0.01", "")}
    assert "dimple.wall_s" not in rows[0]  # a time is a cost
    assert (sweep.out / "costs.csv").read_text().startswith("run,state,dimple.wall_s,")
    assert len({row["seed"] for row in rows}) == 6


def test_study_json_tells_axes_design_and_counts(sweep):
    sweep.go(sweep.file("replicates = 2"))
    told = sweep.study()
    assert told["runs"] == {"all": 12, "done": 12, "failed": 0, "refused": 0, "waiting": 0} and told["exit_code"] == 0
    assert told["axes"][1] == {
        "name": "shot speed", "keys": ["nozzle.speed_m_s"], "unit": "m/s", "range": [40.0, 60.0], "spacing": "linear", "points": 2,
    }  # fmt: skip
    assert told["axes"][0]["unit"] == "kg/s" and told["design"]["replicates"] == 2


def test_done_again_computes_nothing_and_writes_the_same_table(sweep):
    sweep.go()
    before = (sweep.out / "table.csv").read_bytes()
    told = sweep.study() | {"begun": "2026-01-01T00:00:00+00:00"}
    (sweep.out / "study.json").write_text(json.dumps(told))
    assert sweep.go() == []
    assert (sweep.out / "table.csv").read_bytes() == before
    assert sweep.study()["begun"] == told["begun"] < sweep.study()["ended"]


def test_the_first_runs_only_then_the_others(sweep):
    assert len(sweep.go(first=2)) == 6
    assert [row["state"] for row in sweep.rows()] == ["done"] * 2 + ["waiting"] * 4
    assert len(sweep.go()) == 12


def test_a_failed_run_is_recorded_and_the_others_go_on(sweep):
    sweep.fail = {"0001": NotConverged("no balance", cause="too fast"), "0004": SolverFailed("died")}
    sweep.go()
    rows = sweep.rows()
    assert [row["state"] for row in rows] == ["done", "failed", "done", "done", "failed", "done"]
    assert rows[1]["cause"] == "no balance" and rows[1]["coverage.final"] == "" and rows[1]["dimple.radius_m"] == "0.0002"
    assert exit_code(sweep.out) == NotConverged.exit_code  # the first one's
    sweep.fail = {}
    assert sweep.go() == []  # not tried again by itself
    assert sweep.go(retry_failed=True) == [(s, r) for r in (rows[1]["run"], rows[4]["run"]) for s in ("coverage", "uncertainty")]
    assert exit_code(sweep.out) == 0


def test_a_mistake_in_a_model_fails_its_run_alone(sweep, capsys):
    sweep.fail = {"0000": ZeroDivisionError("division by zero")}
    sweep.go()
    assert sweep.rows()[0]["cause"] == "ZeroDivisionError: division by zero" and exit_code(sweep.out) == 1
    assert sweep.study()["runs"]["done"] == 5


def test_a_worker_that_dies_loses_one_run_and_another_goes_on(sweep):
    sweep.fail = {"0002": SystemExit(137)}
    sweep.go()
    rows = sweep.rows()
    assert [row["state"] for row in rows] == ["done", "done", "failed", "done", "done", "done"]
    assert "ended with exit code 137; log logs/worker-0.log" in rows[2]["cause"]


def test_invalid_combinations_are_rows_and_not_fatal(sweep):
    file = sweep.file(more='[[axis]]\nkey = "nozzle.stand_off_m"\nvalues = [0.1, 50.0]\n')
    sweep.go(file)
    assert [row["state"] for row in sweep.rows()] == ["done", "refused"] * 6
    assert sweep.rows()[1]["cause"].startswith("nozzle.stand_off_m: 50.0 is 50000 mm") and exit_code(sweep.out) == 0


def test_a_study_without_any_valid_scene_is_refused_with_every_reason_once(sweep):
    file = sweep.file(more='[set]\nnozzle.divergence = 3.0\n')
    with pytest.raises(InputError) as caught:
        sweep.go(file)
    assert len(caught.value.problems) == 2 and "did you mean" in caught.value.problems[1]
    assert not sweep.out.exists()


def test_a_value_that_the_study_sets_is_blamed_on_the_study(sweep):
    axis = '[[axis]]\nname = "distance"\nkey = "nozzle.stand_off_m"\nvalues = [50.0]\n'
    file = sweep.file(more=f"[set]\nnozzle.jet_diameter_m = 7.0\n{axis}")
    with pytest.raises(InputError) as caught:
        sweep.go(file)
    text = "\n".join(caught.value.problems)
    assert re.search(rf'(?m)^{re.escape(str(file))}: nozzle.stand_off_m: 50.0 .*\(by axis "distance"\)$', text)
    assert re.search(rf"(?m)^{re.escape(str(file))}: nozzle.jet_diameter_m: 7.0 .*\(by \[set\]\)$", text)
    assert "al2024-s390.toml" not in text


def test_warnings_of_runs_are_in_the_table_the_report_and_the_last_lines(sweep, capsys):
    sweep.warn = {"0001": "3 shots lost", "0003": "41 shots lost"}
    sweep.go()
    told = [row["warnings"] for row in sweep.rows()]
    assert told == ["", "coverage: 3 shots lost", "", "coverage: 41 shots lost", "", ""]
    assert cli_study._summary(sweep.out, sweep.study()).count("2 runs warn: coverage: 3 shots lost") == 1
    page = write_study_report(sweep.out).read_text()
    assert "coverage: 3 shots lost" in page and "coverage: 41 shots lost" not in page


def test_a_cache_that_cannot_be_written_is_told_before_anything_starts(sweep, monkeypatch):
    (sweep.folder / "file").touch()
    monkeypatch.setenv("PEEN_CACHE", str(sweep.folder / "file"))
    with pytest.raises(InputError, match="cache folder .*file cannot be written"):
        sweep.go()
    assert not sweep.out.exists()


def test_a_folder_of_another_study_or_of_something_else_is_refused(sweep):
    sweep.go()
    with pytest.raises(InputError, match="holds a study of other runs"):
        sweep.go(sweep.file("replicates = 2"))
    (sweep.folder / "mine").mkdir()
    (sweep.folder / "mine" / "letter.txt").write_text("dear")
    with pytest.raises(InputError, match="no study's folder"):
        run_study(sweep.file(), sweep.folder / "mine", 1)


def test_a_result_that_is_gone_is_computed_again(sweep):
    ran = sweep.go()
    (sweep.out / "runs" / ran[0][1] / "coverage.txt").unlink()
    assert sweep.go() == [("coverage", ran[0][1])]


def test_the_journal_tells_every_start_and_end(sweep):
    sweep.go(first=1)
    lines = [line.split(",")[2:] for line in (sweep.out / records.JOURNAL).read_text().splitlines()]
    assert lines == [[s, e] for s in ("dimple", "coverage", "uncertainty") for e in ("starts", "done")]


def test_one_stage_alone_marks_itself_and_is_passed_over_after_a_failure(sweep):
    """What Snakemake's jobs do."""
    sweep.go(first=1)
    name = sweep.rows()[1]["run"]
    plan = json.loads((sweep.out / "plan.json").read_text())
    assert [run["run"] for run in plan["runs"]][1] == name and plan["all_stages"] == ["dimple", "coverage", "uncertainty"]
    sweep.ran.clear()
    sweep.fail = {"0001": SolverFailed("died")}
    for stage in plan["all_stages"]:
        assert worker.main([str(sweep.out), "--run", name, "--stage", stage]) == 0
    assert sweep.ran == [("dimple", name), ("coverage", name)]
    assert sorted(p.name for p in (sweep.out / "done" / name).iterdir()) == ["coverage", "dimple", "uncertainty"]


def test_a_run_that_another_process_holds_has_not_failed(sweep, monkeypatch):
    monkeypatch.setattr(worker, "_WAIT_S", 0.0)
    sweep.go(first=1)
    name = sweep.rows()[1]["run"]
    (sweep.out / "runs" / name).mkdir()
    with open(sweep.out / "runs" / name / ".lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        with pytest.raises(InUse, match=name):
            sweep.go()
        assert [row["state"] for row in sweep.rows()] == ["done", "waiting", "done", "done", "done", "done"]
        assert worker.main([str(sweep.out), "--run", name, "--stage", "dimple"]) != 0  # Snakemake tries again
        assert not records.failure_file(sweep.out, name).exists() and not (sweep.out / "done" / name).exists()
        monkeypatch.setattr(run, "refuse_snakemake", lambda profile: None)
        monkeypatch.setattr(cluster, "run_module", lambda *args, log, **options: _job_fails(sweep.out, name, log))
        with pytest.raises(InUse, match=name):
            run_study(sweep.file(), sweep.out, 1, executor="snakemake")
        assert not records.failure_file(sweep.out, name).exists()
    assert [run for _, run in sweep.go()] == [name] * 3  # once it is free


def _job_fails(out, name, log):
    return Finished(worker.main([str(out), "--run", name, "--stage", "dimple"]), log, 0.0, 0)


def test_a_run_waits_for_a_process_that_is_just_ending(sweep, monkeypatch):
    monkeypatch.setattr(worker, "_LOOK_EVERY_S", 0.01)
    sweep.go(first=1)
    name = sweep.rows()[1]["run"]
    (sweep.out / "runs" / name).mkdir()
    lock = open(sweep.out / "runs" / name / ".lock", "w")  # noqa: SIM115 (closed by the timer)
    fcntl.flock(lock, fcntl.LOCK_EX)
    threading.Timer(0.3, lock.close).start()
    sweep.go()
    assert {row["state"] for row in sweep.rows()} == {"done"}


@pytest.mark.parametrize(("jobs", "with_profile", "told"), [
    (None, True, []), (7, True, ["--jobs", "7"]), (7, False, ["--jobs", "7", "--cores", "7"]),
])  # fmt: skip
def test_a_profile_says_how_many_jobs_unless_asked(sweep, monkeypatch, jobs, with_profile, told):
    asked = []

    def snakemake(module, args, *, log, on_line, interrupt_s):
        asked.extend(map(str, args))
        assert (interrupt_s is not None) == with_profile  # a cluster's jobs are called off before it is killed
        return Finished(0, log, 0.0, 0)

    monkeypatch.setattr(cluster, "run_module", snakemake)
    monkeypatch.setattr(run, "refuse_snakemake", lambda profile: None)
    run_study(sweep.file(), sweep.out, jobs, executor="snakemake", profile=sweep.folder if with_profile else None)
    numbers = ("--jobs", "--cores")
    found = [word for k, word in enumerate(asked) if word in numbers or asked[k - 1] in numbers]
    assert found == told and ("--profile" in asked) == with_profile
    plan = json.loads((sweep.out / "plan.json").read_text())
    assert plan["jobs"] == (None if with_profile else 7)  # the library's threads are not this machine's cores


def test_a_queue_gives_each_name_once(tmp_path):
    (tmp_path / "queue").write_text("a\nb")
    assert [records.claim(tmp_path / "queue") for _ in range(3)] == ["a", "b", None]
