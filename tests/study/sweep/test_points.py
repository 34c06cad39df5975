"""Points of a study: means and scatter over replicates, what a missing value does, power laws with their error."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glue.errors import InputError
from glue.study.sweep.points import Point, mean_curve, power, read_points
from glue.study.sweep.warned import distinct, warnings_of

TABLE = """run,state,cause,point,replicate,seed,nozzle.speed_m_s,flow.model,coverage.time_98_s
a,done,,0,0,1,30.0,event,8.0
b,done,,0,1,2,30.0,event,10.0
c,done,,1,0,3,60.0,event,4.0
d,done,,1,1,4,60.0,event,
e,failed,no balance,2,0,5,90.0,,
"""


def test_points_have_mean_and_scatter_of_their_finished_runs(tmp_path):
    (tmp_path / "table.csv").write_text(TABLE)
    first, second = read_points(tmp_path)  # the third has no finished run
    assert first.names == ("a", "b") and first.mean("nozzle.speed_m_s") == 30.0
    value = first.value("coverage.time_98_s")
    assert value.mean == 9.0 and value.sd == pytest.approx(math.sqrt(2.0)) and value.standard_error == pytest.approx(1.0)
    # one replicate never came to 98 %: the mean of the other would be too early
    assert second.value("coverage.time_98_s") is None and math.isnan(second.mean("coverage.time_98_s"))
    assert first.value("no.such.column") is None


@pytest.mark.parametrize("text", [None, "run,state\na,failed\n", "other\n1\n"])
def test_no_table_or_no_finished_run_is_told(tmp_path, text):
    if text is not None:
        (tmp_path / "table.csv").write_text(text)
    with pytest.raises(InputError, match="table.csv.*peen sweep"):
        read_points(tmp_path)


def test_power_law_finds_its_exponent_and_the_error_that_scatter_makes():
    rng = np.random.default_rng(5)
    x = [20.0, 40.0, 80.0]

    def points(scatter):
        chance = np.exp(scatter * rng.normal(size=(3, 50)))
        return [Point(("",) * 50, {"x": (v,) * 50, "y": tuple(-3.0 * v**-0.9 * c)}) for v, c in zip(x, chance, strict=True)]

    exact = power(points(0.0), "x", "y")  # of stresses, below 0, too
    assert exact.exponent == pytest.approx(-0.9) and exact.standard_error < 1e-12 and exact.constant == pytest.approx(3.0)
    noisy = power(points(0.1), "x", "y")
    # scatter / (sqrt(150) sd of ln x), sd = ln 2 sqrt(2/3)
    assert noisy.standard_error == pytest.approx(0.1 / (math.sqrt(150) * math.log(2) * math.sqrt(2 / 3)), rel=0.2)
    assert abs(noisy.exponent + 0.9) < 4 * noisy.standard_error
    with pytest.raises(InputError, match="two values"):
        power(points(0.1)[:1], "x", "y")


def test_mean_curve_ends_with_the_shortest(tmp_path):
    for name, end, rise in (("a", 4.0, 0.1), ("b", 5.0, 0.2)):
        (tmp_path / "runs" / name).mkdir(parents=True)
        t = np.linspace(0.0, end, 30)
        file = tmp_path / "runs" / name / "coverage.csv"
        np.savetxt(file, np.c_[t, rise * t, t / 10], delimiter=",", header="time_s,coverage,avrami")
    times, counted, expected = mean_curve(tmp_path, Point(("a", "b"), {}))
    assert times[-1] == 4.0 and counted == pytest.approx(0.15 * times) and expected == pytest.approx(times / 10)
    with pytest.raises(InputError, match="coverage.csv"):
        mean_curve(tmp_path, Point(("c",), {}))


def test_warnings_that_differ_in_numbers_are_one():
    metrics = {"schema": 1, "flow": {"warning": "error 3.5 %"}, "uncertainty": {"table": {"warning": "none like\nit"}}}
    first = warnings_of(metrics)
    assert first == "flow: error 3.5 % | uncertainty: none like it" and warnings_of({"flow": {"impacts": 3}}) == ""
    found = distinct([first, "", warnings_of({"flow": {"warning": "error 1e-05 %"}})])
    assert found == [("flow: error 3.5 %", 2), ("uncertainty: none like it", 1)]
