"""Spot checks: the unreduced model from the reduced one's state through an event, against closed forms and a whole run."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from benchmarks.coverage.closed import cases

import creak
from creak.dynamics import condensed
from creak.dynamics.flow.march import SAMPLES, flow_states
from creak.studies.run.integrate import flowing
from creak.studies.spots import choose
from creak.studies.spots.check import _few_decide, _of_event, _slips, check_spots
from creak.studies.spots.choose import Price, Stretch, affordable
from creak.studies.spots.handover import handed_over
from creak.verify.events import Event
from creak.verify.matching import FIGURES, EventMatch
from creak.verify.unreduced import Spot, Structure, alike_in_size, surely
from helpers_bar import IMPULSE, LASTS, bar
from helpers_decks import STOP, STUDY, write_strips, write_study

MASS, SPRING, PENALTY = 100.0, 1e4, 1e6
OMEGA = math.sqrt((SPRING + PENALTY) / MASS)
STOP_STUDY = """[model]
deck = "strips.inp"
units = "m-kg-s"
[[connector]]
type = "play"
nodes = "TIP"
dof = "x"
upper = 0.01
stiffness = 1e6
[verification]
f_max = 200
[time]
end = 0.5
"""


def solved(folder, study, deck=None, **changes):
    given = creak.change_study(creak.read_study(write_strips(folder, deck=deck, study=study)), changes)
    return creak.run(given)


def closed(folder, name):
    """The study of a closed form of the coverage benchmark."""
    (case,) = (c for c in cases() if c.name == name)
    return write_study(folder, f'[model]\ndeck = "deck.inp"\nunits = "m-kg-s"\n{case.study}', {"deck.inp": case.deck})


# --- against closed forms --------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    return solved(tmp_path_factory.mktemp("stop"), STOP_STUDY, STOP)


def test_a_model_that_is_complete_is_its_own_unreduced_one(stopped):
    """A mass that swings onto a stop: half a period of the pressed spring, momentum 2 m v, of which its own spring takes a part. Both marches,
    exact flow and contact steps, are within what thirty steps to a blow leave (omega h = .1)."""
    speed = math.sqrt(1.0 - SPRING / MASS * 0.01**2)
    pressed = (math.pi - 2.0 * math.atan(SPRING * 0.01 / OMEGA / MASS / speed)) / OMEGA
    impulse = PENALTY * (2.0 * MASS * speed - SPRING * 0.01 * pressed) / (SPRING + PENALTY)
    spots = stopped.summary["verification"]["spots"]
    assert spots
    for spot in spots:
        for key, exact in (("closing_speed", speed), ("duration", pressed)):
            assert spot[key]["unreduced"] == pytest.approx(exact, rel=0.01), key
            assert spot[key]["reduced"] == pytest.approx(exact, rel=0.01), key
        assert spot["impulse"]["unreduced"] == pytest.approx(impulse, rel=0.01)
    assert spots[0]["impulse"]["numerical"] < 0.01
    assert stopped.summary["runs"]["reduced"]["verdict"] == "settled"


@pytest.mark.parametrize(("name", "end"), [("belt squeak", (0.6, 0.2)), ("Coulomb decay", (0.16, 0.08))])
def test_rubbing_is_held_against_the_unreduced_model(tmp_path, name, end):
    """A model of two masses is complete: slips, slid time and heat of both marches are the same, but for a step at the
    ends of a piece. What they differ by is the error of the steps, and tells nothing of the reduction."""
    study = closed(tmp_path, name)
    whole, short = (f"end = {x}" for x in end)
    assert whole in study.read_text()
    study.write_text(study.read_text().replace(whole, short))
    result = creak.run(study)
    pieces = result.summary["verification"]["rub_spots"]
    assert pieces
    for piece in pieces:
        assert piece["slips"]["unreduced"] == piece["slips"]["reduced"]
        for key in ("slip_share", "friction_energy"):
            both = piece[key]
            assert both["unreduced"] == pytest.approx(both["reduced"], rel=0.02), key
    assert not result.convergence.rubs[0].figures["friction_energy"].beside
    assert "Friction and lasting contact against the unreduced model" not in result.page(0.0)


@pytest.mark.parametrize("at", [0.0, 0.4, 0.999])
@pytest.mark.parametrize(("longest", "count"), [(1.0, 8), (0.035, 2)])
def test_a_piece_of_stick_slip_cuts_no_slip(at, longest, count):
    """40 slips of 3 ms, 7 to 13 ms from one to the next: eight of them, or as many as its steps go through."""
    starts = 0.05 + np.cumsum(np.random.default_rng(2).uniform(7e-3, 13e-3, 40))
    slips = [(t, t + 3e-3) for t in starts.tolist()]
    begin, end = _slips(slips, (0.0, 1.0), at, longest)
    inside = [begin <= a and b <= end for a, b in slips]
    assert sum(inside) == (count if longest > 0.1 else pytest.approx(count, abs=1))
    assert all(whole or b < begin or a > end for whole, (a, b) in zip(inside, slips, strict=True))


def test_a_slip_between_long_sticks_is_told_by_itself():
    """Of 2 ms, five a second: no second of sticking is marched with it, whose steps would be as long as the slip."""
    slips = [(t, t + 2e-3) for t in np.arange(0.1, 1.0, 0.2).tolist()]
    begin, end = _slips(slips, (0.0, 1.0), 0.5, 0.1)
    assert (begin, end) == pytest.approx((0.5 - 8e-3, 0.502 + 8e-3))


@pytest.mark.parametrize(
    ("chatter", "lasts", "steps"), [(0, 2e-5, 92), (9, 2e-5, 92), (300, 2e-5, 1472), (300, 2e-6, None)]
)
def test_friction_of_an_event_is_checked_by_steps_that_follow_its_touches(chatter, lasts, steps):
    """A touch of 4 ms, and short ones before it: they may carry a twentieth of the time, or are followed by eight steps
    each, or there is no check. Held together they would rub for as long as they are apart."""
    starts = 5.0 + 1e-4 * np.arange(chatter)
    touches = [*((t, t + lasts) for t in starts.tolist()), (5.5, 5.504)]
    stretch = Stretch(5000, 2, 46, SimpleNamespace(touches=touches), "")
    piece = _of_event(stretch, 1e-4, SimpleNamespace())
    assert (None if piece is None else piece.steps) == steps


def test_a_complete_model_that_begins_with_its_blow_needs_no_spot_check(tmp_path):
    """A mass on its stop from the first instant on: there is no state before the event to take over."""
    told = creak.run(closed(tmp_path, "mass on a spring stop")).summary
    assert told["verification"]["spots"] == []
    assert told["runs"]["reduced"]["verdict"] == "settled"


def test_a_bar_on_a_wall_stays_for_its_wave_only_in_the_unreduced_model(tmp_path):
    """2 L / c and 2 m v (de Saint-Venant). No mode lies below f_max, and none has the wave: the reduced run is told to be far
    off."""
    result = creak.run(bar(tmp_path, "f_max = 5000"))
    (spot,) = result.summary["verification"]["spots"]
    assert spot["duration"]["unreduced"] == pytest.approx(LASTS, rel=0.03)
    assert spot["impulse"]["unreduced"] == pytest.approx(IMPULSE, rel=0.01)
    assert spot["duration"]["reduced"] < 0.5 * LASTS
    reduced = result.summary["runs"]["reduced"]
    assert reduced["verdict"] == "unsettled"
    (event,) = reduced["events"]
    off = abs(event["t_end"] - event["t_start"] - LASTS)
    assert event["settled_to"]["duration"] > off


# --- against the unreduced model's own run ---------------------------------------------------------------------------


WHOLE = STUDY.replace("step = 5e-4\n", "").replace("periods = 2", "periods = 1\n\n[reference]\nrun = true")
WHOLE = WHOLE.replace("f_max = 3000", "f_max = 1e5")


@pytest.fixture(scope="module")
def strips(tmp_path_factory):
    return solved(tmp_path_factory.mktemp("strips"), WHOLE)


def test_spots_are_what_the_whole_run_of_the_unreduced_model_finds(strips):
    """Events that both runs share, of a reduced model with modes enough to follow it: from its state instead of from
    rest, by contact steps alone."""
    partner = {id(b): a for a, b in strips.found.events.pairs}
    spots = [s for s in strips.convergence.structure.spots if id(s.event) in partner]
    assert len(spots) >= 2
    for s in spots:
        whole = partner[id(s.event)]
        for name in ("start", "impulse", "closing_speed"):  # the force is low-passed: it hangs on what is beside it
            of = FIGURES[name]
            scale = whole.t_end - whole.t_start if name == "start" else of(whole)
            assert abs(s.unreduced[name] - of(whole)) <= 0.05 * scale, name


def test_the_whole_run_has_bars_that_cover_what_finer_steps_find(strips, tmp_path):
    """The first blow of the unreduced strips, against a run of them by steps of half the length and less."""
    text = WHOLE.replace("[time]", '[time]\naccuracy = "fine"').replace("run = true", "run = false")
    text = text.replace("periods = 1", "end = 0.07")
    fine = solved(tmp_path, text, **{"reduction.method": "none"})
    (run,) = fine.summary["runs"].values()
    exact, first = run["events"][0], strips.summary["runs"]["reference"]["events"][0]
    told = first["settled_to"]
    for key in ("impulse", "closing_speed"):
        assert abs(first[key] / exact[key] - 1.0) <= told[key] < 0.1, key
    assert abs(first["t_start"] - exact["t_start"]) <= told["t_start"]
    (reduced, *_) = strips.summary["runs"]["reduced"]["events"]
    assert reduced["settled_to"] != told


def test_the_state_taken_over_is_that_of_the_run(strips):
    """Displacement of the second march at its flight steps, and velocity, against those that the run kept."""
    found = strips.found
    of, _ = handed_over(found.band, found.reference)
    at = [4, 9]
    states = flow_states(of.reduced, of.gaps, of.loads, at, resolution=found.setup.marching.resolution)
    h = of.history
    labels = found.setup.contacts.labels[:3]
    rows = found.reduced.system.rows(labels)
    kept = {int(k): j for j, k in enumerate(h.whole_at)}
    assert flowing(found.reduced.system)[0].n == states.coordinates.shape[0]
    for j, step in enumerate(at):
        s = of.loads.support[:, SAMPLES * step]
        u = rows[0] @ states.coordinates[:, j] + rows[1] @ s[0]
        if step in kept:
            np.testing.assert_allclose(u, rows[0] @ h.coordinates[:, kept[step]] + rows[1] @ s[0], rtol=1e-12)
    assert np.isfinite(states.velocities).all()


@pytest.mark.parametrize("kept", [True, False])
def test_marches_side_by_side_are_those_one_by_one(strips, monkeypatch, kept):
    """With the response of the channels kept, and solved for at each contact: nothing of one march is in another."""
    result = strips.found
    of = replace(handed_over(result.band, result.reference)[0], budget=0.0)  # as few as there are at any cost
    monkeypatch.setattr(choose, "STEPS", 10)
    monkeypatch.setattr(condensed, "RESPONSE_MEMORY", condensed.RESPONSE_MEMORY if kept else 0)
    monkeypatch.setattr("creak.studies.spots.march.STEP", 0)  # small models are marched one by one
    several = [check_spots(result.band, of, lambda *_: None).spots for _ in range(2 if kept else 1)]

    def alone(solver, works, counted=int):
        return [work(solver) for work in works]

    monkeypatch.setattr("creak.studies.spots.march.side_by_side", alone)
    one = check_spots(result.band, of, lambda *_: None).spots
    assert len(one) > 2
    for other in several:
        assert other == several[0]  # whatever thread is faster
    for a, b in zip(several[0], one, strict=True):
        assert (a.event, a.why, a.problem) == (b.event, b.why, b.problem)
        assert a.unreduced == pytest.approx(b.unreduced, rel=1e-7)


def test_summary_tells_them(strips):
    told = json.loads(json.dumps(strips.summary["verification"], allow_nan=False))
    events = strips.summary["runs"]["reduced"]["events"]
    assert told["spots"][0]["why"] == "hardest"
    for spot in told["spots"]:
        assert events[spot["event"]]["t_start"] == pytest.approx(spot["t_start"]["reduced"], abs=1e-9)
        assert spot["place"] == 1
    assert told["spot_cost"]["back_substitutions"] > 0
    assert told["spots_missing"] is None


def test_without_proof_nothing_is_settled(tmp_path):
    text = STUDY.replace("step = 5e-4\n", "").replace("periods = 2", "end = 0.1\n\n[reference]\nrun = false")
    reduced = solved(tmp_path, text).summary["runs"]["reduced"]
    assert reduced["verdict"] == "unsettled"
    assert "[reference]" in reduced["reasons"][0]


# --- what follows from them ------------------------------------------------------------------------------------------


def hit(t, force=1.0):
    return Event("c", "c:1", 0, t, t + 1e-3, t + 2e-3, force, force, 1e-3 * force, 5.0, 1, force)


def spot(event, by, lost=False):
    own = {name: of(event) for name, of in FIGURES.items()}
    other = None if lost else own | {"impulse": own["impulse"] * (1.0 + by), "start": own["start"] + by * 1e-3}
    return Spot(event, "drawn", own, other)


def test_differences_cover_the_next_one_as_often_as_said():
    """Normal differences: the interval of t covers 95 of 100 further ones, however few are known."""
    rng = np.random.default_rng(5)
    for n in (1, 3, 8):
        known = rng.standard_normal((20_000, n + 1))
        inside = np.abs(known[:, -1]) <= np.sqrt(np.mean(known[:, :-1] ** 2, axis=1)) * surely(n)
        assert inside.mean() == pytest.approx(0.95, abs=0.006)


def test_events_that_were_looked_at_have_their_own_difference():
    a, b, c = hit(0.1), hit(0.2), hit(0.3)
    of = Structure((spot(a, 0.01), spot(b, -0.04)), first_end=a.t_end)
    worst = 0.04 / 0.96
    assert of.change("impulse", a) == pytest.approx(0.01 / 1.01)  # nothing was before it
    assert of.change("impulse", b) == pytest.approx(worst)
    rms = math.sqrt(((0.01 / 1.01) ** 2 + worst**2) / 2)
    assert of.change("impulse", c) == pytest.approx(rms * surely(2))
    assert of.change("closing_speed", a) == 0.0
    assert of.change("closing_speed", c) == pytest.approx(worst)  # by what impulses before it move
    rest = 2.0 * 0.04 / 0.96 * (c.t_end - c.t_start)
    assert of.change("start", c) == pytest.approx(math.sqrt((1e-5**2 + 4e-5**2) / 2) * surely(2) + rest)


def test_an_event_that_the_unreduced_model_has_not_has_no_bar():
    a, b = hit(0.1), hit(0.2)
    of = Structure((spot(a, 0.0, lost=True),))
    assert of.change("impulse", a) == of.change("impulse", b) == math.inf


def test_its_own_run_votes():
    a, b = hit(0.1), hit(0.2)
    of = Structure((spot(a, 0.01),)).beside(EventMatch([(replace(a, impulse=1.1e-3), a)], [], [b]), None)
    assert of.change("impulse", a) == pytest.approx(0.1 / 1.1)
    assert of.extra == (b,)


def test_of_a_complete_model_its_own_run_counts_and_spot_checks_do_not():
    """These tell of the error of their own steps."""
    a, b = hit(0.1), hit(0.2)
    alone = Structure((spot(a, 0.3),), complete=True)
    assert alone.looked
    assert not alone.counts
    beside = alone.beside(EventMatch([(replace(a, impulse=1.01e-3), a)], [], []), None)
    assert beside.counts
    assert beside.change("impulse", a) == pytest.approx(0.01 / 1.01)
    assert beside.change("impulse", b) == pytest.approx(0.01 / 1.01 * surely(1))
    assert beside.of_sum("impulse") == pytest.approx(0.01, rel=0.02)


def test_as_many_are_checked_as_the_cost_allows():
    order = [Stretch(0, parts, 100, hit(t), "drawn") for t, parts in ((0.1, 50), (0.2, 100), (0.3, 50), (0.4, 50))]
    price = Price(0.0, 90.0, 0.0, 1.0)  # a factor as 50 solutions, 40 channels
    assert affordable(order, price, 300.0, 0) == [order[0], order[2]]  # 190, another factor would be 190 more, 100
    assert affordable(order, price, 0.0, 3) == order[:3]


def test_as_many_again_are_checked_where_their_small_number_decides():
    """Three whose impulse is 2.8, .3 and .2 % off leave 5.2 % open of the others: six of that size 4 %."""
    many = [spot(hit(t), by) for t, by in ((0.1, 0.028), (0.2, 0.003), (0.3, 0.002))]
    others = [hit(t) for t in (0.5, 0.6, 0.7)]
    assert Structure(tuple(many)).spread("impulse", others[0]) > 0.05
    assert _few_decide(many, others)
    assert not _few_decide([spot(hit(t), 0.003) for t in (0.1, 0.2, 0.3)], others)  # they are enough
    assert not _few_decide([spot(hit(t), 0.1) for t in (0.1, 0.2, 0.3)], others)  # no number of them would be
    assert not _few_decide([*many, spot(hit(0.4), 0.0, lost=True)], others)
    assert not _few_decide([replace(s, problem="not there") for s in many], others)


def test_a_faint_tap_that_is_far_off_says_nothing_of_a_blow():
    """Impulses that are off by 1e-5 each, be they large or small: blows have 1 % then, whatever share of a tap it is."""
    blows = [hit(0.1 * k) for k in range(1, 5)]
    of = Structure((*(spot(e, 0.01) for e in blows), *(spot(hit(t, 0.05), 0.2) for t in (0.5, 0.6, 0.7))))
    later, tap = hit(0.9), hit(1.0, 0.05)
    assert of.change("impulse", later) == pytest.approx(0.01 * surely(7), rel=0.1)
    assert of.change("impulse", tap) == pytest.approx(0.2 * surely(7), rel=0.1)
    assert of.inherited(later) == pytest.approx(0.01, rel=0.02)
    assert of.inherited(tap) == pytest.approx(0.2 / 1.2)


def test_shares_that_are_alike_are_seldom_taken_for_others():
    """A ratio of likelihoods of 20 comes by chance once in 20 at most, whatever the sizes of the figures."""
    rng = np.random.default_rng(7)
    for n in (3, 8):
        wrong = [alike_in_size(rng.normal(size=n), rng.lognormal(sigma=2.0, size=n)) for _ in range(2000)]
        assert np.mean(wrong) < 0.05 + 2.0 * math.sqrt(0.05 / 2000)
    sizes = rng.lognormal(sigma=2.0, size=(200, 8))
    assert np.mean([alike_in_size(rng.normal(size=8) / x, x) for x in sizes]) > 0.9
    assert not alike_in_size(np.zeros(3), np.ones(3))
    assert not alike_in_size(np.array([0.1, np.inf, 0.1]), np.ones(3))
    assert not alike_in_size(np.full(3, 0.1), np.array([1.0, 1.0, 0.0]))


def test_those_again_are_other_events_by_the_same_steps(strips, monkeypatch):
    result = strips.found
    monkeypatch.setattr(choose, "STEPS", 10)
    of, _ = handed_over(result.band, result.reference)
    every = check_spots(result.band, of, lambda *_: None)
    asked = []

    def decides(spots, more):
        asked.append((len(spots), len(more)))
        return True

    monkeypatch.setattr("creak.studies.spots.check._few_decide", decides)
    found = check_spots(result.band, replace(of, budget=every.solves / len(every.spots)), lambda *_: None)
    ((few, more),) = asked
    assert len(found.spots) == few + more > few
    assert len({id(s.event) for s in found.spots}) == few + more
    assert [s.numerical is None for s in found.spots] == [False] + [True] * (few + more - 1)
    for s in found.spots:
        (same,) = (o for o in every.spots if o.event is s.event)
        assert s.unreduced == pytest.approx(same.unreduced, rel=1e-9)
