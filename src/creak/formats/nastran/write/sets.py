"""Sets -> SET1 and SET3, and names of sets and properties in comments that pre-processors and creak read."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import IntArray
from creak.formats.nastran.write.elements import is_matrix
from creak.formats.nastran.write.fields import card
from creak.formats.nastran.write.properties import Properties
from creak.model.faces import FACES
from creak.model.mesh import Model, Surface
from creak.words import first_few

_NUMBER = re.compile(r"SET_([1-9][0-9]{0,7})")
_UNREADABLE = re.compile(r'[\s"]+')
"""What a name in a comment does not keep."""
NODES, ELEMENTS = 1, 2
"""Types of sets in HyperMesh's comments."""


@dataclass(frozen=True)
class _Set:
    """Names of one list of labels."""

    kind: int
    labels: tuple[int, ...]
    names: list[str]


def with_plain_names(model: Model) -> tuple[Model, list[str]]:
    """The model with names of sets and surfaces that can stand in comments, and which are others than before.

    An underscore takes the place of blanks and quotes; of two names that become one, the second gets a number.
    """
    every = dict.fromkeys((*model.node_sets, *model.element_sets, *model.surfaces))
    plain = {name: name for name in every if not _UNREADABLE.search(name)}
    taken, changed = set(plain), list[str]()
    for name in every:
        if name not in plain:
            stem = new = _UNREADABLE.sub("_", name)
            count = 1
            while new in taken:
                count += 1
                new = f"{stem}_{count}"
            plain[name] = new
            taken.add(new)
            changed.append(f"{name!r} is {new}")
    notes = [f"{len(changed)} name(s) of sets and surfaces have no blanks and quotes in the deck: {first_few(changed)}"]
    named = replace(
        model,
        node_sets={plain[name]: rows for name, rows in model.node_sets.items()},
        element_sets={plain[name]: rows for name, rows in model.element_sets.items()},
        surfaces={plain[name]: surface for name, surface in model.surfaces.items()},
    )
    return named, notes if changed else []


def without_matrix_elements(model: Model) -> tuple[Model, list[str]]:
    """The model with element sets that hold no element written as matrices on nodes, and which sets lose some."""
    added = [k for k, block in enumerate(model.blocks) if is_matrix(block)]
    kept = {name: rows[~np.isin(rows[:, 0], added)] for name, rows in model.element_sets.items()}
    lost = [name for name, rows in kept.items() if len(rows) < len(model.element_sets[name])]
    why = "element set(s) lose springs, dampers and masses along turned axes, which are matrices on nodes (DMIG)"
    notes = [f"{len(lost)} {why}: {first_few(lost)}"]
    return replace(model, element_sets={n: rows for n, rows in kept.items() if len(rows)}), notes if lost else []


def with_surface_sets(model: Model) -> tuple[Model, list[str]]:
    """The model with an element set for each surface that has none, and how the deck's surfaces are called.

    Nastran decks have no surfaces for creak but those of element sets: of shells both sides, and with .SPOS and .SNEG
    one side; of solids the faces that no other solid shares.
    """
    sets, notes, nodes = dict(model.element_sets), list[str](), list[str]()
    for name, surface in model.surfaces.items():
        stem, _, side = name.rpartition(".")
        if name in sets or (side in ("SPOS", "SNEG") and stem in sets):
            continue
        if surface.is_node_based:
            nodes.append(name)
            continue
        sets[name] = np.unique(surface.facets, axis=0)
        notes.append(f"surface {name} is {name}{_side(model, surface)}")
    if nodes:
        notes.append(
            f"{len(nodes)} surface(s) of nodes are not in the deck, whose couplings name nodes: {first_few(nodes)}"
        )
    return replace(model, element_sets=sets), notes


def _side(model: Model, surface: Surface) -> str:
    """How the surface of an element set is told from its others."""
    solid = any(model.blocks[b].kind in FACES for b in np.unique(surface.facets[:, 0]).tolist())
    if solid:
        return " in the deck: all free faces of its elements"
    sides = {1: ".SPOS", -1: ".SNEG"}
    found = np.unique(surface.side).tolist()
    if len(found) == 1:
        return sides.get(found[0], "") + " in the deck"
    of_shell: dict[tuple[int, ...], set[int]] = {}
    for facet, side in zip(surface.facets.tolist(), surface.side.tolist(), strict=True):
        of_shell.setdefault(tuple(facet), set()).add(side)
    single = sum(of in ({1}, {-1}) for of in of_shell.values())
    lost = f": both sides of its {len(of_shell)} elements, of which {single} had one side in the surface"
    return " in the deck" + (lost if single else "")


def set_lines(model: Model, properties: Properties) -> Iterator[str]:
    """$HMNAME of properties, and sets with their names as $HMSET."""
    sets = [*_grouped(NODES, ((n, model.nodes.ids[rows]) for n, rows in model.node_sets.items()))]
    known, comments = _property_names(model, properties)
    yield from comments
    elements = ((n, labels(model, rows)) for n, rows in model.element_sets.items() if n not in known)
    sets += _grouped(ELEMENTS, elements)
    numbers = _numbers(sets)
    for s in sets:
        for number, name, both in numbers[id(s)]:
            if name:
                yield f'$HMSET {number:>9}{s.kind:>9} "{name}"'
            if both is not None:
                head = [number] if both else [number, "GRID" if s.kind == NODES else "ELEM"]
                yield from card("SET1" if both else "SET3", [*head, *s.labels])


def labels(model: Model, pairs: IntArray) -> IntArray:
    """Labels of elements given as (n, 2): row of the block, row in it."""
    out = np.zeros(len(pairs), dtype=np.int64)
    for b in np.unique(pairs[:, 0]).tolist():
        mine = pairs[:, 0] == b
        out[mine] = model.blocks[b].ids[pairs[mine, 1]]
    return out


def _property_names(model: Model, properties: Properties) -> tuple[set[str], list[str]]:
    """Element sets that are the elements of a property, and the comments that name them."""
    by_members: dict[frozenset[int], int] = {}
    for pid, places in properties.members.items():
        by_members[frozenset(labels(model, np.array(places)).tolist())] = pid
    known, comments, named = set(), [], set()
    for name, rows in model.element_sets.items():
        pid = by_members.get(frozenset(labels(model, rows).tolist()), 0)
        if name == f"PID_{pid}":
            known.add(name)
        elif pid and pid not in named and not _NUMBER.fullmatch(name) and not name.startswith("PID_"):
            known.add(name)
            named.add(pid)
            comments.append(f'$HMNAME PROP {pid:>11}"{name}"')
    return known, comments


def _grouped(kind: int, sets: Iterable[tuple[str, IntArray]]) -> Iterator[_Set]:
    found: dict[tuple[int, ...], _Set] = {}
    for name, rows in sets:
        key = tuple(rows.tolist())
        if key:
            found.setdefault(key, _Set(kind, key, [])).names.append(name)
    yield from found.values()


def _numbers(sets: list[_Set]) -> Mapping[int, list[tuple[int, str, bool | None]]]:
    """For each set its cards: number, name to note, whether it is of grids and elements alike (None: no card)."""
    taken: dict[int, list[_Set]] = {}
    for s in sets:
        for name in s.names:
            match = _NUMBER.fullmatch(name)
            if match:
                taken.setdefault(int(match.group(1)), []).append(s)
    result: dict[int, list[tuple[int, str, bool | None]]] = {}
    after = max(taken, default=0)
    for s in sets:
        others = [n for n in s.names if not _NUMBER.fullmatch(n)]
        cards: list[tuple[int, str, bool | None]] = []
        for number, owners in taken.items():
            if any(o is s for o in owners):
                alike = len(owners) == 2 and owners[0].labels == owners[1].labels
                shown = None if alike and owners[1] is s else alike
                cards.append((number, others.pop(0) if others and len(owners) == 1 else "", shown))
        for name in others:
            after += 1
            cards.append((after, name, False))
        result[id(s)] = cards
    return result
