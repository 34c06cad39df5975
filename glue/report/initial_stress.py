"""The peened layer's stress for other codes: by depth as CSV, and as initial stress of a mesh's elements.

What goes into another part is the stress *before* the part gives way: peened, but held flat and unstretched.  The
other code lets its own part go, which stretches and bends as its shape allows.  The stress of the free plate that the
run modelled is right for that plate alone; the CSV has both.  What a scene's own initial stress adds is left out of
the held stress: it was in balance with the modelled part, not with another.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from glue.atomic import atomic_path
from glue.errors import InputError
from glue.inp_mesh import NODES, read_inp
from glue.scene.model import Scene
from glue.study.results import write_columns
from glue.theory.plate import clamped_stress

CODES = ("calculix", "abaqus")
UNITS = {"m": (1.0, 1.0, "Pa"), "mm": (1e-3, 1e-6, "MPa")}  # length of the mesh [m], Pa to its stress, name
SURFACES = tuple(f"{axis}-{end}" for axis in "zxy" for end in ("max", "min"))
_RESIDUE = 1e-6  # share of the largest stress that is rounding of the profile's balances, or below anyone's notice
_FADED = 8  # last rows of a plate's profile, below what peening reached
_MESHIO = {"tetra": "C3D4", "tetra10": "C3D10", "hexahedron": "C3D8", "hexahedron20": "C3D20"}
_G = 1.0 / np.sqrt(3.0)
_CORNERS = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], dtype=float)  # x runs first
_TET = 0.1381966011250105


def held_profile(profile: Mapping[str, np.ndarray], scene: Scene) -> dict[str, np.ndarray]:
    """depth_m, sigma_xx_Pa, sigma_yy_Pa, each (n,), of the part held flat and unstretched; 0 where it is but rounding.

    ``profile``: the columns of stress_profile.csv.
    Raises InputError where they cannot be told: a plate that ends inside the peened layer.
    """
    depth, initial = profile["depth_m"], np.zeros(len(profile["depth_m"]))
    if len(scene.target.initial_stress):
        at, stress = np.array(scene.target.initial_stress, dtype=float).T
        initial = np.interp(depth, at, stress, right=0.0)
    held = {"depth_m": depth}
    for name in ("sigma_xx_Pa", "sigma_yy_Pa"):
        changed = profile[name] - initial
        try:
            held[name] = changed if scene.target.thickness_m is None else clamped_stress(depth, changed, _FADED)
        except ValueError as problem:
            raise InputError(
                f"target.thickness_m = {scene.target.thickness_m:g}: the stress of the held part cannot be told from"
                f" the free one's ({problem}); allowed: parts thicker than the peened layer, or no thickness_m"
            ) from None
    largest = max(float(np.abs(held[name]).max()) for name in ("sigma_xx_Pa", "sigma_yy_Pa"))
    for name in ("sigma_xx_Pa", "sigma_yy_Pa"):
        held[name] = np.where(np.abs(held[name]) < _RESIDUE * largest, 0.0, held[name])
    return held


def write_stress_csv(path: Path, profile: Mapping[str, np.ndarray], scene: Scene) -> None:
    """depth_m; sigma_xx_Pa, sigma_yy_Pa of the part as modelled; the same held; peeq."""
    held = held_profile(profile, scene)
    write_columns(
        path, depth_m=profile["depth_m"], sigma_xx_Pa=profile["sigma_xx_Pa"], sigma_yy_Pa=profile["sigma_yy_Pa"],
        sigma_xx_held_Pa=held["sigma_xx_Pa"], sigma_yy_held_Pa=held["sigma_yy_Pa"], peeq=profile["peeq"],
    )  # fmt: skip


def write_initial_stress(
    path: Path, mesh: Path, held: Mapping[str, np.ndarray], *, surface: str = "z-max", unit: str = "m",
    code: str = "calculix", title: str = "",
) -> dict:  # fmt: skip
    """Write ``*INITIAL CONDITIONS, TYPE=STRESS`` for every solid element of ``mesh``.

    mesh: .inp with its own numbers, or what meshio reads, numbered from 1.  held: as from ``held_profile``.  surface:
    the peened plane, such as "z-max", the largest z of the mesh; its depth runs inwards, the profile's x and y lie
    along the two other axes in order.  unit: of the mesh, "m" (stress in Pa) or "mm" (MPa).  code: "calculix" (a line
    for each integration point, at its own depth) or "abaqus" (a line for each element, the mean of its points).  Below
    the profile the stress is 0; normal and shear stresses of the plane are 0.

    Returns {"elements", "elements_stressed", "points"}.  Raises InputError for all that is wrong, and when no point of
    the mesh lies in the layer.
    """
    wrong = [
        f"--{name} {value}: allowed: {', '.join(allowed)}"
        for name, value, allowed in (("surface", surface, SURFACES), ("unit", unit, UNITS), ("code", code, CODES))
        if value not in allowed
    ]
    if wrong:
        raise InputError(wrong)
    length, to_stress, stress_unit = UNITS[unit]
    blocks = read_inp(mesh) if mesh.suffix.lower() == ".inp" else _from_meshio(mesh)
    normal, sign = "xyz".index(surface[0]), 1.0 if surface.endswith("max") else -1.0
    first, second = (axis for axis in range(3) if axis != normal)
    top = max(float((sign * corners[:, :, normal]).max()) for _, corners in blocks.values())
    rows, told = [], {"elements": 0, "elements_stressed": 0, "points": 0}
    for kind, (numbers, corners) in blocks.items():
        at = np.einsum("pk,mk->mp", _weights(kind), corners[:, :, normal])
        depth = length * (top - sign * at)
        stress = np.zeros((*depth.shape, 6))
        for axis, name in ((first, "sigma_xx_Pa"), (second, "sigma_yy_Pa")):
            stress[:, :, axis] = to_stress * np.interp(depth, held["depth_m"], held[name], right=0.0)
        told["elements"] += len(numbers)
        told["elements_stressed"] += int((np.abs(stress).max(axis=(1, 2)) > 0.0).sum())
        told["points"] += depth.size
        rows += _lines(numbers, stress, code)
    if not told["elements_stressed"]:
        depth, stressed = held["depth_m"], np.flatnonzero((held["sigma_xx_Pa"] != 0.0) | (held["sigma_yy_Pa"] != 0.0))
        layer = depth[min(stressed[-1] + 1, len(depth) - 1)] if stressed.size else 0.0
        raise InputError(
            f"{mesh}: no element lies within {layer:.3g} m of its {surface} surface, where the stress is;"
            " is it in mm (--unit mm), or is another surface the peened one (--surface)?"
        )
    with atomic_path(path) as part:
        part.write_text("\n".join([*_heading(title, surface, stress_unit, code, told), *rows]) + "\n", encoding="utf-8")
    return told


def _heading(title: str, surface: str, stress_unit: str, code: str, told: dict) -> list[str]:
    ascii_title, stressed = title.encode("ascii", "replace").decode(), told["elements_stressed"]
    return [
        f"** initial stress of {ascii_title} in {stress_unit}: peened at {surface}, held flat and unstretched.",
        f"** {told['elements']} elements, {stressed} of them with stress. Put it before the first step:",
        "** *INCLUDE, INPUT=initial_stress.inp; a static step without load then lets the part go.",
        f"** {code}: element, {'integration point, ' if code == 'calculix' else ''}Sxx, Syy, Szz, Sxy, Sxz, Syz",
        "*INITIAL CONDITIONS, TYPE=STRESS",
    ]


def _lines(numbers, stress, code: str) -> list[str]:
    def six(row) -> str:
        return ", ".join(f"{v:.9g}" for v in row)

    if code == "abaqus":
        return [f"{n}, {six(row)}" for n, row in zip(numbers, stress.mean(axis=1), strict=True)]
    elements = zip(numbers, stress, strict=True)
    return [f"{n}, {p}, {six(row)}" for n, points in elements for p, row in enumerate(points, 1)]


def _from_meshio(mesh: Path) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    from glue.meshes import read_solids  # here: loads meshio

    found: dict[str, list] = {}
    for kind, numbers, nodes in read_solids(mesh):
        if kind in _MESHIO:
            own = _MESHIO[kind]
            found.setdefault(own, []).append((numbers, nodes[:, : NODES[own][1]]))
    if not found:
        raise InputError(f"{mesh}: holds no solid element; allowed: {', '.join(_MESHIO)}")
    return {kind: tuple(np.concatenate(column) for column in zip(*parts, strict=True)) for kind, parts in found.items()}


def _weights(kind: str) -> np.ndarray:
    """(points, corners): each integration point as the corners' weighted mean, in CalculiX's order of points.

    Corners alone: exact where edges are straight, whatever nodes lie between them.
    """
    if kind == "C3D4":
        return np.full((1, 4), 0.25)
    if kind == "C3D10":
        near = np.full((4, 4), _TET)
        near[range(4), range(4)] = 1.0 - 3.0 * _TET
        return near
    if kind == "C3D8R":
        local = np.zeros((1, 3))
    elif kind == "C3D20":
        g = np.sqrt(0.6) * np.array([-1.0, 0.0, 1.0])
        local = np.array([[x, y, z] for z in g for y in g for x in g])
    else:
        local = _G * _CORNERS
    corner = _CORNERS[[0, 1, 3, 2, 4, 5, 7, 6]]  # the element's own order runs around each face
    return np.prod(1.0 + local[:, None, :] * corner[None, :, :], axis=2) / 8.0
