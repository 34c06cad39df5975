"""What the contact model's impacts are held against: the flow's own rebounds, and earlier hits on the same spot."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from glue.flow.impacts import COLUMNS
from glue.study.target_stage import restitution_columns


def test_restitution_impact_by_impact():
    """Four logged, the second left out as too faint; the third strikes .1 mm beside the first, the fourth far off."""
    log = np.zeros(4, COLUMNS)
    log["impact_id"], log["nz"] = [10, 11, 12, 13], 1.0
    log["vz_in_m_s"], log["vz_out_m_s"] = [-60.0, -1.0, -40.0, -50.0], [21.0, 0.9, 16.0, 17.0]
    log["vx_in_m_s"] = log["vx_out_m_s"] = 30.0  # along the surface: no part of it
    history = {"x_mm": np.array([0.0, 0.1, 2.0]), "y_mm": np.zeros(3), "contact_radius_mm": np.full(3, 0.2),
               "restitution": np.array([0.33, 0.45, 0.34])}  # fmt: skip
    result = SimpleNamespace(patch=SimpleNamespace(index=np.array([0, 2, 3])), history=history)
    found = restitution_columns(log, result)
    assert found["impact_id"].tolist() == [10, 12, 13]
    assert found["normal_speed_m_s"] == pytest.approx([60.0, 40.0, 50.0])
    assert found["restitution_flow"] == pytest.approx([0.35, 0.4, 0.34])
    assert found["restitution"].tolist() == [0.33, 0.45, 0.34]
    assert found["hits_before"].tolist() == [0, 1, 0]
