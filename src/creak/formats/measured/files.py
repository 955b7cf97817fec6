"""Measured time histories of files of the trade: RPC III, and functions (data set 58) of universal files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

from creak.errors import InputError, suggest
from creak.formats.measured.channel import Channel
from creak.formats.measured.rpc3 import read_rpc3
from creak.formats.measured.uff_functions import read_uff_functions

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
