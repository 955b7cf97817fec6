"""Points of an external Nastran superelement: which row is which dof, where the grids are, and in which frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import sparse

from creak.arrays import FloatArray, IntArray, Matrix
from creak.errors import InputError
from creak.formats.deck.coordinate_systems import axes_at, point_in_basic
from creak.formats.matrices.checks import DofMap
from creak.formats.nastran.mesh.grids import read_systems
from creak.formats.nastran.text.bulk_data import Card, free_card, id_list, read_cards, real
from creak.model.dofs import ALL, ROTATIONS, TRANSLATIONS
from creak.model.superelement import Superelement

SCALAR = 0
"""Component of a scalar point, which carries a generalised coordinate."""
LARGEST_ID = 99_999_999


@dataclass(frozen=True)
class Grid:
    """Place and displacement frame of a grid."""

    position: FloatArray
    axes: FloatArray


@dataclass(frozen=True)
class PointMap:
    """What the bulk data of a superelement says about its points.

    A point has an interior id (in the superelement, which orders the rows) and an exterior id (in the assembly).
    """

    grids: dict[int, Grid]
    """By exterior id (or interior id, for points that SECONCT does not name)."""
    scalars: set[int]
    exterior: dict[int, int]
    """Exterior id by interior id, from SECONCT."""
    components: dict[int, tuple[int, ...]]
    """Dofs by interior id, from EXTRN; empty if there is no such card."""

    def label(self, interior: int) -> int:
        return self.exterior.get(interior, interior)

    def grid(self, interior: int) -> Grid | None:
        return self.grids.get(self.label(interior)) or self.grids.get(interior)

    def is_scalar(self, interior: int) -> bool:
        return self.label(interior) in self.scalars or interior in self.scalars


def read_points(path: Path) -> PointMap:
    """Read the points of a bulk data file, such as the .asm of EXTSEOUT; see `points_of`."""
    return points_of(read_cards(path))


def points_of(cards: list[Card]) -> PointMap:
    """Points from GRID, GRDSET, SPOINT, CORD2R/C/S, SECONCT and EXTRN cards.

    Raises
    ------
    InputError : a card is wrong, or they describe more than one superelement.
    """
    scalars = {i for card in cards if card.name == "SPOINT" for i in id_list(card)}
    return PointMap(_grids(cards), scalars, _connections(cards), _components(cards))


def _grids(cards: list[Card]) -> dict[int, Grid]:
    systems = read_systems(cards)
    default = next((card for card in cards if card.name == "GRDSET"), Card("GRDSET", (), ""))
    grids = {}
    for card in cards:
        if card.name != "GRID":
            continue
        systems_of_grid = (card.integer(1, default.integer(1, 0)), card.integer(5, default.integer(5, 0)))
        missing = [i for i in systems_of_grid if i not in systems]
        if missing:
            raise InputError(
                f"GRID {card.integer(0)} needs coordinate system {missing[0]}, which is not in the file",
                where=card.where,
                fix="Add its CORD2R, CORD2C or CORD2S card",
            )
        placed, moved = (systems[i] for i in systems_of_grid)
        position = point_in_basic(placed, np.array([card.real(i, 0.0) for i in (2, 3, 4)]))
        grids[card.integer(0)] = Grid(position, axes_at(moved, position))
    return grids


def _connections(cards: list[Card]) -> dict[int, int]:
    """Exterior id by interior id from the pairs of SECONCT."""
    pairs: dict[int, int] = {}
    first: int | None = None
    for card in cards:
        if card.name != "SECONCT":
            continue
        superelement = card.integer(0)
        if first not in (None, superelement):
            raise InputError(
                f"SECONCT cards of superelements {first} and {superelement}",
                where=card.where,
                expected="the map of one superelement",
                fix="Give the map of each on its own",
            )
        first = superelement
        if len(card.fields) > 9 and card.text(9).upper() == "THRU":
            inner, outer = (range(card.integer(i), card.integer(i + 2) + 1) for i in (8, 11))
            if len(inner) != len(outer):
                raise InputError(f"SECONCT connects {len(inner)} points to {len(outer)}", where=card.where)
            pairs.update(zip(inner, outer, strict=True))
        else:
            filled = [i for i in range(8, len(card.fields)) if card.text(i)]
            if len(filled) % 2:
                raise InputError("SECONCT lists an odd number of points", where=card.where, expected="pairs")
            pairs.update((card.integer(i), card.integer(j)) for i, j in zip(filled[::2], filled[1::2], strict=True))
    return pairs


def _components(cards: list[Card]) -> dict[int, tuple[int, ...]]:
    """Dofs of each point of EXTRN: id, dofs or id THRU id dofs."""
    found: dict[int, tuple[int, ...]] = {}
    for card in cards:
        if card.name != "EXTRN":
            continue
        filled = [i for i in range(len(card.fields)) if card.text(i)]
        k = 0
        while k + 1 < len(filled):
            ids = range(card.integer(filled[k]), card.integer(filled[k]) + 1)
            if card.text(filled[k + 1]).upper() == "THRU" and k + 3 < len(filled):
                ids = range(card.integer(filled[k]), card.integer(filled[k + 2]) + 1)
                k += 2
            dofs = tuple(sorted({int(c) for c in str(card.integer(filled[k + 1]))} - {0})) or (SCALAR,)
            found.update(dict.fromkeys(ids, dofs))
            k += 2
    return found


def all_rows(points: PointMap, path: Path) -> list[tuple[int, int]]:
    """(interior id, dof) of every row as Nastran sorts an external superelement: ids ascending, dofs ascending.

    The points are those of EXTRN, else of SECONCT, else of all GRID and SPOINT cards. Grids have six dofs unless EXTRN
    says otherwise, scalar points one (dof 0).
    """
    ids = set(points.components or points.exterior) or {*points.grids, *points.scalars}
    rows: list[tuple[int, int]] = []
    for i in sorted(ids):
        if not points.is_scalar(i) and points.grid(i) is None and points.components.get(i) != (SCALAR,):
            raise InputError(
                f"point {i} of SECONCT or EXTRN has neither a GRID nor an SPOINT card",
                where=path,
                fix="Add the cards of all boundary points to the map file",
            )
        dofs = points.components.get(i, (SCALAR,) if points.is_scalar(i) else ALL)
        rows += [(i, dof) for dof in dofs]
    return rows


def labels(points: PointMap, rows: list[tuple[int, int]]) -> DofMap:
    """Node labels (exterior), dofs and positions of the rows; scalar points become generalised coordinates."""
    nodes = np.array([0 if dof == SCALAR else points.label(i) for i, dof in rows], dtype=np.int64)
    dofs = np.array([dof for _, dof in rows], dtype=np.int64)
    grids = {points.label(i): points.grid(i) for i, dof in rows if dof != SCALAR}
    return DofMap(nodes, dofs, {label: grid.position for label, grid in grids.items() if grid is not None})


def without_card(points: PointMap, rows: list[tuple[int, int]]) -> frozenset[int]:
    """Labels of the grids that no GRID card places: their frames are those of the deck that they join."""
    return frozenset(points.label(i) for i, dof in rows if dof != SCALAR and points.grid(i) is None)


def to_basic(points: PointMap, rows: list[tuple[int, int]], path: Path) -> Matrix | None:
    """R (n, n) with u_basic = R u_local, None where all frames are the basic one; A_basic = R A_local R^T."""
    row_of = {row: k for k, row in enumerate(rows)}
    rotation = sparse.lil_array(sparse.eye_array(len(rows)))
    turned = False
    for i in dict.fromkeys(i for i, dof in rows if dof != SCALAR):
        grid = points.grid(i)
        if grid is None or np.array_equal(grid.axes, np.eye(3)):
            continue
        turned = True
        for dofs in (TRANSLATIONS, ROTATIONS):
            there = [row_of[i, dof] for dof in dofs if (i, dof) in row_of]
            if len(there) in (1, 2):
                raise InputError(
                    f"grid {i} moves in its own frame (field CD) and has only some of its dofs {dofs}",
                    where=path,
                    fix="Keep all three translations or rotations of the grid, or define it in the basic frame",
                )
            if there:
                rotation[np.ix_(there, there)] = grid.axes
    return rotation.tocsr() if turned else None


def rotated(matrix: Matrix | None, rotation: Matrix | None) -> Matrix | None:
    """R A R^T."""
    return matrix if matrix is None or rotation is None else rotation @ matrix @ rotation.T


def scalar_ids(superelement: Superelement) -> IntArray:
    """(n,) point id of each row: its node, or for a generalised coordinate an id above the largest node's."""
    generalised = superelement.generalised
    ids = superelement.node_ids.copy()
    ids[generalised] = int(ids.max(initial=0)) + 1 + np.arange(generalised.size)
    if ids.max(initial=0) > LARGEST_ID:
        raise InputError(
            f"point {ids.max()} is above Nastran's largest id {LARGEST_ID}",
            where=superelement.name,
            fix="Renumber the nodes, or use another format",
        )
    return ids


def point_cards(superelement: Superelement, path: Path) -> Iterator[str]:
    """GRID cards in the basic frame and SPOINT cards of a superelement."""
    for node in sorted({int(n) for n in superelement.node_ids if n > 0}):
        if node not in superelement.positions:
            raise InputError(
                f"the place of node {node} is not known",
                where=path,
                fix="Give positions for all nodes, or use another format",
            )
        x, y, z = (real(v) for v in superelement.positions[node])
        yield free_card("GRID", [node, 0, x, y, z, 0], per_line=4)
    scalars = scalar_ids(superelement)[superelement.generalised].tolist()
    for k in range(0, len(scalars), 8):
        yield free_card("SPOINT", scalars[k : k + 8])
