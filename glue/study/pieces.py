"""Every optional piece of physics of a scene in a table: its number, threshold, decision and what leaving it out saves.

A threshold is the number at which leaving the piece out changes its metric by the tolerance; make thresholds
(tests/benchmarks/thresholds.py) sweeps each over its number, off and on, and holds what stands here against what it
finds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from glue.flow.drag import drag_number
from glue.flow.regime import (
    BALLISTIC_BELOW,
    choose_flow,
    collision_number,
    gravity_number,
    overlap_number,
    resolve_physics,
)
from glue.scene.consistency import dimple_radii_m, estimated_dimple_radius_m
from glue.scene.effects import AirDrag, Gravity
from glue.scene.laws import CombinedHardening
from glue.scene.model import Scene
from glue.scene.presets import PEENED_DEPTH_IN_RADII
from glue.scene.schema import AIR_DRAG, GRAVITY
from glue.study.reference import reference_impact
from glue.target import regime

# Numbers up to which leaving a piece out changes its metric by no more than the tolerance beside it.
THRESHOLDS = {
    "collisions": BALLISTIC_BELOW, "gravity": 0.01, "air_drag": 0.01, "friction": 0.01, **regime.THRESHOLDS,
    "heating": 0.003, "friction_in_dimple": 0.05, "kinematic_hardening": 0.4, "finite_strain": 0.035, "overlap": 0.03,
    "thickness": 0.005,
}  # fmt: skip
TOLERANCES = {
    "collisions": 0.01, "gravity": 0.01, "air_drag": 0.01, "friction": 0.01,
    **dict.fromkeys(
        (*regime.THRESHOLDS, "heating", "friction_in_dimple", "kinematic_hardening", "finite_strain"), regime.TOLERANCE
    ), "overlap": 0.02, "thickness": 0.02,
}  # fmt: skip


def friction_number(scene: Scene, restitution: float) -> float:
    """Collisions per shot, by which friction acts on the mean normal energy, times the larger coefficient."""
    collisions = collision_number(scene, restitution)["collisions_per_shot"]
    return collisions * max(scene.friction.shot_target, scene.friction.shot_shot)


def backstress_share(law) -> float:
    """Share of a bounded law's full strength that its backstresses hold; 0 for any other law."""
    if not isinstance(law, CombinedHardening):
        return 0.0
    held = sum(x for x, _ in law.backstresses)
    return held / (law.R0_Pa + law.Q_Pa + held)


# Time with a piece over time without it, of the stage that it belongs to: medians of the sweeps.
COSTS = {
    "gravity": 1.2, "air_drag": 2.3, "friction": 1.05, "elastic_shot": 2.6, "target_inertia": 1.7, "strain_rate": 1.03,
    "heating": 1.01, "friction_in_dimple": 2.1,
}  # fmt: skip


@dataclass(frozen=True)
class Piece:
    """A row of the table.  ``number`` and ``threshold`` are dimensionless; None: there is none."""

    piece: str
    means: str  # what the number says
    number: float | None
    threshold: float | None
    source: str  # of the threshold
    decision: str  # "on", "off", or what stands in for it
    why: str
    saving: str

    @property
    def misfit(self) -> bool:
        """Whether it is left out although its number says that it matters."""
        return None not in (self.number, self.threshold) and self.decision == "off" and self.number > self.threshold


def pieces(scene: Scene, restitution: float, hits_per_point: float, imported: bool = False) -> list[Piece]:
    """All optional physics of ``scene`` in the order of the data.

    ``restitution`` on the target and the window's mean ``hits_per_point`` are estimates.  ``imported``: the impact log
    is from elsewhere, so nothing is decided of the stream.
    """
    stream = _stream(scene, restitution)
    if imported:
        told = {"decision": "-", "why": "the impact log is from elsewhere", "saving": "nothing"}
        stream = [replace(piece, **told) for piece in stream]
    return [*stream, *_impact(scene), *_target(scene, hits_per_point)]


def _limit(name: str) -> tuple[float, str]:
    """(threshold, its source)."""
    return THRESHOLDS[name], _source(name)


def _source(name: str) -> str:
    return f"make thresholds: {name}, {TOLERANCES[name]:.0%}"


def _saved(name: str, of: str) -> str:
    return f"{1.0 - 1.0 / COSTS[name]:.0%} of {of}"


def _stream(scene: Scene, e: float) -> list[Piece]:
    """Shots on their way."""
    numbers, flow = collision_number(scene, e), choose_flow(scene, e)
    asked = resolve_physics(scene)
    half = 0.5 * scene.accuracy.flow_tolerance
    found = [
        Piece("shot-shot collisions", "collisions per shot to first order, Pi", numbers["pi_eff"],
              *_limit("collisions"), "off" if flow.model == "ballistic" else "on", f"flow model {flow.model}",
              "the search for partners: seconds down to milliseconds"),
        Piece("third shots in a contact", "share of contacts that a third shot joins", overlap_number(scene, e),
              scene.accuracy.flow_tolerance, "make bench-flow: flow_tolerance",
              "on" if flow.model == "dem" else "off", f"flow model {flow.model}", "time steps inside contacts"),
    ]  # fmt: skip
    gravity = scene.gravity or Gravity(GRAVITY["acceleration_m_s2"].default)
    air = scene.air_drag or AirDrag(AIR_DRAG["gas_density_kg_m3"].default, AIR_DRAG["gas_viscosity_Pa_s"].default)
    for block, name, means, number in (
        ("gravity", "gravity", "change of a shot's energy, or its sag over the jet's radius",
         gravity_number(replace(scene, gravity=gravity))),
        ("air_drag", "drag", "change of a shot's energy on its way", 2.0 * drag_number(replace(scene, air_drag=air))),
    ):  # fmt: skip
        choice = asked.choices.get(block)
        threshold = min(THRESHOLDS[block], half) if getattr(scene, block) is not None else THRESHOLDS[block]
        found.append(
            Piece(name, means, number, threshold, _source(block), choice.model if choice else "off",
                  _asked(scene, block, choice), _saved(block, "the flights' time"))
        )  # fmt: skip
    mu = max(scene.friction.shot_target, scene.friction.shot_shot)
    found.append(
        Piece("spin and friction", "collisions per shot times the coefficient", friction_number(scene, e),
              *_limit("friction"), "on" if mu else "off", f"coefficient {mu:g}", _saved("friction", "the flow's time"))
    )  # fmt: skip
    return found


def _asked(scene: Scene, block: str, choice) -> str:
    """Why a block is on or off, in a few words."""
    asked = getattr(scene, block)
    if asked is None:
        return "no such block in the scene"
    return "by its number" if asked.auto else "the scene asks for it"


def _impact(scene: Scene) -> list[Piece]:
    """One shot into the target."""
    nozzle, shots = reference_impact(scene)
    target, speed = scene.target.material, nozzle.normal_speed_m_s
    chosen = regime.impact_physics(scene, shots, speed).choices
    rows = (
        ("elastic_shot", "shot elasticity", regime.elastic_shot_number(target, shots)),
        ("target_inertia", "target inertia", regime.inertia_number(target, shots, speed)),
        ("strain_rate", "strain rate", regime.rate_number(target, shots, speed)),
    )
    means = "change of the restitution, of itself"
    found = []
    for block, name, number in rows:
        choice = chosen.get(block)
        found.append(
            Piece(name, means, number, *_limit(block), choice.model if choice else "off",
                  _asked(scene, block, choice), _saved(block, "the impact's time"))
        )  # fmt: skip
    rate = chosen.get("strain_rate")
    heated = bool(scene.strain_rate and scene.strain_rate.thermal and rate and rate.model == "on")
    found.append(
        Piece("heating", means, regime.heat_number(target, shots, speed), *_limit("heating"),
              "on" if heated else "off", "the scene asks for it" if heated else "strain_rate.thermal is not set",
              _saved("heating", "the impact's time"))
    )  # fmt: skip
    mu = scene.friction.shot_target
    found.append(
        Piece("friction in the dimple", "Coulomb's coefficient", mu, *_limit("friction_in_dimple"),
              "on" if scene.friction.in_dimple else "off",
              f"friction.in_dimple = {str(scene.friction.in_dimple).lower()}",
              _saved("friction_in_dimple", "the impact's time"))
    )  # fmt: skip
    radius = estimated_dimple_radius_m(shots, speed, target) / (0.5 * shots.diameter_m)
    model = scene.models.dimple.model
    found.append(
        Piece("finite strain", "Tabor's strain of the dimple, .2 a/R", regime.TABOR * radius, *_limit("finite_strain"),
              "off" if model == "small_strain" else "on", f"dimple model {model}", "nothing: both cost the same")
    )  # fmt: skip
    return found


def _target(scene: Scene, hits: float) -> list[Piece]:
    """Many shots into the target."""
    target, model = scene.target, scene.models.target.model
    depth = PEENED_DEPTH_IN_RADII * dimple_radii_m(scene.media, scene.nozzles, target.material)[1]
    given = target.thickness_m
    share = depth / given if given else 0.0
    part = ("on", "the scene gives one") if given else ("off", "no thickness: too thick to stretch or bend")
    return [
        Piece("overlap of dimples", "hits per point", hits, *_limit("overlap"), "on",
              f"target model {model}: impacts on what earlier ones left", "all impacts but one"),
        Piece("kinematic hardening", "share of the law's strength that backstresses hold",
              backstress_share(target.material.combined), *_limit("kinematic_hardening"), "on",
              f"in the target ({model}); the dimple takes the monotonic curve", "nothing"),
        Piece("finite strain, many impacts", "hits per point", hits, None, "make bench-target",
              "on" if model == "contact" else "off", f"target model {model}",
              "a factor per step: the cell keeps one for all impacts"),
        Piece("thickness of the part", "peened depth over thickness", share, *_limit("thickness"), *part, "nothing"),
        Piece("edges of the part", "-", None, None, "none", "off", "a window far from any edge; the scene has no edges",
              "a mesh of the part"),
    ]  # fmt: skip


def table_text(rows: list[dict]) -> list[str]:
    """The table as lines of text; ``rows`` as ``check`` has them."""
    head = f"  {'piece':<28}{'number':>9}{'threshold':>11}  {'from':<44} {'decision':<9}"
    lines = [f"{head} why; what leaving it out saves"]
    for row in rows:
        number, threshold = ("-" if v is None else f"{v:.2g}" for v in (row["number"], row["threshold"]))
        decision = row["decision"] + (" (!)" if row["misfit"] else "")
        start = f"  {row['piece']:<28}{number:>9}{threshold:>11}  {row['source']:<44} {decision:<9}"
        lines.append(f"{start} {row['why']}; saves {row['saving']}")
    missed = [row["piece"] for row in rows if row["misfit"]]
    told = f"  (!) left out, though by its number it matters: {', '.join(missed)}; a block in the scene models it"
    return [*lines, *([told] if missed else [])]
