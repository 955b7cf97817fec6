"""Modes of the whole assembly, riding on the quasi-static motion of the supports."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.damping import Damping
from creak.assembly.system import System, project
from creak.linalg.diagonal import Diagonal
from creak.linalg.factor import Factor
from creak.linalg.modes import Modes
from creak.reduction.diagonal import diagonalise


def support_motion(system: System, stiffness: Factor) -> FloatArray:
    """R = -K^-1 K_qs, (n, n_support): how the structure follows its supports without inertia."""
    if system.supports.count == 0:
        return np.zeros((system.n, 0))
    return -stiffness.solve(np.asfortranarray(system.supports.K_qs))


def modal_system(system: System, modes: Modes, R: FloatArray, static: FloatArray) -> System:
    """The System in its lowest modes, q = V eta + R s: small, diagonal, good for a linear pre-check.

    V holds the modes and, made M-orthogonal to them, the `static` answers (n, k) to the applied forces
    (mode acceleration).
    """
    name = f"{system.name}, {modes.omega2.size} modes"
    if static.shape[1] == 0 and system.damping.extra is None:
        small = project(system, modes.shapes, static=R, name=name)
        return replace(small, M=Diagonal(np.ones(modes.omega2.size)), K=Diagonal(modes.omega2))
    rest = static - modes.shapes @ (modes.shapes.T @ np.asarray(system.M @ static))
    size, mix = np.linalg.eigh(rest.T @ np.asarray(system.M @ rest))
    keep = size > 1e-16 * max(float(np.einsum("ij,ij->", static, np.asarray(system.M @ static))), 1e-300)
    V = np.hstack([modes.shapes, rest @ (mix[:, keep] / np.sqrt(size[keep]))])
    return diagonalise(project(system, V, static=R, name=name))


def with_modal_damping(system: System, modes: Modes, R: FloatArray, zeta: float) -> System:
    """C = M Phi diag(2 zeta omega) Phi' M on the motion relative to that of the supports; dashpots stay.

    Modes that were not computed are undamped.
    """
    W = np.asarray(system.M @ modes.shapes)
    d = 2.0 * zeta * np.sqrt(modes.omega2)
    keep = d > 0.0
    damping = Damping(0.0, 0.0, system.damping.extra, W[:, keep], d[keep])
    relative = R.T @ W[:, keep]
    sup = system.supports
    supports = replace(
        sup,
        C_qs=sup.C_qs - (W[:, keep] * d[keep]) @ relative.T,
        C_ss=sup.C_ss + (relative * d[keep]) @ relative.T,
    )
    return replace(system, damping=damping, supports=supports)
