"""The unreduced model takes over the reduced one's state shortly before an event and marches through it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from creak.arrays import IntArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.flight.contact_steps import IN_CONTACT
from creak.dynamics.flow.march import SAMPLES
from creak.dynamics.history import History
from creak.dynamics.loads import Loads, refined
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.record.watch import Watched
from creak.dynamics.simulate import CondensedStepper, march
from creak.linalg.memory import free_bytes
from creak.linalg.together import Solver, side_by_side
from creak.studies.spots.choose import STEP, Span, Stretch
from creak.studies.spots.handover import ROUND_OFF, Begins, Handover
from creak.verify.events import REACH, Event, find_events
from creak.verify.matching import FIGURES, figures_of

Result = TypeVar("Result")
VECTORS = 40
"""Of all unknowns that a march holds: two instants, what their step is made of, its columns in the solver."""
OPEN = 0.25
"""Of its duration that an event must be followed by without contact, so that it has ended."""
SILENT = 4
"""Instants without force beside a stretch."""
BESIDE = 4
"""Samples of the loads beyond a stretch that the spline through them knows."""


@dataclass(frozen=True)
class Marched:
    """A stretch, marched through by the unreduced model."""

    history: History
    gaps: GapOperator
    """Its channels."""
    channels: IntArray
    """Which of the run these are."""
    problem: str
    """What makes it worthless."""
    solves: float
    """Back-substitutions of the whole that it took, or what costs as much."""
    narrow: Marched | None = None
    """The same where fewer dofs move by themselves; None: all do."""


class Checker:
    """Marches through stretches by steps of one length, all unknowns of the unreduced model taking part."""

    def __init__(self, of: Handover, parts: int, near: IntArray) -> None:
        self._of, self._parts, self._near = of, parts, near
        self.gaps = gaps = of.gaps.select(near)
        h = SAMPLES * of.loads.step / parts
        self._watched = watching(of.gaps.select(np.setdiff1d(np.arange(of.gaps.m), near)))
        loads = Loads(h * np.arange(2.0), of.loads.support[:, :2], of.loads.force[:2], of.loads.force_labels)
        self._stepper = CondensedStepper(of.unreduced, gaps, loads, IN_CONTACT)

    def side_by_side(
        self, works: Sequence[Callable[[Solver], Result]], counted: Callable[[int], object] = int
    ) -> list[Result]:
        """Results of marches, as many at once as memory holds beside each other (`linalg.together`).

        Of a small model, one after the other: a step of it costs less than to wait for others.
        """
        n = self._of.unreduced.n
        at_once = 1 if n <= STEP else max(1, int(min(free_bytes() / (VECTORS * 8.0 * n), len(works))))
        groups = [works[k : k + at_once] for k in range(0, len(works), at_once)]
        return [found for own in groups for found in side_by_side(self._stepper.solver, own, counted)]

    def through(self, s: Span, begins: Begins, channels: IntArray, solver: Solver | None = None) -> Marched:
        """The march from displacement and velocity (n,).

        channels : what it is about. solver : what it takes in place of its own, so that several marches go on side by
        side.
        """
        begun = (*begins, self._of.held(s, self._near))
        stepper = self._stepper.over(cut(self._of.loads, s, self._parts), begun, solver)
        none = np.zeros(0, dtype=np.int64)
        history = march(stepper, OutputRequest(none, max(1, stepper.loads.n_step), watched=self._watched))
        return Marched(history, self.gaps, self._near, what_closes(history), s.steps)


def watching(gaps: GapOperator) -> Watched:
    """Channels that were left out of a march, and are to stay open in it."""
    return Watched(gaps.without_force(), np.zeros((0, 0)), np.zeros(0, dtype=np.int64), (), slip=False)


def what_closes(history: History) -> str:
    """Which of these did not, in words; empty: they all did."""
    seen = history.extremes
    closed = [] if seen is None else [n for n, g in zip(seen.silent, seen.gap.tolist(), strict=True) if g < 0.0]
    return f"channel {closed[0]} closes, which was left out" if closed else ""


def cut(loads: Loads, s: Span, parts: int) -> Loads:
    """The loads of a stretch, `parts` samples of each flight step."""
    a = SAMPLES * s.first
    b = a + -(-SAMPLES * s.steps // parts)
    lo, hi = max(0, a - BESIDE), min(loads.n_step, b + BESIDE)
    some = replace(
        loads, time=loads.time[lo : hi + 1], support=loads.support[:, lo : hi + 1], force=loads.force[lo : hi + 1]
    )
    fine = refined(some, parts)  # a sample is SAMPLES / parts of what it was: every SAMPLES-th one is wanted
    rows = slice(parts * (a - lo), parts * (a - lo) + SAMPLES * s.steps + 1, SAMPLES)
    return replace(fine, time=fine.time[rows], support=fine.support[:, rows], force=fine.force[rows])


def within(history: History, window: tuple[float, float]) -> History:
    """Its instants in a window, those at its ends among them."""
    first, last = np.searchsorted(history.time, [window[0] * (1.0 - ROUND_OFF), window[1] * (1.0 + ROUND_OFF)])
    kept = ("time", "gap", "force", "tangential", "sliding")
    return replace(history, **{name: getattr(history, name)[first:last] for name in kept})


def own_figures(of: Handover, s: Stretch) -> dict[str, float] | None:
    """`FIGURES` of the event in the reduced run over the stretch alone, as the unreduced march sees it."""
    figures = figures_over(s.event, within(of.history, s.time(of.ends)), of.gaps, of)
    if figures is not None:  # what came before the stretch tells how fast the gap closed
        figures |= {name: FIGURES[name](s.event) for name in ("start", "closing_speed")}
    return figures


def figures_over(event: Event, history: History, gaps: GapOperator, of: Handover) -> dict[str, float] | None:
    """Figures of what touches at the event's side while it lasts, or begins beside it; the duration only where it ends.

    Touches that one model takes for one event and the other for two are counted alike: together.
    """
    found = find_events(_with_silence(history, of.f_max), gaps, of.merge, of.f_max)
    own = next(own for own in of.sides if (event.group, event.channel) in own)
    same = [e for e in found if (e.group, e.channel) in own and (e.t_start <= event.t_end or _meets(e, event))]
    if not same:
        return None
    whole = replace(
        same[0],
        t_end=max(e.t_end for e in same),
        impulse=sum(e.impulse for e in same),
        force_place=max(e.force_place for e in same),
    )
    figures = figures_of(whole)
    if whole.t_end + OPEN * (whole.t_end - whole.t_start) > history.time[-1]:
        del figures["duration"]
    return figures


def _with_silence(history: History, f_max: float) -> History:
    """The history with as long a time without force beside it as a low-pass sees, where it begins open; behind it too.

    What the force of an event is then hangs on the stretch alone, and not on where it was cut. Before it gaps go on as
    they begin.
    """
    long = 2.0 * REACH / f_max
    step = np.diff(history.time)
    ends = [(-1, long, float(step[-1]))] + ([] if history.force[0].any() else [(0, -long, -float(step[0]))])
    time, gap, force = history.time, history.gap, history.force
    for at, far, near in ends:
        more = history.time[at] + near + np.arange(SILENT) / (SILENT - 1) * far
        order = slice(None) if at else slice(None, None, -1)
        rows, none = np.repeat(history.gap[[at]], SILENT, axis=0), np.zeros((SILENT, force.shape[1]))
        if at == 0:  # a gap that closes has come so fast
            rows += np.multiply.outer(more[order] - history.time[0], (history.gap[1] - history.gap[0]) / step[0])
        pieces = [(time, more[order]), (gap, np.maximum(rows, 0.0)), (force, none)]
        time, gap, force = (np.concatenate([a, b] if at else [b, a]) for a, b in pieces)
    return replace(history, time=time, gap=gap, force=force)


def _meets(e: Event, event: Event) -> bool:
    """Do they begin within the longer one's duration of each other?"""
    return abs(e.t_start - event.t_start) <= max(e.t_end - e.t_start, event.t_end - event.t_start)
