"""JSON files with a checksum of their content in them: the key `sha256`, checked on reading."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from creak.digest import sha256
from creak.formats.deck.command_files import plain_file
from creak.formats.stored.sealed_hdf5 import Damaged

KEY = "sha256"


def sealed_text(data: Mapping[str, Any], *, allow_nan: bool = False) -> str:
    """The text of a JSON file, with the SHA-256 of its content as last key."""
    plain = json.loads(json.dumps(dict(data), allow_nan=allow_nan))
    return json.dumps({**plain, KEY: _digest(plain)}, indent=2) + "\n"


def read_sealed(path: Path) -> dict[str, Any]:
    """What `sealed_text` wrote, without the checksum.

    Raises
    ------
    Damaged : not such a file, or changed since. OSError : it cannot be read.
    """
    try:
        data = json.loads(plain_file(path, is_input=False).read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise Damaged("it is no JSON") from error
    found = data.pop(KEY, None) if isinstance(data, dict) else None
    if found is None:
        raise Damaged("it has no checksum: it is of another program or an earlier creak")
    if found != _digest(data):
        raise Damaged("its checksum does not fit: it was changed after it was written")
    return dict(data)


def _digest(data: dict[str, Any]) -> str:
    """Of the content, however it is laid out."""
    text = json.dumps(data, sort_keys=True, separators=(",", ":"))
    return sha256([text.encode()])
