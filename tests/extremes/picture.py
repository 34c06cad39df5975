"""The stability map as a picture: a panel per crossing of two axes, a square per cell, green, grey or red."""

from __future__ import annotations

import math
from pathlib import Path

from grid import Cell
from judges import REFUSED, RIGHT, WRONG, Verdict

COLOURS = {RIGHT: "#3f9b5b", REFUSED: "#b9bec4", WRONG: "#d3322d"}
COLUMNS = 4


def draw(cells: list[Cell], verdicts: dict[str, Verdict], path: Path) -> None:
    """Write ``path`` (PNG); cells without a verdict stay white."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.patches import Patch, Rectangle

    panels: dict[str, list[Cell]] = {}
    for cell in cells:
        panels.setdefault(cell.panel, []).append(cell)
    rows = math.ceil(len(panels) / COLUMNS)
    heights = [max(len({c.row for c in own}) for own in list(panels.values())[COLUMNS * k : COLUMNS * (k + 1)]) + 3.4 for k in range(rows)]
    figure = plt.figure(figsize=(15.0, 0.25 * sum(heights) + 0.6), dpi=66)
    grid = figure.add_gridspec(rows, COLUMNS, height_ratios=heights, hspace=0.08, wspace=0.66, left=0.09, right=0.965, top=0.945, bottom=0.005)
    for k, (title, own) in enumerate(panels.items()):
        down, across = list(dict.fromkeys(c.row for c in own)), list(dict.fromkeys(c.column for c in own))
        axes = figure.add_subplot(grid[k // COLUMNS, k % COLUMNS])
        for cell in own:
            found = verdicts.get(cell.name)
            colour = COLOURS[found.verdict] if found else "white"
            corner = (across.index(cell.column) + 0.05, down.index(cell.row) + 0.05)
            axes.add_patch(Rectangle(corner, 0.9, 0.9, facecolor=colour, edgecolor="none"))
        axes.set_xlim(0.0, max(len(across), 4))
        axes.set_ylim(heights[k // COLUMNS] - 1.6, -1.6)  # the same size of square in every panel
        axes.set_yticks([i + 0.5 for i in range(len(down))], down, fontsize=8)
        axes.set_xticks([i + 0.5 for i in range(len(across))], across, fontsize=8, rotation=24, ha="left", rotation_mode="anchor")
        axes.xaxis.tick_top()
        axes.tick_params(length=0, pad=1)
        axes.spines[:].set_visible(False)
        axes.xaxis.set_tick_params(pad=-22)
        axes.set_title(title, fontsize=9.5, fontweight="bold", loc="left", x=-0.32, pad=4)
    count = {kind: sum(v.verdict == kind for v in verdicts.values()) for kind in COLOURS}
    told = {RIGHT: "right by a named invariant", REFUSED: "refused, saying what is allowed", WRONG: "wrong"}
    figure.legend([Patch(color=colour) for colour in COLOURS.values()], [f"{count[k]} {told[k]}" for k in COLOURS],
                  loc="upper center", ncols=3, frameon=False, fontsize=12)  # fmt: skip
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    _few_colours(path)
    plt.close(figure)


def _few_colours(path: Path) -> None:
    """A palette of 64 colours that keeps the rare ones: a third of the bytes, and nothing to see of it."""
    from PIL import Image

    with Image.open(path) as picture:
        small = picture.convert("RGB").quantize(64, method=Image.Quantize.MAXCOVERAGE)
    small.save(path, optimize=True)
