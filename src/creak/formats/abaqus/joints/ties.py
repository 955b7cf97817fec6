"""*TIE and tied contact pairs: nodes of one surface joined to the nearest points of another."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.loads.prestress import step_of_modes
from creak.formats.abaqus.mesh.elements import TYPES, Elements
from creak.formats.abaqus.mesh.sets import RawSurface
from creak.formats.abaqus.sections.assigned import Assigned
from creak.formats.abaqus.text.fields import Registry, lookup, to_float, with_short_names
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, Scope
from creak.formats.deck.tying import (
    DEFAULT_TOLERANCE,
    MainSurface,
    Meeting,
    main_surface,
    meet,
    sheet_of,
    skins_of,
    ties_of,
)
from creak.model.constraints import Constraint
from creak.model.faces import FACES, shapes_of
from creak.model.mesh import Nodes

ROUNDING = 1e-3
"""Share of the mean edge length within which nodes of a tied contact pair touch, whatever ADJUST says."""
NAME = "CONTACT PAIR, TIED"


@dataclass(frozen=True)
class _Source:
    """What a tie refers to."""

    deck: Outline
    nodes: Nodes
    elements: Elements
    assigned: Assigned
    surfaces: Mapping[str, RawSurface]
    names: Registry


@dataclass(frozen=True)
class _Search:
    """Candidate nodes of a secondary surface and where they meet the main one."""

    met: Meeting
    shared: int
    """Number of nodes that belong to both surfaces."""


def read_ties(
    deck: Outline,
    nodes: Nodes,
    elements: Elements,
    assigned: Assigned,
    surfaces: Mapping[str, RawSurface],
    names: Registry,
) -> list[Constraint]:
    """Every *TIE and tied *CONTACT PAIR as one `Tie` for each node of its secondary surface, or equations.

    A node is tied when its distance from the main surface is within POSITION TOLERANCE, by default 5 % of the
    mean edge length of the main surface. Across a facet the distance is measured between the faces of the shells
    (half of both thicknesses is taken off) unless NO THICKNESS is given; with TIED NSET= the nodes of that set,
    and no others, are tied at any distance. Nodes are not moved: a rigid arm bridges what is left of the offset,
    so that rigid motion strains no tie; on faces of solids, whose nodes have no rotations, it turns with the facet.
    Nodes that the surfaces share are joined already and are passed over; they and the nodes out of reach are listed in
    `Model.unread`.

    Node collocation is exact for rigid motion, and for constant strain where every node of the main surface lies
    on a node of the secondary one (make the finer side secondary); else it errs by the order of its mesh.

    Raises
    ------
    InputError : unknown surface, a main surface of nodes, a bad tolerance, or no node within it.
    """
    source = _Source(deck, nodes, elements, assigned, surfaces, names)
    ties: list[Constraint] = []
    tied = [(deck.scopes[-1], block) for block in tied_pairs(deck)]
    for scope, block in [*deck.blocks("TIE"), *tied]:
        if block.has("CYCLIC SYMMETRY"):
            continue  # of a sector with itself, turned; listed with the parameters that are not read
        rows = list(block.rows())
        if not rows:
            raise block.error(
                f"*{block.name} without surfaces",
                expected="secondary surface, main surface",
                fix="Name the two surfaces on a data line.",
            )
        if block.name == "TIE" and block.option("TYPE") != "NODE TO SURFACE":
            why = "creak ties each secondary node to the nearest point of the main surface (NODE TO SURFACE)"
            what = f"*TIE, TYPE={block.option('TYPE')}" if block.has("TYPE") else "*TIE without TYPE"
            deck.note(block, why, changes=False, what=what)
        for fields, where in rows:
            ties += _tie_pair(source, scope, block, fields, where)
    return ties


def _tie_pair(source: _Source, scope: Scope, block: Block, fields: list[str], where: str) -> list[Constraint]:
    secondary, other = (_surface(source, name, scope, block, where) for name in (*fields, "", "")[:2])
    main = _main_surface(other, source, block, where)
    if block.has("NO THICKNESS"):
        main = replace(main, sheets=0.0 * main.sheets)
    rows, tolerance = secondary.nodes_idx, _tolerance(block, main)
    if block.has("TIED NSET"):
        rows = rows[np.isin(rows, source.names.find(block.need("TIED NSET"), scope.name, where))]
        tolerance = np.inf
    shared = np.isin(rows, main.nodes_idx)
    rows = rows[~shared]
    sheets = _sheets(secondary.element_rows, source.assigned) * (not block.has("NO THICKNESS"))
    skins = skins_of(secondary.corners, sheets, source.nodes.coords).at(rows)
    found = _Search(meet(source.nodes.coords[rows], rows, skins, main, tolerance), int(shared.sum()))
    if not found.met.tied.any():
        raise _nothing_tied(block, secondary, other, found, where)
    _note_untied(source, block, secondary, other, found)
    return ties_of(block.get("NAME"), where, main, found.met, rotations=not block.has("NO ROTATION"))


def _surface(source: _Source, name: str, scope: Scope, block: Block, where: str) -> RawSurface:
    surface = lookup(source.surfaces, name, scope.name, source.deck.assembly) if name else None
    if surface is None:
        raise InputError(
            f"*{block.name} " + (f"on unknown surface {name!r}" if name else "names one surface only"),
            expected="secondary surface, main surface",
            where=where,
            fix=suggest(name, with_short_names(source.surfaces, source.deck.instances)),
        )
    return surface


def _note_untied(source: _Source, block: Block, secondary: RawSurface, main: RawSurface, found: _Search) -> None:
    """List the nodes that are not tied, and the offset that Abaqus would have closed by moving nodes."""
    met = found.met
    title, pair = f"*{block.name}, NAME={block.get('NAME')}", f"{secondary.name!r} and {main.name!r}"
    if found.shared:
        why = f"{found.shared} node(s) of {pair} belong to both surfaces and are joined already"
        source.deck.note(block, why, changes=False, what=title, used=True)
    if not met.tied.all():
        out = np.sort(met.rows[~met.tied])
        why = f"{out.size} of {met.rows.size} nodes of {secondary.name!r} lie farther than {met.tolerance:.4g} "
        why += f"from {main.name!r} and stay untied: node {source.nodes.first_few(out)}"
        source.deck.note(block, why, changes=False, what=title, used=True)
    offset = float(np.linalg.norm(met.arm[met.tied], axis=1).max())
    if offset > 0.0 and block.option("ADJUST", "YES") != "NO":
        why = f"creak does not move tied nodes; rigid arms up to {offset:.3g} long bridge the offset of {pair}"
        source.deck.note(block, why, changes=False, what=f"{title}, ADJUST=YES", used=True)


def _main_surface(surface: RawSurface, source: _Source, block: Block, where: str) -> MainSurface:
    coords = source.nodes.coords
    if surface.edges.size:
        corners = surface.edges[:, [0, 1, 1, 1]]
        n = corners.shape[0]
        return main_surface(shapes_of(corners, []), corners, np.zeros((n, 2)), np.zeros(n, dtype=bool), coords)
    if not surface.element_rows.size:
        raise InputError(
            f"main surface {surface.name!r} of *{block.name} is a surface of nodes",
            expected="a surface of shell facets, faces of solids or shell edges",
            where=where,
            fix="Give one; the surface of nodes may be the secondary one, which stands first.",
        )
    corners = surface.corners
    rows, solids = surface.element_rows, [t.kind in FACES for t in TYPES]
    solid = np.array(solids)[source.elements.type_idx[rows]]
    shapes = shapes_of(corners, source.elements.with_facets)
    return main_surface(shapes, corners, _sheets(rows, source.assigned), solid, coords)


def _sheets(element_rows: IntArray, assigned: Assigned) -> FloatArray:
    of = np.array([sheet_of(s) for s in assigned.sections], dtype=np.float64).reshape(-1, 2)
    return np.asarray(of[assigned.section_idx[element_rows]])


def _tolerance(block: Block, main: MainSurface) -> float:
    if not block.has("POSITION TOLERANCE"):
        return DEFAULT_TOLERANCE * main.size
    value = to_float(block.get("POSITION TOLERANCE"), block.where, "position tolerance")
    if value < 0.0:
        raise block.error(
            f"position tolerance is {value:g}",
            expected="a number, zero or more",
            fix="Give the largest distance at which a node is tied.",
        )
    return value if block.name == "TIE" else max(value, ROUNDING * main.size)


def _nothing_tied(block: Block, secondary: RawSurface, main: RawSurface, found: _Search, where: str) -> InputError:
    shared = f"{found.shared} node(s) belong to both surfaces, " if found.shared else ""
    far = f"{found.met.rows.size} lie farther than {found.met.tolerance:.4g} from {main.name!r}"
    if found.met.tolerance == np.inf and not found.shared:
        far = "TIED NSET= holds none of them"
    return InputError(
        f"*{block.name} joins no node of {secondary.name!r}: {shared}{far}",
        expected="surfaces that meet without sharing nodes",
        where=where,
        fix="Raise POSITION TOLERANCE=, correct the surfaces (secondary first, then main), or remove the tie.",
    )


def tied_pairs(deck: Outline) -> Iterator[Block]:
    """Each tied pair of the model data and of the steps up to the modes, written as a *TIE; it is no contact any more.

    ADJUST, a distance or a node set, says which nodes are tied (POSITION TOLERANCE, TIED NSET). Rotations stay free, as
    in Abaqus.
    """
    places = [deck.set_aside, *(step.blocks for step in deck.steps[: step_of_modes(deck) + 1])]
    bonded = _bonded([block for blocks in places for block in blocks])
    for blocks in places:
        tied = [
            b for b in blocks if b.name == "CONTACT PAIR" and (b.has("TIED") or b.get("INTERACTION").upper() in bonded)
        ]
        ours = {b.where for b in tied}
        blocks[:] = [b for b in blocks if b.where not in ours or b.name != "CONTACT PAIR"]
        deck.unread = {u: None for u in deck.unread if u.where not in ours}
        yield from (_as_tie(deck, block) for block in tied)


def _bonded(blocks: list[Block]) -> set[str]:
    """Names of the interactions that tie."""
    found, name = set(), ""
    for block in blocks:
        if block.name == "SURFACE INTERACTION":
            name = block.get("NAME").upper()
        elif block.name == "SURFACE BEHAVIOR" and block.option("PRESSURE-OVERCLOSURE") == "TIED":
            found.add(name)
    return found


def _as_tie(deck: Outline, block: Block) -> Block:
    params = {"NAME": block.get("CPSET") or block.get("INTERACTION") or "TIED", "NOROTATION": "", "ADJUST": "NO"}
    given = block.get("ADJUST")
    if given:
        try:
            params["POSITIONTOLERANCE"] = repr(to_float(given, block.where, "ADJUST"))
        except InputError:
            params["TIEDNSET"] = given
    deck.note(
        block,
        "the pair is read as a tie: its nodes follow the main surface, and nothing opens or slides",
        changes=False,
        what=f"*{NAME}",
    )
    return replace(block, name=NAME, params=params, options=[])
