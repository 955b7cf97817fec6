"""K2GG, M2GG, B2GG: DMIG matrices added to those of the structure."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from creak.arrays import IntArray, Matrix
from creak.errors import InputError, suggest
from creak.formats.matrices.checks import SYMMETRY
from creak.formats.matrices.nastran_dmig import SQUARE, SYMMETRIC, Dmig, dmig_matrices
from creak.formats.nastran.sections.materials import damping
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import Deck
from creak.model.dofs import PER_NODE, dof_label, node_dofs, nodes_of
from creak.model.materials import NodalMatrices

SELECTORS = {"K2GG": "CK2", "M2GG": "CM2", "B2GG": "CB2"}
"""Case control command -> parameter that scales its matrices."""
MOST_GRIDS = 400
"""Connected by one matrix; more make dense matrices of several hundred MB."""
_TERM = re.compile(r"(?:([-+.0-9DE]{1,40})\s*\*\s*)?([A-Z][A-Z0-9]{0,7})")


@dataclass(frozen=True)
class Piece:
    """Matrices on grids that they connect with each other and with no others."""

    rows: IntArray
    """(n,) node rows."""
    K: Matrix
    """(6 n, 6 n), node by node."""
    M: Matrix
    C: Matrix


def read_direct_matrices(deck: Deck) -> None:
    """Add the matrices that the case control selects as elements of many nodes, one for each connected piece.

    Real, symmetric matrices on grids and scalar points; those of grids with displacement frames are turned to the
    basic frame. As in Nastran PARAM,WTMASS does not act on M2GG; CK2, CM2 and CB2 scale; ALPHA1, ALPHA2 and G with W3
    count them.

    Raises
    ------
    InputError : a matrix that is not there, not real or not symmetric, or that connects more than `MOST_GRIDS` grids.
    """
    found = dmig_matrices(deck.cards("DMIG"))
    _note_others(deck, found)
    if not deck.case.matrices:
        return
    n = PER_NODE * len(deck.grids.ids)
    turn = _turn(deck)
    sums = {}
    for command, scale in SELECTORS.items():
        total: Matrix = sp.csr_array((n, n))
        for factor, name in _terms(deck, command, found):
            total = total + deck.param(scale, 1.0) * factor * _assembled(deck, command, name, found[name])
        sums[command] = (turn @ total @ turn.T).tocsr()
    where = deck.case.where
    first = max(deck.element_at, default=0)
    for k, piece in enumerate(pieces(sums["K2GG"], sums["M2GG"], sums["B2GG"]), start=1):
        if piece.rows.size > MOST_GRIDS:
            raise InputError(
                f"a matrix of {', '.join(deck.case.matrices)} connects {piece.rows.size} grids",
                where=where,
                expected=f"at most {MOST_GRIDS}",
                fix="Give it as a [superelement] of the study.",
            )
        K, M, C = (A.toarray() for A in (piece.K, piece.M, piece.C))
        card = next(deck.cards("DMIG"), Card("DMIG", (), where))
        alpha, beta = (r if A.any() else 0.0 for A, r in zip((M, K), damping(deck, card), strict=True))
        section = NodalMatrices(" ".join(deck.case.matrices.values()), K, M, C, alpha, beta)
        kind = "nodal1" if piece.rows.size == 1 else "nodal2"
        deck.add(("DMIG", k), kind, section, first + k, piece.rows.tolist(), card)


def pieces(K: Matrix, M: Matrix, C: Matrix) -> Iterator[Piece]:
    """The connected pieces of three matrices (6 n, 6 n) on all nodes, in the order of their first nodes."""
    pattern = sum(abs(A) for A in (K, M, C)).tocoo()
    nodes = K.shape[0] // PER_NODE
    links = sp.csr_array((np.ones(pattern.nnz), (nodes_of(pattern.row), nodes_of(pattern.col))), shape=(nodes, nodes))
    _, of_node = connected_components(links, directed=False)
    used = np.unique(nodes_of(pattern.row))
    for label in dict.fromkeys(of_node[used].tolist()):
        rows = used[of_node[used] == label].astype(np.int64)
        dofs = node_dofs(rows)
        yield Piece(rows, *(sp.csr_array(A)[dofs][:, dofs] for A in (K, M, C)))


def _note_others(deck: Deck, found: Mapping[str, Dmig]) -> None:
    taken = {name for command in SELECTORS for _, name in _terms(deck, command, found)}
    left = [card for card in deck.cards("DMIG") if card.text(0).upper() not in taken]
    if left and deck.case.given:
        deck.note(left[0], "the case control does not select this matrix (K2GG, M2GG, B2GG)", changes=False)
    elif left:
        why = "select it in the case control (K2GG = name, M2GG, B2GG), or give it as a superelement in the study"
        deck.note(left[0], why, changes=True)


def _terms(deck: Deck, command: str, found: Mapping[str, Dmig]) -> Sequence[tuple[float, str]]:
    """(factor, name) of K2GG = name, or factor * name, and so on."""
    text = deck.case.matrices.get(command, "")
    terms = []
    for piece in text.upper().split(",") if text else ():
        match = _TERM.fullmatch(piece.strip())
        try:
            factor = float(match.group(1).replace("D", "E") if match and match.group(1) else 1.0)
        except ValueError:
            match = None
        if not match:
            raise InputError(f"{command} = {text}", where=deck.case.where, expected="the name of a DMIG matrix")
        if match.group(2) not in found:
            raise InputError(
                f"{command} selects matrix {match.group(2)}, which is not defined",
                where=deck.case.where,
                expected="DMIG cards with this name",
                fix=suggest(match.group(2), found),
            )
        terms.append((factor, match.group(2)))
    return terms


def _assembled(deck: Deck, command: str, name: str, matrix: Dmig) -> Matrix:
    """(6 n, 6 n) in the displacement frames."""
    if matrix.form not in (SQUARE, SYMMETRIC) or matrix.kind not in (1, 2):
        raise InputError(
            f"DMIG {name} of {command} has form {matrix.form} and type {matrix.kind}",
            where=matrix.where,
            expected="form 6 or 1 (symmetric, square) and type 1 or 2 (real)",
        )
    n = PER_NODE * len(deck.grids.ids)
    owner = Card("DMIG", (name,), matrix.where)
    pairs = [[_place(deck, owner, *dof) for dof in pair] for pair in matrix.entries]
    at = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    values = np.array(list(matrix.entries.values()))
    A = sp.csr_array((values, (at[:, 0], at[:, 1])), shape=(n, n))
    if matrix.form == SYMMETRIC:
        return A + A.T - sp.diags_array(A.diagonal())
    if abs(A - A.T).max() > SYMMETRY * abs(A).max():
        raise InputError(
            f"DMIG {name} of {command} is not symmetric",
            where=matrix.where,
            fix="creak has no gyroscopic or circulatory matrices.",
        )
    return 0.5 * (A + A.T)


def _place(deck: Deck, owner: Card, identifier: int, dof: int) -> int:
    row = deck.grids.row(identifier, owner)
    if row in deck.grids.scalar:
        dof = 1
    if not 1 <= dof <= 6:
        raise owner.error(
            f"DMIG {owner.text(0)} has an entry at component {dof} of grid {identifier}", expected="1 to 6"
        )
    return dof_label(row, dof)


def _turn(deck: Deck) -> Matrix:
    """u_basic = R u_local of all nodes."""
    blocks = np.tile(np.eye(3), (2 * len(deck.grids.ids), 1, 1))
    for row, axes in deck.grids.axes.items():
        blocks[2 * row : 2 * row + 2] = axes
    n = len(blocks)
    return sp.bsr_array((blocks, np.arange(n), np.arange(n + 1)), shape=(3 * n, 3 * n)).tocsr()
