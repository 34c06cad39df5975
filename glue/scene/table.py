"""One table of the scene file, read key by key; problems and defaults pile up in a :class:`Log`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from glue.scene.catalogue import closest
from glue.scene.fields import REQUIRED, kind, quoted


class Log:
    """What reading one file turned up: problems (sentences with file and key path) and defaults used."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self.problems: list[str] = []
        self.defaults: list[str] = []

    def problem(self, key_path: str, sentence: str) -> None:
        self.problems.append(f"{self.file}: {key_path}: {sentence}")

    def default(self, key_path: str, value: object, source: str) -> None:
        self.defaults.append(f"{key_path} = {quoted(value)} ({source})")


class Table:
    """A table of the file at ``path`` ("" for the top). A value that is refused is logged and read as None."""

    def __init__(self, data: Mapping[str, object], path: str, log: Log) -> None:
        self.data, self.path, self.log = data, path, log

    def __contains__(self, key: str) -> bool:
        return key in self.data

    def at(self, key: str) -> str:
        """Full path of ``key``."""
        return f"{self.path}.{key}" if self.path else key

    def problem(self, key: str, sentence: str) -> None:
        self.log.problem(self.at(key), sentence)

    def get(self, key: str, field) -> object:
        """The checked value of ``key``, its printed default when absent, None when refused."""
        if key not in self.data:
            if field.default is REQUIRED:
                self.problem(key, f"missing, and required; {field.allowed}")
                return None
            self.log.default(self.at(key), field.default, field.source)
            return field.default
        problem = field.problem(self.data[key])
        if problem:
            self.problem(key, problem)
            return None
        return field.convert(self.data[key])

    def table(self, key: str, holds: str) -> Table | None:
        """The table ``[key]`` that must be there; ``holds`` names its keys for the message."""
        if key not in self.data:
            self.problem(key, f"missing, and required; write a table [{self.at(key)}] with {holds}")
            return None
        return self.optional_table(key)

    def optional_table(self, key: str) -> Table | None:
        """The table ``[key]``, empty when absent, None when it is something else."""
        value = self.data.get(key, {})
        if not isinstance(value, Mapping):
            self.problem(key, f"must be a table [{self.at(key)}], not {kind(value)}")
            return None
        return Table(value, self.at(key), self.log)

    def refuse_not_built(self, sentences: Mapping[str, str]) -> None:
        """Refuse the known keys of later versions that are present, each with its sentence."""
        for key, sentence in sentences.items():
            if key in self.data:
                self.problem(key, sentence)

    def refuse_unknown(self, known: Iterable[str], elsewhere: Mapping[str, str]) -> None:
        """Refuse every key not in ``known``. ``elsewhere``: key -> the table it belongs to."""
        known = list(known)
        for key in self.data:
            if key in known:
                continue
            guess = closest(key, known)
            if key in elsewhere:
                hint = f"it belongs in {elsewhere[key]}; "
            else:
                hint = f'did you mean "{guess}"? ' if guess else ""
            self.problem(key, f"unknown key; {hint}allowed: {', '.join(known)}")
