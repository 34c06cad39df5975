"""Elastic constants as the contact flow has them, where ``accuracy.flow_stiffness_scale`` softens its contacts.

A softer contact lasts longer, by scale^-2/5, and the P-wave step grows by scale^-1/2: fewer steps.  Rebound and Coulomb's
impulse stay; depth grows by scale^-2/5, and with the contact's time the chance that a third shot joins in.
"""

from __future__ import annotations

import dataclasses

from glue.scene.model import Material, Scene, Shots


def softened(scene: Scene) -> Scene:
    """``scene`` with the Young's moduli of shots and target scaled; for the flow alone."""
    media, material = softened_parts(scene.media, scene.target.material, scene.accuracy.flow_stiffness_scale)
    return dataclasses.replace(scene, media=media, target=dataclasses.replace(scene.target, material=material))


def softened_parts(media: tuple[Shots, ...], material: Material, scale: float) -> tuple[tuple[Shots, ...], Material]:
    """(media, material) with moduli times ``scale``; the same objects at 1."""
    if scale == 1.0:
        return media, material
    return tuple(_scaled(shots, scale) for shots in media), _scaled(material, scale)


def _scaled(part, scale: float):
    return dataclasses.replace(part, E_Pa=scale * part.E_Pa)
