"""How functions are compiled that compiled code alone calls: without an entry for Python, a quarter of the time.

Python must not call them (it would crash): what it calls is `numba.njit(cache=True)`, as in the rest of creak.

They do not count who holds an array either: each count locks a line of the cache, in the march a quarter of its time,
and more where threads share a model. So they make no arrays: what does is `with_arrays` and returns numbers.
"""

from __future__ import annotations

from typing import Any

import numba

FAST = {"reassoc", "contract", "nsz", "arcp"}
"""Sums in any order; infinities and NaN keep their meaning."""
DONE, NOT_FINITE = 0, -1
"""How a chunk of steps ends; other codes are those of the contact solver."""
_ALONE: dict[str, Any] = {"cache": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True, "_nrt": False}
inner = numba.njit(**_ALONE)
inner_fast = numba.njit(**_ALONE, fastmath=FAST)
_CALLED: dict[str, Any] = {"cache": True, "no_cfunc_wrapper": True, "nogil": True, "_nrt": False}
outer = numba.njit(**_CALLED)
"""For the one that Python calls. A function around it would have all of it compiled twice."""
_MAKING: dict[str, Any] = {"cache": True, "_nrt": True}
with_arrays = numba.njit(**_MAKING)
"""For functions that make arrays and are called by the others (`_nrt` goes on from caller to called)."""
