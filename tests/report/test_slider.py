"""The impact map with a slider: what is drawn, in which order, and the numbers beside it."""

from __future__ import annotations

import json
import math
import re

import numpy as np
import pytest

from glue.report.slider import impact_slider, in_part

WINDOW = (4e-3, 2e-3)


def dimples(x, y, time, radius=1e-4, **options):
    n = len(x)
    return in_part(x, y, np.full(n, radius), np.full(n, radius), np.zeros(n), time, WINDOW, **options)


def content(html):
    return json.loads(re.search(r'<script type="application/json">(.*?)</script>', html).group(1))


def test_a_dimple_that_reaches_into_the_window_is_drawn_and_none_beyond():
    found = dimples([2.05e-3, 2.15e-3, 0.0], [0.0, 0.0, 0.95e-3], [3.0, 2.0, 1.0])
    assert found.time_s.tolist() == [1.0, 3.0]  # in order of time, the one 0.15 mm outside left out
    assert found.part_m == WINDOW


def test_too_many_are_cut_down_to_the_middle_of_the_window():
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-2e-3, 2e-3, 500), rng.uniform(-1e-3, 1e-3, 500)
    found = dimples(x, y, np.arange(500.0), most=100)
    assert found.x_m.size == 100
    assert found.part_m[0] / found.part_m[1] == pytest.approx(2.0)
    reaches = (np.abs(x) - 1e-4 < 0.5 * found.part_m[0]) & (np.abs(y) - 1e-4 < 0.5 * found.part_m[1])
    assert np.count_nonzero(reaches) == 100  # all that reach into the part, not a sample
    html = impact_slider(found, WINDOW, 500.0, None)
    assert "middle of the window" in html and "coverage is of all of them" in html


def test_the_slider_tells_coverage_as_the_curve_has_it():
    found = dimples([0.0, 0.0, 1e-3], [0.0, 0.5e-3, 0.0], [0.5, 1.0, 2.5])
    html = impact_slider(found, WINDOW, 3.0, (np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 0.25, 0.25, 0.9])))
    data = content(html)
    assert data == {"time_s": [0.0, 1.0, 2.0, 3.0], "shown": [0, 2, 2, 3], "coverage": [0.0, 0.25, 0.25, 0.9]}
    assert "3.000 s: coverage 90.0 %, 3 dimples" in html  # the last state, for paper and without scripts
    assert html.count("<circle") == 3


def test_an_oblique_dimple_lies_as_it_was_struck():
    """Long axis 30 degrees from x in a picture whose y runs upwards: SVG turns clockwise, so by -30."""
    found = in_part([1e-3], [0.5e-3], [2e-4], [1e-4], [math.radians(30.0)], [1.0], WINDOW)
    mark = re.search(r"<ellipse[^>]*>", impact_slider(found, WINDOW, 2.0, None)).group()
    assert mark == '<ellipse cx="1000" cy="-500" rx="200" ry="100" transform="rotate(-30.0 1000 -500)"/>'


def test_no_impacts_still_make_a_map():
    none = np.zeros(0)
    html = impact_slider(in_part(none, none, none, none, none, none, WINDOW), WINDOW, 1.0, None)
    assert set(content(html)["shown"]) == {0}
