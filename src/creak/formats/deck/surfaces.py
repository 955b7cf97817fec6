"""Surfaces of element sets: both sides of shells, and the faces of solids that no other solid shares."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from creak.arrays import BoolArray, IntArray
from creak.model.faces import FACES, SHELL_FACETS, face_numbers, faces_of, free_faces
from creak.model.mesh import ElementBlock, Surface

Picked = Mapping[str, Mapping[int, Sequence[set[int]]]]
"""Set -> solid -> rows of some nodes of each of its faces that alone belong to the surface."""


def surfaces(
    blocks: tuple[ElementBlock, ...], sets: Mapping[str, IntArray], picked: Picked | None = None
) -> dict[str, Surface]:
    """For every element set with shells or solids: its name (both sides of shells, free faces of solids), and of shells
    <name>.SPOS and <name>.SNEG, the sides of the positive and negative normal."""
    found: dict[str, Surface] = {}
    free: dict[bytes, tuple[IntArray, IntArray]] = {}
    free_of = _free_of(blocks)
    of_shells = np.array([b.kind in SHELL_FACETS for b in blocks], dtype=bool)
    for name, places in sets.items():
        shells = places[of_shells[places[:, 0]]]
        key = places.tobytes()  # a property is there under its number and under its name
        if key not in free:
            free[key] = _free(places, free_of)
        facets, sides = free[key]
        if picked and picked.get(name):
            mine = _on_faces(blocks, facets, sides, picked[name])
            facets, sides = facets[mine], sides[mine]
        both = np.concatenate([shells, facets])
        if not both.size:
            continue
        side = np.concatenate([np.zeros(len(shells), dtype=np.int64), sides])
        where = blocks[int(both[0, 0])].where
        found[name] = Surface(name, both, side, _nodes(blocks, shells, facets, sides), where)
        for suffix, value in ((".SPOS", 1), (".SNEG", -1)) if len(shells) and not len(facets) else ():
            found[name + suffix] = Surface(
                name + suffix, shells, np.full(len(shells), value, dtype=np.int64), found[name].nodes_idx, where
            )
    return found


def _free_of(blocks: tuple[ElementBlock, ...]) -> dict[int, BoolArray]:
    """(n, k) of each block of solids: which faces of its elements no other solid shares."""
    faces = {i: faces_of(b.kind, b.nodes_idx) for i, b in enumerate(blocks) if b.kind in FACES}
    if not faces:
        return {}
    every = np.concatenate([f.reshape(-1, 4) for f in faces.values()])
    alone = np.zeros(len(every), dtype=bool)
    alone[free_faces(every, [every])] = True
    ends = np.cumsum([f.shape[0] * f.shape[1] for f in faces.values()])[:-1]
    return {i: part.reshape(f.shape[:2]) for (i, f), part in zip(faces.items(), np.split(alone, ends), strict=True)}


def _free(places: IntArray, free_of: dict[int, BoolArray]) -> tuple[IntArray, IntArray]:
    """(n, 2) places and (n,) numbers of the faces of solids that no other solid shares."""
    facets, sides = [np.zeros((0, 2), dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    for b in np.unique(places[:, 0]).tolist():
        if b in free_of:
            rows = places[places[:, 0] == b, 1]
            element, face = np.nonzero(free_of[b][rows])
            facets.append(np.column_stack([np.full(element.size, b), rows[element]]))
            sides.append(face + 1)
    return np.concatenate(facets), np.concatenate(sides)


def _on_faces(
    blocks: tuple[ElementBlock, ...], facets: IntArray, sides: IntArray, faces: Mapping[int, Sequence[set[int]]]
) -> BoolArray:
    """(n,) which facets of solids are of the faces that are named; of solids without such all are."""
    found = np.ones(len(facets), dtype=bool)
    for i, ((b, k), side) in enumerate(zip(facets.tolist(), sides.tolist(), strict=True)):
        wanted = faces.get(int(blocks[b].ids[k]))
        if wanted is not None:
            number = face_numbers(blocks[b].kind)
            whole = np.array(FACES[blocks[b].kind])[number == number[side - 1]]
            nodes = set(blocks[b].nodes_idx[k][whole.ravel()].tolist())
            found[i] = any(rows <= nodes for rows in wanted)
    return found


def _nodes(blocks: tuple[ElementBlock, ...], shells: IntArray, facets: IntArray, sides: IntArray) -> IntArray:
    found = [blocks[b].nodes_idx[shells[shells[:, 0] == b, 1]].ravel() for b in np.unique(shells[:, 0]).tolist()]
    for (b, k), side in zip(facets.tolist(), sides.tolist(), strict=True):
        found.append(blocks[b].nodes_idx[k][list(FACES[blocks[b].kind][side - 1])])
    return np.unique(np.concatenate(found)).astype(np.int64)
