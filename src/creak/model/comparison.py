"""Whether two models describe the same thing, value for value."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from itertools import chain
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.model.constraints import Constraint, Fixed
from creak.model.materials import Section, Spring
from creak.model.mesh import ElementBlock, Model, Surface

DIRECTION_TOLERANCE = 1e-15
"""Between unit vectors: directions pass through a normalisation, everything else is compared bit by bit."""
_PLACES = ("where", "source")


def difference(a: Model, b: Model, *, names: bool = True) -> str:
    """The first difference between two models in words, empty where there is none.

    Compared are nodes, blocks with sections, materials and what elements have of their own, parts, sets, surfaces (as
    sets of facets), constraints (kind by kind, in order), supports (as sets of dofs), initial velocities and the mass
    form. Sets and surfaces that only `b` has do not count; nor do `Model.unread`, places in files and, with
    `names=False`, the names of sections and materials.
    """
    return next(chain(_of_mesh(a, b, names), _of_names(a, b), _of_conditions(a, b)), "")


def _of_mesh(a: Model, b: Model, names: bool) -> Iterator[str]:
    if a.mass_form != b.mass_form:
        yield f"the mass form: {a.mass_form} and {b.mass_form}"
    skip = () if names else ("name",)
    yield from _values(a.nodes, b.nodes, "the nodes", ())
    yield from _values(tuple(p.name for p in a.parts), tuple(p.name for p in b.parts), "the names of the parts", ())
    yield from _values(a.parts, b.parts, "the parts", ())
    if len(a.blocks) != len(b.blocks):
        yield f"the number of element blocks: {len(a.blocks)} and {len(b.blocks)}"
    for one, other in zip(a.blocks, b.blocks, strict=False):
        yield from _of_block(one, other, skip)


def _of_block(a: ElementBlock, b: ElementBlock, skip: Sequence[str]) -> Iterator[str]:
    title = f"elements {a.ids[:3].tolist()}... ({a.kind}, section {a.section.name})"
    for key in ("kind", "part", "ids", "nodes_idx"):
        yield from _values(getattr(a, key), getattr(b, key), f"{title}, {key}", ())
    yield from _values(_section(a), _section(b), f"{title}, section", skip)
    yield from _values(a.own.thickness, b.own.thickness, f"{title}, thickness of their own", ())
    yield from _values(_arms(a), _arms(b), f"{title}, arms of their own", ())
    for key in ("axis1", "axis2"):
        x, y = getattr(a.own, key), getattr(b.own, key)
        if (x is None) != (y is None) or (x is not None and not _parallel(x, y)):
            yield f"{title}, {key} of their own"


def _section(block: ElementBlock) -> Section:
    """A spring to ground has no second dof, whatever a deck gives."""
    section = block.section
    return replace(section, dof2=0) if isinstance(section, Spring) and block.kind == "spring1" else section


def _arms(block: ElementBlock) -> FloatArray | None:
    """None where all are zero, which is the same."""
    return block.own.arms if block.own.arms is not None and block.own.arms.any() else None


def _parallel(x: FloatArray, y: FloatArray) -> bool:
    if x.shape != y.shape:
        return False
    x, y = (v / np.linalg.norm(v, axis=1)[:, None] for v in (x, y))
    return bool(np.abs(x - y).max(initial=0.0) <= DIRECTION_TOLERANCE)


def _of_names(a: Model, b: Model) -> Iterator[str]:
    pairs: tuple[tuple[str, Mapping[str, Any], Mapping[str, Any]], ...] = (
        ("node set", a.node_sets, b.node_sets), ("element set", a.element_sets, b.element_sets),
        ("surface", a.surfaces, b.surfaces),
    )  # fmt: skip
    for what, one, other in pairs:
        for name, value in one.items():
            if name not in other:
                yield f"{what} {name!r} is missing"
            elif isinstance(value, Surface):
                yield from _of_surface(value, other[name])
            else:
                yield from _values(value, other[name], f"{what} {name!r}", ())


def _of_surface(a: Surface, b: Surface) -> Iterator[str]:
    facets = [sorted(map(tuple, np.column_stack([s.facets.reshape(-1, 2), s.side]).tolist())) for s in (a, b)]
    if facets[0] != facets[1]:
        yield f"surface {a.name!r}, its facets"
    one, other = (s.nodes_idx if s.is_node_based else np.sort(s.nodes_idx) for s in (a, b))
    yield from _values(one, other, f"surface {a.name!r}, its nodes", ())


def _of_conditions(a: Model, b: Model) -> Iterator[str]:
    for kind in dict.fromkeys(type(c) for c in (*a.constraints, *b.constraints)):
        one, other = ([c for c in m.constraints if type(c) is kind] for m in (a, b))
        if len(one) != len(other):
            yield f"the number of constraints of kind {kind.__name__}: {len(one)} and {len(other)}"
        for c, d in zip(one, other, strict=False):
            yield from _values(c, d, f"{kind.__name__} {_title(c)}".strip(), ())
    if _held(a.fixed) != _held(b.fixed):
        yield "the supports"
    if a.initial_velocity != b.initial_velocity:
        yield "the initial velocities"


def _title(c: Constraint) -> str:
    return getattr(c, "name", "") or c.where


def _held(fixed: Sequence[Fixed]) -> set[tuple[int, int]]:
    return {(node, dof) for f in fixed for node in f.nodes_idx.tolist() for dof in f.dofs}


def _values(a: Any, b: Any, title: str, skip: Sequence[str]) -> Iterator[str]:
    """Differences of two values, dataclasses field by field, numbers and arrays bit by bit."""
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        if not np.array_equal(a, b):
            yield title
    elif is_dataclass(a) and type(a) is type(b):
        for f in fields(a):
            if f.name not in (*_PLACES, *skip):
                yield from _values(getattr(a, f.name), getattr(b, f.name), f"{title}, {f.name}", skip)
    elif isinstance(a, tuple) and isinstance(b, tuple) and len(a) == len(b):
        for k, (x, y) in enumerate(zip(a, b, strict=True)):
            yield from _values(x, y, f"{title} {k + 1}", skip)
    elif a != b:
        yield f"{title}: {a!r:.60} and {b!r:.60}"
