"""Intel's MKL, where it is installed: found as pypardiso finds it, called through ctypes with 32-bit integers."""

from __future__ import annotations

import ctypes
import functools
import importlib.util
import mmap
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np


@functools.cache
def has_pardiso() -> bool:
    """True where MKL, and with it the PARDISO solver, is installed."""
    return importlib.util.find_spec("pypardiso") is not None


class MatrixKind(ctypes.Structure):
    """matrix_descr of the sparse routines."""

    _fields_ = (("type", ctypes.c_int), ("mode", ctypes.c_int), ("diag", ctypes.c_int))


_PIECES = ("rt", "core", "intel_lp64", "intel_thread", "def")
_KERNELS = ("avx2", "avx512", "avx10", "mc3")
"""Of which it takes one."""


def _sizes(folder: Path, names: tuple[str, ...]) -> list[int]:
    return [path.stat().st_size for name in names for path in folder.glob(f"*mkl_{name}.*")]


ROOM = 64 << 20
"""Bytes that it takes at its first call, besides its libraries."""


def _at_its_place() -> Any:
    """The library of the wheel `mkl`; None elsewhere. pypardiso looks through all folders of the environment, twice."""
    if os.environ.get("PYPARDISO_MKL_RT"):
        return None
    for folder in ("lib", "Library/bin"):
        for path in sorted(Path(sys.prefix, folder).glob("*mkl_rt*"), key=lambda p: len(p.name)):
            # MKL ends the whole program, with status 2, where it cannot load a piece of itself.
            size = sum(_sizes(path.parent, _PIECES)) + max(_sizes(path.parent, _KERNELS), default=0)
            try:
                mmap.mmap(-1, size + ROOM).close()
            except OSError as error:
                raise MemoryError(f"the libraries of MKL take {(size + ROOM) / 1e6:.0f} MB") from error
            try:
                return ctypes.CDLL(str(path))
            except OSError:
                continue
    return None


def _found_by_pypardiso() -> Any:
    from pypardiso import PyPardisoSolver

    return PyPardisoSolver().libmkl


@functools.cache
def mkl_library() -> Any:
    """The library, with the types of the functions that creak calls, all of it loaded.

    Raises
    ------
    MemoryError : there is no room for it.
    """
    library = _at_its_place() or _found_by_pypardiso()
    i, d, p = ctypes.c_int, ctypes.c_double, ctypes.c_void_p
    library.cblas_dgemm.argtypes = [i] * 6 + [d, p, i, p, i, d, p, i]
    library.cblas_dtrsm.argtypes = [i] * 7 + [d, p, i, p, i]
    library.pardiso.argtypes = [p] * 16
    library.cblas_dgemm.restype = library.cblas_dtrsm.restype = library.pardiso.restype = None
    library.mkl_sparse_d_create_csr.argtypes = [p, i, i, i, p, p, p, p]
    library.mkl_sparse_set_mm_hint.argtypes = [p, i, MatrixKind, i, i, i]
    library.mkl_sparse_optimize.argtypes = library.mkl_sparse_destroy.argtypes = [p]
    library.mkl_sparse_d_mm.argtypes = [i, d, p, MatrixKind, i, p, i, i, d, p, i]
    one = np.ones(1)
    library.cblas_dgemm(101, 111, 111, 1, 1, 1, 1.0, one.ctypes.data, 1, one.ctypes.data, 1, 0.0, one.ctypes.data, 1)
    return library
