"""One part of the model as an unsupported System: elements assembled, its own couplings eliminated."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import MISSING, dataclass, fields
from typing import Any

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.assembly.congruent import SideBySide, congruent
from creak.assembly.damping import Damping
from creak.assembly.drilling import HeldDrilling, held_drilling, still_edges, turned, with_edges
from creak.assembly.elimination import eliminate, linear_equations, principal, transformation
from creak.assembly.node_blocks import NodeBlocks
from creak.assembly.partition import shared_nodes
from creak.assembly.system import Rows, Stats, System, fitted_velocity, no_supports
from creak.elements.geometry import DegenerateElement
from creak.errors import InputError
from creak.later import later
from creak.linalg.threads import in_order
from creak.model.constraints import Constraint, Equation
from creak.model.dofs import PER_NODE, dof_label, node_dofs, nodes_of
from creak.model.materials import (
    Discrete,
    Structural,
    has_dashpot,
    has_mass,
    has_stiffness,
    rayleigh,
)
from creak.model.mesh import ElementBlock, Model, elements_named, rigid_vectors

CHUNK = 300_000
"""Entries of element matrices made at a time; 8 bytes each, three times at most: they are summed in the caches.
Each core makes a piece, and as many wait to be summed."""


@dataclass(frozen=True)
class Rayleigh:
    """C = alpha M + beta K."""

    alpha: float
    beta: float


@dataclass(frozen=True)
class PartMatrices:
    """Element matrices of some blocks, summed over dof labels."""

    labels: IntArray
    """(n,) sorted physical dof labels."""
    K: Matrix
    M: Matrix
    C: Matrix | None
    """Damping beyond the common Rayleigh numbers, None if there is none."""


def common_rayleigh(model: Model) -> Rayleigh:
    """The Rayleigh numbers of the structural material with most elements; without any, of most masses and springs.

    Blocks that differ (other materials, springs, point masses) get the difference in an explicit matrix, so
    the sum is each material's own damping.
    """
    structural, masses, springs = Counter[tuple[float, float]](), Counter[float](), Counter[float]()
    for section, n in ((b.section, b.ids.size) for b in model.blocks):
        alpha, beta = rayleigh(section)
        if isinstance(section, Structural):
            structural[alpha, beta] += n
        if has_mass(section):
            masses[alpha] += n
        if isinstance(section, Discrete) and has_stiffness(section):
            springs[beta] += n
    if structural:
        return Rayleigh(*structural.most_common(1)[0][0])
    alpha, beta = (of.most_common(1)[0][0] if of else 0.0 for of in (masses, springs))
    return Rayleigh(alpha, beta)


def assemble_blocks(
    model: Model,
    blocks: Iterable[ElementBlock],
    labels: IntArray,
    common: Rayleigh,
    override: bool,
    u: FloatArray | None = None,
    drilling: HeldDrilling | None = None,
) -> PartMatrices:
    """Sum the element matrices of `blocks` over `labels`.

    Parameters
    ----------
    labels : sorted, all six of every node in question.
    common : Rayleigh numbers that the System carries as scalars.
    override : True when they replace the deck's own damping (dashpots stay).
    u : (n_node, 6) static displacements whose stress stiffens the elements (`elements.geometric`).
    drilling : where the matrices are those of the rotations that shells have of their own.
    """
    nodes, given = nodes_of(labels[::PER_NODE]), list(blocks)
    given = with_edges(model, given, nodes)
    pattern = NodeBlocks([np.searchsorted(nodes, block.nodes_idx) for block in given], nodes.size)
    K, M, C = pattern.zeros(), pattern.zeros(), None
    for block, rows, (Ke, Me, Ce) in _element_matrices(model, given, u, drilling):
        at = np.searchsorted(nodes, block.nodes_idx[rows])
        pattern.add(K, at, Ke)
        pattern.add(M, at, Me)
        da, db, dashpot = _excess_damping(block, common, override)
        if da or db or dashpot:
            C = pattern.zeros() if C is None else C
            for factor, Ae in ((da, Me), (db, Ke), (1.0, Ce)):
                if factor and Ae is not None:
                    pattern.add(C, at, Ae, factor)
    stiffness = pattern.matrix(K)
    del K
    return PartMatrices(labels, stiffness, pattern.matrix(M), None if C is None else pattern.matrix(C))


def _excess_damping(block: ElementBlock, common: Rayleigh, override: bool) -> tuple[float, float, bool]:
    section = block.section
    dashpot = isinstance(section, Discrete) and has_dashpot(section)
    if override:
        return 0.0, 0.0, dashpot
    alpha, beta = rayleigh(section)
    alpha, beta = alpha - common.alpha, beta - common.beta
    return alpha if has_mass(section) else 0.0, beta if has_stiffness(section) else 0.0, dashpot


def damps_by_itself(model: Model, common: Rayleigh, override: bool) -> bool:
    """Whether anything of the model damps other than by the common Rayleigh numbers."""
    return _any_excess(model.blocks, common, override)


def _any_excess(blocks: Iterable[ElementBlock], common: Rayleigh, override: bool) -> bool:
    return any(any(_excess_damping(block, common, override)) for block in blocks)


ElementMatrices = tuple[FloatArray, FloatArray, FloatArray | None]
"""K, M, C (n, 6 k, 6 k)"""


def _element_matrices(
    model: Model, blocks: Sequence[ElementBlock], u: FloatArray | None, drilling: HeldDrilling | None
) -> Iterator[tuple[ElementBlock, slice, ElementMatrices]]:
    """Blocks, some of their rows and the matrices of these, in order; cores make the next ones meanwhile.

    Raises
    ------
    InputError : elements whose geometry admits no stiffness, all of a block with the same fault named at once.
    """
    pieces = [(block, rows) for block in blocks for rows in _pieces(block)]
    bad: list[tuple[ElementBlock, int, str]] = []
    for (block, rows), made in zip(
        pieces, in_order(lambda piece: _made(model, *piece, u, drilling), pieces), strict=True
    ):
        if bad and bad[0][0] is not block:
            break
        if isinstance(made, DegenerateElement):
            bad += [(block, rows.start + row, made.reason) for row in made.rows.tolist()]
        else:
            yield block, rows, made
    if bad:
        block, _, reason = bad[0]
        raise _degenerate(block, block.ids[[row for _, row, why in bad if why == reason]], reason)


def _pieces(block: ElementBlock) -> list[slice]:
    size = max(1, CHUNK // (6 * block.nodes_idx.shape[1]) ** 2)
    return [slice(start, start + size) for start in range(0, block.ids.size, size)]


def _made(
    model: Model, block: ElementBlock, rows: slice, u: FloatArray | None, drilling: HeldDrilling | None
) -> ElementMatrices | DegenerateElement:
    from creak.elements.block_matrices import block_matrices  # a run whose parts are made later does without elements
    from creak.elements.registry import FORMULATIONS

    turns = None if drilling is None else drilling.turns(block, rows)
    try:
        Ke, Me, Ce = block_matrices(block, rows, model.nodes.coords, form=model.mass_form)
        stressed = FORMULATIONS[block.kind].geometric
        if u is not None and stressed is not None:
            at = block.nodes_idx[rows]
            moved = u[at]
            if turns is not None:
                moved = np.concatenate([moved[..., :3], np.einsum("naij,naj->nai", turns, moved[..., 3:])], axis=2)
            Ke = Ke + stressed(model.nodes.coords[at], block.section, block.own.take(rows), moved)
    except DegenerateElement as error:
        return error
    if turns is None:
        return Ke, Me, Ce
    return turned(Ke, turns), turned(Me, turns), None if Ce is None else turned(Ce, turns)


def _degenerate(block: ElementBlock, bad: IntArray, reason: str) -> InputError:
    return InputError(
        f"{elements_named(bad)}: {reason}",
        where=block.where,
        fix="Repair these elements: check node order and coincident nodes.",
    )


def split_constraints(model: Model) -> tuple[list[list[Constraint]], list[Constraint]]:
    """Constraints inside each part, and those that tie parts (or loose or shared nodes) together or hold one."""
    owner = np.full(model.nodes.count, -1, dtype=np.int64)
    for i, part in enumerate(model.parts):
        owner[part.nodes_idx] = i
    owner[shared_nodes(model)] = -1
    inside: list[list[Constraint]] = [[] for _ in model.parts]
    across: list[Constraint] = []
    for constraint in model.constraints:
        owners = set(owner[constraint.nodes].tolist())
        if len(owners) == 1 and -1 not in owners and not _supports(constraint):
            inside[owners.pop()].append(constraint)
        else:
            across.append(constraint)
    return inside, across


def _supports(constraint: Constraint) -> bool:
    """Whether an equation names one node only: a support along no global axis, which acts like `Model.fixed`."""
    return isinstance(constraint, Equation) and np.unique(constraint.nodes).size == 1


def part_system(
    model: Model, part: int, common: Rayleigh, *, override: bool = False, u: FloatArray | None = None
) -> System:
    """M, C, K of one part in its independent dofs, free in space.

    Couplings within the part are eliminated (u = T q); supports and links to other parts are not: these act
    later, on the full and on the reduced part alike. `u` (n_node, 6): static displacements whose stress stiffens it,
    at held drilling rotations those of the shells.
    """
    drilling = held_drilling(model, model.parts[part].nodes_idx)
    labels, T, independent, across = _independent(model, part, drilling)
    matrices = assemble_blocks(model, _blocks(model, part), labels, common, override, u, drilling)
    own = np.searchsorted(labels, independent)
    K, M = (congruent(T, SideBySide([A]), own) for A in (matrices.K, matrices.M))
    C = None if matrices.C is None else congruent(T, SideBySide([matrices.C]), own)
    needed = np.isin(independent, _outside_labels(model, across))
    moves = np.any([A.diagonal() != 0.0 for A in (K, M, C) if A is not None], axis=0)
    keep = np.flatnonzero(moves | needed)
    K, M, T = principal(K, keep), principal(M, keep), T[:, keep]
    C = None if C is None else principal(C, keep)
    along = rigid_vectors(labels, model.nodes, np.zeros(3))[:, 0]
    mass = float(along @ (matrices.M @ along))
    known = _known(model, part, labels, T, independent[keep], mass, drilling)
    known["velocity"] = fitted_velocity(
        T, SideBySide([matrices.M]).times, M, own[keep], _initial_velocity(model, labels)
    )
    return System(M=M, K=K, damping=Damping(common.alpha, common.beta, C), **known)


def outlined_part(
    model: Model, part: int, common: Rayleigh, coordinates: IntArray, mass: float, *, override: bool = False
) -> System:
    """The System that `part_system` makes, its matrices only when they are asked for.

    Parameters
    ----------
    coordinates, mass : those of that System.
    """
    drilling = held_drilling(model, model.parts[part].nodes_idx)
    labels, T, independent, _ = _independent(model, part, drilling)
    T = T[:, np.searchsorted(independent, coordinates)]
    known = {**_OTHERS, **_known(model, part, labels, T, coordinates, mass, drilling)}
    if not np.isin(started_labels(model), labels).any():
        known["velocity"] = np.zeros(coordinates.size)
    if not _any_excess(_blocks(model, part), common, override):
        known["damping"] = Damping(common.alpha, common.beta)
    return later(System, lambda: part_system(model, part, common, override=override), **known)


_OTHERS: dict[str, Any] = {f.name: f.default for f in fields(System) if f.default is not MISSING}
"""What a part has none of."""


def _known(
    model: Model,
    part: int,
    labels: IntArray,
    T: Matrix,
    coordinates: IntArray,
    mass: float,
    drilling: HeldDrilling | None,
) -> dict[str, Any]:
    """All of a part but its matrices; T (n_label, n)."""
    real = T if drilling is None else drilling.real_rows(labels) @ T
    return {
        "name": model.parts[part].name,
        "rows": _rows_of(labels, real, T, model.nodes.count),
        "supports": no_supports(coordinates.size),
        "coordinates": coordinates,
        "stats": Stats(mass, sum(b.ids.size for b in _blocks(model, part))),
        "labels": labels,
        "of_shells": True,
    }


def _blocks(model: Model, part: int) -> list[ElementBlock]:
    return [b for b in model.blocks if b.part == part]


def _independent(
    model: Model, part: int, drilling: HeldDrilling | None
) -> tuple[IntArray, Matrix, IntArray, list[Constraint]]:
    """Labels of a part, T of u = T q for the couplings within it, the labels of q; the other constraints."""
    inside, across = split_constraints(model)
    labels = np.sort(node_dofs(model.parts[part].nodes_idx))
    equations = [e for c in inside[part] for e in linear_equations(c, model.nodes.coords)]
    if drilling is not None:
        equations = drilling.on_shells(equations, labels)
    equations += still_edges(model, model.parts[part].nodes_idx)
    return labels, *transformation(labels, eliminate(equations)), across


def loose_system(model: Model, common: Rayleigh) -> System | None:
    """Nodes that belong to no part: reference nodes shared by parts, ends of connectors, points of a wall.

    They have neither mass nor stiffness of their own; those that nothing uses drop out when parts are joined.
    """
    owned = np.zeros(model.nodes.count, dtype=bool)
    for part in model.parts:
        owned[part.nodes_idx] = True
    if owned.all():
        return None
    return bare_system(model, node_dofs(np.flatnonzero(~owned)), common, "(loose nodes)")


def bare_system(model: Model, labels: IntArray, common: Rayleigh, name: str) -> System:
    """Sorted dof labels (n,) as coordinates of their own, without mass and stiffness."""
    n = labels.size
    zero, one = sp.csr_matrix((n, n)), sp.identity(n, format="csr")
    rows = _rows_of(labels, one, one, model.nodes.count)
    damping = Damping(common.alpha, common.beta)
    velocity = np.nan_to_num(_initial_velocity(model, labels))
    return System(
        name,
        zero,
        zero,
        damping,
        rows,
        no_supports(n),
        labels,
        velocity,
        labels=labels,
        of_shells=True,
    )


def started_labels(model: Model) -> IntArray:
    """Dof labels with an initial velocity, as they come."""
    return np.array([dof_label(node, dof) for node, dof, _ in model.initial_velocity], dtype=np.int64)


def _initial_velocity(model: Model, labels: IntArray) -> FloatArray:
    """Initial velocities at labels, not a number where none is given."""
    velocity = np.full(PER_NODE * model.nodes.count, np.nan)
    velocity[started_labels(model)] = [value for _, _, value in model.initial_velocity]
    return velocity[labels]


def _outside_labels(model: Model, across: Sequence[Constraint]) -> IntArray:
    """Dofs that links to other parts and supports refer to; they stay even without stiffness or mass."""
    linked = {label for c in across for e in linear_equations(c, model.nodes.coords) for label in e.labels}
    held = [node_dofs(fixed.nodes_idx, fixed.dofs) for fixed in model.fixed]
    return np.concatenate([np.array(sorted(linked), dtype=np.int64), *held])


def _rows_of(labels: IntArray, real: Matrix, T: Matrix, n_node: int) -> Rows:
    """`System.rows`: `real` (n_label, n) of labels, T of ~label."""
    place = np.full(PER_NODE * n_node, -1, dtype=np.int64)
    place[labels] = np.arange(labels.size)
    real, T = sp.csr_matrix(real), sp.csr_matrix(T)

    def pick(wanted: IntArray, of: Matrix) -> Matrix:
        at = np.where(wanted >= 0, place[wanted], -1)
        own = np.flatnonzero(at >= 0)
        return sp.csr_matrix((np.ones(own.size), (own, at[own])), shape=(wanted.size, labels.size)) @ of

    def rows(wanted: IntArray) -> tuple[Matrix, Matrix]:
        picked = pick(wanted, real)
        return picked + pick(~wanted, T) if (wanted < 0).any() else picked, np.zeros((wanted.size, 0))

    return rows
