"""The intensity found by layers is held against cells where the preset asks for it, and what is off is said."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from glue.scene.reader import example_path
from glue.study import intensity_stage, pipeline, specify
from glue.study.stages import STAGES
from glue.study.strip_cells import CellCurve
from glue.target.strip import MODEL_ERROR

sys.path.insert(0, str(Path(__file__).parents[1] / "target"))

from strips import stand_in  # noqa: E402

INTENSITY = tuple(s for s in STAGES if s.name == "intensity")


@pytest.fixture
def cells(monkeypatch, tmp_path):
    """Stand-in cells: the layers' own arc heights times ``cells.factor``; ``cells.solved`` counts curves."""
    library = stand_in()
    for module in (specify, intensity_stage):
        monkeypatch.setattr(module, "ready_kernels", lambda: None)
        monkeypatch.setattr(module, "strip_library", lambda progress: library)
    monkeypatch.setattr(specify, "solve_reduced", lambda *args, **kind: "solved")
    monkeypatch.setattr(specify, "zero_height_radius", lambda impact: 0.27)
    monkeypatch.setattr(pipeline.solvers, "find_freefem", lambda: None)
    monkeypatch.setenv("PEEN_CACHE", str(tmp_path / "cache"))

    class Cells:
        factor, solved = 1.0, 0

    def curve(library, strip, stream, accuracy, *, seed, progress):
        Cells.solved += 1
        hits = library.saturation(strip, stream)[0] * np.array([0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0])
        heights = Cells.factor * np.array([library.arc_height_m(strip, stream, float(h)) for h in hits])
        return CellCurve(hits, heights, 0.01 * heights)

    monkeypatch.setattr(intensity_stage, "cell_curve", curve)
    return Cells


def told(out, preset="balanced"):
    path = pipeline.run(str(example_path("al2024-s230-8a")), out, preset=preset, stages=INTENSITY)
    return json.loads((path / "metrics.json").read_text()).get("intensity")


def test_cells_that_agree_confirm(cells, tmp_path):
    found = told(tmp_path / "run")
    assert found["confirmed"] is True and "warning" not in found
    assert found["over_asked"] == pytest.approx(0.0, abs=0.05)  # what a fitted curve is off the exact one
    assert found["asked_m"] == pytest.approx(8 * 25.4e-6)


@pytest.mark.parametrize("factor", (0.7, 1.4))
def test_cells_that_do_not_are_told(cells, tmp_path, factor):
    cells.factor = factor
    found = told(tmp_path / "run")
    assert found["confirmed"] is False and abs(found["over_asked"]) > MODEL_ERROR
    assert "where 8A was asked for" in found["warning"]


def test_the_same_stream_is_solved_once(cells, tmp_path):
    one, other = told(tmp_path / "one"), told(tmp_path / "other")
    assert cells.solved == 1 and one == other


def test_preset_fast_costs_nothing(cells, tmp_path):
    assert told(tmp_path / "run", preset="fast") is None
    assert cells.solved == 0
