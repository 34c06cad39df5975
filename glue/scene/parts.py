"""The parts of a scene that come from the catalogue or are given in full: shots, target material, window."""

from __future__ import annotations

from glue.scene import schema
from glue.scene.catalogue import (
    derived_combined,
    material,
    material_keys,
    not_in_catalogue,
    shot,
    shot_grades,
)
from glue.scene.fields import kind
from glue.scene.model import CombinedHardening, JohnsonCook, Material, Shots
from glue.scene.table import Table

GIVEN = "given in the scene"
_OWN_NUMBERS = ("diameter_m", "density_kg_m3", "E_Pa", "nu")


def read_shots(table: Table) -> Shots | None:
    """``[shots]``: a ``grade`` of the catalogue, or ``diameter_m`` and ``density_kg_m3``."""
    table.refuse_others(schema.SHOTS, not_built=schema.SHOTS_NOT_BUILT, elsewhere=schema.BELONGS_IN)
    size = table.get("size", schema.SHOTS["size"])
    if size == "mono" and "size_cv" in table:
        table.problem(
            "size_cv", 'has no effect with size = "mono"; allowed: size = "distribution", or no size_cv'
        )
    if "grade" in table:
        return _shots_of_grade(table, size)
    if not any(key in table for key in _OWN_NUMBERS):
        allowed = "allowed: a grade of the catalogue, or diameter_m and density_kg_m3"
        table.problem("grade", f"missing, and required; {allowed}")
        return None
    values = {key: table.get(key, schema.SHOTS[key]) for key in _OWN_NUMBERS}
    spread = table.get("size_cv", schema.SHOTS["size_cv"]) if size == "distribution" else 0.0
    if size is None or spread is None or None in values.values():
        return None
    return Shots(grade=None, size=size, size_cv=spread, medium="own", source=GIVEN, evidence="C", **values)


def _shots_of_grade(table: Table, size: str | None) -> Shots | None:
    clash = [key for key in _OWN_NUMBERS if key in table]
    for key in clash:
        table.problem(key, "is fixed by grade; allowed: grade alone, or your own numbers without grade")
    grade = table.get("grade", schema.SHOTS["grade"])
    if grade is not None and grade not in shot_grades():
        table.problem("grade", not_in_catalogue("shot grade", grade, shot_grades()))
        grade = None
    spread = None
    if size == "distribution" and "size_cv" in table:
        spread = table.get("size_cv", schema.SHOTS["size_cv"])
        if spread is None:
            return None
    if clash or grade is None or size is None:
        return None
    shots = shot(grade, size, spread)
    if size == "distribution":
        table.log.default(table.at("diameter_m"), shots.diameter_m, f"mean of the spread; {shots.source}")
        if spread is None:
            table.log.default(table.at("size_cv"), shots.size_cv, shots.source)
    return shots


def read_window(table: Table) -> tuple[float, float] | None:
    """``window_m``: the window's sides in x and y [m]."""
    side = schema.TARGET["window_side_m"]
    allowed = f"allowed: two numbers [x, y], each {side.allowed.removeprefix('allowed ')}"
    if "window_m" not in table:
        table.problem("window_m", f"missing, and required; {allowed}")
        return None
    value = table.data["window_m"]
    if not isinstance(value, list):
        table.problem("window_m", f"must be two numbers, not {kind(value)}; {allowed}")
        return None
    if len(value) != 2:
        table.problem("window_m", f"must be two numbers, not {len(value)}; {allowed}")
        return None
    problems = [(axis, side.problem(item)) for axis, item in zip("xy", value, strict=True)]
    for axis, problem in problems:
        if problem:
            table.problem("window_m", f"{axis}: {problem}")
    return None if any(problem for _, problem in problems) else (float(value[0]), float(value[1]))


def read_material(table: Table) -> Material | None:
    """``target.material``: a key of the catalogue, or a table with the material's own numbers."""
    value = table.data.get("material")
    if isinstance(value, str):
        if value in material_keys():
            return material(value)
        table.problem("material", not_in_catalogue("material", value, material_keys()))
        return None
    if isinstance(value, dict):
        return _own_material(Table(value, table.at("material"), table.log))
    wrong = "missing, and required" if value is None else f"must be a text or a table, not {kind(value)}"
    table.problem(
        "material", f"{wrong}; allowed: one of {', '.join(material_keys())}, or a table [target.material]"
    )
    return None


def _own_material(table: Table) -> Material | None:
    table.refuse_others((*schema.MATERIAL, "johnson_cook", "combined"))
    values = {key: table.get(key, field) for key, field in schema.MATERIAL.items()}
    curve = table.table("johnson_cook", ", ".join(schema.JOHNSON_COOK))
    johnson_cook = combined = None
    if curve:
        curve.refuse_others(schema.JOHNSON_COOK, not_built=schema.JOHNSON_COOK_NOT_BUILT)
        numbers = {key: curve.get(key, field) for key, field in schema.JOHNSON_COOK.items()}
        johnson_cook = None if None in numbers.values() else JohnsonCook(**numbers)
    if "combined" in table:
        combined, origin = _own_combined(table), GIVEN
    elif johnson_cook:
        from_curve = "derived from johnson_cook by the rule of glue/theory/hardening.py; grade C"
        combined, origin = derived_combined(johnson_cook), from_curve
        table.log.default(table.at("combined"), "bounded law", from_curve)
    if johnson_cook is None or combined is None or None in values.values():
        return None
    return Material(
        key="own", johnson_cook=johnson_cook, combined=combined, combined_source=origin, grade="C", **values
    )


def _own_combined(table: Table) -> CombinedHardening | None:
    law = table.optional_table("combined")
    if law is None:
        return None
    law.refuse_others((*schema.COMBINED, "backstresses"))
    values = {key: law.get(key, field) for key, field in schema.COMBINED.items()}
    terms = law.data.get("backstresses", [])
    allowed = "allowed: an array of up to 2 tables { X_Pa = …, gamma = … }"
    if not isinstance(terms, list) or len(terms) > 2 or not all(isinstance(term, dict) for term in terms):
        law.problem("backstresses", f"is no list of backstresses; {allowed}")
        return None
    pairs = []
    for number, term in enumerate(terms, start=1):
        entry = Table(term, f"{law.at('backstresses')}[{number}]", law.log)
        entry.refuse_others(schema.BACKSTRESS)
        pairs.append(tuple(entry.get(key, field) for key, field in schema.BACKSTRESS.items()))
    if None in values.values() or any(None in pair for pair in pairs):
        return None
    return CombinedHardening(**values, backstresses=tuple(pairs))
