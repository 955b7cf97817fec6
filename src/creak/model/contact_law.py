"""How two things press and rub where they touch: one record from what the user says to the gap channels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError


class Coulomb(NamedTuple):
    """|tau| <= mu p, mu(v) = kinetic + (static - kinetic) exp(-v / decay)."""

    static: float = 0.0
    kinetic: float = 0.0
    """At most `static`."""
    decay: float = 0.0
    """Speed, length / time; 0: kinetic as soon as it slides."""


SMOOTH = Coulomb()
"""No friction."""


@dataclass(frozen=True)
class ContactLaw:
    """p >= 0 of the overclosure y and its rate: stiffness y, or the curve at y, plus damping y'; friction; preload.

    Forces, or forces per area: the place that uses the law says which.

    Raises
    ------
    InputError : numbers that are no law.
    """

    stiffness: float | None = None
    """force / length; inf: hard; None: creak's choice, from the parent elements (beside a curve: the curve)."""
    curve: FloatArray | None = None
    """(k, 2) overclosure, length, and force, from (0, 0) on; instead of the stiffness."""
    damping: float = 0.0
    """force time / length, acts while closed."""
    friction: Coulomb = SMOOTH
    preload: float = 0.0
    """force at rest, which the rest of the structure balances."""
    where: str = ""
    """For messages."""

    def __post_init__(self) -> None:
        if self.curve is not None and self.stiffness is not None:
            raise InputError(
                f"both stiffness = {self.stiffness} and an overclosure curve",
                where=self._at("overclosure"),
                expected="one of them",
                fix="Leave out stiffness: the curve replaces it.",
            )
        for name, value in (("stiffness", self.stiffness or 0.0), ("damping", self.damping), ("preload", self.preload)):
            if not value >= 0.0:
                raise InputError(
                    f"{name} = {value:g}", where=self._at(name), expected="zero or more", fix="Contacts only press."
                )
        if self.preload and not 0.0 < (self.stiffness or 0.0) < np.inf:
            raise InputError(
                f"preload = {self.preload:g} without a finite stiffness",
                where=self._at("preload"),
                expected="a stiffness: the channel opens once it has moved by preload / stiffness",
                fix="Give a stiffness.",
            )
        if self.curve is not None:
            check_curve(self.curve, self._at("overclosure"))
        check_friction(*self.friction, self._at("friction"))

    def _at(self, key: str) -> str:
        return f"{self.where} {key}".strip()

    @property
    def automatic(self) -> bool:
        """The elements say how stiff it is."""
        return self.stiffness is None and self.curve is None

    @property
    def hard(self) -> bool:
        """No penetration to speak of."""
        return self.stiffness == np.inf

    @property
    def steepest(self) -> float | None:
        """Largest slope, force / length: what a time step has to resolve; None where the elements say it."""
        if self.curve is None:
            return self.stiffness
        x, y = self.curve.T
        return float(np.max(np.diff(y) / np.diff(x)))


def check_curve(points: FloatArray, where: str) -> None:
    """(k, 2) overclosure and force of a law.

    Raises
    ------
    InputError : fewer than two points, a first point other than [0, 0], or one of both does not rise.
    """
    rises = np.diff(points[:, 0]) > 0.0, np.diff(points[:, 1]) >= 0.0
    problem = ""
    if len(points) < 2 or not np.isfinite(points).all():
        problem = f"the overclosure curve has {len(points)} point(s)"
    elif points[0].any():
        problem = f"the overclosure curve starts at {points[0].tolist()}"
    elif not (rises[0].all() and rises[1].all() and points[-1, 1] > 0.0):
        at = int(np.argmin(rises[0] & rises[1]))
        problem = f"the overclosure curve does not rise from {points[at].tolist()} to {points[at + 1].tolist()}"
    if problem:
        raise InputError(
            problem,
            where=where,
            expected="[[0, 0], [overclosure, pressure], ...], both rising",
            fix="Correct its points.",
        )


def check_friction(
    static: float | FloatArray, kinetic: float | FloatArray, decay: float | FloatArray, where: str
) -> None:
    """Coefficients and decay speeds, of one law or of many channels.

    Raises
    ------
    InputError : a number below zero, or a kinetic coefficient above the static one.
    """
    s, k, d = np.broadcast_arrays(static, kinetic, decay)
    good = (k >= 0.0) & (k <= s) & (s < np.inf) & (d >= 0.0) & (d < np.inf)
    if not good.all():
        i = int(np.argmin(good))
        raise InputError(
            f"friction with static = {s.flat[i]:g}, kinetic = {k.flat[i]:g}, decay = {d.flat[i]:g}",
            where=where,
            expected="0 <= kinetic <= static and decay >= 0",
            fix="Friction falls once it slides: give the larger coefficient as static.",
        )


BY_THE_ELEMENTS = ContactLaw()
"""As stiff as the parent elements say, without damping or friction."""
