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
from glue.scene.asked import Machine, MachineCurve, MachineLaw, Measured, Specification  # noqa: F401 - their home
from glue.scene.laws import CombinedHardening, HardeningTable, JohnsonCook, Material  # noqa: F401 - the laws' home


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
    initial_stress: tuple[tuple[float, float], ...] = ()  # (depth [m], in-plane stress [Pa]) before peening, depth rising
    initial_roughness: tuple[float, float] | None = None  # (Sa, wavelength) [m] before peening

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
class Gravity:
    acceleration_m_s2: float
    direction: tuple[float, float, float] = (0.0, 0.0, -1.0)  # unit vector
    auto: bool = False  # model it only where its regime number says that it matters

    @property
    def vector(self) -> tuple[float, float, float]:
        return tuple(self.acceleration_m_s2 * c for c in self.direction)


@dataclass(frozen=True)
class AirDrag:
    """Gas that slows the shots: drag of a sphere by Schiller-Naumann against gas blowing along the jet's axis."""

    gas_density_kg_m3: float
    gas_viscosity_Pa_s: float
    gas_speed_m_s: float = 0.0  # along the axis of the first nozzle, everywhere
    auto: bool = False


@dataclass(frozen=True)
class StrainRate:
    """The target's flow stress rises with the rate of strain, and with ``thermal`` falls as plastic work heats it."""

    thermal: bool = False
    auto: bool = False  # model it only where its regime number says that it matters


@dataclass(frozen=True)
class Switch:
    """Physics without numbers of its own: a block that is there, or "auto"."""

    auto: bool = False


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
class Accuracy:
    """A preset expanded to the numbers it stands for (see ``presets.py``), with those that the scene states itself in
    their place: numerics only, never physics."""

    preset: str
    flow_tolerance: float  # error of mean normal energy and collided share that auto may accept of a flow model
    flow_dt_over_P: float  # time step over the P-wave step of the smallest shot
    flow_stiffness_scale: float  # Young's moduli of the contact flow over the materials' own
    dimple_elements_per_radius: int  # a/h at the surface, a the expected dimple radius
    dimple_steps_per_contact: float  # time steps per expected contact time
    dimple_speeds: int  # solved, from the reference speed down; a faster one that a nozzle can shoot comes on top
    cell_side_in_radii: float  # periodic cell side over dimple radius
    cell_elements_per_side: int
    cell_load_steps: int  # penetration steps of one impact
    cell_force_tolerance: float  # out-of-balance forces over the contact force
    coverage_points_per_radius: float  # raster points per dimple radius
    stamp_points_per_radius: float
    target_patches: int = 1  # of the window, solved one after another by the cell or the block
    dimple_speed_ratio: float = 0.0  # the dimple lies between impacts at its powers, so that scenes share them; 0: its own impact


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
    inferred: tuple[str, ...] = field(default=(), compare=False)  # what followed from it, with uncertainty, for printing
    defaults_used: tuple[str, ...] = field(default=(), compare=False)  # "key = value (source)" for printing

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
