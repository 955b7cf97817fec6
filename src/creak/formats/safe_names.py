"""Names of the user as parts of file names."""

from __future__ import annotations

import hashlib
import re

LONGEST = 100
"""Bytes; file systems take 255, and an ending and a partial name come on top."""


def file_stem(name: str) -> str:
    """A name that every file system takes; two names never give the same one.

    Letters, digits, `_` and `-` stay. A name with anything else, or too long, ends in a digest of itself.
    """
    safe = re.sub(r"[^\w-]", "_", name)
    if safe == name and 0 < len(name.encode(errors="replace")) <= LONGEST:
        return name
    digest = hashlib.blake2b(name.encode(errors="surrogatepass"), digest_size=4).hexdigest()
    return f"{safe.encode()[: LONGEST - 9].decode(errors='ignore')}-{digest}"
