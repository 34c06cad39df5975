"""Restitution contact by contact: the damping ratio that gives the wanted rebound, set on the live contact.

``MindlinPhys.betan`` is the dashpot's share of the critical one; YADE computes it once from ``en``.  A rebound
that depends on speed, or on how often the spot was struck, or that must be right for shots of every size at one
time step, needs it per contact: it is set right after the contact's first step.

The map wanted rebound -> betan is measured in the rig of ``contact_model.py`` at nodes of betan and at two
steps; between nodes it is linear in ln e, and in the step linear in steps per contact^-1, which is how the
error of the integration grows (0.26 % low at 25 steps, .09 % at 83, e .6).
"""

from __future__ import annotations

import bisect
import math
import statistics
from collections import defaultdict

import numpy as np

from contact_model import Solid, contact_modulus_Pa, measure_rebounds
from glue.flow.restitution import RestitutionLaw
from glue.theory.hertz import CONTACT_TIME_FACTOR

NODES = (*np.geomspace(0.05, 0.94, 36).tolist(), 0.96)  # en at which the map is measured
PHASES = 48
BIN = 0.002  # of fineness, a twentieth of a 25-step contact: the map is inverted once per bin


def contact_time_s(mass_kg: float, radius_m: float, modulus_Pa: float, speed_m_s: float) -> float:
    """Hertz's 2.9432 depth / v of an elastic impact; reduced mass and radius, contact modulus, normal speed."""
    depth = (15.0 * mass_kg * speed_m_s**2 / (16.0 * math.sqrt(radius_m) * modulus_Pa)) ** 0.4
    return CONTACT_TIME_FACTOR * depth / speed_m_s


class DashpotMap:
    """Damping ratio by wanted rebound and ``fineness`` = time step over Hertz's contact time."""

    def __init__(
        self,
        pair: str,
        *,
        en: float,
        shot: Solid,
        target: Solid,
        diameter_m: float,
        dt_s: float,
        speed_m_s: float,
    ):
        """Measure it (.3 s). ``en`` is what YADE gives the contact in its first step."""
        mass = shot.density_kg_m3 * math.pi / 6.0 * diameter_m**3
        radius, other = 0.5 * diameter_m, target
        if pair == "shot":
            mass, radius, other = 0.5 * mass, 0.5 * radius, shot
        whole = contact_time_s(mass, radius, contact_modulus_Pa(shot, other), speed_m_s)
        rig = dict(shot=shot, target=target, pair=pair, diameter_m=diameter_m, speed_m_s=speed_m_s)
        rebounds, fine = [], (0.5 * dt_s / whole, dt_s / whole)
        ratios = [measure_rebounds(en=node, dt_s=dt_s, phases=1, **rig)[0].betan for node in NODES]
        for dt in (0.5 * dt_s, dt_s):
            rebounds.append(
                [
                    statistics.fmean(
                        r.restitution for r in measure_rebounds(en=en, betan=b, dt_s=dt, phases=PHASES, **rig)
                    )
                    for b in ratios
                ]
            )
        # rebound at (betan, fineness) = base + fineness * slope, both at the nodes; inverted over ln(rebound)
        low, high = (np.array(r) for r in rebounds)
        self._slope = (high - low) / (fine[1] - fine[0])
        self._base = low - fine[0] * self._slope
        self._ratios = ratios
        self._inverse: dict[int, list[float]] = {}

    def betan(self, e: float, fineness: float) -> float:
        """The damping ratio that gives the rebound ``e``; 0 for exactly 1."""
        if e == 1.0:
            return 0.0
        number = round(fineness / BIN)
        nodes = self._inverse.get(number)
        if nodes is None:
            nodes = self._inverse[number] = np.log(self._base + number * BIN * self._slope).tolist()
        x, ratios = math.log(e), self._ratios
        i = min(max(bisect.bisect(nodes, x), 1), len(nodes) - 1)
        share = (x - nodes[i - 1]) / (nodes[i] - nodes[i - 1])
        return max(ratios[i - 1] + share * (ratios[i] - ratios[i - 1]), 0.0)


class Spots:
    """Where the target was struck: counts earlier impacts within ``radius_m`` of a point, by a hashed grid."""

    def __init__(self, radius_m: float):
        self.radius2, self.size = radius_m**2, radius_m
        self._cells: dict[tuple, list] = defaultdict(list)

    def _cell(self, point) -> tuple[int, int, int]:
        return tuple(math.floor(c / self.size) for c in point)

    def count(self, point) -> int:
        i, j, k = self._cell(point)
        cells = self._cells
        return sum(
            math.dist(point, other) ** 2 <= self.radius2
            for a in (i - 1, i, i + 1)
            for b in (j - 1, j, j + 1)
            for c in (k - 1, k, k + 1)
            for other in cells.get((a, b, c), ())
        )

    def add(self, point) -> None:
        self._cells[self._cell(point)].append(tuple(point))


class Dashpots:
    """Gives every contact that begins its restitution: ``ImpactLogger``'s ``tune``."""

    def __init__(
        self,
        law: RestitutionLaw,
        e_shot: float,
        maps: dict[str, DashpotMap],
        media,
        target: Solid,
        bodies,
        dt_s: float,
    ):
        self.law, self.e_shot, self.maps, self.bodies, self.dt = law, e_shot, maps, bodies, dt_s
        self._on_target = [contact_modulus_Pa(m, target) for m in media]
        self._on_shot = [[contact_modulus_Pa(a, b) for a in media] for b in media]
        self.spots = Spots(law.spot_radius_m) if law.hardening else None

    def __call__(self, contact) -> None:
        if contact.on_target:
            (shot,) = contact.shots
            speed = -sum(v * n for v, n in zip(contact.vel, contact.normal))
            e = self.law.at(speed, shot.mass / (4.0 / 3.0 * math.pi * shot.radius**3))
            if self.spots:
                e = self.law.at_spot(e, self.spots.count(contact.point))
                self.spots.add(contact.point)
            mass, radius, modulus = shot.mass, shot.radius, self._on_target[shot.medium]
            ratios = self.maps["target"]
        else:
            a, b = contact.shots
            apart = [q - p for p, q in zip(self.bodies.place(a), self.bodies.place(b))]
            (v, _), (w, _) = self.bodies.motion(a), self.bodies.motion(b)
            speed = sum((p - q) * d for p, q, d in zip(v, w, apart)) / math.hypot(*apart)
            e = self.e_shot
            mass, radius = a.mass * b.mass / (a.mass + b.mass), a.radius * b.radius / (a.radius + b.radius)
            modulus, ratios = self._on_shot[a.medium][b.medium], self.maps["shot"]
        if speed > 0.0:  # else it grazes: the dashpot of ``en`` is as good as any
            whole = contact_time_s(mass, radius, modulus, speed)
            contact.phys.betan = ratios.betan(e, self.dt / whole)
