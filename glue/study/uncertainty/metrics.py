"""The metrics that get an interval, and how each answers to a small change of what lies behind it.

Exponents are those of closed forms: a dimple's depth goes as its radius a squared; peak force as flow stress times
a^2, that is flow stress^1/2, and contact time as flow stress^-1/2 (rigid-plastic impact at constant energy);
restitution as flow stress^(5/8) (Johnson, Contact Mechanics, eq. 11.47, at constant modulus and speed); hits per point
as a^2; roughness as the depth; depths of the stress profile as a.
"""

from __future__ import annotations

from typing import NamedTuple


class Metric(NamedTuple):
    """A key of metrics.json and its answers."""

    section: str
    key: str
    like: str = ""  # the measured quantity whose numerical error it shares, times ``share``
    share: float = 1.0
    radius: float = 0.0  # exponent of the dimple radius
    strength: float = 0.0  # exponent of the flow stress under one impact
    exposure: str = ""  # answers through hits per point, "coverage": as the expected coverage does; "time": inversely
    stress: bool = False  # answers to the bounded law's strength
    chance_of: str = ""  # the key of its section whose relative half width by chance it has

    @property
    def name(self) -> str:
        return f"{self.section}.{self.key}"


METRICS = (
    Metric("flow", "mean_normal_speed_m_s", "normal_energy", 0.5),
    Metric("flow", "mean_normal_energy_fraction", "normal_energy"),
    Metric("flow", "collided_fraction", "collided"),
    Metric("flow", "impacts"),
    Metric("dimple", "radius_m", "dimple_radius", radius=1.0),
    Metric("dimple", "crest_radius_m", "dimple_radius", radius=1.0),
    Metric("dimple", "depth_m", "dimple_depth", radius=2.0),
    Metric("dimple", "restitution", "restitution", strength=0.625),
    Metric("dimple", "peak_force_N", "peak_force", strength=0.5),
    Metric("dimple", "contact_time_s", "peak_force", strength=-0.5),
    Metric("coverage", "final", "coverage", exposure="coverage"),
    Metric("coverage", "time_98_s", "t98", exposure="time"),
    Metric("coverage", "avrami_final", "coverage", exposure="coverage"),
    Metric("coverage", "avrami_time_98_s", "t98_avrami", exposure="time"),
    Metric("coverage", "avrami_mass_flow_final", "coverage", exposure="coverage"),
    Metric("coverage", "impacts_in_window"),
    Metric("coverage", "peeq_final", "coverage", exposure="coverage"),
    Metric("residual_stress", "surface_Pa", "surface_stress", stress=True),
    Metric("residual_stress", "max_compressive_Pa", "largest_stress", stress=True),
    Metric("residual_stress", "max_compressive_depth_m", "largest_depth", radius=1.0),
    Metric("residual_stress", "tenth_depth_m", "tenth_depth", radius=1.0),
    Metric("residual_stress", "compressive_depth_m", "sign_change", radius=1.0),
    Metric("residual_stress", "arc_height_m", "largest_stress", radius=1.0, stress=True),
    Metric("roughness", "Sa_m", "Sa", radius=2.0),
    Metric("roughness", "Sq_m", "Sa", radius=2.0),
    Metric("roughness", "Sz_m", "Sz", radius=2.0),
    Metric("roughness", "Ra_m", "Sa", radius=2.0, chance_of="Sa_m"),
    Metric("roughness", "Rz_m", "Sz", radius=2.0, chance_of="Sz_m"),  # a mean of extremes: scatters less
    Metric("roughness", "Ssk"),
    Metric("roughness", "Sku"),
)
