"""Shots in and out of the simulation: in before the nozzle's exit, out when they can no longer matter."""

from __future__ import annotations

import math

import numpy as np
from yade import O

from glue.flow import jets
from flight import Fleet, Flying, FlowFailed
from impact_logger import ImpactLogger

# Shots are inserted this many (largest) diameters upstream of the exit plane, where rebounding shots are
# dropped, so that no shot can appear inside one that leaves.
INLET_DIAMETERS = 1.25


class Stream:
    """The shots of ``arrivals`` (``glue.flow.arrivals.COLUMNS``), fed and removed as time goes on.

    A shot is dropped when in straight flight it meets no jet any more, see ``glue.flow.jets``; falling ones are
    kept until they strike (or are far beside), so impacts beside the jets are in the log.
    """

    def __init__(self, scene, arrivals: np.ndarray, mover, dt_s: float, jet_margin: float = jets.JET_MARGIN):
        self.arrivals, self.mover = arrivals, mover
        self.fleet: Fleet = mover.fleet
        self.logger: ImpactLogger = mover.logger
        self.target = mover.bodies.target
        self._jets = [], math.nan
        self._jets_at = lambda now: jets.jet_rows(scene, max(now, 0.0), jet_margin, self.target.below_m)
        self._moving = any(nozzle.feed for nozzle in scene.nozzles)
        self.next = 0
        self.dropped = dict.fromkeys((*jets.REASONS[1:], "inlet"), 0)
        self.never_struck = 0
        self.energy_in_J = self.energy_out_J = 0.0  # kinetic, of the shots fed and dropped
        self.mass_in_kg = 0.0
        self.peak_live = 0
        speed = np.sqrt(sum(arrivals[c] ** 2 for c in ("vx_m_s", "vy_m_s", "vz_m_s")))
        lead_s = INLET_DIAMETERS * arrivals["diameter_m"].max(initial=0.0) / speed
        # step on which each shot is placed: the first whose time is not before it enters the simulation
        self.steps = np.ceil((arrivals["time_s"] - lead_s) / dt_s).astype(np.int64)
        self.order = np.argsort(
            self.steps, kind="stable"
        )  # a slow shot enters before a fast one that leaves first
        # time is 0 when the first shot could cross the exit plane
        self.first_step = self.logger.step = -math.ceil(lead_s.max(initial=0.0) / dt_s)

    def steps_to_next(self) -> int | None:
        """Steps until the next shot enters, None when all have."""
        if self.next == len(self.arrivals):
            return None
        return int(self.steps[self.order[self.next]]) - self.logger.step

    def feed(self) -> None:
        """Place every shot that is due, each exactly where its flight through the exit plane has it now."""
        now = self.logger.clock()
        while (wait := self.steps_to_next()) is not None and wait <= 0:
            shot = Flying(self.arrivals[self.order[self.next]].item())
            self._clear_inlet(shot, now)
            self.energy_in_J += shot.energy_J()
            self.mass_in_kg += shot.mass
            self.mover.add(shot)
            self.next += 1
        self.peak_live = max(self.peak_live, len(self.fleet.shots))

    def _clear_inlet(self, new: Flying, now: float) -> None:
        """Drop what still blocks the inlet: a shot thrown back into the nozzle that has not left it yet."""
        if not self.fleet.shots:
            return
        for shot in self.fleet.near(new.at(now), new.radius, 0.0, now):
            # Fresh shots of other speeds or directions may overlap up here; at the exit they do not.
            if shot.collisions or shot.impacts:
                self._drop(shot, jets.REASONS[self._fate(shot, now)] or "inlet")
        for contact in self.logger.open.values():
            for shot in contact.shots:
                if math.dist(O.bodies[shot.body].state.pos, new.at(now)) <= new.radius + shot.radius:
                    raise FlowFailed(
                        f"shot {new.shot_id} enters the nozzle inside shot {shot.shot_id},"
                        " which is in contact there: the stream is too dense"
                    )

    def drop(self) -> None:
        """Remove the shots that can no longer matter."""
        fleet = self.fleet
        if not fleet.shots:
            return
        now = self.logger.clock()
        place, outside = fleet.at(now), fleet.free.copy()
        rising = self.target.leaving(fleet.vel)
        for row in self._rows(now):
            axis = np.array(row[3:6])
            off = place - np.array(row[:3])[:, None]
            s = axis @ off
            off2 = np.einsum("ij,ij->j", off, off) - s * s
            beside = (off2 > np.maximum(row[6] + s * row[7], 0.0) ** 2) | (s < 0.0) | (s > row[9])
            outside &= beside & (rising | (off2 > row[8] ** 2))
        for shot in [fleet.shots[i] for i in outside.nonzero()[0].tolist()]:
            if fate := self._fate(shot, now):
                self._drop(shot, jets.REASONS[fate])

    def _rows(self, now: float) -> list[tuple]:
        if self._jets[1] != now and (self._moving or not self._jets[0]):
            self._jets = self._jets_at(now), now
        return self._jets[0]

    def _fate(self, shot: Flying, now: float) -> int:
        """Of a free shot, as ``jets.fate``."""
        leaves = self.target.landing(shot, now) == math.inf
        return jets.fate(*shot.at(now), *shot.vel, leaves, self._rows(now))

    def _drop(self, shot: Flying, why: str) -> None:
        self.dropped[why] += 1
        self.never_struck += shot.impacts == 0
        self.energy_out_J += shot.energy_J()
        self.mover.remove(shot)

    def energy_left(self, work_J: float = 0.0) -> float:
        """Kinetic energy of all shots at their last free flight over what they left the nozzle with.

        ``work_J`` was done on them on the way.
        """
        left = self.energy_out_J + sum(s.energy_J() for s in self.fleet.shots)
        return left / (self.energy_in_J + max(work_J, 0.0))

    def falling(self) -> int:
        """Number of live shots that are yet to strike the target or are in contact."""
        now = self.logger.clock()
        return sum(1 for s in self.fleet.shots if s.open or self.target.landing(s, now) < math.inf)
