"""run_dem against stub solvers: every way a flow run can go wrong ends in the right error with its cause."""

import json

import pytest

from glue.errors import InputError, NotConverged, SolverFailed
from glue.flow.arrivals import draw_arrivals, read_arrivals, scene_hash, write_arrivals
from glue.flow.dem import run_dem
from glue.flow.restitution import RestitutionLaw

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
    """flow(code): run_dem with a stub that runs ``code``; returns ((impacts, report), progress calls, scene)."""

    def run(code, go_on=False, **changes):
        from glue.solvers import repo_root

        stub("PEEN_YADE", START.format(repo=str(repo_root())) + code)
        scene, said = make_scene(exposure_time_s=0.002, **changes), []
        (tmp_path / "scene.toml").write_text("")
        arrivals = tmp_path / "flow" / "arrivals.csv"
        write_arrivals(arrivals, draw_arrivals(scene), scene_hash(scene))
        result = run_dem(
            scene,
            tmp_path / "scene.toml",
            tmp_path / "flow",
            law=RestitutionLaw(0.6, 60.0, 0.25),
            arrivals_path=arrivals,
            surface_path=tmp_path / "surface.npz",
            go_on=go_on,
            progress=lambda fraction, text="": said.append((fraction, text)),
        )
        return result, said, scene

    return run


def test_result_and_progress(flow):
    (impacts, report), said, scene = flow("print('progress 0.25 eta_s 12', flush=True); log(); report('ok')")
    assert len(impacts) == len(draw_arrivals(scene)) > 20 and report["steps"] == 7
    assert said[0][0] == 0.25 and "12 s" in said[0][1]


@pytest.mark.parametrize("go_on", [False, True])
def test_what_yade_is_told(flow, tmp_path, go_on):
    """Preset, law and surface as files, and whether to go on from the checkpoint."""
    flow("(out / 'said').write_text(chr(10).join(sys.argv[7:])); log(); report('ok')", go_on)
    said = (tmp_path / "flow" / "said").read_text().split("\n")
    assert ("--continue" in said) == go_on
    given = dict(zip(said[0::2], said[1::2], strict=False))
    assert given["--accuracy"] == "balanced" and given["--surface"] == str(tmp_path / "surface.npz")
    law = RestitutionLaw.from_dict(json.loads((tmp_path / "flow" / "law.json").read_text()))
    assert given["--law"] == str(tmp_path / "flow" / "law.json") and law == RestitutionLaw(0.6, 60.0, 0.25)
    assert read_arrivals(given["--arrivals"])[0].size > 20


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
