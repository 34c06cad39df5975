"""A nozzle's mass flow in time: p(t) of mean 1, its integral P(t), and the way back.

P(t) is the time in which steady flow would have fed as much: shots that are evenly random in P are random in
time with density p.  Standard library and numpy only: YADE's interpreter imports this too.
"""

from __future__ import annotations

import math

import numpy as np

from glue.scene.model import Pulse

_TINY_RAD = 1e-14  # a phase is found to this; in time that is nothing beside a contact


def fed_time_s(pulse: Pulse | None, time_s):
    """P(t) [s], the integral of p from 0 to ``time_s`` (float or array).

    A float is computed by ``math`` alone, the same bits under every numpy.
    """
    if pulse is None:
        return time_s
    lib = np if isinstance(time_s, np.ndarray) else math
    f = pulse.frequency_Hz
    if pulse.pattern == "pulsed":
        periods = lib.floor(time_s * f)
        phase = time_s * f - periods
        on = 1.0 * (phase < pulse.duty)
        return (periods + on * phase / pulse.duty + (1.0 - on)) / f
    angle = 2.0 * math.pi * f
    return time_s + pulse.amplitude * (1.0 - lib.cos(angle * time_s)) / angle


def times_when_fed_s(pulse: Pulse | None, fed_s: np.ndarray) -> np.ndarray:
    """The times t [s] at which P(t) = ``fed_s``, shape (n,); the same bits under every numpy."""
    if pulse is None:
        return fed_s
    f = pulse.frequency_Hz
    periods = np.floor(fed_s * f)
    part = fed_s * f - periods
    if pulse.pattern == "pulsed":
        return (periods + part * pulse.duty) / f
    angles = [_phase_rad(2.0 * math.pi * u, pulse.amplitude) for u in part.tolist()]
    return (periods + np.array(angles) / (2.0 * math.pi)) / f


def _phase_rad(mean_rad: float, amplitude: float) -> float:
    """x in [0, 2 pi] with x + amplitude (1 - cos x) = mean_rad (Kepler's equation): Newton, kept in a bracket."""
    low, high = max(0.0, mean_rad - 2.0 * amplitude), mean_rad
    x = max(low, mean_rad - amplitude * (1.0 - math.cos(mean_rad)))
    for _ in range(100):
        excess = x + amplitude * (1.0 - math.cos(x)) - mean_rad
        if excess > 0.0:
            high = x
        else:
            low = x
        slope = 1.0 + amplitude * math.sin(x)
        new = x - excess / slope if slope > 0.0 else low
        if not low <= new <= high:  # near standstill (amplitude 1) Newton overshoots
            new = 0.5 * (low + high)
        if abs(new - x) <= _TINY_RAD:
            return new
        x = new
    return x
