"""From a scene to what the event loop runs on: constants, entries, cells."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from glue.errors import InputError
from glue.flow import drag
from glue.flow.event_kernels import Physics
from glue.flow.event_state import Grid
from glue.flow.event_surface import Shape, shape_of
from glue.flow.jets import jet_rows
from glue.flow.restitution import RestitutionLaw
from glue.flow.surface import PLANE, TargetSurface

# Shots enter this many largest diameters upstream of the exit plane, as in YADE: rebounding shots meet the
# stream until they leave through the exit.
INLET_DIAMETERS = 1.25
# The guard against endless bouncing: a contact sooner than this many diameters of flight at nozzle speed
# after a shot's last one loses no energy across its normal.  Luding and McNamara (1998) take the duration of a
# contact; this is some hundredth of it, so that it leaves the collisions of a dense stream alone.
GUARD_DIAMETERS = 1e-3
# Between two kicks a shot's velocity changes by at most this share of the slowest nozzle's speed, its path bends
# off the straight stretch by at most this many diameters, and drag takes at most this share of its speed against
# the gas.  Against the differential equation, .05 mm glass to 5 mm steel, 1 to 300 m/s, 100 mm: speed at the
# target within 7e-5, time of flight within 5e-5 (twice the numbers: 1.4e-4, 1.0e-4).
KICK_LOSS, KICK_BEND, KICK_SHARE = 0.02, 0.05, 0.05
# Cells, measured at 60 m/s, 1 mm, 20 mm jet, 100 mm: processor seconds per peening second at 5, 10, 20, 40 and
# 100 kg/min (peak of 127, 227, 372, 606 and 1270 live shots): one cell .10, .33, 1.3, 4.7 and far more; these
# cells .25 at 10, then .60, 1.5 and 6.9.  Twice or half as many shots per cell or the stretch: within 20 %.
ALL_PAIRS_BELOW = 150  # expected live shots; fewer stand in one cell
SHOTS_PER_CELL = 1.0
STRETCH = 8.0  # length over width of a cell along the jet: shots fly that way, crossings are rarer
MAX_CELLS = 1 << 20
ONE_CELL = Grid(0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1, 1, 1)


SWEEPS_PER_FLIGHT = 10.0  # looks over all shots (who can be dropped?) in the time from nozzle to target
SWEEPS_PER_LEG = 100  # so long the jets count as at rest when shots are dropped
TAIL_FLIGHTS = 20.0  # give up on slow stragglers after this many flights of the stand-off at nozzle speed


class Plan(NamedTuple):
    """All that stays the same during a run; times in s."""

    arrivals: np.ndarray  # in the order in which they enter
    enter_s: np.ndarray
    physics: Physics
    shape: Shape
    grid: Grid
    start_s: float
    fed_s: float  # the last shot has flown to the target
    end_s: float  # at the latest
    sweep_s: float  # between two sweeps
    jet_margin: float
    body_m: float  # how far the target reaches below z = 0 along the jets

    def leg_ends_s(self, leg: int) -> float:
        """The run is cut into legs, in each of which the jets count as at rest."""
        return min(self.start_s + (leg + 1) * SWEEPS_PER_LEG * self.sweep_s, self.end_s)

    def jets(self, scene, leg: int) -> np.ndarray:
        """The jets in the middle of a leg, rows of ``jets.jet_rows``."""
        middle = self.start_s + (leg + 0.5) * SWEEPS_PER_LEG * self.sweep_s
        middle = min(max(middle, 0.0), scene.exposure_time_s)
        return np.array(jet_rows(scene, middle, self.jet_margin, self.body_m))


def plan_run(scene, arrivals, law: RestitutionLaw, surface: TargetSurface, grid, jet_margin: float) -> Plan:
    """What ``event_driven.run_event`` needs to know. Raises InputError for no arrivals."""
    if not len(arrivals):
        raise InputError("no shot leaves the nozzle: raise exposure_time_s or mass_flow_kg_s")
    odd = [name for name in arrivals.dtype.names if not np.isfinite(arrivals[name]).all()]
    if odd:
        raise InputError(f"arrivals: {', '.join(odd)}: every number must be finite")
    enter_s, arrivals = entries(arrivals)
    flights_s = [n.stand_off_m / n.speed_m_s for n in scene.nozzles]
    fed_s = float(arrivals["time_s"].max()) + max(flights_s)
    return Plan(
        arrivals=arrivals,
        enter_s=enter_s,
        physics=physics_of(scene, law, surface),
        shape=shape_of(surface),
        grid=grid or choose_grid(scene, arrivals),
        start_s=float(enter_s[0]),
        fed_s=fed_s,
        end_s=fed_s + TAIL_FLIGHTS * max(flights_s),
        sweep_s=min(flights_s) / SWEEPS_PER_FLIGHT,
        jet_margin=jet_margin,
        body_m=-surface.lowest_m / min(abs(n.direction[2]) for n in scene.nozzles),
    )


def entries(arrivals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(times [s] at which the shots enter, ascending; the arrivals in that order)."""
    speed = np.sqrt(sum(arrivals[v] ** 2 for v in ("vx_m_s", "vy_m_s", "vz_m_s")))
    enter_s = arrivals["time_s"] - INLET_DIAMETERS * arrivals["diameter_m"].max() / speed
    order = np.argsort(enter_s, kind="stable")
    return enter_s[order], arrivals[order]


def physics_of(scene, law: RestitutionLaw, surface: TargetSurface) -> Physics:
    """The constants of a run of ``scene``; an "auto" block of it counts as present."""
    around = drag.surroundings(scene)
    pull = around[5:]
    bends = surface.kind == PLANE  # the other shapes know straight flight only
    if bends:
        around = around._replace(gravity_x_m_s2=0.0, gravity_y_m_s2=0.0, gravity_z_m_s2=0.0)
    kicked = around.gas_density_kg_m3 > 0.0 or any(around[5:])
    hardening = law.hardening
    return Physics(
        e_shots=float(scene.restitution.shot_shot),
        mu_shots=float(scene.friction.shot_shot),
        e_target=float(law.e),
        e_speed_m_s=float(law.speed_m_s),
        e_exponent=float(law.exponent),
        e_largest=float(law.largest),
        e_logs=law.logs,
        e_density_kg_m3=float(law.density_kg_m3),
        mu_target=float(scene.friction.shot_target),
        saturated=float(hardening.saturated) if hardening else 0.0,
        hits=float(hardening.hits) if hardening else 1.0,
        spot_radius_m=float(law.spot_radius_m) if hardening else 0.0,
        elastic_within_s=GUARD_DIAMETERS * scene.smallest_diameter_m / scene.fastest_m_s,
        gravity=pull if bends else (0.0, 0.0, 0.0),
        pull=pull,
        kick_loss_m_s=KICK_LOSS * min(n.speed_m_s for n in scene.nozzles) if kicked else math.inf,
        kick_bend=KICK_BEND if kicked else math.inf,
        kick_share=KICK_SHARE,
        around=drag.Surroundings(*(float(x) for x in around)),
        compliance=np.array([(1.0 - shots.nu**2) / shots.E_Pa for shots in scene.media]),
    )


def choose_grid(scene, arrivals: np.ndarray) -> Grid:
    """Cells that hold about one shot each over all the jets, longer along them; one cell for a thin stream."""
    span = max(float(np.ptp(arrivals["time_s"])), 1e-12)
    flight = max(n.stand_off_m / n.speed_m_s for n in scene.nozzles)
    rate = min(len(arrivals) / span, 2.0 * scene.shot_rate_1_s)
    expected = min(2.5 * rate * flight, len(arrivals))  # rebounding shots stay longer than falling ones
    if expected < ALL_PAIRS_BELOW:
        return ONE_CELL
    start = np.array([arrivals[name] for name in ("x_m", "y_m", "z_m")])
    velocity = np.array([arrivals[name] for name in ("vx_m_s", "vy_m_s", "vz_m_s")])
    landing = start - velocity * (start[2] / velocity[2])
    low = np.minimum(start.min(axis=1), landing.min(axis=1))
    size = np.maximum(start.max(axis=1), landing.max(axis=1)) - low
    across = math.pi / 4.0 * sum(n.jet_diameter_m**2 * n.stand_off_m for n in scene.nozzles)
    shape = 1.0 + (STRETCH - 1.0) * np.abs(scene.nozzle.direction)
    width = (SHOTS_PER_CELL * across / expected / shape.prod()) ** (1.0 / 3.0)
    edges = np.maximum(width * shape, 1.01 * float(arrivals["diameter_m"].max()))
    while (counts := np.maximum(np.ceil(size / edges), 1.0)).prod() > MAX_CELLS:
        edges *= 1.2
    return Grid(*low.tolist(), *edges.tolist(), *(int(n) for n in counts))
