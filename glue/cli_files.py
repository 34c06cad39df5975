"""``peen export`` and ``peen import``: a run's files for other codes, and other codes' impact tables for a run."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

_EXPORT = """Write a run as files that other codes read, into RUN/export/.

  stl     surface.stl: the height map over the window as an open sheet, normals outwards, binary STL
  vtu     surface.vtu (height, hits), impacts.vtu (every impact with its time), dimples.pvd (a series over time) for ParaView
  stress  stress.csv: residual stress by depth, of the part as modelled and of the part held flat; plastic strain
  inp     initial_stress.inp: *INITIAL CONDITIONS, TYPE=STRESS for every solid element of your mesh (--mesh)
  log     impacts.csv as plain CSV, and impacts_map.toml, with which peen import reads it back

Which stress goes into another part: that of the part *held* flat and unstretched, as peening left it.  Your code then
lets your part go, and it stretches and bends as its own shape allows; the run's own free plate has done so already
(sigma_xx_Pa in stress.csv), which is right for that plate alone.  A first static step without load brings the part
into balance.  Depth is measured from the plane of the mesh that --surface names, inwards; the profile's x and y lie along
the two other axes.  Nothing is written of stresses normal to the surface, nor of plastic strain: the part is as if elastic."""

_EXPORT_EXAMPLES = """examples:
  peen export runs/mine                                       everything but inp
  peen export runs/mine --what stl --unit mm --every 2        each other row of the height map, for CAD in mm
  peen export runs/mine --what inp --mesh part.inp --unit mm  for a mesh in mm: stress in MPa; then, in your deck before
                                                              *STEP:  *INCLUDE, INPUT=initial_stress.inp
  peen export runs/mine --what inp --mesh part.vtu --surface x-max --code abaqus"""

_IMPORT = """Turn an impact table of another code (EDEM, LIGGGHTS, any CSV) into an impact log, checked like our own.

A map in TOML tells how the table reads:

  schema = 1
  format = "csv"                  # csv, whitespace, or dump (LIGGGHTS: ITEM: TIMESTEP, ITEM: ENTRIES; needs timestep_s)
  timestep_s = 1e-7               # dump alone: seconds of one step
  separator = ","                 # between columns, csv alone: ";", "\\t", …
  decimal = "."                   # "," where numbers read 0,8 (then with another separator)
  skip_lines = 0                  # title lines above the line of column names; later lines with # in front are left out
  position = "contact"            # the points are where the shot touches; "centre": where its centre is
  origin_m = [0, 0, 0]            # our origin (middle of the window, on the surface), in the table's axes
  same_impact_s = 0.0             # rows of one shot_id at most so far apart are one impact, as in dumps of contacts
  axes = {x = "x", y = "-z", z = "y"}    # which of the table's axes ours are: z up, out of the target
  [columns]                       # our name = its column (SI), or with its unit; all in the table's own axes
  time_s = {column = "Time", unit = "ms"}
  x_m = {column = "Pos X", unit = "mm"}
  vz_in_m_s = {column = "Vel Z", unit = "mm/s", factor = -1}
  [constants]                     # one value for every row, SI
  diameter_m = 1e-3
  density_kg_m3 = 7800
  restitution = 0.4               # where the table has no velocities after the impact

Needed: time_s, x_m, y_m, v?_in_m_s, diameter_m, density_kg_m3, and v?_out_m_s or restitution. What else a log has (z_m,
spins, nx ny nz, shot_id, collisions_before, …) is taken where the map names it; columns that it does not name may hold
anything, text too. Errors name the file's line, counted from 1."""

_IMPORT_EXAMPLES = """examples:
  peen import edem.csv --map edem.toml --out impacts.csv
  peen run my.toml --impacts impacts.csv                      the log in place of the flow's own: checked against the scene"""


def add_commands(add) -> None:
    """Add both commands; ``add(name, does, help)`` makes a subparser (see ``glue.cli``)."""
    raw = argparse.RawDescriptionHelpFormatter
    export = add("export", _export, "a run as files for other codes: STL, ParaView, initial stress, plain impact log")
    export.description, export.epilog, export.formatter_class = _EXPORT, _EXPORT_EXAMPLES, raw
    export.add_argument("run", metavar="RUN", type=Path)
    export.add_argument("--what", metavar="KIND", nargs="+", default=[], help="stl, vtu, stress, inp, log (default: all but inp)")

    def option(name: str, default, metavar: str, help_text: str) -> None:
        kind = int if isinstance(default, int) else str
        export.add_argument(name, type=kind, default=default, metavar=metavar, help=f"{help_text} (default %(default)s)")

    option("--unit", "m", "m|mm", "lengths of STL, mesh and log; mm goes with MPa")
    option("--every", 1, "N", "each N-th row and column of the height map")
    export.add_argument("--mesh", type=Path, metavar="FILE", help="inp: your part, .inp (its own numbers) or .vtu, .msh, …")
    option("--surface", "z-max", "AXIS-END", "inp: the peened plane of the mesh: z-max, x-min, …")
    option("--code", "calculix", "CODE", "inp: calculix (a line an integration point) or abaqus (a line an element)")

    brought = add("import", _import, "an impact table of another code as an impact log, checked like our own")
    brought.description, brought.epilog, brought.formatter_class = _IMPORT, _IMPORT_EXAMPLES, raw
    brought.add_argument("table", metavar="TABLE", type=Path)
    brought.add_argument("--map", metavar="MAP.toml", type=Path, required=True, help="how its columns read, see above")
    brought.add_argument("--out", metavar="FILE", type=Path, default=Path("impacts.csv"), help="default %(default)s")


def _export(args) -> int:
    from glue.report.exports import Options, write_exports

    options = Options(args.unit, args.every, args.mesh, args.surface, args.code)
    files, remarks = write_exports(args.run, tuple(args.what), options)
    if args.json:
        print(json.dumps({"files": [str(f) for f in files], "remarks": remarks}, indent=2))
    else:
        print("\n".join([*(f"{f}  ({f.stat().st_size / 1e6:.2f} MB)" for f in files), *remarks]))
    return 0


def _import(args) -> int:
    from glue.flow.column_map import read_map
    from glue.flow.foreign_log import read_foreign
    from glue.flow.impacts import normal_speed_m_s, write_impacts

    impacts, header = read_foreign(args.table, read_map(args.map))
    write_impacts(args.out, impacts, {"scene_hash": None, **header})
    spans = {name: impacts[name] for name in ("time_s", "x_m", "y_m", "diameter_m")}
    spans["normal_speed_m_s"] = normal_speed_m_s(impacts)
    told = {"file": str(args.out), "impacts": len(impacts)}
    told |= {name: [float(values.min()), float(values.max())] for name, values in spans.items()}
    if args.json:
        print(json.dumps(told, indent=2))
    else:
        for key, value in told.items():
            print(f"{key:<18}{' to '.join(f'{v:.4g}' for v in value) if isinstance(value, list) else value}")
        print(f"use it: peen run SCENE --impacts {args.out}")
    return 0
