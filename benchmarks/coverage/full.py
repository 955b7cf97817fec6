"""The full matrices of a study in all of their modes, their independent march, and its events."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg as sla

from benchmarks.coverage.march import Course, Modes, march
from creak.arrays import FloatArray, to_dense
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator, join
from creak.dynamics.history import ENERGIES, History
from creak.progress import silent
from creak.reduction.modal import shares_at
from creak.studies.models.reference import build_reference
from creak.studies.prepare.excitation import sample_loads
from creak.studies.prepare.setup import Setup
from creak.verify.events import Event, find_events, sides

OF_CONTACT = 30.0
"""Steps in the shortest period of the contact springs; what is told takes twice as many, to check it."""
OF_LOADS = 1500.0
"""Samples in a period of the fastest excitation: straight lines between them are within 2e-6."""
IN_FLIGHT = 600.0
"""Longest flight steps in that period: a load that is linear in one is within 1.4e-5."""
MASSLESS = 1e-10
"""Share of the largest mass of a dof of its kind below which it has none, and follows statically."""
HARD = 10.0
"""Stiffness that stands for exact unilateral contact, times what the elements set against the motion of one channel."""
DIAGONAL = 1e-6
"""Damping between two modes, as a share of that of both, that counts as none."""


@dataclass(frozen=True)
class Full:
    """All modes of a study's unreduced model, its channels and loads."""

    modes: Modes
    gaps: GapOperator
    signals: FloatArray
    spacing: float
    longest: float
    end: float
    massless: int
    """Dofs that follow statically."""

    def run(self, of_contact: float) -> Course:
        """March with so many steps in the shortest contact period."""
        h = 2.0 * np.pi / max(self.modes.contact_omega, 2.0 * np.pi / self.longest) / of_contact
        return march(self.modes, self.signals, self.spacing, self.end, min(h, self.longest), self.longest)

    def silent(self) -> Course:
        """The same motion if nothing ever pressed."""
        none = np.zeros(0, dtype=np.int64)
        modes = replace(self.modes, stiffness=np.zeros(self.gaps.m), rubs=none)
        modes = replace(modes, tangent=np.zeros((0, modes.omega.size)), mu=np.zeros((0, 3)))
        return march(modes, self.signals, self.spacing, self.end, self.longest, self.longest)

    def events(self, course: Course, merge: float | None, f_max: float) -> list[Event]:
        """Of a march, by the one definition of an event."""
        n, m = course.gap.shape
        return find_events(
            History(
                time=course.time,
                gap=course.gap,
                force=course.force,
                slip=np.zeros((0, m)),
                output_index=np.zeros(0, dtype=np.int64),
                displacement=np.zeros((0, 0)),
                energy=np.zeros((n, len(ENERGIES))),
                contact_steps=0,
                setup_s=0.0,
            ),
            self.gaps,
            merge,
            f_max,
        )


def full_model(setup: Setup, fastest: float) -> Full:
    """The unreduced model of a study, which nothing of its numerics touches.

    Parameters
    ----------
    fastest : Hz, of the excitation.
    """
    system = build_reference(setup.structure, setup.band, silent).system
    gaps = join([setup.contacts, setup.connectors])
    sup = system.supports
    M, K = to_dense(system.M), to_dense(system.K)
    light = massless(system, M)
    heavy = np.setdiff1d(np.arange(system.n), light)
    follow = np.zeros((system.n, heavy.size))  # q = follow q_heavy (+ statically with the supports: below)
    follow[heavy, np.arange(heavy.size)] = 1.0
    by_support = np.zeros((system.n, sup.count))
    if light.size:
        inside = sla.cho_factor(K[np.ix_(light, light)])
        follow[light] = -sla.cho_solve(inside, K[np.ix_(light, heavy)])
        by_support[light] = -sla.cho_solve(inside, to_dense(sup.K_qs)[light])
    omega2, shapes = sla.eigh(follow.T @ K @ follow, follow.T @ M @ follow)
    Phi = follow @ shapes
    omega = np.sqrt(np.where(omega2 > 1e-9 * np.median(omega2), omega2, 0.0))
    c, by_rate = damping_of(setup, system, omega, Phi, by_support)
    end = float(setup.loads.time[-1])
    spacing = min(1.0 / (OF_LOADS * fastest), end / 100.0)
    time = spacing * np.arange(int(np.ceil(end / spacing)) + 2)
    loads = sample_loads(setup.model, setup.study.driving, time)
    signals = np.concatenate([loads.support[0].T, loads.support[1].T, loads.support[2].T, loads.force.T])
    B = np.zeros((system.n, len(loads.force_labels)))
    for j, labels in enumerate(loads.force_labels):
        B[:, j] = np.asarray(system.rows(labels)[0].sum(axis=0)).ravel()
    M_qs, K_qs = to_dense(sup.M_qs), to_dense(sup.K_qs)
    load = np.hstack(
        [
            -Phi.T @ (K_qs + K @ by_support),
            by_rate,
            -Phi.T @ (M_qs + M @ by_support),
            Phi.T @ B,
        ]
    )
    R, R_s = system.rows(gaps.labels)
    rubs = np.zeros(0, dtype=np.int64) if gaps.friction is None else gaps.friction.channels.astype(np.int64)

    def rows(A: object) -> tuple[FloatArray, FloatArray]:
        onto, by = to_dense(A @ R), to_dense(A @ R_s)
        return onto @ Phi, by + onto @ by_support

    if light.size and np.abs(to_dense(gaps.G @ R)[:, light]).max(initial=0.0) > 0.0:
        raise ValueError("a channel moves a dof without mass")
    G, G_s = rows(gaps.G)
    zeros, n_force = np.zeros_like(G_s), len(loads.force_labels)
    T, T_s = np.zeros((2 * rubs.size, omega.size)), np.zeros((2 * rubs.size, sup.count))
    for k, A in enumerate(gaps.tangents):
        onto, by = rows(A)
        T[k::2], T_s[k::2] = onto[rubs], by[rubs]
    f = gaps.friction
    mu = np.zeros((0, 3)) if f is None else np.column_stack([f.static, f.kinetic, f.decay])[rubs]
    onto = to_dense(gaps.G @ R)
    behind = np.einsum("ij,jk,ik->i", onto, K, onto) / np.maximum(np.einsum("ij,ij->i", onto, onto) ** 2, 1e-300)
    side = np.zeros(gaps.m, dtype=np.int64)
    for number, channels in enumerate(sides(gaps)):
        side[channels] = number
    modes = Modes(
        omega=omega,
        c=c,
        load=load,
        normal=G,
        normal_sig=np.hstack([G_s, zeros, zeros, np.zeros((gaps.m, n_force))]),
        gap0=gaps.gap0,
        stiffness=np.where(np.isfinite(gaps.stiffness), gaps.stiffness, HARD * behind),
        tangent=T,
        tangent_sig=np.hstack([0.0 * T_s, T_s, 0.0 * T_s, np.zeros((2 * rubs.size, n_force))]),
        rubs=rubs,
        side=side,
        mu=mu,
        start=np.array([np.zeros(omega.size), Phi.T @ (M @ system.velocity)]),
    )
    return Full(modes, gaps, signals, spacing, 1.0 / (IN_FLIGHT * fastest), end, light.size)


def massless(system: System, M: FloatArray) -> FloatArray:
    """Rows of dofs without mass."""
    diagonal = M.diagonal()
    turning = (system.coordinates % 6) >= 3
    largest = np.array([diagonal[~turning].max(initial=0.0), diagonal[turning].max(initial=0.0)])
    return np.flatnonzero(diagonal <= MASSLESS * largest[turning.astype(int)])


def damping_of(
    setup: Setup, system: System, omega: FloatArray, Phi: FloatArray, by_support: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """(n_mode,) damping of each mode, rad/s, and (n_mode, n_support) its force by the rate of the supports.

    As the study says it: a share of critical is that of every mode, of the motion relative to what the supports carry
    along without inertia; Rayleigh's is alpha M + beta K.

    Raises
    ------
    ValueError : it couples the modes, or is of two kinds.
    """
    M, K = to_dense(system.M), to_dense(system.K)
    sup, zeta, d = system.supports, setup.structure.modal, system.damping
    if zeta is not None:
        if d.extra is not None:
            raise ValueError("dashpots beside modal damping")
        c = 2.0 * shares_at(zeta, omega**2) * omega
        carried = -np.linalg.solve(K, to_dense(sup.K_qs)) if sup.count else np.zeros((system.n, 0))
        return c, c[:, None] * (Phi.T @ (M @ (carried - by_support)))
    C = d.alpha * M + d.beta * K + np.asarray(d.other(np.eye(system.n)))
    damped = Phi.T @ C @ Phi
    c = np.diag(damped).copy()
    size = np.maximum(np.sqrt(np.outer(np.abs(c), np.abs(c))), 1e-3 * np.abs(c).max() + 1e-300)
    if c.any() and (np.abs(damped - np.diag(c)) / size).max() > DIAGONAL:
        raise ValueError("damping couples the modes")
    C_qs = d.alpha * to_dense(sup.M_qs) + d.beta * to_dense(sup.K_qs) + sup.C_qs
    return c, -Phi.T @ (C_qs + C @ by_support)
