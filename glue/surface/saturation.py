"""The saturation curve of an Almen strip: arc height h over exposure t, and the intensity read off it.

SAE J443: the intensity is the arc height at the first exposure T whose doubling raises it by a tenth,

    h(2 T) = 1.1 h(T).                                                                                   (1)

Three curves through the origin are fitted by least squares:

    two-parameter exponential    h = a (1 - exp(-t/b))          T = b ln 10,   h(T) = .9 a               (2)
    two-parameter hyperbola      h = a t/(b + t)                T = 4.5 b,     h(T) = .8182 a            (3)
    three-parameter exponential  h = a (1 - exp(-(t/b)^c))      T by bisection                           (4)

(2) and (3) are the two-parameter equations of SAE J2597 and of the French standard (grade B); (4) takes part
from six points on.  The one with the least residual per degree of freedom is taken.  The a of each is linear and eliminated, so that
one or two numbers are searched.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from glue.errors import InputError

FEWEST, THIRD_FROM = 4, 6  # points that SAE J443 asks for; from which on a third parameter takes part
MOST_DROP = 0.05  # of the largest arc height: a fall from one exposure to the next beyond it is no saturation curve
STATED = 0.95
RISE = 1.1
_ZOOMS = 26  # each to .4 of the last: the parameters to 1e-9


class Form(NamedTuple):
    """One equation: ``shape(t/b, c)`` runs from 0 to 1."""

    name: str
    text: str
    parameters: int

    def shape(self, x, c: float):
        x = np.asarray(x, dtype=float)
        return x / (1.0 + x) if self.name == "hyperbola" else -np.expm1(-(x**c))

    def saturation(self, c: float) -> float:
        """T/b of (1)."""
        from scipy.optimize import brentq  # here and below: a second that other stages do without

        if self.name == "hyperbola":
            return 4.5
        # with u = (T/b)^c: 1 - exp(-2^c u) = 1.1 (1 - exp(-u)); it has a root for 2^c > 1.1
        if 2.0**c <= RISE * (1.0 + 1e-6):
            return math.inf
        u = brentq(lambda u: -math.expm1(-(2.0**c) * u) + RISE * math.expm1(-u), 1e-12, 60.0)
        return u ** (1.0 / c)


FORMS = (
    Form("exponential", "h = a (1 - exp(-t/b))", 2),
    Form("hyperbola", "h = a t/(b + t)", 2),
    Form("exponential, three parameters", "h = a (1 - exp(-(t/b)^c))", 3),
)


class Fit(NamedTuple):
    """One form fitted: parameters (a, b) or (a, b, c), saturation exposure and intensity with standard errors."""

    form: Form
    parameters: tuple[float, ...]
    residual_m: float  # root of the residual sum of squares per degree of freedom
    saturation: float
    intensity_m: float
    saturation_sd: float
    intensity_sd_m: float

    def __call__(self, exposure):
        """Arc height [m] at ``exposure``."""
        a, b, *c = self.parameters
        return a * self.form.shape(np.asarray(exposure, dtype=float) / b, *(c or [1.0]))


@dataclass(frozen=True)
class Saturation:
    """What a saturation curve says; ``problem`` instead of numbers where it does not allow any."""

    exposure: np.ndarray
    arc_height_m: np.ndarray
    fits: tuple[Fit, ...]  # the best first
    problem: str | None
    warnings: tuple[str, ...]

    @property
    def best(self) -> Fit:
        return self.fits[0]

    @property
    def intensity_m(self) -> float:
        return self.best.intensity_m

    @property
    def intensity_half_width_m(self) -> float:
        """Half of the interval that holds the intensity in STATED of all cases: scatter of the points, and the form."""
        return self._half_width("intensity_m", "intensity_sd_m")

    @property
    def saturation_half_width(self) -> float:
        return self._half_width("saturation", "saturation_sd")

    def _half_width(self, value: str, sd: str) -> float:
        from scipy.stats import t as student

        best = self.best
        degrees = self.exposure.size - best.form.parameters
        # Another form that fits about as well might be the true one.
        alike = [f for f in self.fits if f.residual_m <= 2.0 * best.residual_m and math.isfinite(getattr(f, value))]
        form = max(abs(getattr(f, value) - getattr(best, value)) for f in alike)
        return math.hypot(student.ppf(0.5 + 0.5 * STATED, degrees) * getattr(best, sd), form)


def fit_saturation(exposure, arc_height_m) -> Saturation:
    """Fit the curve through (exposure (n,) in any unit, rising; arc_height_m (n,)).

    Raises InputError for numbers that are no measurement (not finite, exposures not above 0 or not rising, heights not
    above 0).  A measurement that does not allow an intensity has ``problem`` set, and no ``fits`` where there are too few points.
    """
    t, h = np.asarray(exposure, dtype=float), np.asarray(arc_height_m, dtype=float)
    _check(t, h)
    if t.size < FEWEST:
        text = f"only {t.size} points: a saturation curve needs {FEWEST} and more exposures (SAE J443)"
        return Saturation(t, h, (), text, ())
    drop = float(np.max(np.maximum.accumulate(h) - h) / h.max())
    if drop > MOST_DROP:
        text = (
            f"the arc height is not monotone: it falls by {drop:.0%} of the largest as the exposure grows; allowed"
            f" {MOST_DROP:.0%} (a mixed-up strip, or peening conditions that changed)"
        )
        return Saturation(t, h, (), text, ())
    if h.max() < RISE * h.min():
        text = "the arc height hardly rises with exposure: every point is beyond saturation; measure shorter exposures"
        return Saturation(t, h, (), text, ())
    fits = [_fit(form, t, h) for form in FORMS if form.parameters == 2 or t.size >= THIRD_FROM]
    fits = tuple(sorted((f for f in fits if f is not None), key=lambda f: f.residual_m))
    if not fits:
        text = "no saturation within the data: the points rise without levelling off; measure longer exposures"
        return Saturation(t, h, (), text, ())
    return Saturation(t, h, fits, _no_saturation(t, fits[0]), tuple(_warnings(t, h, fits[0])))


def _no_saturation(t: np.ndarray, best: Fit) -> str | None:
    """Why the data do not reach (1), None when they do."""
    if not math.isfinite(best.saturation) or best.saturation > t[-1]:
        found = "nowhere" if not math.isfinite(best.saturation) else f"only at {best.saturation:.4g}"
        return (
            f"no saturation within the data: the fitted curve has h(2T) = 1.1 h(T) {found}, beyond the longest exposure"
            f" {t[-1]:.4g}; measure longer exposures, at least twice that"
        )
    return None


def _warnings(t: np.ndarray, h: np.ndarray, best: Fit):
    if best.saturation <= t[-1] < 2.0 * best.saturation:
        yield f"the longest exposure {t[-1]:.4g} is below twice the saturation exposure: h(2T) is extrapolated"
    if best.saturation < t[0]:
        yield (
            f"every exposure is beyond the saturation exposure {best.saturation:.3g}: it is extrapolated towards 0; measure"
            " shorter ones"
        )
    if (np.diff(h) < 0.0).any():
        yield "the arc height falls somewhere by less than the scatter that is allowed"
    if best.residual_m > 0.1 * h.max():
        yield f"the points scatter by {best.residual_m / h.max():.0%} of the largest arc height about the curve"


def _check(t: np.ndarray, h: np.ndarray) -> None:
    problems = []
    if t.ndim != 1 or t.shape != h.shape:
        problems.append(f"saturation curve: shapes {t.shape} and {h.shape}: two equal columns are needed")
    elif not (np.isfinite(t).all() and np.isfinite(h).all()):
        problems.append("saturation curve: holds values that are not finite")
    else:
        if (t <= 0.0).any():
            problems.append("saturation curve: exposures must be above 0")
        if (np.diff(t) <= 0.0).any():
            problems.append("saturation curve: exposures must rise, each once")
        if (h <= 0.0).any():
            problems.append("saturation curve: arc heights must be above 0")
    if problems:
        raise InputError(problems)


def _fit(form: Form, t: np.ndarray, h: np.ndarray) -> Fit | None:
    """Least squares over (log b) or (log b, log c), a eliminated; None when it runs away."""
    third = form.parameters == 3
    low, high = np.array([math.log(t[0] * 1e-2), math.log(0.25)]), np.array([math.log(t[-1] * 1e2), math.log(4.0)])
    x, misses = _search(form, t, h, low, high, third)
    if min(x[0] - low[0], high[0] - x[0]) < 1e-2:
        return None
    shape = form.shape(t / math.exp(x[0]), math.exp(x[1]))
    a = float(shape @ h / (shape @ shape))
    p = (a, *(float(v) for v in np.exp(x[: form.parameters - 1])))
    degrees = t.size - form.parameters
    residual = math.sqrt(misses / degrees)
    jacobian = _gradient(lambda q: q[0] * form.shape(t / q[1], _third(q)), p)
    covariance = residual**2 * np.linalg.pinv(jacobian.T @ jacobian)

    def sd(value) -> float:
        g = _gradient(lambda q: np.array([value(q)]), p)[0]
        return math.sqrt(max(float(g @ covariance @ g), 0.0))

    def saturation(q) -> float:
        return q[1] * form.saturation(_third(q))

    def intensity(q) -> float:
        return q[0] * float(form.shape(form.saturation(_third(q)), _third(q)))

    if not math.isfinite(saturation(p)):
        return Fit(form, p, residual, math.inf, math.nan, math.inf, math.inf)
    return Fit(form, p, residual, saturation(p), intensity(p), sd(saturation), sd(intensity))


def _search(form: Form, t, h, low, high, third: bool) -> tuple[np.ndarray, float]:
    """(log b, log c) of the least sum of squared residuals [m^2], and that: a grid, then ever finer ones around its best.

    No gradient: with few points the valley may be flat, and every step here is finite.
    """
    x, half, best = 0.5 * (low + high), 0.5 * (high - low), math.inf
    for k in range(_ZOOMS):
        n = (121, 25) if k == 0 else (9, 9)
        b, c = (np.clip(np.linspace(m - w, m + w, i), lo, hi) for m, w, i, lo, hi in zip(x, half, n, low, high))
        b, c = (g.ravel() for g in np.meshgrid(b, c if third else 0.0))
        f = form.shape(t / np.exp(b)[:, None], np.exp(c)[:, None])
        a = (f @ h) / np.maximum((f * f).sum(axis=1), 1e-300)
        misses = ((a[:, None] * f - h) ** 2).sum(axis=1)
        least = int(np.argmin(misses))
        x, best = np.array([b[least], c[least]]), float(misses[least])
        half = half * (2.5 / 120 if k == 0 else 0.4) * (np.array([1.0, 5.0]) if k == 0 else 1.0)
    return x, best


def _third(q) -> float:
    return q[2] if len(q) > 2 else 1.0


def _gradient(values, p) -> np.ndarray:
    """(n, len(p)): derivatives by the parameters' logarithms, so that no unit matters; central differences of 1e-5."""
    columns = []
    for k, value in enumerate(p):
        step = 1e-5 * value
        up, down = (list(p) for _ in range(2))
        up[k] += step
        down[k] -= step
        columns.append((values(up) - values(down)) / 2e-5)
    return np.stack(columns, axis=-1)
