"""A machine's speeds: the weighted law is the exact one, intervals hold what they say, a curve gives its speed back."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest

from glue.scene.asked import Machine, MachineLaw
from glue.study.machine import Calibrated, CurveSpeed, calibrate, curve_speed, power_law
from glue.study.measured import MeasuredCurve
from glue.target.strip import IntensityCurve, even_stream
from glue.theory.almen import STRIPS

sys.path.insert(0, str(Path(__file__).parents[1] / "target"))

from strips import stand_in  # noqa: E402


def points(settings, speeds, sd):
    return [CurveSpeed(p, v, s, 1e-4, 1e-5) for p, v, s in zip(settings, speeds, np.broadcast_to(sd, len(settings)))]


def test_an_exact_power_law_comes_back():
    p = np.array([1.5e5, 2.5e5, 4e5])
    law = power_law(points(p, 30 * (p / 2.5e5) ** 0.6, [0.02, 0.05, 0.01]))
    assert law.n == pytest.approx(0.6) and law.speed(3e5).value == pytest.approx(30 * 1.2**0.6)
    assert law.setting(30.0) == pytest.approx(2.5e5)


def test_one_curve_says_one_speed():
    law = power_law(points([2e5], [35.0], 0.03))
    assert law.speed(2e5).value == pytest.approx(35.0)
    assert law.speed(2e5).high / 35.0 == pytest.approx(math.exp(1.96 * 0.03), rel=1e-3)


@pytest.mark.parametrize("count", [2, 3, 5])
def test_the_stated_interval_holds_the_speed_as_often_as_it_says(count):
    """Noise of exactly the size that the curves state; 95 %, less three binomial standard deviations."""
    rng, p, trials = np.random.default_rng(3), np.geomspace(1e5, 4e5, count), 400
    held = 0
    for _ in range(trials):
        found = power_law(points(p, 30 * (p / 2e5) ** 0.6 * np.exp(0.05 * rng.normal(size=count)), 0.05)).speed(3e5)
        held += found.low <= 30 * 1.5**0.6 <= found.high
    assert held / trials > 0.95 - 3 * math.sqrt(0.95 * 0.05 / trials)


def test_curves_that_scatter_more_than_they_say_widen_the_interval():
    p = np.array([1e5, 2e5, 3e5, 4e5])
    calm = power_law(points(p, 30 * (p / 2e5) ** 0.6, 0.01))
    wild = power_law(points(p, 30 * (p / 2e5) ** 0.6 * np.array([1.1, 0.9, 1.1, 0.9]), 0.01))
    assert wild.scatter > 5.0
    assert math.log(wild.speed(3e5).high / wild.speed(3e5).low) > 5 * math.log(calm.speed(3e5).high / calm.speed(3e5).low)


def test_a_curve_of_a_known_speed_gives_that_speed():
    """The points are the model's own at 35 m/s, at other exposures than any that are used inside; the fit's bias must drop out."""
    library, strip = stand_in(), STRIPS["A"]
    curves = IntensityCurve(library, strip, even_stream(0.6e-3, 7800.0, 25.0))
    stream = curves.faster(35.0 / 25.0)
    hits, _ = library.saturation(strip, stream)
    over = np.array([0.3, 0.8, 1.7, 3.5])
    heights = np.array([library.arc_height_m(strip, stream, hits * m) for m in over])
    found = curve_speed(2e5, MeasuredCurve(7.0 * over, heights, "min", "mine.csv"), "A", curves)
    assert found.speed_m_s == pytest.approx(35.0, rel=0.01)
    assert found.sd > 0.0


def test_a_table_and_a_law():
    table = Machine("air_pressure_Pa", table=((1e5, 20.0), (2e5, 30.0), (4e5, 45.0)))
    machine = calibrate(table, Path("x"), None, None)
    assert machine.speed(2e5).value == pytest.approx(30.0)
    assert machine.setting_for(machine.speed(3e5).value) == pytest.approx(3e5)
    assert machine.setting_for(50.0) is None
    law = Calibrated(Machine("wheel_speed_m_s", law=MachineLaw(50.0, 60.0, 1.0, 0.1, 2.0)), None, ())
    speed = law.speed(40.0)
    assert speed.value == pytest.approx(48.0)
    assert (speed.low, speed.high) == (pytest.approx(48 * math.exp(-0.196), rel=1e-3), pytest.approx(48 * math.exp(0.196), rel=1e-3))
