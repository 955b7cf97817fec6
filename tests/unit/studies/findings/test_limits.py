"""Limits and background of the user, and places ranked by what is heard: two strips that hit each other.

A change that alters a place by less than its bar is told as such.
"""

from __future__ import annotations

import numpy as np
import pytest

import creak
from creak.report.words.terminal import place_table
from creak.sound.quality import BEYOND, TOO_FAINT, TOO_SHORT
from creak.sound.zwicker_tables import BANDS, NAMES
from creak.studies.file.eline_tables import LimitTable
from creak.studies.findings.limits import judged, limit_words
from creak.studies.findings.places import find_places, ranked
from creak.studies.findings.spots import beside_bars
from creak.studies.sound.cabin import NOTHING, background_of
from creak.studies.sound.heard import Sound
from helpers_cli import caller, empty_reports
from helpers_decks import STUDY, write_strips
from helpers_findings import sound_of

pytestmark = pytest.mark.once

BASE = STUDY.replace("step = 5e-4\nperiods = 2", 'end = 0.2\naccuracy = "quick"\n[reference]\nrun = false\n')
BASE = BASE.replace("0.05,", "0.1,") + '[listener.driver]\nposition = [60, 200, 500]\nparts = "LOWER"\n'
LIMITS = """
[limit]
n5 = "1 sone"
n_max = "1e4 sone"
level = "30 dB(A)"
force = "1 mN"
in_plane = "1 m"

[background]
file = "cabin.csv"
"""
CABIN = "frequency,level\n63,55\n125,50\n250,45\n500,40\n1000,35\n2000,30\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("limits")
    write_strips(folder, study=BASE + LIMITS)
    (folder / "cabin.csv").write_text(CABIN)
    return folder


@pytest.fixture(scope="module")
def result(folder):
    return creak.run(creak.read_study(folder / "study.toml"), converge=False, record=False)


def test_limits_say_what_fails_and_what_holds(result):
    limits = {one["limit"]: one for one in result.summary["limits"]}
    place = result.summary["runs"]["reduced"]["places"][0]
    assert list(limits) == ["n5", "n_max", "level", "force", "in_plane"]
    # Beside a background the loudness that is added counts.
    assert place["n5"] > place["n5_added"] > 1.0
    assert limits["n5"]["failed"] == [{"name": place["name"], "value": place["n5_added"]}]
    assert limits["force"]["allowed"] == pytest.approx(1e-3)
    assert limits["force"]["failed"][0]["value"] == place["force"]
    assert limits["n_max"]["failed"] == limits["in_plane"]["failed"] == []
    said = limit_words(result.summary["limits"])
    assert said[0].startswith("limit n5 = 1 sone fails at tip 1 (")
    assert "limit n_max = 1e+04 sone holds everywhere" in said


def test_limits_stand_in_page_and_terminal(result, folder, monkeypatch, capsys):
    text = result.page(0.0)
    assert "Limit n5 = 1 sone fails at tip 1" in text
    rows = place_table(result.summary)
    assert rows[0][-1] == "N5 added to background, sone"
    assert rows[1][0] == "tip 1"
    empty_reports(monkeypatch)
    said = caller(monkeypatch, capsys)("run", folder / "study.toml", "--no-converge", "--out", folder / "out")
    assert said.status == 0
    assert "limit level = 30 dB(A) fails at tip 1" in said.words


def test_a_limit_of_loudness_without_sound_is_not_passed(result):
    limit = result.found.setup.study.config.limit
    found = judged(limit, {**result.summary, "sound": {"missing": "none: only a reduced model carries sound"}})
    assert [one["missing"] is None for one in found] == [False, False, False, True, True]
    assert "limit n5 = 1 sone was not looked at: none: only a reduced model carries sound" in limit_words(found)


def test_places_are_ranked_by_what_is_heard(result):
    """The channels that touched as two places, the quieter one given first."""
    found, h = result.found, result.history
    impulse = h.weights @ h.force
    order = np.argsort(impulse)
    touched = order[impulse[order] > 0.0]
    quiet, loud = touched[:1], touched[1:]
    sound = sound_of(found, [quiet, loud])
    assert isinstance(sound, Sound)
    assert sound.order == (1, 0)
    alone = sound_of(found, [loud, quiet])
    np.testing.assert_allclose(sound.pressure, alone.pressure, atol=1e-9)
    n5 = [h.n5_added for h in sound.heard[0][:-1]]
    assert n5[0] > n5[1]
    place = find_places(found.scope, result.main)[0]
    assert [p.number for p in ranked((place, place), sound.order)] == [1, 2]


def test_a_loud_background_leaves_nothing(result, folder):
    (folder / "loud.csv").write_text("frequency,level\n" + "".join(f"{f:.0f},110\n" for f in BANDS))
    study = creak.change_study(result.found.setup.study, {"background.file": "loud.csv"})
    again = creak.run(study, converge=False, record=False)
    place = again.summary["runs"]["reduced"]["places"][0]
    assert place["n5"] == result.summary["runs"]["reduced"]["places"][0]["n5"]
    assert place["n_max_added"] < 0.01 * place["n_max"]


def test_regularity_of_events(result):
    place = find_places(result.found.scope, result.main)[0]
    starts = np.diff(sorted(e.t_start for e in place.events))
    assert place.irregularity == pytest.approx(np.std(starts) / np.mean(starts))


def background(study):
    return background_of(study.config.background, study.places)


def test_octaves_of_a_background_are_shared_by_their_third_octaves(result):
    """Powers of the three add up to the octave's: 35 dB at 1 kHz is 30.2 dB in each."""
    levels = background(result.found.setup.study)
    (at,) = np.flatnonzero(BANDS.round() == 1000)
    assert levels[at - 1 : at + 2] == pytest.approx(35.0 - 10 * np.log10(3.0))
    assert (levels == NOTHING).sum() == 28 - 18
    assert any("has nothing outside 45 to 2818 Hz" in note for note in result.sound.notes)


THIRDS = "25 31.5 40 50 63 80 100 125 160 200 250 315 400 500 630 800 1000 1250 1600 2000 2500 3150 4000 5000 6300 8000"
THIRDS = [float(f) for f in [*THIRDS.split(), 10_000, 12_500]]


@pytest.mark.parametrize("frequencies", [THIRDS, BANDS, 1000.0 * 2.0 ** (np.arange(-16, 12) / 3)])
@pytest.mark.parametrize("more", [[], [10.0, 12.5, 16.0, 20.0, 16_000.0, 20_000.0]])
def test_third_octaves_are_read_by_nominal_and_exact_frequency(result, folder, frequencies, more):
    rows = sorted([(f, 30.0 + k) for k, f in enumerate(frequencies)] + [(f, 77.0) for f in more])
    (folder / "thirds.csv").write_text("frequency,level\n" + "".join(f"{f:.9g},{x:g}\n" for f, x in rows))
    study = creak.change_study(result.found.setup.study, {"background.file": "thirds.csv"})
    np.testing.assert_array_equal(background(study), 30.0 + np.arange(28))


@pytest.mark.parametrize("base", [2.0, 10**0.3])
def test_octaves_reach_as_far_as_their_third_octaves(result, folder, base):
    rows = [(1000.0 * base**k, 60.0 + k) for k in range(-5, 5)]
    (folder / "octaves.csv").write_text("frequency,level\n" + "".join(f"{f:.9g},{x:g}\n" for f, x in rows))
    levels = background(creak.change_study(result.found.setup.study, {"background.file": "octaves.csv"}))
    wanted = np.repeat(60.0 + np.arange(-5, 5), 3)[:28] - 10 * np.log10(3.0)
    np.testing.assert_allclose(levels, wanted)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (('n5 = "1 sone"', "n5 = 1"), 'a loudness without its unit; write "1 sone"'),
        (('n5 = "1 sone"', 'n5 = "1 dB"'), "the unit 'dB' is none of a loudness"),
        (('level = "30 dB(A)"', 'level = "30 dB"'), 'write it as "30 dB(A)"'),
        (('force = "1 mN"', 'force = "-1 N"'), "a force that is negative"),
        (('force = "1 mN"', 'rattle = "1 N"'), "unknown key 'limit.rattle'"),
        (("cabin.csv", "no.csv"), "no such table"),
        (("cabin.csv", "bad.csv"), "300 Hz is no third octave"),
        (("cabin.csv", "hole.csv"), "no level between 500 and 2000 Hz"),
        (("cabin.csv", "third.csv"), "no level between 63 and 125 Hz"),
        (("cabin.csv", "one.csv"), "the table has 1 row(s)"),
        (("cabin.csv", "twice.csv"), "two levels of one third octave"),
        (("cabin.csv", "down.csv"), "frequency does not increase"),
    ],
)
def test_wrong_limits_and_backgrounds_are_one_message(tmp_path, change, says, monkeypatch, capsys):
    path = write_strips(tmp_path, study=BASE + LIMITS.replace(*change))
    (tmp_path / "cabin.csv").write_text(CABIN)
    (tmp_path / "bad.csv").write_text(CABIN.replace("250,", "300,"))
    (tmp_path / "hole.csv").write_text(CABIN.replace("1000,35\n", ""))
    (tmp_path / "third.csv").write_text(CABIN.replace("63,55\n", "50,56\n63,55\n"))
    (tmp_path / "down.csv").write_text("frequency,level\n2000,30\n1000,35\n")
    (tmp_path / "one.csv").write_text("frequency,level\n1000,35\n")
    (tmp_path / "twice.csv").write_text(CABIN.replace("63,", "62.5,55\n63,"))
    said = caller(monkeypatch, capsys)("run", path)
    said.refuses(says)
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize(
    ("why", "failed", "missing"),
    [(TOO_FAINT, 0, None), (TOO_SHORT, 0, "tip 1 has none, shorter than"), (BEYOND, 1, None)],
)
def test_a_figure_that_is_none_holds_only_where_there_is_nothing_to_hear(result, why, failed, missing):
    run = result.summary["runs"]["reduced"]
    place = {**run["places"][0], "sharpness": None, "figures_missing": {"sharpness": why}}
    sound = result.summary["sound"]
    sound = {**sound, "listeners": [{**sound["listeners"][0], "places": [place]}]}
    summary = {**result.summary, "runs": {"reduced": {**run, "places": [place]}}, "sound": sound}
    (found,) = judged(LimitTable(sharpness="1 acum"), summary)
    assert len(found["failed"]) == failed
    assert found["missing"] is None if missing is None else found["missing"].startswith(missing)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"sharpness": "2 sone"}, "'sone' is none of a sharpness"),
        ({"roughness": 0.5}, "a roughness without its unit"),
        ({"sharp_time": "1 min"}, "'min' is none of a time"),
        ({"prominence": "8 dB"}, "valid number"),
        ({"impulse_adjustment": "-1 dB"}, "negative"),
    ],
)
def test_a_limit_has_the_unit_of_its_figure(given, message):
    with pytest.raises(ValueError, match=message):
        LimitTable(**given)


def test_times_may_be_milliseconds(result):
    (found,) = judged(LimitTable(sharp_time="200 ms"), result.summary)
    assert (found["allowed"], found["unit"]) == (pytest.approx(0.2), "s")


def test_third_octaves_have_limits_of_their_own(result):
    """One that is exceeded, one that holds, one above the band."""
    place = result.summary["sound"]["listeners"][0]["places"][0]
    loud = int(np.argmax(place["third_octaves"]))
    limit = LimitTable(third_octaves={NAMES[loud]: "1 dB", "25": "120 dB", "12500": "1 dB"})
    over, holds, above = judged(limit, result.summary)
    assert over["failed"][0] == {"name": place["name"], "value": place["third_octaves"][loud]}
    assert over["limit"] == f"third_octaves.{NAMES[loud]}"
    assert (holds["failed"], holds["missing"]) == ([], None)
    assert above["missing"].startswith("the band of the run ends at")
    with pytest.raises(ValueError, match="1001"):
        LimitTable(third_octaves={"1001": "1 dB"})
    assert [float(name) for name in NAMES] == pytest.approx(BANDS.tolist(), rel=0.02)


HALF = {"far": [60.0, 200.0, 2000.0], "near": [60.0, 200.0, 1000.0]}
"""Places of listeners, one at half the distance of the other: 6 dB louder (1 / r of a small source)."""


@pytest.mark.parametrize("first", ["far", "near"])
def test_limits_of_sound_are_judged_at_every_listener(tmp_path, first):
    """Limits between what both hear: the near one fails them, wherever it stands in the file, and read back too."""
    order = [first, *(name for name in HALF if name != first)]
    listeners = "".join(f"[listener.{name}]\nposition = {HALF[name]}\n" for name in order)
    study = BASE.partition("[listener.driver]")[0] + listeners
    ran = creak.run(creak.read_study(write_strips(tmp_path, study=study)), converge=False, record=False)
    at = {x["listener"]: x for x in ran.summary["sound"]["listeners"]}
    far, near = (at[name]["places"][0] for name in HALF)
    loud = int(np.argmax(far["third_octaves"]))
    assert near["level"] - far["level"] == pytest.approx(20 * np.log10(2.0), abs=0.5)
    limit = LimitTable(
        level=f"{far['level'] + 3.0} dB(A)",
        n5=f"{0.5 * (near['n5'] + far['n5'])} sone",
        third_octaves={NAMES[loud]: f"{far['third_octaves'][loud] + 3.0} dB"},
        n_max="1e4 sone",
    )
    found = {one["limit"]: one for one in judged(limit, ran.summary)}
    for name, value in (("level", near["level"]), ("n5", near["n5"])):
        assert found[name]["failed"] == [{"name": far["name"], "listener": "near", "value": value}]
    (octave,) = found[f"third_octaves.{NAMES[loud]}"]["failed"]
    assert (octave["listener"], octave["value"]) == ("near", near["third_octaves"][loud])
    said = limit_words([*found.values()])
    assert any(text.endswith(f"fails at {far['name']} ({near['n5']:.3g} sone to near)") for text in said)
    assert "limit n_max = 1e+04 sone holds everywhere" in said
    both = judged(LimitTable(level="1 dB(A)"), ran.summary)[0]["failed"]
    of_one = [f["listener"] for f in both if f["name"] == far["name"]]
    assert of_one == ["near", "far"]  # worst first
    ran.save(tmp_path / "out")
    assert judged(limit, creak.open_result(tmp_path / "out").summary) == [*found.values()]


def cause(now: dict, *then: dict) -> dict:
    changes = [{"now": now, "predicted": t} for t in then]
    return {"words": "mode", "changes": changes, "changes_words": [f"change {k}" for k in range(len(then))]}


def test_a_small_change_is_told_as_one():
    told = beside_bars(cause({"n5": 10.0, "impulse": 1.0}, {"n5": 9.2, "impulse": 0.1}, {"n5": 5.0}), {"n5": 0.1})
    assert told["changes_words"] == ["change 0; within the uncertainty of the place, 10 %", "change 1"]


@pytest.mark.parametrize(("bar", "small"), [(0.2, True), (0.05, False), (None, False)])
def test_without_sound_the_impulse_decides(bar, small):
    told = beside_bars(cause({"n5": None, "impulse": 1.0}, {"n5": None, "impulse": 0.9}), {"n5": 0.9, "impulse": bar})
    assert ("uncertainty" in told["changes_words"][0]) is small


def test_nothing_is_said_where_nothing_is_told():
    assert beside_bars(None, {"n5": 0.1}) is None
    assert beside_bars({"words": "mode"}, {"n5": 0.1}) == {"words": "mode"}
    same = cause({"n5": 10.0}, {"n5": None})
    assert beside_bars(same, {"n5": 0.5}) == same
