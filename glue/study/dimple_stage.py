"""The stage ``dimple``: the impact that stands for all in a scene, with a small table of slower ones."""

from __future__ import annotations

import math

from glue.errors import InputError
from glue.scene import sizes
from glue.scene.model import HardeningTable, JohnsonCook, Material, Scene
from glue.solvers import build_plugin
from glue.study.reference import reference_impact
from glue.study.results import plain
from glue.study.stage import Work
from glue.target.between import shared_density_kg_m3, shared_speeds_m_s, solve_dimple_between
from glue.target.dimple import RATE_TOLERANCE, Dimple, solve_dimple
from glue.target.driver import kernel_flavour
from glue.target.physics import STEEL_SHOT, ImpactPhysics, shot_yield_warning
from glue.target.regime import ImpactChoices, impact_physics
from glue.target.speeds import spaced

SLOWEST = 1.0 / 16.0  # of the reference speed; slower impacts are few and bring no energy
ABSURD_STRAIN = 1.0


def dimple_stage(work: Work) -> tuple[dict, list[str]]:
    """One shot at nominal normal speed into the flat target, the one with the largest dimple where they differ.

    Beside it the same shot at other speeds, down to SLOWEST of that and up to the fastest that a nozzle can shoot.  With
    ``accuracy.dimple_speed_ratio`` it lies between impacts at speeds that other scenes have too.
    """
    from glue.meshes import write_triangles  # here: loads meshio

    ready_kernels()
    scene = work.scene
    nozzle, shots = reference_impact(scene)
    physics, choices = scene_physics(scene)
    speed, ratio = nozzle.normal_speed_m_s, scene.accuracy.dimple_speed_ratio
    common = {
        "speed_m_s": speed, "density_kg_m3": shots.density_kg_m3, "diameter_m": shots.diameter_m,
        "elements_per_radius": scene.accuracy.dimple_elements_per_radius,
        "steps_per_contact": scene.accuracy.dimple_steps_per_contact,
        "workdir": work.path / "dimple", "physics": physics, "progress": work.progress,
    }  # fmt: skip
    if ratio:
        dimple = solve_dimple_between(
            scene.target.material, slowest_m_s=SLOWEST * speed, fastest_m_s=max(speed, fastest_speed(scene)), ratio=ratio, **common
        )
    else:
        dimple = solve_dimple(scene.target.material, other_speeds_m_s=other_speeds(scene), **common)
    dimple.save(work.path / "dimple" / "dimple.npz")
    fields = {"peeq": dimple.peeq, "sigma_rr_Pa": dimple.sigma_rr_Pa}
    write_triangles(
        work.path / "dimple" / "dimple.vtu", dimple.points_m, dimple.triangles, fields
    )  # for viewing
    metrics = dimple_metrics(dimple, shots.medium)
    if ratio:
        metrics["between_solved_speeds"] = True
    if choices:
        metrics["physics"] = {block: vars(choice) for block, choice in choices.items()}
    return {"dimple": metrics}, ["dimple/dimple.npz", "dimple/dimple.vtu"]


def ready_kernels() -> None:
    """Compile FreeFEM's kernels when their sources changed, unless the pure-script twins are asked for."""
    if kernel_flavour() == "kernel":
        build_plugin()


def scene_physics(scene: Scene) -> ImpactChoices:
    """The impact physics of the scene, decided for its reference impact."""
    nozzle, shots = reference_impact(scene)
    return impact_physics(scene, shots, nozzle.normal_speed_m_s)


def impact_speeds(scene: Scene) -> list[float]:
    """Speeds [m/s] of the impacts that the stage solves, rising; of shots of ``impact_density(scene)``."""
    nominal, ratio = reference_impact(scene)[0].normal_speed_m_s, scene.accuracy.dimple_speed_ratio
    if not ratio:
        return sorted({nominal, *other_speeds(scene)})
    density, fastest = reference_impact(scene)[1].density_kg_m3, max(nominal, fastest_speed(scene))
    return shared_speeds_m_s(SLOWEST * nominal, fastest, density, scene_physics(scene)[0], ratio)


def impact_density(scene: Scene) -> float:
    """Density [kg/m3] of the shot in the impacts that the stage solves."""
    own = reference_impact(scene)[1].density_kg_m3
    return shared_density_kg_m3(scene_physics(scene)[0], own) if scene.accuracy.dimple_speed_ratio else own


def layer_speeds(scene: Scene) -> list[float]:
    """Speeds [m/s] of the impacts with the bounded law that the layer model solves.

    Of the reference shot; with ``accuracy.dimple_speed_ratio`` of shots of ``between.DENSITY_KG_M3``.
    """
    nozzle, shots = reference_impact(scene)
    nominal, ratio = nozzle.normal_speed_m_s, scene.accuracy.dimple_speed_ratio
    return shared_speeds_m_s(nominal, nominal, shots.density_kg_m3, ImpactPhysics(), ratio) if ratio else [nominal]


def other_speeds(scene: Scene) -> list[float]:
    """Speeds [m/s] of the table beside the dimple's: slower ones, and the fastest of any nozzle and medium."""
    nominal = reference_impact(scene)[0].normal_speed_m_s
    speeds, fastest = spaced(SLOWEST * nominal, nominal, scene.accuracy.dimple_speeds)[:-1], fastest_speed(scene)
    return [*speeds, float(f"{fastest:.9g}")] if fastest > 1.001 * nominal else speeds


def fastest_speed(scene: Scene) -> float:
    """Normal speed [m/s] of the reference shot with the density x speed^2 of the fastest shot of any nozzle and medium."""
    _, shots = reference_impact(scene)
    return max(
        n.fastest_m_s * n.normal_speed_m_s / n.speed_m_s * math.sqrt(s.density_kg_m3 / shots.density_kg_m3)
        for n in scene.nozzles
        for s in scene.media
    )


def law_text(material: Material) -> tuple[str, str]:
    """Name and formula of the law of single impacts."""
    law = material.single_law
    if isinstance(law, JohnsonCook):
        capped = f", at most {law.saturation_Pa / 1e6:g} MPa" if law.saturation_Pa is not None else ""
        return "johnson-cook", f"A {law.A_Pa / 1e6:g}, B {law.B_Pa / 1e6:g} MPa, n {law.n:g}{capped}"
    if isinstance(law, HardeningTable):
        return "table", f"{len(law.strain)} points to {law.stress_Pa[-1] / 1e6:g} MPa at strain {law.strain[-1]:g}"
    return "voce", f"{law.R0_Pa / 1e6:g} + {law.Q_Pa / 1e6:g}(1 - exp(-{law.b:g} p)) MPa"


def refuse_dimple(scene: Scene, scene_file=None) -> None:
    """Raise InputError for shots that the dimple cannot be scaled to with the physics that the scene asks for."""
    _, reference = reference_impact(scene)
    physics, _ = scene_physics(scene)
    problems = []
    if physics.rate:
        most = math.exp(RATE_TOLERANCE / scene.target.material.single_law.C)
        ends = [end / reference.diameter_m for s in scene.media for end in (sizes.smallest_m(s), sizes.largest_m(s))]
        if max(*ends, *(1.0 / end for end in ends)) > most:
            problems.append(
                f"strain_rate: a rate-dependent dimple belongs to its diameter, {reference.diameter_m:g} m; shots of this"
                f" scene have {min(ends):.3g} to {max(ends):.3g} times that; allowed within a factor {most:.3g} (flow stress"
                f" within {RATE_TOLERANCE:.1%})"
            )
    alone = physics.rate or physics.inertia or physics.elastic_shot is not None
    if alone and any(abs(s.density_kg_m3 / reference.density_kg_m3 - 1.0) > 1e-6 for s in scene.media):
        problems.append(
            "strain_rate, target_inertia, elastic_shot: with one of them a dimple belongs to the density of its shot;"
            " allowed: media of one density"
        )
    if problems:
        raise InputError(problems)


def dimple_metrics(dimple: Dimple, medium: str = "steel") -> dict:
    """The section ``dimple`` of metrics.json; with a warning where the model is beyond what it was tried for.

    medium: of the shot; the strength of steel shot is known, so that only its yielding is warned of.
    """
    keys = (
        "radius_m",
        "depth_m",
        "crest_radius_m",
        "restitution",
        "peak_force_N",
        "contact_time_s",
        "speed_m_s",
        "speed_exponent",
        "restitution_exponent",
        "edge_peeq",
        "wall_s",
    )
    found = plain({k: getattr(dimple, k) for k in keys})
    if dimple.table_speed_m_s.size:
        found["table_from_m_s"], found["table_to_m_s"] = map(float, dimple.table_speed_m_s[[0, -1]])
    warnings = []
    if dimple.largest_peeq > ABSURD_STRAIN:
        warnings.append(
            f"plastic strain reaches {dimple.largest_peeq:.1f} in one impact: beyond {ABSURD_STRAIN:g} real metal cracks or"
            " melts first, take the results as a trend"
        )
    if "steel" in medium or "wire" in medium:
        told = shot_yield_warning(dimple.centre_pressure_Pa, dimple.mean_pressure_Pa, STEEL_SHOT.yield_Pa)
        warnings += [f"{told} ({STEEL_SHOT.source}; grade {STEEL_SHOT.grade})"] if told else []
    if warnings:
        found["warning"] = "; ".join(warnings)
    return found
