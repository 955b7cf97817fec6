"""What errors of earlier impulses pass on to the events after them, by the runs that change the impulses."""

from __future__ import annotations

import pytest

from creak.studies.converge.compared import assess
from creak.studies.converge.settling import BASE, MORE_MODES, UNREDUCED, Outcome, Repeat
from creak.verify.events import Event
from creak.verify.matching import FIGURES
from creak.verify.unreduced import Spot, Structure

E = 0.01
"""By which the impulse of each event that was looked at is off."""


def hit(t, force=1.0, share=0.0):
    return Event("c", "c:1", 0, t, t + 1e-3, t + 2e-3, force, force, (1.0 + share) * 1e-3 * force, 5.0, 1, force)


def unreduced(name, base, more, beside=()):
    """What the unreduced model changes of a figure of each event of the base run, where more modes make `more`."""
    outcomes = {
        key: Outcome(Repeat(key, family, 1e-3), tuple(own), 1.0, 0.0, 0.0, 100, 1.0, 0.1, modes=modes)
        for key, family, own, modes in ((BASE, "", base, 10), (MORE_MODES, "modes", more, 15))
    }
    spots = []
    for event in base:
        own = {key: of(event) for key, of in FIGURES.items()}
        spots.append(Spot(event, "drawn", own, own | {"impulse": own["impulse"] / (1.0 - E)}))
    structure = Structure((*spots, *beside), first_end=base[0].t_end)
    found = assess(outcomes, "reduced", (0.0, 1.0), 0.01, structure=structure)
    return [e.figures[name].beside[UNREDUCED] for e in found.events]


def test_a_faint_event_after_a_hard_one_inherits_as_the_runs_show():
    """More modes move the hard blow by .1 %, a hundredth of a faint one, and the faint one by 1.5 %: fifteen times its
    error of 1 %, 14 more than blows that are alike pass on. The next one, moved by 3 %, has twice what moved the faint
    one, by .015; an error of a tenth moves it by 20 %."""
    base = [hit(0.1, 10.0), hit(0.3), hit(0.5)]
    more = [hit(0.1, 10.0, 1e-3), hit(0.3, 1.0, 0.015), hit(0.5, 1.0, 0.03)]
    first, faint, last = unreduced("impulse", base, more)
    assert first == pytest.approx(E, rel=1e-6)
    assert faint == pytest.approx(E + 14.0 * E, rel=0.05)
    assert last == pytest.approx(0.2, rel=0.05)


def test_a_faint_event_that_is_far_off_does_nothing_to_a_hard_one():
    """A tap of a hundredth is off by a half; a hard blow after it, moved as little as those before, by next to nothing."""
    base, tap = [hit(0.1, 10.0), hit(0.5, 10.0)], hit(0.3, 0.1)
    own = {key: of(tap) for key, of in FIGURES.items()}
    off = (Spot(tap, "drawn", own, own | {"impulse": 2.0 * own["impulse"]}),)
    *_, last = unreduced("impulse", base, [hit(0.1, 10.0, 1e-3), hit(0.5, 10.0, 1e-3)], off)
    assert last == pytest.approx(E, rel=0.05)


def test_what_a_run_changes_without_moving_the_impulses_before_is_its_own():
    """A hundred-thousandth before and a thousandth of the event: tenfold of that at most, not a hundredfold of 1 %."""
    base = [hit(0.1, 10.0), hit(0.3)]
    _, later = unreduced("impulse", base, [hit(0.1, 10.0, 1e-5), hit(0.3, 1.0, 1.5e-3)])
    assert later == pytest.approx(E + 0.5 * E, rel=0.05)


def test_an_event_that_goes_when_the_one_before_changes_is_all_that_may_be_lost():
    """It is there no more where 2 % are changed: half of it hangs on an error of 1 %."""
    base = [hit(0.1, 10.0), hit(0.3)]
    _, faint = unreduced("impulse", base, [hit(0.1, 10.0, 0.02)])
    assert faint == pytest.approx(0.5, rel=0.05)


def test_blows_that_are_alike_pass_nothing_more_on():
    base = [hit(0.1 * k) for k in range(1, 5)]
    more = [hit(0.1 * k, 1.0, 0.01) for k in range(1, 5)]
    assert unreduced("impulse", base, more) == pytest.approx([E] * 4, rel=0.05)


def test_an_event_that_a_run_lacks_is_no_measure_for_the_next():
    """The first blow is moved by 2 %, the second one is gone, the third one moved by 10 %: five times the first."""
    base = [hit(0.1, 10.0), hit(0.3), hit(0.5)]
    *_, last = unreduced("impulse", base, [hit(0.1, 10.0, 0.02), hit(0.5, 1.0, 0.1)])
    assert last == pytest.approx(E + (0.1 / 1.1 / (0.02 / 1.02) - 1.0) * E, rel=0.05)


def test_where_the_unreduced_model_lacks_an_event_all_bars_are_infinite_and_none_is_unknown():
    base = [hit(0.1, 10.0), hit(0.3)]
    lost = Spot(base[0], "drawn", {key: of(base[0]) for key, of in FIGURES.items()}, None)
    outcomes = {
        key: Outcome(Repeat(key, family, 1e-3), tuple(base), 1.0, 0.0, 0.0, 100, 1.0, 0.1)
        for key, family in ((BASE, ""), (MORE_MODES, "modes"))
    }
    found = assess(outcomes, "reduced", (0.0, 1.0), 0.01, structure=Structure((lost,), first_end=base[0].t_end))
    assert [e.figures["impulse"].beside[UNREDUCED] for e in found.events] == [float("inf")] * 2
    assert found.events[1].figures["closing_speed"].beside[UNREDUCED] == float("inf")
