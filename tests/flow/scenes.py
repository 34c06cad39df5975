"""Scenes built by hand, without the reader: also imported under Debian's Python and inside YADE."""

from __future__ import annotations

import dataclasses

from glue.scene import model
from glue.scene.presets import PRESETS


def bare_scene(**changes) -> model.Scene:
    """S390 steel (1 mm, 60 m/s, 5 kg/min, 20 mm jet, 100 mm stand-off) on 2024; ``changes`` by field name.

    A change goes to whichever part of the scene has that field.
    """
    aluminium = model.Material(
        "al2024-t351",
        "2024-T351",
        73.1e9,
        0.33,
        2780.0,
        model.JohnsonCook(369e6, 684e6, 0.73),
        model.CombinedHardening(300e6, 50e6, 10.0, ((100e6, 50.0),)),
        "test",
        "test",
        "C",
    )
    auto = model.Choice("dem", "test")
    scene = model.Scene(
        name="bare",
        seed=1,
        exposure_time_s=0.02,
        media=(model.Shots("S390", 1e-3, 7800.0, 210e9, 0.3, "mono", 0.0, "steel", "test", "C"),),
        nozzles=(model.Nozzle(60.0, 5.0 / 60.0, 0.020, 0.10, 90.0),),
        target=model.Target(aluminium, (0.004, 0.004)),
        restitution=model.Restitution(0.6, 0.8),
        friction=model.Friction(0.2, 0.2),
        models=model.Models(auto, auto, auto),
        accuracy=PRESETS["balanced"],
    )
    for part_name in ("media", "nozzles", "restitution", "friction", "accuracy"):
        part = getattr(scene, part_name)
        first = part[0] if isinstance(part, tuple) else part
        own = {k: changes.pop(k) for k in [f.name for f in dataclasses.fields(first)] if k in changes}
        first = dataclasses.replace(first, **own)
        scene = dataclasses.replace(scene, **{part_name: (first,) if isinstance(part, tuple) else first})
    return dataclasses.replace(scene, **changes)
