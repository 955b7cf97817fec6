"""Measured time histories of files of the trade: RPC III, and functions (data set 58) of universal files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from creak.errors import InputError, suggest
from creak.formats.measured.channel import Channel
from creak.formats.measured.rpc3 import read_rpc3
from creak.formats.measured.uff_functions import read_uff_functions

READERS: dict[str, Callable[[Path], list[Channel]]] = {
    **dict.fromkeys((".rsp", ".drv", ".rpc", ".rpc3", ".tim"), read_rpc3),
    **dict.fromkeys((".uff", ".unv", ".u58"), read_uff_functions),
}
"""Ending of a file -> its reader."""


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
    names = [c.name for c in channels]
    if isinstance(wanted, int):
        if not 1 <= wanted <= len(channels):
            raise InputError(f"{path.name} has no channel {wanted}", where=where, expected=f"1 to {len(channels)}")
        return channels[wanted - 1]
    if wanted is None:
        if len(channels) == 1:
            return channels[0]
        raise InputError(
            f"{path.name} has {len(channels)} channels",
            where=where,
            expected=f"channel = one of {', '.join(names)}, or its number",
            fix="Name one.",
        )
    found = [c for c in channels if c.name.upper() == wanted.upper()]
    if len(found) != 1:
        what = "has no channel" if not found else f"has {len(found)} channels"
        raise InputError(
            f"{path.name} {what} {wanted!r}", where=where, fix=suggest(wanted, names) or "Give its number."
        )
    return found[0]
