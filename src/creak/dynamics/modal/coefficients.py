"""One step of a diagonal System, mode by mode: coefficients of Newmark's family and of the exact rotation.

Mode (m, c, k) under load E, channel force F and state (u, v, a):

* `newmark_step`: the scheme's equation (1 - am) m a1 + am m a0 + (1 - af)(c v1 + k u1 - F1) + af (c v0 + k u0 - F0) = E
  solved for a1, E the weighted loads of both ends; just the condensed step of `simulate`, one line per mode.
* `exact_step`: kick v += h/2 F0/m, exact damped motion under a load that is linear over the step, kick v += h/2 F1/m.
  Modes without mass follow their force at once, with c > 0 as a spring and dashpot side by side.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy.linalg as sla

from creak.arrays import BoolArray, FloatArray
from creak.assembly.system import System
from creak.dynamics.modal.damped import damped_waves
from creak.dynamics.scheme import Scheme
from creak.errors import InputError
from creak.linalg.diagonal import Diagonal

SLOW = 0.3
"""omega h below which the exact step comes from the matrix exponential, its closed form losing digits."""
OFF_DIAGONAL = 1e-6
"""Modal damping that couples modes by less than this share of their own damping counts as diagonal."""


@dataclass(frozen=True)
class MasslessBoundary:
    """Kick, exact rotation, kick, with contact in coordinates without mass; takes the place of a Scheme.

    Second order and symplectic between changes of the load, exact in free flight for any step. Near contact the step
    must resolve the contact springs (`modal.massless.contact_frequency`). Source: Monjaraz-Tec, Gross, Krack, Comput.
    Struct. 260, 2022, with the impulse splitting of Garcia-Archilla, Sanz-Serna, Skeel, SIAM J. Sci. Comput. 20, 1998.
    """


class ModalStep(NamedTuple):
    """Coefficients of one step of length h for n modes, rows contiguous."""

    h: float
    exact: bool
    free: FloatArray
    """(4, n) Newmark: a1 = free @ (u, v, a, E). (13, n) exact: u, v and the integral of u over the step from (u, v) in
    rows 0 to 5, from the loads at both ends in rows 6 to 11; row 12: velocity of the first kick per force."""
    gain: FloatArray
    """(3, n) u1, v1, a1 per channel force at the end of the step."""
    rate_gain: float
    """Gap rate over gap that a channel force at the end of the step gives, 1 / time."""
    slip_gain: float
    """Sliding of the step over displacement that a channel force at its end gives."""
    weights: tuple[float, float, float, float]
    """alpha_m, alpha_f, beta, gamma; zeros for the exact step."""


def newmark_step(m: FloatArray, c: FloatArray, k: FloatArray, scheme: Scheme, h: float) -> ModalStep:
    """Coefficients of the generalised-alpha family (HHT with alpha_m = 0).

    S = (1 - am) m + (1 - af)(gamma h c + beta h^2 k); identical to the general step up to round-off.
    """
    am, af, beta, gamma = scheme.alpha_m, scheme.alpha_f, scheme.beta, scheme.gamma
    S = (1.0 - am) * m + (1.0 - af) * (gamma * h * c + beta * h * h * k)
    of_a = am * m + (1.0 - af) * (c * h * (1.0 - gamma) + k * h * h * (0.5 - beta))
    free = np.stack([-k / S, -(c + (1.0 - af) * h * k) / S, -of_a / S, 1.0 / S])
    push = (1.0 - af) / S
    gain = np.stack([beta * h * h * push, gamma * h * push, push])
    return ModalStep(h, False, free, gain, gamma / (beta * h), gamma / beta, (am, af, beta, gamma))


def exact_step(m: FloatArray, c: FloatArray, k: FloatArray, h: float) -> ModalStep:
    """Coefficients of kick, exact motion, kick; coordinates without mass follow their force at once (c = 0 there).

    Kicks give the modes the mean of the forces at both ends of a step. A damper on a massless coordinate would see the
    force of the end, and the mismatch of the works would create energy of first order in the step.
    """
    heavy = m > 0.0
    free, gain = np.zeros((13, m.size)), np.zeros((3, m.size))
    free[:12, heavy] = _motion(m[heavy], c[heavy], k[heavy], h)
    free[12, heavy] = gain[1, heavy] = 0.5 * h / m[heavy]
    light = ~heavy
    free[7, light] = gain[0, light] = 1.0 / k[light]
    return ModalStep(h, True, free, gain, 1.0 / h, 1.0, (0.0, 0.0, 0.0, 0.0))


def _motion(m: FloatArray, c: FloatArray, k: FloatArray, h: float) -> FloatArray:
    """(12, n): u <- (u, v), v <- (u, v), integral <- (u, v), then u, v, integral <- (load at start, at end)."""
    slow = h * np.sqrt(k / m) < SLOW
    out = np.empty((12, m.size))
    out[:, slow] = _by_exponential(m[slow], c[slow], k[slow], h)
    out[:, ~slow] = _in_closed_form(m[~slow], c[~slow], k[~slow], h)
    return out


def _in_closed_form(m: FloatArray, c: FloatArray, k: FloatArray, h: float) -> FloatArray:
    """Under-, over- and critically damped modes with k > 0."""
    omega2, delta = k / m, 0.5 * c / m
    cosine, sine = damped_waves(delta, omega2, h)
    uu, uv, vu, vv = cosine + delta * sine, sine, -omega2 * sine, cosine - delta * sine
    iu, iv = (omega2 * sine + 2.0 * delta * (1.0 - uu)) / omega2, (1.0 - vv - 2.0 * delta * uv) / omega2
    u_step = (1.0 - uu) / k
    u_ramp, v_step, v_ramp = (h - iu) / (h * k), sine / m, u_step / h
    i_ramp = (0.5 * h - m * v_ramp - c * u_ramp) / k
    i_step = h * u_ramp
    return np.stack([uu, uv, vu, vv, iu, iv, u_step - u_ramp, u_ramp, v_step - v_ramp, v_ramp, i_step - i_ramp, i_ramp])


def _by_exponential(m: FloatArray, c: FloatArray, k: FloatArray, h: float) -> FloatArray:
    """States u, h v, integral / h, load at the start and its change over the step; time in steps."""
    A = np.zeros((m.size, 5, 5))
    A[:, 0, 1] = A[:, 2, 0] = A[:, 3, 4] = 1.0
    A[:, 1, 0], A[:, 1, 1], A[:, 1, 3] = -h * h * k / m, -h * c / m, h * h / m
    P = sla.expm(A) if m.size else A
    u, v, i = P[:, 0], P[:, 1] / h, P[:, 2] * h
    rows = [u[:, 0], u[:, 1] * h, v[:, 0], v[:, 1] * h, i[:, 0], i[:, 1] * h]
    for x in (u, v, i):
        rows += [x[:, 3] - x[:, 4], x[:, 4]]
    return np.stack(rows)


def modal_damping(system: System) -> FloatArray | None:
    """(n,) diagonal of C; None where M or K is not Diagonal or C couples coordinates.

    C = alpha M + beta K + W diag(d) W', the last term diagonal within `OFF_DIAGONAL` where the modes it was made for
    are those of the System.
    """
    d = system.damping
    if not (isinstance(system.M, Diagonal) and isinstance(system.K, Diagonal)) or d.extra is not None:
        return None
    own = d.alpha * system.M.d + d.beta * system.K.d
    if d.modal_shapes is None or d.modal_values is None:
        return np.asarray(own)
    C = (d.modal_shapes * d.modal_values) @ d.modal_shapes.T
    diagonal = C.diagonal().copy()
    np.fill_diagonal(C, 0.0)
    size = np.sqrt(np.maximum(own + diagonal, 0.0))
    coupled = np.abs(C) > OFF_DIAGONAL * np.maximum(np.outer(size, size), OFF_DIAGONAL * diagonal.max(initial=0.0))
    return None if coupled.any() else np.asarray(own + diagonal)


def is_modal(system: System) -> bool:
    """Can `simulate_modal` march this System?"""
    return modal_damping(system) is not None


def modal_matrices(system: System) -> tuple[FloatArray, FloatArray, FloatArray]:
    """m, c, k (n,) of a diagonal System.

    Raises
    ------
    InputError : the System is not diagonal, or a coordinate has neither mass nor stiffness.
    """
    c = modal_damping(system)
    if c is None:
        raise InputError(
            "the modal integrator needs diagonal M, C and K",
            where=system.name,
            fix="Diagonalise the System, or leave out dashpots; damping by Rayleigh's rule or by its own modes.",
        )
    m, k = np.asarray(system.M.diagonal(), dtype=float), np.asarray(system.K.diagonal(), dtype=float)
    _check((m <= 0.0) & (k <= 0.0), system.name)
    return m, c, k


def _check(empty: BoolArray, name: str) -> None:
    if empty.any():
        raise InputError(f"{int(empty.sum())} coordinates have neither mass nor stiffness", where=name)
