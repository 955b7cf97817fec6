"""Reading a study file: TOML in, checked configuration out, errors with file and line."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from creak.errors import InputError, suggest
from creak.formats.deck.command_files import file_meant, plain_file
from creak.formats.endings import DECKS, is_deck
from creak.studies.file.case import Course, Driving, Lines, Listening, Touching
from creak.studies.file.config import FORCED, GONE, StudyConfig, TimeTable
from creak.studies.file.places import Places, dotted, line_of
from creak.studies.file.signals.tables import SignalTable
from creak.studies.file.table import Table
from creak.studies.file.toml_text import toml_value


@dataclass(frozen=True)
class Study:
    """What a study file, or a deck with its own transient step, asks for."""

    config: StudyConfig
    text: str
    """As TOML, or of a deck as JSON."""
    places: Places
    """Where it was written."""

    @property
    def path(self) -> Path:
        """The study file, or the deck."""
        return self.places.path

    @property
    def touching(self) -> Touching:
        """What may touch."""
        c, press_fit = self.config, any(table.press_fit for table in self.config.static)
        return Touching(c.contact, c.connector, c.clip, c.clips, press_fit, c.model.units, self.places)

    @property
    def driving(self) -> Driving:
        """What drives the model."""
        c = self.config
        return Driving(c.excitation, c.static, c.model.units, self.places)

    @property
    def course(self) -> Course:
        """How long the run is, and what of it is kept."""
        c = self.config
        until = c.reference.until if c.proof == "whole" and c.reduction.method != "none" else None
        drives = self.driving
        comes = drives.period, drives.repeats, drives.fade
        return Course(c.time, c.output, c.verification.f_max, *comes, until, self.places)

    @property
    def lines(self) -> Lines:
        """Between which parts relative motion is looked at."""
        c = self.config
        told, library = (c.limit.tolerance, c.limit.percentile), c.material_pairs
        return Lines(c.eline, c.contact.keys(), c.material_pair, library, *told, c.model.units, self.places)

    @property
    def listening(self) -> Listening:
        """Who hears the contacts."""
        c = self.config
        return Listening(c.listener, c.background, c.room, c.limit.sharpness_above, c.model.units, self.places)

    def tables(self, names: Sequence[str]) -> dict[str, Any]:
        """Name of a table -> that table."""
        return {name: getattr(self.config, name) for name in names}

    def with_tables(self, **tables: Table) -> Study:
        """The same study with other tables."""
        return replace(self, config=self.config.model_copy(update=tables))

    def from_anywhere(self) -> Study:
        """With the whole path of its file: for a process in another folder."""
        return replace(self, places=replace(self.places, path=self.path.resolve()))


def read_study(path: Path) -> Study:
    """Read and check a study file.

    Raises
    ------
    InputError : a deck, no such file, not TOML, unknown or missing key, wrong value, or something this version of
        creak does not do.
    """
    if is_deck(path):
        raise InputError(
            f"{path.name} is a deck",
            expected="a study file (.toml)",
            fix=f"Write a study that names the deck in [model]; `creak new {path.name}` writes a first one.",
        )
    if path.suffix.lower() != ".toml" and os.path.isfile(path):
        raise InputError(
            f"{path.name} is neither a study nor a deck",
            expected=f"a study (.toml) or a deck ({', '.join(DECKS)})",
            fix="Results of other programs are not read: export the model as a deck.",
        )
    data, text = read_toml(path, "study")
    return checked_study(path, data, text)


def checked_study(
    path: Path,
    data: Mapping[str, Any],
    text: str,
    file_text: str | None = None,
    changes: Mapping[str, Any] | None = None,
) -> Study:
    """A study from its tables.

    Parameters
    ----------
    file_text : text of the file, where the study was changed since it was read: what lines are counted in.
    changes : dotted key -> value that it was changed to since.

    Raises
    ------
    InputError : unknown or missing key, wrong value.
    """
    try:
        config = StudyConfig.model_validate(data)
    except ValidationError as error:
        raise explain(path, text, error) from error
    places = Places(path, text if file_text is None else file_text, changes or {})
    check_idle(config, data, places.where)
    return Study(config, text, places)


OWN = {"hht": {"alpha"}, "generalised-alpha": {"rho_inf"}}
"""Keys of [time] that belong to an integrator."""


def check_idle(config: StudyConfig, data: Mapping[str, Any], where: Callable[..., str]) -> None:
    """Raise InputError where a study, read from these tables, has a key that would do nothing beside its others.

    Parameters
    ----------
    where : table, key -> where it was written.
    """
    _check_time(config.time, data.get("time", {}), where)
    if config.reference.until is not None and config.proof != "whole":
        raise InputError(
            f"until = {config.reference.until:g} ends a run of the unreduced model from rest, and run = "
            f"{toml_value(config.reference.run)} makes none",
            where=where("reference", "until"),
            expected='run = "whole" beside it, or no run',
            fix="Leave out one of both.",
        )
    if config.reference.until is not None and config.reduction.method == "none":
        raise InputError(
            f"until = {config.reference.until:g} ends the unreduced run that a reduced one is compared with, and "
            'method = "none" reduces nothing',
            where=where("reference", "until"),
            expected="a reduction beside it",
            fix="Leave it out; [time] end says how long the run is.",
        )


def _check_time(table: TimeTable, given: Mapping[str, Any], where: Callable[..., str]) -> None:
    """Raise InputError where [time], given with these keys, asks for an accuracy and forces a scheme."""
    forced = sorted((FORCED | {"rho_inf"}) & given.keys())
    if "accuracy" in given and not table.exact:
        raise InputError(
            f"accuracy = {table.accuracy!r} chooses the steps itself, {', '.join(forced) or 'integrator'} would force "
            "them",
            where=where("time", "accuracy"),
            expected="one of both",
            fix="Leave out all but accuracy.",
        )
    unused = sorted({"alpha", "rho_inf"} & given.keys() - OWN.get(table.integrator, set()))
    if not table.exact and unused:
        raise InputError(
            f"{unused[0]} is nothing that integrator = {table.integrator!r} takes",
            where=where("time", unused[0]),
            expected=", ".join(sorted(FORCED - {"alpha"} | OWN[table.integrator])),
            fix="Leave it out, or take the integrator that it belongs to: alpha hht, rho_inf generalised-alpha.",
        )
    if table.exact and forced:
        raise InputError(
            f'integrator = "exact" chooses its steps itself: {", ".join(forced)} have no meaning',
            where=where("time", forced[0]),
            fix="Leave them out, or name the integrator that they are for.",
        )


def read_toml(path: Path, kind: str) -> tuple[dict[str, Any], str]:
    """Tables and text of a TOML file, without the mark that editors put before UTF-8; `kind` names it in messages.

    Raises
    ------
    InputError : no such file, unreadable, or not TOML.
    """
    try:
        text = plain_file(path).read_text(encoding="utf-8-sig")
    except FileNotFoundError as error:
        raise InputError(f"no such {kind} file: {path}", fix=file_meant(path) or "Check the path.") from error
    except (OSError, ValueError) as error:
        text = "it is not text in UTF-8" if isinstance(error, UnicodeDecodeError) else str(error)
        reason = getattr(error, "strerror", None) or text
        raise InputError(f"cannot read the {kind} file {path}: {reason}", fix="Give the .toml file.") from error
    try:
        return tomllib.loads(text), text
    except tomllib.TOMLDecodeError as error:
        fix = "Write paths with / instead of \\." if "\\" in str(error) else "Repair that line."
        comma = DECIMAL_COMMA.search(_line_told(text, str(error)))
        fix = f"Write {comma[1]}.{comma[2]}: decimals have a point." if comma else fix
        raise InputError(f"not valid TOML: {error}", where=path, fix=fix) from error
    except (ValueError, RecursionError) as error:
        what = "tables or lists nested too deep" if isinstance(error, RecursionError) else "a number of too many digits"
        raise InputError(f"cannot read the {kind} file: it has {what}", where=path, fix="Remove them.") from error


DECIMAL_COMMA = re.compile(r"=\s*([-+]?\d+),(\d+)\s*(#|$)")
QUOTED_NUMBER = re.compile(r"\s*([-+]?\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?)\s*[^\d]*$")


def _line_told(text: str, message: str) -> str:
    """The line of a file that a message of the TOML reader tells."""
    told = re.search(r"at line (\d+)", message)
    return "" if told is None else text.splitlines()[int(told[1]) - 1]


SIGNALS = (
    *("multisine", "sine", "step", "table", "record", "smooth-step", "periodic", "psd", "sweep"),
    *("half-sine", "trapezoid"),
)
OTHER_MEMBER = ("literal_error", "float_type", "string_type", "model_type", "dict_type", "none_required")
"""Errors of union members that the value was not meant for."""
KINDS = {
    "string": "a text in quotes",
    "list": "a list in brackets",
    "tuple": "a list in brackets",
    "float": "a number",
    "int": "a whole number",
    "bool": "true or false",
    "model": "a table",
    "dict": "a table",
}
"""First word of an error of a value of another kind -> what is expected."""


def explain(path: Path, text: str, error: ValidationError, root: type[BaseModel] = StudyConfig) -> InputError:
    """The first problem of a validation, in the words of the file; `root` is what the file was checked against."""
    # A misspelt key explains a missing one; of a union the member that was meant explains more than the others.
    named = {f.alias or name for name, f in root.model_fields.items() if get_origin(f.annotation) is dict}

    def rank(e: ErrorDetails) -> tuple[bool, bool, bool]:
        return not _is_nameless(e, named), e["type"] != "extra_forbidden", e["type"] in OTHER_MEMBER

    problem = min(error.errors(), key=rank)
    loc = problem["loc"]
    keys = tuple(k for k, before in zip(loc, (None, *loc), strict=False) if not _is_tag(k, before))
    where = f"{path}:{line_of(text, keys)}"
    name = dotted(keys)
    if problem["type"] == "extra_forbidden":
        known = _known_keys(problem["loc"][:-1], root)
        return InputError(f"unknown key {name!r}", where=where, fix=suggest(str(keys[-1]), known))
    if problem["type"] == "missing" and isinstance(keys[-1], int):
        return InputError(f"{dotted(keys[:-1])} has {keys[-1]} value(s)", where=where, expected="one more at least")
    if problem["type"] == "missing":
        return InputError(f"{name!r} is missing", where=where, fix=_told_of(problem["loc"], root))
    if problem["type"] == GONE:
        return InputError(
            f"{name} = {problem['input']!r}: {problem['msg']}",
            where=where,
            expected='method = "craig-bampton", and [time] without integrator and step',
            fix="Change it: motion between contacts is exact then, and contact is resolved in its own time scale.",
        )
    if problem["type"] in ("union_tag_invalid", "union_tag_not_found"):
        kinds = [get_args(t.model_fields["type"].annotation)[0] for t in get_args(get_args(SignalTable)[0])]
        got = problem["input"].get("type") if isinstance(problem["input"], dict) else problem["input"]
        return InputError(
            f"{name} has type {got!r}", where=where, expected=f"one of {', '.join(kinds)}", fix=suggest(str(got), kinds)
        )
    if header := _right_header(problem, keys, named):
        written = f"[[{keys[0]}]]" if isinstance(problem["input"], list) else f"[{keys[0]}]"
        return InputError(f"{written} is not how such a table starts", where=where, fix=f"Write {header}.")
    message = problem["msg"].removeprefix("Value error, ")
    kind, _, how = problem["type"].partition("_")
    if kind in KINDS and how in ("type", "parsing", "from_float"):
        message = f"input should be {KINDS[kind]}"
    words = _words_beside(error, loc) if problem["type"].startswith(("float_", "bool_")) else ""
    message += words
    got = problem["input"]
    shown = "" if isinstance(got, dict) else f" = {got!r}"
    text = f"{message[:1].lower()}{message[1:]}"
    return InputError(f"{name}{shown}: {text}" if name else text, where=where, fix=_fix(problem, words))


def _fix(problem: ErrorDetails, words: str) -> str:
    """What to write instead of a wrong value, where that can be told; systems of units are no slips of each other."""
    got, fix = problem["input"], "Correct the value."
    if not isinstance(got, str) or problem["loc"][-1] == "units":
        return fix
    number = QUOTED_NUMBER.match(got) if problem["type"].endswith("_parsing") else None
    if number:
        return f"Write {number[1].replace(',', '.')}, without quotes and unit."
    words = str(problem["ctx"]["expected"]) if problem["type"] == "literal_error" else words
    meant = suggest(got, re.findall(r"'([^']+)'", words))
    return meant if meant.startswith("Did") else fix


def _is_nameless(problem: ErrorDetails, named: Collection[str]) -> bool:
    """Whether a key stands where a table should: [NAME] was left out."""
    return problem["type"] == "model_type" and len(problem["loc"]) == 2 and problem["loc"][0] in named


def _right_header(problem: ErrorDetails, keys: tuple[int | str, ...], named: Collection[str]) -> str:
    """How the table of a wrong header is written; empty where the header is right."""
    kind, given = problem["type"], problem["input"]
    if _is_nameless(problem, named):
        return f"[{keys[0]}.NAME]"
    if len(keys) != 1 or not isinstance(given, dict | list):
        return ""
    headers = {"list_type": f"[[{keys[0]}]]", "dict_type": f"[{keys[0]}.NAME]", "model_type": f"[{keys[0]}]"}
    return headers.get(kind, "")


def _words_beside(error: ValidationError, loc: tuple[int | str, ...]) -> str:
    """The words that a key takes besides a number or a truth value; empty where it takes none."""
    if not _is_tag(loc[-1], None):
        return ""
    words = [e["ctx"]["expected"] for e in error.errors() if e["type"] == "literal_error" and e["loc"][:-1] == loc[:-1]]
    return f", or {' or '.join(words)}" if words else ""


def _is_tag(key: Any, before: Any) -> bool:
    """Pydantic adds the tag of a union member to the location; the user never wrote it."""
    if before == "signal" and key in SIGNALS:
        return True
    if before in ("friction", "tolerance") and key in ("number", "text", "table"):
        return True
    return key in ("literal['auto']", "float", "str", "bool") or (
        isinstance(key, str) and ("[" in key or "constrained" in key)
    )


def _told_of(loc: Sequence[str | int], root: type[BaseModel]) -> str:
    """What to add at a location where a key is missing, in the words of the schema."""
    from creak.studies.file.schema import texts_of

    table = _table_at(loc[:-1], root)
    text = "" if table is None else texts_of(table).get(str(loc[-1]), "")
    return f"Add it: {' '.join(text.split())}" if text else "Add it."


def _known_keys(loc: Sequence[str | int], root: type[BaseModel]) -> list[str]:
    """Keys allowed in the table at a location."""
    table = _table_at(loc, root)
    return [] if table is None else [field.alias or name for name, field in table.model_fields.items()]


def _table_at(loc: Sequence[str | int], root: type[BaseModel]) -> type[BaseModel] | None:
    """The one kind of table that may stand at a location."""
    table: Any = root
    for key in loc:
        if isinstance(table, type) and issubclass(table, BaseModel):
            fields = {f.alias or name: f for name, f in table.model_fields.items()}
            field = fields.get(str(key))
            if field is None:  # the NAME of a table, or the number of a row
                continue
            table = field.annotation
            members = [t for t in _flatten(table) if isinstance(t, type) and issubclass(t, BaseModel)]
            table = members[0] if len(members) == 1 else members
        elif isinstance(table, list):
            named = [t for t in table if str(key) in get_args(t.model_fields["type"].annotation)]
            table = named[0] if named else table
    return table if isinstance(table, type) and issubclass(table, BaseModel) else None


def _flatten(annotation: Any) -> list[Any]:
    inner = get_args(annotation)
    return [annotation] if not inner else [x for a in inner for x in _flatten(a)]
