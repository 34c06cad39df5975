"""One table of the scene file, read key by key; problems and defaults pile up in a :class:`Log`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from glue.scene.catalogue import closest
from glue.scene.fields import REQUIRED, Field, kind, quoted, show

NOTHING: Mapping[str, str] = {}


class Log:
    """What reading one file turned up: problems (sentences with file and key path) and defaults used."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self.problems: list[str] = []
        self.defaults: list[str] = []

    def problem(self, key_path: str, sentence: str) -> None:
        self.problems.append(f"{self.file}: {key_path}: {sentence}")

    def default(self, key_path: str, value: object, source: str) -> None:
        if isinstance(value, tuple):
            shown = f"[{', '.join(show(item) for item in value)}]"
        else:
            shown = show(value) if isinstance(value, float) else f'"{value}"' if isinstance(value, str) else quoted(value)
        self.defaults.append(f"{key_path} = {shown} ({source})")


class Table:
    """The table at ``path`` of the file ("" for the top). A refused value is logged and read as None."""

    def __init__(self, data: Mapping[str, object], path: str, log: Log) -> None:
        self.data, self.path, self.log = data, path, log

    def __contains__(self, key: str) -> bool:
        return key in self.data

    def at(self, key: str) -> str:
        """Full path of ``key``."""
        return f"{self.path}.{key}" if self.path else key

    def problem(self, key: str, sentence: str) -> None:
        self.log.problem(self.at(key), sentence)

    def get(self, key: str, field: Field) -> object:
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

    def get_all(self, fields: Mapping[str, Field]) -> dict[str, object]:
        """:meth:`get` of every key in ``fields``."""
        return {key: self.get(key, field) for key, field in fields.items()}

    def several(self, key: str, holds: str, most: int) -> list[Table] | None:
        """The required table ``[key]``, or up to ``most`` of an array ``[[key]]``; None when it is neither.

        Tables of an array are called key[1], key[2], … unless there is one only.
        """
        value = self.data.get(key)
        if not isinstance(value, list):
            table = self.table(key, holds)
            return None if table is None else [table]
        if not value or not all(isinstance(item, Mapping) for item in value):
            wrong = "must be a table, or tables, not an array of something else" if value else "must not be empty"
            self.problem(key, f"{wrong}; allowed: one table [{key}], or several written [[{key}]]")
            return None
        if len(value) > most:
            self.problem(key, f"must be at most {most} tables, not {len(value)}; allowed 1..{most}")
            return None
        names = [key] if len(value) == 1 else [f"{key}[{number}]" for number in range(1, len(value) + 1)]
        return [Table(item, self.at(name), self.log) for name, item in zip(names, value)]

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

    def refuse_others(
        self,
        known: Iterable[str],
        *,
        not_built: Mapping[str, str] = NOTHING,
        elsewhere: Mapping[str, str] = NOTHING,
    ) -> None:
        """Refuse every key that is not ``known``.

        ``not_built``: key of a later version -> the sentence that says what this version has instead.
        ``elsewhere``: key -> the table it belongs to.
        """
        known = list(known)
        for key in self.data:
            if key in known:
                continue
            if key in not_built:
                self.problem(key, not_built[key])
                continue
            guess = closest(key, [*known, *not_built])
            if key in elsewhere:
                hint = f"it belongs in {elsewhere[key]}; "
            else:
                hint = f'did you mean "{guess}"? ' if guess else ""
            self.problem(key, f"unknown key; {hint}allowed: {', '.join(known)}")
