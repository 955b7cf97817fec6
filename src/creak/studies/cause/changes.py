"""Single changes to a model that quieten a place: found on the reduced model, nothing is reduced again.

A gap, a contact spring and damping are changed as they are; a mass or a fastener is a low-rank change of M or K of the
reduced model, which is then diagonalised again. Each is also known as a change of the whole model, so that a full run
can check it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.part import Rayleigh
from creak.assembly.system import System, to_dense
from creak.contact.gap_operator import GapOperator
from creak.model.dofs import TRANSLATIONS, node_dofs, nodes_of
from creak.model.materials import PointMass, Spring
from creak.model.mesh import ElementBlock, Model
from creak.model.units import UNITS
from creak.reduction.diagonal import diagonalise
from creak.studies.cause.decompose import Cause
from creak.studies.file.config import DampingTable
from creak.studies.models.reduced import with_damping
from creak.studies.prepare.setup import Setup
from creak.studies.results.places import Place

GAP = 0.1
"""Share of the clearance by which a gap is opened."""
SOFTER = 0.1
"""Of the contact's stiffness: a pad between the parts."""
DAMPING = 2.0
"""Of all modes."""
MASS = 0.01
"""Of the model's mass, at the place."""
FASTENER = {"mm-t-s": 100.0, "m-kg-s": 1e5}
"""Stiffness of an added fastener in x, y and z, force / length."""
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
    of_setup: Callable[[Setup], Setup]
    same_modes: bool = True
    """The System's modes stay those that they were."""


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


def candidates(setup: Setup, gaps: GapOperator, place: Place, cause: Cause, mass: float) -> Iterator[Change]:
    """All changes that are tried for a place.

    Parameters
    ----------
    mass : of the whole model.
    """
    name, mine = place.contact, gaps.of_groups({place.contact})
    clearance = float(gaps.gap0[mine].mean())
    if clearance > 0.0 and gaps.preload is None:
        yield _wider(name, GAP * clearance, setup)
    springs = mine & np.isfinite(gaps.stiffness) & (gaps.stiffness > 0.0)
    if springs[place.channels].all() and gaps.curves is None:
        yield _softer(name)
    if _damps(setup):
        yield _more_damping(setup)
    if setup.static is not None:
        return
    node = int(gaps.nodes_idx[cause.channel])
    yield _heavier(setup, node, MASS * mass)
    for channel in _fastened(setup.model, gaps, mine, cause.channel):
        ends = _ends(gaps, channel)
        if ends is not None:
            yield _fastener(setup, *ends)


def _same(what: GapOperator) -> GapOperator:
    return what


def _wider(name: str, by: float, setup: Setup) -> Change:
    length = UNITS[setup.study.config.model.units].length

    def of(gaps: GapOperator) -> GapOperator:
        return replace(gaps, gap0=gaps.gap0 + by * gaps.of_groups({name}))

    return Change("gap", f"{by:.3g} {length} more gap at {name}", of, None, lambda s: _with_gaps(s, of))


def _softer(name: str) -> Change:
    def of(gaps: GapOperator) -> GapOperator:
        return gaps.with_stiffness(np.where(gaps.of_groups({name}), SOFTER * gaps.stiffness, gaps.stiffness))

    return Change(
        "stiffness", f"contact {1 / SOFTER:.0f} times softer at {name}", of, None, lambda s: _with_gaps(s, of)
    )


def _with_gaps(setup: Setup, of: Callable[[GapOperator], GapOperator]) -> Setup:
    return replace(setup, contacts=of(setup.contacts), connectors=of(setup.connectors))


def _damps(setup: Setup) -> bool:
    return setup.study.config.damping.modal is not None or setup.rayleigh != Rayleigh(0.0, 0.0)


def _more_damping(setup: Setup) -> Change:
    zeta = setup.study.config.damping.modal
    ray = Rayleigh(DAMPING * setup.rayleigh.alpha, DAMPING * setup.rayleigh.beta)

    def of(system: System) -> System:
        d = system.damping
        values = None if d.modal_values is None else DAMPING * d.modal_values
        return replace(system, damping=replace(d, alpha=DAMPING * d.alpha, beta=DAMPING * d.beta, modal_values=values))

    def whole(s: Setup) -> Setup:
        if zeta is not None:
            return s.with_tables(damping=DampingTable(modal=min(DAMPING * zeta, 0.99)))
        return replace(s, rayleigh=ray, override_damping=True)

    return Change("damping", f"{DAMPING:.0f} times the damping of all modes", _same, of, whole)


def _heavier(setup: Setup, node: int, mass: float) -> Change:
    kg = UNITS[setup.study.config.model.units].to_kg
    labels = node_dofs(np.array([node]), TRANSLATIONS)

    def of(system: System) -> System:
        R, R_s = (to_dense(a) for a in system.rows(labels))
        return _again(setup, system, mass * R.T @ R, mass * R.T @ R_s, mass * R_s.T @ R_s, mass=True)

    block = ElementBlock("mass", np.array([0]), np.array([[node]]), PointMass("ADDED", mass), _part(setup.model, node))
    words = f"{mass * kg:.3g} kg more at {node_name(setup.model, node)}"
    return Change("mass", words, _same, of, lambda s: _with_blocks(s, [block]), same_modes=False)


def _fastener(setup: Setup, node: int, other: int) -> Change:
    units = setup.study.config.model.units
    k = FASTENER[units]
    labels = node_dofs(np.array([node, other]), TRANSLATIONS)
    D = np.hstack([np.eye(3), -np.eye(3)])

    def of(system: System) -> System:
        R, R_s = (D @ to_dense(a) for a in system.rows(labels))
        return _again(setup, system, k * R.T @ R, k * R.T @ R_s, k * R_s.T @ R_s, mass=False)

    blocks = [
        ElementBlock("spring2", np.array([0]), np.array([[node, other]]), Spring("ADDED", d, d, k), -1)
        for d in (1, 2, 3)
    ]
    unit = UNITS[units].stiffness
    words = f"a fastener of {k:g} {unit} from {node_name(setup.model, node)} to {node_name(setup.model, other)}"
    return Change("fastener", words, _same, of, lambda s: _with_blocks(s, blocks), same_modes=False)


def _with_blocks(setup: Setup, blocks: list[ElementBlock]) -> Setup:
    """More elements, damped as all others are: else the modes that are damped alike would no longer be."""
    model = replace(setup.model, blocks=(*setup.model.blocks, *blocks))
    return replace(setup, model=model, override_damping=True)


def _part(model: Model, node: int) -> int:
    return next((i for i, p in enumerate(model.parts) if p.has(node)), -1)


def _again(
    setup: Setup, system: System, own: FloatArray, side: FloatArray, corner: FloatArray, *, mass: bool
) -> System:
    """The reduced System with more mass or stiffness, in its new modes."""
    sup, d = system.supports, replace(system.damping, modal_shapes=None, modal_values=None)
    if mass:
        supports = replace(
            sup,
            M_qs=to_dense(sup.M_qs) + side,
            M_ss=sup.M_ss + corner,
            M_start=to_dense(sup.M_start) + side,
        )
        changed = replace(system, M=to_dense(system.M) + own, K=to_dense(system.K), supports=supports, damping=d)
    else:
        supports = replace(sup, K_qs=to_dense(sup.K_qs) + side, K_ss=sup.K_ss + corner)
        changed = replace(system, M=to_dense(system.M), K=to_dense(system.K) + own, supports=supports, damping=d)
    return with_damping(setup, diagonalise(changed))


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
