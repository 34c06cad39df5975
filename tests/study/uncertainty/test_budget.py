"""The section ``uncertainty`` of a whole run behind a stand-in dimple: every value has an interval, made of its causes."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest

from glue.scene.derive import changed
from glue.study import pipeline
from glue.study.stage import Stage
from glue.study.summary import summary
from glue.study.uncertainty.budget import _coverage_chances, patch_scatter
from glue.study.uncertainty.metrics import METRICS
from flow_runs import SCENE, dimple


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    from glue.study.stages import STAGES

    folder = tmp_path_factory.mktemp("budget")
    (folder / "scene.toml").write_bytes(changed(SCENE.format(model="ballistic", nozzle="", target="", flow=0.05).encode(), {}))

    def stand_in(work):
        dimple().save(work.path / "dimple" / "dimple.npz")
        return {"dimple": {"radius_m": 0.22e-3, "restitution": 0.34, "peak_force_N": None, "peak_force_N_reason": "stand-in"}}, ["dimple/dimple.npz"]

    chosen = {s.name: s for s in STAGES}
    kept = [dataclasses.replace(chosen[n], code=()) for n in ("flow", "coverage", "surface", "uncertainty")]
    return pipeline.run(str(folder / "scene.toml"), folder / "run", stages=(Stage("dimple", (), (), ("dimple",), stand_in), *kept))


def metrics(run):
    return json.loads((run / "metrics.json").read_text())


def test_every_value_has_an_interval_and_a_missing_one_has_none(run):
    found = metrics(run)
    for m in METRICS:
        value = found.get(m.section, {}).get(m.key)
        assert (m.name in found["uncertainty"]) == (value is not None), m.name
        if value is not None:
            told = found["uncertainty"][m.name]
            assert told["value"] == value and told["half_width_95"] >= 0.0


def test_causes_add_by_squares_and_the_largest_is_named(run):
    for name, told in metrics(run)["uncertainty"].items():
        if "by_cause" in told:
            known = {cause: half for cause, half in told["by_cause"].items() if half is not None}
            assert told["half_width_95"] == pytest.approx(math.sqrt(sum(h**2 for h in known.values()))), name
            if told["mostly"]:
                assert known[told["mostly"]] == max(known.values())


def test_ballistic_coverage_scatters_as_poisson_impacts_do(run):
    found = metrics(run)
    c, told = found["coverage"], found["uncertainty"]["coverage.impacts_in_window"]
    assert told["by_cause"]["statistical"] == pytest.approx(1.96 * math.sqrt(c["impacts_in_window"]))


def test_shots_that_never_meet_err_by_the_collisions_left_out(run):
    # with c n/(1 + k n) of the energy lost to n collisions per shot, of a stream as dense as this one
    told = metrics(run)["uncertainty"]["flow.mean_normal_energy_fraction"]
    assert told["mostly"] == "numerical" and 0.1 < told["by_cause"]["numerical"] / told["value"] < 1.0


def test_line_roughness_has_the_relative_interval_of_the_area_s(run):
    told = metrics(run)["uncertainty"]
    for line, area in (("Ra_m", "Sa_m"), ("Rz_m", "Sz_m")):
        own, other = told[f"roughness.{line}"], told[f"roughness.{area}"]
        assert own["half_width_95"] / own["value"] == pytest.approx(other["half_width_95"] / other["value"])
        assert own["half_width_95"] > 0.0 and area in own["source"]


def test_times_have_an_interval_where_every_point_is_covered():
    # 60 hits per point: the expected coverage is 1 in double precision, the time to 98 % is known all the same
    coverage = {"avrami_final": 1.0, "time_98_s": 2.0, "avrami_time_98_s": 1.9}
    found = _coverage_chances({"coverage": coverage}, np.full(900, 0.2e-3), 900, 0.065, (3e-3, 3e-3))
    assert found["coverage.avrami_time_98_s"] == pytest.approx(0.065 * 1.9) and 0.0 < found["coverage.time_98_s"] < 2.0


def test_the_summary_reads_value_interval_cause(run):
    line = next(line for line in summary(run).splitlines() if line.startswith("  at the end"))
    assert " % ± " in line and ", mostly " in line


def test_scatter_of_a_patch_between_the_exposures_measured():
    entry = {"patch_hits": {"few": 1.0, "many": 4.0}, "patches": {"few": {"Sa": {"sd": 0.1}}, "many": {"Sa": {"sd": 0.025}}}}
    found = [patch_scatter(entry, hits)["Sa"]["sd"] for hits in (0.5, 1.0, 2.0, 4.0, 9.0)]
    assert found == pytest.approx([0.1, 0.1, 0.05, 0.025, 0.025])
