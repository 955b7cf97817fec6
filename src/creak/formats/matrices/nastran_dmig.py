"""Superelements as Nastran DMIG bulk data: matrices whose entries carry their points and dofs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from scipy import sparse

from creak.arrays import FloatArray, Matrix
from creak.errors import InputError
from creak.formats.complete_file import complete_file
from creak.formats.matrices import nastran_points as nastran
from creak.formats.matrices.checks import by_node, checked, compact, first_of, refuse_structural, reordered
from creak.formats.matrices.nastran_op4 import DAMPING, MASS, STIFFNESS, STRUCTURAL
from creak.formats.nastran.text.bulk_data import Card, free_card, read_cards, real
from creak.model.superelement import Superelement

SQUARE, SYMMETRIC = 1, 6
Row = tuple[int, int]


@dataclass(frozen=True)
class Dmig:
    """One matrix: entries by (row, column), each (point, dof)."""

    form: int
    kind: int
    """1, 2 real; 3, 4 complex."""
    where: str
    entries: dict[tuple[Row, Row], float] = field(default_factory=dict)


def read_dmig(path: Path, map_file: Path | None = None) -> Superelement:
    """Read the DMIG matrices KAAX, MAAX, BAAX, K4AAX (or KAA, KXX, ...) of a bulk data or punch file.

    Square (1) and symmetric (6) real matrices in small, large and free field. Points without a dof are scalar points
    and become generalised coordinates. GRID, SPOINT, CORD2 and SECONCT cards are looked for in `map_file`, or in the
    same file: they give places, labels and CD frames. Grids without a card move in the frame that the deck they join
    gives them (`Superelement.in_deck_frames`).

    Raises
    ------
    InputError : K or M is missing, complex, rectangular or not symmetric; an entry is given twice; K4 is not 0.
    """
    cards = read_cards(path)
    found = dmig_matrices(cards)
    parts = {"stiffness": STIFFNESS, "mass": MASS}
    stiffness, mass = (first_of(found, names, what, path) for what, names in parts.items())
    damping, structural = (next((found[n] for n in names if n in found), None) for names in (DAMPING, STRUCTURAL))
    rows = sorted({row for m in (stiffness, mass, damping, structural) if m for pair in m.entries for row in pair})
    K, M = _assembled(stiffness, rows), _assembled(mass, rows)
    refuse_structural(_assembled(structural, rows), path)
    C = _assembled(damping, rows)
    points = nastran.points_of(cards) if map_file is None else nastran.read_points(map_file)
    rotation = nastran.to_basic(points, rows, map_file or path)
    K, M, C = (nastran.rotated(matrix, rotation) for matrix in (K, M, C))
    made = checked(path.stem, nastran.labels(points, rows), K, M, C, path)
    return replace(made, in_deck_frames=nastran.without_card(points, rows))


def dmig_matrices(cards: Iterable[Card]) -> dict[str, Dmig]:
    """All DMIG matrices by name.

    Raises
    ------
    InputError : a column before its header, an entry that is given twice.
    """
    found: dict[str, Dmig] = {}
    for card in cards:
        if card.name != "DMIG":
            continue
        name = card.text(0).upper()
        if card.integer(1) == 0:
            form, kind = card.integer(2), card.integer(3)
            if name in {*STIFFNESS, *MASS, *DAMPING, *STRUCTURAL} and (
                form not in (SQUARE, SYMMETRIC) or kind not in (1, 2)
            ):
                raise InputError(
                    f"DMIG {name} has form {form} and type {kind}",
                    where=card.where,
                    expected="form 6 or 1 (symmetric, square) and type 1 or 2 (real)",
                )
            found[name] = Dmig(form, kind, card.where)
        elif name not in found:
            raise InputError(
                f"a column of DMIG {name} comes before its header",
                where=card.where,
                fix=f"Start the matrix with DMIG,{name},0,6,2",
            )
        else:
            _add_column(found[name], card, name)
    return found


def _add_column(matrix: Dmig, card: Card, name: str) -> None:
    column = (card.integer(1), card.integer(2, 0))
    for k in range(4, len(card.fields), 4):
        if not card.text(k):
            continue
        row, value = (card.integer(k), card.integer(k + 1, 0)), card.real(k + 2, 0.0)
        twice = (row, column) in matrix.entries or (matrix.form == SYMMETRIC and (column, row) in matrix.entries)
        if twice:
            raise InputError(
                f"entry {row}, {column} of DMIG {name} is given twice",
                where=card.where,
                fix="Give each entry once; of a symmetric matrix (form 6) one triangle only",
            )
        matrix.entries[row, column] = value


def _assembled(matrix: Dmig | None, rows: list[Row]) -> Matrix | None:
    if matrix is None:
        return None
    index = {row: k for k, row in enumerate(rows)}
    i = np.array([index[row] for row, _ in matrix.entries], dtype=np.int64)
    j = np.array([index[column] for _, column in matrix.entries], dtype=np.int64)
    values = np.array(list(matrix.entries.values()))
    if matrix.form == SYMMETRIC:
        off = i != j
        i, j, values = (np.concatenate(pair) for pair in ((i, j[off]), (j, i[off]), (values, values[off])))
    return compact(sparse.csr_array((values, (i, j)), shape=(len(rows), len(rows))))


def write_dmig(superelement: Superelement, path: Path) -> list[Path]:
    """Write KAAX, MAAX, BAAX (symmetric, real double, free field with all digits), GRID and SPOINT cards.

    Rows come back sorted by node and dof; generalised coordinates become scalar points above the largest node.

    Raises
    ------
    InputError : the place of a node is not known, or ids are too large for Nastran.
    """
    order = by_node(superelement)
    ids, dofs = nastran.scalar_ids(superelement)[order].tolist(), superelement.dofs[order].tolist()
    rows = list(zip(ids, dofs, strict=True))
    header = list(nastran.point_cards(superelement, path))
    matrices = {"KAAX": superelement.K, "MAAX": superelement.M, "BAAX": superelement.C}
    with complete_file(path) as partial, partial.open("w", encoding="ascii") as file:
        file.writelines(header)
        for name, matrix in matrices.items():
            if matrix is not None:
                file.writelines(_matrix_cards(name, reordered(matrix, order), rows))
    return [path]


def _matrix_cards(name: str, matrix: FloatArray, rows: list[Row]) -> Iterator[str]:
    """Header and one card per column of the lower triangle; the diagonal always, so that every row is there."""
    yield free_card("DMIG", [name, 0, SYMMETRIC, 2, 0])
    for j, (point, dof) in enumerate(rows):
        fields: list[object] = [name, point, dof, None]
        for i in range(j, len(rows)):
            if matrix[i, j] != 0.0 or i == j:
                fields += [*rows[i], real(matrix[i, j]), None]
        yield free_card("DMIG", fields, per_line=4)
