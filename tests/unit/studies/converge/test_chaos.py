"""Settled, or statistics only: a ball on a shaken table, told from what two resolutions of the same motion give."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from creak.dynamics.flow.march import SAMPLES, simulate_flow
from creak.dynamics.flow.resolution import SETTLED as RESOLUTION
from creak.dynamics.flow.resolution import finer
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.reduction.diagonal import diagonalise
from creak.studies.converge.compared import assess
from creak.studies.converge.settled import SETTLED, STATISTICS, _of_convergence
from creak.studies.converge.settling import BASE, CHANCE, FINER, MORE_MODES, Followed, Outcome, Repeat
from creak.verify.events import Event, find_events
from creak.verify.rubbing import Rub, Rubbing
from creak.verify.statistics import chance, chance_between, rate_interval
from helpers_core import channels, system_of

G, FREQUENCY, STEP = 9810.0, 60.0, 2e-3


def bounce(shake: float, loss: float, end: float, by: float) -> Outcome:
    """Events of a ball of mass 1 on a table that shakes with `shake` g, in the frame of the table."""
    time = STEP / SAMPLES * np.arange(SAMPLES * round(end / STEP) + 1)
    pull = -G + shake * G * np.sin(2.0 * np.pi * FREQUENCY * time)
    k = (np.pi / 5e-4) ** 2  # half a period of contact: .5 ms
    gaps = channels([[1.0]], 1.0, k, 2.0 * loss * np.sqrt(k))
    loads = Loads(time, np.zeros((3, time.size, 0)), pull[:, None], (np.array([0]),))
    ball = diagonalise(system_of(np.eye(1), np.zeros((1, 1))))
    h = simulate_flow(ball, gaps, loads, OutputRequest(np.array([0])), resolution=finer(RESOLUTION, by))
    impulse = float((h.weights @ h.force).sum())
    events = tuple(find_events(h, gaps))
    return Outcome(Repeat(FINER if by > 1.0 else BASE, "", STEP), events, impulse, 0.0, 0.0, h.time.size, end, 0.0)


@pytest.mark.parametrize(("shake", "loss", "begin", "word"), [(1.8, 0.6, 1.0, SETTLED), (6.0, 0.02, 0.0, STATISTICS)])
def test_a_ball_on_a_shaken_table(shake, loss, begin, word):
    """Much loss: once in its orbit, the same two hits in each period, whatever the resolution. Little: no two resolutions
    agree for long."""
    runs = {o.repeat.name: o for o in (bounce(shake, loss, 2.0, by) for by in (1.0, 2.0))}
    convergence = assess(runs, "reduced", (begin, 2.0), 0.002)
    verdict, impulse = _of_convergence(convergence), convergence.totals["impulse"]
    assert verdict.word == word
    assert (CHANCE in impulse.sources) == (word == STATISTICS)
    if word == STATISTICS:
        assert 0.0 < impulse.sources[CHANCE] < 1.0
        rate = len(runs[BASE].events) / 2.0
        assert f"{rate:.3g} events per second over the whole run (95 % confidence:" in verdict.reasons[1]
    else:
        assert len(runs[BASE].events) > 100  # more than forty a second


def test_chance_counts_runs_that_were_made_in_places_and_friction_too():
    """A complete model has no run with more modes: the base run stands for it, and is no draw of chance."""
    runs = {o.repeat.name: o for o in (bounce(6.0, 0.02, 2.0, by) for by in (1.0, 2.0))}
    rub = Rub(Rubbing(1.0, (0.0, 0.0, 1.0), 1.0, (), 2.0, 1.0, 3.0), None)
    runs = {n: replace(o, places=({"impulse": o.impulse},), rubs=(rub,)) for n, o in runs.items()}
    hits = tuple(e.impulse for e in runs[BASE].events)
    same = replace(runs[BASE], repeat=Repeat(MORE_MODES, "modes", STEP), steps=0)
    followed = Followed(base=runs[BASE].places, impulses=(hits,), rub_names=(("table", 1),))
    found = assess(runs | {MORE_MODES: same}, "reduced", (0.0, 2.0), 0.002, places=followed)
    assert runs[BASE].events != runs[FINER].events
    told = [found.totals["impulse"], found.places[0]["impulse"], found.rubs[0].figures["friction_energy"]]
    between = chance_between([o.events for o in runs.values()], (0.0, 2.0))
    assert [f.sources[CHANCE] for f in told] == [pytest.approx(between)] * 3
    assert 0.0 < between < 2.0 * chance(hits)
    assert CHANCE not in found.rubs[0].figures["slip_share"].sources
    calm = assess({n: o for n, o in runs.items() if n == BASE}, "reduced", (0.0, 2.0), 0.002, places=followed)
    assert CHANCE not in calm.places[0]["impulse"].sources


def test_confidence_of_a_rate():
    """Garwood's table: 10 events give 4.795 to 18.39, none 0 to 3.689."""
    assert rate_interval(10, 2.0) == pytest.approx((4.795 / 2.0, 18.39 / 2.0), rel=1e-3)
    assert rate_interval(0, 1.0) == pytest.approx((0.0, 3.689), rel=1e-3)


def sum_of(rng, irregular, spread, memory, n=100):
    """Events at random intervals, three times as many in the middle as at the ends, whose impulses remember the last one."""
    level = np.interp(np.arange(n), [0, n // 2, n], [1.0, 3.0, 1.0])
    tau = np.cumsum(rng.gamma(irregular**-2, irregular**2, 2 * n)) - rng.random()
    t = np.interp(tau, np.concatenate([[0.0], np.cumsum(level)]) * n / level.sum(), np.arange(n + 1.0))
    z = lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], rng.standard_normal(t.size + 50))[50:]
    J, inside = np.exp(spread * z - 0.5 * spread**2), (tau > 0.0) & (tau < n)
    return [Event("c", "c:1", 0, a, a, a, 1.0, 1.0, x, 1.0, 1, 1.0) for a, x in zip(t[inside], J[inside], strict=True)]


@pytest.mark.parametrize(
    ("irregular", "spread", "memory", "beside"), [(0.3, 0.3, 0.0, 0.9), (1.0, 0.5, 0.0, 2.0), (1.0, 1.0, 0.7, 4.0)]
)
@pytest.mark.parametrize("count", [2, 4])
def test_a_sum_by_the_runs_that_were_made(irregular, spread, memory, beside, count):
    """Of 300 sets of runs with 100 events the first is as near to the mean as is told in nine tenths or more, also where
    a compound Poisson process covers seven tenths; bars of regular events are narrower than its."""
    rng = np.random.default_rng(7)
    sets = [[sum_of(rng, irregular, spread, memory) for _ in range(count)] for _ in range(300)]
    told = np.array([chance_between(runs, (0.0, 100.0)) for runs in sets])
    off = np.array([abs(sum(e.impulse for e in runs[0]) - 100.0) for runs in sets]) / 100.0
    own = np.mean([chance([e.impulse for e in runs[0]]) for runs in sets])
    assert np.mean(off <= told) >= 0.9
    assert told.mean() < beside * own


def test_runs_that_do_not_part_leave_nothing_to_chance():
    events = [Event("c", "c:1", 0, t, t, t, 1.0, 1.0, 2.0, 1.0, 1, 1.0) for t in (0.1, 0.5, 0.7)]
    assert chance_between([events, events, events], (0.0, 1.0)) == 0.0
    late = [*events[:2], replace(events[2], impulse=3.0)]  # in one part alone: one degree of freedom
    assert chance_between([events, late], (0.0, 1.0)) == pytest.approx(12.706 * np.sqrt(0.5) / 6.5, rel=1e-4)


def test_a_sum_of_events_by_chance():
    """Of 400 compound Poisson sums of 40 exponential impulses in the mean, 95 % lie as near to the mean as is told."""
    rng = np.random.default_rng(5)
    runs = [rng.exponential(1.0, rng.poisson(40)) for _ in range(400)]
    assert np.mean([abs(x.sum() - 40.0) <= 40.0 * chance(x) for x in runs]) == pytest.approx(0.95, abs=0.03)
    assert chance([2.0] * 16) == pytest.approx(1.96 / 4.0)
