"""What a march keeps: the table of all instants, and the motion at output steps, block by block.

A compiled march writes blocks of its own (`first`, then `room` and `take` in turn); one that goes instant by instant
hands them over one by one (`keep`).
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from creak.arrays import BoolArray, FloatArray, IntArray, Matrix
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.books import DAMPING, KINETIC, STRAIN
from creak.dynamics.channels import ChannelMatrices
from creak.dynamics.flow.model import FlowState
from creak.dynamics.history import ENERGIES, History, split_columns
from creak.dynamics.instant import Instant, LogState
from creak.dynamics.loads import Loads
from creak.dynamics.record.thinning import room_for, spacing_for, thin
from creak.dynamics.record.watch import Watch, Watched
from creak.linalg.complex_modes import ComplexModes
from creak.linalg.memory import require

CHUNK = 2_000
"""Output steps between two reports of progress."""
BUFFER_MEMORY = 64_000_000
"""Bytes of motion kept before it is turned into output."""
FEWER = "Let the run end earlier, or keep fewer channels by a smaller [precheck] margin."
"""What to do where the instants of contact are too many."""


class Output(NamedTuple):
    """Where a compiled march writes to."""

    table: FloatArray
    """(rows, 1 + m + (m + 2 f) + 2 f + 8): time, gaps, forces, sliding, energies."""
    at: IntArray
    """(chunk,) rows of the table at which motion is kept."""
    u: FloatArray
    """(chunk, n)"""
    s: FloatArray
    """(chunk, n_support)"""
    whole_at: IntArray
    whole: FloatArray
    """(n_whole, n)"""
    ring: FloatArray
    """(chunk, n_band) largest sqrt(2 E) of each band of modes in the step that ends there; n_band is 0 where nobody
    asks for it."""


@dataclass(frozen=True)
class OutputRequest:
    """What of a march's motion is kept, and what it looks at; gaps and forces are kept at every instant."""

    observed: IntArray
    """(n_label,) physical dof labels whose displacement is kept."""
    every: int = 1
    """Whole steps between two displacements."""
    whole_at: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """(n_whole,) sorted whole steps at which all coordinates are kept, to recover the motion of every node later."""
    watched: Watched | None = None
    """Looked at at the end of every whole step."""


Between = Callable[[FloatArray], FloatArray]
"""Rows (k, n) on the coordinates of a System -> (n_band, k): how far what they see may fall below the parabolas through
the ends of steps, over sqrt(2 E) of each band (`flow.resolution.below_parabola`)."""


class Recorder:
    """The table of all instants, the motion at output steps, and what they become.

    What a march keeps of its motion are coordinates of the System, or pairs of its complex modes.
    One by one (`lean`), only the coordinates that output needs are kept: few of a sparse System.
    """

    def __init__(
        self,
        system: System,
        on: ChannelMatrices,
        gaps: GapOperator,
        loads: Loads,
        substeps: int,
        asked: OutputRequest,
        pairs: ComplexModes | None = None,
        lean: bool = False,
        between: Between | None = None,
    ) -> None:
        self._preload = np.zeros(0) if gaps.preload is None else gaps.preload
        self._m, self._f2, self._every = gaps.m, on.T.shape[0], asked.every
        self._width = 1 + 2 * gaps.m + 2 * self._f2 + len(ENERGIES)
        self._pairs, self._needed = pairs, np.arange(system.n, dtype=np.int64)
        self._basis = None if pairs is None else pairs.basis
        self._watch = None if asked.watched is None else Watch(system, gaps, on, asked.watched)
        wanted = [system.rows(asked.observed), *on.tangents, *(() if self._watch is None else self._watch.rows)]
        if lean:
            self._needed = _columns([A for A, _ in wanted if A.shape[0]], system.n)
        width = self._needed.size if pairs is None else pairs.basis.shape[1]
        self._taken = slice(None) if self._needed.size == system.n else self._needed
        self._rows = self._on_kept(wanted[0])
        moves = any(abs(x).max() > 0.0 for rows in on.tangents for x in rows if np.prod(x.shape))
        self._tangents = tuple(self._on_kept(rows) for rows in on.tangents) if moves else ()
        self._seen = () if self._watch is None else tuple(self._on_kept(rows) for rows in self._watch.rows)
        self._below = np.zeros((0, 0)) if self._watch is None or between is None else self._watch.below(between)
        self._whole_at = np.asarray(asked.whole_at, dtype=np.int64)
        self._end, self._step = float(loads.time[-1]), substeps * loads.step
        self._sizes = loads.n_step // substeps, asked.observed.size, width, system.supports.count
        self._whole_width = system.n if pairs is None else width
        self._begin_tables()

    def again(self) -> Recorder:
        """For another run of the same System and channels at the same instants, which shares all but the tables."""
        other = copy.copy(self)
        if self._watch is not None:
            other._watch = self._watch.again()
        other._begin_tables()
        return other

    def _begin_tables(self) -> None:
        n_step, n_observed, width, n_support = self._sizes
        self._table, self.used = np.empty((n_step + 1, self._width)), 0
        n_out, self._steps = n_step // self._every + 1, 0
        self._at, self._out, self._looked = np.zeros(n_out, dtype=np.int64), 0, 0
        self._displacement, self._slip = np.zeros((n_out, n_observed)), np.zeros((n_out, self._m))
        room = int(np.clip(BUFFER_MEMORY // (8 * max(width, 1)), 1, n_step + 1))
        self.chunk = min(CHUNK, room)
        kept, self._filled = self.chunk + 1, 0
        self._ends = np.zeros(kept, dtype=np.int64)
        self._u, self._s = np.zeros((kept, width)), np.zeros((kept, n_support))
        self._ring = np.zeros((kept, self._below.shape[0]))
        self._whole = np.zeros((self._whole_at.size, self._whole_width))
        self.setup_s = self._spacing = 0.0

    @property
    def state(self) -> LogState:
        """Of a log that is kept instant by instant."""
        n, k = self._out, self._filled
        return LogState(
            self._table[: self.used],
            self._at[:n],
            self._displacement[:n],
            self._slip[:n],
            self._ends[:k],
            self._u[:k],
            self._s[:k],
            self._whole[: self._reached(k)],
            self._steps,
            self._looked,
            self._spacing,
            None if self._watch is None else self._watch.state,
        )

    def _reached(self, more: int = 0) -> int:
        """How many of the wanted whole steps were taken; `more`: not passed on yet."""
        return int(np.searchsorted(self._whole_at, self._steps + more, side="right"))

    def resume(self, state: LogState) -> None:
        """Go on where another one was, of the same System and channels at the same instants."""
        self._grow(state.table.shape[0])
        self.used, self._out, self._filled = state.table.shape[0], state.at.size, state.ends.size
        self._table[: self.used] = state.table
        for own, given in (
            (self._at, state.at),
            (self._displacement, state.displacement),
            (self._slip, state.slip),
            (self._ends, state.ends),
            (self._u, state.u),
            (self._s, state.s),
            (self._whole, state.whole),
        ):
            own[: given.shape[0]] = given
        self._steps, self._looked, self._spacing = state.steps, state.looked, state.spacing
        if self._watch is not None and state.watch is not None:
            self._watch.state = state.watch

    def _on_kept(self, rows: tuple[Matrix, Matrix]) -> tuple[Matrix, Matrix]:
        """Rows on the coordinates of the System as rows on what is kept."""
        if self._basis is not None:
            return np.asarray(rows[0] @ self._basis), rows[1]
        return rows if self._needed.size == rows[0].shape[1] else (rows[0][:, self._needed], rows[1])

    def first(self, time: float, x: FlowState, kept: FloatArray) -> None:
        """The instant that a compiled march starts from."""
        row = np.concatenate([[time], x.gap, x.force, x.sliding, x.energy[: len(ENERGIES)]])
        self._begin(row, kept, kept, x.support[0])
        if self._pairs is not None:
            self._stored = np.concatenate(self._pairs.energies(kept[None]))
            self._table[0, self._width - len(ENERGIES) :][[KINETIC, STRAIN]] += self._stored
            self._begun = float(self._stored.sum())

    def _begin(self, row: FloatArray, kept: FloatArray, whole: FloatArray, support: FloatArray) -> None:
        self._table[0], self._u[0], self._s[0] = row, kept, support
        self.used = self._looked = 1
        self._look(self._at[:1])
        self._flush(slice(1))
        if self._whole_at.size and self._whole_at[0] == 0:
            self._whole[0] = whole

    def keep(self, time: float, now: Instant, energy: FloatArray, step: int | None) -> None:
        """The next instant; `step`: the whole step that it ends, 0 at the start, None within one."""
        row = np.concatenate([[time], now.gap, now.force, now.sliding, energy])
        if step == 0:
            self._begin(row, now.x.u[self._taken], now.x.u, now.support[0])
            return
        self._grow(1)
        self._table[self.used] = row
        self.used += 1
        if step is None:
            return
        k = self._filled
        self._ends[k], self._u[k], self._s[k] = self.used - 1, now.x.u[self._taken], now.support[0]
        if self._whole_at.size:
            self._whole[self._whole_at == step] = now.x.u
        self._filled += 1
        if self._filled == self.chunk:
            self._pass_on()

    def _pass_on(self) -> None:
        """What `keep` has gathered becomes output."""
        filled, self._filled = self._filled, 0
        self._took(filled, self._ends)

    def room(self, rows: int) -> Output:
        """Where the next instants go, at most `rows`."""
        self._grow(rows)
        at = np.zeros(self._u.shape[0], dtype=np.int64)
        self._ring[:] = 0.0
        return Output(self._table, at, self._u, self._s, self._whole_at, self._whole, self._ring)

    def _grow(self, rows: int) -> None:
        room = self._table.shape[0]
        if self.used + rows > room:
            larger = max(self.used + rows, 3 * self.used // 2)
            require(8.0 * self._width * (larger - room), f"{larger:,} instants of {self._m:,} channels", FEWER)
            self._table.resize((larger, self._width), refcheck=False)

    def take(self, used: int, kept: int, out: Output) -> None:
        """Account for what a chunk left, all of its whole steps."""
        if self._pairs is not None and used > self.used:
            self._store(self._pairs, self._table[self.used - 1 : used], out.at[:kept] - self.used + 1, out.u[:kept])
        self.used = used
        self._took(kept, out.at)

    def _store(self, pairs: ComplexModes, table: FloatArray, known: IntArray, z: FloatArray) -> None:
        """Put the energies of pairs into all rows but the first, which has its own.

        Each costs n^2, so that they are found where whole steps end, at the rows `known`, of z (k, 2 n). What is left
        of the work there has gone into the dampers of the structure. That only grows, so that it is as good as
        straight in between, as is the strain energy; the rest is kinetic.
        """
        energy, time = table[:, self._width - len(ENERGIES) :], table[:, 0]
        held = np.vstack([self._stored, np.stack(pairs.energies(z), axis=1)])
        whole, at = energy[1:, DAMPING] + self._begun, time[np.concatenate([[0], known])]
        lost = np.concatenate([energy[:1, DAMPING], whole[known - 1] - held[1:].sum(axis=1)])
        stored = np.maximum(whole - np.interp(time[1:], at, lost), 0.0)
        kinetic = np.maximum(stored - np.interp(time[1:], at, held[:, 1]), 0.0)
        energy[1:, KINETIC] += kinetic
        energy[1:, STRAIN] += stored - kinetic
        energy[1:, DAMPING] -= stored - self._begun
        self._stored = held[-1]

    def _took(self, kept: int, at: IntArray) -> None:
        """Whole steps that end at the rows `at` of the table."""
        self._look(at[:kept], self._looked)
        at = self._fewer(at[:kept])
        self._looked = self.used
        first = (self._every - 1 - self._steps) % self._every
        self._steps += kept
        rows = slice(first, kept, self._every)
        wanted = at[rows]
        self._at[self._out : self._out + wanted.size] = wanted
        self._flush(rows)

    def _fewer(self, at: IntArray) -> IntArray:
        """Fewer instants where the table would become too large; where those `at` are then."""
        if not at.size:
            return at
        room = room_for(self._width, float(self._table[at[-1], 0]) / self._end)
        if self.used <= room:
            return at
        first, forces = self._looked, slice(1 + self._m, 1 + 2 * self._m + self._f2)
        spacing = spacing_for(self._table[first : at[-1] + 1, 0], room - first, self._step)
        before = self.used
        self.used, at = thin(self._table, before, first, at, forces, spacing)
        if self.used < before:
            self._spacing = max(self._spacing, spacing)
        return at

    def _look(self, at: IntArray, before: int = 0) -> None:
        """Let the watch see the whole steps that end at the rows `at`; those after row `before` are new."""
        if self._watch is None or not at.size:
            return
        Q, S = self._u[: at.size].T, self._s[: at.size].T
        motions = [np.asarray(A @ Q + A_s @ S) for A, A_s in self._seen]
        below = (self._ring[: at.size] @ self._below).T if self._below.size else None
        self._watch.see(self._table[at, 0], self._pressed(at, before), motions, below)

    def _pressed(self, at: IntArray, before: int) -> BoolArray:
        """(k, m) did a channel press in the step that ends at each of the rows `at`?"""
        force = self._table[before : at[-1] + 1, 1 + self._m : 1 + 2 * self._m]
        begin = np.concatenate([[0], at[:-1] + 1 - before])
        return np.asarray(np.maximum.reduceat(force, begin, axis=0) > 0.0)

    def _flush(self, rows: slice) -> None:
        Q, S = self._u[rows].T, self._s[rows].T
        here = slice(self._out, self._out + Q.shape[1])
        self._displacement[here] = (self._rows[0] @ Q + self._rows[1] @ S).T
        if self._tangents:
            self._slip[here] = np.hypot(*(np.asarray(A @ Q + A_s @ S) for A, A_s in self._tangents)).T
        self._out = here.stop

    def history(self, residual: float = 0.0) -> History:
        """All that was kept so far."""
        if self._filled:
            self._pass_on()
        time, gap, force, tangential, sliding, energy = split_columns(self._table[: self.used], self._m, self._f2)
        n = self._out
        reached = self._reached()
        steps = int(np.count_nonzero(force[1:].any(axis=1)))
        return History(
            time,
            gap,
            force,
            self._slip[:n],
            self._at[:n],
            self._displacement[:n],
            energy,
            steps,
            self.setup_s,
            self._whole_at[:reached],
            self._whole[:reached].T if self._basis is None else self._basis @ self._whole[:reached].T,
            tangential,
            sliding,
            residual,
            None if self._watch is None else self._watch.extremes,
            self._spacing,
            self._preload,
        )


def _columns(matrices: list[Matrix], n: int) -> IntArray:
    """Coordinates that any of the rows needs: few for a sparse System, all for a dense one."""
    if any(not sp.issparse(A) for A in matrices):
        return np.arange(n, dtype=np.int64)
    none = np.zeros(0, dtype=np.int64)
    return np.unique(np.concatenate([none, *(sp.csr_matrix(A).indices for A in matrices)])).astype(np.int64)
