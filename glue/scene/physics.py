"""Rebound, friction and the optional physics of a flight (gravity, air drag) and of an impact (rate, inertia, shot)."""

from __future__ import annotations

import math

from glue.scene import schema
from glue.scene.effects import AirDrag, Gravity, StrainRate, Switch
from glue.scene.fields import kind, show
from glue.scene.model import Friction, JohnsonCook, Material, Restitution, SpotHardening
from glue.scene.table import Table


def read_restitution(top: Table) -> Restitution | None:
    """``[restitution]`` with its optional ``[restitution.hardening]``; None when any of it is refused."""
    table = top.optional_table("restitution")
    if table is None:
        return None
    table.refuse_others((*schema.RESTITUTION, "hardening"), elsewhere=schema.BELONGS_IN)
    values = table.get_all(schema.RESTITUTION)
    hardening = None
    if "hardening" in table:
        hardening = _read_hardening(table, values["shot_target"])
        if hardening is None:
            return None
    return None if None in values.values() else Restitution(**values, hardening=hardening)


def _read_hardening(table: Table, shot_target: float | str | None) -> SpotHardening | None:
    part = table.optional_table("hardening")
    if part is None:
        return None
    part.refuse_others(schema.SPOT_HARDENING)
    values = part.get_all(schema.SPOT_HARDENING)
    if None in values.values():
        return None
    if isinstance(shot_target, float) and values["saturated"] <= shot_target:
        part.problem(
            "saturated",
            f"{show(values['saturated'])} is no more than restitution.shot_target, {show(shot_target)}: a spot that was "
            f"struck before is harder and rebounds more; allowed above {show(shot_target)}, up to 0.94, or exactly 1",
        )
        return None
    return SpotHardening(**values)


def read_friction(top: Table) -> Friction | None:
    table = top.optional_table("friction")
    if table is None:
        return None
    table.refuse_others(schema.FRICTION, elsewhere=schema.BELONGS_IN)
    values = table.get_all(schema.FRICTION)
    if None in values.values():
        return None
    if values["in_dimple"] and values["shot_target"] == 0.0:
        table.problem("in_dimple", "has no effect with shot_target = 0; allowed: shot_target above 0, or in_dimple = false")
        return None
    return Friction(**values)


def read_gravity(top: Table) -> Gravity | None:
    """``[gravity]``, or ``gravity = "auto"``; None without it: an absent block is not modelled."""
    table, values, auto = _block(top, "gravity", "straight flights", schema.GRAVITY)
    if values is None:
        return None
    length = math.hypot(*values["direction"])
    if length == 0.0:
        table.problem(
            "direction", "[0, 0, 0] points nowhere; allowed: any vector but that, it is scaled to length 1"
        )
        return None
    direction = tuple(component / length for component in values["direction"])
    return Gravity(values["acceleration_m_s2"], direction, auto)


def read_air_drag(top: Table) -> AirDrag | None:
    """``[air_drag]``, or ``air_drag = "auto"``; None without it: an absent block is not modelled."""
    _, values, auto = _block(top, "air_drag", "flights in vacuum", schema.AIR_DRAG)
    return None if values is None else AirDrag(**values, auto=auto)


def read_strain_rate(top: Table, material: Material | None) -> StrainRate | None:
    """``[strain_rate]``, or "auto"; a block is refused where ``material`` has no number that it could act by."""
    table, values, auto = _block(top, "strain_rate", "laws that know no rate and no heat", schema.STRAIN_RATE)
    if material is None or values is None:
        return None
    thermal, law = values["thermal"], material.single_law
    if auto:
        return StrainRate(thermal, auto)
    if not isinstance(law, JohnsonCook) or law.C == 0.0:
        why = "C is 0" if isinstance(law, JohnsonCook) else "it has no johnson_cook curve"
        top.problem("strain_rate", f'has no effect: {material.name} knows no rate ({why}); allowed: no strain_rate block, '
                    "or a material with johnson_cook.C above 0")  # fmt: skip
        return None
    missing = [key for key in ("m", "melting_K", "specific_heat_J_kg_K") if not getattr(law, key)]
    if thermal and missing:
        table.problem("thermal", f"{material.name} has no {' and no '.join(missing)}; allowed: false, or a material "
                      "whose johnson_cook has m, melting_K and specific_heat_J_kg_K")  # fmt: skip
        return None
    return StrainRate(thermal)


def read_target_inertia(top: Table) -> Switch | None:
    """``[target_inertia]``, or "auto": a target that carries waves away."""
    return _read_switch(top, "target_inertia", "a quasi-static target")


def read_elastic_shot(top: Table) -> Switch | None:
    """``[elastic_shot]``, or "auto": a shot that gives way, by its own modulus."""
    return _read_switch(top, "elastic_shot", "rigid shots in the dimple model")


def _read_switch(top: Table, key: str, without: str) -> Switch | None:
    table, auto = _optional_physics(top, key, without)
    if table is None:
        return None
    for other in table.data:
        table.problem(other, f"unknown key; [{key}] is an empty block; allowed: no keys")
    return Switch(auto)


def _block(top: Table, key: str, without: str, fields: dict) -> tuple[Table | None, dict | None, bool]:
    """(table, values, auto) as from ``_optional_physics``; values None when the block is absent or any is refused."""
    table, auto = _optional_physics(top, key, without)
    if table is None:
        return None, None, auto
    table.refuse_others(fields, elsewhere=schema.BELONGS_IN)
    values = table.get_all(fields)
    return table, (None if None in values.values() else values), auto


def _optional_physics(top: Table, key: str, without: str) -> tuple[Table | None, bool]:
    """(the block's table, empty for "auto" and None when absent or refused; whether it says "auto")."""
    value = top.data.get(key)
    if value is None:
        top.log.default(key, "none", f"{without}: an absent block is not modelled")
        return None, False
    if value == "auto":
        return Table({}, key, top.log), True
    if not isinstance(value, dict):
        top.problem(key, f'must be a table [{key}] or "auto", not {kind(value)}')
        return None, False
    return Table(value, key, top.log), False
