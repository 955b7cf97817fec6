"""Extremes over every whole step of a run, whatever of its motion is kept: gaps without force, slip, rotations."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray, Matrix, to_dense
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import ChannelMatrices, on_coordinates
from creak.dynamics.instant import WatchState


@dataclass(frozen=True)
class Watched:
    """What a run looks at at the end of every whole step."""

    silent: GapOperator
    """Channels that carry no force: do they close?"""
    turns: Matrix
    """(3 k, n_label) rotation vectors of k places, rad."""
    turn_labels: IntArray
    """(n_label,) physical dof labels that they follow from."""
    turn_names: tuple[str, ...]
    """(k,) places in words."""
    slip: bool = True
    """Whether tangential motion is looked at; else it is told as 0."""


@dataclass(frozen=True)
class Extremes:
    """What was seen; times in s, not a number where there was nothing to see."""

    slip: FloatArray
    """(m,) largest tangential motion at the ends of a step in which the channel presses, length."""
    slip_at: FloatArray
    silent: tuple[str, ...]
    """Names of the channels without force."""
    gap: FloatArray
    """(len(silent),) smallest gap of these, between the steps by the parabola through three of them, length."""
    gap_at: FloatArray
    least: FloatArray
    """(len(silent),) what these gaps cannot have fallen below between the steps, where the march tells how its modes
    ring; else as `gap`."""
    turn_names: tuple[str, ...]
    turn: FloatArray
    """(k,) largest rotation, rad."""
    turn_at: FloatArray

    @property
    def doubtful(self) -> IntArray:
        """Which of the gaps without force are open as far as they were seen, and may have closed between the steps."""
        return np.flatnonzero((self.least <= 0.0) & (self.gap > 0.0))


class Watch:
    """Takes the motion of a run, some whole steps at a time, and keeps its extremes."""

    def __init__(self, system: System, gaps: GapOperator, on: ChannelMatrices, watched: Watched) -> None:
        self._watched, silent = watched, watched.silent
        no_slip = np.zeros((0, system.n)), np.zeros((0, system.supports.count))
        self.rows: list[tuple[Matrix, FloatArray]] = [
            *(on.tangents if watched.slip else (no_slip, no_slip)),
            on_coordinates(system, silent.G, silent.labels),
            on_coordinates(system, watched.turns, watched.turn_labels),
        ]
        """Of both tangents, the silent gaps (without their size at rest), the rotations: A q + A_s s."""
        self._m = gaps.m
        self._begin()

    def again(self) -> Watch:
        """For another run of the same System and channels, which shares the rows."""
        other = copy.copy(self)
        other._begin()
        return other

    def _begin(self) -> None:
        m, silent, k = self._m, self._watched.silent.m, len(self._watched.turn_names)
        slip_at, gap_at, turn_at = (np.full(n, np.nan) for n in (m, silent, k))
        self.state = WatchState(
            *(np.zeros(m), slip_at, np.full(silent, np.inf), gap_at, np.full(silent, np.inf), np.zeros(k), turn_at),
            *(np.zeros(0), np.zeros((m, 0)), np.zeros((silent, 0)), np.zeros((silent, 0))),
        )

    def below(self, between: Callable[[FloatArray], FloatArray]) -> FloatArray:
        """(n_band, len(silent)) `recorder.Between` of the silent gaps; (0, 0) where there are none to look at."""
        return between(to_dense(self.rows[2][0])) if self._watched.silent.m else np.zeros((0, 0))

    def see(
        self, time: FloatArray, pressed: BoolArray, motions: list[FloatArray], below: FloatArray | None = None
    ) -> None:
        """Whole steps in their order.

        Parameters
        ----------
        time : (k,) their ends. pressed : (k, m) did a channel press in the step that ends there?
        motions : `rows` times the motion, (rows, k) each.
        below : (len(silent), k) how far gaps may lie below the parabolas in the step that ends there.
        """
        first, second, closed, turned = motions
        if self._watched.slip:
            self._see_slip(time, np.hypot(first, second), pressed.T)
        self._see_gaps(time, closed + self._watched.silent.gap0[:, None], np.zeros(1) if below is None else below)
        angle = np.linalg.norm(turned.reshape(-1, 3, time.size), axis=1)
        _raise_to(self.state.turn, self.state.turn_at, angle, time)
        self.state = replace(self.state, time=np.append(self.state.time, time)[-2:])

    def _see_slip(self, time: FloatArray, slip: FloatArray, pressed: BoolArray) -> None:
        seen = self.state
        both = np.hstack([seen.slid if seen.slid.size else slip[:, :1], slip])
        _raise_to(seen.slip, seen.slip_at, np.where(pressed, np.maximum(both[:, 1:], both[:, :-1]), 0.0), time)
        self.state = replace(seen, slid=slip[:, -1:])

    def _see_gaps(self, time: FloatArray, gap: FloatArray, below: FloatArray) -> None:
        seen = self.state
        off = np.hstack([seen.below, np.broadcast_to(below, gap.shape)])
        at, every = np.append(seen.time[-seen.last.shape[1] :], time), np.hstack([seen.last, gap])
        low = every.copy()
        if at.size > 2:
            rise, bend = every[:, 2:] - every[:, :-2], np.diff(every, 2, axis=1)
            turns = (bend > 0.0) & (np.abs(rise) <= 2.0 * bend)
            low[:, 1:-1] -= np.divide(rise**2, 8.0 * bend, out=np.zeros_like(bend), where=turns)
        lower = -seen.gap
        _raise_to(lower, seen.gap_at, -low, at)
        least = np.minimum(low[:, :-1], low[:, 1:]) - off[:, 1 - at.size :] if at.size > 1 else low
        least = np.minimum(seen.least, least.min(axis=1, initial=np.inf))
        self.state = replace(seen, gap=-lower, least=least, last=every[:, -2:], below=off[:, -1:])

    @property
    def extremes(self) -> Extremes:
        """All that was seen so far."""
        w, s = self._watched, self.state
        return Extremes(
            slip=s.slip,
            slip_at=s.slip_at,
            silent=w.silent.names,
            gap=s.gap,
            gap_at=s.gap_at,
            least=s.least,
            turn_names=w.turn_names,
            turn=s.turn,
            turn_at=s.turn_at,
        )


def _raise_to(most: FloatArray, at: FloatArray, values: FloatArray, time: FloatArray) -> None:
    """most (k,) and the times of it, in place, by values (k, n)."""
    if not values.size:
        return
    column = values.argmax(axis=1)
    here = values[np.arange(most.size), column]
    more = here > most
    most[more], at[more] = here[more], time[column[more]]
