"""Digests of data and files: what is kept is found by that of all that it was made from; names of the user as parts of
file names."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

PLACES = ("where",)
"""Fields that only say where in its file something stands."""
BLOCK = 1 << 20
"""Bytes of a file read at a time."""


def digest(value: Any, size: int = 16) -> str:
    """BLAKE2b of plain data: records by all fields but `PLACES`, arrays and sparse matrices with shape and type,
    tables whatever their order, lists, texts, numbers.

    Parameters
    ----------
    size : bytes; two hexadecimal digits each.

    Raises
    ------
    TypeError : it holds something else, of which no digest says all.
    """
    found = hashlib.blake2b(digest_size=size)
    _feed(found, value)
    return found.hexdigest()


def sha256(content: Iterable[bytes | memoryview]) -> str:
    """SHA-256 of what comes in pieces."""
    found = hashlib.sha256()
    for piece in content:
        found.update(piece)
    return found.hexdigest()


def file_sha256(path: Path) -> str:
    """SHA-256 of a file."""
    with path.open("rb") as file:
        return sha256(iter(lambda: file.read(BLOCK), b""))


def _feed(found: Any, value: Any) -> None:
    if isinstance(value, np.ndarray):
        found.update(f"array {value.dtype.str} {value.shape} ".encode())
        found.update(np.ascontiguousarray(value).data)
    elif sp.issparse(value):
        A = sp.csr_matrix(value)
        A.sort_indices()
        _feed(found, ["sparse", A.shape, A.data, A.indices.astype(np.int64), A.indptr.astype(np.int64)])
    elif is_dataclass(value) and not isinstance(value, type):
        found.update(f"record {type(value).__name__} ".encode())
        _feed(found, [(f.name, getattr(value, f.name)) for f in fields(value) if f.name not in PLACES])
    elif isinstance(value, Mapping):
        found.update(f"table {len(value)} ".encode())
        for pair in sorted(value.items(), key=lambda pair: str(pair[0])):
            _feed(found, pair)
    elif isinstance(value, list | tuple):
        found.update(f"list {len(value)} ".encode())
        for one in value:
            _feed(found, one)
    elif value is None or isinstance(value, str | int | float | np.generic):
        text = repr(value).encode(errors="surrogatepass")
        found.update(f"{len(text)} ".encode() + text)
    else:
        raise TypeError(f"no digest of a {type(value).__name__}")


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
