"""A scene file with some keys changed: for ladders of one scene over its models and numbers."""

from __future__ import annotations

import copy
import json
import tomllib
from collections.abc import Mapping


def changed(content: bytes, changes: Mapping[str, object]) -> bytes:
    """TOML of the scene ``content`` with the values at these key paths ("accuracy.preset") set; None removes a key.

    A path into an array of tables changes each of them ("nozzle.mass_flow_kg_s" of several nozzles).  Comments are lost.
    Raises ValueError for content that is no TOML, KeyError for a path through something else than a table.
    """
    data = copy.deepcopy(tomllib.loads(content.decode("utf-8-sig")))
    for path, value in changes.items():
        *tables, key = path.split(".")
        places = [data]
        for name in tables:
            found = [place.setdefault(name, {}) for place in places]
            places = [item for f in found for item in (f if isinstance(f, list) else [f])]
        for place in places:
            if not isinstance(place, dict):
                raise KeyError(path)
            if value is None:
                place.pop(key, None)
            else:
                place[key] = value
    return toml(data).encode()


def toml(data: Mapping[str, object]) -> str:
    """``data`` (what ``tomllib`` gives, dates apart) as TOML, a top-level key a line."""
    return "".join(f"{_key(key)} = {_value(value)}\n" for key, value in data.items())


def _value(value: object) -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    if isinstance(value, bool | str):
        return json.dumps(value, ensure_ascii=False)  # TOML's basic strings have JSON's escapes
    if isinstance(value, int | float):
        return repr(value)
    raise ValueError(f"{type(value).__name__} in a scene")


def _key(key: str) -> str:
    plain = key.replace("-", "").replace("_", "")
    return key if plain.isascii() and plain.isalnum() else json.dumps(key, ensure_ascii=False)
