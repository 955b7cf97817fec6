"""Springs, dampers, bushings and concentrated masses."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.formats.deck.coordinate_systems import axes_at
from creak.formats.deck.refusals import referred
from creak.formats.nastran.sections.materials import damping
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import LINEAR, Deck
from creak.model.materials import AxialSpring, Bushing, NodalMatrices, PointMass, Spring

_PER_CARD = {"PELAS": (4, 1), "PDAMP": (2, 1), "PMASS": (2, 1)}
"""Property -> fields of one entry, and where its value stands after the id."""
_BY_PROPERTY = {
    "CELAS1": "PELAS",
    "CELAS3": "PELAS",
    "CDAMP1": "PDAMP",
    "CDAMP3": "PDAMP",
    "CMASS1": "PMASS",
    "CMASS3": "PMASS",
}
SCALAR_ELEMENTS = (
    *("CELAS1", "CELAS2", "CELAS3", "CELAS4", "CDAMP1", "CDAMP2", "CDAMP3", "CDAMP4", "CMASS1", "CMASS2"),
    *("CMASS3", "CMASS4"),
)


def read_points(deck: Deck) -> None:
    """Add springs, dampers, bushings and masses to the deck's groups.

    Raises
    ------
    InputError : an unknown grid or property, an id twice, a bushing without orientation.
    """
    values = {name: _values(deck, name) for name in _PER_CARD}
    for name in SCALAR_ELEMENTS:
        for card in deck.cards(name):
            _add_scalar(deck, card, values)
    table = {card.integer(i): (card, i) for card in deck.cards("PVISC") for i in (0, 4) if card.text(i)}
    for card in deck.cards("CVISC"):
        pid = card.integer(1, card.integer(0))
        owner, at = referred(table, pid, card, "property", "PVISC")
        if owner.real(at + 2, 0.0):
            deck.note(owner, "creak reads the axial dashpot only", changes=True, what="PVISC, CR")
        section = AxialSpring(f"PVISC {pid}", 0.0, owner.real(at + 1, 0.0))
        deck.add((pid,), "axial2", section, deck.new_element(card, pid), deck.nodes(card, (2, 3)), card)
    _read_axial(deck)
    bushings = {card.integer(0): card for card in deck.cards("PBUSH")}
    for card in deck.cards("CBUSH"):
        _add_bushing(deck, card, bushings)
    for card in deck.cards("CONM2"):
        _add_conm2(deck, card)
    for card in deck.cards("CONM1"):
        _add_conm1(deck, card)


_Values = dict[int, tuple[Card, float, float]]
"""Property -> its card, value and structural damping GE."""


def _values(deck: Deck, name: str) -> _Values:
    width, at = _PER_CARD[name]
    found: _Values = {}
    for card in deck.cards(name):
        for i in range(0, len(card.fields), width):
            if card.text(i):
                identifier, value = card.integer(i), card.real(i + at, 0.0)
                loss = card.real(i + 2, 0.0) if name == "PELAS" else 0.0
                if identifier in found and found[identifier][1:] != (value, loss):
                    raise card.twice(f"property {identifier}", found[identifier][0].where)
                found[identifier] = (card, value, loss)
    return found


def _add_scalar(deck: Deck, card: Card, values: dict[str, _Values]) -> None:
    """CELAS, CDAMP, CMASS between two dofs or one dof and ground, in the displacement frames of their grids."""
    kind = card.name
    if kind in _BY_PROPERTY:
        table, pid = values[_BY_PROPERTY[kind]], card.integer(1, card.integer(0))
        owner, value, loss = referred(table, pid, card, "property", _BY_PROPERTY[kind])
        identifier = deck.new_element(card, pid)
    else:
        identifier, value, owner = deck.new_element(card), card.real(1), card
        loss = card.real(6, 0.0) if kind == "CELAS2" else 0.0
    ends = _ends(deck, card, ((2, 0), (3, 0)) if kind[-1] in "34" else ((2, 3), (4, 5)))
    nodes = list(dict.fromkeys(row for row, _ in ends))
    g = np.zeros(6 * len(nodes))
    for sign, (row, dof) in zip((1.0, -1.0), ends, strict=False):
        g.reshape(-1, 6)[nodes.index(row)] += sign * deck.grids.six(row, dof)
    _put_scalar(deck, card, identifier, nodes, g, value, damping(deck, owner, loss))


def _ends(deck: Deck, card: Card, fields: tuple[tuple[int, int], ...]) -> list[tuple[int, int]]:
    """(row, dof) of the ends that are not ground."""
    ends = []
    for at, component in fields:
        if not card.integer(at, 0):
            continue
        row = deck.grids.row(card.integer(at), card)
        dof = card.integer(component, 0) if component else 0
        if row in deck.grids.scalar:
            dof = 1
        if not 1 <= dof <= 6:
            raise card.error(f"{card.title} acts on component {dof} of grid {card.text(at)}", expected="1 to 6")
        ends.append((row, dof))
    if not ends:
        raise card.error(f"{card.title} has no grid", expected="one or two grids")
    return ends


def _put_scalar(
    deck: Deck,
    card: Card,
    identifier: int,
    nodes: list[int],
    g: FloatArray,
    value: float,
    rayleigh: tuple[float, float],
) -> None:
    """As a spring between global dofs where it is one, else as matrices."""
    n = len(nodes)
    alpha, beta = (r if value and card.name[1] == key else 0.0 for key, r in zip("ME", rayleigh, strict=True))
    spring = card.name[1] in "ED"
    axes = [np.flatnonzero(end) for end in g.reshape(n, 6)]
    # A spring whose two ends lie along one global dof each, with opposite signs; its direction does not matter.
    plain = spring and all(a.size == 1 for a in axes) and (n == 1 or abs(g.sum()) < 1e-14) and np.abs(g).max() == 1.0
    if plain:
        dofs = [int(a[0]) + 1 for a in axes] + [0]
        k, c = (value, 0.0) if card.name[1] == "E" else (0.0, value)
        section = Spring(f"{card.name} {identifier}", dofs[0], dofs[1], k, c, beta)
        deck.add((dofs[0], dofs[1], k, c, beta), f"spring{n}", section, identifier, nodes, card)
        return
    matrix, zero = value * np.outer(g, g), np.zeros((6 * n, 6 * n))
    K, C, M = (matrix if card.name[1] == key else zero for key in "EDM")
    nodal = NodalMatrices(f"{card.name} {identifier}", K, M * deck.mass_factor, C, alpha, beta)
    deck.add((card.name[:5], value, beta, *np.round(g, 12).tolist()), f"nodal{n}", nodal, identifier, nodes, card)


def _read_axial(deck: Deck) -> None:
    """CBUSH1D: a spring and dashpot along the line of its grids, or along axis 1 of CID; its tables are left out."""
    table = {card.integer(0): card for card in deck.cards("PBUSH1D")}
    for card in deck.cards("CBUSH1D"):
        pid = card.integer(1, card.integer(0))
        identifier = deck.new_element(card, pid)
        owner = referred(table, pid, card, "property", "PBUSH1D")
        k, c, m = (owner.real(i, 0.0) for i in (1, 2, 3))
        alpha, beta = damping(deck, owner)
        kcb = (k, c, beta if k else 0.0)
        if any(owner.fields[8:]):
            linear = deck.case.solution in LINEAR
            why = (
                "the solution is linear: K and C hold, as in Nastran"
                if linear
                else "creak takes K and C at every motion"
            )
            deck.note(owner, why, changes=not linear, what="PBUSH1D, tables")
        nodes = deck.nodes(card, (2, 3) if card.integer(3, 0) else (2,))
        for row in nodes if m else ():
            share = m / len(nodes) * deck.mass_factor
            point = PointMass(f"PBUSH1D {pid}", share, alpha=alpha)
            deck.add(("PBUSH1D", pid, share), "mass", point, deck.free_id(), [row], card)
        if card.text(4) or len(nodes) == 1:
            # Stiffness, dashpot and beta along axis 1 of CID, on the translations alone.
            axes = axes_at(deck.system(card.integer(4, 0), card), deck.grids.place(nodes[0]))
            n = len(nodes)
            ends = np.zeros((n, 6))
            ends[:, :3] = np.outer((1.0, -1.0)[:n], axes[:, 0])
            g = ends.ravel()
            K, C = (value * np.outer(g, g) for value in kcb[:2])
            section = NodalMatrices(f"PBUSH1D {pid}", K, np.zeros_like(K), C, beta=kcb[2])
            deck.add(("PBUSH1D", pid, *np.round(g, 12).tolist()), f"nodal{n}", section, identifier, nodes, card)
        else:
            line = deck.grids.place(nodes[1]) - deck.grids.place(nodes[0])
            if not np.linalg.norm(line) > 0.0:
                raise card.error(f"CBUSH1D {identifier} has coincident grids and no CID", expected="CID")
            deck.add(("PBUSH1D", pid), "axial2", AxialSpring(f"PBUSH1D {pid}", *kcb), identifier, nodes, card)


def _add_bushing(deck: Deck, card: Card, properties: dict[int, Card]) -> None:
    pid = card.integer(1, card.integer(0))
    identifier = deck.new_element(card, pid)
    owner = referred(properties, pid, card, "property", "PBUSH")
    k, c, losses = _bushing_values(deck, owner)
    two = bool(card.integer(3, 0))
    nodes = deck.nodes(card, (2, 3) if two else (2,))
    ends = [deck.grids.place(row) for row in nodes]
    own = _bushing_axes(deck, card, nodes, ends, k, c)
    if card.text(9) and card.integer(9) >= 0:
        deck.note(card, "creak takes the point of the spring at S between the grids", changes=True, what="CBUSH, OCID")
    location = card.real(8, 0.5)
    betas = np.array([damping(deck, owner, loss)[1] if stiff else 0.0 for stiff, loss in zip(k, losses, strict=True)])
    for n, beta in enumerate(dict.fromkeys(betas[k != 0.0].tolist()) or [0.0]):
        # Directions damped otherwise (GE1 to GE6) are a further bushing beside the first, which has the dashpots.
        K, C = np.diag(np.where(betas == beta, k, 0.0)), np.diag(0.0 * c if n else c)
        one = deck.further_piece(identifier) if n else identifier
        section = Bushing(f"PBUSH {pid}", K, C, location, beta)
        deck.add((pid, location, beta), "bush2" if two else "bush1", section, one, nodes, card, **own)


def _bushing_values(deck: Deck, card: Card) -> tuple[FloatArray, FloatArray, FloatArray]:
    """K, B and GE lines of a PBUSH card, six values each; a line may begin with its flag, one field early.

    GE1 alone holds for all directions.
    """
    found = {"K": np.zeros(6), "B": np.zeros(6), "GE": np.zeros(6)}
    for line in range(0, len(card.fields), 8):
        at = line if line and card.text(line) else line + 1
        flag = card.text(at).upper()
        values = [card.text(at + 1 + i) for i in range(6)]
        if flag in found:
            found[flag] = np.array([card.real(at + 1 + i, 0.0) for i in range(6)])
            if flag == "GE" and not any(values[1:]):
                found[flag][:] = found[flag][0]
        elif flag == "M" and any(values):
            deck.note(card, "creak does not read the mass of a bushing", changes=True, what="PBUSH, M")
        elif flag not in ("RCV", "M") and (flag or any(values)):
            raise card.error(f"a line of PBUSH {card.text(0)} begins with {flag!r}", expected="K, B, GE, RCV or M")
    return found["K"], found["B"], found["GE"]


def _bushing_axes(
    deck: Deck, card: Card, nodes: list[int], ends: list[FloatArray], k: FloatArray, c: FloatArray
) -> dict[str, FloatArray]:
    """CID: its axes at GA. Else axis 1 runs from GA to GB and GO or X1, X2, X3 lies in the 1-2 plane."""
    if card.text(7):
        axes = axes_at(deck.system(card.integer(7), card), ends[0])
        return {} if np.array_equal(axes, np.eye(3)) else {"axis1": axes[:, 0], "axis2": axes[:, 1]}
    across = np.flatnonzero(k + c)
    if len(ends) == 1 or not np.linalg.norm(ends[1] - ends[0]) > 0.0:
        if np.ptp(k[:3]) + np.ptp(k[3:]) + np.ptp(c[:3]) + np.ptp(c[3:]) > 0.0:
            raise card.error(
                f"CBUSH {card.text(0)} has coincident grids (or one) and no CID",
                expected="CID",
                fix="Give the coordinate system of its axes.",
            )
        return {}
    line = ends[1] - ends[0]
    if card.is_integer(4) and not card.text(5):
        v = deck.grids.place(deck.grids.row(card.integer(4), card)) - ends[0]
    elif any(card.text(i) for i in (4, 5, 6)):
        v = np.array([card.real(i, 0.0) for i in (4, 5, 6)])
        v = deck.grids.axes[nodes[0]] @ v if nodes[0] in deck.grids.axes else v
    elif set(across.tolist()) <= {0, 3}:
        v = np.eye(3)[int(np.argmin(np.abs(line)))]
    else:
        raise card.error(f"CBUSH {card.text(0)} has no orientation", expected="GO, X1, X2, X3 or CID")
    if not np.linalg.norm(np.cross(line, v)) > 1e-6 * np.linalg.norm(line) * np.linalg.norm(v):
        raise card.error(f"the orientation of CBUSH {card.text(0)} lies along it", expected="a vector across it")
    return {"axis1": line, "axis2": v}


def _frame(deck: Deck, card: Card, field: int, place: FloatArray) -> FloatArray:
    return axes_at(deck.system(card.integer(field, 0), card), place)


def _add_conm2(deck: Deck, card: Card) -> None:
    """Mass and inertia about its centre, offset X in the axes of CID (CID = -1: X is a place in the basic frame)."""
    identifier, (node,) = deck.new_element(card), deck.nodes(card, (1,))
    place, factor = deck.grids.place(node), deck.mass_factor
    x = np.array([card.real(i, 0.0) for i in (4, 5, 6)])
    absolute = card.integer(2, 0) == -1
    R = np.eye(3) if absolute else _frame(deck, card, 2, place)
    offset = x - place if absolute else R @ x
    i11, i21, i22, i31, i32, i33 = (card.real(i, 0.0) for i in range(8, 14))
    J = factor * R @ np.array([[i11, -i21, -i31], [-i21, i22, -i32], [-i31, -i32, i33]]) @ R.T
    inertia = (J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2])
    values = tuple(float(v) for v in inertia)
    mass = PointMass(
        f"CONM2 {identifier}",
        card.real(3, 0.0) * factor,
        values,  # type: ignore[arg-type]
        damping(deck, card)[0],
        offset=tuple(float(v) for v in offset),  # type: ignore[arg-type]
    )
    deck.add((mass.mass, *values, *mass.offset), "mass", mass, identifier, [node], card)


def _add_conm1(deck: Deck, card: Card) -> None:
    """A 6 x 6 mass matrix, lower triangle, in the axes of CID."""
    identifier, (node,) = deck.new_element(card), deck.nodes(card, (1,))
    M, at = np.zeros((6, 6)), 3
    for i in range(6):
        for j in range(i + 1):
            M[i, j] = M[j, i] = card.real(at, 0.0)
            at += 1
    turn = np.kron(np.eye(2), _frame(deck, card, 2, deck.grids.place(node)))
    M = deck.mass_factor * turn @ M @ turn.T
    zero = np.zeros((6, 6))
    section = NodalMatrices(f"CONM1 {identifier}", zero, M, zero, damping(deck, card)[0] if M.any() else 0.0)
    deck.add((identifier,), "nodal1", section, identifier, [node], card)
