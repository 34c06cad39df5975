"""The catalogue: materials and shots by name, read from ``materials.toml`` and ``shots.toml``.

Every group of numbers in those files carries its source and evidence grade, and both travel with the
numbers into the scene, so that a report can say how far to trust them.  Standard library only.
"""

from __future__ import annotations

import dataclasses
import difflib
import functools
import tomllib
from collections.abc import Iterable
from pathlib import Path

from glue.errors import InputError
from glue.scene import sizes
from glue.scene.laws import CombinedHardening, HardeningTable, JohnsonCook, Material
from glue.scene.model import Shots
from glue.theory.hardening import bounded_law

HERE = Path(__file__).resolve().parent
GRADES = "DABC"  # from the most to the least trustworthy
DERIVED_LAW = "derived from the monotonic curve by the rule of glue/theory/hardening.py; grade C"


def closest(word: str, known: Iterable[str]) -> str | None:
    """The known word that ``word`` most resembles, upper and lower case alike, or None when none does.

    A key without its unit (``speed`` for ``speed_m_s``) resembles it most.
    """
    by_lower = {k.lower(): k for k in known}
    for lower, name in by_lower.items():
        if word and lower.startswith(f"{word.lower()}_"):
            return name
    found = difflib.get_close_matches(word.lower(), by_lower, n=1, cutoff=0.6)
    return by_lower[found[0]] if found else None


def not_in_catalogue(what: str, word: str, known: Iterable[str]) -> str:
    """Sentence for a name that the catalogue does not have: the nearest name, then all of them."""
    known = list(known)
    guess = closest(word, known)
    hint = f'did you mean "{guess}"? ' if guess else ""
    return f'no {what} "{word}" in the catalogue; {hint}allowed: {", ".join(known)}'


def worst_grade(grades: Iterable[str]) -> str:
    """The least trustworthy of several evidence grades."""
    return max(grades, key=GRADES.index)


@functools.cache
def material_tables() -> dict[str, dict]:
    """The raw tables of ``materials.toml`` by material key."""
    return tomllib.loads((HERE / "materials.toml").read_text(encoding="utf-8"))


@functools.cache
def shot_tables() -> dict[str, dict]:
    """The raw tables of ``shots.toml`` by medium."""
    return tomllib.loads((HERE / "shots.toml").read_text(encoding="utf-8"))


def material_keys() -> list[str]:
    return list(material_tables())


def shot_grades() -> list[str]:
    """Every grade of every medium, in the order of the file."""
    return [grade for medium in shot_tables().values() for grade in medium["sizes"]["diameter_m"]]


def sieve_grades() -> list[str]:
    """Every grade whose screening limits are in the file."""
    return [grade for medium in shot_tables().values() for grade in medium.get("screens", {}).get("limits", {})]


def sieve_of(limits: dict) -> tuple[tuple[float, float], ...]:
    """(opening [m], mass share finer) from fine to coarse: one size distribution for what a standard allows.

    ``limits`` holds what must pass whole (``all_pass_m``), what at most and at least may stay on sieves
    (``at_most``, ``at_least``: [opening, share]), and the next finer sieve (``pan_m``).  Each allowance is taken at its
    middle: half of what "at most" allows stays there, and half of what "at least" leaves passes; what passes the
    finest sieve is taken to stay on the next.
    """
    middles = [(opening, 1.0 - 0.5 * share) for opening, share in limits.get("at_most", [])]
    middles += [(opening, 0.5 * (1.0 - share)) for opening, share in limits["at_least"]]
    return tuple(sorted([(limits["pan_m"], 0.0), *middles, (limits["all_pass_m"], 1.0)]))


@functools.cache
def material(key: str) -> Material:
    """Material ``key`` of the catalogue; :class:`InputError` with the nearest name when there is none."""
    if key not in material_tables():
        raise InputError(not_in_catalogue("material", key, material_keys()))
    table = material_tables()[key]
    elastic, curve = table["elastic"], table["johnson_cook"]
    density = table.get("density", elastic)
    thermal = table.get("thermal", {})
    numbers = {k: v for k, v in (curve | thermal).items() if k not in ("source", "grade")}
    johnson_cook = JohnsonCook(**numbers)
    if "combined" in table:
        law = table["combined"]
        pairs = tuple((term["X_Pa"], term["gamma"]) for term in law["backstresses"])
        combined = CombinedHardening(law["R0_Pa"], law["Q_Pa"], law["b"], pairs)
        combined_source = f"{law['source']}; grade {law['grade']}"
    else:
        combined, combined_source = derived_combined(johnson_cook), DERIVED_LAW
    parts = {"elastic": elastic, "Johnson-Cook": curve}
    parts |= {name: table[name] for name in ("density", "thermal") if name in table}
    return Material(
        key=key,
        name=table["name"],
        E_Pa=elastic["E_Pa"],
        nu=elastic["nu"],
        density_kg_m3=density["density_kg_m3"],
        johnson_cook=johnson_cook,
        combined=combined,
        combined_source=combined_source,
        source="; ".join(f"{part}: {t['source']} (grade {t['grade']})" for part, t in parts.items()),
        grade=worst_grade(t["grade"] for t in parts.values()),
    )


def derived_combined(curve: JohnsonCook | CombinedHardening | HardeningTable) -> CombinedHardening:
    """Bounded law for a material that has only its monotonic ``curve`` (evidence grade C)."""
    return CombinedHardening(*bounded_law(curve.flow_stress_Pa))


@functools.cache
def shot(grade: str, size: str = "mono", size_cv: float | None = None) -> Shots:
    """Shots of ``grade``: each of the nominal diameter ("mono"), spread about their mean ("distribution"), or
    between the sieves of the grade's standard ("sieve").

    ``size_cv`` replaces the catalogue's coefficient of variation of the diameter.
    :class:`InputError` with the nearest name when there is no such grade, or none with screening limits.
    """
    media = [medium for medium, table in shot_tables().items() if grade in table["sizes"]["diameter_m"]]
    if not media:
        raise InputError(not_in_catalogue("shot grade", grade, shot_grades()))
    medium = media[0]
    table = shot_tables()[medium]
    substance, nominal_sizes, spread = table["material"], table["sizes"], table["spread"]
    parts = {"material": substance}
    diameter_m, sieve = nominal_sizes["diameter_m"][grade], ()
    if size == "sieve":
        if grade not in sieve_grades():
            raise InputError(not_in_catalogue("shot grade with screening limits", grade, sieve_grades()))
        parts["sieve"] = table["screens"]
        sieve = sieve_of(table["screens"]["limits"][grade])
    else:
        parts["diameter"] = nominal_sizes
    if size == "distribution":
        parts["spread"] = spread
        diameter_m *= spread["mean_over_nominal"]
    shots = Shots(
        grade=grade,
        diameter_m=diameter_m,
        density_kg_m3=substance["density_kg_m3"],
        E_Pa=substance["E_Pa"],
        nu=substance["nu"],
        size=size,
        size_cv=(spread["size_cv"] if size_cv is None else size_cv) if size == "distribution" else 0.0,
        medium=medium,
        source="; ".join(f"{part}: {t['source']} (grade {t['grade']})" for part, t in parts.items()),
        evidence=worst_grade(t["grade"] for t in parts.values()),
        sieve=sieve,
    )
    return dataclasses.replace(shots, diameter_m=sizes.mean_m(shots))
