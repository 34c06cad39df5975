"""What a design is asked for: "coverage>=98%", "max_compressive<=-250MPa", minimise "Sa".

Names are those of metrics.json: a full key path (``residual_stress.max_compressive_Pa``) or a short name for the headline
ones.  Of the scene itself ``exposure_time_s`` and ``shot_mass_kg`` (mass flow times time) may be asked for, too.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from glue.errors import InputError
from glue.scene.catalogue import closest
from glue.scene.model import Scene
from glue.study.rows import ROWS

SHORT = {
    "coverage": "coverage.final", "time_98": "coverage.time_98_s", "max_compressive": "residual_stress.max_compressive_Pa",
    "max_compressive_depth": "residual_stress.max_compressive_depth_m", "surface_stress": "residual_stress.surface_Pa",
    "tenth_depth": "residual_stress.tenth_depth_m", "compressive_depth": "residual_stress.compressive_depth_m",
    "arc_height": "residual_stress.arc_height_m", "Sa": "roughness.Sa_m", "Sq": "roughness.Sq_m", "Sz": "roughness.Sz_m",
    "Ra": "roughness.Ra_m", "Rz": "roughness.Rz_m", "dimple_radius": "dimple.radius_m", "dimple_depth": "dimple.depth_m",
    "exposure_time": "scene.exposure_time_s", "shot_mass": "scene.shot_mass_kg",
}  # fmt: skip
# Coverage counted in one window scatters; what is searched by is its expectation for the dimples found in the window.
EXPECTED = {"coverage.final": "coverage.avrami_final", "coverage.time_98_s": "coverage.avrami_time_98_s"}
# Other seeds and finer models of the same scene may differ by these; the law and friction are the same in them.
RERUN_CAUSES = ("statistical", "numerical")
_STAGE = {  # by section of metrics.json
    "dimple": "dimple", "flow": "flow", "coverage": "coverage", "residual_stress": "target", "target": "target",
    "roughness": "surface",
}  # fmt: skip
_UNITS = {  # ending of the key: {unit: factor to SI}, the first the one printed
    "_Pa": {"MPa": 1e6, "GPa": 1e9, "kPa": 1e3, "Pa": 1.0},
    "_m_s": {"m/s": 1.0},
    "_m": {"µm": 1e-6, "um": 1e-6, "mm": 1e-3, "m": 1.0},
    "_s": {"s": 1.0, "min": 60.0, "h": 3600.0},
    "_N": {"N": 1.0},
    "_kg": {"kg": 1.0, "g": 1e-3},
    ".percent": {"%": 1.0, "": 1.0},
}
_SHARES = {"coverage.final", "coverage.avrami_final", "coverage.avrami_mass_flow_final", "coverage.peeq_final",
           "flow.collided_fraction", "flow.mean_normal_energy_fraction", "coverage.beyond_table_share",
           "coverage.beyond_table_area_share"}  # fmt: skip
_FORM = re.compile(r"\s*([A-Za-z][\w.]*)\s*(>=|<=)\s*([-+−]?[\d.]+(?:[eE][-+]?\d+)?)\s*([^\s\d]*)\s*")


class Reading(NamedTuple):
    """A metric of one run with its half widths (95 %): of a re-run (``RERUN_CAUSES``), and of all causes together.

    None: nothing is known of it, which is not exactly known.
    """

    value: float
    half: float | None
    half_all: float | None

    @property
    def margin(self) -> float:
        """The half width that a limit is kept off by: 0 where none is known, which has to be told."""
        return self.half or 0.0


class Quantity(NamedTuple):
    """A metric by its key path."""

    path: str
    short: str

    @property
    def units(self) -> dict[str, float]:
        """{unit: factor to SI}; the first is the one printed."""
        if self.path in _SHARES:
            return {"%": 0.01, "": 1.0}
        found = (units for ending, units in _UNITS.items() if self.path.endswith(ending))
        return next(found, {"": 1.0, "%": 0.01})

    @property
    def stage(self) -> str | None:
        """The stage that finds it; None for what the scene itself says."""
        return _STAGE.get(self.path.split(".")[0])

    def shown(self, value: float, digits: int = 4) -> str:
        """``value`` (SI) in the printed unit."""
        unit, factor = next(iter(self.units.items()))
        return f"{float(f'{value / factor:.{digits}g}'):.10g} {unit}".strip()

    def told(self, reading: Reading | None) -> str:
        """A reading as it is printed, with the half width of a re-run."""
        if reading is None:
            return "no value"
        if reading.half is None:
            return f"{self.shown(reading.value)}, no interval known"
        return self.shown(reading.value) + (f" ± {self.shown(reading.half, 2)}" if reading.half else "")

    def read(self, metrics: Mapping, scene: Scene, expected: bool = True) -> Reading | None:
        """The quantity of a run; None where it could not be determined.

        expected: of coverage the expectation for the window's dimples, with the half width that one window's count has.
        """
        section, key = self.path.split(".", 1)
        if section == "scene":
            value = scene.exposure_time_s * (scene.mass_flow_kg_s if key == "shot_mass_kg" else 1.0)
            return Reading(value, 0.0, 0.0)
        section, key = (EXPECTED.get(self.path, self.path) if expected else self.path).split(".", 1)
        value = metrics.get(section, {}).get(key)
        if value is None:
            return None
        told = metrics.get("uncertainty", {})
        stated = told.get(self.path) or told.get(f"{section}.{key}")
        if stated is None:
            return Reading(float(value), None, None)
        known = [half for cause in RERUN_CAUSES if (half := stated["by_cause"].get(cause)) is not None]
        return Reading(float(value), math.hypot(*known) if known else None, float(stated["half_width_95"]))


class Target(NamedTuple):
    """``quantity`` at least (sign +1) or at most (sign -1) ``limit`` (SI)."""

    quantity: Quantity
    sign: int
    limit: float

    def slack(self, reading: Reading) -> float:
        """How far beyond the limit the unfavourable end of the re-run's interval lies (SI); below 0: not surely met."""
        return self.sign * (reading.value - self.limit) - reading.margin

    def scaled(self, slack: float) -> float:
        """``slack`` over the limit's size, so that targets of different units compare."""
        return slack / (abs(self.limit) or 1.0)

    def __str__(self) -> str:
        return f"{self.quantity.short} {'>=' if self.sign > 0 else '<='} {self.quantity.shown(self.limit)}"


class Objective(NamedTuple):
    """``quantity`` to be made small (sign +1) or large (sign -1)."""

    quantity: Quantity
    sign: int

    def __str__(self) -> str:
        return f"{'minimise' if self.sign > 0 else 'maximise'} {self.quantity.short}"


class Goals(NamedTuple):
    targets: tuple[Target, ...]
    objectives: tuple[Objective, ...]

    @property
    def quantities(self) -> list[Quantity]:
        """Each quantity once, targets first."""
        return list(dict.fromkeys([*(t.quantity for t in self.targets), *(o.quantity for o in self.objectives)]))

    @property
    def stages(self) -> list[str]:
        """The stages that find them, and their uncertainty."""
        return list(dict.fromkeys([q.stage for q in self.quantities if q.stage] + ["uncertainty"]))


def read_goals(targets: Sequence[str], minimise: Sequence[str], maximise: Sequence[str] = ()) -> Goals:
    """Goals as written on the command line.  Raises InputError with everything that is wrong."""
    problems: list[str] = []
    found = [t for text in targets if (t := _target(text, problems))]
    aims = [(text, +1, "--minimise") for text in minimise] + [(text, -1, "--maximise") for text in maximise]
    objectives = [Objective(q, sign) for text, sign, option in aims if (q := quantity(text, option, problems))]
    if not aims:
        problems.append("--minimise: nothing to choose by; allowed: --minimise NAME or --maximise NAME, such as --minimise Sa")
    if len({o.quantity for o in objectives}) < len(objectives):
        problems.append("--minimise, --maximise: a quantity is named twice; allowed once")
    for q in {t.quantity for t in found}:
        low = max((t.limit for t in found if t.quantity == q and t.sign > 0), default=-math.inf)
        high = min((t.limit for t in found if t.quantity == q and t.sign < 0), default=math.inf)
        if low > high:
            problems.append(f"--target: {q.short} cannot be at least {q.shown(low)} and at most {q.shown(high)}")
    if problems:
        raise InputError(problems)
    return Goals(tuple(found), tuple(objectives))


def quantity(name: str, option: str, problems: list[str]) -> Quantity | None:
    """The quantity of a short name or key path; else a sentence into ``problems``."""
    name = name.strip()
    path = SHORT.get(name, name)
    if path not in _paths():
        section, _, _ = name.partition(".")
        inside = [known for known in _paths() if known.startswith(f"{section}.")]
        guess = closest(name, [*SHORT, *_paths()])
        hint = f"did you mean {guess}? " if guess else ""
        allowed = ", ".join(inside or SHORT)
        problems.append(
            f"{option} {name}: unknown name; {hint}allowed: {allowed}, or a key path of metrics.json such as"
            " residual_stress.max_compressive_Pa"
        )
        return None
    return Quantity(path, next((short for short, known in SHORT.items() if known == path), path))


def _paths() -> list[str]:
    rows = [f"{section}.{row[0]}" for section in _STAGE for row in ROWS[section][1] if row[2] is not None]
    return [*rows, "scene.exposure_time_s", "scene.shot_mass_kg"]


def _target(text: str, problems: list[str]) -> Target | None:
    parts = _FORM.fullmatch(text)
    if parts is None:
        problems.append(f"--target {text}: must be NAME>=VALUE or NAME<=VALUE and a unit, such as 'max_compressive<=-250MPa'")
        return None
    name, sign, number, unit = parts.groups()
    found = quantity(name, "--target", problems)
    if found is None:
        return None
    if unit not in found.units:
        allowed = ", ".join(u or "no unit" for u in found.units)
        problems.append(f"--target {text}: {f'unit {unit}' if unit else 'a unit is missing'}; {name} allows {allowed}")
        return None
    try:
        value = float(number.replace("−", "-"))
    except ValueError:
        problems.append(f"--target {text}: {number} is no number")
        return None
    limit = value * found.units[unit]
    if found.path in _SHARES and not 0.0 <= limit <= 1.0:
        meant = f"{value:g} % is written {value:g}% or {value / 100.0:g}; " if not unit and 1.0 < value <= 100.0 else ""
        problems.append(f"--target {text}: {meant}{name} is a share; allowed: 0 to 1, or 0% to 100%")
        return None
    if found.path == SHORT["max_compressive"] and limit > 0.0:  # met by every setting, or by none
        meant = f"{name}<=-{number.lstrip('+')}{unit}"
        problems.append(f"--target {text}: compression is negative here: did you mean {meant}? allowed: up to 0")
        return None
    return Target(found, +1 if sign == ">=" else -1, limit)
