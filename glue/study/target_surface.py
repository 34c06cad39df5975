"""The triangulated surface of a target: from its STL file beside the scene to triangles in metres."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np

from glue.errors import InputError
from glue.flow import surface
from glue.scene.model import Scene
from glue.scene.measured import beside


def companions(scene: Scene, scene_file: Path) -> dict[str, bytes]:
    """{bare name: content} of the files that ``scene`` names, for a copy of the scene to be complete."""
    path = _file(scene, scene_file)
    return {} if path is None else {path.name: path.read_bytes()}


def target_triangles(scene: Scene, scene_file: Path) -> np.ndarray | None:
    """Triangles (m, 3, 3) [m] of the target's surface; None for a plane or cylinder.

    Raises InputError for a file that is gone, was changed since the scene was read, or cannot be used: with all
    that is wrong with its triangles.
    """
    path = _file(scene, scene_file)
    if path is None:
        return None
    if hashlib.sha256(path.read_bytes()).hexdigest() != scene.target.surface.sha256:
        raise InputError(f"{path}: was changed after the scene was read; run again")
    from glue.meshes import read_surface  # here: loads meshio

    triangles = read_surface(path)
    problems = surface.check_triangles(triangles) or surface.placement_problems(triangles, scene.target.window_m)
    if problems:
        raise InputError([f"{path}: {sentence}" for sentence in problems])
    return triangles


def _file(scene: Scene, scene_file: Path) -> Path | None:
    written = scene.target.surface.file
    if scene.target.surface.kind != "stl":
        return None
    found = beside(scene_file, written)
    if found is None:
        raise InputError(f"target.surface.file: no file {written} beside {scene_file}")
    return found
