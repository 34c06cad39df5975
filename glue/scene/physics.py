"""Rebound, friction and the optional physics of a flight: gravity and air drag."""

from __future__ import annotations

import math

from glue.scene import schema
from glue.scene.fields import kind, show
from glue.scene.model import AirDrag, Friction, Gravity, Restitution, SpotHardening
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
    return None if None in values.values() else Friction(**values)


def read_gravity(top: Table) -> Gravity | None:
    """``[gravity]``, or ``gravity = "auto"``; None without it: an absent block is not modelled."""
    table, auto = _optional_physics(top, "gravity", "straight flights")
    if table is None:
        return None
    table.refuse_others(schema.GRAVITY, elsewhere=schema.BELONGS_IN)
    values = table.get_all(schema.GRAVITY)
    if None in values.values():
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
    table, auto = _optional_physics(top, "air_drag", "flights in vacuum")
    if table is None:
        return None
    table.refuse_others(schema.AIR_DRAG, elsewhere=schema.BELONGS_IN)
    values = table.get_all(schema.AIR_DRAG)
    return None if None in values.values() else AirDrag(**values, auto=auto)


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
