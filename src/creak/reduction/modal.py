"""Modes of the whole assembly, riding on the quasi-static motion of the supports; their effective mass and
participation in the six rigid-body directions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg as sla

from creak.arrays import FloatArray, IntArray, Matrix, to_dense
from creak.assembly.damping import Damping
from creak.assembly.system import System, project
from creak.linalg.dense_product import symmetric
from creak.linalg.diagonal import Diagonal
from creak.linalg.factor import Factor
from creak.linalg.modes import Modes
from creak.model.mesh import Nodes, rigid_vectors

RANK = 1e-12
"""Static answers whose strain energy falls below this share of that of the loads they come from are left out."""
MASSLESS = 1e-13
"""Residual shapes with less kinetic than strain energy by this factor, relative to the heaviest, have no mass."""

ROUND_OFF = 1e-9
"""Modal damping below this share of that of the highest mode is none."""


SAME_MODE = 0.05
"""Relative distance up to which the mode of one model is that of another, reduced one."""


@dataclass(frozen=True)
class ModalShares:
    """Shares of critical damping by mode: those near some frequencies, and one of all others; or a curve over them."""

    freq: FloatArray
    """(k,) Hz, rising."""
    zeta: FloatArray
    """(k,)"""
    other: float
    curve: bool = False
    """All modes take the straight lines between the points, and beyond these the values at the ends."""

    def at(self, omega2: FloatArray) -> FloatArray:
        """(n_mode,) share of each mode: of the frequency that is nearest, within `SAME_MODE`, each taken once."""
        if self.curve:
            return np.asarray(np.interp(np.sqrt(np.maximum(omega2, 0.0)) / (2.0 * np.pi), self.freq, self.zeta))
        freq, found = np.sqrt(np.maximum(omega2, 0.0)) / (2.0 * np.pi), np.full(omega2.size, self.other)
        off = np.abs(freq[:, None] / self.freq - 1.0)
        while off.size and off.min() <= SAME_MODE:
            k, j = np.unravel_index(int(off.argmin()), off.shape)
            found[k] = self.zeta[j]
            off[k], off[:, j] = np.inf, np.inf
        return found

    def times(self, factor: float, most: float) -> ModalShares:
        """All shares times a factor, up to a largest one."""
        return replace(self, zeta=np.minimum(factor * self.zeta, most), other=min(factor * self.other, most))


ModalDamping = float | ModalShares
"""Share of critical damping: of all modes, or of each."""


def shares_at(zeta: ModalDamping, omega2: FloatArray) -> FloatArray:
    """(n_mode,) share of critical damping of each mode."""
    return zeta.at(omega2) if isinstance(zeta, ModalShares) else np.full(omega2.size, zeta)


def one_share(zeta: ModalDamping | None) -> float | None:
    """One share for all modes, where one is asked for."""
    return zeta.other if isinstance(zeta, ModalShares) else zeta


@dataclass(frozen=True)
class Residual:
    """What the modes leave over of static answers: Z' K Z = I, Z' M Z = diag(mu), Z' M Phi = 0, Z' K Phi = 0."""

    shapes: FloatArray
    """Z, (n, k)"""
    mu: FloatArray
    """(k,) 1 / omega^2 of each shape; 0 for shapes without mass."""
    dropped: int
    """Answers left out because the modes and the other answers already hold them."""


def support_motion(system: System, stiffness: Factor) -> FloatArray:
    """R = -K^-1 K_qs, (n, n_support): how the structure follows its supports without inertia."""
    if system.supports.count == 0:
        return np.zeros((system.n, 0))
    return -stiffness.solve(np.asfortranarray(system.supports.K_qs))


def residual_shapes(system: System, modes: Modes, rest: FloatArray, energy: FloatArray) -> Residual:
    """An orthonormal basis of what is left of static answers beyond the modes.

    Eigenvectors of D rest' K rest D, D = diag(energy)^-1/2, below `RANK` are dropped: loads that differ by such a
    combination deform the structure, within that share of their energy, as the modes do (near-dependent channels).

    Parameters
    ----------
    rest : (n, k) static answers less their modal part. energy : (k,) x' K x of the whole answers x.
    """
    Phi, MPhi = modes.shapes, np.asarray(system.M @ modes.shapes)
    used = np.flatnonzero(energy > 0.0)
    X = rest[:, used] / np.sqrt(energy[used])
    X = X - Phi @ (MPhi.T @ X)
    values, vectors = np.linalg.eigh(symmetric(X.T @ np.asarray(system.K @ X)))
    keep = values > RANK
    Z = X @ (vectors[:, keep] / np.sqrt(values[keep]))
    Z = Z - Phi @ (MPhi.T @ Z)
    stiffness, mass = (symmetric(Z.T @ np.asarray(A @ Z)) for A in (system.K, system.M))
    mu, mix = sla.eigh(mass, stiffness) if keep.any() else (np.zeros(0), np.zeros((0, 0)))
    mu = np.where(mu > MASSLESS * mu.max(initial=0.0), mu, 0.0)[::-1]
    return Residual(Z @ mix[:, ::-1], mu, int(rest.shape[1] - mu.size))


def riding_system(system: System, modes: Modes, R: FloatArray, residual: Residual, name: str) -> System:
    """The System in q = Phi eta + Z zeta + R s: M = diag(1.., 0..), K = diag(omega^2.., 1..).

    Residual shapes with mass are mass-normalised, those without are stiffness-normalised and have no initial
    velocity. Dashpots make the matrices dense, other damping leaves them diagonal.
    """
    heavy = residual.mu > 0.0
    size = np.where(heavy, np.sqrt(np.where(heavy, residual.mu, 1.0)), 1.0)
    V = np.hstack([modes.shapes, residual.shapes / size])
    n_modes = modes.omega2.size
    mass = np.concatenate([np.ones(n_modes), heavy.astype(float)])
    stiffness = np.concatenate([modes.omega2, 1.0 / size**2])
    M, K = Diagonal(mass), Diagonal(stiffness)
    small = project(replace(system, velocity=np.zeros(system.n)), V, static=R, name=name, known=(M, K))
    velocity = mass * np.asarray(V.T @ np.asarray(system.M @ system.velocity))
    dense = small.damping.extra is not None
    return replace(
        small,
        M=M.toarray() if dense else M,
        K=K.toarray() if dense else K,
        velocity=velocity,
        stats=replace(
            system.stats,
            modes=n_modes,
            retained=residual.mu.size,
            dropped=residual.dropped,
            first_left_out=float(np.sqrt(np.nan_to_num(modes.next_omega2, nan=np.inf, posinf=np.inf)) / (2.0 * np.pi)),
        ),
    )


def modal_system(system: System, modes: Modes, R: FloatArray, static: FloatArray) -> System:
    """The System in its lowest modes, q = V eta + R s: small, diagonal, good for a linear pre-check.

    V holds the modes and, made orthogonal to them, the `static` answers (n, k) to the applied forces
    (mode acceleration).
    """
    rest = static - modes.shapes @ (modes.shapes.T @ np.asarray(system.M @ static))
    energy = np.einsum("ij,ij->j", static, to_dense(system.K @ static))
    name = f"{system.name}, {modes.omega2.size} modes"
    return riding_system(system, modes, R, residual_shapes(system, modes, rest, energy), name)


def with_modal_damping(system: System, modes: Modes, R: FloatArray, zeta: ModalDamping, beyond: bool = False) -> System:
    """C = beta K + M Phi diag(2 zeta omega - beta omega^2) Phi' M on the motion relative to the supports.

    Dashpots stay. Every computed mode has its fraction zeta of critical; those that were not computed are undamped,
    beta = 0, unless asked for.

    Parameters
    ----------
    beyond : damp what was not computed in proportion to its stiffness, beta = 2 zeta / omega_b, omega_b the highest
        computed frequency: zeta omega / omega_b of critical, which goes on from zeta without a step. Of fractions by
        mode zeta is there the one of all others, of a curve its value at omega_b.
    """
    W = np.asarray(system.M @ modes.shapes)
    beta, d = modal_values(modes.omega2, zeta, beyond)
    keep = d != 0.0
    damping = Damping(0.0, beta, system.damping.extra, W[:, keep], d[keep])
    relative = R.T @ W[:, keep]
    sup = system.supports
    supports = replace(
        sup,
        C_qs=sup.C_qs - (W[:, keep] * d[keep]) @ relative.T,
        C_ss=sup.C_ss + (relative * d[keep]) @ relative.T,
    )
    return replace(system, damping=damping, supports=supports)


def without_modal_damping(system: System, R: FloatArray) -> System:
    """The System before `with_modal_damping`, its dashpots left."""
    d, sup = system.damping, system.supports
    if d.modal_shapes is None or d.modal_values is None:
        return system
    by = d.modal_shapes * d.modal_values
    relative = R.T @ d.modal_shapes
    supports = replace(sup, C_qs=sup.C_qs + by @ relative.T, C_ss=sup.C_ss - (relative * d.modal_values) @ relative.T)
    return replace(system, damping=Damping(extra=d.extra), supports=supports)


def modal_values(omega2: FloatArray, zeta: ModalDamping, beyond: bool) -> tuple[float, FloatArray]:
    """beta, and 2 zeta omega - beta omega^2 of each mode, 0 where it is round-off; see `with_modal_damping`."""
    omega = np.sqrt(omega2)
    top = float(omega.max(initial=0.0))
    each, most = (zeta.at(omega2), zeta.zeta.max()) if isinstance(zeta, ModalShares) else (zeta, zeta)
    last = float(zeta.at(np.array([top**2]))[0]) if isinstance(zeta, ModalShares) and zeta.curve else one_share(zeta)
    beta = 2.0 * (last or 0.0) / top if beyond and top > 0.0 else 0.0
    d = 2.0 * each * omega - beta * omega2
    return beta, np.where(np.abs(d) > ROUND_OFF * most * top, d, 0.0)


NOTHING = 1e-12
"""A direction with a smaller inertia, relative to the largest of its kind, has none."""


@dataclass(frozen=True)
class EffectiveMass:
    """How the modes take part in rigid motion of the base: three translations, three rotations about a point."""

    about: FloatArray
    """(3,) point that the rotations turn about."""
    participation: FloatArray
    """(n_mode, 6) L = Phi' M R for mass-normalised modes: sqrt(mass), and sqrt(mass) length in rotation."""
    rigid_mass: FloatArray
    """(6, 6) R' M R: the model's mass, its moments and inertia about the point, held nodes included."""

    @property
    def effective(self) -> FloatArray:
        """(n_mode, 6) L^2: mass, and mass length^2."""
        return self.participation**2

    @property
    def total(self) -> FloatArray:
        """(6,) what all of the model would give: diagonal of R' M R, 0 where that is round-off."""
        own = np.diag(self.rigid_mass).copy()
        for kind in (slice(0, 3), slice(3, 6)):
            own[kind] = np.where(own[kind] > NOTHING * own[kind].max(), own[kind], 0.0)
        return own

    @property
    def share(self) -> FloatArray:
        """(n_mode, 6) L^2 / total; 0 in a direction without inertia."""
        total = self.total
        return np.divide(self.effective, total, out=np.zeros_like(self.participation), where=total > 0.0)

    @property
    def cumulative(self) -> FloatArray:
        """(n_mode, 6) sum of the shares up to each mode."""
        return np.cumsum(self.share, axis=0)


def effective_mass(
    system: System,
    shapes: FloatArray,
    carriers: Iterable[tuple[IntArray, Matrix]],
    nodes: Nodes,
    about: FloatArray,
) -> EffectiveMass:
    """Effective mass L^2 of mass-normalised modes, L = Phi' M R.

    R is the rigid motion of the whole model, held nodes included: when the base moves as R s'', the modal load is
    -L s''. Over all modes L^2 sums to the part of R' M R that does not ride on held nodes alone; for a free model the
    rigid-body modes carry all of it and elastic modes nothing.

    Parameters
    ----------
    system : the assembly. shapes : (n, n_mode) in its coordinates.
    carriers : physical dof labels (k,) and mass (k, k) of each part before it was joined, independent dofs.
    nodes : all of the model. about : (3,) point of the rotations.

    Exact where constraints inside a part allow rigid motion, as couplings, ties and rigid bodies do; an equation
    that resists it (u_x = 0 at one of two nodes) leaves out what it blocks.

    Source: Craig and Kurdila, Fundamentals of Structural Dynamics, 2nd ed., ch. 17; Wijker, Spacecraft Structures.
    """
    mass, load = np.zeros((6, 6)), np.zeros((system.n, 6))
    for labels, M in carriers:
        R = rigid_vectors(labels, nodes, about)
        MR = np.asarray(M @ R)
        mass += R.T @ MR
        load += np.asarray(system.rows(labels)[0].T @ MR)
    return EffectiveMass(np.asarray(about, dtype=np.float64), shapes.T @ load, symmetric(mass))
