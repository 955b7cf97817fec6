"""Measured time histories of files of the trade: RPC III, and functions (data set 58) of universal files.

RPC III is of test rigs (MTS): records of 128 bytes (keyword 32, value 96), then groups of samples. A group holds
`PTS_PER_GROUP` samples of each channel in turn; the last one is filled up. Integers stand for their value times
SCALE.CHAN_n."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError, suggest
from creak.formats.deck.command_files import plain_file
from creak.formats.measured.modes import Channel
from creak.formats.measured.uff_functions import read_uff_functions

BLOCK, RECORD, KEY = 512, 128, 32
ORDERS = {"BINARY": "<", "BINARY_IEEE_LITTLE_END": "<", "BINARY_IEEE_BIG_END": ">"}
KINDS = {"SHORT_INTEGER": "i2", "FLOATING_POINT": "f4"}
MOST_BLOCKS = 4096


def read_rpc3(path: Path) -> list[Channel]:
    """The channels of a time history.

    Raises
    ------
    InputError : not such a file, another kind of data in it, or cut short.
    """
    data = plain_file(path).read_bytes()
    first = _records(data[:BLOCK])
    if first.get("FORMAT", "").upper() not in ORDERS:
        raise InputError("not a file of RPC III", where=path, expected="a header that begins with FORMAT")
    blocks = _whole(first, "NUM_HEADER_BLOCKS", path)
    if not 1 <= blocks <= MOST_BLOCKS or len(data) < BLOCK * blocks:
        raise _short(path)
    head = _records(data[: BLOCK * blocks])
    kind = head.get("DATA_TYPE", "SHORT_INTEGER").upper()
    if head.get("FILE_TYPE", "TIME_HISTORY").upper() != "TIME_HISTORY" or kind not in KINDS:
        raise InputError(
            f"an RPC III file with {head.get('FILE_TYPE', '')} {kind}".replace("  ", " "),
            where=path,
            expected="TIME_HISTORY of SHORT_INTEGER or FLOATING_POINT",
        )
    count, group = _whole(head, "CHANNELS", path), _whole(head, "PTS_PER_GROUP", path)
    frames = _whole(head, "FRAMES", path) + _whole(head, "HALF_FRAMES", path, 0)
    points, step = frames * _whole(head, "PTS_PER_FRAME", path), _number(head, "DELTA_T", path)
    if min(count, group, points) < 1 or not step > 0.0:
        raise InputError("an RPC III file without samples, or without a step", where=path)
    groups = math.ceil(points / group)
    form = np.dtype(ORDERS[head["FORMAT"].upper()] + KINDS[kind])
    if len(data) < BLOCK * blocks + groups * count * group * form.itemsize:
        raise _short(path)
    raw = np.frombuffer(data, form, groups * count * group, BLOCK * blocks).reshape(groups, count, group)
    found = []
    for k in range(count):
        scale = _number(head, f"SCALE.CHAN_{k + 1}", path) if kind == "SHORT_INTEGER" else 1.0
        values: FloatArray = scale * raw[:, k].ravel()[:points].astype(np.float64)
        name = head.get(f"DESC.CHAN_{k + 1}", "") or str(k + 1)
        found.append(Channel(name, head.get(f"UNITS.CHAN_{k + 1}", ""), 0.0, step, values))
    return found


def _records(head: bytes) -> dict[str, str]:
    found: dict[str, str] = {}
    for at in range(0, len(head) - RECORD + 1, RECORD):
        key, value = (
            part.split(b"\0")[0].decode("latin-1").strip()
            for part in (head[at : at + KEY], head[at + KEY : at + RECORD])
        )
        if key:
            found.setdefault(key.upper(), value)
    return found


def _whole(head: dict[str, str], key: str, path: Path, default: int | None = None) -> int:
    if key not in head and default is not None:
        return default
    try:
        return int(head[key])
    except (KeyError, ValueError) as error:
        got = repr(head[key]) if key in head else "missing"
        raise InputError(f"{key} of the RPC III file is {got}", where=path, expected="a whole number") from error


def _number(head: dict[str, str], key: str, path: Path) -> float:
    try:
        value = float(head[key])
    except (KeyError, ValueError):
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{key} of the RPC III file is {head.get(key, 'missing')!r}", where=path, expected="a number")
    return value


def _short(path: Path) -> InputError:
    return InputError("the RPC III file is cut short: it ends before its samples do", where=path, fix="Copy it again.")


READERS: dict[str, Callable[[Path], list[Channel]]] = {
    **dict.fromkeys((".rsp", ".drv", ".rpc", ".rpc3", ".tim"), read_rpc3),
    **dict.fromkeys((".uff", ".unv", ".u58"), read_uff_functions),
}
"""Ending of a file -> its reader."""
MOST_NAMES = 12
"""That a message lists."""
Item = TypeVar("Item")


def is_measured(path: Path) -> bool:
    """Whether the ending is one of `READERS`."""
    return path.suffix.lower() in READERS


def read_channels(path: Path) -> list[Channel]:
    """All channels of a file.

    Raises
    ------
    InputError : no such file; it is cut short, or not of its kind.
    """
    try:
        return READERS[path.suffix.lower()](path)
    except FileNotFoundError as error:
        raise InputError(f"no such file: {path}", fix="Check the path.") from error
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from error


def chosen_channel(path: Path, wanted: str | int | None, where: str) -> Channel:
    """The channel of a name, or of a number from 1; without either the only one.

    Raises
    ------
    InputError : as `read_channels`; there is no such channel, or more than one and none is named.
    """
    channels = read_channels(path)
    return chosen(channels, [c.name for c in channels], "channel", wanted, path, where)


def chosen(
    found: Sequence[Item], names: Sequence[str], key: str, wanted: str | int | None, path: Path, where: str
) -> Item:
    """Of what a file holds, that of a name, in any case of letters, or of a number from 1; without either the only one.

    Parameters
    ----------
    key : of the study, by which it is chosen.

    Raises
    ------
    InputError : there is none, or more than one and none is named.
    """
    if isinstance(wanted, int) and 1 <= wanted <= len(found):
        return found[wanted - 1]
    if wanted is None and len(found) == 1:
        return found[0]
    alike = [k for k, name in enumerate(names) if isinstance(wanted, str) and name.upper() == wanted.upper()]
    if len(alike) == 1:
        return found[alike[0]]
    told = f"{path.name} has {len(found)} {key}{'s' * (len(found) != 1)}"
    raise InputError(
        told if wanted is None else f"{told}, {len(alike) or 'none'} of them {wanted!r}",
        where=where,
        expected=f"{key} = one of {', '.join(names[:MOST_NAMES])}, or its number, from 1",
        fix="Name one." if wanted is None else suggest(str(wanted), names) or "Give its number.",
    )
