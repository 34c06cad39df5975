"""The target of a scene: material from the catalogue or in full, window, thickness, shape of the surface."""

from __future__ import annotations

import hashlib
from pathlib import Path

from glue.scene import schema
from glue.scene.catalogue import material, material_keys, not_in_catalogue
from glue.scene.fields import kind, quoted
from glue.scene.measured import beside, read_initial_roughness, read_initial_stress
from glue.scene.model import Material, Surface, Target
from glue.scene.own_material import read_own_material
from glue.scene.table import Table


def read_target(top: Table, scene_file: Path) -> Target | None:
    """``[target]``; None when any of it is refused. No thickness is a part too thick to stretch or bend."""
    table = top.table("target", "material and window_m")
    if table is None:
        return None
    table.refuse_others(
        ("material", *schema.TARGET, "surface", "initial_stress", "initial_roughness"), elsewhere=schema.BELONGS_IN
    )
    stress, roughness = read_initial_stress(table), read_initial_roughness(table)
    thickness = 0.0
    if "thickness_m" in table:
        thickness = table.get("thickness_m", schema.TARGET["thickness_m"])
    else:
        table.log.default(table.at("thickness_m"), "none", "a part too thick to stretch or bend; choice of this project")
    material, window = _read_material(table), table.get("window_m", schema.TARGET["window_m"])
    surface = _read_surface(table, scene_file)
    if None in (material, window, surface, thickness):
        return None
    return Target(material, window, thickness or None, surface, stress, roughness)


def _read_surface(table: Table, scene_file: Path) -> Surface | None:
    if "surface" not in table:
        table.log.default(table.at("surface"), "plane", "a flat target; choice of this project")
        return Surface()
    part = table.optional_table("surface")
    if part is None:
        return None
    part.refuse_others(schema.SURFACE)
    kind_of = part.get("kind", schema.SURFACE["kind"])
    if kind_of is None:
        return None
    wanted = schema.SURFACE_KEYS[kind_of]
    for key in schema.SURFACE:
        if key in part and key != "kind" and key not in wanted:
            homes = [word for word, keys in schema.SURFACE_KEYS.items() if key in keys]
            part.problem(key, f'has no effect with kind = "{kind_of}"; allowed: kind = "{homes[0]}", or no {key}')
    values = {key: part.get(key, schema.SURFACE[key]) for key in wanted}
    if None in values.values():
        return None
    if kind_of == "stl":
        values["sha256"] = _sha256(part, scene_file, values["file"])
        if not values["sha256"]:
            return None
    return Surface(kind=kind_of, **values)


def _sha256(part: Table, scene_file: Path, written: str) -> str:
    """Hash of the STL file's content, "" when it cannot be read (which is logged)."""
    allowed = "allowed: an STL file that can be read, its name from the scene file's folder"
    try:
        found = beside(scene_file, written)
        if found is None:
            part.problem("file", f"no file {quoted(written)} in {scene_file.parent or '.'}; {allowed}")
            return ""
        return hashlib.sha256(found.read_bytes()).hexdigest()
    except (OSError, ValueError) as error:  # ValueError: a name that no file system takes
        reason = getattr(error, "strerror", None) or error
        part.problem("file", f"{quoted(written)} cannot be read: {reason}; {allowed}")
        return ""


def _read_material(table: Table) -> Material | None:
    """``target.material``: a key of the catalogue, or a table with the material's own numbers."""
    value = table.data.get("material")
    if isinstance(value, str):
        if value in material_keys():
            return material(value)
        table.problem("material", not_in_catalogue("material", value, material_keys()))
        return None
    if isinstance(value, dict):
        return read_own_material(Table(value, table.at("material"), table.log))
    wrong = "missing, and required" if value is None else f"must be a text or a table, not {kind(value)}"
    table.problem(
        "material", f"{wrong}; allowed: one of {', '.join(material_keys())}, or a table [target.material]"
    )
    return None
