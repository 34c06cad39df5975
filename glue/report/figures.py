"""The figures of a run: PNG files from plain arrays in SI units, drawn in mm, um and MPa.

Every function takes the file's path first, writes it whole and returns it.  Matplotlib is imported when a
figure is drawn, not before, and used without pyplot, so that no window or global state is involved.
Colours tell apart for every kind of colour vision (Okabe and Ito; cividis for fields).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from glue.atomic import atomic_path

BLUE, ORANGE, GREEN, RED, GREY = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#6b6b6b"
FIELD_MAP = "cividis"
DPI = 150
STYLE = {
    "font.size": 11.0,
    "axes.titlesize": 11.5,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e6e6e6",
    "grid.linewidth": 0.8,
    "axes.axisbelow": True,
    "axes.edgecolor": "#404040",
    "legend.frameon": False,
    "lines.linewidth": 2.0,
}


def impact_map(
    path: Path, x_m, y_m, semi_major_m, semi_minor_m, azimuth_rad, time_s, window_m, jets_m
) -> Path:
    """Dimples to scale where the jets strike and in the window, coloured by the time of impact.

    All columns (n,); window_m: (width, height); jets_m: for each jet the closed outline (k, 2) of what it
    strikes (where it starts), and None or the way (k, 2) that its aim point travels.
    """
    from matplotlib.patches import Rectangle
    from matplotlib.ticker import MaxNLocator

    columns = (x_m, y_m, semi_major_m, semi_minor_m, azimuth_rad, time_s)
    x, y, major, minor, azimuth, time = (np.asarray(c, dtype=float) for c in columns)
    width, height = (1e3 * side for side in window_m)
    jets = [(1e3 * np.asarray(outline), None if way is None else 1e3 * np.asarray(way)) for outline, way in jets_m]
    travelling = any(way is not None for _, way in jets)
    with styled_figure(path, (11.5, 5.6)) as figure:
        whole, zoom = figure.subplots(1, 2)
        for axes in (whole, zoom):
            dimples = _ellipses(axes, 1e3 * x, 1e3 * y, 1e3 * major, 1e3 * minor, azimuth, time)
            axes.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
            axes.grid(False)
        corner = np.array([[width, height]]) / 2
        seen = [corner, -corner]
        for outline, way in jets:
            whole.plot(*outline.T, color=GREY, ls=(0, (5, 3)), lw=1.5)
            seen.append(outline)
            if way is None:
                continue
            seen += [outline + (place - way[0]) for place in way]
            whole.plot(*way.T, color="#202020", lw=1.2)
            whole.plot(*way[0], "o", color="#202020", ms=5)
            whole.annotate("", way[-1], way[-2], arrowprops={"arrowstyle": "-|>", "color": "#202020", "lw": 1.2})
        whole.add_patch(Rectangle((-width / 2, -height / 2), width, height, fill=False, ec=RED, lw=2.0))
        middle, reach = _square(np.concatenate(seen))
        dashed = f"jet{'s' if len(jets) > 1 else ''} (dashed{', at the start' if travelling else ''})"
        whole.set(
            xlim=(middle[0] - reach, middle[0] + reach),
            ylim=(middle[1] - reach, middle[1] + reach),
            title=f"{x.size} impacts; {dashed}, window (red)",
        )
        for axis in (whole.xaxis, whole.yaxis):
            axis.set_major_locator(MaxNLocator(6, integer=True))
        zoom.set(xlim=(-width / 2, width / 2), ylim=(-height / 2, height / 2))
        inside = np.count_nonzero((np.abs(x) <= window_m[0] / 2) & (np.abs(y) <= window_m[1] / 2))
        zoom.set_title(f"Window {width:g} × {height:g} mm: {inside} impacts (white: not hit)")
        for side in zoom.spines.values():
            side.set(visible=True, edgecolor=RED, linewidth=2.0)
        figure.colorbar(
            dimples, ax=[whole, zoom], label="time of impact [s]", shrink=0.85, pad=0.015
        ).solids.set_alpha(1)
    return path


def coverage_plot(
    path: Path, time_s, coverage, avrami, *, avrami_sd=None, time_98_s=None, avrami_time_98_s=None
) -> Path:
    """Coverage (0-1) against time (n,), counted and by Avrami, with the 98 % line.

    avrami_sd: optional (n,) standard deviation of one window's coverage about Avrami's, drawn as +- 2 sd.
    time_98_s, avrami_time_98_s: optional times at which each reaches 98 %.
    """
    t, counted, expected = (np.asarray(c, dtype=float) for c in (time_s, coverage, avrami))
    with styled_figure(path, (8.0, 5.0)) as figure:
        axes = figure.subplots()
        if avrami_sd is not None:
            low, high = expected - 2 * np.asarray(avrami_sd), expected + 2 * np.asarray(avrami_sd)
            label = "its scatter in a window this size (± 2 sd)"
            axes.fill_between(
                t,
                100 * np.clip(low, 0, 1),
                100 * np.clip(high, 0, 1),
                color=ORANGE,
                alpha=0.2,
                lw=0,
                label=label,
            )
        axes.plot(t, 100 * expected, color=ORANGE, ls=(0, (6, 2)), label=f"Avrami{_at(avrami_time_98_s)}")
        axes.plot(t, 100 * counted, color=BLUE, label=f"share of sample points hit{_at(time_98_s)}")
        axes.axhline(98, color=GREY, lw=1.2)
        axes.text(1.01, 98, "98 %", transform=axes.get_yaxis_transform(), va="center", color=GREY)
        for when, colour in ((time_98_s, BLUE), (avrami_time_98_s, ORANGE)):
            if when is not None and when <= t[-1]:
                axes.plot([when], [98], "o", ms=7, color=colour, mec="white", zorder=5)
        axes.set(xlabel="exposure time [s]", ylabel="coverage [%]", xlim=(t[0], t[-1]), ylim=(0, 102))
        handles, labels = axes.get_legend_handles_labels()
        order = sorted(
            range(len(labels)),
            key=lambda i: ("share", "Avrami", "its").index(labels[i].split()[0].rstrip(",")),
        )
        axes.legend([handles[i] for i in order], [labels[i] for i in order], loc="lower right")
    return path


def stress_plot(
    path: Path,
    depth_m,
    sigma_xx_Pa,
    sigma_yy_Pa,
    *,
    sigma_xx_std_Pa=None,
    sigma_yy_std_Pa=None,
    peeq=None,
    marks=None,
    measured=None,
) -> Path:
    """Residual stress against depth (n,), its spread over position (+- 1 sd) and plastic strain beside it.

    marks: optional residual-stress metrics (see ``glue.surface.stress``) whose largest compression and sign
    change are pointed at.  measured: optional (depth_m, stress_Pa, stress_sd_Pa or None), drawn as points.
    """
    depth = 1e3 * np.asarray(depth_m, dtype=float)
    marks = marks or {}
    with styled_figure(path, (8.0, 5.2)) as figure:
        axes = figure.subplots()
        axes.axhline(0, color="#404040", lw=1.0)
        curves = (
            (sigma_xx_Pa, sigma_xx_std_Pa, BLUE, "-", "σxx"),
            (sigma_yy_Pa, sigma_yy_std_Pa, RED, (0, (6, 2)), "σyy"),
        )
        for stress, spread, colour, line, name in curves:
            stress = 1e-6 * np.asarray(stress, dtype=float)
            label = name
            if spread is not None:
                spread = 1e-6 * np.asarray(spread, dtype=float)
                axes.fill_between(depth, stress - spread, stress + spread, color=colour, alpha=0.14, lw=0)
                label += " (band: ± 1 sd over position)"
            axes.plot(depth, stress, color=colour, ls=line, label=label)
        if measured is not None:
            at, values, sd = (None if c is None else np.asarray(c, dtype=float) for c in measured)
            bars = None if sd is None else 1e-6 * sd
            axes.errorbar(
                1e3 * at, 1e-6 * values, yerr=bars, fmt="s", ms=6, color="#202020", mec="white", lw=1.2, capsize=3, zorder=6,
                label="measured" + ("" if sd is None else " (± 1 sd)"),
            )  # fmt: skip
        low, where = marks.get("max_compressive_Pa"), marks.get("max_compressive_depth_m")
        if low is not None:
            _point(
                axes, 1e3 * where, 1e-6 * low, f"−{-1e-6 * low:.0f} MPa at {1e3 * where:.2f} mm", (10, -22)
            )
        if marks.get("compressive_depth_m") is not None:
            _point(
                axes,
                1e3 * marks["compressive_depth_m"],
                0.0,
                f"{1e3 * marks['compressive_depth_m']:.2f} mm",
                (10, -18),
            )
        deepest = depth[-1]
        if peeq is not None and np.max(peeq) > 0:  # the rest of a thick plate is one straight line
            deepest = min(deepest, 2.0 * depth[np.flatnonzero(np.asarray(peeq) > 1e-3 * np.max(peeq))[-1]])
        if measured is not None:
            deepest = max(deepest, 1.03e3 * float(np.max(measured[0])))
        axes.set(xlabel="depth [mm]", ylabel="residual stress [MPa]", xlim=(0, deepest))
        axes.margins(y=0.1)
        handles, labels = axes.get_legend_handles_labels()
        if peeq is not None:
            strain = axes.twinx()
            strain.grid(False)
            strain.spines["right"].set(visible=True, color=GREEN)
            handles += strain.plot(depth, 100 * np.asarray(peeq, dtype=float), color=GREEN, ls=":", lw=2.2)
            labels += ["equivalent plastic strain (right)"]
            strain.set_ylabel("equivalent plastic strain [%]", color=GREEN)
            strain.tick_params(axis="y", colors=GREEN)
            strain.set_ylim(bottom=0)
        figure.legend(handles, labels, loc="outside upper center", ncols=2)
    return path


def height_map_plot(path: Path, x_m, y_m, z_m, *, roughness=None) -> Path:
    """Height map ``z_m`` (ny, nx) over ``x_m`` (nx,) and ``y_m`` (ny,), mean taken out, and a cut.

    roughness: optional metrics (see ``glue.surface.roughness``) for the title.
    """
    x, y = 1e3 * np.asarray(x_m, dtype=float), 1e3 * np.asarray(y_m, dtype=float)
    z = 1e6 * np.asarray(z_m, dtype=float)
    z = z - z.mean()
    cut = int(np.argmin(np.abs(y)))
    with styled_figure(path, (7.2, 8.4)) as figure:
        top, bottom = figure.subplots(2, 1, height_ratios=(3.4, 1), sharex=True)
        image = top.imshow(
            z, origin="lower", extent=_extent(x, y), cmap=FIELD_MAP, interpolation="nearest", aspect="equal"
        )
        top.axhline(y[cut], color="white", lw=1.2, ls=(0, (4, 3)))
        top.set(ylabel="y [mm]")
        top.grid(False)
        if roughness:
            shape = "".join(
                f", {key} {roughness[key]:.2f}" for key in ("Ssk", "Sku") if roughness.get(key) is not None
            )
            top.set_title(f"Sa {1e6 * roughness['Sa_m']:.1f} µm, Sz {1e6 * roughness['Sz_m']:.0f} µm{shape}")
        figure.colorbar(image, ax=top, label="height [µm]", shrink=0.95, pad=0.02)
        bottom.axhline(0, color="#404040", lw=0.8)
        bottom.plot(x, z[cut], color=BLUE, lw=1.6)
        bottom.set(
            xlabel="x [mm]", ylabel="height [µm]", title=f"Cut at y = {_zero(y[cut]):.2f} mm (dashed above)"
        )
        bottom.set_xlim(*_extent(x, y)[:2])
    return path


class styled_figure:
    """A styled matplotlib figure that is written to ``path`` when the block ends well."""

    def __init__(self, path: Path, size: tuple[float, float]):
        from matplotlib import rc_context
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.path, self.style = Path(path), rc_context(STYLE)
        self.style.__enter__()
        self.figure = Figure(figsize=size, layout="constrained")
        FigureCanvasAgg(self.figure)

    def __enter__(self):
        return self.figure

    def __exit__(self, kind, *exc):
        try:
            if kind is None:
                with atomic_path(self.path) as part:
                    self.figure.savefig(part, dpi=DPI, format="png")
        finally:
            self.style.__exit__(None, None, None)


def _square(points) -> tuple[np.ndarray, float]:
    """Middle (2,) and half side of the square, with a rim, that holds ``points`` (n, 2)."""
    low, high = points.min(axis=0), points.max(axis=0)
    return 0.5 * (low + high), 1.06 * 0.5 * float((high - low).max())


def _ellipses(axes, x, y, major, minor, azimuth, colour):
    from matplotlib.collections import EllipseCollection

    collection = EllipseCollection(
        2 * major, 2 * minor, np.degrees(azimuth), units="xy", offsets=np.column_stack([x, y]),
        offset_transform=axes.transData, array=colour, cmap=FIELD_MAP, alpha=0.7,
        edgecolors="white", linewidths=0.25,
    )  # fmt: skip
    return axes.add_collection(collection)


def _point(axes, x, y, text, offset):
    axes.plot([x], [y], "o", ms=7, color="#202020", mec="white", zorder=5)
    axes.annotate(text, (x, y), xytext=offset, textcoords="offset points", zorder=6,
                  bbox={"fc": "white", "ec": "none", "alpha": 0.75, "pad": 1.5})  # fmt: skip


def _at(time_s) -> str:
    return "" if time_s is None else f", 98 % at {time_s:.2f} s"


def _extent(x, y) -> tuple[float, float, float, float]:
    """Outer edges of the cells whose centres are ``x`` and ``y``."""
    half_x, half_y = 0.5 * (x[1] - x[0]), 0.5 * (y[1] - y[0])
    return x[0] - half_x, x[-1] + half_x, y[0] - half_y, y[-1] + half_y


def _zero(value: float) -> float:
    """``value`` without the sign of a zero that prints as -0.00."""
    return value if abs(value) >= 0.005 else 0.0
