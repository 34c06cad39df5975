"""Meshes as CalculiX and Abaqus read them: solid elements with the numbers and types that their author gave them.

meshio reads such files too, but drops the elements' numbers, without which nothing can be said of an element.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from glue.errors import InputError

# Nodes of the solid elements known here, and how many of them are corners (which come first).
NODES = {"C3D4": (4, 4), "C3D10": (10, 4), "C3D8": (8, 8), "C3D8I": (8, 8), "C3D8R": (8, 8), "C3D20": (20, 8), "C3D20R": (20, 8)}


def read_inp(path: Path) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """{element type: (numbers (m,), corners (m, 4 or 8, 3))} of the solid elements of a CalculiX or Abaqus input file.

    Raises InputError for a missing file, one without solids, keywords that make or place nodes out of sight (*INCLUDE,
    *NGEN, *NCOPY, *ELGEN, *INSTANCE), other solid elements, and elements of unknown nodes: all at once.
    """
    try:
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError as problem:
        raise InputError(f"{path}: cannot be read ({problem.strerror})") from None
    nodes, elements, problems = {}, {}, []
    into, waiting = None, []
    for count, line in enumerate(lines, 1):
        text = line.strip()
        if not text or text.startswith("**"):
            continue
        if text.startswith("*"):
            into, waiting = _opened(text, f"{path}:{count}", problems), []
            continue
        if into is None:
            continue
        try:
            waiting += [float(word) for word in text.split(",") if word.strip()]
        except ValueError:
            problems.append(f"{path}:{count}: {text[:40]!r} is not a row of numbers")
            into = None
            continue
        if into == "NODE":
            nodes[int(waiting[0])] = [*waiting[1:4], 0.0, 0.0][:3]
            waiting = []
        elif len(waiting) > NODES[into][0]:  # an element may take several lines
            elements.setdefault(into, {})[int(waiting[0])] = [int(v) for v in waiting[1 : 1 + NODES[into][1]]]
            waiting = []
    if not elements and not problems:
        problems.append(f"{path}: holds no solid element; allowed: {', '.join(NODES)}")
    unknown = sorted({n for rows in elements.values() for row in rows.values() for n in row if n not in nodes})
    if unknown:
        problems.append(f"{path}: {len(unknown)} nodes of elements are not in the file (first: {unknown[0]})")
    if problems:
        raise InputError(problems)
    return {
        kind: (np.array(list(rows)), np.array([[nodes[n] for n in row] for row in rows.values()], dtype=float))
        for kind, rows in elements.items()
    }


def _opened(text: str, place: str, problems: list[str]) -> str | None:
    """What the rows after a keyword line are: "NODE", an element type, or None for rows of no interest."""
    words = [word.strip().upper() for word in text.split(",")]
    keyword = words[0].replace(" ", "")
    if keyword in ("*INCLUDE", "*NGEN", "*NCOPY", "*NFILL", "*ELGEN", "*ELCOPY", "*INSTANCE"):
        problems.append(f"{place}: {words[0]} is not followed; give a mesh whose nodes and elements are all written out")
        return None
    if keyword == "*NODE":
        return "NODE"
    if keyword != "*ELEMENT":
        return None
    kind = next((w.split("=")[1].strip() for w in words[1:] if w.replace(" ", "").startswith("TYPE=")), "")
    if kind in NODES:
        return kind
    if kind.startswith("C3D"):
        problems.append(f"{place}: elements of type {kind} are not known here; allowed: {', '.join(NODES)}")
    return None  # shells and beams have no place in a depth
