"""Physics that a scene may ask for, or leave to its regime number: the data of the optional blocks, in SI units.

An absent block is not modelled.  Standard library only.
"""

from __future__ import annotations

from dataclasses import dataclass


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
