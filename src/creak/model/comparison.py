"""Whether two models describe the same thing, value for value."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from itertools import chain
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.model.constraints import Constraint, Fixed
from creak.model.materials import NodalMatrices, Section, Spring
from creak.model.mesh import ElementBlock, Model, Surface, some_of

DIRECTION_TOLERANCE = 1e-15
"""Between unit vectors: directions pass through a normalisation, everything else is compared bit by bit."""
TURNED_TOLERANCE = 1e-14
"""Share of the largest number of a matrix: those of springs along turned axes are products of directions."""
POISSON_TOLERANCE = 1e-15
"""Of Poisson's ratio, which passes through the shear modulus where a deck has that of a beam in its place."""
_PLACES = ("where", "source", "expansion")
_FOR_WRITERS = ("plies", "bottom", "constants", "profile", "dimensions")
"""What sections keep of where their values came from; what only `b` has does not count."""
_TO_MAKE_AGAIN = ("made_of", "own_shear", "added_density", "isotropic")
"""What shells and sheets are made again from: a deck holds what it makes."""


@dataclass(frozen=True)
class _How:
    """How values are compared."""

    skip: tuple[str, ...] = ()
    """Fields that do not count."""
    tolerance: float = 0.0
    """Share of the largest number of an array by which numbers may differ."""


def difference(a: Model, b: Model, *, names: bool = True, tolerance: float = 0.0, by_element: bool = False) -> str:
    """The first difference between two models in words, empty where there is none.

    Compared are nodes, blocks with sections, materials and what elements have of their own, parts, sets, surfaces (as
    sets of facets), constraints (kind by kind, in order), supports (as sets of dofs), initial velocities and the mass
    form. Sets and surfaces that only `b` has do not count; nor do `Model.unread`, places in files and, with
    `names=False`, the names of sections and materials.

    Parameters
    ----------
    tolerance : share of the largest number of an array by which numbers may differ.
    by_element : elements are matched by their labels (which must tell them apart) in whatever blocks they stand; parts,
        element sets and surfaces, and what sections were made of, do not count.
    """
    skip = (() if names else ("name",)) + (_FOR_WRITERS if by_element else ())
    how = _How(skip, tolerance)
    mesh = _of_elements(a, b, how) if by_element else _of_blocks(a, b, how)
    return next(chain(_of_nodes(a, b), mesh, _of_names(a, b, by_element), _of_conditions(a, b, tolerance)), "")


def _of_nodes(a: Model, b: Model) -> Iterator[str]:
    if a.mass_form != b.mass_form:
        yield f"the mass form: {a.mass_form} and {b.mass_form}"
    yield from _values(a.nodes, b.nodes, "the nodes", _How())


def _of_blocks(a: Model, b: Model, how: _How) -> Iterator[str]:
    titles = [tuple(p.name for p in m.parts) for m in (a, b)]
    yield from _values(titles[0], titles[1], "the names of the parts", _How())
    yield from _values(a.parts, b.parts, "the parts", _How())
    if len(a.blocks) != len(b.blocks):
        yield f"the number of element blocks: {len(a.blocks)} and {len(b.blocks)}"
    for one, other in zip(a.blocks, b.blocks, strict=False):
        yield from _values(one.part, other.part, f"{_block_title(one)}, part", _How())
        yield from _of_block(one, other, how)


def _of_elements(a: Model, b: Model, how: _How) -> Iterator[str]:
    """Blocks of `a` against the elements of `b` with the same labels, those of each block of `b` at a time."""
    if a.n_elements != b.n_elements:
        yield f"the number of elements: {a.n_elements} and {b.n_elements}"
    place = {i: (k, row) for k, block in enumerate(b.blocks) for row, i in enumerate(block.ids.tolist())}
    for block in a.blocks:
        found = np.array([place.get(i, (-1, -1)) for i in block.ids.tolist()], dtype=np.int64).reshape(-1, 2)
        for k in np.unique(found[:, 0]).tolist():
            rows = np.flatnonzero(found[:, 0] == k)
            if k < 0:
                yield f"element {block.ids[rows[0]]} is missing"
            else:
                yield from _of_block(some_of(block, rows), some_of(b.blocks[k], found[rows, 1]), how)


def _block_title(a: ElementBlock) -> str:
    return f"{a.title} ({a.kind}, section {a.section.name})"


def _of_block(a: ElementBlock, b: ElementBlock, how: _How) -> Iterator[str]:
    title, values = _block_title(a), _How((), how.tolerance)
    for key in ("kind", "ids", "nodes_idx"):
        yield from _values(getattr(a, key), getattr(b, key), f"{title}, {key}", _How())
    matrices = isinstance(a.section, NodalMatrices)
    turned = replace(how, tolerance=max(how.tolerance, TURNED_TOLERANCE)) if matrices else how
    yield from _values(_section(a), _section(b), f"{title}, section", turned)
    yield from _values(a.own.thickness, b.own.thickness, f"{title}, thickness of their own", values)
    yield from _values(_arms(a), _arms(b), f"{title}, arms of their own", values)
    for key in ("axis1", "axis2"):
        x, y = getattr(a.own, key), getattr(b.own, key)
        if (x is None) != (y is None) or (x is not None and not _parallel(x, y, how.tolerance)):
            yield f"{title}, {key} of their own"


def _section(block: ElementBlock) -> Section:
    """A spring to ground has no second dof, whatever a deck gives."""
    section = block.section
    return replace(section, dof2=0) if isinstance(section, Spring) and block.kind == "spring1" else section


def _arms(block: ElementBlock) -> FloatArray | None:
    """None where all are zero, which is the same."""
    return block.own.arms if block.own.arms is not None and block.own.arms.any() else None


def _parallel(x: FloatArray, y: FloatArray, tolerance: float) -> bool:
    if x.shape != y.shape:
        return False
    x, y = (v / np.linalg.norm(v, axis=1)[:, None] for v in (x, y))
    return bool(np.abs(x - y).max(initial=0.0) <= max(tolerance, DIRECTION_TOLERANCE))


def _of_names(a: Model, b: Model, nodes_only: bool) -> Iterator[str]:
    pairs: tuple[tuple[str, Mapping[str, Any], Mapping[str, Any]], ...] = (
        ("node set", a.node_sets, b.node_sets),
        ("element set", a.element_sets, b.element_sets),
        ("surface", a.surfaces, b.surfaces),
    )
    for what, one, other in pairs[: 1 if nodes_only else 3]:
        for name, value in one.items():
            if name not in other:
                yield f"{what} {name!r} is missing"
            elif isinstance(value, Surface):
                yield from _of_surface(value, other[name])
            else:
                yield from _values(value, other[name], f"{what} {name!r}", _How())


def _of_surface(a: Surface, b: Surface) -> Iterator[str]:
    facets = [sorted(map(tuple, np.column_stack([s.facets.reshape(-1, 2), s.side]).tolist())) for s in (a, b)]
    if facets[0] != facets[1]:
        yield f"surface {a.name!r}, its facets"
    one, other = (s.nodes_idx if s.is_node_based else np.sort(s.nodes_idx) for s in (a, b))
    yield from _values(one, other, f"surface {a.name!r}, its nodes", _How())


def _of_conditions(a: Model, b: Model, tolerance: float) -> Iterator[str]:
    for kind in dict.fromkeys(type(c) for c in (*a.constraints, *b.constraints)):
        one, other = ([c for c in m.constraints if type(c) is kind] for m in (a, b))
        if len(one) != len(other):
            yield f"the number of constraints of kind {kind.__name__}: {len(one)} and {len(other)}"
        for c, d in zip(one, other, strict=False):
            yield from _values(c, d, f"{kind.__name__} {_title(c)}".strip(), _How((), tolerance))
    if _held(a.fixed) != _held(b.fixed):
        yield "the supports"
    if a.initial_velocity != b.initial_velocity:
        yield "the initial velocities"


def _title(c: Constraint) -> str:
    return getattr(c, "name", "") or c.where


def _held(fixed: Sequence[Fixed]) -> set[tuple[int, int]]:
    return {(node, dof) for f in fixed for node in f.nodes_idx.tolist() for dof in f.dofs}


def _values(a: Any, b: Any, title: str, how: _How) -> Iterator[str]:
    """Differences of two values, dataclasses field by field, numbers and arrays bit by bit or within the tolerance."""
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        if not _same_numbers(a, b, how.tolerance):
            yield title
    elif is_dataclass(a) and type(a) is type(b):
        for f in fields(a):
            x, y = getattr(a, f.name), getattr(b, f.name)
            unknown = f.name in _FOR_WRITERS and not x
            rounded = f.name == "poisson_ratio" and abs(x - y) <= POISSON_TOLERANCE
            if f.name not in (*_PLACES, *_TO_MAKE_AGAIN, *how.skip) and not unknown and not rounded:
                yield from _values(x, y, f"{title}, {f.name}", how)
    elif _are_reals(a) and _are_reals(b) and how.tolerance:
        if not _same_numbers(np.array(a), np.array(b), how.tolerance):
            yield f"{title}: {a!r:.60} and {b!r:.60}"
    elif isinstance(a, tuple) and isinstance(b, tuple) and len(a) == len(b):
        for k, (x, y) in enumerate(zip(a, b, strict=True)):
            yield from _values(x, y, f"{title} {k + 1}", how)
    elif a != b:
        yield f"{title}: {a!r:.60} and {b!r:.60}"


def _are_reals(a: Any) -> bool:
    """A real number or a tuple of them."""
    return isinstance(a, float) or (isinstance(a, tuple) and bool(a) and all(isinstance(x, float) for x in a))


def _same_numbers(a: Any, b: Any, tolerance: float) -> bool:
    if np.array_equal(a, b):
        return True
    if not tolerance or np.shape(a) != np.shape(b) or a is None or b is None:
        return False
    x, y = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    return bool(np.abs(x - y).max(initial=0.0) <= tolerance * max(np.abs(x).max(), np.abs(y).max()))
