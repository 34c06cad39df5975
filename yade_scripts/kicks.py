"""Air drag and gravity on free shots: kicks of the velocity between stretches of straight flight.

The scheme is that of ``glue.flow.drag``: every flight begins with a kick of half of what is left to the next
common kick, then all free shots are kicked together; the velocity of a stretch is the true one in its middle.
A shot in contact is not kicked (a contact lasts microseconds); it catches up with its next kick.
"""

from __future__ import annotations

import math

from flight import Flying
from glue.flow import drag
from glue.flow.arrivals import COLUMNS

_SIZE = [COLUMNS.names.index(n) for n in ("diameter_m", "density_kg_m3")]


class Kicks:
    """Kicks every ``stride`` steps what ``mover`` moves; without drag and gravity ``stride`` is None."""

    def __init__(self, scene, mover, dt_s: float):
        self.around = drag.surroundings(scene)
        self.mover, self.dt = mover, dt_s
        interval = drag.kick_interval_s(scene)
        self.stride = None if interval == math.inf else max(1, int(interval / dt_s))
        self.work_J = 0.0  # done on the shots, negative where they were slowed

    def next_step(self, step: int) -> float:
        """The step of the next kick after ``step``."""
        return math.inf if self.stride is None else (step // self.stride + 1) * self.stride

    def begin(self, shot: Flying, now: float) -> None:
        """``shot`` begins to fly freely at ``now``, its velocity true at ``true_at``."""
        if self.stride is not None:
            end = self.next_step(math.floor(now / self.dt + 0.5)) * self.dt
            self._to(shot, 0.5 * (now + end))

    def all(self) -> None:
        """Kick every free shot; the step is one of ``next_step``'s."""
        fleet, now = self.mover.fleet, self.mover.logger.clock()
        middle = now + 0.5 * self.stride * self.dt
        for shot in fleet.shots:
            if not shot.open:
                shot.pos, shot.t = shot.at(now), now
                self._to(shot, middle)
                fleet.renew(shot)
        self.mover.renew_all(now)

    def _to(self, shot: Flying, moment: float) -> None:
        """Make the velocity that of ``moment``."""
        before = shot.energy_J()
        size = (shot.arrival[i] for i in _SIZE)
        shot.vel = drag.slowed(*shot.vel, moment - shot.true_at, *size, self.around)
        shot.true_at = moment
        shot.start_speed = max(shot.start_speed, math.hypot(*shot.vel))
        self.work_J += shot.energy_J() - before
