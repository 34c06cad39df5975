"""run_dem against stub solvers: every way a flow run can go wrong ends in the right error with its cause."""

import json

import pytest

from glue.errors import InputError, NotConverged, SolverFailed
from glue.flow.arrivals import read_arrivals, scene_hash
from glue.flow.dem import run_dem

# the stub gets: -n -x -j1 SCRIPT SCENE OUT …
START = """
import json
out = Path(sys.argv[6])
sys.path.insert(0, {repo!r})
import numpy as np
from glue.flow import arrivals, impacts
a, head = arrivals.read_arrivals(out / "arrivals.csv")
rows = np.zeros(len(a), impacts.COLUMNS)
rows["shot_id"] = a["shot_id"]; rows["vz_in_m_s"] = a["vz_m_s"]; rows["nz"] = 1.0
rows["time_s"] = a["time_s"] + .0016
rows["impact_id"] = np.arange(len(a))
def report(status, kind=None, cause=None):
    (out / "flow.json").write_text(json.dumps(dict(schema=1, status=status, kind=kind, cause=cause, steps=7)))
def log(**changed):
    impacts.write_impacts(out / "impacts.csv", rows, {{**head, "model": "dem", **changed}})
"""


@pytest.fixture
def flow(stub, make_scene, tmp_path):
    """flow(code): run_dem with a stub that runs ``code``; returns (result, progress calls, scene)."""

    def run(code, **changes):
        from glue.solvers import repo_root

        stub("PEEN_YADE", START.format(repo=str(repo_root())) + code)
        scene, said = make_scene(exposure_time_s=0.002, **changes), []
        (tmp_path / "scene.toml").write_text("")
        result = run_dem(
            scene,
            tmp_path / "scene.toml",
            tmp_path / "flow",
            shot_target_restitution=0.6,
            progress=lambda fraction, text="": said.append((fraction, text)),
        )
        return result, said, scene

    return run


def test_result_and_progress(flow):
    result, said, scene = flow("print('progress 0.25 eta_s 12', flush=True); log(); report('ok')")
    arrivals, header = read_arrivals(result.arrivals_path)
    assert header["scene_hash"] == scene_hash(scene)
    assert (
        result.info["model"] == "dem" and result.info["impacts"] == len(arrivals) == len(result.impacts) > 20
    )
    assert result.info["mean_normal_speed_m_s"] == 60.0 and result.info["collided_fraction"] == 0.0
    assert result.info["collision_number"] == pytest.approx(0.907, abs=0.001)
    assert result.info["steps"] == 7 and result.info["wall_s"] > 0.0
    assert said[0][0] == 0.25 and "12 s" in said[0][1]


@pytest.mark.parametrize(
    "code, error, words",
    [
        (
            "report('failed', 'check', 'kinetic energy rises'); sys.exit(3)",
            NotConverged,
            "kinetic energy rises",
        ),
        ("report('failed', 'input', 'too slow'); sys.exit(2)", InputError, "too slow"),
        ("report('failed', 'defect', 'KeyError: 3'); sys.exit(1)", SolverFailed, "KeyError: 3"),
        (
            "print('Traceback (most recent call last):\\n  x\\nValueError: nan'); sys.exit(1)",
            SolverFailed,
            "ValueError: nan",
        ),
        ("report('ok')", SolverFailed, "impacts.csv was not written"),
        (
            "log(); report('ok'); p = out / 'impacts.csv'; p.write_text(p.read_text()[:-40])",
            SolverFailed,
            "truncated",
        ),
        ("log(scene_hash='other'); report('ok')", SolverFailed, "another scene"),
        ("log(); (out / 'flow.json').write_text('{')", SolverFailed, "cannot be used"),
        ("os.kill(os.getpid(), signal.SIGKILL)", SolverFailed, "SIGKILL"),
    ],
)
def test_failures_name_their_cause(flow, code, error, words):
    with pytest.raises(error) as caught:
        flow(code)
    assert words in str(caught.value) and type(caught.value) is error


def test_an_older_report_does_not_explain_a_new_failure(flow, tmp_path):
    (tmp_path / "flow").mkdir()
    (tmp_path / "flow" / "flow.json").write_text(json.dumps(dict(kind="check", cause="long ago")))
    with pytest.raises(SolverFailed) as caught:
        flow("sys.exit(1)")
    assert "long ago" not in str(caught.value)


def test_bad_input_needs_no_solver(flow):
    with pytest.raises(InputError, match="too dense"):
        flow("raise SystemExit('must not run')", jet_diameter_m=1e-3, mass_flow_kg_s=0.5)
