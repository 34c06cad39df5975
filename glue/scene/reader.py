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
from glue.scene.model import Accuracy, Choice, Friction, Models, Nozzle, Restitution, Scene, Shots, Target
from glue.scene.parts import read_material, read_shots, read_window
from glue.scene.presets import PRESETS
from glue.scene.table import Log, Table

EXAMPLES = Path(__file__).resolve().parent / "examples"

# What "auto" stands for in this version, and why.
_AUTO = {
    "flow": Choice("dem", "auto: the flow model of this version, every shot-shot collision resolved in YADE"),
    "dimple": Choice("axisymmetric", "auto: the dimple model of this version, axisymmetric finite strain"),
    "target": Choice(
        "cell", "auto: the target model of this version, a periodic cell under the logged impacts"
    ),
}


def read_scene(path: Path | str, *, preset: str | None = None, content: bytes | None = None) -> Scene:
    """The scene in the TOML file ``path``, checked and with every default filled in.

    ``preset`` takes the place of the file's ``accuracy.preset``; ``content`` is the file's, when it was read before.
    Raises :class:`InputError` with all problems found.
    """
    path = Path(path)
    log = Log(path)
    top = Table(_parse(path, read_bytes(path) if content is None else content), "", log)
    top.refuse_others(
        (*schema.TOP, *schema.TABLES), not_built=schema.TOP_NOT_BUILT, elsewhere=schema.BELONGS_IN
    )
    head = {
        key: top.get(key, field)
        for key, field in schema.TOP.items()
        # An exposure given as coverage_percent has been refused already: do not call the time missing too.
        if not (key == "exposure_time_s" and "coverage_percent" in top and key not in top)
    }
    shots = _read_shots_table(top)
    nozzle = _read_nozzle(top)
    material, window, thickness = _read_target(top)
    restitution = Restitution(**_small_table(top, "restitution", schema.RESTITUTION))
    friction = Friction(**_small_table(top, "friction", schema.FRICTION))
    models = _read_models(top)
    accuracy = _read_accuracy(top, preset)

    for key_path, sentence in _cross_checks(
        shots, nozzle, material, window, thickness, accuracy, head.get("exposure_time_s")
    ):
        log.problem(key_path, sentence)
    if log.problems:
        raise InputError(log.problems)
    return Scene(
        name=head["name"],
        seed=head["seed"],
        exposure_time_s=head["exposure_time_s"],
        media=(shots,),
        nozzles=(nozzle,),
        target=Target(material, window, thickness),
        restitution=restitution,
        friction=friction,
        models=models,
        accuracy=accuracy,
        defaults_used=tuple(log.defaults),
    )


def resolved_dict(scene: Scene) -> dict:
    """The scene as nested plain values in SI units (JSON-able, deterministic), for manifests and hashing.

    ``defaults_used`` is left out: a default and the same value written down are the same scene.
    """
    plain = _plain(dataclasses.asdict(scene))
    del plain["defaults_used"]
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


def _parse(path: Path, raw: bytes) -> dict:
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


def _single(top: Table, key: str, several: str, holds: str) -> Table | None:
    """The required table ``[key]``; an array of tables is a feature of a later version."""
    if isinstance(top.data.get(key), list):
        top.problem(key, schema.not_built(several, f"one, written [{key}]"))
        return None
    return top.table(key, holds)


def _read_shots_table(top: Table) -> Shots | None:
    table = _single(top, "shots", "mixed shots are", "grade, or diameter_m and density_kg_m3")
    return read_shots(table) if table else None


def _read_nozzle(top: Table) -> Nozzle | None:
    table = _single(top, "nozzle", "several nozzles are", ", ".join(schema.NOZZLE))
    if table is None:
        return None
    known = (*schema.NOZZLE, *schema.NOZZLE_ZERO)
    table.refuse_others(known, not_built=schema.NOZZLE_NOT_BUILT, elsewhere=schema.BELONGS_IN)
    for key, sentence in schema.NOZZLE_ZERO.items():
        value = table.data.get(key, 0.0)
        if isinstance(value, bool) or not isinstance(value, int | float) or value != 0:
            table.problem(key, f"{sentence}; allowed 0")
    values = {key: table.get(key, field) for key, field in schema.NOZZLE.items()}
    return None if None in values.values() else Nozzle(**values)


def _read_target(top: Table):
    """(Material or None, window or None, thickness or None); no thickness is a part too thick to stretch or bend."""
    table = top.table("target", "material and window_m")
    if table is None:
        return None, None, None
    table.refuse_others(("material", "window_m", "thickness_m"), elsewhere=schema.BELONGS_IN)
    thickness = None
    if "thickness_m" in table:
        thickness = table.get("thickness_m", schema.TARGET["thickness_m"])
    else:
        table.log.default(table.at("thickness_m"), "none", "a part too thick to stretch or bend; choice of this project")
    return read_material(table), read_window(table), thickness


def _small_table(top: Table, key: str, fields: dict) -> dict:
    """Values of an optional table whose keys are all ``fields``."""
    table = top.optional_table(key)
    if table is None:
        return dict.fromkeys(fields)
    table.refuse_others(fields, elsewhere=schema.BELONGS_IN)
    return {name: table.get(name, field) for name, field in fields.items()}


def _read_models(top: Table) -> Models:
    asked = _small_table(top, "models", schema.MODELS)
    return Models(
        **{
            stage: _AUTO[stage] if word in ("auto", None) else Choice(word, "asked for in the scene")
            for stage, word in asked.items()
        }
    )


def _read_accuracy(top: Table, preset: str | None) -> Accuracy | None:
    """The file's preset; a run's own ``preset`` takes its place, but the file's is checked all the same."""
    table = top.optional_table("accuracy")
    word = None
    if table is not None:
        table.refuse_others(schema.ACCURACY, elsewhere=schema.BELONGS_IN)
        if preset is None or "preset" in table:
            word = table.get("preset", schema.ACCURACY["preset"])
    if preset is not None:
        word = preset
        problem = schema.ACCURACY["preset"].problem(preset)
        if problem:
            top.log.problems.append(f"accuracy preset given for this run: {problem}")
            return None
    return PRESETS[word] if word else None


def _cross_checks(shots, nozzle, material, window, thickness, accuracy, exposure_time_s):
    """Problems between keys, as far as the keys themselves could be read."""
    if shots and nozzle:
        yield from consistency.jet_problems(shots, nozzle)
        if exposure_time_s:
            yield from consistency.count_problems(shots, nozzle, exposure_time_s)
        if material and accuracy:
            yield from consistency.contact_problems(shots, nozzle, material, accuracy)
        if material and thickness:
            yield from consistency.thickness_problems(shots, nozzle, material, thickness)
        if window:
            yield from consistency.window_problems(shots, nozzle, window)
            if material and accuracy:
                yield from consistency.resolution_problems(shots, nozzle, material, window, accuracy)
