"""Bundles of arrays for compiled code, by reference: a call passes one pointer, whatever the bundle holds.

Numba passes a NamedTuple by value: each array in it is seven numbers or more, of a model some two hundred for each
call, and as many for each assignment. What a function makes of its bundle by `by_reference` lives as long as the call
of that function; the functions that it calls read its fields as those of the bundle itself.
"""

from __future__ import annotations

import zlib
from typing import Any

from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, intrinsic, lower_getattr_generic, models, register_model


class Reference(types.Type):
    """To a NamedTuple."""

    def __init__(self, dtype: Any) -> None:
        self.dtype = dtype
        # Short, and different for each: functions that are compiled get their name from it.
        super().__init__(name=f"{dtype.instance_class.__name__}_{zlib.crc32(str(dtype).encode()):x}")


register_model(Reference)(models.PointerModel)


def _refer(typing: Any, bundle: Any) -> Any:
    def place(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        model = context.data_model_manager[bundle]
        at = cgutils.alloca_once(builder, model.get_data_type(), name=bundle.instance_class.__name__)
        for i in range(len(bundle)):
            member = context.data_model_manager[bundle[i]].as_data(builder, builder.extract_value(args[0], i))
            builder.store(member, cgutils.gep_inbounds(builder, at, 0, i))
        return at

    return (Reference(bundle)(bundle), place) if isinstance(bundle, types.BaseNamedTuple) else None


def _fetch(typing: Any, reference: Any) -> Any:
    def fetch(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return context.data_model_manager[reference.dtype].load_from_data_pointer(builder, args[0])

    return (reference.dtype(reference), fetch) if isinstance(reference, Reference) else None


by_reference: Any = intrinsic(_refer)
"""A reference to a bundle (NamedTuple) that the function holds which calls this."""
by_value: Any = intrinsic(_fetch)
"""The bundle that a reference is to."""


@infer_getattr
class _Fields(AttributeTemplate):
    key = Reference

    def generic_resolve(self, value: Any, attr: Any) -> Any:  # type: ignore[override]
        fields = value.dtype.fields
        if attr not in fields:
            return None
        kind = value.dtype[fields.index(attr)]
        return Reference(kind) if isinstance(kind, types.BaseNamedTuple) else kind


@lower_getattr_generic(Reference)
def _field(context: Any, builder: Any, reference: Any, pointer: Any, name: str) -> Any:
    index = reference.dtype.fields.index(name)
    kind, at = reference.dtype[index], cgutils.gep_inbounds(builder, pointer, 0, index)
    if isinstance(kind, types.BaseNamedTuple):
        return at
    found = context.data_model_manager[kind].load_from_data_pointer(builder, at)
    if context.enable_nrt:
        context.nrt.incref(builder, kind, found)
    return found
