"""The warnings of a study's runs: of one run, and which there are in how many runs."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

_BETWEEN = " | "
_NUMBER = re.compile(r"\d[\d.]*(e[+-]?\d+)?")


def warnings_of(metrics: dict) -> str:
    """Every text under a key ``warning`` of metrics.json, at any depth, as "<section>: <text>", in the file's order."""
    told = [(section, text) for section, values in metrics.items() for text in _told(values)]
    return _BETWEEN.join(f"{section}: {' '.join(text.split())}" for section, text in told)


def distinct(cells: Iterable[str]) -> list[tuple[str, int]]:
    """(warning, number of runs that have it) from ``warnings_of`` each run, the most frequent first.

    Warnings that differ in their numbers alone are one, shown as the first run has it.
    """
    shown: dict[str, str] = {}
    runs: dict[str, int] = {}
    for cell in cells:
        own = {_NUMBER.sub("0", text): text for text in reversed(cell.split(_BETWEEN)) if text}
        for alike, text in own.items():
            shown.setdefault(alike, text)
            runs[alike] = runs.get(alike, 0) + 1
    return sorted(((shown[alike], count) for alike, count in runs.items()), key=lambda found: (-found[1], found[0]))


def _told(values: object) -> Iterator[str]:
    for key, value in values.items() if isinstance(values, dict) else ():
        if key == "warning" and isinstance(value, str) and value:
            yield value
        else:
            yield from _told(value)
