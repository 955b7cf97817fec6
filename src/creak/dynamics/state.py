"""The state of a run and the linear terms of its equation of motion.

K u, K v and K a are carried along with u, v and a, so that a step needs one product with K and one with M. The vectors
of a step are read and written once (`vector_kernels`): in a large model they cost as much memory traffic as that.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray, to_dense
from creak.assembly.system import System, rows_with_entries
from creak.dynamics.loads import Loads
from creak.dynamics.scheme import Scheme
from creak.dynamics.step_matrix import rayleigh_weights
from creak.dynamics.vector_kernels import correct, predict
from creak.linalg.diagonal import Diagonal
from creak.linalg.together import Solver


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
    """The state at the end of a step before its acceleration is known; `LinearTerms.advance` completes it in place."""

    u: FloatArray
    v: FloatArray
    Ku: FloatArray
    Kv: FloatArray
    Mv: FloatArray


@dataclass(frozen=True)
class Outside:
    """What acts from outside at an instant, (k,) on the `driven` coordinates."""

    load: FloatArray
    """f - C_qs s' - K_qs s"""
    inertia: FloatArray
    """M_qs s'', which the scheme weights like M a."""


class LinearTerms:
    """M, C, K, supports and forces of a System under given loads.

    Raises
    ------
    InputError : a force acts on a dof that has neither stiffness nor mass.
    """

    driven: IntArray | slice
    """(k,) coordinates that supports or forces act on: few in a full model, a slice where it is all of them. M_qs,
    C_qs, K_qs (k, n_support) and B (k, n_force) have these rows."""

    def __init__(self, system: System, loads: Loads) -> None:
        self.system, self.loads = system, loads
        sup, d = system.supports, system.damping
        self.C_ss = d.alpha * sup.M_ss + d.beta * sup.K_ss + sup.C_ss
        n_force = len(loads.force_labels)
        B, self.B_s = np.zeros((system.n, n_force)), np.zeros((sup.count, n_force))
        for j, labels in enumerate(loads.force_labels):
            if system.bear is not None:
                system.bear(labels)
            R, R_s = system.rows(labels)
            B[:, j] = np.asarray(R.sum(axis=0)).ravel()
            self.B_s[:, j] = np.asarray(R_s.sum(axis=0)).ravel()
        acted = [rows_with_entries(side) for side in (sup.M_qs, sup.C_qs, sup.K_qs, B)]
        some = np.flatnonzero(np.any(acted, axis=0))
        self.driven = some if some.size < system.n else slice(None)
        M_qs, C_qs, K_qs = (to_dense(side[self.driven]) for side in (sup.M_qs, sup.C_qs, sup.K_qs))
        sides = (M_qs, d.alpha * M_qs + d.beta * K_qs + C_qs, K_qs, B[self.driven])
        self.M_qs, self.C_qs, self.K_qs, self.B = (np.asfortranarray(side) for side in sides)
        self.forced = bool(n_force)
        self._simple = d.is_rayleigh
        self._derives = self._simple and sp.issparse(system.M)

    def on_all(self, side: FloatArray) -> FloatArray:
        """(n, j) from rows of the driven coordinates."""
        whole = np.zeros((self.system.n, side.shape[1]))
        whole[self.driven] = side
        return whole

    def outside(self, row: int, support: FloatArray) -> Outside:
        """Loads at row `row` with the supports' motion (3, n_support)."""
        f = -(np.dot(self.C_qs, support[1]) + np.dot(self.K_qs, support[0]))  # `@` is slow with a single column
        if self.forced:
            f += np.dot(self.B, self.loads.force[row])
        return Outside(f, np.dot(self.M_qs, support[2]))

    def under(self, loads: Loads) -> LinearTerms:
        """The same with other loads."""
        other = copy.copy(self)
        other.loads = loads
        return other

    def at_start(self) -> tuple[FloatArray, FloatArray]:
        """Displacement and velocity (n,) at rest, or with the System's initial velocity."""
        return self.inside_at_rest(0), self.system.velocity + self.inside_at_rest(1)

    def start(
        self, solver: Solver, scheme: Scheme, contact: FloatArray, begins: tuple[FloatArray, FloatArray]
    ) -> State:
        """The state of displacement and velocity `begins`, its acceleration under loads and `contact` forces (n,)."""
        K, M = self.system.K, self.system.M
        u, v = begins
        Ku, Kv, Mv = np.asarray(K @ u), np.asarray(K @ v), np.asarray(M @ v)
        Cv = self.damped(v, Mv, Kv)
        now = self.outside(0, self.loads.support[:, 0])
        pull = contact - Cv - Ku
        pull[self.driven] += now.load - now.inertia
        a = (1.0 - scheme.alpha_m) * solver.solve(pull)
        return State(u=u, v=v, a=a, Ku=Ku, Kv=Kv, Ka=np.asarray(K @ a), Mv=Mv, Ma=np.asarray(M @ a), Cv=Cv)

    def inside_at_rest(self, order: int) -> FloatArray:
        """Coordinates that hold the inside of reduced parts at rest while the supports start with s or s'.

        M q = (M_start - M_qs) s: the M-orthogonal projection of the full model's start; 0 in a full model and for
        coordinates without mass.
        """
        sup, M = self.system.supports, self.system.M
        if sup.M_start is sup.M_qs:
            return np.zeros(self.system.n)
        momentum = (to_dense(sup.M_start) - to_dense(sup.M_qs)) @ self.loads.support[order, 0]
        if not momentum.any():
            return np.zeros(self.system.n)
        if isinstance(M, Diagonal):
            heavy = M.d > 0.0
            return np.where(heavy, momentum / np.where(heavy, M.d, 1.0), 0.0)
        return np.asarray(np.linalg.lstsq(to_dense(M), momentum, rcond=None)[0])

    def begin(self, x: State, scheme: Scheme, h: float, ends: tuple[Outside, Outside]) -> tuple[Predictor, FloatArray]:
        """The step's end without its acceleration, and r of S a1 = r without channel forces.

        u + h v + h^2 (1/2 - beta) a and v + h (1 - gamma) a with their products, and
        r = (1 - af)(f1 - C v - K u) + af (f0 - C v0 - K u0) - (1 - am) M_qs s1'' - am (M a0 + M_qs s0'').

        Parameters
        ----------
        ends : what acts from outside at the step's beginning and end.
        """
        af, am, d = scheme.alpha_f, scheme.alpha_m, self.system.damping
        to_motion = h * h * (0.5 - scheme.beta), h * (1.0 - scheme.gamma)
        products = x.Ku, x.Kv, x.Ka, x.Mv, x.Ma, x.Cv
        *half, r = predict((x.u, x.v, x.a), products, h, to_motion, (d.alpha, d.beta), (af, am))
        before, after = ends
        r[self.driven] += (1.0 - af) * after.load + af * before.load - (1.0 - am) * after.inertia - am * before.inertia
        predictor = Predictor(*half)
        if not self._simple:
            r -= (1.0 - af) * d.other(predictor.v)
        return predictor, r

    def advance(
        self, half: Predictor, a: FloatArray, scheme: Scheme, h: float, fresh: bool, Sa: FloatArray | None = None
    ) -> State:
        """The state at the end of the step, in the vectors of `half`.

        With S a known (the right side of the step), M a = (S a - c_K K a) / c_M saves a product with a sparse M. It
        loses digits only where stiffness outweighs inertia within a step, and such motion has no M a to speak of.

        Parameters
        ----------
        fresh : compute the products anew, so that round-off does not pile up.
        """
        K, M, d = self.system.K, self.system.M, self.system.damping
        Ka = np.asarray(K @ a)
        c_M, c_K = 1.0, 0.0
        if Sa is not None and self._derives and not fresh:
            Ma = Sa
            c_M, c_K = rayleigh_weights(self.system, scheme, h)
        else:
            Ma = np.asarray(M @ a)
        to_motion, moved = (scheme.beta * h * h, scheme.gamma * h), (half.u, half.v, half.Ku, half.Kv, half.Mv)
        Ma, Cv = correct(moved, (a, Ka, Ma), to_motion, (c_M, c_K), (d.alpha, d.beta))
        x = State(u=half.u, v=half.v, a=a, Ku=half.Ku, Kv=half.Kv, Ka=Ka, Mv=half.Mv, Ma=Ma, Cv=Cv)
        if fresh:
            x.Ku, x.Kv, x.Mv = np.asarray(K @ x.u), np.asarray(K @ x.v), np.asarray(M @ x.v)
            x.Cv = self.damped(x.v, x.Mv, x.Kv)
        elif not self._simple:
            x.Cv += d.other(x.v)
        return x

    def damped(self, v: FloatArray, Mv: FloatArray, Kv: FloatArray) -> FloatArray:
        """C v from M v and K v, (n,) or (n, k)."""
        d = self.system.damping
        Cv = d.alpha * Mv + d.beta * Kv
        return Cv if self._simple else Cv + d.other(v)
