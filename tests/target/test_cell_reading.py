"""Layers, thresholds and refusals of the target cell, without FreeFEM."""

from __future__ import annotations

import numpy as np
import pytest

from glue.errors import NotConverged, SolverFailed
from glue.scene.presets import PRESETS
from glue.target.cell_mesh import layer_bounds_mm
from glue.target.cell_result import edge_threshold
from glue.target.tables import read_table


@pytest.mark.parametrize("preset", PRESETS)
def test_layers_start_a_tenth_of_a_radius_thick_and_end_at_six(preset):
    bounds = layer_bounds_mm(PRESETS[preset], 200e-6)
    assert bounds[0] == 0
    assert bounds[1] == pytest.approx(0.02)
    assert bounds[-1] == pytest.approx(1.2)
    thickness = np.diff(bounds)
    assert thickness[1:] / thickness[:-1] == pytest.approx(thickness[1] / thickness[0])


def test_edge_threshold_is_exceeded_on_the_asked_share():
    """Strain falling linearly from 1 to 0 over equal volumes: a quarter of them lie above .75."""
    peeq = np.linspace(1, 0, 1001)
    assert edge_threshold(peeq, np.ones(1001), 0.25) == pytest.approx(0.75, abs=1e-3)
    rng = np.random.default_rng(3)
    volume, strain = rng.uniform(0.5, 1.5, 5000), rng.exponential(0.1, 5000)
    above = volume[strain >= edge_threshold(strain, volume, 0.13)].sum() / volume.sum()
    assert above == pytest.approx(0.13, abs=3e-4)  # one point of 5000 either way


def test_table_round_trip(tmp_path):
    (tmp_path / "t.csv").write_text("a,b\n0.30000000000000004,2\n3,4\n")
    table = read_table(tmp_path / "t.csv")
    assert table["a"][0] == 0.1 + 0.2
    assert table["b"].tolist() == [2, 4]


def test_a_table_with_fewer_rows_than_were_written_is_refused(tmp_path):
    (tmp_path / "t.csv").write_text("a\n1\n2\n")
    (tmp_path / "status").write_text("ok\nrows t.csv 3\nrows other.csv 2\n")
    with pytest.raises(SolverFailed, match="cut short"):
        read_table(tmp_path / "t.csv")
    (tmp_path / "status").write_text("ok\nrows t.csv 2\n")
    assert read_table(tmp_path / "t.csv")["a"].tolist() == [1, 2]


@pytest.mark.parametrize(
    ("text", "error"),
    [(None, SolverFailed), ("a,b\n1\n2\n", SolverFailed), ("a,b\n1,2\n3\n", SolverFailed), ("a,b\n1,nan\n", NotConverged), ("a,b\n1,inf\n", NotConverged)],
)  # fmt: skip
def test_a_torn_or_poisoned_table_is_refused(tmp_path, text, error):
    if text is not None:
        (tmp_path / "t.csv").write_text(text)
    with pytest.raises(error, match="t.csv"):
        read_table(tmp_path / "t.csv")
