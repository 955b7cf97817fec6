"""Frozen dataclasses <-> HDF5: a group for each that holds arrays, a dataset for each array, JSON for all else."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterator
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

import h5py
import numpy as np

T = TypeVar("T")
BIG = 10_000
"""Numbers from which a dataset is compressed."""
COMPRESSED = {"compression": "gzip", "compression_opts": 4, "shuffle": True}
SMALL = np.iinfo(np.int32)


def write_tree(group: h5py.Group, value: Any, skip: Collection[str] = (), packed: bool = True) -> None:
    """Write the fields of a dataclass into a group, each under its name.

    The values decide: arrays are datasets, 64-bit integers as 32-bit ones where they fit; dataclasses, tuples and
    dictionaries that hold an array somewhere are groups (of numbers from 0, or of the keys); all else is a dataset with
    JSON, infinities and not-a-numbers as Python writes them. What is None is left out, in pydantic models too: there it
    is a key that is not given.

    Parameters
    ----------
    skip : fields of `value` that are left out. packed : whether large arrays are compressed.
    """
    for field in fields(value):
        if field.name not in skip:
            _write(group, field.name, getattr(value, field.name), packed)


def read_tree(kind: type[T], group: h5py.Group, **given: Any) -> T:
    """The dataclass that `write_tree` wrote, with the values `given` for fields that it left out.

    What is stored tells arrays from the rest, type hints which dataclass, tuple or path the rest is. Integers come back
    with 64 bits.

    Raises
    ------
    KeyError, TypeError, ValueError : the group does not hold such a dataclass.
    """
    found = {name: given[name] if name in given else _read(group, name, hint) for name, hint in _hints(kind)}
    return kind(**found)


def _fields(kind: Any) -> tuple[tuple[str, Any], ...]:
    """Names of the fields of a dataclass, and their hints."""
    known = get_type_hints(kind)
    return tuple((f.name, known[f.name]) for f in fields(kind))


_hints: Callable[[Any], tuple[tuple[str, Any], ...]] = cache(_fields)


def _bare(hint: Any) -> Any:
    """A hint without its `| None`."""
    members = [h for h in get_args(hint) if h is not NoneType] if get_origin(hint) in (Union, UnionType) else [hint]
    return members[0] if len(members) == 1 else hint


def _is_no_array(hint: Any) -> bool:
    """Whether a hint is plainly one of something else; that of an array has many spellings."""
    if isinstance(hint, type):
        return not issubclass(hint, np.ndarray)
    return get_origin(hint) in (tuple, list, dict)


def _holds_arrays(value: Any) -> bool:
    if isinstance(value, np.ndarray):
        return True
    if is_dataclass(value) and not isinstance(value, type):
        return any(_holds_arrays(getattr(value, f.name)) for f in fields(value))
    if isinstance(value, dict):
        return any(_holds_arrays(one) for one in value.values())
    return isinstance(value, list | tuple) and any(_holds_arrays(one) for one in value)


def _write(group: h5py.Group, name: str, value: Any, packed: bool) -> None:
    if value is None:
        return
    if isinstance(value, np.ndarray):
        data = _short(value)
        group.create_dataset(name, data=data, **(COMPRESSED if packed and data.size > BIG else {}))
    elif not _holds_arrays(value):
        group.create_dataset(name, data=json.dumps(_plain(value)), dtype=h5py.string_dtype())
    elif is_dataclass(value):
        write_tree(group.create_group(name), value, packed=packed)
    else:
        inner = group.create_group(name, track_order=True)
        for key, one in _items(value):
            _write(inner, key, one, packed)


def _items(value: Any) -> Iterator[tuple[str, Any]]:
    return iter(value.items()) if isinstance(value, dict) else ((str(k), one) for k, one in enumerate(value))


def _short(data: Any) -> Any:
    """64-bit integers as 32-bit ones where they fit."""
    if data.dtype == np.int64 and (not data.size or (data.min() >= SMALL.min and data.max() <= SMALL.max)):
        return data.astype(np.int32)
    return data


def _long(data: Any) -> Any:
    """32-bit integers as 64-bit ones."""
    return data.astype(np.int64) if data.dtype == np.int32 else data


def _read(group: h5py.Group, name: str, hint: Any) -> Any:
    if name not in group and NoneType in get_args(hint):
        return None
    item, hint = group[name], _bare(hint)
    if isinstance(item, h5py.Dataset):
        is_array = not h5py.check_string_dtype(item.dtype)
        value = item[()] if is_array else json.loads(item.asstr()[()])
        if _is_no_array(hint) == is_array and (is_array or isinstance(value, list | dict)):
            raise TypeError(f"{item.name} holds {'an array' if is_array else 'no array'}")
        return _long(value) if is_array else _made(hint, value)
    if is_dataclass(hint) and isinstance(hint, type):
        return read_tree(hint, item)
    kind, inside = get_origin(hint), get_args(hint)
    if kind is dict:
        return {key: _read(item, key, inside[1]) for key in item}
    hints = [inside[0]] * len(item) if kind is list or inside[1:] == (...,) else inside
    return kind(_read(item, str(k), h) for k, h in zip(range(len(item)), hints, strict=True))


def _plain(value: Any) -> Any:
    """Dataclasses, pydantic models, paths and NumPy's numbers as what JSON knows."""
    if hasattr(value, "model_dump"):
        return value.model_dump(exclude_none=True)
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: _plain(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, Path):
        return str(value)
    return value.item() if isinstance(value, np.generic) else value


def _made(hint: Any, value: Any) -> Any:
    """What `_plain` took apart."""
    hint = _bare(hint)
    if value is None:
        return None
    if hasattr(hint, "model_validate"):
        return hint.model_validate(value)
    if is_dataclass(hint) and isinstance(hint, type):
        return hint(**{name: _made(h, value[name]) for name, h in _hints(hint)})
    kind, inside = get_origin(hint), get_args(hint)
    if kind is dict:
        return {key: _made(inside[1], one) for key, one in value.items()}
    if kind is list or (kind is tuple and inside[1:] == (...,)):
        return kind(_made(inside[0], one) for one in value)
    if kind is tuple:
        return tuple(_made(h, one) for h, one in zip(inside, value, strict=True))
    return hint(value) if hint is Path else value
