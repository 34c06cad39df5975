"""A target material given in the scene: elastic constants, one monotonic curve, the bounded law or none."""

from __future__ import annotations

from itertools import pairwise

from glue.scene import schema
from glue.scene.catalogue import derived_combined
from glue.scene.fields import kind, show
from glue.scene.laws import CombinedHardening, HardeningTable, JohnsonCook, Material
from glue.scene.table import Table

GIVEN = "given in the scene"


def read_own_material(table: Table) -> Material | None:
    """``[target.material]``; None when any of it is refused."""
    table.refuse_others((*schema.MATERIAL, *schema.CURVES, "combined"))
    values = {key: table.get(key, field) for key, field in schema.MATERIAL.items()}
    name, curve = _read_curve(table)
    combined = None
    if "combined" in table:
        combined, origin = _read_combined(table), GIVEN
    elif curve:
        combined, origin = derived_combined(curve), f"derived from {name} by the rule of glue/theory/hardening.py; grade C"
        table.log.default(table.at("combined"), "bounded law", origin)
    if curve is None or combined is None or None in values.values():
        return None
    laws = {key: curve if key == name else None for key in schema.CURVES}
    return Material(key="own", combined=combined, combined_source=origin, grade="C", **laws, **values)


def _read_curve(table: Table) -> tuple[str, JohnsonCook | CombinedHardening | HardeningTable | None]:
    """Name and law of the one monotonic curve; its law is None when it is refused."""
    given = [key for key in schema.CURVES if key in table]
    if len(given) > 1:
        for key in given[1:]:
            table.problem(key, f"stands beside {given[0]}; allowed: one monotonic curve, of {', '.join(schema.CURVES)}")
        return given[0], None
    if given == ["table"]:
        return "table", _read_table(table)
    if given == ["voce"]:
        return "voce", _read_voce(table)
    return "johnson_cook", _read_johnson_cook(table)


def _read_johnson_cook(table: Table) -> JohnsonCook | None:
    keys = (*schema.JOHNSON_COOK, *schema.JOHNSON_COOK_OPTIONAL)
    curve = table.table("johnson_cook", f"{', '.join(keys)}; or voce, or table")
    if curve is None:
        return None
    curve.refuse_others(keys)
    values = curve.get_all(schema.JOHNSON_COOK)
    values |= {key: curve.get(key, field) for key, field in schema.JOHNSON_COOK_OPTIONAL.items() if key in curve}
    if None in values.values():
        return None
    if values.get("saturation_Pa", 1e300) <= values["A_Pa"]:
        curve.problem("saturation_Pa", f"{show(values['saturation_Pa'])} is no more than A_Pa, so that nothing hardens; "
                      f"allowed above {show(values['A_Pa'])}, or B_Pa = 0 without a saturation")  # fmt: skip
        return None
    if values.get("melting_K", 1e300) <= values["reference_K"]:
        curve.problem("melting_K", f"{show(values['melting_K'])} is no more than reference_K; "
                      f"allowed above {show(values['reference_K'])} K")  # fmt: skip
        return None
    return JohnsonCook(**values)


def _read_voce(table: Table) -> CombinedHardening | None:
    law = table.optional_table("voce")
    if law is None:
        return None
    law.refuse_others(schema.COMBINED)
    values = law.get_all(schema.COMBINED)
    return None if None in values.values() else CombinedHardening(**values, backstresses=())


def _read_table(table: Table) -> HardeningTable | None:
    rows = table.data["table"]
    allowed = f"allowed: 2 to {schema.MAX_TABLE} rows [plastic strain, stress in Pa], the first at strain 0"
    if not isinstance(rows, list) or not all(isinstance(row, list) and len(row) == 2 for row in rows):
        table.problem("table", f"is no list of pairs, {kind(rows)}; {allowed}")
        return None
    if not 2 <= len(rows) <= schema.MAX_TABLE:
        table.problem("table", f"has {len(rows)} rows; {allowed}")
        return None
    for number, row in enumerate(rows, start=1):
        for value, field in zip(row, (schema.TABLE_STRAIN, schema.TABLE_STRESS)):
            problem = field.problem(value)
            if problem:
                table.problem(f"table[{number}]", problem)
                return None
    strain, stress = (tuple(float(row[k]) for row in rows) for k in (0, 1))
    if strain[0] != 0.0:
        table.problem("table[1]", f"begins at strain {show(strain[0])}; {allowed}")
        return None
    for number, (low, high) in enumerate(pairwise(strain), start=2):
        if high <= low:
            table.problem(f"table[{number}]", f"strain {show(high)} does not rise; allowed above {show(low)}")
            return None
    for number, (low, high) in enumerate(pairwise(stress), start=2):
        if high < low:
            table.problem(f"table[{number}]", f"{show(high)} Pa softens: the answer would hang on the mesh; "
                          f"allowed {show(low)} Pa or more")  # fmt: skip
            return None
    return HardeningTable(strain, stress)


def _read_combined(table: Table) -> CombinedHardening | None:
    law = table.optional_table("combined")
    if law is None:
        return None
    law.refuse_others((*schema.COMBINED, "backstresses"))
    values = law.get_all(schema.COMBINED)
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
