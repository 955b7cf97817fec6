"""Single changes to a model that quieten a place: found on the reduced model, nothing is reduced again.

A gap, a contact spring and damping are changed as they are; a mass or a fastener is a low-rank change of M or K of the
reduced model, which is then diagonalised again. Each is also known as a change of the whole model, so that a full run
can check it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from creak.arrays import FloatArray, IntArray, to_dense
from creak.assembly.part import Rayleigh
from creak.assembly.rigid import unheld_parts
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.elements.block_matrices import block_matrices
from creak.model.dofs import PER_NODE, node_dofs, nodes_of
from creak.model.materials import NodalMatrices
from creak.model.mesh import ElementBlock, Model, some_of
from creak.model.units import UNITS, UnitsName
from creak.reduction.diagonal import diagonalise
from creak.reduction.modal import ModalShares, support_motion, without_modal_damping
from creak.studies.cause.decompose import Cause
from creak.studies.findings.places import Place
from creak.studies.models.reduced import ReducedModel, coupled_again, with_damping
from creak.studies.models.reference import ReferenceModel, held_factor
from creak.studies.prepare.reduction import Reduction
from creak.studies.prepare.setup import Setup
from creak.studies.prepare.structure import Structure

GAP = 0.1
"""Share of the clearance by which a gap is opened."""
SOFTER = 0.1
"""Of the contact's stiffness: a pad between the parts."""
MOST = 0.99
"""Share of critical damping that a change goes up to."""
DAMPING = 2.0
"""Of all modes."""
MASS = 0.01
"""Of the model's mass, at the place."""
FASTENER = {"mm-t-s": 100.0, "m-kg-s": 1e5, "in-lbf-s": 500.0}
"""Stiffness of an added fastener in x, y and z, force / length; of one size in all units."""
Damped = Callable[[System], System]
"""Gives a reduced System the modal damping of the study."""
APART = 0.1
"""Of the model's diagonal: how far from the place a fastener beside it is."""


@dataclass(frozen=True)
class Change:
    """One change, on the reduced model and on the whole one."""

    kind: str
    words: str
    of_gaps: Callable[[GapOperator], GapOperator]
    of_system: Callable[[System], System] | None
    """None: the System stays."""
    of_structure: Callable[[Structure], Structure] | None = None
    """What the whole model becomes; None: it stays."""
    same_modes: bool = True
    """The System's modes stay those that they were."""
    blocks: tuple[ElementBlock, ...] = ()
    """Elements that the whole model gets."""

    def of_setup(self, setup: Setup) -> Setup:
        """The change of the whole model."""
        of = self.of_gaps
        setup = replace(setup, contacts=of(setup.contacts), connectors=of(setup.connectors))
        return setup if self.of_structure is None else replace(setup, structure=self.of_structure(setup.structure))


@dataclass(frozen=True)
class Effect:
    """What a place does in the verification window, and all of them together."""

    events: int
    impulse: float
    total_impulse: float
    n5: float | None
    total_n5: float | None

    @property
    def rank(self) -> float:
        return self.impulse if self.n5 is None else self.n5


def candidates(
    place: Place,
    cause: Cause,
    reduction: Reduction,
    reference: ReferenceModel,
    reduced: ReducedModel,
    gaps: GapOperator,
    at_rest: GapOperator,
) -> Iterator[Change]:
    """All changes that are tried for a place.

    Parameters
    ----------
    gaps : channels of the run. at_rest : the same, or all, without static loads.
    """
    name, structure, units = place.contact, reduction.structure, reduction.driving.units
    damp = partial(with_damping, structure.modal, reduction.band)
    mine, unloaded = gaps.of_groups({name}), at_rest.of_groups({name})
    clearance = float(at_rest.gap0[unloaded].mean())
    if clearance > 0.0 and (at_rest.preload is None or not at_rest.preload[unloaded].any()):
        yield _wider(name, GAP * clearance, UNITS[units].length)
    springs = mine & np.isfinite(gaps.stiffness) & (gaps.stiffness > 0.0)
    if springs[place.channels].all() and (gaps.curves is None or (gaps.curves.of[place.channels] < 0).all()):
        yield _softer(name)
    if structure.modal is not None or structure.rayleigh != Rayleigh(0.0, 0.0):
        yield _more_damping(structure)
    mass = MASS * reference.system.stats.mass
    yield _heavier(structure.model, int(gaps.nodes_idx[cause.channel]), mass, units, damp)
    for channel in _fastened(structure.model, gaps, mine, cause.channel):
        ends = _ends(gaps, channel)
        if ends is not None:
            yield _fastener(structure.model, ends, units, damp)
    ends = _ends(gaps, cause.channel)
    if ends is not None and reduced.superelements:
        hard = float(gaps.stiffness[cause.channel])
        apart = partial(coupled_again, reference=reference, gaps=gaps, superelements=reduced.superelements)
        yield from _moved(reduction, ends, hard, apart, damp)


def _same(what: GapOperator) -> GapOperator:
    return what


def _wider(name: str, by: float, length: str) -> Change:
    def of(gaps: GapOperator) -> GapOperator:
        return replace(gaps, gap0=gaps.gap0 + by * gaps.of_groups({name}))

    return Change("gap", f"{by:.3g} {length} more gap at {name}", of, None)


def _softer(name: str) -> Change:
    def of(gaps: GapOperator) -> GapOperator:
        return gaps.with_stiffness(np.where(gaps.of_groups({name}), SOFTER * gaps.stiffness, gaps.stiffness))

    return Change("stiffness", f"contact {1 / SOFTER:.0f} times softer at {name}", of, None)


def _more_damping(structure: Structure) -> Change:
    zeta, ray = structure.modal, structure.rayleigh
    ray = Rayleigh(DAMPING * ray.alpha, DAMPING * ray.beta)

    def of(system: System) -> System:
        d, sup, bare = system.damping, system.supports, _undamped(system).supports
        values = None if d.modal_values is None else DAMPING * d.modal_values
        by_modes = {name: getattr(sup, name) - getattr(bare, name) for name in ("C_qs", "C_ss")}
        more = {name: getattr(sup, name) + (DAMPING - 1.0) * C for name, C in by_modes.items()}
        damping = replace(d, alpha=DAMPING * d.alpha, beta=DAMPING * d.beta, modal_values=values)
        return replace(system, damping=damping, supports=replace(sup, **more))

    def whole(s: Structure) -> Structure:
        if zeta is not None:
            more = zeta.times(DAMPING, MOST) if isinstance(zeta, ModalShares) else min(DAMPING * zeta, MOST)
            return replace(s, modal=more)
        return replace(s, rayleigh=ray, override_damping=True)

    return Change("damping", f"{DAMPING:.0f} times the damping of all modes", _same, of, whole)


def _heavier(model: Model, node: int, mass: float, units: UnitsName, damp: Damped) -> Change:
    kg = UNITS[units].to_kg
    M = np.zeros((PER_NODE, PER_NODE))
    M[:3, :3] = mass * np.eye(3)
    words = f"{mass * kg:.3g} kg more at {node_name(model, node)}"
    return _with_matrices("mass", words, model, (node,), np.zeros_like(M), M, damp)


def _fastener(model: Model, ends: tuple[int, int], units: UnitsName, damp: Damped) -> Change:
    k = FASTENER[units]
    first, other = (node_name(model, n) for n in ends)
    words = f"a fastener of {k:g} {UNITS[units].stiffness} from {first} to {other}"
    K = translations(k * np.eye(3))
    return _with_matrices("fastener", words, model, ends, K, np.zeros_like(K), damp)


def _moved(
    reduction: Reduction,
    ends: tuple[int, int],
    hard: float,
    joined: Callable[[Reduction], ReducedModel],
    damp: Damped,
) -> Iterator[Change]:
    """The nearest fastener between the parts of two nodes, put there.

    Parameters
    ----------
    hard : stiffness of the contact there. joined : gives the model whose superelements are joined another way.
    """
    structure = reduction.structure
    model = structure.model
    beyond = APART * float(np.linalg.norm(np.ptp(model.nodes.coords, axis=0)))
    parts = tuple(part_of(model, n) for n in ends)
    old = nearest_fastener(model, (parts[0], parts[1]), model.nodes.coords[ends[0]], beyond)
    if old is None or (old.stiffness is not None and not old.stiffness.any()):
        return
    less = without_fastener(model, old)
    k = old.stiffness
    if k is None:
        k = (hard if 0.0 < hard < np.inf else FASTENER[reduction.driving.units]) * np.eye(3)
    K = translations(k)

    def rest(s: Structure) -> Structure:
        return replace(s, model=without_fastener(s.model, old))

    def apart(_: System) -> System:
        return joined(replace(reduction, structure=rest(structure))).system

    a, b, c, d = (node_name(model, n) for n in (*old.nodes, *ends))
    words = f"the fastener between {a} and {b} moved to {c} and {d}"
    change = _with_matrices("moved", words, model, ends, K, 0.0 * K, damp)
    if unheld_parts(replace(less, blocks=(*less.blocks, *change.blocks)), structure.driven):
        return
    of, whole = change.of_system, change.of_structure
    assert of is not None
    assert whole is not None
    yield replace(change, of_system=lambda s: of(apart(s)), of_structure=lambda s: whole(rest(s)))


def _with_matrices(
    kind: str, words: str, model: Model, nodes: tuple[int, ...], K: FloatArray, M: FloatArray, damp: Damped
) -> Change:
    """Stiffness and mass (d, d) added at some nodes."""
    every = node_dofs(np.array(nodes))
    active = np.flatnonzero(K.any(axis=0) | M.any(axis=0))
    labels, k, m = every[active], K[np.ix_(active, active)], M[np.ix_(active, active)]
    part = part_of(model, nodes[0]) if len(nodes) == 1 else -1
    section = NodalMatrices("ADDED", K, M, np.zeros_like(K))
    block = ElementBlock(f"nodal{len(nodes)}", np.array([0]), np.array([nodes]), section, part)
    return Change(
        kind,
        words,
        _same,
        lambda system: damp(_again(system, labels, k, m)),
        lambda s: _with_blocks(s, [block]),
        same_modes=False,
        blocks=(block,),
    )


def _with_blocks(structure: Structure, blocks: list[ElementBlock]) -> Structure:
    """More elements, damped as all others are: else the modes that are damped alike would no longer be."""
    model = replace(structure.model, blocks=(*structure.model.blocks, *blocks))
    return replace(structure, model=model, override_damping=True)


def _again(system: System, labels: IntArray, k: FloatArray, m: FloatArray) -> System:
    """The reduced System with more stiffness and mass (d, d) on physical dofs (d,), in its new modes, without the
    modal damping of the old ones."""
    system = _undamped(system)
    sup = system.supports
    R, R_s = (to_dense(a) for a in system.rows(labels))
    supports = replace(
        sup,
        K_qs=to_dense(sup.K_qs) + R.T @ k @ R_s,
        K_ss=sup.K_ss + R_s.T @ k @ R_s,
        M_qs=to_dense(sup.M_qs) + R.T @ m @ R_s,
        M_ss=sup.M_ss + R_s.T @ m @ R_s,
        M_start=to_dense(sup.M_start) + R.T @ m @ R_s,
    )
    M, K = to_dense(system.M) + R.T @ m @ R, to_dense(system.K) + R.T @ k @ R
    return diagonalise(replace(system, M=M, K=K, supports=supports))


def _undamped(system: System) -> System:
    """Without modal damping, which acts on the motion relative to the supports."""
    if system.damping.modal_shapes is None:
        return system
    return without_modal_damping(system, support_motion(system, held_factor(system)))


def _fastened(model: Model, gaps: GapOperator, mine: np.ndarray, channel: int) -> list[int]:
    """Channels at which a fastener is tried: at the place, and a little way along the contact."""
    channels = np.flatnonzero(mine)
    away = np.linalg.norm(
        model.nodes.coords[gaps.nodes_idx[channels]] - model.nodes.coords[gaps.nodes_idx[channel]], axis=1
    )
    beside = APART * float(np.linalg.norm(np.ptp(model.nodes.coords, axis=0)))
    other = int(channels[np.abs(away - beside).argmin()])
    return [channel] if away.max() < 0.5 * beside or other == channel else [channel, other]


def _ends(gaps: GapOperator, channel: int) -> tuple[int, int] | None:
    """The secondary node of a channel and the main one that counts most; None where it stands against the ground."""
    row = gaps.G[[channel]].tocoo()
    nodes, own = nodes_of(gaps.labels[row.col]), int(gaps.nodes_idx[channel])
    others: IntArray = np.unique(nodes[nodes != own])
    if not others.size:
        return None
    weight = [float(np.abs(row.data[nodes == n]).sum()) for n in others]
    return own, int(others[int(np.argmax(weight))])


def node_name(model: Model, node_idx: int) -> str:
    """Node and its part, for sentences."""
    part = next((p.name for p in model.parts if p.has(node_idx)), "")
    return f"node {model.nodes.label(node_idx)}{f' of {part}' if part else ''}"


@dataclass(frozen=True)
class Fastener:
    """Elements between two parts, or links of one node to one."""

    nodes: tuple[int, int]
    """Rows of the nodes, in order."""
    stiffness: FloatArray | None
    """(3, 3) against relative translation; None: it is rigid."""


def nearest_fastener(model: Model, parts: tuple[int, int], point: FloatArray, beyond: float) -> Fastener | None:
    """The one between two parts that is nearest to a point, of those further than `beyond` from it."""
    found = []
    for pair in sorted({pair for _, pair in _pairs(model)}):
        if {part_of(model, n) for n in pair} != set(parts):
            continue
        away = float(np.linalg.norm(model.nodes.coords[list(pair)].mean(axis=0) - point))
        if away > beyond:
            found.append((away, pair))
    if not found:
        return None
    pair = min(found)[1]
    return Fastener(pair, _stiffness(model, pair))


def without_fastener(model: Model, fastener: Fastener) -> Model:
    """The model with neither elements nor links between its two nodes."""
    blocks: list[ElementBlock] = []
    for block in model.blocks:
        own = _between(block, fastener.nodes)
        kept = np.flatnonzero(~own)
        blocks.append(some_of(block, kept) if own.any() else block)
    links = tuple(c for c in model.constraints if _two_ends(c.nodes) != fastener.nodes)
    return replace(model, blocks=tuple(b for b in blocks if b.ids.size), constraints=links)


def part_of(model: Model, node: int) -> int:
    """Row of the part that has a node, -1: none."""
    return next((i for i, p in enumerate(model.parts) if p.has(node)), -1)


def _pairs(model: Model) -> Iterator[tuple[object, tuple[int, int]]]:
    """Everything that has just two nodes, in different parts."""
    for block in model.blocks:
        if block.part < 0 and block.nodes_idx.shape[1] == 2:
            yield from ((block, pair) for pair in map(_two_ends, block.nodes_idx) if pair is not None)
    for link in model.constraints:
        pair = _two_ends(link.nodes)
        if pair is not None:
            yield link, pair


def _two_ends(nodes_idx: IntArray) -> tuple[int, int] | None:
    """The two nodes, in order; None where there are not two."""
    nodes = np.unique(nodes_idx)
    return (int(nodes[0]), int(nodes[1])) if nodes.size == 2 else None


def _between(block: ElementBlock, nodes: tuple[int, int]) -> np.ndarray:
    """(n_elem,) elements between parts that have these two nodes."""
    if block.part >= 0 or block.nodes_idx.shape[1] != 2:
        return np.zeros(block.ids.size, dtype=bool)
    return np.asarray((np.sort(block.nodes_idx, axis=1) == nodes).all(axis=1))


def _stiffness(model: Model, nodes: tuple[int, int]) -> FloatArray | None:
    """(3, 3) of the elements between two nodes against relative translation; None where a link holds them."""
    if any(_two_ends(c.nodes) == nodes for c in model.constraints):
        return None
    k = np.zeros((3, 3))
    for block in model.blocks:
        rows = np.flatnonzero(_between(block, nodes))
        if rows.size:
            k += block_matrices(block, rows, model.nodes.coords)[0][:, :3, :3].sum(axis=0)
    return k


def translations(k: FloatArray) -> FloatArray:
    """(12, 12) stiffness of two nodes that resist relative translation with k (3, 3)."""
    D = np.zeros((3, 2 * PER_NODE))
    D[:, :3], D[:, PER_NODE : PER_NODE + 3] = np.eye(3), -np.eye(3)
    return np.asarray(D.T @ k @ D)
