"""CFAST and CWELD: a short bar between two shell patches, each of which carries one end of it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError
from creak.formats.deck.coordinate_systems import axes_at
from creak.formats.deck.refusals import referred
from creak.formats.nastran.sections.materials import Materials, damping
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import Deck, unique_cards
from creak.model.constraints import Constraint, Equation, Fixed, RigidLink, rigid_at
from creak.model.faces import FACES, SHELL_FACETS
from creak.model.materials import Bushing, GeneralShell, Material, PointMass, ShellSection
from creak.model.projection import nearest_points

Patch = tuple[str, int, int]
"""PROP or ELEM and an id, or GRID, the element and its side."""
HALF = math.sqrt(math.pi) / 4.0
"""Half the side of the square of the fastener's area, over its diameter: where the four points of a patch stand."""
SHORTEST = 1e-4
"""Length of a CWELD whose ends coincide and whose LDMIN is 0."""
SLENDER = (0.2, 5.0)
"""LDMIN and LDMAX of a PWELD that gives none."""
BESIDE = 0.05
"""Share of a facet by which a fastener may lie beside a patch."""
SHEAR = 0.9
"""Shear factor of its circular section."""


@dataclass(frozen=True)
class _Fastener:
    card: Card
    identifier: int
    owner: Card
    """Its property."""
    patches: tuple[Patch | None, Patch | None]
    """None: the other end is the grid itself."""
    start: FloatArray
    """(3,) what is projected on the patches."""
    given: tuple[int | None, int | None]
    """Rows of GA and GB where the deck gives them."""

    @property
    def is_spot(self) -> bool:
        """A weld of TYPE = SPOT between shells, whose length is half of both thicknesses."""
        shells = all(patch is not None and patch[0] != "GRID" for patch in self.patches)
        return shells and self.owner.name == "PWELD" and self.owner.text(7).upper() == "SPOT"


@dataclass(frozen=True)
class GivenEnd:
    """GA or GB of a fastener: a grid at one of its ends."""

    card: Card
    link: RigidLink
    """The grid follows the node of the end."""
    own: bool
    """MSET = ON of PWELD: Nastran would make the grid itself the end, and stop where it follows others too."""


def read_fasteners(deck: Deck, materials: Materials) -> tuple[list[Constraint], list[GivenEnd]]:
    """Springs in the middle between the piercing points, and the equations that hang these points on their patches.

    The second list is what `following_grids` needs once all other constraints and supports are known.

    A point follows four points around it, at the corners of the square of the same area, by least squares (rigid
    motion is exact); each of them follows the shape functions of the shell that it meets.

    Raises
    ------
    InputError : an unknown grid, element or property, a patch without shells, no place, wrong limits of a length.
    """
    fasteners = [*_cfasts(deck), *_cwelds(deck)]
    found: list[Constraint] = []
    given_ends: list[GivenEnd] = []
    surfaces: dict[Patch, tuple[IntArray, FloatArray]] = {}
    coords = np.array(deck.grids.coords)
    for f in fasteners:
        ends: list[FloatArray] = []
        rows: list[int] = []
        for side, patch in enumerate(f.patches):
            given = f.given[side]
            if patch is None:
                assert given is not None
                ends.append(deck.grids.place(given))
                rows.append(given)
                continue
            if patch not in surfaces:
                surfaces[patch] = _facets(deck, f.card, patch)
            ends.append(deck.grids.place(given) if given is not None else _pierced(f, *surfaces[patch], coords))
            rows.append(deck.grids.add(ends[-1]))
            if given is not None:
                own = f.owner.name == "PWELD" and f.owner.text(5).upper() == "ON"
                given_ends.append(GivenEnd(f.card, RigidLink("tie", given, rows[-1], f.card.where), own))
        normal = np.eye(3)[0] if f.patches[0] is None else _normal(ends[0], *surfaces[f.patches[0]], coords)
        along = _frame(ends, normal)
        for side, patch in enumerate(f.patches):
            if patch is not None:
                found += _hung(f, rows[side], ends[side], along, *surfaces[patch], coords)
        met = [(end, *surfaces[p]) for end, p in zip(ends, f.patches, strict=True) if p is not None]
        if f.is_spot:
            length = 0.5 * sum(float(t[_met(end[None], corners, coords)[0][0]]) for end, corners, t in met)
        else:
            length = _within_limits(f, float(np.linalg.norm(ends[1] - ends[0])))
        _connect(deck, f, rows, _axes(deck, f, ends[0], along), materials, length)
    return found, given_ends


def following_grids(
    deck: Deck, ends: list[GivenEnd], constraints: Iterable[Constraint], fixed: Iterable[Fixed]
) -> Iterator[Constraint]:
    """GA and GB follow the ends of their fastener, so that what hangs on them hangs on its patches.

    A grid of a shell or solid, or one that follows or is held already, gives its place alone.
    """
    meshes = (g.nodes for g in deck.groups.values() if g.kind in SHELL_FACETS or g.kind in FACES)
    meshed = {row for elements in meshes for nodes in elements for row in nodes}
    bound = {row for c in constraints for row in c.dependents.tolist()}
    bound |= {row for f in fixed for row in f.nodes_idx.tolist()}
    joined: set[int] = set()
    for end in ends:
        row = end.link.dependent_idx
        if row in bound and row not in meshed:
            why = "its grid is held or follows others already: it gives the place of an end and does not follow it"
            what = f"GA or GB of {end.card.name}" + (" with MSET = ON" if end.own else "")
            deck.note(end.card, why, changes=end.own, what=what)
        elif row not in meshed | joined:
            joined.add(row)
            yield end.link


def _cfasts(deck: Deck) -> Iterator[_Fastener]:
    properties = unique_cards(deck.cards("PFAST"), "property")
    for card in deck.cards("CFAST"):
        pid = card.integer(1, card.integer(0))
        owner = referred(properties, pid, card, "property", "PFAST")
        kind = card.text(2).upper()
        if kind not in ("PROP", "ELEM"):
            raise card.wrong(2, "PROP or ELEM")
        given = tuple(deck.grids.row(card.integer(i), card) if card.integer(i, 0) else None for i in (6, 7))
        patches = (kind, card.integer(3), 0), (kind, card.integer(4), 0)
        start = _place(deck, card, 5, given[0], 8)
        yield _Fastener(card, deck.new_element(card, pid), owner, patches, start, (given[0], given[1]))


def _cwelds(deck: Deck) -> Iterator[_Fastener]:
    properties = unique_cards(deck.cards("PWELD"), "property")
    for card in deck.cards("CWELD"):
        pid = card.integer(1, card.integer(0))
        owner = referred(properties, pid, card, "property", "PWELD")
        identifier, kind = deck.new_element(card, pid), card.text(3).upper()
        given = tuple(deck.grids.row(card.integer(i), card) if card.integer(i, 0) else None for i in (4, 5))
        first, second = given
        if kind == "ALIGN":
            if first is None or second is None:
                raise card.error(f"CWELD {identifier} has no GA and GB", expected="two grids")
            yield _Fastener(card, identifier, owner, (None, None), deck.grids.place(first), (first, second))
            continue
        names = {"PARTPAT": "PROP", "ELPAT": "ELEM", "ELEMID": "ONE", "GRIDID": "GRID"}
        if kind not in names:
            raise card.wrong(3, f"{', '.join(names)} or ALIGN")
        start = _place(deck, card, 2, first, 16 if kind in ("PARTPAT", "ELPAT") else len(card.fields))
        if kind == "GRIDID":
            patches: tuple[Patch | None, Patch | None] = ("GRID", identifier, 8), ("GRID", identifier, 16)
        else:
            patches = (names[kind], card.integer(8), 0), (names[kind], card.integer(9, 0), 0)
        if not card.integer(16 if kind == "GRIDID" else 9, 0):
            patches, second = (patches[0], None), deck.grids.row(card.integer(2), card)
        yield _Fastener(card, identifier, owner, patches, start, (first, second))


def _place(deck: Deck, card: Card, gs: int, ga: int | None, xyz: int) -> FloatArray:
    if card.integer(gs, 0):
        return deck.grids.place(deck.grids.row(card.integer(gs), card))
    if ga is not None:
        return deck.grids.place(ga)
    if not any(card.text(xyz + i) for i in range(3)):
        raise card.error(f"{card.title} has no place", expected="GS, GA or XS, YS, ZS")
    return np.array([card.real(xyz + i, 0.0) for i in range(3)])


def _facets(deck: Deck, card: Card, patch: Patch) -> tuple[IntArray, FloatArray]:
    """(n, 4) corners of the shells of a patch, and (n,) their thickness."""
    kind, identifier, at = patch
    if kind == "GRID":
        count = 4 if card.text(6).upper()[(at - 8) // 8 :][:1] == "Q" else 3
        rows = [deck.grids.row(card.integer(at + i), card) for i in range(count)]
        return np.array([rows if count == 4 else [*rows, rows[2]]], dtype=np.int64), np.zeros(1)
    wanted = deck.property_of.get(identifier) if kind == "ELEM" else identifier
    corners: list[list[int]] = []
    thickness: list[float] = []
    for group in deck.groups.values():
        if group.kind not in SHELL_FACETS:
            continue
        for k, (e, nodes) in enumerate(zip(group.ids, group.nodes, strict=True)):
            if (e == identifier) if kind == "ONE" else deck.property_of.get(e) == wanted:
                mine = [[nodes[i] for i in facet] for facet in SHELL_FACETS[group.kind]]
                corners += mine
                # Mean thickness of the k-th shell of a group, wherever its middle lies.
                assert isinstance(group.section, ShellSection | GeneralShell)
                own = group.own.get("thickness")
                thickness += [group.section.thickness * (1.0 if own is None else float(own[k].mean()))] * len(mine)
    if not corners:
        what = "property" if kind == "PROP" else "element"
        raise card.error(
            f"{card.title} joins {what} {identifier}, which has no shells", expected="CQUAD4, CTRIA3, CQUAD8 or CTRIA6"
        )
    return np.array(corners, dtype=np.int64), np.array(thickness)


def _met(points: FloatArray, corners: IntArray, coords: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """The nearest facet of each point, its shape functions there, and the place."""
    X = coords[corners]
    nearest = nearest_points(points, X, corners[:, 2] == corners[:, 3], np.inf)
    return nearest.facet, nearest.shape, np.einsum("nj,njx->nx", nearest.shape, X[nearest.facet])


def _pierced(f: _Fastener, corners: IntArray, _: FloatArray, coords: FloatArray) -> FloatArray:
    """Where the place of the fastener projects on a patch."""
    facet, _, met = _met(f.start[None], corners, coords)
    X, apart = coords[corners[facet[0]]], f.start - met[0]
    normal = np.cross(X[2] - X[0], X[3] - X[1])
    normal /= np.linalg.norm(normal)
    beside = float(np.linalg.norm(apart - (apart @ normal) * normal))
    if beside > BESIDE * float(np.linalg.norm(X[2] - X[0])):
        raise InputError(
            f"{f.card.title} lies {beside:.4g} beside a patch",
            where=f.card.where,
            expected="a place that projects on both patches",
            fix="Move GS, or correct the ids of the patches.",
        )
    return np.asarray(met[0])


def _normal(place: FloatArray, corners: IntArray, _: FloatArray, coords: FloatArray) -> FloatArray:
    X = coords[corners[_met(place[None], corners, coords)[0][0]]]
    normal = np.cross(X[2] - X[0], X[3] - X[1])
    return np.asarray(normal / np.linalg.norm(normal))


def _frame(ends: list[FloatArray], normal: FloatArray) -> FloatArray:
    """(3, 3), rows x along the fastener (the normal of patch A where it has no length), y near a basic axis, z."""
    line = ends[1] - ends[0]
    length = float(np.linalg.norm(line))
    x = line / length if length > 1e-9 * (1.0 + float(np.abs(ends[0]).max())) else normal
    return _about(x, np.eye(3)[int(np.argmin(np.round(np.abs(x), 9)))])


def _about(x: FloatArray, y: FloatArray) -> FloatArray:
    """(3, 3), rows x, the part of y across it, z."""
    z = np.cross(x, y)
    z /= np.linalg.norm(z)
    return np.array([x, np.cross(z, x), z])


def _axes(deck: Deck, f: _Fastener, place: FloatArray, along: FloatArray) -> FloatArray:
    """(3, 3), rows are the directions of the springs: `along`, or by MCID and MFLAG of PFAST."""
    mcid = f.owner.integer(2, -1) if f.card.name == "CFAST" else -1
    if mcid < 0:
        return along
    T = axes_at(deck.system(mcid, f.owner), place)
    return np.asarray(T.T) if f.owner.integer(3, 0) == 1 else _about(along[0], T[:, 1])


def _hung(
    f: _Fastener, row: int, place: FloatArray, along: FloatArray, corners: IntArray, _: FloatArray, coords: FloatArray
) -> Iterator[Equation]:
    """(u, theta) of the piercing point from the translations of the grids: A^-1 sum_k S_k' sum_j N_kj u_j.

    The four points lie across `along`, whatever the directions of the springs.
    """
    d = HALF * f.owner.real(1 if f.card.name == "CFAST" else 2)
    if not d > 0.0:
        raise InputError(f"{f.owner.title} has diameter {d / HALF:g}", where=f.owner.where, expected="> 0")
    _, y, z = along
    around = place + d * np.array([y + z, y - z, -y - z, z - y])
    facet, shape, met = _met(around, corners, coords)
    S = rigid_at(met - place)
    A = np.einsum("kia,kib->ab", S, S)
    scale = np.array([1.0, 1.0, 1.0, d, d, d])
    if np.linalg.cond(A / np.outer(scale, scale)) > 1e10:
        raise InputError(
            f"{f.card.title} meets a patch at its edge only",
            where=f.card.where,
            expected="a patch that is there around the fastener",
            fix="Move the fastener, or give a smaller diameter.",
        )
    lines = np.linalg.solve(A, S.transpose(2, 0, 1).reshape(6, 12)).reshape(6, 4, 3)
    shares: dict[int, FloatArray] = {}
    for k in range(4):
        for j, node in enumerate(corners[facet[k]].tolist()):
            if shape[k, j]:
                shares[node] = shares.get(node, 0.0) + shape[k, j] * lines[:, k]
    nodes = np.array([row, *np.repeat(list(shares), 3).tolist()], dtype=np.int64)
    for dof in range(6):
        coefficients = np.array([1.0, *(-v for share in shares.values() for v in share[dof].tolist())])
        dofs = np.array([dof + 1, *([1, 2, 3] * len(shares))], dtype=np.int64)
        used = np.abs(coefficients) > 1e-14
        yield Equation(nodes[used], dofs[used], coefficients[used], f.card.where)


def _within_limits(f: _Fastener, length: float) -> float:
    """LDMIN D to LDMAX D of a PWELD."""
    if f.card.name != "CWELD":
        return length
    low, high = (f.owner.real(8 + i, SLENDER[i]) for i in range(2))
    if not 0.0 <= low <= high:
        raise InputError(
            f"PWELD {f.owner.text(0)} has LDMIN {low:g} and LDMAX {high:g}",
            where=f.owner.place(8),
            expected="0 <= LDMIN <= LDMAX",
        )
    return min(max(length, low * f.owner.real(2)), high * f.owner.real(2))


def _connect(
    deck: Deck,
    f: _Fastener,
    rows: list[int],
    axes: FloatArray,
    materials: Materials,
    length: float,
) -> None:
    """`length` is that of a weld."""
    made_of: Material | None = None
    if f.card.name == "CFAST":
        k = np.array([f.owner.real(i, 0.0) for i in range(4, 10)])
        mass = 0.5 * f.owner.real(10, 0.0) * deck.mass_factor
        for row in rows if mass else ():
            point = PointMass(f"PFAST {f.owner.text(0)}", mass, alpha=damping(deck, f.owner)[0])
            deck.add((f.owner.text(0), mass), "mass", point, deck.free_id(), [row], f.card)
        beta = damping(deck, f.owner, f.owner.real(11, 0.0))[1]
    else:
        k = weld_stiffness(f.owner, materials, length)
        made_of, _ = materials.isotropic(f.owner.integer(1), f.owner)
        beta = made_of.beta
    beta = beta if k.any() else 0.0
    section = Bushing(f.owner.title, np.diag(k), np.zeros((6, 6)), 0.5, beta, made_of)
    own = {"axis1": axes[0], "axis2": axes[1]}
    deck.add((f.owner.name, f.owner.text(0), *k.tolist()), "bush2", section, f.identifier, rows, f.card, **own)


def weld_stiffness(owner: Card, materials: Materials, length: float) -> FloatArray:
    """(6,) of a round bar about its middle: EA/L, 12 E I/(L^3 (1 + phi)) twice, G J/L, E I/L twice."""
    material, factor = materials.isotropic(owner.integer(1), owner)
    d = owner.real(2)
    if not d > 0.0:
        raise owner.error(f"PWELD {owner.text(0)} has diameter {d:g}", expected="> 0")
    L, E, G = max(length, SHORTEST), material.youngs_modulus, material.shear_modulus * factor
    area, inertia = math.pi * d * d / 4.0, math.pi * d**4 / 64.0
    phi = 12.0 * E * inertia / (SHEAR * G * area * L * L)
    across, bend = 12.0 * E * inertia / (L**3 * (1.0 + phi)), E * inertia / L
    return np.array([E * area / L, across, across, 2.0 * G * inertia / L, bend, bend])
