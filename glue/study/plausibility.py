"""Bands that peened parts usually lie in: a result outside is told, never refused (all grade C).

For 2024-T3x, from memory: surface stress -180 to -280 MPa, largest compression -270 to -350 MPa; at an intensity of 4-10A
at a depth of .05-.15 mm, with the sign change at .2-.45 mm, Ra 2-6 um.  For any material the largest compression is about
half of the strength and cannot be beyond it.
"""

from __future__ import annotations

from glue.scene.model import Scene
from glue.theory.almen import INCH_m, read_intensity
from glue.theory.plate import force_and_moment

_2024 = "al2024"
STRESS = {"surface_Pa": (-280e6, -180e6), "max_compressive_Pa": (-350e6, -270e6)}
DEPTH = {"max_compressive_depth_m": (0.05e-3, 0.15e-3), "compressive_depth_m": (0.2e-3, 0.45e-3)}
RA = (2e-6, 6e-6)
_NAMES = {
    "surface_Pa": "surface stress", "max_compressive_Pa": "largest compression",
    "max_compressive_depth_m": "depth of the largest compression", "compressive_depth_m": "depth of the sign change",
}  # fmt: skip


def stress_warnings(scene: Scene, metrics: dict) -> list[str]:
    """Sentences for the stress metrics outside what peened parts usually show."""
    material, told = scene.target.material, []
    if material.key.startswith(_2024):
        for key, band in (STRESS | (DEPTH if _usual(scene) else {})).items():
            unit, factor = ("MPa", 1e-6) if key.endswith("_Pa") else ("mm", 1e3)
            value = metrics.get(key)
            if value is not None and not band[0] <= value <= band[1]:
                low, high = (end * factor for end in band)
                told.append(
                    f"{_NAMES[key]} {value * factor:.3g} {unit} is outside {low:g} to {high:g} {unit}, usual for peened 2024-T3x"
                    " (grade C)"
                )
    if scene.target.initial_stress and scene.target.thickness_m is not None:
        z, s = zip(*scene.target.initial_stress)
        force, _ = force_and_moment(z, s, 0.0)
        gross, _ = force_and_moment(z, [abs(v) for v in s], 0.0)
        if abs(force) > 0.1 * gross:
            told.append(
                "initial_stress is not in balance by itself: what holds it lies deeper than it says, and is missing from the"
                " balances here"
            )
    strength = material.combined.flow_stress_Pa(0.1)
    most = metrics.get("max_compressive_Pa")
    if most is not None and -most > 1.2 * strength:
        told.append(
            f"largest compression {most * 1e-6:.0f} MPa is beyond the flow stress at 10 % strain, {strength * 1e-6:.0f} MPa"
        )
    return told


def roughness_warnings(scene: Scene, metrics: dict) -> list[str]:
    """The same for the roughness; only for intensities of which it is known."""
    if not (scene.target.material.key.startswith(_2024) and _usual(scene)) or RA[0] <= metrics["Ra_m"] <= RA[1]:
        return []
    low, high = (end * 1e6 for end in RA)
    found = f"Ra {metrics['Ra_m'] * 1e6:.3g} um is outside {low:g} to {high:g} um"
    return [f"{found}, usual for 2024-T3x peened to 4-10A (grade C)"]


def _usual(scene: Scene) -> bool:
    """Whether the scene asks for an intensity of 4A to 10A."""
    said = scene.specification.intensities if scene.specification else ()
    found = [read_intensity(text) for text in said if text]
    return bool(found) and all(i.strip.letter == "A" and i.aim_m <= 10e-3 * INCH_m * (1 + 1e-9) for i in found)
