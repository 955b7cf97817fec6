"""What repeated runs say of friction and of contact that lasts, and which verdict follows."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from creak.studies.converge.compared import assess
from creak.studies.converge.settled import SETTLED, STATISTICS, UNSETTLED, Verdict, place_settled_to, verdict_of_runs
from creak.studies.converge.settling import BASE, FINER, LAST_TWO, MORE_MODES, SMALL, STIFFER, Followed, Outcome, Repeat
from creak.studies.converge.words import as_dict, findings
from creak.verify.rubbing import Pressing, Rub, Rubbing

END = 1.0
FORCE = Pressing(10.0, 1.0)


def squeak(starts=None, share=0.2, energy=1.0, shares=(0.1, 0.9, 0.0)) -> Rubbing:
    starts = np.arange(0.01, END, 0.01) if starts is None else starts
    return Rubbing(END, shares, share * END, tuple((t, t + 0.002) for t in starts), energy, share, energy)


def slides(energy=1.0) -> Rubbing:
    return Rubbing(END, (0.0, 0.0, 1.0), END, (), energy, 1.0, energy)


def sticks() -> Rubbing:
    return Rubbing(END, (1.0, 0.0, 0.0), 0.0, (), 0.0, 0.0, 0.0)


def verdict(told=(), **runs: Rub | tuple[Rub, ...]) -> Verdict:
    """Of runs named base, finer, stiffer, modes."""
    return verdict_of_runs(convergence(told, **runs))


def convergence(told=(), **runs: Rub | tuple[Rub, ...]):
    names = {"base": BASE, "finer": FINER, "stiffer": STIFFER, "modes": MORE_MODES}
    outcomes = {}
    for key, rubs in runs.items():
        family = next((f for f, pair in LAST_TWO.items() if pair == (BASE, names[key])), "")
        repeat = Repeat(names[key], family, 1e-3, judged=key not in told)
        every = rubs if isinstance(rubs, tuple) else (rubs,)
        modes = 15 if names[key] == MORE_MODES else 10
        outcomes[names[key]] = Outcome(repeat, (), 1.0, 0.0, 0.0, 100, END, 0.1, modes=modes, rubs=every)
    count = len(outcomes[BASE].rubs)
    places = [("belt", k + 1) for k in range(count)]
    return assess(outcomes, "reduced", (0.0, END), 0.002, places=Followed(rub_names=tuple(places)))


def test_the_same_squeak_in_all_runs_is_settled():
    same = Rub(squeak(), FORCE)
    assert verdict(base=same, finer=same, modes=same) == Verdict(SETTLED, ())


def test_a_rate_that_changes_with_the_modes_is_unsettled_and_names_them():
    other = Rub(squeak(np.arange(0.01, END, 0.02), share=0.19), FORCE)
    said = verdict(base=Rub(squeak(), FORCE), finer=Rub(squeak(), FORCE), modes=other)
    assert said.word == UNSETTLED
    assert "number of slips" in said.reasons[0]
    assert "slips per second" in said.reasons[0]
    assert "the modes" in said.reasons[1]


@pytest.mark.parametrize(("other", "word"), [(slides(), "sliding"), (sticks(), "stick")])
def test_another_state_is_unsettled_both_ways(other, word):
    for a, b in ((squeak(), other), (other, squeak())):
        said = verdict(base=Rub(a, FORCE), finer=Rub(a, FORCE), modes=Rub(b, FORCE))
        assert said.word == UNSETTLED
        assert f"{word} with " in said.reasons[0]


def test_a_state_that_turns_by_a_hair_is_none():
    a, b = squeak(shares=(0.0, 0.51, 0.49)), squeak(shares=(0.0, 0.49, 0.51))
    assert verdict(base=Rub(a, FORCE), finer=Rub(b, FORCE)).word == SETTLED


def test_regular_slips_may_come_later():
    late = squeak(np.arange(0.01, END, 0.01) + 0.005)
    assert verdict(base=Rub(squeak(), FORCE), finer=Rub(late, FORCE)) == Verdict(SETTLED, ())


def test_irregular_slips_that_part_are_statistics():
    rng = np.random.default_rng(1)
    a, b = (np.sort(rng.uniform(0.0, END, 100)) for _ in range(2))
    a[0] = b[0] = 0.0
    a[-1] = b[-1] = END  # the same rate
    said = verdict(base=Rub(squeak(a), FORCE), finer=Rub(squeak(b), FORCE))
    assert said.word == STATISTICS
    assert "single slips part" in said.reasons[0]
    assert verdict(base=Rub(squeak(a), FORCE), finer=Rub(squeak(a + 1e-5), FORCE)).word == SETTLED


def test_rates_of_slips_that_part_are_those_of_samples():
    """100 slips of a Poisson process against 110 are alike, against 160 they are not: 1.96 sqrt(1/100 + 1/160) = .25.

    Of slips as regular as a clock 100 and 110 are not.
    """
    rng = np.random.default_rng(2)

    def rain(n: int) -> Rub:
        between = rng.exponential(1.0, n - 1)
        return Rub(squeak(np.concatenate([[0.0], np.cumsum(between) / between.sum()]) * 0.99), FORCE)

    base = rain(100)
    assert verdict(base=base, finer=rain(110)).word == STATISTICS
    assert verdict(base=base, finer=rain(160)).word == UNSETTLED
    clocks = [Rub(squeak(np.linspace(0.0, 0.99, n)), FORCE) for n in (100, 110)]
    assert verdict(base=clocks[0], finer=clocks[1]).word == UNSETTLED


def test_one_slip_more_is_none():
    starts = np.arange(0.1, END, 0.1)
    assert verdict(base=Rub(squeak(starts), FORCE), finer=Rub(squeak(starts[1:]), FORCE)).word == SETTLED
    assert verdict(base=Rub(squeak(starts), FORCE), finer=Rub(squeak(starts[2:]), FORCE)).word == UNSETTLED


def test_energy_of_steady_sliding_must_settle():
    assert verdict(base=Rub(slides(), FORCE), finer=Rub(slides(1.03), FORCE)).word == SETTLED
    said = verdict(base=Rub(slides(), FORCE), finer=Rub(slides(1.1), FORCE))
    assert said.word == UNSETTLED
    assert "energy by friction by 12 %" in said.reasons[0]


def test_a_squeak_that_dies_out_later_is_unsettled():
    """For a quarter of the time or for a third of it: what slides most of the time in both is not the same."""
    a, b = (replace(slides(), shares=(0.0, x, 1.0 - x)) for x in (0.25, 0.35))
    said = verdict(base=Rub(a, FORCE), finer=Rub(b, FORCE))
    assert said.word == UNSETTLED
    assert "other parts of the time" in said.reasons[0]
    a, b = (replace(a, slips=tuple((t, t + 1e-3) for t in np.linspace(0.0, 0.2, n))) for n in (22, 44))
    said = verdict(base=Rub(a, FORCE), finer=Rub(b, FORCE))
    assert said.word == UNSETTLED
    assert "slips per second" in said.reasons[0]


def test_slips_of_what_slides_or_sticks_in_all_runs_decide_nothing():
    a, b = (replace(slides(), slips=tuple((0.001 * k, 0.001 * k + 5e-4) for k in range(n))) for n in (12, 30))
    assert verdict(base=Rub(a, FORCE), finer=Rub(b, FORCE)).word == SETTLED
    once = replace(sticks(), slip_time=1e-3, energy=1e-9)
    assert verdict(base=Rub(sticks(), FORCE), finer=Rub(once, FORCE)).word == SETTLED


@pytest.mark.parametrize(
    ("other", "word"),
    [
        (Pressing(10.3, 1.0), SETTLED),
        (Pressing(11.0, 1.0), UNSETTLED),
        (Pressing(10.0, 1.2), UNSETTLED),
        (None, UNSETTLED),
    ],
)
def test_lasting_contact_without_friction_is_judged_by_its_force(other, word):
    assert verdict(base=Rub(None, FORCE), finer=Rub(None, other)).word == word


def test_a_force_that_hardly_moves_may_move_otherwise():
    still, other = Pressing(10.0, 1e-9), Pressing(10.0, 5e-9)
    assert verdict(base=Rub(None, still), finer=Rub(None, other)).word == SETTLED


def test_a_given_stiffness_is_told_and_unsettles_nothing():
    a, b = Rub(squeak(), FORCE), Rub(slides(), FORCE)
    assert verdict(("stiffer",), base=a, finer=a, stiffer=b) == Verdict(SETTLED, ())
    assert verdict(base=a, finer=a, stiffer=b).word == UNSETTLED


def test_faint_friction_is_told_and_decides_nothing():
    loud = Rub(squeak(energy=100.0), FORCE)
    said = verdict(base=(loud, Rub(squeak(energy=1.0))), finer=(loud, Rub(slides(energy=1.0))))
    assert said.word == SETTLED
    assert "place 2" in said.reasons[0]


def test_a_run_that_stopped_settles_nothing():
    c = convergence(base=Rub(squeak(), FORCE), finer=Rub(squeak(), FORCE))
    short = replace(c.outcomes[FINER], stopped="it diverged", rubs=())
    c = assess(c.outcomes | {FINER: short}, "reduced", (0.0, END), 0.002, places=Followed(rub_names=(("belt", 1),)))
    assert not c.rubs[0].settled
    assert verdict_of_runs(c).word == UNSETTLED


def test_what_no_longer_touches_in_another_run_is_unsettled():
    said = verdict(base=Rub(squeak(), FORCE), finer=Rub())
    assert said.word == UNSETTLED
    assert "the force of the whole run is not known in all runs" in said.reasons
    assert any("which not all runs have" in reason for reason in said.reasons)


def test_more_than_all_of_it_is_told_in_whole_per_cent():
    said = verdict(base=Rub(squeak(share=0.2), FORCE), modes=Rub(squeak(share=0.8), FORCE))
    assert any(re.search(r"share of slip by 1\d\d %", reason) for reason in said.reasons), said.reasons


def test_it_is_told():
    c = convergence(base=Rub(squeak(), FORCE), finer=Rub(squeak(share=0.202), FORCE), modes=Rub(slides(), FORCE))
    to = place_settled_to(c, 1)
    assert to["slip_share"] == sum(c.rubs[0].figures["slip_share"].sources.values()) >= 0.8
    assert to["force_mean"] == pytest.approx(SMALL)
    assert to["slips"] == pytest.approx(2.0)  # of the most that any run has, and modes count twice
    assert to["slip_rate"] is None
    (told,) = as_dict(c)["friction"]
    assert told["states"] == {BASE: "stick-slip", FINER: "stick-slip", MORE_MODES: "sliding"}
    assert told["turned"] == ("modes",)
    assert any("friction changes from run to run" in text for text in findings(c))
