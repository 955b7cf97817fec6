"""Free-interface modes with massless residual flexibility of the gap channels (MacNeal's method)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray, Matrix
from creak.assembly.system import System, to_dense
from creak.linalg.factor import Factor
from creak.linalg.modes import Modes
from creak.progress import Progress
from creak.reduction.gap_modes import free_interface
from creak.reduction.modal import riding_system


def massless_boundary(
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
    """Reduce a System to its modes below `f_max` (Hz) and a massless spring per gap channel.

    u = Phi eta + R_res G' r^-1 (g - G Phi eta) + R s, with R_res the residual flexibility of `gap_modes` and
    r = G R_res G'. In coordinates (g, eta), M = blkdiag(0, I) and
    K = [[r^-1, -r^-1 G Phi], [-(G Phi)' r^-1, diag(omega^2) + (G Phi)' r^-1 G Phi]].
    The coordinates used here are the same in diagonal form: with Z the residual shapes, Z' K Z = I,
    q = Phi eta + Z zeta + R s, M = diag(1.., 0..), K = diag(omega^2.., 1..). r^-1 is never formed, so near-dependent
    channels do no harm: combinations of them without residual flexibility of their own have no zeta.

    Channel and applied forces act on zeta at once, as in statics; inertia, that of moving supports included, acts on
    eta alone, so that the kinetic energy stays positive. Rayleigh's beta acts on zeta as on the modes it stands for.

    HHT needs no special start; what is out of balance at t = 0 (a channel closed from the start) is left by
    alpha / (1 + alpha) a step.

    Parameters, errors and stats as `gap_modes`. Vibration without contact is exact below f_max; the impulse of a
    contact converges with the modes, its force at an instant rings with the highest modes kept.

    Source: Monjaraz-Tec, Gross, Krack, Computers & Structures 260, 2022, arXiv 2111.07693, after MacNeal (1971).
    """
    basis = free_interface(
        system, G, f_max=f_max, count=count, modes=modes, stiffness=stiffness, static=static, progress=progress
    )
    residual = replace(basis.residual, mu=np.zeros(basis.residual.mu.size))
    name = f"{system.name}, {basis.modes.omega2.size} modes and {residual.mu.size} massless gap shapes"
    return _inertia_on_modes(riding_system(system, basis.modes, basis.support, residual, name))


def _inertia_on_modes(system: System) -> System:
    """Without the inertia that massless coordinates would have through the acceleration of the supports."""
    moving = system.M.diagonal()[:, None] > 0.0
    sup = system.supports
    M_qs, M_start = np.where(moving, to_dense(sup.M_qs), 0.0), np.where(moving, to_dense(sup.M_start), 0.0)
    return replace(system, supports=replace(sup, M_qs=M_qs, M_start=M_start))
