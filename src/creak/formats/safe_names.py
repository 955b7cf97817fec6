"""Names of the user as parts of file names."""

from __future__ import annotations

import re

from creak.digest import digest

LONGEST = 100
"""Bytes; file systems take 255, and an ending and a partial name come on top."""


def file_stem(name: str) -> str:
    """A name that every file system takes; two names never give the same one.

    Letters, digits, `_` and `-` stay. A name with anything else, or too long, ends in a digest of itself.
    """
    safe = re.sub(r"[^\w-]", "_", name)
    if safe == name and 0 < len(name.encode(errors="replace")) <= LONGEST:
        return name
    return f"{safe.encode()[: LONGEST - 9].decode(errors='ignore')}-{digest(name, 4)}"
