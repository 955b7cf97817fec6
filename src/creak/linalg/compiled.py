"""How functions are compiled that compiled code alone calls: typed once each, optimised once with all that they call.

Numba has LLVM optimise each function with all that it calls, and make machine code of it, once more at every level of
calls, and an entry for Python besides. Here that is left to the one that Python calls. Python must call none of the
others: it would crash.

They do not count who holds an array either: each count locks a line of the cache, in the march a quarter of its time,
and more where threads share a model. So they make no arrays: what does is `with_arrays`.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import llvmlite.binding
import llvmlite.ir
from numba.core import cgutils
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler

from creak.jit import njit

FAST = {"reassoc", "contract", "nsz", "arcp"}
"""Sums in any order; infinities and NaN keep their meaning."""


class _Part(JITCodeLibrary):
    """Code that is optimised where it is linked in; by itself only the places of its environments exist."""

    def _optimize_final_module(self) -> None:
        whole, places = self._final_module, self._codegen._create_empty_module(self.name)
        for function in whole.functions:
            if not function.is_declaration and function.linkage == llvmlite.binding.Linkage.external:
                function.linkage = "linkonce_odr"
        for variable in whole.global_variables:
            if variable.name.startswith("_ZN08NumbaEnv"):
                place = llvmlite.ir.GlobalVariable(places, cgutils.voidptr_t, variable.name)
                place.linkage, place.initializer = "common", llvmlite.ir.Constant(cgutils.voidptr_t, None)
        self._shared_module = whole
        self._final_module = llvmlite.binding.parse_assembly(str(places))
        self._final_module.name = whole.name


class _PartCompiler(Compiler):
    """Numba's own, into a `_Part`."""

    def define_pipelines(self) -> Any:
        state = self.state
        if state.library is None:
            state.library = _Part(state.targetctx.codegen(), state.func_id.func_qualname)
            state.library.enable_object_caching()
        return super().define_pipelines()


@contextmanager
def few_collections() -> Iterator[None]:
    """Within it Python looks for objects in rings a hundred times less often: a tenth of what compiling takes."""
    before = gc.get_threshold()
    gc.set_threshold(100 * before[0], *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)


_ALL: dict[str, Any] = {"no_cfunc_wrapper": True, "error_model": "numpy"}
_PART: dict[str, Any] = {**_ALL, "pipeline_class": _PartCompiler, "no_cpython_wrapper": True}
_NO_COUNTS: dict[str, Any] = {**_PART, "_nrt": False}
inner = njit(**_NO_COUNTS)
inner_fast = njit(**_NO_COUNTS, fastmath=FAST)
_COUNTS: dict[str, Any] = {**_PART, "_nrt": True}
with_arrays = njit(**_COUNTS)
"""For functions that make arrays and are called by the others (`_nrt` goes on from caller to called)."""
_CALLED: dict[str, Any] = {**_ALL, "nogil": True, "_nrt": False}
outer = njit(**_CALLED)
"""For the one that Python calls. A function around it would have all of it compiled twice."""
either = njit(**_ALL)
"""For small ones that both call."""
