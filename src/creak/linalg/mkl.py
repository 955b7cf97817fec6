"""Intel's MKL, where it is installed: found by pypardiso, called through ctypes with 32-bit integers."""

from __future__ import annotations

import ctypes
import functools
import importlib.util
from typing import Any


def has_pardiso() -> bool:
    """True where MKL, and with it the PARDISO solver, is installed."""
    return importlib.util.find_spec("pypardiso") is not None


class MatrixKind(ctypes.Structure):
    """matrix_descr of the sparse routines."""

    _fields_ = (("type", ctypes.c_int), ("mode", ctypes.c_int), ("diag", ctypes.c_int))


@functools.cache
def mkl_library() -> Any:
    """The library, with the types of the functions that creak calls."""
    from pypardiso import PyPardisoSolver

    library = PyPardisoSolver().libmkl
    i, d, p = ctypes.c_int, ctypes.c_double, ctypes.c_void_p
    library.cblas_dgemm.argtypes = [i] * 6 + [d, p, i, p, i, d, p, i]
    library.cblas_dtrsm.argtypes = [i] * 7 + [d, p, i, p, i]
    library.cblas_dgemm.restype = library.cblas_dtrsm.restype = None
    library.mkl_sparse_d_create_csr.argtypes = [p, i, i, i, p, p, p, p]
    library.mkl_sparse_set_mm_hint.argtypes = [p, i, MatrixKind, i, i, i]
    library.mkl_sparse_optimize.argtypes = library.mkl_sparse_destroy.argtypes = [p]
    library.mkl_sparse_d_mm.argtypes = [i, d, p, MatrixKind, i, p, i, i, d, p, i]
    return library
