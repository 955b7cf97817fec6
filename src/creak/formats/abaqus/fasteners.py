"""*FASTENER: rigid fasteners, each of which joins patches of two or more surfaces at a reference node."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.lexer import Block
from creak.formats.abaqus.names import Registry, lookup, with_short_names
from creak.formats.abaqus.numbers import positive, to_float
from creak.formats.abaqus.outline import Outline, Scope
from creak.formats.abaqus.surfaces import RawSurface
from creak.model.constraints import Constraint, DistributingCoupling
from creak.model.projection import nearest_points

RIGID = ("BEAM", "WELD")
"""Connection types of a fastener that creak reads; without a *CONNECTOR SECTION it is a BEAM."""


def read_fasteners(
    deck: Outline, surfaces: dict[str, RawSurface], nodes: Registry, coords: FloatArray
) -> list[Constraint]:
    """On each surface the mean motion of the nodes round the fastening point is that of the reference node.

    The point is the nearest one of the surface; the nodes are those within RADIUS OF INFLUENCE of it, by default
    those within the radius of *FASTENER PROPERTY and of the facet that it lies on, all of equal weight. Rotations of
    the nodes are not tied. So the fastener is rigid between its layers.

    Raises
    ------
    InputError : no property, surface or reference nodes; fewer than two surfaces, or one that is too far; springs.
    """
    properties = {block.need("NAME").upper(): block for _, block in deck.blocks("FASTENER PROPERTY")}
    found: list[Constraint] = []
    for scope, block in deck.blocks("FASTENER"):
        _require_rigid(deck, block)
        owner = properties.get(block.need("PROPERTY").upper())
        if owner is None:
            raise InputError(
                f"unknown *FASTENER PROPERTY {block.get('PROPERTY')!r}",
                where=block.where,
                fix=suggest(block.get("PROPERTY"), properties),
            )
        _list_unused(deck, block, owner)
        rows = nodes.find(block.need("REFERENCE NODE SET"), scope.name, block.where)
        for surface in _surfaces(deck, scope, block, surfaces):
            found += _hung(block, rows, surface, _radius(owner), coords)
    return found


def made_sets(deck: Outline) -> set[str]:
    """Element sets of connectors that Abaqus makes for fasteners: no element of the deck is in them."""
    return {block.get("ELSET").upper() for _, block in deck.blocks("FASTENER") if block.get("ELSET")}


def _require_rigid(deck: Outline, block: Block) -> None:
    for _, section in deck.blocks("CONNECTOR SECTION"):
        if not block.get("ELSET") or section.get("ELSET").upper() != block.get("ELSET").upper():
            continue
        kinds = [f.upper() for fields, _ in list(section.rows())[:1] for f in fields]
        if kinds not in [[k] for k in RIGID]:
            raise InputError(
                f"*FASTENER with connectors of type {', '.join(kinds) or 'none'}",
                expected=f"{' or '.join(RIGID)}: rigid fasteners",
                where=section.where,
                fix="Write springs between the layers as CONN3D2 elements with *COUPLING, *DISTRIBUTING at their ends.",
            )


def _list_unused(deck: Outline, block: Block, owner: Block) -> None:
    mass = owner.get("MASS")
    if mass and to_float(mass, owner.where, "MASS of the fastener"):
        deck.note(owner, "creak's fasteners have no mass", changes=True, what="*FASTENER PROPERTY, MASS")
    if block.option("COUPLING", "CONTINUUM") != "CONTINUUM":
        why = "creak does not tie rotations of the nodes round a fastener"
        deck.note(block, why, changes=True, what="*FASTENER, COUPLING=STRUCTURAL")
    if block.option("WEIGHTING METHOD", "UNIFORM") != "UNIFORM":
        deck.note(block, "creak weights all nodes alike", changes=True, what="*FASTENER, WEIGHTING METHOD")


def _radius(owner: Block) -> float:
    rows = list(owner.rows())
    fields, where = rows[0] if rows else ([""], owner.where)
    return positive(fields[0], where, "radius of the fastener")


def _surfaces(deck: Outline, scope: Scope, block: Block, known: dict[str, RawSurface]) -> list[RawSurface]:
    """Surfaces of the data lines after the first, which holds a direction."""
    names = [(f, where) for fields, where in list(block.rows(blanks=True))[1:] for f in fields if f]
    if len(names) < 2:
        raise InputError(
            f"*FASTENER names {len(names)} surface(s)",
            expected="a line with the direction (or blank), then two surfaces or more",
            where=block.where,
            fix="Name the surfaces of both layers: creak does not look for them.",
        )
    found = []
    for name, where in names:
        surface = lookup(known, name, scope.name, deck.assembly)
        if surface is None or not surface.corners.size:
            fix = suggest(name, with_short_names(known)) if surface is None else "Name a surface of elements."
            raise InputError(f"*FASTENER on surface {name!r}, which has no facets", where=where, fix=fix)
        found.append(surface)
    return found


def _hung(
    block: Block, rows: IntArray, surface: RawSurface, radius: float, coords: FloatArray
) -> Iterable[DistributingCoupling]:
    """One coupling for each reference node."""
    X = coords[surface.corners]
    edge = float(np.linalg.norm(np.roll(X, -1, axis=1) - X, axis=2).max())
    reach = edge
    if block.has("SEARCH RADIUS"):
        reach = positive(block.get("SEARCH RADIUS"), block.where, "SEARCH RADIUS")
    influence = radius
    if block.has("RADIUS OF INFLUENCE"):
        influence = positive(block.get("RADIUS OF INFLUENCE"), block.where, "RADIUS OF INFLUENCE")
    nearest = nearest_points(coords[rows], X, surface.corners[:, 2] == surface.corners[:, 3], reach)
    name = block.get("INTERACTION NAME") or block.get("PROPERTY")
    for k, row in enumerate(rows.tolist()):
        if not nearest.found[k]:
            raise InputError(
                f"reference node at {', '.join(f'{x:g}' for x in coords[row])} of *FASTENER is farther than {reach:g} "
                f"from surface {surface.name!r}",
                where=block.where,
                expected="reference nodes between the layers",
                fix="Move the node, or give SEARCH RADIUS.",
            )
        facet = int(nearest.facet[k])
        point = nearest.shape[k] @ X[facet]
        close = np.linalg.norm(coords[surface.nodes_idx] - point, axis=1) <= influence * (1.0 + 1e-9)
        patch = np.union1d(surface.nodes_idx[close], surface.corners[facet])
        patch = patch[patch != row]
        yield DistributingCoupling(name, row, patch, np.ones(patch.size), (1, 2, 3, 4, 5, 6), block.where)
