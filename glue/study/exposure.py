"""Expected coverage of a window under jets that may move, pulse, lie side by side and strike a curved target.

Where impacts fall at random (a Poisson process), a point that dimples are expected to cover h times ("hits")
stays bare with probability exp(-h), whatever the mixture of their sizes; the expected coverage is the mean of
1 - exp(-h) over the window.  For shots that meet no other, h(x, t) is the sum over nozzles and media of the
fluence of ``glue.flow.footprint`` by time t times the mean area of that nozzle's and medium's dimples.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from glue.flow.drag import speed_after_flight, surroundings
from glue.flow.footprint import fluence_1_m2
from glue.scene import sizes
from glue.scene.consistency import estimated_dimple_radius_m
from glue.scene.model import Scene
from glue.surface.coverage import lengthening
from glue.surface.window import surface_points

POINTS = 9  # a side, of the raster over which the window's hits are sampled
_TIMES, _TIMES_PULSED = 100, 200  # steps of a history that is no straight line


class Hits(NamedTuple):
    """Expected hits at the window's raster points by time; 0 at first, rising."""

    time_s: np.ndarray  # (k,), the last the end of the exposure
    hits: np.ndarray  # (k, p)
    goes_on: bool  # nozzles that stand still would go on like this; a feed ends

    def at(self, times_s) -> np.ndarray:
        """(m, p) at ``times_s`` (m,): straight between times; after the end as before it, or at rest."""
        t, end = np.asarray(times_s, dtype=float), self.time_s[-1]
        inside = np.minimum(t, end)
        found = np.stack([np.interp(inside, self.time_s, column) for column in self.hits.T], axis=-1)
        return found * (np.maximum(t, end) / end)[:, None] if self.goes_on else found

    def coverage(self, times_s) -> np.ndarray:
        """Expected coverage (0-1) of the window at ``times_s`` (m,)."""
        return (-np.expm1(-self.at(times_s))).mean(axis=-1)

    def scaled_to(self, mean_hits: float) -> Hits:
        """The same history for ``mean_hits`` over the window at the end; even in place and time if there was none."""
        own = float(self.hits[-1].mean())
        if own > 0.0:
            return self._replace(hits=self.hits * (mean_hits / own))
        even = mean_hits * self.time_s / self.time_s[-1]
        return self._replace(hits=np.repeat(even[:, None], self.hits.shape[1], axis=1))

    def time_to(self, level: float) -> float | None:
        """Time [s] at which the expected coverage reaches ``level`` (< 1), by bisection; None when it never does."""

        def reached(t: float) -> bool:
            return bool(self.coverage([t])[0] >= level)

        high = float(self.time_s[-1])
        while not reached(high):
            # points that no shot is aimed at stay bare however long it lasts
            if not self.goes_on or (self.hits[-1] > 0.0).mean() <= level:
                return None
            high *= 2.0
        low = 0.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if reached(middle) else (middle, high)
        return high


def expected_hits(scene: Scene, dimple_area_m2: np.ndarray) -> Hits:
    """Hits at a raster of POINTS x POINTS over the window; ``dimple_area_m2`` (nozzles, media) as below."""
    width, height = scene.target.window_m
    even = (np.arange(POINTS) + 0.5) / POINTS - 0.5
    x, y = (g.ravel() for g in np.meshgrid(width * even, height * even))
    moving = any(nozzle.feed is not None for nozzle in scene.nozzles)
    end = scene.exposure_time_s
    pulsed = any(nozzle.pulse is not None for nozzle in scene.nozzles)
    times = np.linspace(0.0, end, (_TIMES_PULSED if pulsed else _TIMES if moving else 1) + 1)
    shares, hits = number_shares(scene), np.zeros((times.size, x.size))
    for number, (at_x, at_y, facing) in enumerate(_on_aim_level(scene, x, y)):
        area = facing * float(dimple_area_m2[number] @ shares)
        for k, t in enumerate(times[1:], 1):
            hits[k] += area * fluence_1_m2(scene, at_x, at_y, t_end=float(t), nozzle=number)
    return Hits(times, hits, not moving)


def dimple_areas_m2(scene: Scene, dimple, impacts: np.ndarray, area_m2: np.ndarray) -> np.ndarray:
    """Mean dimple area by nozzle and medium, (nozzles, media) [m^2].

    Of ``impacts`` with dimple areas ``area_m2`` (n,) where there are any of the kind, else that of a shot as it
    leaves the nozzle, on a flat target.
    """
    found = np.empty((len(scene.nozzles), len(scene.media)))
    for i, nozzle in enumerate(scene.nozzles):
        for k, shots in enumerate(scene.media):
            own = (impacts["nozzle_id"] == i) & (impacts["medium"] == k)
            if own.any():
                found[i, k] = area_m2[own].mean()
            else:
                along = math.sqrt(max(nozzle.speed_m_s**2 - nozzle.normal_speed_m_s**2, 0.0))
                radius = float(dimple.radius_for(shots.diameter_m, nozzle.normal_speed_m_s, shots.density_kg_m3))
                longer = float(lengthening(dimple, shots.diameter_m, shots.density_kg_m3, radius, along))
                found[i, k] = math.pi * longer * (radius / shots.diameter_m) ** 2 * mean_square_diameter_m2(shots)
    return found


def estimated_areas_m2(scene: Scene) -> np.ndarray:
    """Estimated mean dimple area by nozzle and medium, (nozzles, media) [m^2]."""
    found = np.empty((len(scene.nozzles), len(scene.media)))
    for i, nozzle in enumerate(scene.nozzles):
        for k, shots in enumerate(scene.media):
            speed = nozzle.normal_speed_m_s * speed_kept(scene, nozzle, shots)
            radius = estimated_dimple_radius_m(shots, speed, scene.target.material)
            found[i, k] = math.pi * (radius / shots.diameter_m) ** 2 * mean_square_diameter_m2(shots)
    return found


def speed_kept(scene: Scene, nozzle, shots) -> float:
    """Share of its speed that a mean shot still has where it strikes: drag along the axis."""
    if scene.air_drag is None:
        return 1.0
    around = surroundings(scene)
    after = speed_after_flight(nozzle.speed_m_s, nozzle.stand_off_m, shots.diameter_m, shots.density_kg_m3, around)
    return after / nozzle.speed_m_s


def number_shares(scene: Scene) -> np.ndarray:
    """Share of the shots, by number, that is of each medium, (media,)."""
    per_kg = np.array([shots.mass_fraction / shots.mean_mass_kg for shots in scene.media])
    return per_kg / per_kg.sum()


def mean_square_diameter_m2(shots) -> float:
    """Mean over the shots of the squared diameter [m^2], by quantiles."""
    share = (np.arange(200) + 0.5) / 200
    return float(np.mean([sizes.quantile_m(shots, float(u)) ** 2 for u in share]))


def _on_aim_level(scene: Scene, x, y):
    """For each nozzle: where its shots towards the window's points cross z = 0, and area there per area of surface.

    Flight is taken along the nozzle's axis: of a jet that widens, exact only where the surface is z = 0.
    """
    point, normal = surface_points(scene.target.surface, x, y)
    for nozzle in scene.nozzles:
        direction = np.array(nozzle.direction)
        back = point[2] / direction[2]
        facing = np.maximum(-(direction[:, None] * normal).sum(axis=0), 0.0) / -direction[2]
        yield point[0] - back * direction[0], point[1] - back * direction[1], facing
