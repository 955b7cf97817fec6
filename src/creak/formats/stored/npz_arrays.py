"""The arrays of a NumPy file (.npz), each checked before it takes memory: size, kind, and the CRC that zip keeps."""

from __future__ import annotations

import math
import struct
import zipfile
import zlib
from pathlib import Path

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from creak.formats.deck.command_files import plain_file
from creak.formats.stored.sealed import MOST_PACKED, Damaged

KINDS = "biufU"
"""Truth values, numbers and text; no objects, no records."""
HEADERS = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}
WRONG = (
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
    EOFError,
    OSError,
    ValueError,
    LookupError,
    TypeError,
    AttributeError,
    NotImplementedError,
    RuntimeError,
    SyntaxError,
    ArithmeticError,
)
"""What zipfile and NumPy raise on damaged files."""


def read_arrays(path: Path) -> dict[str, NDArray]:
    """Name -> array.

    Raises
    ------
    Damaged : the file cannot be read, is no .npz, is damaged, or holds objects or records.
    """
    try:
        with zipfile.ZipFile(plain_file(path, is_input=False)) as archive:
            return {info.filename.removesuffix(".npy"): _array(archive, info) for info in archive.infolist()}
    except WRONG as error:
        raise error if isinstance(error, Damaged) else Damaged(str(error) or type(error).__name__) from error


def _array(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> NDArray:
    with archive.open(info) as file:
        version = npy.read_magic(file)
        if version not in HEADERS:
            raise Damaged("an array has a header of another version")
        shape, fortran, dtype = HEADERS[version](file)
        if dtype.kind not in KINDS or dtype.hasobject:
            raise Damaged(f"the array {info.filename[:60]} holds {dtype.name[:60]}, not numbers")
        size = math.prod(shape) * dtype.itemsize
        most = min(info.file_size - file.tell(), MOST_PACKED * info.compress_size)
        if min(shape, default=0) < 0 or size != info.file_size - file.tell() or size > most:
            raise Damaged(f"the array {info.filename[:60]} is not as long as it says")
        data = file.read()
    return np.frombuffer(data, dtype).reshape(shape, order="F" if fortran else "C").copy()
