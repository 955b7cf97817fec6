"""Element table, sections and parts -> element blocks, and the geometry checks of each block."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError
from creak.formats.abaqus.mesh.elements import TYPES, Elements
from creak.formats.abaqus.mesh.parts import Partition
from creak.formats.abaqus.sections.assigned import Assigned
from creak.model.materials import AxialSpring, BeamSection, NodalMatrices
from creak.model.mesh import ElementBlock, Own
from creak.model.shell_facets import N_CORNER, SHELL_FACETS

_KINDS = tuple(dict.fromkeys(t.kind for t in TYPES))
_KIND_OF_TYPE = np.array([_KINDS.index(t.kind) for t in TYPES])
_N_NODES = {t.kind: t.n_nodes for t in TYPES}
_SMALL = 1e-12
"""Relative size below which a length, area or angle counts as zero."""


@dataclass(frozen=True)
class Blocks:
    """Element blocks, and where each row of the element table went."""

    blocks: tuple[ElementBlock, ...]
    place: IntArray
    """(n_elem, 2) row into `blocks`, row in that block; -1 for gaps, which are stops and no structure."""


def make_blocks(elements: Elements, assigned: Assigned, partition: Partition, coords: FloatArray) -> Blocks:
    """Split the elements so that each block has one kind, section and part, in deck order.

    Raises
    ------
    InputError : an element of zero length or area, a beam along its own axis 1.
    """
    kinds = _KIND_OF_TYPE[elements.type_idx]
    keys = np.stack([kinds, assigned.section_idx, partition.element_part], axis=1)
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    inverse = inverse.reshape(-1)
    place = np.full((elements.ids.size, 2), -1, dtype=np.int64)
    blocks: list[ElementBlock] = []
    by_group = np.argsort(inverse, kind="stable")
    bounds = np.searchsorted(inverse[by_group], np.arange(first.size + 1))
    for group in np.argsort(first):
        rows = by_group[bounds[group] : bounds[group + 1]]
        if elements.of(int(rows[0])).kind == "gap2":
            continue
        block = _block(elements, rows, assigned, partition)
        _check_geometry(block, elements, rows, coords)
        place[rows, 0] = len(blocks)
        place[rows, 1] = np.arange(rows.size)
        blocks.append(block)
    return Blocks(tuple(blocks), place)


def _block(elements: Elements, rows: IntArray, assigned: Assigned, partition: Partition) -> ElementBlock:
    row = int(rows[0])
    kind, section = elements.of(row).kind, assigned.sections[int(assigned.section_idx[row])]
    formulation = kind
    if isinstance(section, NodalMatrices):
        formulation = f"nodal{_N_NODES[kind]}"
    elif isinstance(section, AxialSpring):
        formulation = "axial2"
    return ElementBlock(
        formulation,
        elements.ids[rows],
        elements.nodes_idx[rows, : _N_NODES[kind]],
        section,
        int(partition.element_part[row]),
        elements.where(row),
        _corners_only(assigned.own_of(rows), _N_NODES[kind]),
    )


def _corners_only(own: Own, n_node: int) -> Own:
    return own if own.thickness is None else replace(own, thickness=own.thickness[:, :n_node])


def _check_geometry(block: ElementBlock, elements: Elements, rows: IntArray, coords: FloatArray) -> None:
    corner = coords[block.nodes_idx]
    if block.kind == "beam3":
        halves = np.diff(corner, axis=1)
        back = np.einsum("ni,ni->n", halves[:, 0], halves[:, 1]) < 0.0
        _refuse(back, "goes back on itself: its second node is the one in the middle", elements, rows)
        for half in ([0, 1], [1, 2]):
            _check_geometry(replace(block, kind="beam2", nodes_idx=block.nodes_idx[:, half]), elements, rows, coords)
    elif block.kind in ("beam2", "truss2", "axial2"):
        along = corner[:, 1] - corner[:, 0]
        size = np.linalg.norm(along, axis=1)
        _refuse(size <= _SMALL * np.abs(corner).max(), "has zero length", elements, rows)
        if isinstance(block.section, BeamSection):
            axis = np.array(block.section.axis1) if block.own.axis1 is None else block.own.axis1
            across = np.linalg.norm(np.cross(along, axis), axis=1)
            parallel = across <= 1e-6 * size * np.linalg.norm(axis, axis=-1)
            _refuse(parallel, "lies along the direction of its section axis 1", elements, rows)
    elif block.kind in SHELL_FACETS:
        corner = corner[:, : N_CORNER[block.kind]]
        diagonals = (corner[:, 2] - corner[:, 0], corner[:, -1] - corner[:, 1])
        if N_CORNER[block.kind] == 3:
            diagonals = (corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        lengths = [np.linalg.norm(d, axis=1) for d in diagonals]
        size = lengths[0] * lengths[0] + lengths[1] * lengths[1]
        area = np.linalg.norm(np.cross(*diagonals), axis=1)
        _refuse(area <= _SMALL * size, "has zero area", elements, rows)


def _refuse(bad: np.ndarray, problem: str, elements: Elements, rows: IntArray) -> None:
    if bad.any():
        row = int(rows[int(np.argmax(bad))])
        raise InputError(
            f"element {elements.ids[row]} ({elements.of(row).name}) {problem}",
            where=elements.where(row),
            fix="Check the coordinates and the order of its nodes, and its section.",
        )
