"""Writes the FreeFEM drivers: typed parameter declarations with their units, the load table, one include.

All physics lives in ``freefem/*.edp``; a driver is what a user would type by hand to run it.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence

from glue.errors import InputError
from glue.scene.model import CombinedHardening, HardeningTable, JohnsonCook

_MPA = 1e-6  # Pa -> MPa
LAW_COMMENT = "E nu | A B n | Q b | X1 g1 X2 g2 | cap | C rate0 | m T0 Tm heat | k p_1.. s_1.. (MPa, K, time R/(1 m/s))"


class Parameter:
    """One declaration: FreeFEM type, name, value, unit or meaning for the comment."""

    def __init__(self, kind: str, name: str, value, comment: str):
        self.kind, self.name, self.value, self.comment = kind, name, value, comment

    def line(self) -> str:
        """The declaration; 17 digits, so that FreeFEM reads the same number back."""
        return f"{self.kind} {self.name} = {_literal(self.value)}; // {self.comment}"


def _literal(value) -> str:
    if isinstance(value, str):
        if any(c in value for c in '"\\\n'):
            raise InputError(
                f"a path with quotes, backslashes or line breaks cannot be written into a driver: {value!r}"
            )
        return f'"{value}"'
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"a driver's number must be finite, got {value}")
        return f"{value:.17g}"
    return "[" + ", ".join(_literal(v) for v in value) + "]"


def law_table(
    E_Pa: float,
    nu: float,
    law: JohnsonCook | CombinedHardening | HardeningTable,
    *,
    radius_m: float | None = None,
    density_kg_m3: float | None = None,
    rate: bool = False,
    thermal: bool = False,
) -> list[float]:
    """The numbers of ``law`` as the kernels read them (LAW_COMMENT): stresses in MPa, time in R/(1 m/s).

    rate: with Johnson-Cook's rate factor, which needs the shot's radius R [m] for the unit of time; thermal: with
    its temperature factor, which needs the target's density.  Raises InputError for a law that has no such factor
    and for more than two backstresses.
    """
    power, saturating, cap, points = [0.0, 0.0, 1.0], [0.0] * 6, 0.0, []
    if isinstance(law, JohnsonCook):
        power = [law.A_Pa * _MPA, law.B_Pa * _MPA, law.n]
        cap = 0.0 if law.saturation_Pa is None else law.saturation_Pa * _MPA
    elif isinstance(law, HardeningTable):
        points = [len(law.strain), *law.strain, *(s * _MPA for s in law.stress_Pa)]
    else:
        if len(law.backstresses) > 2:
            raise InputError("target.material.combined: at most two backstresses")
        pairs = [v for x, g in law.backstresses for v in (x * _MPA, g)]
        power[0] = law.R0_Pa * _MPA
        saturating = [law.Q_Pa * _MPA, law.b, *pairs, *[0.0] * (4 - len(pairs))]
    factors = [*_rate_factor(law, radius_m, rate), *_thermal_factor(law, density_kg_m3, thermal)]
    return [float(v) for v in (E_Pa * _MPA, nu, *power, *saturating, cap, *factors, *(points or [0.0]))]


def _rate_factor(law, radius_m: float | None, wanted: bool) -> list[float]:
    """C and the reference rate in 1/(R/(1 m/s)); zeros when not wanted."""
    if not wanted:
        return [0.0, 0.0]
    if not isinstance(law, JohnsonCook) or law.C == 0.0:
        raise InputError("strain_rate: this law has no rate term; allowed: johnson_cook with C above 0")
    if radius_m is None:
        raise InputError("strain_rate: a rate is counted in units of the shot, so its radius is needed")
    return [law.C, law.rate_ref_1_s * radius_m]


def _thermal_factor(law, density_kg_m3: float | None, wanted: bool) -> list[float]:
    """m, T0 [K], Tm [K] and the kelvins per MPa of plastic work; zeros when not wanted."""
    if not wanted:
        return [0.0] * 4
    known = isinstance(law, JohnsonCook) and law.m and law.melting_K and law.specific_heat_J_kg_K
    if not known or density_kg_m3 is None:
        raise InputError(
            "strain_rate.thermal: needs johnson_cook with m, melting_K and specific_heat_J_kg_K, and the density"
        )
    heat = law.taylor_quinney / (density_kg_m3 * law.specific_heat_J_kg_K) / _MPA
    return [law.m, law.reference_K, law.melting_K, heat]


def kernel_flavour() -> str:
    """``kernel`` (compiled) unless PEEN_KERNEL=script asks for the pure-script twin."""
    flavour = os.environ.get("PEEN_KERNEL", "kernel")
    if flavour not in ("kernel", "script"):
        raise InputError(f"PEEN_KERNEL={flavour}: allowed kernel, script")
    return flavour


def write_driver(
    title: str, parameters: Sequence[Parameter], includes: Sequence[str], loads: Sequence[Sequence[float]] | None = None,
    load_comment: str = "",
) -> str:  # fmt: skip
    """Text of a driver.

    loads: rows of the impact table ``impactLoad``; includes: files of ``freefem/`` in order, the physics last.
    """
    lines = [
        f"// {title}",
        "// Written by peen; runs alone: FreeFem++ -nw -ne -v 0 driver.edp (search paths: peen doctor).",
    ]
    lines += [p.line() for p in parameters]
    if loads is not None:
        lines += [
            f"// {load_comment}",
            f"real[int, int] impactLoad({len(loads)}, {len(loads[0]) if loads else 4});",
        ]
        # One short statement a row: a literal of thousands of entries overflows FreeFEM's parser stack.
        lines += [f"impactLoad({k}, :) = {_literal([float(v) for v in row])};" for k, row in enumerate(loads)]
    lines += [f'include "{name}"' for name in includes]
    return "\n".join(lines) + "\n"
