"""A small report in a real browser; the full one, with screenshots to look at, is ``make check-report``."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))
from browser import chromium, missing, outside_references  # noqa: E402

from glue.report.page import page  # noqa: E402
from glue.report.slider import impact_slider, in_part  # noqa: E402

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def browser():
    if missing():
        reason = f"{', '.join(missing())} not installed; make check-report installs them"
        pytest.fail(reason) if os.environ.get("PEEN_REQUIRE_TOOLS") == "1" else pytest.skip(reason)
    with chromium() as found:
        yield found


@pytest.fixture
def report(tmp_path):
    rng = np.random.default_rng(1)
    time, sizes = np.linspace(0.1, 3.0, 60), np.full(60, 2e-4)
    window, curve = (4e-3, 3e-3), (np.linspace(0, 3, 31), np.linspace(0, 0.9, 31))
    places = rng.uniform(-2e-3, 2e-3, 60), rng.uniform(-1.5e-3, 1.5e-3, 60)
    slider = impact_slider(in_part(*places, sizes, sizes, 0 * sizes, time, window), window, 3.0, curve)
    metrics = {"coverage": {"final": 0.9, "time_98_s": None, "time_98_s_reason": "it ends at " + "x" * 60}}
    path = tmp_path / "a report.html"
    path.write_text(page([("Target", "x" * 300)], {"scene": "<i>&", "seed": 1}, metrics, [], slider=slider), encoding="utf-8")
    return path


@pytest.mark.parametrize("size", ["desktop", "phone"])
def test_it_opens_without_complaint_or_sideways_scrolling(browser, report, size):
    browser.open(report, size)
    assert browser.complaints() == []
    assert browser.overflow_px() <= 0
    assert browser.empty_figures() == []


def test_arrow_keys_move_picture_and_number(browser, report):
    from selenium.webdriver.common.keys import Keys

    drawn = "return [...document.querySelectorAll('g.marks > *')].filter(m => m.style.display !== 'none').length"
    browser.open(report, "desktop")
    assert browser.run(drawn) == 60
    browser.press(".dimples input", Keys.HOME, *[Keys.ARROW_RIGHT] * 10)
    # a tenth of a second and 3 % a step; the first impact at .1 s, the others 2.9/59 s apart
    assert browser.run("return document.querySelector('output').textContent") == "1.000 s: coverage 30.0 %, 19 dimples"
    assert browser.run(drawn) == 19


def test_without_scripts_the_last_state_stands(browser, report):
    browser.open(report, "phone", scripts=False)
    html = report.read_text(encoding="utf-8")
    assert "3.000 s: coverage 90.0 %, 60 dimples" in html and "display" not in html[html.index("<svg") : html.index("</svg>")]


def test_a_request_to_elsewhere_would_be_a_complaint(browser, tmp_path, report):
    """The page's policy really forbids what the check looks for."""
    html = report.read_text(encoding="utf-8").replace("</body>", '<img src="https://example.invalid/a.png"></body>')
    (tmp_path / "bad.html").write_text(html, encoding="utf-8")
    browser.open(tmp_path / "bad.html", "desktop")
    assert any("Content Security Policy" in text for text in browser.complaints())
    assert outside_references(html) == ["https://example.invalid/a.png"]
