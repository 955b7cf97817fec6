"""The first screen: what rattles, how audible, how sure, by summaries of which the answer is plain."""

from __future__ import annotations

import pytest

from creak.report.words.answer import AMBER, GREEN, RED, answer, tiles
from creak.report.words.terminal import _fitting, answer_lines


def place(name="rib 1", events=4, force=2.0, n5=None, **more):
    base = {"name": name, "events": events, "slips": 0, "friction": None, "force": force, "n5": n5, "n5_added": None}
    base |= {"n_max": n5, "n_max_added": None}
    base["level"] = None if n5 is None else 40.0
    return {**base, "cause": None, **more}


def summary(places=(), *, verdict="settled", limits=(), sound=None, unanswered="", stopped=None, reasons=()):
    run = {"places": list(places), "end": 2.0, "verdict": verdict, "reasons": list(reasons)}
    return {
        "runs": {"reduced": run},
        "units": "mm-t-s",
        "sound": sound,
        "limits": list(limits),
        "unanswered": unanswered,
        "stopped": stopped,
        "verification": {"window": [1.0, 2.0]},
    }


def limit(failed=(), missing=None):
    return {
        "limit": "force",
        "allowed": 5.0,
        "unit": "N",
        "failed": [{"name": n, "value": v} for n, v in failed],
        "missing": missing,
    }


def test_a_place_that_is_heard_rarely_is_told_by_its_loudest_instant():
    """N5 of a blow in 20 s is the dust of its decay: it says nothing of how loud it was, nor which place is louder."""
    places = [place("soft", n5=2.2e-4, n_max=3.35), place("loud", n5=0.0, n_max=9.98)]
    told = answer(summary(places, sound={"level": 30.0, "n5": 3e-4, "n_max": 9.98, "beside_background": False}))
    assert told.headline == "2 places rattle; worst is loud: rare, up to 10 sone"
    assert tiles(told, "settled")[1].detail.startswith("heard in less than 5 % of the time, up to 10 sone; ")
    assert "Nmax 10 sone" in " ".join(answer_lines(summary(places)))


@pytest.mark.parametrize(
    ("told", "light"),
    [
        (summary(), GREEN),
        (summary(verdict="unsettled"), AMBER),
        (summary([place(force=0.05)]), GREEN),
        (summary([place(force=0.05)], verdict="unsettled"), AMBER),
        (summary([place(force=2.0)]), AMBER),
        (summary([place(n5=0.05)]), GREEN),
        (summary([place(n5=0.05, n_max=8.0)]), AMBER),
        (summary([place(n5=0.5)]), AMBER),
        (summary([place(n5=9.0)]), RED),
        (summary([place(n5=9.0)], limits=[limit()]), GREEN),
        (summary([place(n5=9.0)], limits=[limit()], verdict="unsettled"), AMBER),
        (summary([place()], limits=[limit([("rib 1", 7.0)])]), RED),
        (summary([place()], limits=[limit(missing="the run was not heard")]), AMBER),
        (summary([place(force=0.0)], verdict="unreliable"), RED),
        (summary(unanswered="nothing can touch"), RED),
        (summary(stopped="interrupted at t = 0.1 s"), RED),
    ],
)
def test_the_light(told, light):
    """A limit of the user's decides where there is one; a run that nobody should rely on is never green."""
    assert answer(told).light == light
    assert answer_lines(told)[0].startswith(light.upper())


def test_figures_in_other_units_are_told_first_and_judge_nothing():
    """A force of 2 in a deck in inches is 8.9 N: neither word nor colour may go by it."""
    odd = "the deck looks to be in mm-kg-ms, not in mm-t-s as the study says"
    for force in (0.05, 2.0, 50.0):
        told = summary([place(force=force)]) | {"other_units": odd}
        assert answer(told).light == AMBER
        assert (
            answer(told).headline
            == f"T{odd[1:]}, so no figure is in the unit beside it. 1 place rattles; worst is rib 1"
        )
        first = " ".join(answer_lines(told)[:2])
        assert first.startswith("AMBER: The deck looks to be in mm-kg-ms")
        assert not any(word in first for word in ("soft", "moderate", "hard", "sone", " N"))
        assert odd in answer(told).why
    failed = summary([place()], limits=[limit([("rib 1", 7.0)])]) | {"other_units": odd}
    assert answer(failed).light == RED


def test_the_words_say_whose_they_are():
    assert "creak's own scale" in answer(summary([place()])).why
    assert answer(summary([place()], limits=[limit()])).why == "limit force = 5 N holds everywhere"


def test_rates_are_those_of_the_window():
    """Four events and six slips in its one second, though the run takes two."""
    found = answer(summary([place(slips=6, friction="stick-slip")]))
    assert found.rate == pytest.approx(10.0)
    assert found.places[0].does == "rattles and squeaks"


def test_what_sticks_most_of_the_time_does_not_slide():
    """Beside `friction = "stick"` it slips at times; the rate of a squeak is told beside the mean one."""
    odd = [place("a", 0, slips=2, friction="stick"), place("b", 0, friction="stick"), place("c", 0, friction="sliding")]
    assert [p.does for p in answer(summary(odd)).places] == ["slips", "slides now and then", "slides"]
    assert answer(summary(odd[:1])).headline.startswith("1 place slips; ")
    squeaks = place("d", 0, slips=3, slip_rate=12.0, friction="stick-slip")
    assert tiles(answer(summary([squeaks])), "Settled.")[2].detail == "touches and slips at 1 place"
    assert any(" squeaks, 3.0 a second (12 slips in a squeak), " in line for line in answer_lines(summary([squeaks])))


def test_what_hits_at_two_places_at_once_is_one_event():
    """As the verdict below counts it; each place has its own rate."""
    told = summary([place("left", force=2.0), place("right", force=2.0)])
    told["runs"]["reduced"]["events"] = [event(1.0 + 0.2 * k, 2.0) for k in range(1, 5)]
    found = answer(told)
    assert found.rate == pytest.approx(4.0)
    assert [p.rate for p in found.places] == pytest.approx([4.0, 4.0])
    tile = tiles(found, "Settled.")[2]
    assert (tile.value, tile.detail) == ("4.0", "at 2 places")


def test_the_worst_is_the_loudest_where_it_is_heard():
    found = answer(summary([place("a", force=9.0, n5=0.2), place("b", force=1.0, n5=2.0)]))
    assert found.headline == "2 places rattle; worst is b: clearly audible, 2.0 sone"


def test_beside_a_background_what_it_adds_counts():
    sound = {"beside_background": True, "level": 60.0, "n5": 9.0, "n5_added": 0.3, "n_max_added": 0.4}
    sound["band"] = {"low": 20.0, "high": 900.0}
    found = answer(summary([place(n5=9.0, n5_added=0.3)], sound=sound))
    assert (found.light, found.n5, found.places[0].n5) == (AMBER, 0.3, 0.3)
    loud = tiles(found, "Settled.")[1]
    assert (loud.label, loud.value) == ("loudness added to the background", "0.30 sone")
    assert loud.detail.startswith("faint; from 20 to 900 Hz; ")
    assert found.headline.endswith(": faint, 0.30 sone added to the background")
    assert ", adds 0.30 sone" in answer_lines(summary([place(n5=9.0, n5_added=0.3)], sound=sound))[1]


@pytest.mark.parametrize(
    ("forces", "told"),
    [
        ((), "nothing touches"),
        ((29.997,), "nothing hits or slips (1 patch rests with 30.0 N)"),
        ((20.0, 5.5), "nothing hits or slips (2 patches rest with 25.5 N)"),
        ((20.0, None), "nothing hits or slips (2 patches rest)"),
    ],
)
def test_what_rests_touches(forces, told):
    """Parts that press all the time are no place, but they do touch."""
    still = summary()
    still["runs"]["reduced"]["resting"] = [{"contact": "base", "force_mean": f} for f in forces]
    found = answer(still)
    assert found.why == told
    assert tiles(found, "Settled.")[0].detail == told
    assert answer_lines(still)[-1] == f"why GREEN: {told}"


def test_what_touched_before_the_window_is_not_denied():
    earlier = summary()
    earlier["verification"]["window"] = [1.0, 1.5]
    earlier["runs"]["reduced"]["events"] = [{"t_start": 0.1, "t_end": 0.2, "force_place": 2.2}]
    found = answer(earlier)
    assert "before that 1 event" in found.headline
    assert found.why == tiles(found, "Settled.")[0].detail == "nothing touches from 1.00 s on"


@pytest.mark.parametrize("count", [0, 1, 3, 40])
def test_eight_lines_of_eighty_columns(count):
    cause = {"words": "mode 3 at 44 Hz of the panel, " * 9, "changes_words": ["a clip at node 17, " * 9]}
    places = [place(f"a rather long name of a contact pair {k}", cause=cause, n5=1.0) for k in range(count)]
    lines = answer_lines(summary(places))
    assert len(lines) <= 8
    assert all(len(line) <= 80 for line in lines)
    assert len(tiles(answer(summary(places)), "Settled.")) == 4


def test_a_long_text_goes_on_where_there_are_lines_left():
    cause = {
        "words": "mode 3 at 44 Hz of the panel, " * 4 + "end",
        "changes_words": ["a clip at node 17, " * 5 + "end"],
    }
    lines = answer_lines(summary([place("rib", cause=cause, n5=1.0)]))
    assert len(lines) <= 8
    assert " ".join(" ".join(lines).split()).count("end") == 2
    assert not any("[...]" in line for line in lines)


def test_a_text_that_does_not_fit_ends_with_a_clause():
    """Not amid one: '-0.674 mm by [...]' says less than nothing."""
    begin = "cause: at 0.537 s the gap of 0.396 mm had closed by 0.399 mm"
    assert _fitting(f"{begin}: -0.674 mm by excitation road_y, 0.442 mm by a clip", 1) == [begin]
    places = [f"a rather long name {k} (12.5 sone)" for k in range(3)]
    assert _fitting(f"limit fails at {', '.join(places)}", 1) == [f"limit fails at {places[0]}, ..."]
    assert _fitting("; ".join(places), 1) == ["; ".join(places[:2])]
    (cut,) = _fitting("one word after another " * 9, 1)
    assert cut.endswith("[...]")


def test_the_first_screen_says_where_when_and_who_hears_it():
    """The hardest event of the window at a node of the place; the listener of the study, or the ear that creak took."""
    told = summary(
        [place("rib 1", nodes=[7, 8], n5=5.0)], sound={"level": 60.0, "n5": 5.0, "n_max": 6.0, "listener": "driver"}
    )
    hits = [(0.5, 9.0, 7), (1.3, 2.0, 8), (1.6, 1.0, 7), (1.7, 3.0, 99)]
    told["runs"]["reduced"]["events"] = [
        {**event(t, force), "node": node, "channel": f"rib:PANEL-1.{node}"} for t, force, node in hits
    ]
    where, loud = tiles(answer(told), "Settled.")[:2]
    assert where.detail == "rattles; 2.00 N at node PANEL-1.8, 1.290\u00a0s"
    assert loud.detail.startswith("loud to an ear off the loudest panel; ")
    told["sound"]["given"] = True
    assert tiles(answer(told), "Settled.")[1].detail.startswith("loud to driver; ")


def test_a_long_name_of_the_only_place_is_not_cut():
    squeaks = place("trimbottom-foamtop 1", slips=20, slip_rate=416.0, friction="stick-slip", n5=83.0, force=113.0)
    lines = answer_lines(summary([squeaks]))
    assert "trimbottom-foamtop 1 rattles and squeaks" in " ".join(" ".join(lines).split())
    assert all(len(line) <= 80 for line in lines)


def test_how_sure_is_said_in_a_word():
    found = answer(summary())
    assert tiles(found, "Settled.")[3].value == "Settled"
    unsure = tiles(found, "Not checked: it was not repeated. More.")[3]
    assert (unsure.value, unsure.detail) == ("Not checked", "why stands below")


def test_what_is_louder_than_the_standard_reaches_is_loud():
    """Its N5 is none then, as that of a place that was not heard."""
    found = answer(summary([place(force=0.01, level=130.0)]))
    assert (found.light, found.headline) == (RED, "1 place rattles; worst is rib 1: loud, beyond ISO 532-1")
    assert answer(summary([place(force=0.01)])).light == GREEN


def event(t_end, force):
    return {"t_start": t_end - 0.01, "t_end": t_end, "force_place": force}


@pytest.mark.parametrize(
    ("places", "events", "told"),
    [
        ([], [event(0.2, 30.0), event(0.4, 9.0)], "before that 2 events, the hardest 30.0 N"),
        ([place(force=2.0)], [event(0.2, 30.0), event(1.5, 2.0)], "1 event, the hardest 30.0 N"),
        ([place(force=20.0)], [event(0.2, 30.0)], ""),
        ([], [], ""),
    ],
)
def test_what_hit_harder_before_is_told(places, events, told):
    """Only the last second of two counts."""
    said = summary(places)
    said["runs"]["reduced"]["events"] = events
    lines = " ".join(" ".join(answer_lines(said)).split())
    assert (told in lines) if told else "before that" not in lines


def eline(name, risk=False, squeak="no", of="contact", tolerance=0.2):
    figures = {"risk": risk, "squeak": squeak, "margin": -0.1 if risk else 0.1, "tolerance": tolerance}
    return {"name": name, "linear": None, "contact": None, of: figures}


@pytest.mark.parametrize(
    ("failed", "lines", "verdict", "light", "told"),
    [
        ([], [], "settled", GREEN, "Nothing rattles or squeaks in 1.00 s"),
        ([], [eline("a"), eline("b", of="linear")], "settled", GREEN, "Nothing rattles or squeaks in 1.00 s"),
        ([], [eline("rests", True, tolerance=0.0)], "settled", GREEN, "Nothing rattles or squeaks in 1.00 s"),
        (["in_plane"], [], "settled", RED, "The run is quiet in 1.00 s, but limit in_plane fails"),
        (
            ["tolerance", "in_plane"],
            [eline("pts", True, "yes"), eline("file", True, "yes"), eline("c", True, "possible")],
            "settled",
            RED,
            "The run is quiet in 1.00 s, but limits tolerance and in_plane fail and tolerances let E-lines pts and file "
            "squeak",
        ),
        ([], [eline("c", True, None, "linear")], "settled", AMBER, "but tolerances let E-line c touch"),
        ([], [eline(n, True, "yes") for n in "abcde"], "settled", AMBER, "E-lines a, b, c and 2 more squeak"),
        ([], [], "unreliable", RED, "The run is quiet in 1.00 s, but it cannot be relied on"),
    ],
)
def test_a_quiet_run_with_something_wrong_says_what(failed, lines, verdict, light, told):
    """Nothing rattles in the run: that is no headline under a red light, nor where tolerances let a line squeak."""
    limits = [{**limit([("pts", 1.1)]), "limit": name} for name in failed]
    found = answer({**summary(verdict=verdict, limits=limits), "elines": {"lines": lines}})
    assert found.light == light
    assert told in found.headline
    assert ("Nothing" in found.headline) == (light == GREEN)
    assert found.light != AMBER or found.why in found.headline
    held = {**limit(), "limit": "force"}
    with_held = answer({**summary(verdict=verdict, limits=[*limits, held]), "elines": {"lines": lines}})
    assert (with_held.light, with_held.headline) == (found.light, found.headline)


def test_of_a_run_that_stopped_before_what_is_counted_nothing_is_known():
    """Quiet is what was looked at and did nothing; of a run that did not come there it is no answer."""
    ended, stopped = summary(), summary(stopped="interrupted at t = 0.7 s")
    stopped["runs"]["reduced"]["end"] = 0.7
    assert [t.value for t in tiles(answer(ended), "")][:3] == ["none", "not heard", "0"]
    told = tiles(answer(stopped), "")
    assert [t.value for t in told][:3] == ["not known"] * 3
    assert told[0].detail == told[2].detail == "the run stopped before what is counted"
    stopped["runs"]["reduced"]["end"] = 1.5
    assert tiles(answer(stopped), "")[0].value == "none"


def test_loudness_that_is_not_computed_is_not_taken_for_silence():
    coupled = {"missing": "none: damping couples the modes of the reduced model"}
    loud = tiles(answer(summary([place(force=20.0)], sound=coupled)), "")[1]
    assert (loud.value, loud.detail) == ("not computed", "damping couples the modes of the reduced model")
    still = tiles(answer(summary(sound={"missing": "none: nothing touches in the window"})), "")[1]
    assert (still.value, still.detail) == ("not heard", "nothing touches")
