"""What shot speed a machine gives at a setting: its table, its law, or its own saturation curves.

Of every curve the intensity is read, and the strip model says at which speed these shots bring it.  The model's own curve
is read in the same way, at the same exposures by the same fit, so that what a fit is off by drops out.  Through the
speeds goes log v = log c + n log(setting), by least squares weighted with the curves' own uncertainty (one curve: that
setting alone).  The uncertainty is that of the measurements; what the strip model is off by stands beside it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from glue.errors import InputError
from glue.scene.asked import Machine
from glue.scene.measured import beside
from glue.study.measured import MeasuredCurve, read_curve
from glue.surface.saturation import STATED, fit_saturation
from glue.target.strip import IntensityCurve, StripLibrary, Stream
from glue.theory.almen import STRIPS, mils

_NORMAL = 1.959964  # half of the interval that holds STATED of a normal distribution, in standard deviations
_START_m_s = 30.0  # of the stream whose sizes and speeds are scaled
_LEAST_SD = 1e-4  # of a speed: no measurement is exact


class Speed(NamedTuple):
    """A speed [m/s] and the interval that holds it in STATED of all cases."""

    value: float
    low: float
    high: float


class CurveSpeed(NamedTuple):
    """What one saturation curve says of the speed."""

    setting: float
    speed_m_s: float
    sd: float  # relative
    intensity_m: float
    intensity_half_width_m: float


class PowerLaw(NamedTuple):
    """log v = a + n (log setting - middle), with the covariance of (a, n); a single setting has n = 0 and no slope."""

    a: float
    n: float
    middle: float
    covariance: np.ndarray  # (2, 2)
    quantile: float  # half of the stated interval, in standard deviations
    scatter: float  # of the curves about the law over what they say of themselves; nan for fewer than three

    def speed(self, setting: float) -> Speed:
        x = np.array([1.0, math.log(setting) - self.middle])
        log_v, sd = self.a + self.n * x[1], math.sqrt(float(x @ self.covariance @ x))
        return Speed(*(math.exp(log_v + k * self.quantile * sd) for k in (0.0, -1.0, 1.0)))

    def setting(self, speed_m_s: float) -> float:
        """The setting that gives this speed.  Raises InputError for a law without slope."""
        if self.n <= 0.0:
            raise InputError("machine: one curve, or curves that do not rise: no setting follows for another speed")
        return math.exp(self.middle + (math.log(speed_m_s) - self.a) / self.n)


def curve_speed(
    setting: float, curve: MeasuredCurve, letter: str, curves: IntensityCurve, *, polish: bool = True
) -> CurveSpeed:
    """The mean normal speed at which the stream of ``curves`` peens strip ``letter`` to the measured curve's intensity.

    Raises InputError for a curve that allows no intensity, or one out of reach.
    """
    found = fit_saturation(curve.exposure, curve.arc_height_m)
    if found.problem:
        raise InputError(f"{curve.file}: {found.problem}")
    factor = curves.factor(found.intensity_m, polish=polish)
    for _ in range(2):
        read = _as_read(curves, factor, curve)
        factor *= (found.intensity_m / read) ** (1.0 / curves.exponent(factor))
    sd = found.intensity_half_width_m / _NORMAL / found.intensity_m / curves.exponent(factor)
    speed = float(curves.stream.normal_speed_m_s.mean()) * factor
    return CurveSpeed(setting, speed, max(sd, _LEAST_SD), found.intensity_m, found.intensity_half_width_m)


def _as_read(curves: IntensityCurve, factor: float, curve: MeasuredCurve) -> float:
    """Intensity [m] that the fit reads off the model's own curve, at the measured exposures.

    How many hits an exposure brings is not known: it is what makes the model's curve most like the measured one in shape.
    """
    from scipy.optimize import minimize_scalar  # here and below: a second that scenes without a machine do without

    library, strip, stream = curves.library, curves.strip, curves.faster(factor)
    hits, exact = library.saturation(strip, stream)
    over, wanted = curve.exposure / curve.exposure[-1], curve.arc_height_m

    def heights(x: float) -> np.ndarray:
        return np.array([library.arc_height_m(strip, stream, math.exp(x) * float(m)) for m in over])

    def miss(x: float) -> float:
        h = heights(x)
        return float(((h * (h @ wanted) / (h @ h) - wanted) ** 2).sum() / (wanted @ wanted))

    found = minimize_scalar(miss, bounds=(math.log(0.7 * hits), math.log(8.0 * hits)), method="bounded", options={"xatol": 1e-2})
    read = fit_saturation(over, heights(found.x))
    return exact if read.problem else read.intensity_m


def power_law(points: list[CurveSpeed]) -> PowerLaw:
    """The law through the speeds of several curves at different settings."""
    from scipy.stats import t as student

    x, y = np.log([p.setting for p in points]), np.log([p.speed_m_s for p in points])
    sd = np.array([p.sd for p in points])
    if len(points) == 1:
        return PowerLaw(float(y[0]), 0.0, float(x[0]), np.diag([sd[0] ** 2, 0.0]), _NORMAL, math.nan)
    middle = float(np.average(x, weights=sd**-2))
    design = np.column_stack([np.ones_like(x), x - middle]) / sd[:, None]
    covariance = np.linalg.inv(design.T @ design)
    a, n = covariance @ design.T @ (y / sd)
    quantile, scatter, degrees = _NORMAL, math.nan, len(points) - 2
    if degrees:
        scatter = math.sqrt(float((((y - a - n * (x - middle)) / sd) ** 2).sum()) / degrees)
        if scatter > 1.0:  # the curves differ by more than they own up to: let their scatter speak
            covariance, quantile = covariance * scatter**2, min(float(student.ppf(0.5 + 0.5 * STATED, degrees)), 3.0 * _NORMAL)
    return PowerLaw(float(a), float(n), middle, covariance, quantile, scatter)


class Calibrated(NamedTuple):
    """A machine that is ready to say speeds; ``text``: how it was found, line by line."""

    machine: Machine
    law: PowerLaw | None
    text: tuple[str, ...]

    def speed(self, setting: float) -> Speed:
        """Shot speed [m/s] at a setting inside the calibration."""
        from scipy.interpolate import PchipInterpolator

        if self.law is not None:
            return self.law.speed(setting)
        if self.machine.law is not None:
            law = self.machine.law
            v = law.speed_m_s * (setting / law.reference) ** law.exponent
            return Speed(v, v * math.exp(-_NORMAL * law.relative_sd), v * math.exp(_NORMAL * law.relative_sd))
        at, speeds = np.log(np.array(self.machine.table)).T
        v = math.exp(float(PchipInterpolator(at, speeds)(math.log(setting))))
        # Straight between the rows beside it is another reading of the same table: their difference, at least.
        other = math.exp(float(np.interp(math.log(setting), at, speeds)))
        half = abs(v - other)
        return Speed(v, v - half, v + half)

    def setting_for(self, speed_m_s: float) -> float | None:
        """The setting that gives this speed, None outside the calibration."""
        low, high = self.machine.range
        if low == high or not self.speed(low).value <= speed_m_s <= self.speed(high).value:
            return None
        for _ in range(60):
            middle = math.sqrt(low * high)
            low, high = (middle, high) if self.speed(middle).value < speed_m_s else (low, middle)
        return math.sqrt(low * high)


def exit_speed(normal_m_s: float, arriving: Callable[[float], Stream]) -> float:
    """Speed [m/s] at the nozzle with which the mean normal speed on arrival is ``normal_m_s``.

    arriving: the stream by the speed at the nozzle; angle, drag and collisions are in it, all nearly in proportion.
    """
    speed = normal_m_s
    for _ in range(30):
        ratio = float(arriving(speed).normal_speed_m_s.mean()) / normal_m_s
        speed /= ratio
        if abs(ratio - 1.0) < 1e-6:
            break
    return speed


def calibrate(
    machine: Machine, scene_file: Path, library: StripLibrary | None, arriving: Callable[[float], Stream]
) -> Calibrated:
    """Make a machine's table, law or curves ready; curves need the library.

    arriving: the stream of the scene's shots by the speed at the nozzle.  Raises InputError with the problems of all curves.
    """
    low, high = machine.range
    if not machine.curves:
        kind = "table" if machine.table else "law"
        return Calibrated(machine, None, (f"machine: {kind} over {machine.setting}, {low:g} to {high:g}",))
    points, problems, by_strip = [], [], {}
    for curve in machine.curves:
        try:
            path = beside(scene_file, curve.file)
            measured = read_curve(path or Path(curve.file))
            if curve.strip not in by_strip:
                by_strip[curve.strip] = IntensityCurve(library, STRIPS[curve.strip], arriving(_START_m_s))
            found = curve_speed(curve.at, measured, curve.strip, by_strip[curve.strip])
            points.append(found._replace(speed_m_s=exit_speed(found.speed_m_s, arriving)))
        except InputError as problem:
            problems += [f"machine.curves ({machine.setting} = {curve.at:g}): {text}" for text in problem.problems]
    if problems:
        raise InputError(problems)
    law = power_law(points)
    lines = [
        f"machine at {machine.setting} = {p.setting:g}: {mils(p.intensity_m):.2f}{c.strip} ± {mils(p.intensity_half_width_m):.2f}, so"
        f" {p.speed_m_s:.4g} m/s ± {_NORMAL * p.sd:.1%}"
        for p, c in zip(points, machine.curves, strict=True)
    ]
    if len(points) > 1:
        sd = math.sqrt(law.covariance[1, 1])
        lines.append(f"machine: speed ~ {machine.setting}^({law.n:.3f} ± {law.quantile * sd:.3f}) ({STATED:.0%})")
    return Calibrated(machine, law, tuple(lines))
