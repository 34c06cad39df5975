"""The scene: what is peened with what, in SI units. Plain data; reading and checking live in ``reader.py``.

Axes: the target's surface is z = 0 with the target below; the jet axis meets it at the origin and
leans in the x-z plane, so that shots fly along (cos a, 0, -sin a), a the impact angle measured from
the surface (90 degrees = normal).  Standard library only: YADE's interpreter imports this too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

TRUNCATION_SD = 2.5  # a size distribution is a normal one cut at this many standard deviations on either side
# Variance of that distribution over sd^2: 1 - 2 c phi(c) / (2 Phi(c) - 1).
TRUNCATED_VARIANCE = 1.0 - 2.0 * TRUNCATION_SD * math.exp(-0.5 * TRUNCATION_SD**2) / math.sqrt(2.0 * math.pi) / math.erf(
    TRUNCATION_SD / math.sqrt(2.0)
)

@dataclass(frozen=True)
class JohnsonCook:
    """Flow stress (A + B p^n)(1 + C ln(rate/rate_ref)); the rate term is carried, not yet used."""

    A_Pa: float
    B_Pa: float
    n: float
    C: float = 0.0
    rate_ref_1_s: float = 1.0

    def flow_stress_Pa(self, p):
        """Quasi-static flow stress [Pa] at equivalent plastic strain ``p`` (float or array)."""
        return self.A_Pa + self.B_Pa * p**self.n


@dataclass(frozen=True)
class CombinedHardening:
    """Bounded isotropic part R0 + Q(1-exp(-b p)) plus Armstrong-Frederick backstresses, each (X_Pa, gamma).

    A backstress saturates at X = C/gamma in uniaxial tension; monotonic curve:
    R0 + Q(1-exp(-b p)) + sum X_i (1-exp(-gamma_i p)).
    """

    R0_Pa: float
    Q_Pa: float
    b: float
    backstresses: tuple[tuple[float, float], ...]

    def flow_stress_Pa(self, p: float) -> float:
        """Monotonic uniaxial flow stress [Pa] at equivalent plastic strain ``p``."""
        iso = self.R0_Pa + self.Q_Pa * (1.0 - math.exp(-self.b * p))
        return iso + sum(x * (1.0 - math.exp(-g * p)) for x, g in self.backstresses)


@dataclass(frozen=True)
class Material:
    """Target material: ``johnson_cook`` serves single impacts, ``combined`` every run where impacts overlap."""

    key: str
    name: str
    E_Pa: float
    nu: float
    density_kg_m3: float
    johnson_cook: JohnsonCook
    combined: CombinedHardening
    combined_source: str
    source: str
    grade: str  # D derived, A read in a source, B quoted, C from memory or unverified


@dataclass(frozen=True)
class Shots:
    """The medium. ``size``: "mono" (every shot ``diameter_m``) or "distribution" (truncated normal, ``size_cv``)."""

    grade: str | None
    diameter_m: float
    density_kg_m3: float
    E_Pa: float
    nu: float
    size: str
    size_cv: float
    medium: str
    source: str
    evidence: str  # evidence grade of the numbers, as for materials

    @property
    def mean_mass_kg(self) -> float:
        """Mean mass of one shot [kg]; E[d^3] = d^3 (1 + 3 k cv^2), k the variance left by the cut at 2.5 sd."""
        spread = 1.0 + 3.0 * TRUNCATED_VARIANCE * self.size_cv**2 if self.size == "distribution" else 1.0
        return self.density_kg_m3 * math.pi / 6.0 * self.diameter_m**3 * spread


@dataclass(frozen=True)
class Nozzle:
    speed_m_s: float
    mass_flow_kg_s: float
    jet_diameter_m: float
    stand_off_m: float
    impact_angle_deg: float

    @property
    def direction(self) -> tuple[float, float, float]:
        """Unit vector of flight, shape (3,)."""
        a = math.radians(self.impact_angle_deg)
        return (math.cos(a) if self.impact_angle_deg != 90.0 else 0.0, 0.0, -math.sin(a))

    @property
    def normal_speed_m_s(self) -> float:
        return self.speed_m_s * math.sin(math.radians(self.impact_angle_deg))

    @property
    def footprint_semi_axes_m(self) -> tuple[float, float]:
        """Semi-axes (x, y) [m] of the jet's ellipse on the target."""
        r = 0.5 * self.jet_diameter_m
        return (r / math.sin(math.radians(self.impact_angle_deg)), r)

    @property
    def footprint_area_m2(self) -> float:
        a, b = self.footprint_semi_axes_m
        return math.pi * a * b


@dataclass(frozen=True)
class Target:
    material: Material
    window_m: tuple[float, float]  # size in x and y, centred on the jet axis
    thickness_m: float | None = None  # of a free plate; None: too thick to stretch or bend

    @property
    def window_area_m2(self) -> float:
        return self.window_m[0] * self.window_m[1]


@dataclass(frozen=True)
class Restitution:
    shot_target: float | str  # a number or "from_dimple"
    shot_shot: float


@dataclass(frozen=True)
class Friction:
    shot_target: float
    shot_shot: float


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
    """A preset expanded to the numbers it stands for (see ``presets.py``): numerics only, never physics."""

    preset: str
    flow_dt_over_P: float  # time step over the P-wave step of the smallest shot
    dimple_elements_per_radius: int  # a/h at the surface, a the expected dimple radius
    cell_side_in_radii: float  # periodic cell side over dimple radius
    cell_elements_per_side: int
    cell_load_steps: int  # penetration steps of one impact
    cell_force_tolerance: float  # out-of-balance forces over the contact force
    coverage_points_per_radius: float  # raster points per dimple radius
    stamp_points_per_radius: float


@dataclass(frozen=True)
class Scene:
    name: str
    seed: int
    exposure_time_s: float
    shots: Shots
    nozzle: Nozzle
    target: Target
    restitution: Restitution
    friction: Friction
    models: Models
    accuracy: Accuracy
    defaults_used: tuple[str, ...] = field(default=(), compare=False)  # "key = value (source)" for printing

    @property
    def shot_rate_1_s(self) -> float:
        """Mean number of shots leaving the nozzle per second."""
        return self.nozzle.mass_flow_kg_s / self.shots.mean_mass_kg

    @property
    def expected_shots(self) -> float:
        return self.shot_rate_1_s * self.exposure_time_s
