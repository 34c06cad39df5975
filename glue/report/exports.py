"""``peen export``: a run as files that other codes read, in ``export/`` of its directory."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from glue.errors import InputError
from glue.scene.model import Scene
from glue.scene.reader import read_scene
from glue.study.manifest import read_manifest

FOLDER = "export"
# what: (stages it needs, what it writes)
KINDS = {
    "stl": (("surface",), "surface.stl: the peened surface over the window, an open sheet, binary"),
    "vtu": (("dimple", "flow", "surface"), "surface.vtu (height, hits), impacts.vtu, dimples.pvd (a series over time)"),
    "stress": (("target",), "stress.csv: by depth, of the part as modelled and held flat; plastic strain"),
    "inp": (("target",), "initial_stress.inp: *INITIAL CONDITIONS, TYPE=STRESS for the elements of --mesh"),
    "log": (("flow",), "impacts.csv in the units of --unit, and impacts_map.toml, with which peen import reads it back"),
}
ALWAYS = ("stl", "vtu", "stress", "log")  # what there is without being asked for: inp needs a mesh


@dataclass(frozen=True)
class Options:
    """``unit``: "m" or "mm", of STL, mesh and log; ``every``: row and column of the height map; the rest for inp."""

    unit: str = "m"
    every: int = 1
    mesh: Path | None = None
    surface: str = "z-max"
    code: str = "calculix"


def write_exports(run: Path, what: tuple[str, ...] = (), options: Options = Options()) -> tuple[list[Path], list[str]]:
    """Write the exports named (none named: all that the run has) and return (files, remarks).

    Raises InputError with everything that stands against it: unknown names, stages not complete, no mesh.
    """
    manifest = read_manifest(run)
    complete = {name for name, record in manifest["stages"].items() if record["state"] == "complete"}
    if not (run / "stress_profile.csv").exists():
        complete -= {"target"}  # complete, but nothing struck it
    lacking = {kind: [s for s in needs if s not in complete] for kind, (needs, _) in KINDS.items()}
    remarks = []
    if what:
        problems = [f"--what {kind}: allowed: {', '.join(KINDS)}" for kind in what if kind not in KINDS]
        problems += [
            f"--what {kind}: needs the stage {', '.join(lacking[kind])} complete; peen run goes on with it"
            for kind in what if kind in KINDS and lacking[kind]
        ]  # fmt: skip
        if "inp" in what and options.mesh is None:
            problems.append("--what inp: needs --mesh, the part that is to have the stress")
    else:
        what = tuple(kind for kind in (*ALWAYS, *(("inp",) if options.mesh else ())) if not lacking[kind])
        remarks = [f"left out: {kind} (stage {', '.join(lacking[kind])} is not complete)" for kind in ALWAYS if lacking[kind]]
        problems = [] if what else [f"{run}: has no complete stage that could be exported"]
    if options.every < 1:
        problems.append(f"--every {options.every}: allowed from 1 up")
    if options.unit not in ("m", "mm"):
        problems.append(f"--unit {options.unit}: allowed: m, mm")
    if problems:
        raise InputError(problems)
    scene = read_scene(run / "scene.toml", preset=manifest["preset_argument"])
    files = []
    for kind in what:
        written, told = _WRITERS[kind](run, scene, run / FOLDER, options)
        files += written
        remarks += told
    return files, remarks


def _stl(run: Path, scene: Scene, out: Path, options: Options):
    from glue.report.shapes import write_stl  # here: loads meshio

    write_stl(out / "surface.stl", *_heights(run), every=options.every, scale=1.0 if options.unit == "m" else 1e3)
    return [out / "surface.stl"], []


def _vtu(run: Path, scene: Scene, out: Path, options: Options):
    from glue.report import shapes
    from glue.report.slider import in_part
    from glue.study.results import load_dimple, load_impacts
    from glue.surface.coverage import dimple_semi_axes
    from glue.surface.hits import hit_counts

    impacts, (x, y, z) = load_impacts(run, scene), _heights(run)
    axes, window = dimple_semi_axes(load_dimple(run), impacts), scene.target.window_m
    near = in_part(impacts["x_m"], impacts["y_m"], *axes, impacts["time_s"], window, most=len(impacts) + 1)
    shapes.write_surface_vtu(out / "surface.vtu", x, y, z, hit_counts(x, y, *near[:5]), options.every)
    shapes.write_impacts_vtu(out / "impacts.vtu", impacts, axes)
    end = max([scene.exposure_time_s, *near.time_s[-1:]])
    series = shapes.write_dimple_series(out, near, float(end))
    solved = sorted(run.glob("target/**/fields.vtu"))
    told = [f"the target's own fields are there already: {', '.join(map(str, solved))}"] if solved else []
    return [out / "surface.vtu", out / "impacts.vtu", series[0]], [*told, f"dimples.pvd has {len(series) - 1} frames in dimples/"]


def _stress(run: Path, scene: Scene, out: Path, options: Options):
    from glue.report.initial_stress import write_stress_csv

    write_stress_csv(out / "stress.csv", _profile(run), scene)
    return [out / "stress.csv"], []


def _inp(run: Path, scene: Scene, out: Path, options: Options):
    from glue.report.initial_stress import held_profile, write_initial_stress

    told = write_initial_stress(
        out / "initial_stress.inp", options.mesh, held_profile(_profile(run), scene), surface=options.surface, unit=options.unit,
        code=options.code, title=scene.name,
    )  # fmt: skip
    return [out / "initial_stress.inp"], [
        f"{told['elements_stressed']} of {told['elements']} elements have initial stress: the part held flat, before it gives way"
    ]


def _log(run: Path, scene: Scene, out: Path, options: Options):
    from glue.flow.foreign_log import write_plain
    from glue.flow.impacts import read_impacts

    impacts, _ = read_impacts(run / "flow" / "impacts.csv")
    units = {} if options.unit == "m" else {"length": "mm", "speed": "mm/s"}
    write_plain(out / "impacts.csv", impacts, units, out / "impacts_map.toml")
    return [out / "impacts.csv", out / "impacts_map.toml"], []


def _heights(run: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    with np.load(run / "surface.npz") as data:
        return data["x_m"], data["y_m"], data["z_m"]


def _profile(run: Path) -> dict[str, np.ndarray]:
    table = np.genfromtxt(run / "stress_profile.csv", delimiter=",", names=True)
    return {name: np.atleast_1d(table[name]) for name in table.dtype.names}


_WRITERS = {"stl": _stl, "vtu": _vtu, "stress": _stress, "inp": _inp, "log": _log}
