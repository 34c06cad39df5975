"""Reads a scene file strictly: every problem at once, each with file, key path and what is allowed.

Standard library only: YADE's interpreter imports this too.
"""

from __future__ import annotations

import dataclasses
import re
import tomllib
from pathlib import Path

from glue.errors import InputError
from glue.scene import consistency, schema
from glue.scene.measured import read_measured
from glue.scene.media import read_media
from glue.scene.model import Choice, Models, Scene
from glue.scene.nozzles import feed_says, read_exposure, read_nozzles
from glue.scene.physics import (
    read_air_drag,
    read_elastic_shot,
    read_friction,
    read_gravity,
    read_restitution,
    read_strain_rate,
    read_target_inertia,
)
from glue.scene.presets import PRESETS, Accuracy
from glue.scene.specification import INFERRED, PROVISIONAL_TIME_s, inferred_beside, read_specification
from glue.scene.table import Log, Table
from glue.scene.targets import read_target

EXAMPLES = Path(__file__).resolve().parent / "examples"

# What "auto" stands for in this version, and why.
_AUTO = {
    "flow": Choice("auto", "auto: the cheapest flow model whose expected error the preset accepts"),
    "dimple": Choice("axisymmetric", "auto: the dimple model of this version, axisymmetric finite strain"),
    "target": Choice("auto", "auto: by the preset"),
}
_AUTO_TARGET = {
    "fast": Choice("layers", "auto: preset fast takes the layer model, fed by one finite-element impact"),
    "balanced": Choice("cell", "auto: a periodic cell under the logged impacts of one patch"),
    "reference": Choice("cell", "auto: a periodic cell under the logged impacts of one patch, wider and finer"),
}


def read_scene(
    path: Path | str,
    *,
    preset: str | None = None,
    content: bytes | None = None,
    inferred: dict | None = None,
    provisional: bool = False,
) -> Scene:
    """The scene in the TOML file ``path``, checked and with every default filled in.

    ``preset`` takes the place of the file's ``accuracy.preset``; ``content`` is the file's, when it was read before.
    ``inferred``: what ``glue.study.specify`` found for a file that says an intensity, a machine's setting or a coverage
    instead of speed and time; without it what lies beside the file.  ``provisional`` reads such a file without, with
    stand-ins in place of what is to be found and without the checks between keys: for ``specify`` alone.
    Raises :class:`InputError` with all problems found.
    """
    path = Path(path)
    log = Log(path)
    content = read_bytes(path) if content is None else content
    top = Table(parse(path, content), "", log)
    top.refuse_others((*schema.TOP, "coverage_percent", *schema.TABLES), elsewhere=schema.BELONGS_IN)
    head = {key: top.get(key, field) for key, field in schema.TOP.items() if not _left_out(top, key)}
    specification = read_specification(top, path)
    if specification is not None and inferred is None and not provisional:
        inferred = inferred_beside(path, content)
    exposure = head.get("exposure_time_s")
    by_coverage = specification is not None and specification.coverage_percent is not None and exposure is None
    if by_coverage and not feed_says(top):  # else as long as the passes take that were found
        exposure = inferred["exposure_time_s"] if inferred else PROVISIONAL_TIME_s
        if problem := schema.TOP["exposure_time_s"].problem(exposure):
            top.problem("coverage_percent", f"leads to an exposure of {exposure:.4g} s: {problem}")
    media = read_media(top)
    passes = (inferred or {}).get("passes", 1) if by_coverage else None
    nozzles = read_nozzles(top, exposure, inferred["speed_m_s"] if inferred else None, passes)
    exposure = read_exposure(top, exposure, nozzles)
    target = read_target(top, path)
    measured = read_measured(top, path)
    restitution, friction = read_restitution(top), read_friction(top)
    gravity, air_drag = read_gravity(top), read_air_drag(top)
    strain_rate = read_strain_rate(top, target.material if target else None)
    target_inertia, elastic_shot = read_target_inertia(top), read_elastic_shot(top)
    models = _read_models(top)
    accuracy = _read_accuracy(top, preset)
    if models.target.model == "auto" and accuracy:
        models = dataclasses.replace(models, target=_AUTO_TARGET[accuracy.preset])

    parts = (media, nozzles, target, restitution, air_drag, models, accuracy, exposure)
    unknown = specification is not None and inferred is None
    for key_path, sentence in () if unknown else consistency.problems(*parts):
        log.problem(key_path, sentence)
    if unknown and not provisional and not log.problems:
        log.problem(
            "nozzle" if any(specification.intensities) or specification.machine else "coverage_percent",
            "says what is to come out instead of speed and time, which are not found yet; allowed: peen check and peen run,"
            f" which find them, or a run directory, which holds them ({INFERRED})",
        )
    if log.problems:
        raise InputError(log.problems)
    return Scene(
        name=head["name"],
        seed=head["seed"],
        exposure_time_s=exposure,
        media=media,
        nozzles=nozzles,
        target=target,
        restitution=restitution,
        friction=friction,
        models=models,
        accuracy=accuracy,
        arrivals=head["arrivals"],
        gravity=gravity,
        air_drag=air_drag,
        strain_rate=strain_rate,
        target_inertia=target_inertia,
        elastic_shot=elastic_shot,
        measured=measured,
        specification=specification,
        inferred=tuple(inferred["text"]) if inferred else (),
        defaults_used=tuple(log.defaults),
    )


def _left_out(top: Table, key: str) -> bool:
    """An exposure may follow from a feed's path, or from coverage_percent."""
    return key == "exposure_time_s" and key not in top and ("coverage_percent" in top or feed_says(top))


def resolved_dict(scene: Scene) -> dict:
    """The scene as nested plain values in SI units (JSON-able, deterministic), for manifests and hashing.

    ``defaults_used`` is left out: a default and the same value written down are the same scene.
    """
    plain = _plain(dataclasses.asdict(scene))
    del plain["defaults_used"], plain["inferred"]
    # What a scene does not have is left out: scenes that never heard of it hash as they always did.
    own = {"specification": plain, "measured": plain, "dimple_speed_ratio": plain["accuracy"]}
    for key, table in (own | dict.fromkeys(("initial_stress", "initial_roughness"), plain["target"])).items():
        if not table[key]:
            del table[key]
    return {"schema": schema.SCHEMA, **plain}


def example_names() -> list[str]:
    """Names of the scenes shipped with the project."""
    return sorted(file.stem for file in EXAMPLES.glob("*.toml"))


def example_path(name: str) -> Path | None:
    """File of the shipped scene ``name``, None when there is none of that name."""
    return EXAMPLES / f"{name}.toml" if name in example_names() else None


def _plain(value: object) -> object:
    """Tuples as lists, all the way down, as JSON would give them back."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    return [_plain(item) for item in value] if isinstance(value, list | tuple) else value


def read_bytes(path: Path) -> bytes:
    """Content of a scene file. Raises :class:`InputError` when it cannot be read."""
    try:
        return path.read_bytes()
    except FileNotFoundError:
        names = ", ".join(example_names())
        raise InputError(f"{path}: no such file; allowed: a scene file, or one of {names}") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None


def parse(path: Path, raw: bytes) -> dict:
    """The raw tables of the TOML file ``path`` of content ``raw``; :class:`InputError` naming the line at fault."""
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise InputError(
            f"{path}: line {line}: byte 0x{raw[error.start]:02x} is not UTF-8; allowed: text saved as UTF-8"
        ) from None
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise InputError(
            f"{path}: is not TOML that can be read: arrays or tables nested too deeply"
        ) from None
    except ValueError as error:  # also what a number of thousands of digits raises
        raise InputError(f"{path}: is not valid TOML: {_with_line(str(error), text)}") from None


def _with_line(message: str, text: str) -> str:
    """The TOML parser's message with the line it speaks of."""
    lines = text.splitlines() or [""]
    at = re.search(r"at line (\d+)", message)
    number = int(at[1]) if at else len(lines)
    if not at:
        message = message.replace("at end of document", f"at line {number}, the end of the file")
    return f"{message}: {lines[min(number, len(lines)) - 1].strip()}"


def _read_models(top: Table) -> Models:
    table = top.optional_table("models")
    asked = dict.fromkeys(schema.MODELS)
    if table is not None:
        table.refuse_others(schema.MODELS, elsewhere=schema.BELONGS_IN)
        asked = table.get_all(schema.MODELS)
    return Models(
        **{
            stage: _AUTO[stage] if word in ("auto", None) else Choice(word, "asked for in the scene")
            for stage, word in asked.items()
        }
    )


def _read_accuracy(top: Table, preset: str | None) -> Accuracy | None:
    """The file's preset with the numbers that the file states itself.

    A run's own ``preset`` takes the place of the file's, which is checked all the same; stated numbers hold with either.
    """
    table = top.optional_table("accuracy")
    word, own = None, {}
    if table is not None:
        table.refuse_others(schema.ACCURACY, elsewhere=schema.BELONGS_IN)
        if preset is None or "preset" in table:
            word = table.get("preset", schema.ACCURACY["preset"])
        # Only the number of patches has a default of its own: the others' are the preset's.
        own = {k: table.get(k, schema.ACCURACY[k]) for k in schema.ACCURACY if k == "target_patches" or k in table and k != "preset"}
    if preset is not None:
        word = preset
        problem = schema.ACCURACY["preset"].problem(preset)
        if problem:
            top.log.problems.append(f"accuracy preset given for this run: {problem}")
            return None
    return dataclasses.replace(PRESETS[word], **own) if word and None not in own.values() else None
