"""The media of a scene: grades of the catalogue or own numbers, their sizes, their shares of the mass."""

from __future__ import annotations

import dataclasses
import math
from itertools import pairwise

from glue.scene import schema, sizes
from glue.scene.catalogue import not_in_catalogue, shot, shot_grades, sieve_grades
from glue.scene.fields import kind, show
from glue.scene.model import Shots
from glue.scene.table import Table

_OWN_NUMBERS = ("diameter_m", "density_kg_m3", "E_Pa", "nu")
_SIEVE_ALLOWED = (
    'allowed: an array of 2 to 20 tables { opening_m = …, finer = … }, openings rising, "finer" (the share of the '
    "mass that passes) rising from 0 to 1"
)


def read_media(top: Table) -> tuple[Shots, ...] | None:
    """``[shots]``, or several ``[[shots]]`` with a ``mass_fraction`` each; None when any of them is refused."""
    tables = top.several("shots", "grade, or diameter_m and density_kg_m3", schema.MAX_MEDIA)
    if tables is None:
        return None
    media = [_read_shots(table) for table in tables]
    shares = [_mass_fraction(table, alone=len(tables) == 1) for table in tables]
    if None in shares:
        return None
    total = math.fsum(shares)
    if abs(total - 1.0) > 1e-6:
        top.problem(
            "shots.mass_fraction" if len(tables) == 1 else "shots",
            f"the mass fractions ({' + '.join(show(share) for share in shares)}) sum to {total:.9g}; "
            "allowed: a sum of 1 within 1e-6",
        )
        return None
    if None in media:
        return None
    return tuple(
        dataclasses.replace(shots, mass_fraction=share) for shots, share in zip(media, shares, strict=True)
    )


def _mass_fraction(table: Table, *, alone: bool) -> float | None:
    if alone and "mass_fraction" not in table:
        return 1.0
    return table.get("mass_fraction", schema.SHOTS["mass_fraction"])


def _read_shots(table: Table) -> Shots | None:
    """One medium: a ``grade`` of the catalogue, or its own numbers."""
    table.refuse_others((*schema.SHOTS, "sieve"), elsewhere=schema.BELONGS_IN)
    size = table.get("size", schema.SHOTS["size"])
    for key, word in (("size_cv", "distribution"), ("sieve", "sieve")):
        if size not in (None, word) and key in table:
            table.problem(key, f'has no effect with size = "{size}"; allowed: size = "{word}", or no {key}')
    if "grade" in table:
        return _shots_of_grade(table, size)
    if not any(key in table for key in (*_OWN_NUMBERS, "sieve")):
        allowed = "allowed: a grade of the catalogue, or diameter_m and density_kg_m3"
        table.problem("grade", f"missing, and required; {allowed}")
        return None
    return _own_sieve(table) if size == "sieve" else _own_shots(table, size)


def _own_shots(table: Table, size: str | None) -> Shots | None:
    values = {key: table.get(key, schema.SHOTS[key]) for key in _OWN_NUMBERS}
    spread = table.get("size_cv", schema.SHOTS["size_cv"]) if size == "distribution" else 0.0
    if size is None or spread is None or None in values.values():
        return None
    return _own(size=size, size_cv=spread, **values)


def _own_sieve(table: Table) -> Shots | None:
    if "diameter_m" in table:
        table.problem(
            "diameter_m", "follows from the sieve analysis; allowed: no diameter_m, or another size"
        )
    values = {key: table.get(key, schema.SHOTS[key]) for key in _OWN_NUMBERS if key != "diameter_m"}
    sieve = _read_sieve(table)
    if sieve is None or "diameter_m" in table or None in values.values():
        return None
    shots = _own(size="sieve", size_cv=0.0, diameter_m=0.0, sieve=sieve, **values)
    return dataclasses.replace(shots, diameter_m=sizes.mean_m(shots))


def _own(**values) -> Shots:
    return Shots(grade=None, medium="own", source="given in the scene", evidence="C", **values)


def _read_sieve(table: Table) -> tuple[tuple[float, float], ...] | None:
    """(opening [m], mass share finer) of ``sieve = [{ opening_m = …, finer = … }, …]``, from fine to coarse."""
    rows = table.data.get("sieve")
    if rows is None:
        table.problem("sieve", f"missing, and required; {_SIEVE_ALLOWED}")
        return None
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        wrong = "an array of something else" if isinstance(rows, list) else kind(rows)
        table.problem("sieve", f"must be an array of tables, not {wrong}; {_SIEVE_ALLOWED}")
        return None
    if not 2 <= len(rows) <= schema.MAX_SIEVES:
        table.problem(
            "sieve", f"must have 2 to {schema.MAX_SIEVES} sieves, not {len(rows)}; {_SIEVE_ALLOWED}"
        )
        return None
    pairs = []
    for number, row in enumerate(rows, start=1):
        entry = Table(row, f"{table.at('sieve')}[{number}]", table.log)
        entry.refuse_others(schema.SIEVE)
        pairs.append(tuple(entry.get_all(schema.SIEVE).values()))
    if any(None in pair for pair in pairs):
        return None
    problems = list(_sieve_problems(pairs))
    for where, sentence in problems:
        table.problem(f"sieve{where}", f"{sentence}; {_SIEVE_ALLOWED}")
    return None if problems else tuple(pairs)


def _sieve_problems(pairs: list[tuple[float, float]]):
    """(index in brackets, sentence) for every two neighbours out of order, and for ends that are not 0 and 1."""
    for number, ((a, finer), (b, up_to)) in enumerate(pairwise(pairs), start=2):
        if b <= a:
            yield f"[{number}].opening_m", f"{show(b)} m does not rise above the {show(a)} m before it"
        if up_to < finer:
            yield (
                f"[{number}].finer",
                f"{show(up_to)} after {show(finer)} puts a negative mass ({show(up_to - finer)}) between these sieves",
            )
    if pairs[0][1] != 0.0:
        yield "[1].finer", f"{show(pairs[0][1])} leaves shots finer than the finest sieve without a size"
    if pairs[-1][1] != 1.0:
        yield (
            f"[{len(pairs)}].finer",
            f"{show(pairs[-1][1])} leaves shots coarser than the coarsest sieve without a size",
        )


def _shots_of_grade(table: Table, size: str | None) -> Shots | None:
    clash = [
        key for key in (*_OWN_NUMBERS, "sieve") if key in table and not (key == "sieve" and size != "sieve")
    ]
    for key in clash:
        table.problem(key, "is fixed by grade; allowed: grade alone, or your own numbers without grade")
    grade = table.get("grade", schema.SHOTS["grade"])
    if grade is not None and grade not in shot_grades():
        table.problem("grade", not_in_catalogue("shot grade", grade, shot_grades()))
        grade = None
    if size == "sieve" and grade is not None and grade not in sieve_grades():
        table.problem(
            "size",
            f'"sieve" needs the screening limits of a cast steel grade, and {grade} has none; allowed "mono", '
            f'"distribution", or one of {", ".join(sieve_grades())}',
        )
        return None
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
    if size == "sieve":
        bands = ", ".join(f"{show(opening)} m: {show(finer)}" for opening, finer in shots.sieve)
        table.log.default(table.at("sieve"), f"finer than {bands}", shots.source)
    return shots
