"""How large the reduced model becomes, before any mode is computed, and what a run would cost here."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg as sla
import scipy.sparse as sp

from creak.arrays import IntArray
from creak.assembly.elimination import fixed_equations, linear_equations
from creak.assembly.part import split_constraints
from creak.assembly.partition import shared_nodes
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.scheme import Scheme
from creak.dynamics.step_matrix import StepFactor
from creak.linalg.factor import Factor, SingularMatrixError, regular_factor
from creak.linalg.modes import dense_is_faster, small_shift
from creak.linalg.pencil import Pencil
from creak.linalg.threads import one_blas_thread
from creak.model.dofs import node_dofs
from creak.model.mesh import Model
from creak.reduction.inside import Inside, pieces_of
from creak.studies.file.config import InterfaceTable
from creak.studies.models.reference import ReferenceModel
from creak.studies.models.substructures import Partition, Substructure, partition, required
from creak.studies.prepare.reduction import Reduction
from creak.studies.prepare.structure import Structure
from creak.studies.run.foretold import median_s

BLOCK = 32
"""Columns of the back-substitution that is timed."""

Progress = Callable[[str, int, int], None]
CONTACT_STEP = 2.0
"""Step with contact over a back-substitution (1.4 to 2.0 measured, docs/evidence.md)."""
COLUMNS_PER_MODE, LANCZOS, STATIC = 3.8, 4.0, 1.5
"""Lanczos columns for a mode (door at 40 mm, 238 modes), and time over that of blocked back-substitutions: modes 3.6 to
4.5, constraint modes 1.3 to 1.6 (docs/reduction.md, a million dofs)."""
EIGEN = 300
"""Size of the dense eigenproblem that is timed."""


@dataclass(frozen=True)
class Counted:
    """Modes of K x = omega^2 M x below some frequencies."""

    below: Mapping[float, int]
    """Hz -> number of modes."""
    factor_s: float
    """The last factorisation."""
    column_s: float
    """A column of a back-substitution of `BLOCK`."""
    memory: float = 0.0
    """Bytes of the last factor."""


@dataclass(frozen=True)
class PartSize:
    """One substructure as it would be reduced."""

    name: str
    dofs: int
    retained: Mapping[str, int]
    """Why a dof is retained -> how many, each counted once."""
    modes: Counted
    """Fixed-interface modes; none of unreduced elements."""
    held: bool
    """The retained dofs hold the part: without that there is no Craig-Bampton model of it."""
    unreduced: bool
    inner: int = 0
    """Dofs that are not retained."""
    entries_K: int = 0
    entries_M: int = 0
    """Stored entries of the inner stiffness and mass."""
    cut: float = 0.0
    """Bytes that its pieces take at a time where memory does not hold a factor of it; 0: it does."""

    @property
    def boundary(self) -> int:
        return sum(self.retained.values())

    @property
    def factor(self) -> float:
        """Bytes of a factor of its inside, or of the pieces of one that are there at a time."""
        return self.cut or self.modes.memory


@dataclass(frozen=True)
class Sizes:
    """All substructures, and what their coupling takes away."""

    parts: tuple[PartSize, ...]
    coupled: int
    """Physical dofs of the coupled model: links, supports and shared nodes counted once."""

    def unknowns(self, f_max: float) -> int:
        """Coordinates of the coupled Craig-Bampton model with modes to `f_max`, one of the frequencies counted."""
        return self.coupled + sum(p.modes.below.get(f_max, 0) for p in self.parts)


def sizes(
    reduction: Reduction,
    reference: ReferenceModel,
    gaps: GapOperator,
    frequencies: Sequence[float],
    progress: Progress,
) -> Sizes:
    """Retained dofs and number of fixed-interface modes of each part: a factorisation per part and frequency.

    Every contact dof is retained: there is no keep_out, and no interface is thinned.

    Raises
    ------
    InputError : as `partition`.
    """
    table = reduction.table.model_copy(update={"keep_out": 0.0, "interface": InterfaceTable()})
    cut, watched = partition(replace(reduction, table=table), reference, gaps), reduction.exterior.watch.nodes
    reasons = list(_reasons(required(reduction, cut.model), cut.model, watched, gaps))
    parts, count = [], len(cut.substructures)
    for k, sub in enumerate(cut.substructures):
        progress("count fixed-interface modes", k, count)
        parts.append(_part_size(sub, reasons, frequencies))
    progress("count fixed-interface modes", count, count)
    return Sizes(tuple(parts), _coupled(reduction.structure, reference.loose, cut))


def sturm_counts(pencil: Pencil, frequencies: Sequence[float]) -> Counted:
    """Number of modes below each frequency (Hz): the inertia of K - omega^2 M (Sylvester), no mode computed."""
    n = pencil.K.shape[0]
    below, seconds, column, memory = {}, 0.0, 0.0, 0.0
    if n == 0:
        return Counted(dict.fromkeys(frequencies, 0), 0.0, 0.0)
    found: Factor | None = None
    for f in frequencies:
        started = time.perf_counter()
        found = pencil.counted((2.0 * np.pi * f) ** 2, found)
        seconds = time.perf_counter() - started
        below[f], memory = found.n_negative, found.memory
        if f == frequencies[-1]:
            b = np.asfortranarray(np.random.default_rng(5).standard_normal((n, BLOCK)))
            started = time.perf_counter()
            found.solve(b)
            column = (time.perf_counter() - started) / BLOCK
    return Counted(below, seconds, column, memory)


def _part_size(sub: Substructure, reasons: Sequence[tuple[str, IntArray]], frequencies: Sequence[float]) -> PartSize:
    part = sub.part
    if sub.stays:
        none = Counted(dict.fromkeys(frequencies, 0), 0.0, 0.0)
        return PartSize(part.name, part.n, {"unreduced": part.n}, none, True, True)
    inside = Inside(part, sub.boundary)
    pencil = Pencil(inside.K_ii, inside.M_ii, pieces_of(inside.K_ii, inside.M_ii))
    held = _held(pencil)
    counted = sturm_counts(pencil, frequencies)
    retained, entries = _by_reason(part, sub.boundary, reasons), (int(pencil.K.nnz), int(pencil.M.nnz))
    cut = 0.0 if pencil.pieces is None else pencil.pieces.bytes
    return PartSize(part.name, part.n, retained, counted, held, False, inside.i.size, *entries, cut)


def _held(pencil: Pencil) -> bool:
    """No motion of the inside without stiffness: none below a trace of the first elastic eigenvalue."""
    K, M = pencil.K, pencil.M
    if K.shape[0] == 0 or not M.diagonal().any():
        return K.shape[0] == 0 or regular_factor(K) is not None
    try:
        return pencil.factor(small_shift(K, M), definite=False).n_negative == 0
    except SingularMatrixError:
        return False


def _by_reason(part: System, boundary: IntArray, reasons: Sequence[tuple[str, IntArray]]) -> dict[str, int]:
    """Boundary coordinates by the first reason that names them."""
    left, out = boundary, {}
    for name, labels in reasons:
        rows, _ = part.rows(np.intersect1d(labels, part.labels))
        mine = np.intersect1d(left, sp.csr_matrix(rows).indices)
        left = np.setdiff1d(left, mine)
        if mine.size:
            out[name] = int(mine.size)
    if left.size:
        out["without stiffness"] = int(left.size)
    return out


def _reasons(
    must: dict[str, IntArray], model: Model, watched: IntArray, gaps: GapOperator
) -> Iterator[tuple[str, IntArray]]:
    """Why a physical dof stays, the strongest reason first."""
    chosen = must.pop("chosen")
    yield from must.items()
    yield "interfaces", node_dofs(shared_nodes(model))
    contact = np.union1d(node_dofs(gaps.retained_nodes, (1, 2, 3)), gaps.labels)
    yield "contact", contact.astype(np.int64)
    yield "outputs", node_dofs(watched, (1, 2, 3))
    yield "chosen", chosen


def _coupled(structure: Structure, loose: System | None, cut: Partition) -> int:
    """Physical coordinates once links, supports and shared nodes are gone."""
    kept = [s.part.coordinates[s.boundary] for s in cut.substructures]
    if loose is not None:
        kept.append(loose.coordinates)
    kept += [s.coordinates[s.coordinates >= 0] for s in structure.superelements]
    inner = sum(int((s.coordinates < 0).sum()) for s in structure.superelements)
    labels = np.unique(np.concatenate(kept))
    links = [e.labels[0] for c in split_constraints(cut.model)[1] for e in linear_equations(c, cut.model.nodes.coords)]
    fixed = [e.labels[0] for f in cut.model.fixed for e in fixed_equations(f)]
    gone = np.concatenate([np.array(links + fixed, dtype=np.int64), *structure.driven.labels.values()])
    return inner + int(np.setdiff1d(labels, gone).size)


@dataclass(frozen=True)
class UnreducedCost:
    """The unreduced model at one step length."""

    dofs: int
    factor_s: float
    solve_s: float
    """A back-substitution."""
    channels: int

    def run_s(self, steps: int) -> float:
        """Factorisation, the channels' responses, and every step as if it had contact: an upper estimate."""
        return self.factor_s + (self.channels + CONTACT_STEP * steps) * self.solve_s


def unreduced_cost(system: System, scheme: Scheme, h: float, channels: int) -> UnreducedCost:
    """Time one factorisation and the median of a few back-substitutions of the step matrix."""
    started = time.perf_counter()
    solver = StepFactor(system, scheme, h)
    made = time.perf_counter() - started
    b = np.random.default_rng(3).standard_normal(system.n)
    with one_blas_thread():
        return UnreducedCost(system.n, made, median_s(lambda: solver.solve(b)), channels)


def superelements_s(parts: Sequence[PartSize], f_max: float, unknowns: int, cube_s: float) -> float:
    """Offline time of a Craig-Bampton model: factors, two back-substitutions a retained dof, Lanczos, diagonalising."""
    total = cube_s * float(unknowns) ** 3
    for part in parts:
        total += part.modes.factor_s + 2.0 * STATIC * part.boundary * part.modes.column_s
        dense = dense_is_faster(part.inner, part.modes.below.get(f_max, 0))
        total += cube_s * float(part.inner) ** 3 if dense else lanczos_s(part.modes, f_max)
    return total


def lanczos_s(counted: Counted, f_max: float) -> float:
    """Time for the modes below `f_max` (one of the frequencies counted)."""
    return LANCZOS * COLUMNS_PER_MODE * counted.below.get(f_max, 0) * counted.column_s


def assembly_modes_s(counted: Counted, f_max: float, rows: int) -> float:
    """Offline time of gap modes: modes of the assembly, a static shape per channel row."""
    return counted.factor_s + lanczos_s(counted, f_max) + STATIC * rows * counted.column_s


def eigen_cube_s() -> float:
    """Seconds per n^3 of the dense symmetric eigenproblem."""
    A = np.random.default_rng(1).standard_normal((EIGEN, EIGEN))
    A = A @ A.T + EIGEN * np.eye(EIGEN)
    started = time.perf_counter()
    sla.eigh(A, np.eye(EIGEN))
    return (time.perf_counter() - started) / EIGEN**3
