"""Changes of a study: dotted keys and their values, applied to its tables and told in words."""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from creak.errors import InputError, suggest
from creak.studies.file.places import overlap
from creak.studies.file.reader import Study, checked_study
from creak.studies.file.toml_text import toml_text

NAMED = ("contact", "excitation", "superelement", "nodes", "support", "test")
"""Tables of named tables: a change may not invent a name."""
LISTED = ("connector", "clip", "static")
"""Lists of tables: a change goes to a row that there is."""
SEEDED = ("multisine", "psd")
"""Signals with random phases."""
UNSEEDED = 1
"""Seed of a signal that says none."""
STRIDE = 1_000_000
"""Between the seeds of signals that are independent of each other."""


def with_changes(study: Study, changes: Mapping[str, Any]) -> Study:
    """The study with other values, checked as a study file is; its file stays as it is.

    Parameters
    ----------
    changes : dotted key -> value; rows of lists by number or by name, `clip.0.gap` or `clip.bumper.gap`.

    Raises
    ------
    InputError : a key that studies do not have, a name that this one does not have, or a wrong value.
    """
    if not changes:
        return study
    own = tomllib.loads(study.text)
    data = changed(own, changes, None)
    changes = {numbered(own, key): value for key, value in changes.items()}
    every = {**study.places.changes, **changes}
    try:
        text = toml_text(data)
        return checked_study(study.path, data, text, study.places.text, every)
    except InputError as error:
        wrong = next((k for k in changes if _alone_wrong(study.path, study.text, k, changes[k])), None)
        place = str(study.path) if wrong is None else f"the change {wrong} = {changes[wrong]!r} of {study.path}"
        raise InputError(error.what, where=place, expected=error.expected, fix=error.fix) from error
    except TypeError as error:
        raise InputError(str(error), where=str(study.path), expected="numbers, strings, lists and mappings") from error


def _alone_wrong(path: Path, text: str, key: str, value: Any) -> bool:
    """Whether this change alone cannot be made."""
    try:
        checked_study(path, changed(tomllib.loads(text), {key: value}, None), text)
    except InputError:
        return True
    return False


def read_changes(texts: Sequence[str]) -> dict[str, Any]:
    """`KEY=VALUE` words: the value as in a study file; one that is no TOML is taken for a string.

    Raises
    ------
    InputError : no `=`, no key, or a key given twice.
    """
    found: dict[str, Any] = {}
    for text in texts:
        key, sign, value = (part.strip() for part in text.partition("="))
        if not sign or not all(key.split(".")) or not value:
            raise InputError(f"{text!r} is no change", expected="KEY=VALUE, as contact.flange.clearance=3.2")
        if key in found:
            raise InputError(f"{key} is changed twice: to {found[key]!r} and to {value}", fix="Give it once.")
        found[key] = _value(value)
    return found


def _value(text: str) -> Any:
    try:
        tables = tomllib.loads(f"value = {text}")
    except tomllib.TOMLDecodeError:
        return text
    return tables["value"] if len(tables) == 1 else text


def changed(data: Mapping[str, Any], changes: Mapping[str, Any], seed: int | None) -> dict[str, Any]:
    """Tables of a study with changes applied, and other seeds of its random signals.

    Parameters
    ----------
    seed : of the random signals. Those with the same seed keep having the same, so they stay coherent; those with
        another stay independent: the k-th seed of the study in rising order, from 0, becomes `seed + k STRIDE`.

    Raises
    ------
    InputError : a change leads through something that is no table, or to a name that the study does not have; two
        change the same.
    """
    numbers = {key: numbered(data, key) for key in changes}
    for key in changes:
        clash = next((other for other in changes if other != key and overlap(numbers[key], numbers[other])), None)
        if clash is not None:
            raise InputError(f"{key} and {clash} change the same", fix="Give one of them.")
    out = copy.deepcopy(dict(data))
    for key, value in changes.items():
        _put(out, key, copy.deepcopy(value))
    if seed is not None:
        _reseed([table.get("signal") for table in out.get("excitation", {}).values()], seed)
    return out


def _reseed(signals: Sequence[Any], seed: int) -> None:
    """Give random signals other seeds; one that is no whole number stays, for the check of the study to tell."""
    random = [s for s in signals if isinstance(s, dict) and s.get("type") in SEEDED]
    own = [s.get("seed", UNSEEDED) for s in random]
    ranks = {one: k for k, one in enumerate(sorted({one for one in own if isinstance(one, int)}))}
    for signal, one in zip(random, own, strict=True):
        if isinstance(one, int):
            signal["seed"] = seed + ranks[one] * STRIDE


def _put(data: dict[str, Any], key: str, value: Any) -> None:
    words, table = key.split("."), data
    for depth, word in enumerate(words[:-1]):
        table = _inside(table, words, depth, word)
    if isinstance(table, list):
        table[checked_row(table, words, len(words) - 1)] = value
    else:
        table[words[-1]] = value


def _inside(table: Any, words: Sequence[str], depth: int, word: str) -> Any:
    if isinstance(table, list):
        inner = table[checked_row(table, words, depth)]
    else:
        if depth == 1 and words[0] in NAMED and word not in table:
            raise InputError(f"the study has no [{words[0]}.{word}]", fix=suggest(word, table))
        if depth == 0 and word in LISTED and word not in table:
            raise InputError(f"the study has no [[{word}]]", fix=f"It has {', '.join(sorted(table))}.")
        inner = table.setdefault(word, {})
    if not isinstance(inner, dict | list):
        raise InputError(f"{'.'.join(words[: depth + 1])} is not a table in the study, it is {inner!r}")
    return inner


def is_row(word: str) -> bool:
    """Whether a word of a key is the number of a row, in the one way to write it: 00 is none."""
    return word.isascii() and word.isdigit() and len(word) < 10 and (word == "0" or word[0] != "0")


def row_of(rows: Sequence[Any], word: str) -> int | None:
    """The row that a word of a key means: by its number, or by the name that it alone has; None: there is none."""
    if is_row(word):
        return int(word) if int(word) < len(rows) else None
    names = _names(rows)
    return names.index(word) if word and names.count(word) == 1 else None


def _names(rows: Sequence[Any]) -> list[str]:
    """Of each row, empty where it has none."""
    return [str(row.get("name") or "") if isinstance(row, Mapping) else "" for row in rows]


def numbered(data: Any, key: str) -> str:
    """A dotted key with the numbers of the rows that it names; what a study does not have stays as it is."""
    words = key.split(".")
    for k, word in enumerate(words):
        if isinstance(data, list) and (row := row_of(data, word)) is not None:
            words[k] = str(row)
        data = value_at(data, word)
    return ".".join(words)


def checked_row(rows: Sequence[Any], words: Sequence[str], depth: int, where: str = "") -> int:
    """The row that the word of a key at this depth means; InputError where there is none."""
    row, name = row_of(rows, words[depth]), ".".join(words[:depth])
    if row is None:
        last = f" to {name}.{len(rows) - 1}" if len(rows) > 1 else ""
        called = "".join(f", {name}.{x}" for x in _names(rows) if "." not in x and row_of(rows, x) is not None)
        told = f"{name}.0{last}{called}" if rows else ""
        raise InputError(f"the study has {len(rows)} [[{name}]]", where=where, expected=told)
    return row


def value_at(data: Any, key: str) -> Any:
    """Value of a dotted key, None where there is none."""
    for word in key.split("."):
        if isinstance(data, list) and (row := row_of(data, word)) is not None:
            data = data[row]
        elif isinstance(data, Mapping) and word in data:
            data = data[word]
        else:
            return None
    return data


def short_keys(keys: Sequence[str]) -> dict[str, str]:
    """Key -> its last words, as many as it takes to tell it from the others."""
    out = {}
    for key in keys:
        words = key.split(".")
        ends = [".".join(words[-n:]) for n in range(1, len(words) + 1)]
        others = [k for k in keys if k != key]
        out[key] = next((e for e in ends if e != "seed" and not any(f".{k}".endswith(f".{e}") for k in others)), key)
    return out


def change_words(changes: Mapping[str, Any], short: Mapping[str, str]) -> str:
    """Changes for people, `f_max=700,friction=0.2`."""
    return ",".join(f"{short[key]}={value_words(value)}" for key, value in changes.items())


def value_words(value: Any) -> str:
    """A value for people: numbers in short, of tables and lists only the values."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return f"{value:g}" if float(f"{value:g}") == value else repr(value)
    if isinstance(value, Mapping):
        return "+".join(map(value_words, value.values()))
    if isinstance(value, list):
        return "+".join(map(value_words, value))
    return str(value)
