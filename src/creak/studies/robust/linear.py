"""What a run without contact tells of draws: how far gaps close, and so how far each is from touching.

Of draws that differ in gaps and in the size of the loads alone, that is told for all of them at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator, join
from creak.dynamics.flow.unhindered import gaps_without_contact
from creak.dynamics.history import History
from creak.dynamics.loads import Loads
from creak.signals.spectra import largest
from creak.studies.prepare.setup import Setup
from creak.studies.robust.draws import Cause, Draw, Drawn

FACTORS = (0.25, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5, 2.0)
"""On the load, of the fragility curve."""
SURE = 0.05
"""Of its closing without contact that must be left of a gap, so that it stays open for sure: between two instants its
course is taken for a parabola."""
SAME = 1e-12
"""Of the largest load, round-off of a multiple of it."""


@dataclass(frozen=True)
class Linear:
    """A run without contact."""

    excursion: FloatArray
    """(m,) most that each kept channel closes in the window, 0 or less."""
    whole: FloatArray
    """The same of the whole run."""
    dropped: FloatArray
    """(2, k) gap at rest of the channels that the pre-check dropped, and most that they close in the whole run."""

    def times(self, factor: float) -> Linear:
        """That of `factor` times the loads, at rest before."""
        rest, closes = self.dropped
        return Linear(factor * self.excursion, factor * self.whole, np.stack([rest, factor * closes]))

    def clear_of(self, gap0: FloatArray, factors: FloatArray) -> BoolArray:
        """(n,) does nothing touch for sure, so that a run with contact is this one?

        Parameters
        ----------
        gap0 : (n, m) gaps at rest of each draw. factors : (n,) on the loads, at rest before.
        """
        by, (rest, closes) = (1.0 + SURE) * factors[:, None], self.dropped
        open_ones = (gap0 + by * self.whole > 0.0).all(axis=1)
        return np.asarray(open_ones & (rest + by * closes > 0.0).all(axis=1))

    def slack(self, gap0: FloatArray, factors: FloatArray, of_places: Sequence[BoolArray]) -> FloatArray:
        """(n, n_place, n_factor) smallest gap of each place, the loads times each of `FACTORS` besides.

        Parameters
        ----------
        gap0, factors : as for `clear_of`. of_places : (m,) channels of each place; inf where it has none.
        """
        found = np.full((len(gap0), len(of_places), len(FACTORS)), np.inf)
        for k, own in enumerate(of_places):
            for j, factor in enumerate(FACTORS if own.any() else ()):
                left = gap0[:, own] + (factor * factors)[:, None] * self.excursion[own]
                found[:, k, j] = left.min(axis=1)
        return found


def own_linear(
    system: System, gaps: GapOperator, dropped: GapOperator, loads: Loads, window: tuple[float, float]
) -> Linear:
    """How far gaps close in the study's own load without contact, between the steps too.

    Parameters
    ----------
    dropped : channels that the pre-check dropped.
    """
    every = join([gaps.without_force(), dropped])
    found = gaps_without_contact(system, every, loads, window=window)
    closing = [np.minimum(low[: gaps.m] - gaps.gap0, 0.0) for low in (found.in_window, found.lowest)]
    return Linear(closing[0], closing[1], np.stack([dropped.gap0, found.lowest[gaps.m :] - dropped.gap0]))


def linear_of(history: History, gaps: GapOperator, window: tuple[float, float], rest: FloatArray) -> Linear:
    """Of a run in which nothing touched, or could not, how far gaps closed.

    Parameters
    ----------
    rest : (k,) gaps at rest of the channels that the pre-check dropped.
    """
    inside = (history.time >= window[0]) & (history.time <= window[1])
    spans = [(history.time[i], history.gap[i]) for i in (inside, slice(None))]
    closing = [np.minimum(-largest(-gap, time) - gaps.gap0, 0.0) for time, gap in spans]
    return Linear(closing[0], closing[1], dropped_of(history, rest))


def dropped_of(history: History, rest: FloatArray) -> FloatArray:
    """`Linear.dropped` of any run; channels that were not watched stay at rest."""
    lowest = rest if history.extremes is None else history.extremes.gap
    return np.stack([rest, lowest - rest])


def closes(dropped: FloatArray) -> bool:
    """Does one of the channels that the pre-check dropped close?"""
    return bool((dropped.sum(axis=0) <= 0.0).any())


def multiple(loads: Loads, base: Loads) -> float | None:
    """f with loads = f base, 0 or more; None: they are no such multiple."""
    pairs = [(loads.support, base.support), (loads.force, base.force)]
    on = [loads.force_labels, base.force_labels]
    if any(a.shape != b.shape for a, b in pairs) or not all(map(np.array_equal, *on)):
        return None
    ours, of = (np.concatenate([x.ravel() for x in every]) for every in zip(*pairs, strict=True))
    k = int(np.abs(of).argmax()) if of.size else 0
    if not of.size or of[k] == 0.0:
        return None
    factor = float(ours[k] / of[k])
    same = np.allclose(ours, factor * of, rtol=0.0, atol=SAME * float(np.abs(ours).max()))
    return factor if factor >= 0.0 and same else None


def pressed(gaps: GapOperator) -> bool:
    """Do channels press from the start?"""
    return bool(gaps.resting.any() or (gaps.gap0[gaps.can_press()] < 0.0).any())


STRAIGHT = 1e-9
"""Of the largest gap, or of a factor, by which the middle of a cause may be off the line through its ends, and what is
told of a draw off what it is."""
TRIED = 4
"""Draws that are set up one by one, to hold what is told against them."""
Known = Callable[[Draw], tuple[FloatArray, float] | None]
"""Gaps at rest, and factor on the study's loads; None: they are no multiple of these, or other channels are."""


@dataclass(frozen=True)
class Plain:
    """Gaps and loads of draws, in which no cause changes what another one does.

    Contact stiffness, friction and dampers may differ, too: they do nothing before something touches.
    """

    drawn: Drawn
    gap0: FloatArray
    """(m,) of all channels, contacts and connectors, at rest in the study's own state."""
    contacts: int
    """Of them that belong to contacts, the first ones."""
    lines: tuple[tuple[float, FloatArray, FloatArray], ...]
    """Of each cause: a value, (m,) what it adds to the gaps there, and per unit from there on; all 0 of a field."""
    fields: tuple[tuple[int, IntArray, FloatArray], ...]
    """Cause, its channels (k,), and what is between its gaps and those at rest (k,)."""
    load: int | None = None
    """The cause that multiplies the loads; None: they are the study's own."""
    load_line: tuple[float, float, float] = (0.0, 1.0, 0.0)
    """Its value, factor on the loads there, and per unit from there on."""

    def blocks(self, first: int = 0, last: int | None = None) -> list[slice]:
        """Draws from `first` to before `last`, some at a time."""
        return self.drawn.blocks(self.gap0.size, first, last)

    def gaps(self, rows: slice) -> FloatArray:
        """(n, m) of some draws."""
        found = np.tile(self.gap0, (rows.stop - rows.start, 1))
        for k, own, between in self.fields:
            found[:, own] = self.drawn.causes[k].values(self.drawn.points[rows]) + between
        for column, (start, there, slope) in zip(self.drawn.numbers, self.lines, strict=True):
            if column is not None:
                found += there + (column[rows, None] - start) * slope
        return found

    def factors(self, rows: slice) -> FloatArray:
        """(n,) on the study's loads, of some draws."""
        column = None if self.load is None else self.drawn.numbers[self.load]
        if column is None:
            return np.ones(rows.stop - rows.start)
        start, there, slope = self.load_line
        return np.asarray(there + (column[rows] - start) * slope)

    def lowest(self, linear_gaps: FloatArray | None) -> FloatArray:
        """(contacts,) how far their gaps fall below those of the study in any draw, 0 or less, larger loads counted in.

        Parameters
        ----------
        linear_gaps : (contacts,) smallest gaps without contact under the study's own loads; None: they are not known.
        """
        own = slice(0, self.contacts)
        found = np.zeros(self.contacts)
        moves = 0.0 if linear_gaps is None else np.minimum(linear_gaps - self.gap0[own], 0.0)
        for rows in self.blocks():
            more = np.maximum(self.factors(rows) - 1.0, 0.0)[:, None] * moves
            found = np.minimum(found, (self.gaps(rows)[:, own] - self.gap0[own] + more).min(axis=0))
        return found


def plain_of(set_up: Callable[[Draw], Setup], drawn: Drawn) -> Plain | None:
    """What draws of a study have in common; None: they differ in more, or not as a line in each number.

    Each cause is set up at both ends and the middle of what was drawn of it, and a few draws whole.

    Parameters
    ----------
    set_up : gives a draw at its static start.
    """
    if any(cause.of.type == "seed" or cause.key == "damping.modal" for cause in drawn.causes) or not drawn.total:
        return None
    base = set_up(Draw(0, {}, {}))
    gaps = join([base.contacts, base.connectors])
    scale = float(np.abs(gaps.gap0).max(initial=0.0))

    def known(draw: Draw) -> tuple[FloatArray, float] | None:
        other = set_up(draw)
        factor = 1.0 if other.loads is base.loads else multiple(other.loads, base.loads)
        names = other.contacts.names + other.connectors.names
        gap0 = np.concatenate([other.contacts.gap0, other.connectors.gap0])
        return None if factor is None or names != gaps.names else (gap0, factor)

    lines, fields, load, load_line = [], [], None, (0.0, 1.0, 0.0)
    group = np.array(gaps.group, dtype=object)
    for k, (cause, column) in enumerate(zip(drawn.causes, drawn.numbers, strict=True)):
        nothing = 0.0, np.zeros(gaps.m), np.zeros(gaps.m)
        if column is None:
            own = np.flatnonzero(group == cause.contact)
            one = np.zeros(own.size) if cause.mean is None else cause.mean
            found = known(Draw(0, {}, {cause.contact: one}))
            if found is None or found[1] != 1.0 or cause.names != tuple(gaps.names[j] for j in own.tolist()):
                return None
            fields.append((k, own, found[0][own] - one))
        elif not cause.is_factor:
            line = _line(cause, column, known, gaps.gap0)
            if line is None:
                return None
            nothing, factor = line
            if factor is not None and load is not None:
                return None
            load, load_line = (load, load_line) if factor is None else (k, factor)
        lines.append(nothing)
    plain = Plain(drawn, gaps.gap0, base.contacts.m, tuple(lines), tuple(fields), load, load_line)
    return plain if _holds(plain, known, scale) else None


def _line(
    cause: Cause, column: FloatArray, known: Known, gap0: FloatArray
) -> tuple[tuple[float, FloatArray, FloatArray], tuple[float, float, float] | None] | None:
    """What a number adds to the gaps, and its factor on the loads (None: it has none); None: it is no line."""
    low, high = float(column.min()), float(column.max())
    ends = [known(Draw(0, {cause.key: cause.number(x)}, {})) for x in (low, 0.5 * (low + high), high)]
    if ends[0] is None or ends[1] is None or ends[2] is None:
        return None
    (a, f_a), (middle, f_middle), (b, f_b) = ends[0], ends[1], ends[2]
    bent = float(np.abs(middle - 0.5 * (a + b)).max(initial=0.0))
    if bent > STRAIGHT * float(np.abs(gap0).max(initial=0.0)) or abs(f_middle - 0.5 * (f_a + f_b)) > STRAIGHT:
        return None
    width = high - low or 1.0
    factor = None if f_a == f_middle == f_b == 1.0 else (low, f_a, (f_b - f_a) / width)
    return (low, a - gap0, (b - a) / width), factor


def _holds(plain: Plain, known: Known, scale: float) -> bool:
    """Whether some draws, set up one by one, are what is told of them. One that presses from the start is marched."""
    for number in np.unique(np.linspace(0, plain.drawn.total - 1, TRIED).astype(np.int64)).tolist():
        found, row = known(plain.drawn.draw(number)), slice(number, number + 1)
        told = plain.gaps(row)[0]
        if found is None or abs(found[1] - plain.factors(row)[0]) > STRAIGHT * max(found[1], 1.0):
            return False
        if told.min(initial=np.inf) > 0.0 and np.abs(found[0] - told).max() > STRAIGHT * scale:
            return False
    return True
