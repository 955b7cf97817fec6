"""The state of a run and the linear terms of its equation of motion.

K u, K v and K a are carried along with u, v and a, so that a step needs one product with K and one with M.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray
from creak.assembly.system import System, to_dense
from creak.dynamics.loads import Loads
from creak.dynamics.scheme import Scheme
from creak.dynamics.step_matrix import StepFactor, rayleigh_weights
from creak.linalg.diagonal import Diagonal


@dataclass
class State:
    """Displacement, velocity, acceleration (n,) and their products with K and M."""

    u: FloatArray
    v: FloatArray
    a: FloatArray
    Ku: FloatArray
    Kv: FloatArray
    Ka: FloatArray
    Mv: FloatArray
    Ma: FloatArray
    Cv: FloatArray


@dataclass
class Predictor:
    """The state at the end of a step before its acceleration is known."""

    u: FloatArray
    v: FloatArray
    Ku: FloatArray
    Kv: FloatArray
    Mv: FloatArray
    Cv: FloatArray


class LinearTerms:
    """M, C, K, supports and forces of a System under given loads."""

    def __init__(self, system: System, loads: Loads) -> None:
        self.system, self.loads = system, loads
        sup, d = system.supports, system.damping
        self.M_qs, self.K_qs = np.asarray(sup.M_qs), np.asarray(sup.K_qs)
        self.C_qs = d.alpha * self.M_qs + d.beta * self.K_qs + sup.C_qs
        self.C_ss = d.alpha * sup.M_ss + d.beta * sup.K_ss + sup.C_ss
        n_force = len(loads.force_labels)
        self.B, self.B_s = np.zeros((system.n, n_force)), np.zeros((sup.count, n_force))
        for j, labels in enumerate(loads.force_labels):
            R, R_s = system.rows(labels)
            self.B[:, j] = np.asarray(R.sum(axis=0)).ravel()
            self.B_s[:, j] = np.asarray(R_s.sum(axis=0)).ravel()
        self.forced = bool(n_force)
        self._simple = d.is_rayleigh
        self._derives = self._simple and sp.issparse(system.M)

    def damped(self, v: FloatArray, Mv: FloatArray, Kv: FloatArray) -> FloatArray:
        """C v from M v and K v."""
        d = self.system.damping
        Cv = d.alpha * Mv + d.beta * Kv
        return Cv if self._simple else Cv + d.other(v)

    def external(self, row: int, support: FloatArray) -> FloatArray:
        """f - C_qs s' - K_qs s at an instant (the inertia of the supports is weighted like M a)."""
        f = -(self.C_qs @ support[1] + self.K_qs @ support[0])
        return f + self.B @ self.loads.force[row] if self.forced else f

    def start(self, solver: StepFactor, scheme: Scheme, contact: FloatArray) -> State:
        """At rest or with the System's initial velocity, and the acceleration under loads and `contact` forces (n,)."""
        K, M, support = self.system.K, self.system.M, self.loads.support[:, 0]
        u, v = self.inside_at_rest(0), self.system.velocity + self.inside_at_rest(1)
        Ku, Kv, Mv = np.asarray(K @ u), np.asarray(K @ v), np.asarray(M @ v)
        Cv = self.damped(v, Mv, Kv)
        pull = self.external(0, support) + contact - Cv - Ku - self.M_qs @ support[2]
        a = (1.0 - scheme.alpha_m) * solver.solve(pull)
        return State(u, v, a, Ku, Kv, np.asarray(K @ a), Mv, np.asarray(M @ a), Cv)

    def inside_at_rest(self, order: int) -> FloatArray:
        """Coordinates that hold the inside of reduced parts at rest while the supports start with s or s'.

        M q = (M_start - M_qs) s: the M-orthogonal projection of the full model's start; 0 in a full model and for
        coordinates without mass.
        """
        drag = to_dense(self.system.supports.M_start) - self.M_qs
        momentum = drag @ self.loads.support[order, 0]
        if not momentum.any():
            return np.zeros(self.system.n)
        M = self.system.M
        if isinstance(M, Diagonal):
            heavy = M.d > 0.0
            return np.where(heavy, momentum / np.where(heavy, M.d, 1.0), 0.0)
        return np.asarray(np.linalg.lstsq(to_dense(M), momentum, rcond=None)[0])

    def predict(self, x: State, scheme: Scheme, h: float) -> Predictor:
        """u + h v + h^2 (1/2 - beta) a and v + h (1 - gamma) a, with their products."""
        c_u, c_v = h * h * (0.5 - scheme.beta), h * (1.0 - scheme.gamma)
        v, Kv, Mv = x.v + c_v * x.a, x.Kv + c_v * x.Ka, x.Mv + c_v * x.Ma
        u, Ku = x.u + h * x.v + c_u * x.a, x.Ku + h * x.Kv + c_u * x.Ka
        return Predictor(u, v, Ku, Kv, Mv, self.damped(v, Mv, Kv))

    def right_side(
        self, x: State, half: Predictor, scheme: Scheme, external: tuple[FloatArray, FloatArray],
        inertia: tuple[FloatArray, FloatArray], contact: FloatArray | None,
    ) -> FloatArray:  # fmt: skip
        """r of S a1 = r without channel forces at the end of the step.

        Parameters
        ----------
        external, inertia : (n,) `external` and M_qs s'' at the step's beginning and end.
        contact : (n,) channel forces at its beginning; None: none.
        """
        af, am = scheme.alpha_f, scheme.alpha_m
        r = (1.0 - af) * (external[1] - half.Cv - half.Ku) - (1.0 - am) * inertia[1]
        if af != 0.0:
            before = external[0] - x.Cv - x.Ku
            r += af * (before if contact is None else before + contact)
        if am != 0.0:
            r -= am * (x.Ma + inertia[0])
        return r

    def advance(
        self, half: Predictor, a: FloatArray, scheme: Scheme, h: float, fresh: bool, Sa: FloatArray | None = None
    ) -> State:
        """The state at the end of the step; `fresh`: products computed anew, so that round-off does not pile up.

        With S a known (the right side of the step), M a = (S a - c_K K a) / c_M saves a product with a sparse M. It
        loses digits only where stiffness outweighs inertia within a step, and such motion has no M a to speak of.
        """
        K, M = self.system.K, self.system.M
        c_u, c_v = scheme.beta * h * h, scheme.gamma * h
        Ka = np.asarray(K @ a)
        if Sa is None or fresh or not self._derives:
            Ma = np.asarray(M @ a)
        else:
            c_M, c_K = rayleigh_weights(self.system, scheme, h)
            Ma = (Sa - c_K * Ka) / c_M
        u, v = half.u + c_u * a, half.v + c_v * a
        if fresh:
            Ku, Kv, Mv = np.asarray(K @ u), np.asarray(K @ v), np.asarray(M @ v)
        else:
            Ku, Kv, Mv = half.Ku + c_u * Ka, half.Kv + c_v * Ka, half.Mv + c_v * Ma
        return State(u, v, a, Ku, Kv, Ka, Mv, Ma, self.damped(v, Mv, Kv))
