"""The scene: what is peened with what, in SI units. Plain data; reading and checking live in ``reader.py``.

Axes: the target's surface is z = 0 with the target below (a curved target touches it at the origin from
below).  A jet's axis meets z = 0 at ``aim_m`` and leans by the impact angle a, measured from the surface (90
degrees = normal), towards the azimuth p: shots fly along (cos a cos p, cos a sin p, -sin a).  The window is
centred on the origin.  Standard library only: YADE's interpreter imports this too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from glue.scene import sizes
from glue.scene.asked import Measured, Specification
from glue.scene.effects import AirDrag, Gravity, StrainRate, Switch
from glue.scene.laws import CombinedHardening, HardeningTable, JohnsonCook, Material  # noqa: F401 - the laws' home
from glue.scene.presets import Accuracy


@dataclass(frozen=True)
class Shots:
    """One medium of the stream. ``size`` is "mono", "distribution" or "sieve", see ``sizes.py``."""

    grade: str | None
    diameter_m: float  # mean over the shots
    density_kg_m3: float
    E_Pa: float
    nu: float
    size: str
    size_cv: float
    medium: str
    source: str
    evidence: str  # evidence grade of the numbers, as for materials
    mass_fraction: float = 1.0  # of all media together
    sieve: tuple[tuple[float, float], ...] = ()  # (opening [m], mass share finer), 0 .. 1, from fine to coarse

    @property
    def mean_mass_kg(self) -> float:
        """Mean mass of one shot [kg]."""
        return self.density_kg_m3 * math.pi / 6.0 * sizes.mean_cube_m3(self)


@dataclass(frozen=True)
class Feed:
    """A nozzle that travels to and fro: ``passes`` strokes through the aim point, side by side by ``pitch_m``.

    It shoots all the time, also while it dwells at the end of every stroke but the last.
    """

    speed_m_s: float
    stroke_m: float
    passes: int = 1
    pitch_m: float = 0.0
    dwell_s: float = 0.0
    direction_deg: float = 0.0  # of the first stroke, from +x; the pitch is across, to its left

    @property
    def duration_s(self) -> float:
        return self.passes * self.stroke_m / self.speed_m_s + (self.passes - 1) * self.dwell_s

    def at(self, time_s: float) -> tuple[float, float, int]:
        """(x, y) [m] of the nozzle relative to its middle, and the pass (0, 1, …), at ``time_s`` after its start."""
        stroke_s = self.stroke_m / self.speed_m_s
        number = min(int(time_s / (stroke_s + self.dwell_s)), self.passes - 1)
        along = self.speed_m_s * min(time_s - number * (stroke_s + self.dwell_s), stroke_s) - 0.5 * self.stroke_m
        if number % 2:
            along = -along
        across = (number - 0.5 * (self.passes - 1)) * self.pitch_m
        c, s = math.cos(math.radians(self.direction_deg)), math.sin(math.radians(self.direction_deg))
        return along * c - across * s, along * s + across * c, number


@dataclass(frozen=True)
class Pulse:
    """A mass flow that changes in time about its mean: "pulsed" (on for ``duty`` of each period) or "sinusoidal"."""

    pattern: str
    frequency_Hz: float
    duty: float = 1.0  # pulsed: share of the period, from its beginning, in which shots flow
    amplitude: float = 0.0  # sinusoidal: 1 + amplitude sin(2 pi f t)

    @property
    def peak(self) -> float:
        """Largest flow over the mean."""
        return 1.0 / self.duty if self.pattern == "pulsed" else 1.0 + self.amplitude


@dataclass(frozen=True)
class Nozzle:
    """One jet: ``jet_diameter_m`` wide where it leaves, ``stand_off_m`` along its axis before ``aim_m``."""

    speed_m_s: float
    mass_flow_kg_s: float  # mean over time
    jet_diameter_m: float
    stand_off_m: float
    impact_angle_deg: float
    azimuth_deg: float = 0.0
    aim_m: tuple[float, float] = (0.0, 0.0)  # where the axis meets z = 0; with a feed, in the middle of its path
    profile: str = "uniform"  # over the exit; "gaussian": sd a quarter of the diameter, cut at the edge
    divergence_half_angle_deg: float = 0.0  # of the shots at the exit's edge; in proportion inside
    speed_cv: float = 0.0  # truncated normal, cut as sizes are
    feed: Feed | None = None
    pulse: Pulse | None = None

    @property
    def direction(self) -> tuple[float, float, float]:
        """Unit vector of flight along the axis, shape (3,)."""
        a, p = math.radians(self.impact_angle_deg), math.radians(self.azimuth_deg)
        flat = math.cos(a) if self.impact_angle_deg != 90.0 else 0.0
        return (flat * math.cos(p), flat * math.sin(p), -math.sin(a))

    @property
    def exit_axes(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """Two unit vectors that span the exit plane: in the plane of the lean (upwards), and level."""
        a, p = math.radians(self.impact_angle_deg), math.radians(self.azimuth_deg)
        flat = math.cos(a) if self.impact_angle_deg != 90.0 else 0.0
        c, s = math.cos(p), math.sin(p)
        return (math.sin(a) * c, math.sin(a) * s, flat), (-s, c, 0.0)

    @property
    def normal_speed_m_s(self) -> float:
        return self.speed_m_s * math.sin(math.radians(self.impact_angle_deg))

    @property
    def fastest_m_s(self) -> float:
        """Largest speed [m/s] with which a shot can leave."""
        return self.speed_m_s * (1.0 + sizes.CUT_SD * self.speed_cv)

    def aim_at(self, time_s: float) -> tuple[float, float, int]:
        """(x, y) [m] where the axis meets z = 0 at ``time_s``, and the number of the pass."""
        if self.feed is None:
            return (*self.aim_m, 0)
        x, y, number = self.feed.at(time_s)
        return self.aim_m[0] + x, self.aim_m[1] + y, number

    @property
    def footprint_semi_axes_m(self) -> tuple[float, float]:
        """Semi-axes [m] of the jet's footprint on z = 0, along the lean and across; divergence to first order."""
        sine = math.sin(math.radians(self.impact_angle_deg))
        r = 0.5 * self.jet_diameter_m + self.stand_off_m * math.tan(math.radians(self.divergence_half_angle_deg))
        return (r / sine, r)

    @property
    def footprint_area_m2(self) -> float:
        a, b = self.footprint_semi_axes_m
        return math.pi * a * b


@dataclass(frozen=True)
class Surface:
    """Shape of the target's surface. A "cylinder" is convex, of ``radius_m``, its axis level and along ``axis``."""

    kind: str = "plane"  # "plane", "cylinder", "stl"
    radius_m: float | None = None  # of a "cylinder"
    axis: str = "y"  # "x" or "y"
    file: str = ""  # of an "stl", as written in the scene
    sha256: str = ""  # of its content


@dataclass(frozen=True)
class Target:
    material: Material
    window_m: tuple[float, float]  # size in x and y, centred on the origin
    thickness_m: float | None = None  # of a free plate; None: too thick to stretch or bend
    surface: Surface = Surface()
    # Before peening: (depth [m], in-plane stress [Pa]) with depth rising, and (Sa, wavelength) [m].
    initial_stress: tuple[tuple[float, float], ...] = ()
    initial_roughness: tuple[float, float] | None = None

    @property
    def window_area_m2(self) -> float:
        return self.window_m[0] * self.window_m[1]


@dataclass(frozen=True)
class SpotHardening:
    """Restitution that rises where shots struck before: e_n = saturated - (saturated - e) exp(-n / hits).

    n counts the earlier impacts within one dimple radius.
    """

    saturated: float
    hits: float


@dataclass(frozen=True)
class Restitution:
    shot_target: float | str  # a number or "from_dimple"
    shot_shot: float
    hardening: SpotHardening | None = None


@dataclass(frozen=True)
class Friction:
    shot_target: float
    shot_shot: float
    in_dimple: bool = False  # shot_target also acts while the shot presses its dimple


@dataclass(frozen=True)
class Choice:
    """A model and why: printed and stored, so that no choice is silent."""

    model: str
    why: str


@dataclass(frozen=True)
class Models:
    flow: Choice
    dimple: Choice
    target: Choice


@dataclass(frozen=True)
class Scene:
    name: str
    seed: int
    exposure_time_s: float
    media: tuple[Shots, ...]
    nozzles: tuple[Nozzle, ...]
    target: Target
    restitution: Restitution
    friction: Friction
    models: Models
    accuracy: Accuracy
    arrivals: str = "poisson"  # or "exact_mass": the mass fed is right to one shot, times evenly random
    gravity: Gravity | None = None
    air_drag: AirDrag | None = None
    strain_rate: StrainRate | None = None
    target_inertia: Switch | None = None
    elastic_shot: Switch | None = None
    measured: Measured | None = None
    specification: Specification | None = None
    # For printing: what followed from the specification, with uncertainty, and "key = value (source)" of each default.
    inferred: tuple[str, ...] = field(default=(), compare=False)
    defaults_used: tuple[str, ...] = field(default=(), compare=False)

    @property
    def shots(self) -> Shots:
        """The leading medium: the one with the largest share of the mass."""
        return max(self.media, key=lambda shots: shots.mass_fraction)

    @property
    def nozzle(self) -> Nozzle:
        """The first nozzle."""
        return self.nozzles[0]

    @property
    def mass_flow_kg_s(self) -> float:
        """Mean mass flow of all nozzles together."""
        return sum(nozzle.mass_flow_kg_s for nozzle in self.nozzles)

    @property
    def shots_per_kg(self) -> float:
        """Mean number of shots in a kilogram of the mixture."""
        return sum(shots.mass_fraction / shots.mean_mass_kg for shots in self.media)

    @property
    def shot_rate_1_s(self) -> float:
        """Mean number of shots leaving the nozzles per second."""
        return self.mass_flow_kg_s * self.shots_per_kg

    @property
    def smallest_diameter_m(self) -> float:
        return min(sizes.smallest_m(shots) for shots in self.media)

    @property
    def largest_diameter_m(self) -> float:
        return max(sizes.largest_m(shots) for shots in self.media)

    @property
    def fastest_m_s(self) -> float:
        """Largest speed [m/s] with which a shot can leave a nozzle."""
        return max(nozzle.fastest_m_s for nozzle in self.nozzles)

    @property
    def expected_shots(self) -> float:
        return self.shot_rate_1_s * self.exposure_time_s
