"""What looks along axes of its own: a section for each direction of beams, springs and dashpots along turned axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.model.materials import BeamSection, NodalMatrices, Spring
from creak.model.mesh import ElementBlock, Model, some_of

SAME = 1e-12
"""Between unit vectors that are one direction but for round-off."""
ROUND_OFF = 1e-12


def third_nodes(coords: FloatArray, block: ElementBlock) -> list[int]:
    """Nodes that give beams an axis 1 of their own, -1 where the section gives it, -2 where neither does; empty where
    the section always does.

    Parameters
    ----------
    coords : (n_node, 3) of the model.
    """
    axes = block.own.axis1
    if axes is None or not isinstance(block.section, BeamSection):
        return []
    result = []
    for origin, axis in zip(coords[block.nodes_idx[:, 0]], axes, strict=True):
        found = np.flatnonzero((coords - origin == axis).all(axis=1))
        by_section = -1 if np.array_equal(axis, block.section.axis1) else -2
        result.append(int(found[0]) if found.size else by_section)
    return result


def without_surfaces(model: Model) -> tuple[Model, list[str]]:
    """The model with beams that are written by their moments as thin as a line, and which lose their surface so."""
    plain: dict[int, BeamSection] = {}
    notes: list[str] = []
    for section in (b.section for b in model.blocks):
        if isinstance(section, BeamSection) and section.radius and section.profile in ("", "GENERAL"):
            plain[id(section)] = plain.get(id(section), replace(section, radius=0.0))
            notes.append(
                f"beam section {section.name}: its surface, {section.radius:g} from the axis, is not in the deck"
            )
    blocks = tuple(replace(b, section=plain.get(id(b.section), b.section)) for b in model.blocks)
    return replace(model, blocks=blocks) if plain else model, list(dict.fromkeys(notes))


def by_direction(model: Model) -> Model:
    """The model with beams whose axes no third node gives in blocks of one direction each, which is their section's."""
    blocks: list[ElementBlock] = []
    places: list[IntArray] = []
    for block in model.blocks:
        groups, section = _groups(model.nodes.coords, block), block.section
        place = np.zeros((block.ids.size, 2), dtype=np.int64)
        for rows, direction in groups:
            place[rows, 0], place[rows, 1] = len(blocks), np.arange(rows.size)
            assert isinstance(section, BeamSection)
            own = replace(block.own.take(rows), axis1=None)
            blocks.append(replace(some_of(block, rows), section=replace(section, axis1=direction), own=own))
        if not groups:
            place[:, 0], place[:, 1] = len(blocks), np.arange(block.ids.size)
            blocks.append(block)
        places.append(place)
    if len(blocks) == len(model.blocks) and all(a is b for a, b in zip(blocks, model.blocks, strict=True)):
        return model
    return replace(
        model,
        blocks=tuple(blocks),
        element_sets={name: _moved(rows, places) for name, rows in model.element_sets.items()},
        surfaces={name: replace(s, facets=_moved(s.facets, places)) for name, s in model.surfaces.items()},
    )


def _moved(rows: IntArray, places: Sequence[IntArray]) -> IntArray:
    """(n, 2) rows of blocks and of elements in them, where these are now."""
    return np.array([places[b][r] for b, r in rows.tolist()], dtype=np.int64).reshape(-1, 2)


def _groups(coords: FloatArray, block: ElementBlock) -> list[tuple[IntArray, tuple[float, float, float]]]:
    """Rows of a block and their direction; none where section and third nodes say all."""
    if -2 not in third_nodes(coords, block):
        return []
    axes = block.own.axis1
    assert axes is not None
    if block.kind == "beam2" and np.ptp(axes, axis=0).any():
        along = np.diff(coords[block.nodes_idx], axis=1)[:, 0]
        along /= np.linalg.norm(along, axis=1)[:, None]
        axes = axes - np.einsum("ni,ni->n", axes, along)[:, None] * along
    axes = axes / np.linalg.norm(axes, axis=1)[:, None]
    groups = []
    left = np.arange(block.ids.size)
    while left.size:
        one = np.abs(axes[left] - axes[left[0]]).max(axis=1) <= SAME
        x, y, z = axes[left[0]].tolist()
        groups.append((left[one], (x, y, z)))
        left = left[~one]
    return groups


@dataclass(frozen=True)
class TurnedSpring:
    """A spring in the axes of an *ORIENTATION."""

    spring: Spring
    axes: FloatArray
    """(2, 3) axis 1, and another one across it."""


def turned_spring(section: NodalMatrices) -> TurnedSpring | None:
    """The spring or dashpot whose matrix k g g' it is, g a direction at one node and, less, one at the other."""
    given = [A for A in (section.stiffness, section.damping) if A.any()]
    if len(given) != 1 or section.mass.any() or section.stiffness.shape[0] > 12:
        return None
    (A,) = given
    k, j = float(np.trace(A[:6, :6])), int(np.abs(np.diag(A)[:6]).argmax())
    if not k * A[j, j] > 0.0:
        return None
    g = A[:, j] / np.sqrt(k * A[j, j])
    ends = [g[:6].reshape(2, 3), *([-g[6:].reshape(2, 3)] if g.size == 12 else [])]
    triples = [np.flatnonzero(end.any(axis=1)) for end in ends]
    if np.abs(k * np.outer(g, g) - A).max() > ROUND_OFF * abs(k) or any(t.size != 1 for t in triples):
        return None
    n = [end[int(t[0])] for end, t in zip(ends, triples, strict=True)]
    along = float(n[0] @ n[-1])
    if any(abs(np.linalg.norm(x) - 1.0) > ROUND_OFF for x in n) or min(abs(along - 1.0), abs(along)) > ROUND_OFF:
        return None
    same = abs(along - 1.0) <= ROUND_OFF
    dofs = [1 + 3 * int(t[0]) + (i and not same) for i, t in enumerate(triples)]
    across = np.cross(n[0], np.eye(3)[int(np.abs(n[0]).argmin())]) if same else n[-1]
    stiffness, damping = (k, 0.0) if section.stiffness.any() else (0.0, k)
    spring = Spring(section.name, dofs[0], dofs[1] if len(dofs) == 2 else 0, stiffness, damping)
    return TurnedSpring(spring, np.array([n[0], across]))
