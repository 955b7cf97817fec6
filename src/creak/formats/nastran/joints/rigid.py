"""RBE1, RBE2, RBE3, RBAR, RBAR1, RROD and MPC -> constraints, and which sets of SPC and MPC cards act."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.deck.equations import ZERO, global_equations, relative_motion, rigid_arm
from creak.formats.nastran.mesh.grids import Grids
from creak.formats.nastran.text.bulk_data import Card, id_list
from creak.formats.nastran.text.deck import Deck
from creak.model.constraints import Constraint, DistributingCoupling, Equation, KinematicCoupling, RigidLink
from creak.model.dofs import ALL
from creak.model.mesh import Unread

SINGULAR = 1e-12
LocalDof = tuple[int, int]
"""Node row and dof 1..6 in the node's displacement frame."""
_CARDS = {"SPC": ("SPC", "SPC1"), "MPC": ("MPC",)}


def read_rigid(deck: Deck) -> list[Constraint]:
    """All rigid elements, and the MPC set that the case control takes.

    Raises
    ------
    InputError : an unknown grid, an id twice, independent dofs that do not define a rigid motion.
    """
    found: list[Constraint] = []
    first: dict[int, Card] = {}
    readers = {"RBE2": _rbe2, "RBE3": _rbe3, "RBAR": _rbar, "RBAR1": _rbar1, "RBE1": _rbe1, "RROD": _rrod}
    for name, reader in readers.items():
        for card in deck.cards(name):
            before = first.setdefault(card.integer(0), card)
            if before is not card:
                raise card.twice(f"rigid element {card.integer(0)} ({card.name})", before.where)
            found += reader(deck, card)
    return found + list(_multipoint(deck))


def _whole(dofs: tuple[int, ...]) -> bool:
    """Are the translations all there or all missing, and the rotations too? Then the frame does not matter."""
    return len({1, 2, 3} & set(dofs)) in (0, 3) and len({4, 5, 6} & set(dofs)) in (0, 3)


def _rows(deck: Deck, node: int, dofs: tuple[int, ...]) -> FloatArray:
    """(n, 6) local dofs of a node in its global (u, theta)."""
    return np.array([deck.grids.six(node, dof) for dof in dofs], dtype=np.float64).reshape(-1, 6)


def _rbe2(deck: Deck, card: Card) -> Iterator[Constraint]:
    """The dofs CM of the grids GM follow grid GN."""
    ref, dofs = deck.grids.row(card.integer(1), card), card.components(2)
    if not dofs:
        raise card.wrong(2, "dofs, digits 1 to 6")
    nodes = _grid_list(deck, card, 3)
    if ref in nodes:
        raise card.error(f"RBE2 {card.text(0)} makes grid {card.text(1)} follow itself")
    plain = [n for n in nodes if _whole(dofs) or n not in deck.grids.axes]
    if plain:
        name = f"RBE2 {card.integer(0)}"
        yield KinematicCoupling(name, ref, np.array(plain, dtype=np.int64), dofs, card.where)
    for node in sorted(set(nodes) - set(plain)):
        arm = deck.grids.place(node) - deck.grids.place(ref)
        yield from relative_motion(node, ref, arm, _rows(deck, node, dofs), card.where)


def _rbar1(deck: Deck, card: Card) -> Iterator[Constraint]:
    """The dofs CB of GB (default all) follow GA."""
    ref, node = deck.nodes(card, (1, 2))
    dofs = card.components(3, "123456")
    arm = deck.grids.place(node) - deck.grids.place(ref)
    yield from relative_motion(node, ref, arm, _rows(deck, node, dofs), card.where)


def _grid_list(deck: Deck, card: Card, first: int) -> list[int]:
    """Rows of a list of grids with THRU; real fields (ALPHA) end it."""
    rows: list[int] = []
    i = first
    while i < len(card.fields):
        text = card.text(i)
        if text.upper() == "THRU" and rows:
            low, high = card.integer(i - 1) + 1, card.integer(i + 1)
            rows += [deck.grids.row(k, card) for k in range(low, high + 1)]
            i += 2
        elif not text:
            i += 1
        elif not card.is_integer(i):
            card.real(i)
            break
        else:
            rows.append(deck.grids.row(card.integer(i), card))
            i += 1
    if not rows:
        raise card.error(f"{card.title} has no grids", expected="dependent grids")
    return list(dict.fromkeys(rows))


def _rbe3(deck: Deck, card: Card) -> Iterator[Constraint]:
    """The reference grid follows the weighted mean motion of the others: u_ref = (S' W S)^-1 S' W u.

    S holds the rigid motion of each listed dof about the reference grid; W its weight, for rotations times the
    square of the mean distance of the grids (MSC and NX). UM swaps which dofs are eliminated.
    """
    ref, refc = deck.grids.row(card.integer(2), card), card.components(3)
    if not refc:
        raise card.wrong(3, "dofs, digits 1 to 6")
    entries, swapped = _weights(deck, card)
    simple = not swapped and _whole(refc) and all(dofs == (1, 2, 3) for _, dofs, _ in entries)
    nodes = [node for node, _, _ in entries]
    if simple and len(set(nodes)) == len(nodes):
        weights = np.array([w for _, _, w in entries])
        yield DistributingCoupling(f"RBE3 {card.integer(0)}", ref, np.array(nodes), weights, refc, card.where)
        return
    X, dofs = _mean_motion(deck, card, ref, entries)
    own = [(ref, d) for d in refc]
    C = np.concatenate([np.eye(len(refc)), -_rows(deck, ref, refc) @ X], axis=1)
    yield from _eliminating(deck, card, [*own, *dofs], C, swapped or own)


def _eliminating(
    deck: Deck, card: Card, dofs: list[LocalDof], C: FloatArray, dependent: list[LocalDof]
) -> Iterator[Constraint]:
    """C u = 0 with columns summed where a dof is there twice, solved for `dependent`."""
    names = list(dict.fromkeys([*dependent, *dofs]))
    if len(names) > len(set(dofs)):
        raise card.error(
            f"UM of {card.title} names dofs that the card does not use",
            expected="dofs of the reference grid and of the listed grids",
        )
    if len(dependent) != C.shape[0]:
        raise card.error(f"UM of {card.title} names {len(dependent)} dofs", expected=f"{C.shape[0]}, as many as REFC")
    summed, column = np.zeros((C.shape[0], len(names))), {name: k for k, name in enumerate(names)}
    for k, dof in enumerate(dofs):
        summed[:, column[dof]] += C[:, k]
    block = summed[:, : len(dependent)]
    if not np.linalg.cond(block / np.abs(block).max(axis=0)) < 1.0 / SINGULAR:
        raise card.error(f"the dependent dofs of {card.title} cannot be solved for", fix="Choose other dofs.")
    yield from local_equations(deck.grids, names, summed, len(dependent), card.where)


def _weights(deck: Deck, card: Card) -> tuple[list[tuple[int, tuple[int, ...], float]], list[LocalDof]]:
    """(node, dofs, weight) of each listed grid, and the dofs of UM."""
    entries: list[tuple[int, tuple[int, ...], float]] = []
    swapped: list[LocalDof] = []
    weight = 0.0
    dofs: tuple[int, ...] = ()
    i = 4
    while i < len(card.fields):
        text = card.text(i).upper()
        if text in ("UM", "ALPHA"):
            swapped += _swapped(deck, card, i + 1) if text == "UM" else []
            break
        if not text:
            i += 1
        elif card.is_integer(i):
            entries.append((deck.grids.row(card.integer(i), card), dofs, weight))
            i += 1
        else:
            weight, dofs = card.real(i), card.components(i + 1)
            i += 2
    if not entries or not all(d and w > 0.0 for _, d, w in entries):
        raise card.error(f"RBE3 {card.text(0)} has grids without weight or dofs", expected="WT > 0, C, and grids")
    return entries, swapped


def _swapped(deck: Deck, card: Card, first: int) -> list[LocalDof]:
    """Pairs of grid and dofs after UM, up to ALPHA."""
    end = next((i for i in range(first, len(card.fields)) if card.text(i).upper() == "ALPHA"), len(card.fields))
    filled = [i for i in range(first, end) if card.text(i)]
    found: list[LocalDof] = []
    for i, j in zip(filled[::2], filled[1::2], strict=False):
        found += [(deck.grids.row(card.integer(i), card), d) for d in card.components(j)]
    return found


def _mean_motion(
    deck: Deck, card: Card, ref: int, entries: list[tuple[int, tuple[int, ...], float]]
) -> tuple[FloatArray, list[LocalDof]]:
    """X (6, n): global motion of the reference grid from the listed local dofs."""
    arms = {node: deck.grids.place(node) - deck.grids.place(ref) for node, _, _ in entries}
    length = float(np.mean([np.linalg.norm(arms[node]) for node, _, _ in entries])) or 1.0
    dofs = [(node, d) for node, of_node, _ in entries for d in of_node]
    S = np.concatenate([_rows(deck, node, of_node) @ rigid_arm(arms[node]) for node, of_node, _ in entries])
    w = np.array([weight * (length**2 if d > 3 else 1.0) for _, of_node, weight in entries for d in of_node])
    A = S.T @ (w[:, None] * S)
    scale = np.array([1.0, 1.0, 1.0, length, length, length])
    if not np.linalg.cond(A / np.outer(scale, scale)) < 1.0 / SINGULAR:
        raise card.error(
            f"the grids of RBE3 {card.text(0)} do not define a rigid motion",
            expected="three grids that span an area, or rotations",
            fix="List more dofs.",
        )
    return np.linalg.solve(A, S.T * w), dofs


def _rbar(deck: Deck, card: Card) -> Iterator[Constraint]:
    """Rigid bar; independent dofs CNA, CNB (six in all), dependent CMA, CMB (blank: the rest)."""
    a, b = (deck.grids.row(card.integer(i), card) for i in (1, 2))
    cna, cnb, cma, cmb = (card.components(i) for i in (3, 4, 5, 6))
    if not cna and not cnb:
        cna = ALL
    if not cma and not cmb:
        cma, cmb = tuple(sorted(set(ALL) - set(cna))), tuple(sorted(set(ALL) - set(cnb)))
    if (cna, cmb) == (ALL, ALL):
        yield RigidLink("beam", b, a, card.where)
    elif (cnb, cma) == (ALL, ALL):
        yield RigidLink("beam", a, b, card.where)
    else:
        yield from _rigid_body(deck, card, [(a, cna), (b, cnb)], [(a, cma), (b, cmb)])


def _rbe1(deck: Deck, card: Card) -> Iterator[Constraint]:
    """Rigid body: six independent dofs (GN, CN), dependent ones after UM."""
    um = next((i for i in range(1, len(card.fields)) if card.text(i).upper() == "UM"), len(card.fields))
    sides: list[list[tuple[int, tuple[int, ...]]]] = []
    for first, end in ((1, um), (um + 1, len(card.fields))):
        filled = [i for i in range(first, end) if card.text(i) and (card.is_integer(i))]
        sides.append(
            [
                (deck.grids.row(card.integer(i), card), card.components(j))
                for i, j in zip(filled[::2], filled[1::2], strict=False)
            ]
        )
    yield from _rigid_body(deck, card, sides[0], sides[1])


def _rigid_body(
    deck: Deck,
    card: Card,
    independent: list[tuple[int, tuple[int, ...]]],
    dependent: list[tuple[int, tuple[int, ...]]],
) -> Iterator[Constraint]:
    """u_m = R_m R_n^-1 u_n with the rigid motion R of each dof; the six dofs n define it."""
    pole = deck.grids.place(independent[0][0] if independent else dependent[0][0])

    def motion(side: list[tuple[int, tuple[int, ...]]]) -> FloatArray:
        rows = [_rows(deck, node, dofs) @ rigid_arm(deck.grids.place(node) - pole) for node, dofs in side]
        return np.concatenate([np.zeros((0, 6)), *rows])

    R_n, R_m = motion(independent), motion(dependent)
    if R_n.shape[0] != 6 or not np.linalg.cond(R_n / np.maximum(np.abs(R_n).max(axis=0), 1e-300)) < 1.0 / SINGULAR:
        raise card.error(
            f"the independent dofs of {card.title} do not define a rigid motion",
            expected="six dofs that no rigid motion leaves at rest",
        )
    m, n = ([(node, d) for node, of_node in side for d in of_node] for side in (dependent, independent))
    C = np.concatenate([np.eye(len(m)), -R_m @ np.linalg.inv(R_n)], axis=1)
    yield from local_equations(deck.grids, [*m, *n], C, len(m), card.where)


def _rrod(deck: Deck, card: Card) -> Iterator[Constraint]:
    """The distance of two grids stays: t . (u_b - u_a) = 0."""
    a, b = (deck.grids.row(card.integer(i), card) for i in (1, 2))
    t = deck.grids.place(b) - deck.grids.place(a)
    if not np.linalg.norm(t) > 0.0:
        raise card.error(f"RROD {card.text(0)} has zero length")
    row = np.concatenate([t, np.zeros(3)])[None, :] / np.linalg.norm(t)
    dependent, other = (a, b) if card.components(3) else (b, a)
    yield from relative_motion(dependent, other, np.zeros(3), row, card.where)


def _multipoint(deck: Deck) -> Iterator[Constraint]:
    """MPC: sum A u = 0 over dofs of displacement frames; the first is eliminated."""
    chosen = combined(deck, "MPCADD", selected(deck, "MPC", deck.case.mpc))
    for card in deck.cards("MPC"):
        if card.integer(0) not in chosen:
            continue
        dofs: list[LocalDof] = []
        values: list[float] = []
        for i in _triples(card):
            row = deck.grids.row(card.integer(i), card)
            dof = 1 if row in deck.grids.scalar else card.integer(i + 1)
            if not 1 <= dof <= 6:
                raise card.wrong(i + 1, "a dof from 1 to 6")
            dofs.append((row, dof))
            values.append(card.real(i + 2, 0.0))
        if not values or values[0] == 0.0:
            raise card.error(f"MPC of set {card.integer(0)} has no first coefficient", expected="A1 not 0")
        yield from local_equations(deck.grids, dofs, np.array([values]), 1, card.where)


def _triples(card: Card) -> Iterator[int]:
    """Where G, C, A stand: two in each line of eight, after its first field."""
    for line in range(0, len(card.fields), 8):
        for i in (line + 1, line + 4):
            if card.text(i):
                yield i


def local_equations(
    grids: Grids, dofs: Sequence[LocalDof], C: FloatArray, n_dependent: int, where: str
) -> Iterator[Equation]:
    """C u = 0 on local dofs; those of the first `n_dependent` are to be eliminated.

    The dofs are turned to global axes, and the equations combined so that each eliminates a global dof of its own
    (of a node with a dependent dof, the translations and the rotations apart) with the largest pivot there is.
    """
    columns: dict[LocalDof, int] = {}
    entries: list[tuple[int, int, float]] = []
    dependent: set[int] = set()
    for k, (row, dof) in enumerate(dofs):
        first = 4 if dof > 3 else 1
        for axis, share in enumerate(grids.direction(row, dof)):
            if abs(share) > ZERO:
                column = columns.setdefault((row, first + axis), len(columns))
                entries.append((k, column, float(share)))
                if k < n_dependent:
                    dependent.add(column)
    turn = np.zeros((len(dofs), len(columns)))
    for k, column, share in entries:
        turn[k, column] = share
    yield from global_equations(list(columns), np.asarray(C) @ turn, dependent, where)


def selected(deck: Deck, what: str, chosen: int) -> int:
    """The set that acts: the case control's; in a deck without case control the only one there is.

    Raises
    ------
    InputError : the case control names a set that no card has.
    """
    cards = list(deck.cards(*_CARDS[what], f"{what}ADD"))
    there = sorted({card.integer(0) for card in cards})
    if chosen and not there:
        why = f"{what} = {chosen} in the case control, but the deck has no {what} cards: nothing is held by them"
        entry = Unread(f"{what} = {chosen}", deck.case.where, False, why)
        deck.unread += [] if entry in deck.unread else [entry]
        return 0
    if chosen:
        if chosen not in there:
            raise InputError(
                f"{what} = {chosen} in the case control, but no card has this set",
                where=deck.case.where,
                expected=f"one of {there}",
            )
        return chosen
    if not there:
        return 0
    alone = sorted({card.integer(0) for card in deck.cards(*_CARDS[what])})
    if not deck.case.given and len(alone) == 1:
        deck.note(cards[0], f"the deck has no case control: its only {what} set {alone[0]} is taken", changes=False)
        return alone[0]
    why = f"the case control takes no {what} set (there are {', '.join(map(str, there))})"
    deck.note(cards[0], why, changes=not deck.case.given)
    return 0


def combined(deck: Deck, adding: str, chosen: int) -> set[int]:
    """The set itself and those that SPCADD or MPCADD put together."""
    found, left = set(), [chosen]
    while left:
        one = left.pop()
        if one in found:
            continue
        found.add(one)
        for card in deck.cards(adding):
            if card.integer(0) == one:
                left += list(id_list(card, 1))
    return found - {0}
