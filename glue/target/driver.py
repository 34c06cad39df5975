"""Writes the FreeFEM drivers: typed parameter declarations with their units, the load table, one include.

All physics lives in ``freefem/*.edp``; a driver is what a user would type by hand to run it.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence

from glue.errors import InputError
from glue.scene.model import CombinedHardening, JohnsonCook

_MPA = 1e-6  # Pa -> MPa


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


def law_table(E_Pa: float, nu: float, law: JohnsonCook | CombinedHardening) -> list[float]:
    """The 11 numbers of ``law`` as the kernels read them, stresses in MPa: E nu | A B n | Q b | X1 g1 X2 g2.

    Johnson-Cook's rate and temperature factors are not part of it.  Raises InputError for more than two backstresses.
    """
    if isinstance(law, JohnsonCook):
        hardening = [law.A_Pa * _MPA, law.B_Pa * _MPA, law.n, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    else:
        if len(law.backstresses) > 2:
            raise InputError("target.material.combined: at most two backstresses")
        pairs = [v for x, g in law.backstresses for v in (x * _MPA, g)]
        hardening = [law.R0_Pa * _MPA, 0.0, 1.0, law.Q_Pa * _MPA, law.b, *pairs, *[0.0] * (4 - len(pairs))]
    return [float(v) for v in (E_Pa * _MPA, nu, *hardening)]


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
