"""Shots in and out of the simulation: in before the nozzle's exit, out when they can no longer matter.

Bodies are recycled by moving them, because YADE never reuses the id of an erased one and insertion
gets slower with every id used.  A body without a shot is parked far away under another group mask:
the integrator skips it, the collider finds it no partner.
"""

from __future__ import annotations

import math

import numpy as np
from yade import O

from contact_model import LIVE, PARKED, add_shot, look_for_partners
from impact_logger import Flying, FlowFailed, ImpactLogger

# Shots are inserted this many (largest) diameters upstream of the exit plane, where rebounding shots are
# dropped, so that no shot can appear inside one that leaves.
INLET_DIAMETERS = 1.25
# Rising shots outside the jet by this many jet radii are dropped, see Stream.  Measured at 5 kg/min (1 mm,
# 60 m/s, e .6, 2100 shots): .2, 1, 3 and 10 jet radii give 1.0572, 1.0576, 1.0576 and 1.0572 impacts per
# shot, mean normal energy .727 and collided share .247 in all, so what this loses is below what chance does.
JET_MARGIN_RADII = 0.5
# Shots this many stand-offs beside the jet are dropped even when falling: 1 m off where the window is a few
# millimetres.  At 3 stand-offs 4 % of the shots went this way, at 10 it is .8 %.
FAR_STAND_OFFS = 10.0


class Stream:
    """The shots of ``arrivals`` (``glue.flow.arrivals.COLUMNS``), fed and removed as time goes on.

    A shot is dropped when, in straight flight, it can meet neither the stream nor the target again:

    - *out of the exit*: it flies upstream through the nozzle's exit plane, where no shot has yet been;
    - *beside the jet*: its distance from the jet's axis exceeds the jet's radius by ``JET_MARGIN_RADII`` of
      it and grows (in straight flight it then grows for ever), and it does not fall towards the target;
    - *far*: falling, but more than ``FAR_STAND_OFFS`` stand-offs from the axis and moving away.

    Falling shots nearer than that are kept until they strike, so impacts beside the jet are in the log.
    Only collisions among dropped shots, both of which have left the stream, are lost.
    """

    def __init__(
        self,
        scene,
        arrivals: np.ndarray,
        logger: ImpactLogger,
        material: int,
        dt_s: float,
        jet_margin_radii: float = JET_MARGIN_RADII,
    ):
        self.arrivals, self.logger, self.material = arrivals, logger, material
        nozzle = scene.nozzle
        self.direction = nozzle.direction
        self.stand_off = nozzle.stand_off_m
        self.beside2 = (0.5 * nozzle.jet_diameter_m * (1.0 + jet_margin_radii)) ** 2
        self.far2 = (0.5 * nozzle.jet_diameter_m + FAR_STAND_OFFS * nozzle.stand_off_m) ** 2
        self.next = 0
        self.parked: list[int] = []
        self.dropped = {"exit": 0, "beside": 0, "far": 0, "inlet": 0}
        self.never_struck = 0
        self.energy_in_J = self.energy_out_J = 0.0  # kinetic, of the shots fed and dropped
        self.peak_live = 0
        diameters = arrivals["diameter_m"]
        lead_s = INLET_DIAMETERS * diameters.max(initial=0.0) / nozzle.speed_m_s
        # step on which each shot is placed: the first whose time is not before it enters the simulation
        self.steps = np.ceil((arrivals["time_s"] - lead_s) / dt_s).astype(np.int64)
        # time is 0 when the first shot could cross the exit plane
        self.first_step = logger.step = -math.ceil(lead_s / dt_s)

    def steps_to_next(self) -> int | None:
        """Steps until the next shot enters, None when all have."""
        return int(self.steps[self.next]) - self.logger.step if self.next < len(self.arrivals) else None

    def feed(self) -> None:
        """Place every shot that is due, each exactly where its flight through the exit plane has it now."""
        now, first = self.logger.clock(), self.next
        while (wait := self.steps_to_next()) is not None and wait <= 0:
            arrival = self.arrivals[self.next]
            shot = self._place(arrival, now)
            self._clear_inlet(shot, now)
            self.logger.add(shot)
            self.energy_in_J += shot.energy_J()
            self.next += 1
        if self.next > first:
            look_for_partners()
        self.peak_live = max(self.peak_live, len(self.logger.live))

    def _place(self, arrival, now: float) -> Flying:
        diameter, density = float(arrival["diameter_m"]), float(arrival["density_kg_m3"])
        mass = density * math.pi / 6.0 * diameter**3
        if not self.parked:
            self.parked.append(add_shot(self.material, diameter, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
        body = O.bodies[self.parked.pop()]
        shot = Flying(arrival, body.id, mass)
        body.mask = LIVE
        body.shape.radius = 0.5 * diameter
        state = body.state
        state.mass = mass
        state.inertia = (0.1 * mass * diameter**2,) * 3
        state.pos, state.vel = shot.at(now), shot.vel
        state.angVel = state.angMom = (0.0, 0.0, 0.0)
        return shot

    def _clear_inlet(self, new: Flying, now: float) -> None:
        """Drop what still blocks the inlet: a shot thrown back into the nozzle that has not left it yet."""
        x, y, z = new.at(now)
        for shot in list(self.logger.live.values()):
            p = O.bodies[shot.body].state.pos if shot.open else shot.at(now)
            if math.dist(p, (x, y, z)) <= new.radius + shot.radius:
                if shot.open:
                    raise FlowFailed(
                        f"shot {new.shot_id} enters the nozzle inside shot {shot.shot_id},"
                        " which is in contact there: the stream is too dense"
                    )
                self._park(shot, "inlet")

    def drop(self) -> None:
        """Remove the shots that can no longer matter."""
        now = self.logger.clock()
        dx, _, dz = self.direction  # lies in the x-z plane
        for shot in list(self.logger.live.values()):
            if shot.open:
                continue
            x, y, z = shot.at(now)
            u, v, w = shot.vel
            upstream, drift = -(x * dx + z * dz), u * dx + w * dz
            qx, qz = x + upstream * dx, z + upstream * dz  # vector from the jet's axis
            off2, leaving = qx * qx + y * y + qz * qz, qx * u + y * v + qz * w > 0.0
            if drift < 0.0 and upstream > self.stand_off:
                self._park(shot, "exit")
            elif leaving and off2 > self.beside2 and w >= 0.0:
                self._park(shot, "beside")
            elif leaving and off2 > self.far2:
                self._park(shot, "far")

    def _park(self, shot: Flying, why: str) -> None:
        self.check_flight(shot)
        self.dropped[why] += 1
        self.never_struck += shot.impacts == 0
        self.energy_out_J += shot.energy_J()
        self.logger.remove(shot)
        body = O.bodies[shot.body]
        body.mask = PARKED
        body.state.pos = (1e3 + shot.body, 0.0, 1e3)
        body.state.vel = body.state.angVel = (0.0, 0.0, 0.0)
        self.parked.append(shot.body)

    def check_flight(self, shot: Flying) -> None:
        """A free shot must fly as its last contact left it: else a contact was missed. Raises FlowFailed."""
        state = O.bodies[shot.body].state
        if tuple(state.vel) != shot.vel:
            raise FlowFailed(
                f"shot {shot.shot_id} changed its velocity without a logged contact at t ="
                f" {self.logger.clock():.6g} s ({shot.vel} to {tuple(state.vel)})"
            )
        off = math.dist(state.pos, shot.at(self.logger.clock()))
        if not off < 1e-3 * shot.radius:
            raise FlowFailed(f"shot {shot.shot_id} is {off:.3g} m off its straight flight")

    def audit(self) -> None:
        """Every live shot: finite, above the plane, in undisturbed flight unless in contact."""
        for shot in self.logger.live.values():
            z = O.bodies[shot.body].state.pos[2]
            if not 0.0 < z < math.inf:
                raise FlowFailed(f"shot {shot.shot_id} is below the target's surface or lost (z = {z:.4g} m)")
            if not shot.open:
                self.check_flight(shot)

    def energy_left(self) -> float:
        """Kinetic energy of all shots at their last free flight over what they left the nozzle with."""
        return (self.energy_out_J + sum(s.energy_J() for s in self.logger.live.values())) / self.energy_in_J

    def falling(self) -> int:
        """Number of live shots that still fly towards the target or are in contact."""
        return sum(1 for s in self.logger.live.values() if s.open or s.vel[2] < 0.0)
