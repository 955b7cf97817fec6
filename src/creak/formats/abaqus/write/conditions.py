"""Sets, surfaces, constraints, supports and initial velocities -> keyword lines."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.formats.abaqus.mesh.sets import tributary_areas
from creak.formats.abaqus.write.elements import Written
from creak.formats.abaqus.write.names import Scopes, listed, number, quoted
from creak.formats.deck.refusals import unwritable
from creak.model.constraints import DistributingCoupling, Equation, KinematicCoupling, RigidLink
from creak.model.faces import FACES, face_numbers, faces_of, facets_of_shells
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
