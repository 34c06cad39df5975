"""Does everything work here? Each row proves one thing by doing it, and says what to do when it fails."""

from __future__ import annotations

import math
import os
import re
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from glue.errors import SolverFailed
from glue.solvers import find, freefem, process
from glue.solvers.yade import run_yade

_DONE = '{ ofstream status("status"); status << "ok" << endl; }\n'

# -u'' = 1 on the unit square, u = 0 at x = 0 and 1: u = x (1 - x)/2, which P2 holds exactly; integral 1/12.
_POISSON = (
    """load "UMFPACK64"
mesh Th = square(8, 8);
fespace Vh(Th, P2);
Vh u, v;
solve Poisson(u, v, solver = "CHOLMOD", sym = 1)
  = int2d(Th)(dx(u)*dx(v) + dy(u)*dy(v)) - int2d(Th)(v) + on(2, 4, u = 0);
cout.precision(12);
cout << "integral " << int2d(Th)(u) << endl;
"""
    + _DONE
)

# One steel shot of 1 mm strikes a wall at 60 m/s with restitution .6: .5998 was measured at this time step.
_BOUNCE = """
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()]),
  InteractionLoop([Ig2_Wall_Sphere_ScGeom(hertzian=True)],
    [Ip2_FrictMat_FrictMat_MindlinPhys(en=0.6, es=0.99)], [Law2_ScGeom_MindlinPhys_Mindlin()]),
  NewtonIntegrator(damping=0)]
O.materials.append(FrictMat(young=210e9, poisson=0.3, density=7800, frictionAngle=0))
O.bodies.append(utils.wall(0, axis=2))
shot = O.bodies[O.bodies.append(utils.sphere((0, 0, 0.51e-3), 0.5e-3))]
shot.state.vel = (0, 0, -60)
O.dt = 0.05 * 0.5e-3 * (7800 / 210e9) ** 0.5
while shot.state.pos[2] < 0.52e-3 and O.iter < 20000:
    O.step()
print("restitution", shot.state.vel[2] / 60, flush=True)
"""


class Row(NamedTuple):
    """One finding; ``advice`` is empty when ``ok``."""

    ok: bool
    what: str
    detail: str
    advice: str = ""


def doctor() -> list[Row]:
    """Examine this machine (about 10 s); never raises for what it examines."""
    checks: list[tuple[str, Callable[[], str]]] = [
        ("Python", _python),
        ("checkout", lambda: f"runs from {find.require_checkout()}"),
        ("YADE version", lambda: _version("yade", find.find_yade)),
        ("YADE runs", _yade_bounces),
        ("FreeFem++ version", lambda: _version("freefem", find.find_freefem)),
        ("FreeFem++ solves", _freefem_solves),
        ("ff-c++", lambda: str(find.find_compiler())),
        ("kernels", lambda: f"built in {freefem.build_plugin()}"),
        *((f'load "{name}"', lambda name=name: _plugin_loads(name)) for name in plugins_used()),
        ("pictures", _draws),
    ]
    return [_row(what, check) for what, check in checks]


def plugins_used() -> list[str]:
    """Names that the project's own scripts load, sorted."""
    scripts = [p for kind in ("*.edp", "*.idp") for p in (find.repo_root() / "freefem").rglob(kind)]
    found = {"msh3", "UMFPACK64"}
    for path in scripts:
        found.update(re.findall(r'^\s*load\s+"([^"]+)"', path.read_text(), re.MULTILINE))
    return sorted(found)


def _row(what: str, check: Callable[[], str]) -> Row:
    try:
        return Row(True, what, check())
    except SolverFailed as problem:  # its log went with the scratch folder
        return Row(False, what, problem.cause or problem.what, problem.advice)
    except OSError as problem:
        return Row(False, what, str(problem), "is the folder writable and the disk not full?")


def _python() -> str:
    if sys.version_info < (3, 11):
        raise SolverFailed(
            "", cause=f"{sys.version.split()[0]}, 3.11 or later is needed", advice="make setup"
        )
    return f"{sys.version.split()[0]} at {sys.executable}"


def _version(code: str, finder: Callable[[], Path]) -> str:
    binary = finder()
    found = find.versions()[code]
    if found["binary"] is None:
        raise SolverFailed(
            "", cause=f"{binary} does not tell its version", advice="reinstall its package: make setup"
        )
    return f"{binary} calls itself {found['binary']}, Debian package {found['package'] or 'not installed'}"


def _yade_bounces() -> str:
    with tempfile.TemporaryDirectory(prefix="peen-doctor-") as name:
        folder = Path(name)
        script = folder / "bounce.py"
        script.write_text(_BOUNCE)
        lines: list[str] = []
        done = run_yade(script, [], cwd=folder, log=folder / "log", timeout_s=60, on_line=lines.append)
    e = _number("restitution", lines)
    if not abs(e - 0.6) < 0.003:
        raise SolverFailed(
            "",
            cause=f"restitution {e:.4f}, expected .6 within .003",
            advice="another YADE version? 2023.02a is known to work",
        )
    return f"one impact in {done.wall_s:.1f} s, restitution {e:.4f} of .6"


def _freefem_solves() -> str:
    integral, wall_s = _freefem(_POISSON, "integral")
    if not abs(integral - 1 / 12) < 1e-9:
        raise SolverFailed(
            "",
            cause=f"Poisson integral {integral!r}, expected 1/12",
            advice="another FreeFEM version? package 4.11 is known to work",
        )
    return f"Poisson in {wall_s:.1f} s, integral {integral:.10f} of 1/12"


def _plugin_loads(name: str) -> str:
    _freefem(f'load "{name}"\n' + _DONE)
    return "loads"


def _freefem(text: str, key: str | None = None) -> tuple[float, float]:
    with tempfile.TemporaryDirectory(prefix="peen-doctor-") as name:
        folder = Path(name)
        (folder / "job.edp").write_text(text)
        lines: list[str] = []
        done = freefem.run_freefem(
            folder / "job.edp",
            cwd=folder,
            log=folder / "log",
            status=folder / "status",
            timeout_s=60,
            on_line=lines.append,
        )
    return (_number(key, lines) if key else math.nan), done.wall_s


def _number(key: str, lines: list[str]) -> float:
    for line in lines:
        if line.startswith(key):
            return float(line.split()[1])
    raise SolverFailed(
        "", cause=f"it ended well without printing its {key}", advice="reinstall its package: make setup"
    )


def _draws() -> str:
    """In a process of its own, since pyvista aborts the interpreter where the GL libraries are missing."""
    code = (
        "import pyvista as pv; p = pv.Plotter(off_screen=True, window_size=(64, 64)); p.add_mesh(pv.Cube());"
        "assert p.screenshot(return_img=True).std() > 1, 'an empty picture'; print('pyvista', pv.__version__)"
    )
    with tempfile.TemporaryDirectory(prefix="peen-doctor-") as name:
        log, lines = Path(name) / "log", []
        try:
            done = process.run(
                [sys.executable, "-c", code],
                cwd=Path(name),
                log=log,
                env=os.environ,
                timeout_s=120,
                on_line=lines.append,
            )
        except process.TimedOut:
            raise SolverFailed("", cause="no picture after 120 s", advice="make setup") from None
    if done.exit_code != 0:
        raise SolverFailed("", cause=f"off-screen drawing failed: {lines[-1] if lines else done.exit_code}",
                           advice="make setup (packages libegl1 libgl1 libxrender1)")  # fmt: skip
    return f"off-screen in {done.wall_s:.1f} s, {lines[-1]}"
