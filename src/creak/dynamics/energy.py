"""Energy balance of a run: nothing is created, and what is lost is accounted for."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from creak.arrays import FloatArray, Matrix
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import ENERGIES
from creak.dynamics.loads import Loads
from creak.dynamics.state import LinearTerms, State


class OnCoordinates(Protocol):
    """Channel rows on coordinates and supports."""

    @property
    def G(self) -> Matrix: ...

    @property
    def G_s(self) -> FloatArray: ...


class EnergyAudit:
    """Kinetic, strain and contact energy, work of dampers and of the outside, at every step.

    Works are trapezoidal: dW = 1/2 (F0 + F1) . (u1 - u0), which is exact for Newmark's average acceleration
    on a linear system; the remainder `scheme` is then the dissipation of HHT and of contact impacts in it.
    Work at the supports is that of the reaction, M_sq a + M_ss s'' + C_sq v + ... - G_s' p.
    """

    def __init__(self, terms: LinearTerms, gaps: GapOperator, on: OnCoordinates, loads: Loads) -> None:
        self._t, self._gaps, self._on, self._loads = terms, gaps, on, loads
        self._table = np.zeros((loads.time.size, len(ENERGIES)))
        self._damping = self._contact_damping = self._external = 0.0
        self._initial = 0.0

    def start(self, x: State, gap: FloatArray, p: FloatArray) -> None:
        """Take the energy of the first instant as given."""
        stored = self._stored(0, x, gap)
        self._initial = sum(stored)
        self._table[0, :3] = stored
        self._forces = self._boundary(0, x, p)
        self._gap = gap

    def step(self, step: int, x0: State, x1: State, gap: FloatArray, p0: FloatArray, p1: FloatArray) -> float:
        """Book one step that led from x0 to x1; `gap` and `p1` at its end, `p0` at its start.

        Returns the stored energy at its end.
        """
        before, after = self._forces, self._boundary(step, x1, p1)
        self._forces = after
        du = x1.u - x0.u
        ds = self._loads.support[0, step] - self._loads.support[0, step - 1]
        damper0, reaction0, force0 = before
        damper1, reaction1, force1 = after
        self._damping += 0.5 * float((damper0[0] + damper1[0]) @ du + (damper0[1] + damper1[1]) @ ds)
        self._external += 0.5 * float((reaction0 + reaction1) @ ds)
        if self._t.forced:
            self._external += 0.5 * float((force0 + force1) @ (self._t.B.T @ du + self._t.B_s.T @ ds))
        if self._gaps.damping.any():
            self._contact_damping += self._dampers_of_channels(step, gap, p1)
        stored = self._stored(step, x1, gap)
        spent = self._damping + self._contact_damping
        scheme = self._external + self._initial - sum(stored) - spent
        self._table[step] = [*stored, self._damping, self._contact_damping, self._external, scheme]
        self._gap = gap
        return sum(stored)

    def table(self) -> FloatArray:
        """(n_time, len(ENERGIES))"""
        return self._table

    def _stored(self, step: int, x: State, gap: FloatArray) -> tuple[float, float, float]:
        s, s_dot = self._loads.support[0, step], self._loads.support[1, step]
        sup, t = self._t.system.supports, self._t
        kinetic = 0.5 * x.v @ x.Mv + x.v @ (t.M_qs @ s_dot) + 0.5 * s_dot @ sup.M_ss @ s_dot
        strain = 0.5 * x.u @ x.Ku + x.u @ (t.K_qs @ s) + 0.5 * s @ sup.K_ss @ s
        closed = np.minimum(gap, 0.0)
        return float(kinetic), float(strain), 0.5 * float(self._gaps.stiffness @ closed**2)

    def _boundary(
        self, step: int, x: State, p: FloatArray
    ) -> tuple[tuple[FloatArray, FloatArray], FloatArray, FloatArray]:
        """Damper forces (on q, on s), reaction of the supports, applied forces."""
        s, s_dot, s_ddot = self._loads.support[:, step]
        sup, t, force = self._t.system.supports, self._t, self._loads.force[step]
        damper = (x.Cv + t.C_qs @ s_dot, t.C_qs.T @ x.v + t.C_ss @ s_dot)
        reaction = t.M_qs.T @ x.a + sup.M_ss @ s_ddot + t.K_qs.T @ x.u + sup.K_ss @ s + damper[1]
        reaction = reaction - self._on.G_s.T @ p - t.B_s @ force
        return damper, reaction, force

    def _dampers_of_channels(self, step: int, gap: FloatArray, p: FloatArray) -> float:
        """Work that the channel dampers took in the step (backward rule: they act at its end).

        Also where a spring that unloads faster than its damper lets it go presses no more (p = 0, g < 0).
        """
        viscous = p - self._gaps.stiffness * np.maximum(0.0, -gap)
        return float(viscous @ (self._gap - gap))
