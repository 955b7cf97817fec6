"""Model -> Abaqus deck: elements and sections (`write/`), and the lines of sets, surfaces, constraints, supports and
initial velocities."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError
from creak.formats.abaqus.mesh.sets import tributary_areas
from creak.formats.abaqus.reader import read_deck
from creak.formats.abaqus.write.directions import by_direction, without_surfaces
from creak.formats.abaqus.write.elements import Written, element_lines
from creak.formats.abaqus.write.names import ROOT, Scopes, listed, number, quoted, vector
from creak.formats.abaqus.write.sections import lost_expansion
from creak.formats.deck.catalogue import stop_on_unread
from creak.formats.deck.refusals import unwritable
from creak.formats.written_deck import write_checked
from creak.model.comparison import difference
from creak.model.constraints import DistributingCoupling, Equation, KinematicCoupling, RigidLink
from creak.model.faces import FACES, face_numbers, faces_of, facets_of_shells
from creak.model.materials import AxialSpring, Bushing, NodalMatrices, Section, Spring, rayleigh
from creak.model.mesh import ElementBlock, Model, Surface

_SIDES = {1: "SPOS", -1: "SNEG", 0: ""}
HELPER = "_COUPLING"
"""Begin of the names of node surfaces that a coupling needs and the model does not have."""


def set_lines(model: Model, scopes: Scopes, out: Written) -> None:
    """*NSET and *ELSET, labels in the order of the sets."""
    for scope, name, rows in scopes.own(model.node_sets):
        out.lines[scope] += [f"*NSET, NSET={quoted(name)}, UNSORTED", *listed(scopes.nodes(rows, scope))]
    for scope, name, pairs in scopes.own(model.element_sets):
        out.lines[scope] += [f"*ELSET, ELSET={quoted(name)}, UNSORTED", *listed(scopes.elements(pairs, scope))]


def surface_lines(model: Model, scopes: Scopes, weights: dict[str, FloatArray], out: Written) -> None:
    """*SURFACE of facets, or of nodes with the weights that couplings give them."""
    names = {id(surface): key for key, surface in model.surfaces.items()}
    for scope, name, surface in scopes.own(model.surfaces):
        if surface.is_node_based:
            factors = weights.get(names[id(surface)], np.ones(surface.nodes_idx.size))
            out.lines[scope] += _node_surface(name, scopes.nodes(surface.nodes_idx, scope), factors)
        else:
            lines = [
                _facet(model.blocks[b], scopes.element(b, r, scope), side)
                for (b, r), side in zip(surface.facets.tolist(), surface.side.tolist(), strict=True)
            ]
            out.lines[scope] += [f"*SURFACE, NAME={quoted(name)}", *dict.fromkeys(lines)]


def _node_surface(name: str, tokens: Sequence[str], factors: FloatArray) -> list[str]:
    lines = [t if f == 1.0 else f"{t}, {number(f)}" for t, f in zip(tokens, factors.tolist(), strict=True)]
    return [f"*SURFACE, NAME={quoted(name)}, TYPE=NODE", *lines]


def _facet(block: ElementBlock, element: str, side: int) -> str:
    if block.kind in FACES:
        return f"{element}, S{face_numbers(block.kind)[side - 1]}"
    return f"{element}, {_SIDES[side]}".rstrip(", ")


def constraint_lines(model: Model, scopes: Scopes, out: Written) -> tuple[list[str], dict[str, FloatArray]]:
    """*COUPLING, *MPC and *EQUATION of the root, and the weights that couplings give node surfaces.

    Raises
    ------
    InputError : a tie: a model holds its points, not its surfaces.
    """
    lines, links, equations = [], ["*MPC"], ["*EQUATION"]
    weights: dict[str, FloatArray] = {}
    for c in model.constraints:
        if isinstance(c, KinematicCoupling | DistributingCoupling):
            lines += _coupling(model, scopes, c, weights, out)
        elif isinstance(c, RigidLink):
            links.append(f"{c.kind.upper()}, {scopes.node(c.dependent_idx)}, {scopes.node(c.independent_idx)}")
        elif isinstance(c, Equation):
            equations += _equation(scopes, c)
        else:
            raise unwritable(f"tie {c.name!r} ({c.where})", "the model holds its points and weights, not its surfaces")
    return lines + [line for block in (links, equations) if len(block) > 1 for line in block], weights


def _equation(scopes: Scopes, c: Equation) -> Iterator[str]:
    yield str(c.dofs.size)
    terms = [f"{scopes.node(n)}, {d}, {number(f)}" for n, d, f in zip(c.nodes_idx, c.dofs, c.coefficients, strict=True)]
    for k in range(0, len(terms), 4):
        yield ", ".join(terms[k : k + 4])


def _coupling(
    model: Model,
    scopes: Scopes,
    c: KinematicCoupling | DistributingCoupling,
    weights: dict[str, FloatArray],
    out: Written,
) -> list[str]:
    factors = c.weights if isinstance(c, DistributingCoupling) else None
    surface = next((k for k, s in model.surfaces.items() if _carries(model, k, s, c, factors, weights)), "")
    lines = []
    if not surface:
        out.n_sets += 1
        surface = f"{HELPER}-{out.n_sets}"
        every = np.ones(c.nodes_idx.size) if factors is None else factors
        lines += _node_surface(surface, scopes.nodes(c.nodes_idx), every)
    name = f", CONSTRAINT NAME={quoted(c.name)}" if c.name else ""
    kind = "*KINEMATIC" if factors is None else "*DISTRIBUTING"
    lines += [f"*COUPLING{name}, REF NODE={scopes.node(c.ref_idx)}, SURFACE={scopes.seen(surface)}", kind]
    return lines + [f"{first}, {last}" for first, last in runs(c.dofs)]


def _carries(
    model: Model,
    name: str,
    surface: Surface,
    c: KinematicCoupling | DistributingCoupling,
    factors: FloatArray | None,
    weights: dict[str, FloatArray],
) -> bool:
    """Whether a surface has the nodes of a coupling, in order, and gives them its weights."""
    others = surface.nodes_idx != c.ref_idx
    if int(others.sum()) != c.nodes_idx.size or not np.array_equal(surface.nodes_idx[others], c.nodes_idx):
        return False
    if factors is None:
        return True
    if not surface.is_node_based:
        nodes, areas = tributary_areas(model.nodes.coords, _corners(model, surface))
        return np.array_equal(nodes, surface.nodes_idx) and np.array_equal(areas[others], factors)
    given = np.ones(surface.nodes_idx.size)
    given[others] = factors
    return np.array_equal(weights.setdefault(name, given)[others], factors)


def _corners(model: Model, surface: Surface) -> IntArray:
    """(n, 4) node rows of the facets; a triangle repeats its third node."""
    result = []
    for (b, r), side in zip(surface.facets.tolist(), surface.side.tolist(), strict=True):
        block = model.blocks[b]
        nodes = block.nodes_idx[r]
        if block.kind in FACES:
            result.append(faces_of(block.kind, nodes[None])[0, side - 1])
        else:
            result.extend(facets_of_shells(block.kind, nodes[None])[0])
    return np.array(result, dtype=np.int64)


def runs(dofs: Sequence[int]) -> list[tuple[int, int]]:
    """Dofs as ranges first, last."""
    result: list[tuple[int, int]] = []
    for d in sorted(dofs):
        if result and result[-1][1] == d - 1:
            result[-1] = (result[-1][0], d)
        else:
            result.append((d, d))
    return result


def condition_lines(model: Model, scopes: Scopes) -> list[str]:
    """*BOUNDARY and *INITIAL CONDITIONS, TYPE=VELOCITY of the root."""
    lines = []
    if model.fixed:
        lines.append("*BOUNDARY")
    for f in model.fixed:
        named = next((n for n, rows in model.node_sets.items() if np.array_equal(rows, f.nodes_idx)), "")
        for token in [scopes.seen(named)] if named else scopes.nodes(f.nodes_idx):
            lines += [f"{token}, {first}, {last}" for first, last in runs(f.dofs)]
    if model.initial_velocity:
        lines.append("*INITIAL CONDITIONS, TYPE=VELOCITY")
    return lines + [f"{scopes.node(node)}, {dof}, {number(v)}" for node, dof, v in model.initial_velocity]


def write_deck(model: Model, path: str | Path, ignore: Sequence[str] = ()) -> tuple[str, ...]:
    """Write the model data of a Model as an Abaqus deck, and read it back: the file appears only if nothing is lost.

    Flat, or one *PART and *INSTANCE for each instance, in global coordinates. Numbers have all their digits. Reading
    gives the same model back, as `model.comparison.difference` sees it, names of sections and materials aside:
    couplings that belong to no surface of the model get node surfaces `_COUPLING-n`, sections that belong to no
    element set `_SECTION-n`, a second material of one name a number. Beams whose axis 1 no third node gives have a
    section for each direction. Element types are those of the formulation (S4R becomes S4). Damping of springs that
    follows their stiffness becomes dashpots.

    Parameters
    ----------
    ignore : keywords of `Model.unread` that may be left out although they change the answer.

    Returns
    -------
    Which damping of springs became dashpots, and what is lost because it bears on contact or on thermal loads only.

    Raises
    ------
    InputError : the model holds what creak does not read from Abaqus decks (lumped mass, masses along turned axes,
        axes that vary inside a section), ties, or keywords that were not read; named, and nothing is written.
    """
    stop_on_unread(model, ignore)
    if model.mass_form != "consistent":
        raise InputError(
            f"the mass of this deck is {model.mass_form}; creak reads Abaqus decks with consistent mass",
            where=model.source,
            fix="Accept another mass with --mass consistent (the answer changes with it).",
        )
    model, damped = with_dashpots(model)
    model, notes = without_surfaces(by_direction(model))
    text = "\n".join(deck_lines(model)) + "\n"
    write_checked(path, text, lambda copy: _lost(model, copy), kind="an Abaqus", source=model.source)
    return (*damped, *notes, *lost_expansion(block.section for block in model.blocks))


def deck_lines(model: Model) -> list[str]:
    """Lines of the deck.

    Raises
    ------
    InputError : as `write_deck`.
    """
    scopes = Scopes(model)
    out = Written({scope: _nodes(model, scopes, scope) for scope in scopes.all})
    element_lines(model, scopes, out)
    set_lines(model, scopes, out)
    conditions, weights = constraint_lines(model, scopes, out)
    surface_lines(model, scopes, weights, out)
    conditions += condition_lines(model, scopes)
    lines = ["*HEADING", f"written by creak from {Path(model.source).name}"]
    for scope, name in enumerate(scopes.names):
        lines += [f"*PART, NAME={quoted(_part_name(model, name))}", *out.lines[scope], "*END PART"]
    inside = [*out.lines[ROOT], *conditions]
    if scopes.names:
        placed = [line for name in scopes.names for line in _instance(model, name)]
        inside = ["*ASSEMBLY, NAME=ASSEMBLY", *placed, *inside, "*END ASSEMBLY"]
    return [*lines, *inside, *out.materials.lines()]


def _nodes(model: Model, scopes: Scopes, scope: int) -> list[str]:
    rows = (scopes.of_node == scope).nonzero()[0].tolist()
    lines = [f"{int(model.nodes.ids[r])}, {vector(model.nodes.coords[r])}" for r in rows]
    return ["*NODE", *lines] if lines else []


def _instance(model: Model, name: str) -> list[str]:
    return [f"*INSTANCE, NAME={quoted(name)}, PART={quoted(_part_name(model, name))}", "*END INSTANCE"]


def _part_name(model: Model, instance: str) -> str:
    """The *PART of an instance: its alias where it has one."""
    return next((p.aliases[0] for p in model.parts if p.name == instance and p.aliases), instance)


def _same_part_names(copy: Model, model: Model) -> Model:
    """Parts of a flat deck are named after sets that happen to hold them: the names of the model instead."""
    if model.nodes.instance or len(copy.parts) != len(model.parts):
        return copy
    pairs = zip(copy.parts, model.parts, strict=True)
    return replace(copy, parts=tuple(replace(p, name=q.name, aliases=q.aliases) for p, q in pairs))


def _lost(model: Model, path: Path) -> str:
    """What the written deck lacks of the model."""
    return difference(model, _same_part_names(read_deck(path), model), names=False)


def with_dashpots(model: Model) -> tuple[Model, list[str]]:
    """The model with beta K of springs, bushings and matrices as dashpots, and which became one.

    Connectors hold both; a spring gets a dashpot beside it, an element of its own above all others.

    Raises
    ------
    InputError : a mass matrix that is damped in proportion to itself.
    """
    label = max((int(b.ids.max()) for b in model.blocks if b.ids.size), default=0)
    kept: list[ElementBlock] = []
    beside: list[ElementBlock] = []
    made: dict[int, tuple[Section, Section | None]] = {}
    notes: list[str] = []
    for block in model.blocks:
        section = block.section
        if id(section) not in made:
            made[id(section)] = _split(section)
            if made[id(section)][0] is not section:
                notes.append(f"{section.name}: its damping, proportional to its stiffness, is a dashpot in the deck")
        spring, dashpot = made[id(section)]
        kept.append(replace(block, section=spring))
        if dashpot is not None:
            ids = np.arange(label + 1, label + 1 + block.ids.size)
            label += block.ids.size
            beside.append(replace(block, section=dashpot, ids=ids))
    return replace(model, blocks=(*kept, *beside)), notes


def _split(section: Section) -> tuple[Section, Section | None]:
    """The section without beta, and the dashpot that stands beside it."""
    if not isinstance(section, Spring | AxialSpring | Bushing | NodalMatrices) or not any(rayleigh(section)):
        return section, None
    name = f"{section.name} DASHPOT"
    if isinstance(section, Spring | AxialSpring):
        dashpot = section.damping + section.beta * section.stiffness
        spring = replace(section, damping=0.0, beta=0.0)
        return spring, replace(spring, name=name, stiffness=0.0, damping=dashpot)
    damping = section.damping + section.beta * section.stiffness
    if isinstance(section, NodalMatrices):
        none = np.zeros_like(section.stiffness)
        if section.alpha:
            why = f"they damp by {section.alpha:g} 1/s times their mass, which *MASS, TYPE=ANISOTROPIC does not"
            raise unwritable(f"the matrices {section.name!r}", why)
        if section.mass.any():
            return replace(section, damping=damping, beta=0.0), None
        return replace(section, damping=none, beta=0.0), NodalMatrices(name, none, none, damping)
    return replace(section, damping=damping, beta=0.0), None
