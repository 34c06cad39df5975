"""Do the reports work in a browser?  A run's and a study's in headless Chromium, at a desk, on a phone, on paper.

    .venv/bin/python tests/report/browser_check.py [--run DIR] [--json FILE]      (make check-report)

One PASS/FAIL line a row; screenshots and PDFs go to build/report/shots, to be looked at.  Without --run the default scene is
run with the fast models (half a minute, once).
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from browser import Browser, chromium, missing, outside_references
from study_case import write_study

from glue.checkrows import Rows
from glue.report.study_page import write_study_report

LARGEST_BYTES = 5_000_000
FAST = {"models": {}, "models.target": "layers", "models.flow": "event", "accuracy": {}, "accuracy.preset": "fast"}
_STATE = (
    "const map = document.querySelector('.dimples');"
    "return [map.querySelector('output').textContent,"
    " [...map.querySelectorAll('g.marks > *')].filter(m => m.style.display !== 'none').length]"
)
_LEAST = {"run": 6, "study": 2}  # figures: the impact map and five drawn ones; a study has one for each metric


def check_page(rows: Rows, browser: Browser, page: Path, kind: str, shots: Path) -> None:
    """What holds for every report: size, nothing from outside, no complaint, figures, widths, tables that copy."""
    html = page.read_text(encoding="utf-8")
    rows.below(f"{kind}: size of the file, bytes", page.stat().st_size, LARGEST_BYTES)
    outside = outside_references(html)
    rows.below(f"{kind}: references to anything outside the file", len(outside), 0, " ".join(outside[:3]))
    for size in ("desktop", "phone"):
        browser.open(page, size)
        empty = browser.empty_figures()
        rows.below(f"{kind}, {size}: figures without a natural size", len(empty), 0, "; ".join(empty))
        figures = browser.run("return document.querySelectorAll('figure img, figure svg').length")
        rows.true(f"{kind}, {size}: at least {_LEAST[kind]} figures", figures >= _LEAST[kind], f"{figures} found")
        rows.below(f"{kind}, {size}: pixels of sideways scrolling", browser.overflow_px(), 0)
        browser.click("button.copy")
        copied = browser.driver.execute_async_script(
            "const end = arguments[0]; setTimeout(() => end(document.querySelector('button.copy').textContent), 300)"
        )
        rows.true(f"{kind}, {size}: a table's button copies", copied == "copied", f"says {copied!r}")
        browser.screenshot(shots / f"{kind}-{size}.png")
        complaints = browser.complaints()
        rows.below(f"{kind}, {size}: console warnings and errors", len(complaints), 0, "; ".join(complaints)[:300])
    browser.pdf(shots / f"{kind}.pdf")
    browser.open(page, "desktop", scripts=False)
    browser.screenshot(shots / f"{kind}-no-script.png")


def check_tables(rows: Rows, browser: Browser, page: Path, kind: str) -> None:
    """What the copy button takes: as many columns in every row, with the number's own digits."""
    browser.open(page, "desktop")
    texts = browser.run("return [...document.querySelectorAll('table')].map(tableText)")
    ragged = [text for text in texts if len({line.count("\t") for line in text.rstrip("\n").split("\n")}) != 1]
    rows.below(f"{kind}: tables whose text has rows of unequal length", len(ragged), 0, f"of {len(texts)}")


def check_slider(rows: Rows, browser: Browser, page: Path) -> None:
    """The impact map: the last state first, then moved by the keyboard to the start and one step on."""
    from selenium.webdriver.common.keys import Keys

    browser.open(page, "phone")
    words, marks = browser.run(_STATE)
    rows.true("slider: shows the last state first", marks > 0 and "coverage" in words, f"{words}; {marks} drawn")
    at, last = browser.run("const s = document.querySelector('.dimples input'); return [s.value, s.max]")
    rows.true("slider: stands at its end", at == last, f"step {at} of {last}")
    browser.press(".dimples input", Keys.HOME)
    at_start = browser.run(_STATE)
    rows.true("slider: HOME empties the picture", at_start[1] == 0 and "coverage 0.0 %" in at_start[0], at_start[0])
    seen = [at_start[0]]
    for _ in range(40):
        browser.press(".dimples input", Keys.ARROW_RIGHT)
        seen.append(browser.run(_STATE)[0])
    rows.true("slider: every arrow key changes the number", len(set(seen)) == len(seen), seen[-1])
    rows.true("slider: dimples appear with it", 0 < browser.run(_STATE)[1] < marks, f"{browser.run(_STATE)[1]} of {marks}")
    browser.press(".dimples input", Keys.END)
    rows.true("slider: END brings the last state back", browser.run(_STATE) == [words, marks])
    complaints = browser.complaints()
    rows.below("slider: console warnings and errors", len(complaints), 0, "; ".join(complaints)[:300])


def check_sorting(rows: Rows, browser: Browser, page: Path) -> None:
    """A click on a head of the runs' table sorts by its numbers, another turns the order round."""
    browser.open(page, "desktop")
    column = "const t = document.querySelector('th[aria-sort]').closest('table'); const n = t.rows[0].cells.length - 2;"
    word = "r => r.cells[n].dataset.raw ?? r.cells[n].textContent"
    values = column + f"return [...t.tBodies[0].rows].map({word}).filter(v => v).map(Number)"
    mark = column + "t.rows[0].cells[n].querySelector('button').click()"
    before = browser.run(values)
    browser.run(mark)
    up = browser.run(values)
    browser.run(mark)
    rows.true("study: a click sorts the runs by number", up == sorted(before) and len(set(up)) > 2, f"{len(up)} values")
    rows.true("study: a second click turns them round", browser.run(values) == up[::-1])


def a_run(out: Path) -> Path:
    """The default scene with the fast models in ``out``, run or brought up to date."""
    from glue.scene.derive import changed
    from glue.scene.reader import example_path
    from glue.study import pipeline

    def told(stage: str, fraction: float | None, text: str) -> None:
        if fraction in (0.0, 1.0):
            print(f"{stage} {text}", file=sys.stderr, flush=True)

    content = changed(example_path("al2024-s390").read_bytes(), FAST)
    return pipeline.run("al2024-s390", out, content=content, progress=told)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--run", type=Path, metavar="DIR", help="a run directory whose report is checked (default: one is made)")
    parser.add_argument("--study", type=Path, metavar="DIR", help="a study's folder (default: one made by hand)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write the rows here")
    given = parser.parse_args()
    if missing():
        sys.exit(f"{', '.join(missing())} not installed; make check-report installs them")
    out = Path("build/report")
    shots = out / "shots"
    shots.mkdir(parents=True, exist_ok=True)
    run = given.run or a_run(out / "run")
    sys.argv[1:] = ["--json", str(given.json)] if given.json else []
    rows = Rows("reports in headless Chromium")
    with chromium() as browser:
        print(f"Chromium {browser.driver.capabilities['browserVersion']}")
        check_page(rows, browser, run / "report.html", "run", shots)
        check_tables(rows, browser, run / "report.html", "run")
        check_slider(rows, browser, run / "report.html")
        study = write_study_report(given.study or write_study(out / "study"))
        check_page(rows, browser, study, "study", shots)
        check_tables(rows, browser, study, "study")
        check_sorting(rows, browser, study)
    rows.finish()


if __name__ == "__main__":
    main()
