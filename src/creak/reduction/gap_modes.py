"""Modes of the assembly and the static answer to each gap channel: the smallest basis with exact contact statics."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray, Matrix, to_dense
from creak.assembly.system import System
from creak.errors import InputError, NumericalError
from creak.linalg.diagonal import Diagonal
from creak.linalg.factor import Factor, factor, regular_factor
from creak.linalg.modes import RIGID, Modes, small_shift
from creak.linalg.modes import modes as lowest_modes
from creak.progress import Progress
from creak.reduction.modal import residual_shapes, riding_system, support_motion

COLUMNS = 128
"""Right-hand sides solved at a time."""
REFINEMENTS = 3
"""Solves with K + s M for one with K; each leaves s / (s + omega^2) of the error, omega beyond the modes."""


def gap_modes(
    system: System,
    G: Matrix,
    *,
    f_max: float | None = None,
    count: int | None = None,
    modes: Modes | None = None,
    stiffness: Factor | None = None,
    static: FloatArray | None = None,
    progress: Progress | None = None,
) -> System:
    """Reduce a System to its modes below `f_max` (Hz) and one residual-flexibility vector per gap channel.

    q = Phi eta + Z zeta + R s. Phi: modes with the channels open, Phi' M Phi = I. Z spans
    X = (I - Phi Phi' M) K^+ (I - M Phi Phi') G', made orthogonal in M and K, so that the modes stay exact modes of the
    result. R = -K^+ K_qs. The answer to static channel forces G' p is that of the full model, everywhere. On a
    structure that can move freely K^+ acts on the self-equilibrated forces (inertia relief), and the rigid-body
    modes are among Phi. The result has M = I and K diagonal unless there are dashpots.

    Parameters
    ----------
    G : (m, n) gap rows in the coordinates of the System, g = g0 + G q.
    f_max, count, modes : highest frequency (Hz), number of modes, or the modes themselves; one of them.
    stiffness : a factor of K; for a structure that can move freely, of K + s M with s = `small_shift(K, M)`.
    static : (n, k) static answers to applied forces, appended to the channels' (mode acceleration).

    Returns
    -------
    System; stats: modes, retained (residual vectors kept), dropped (near-dependent ones left out, see
    `modal.residual_shapes`), first_left_out (Hz, inf where it was not sought).

    Raises
    ------
    InputError : not exactly one of f_max, count and modes; G or static of the wrong size.
    NumericalError : the structure can move freely and not all its rigid-body modes are kept.

    Source: residual flexibility as in MacNeal, Computers & Structures 1, 1971, and Rubin, AIAA J. 13(8), 1975. Good up
    to about f_max / 2 between contacts; the residual shapes vibrate at frequencies of their own far above f_max, which
    the time step seldom resolves and which HHT damps.
    """
    _check_input(system, G, static, (f_max, count, modes))
    free = modes is not None and bool(np.any(modes.omega2 == 0.0))
    if stiffness is None and not free:
        stiffness = regular_factor(system.K)
        free = stiffness is None
    shift = small_shift(system.K, system.M) if free else 0.0
    if stiffness is None:
        stiffness = factor(system.K + shift * system.M)
    if modes is None:
        modes = _modes(system, f_max, count, free, stiffness, progress)
    static = np.zeros((system.n, 0)) if static is None else static
    solver = _ResidualSolver(system, modes, stiffness, shift)
    forces = np.asfortranarray(to_dense(G).T)
    rest = solver.rest(forces, progress)
    energy = np.einsum("ij,ij->j", forces, rest) + solver.modal_energy(forces)
    energy = np.concatenate([energy, np.einsum("ij,ij->j", static, to_dense(system.K @ static))])
    rest = np.hstack([rest, solver.without_modes(static)])
    support = solver.answer(-to_dense(system.supports.K_qs)) if free else support_motion(system, stiffness)
    residual = residual_shapes(system, modes, rest, energy)
    name = f"{system.name}, {modes.omega2.size} modes and {residual.mu.size} gap modes"
    return riding_system(system, modes, support, residual, name)


def _check_input(system: System, G: Matrix, static: FloatArray | None, choice: tuple[object, ...]) -> None:
    given = sum(c is not None for c in choice)
    if given != 1:
        raise InputError(f"{given} of f_max, count and modes are given", expected="one", where=system.name)
    if G.shape[1] != system.n:
        raise InputError(
            f"the gap rows have {G.shape[1]} columns",
            expected=f"{system.n}, the coordinates",
            where=system.name,
            fix="Multiply them with system.rows(labels)[0].",
        )
    if static is not None and static.shape[0] != system.n:
        raise InputError(f"static has {static.shape[0]} rows", expected=f"{system.n}", where=system.name)


def _modes(
    system: System, f_max: float | None, count: int | None, free: bool, stiffness: Factor, progress: Progress | None
) -> Modes:
    if isinstance(system.K, Diagonal) and isinstance(system.M, Diagonal):
        m = system.M.d
        omega2 = np.where(m > 0.0, system.K.d / np.where(m > 0.0, m, 1.0), np.inf)
        order = np.argsort(omega2, kind="stable")
        limit = np.inf if f_max is None else (2.0 * np.pi * f_max) ** 2
        order = order[np.isfinite(omega2[order])]
        kept = int(np.count_nonzero(omega2[order] <= limit)) if count is None else min(count, order.size)
        beyond = float(omega2[order[kept]]) if kept < order.size else np.inf
        order = order[:kept]
        shapes = np.zeros((system.K.d.size, order.size))
        shapes[order, np.arange(order.size)] = 1.0 / np.sqrt(m[order])
        return Modes(omega2[order], shapes, 0.0, True, next_omega2=beyond)

    def report(done: int, total: int) -> None:
        if progress is not None:
            progress(f"{system.name}: modes", done, total)

    return lowest_modes(
        system.K, system.M, f_max=f_max, count=count, free=free, stiffness_factor=stiffness, progress=report
    )


class _ResidualSolver:
    """Static answers beyond the modes: (I - Phi Phi' M) K^+ (I - M Phi Phi') f.

    With rigid-body modes the factor is that of K + s M, and K x = f is reached by iterative refinement.
    """

    def __init__(self, system: System, modes: Modes, stiffness: Factor, shift: float) -> None:
        self._system, self._modes, self._stiffness, self._shift = system, modes, stiffness, shift
        self._MPhi = np.asarray(system.M @ modes.shapes)
        if shift > 0.0:
            self._check_rigid_modes()

    def without_modes(self, x: FloatArray) -> FloatArray:
        return np.asarray(x - self._modes.shapes @ (self._MPhi.T @ x))

    def modal_energy(self, forces: FloatArray) -> FloatArray:
        """(k,) f' Phi omega^-2 Phi' f of the elastic modes."""
        elastic = self._modes.omega2 > 0.0
        return np.asarray(((self._modes.shapes.T @ forces) ** 2)[elastic].T @ (1.0 / self._modes.omega2[elastic]))

    def answer(self, forces: FloatArray) -> FloatArray:
        """K^+ f, the modal part included, (n, k)."""
        elastic = self._modes.omega2 > 0.0
        Phi, omega2 = self._modes.shapes[:, elastic], self._modes.omega2[elastic]
        return self.rest(forces, None) + Phi @ ((Phi.T @ forces) / omega2[:, None])

    def rest(self, forces: FloatArray, progress: Progress | None) -> FloatArray:
        """The answer less its modal part, (n, k), `COLUMNS` forces at a time."""
        k = forces.shape[1]
        x = np.empty(forces.shape, order="F")
        for start in range(0, k, COLUMNS):
            here = slice(start, min(start + COLUMNS, k))
            x[:, here] = self._solve(forces[:, here])
            if progress is not None:
                progress(f"{self._system.name}: residual flexibility", here.stop, k)
        return x

    def _solve(self, forces: FloatArray) -> FloatArray:
        left = forces - self._MPhi @ (self._modes.shapes.T @ forces)
        x = self._once(left)
        for _ in range(REFINEMENTS - 1 if self._shift > 0.0 else 0):
            x += self._once(left - np.asarray(self._system.K @ x))
        return x

    def _once(self, forces: FloatArray) -> FloatArray:
        return self.without_modes(self._stiffness.solve(np.asfortranarray(forces)))

    def _check_rigid_modes(self) -> None:
        """Inverse iteration beyond the modes must not find another motion without stiffness."""
        M, K = self._system.M, self._system.K
        x = np.random.default_rng(11).standard_normal((self._system.n, 1))
        for _ in range(2):
            x = self._once(np.asarray(M @ self.without_modes(x)))
            x /= max(float(np.abs(x).max()), np.finfo(float).tiny)
        mass, stiffness = float(np.vdot(x, M @ x)), float(np.vdot(x, K @ x))
        if self._modes.omega2.size < self._system.n and stiffness < RIGID * self._shift * mass:
            raise NumericalError(
                f"{self._system.name} can move freely, and the {self._modes.omega2.size} modes kept do not hold all "
                "its rigid-body motion: keep at least six modes per loose body"
            )
