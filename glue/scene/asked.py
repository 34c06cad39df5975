"""What a shop asks for and what a laboratory measured: plain data, read in ``specification.py`` and ``measured.py``."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class MachineLaw:
    """speed = speed_m_s (setting/reference)^exponent, to ``relative_sd``; from reference/factor to reference x factor."""

    reference: float
    speed_m_s: float
    exponent: float
    relative_sd: float
    factor: float


@dataclass(frozen=True)
class MachineCurve:
    """A saturation curve that the machine peened at a setting, from ``file`` as written in the scene."""

    at: float
    file: str
    strip: str
    sha256: str


@dataclass(frozen=True)
class Machine:
    """What shot speed a setting of the machine gives: one of ``table`` (setting, speed [m/s]; rising), law, curves."""

    setting: str  # "air_pressure_Pa" or "wheel_speed_m_s"
    table: tuple[tuple[float, float], ...] = ()
    law: MachineLaw | None = None
    curves: tuple[MachineCurve, ...] = ()  # by rising setting

    @property
    def range(self) -> tuple[float, float]:
        """Settings for which it is calibrated."""
        if self.law is not None:
            return self.law.reference / self.law.factor, self.law.reference * self.law.factor
        at = [pair[0] for pair in self.table] or [curve.at for curve in self.curves]
        return at[0], at[-1]


@dataclass(frozen=True)
class Specification:
    """What the scene says in a shop's words; the speeds and the time that follow stand where they always do."""

    intensities: tuple[str | None, ...]  # by nozzle
    settings: tuple[float | None, ...]  # by nozzle, of the machine
    coverage_percent: float | None
    machine: Machine | None


@dataclass(frozen=True)
class Measured:
    """What was measured on the part, to stand beside what is computed; nothing of it goes into the computation."""

    stress_file: str = ""
    sha256: str = ""  # of its content
    Ra_m: float | None = None
    Rz_m: float | None = None
    xray_depth_m: float | None = None  # in which the X-rays' intensity falls to 1/e
