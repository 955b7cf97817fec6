"""How functions are compiled that compiled code alone calls: without an entry for Python, a quarter of the time.

Python must not call them (it would crash): what it calls is `numba.njit(cache=True)`, as in the rest of creak.
"""

from __future__ import annotations

from typing import Any

import numba

from creak.dynamics.modal_model import FAST

_ALONE: dict[str, Any] = {"cache": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
inner = numba.njit(**_ALONE)
inner_fast = numba.njit(**_ALONE, fastmath=FAST)
"""Sums in any order."""
