"""Energy balance of a run: nothing is created, and what is lost is accounted for."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.contact.gap_operator import GapOperator
from creak.contact.step_problem import damper_work
from creak.dynamics.books import (
    CONTACT,
    CONTACT_DAMPING,
    DAMPING,
    EXTERNAL,
    FRICTION,
    KINETIC,
    SCHEME,
    STRAIN,
    balance,
    in_channels,
    new_book,
    open_book,
)
from creak.dynamics.channels import ChannelMatrices
from creak.dynamics.instant import AuditState, Boundary, Instant
from creak.dynamics.state import LinearTerms


class EnergyAudit:
    """Kinetic, strain and contact energy, work of dampers, friction and of the outside, at every step.

    Works are trapezoidal: dW = 1/2 (F0 + F1) . (u1 - u0), which is exact for Newmark's average acceleration
    on a linear system; the remainder `scheme` is then the dissipation of the scheme and of contact impacts in it.
    A step that brings its own works (`Instant.works`: a flight, by the quadrature of its stages) is booked with those.
    Work at the supports is that of the reaction, C_sq v + K_sq u + ... - G_s' p, and of its inertia as the change of
    momentum M_sq v + M_ss s'. The accelerations of the scheme would not do: they are those of a time (gamma - 1/2) h
    before the instant (Erlicher, Bonaventura, Bursi, Comput. Mech. 28, 2002), and how much of the reaction is inertia
    depends on the coordinates.
    """

    def __init__(self, terms: LinearTerms, gaps: GapOperator, on: ChannelMatrices) -> None:
        self._t, self._gaps, self._on, self._laws = terms, gaps, on, gaps.laws
        self._rows_s = np.vstack([on.G_s, on.T_s])
        self._balanced = np.zeros(gaps.m) if gaps.preload is None else gaps.preload
        self._preload = on.G_s.T @ self._balanced
        self._held = gaps.resting[gaps.m :]
        self._holds, self._damps, self._rubs = bool(self._held.any()), gaps.has_dampers, gaps.rubbing > 0
        self._book = new_book()

    def start(self, now: Instant) -> FloatArray:
        """Take the energy of the first instant as given; returns its row of the table."""
        e = self._book
        self._forces, carried = self._boundary(now)
        e[KINETIC], e[STRAIN], e[CONTACT] = self._stored(now, carried)
        open_book(e)
        return e[: SCHEME + 1].copy()

    @property
    def state(self) -> AuditState:
        return AuditState(self._book, self._forces)

    def resume(self, state: AuditState) -> None:
        """Go on where another one was."""
        self._book, self._forces = state.book, state.forces

    def step(self, before: Instant, now: Instant) -> FloatArray:
        """Book one step; returns its row of the table, (len(ENERGIES),)."""
        e, forces = self._book, self._forces
        self._forces, carried = self._boundary(now)
        du, ds = now.x.u - before.x.u, now.support[0] - before.support[0]
        if now.works is None:
            damping, external = self._trapezoidal(before, now, forces, du, ds)
        else:
            damping, external = now.works.damping, now.works.external
        e[DAMPING] += damping
        e[EXTERNAL] += external
        if self._holds:
            e[EXTERNAL] -= float(self._held @ (self._on.T @ du))
        if self._damps:
            e[CONTACT_DAMPING] += float(damper_work(self._laws, before.gap, now.gap, now.force))
        if self._rubs and (now.tau.any() or before.tau.any()):
            slid = np.asarray(self._on.T @ du + self._on.T_s @ ds)
            e[FRICTION] -= 0.5 * float((before.tau + now.tau) @ slid)
        e[KINETIC], e[STRAIN], e[CONTACT] = self._stored(now, carried)
        balance(e)
        return e[: SCHEME + 1].copy()

    def _trapezoidal(
        self, before: Instant, now: Instant, forces: Boundary, du: FloatArray, ds: FloatArray
    ) -> tuple[float, float]:
        """Work of dampers and of the outside in a step with the boundary `forces` at its beginning."""
        (damper0, reaction0, momentum0, force0), (damper1, reaction1, momentum1, force1) = forces, self._forces
        h = (now.row - before.row) * self._t.loads.step
        damping = 0.5 * float((before.x.Cv + now.x.Cv) @ du)
        damping += 0.5 * float((damper0[0] + damper1[0]) @ du[self._t.driven] + (damper0[1] + damper1[1]) @ ds)
        external = float((0.5 * (reaction0 + reaction1) + (momentum1 - momentum0) / h) @ ds)
        if self._t.forced:
            external += 0.5 * float((force0 + force1) @ (self._t.B.T @ du[self._t.driven] + self._t.B_s.T @ ds))
        return damping, external

    def _stored(self, now: Instant, carried: tuple[float, float]) -> tuple[float, float, float]:
        """Kinetic, strain and contact energy; `carried`: kinetic and strain energy that the supports take part in."""
        x = now.x
        if now.works is None:
            kinetic, strain = 0.5 * float(x.v @ x.Mv), 0.5 * float(x.u @ x.Ku)
        else:
            kinetic, strain = now.works.kinetic, now.works.strain
        contact = float(in_channels(self._laws, self._balanced, self._gaps.gap0, now.gap))
        return kinetic + carried[0], strain + carried[1], contact

    def _boundary(self, now: Instant) -> tuple[Boundary, tuple[float, float]]:
        """What acts at the boundary, and the kinetic and strain energy that the supports take part in."""
        s, s_dot = now.support[:2]
        sup, t, x = self._t.system.supports, self._t, now.x
        force = t.loads.force[now.row]
        u, v = x.u[t.driven], x.v[t.driven]
        momentum, pull, own_momentum, own_pull = t.M_qs.T @ v, t.K_qs.T @ u, sup.M_ss @ s_dot, sup.K_ss @ s
        damper = (np.dot(t.C_qs, s_dot), t.C_qs.T @ v + t.C_ss @ s_dot)
        reaction = pull + own_pull + damper[1] - self._rows_s.T @ now.force + self._preload - t.B_s @ force
        carried = float(s_dot @ (momentum + 0.5 * own_momentum)), float(s @ (pull + 0.5 * own_pull))
        return (damper, reaction, momentum + own_momentum, force), carried
