"""What a run leaves behind, also one that ended early."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from creak.arrays import FloatArray, IntArray, brief
from creak.dynamics.record.watch import Extremes
from creak.errors import NumericalError

ENERGIES = ("kinetic", "strain", "contact", "damping", "contact_damping", "friction", "external", "scheme")
"""Columns of `History.energy`: three stored energies, then work since the start. The energy of channels with a preload
counts from their rest. `friction` is what sliding took; `scheme` is what the others leave over of the external work and
of the initial energy: the scheme's own dissipation, negative when energy was created."""

ROUND_OFF = 1e-9
"""Share of `History.energy_held` that is nothing."""
GROWS = "look for loads that grow without bound, and for damping or springs below zero that give energy"
"""What to do where creak chose the steps."""


def split_columns(table: FloatArray, m: int, f2: int) -> tuple[FloatArray, ...]:
    """time (n,), gap and force (n, m), tangential and sliding (n, f2), energy, side by side in a table of instants."""
    time, *others = np.split(table, np.cumsum([1, m, m, f2, f2]), axis=1)
    return time[:, 0].copy(), *others


@dataclass(frozen=True)
class History:
    """Time histories of one run; contact quantities at every step, motion at the output times."""

    __repr__ = brief

    time: FloatArray
    """(n_time,) every instant; uneven where steps are shorter near contact."""
    gap: FloatArray
    """(n_time, m)"""
    force: FloatArray
    """(n_time, m), >= 0"""
    slip: FloatArray
    """(n_out, m): length of the tangential relative displacement."""
    output_index: IntArray
    """(n_out,) rows of `time` at which motion is kept."""
    displacement: FloatArray
    """(n_out, n_label)"""
    energy: FloatArray
    """(n_time, len(ENERGIES))"""
    contact_steps: int
    """Steps with at least one closed channel."""
    setup_s: float
    """Wall time before the first step (factorisation, compliance of the channels)."""
    whole_at: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """(n_whole,) steps at which all coordinates are kept."""
    coordinates: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    """(n, n_whole) coordinates q of the System at those steps; `assembly.recovery` gives the motion of every node."""

    tangential: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    """(n_time, 2 f) friction forces on the structure, two tangents for each rubbing channel in turn; empty without
    friction."""
    sliding: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    """(n_time, 2 f) slip velocity of the rubbing channels, 0 while stuck and while open; empty without friction."""
    residual: float = 0.0
    """Largest residual of the equations of motion seen, as a fraction of the forces in them; 0: not measured."""
    extremes: Extremes | None = None
    """Of what was watched at every whole step; None: nothing was."""
    spacing: float = 0.0
    """s between instants where contact changed too often for all of them to be kept, and forces are means
    (`dynamics.record.thinning`); 0: nowhere."""
    preload: FloatArray = field(default_factory=lambda: np.zeros(0))
    """(m,) forces with which the channels press at rest, balanced by what is not in the motion; empty: none has any."""

    @property
    def nbytes(self) -> int:
        """Of its arrays."""
        return sum(x.nbytes for x in vars(self).values() if isinstance(x, np.ndarray))

    @property
    def weights(self) -> FloatArray:
        """(n_time,) time that each instant stands for, half of the steps on both sides of it (trapezoidal rule).

        `weights @ force` is the impulse of the channels. With even steps it is the sum of the forces times the step,
        just what Newmark's family gives the structure between two instants at which nothing presses: the shares in
        which the force of an instant enters the steps around it add up to one.
        """
        half = 0.5 * np.diff(self.time)
        return np.asarray(np.concatenate([[0.0], half]) + np.concatenate([half, [0.0]]))

    @property
    def energy_scale(self) -> float:
        """Largest external work, or the energy at the start, the yardstick of the balance.

        Strain that never falls below that of the start, as that of static loads, does not count, but for round-off.
        """
        external = float(np.abs(self.energy[:, ENERGIES.index("external")]).max())
        kinetic, strain, contact = (self.energy[:, ENERGIES.index(k)] for k in ("kinetic", "strain", "contact"))
        stored = float(kinetic[0] + (strain[0] - strain.min()) + contact[0])
        return max(external, stored, ROUND_OFF * self.energy_held, np.finfo(float).tiny)

    @property
    def energy_held(self) -> float:
        """Energy of springs at the start, of structure and contact: its round-off is that of the balance."""
        pressed = 0.5 * float(self.force[0] @ np.abs(self.gap[0])) if self.gap.size else 0.0
        return float(self.energy[0, ENERGIES.index("strain")]) + pressed

    @property
    def energy_created(self) -> float:
        """Largest energy that the scheme created so far at any time, as a fraction of `energy_scale`."""
        return float(max(0.0, -self.energy[:, ENERGIES.index("scheme")].min() / self.energy_scale))

    @property
    def energy_dissipated_by_scheme(self) -> float:
        """The scheme's own dissipation at the end, as a fraction of `energy_scale`."""
        return float(self.energy[-1, ENERGIES.index("scheme")] / self.energy_scale)


class Stopped(NumericalError):
    """A run did not reach its end; `history` is what it has."""

    def __init__(self, why: str, history: History) -> None:
        self.history = history
        super().__init__(why)


class Diverged(Stopped):
    """The motion is no longer finite; `forced`: its steps were given, not chosen by creak."""

    def __init__(self, time: float, history: History, *, forced: bool = False) -> None:
        remedy = "shorten the step or lower the contact stiffness" if forced else GROWS
        super().__init__(f"the motion is no longer finite at t = {time:.6g} s: {remedy}", history)


class Interrupted(Stopped):
    """Ctrl-C."""

    def __init__(self, history: History) -> None:
        super().__init__(f"stopped at t = {history.time[-1]:.6g} s", history)
