"""What the unreduced model takes over from the run of the reduced one: what both share, damping and motion, and states
at some instants."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.linalg as sla
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, Matrix
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import channel_matrices
from creak.dynamics.flight.contact_steps import fewest_parts
from creak.dynamics.flow.march import SAMPLES, FlowStates, flow_states, with_springs
from creak.dynamics.history import History
from creak.dynamics.loads import Loads
from creak.errors import InputError
from creak.linalg.diagonal import Diagonal
from creak.linalg.memory import ENTRY, fits, spared
from creak.reduction.modal import ModalDamping, modal_values, with_modal_damping, without_modal_damping
from creak.studies.findings.places import find_places
from creak.studies.models.reduced import BLOCKED, ReducedModel, reduced_modes
from creak.studies.models.reference import ReferenceModel
from creak.studies.prepare.flight_steps import RESOLUTIONS
from creak.studies.prepare.marching import Marching
from creak.studies.run.integrate import flowing
from creak.studies.run.job import ReducedRun
from creak.studies.spots.choose import FEWEST, SHARE, STEP, Span, chosen
from creak.verify.events import Event, sides

LARGEST = 8e6
"""Dofs times modes: each step goes through all shapes some five times, 30 ms or so."""


def recovered_on(
    unreduced: System, reduced: System, q: FloatArray, s: FloatArray, kept: IntArray | None = None
) -> FloatArray:
    """(n, k) coordinates of the unreduced System in the motion (q, s) of the reduced one; velocities alike.

    Parameters
    ----------
    kept : of the coordinates, those that are asked for; default: all.

    Raises
    ------
    InputError : the unreduced System has coordinates that are no dofs of nodes.
    """
    at = np.searchsorted(reduced.labels, unreduced.coordinates)
    if np.any(reduced.labels[np.minimum(at, reduced.labels.size - 1)] != unreduced.coordinates):
        raise InputError("the unreduced model has coordinates that are no motion of nodes", expected="full matrices")
    return reduced.recover(q, s, at if kept is None else at[kept])


def damped_alike(zeta: ModalDamping | None, raised: bool, reference: ReferenceModel, reduced: ReducedModel) -> System:
    """The unreduced System for a short march, with the modal damping of a reduced one that has more modes than it.

    C = M Phi diag(2 zeta omega - beta omega^2) Phi' M + beta K with the modes of the reduced model, recovered, in place
    of those of the whole up to the first f_max. A share of critical is that of every mode. Beyond known modes damping
    grows with the frequency (`with_modal_damping`), so a blow that excites modes up to many times the first f_max loses
    up to a tenth of its impulse to that.

    It stays as it is where the damping is another, where f_max was not raised and modes are left, beyond `LARGEST`, and
    where the shapes are not independent.
    All shapes take part in each step, which a march of the whole time cannot afford.

    Shapes of a reduced model are mass-normalised by its own mass, which is off where its last modes are known to few
    digits. They are made orthonormal by that of the whole, the lowest first: a product of two that are not would damp
    low modes as the highest are.
    """
    whole, small = reference.system, reduced.system
    n, k = whole.n, small.n
    if zeta is None or not (raised or reduced.complete) or not isinstance(small.K, Diagonal) or n * k > LARGEST:
        return whole
    own, R = reduced_modes(small, np.inf), reference.support_shapes
    at_rest = np.zeros((small.supports.count, own.omega2.size))
    shapes = recovered_on(whole, small, own.shapes, at_rest)
    try:
        upper = sla.cholesky(shapes.T @ np.asarray(whole.M @ shapes))
    except np.linalg.LinAlgError:
        return whole
    known = replace(own, shapes=np.ascontiguousarray(sla.solve_triangular(upper, shapes.T, trans="T").T))
    return with_modal_damping(without_modal_damping(whole, R), known, R, zeta, beyond=not reduced.complete)


SEED = 1
"""Of what is drawn."""
NEARBY = 40_000
"""Unknowns of the unreduced model that move by themselves in a check, where it has more than twice as many; half of it
where memory holds no factor of the whole."""
SHARES = 15
"""As large a part of the unreduced model, where that is more: what is near then does not shrink with the mesh."""
MODES = 100
"""Lowest modes of the reduced model in which the rest moves with them."""
SAME = 1.01
"""Times the square of a frequency: a reduced model has it so near."""
ROUND_OFF = 1e-12
"""Of a time."""
Begins = tuple[FloatArray, FloatArray]
"""Displacement and velocity that a march begins with: (n,) of the unreduced model, or of the reduced one."""


@dataclass(frozen=True)
class LowModes:
    """The lowest modes of the reduced model, and damping by them: C = beta K + C_extra + M Phi diag(d) Phi' M."""

    shapes: FloatArray
    """(n, p) in its coordinates, V' M V = I."""
    omega2: FloatArray
    """(p,)"""
    damped: FloatArray
    """d (p,)"""
    beta: float | None
    """s; None: damping is not by modes."""
    extra: FloatArray
    """(p, p) V' C_extra V"""


@dataclass(frozen=True)
class Handover:
    """What the unreduced model needs of the reduced one's run."""

    unreduced: System
    reduced: System
    """As it was marched."""
    gaps: GapOperator
    """All channels of the run, hard ones with their springs there."""
    loads: Loads
    """`SAMPLES` of each flight step."""
    history: History
    """Of the reduced run."""
    merge: float | None
    f_max: float
    """Of the verification."""
    fewest: int
    """Contact steps in a flight step by default."""
    budget: float
    """Back-substitutions that the checks of events may take, and those of rubbing as many again."""
    positions: FloatArray
    """(n_node, 3)"""
    nearby: int | None = None
    """Unknowns of the unreduced model that move by themselves, near an event; None: all."""
    low: LowModes | None = None
    """Where some do: modes in which the rest moves with them; their damping, which `unreduced` does not have then."""
    by_parts: bool = False
    """Memory holds factors of single parts alone: they are made for each check anew."""

    @property
    def ends(self) -> FloatArray:
        """(n_step + 1,) of the flight steps, s."""
        return np.asarray(self.loads.time[::SAMPLES])

    @cached_property
    def sides(self) -> list[set[tuple[str, str]]]:
        """Contact and channel of each side: those that are left of some channels may be numbered otherwise."""
        return [{(self.gaps.group[j], self.gaps.names[j]) for j in own.tolist()} for own in sides(self.gaps)]

    @cached_property
    def low_motion(self) -> FloatArray:
        """(p, n) the lowest modes in the coordinates of the unreduced model."""
        assert self.low is not None
        V = self.low.shapes
        return recovered_on(self.unreduced, self.reduced, V, np.zeros((self.reduced.supports.count, V.shape[1]))).T

    @cached_property
    def acts(self) -> Matrix:
        """(m, n) by which the unreduced coordinates act on each channel, in any direction."""
        on = channel_matrices(self.unreduced, self.gaps)
        return sp.csr_matrix(sum((abs(sp.csr_matrix(t)) for t, _ in on.tangents), abs(sp.csr_matrix(on.G))))

    def channels(self, event: Event) -> IntArray:
        """Those of the event's side."""
        own = next(own for own in self.sides if (event.group, event.channel) in own)
        names = zip(self.gaps.group, self.gaps.names, strict=True)
        return np.array([j for j, name in enumerate(names) if name in own], dtype=np.int64)

    def held(self, s: Span, near: IntArray) -> FloatArray:
        """(2 f,) friction forces of the channels `near` where a piece begins."""
        friction = self.gaps.friction
        if friction is None:
            return np.zeros(0)
        row = np.searchsorted(self.history.time, s.time(self.ends)[0] * (1.0 - ROUND_OFF))
        return np.asarray(self.history.tangential[row, np.repeat(np.isin(friction.channels, near), 2)])


def handed_over(found: ReducedRun, reference: ReferenceModel) -> tuple[Handover | None, str]:
    """What the marches need, or why there are none."""
    structure, marching, run, reduced = found.reduction.structure, found.marching, found.run, found.reduced
    if not marching.table.exact:
        return None, "a scheme was forced, which the unreduced model does not share"
    if run.stopped is not None:
        return None, "the run was stopped"
    system, why = flowing(reduced.system)
    if system is None:
        return None, f"the reduced model was not marched by exact flow{why}"
    v, raised = found.scope.verification, found.reduction.band.raised > 0
    if any((s.coordinates < 0).any() for s in structure.superelements):
        return None, "parts of the model are superelements from files, whose inside is not there"
    nearby, low, n = None, None, reference.free_dof
    if n > 2 * NEARBY or reference.of_parts is not None:
        nearby, low = min(max(NEARBY, n // SHARES), n // 2), low_modes(structure.modal, system, reference)
    if nearby is None:
        unreduced = damped_alike(structure.modal, raised, reference, reduced)
    elif reference.of_parts is None:
        unreduced = without_modal_damping(reference.system, reference.support_shapes)
    elif fits(sum(ENTRY * (part.K.nnz + part.M.nnz) for part in reference.parts)):
        joined = structure.joined(reference.parts, reference.loose)
        unreduced = replace(joined, K=spared(joined.K), M=spared(joined.M))
    else:
        return None, "memory does not hold the matrices of the whole model"
    fewest = fewest_parts(RESOLUTIONS[marching.table.accuracy].stepped)
    budget = max(FEWEST / (unreduced.n + STEP), SHARE * BLOCKED * reduced.solves)
    run_of = marching.loads, run.history, v.merge, v.f_max
    positions = structure.model.nodes.coords
    by_parts = reference.of_parts is not None
    gaps = with_springs(system, found.gaps, marching.loads, marching.resolution)
    return Handover(unreduced, system, gaps, *run_of, fewest, budget, positions, nearby, low, by_parts), ""


def low_modes(zeta: ModalDamping | None, reduced: System, reference: ReferenceModel) -> LowModes:
    """The lowest modes of the reduced model. Those up to the highest that is known of the whole are damped by `zeta`;
    beyond, damping is in proportion to the stiffness."""
    top = reference.modes.omega2.max(initial=0.0)
    own = reduced_modes(reduced, np.inf if isinstance(reduced.K, Diagonal) else np.sqrt(top) / (2.0 * np.pi))
    lowest = np.argsort(own.omega2, kind="stable")[:MODES]
    V, omega2 = own.shapes[:, lowest], np.maximum(own.omega2[lowest], 0.0)
    E = reduced.damping.extra
    extra = np.zeros((V.shape[1], V.shape[1])) if E is None else np.asarray(V.T @ (E @ V))
    damped, beta = np.zeros(omega2.size), None
    if zeta is not None:
        known = omega2 <= SAME * top
        beta, damped[known] = modal_values(omega2[known], zeta, beyond=True)
    return LowModes(V, omega2, damped, beta, extra)


def ordered(found: ReducedRun, of: Handover) -> list[tuple[Event, str]]:
    """Events of each place of the reduced run in the order in which they are looked at."""
    return chosen(found.run.events, find_places(found.scope, found.run), of.gaps, SEED)


@dataclass(frozen=True)
class States:
    """States of the reduced run where pieces of it begin."""

    found: FlowStates
    begins: dict[int, Begins]
    """Flight step at whose end it is -> the state: of the unreduced model, recovered, where all of that takes part in
    the checks (`Handover.nearby` is None), else of the reduced one."""


def states_at(marching: Marching, of: Handover, spans: Sequence[Span]) -> States:
    """States of the reduced run where the pieces begin, by marching it again up to there."""
    at = sorted({s.first for s in spans})
    found = flow_states(of.reduced, of.gaps, of.loads, at, resolution=marching.resolution, solver=marching.solver)
    u, v = found.coordinates, found.velocities
    if of.nearby is None:
        support = of.loads.support[:2, [SAMPLES * first for first in at]]
        both = recovered_on(of.unreduced, of.reduced, np.hstack([u, v]), support.reshape(2 * len(at), -1).T)
        u, v = both[:, : len(at)], both[:, len(at) :]
    return States(found, {first: (u[:, k].copy(), v[:, k].copy()) for k, first in enumerate(at)})
