"""What must hold of any flow's impact log, whatever model wrote it: checked before anything is built on it."""

from __future__ import annotations

import numpy as np

from glue.flow.impacts import normal_speed_m_s
from glue.flow.surface import PLANE, TargetSurface
from glue.scene.model import Scene

# Speed over that of the fastest nozzle (or the gas).  Of two equal shots at right angles one may leave with sqrt(2)
# times their speed, a light one struck head-on by a much heavier one with 3 times; a third shot adds to that.
_SPEED_ALIKE, _SPEED_MIXED = 2.0, 5.0
_ENERGY = 1e-9  # share by which rounding may raise a shot's energy in one impact
_TOUCH = 1e-6  # distance of a touched point from the surface over the shot's diameter
_SAMPLE = 200  # touched points tried on a surface of triangles, where each takes a search


def log_problems(
    scene: Scene, arrivals: np.ndarray | None, impacts: np.ndarray, surface: TargetSurface, touch: float = _TOUCH
) -> list[str]:
    """Sentences about what cannot be; empty when ``impacts`` (``impacts.COLUMNS``) may be believed.

    Finite, in order of time, of shots that left before, into the target and out of it again, no faster than
    the stream, with no more energy after than before, and touching the surface (``touch``: how far off it they may be, in
    diameters).  ``arrivals`` None: of a log from elsewhere, nothing is known of where its shots left.
    """
    if not len(impacts):
        return []
    problems = []
    known = [n for n in impacts.dtype.names if n != "peak_force_N" and impacts.dtype[n].kind == "f"]
    bad = [name for name in known if not np.isfinite(impacts[name]).all()]
    if bad:
        return [f"{', '.join(bad)}: not finite"]

    def expect(holds, sentence: str) -> None:
        if not np.all(holds):
            problems.append(f"{np.size(holds) - np.count_nonzero(holds)} of {np.size(holds)} impacts: {sentence}")

    expect(np.diff(impacts["time_s"]) >= 0.0, "earlier than the one before")
    if arrivals is not None:
        shots = np.asarray(impacts["shot_id"])
        left = (0 <= shots) & (shots < len(arrivals))
        expect(left, "of shots that never left a nozzle")
        if left.all():
            expect(impacts["time_s"] > arrivals["time_s"][shots], "before the shot left its nozzle")
            same = arrivals["diameter_m"][shots] == impacts["diameter_m"]
            expect(same, "of another size than the shot that left")
    expect(normal_speed_m_s(impacts) > 0.0, "out of the target instead of into it")
    expect(_energy(impacts, "out") <= (1.0 + _ENERGY) * _energy(impacts, "in"), "with more energy after than before")
    expect(_speed2(impacts, "in") <= _fastest(scene) ** 2, f"faster than {_fastest(scene):.4g} m/s")
    expect(_off_surface(impacts, surface) <= touch, "away from the target's surface")
    return problems


def _speed2(impacts, when):
    return sum(impacts[f"v{axis}_{when}_m_s"] ** 2 for axis in "xyz")


def _energy(impacts, when):
    """Twice the kinetic energy per mass [m^2/s^2], spin of a solid sphere included."""
    spin2 = sum(impacts[f"w{axis}_{when}_rad_s"] ** 2 for axis in "xyz")
    return _speed2(impacts, when) + 0.1 * impacts["diameter_m"] ** 2 * spin2


def _fastest(scene: Scene) -> float:
    factor = _SPEED_ALIKE if scene.smallest_diameter_m == scene.largest_diameter_m else _SPEED_MIXED
    gas = scene.air_drag.gas_speed_m_s if scene.air_drag else 0.0
    fall = 0.0
    if scene.gravity:  # from ten stand-offs up, where falling shots are dropped
        fall = 20.0 * scene.gravity.acceleration_m_s2 * max(n.stand_off_m for n in scene.nozzles)
    return ((factor * max(scene.fastest_m_s, gas)) ** 2 + fall) ** 0.5


def _off_surface(impacts, surface):
    """Distance from the surface over the diameter, of all impacts or of a sample."""
    if surface.kind == PLANE:
        return np.abs(impacts["z_m"]) / impacts["diameter_m"]
    some = impacts[:: max(len(impacts) // _SAMPLE, 1)]
    points = zip(some["x_m"], some["y_m"], some["z_m"], strict=True)
    return np.abs([surface.clearance(point) for point in points]) / some["diameter_m"]
