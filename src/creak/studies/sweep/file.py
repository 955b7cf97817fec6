"""The sweep file: a base study, a grid of changes, cases of their own, seeds."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, ValidationError, model_validator

from creak.errors import InputError
from creak.studies.file.changes import value_at
from creak.studies.file.config import StudyConfig
from creak.studies.file.places import overlap
from creak.studies.file.reader import explain, read_study, read_toml
from creak.studies.file.table import Table

OF_THE_SWEEP = ("title", "base", "seeds")
"""Keys that stand above the first table."""


def _changes(values: Mapping[str, Any], table: str) -> None:
    """Check the keys of changes: dotted keys of the study file, in quotes."""
    for key, value in values.items():
        if key in OF_THE_SWEEP and key != "title":
            raise ValueError(f"{key!r} belongs to the sweep: write it above the first [grid] or [[case]]")
        if isinstance(value, dict) and "." not in key:
            inner = next(iter(value), "f_max")
            raise ValueError(f'write keys of {table} one by one and in quotes: "{key}.{inner}" = ...')


def _gives_seed(key: str, value: Any) -> bool:
    """Whether a change gives a signal its seed, by itself or in a table."""
    words, whole = key.split("."), ["signal", "seed"]
    inside = whole[len(words[2:]) :]
    if words[0] != "excitation" or words[2:] != whole[: len(words[2:])]:
        return False
    return not inside or value_at(value, ".".join(inside)) is not None


class CaseTable(Table):
    """[[case]]: changes that belong together, combined with the grid and the seeds."""

    name: Annotated[str, Field(min_length=1)] | None = None
    changes: dict[str, Any] = Field(default_factory=dict)
    """Dotted key of the study file -> value."""

    @model_validator(mode="before")
    @classmethod
    def _keys(cls, data: Any) -> Any:
        if isinstance(data, dict):
            _changes({k: v for k, v in data.items() if k in ("base", "seeds")}, "case")
            if isinstance(data.get("changes"), dict):
                _changes(data["changes"], "changes")
        return data

    @model_validator(mode="after")
    def _says_something(self) -> CaseTable:
        if self.name is None and not self.changes:
            raise ValueError("a case needs a name or changes")
        return self


class SweepConfig(Table):
    """The whole sweep file."""

    title: str = ""
    base: str
    """Path of the study, relative to the sweep file."""
    grid: dict[str, Annotated[list[Any], Field(min_length=1)]] = Field(default_factory=dict)
    """Dotted key of the study file -> values; every combination is a case."""
    case: list[CaseTable] = Field(default_factory=list)
    seeds: list[Annotated[int, Field(ge=0)]] = Field(default_factory=list)
    """Of every multisine and psd; those whose seeds differ in the base study stay independent."""

    @model_validator(mode="before")
    @classmethod
    def _keys(cls, data: Any) -> Any:
        if isinstance(data, dict) and isinstance(data.get("grid"), dict):
            _changes(data["grid"], "grid")
        return data

    @model_validator(mode="after")
    def _varies(self) -> SweepConfig:
        if not (self.grid or self.case or self.seeds):
            raise ValueError("the sweep changes nothing: give [grid], [[case]] or seeds")
        for key, values in {**self.grid, "seeds": self.seeds}.items():
            twice = [v for i, v in enumerate(values) if v in values[:i]]
            if twice:
                raise ValueError(f"{key} lists {twice[0]!r} twice")
        for case in self.case:
            for key in case.changes:
                others = [*self.grid, *(k for k in case.changes if k != key)]
                clash = next((k for k in others if overlap(k, key)), None)
                if clash is not None:
                    raise ValueError(f"the case {case.name or ''!r} changes {key!r}, which {clash!r} changes too")
        changes = [(key, value) for key, values in self.grid.items() for value in values]
        changes += [change for case in self.case for change in case.changes.items()]
        seeded = next((key for key, value in changes if _gives_seed(key, value)), None)
        if self.seeds and seeded is not None:
            raise ValueError(f"seeds and {seeded!r} both change the seed of a signal: give one of them")
        keys = list(self.grid)
        for i, key in enumerate(keys):
            clash = next((k for k in keys[:i] if overlap(k, key)), None)
            if clash is not None:
                raise ValueError(f"the grid changes both {clash!r} and {key!r}")
        return self


@dataclass(frozen=True)
class SweepFile:
    """A sweep file, where it lies, and the study that it starts from."""

    path: Path
    config: SweepConfig
    text: str
    base: Path
    data: Mapping[str, Any]
    """Tables of the base study as written."""
    study: StudyConfig
    """The base study, checked."""

    def where(self, key: str = "") -> str:
        """file:line of a key, as it is quoted in the file; just the file where it is not found."""
        pattern = re.compile(rf"""(^|[\s,{{"']){re.escape(key)}["']?\s*=""")
        for number, line in enumerate(self.text.splitlines(), start=1):
            if key and pattern.search(line.split("#")[0]):
                return f"{self.path}:{number}"
        return str(self.path)

    @property
    def keys(self) -> list[str]:
        """Every key that some case changes, in the order of the file."""
        return list(dict.fromkeys([*self.config.grid, *(k for c in self.config.case for k in c.changes)]))


def read_sweep(path: Path) -> SweepFile:
    """Read and check a sweep file and its base study.

    Raises
    ------
    InputError : either is missing, not TOML, or has an unknown key or a wrong value.
    """
    data, text = read_toml(path, "sweep")
    try:
        config = SweepConfig.model_validate(data)
    except ValidationError as error:
        raise explain(path, text, error, SweepConfig) from error
    base = path.parent / config.base
    if not base.exists():
        raise InputError(
            f"no such study file: {base}",
            where=f"{path} [base]",
            expected="the path of a study, relative to the sweep file",
            fix="Check the path.",
        )
    study = read_study(base)
    return SweepFile(path, config, text, base, read_toml(base, "study")[0], study.config)
