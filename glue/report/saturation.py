"""The figure of a saturation curve: points, fitted curve, saturation and its double."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from glue.report.figures import BLUE, GREY, ORANGE, RED, styled_figure
from glue.theory.almen import INCH_m


def saturation_plot(path: Path, found, *, unit: str, title: str = "", measured=None) -> Path:
    """Arc heights over exposure with the fit of ``glue.surface.saturation``; a curve without problem.

    unit: of the exposures; measured: optional (exposure, arc_height_m) drawn beside, in the same unit.
    """
    best, t, h = found.best, found.exposure, found.arc_height_m
    end = 1.05 * max(t[-1], 2.0 * best.saturation, *([] if measured is None else [np.max(measured[0])]))
    smooth = np.linspace(0.0, end, 300)
    with styled_figure(path, (8.0, 5.2)) as figure:
        axes = figure.subplots()
        axes.plot(smooth, 1e3 * best(smooth), color=BLUE, label=f"{best.form.text}")
        axes.plot(t, 1e3 * h, "o", color=BLUE, mec="white", ms=8, label="points fitted", zorder=4)
        if measured is not None:
            axes.plot(measured[0], 1e3 * np.asarray(measured[1]), "s", color=ORANGE, mec="white", ms=8, label="measured", zorder=5)
        for factor, name in ((1.0, "T"), (2.0, "2T")):
            at, height = factor * best.saturation, 1e3 * float(best(factor * best.saturation))
            axes.plot([at, at], [0.0, height], color=GREY, ls=(0, (4, 3)), lw=1.4)
            axes.annotate(name, (at, height), xytext=(4, -14), textcoords="offset points", color=GREY)
        half = found.intensity_half_width_m
        axes.axhspan(1e3 * (found.intensity_m - half), 1e3 * (found.intensity_m + half), color=RED, alpha=0.12, lw=0)
        axes.plot([best.saturation], [1e3 * found.intensity_m], "D", color=RED, ms=8, mec="white", zorder=6,
                  label=f"intensity {found.intensity_m / INCH_m * 1e3:.2f} mil ± {half / INCH_m * 1e3:.2f}")  # fmt: skip
        axes.set(xlabel=f"exposure [{unit}]", ylabel="arc height [mm]", xlim=(0, end), title=title)
        axes.set_ylim(0, 1.12e3 * max(float(h.max()), float(best(end))))
        second = axes.secondary_yaxis("right", functions=(lambda y: y / 25.4 * 1e3, lambda y: y * 25.4e-3))
        second.set_ylabel("[mil]")
        axes.legend(loc="lower right", frameon=True, facecolor="white", edgecolor="none", framealpha=0.9)
    return path
