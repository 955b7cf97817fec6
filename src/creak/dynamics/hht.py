"""Hilber-Hughes-Taylor alpha method: parameters."""

from __future__ import annotations

from dataclasses import dataclass

from creak.errors import InputError


@dataclass(frozen=True)
class HHT:
    """M a1 + (1 + alpha)(C v1 + K u1 - f1) - alpha (C v0 + K u0 - f0) = 0.

    beta = (1 - alpha)^2 / 4, gamma = 1/2 - alpha: second order, unconditionally stable on linear systems
    (Hilber, Hughes, Taylor, Earthquake Eng. Struct. Dyn. 5, 1977). alpha = -0.05 is Abaqus's transient
    fidelity, 1 - sqrt(2) its moderate dissipation.
    """

    alpha: float = -0.05

    def __post_init__(self) -> None:
        if not -0.5 <= self.alpha <= 0.0:
            raise InputError(
                f"HHT alpha = {self.alpha}", expected="a value from -1/2 to 0", where="[time] alpha",
                fix="-0.05 is the usual choice.",
            )  # fmt: skip

    @property
    def beta(self) -> float:
        return (1.0 - self.alpha) ** 2 / 4.0

    @property
    def gamma(self) -> float:
        return 0.5 - self.alpha
