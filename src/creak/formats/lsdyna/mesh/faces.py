"""Faces of elements: those of segments, of sets and of parts."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from creak.arrays import IntArray
from creak.errors import InputError
from creak.formats.deck.groups import Group
from creak.formats.lsdyna.mesh.sets import Segment
from creak.model.mesh import ElementBlock, Surface
from creak.model.shell_facets import N_CORNER, SHELL_FACETS
from creak.model.solid_faces import FACES, face_numbers, solid_corners

Element = tuple[int, int]
"""Row of a group or block, row in it."""


@dataclass(frozen=True)
class Face:
    """One face of an element."""

    element: Element
    facets: tuple[int, ...]
    """Rows of its facets in `SHELL_FACETS` or `FACES`."""
    side: int
    """Of a shell: 1 where the segment looks as its normal does, else -1; 0 of a solid."""


class FaceFinder:
    """Finds the elements that segments lie on; a shell goes before a solid."""

    def __init__(self, elements: Iterable[tuple[str, IntArray]]) -> None:
        """Kind and nodes (n, n_node) of groups or blocks, in their order."""
        self._shells: dict[frozenset[int], tuple[Element, tuple[int, ...], str]] = {}
        self._solids: dict[frozenset[int], Face] = {}
        for b, (kind, nodes) in enumerate(elements):
            if kind in SHELL_FACETS:
                for k, row in enumerate(nodes[:, : N_CORNER[kind]].tolist()):
                    self._shells[frozenset(row)] = (b, k), tuple(row), kind
            elif kind in FACES:
                self._add_solids(b, kind, nodes)

    def _add_solids(self, b: int, kind: str, nodes: IntArray) -> None:
        number = face_numbers(kind)
        faces = [
            (corners, tuple(np.flatnonzero(number == face).tolist()))
            for face, corners in enumerate(solid_corners(kind), 1)
        ]
        for k, row in enumerate(nodes.tolist()):
            for corners, facets in faces:
                self._solids[frozenset(row[c] for c in corners)] = Face((b, k), facets, 0)

    def face(self, segment: Segment) -> Face:
        """The face that a segment is.

        Raises
        ------
        InputError : no shell or solid has it.
        """
        key = frozenset(segment.nodes)
        if key in self._shells:
            element, corners, kind = self._shells[key]
            at = corners.index(segment.nodes[0])
            ahead = corners[(at + 1) % len(corners)] == segment.nodes[1]
            return Face(element, tuple(range(len(SHELL_FACETS[kind]))), 1 if ahead else -1)
        if key in self._solids:
            return self._solids[key]
        raise InputError(
            "a segment of *SET_SEGMENT is no face of a shell or solid",
            where=segment.where,
            expected="the corners of an element that creak reads, in order",
            fix="Correct its nodes, or make the set anew from the mesh.",
        )


def nodes_of(groups: Iterable[Group | ElementBlock]) -> list[tuple[str, IntArray]]:
    """Kind and nodes of groups or blocks."""
    return [(g.kind, g.nodes_idx if isinstance(g, ElementBlock) else np.array(g.nodes, dtype=np.int64)) for g in groups]


def segment_surface(name: str, segments: list[Segment], finder: FaceFinder) -> Surface:
    """The surface of a segment set: shells on the side that their segments look to, faces of solids."""
    facets: list[Element] = []
    sides: list[int] = []
    for segment in segments:
        face = finder.face(segment)
        for facet in (0,) if face.side else face.facets:
            facets.append(face.element)
            sides.append(face.side or facet + 1)
    nodes = np.unique(np.array([row for s in segments for row in s.nodes], dtype=np.int64))
    table = np.array(facets, dtype=np.int64).reshape(-1, 2)
    where = segments[0].where if segments else ""
    return Surface(name, table, np.array(sides, dtype=np.int64), nodes, where)
