"""RPC III: time histories of test rigs (MTS). Records of 128 bytes (keyword 32, value 96), then groups of samples.

A group holds `PTS_PER_GROUP` samples of each channel in turn; the last one is filled up. Integers stand for their value
times SCALE.CHAN_n.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.deck.command_files import plain_file
from creak.formats.measured.channel import Channel

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
