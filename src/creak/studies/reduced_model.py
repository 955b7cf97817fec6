"""The reduced model: Craig-Bampton per part, joined like the full parts, then diagonalised."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from creak.arrays import IntArray
from creak.assembly.constraints import fixed_equations, linear_equations
from creak.assembly.part import split_constraints
from creak.assembly.system import System, to_dense
from creak.contact.gap_operator import GapOperator
from creak.linalg.diagonal import Diagonal
from creak.linalg.modes import Modes, modes
from creak.reduction.craig_bampton import craig_bampton
from creak.reduction.diagonal import diagonalise
from creak.reduction.modal import support_motion
from creak.studies.reference_model import ReferenceModel, damped, held_factor, join_parts, modal_band
from creak.studies.setup import Setup

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class ReducedModel:
    """The coupled superelements and what they cost."""

    parts: tuple[System, ...]
    system: System
    retained: int
    modes: int
    wall_s: float
    cpu_s: float


def reduce_model(setup: Setup, reference: ReferenceModel, gaps: GapOperator, progress: Progress) -> ReducedModel:
    """Reduce each part to its retained dofs and modes, couple the parts, diagonalise the whole."""
    wall, cpu = clock.perf_counter(), clock.process_time()
    labels = retained_labels(setup, gaps)
    f_max = setup.study.config.reduction.f_max
    reduced = [
        craig_bampton(part, _touched(part, labels), f_max=f_max, progress=progress) for part in reference.parts
    ]
    progress("couple and diagonalise", 0, 1)
    coupled = join_parts(setup, list(reduced), reference.loose)
    system = _with_damping(setup, diagonalise(coupled))
    progress("couple and diagonalise", 1, 1)
    return ReducedModel(
        tuple(reduced), system, int(sum(p.stats["retained"] for p in reduced)),
        int(sum(p.stats["modes"] for p in reduced)), clock.perf_counter() - wall, clock.process_time() - cpu,
    )  # fmt: skip


def retained_labels(setup: Setup, gaps: GapOperator) -> IntArray:
    """Physical dofs that must stay: links between parts, supports, loads, channels, watched nodes.

    Channels and watched nodes need their translations (a connector its own dof); with `keep_out` all nodes
    of the mesh within that distance of a channel stay as well, with all their dofs.
    """
    model = setup.model
    pieces = [setup.connectors.labels, gaps.labels, *setup.driven.labels.values(), *setup.loads.force_labels]
    pieces.append((6 * setup.watched[:, None] + np.arange(3)).ravel())
    for constraint in split_constraints(model)[1]:
        pieces += [np.array(e.labels, dtype=np.int64) for e in linear_equations(constraint, model.nodes.coords)]
    for fixed in model.fixed:
        pieces += [np.array(e.labels, dtype=np.int64) for e in fixed_equations(fixed)]
    for block in model.blocks:
        if block.part < 0:
            pieces.append((6 * block.nodes_idx.ravel()[:, None] + np.arange(6)).ravel())
    pieces.append(_near_contact(setup, gaps))
    return np.unique(np.concatenate(pieces)).astype(np.int64)


def _near_contact(setup: Setup, gaps: GapOperator) -> IntArray:
    distance = setup.study.config.reduction.keep_out
    if distance == 0.0 or gaps.m == 0:
        return np.zeros(0, dtype=np.int64)
    coords = setup.model.nodes.coords
    near, _ = cKDTree(coords[gaps.retained_nodes]).query(coords, distance_upper_bound=distance)
    nodes = np.flatnonzero(np.isfinite(near))
    return (6 * nodes[:, None] + np.arange(6)).ravel()


def _touched(part: System, labels: IntArray) -> IntArray:
    """Coordinates of the part that the labels depend on, and those without stiffness (free point masses)."""
    rows, _ = part.rows(labels)
    loose = np.flatnonzero(part.K.diagonal() == 0.0)
    return np.union1d(sp.csr_matrix(rows).indices, loose).astype(np.int64)


def _with_damping(setup: Setup, system: System) -> System:
    if setup.study.config.damping.modal is None:
        return system
    modes = _own_modes(system, modal_band(setup))
    return damped(setup, system, modes, support_motion(system, held_factor(system)))


def _own_modes(system: System, f_max: float) -> Modes:
    """Modes of a System that is diagonal already (M = I): unit vectors."""
    omega2 = np.asarray(system.K.diagonal() if hasattr(system.K, "diagonal") else np.diag(to_dense(system.K)))
    keep = np.flatnonzero(omega2 <= (2.0 * np.pi * f_max) ** 2)
    shapes = np.zeros((system.n, keep.size))
    shapes[keep, np.arange(keep.size)] = 1.0
    return Modes(omega2[keep], shapes, 0.0, True)


def reduced_modes(system: System, f_max: float) -> Modes:
    """Modes of the reduced model up to `f_max`, Hz, for comparison with the reference."""
    if isinstance(system.K, Diagonal):
        return _own_modes(system, f_max)
    return modes(system.K, system.M, f_max=f_max, free=True)
