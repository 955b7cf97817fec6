"""One-step schemes of the generalised-alpha family: HHT-alpha and Chung-Hulbert."""

from __future__ import annotations

from dataclasses import dataclass

from creak.errors import InputError
from creak.given import check_fields, finite, number


@dataclass(frozen=True)
class Scheme:
    """(1 - am) M a1 + am M a0 + (1 - af)(C v1 + K u1 - f1) + af (C v0 + K u0 - f0) = 0 with Newmark's u1, v1.

    u1 = u0 + h v0 + h^2 ((1/2 - beta) a0 + beta a1), v1 = v0 + h ((1 - gamma) a0 + gamma a1).
    """

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float

    def __post_init__(self) -> None:
        check_fields(self, dict.fromkeys(("alpha_m", "alpha_f", "beta", "gamma"), finite))


def HHT(alpha: float = -0.05) -> Scheme:
    """alpha_m = 0, alpha_f = -alpha, beta = (1 - alpha)^2 / 4, gamma = 1/2 - alpha.

    Second order, unconditionally stable on linear systems (Hilber, Hughes, Taylor, Earthquake Eng. Struct. Dyn. 5,
    1977). alpha = -0.05 is Abaqus's transient fidelity, 1 - sqrt(2) its moderate dissipation.

    Raises
    ------
    InputError : alpha outside -1/2 to 0.
    """
    alpha = number(alpha, "HHT alpha")
    if not -0.5 <= alpha <= 0.0:
        raise InputError(
            f"HHT alpha = {alpha}",
            expected="a value from -1/2 to 0",
            where="[time] alpha",
            fix="-0.05 is the usual choice.",
        )
    return Scheme(0.0, -alpha, (1.0 - alpha) ** 2 / 4.0, 0.5 - alpha)


def generalised_alpha(rho_inf: float = 0.9) -> Scheme:
    """The least dissipation at low frequencies for a spectral radius `rho_inf` at infinite frequency.

    alpha_m = (2 r - 1) / (r + 1), alpha_f = r / (r + 1), beta = (1 - alpha_m + alpha_f)^2 / 4,
    gamma = 1/2 - alpha_m + alpha_f: second order, unconditionally stable on linear systems (Chung and Hulbert,
    J. Appl. Mech. 60, 1993).

    Raises
    ------
    InputError : rho_inf outside 0 to 1.
    """
    rho_inf = number(rho_inf, "rho_inf")
    if not 0.0 <= rho_inf <= 1.0:
        raise InputError(
            f"rho_inf = {rho_inf}",
            expected="a value from 0 to 1",
            where="[time] rho_inf",
            fix="0.9 is the usual choice.",
        )
    alpha_m, alpha_f = (2.0 * rho_inf - 1.0) / (rho_inf + 1.0), rho_inf / (rho_inf + 1.0)
    return Scheme(alpha_m, alpha_f, (1.0 - alpha_m + alpha_f) ** 2 / 4.0, 0.5 - alpha_m + alpha_f)
