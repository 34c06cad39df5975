"""Which models a scene takes and why, as the manifest keeps it and ``peen check`` prints it."""

from __future__ import annotations

from glue.flow.regime import choose_flow, resolve_physics
from glue.scene.model import Scene


def choices(scene: Scene) -> dict:
    """{stage: {"model", "why"}} for the manifest and for printing; with it the hardening law of each solver.

    The flow's is chosen again when it runs, with the restitution of the dimple instead of an estimate.
    """
    from glue.study.dimple_stage import law_text, scene_physics  # here: they load the target's models
    from glue.study.flow_stage import restitution_estimate

    material = scene.target.material
    chosen = {name: {"model": c.model, "why": c.why} for name, c in vars(scene.models).items()}
    flow = choose_flow(scene, restitution_estimate(scene)[0])
    chosen["flow"] = {"model": flow.model, "why": flow.why}
    chosen |= {
        block.replace("_", " "): {"model": c.model, "why": c.why}
        for block, c in resolve_physics(scene).choices.items()
    }
    physics, impact_choices = scene_physics(scene)
    chosen |= {
        block.replace("_", " "): {"model": c.model, "why": c.why} for block, c in impact_choices.items()
    }
    bounded = material.combined
    law, formula = law_text(material)
    factors = [name for name, on in (("rate term", physics.rate), ("softening by heat", physics.thermal)) if on]
    chosen["dimple law"] = {
        "model": law,
        "why": f"single impact: {formula}, {'with ' + ' and '.join(factors) if factors else 'no rate term'}"
        f" ({material.source}; grade {material.grade})",
    }
    backstresses = ", ".join(f"X {x / 1e6:.4g} MPa (gamma {g:g})" for x, g in bounded.backstresses)
    chosen["target law"] = {
        "model": "combined",
        "why": f"impacts overlap, so hardening must be bounded: R {bounded.R0_Pa / 1e6:.4g} + {bounded.Q_Pa / 1e6:.4g}"
        f"(1 - exp(-{bounded.b:g} p)) MPa, {backstresses or 'no backstress'} ({material.combined_source})",
    }
    return chosen
