"""A run whose mesh ends at 680 Hz: what is told of its statistical part, from the summary to the page and back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import creak
from creak.report.sound_parts import sound_tables
from creak.report.words.answer_lines import answer_lines
from creak.sound.carriers import SEED
from creak.studies.findings.followed import followed
from creak.studies.findings.places import find_places
from creak.studies.sound.ear import n5_of
from creak.studies.sound.heard import Sound
from helpers_decks import STEEL, STUDY, patch, write_strips

BASE = STUDY.replace("step = 5e-4\nperiods = 2", "end = 0.2\n[reference]\nrun = false\n").replace("0.05,", "0.1,")


def sheet(first: int, elset: str, z: float) -> str:
    """120 mm x 240 mm in elements of 20 mm, clamped at x = 0."""
    quads = patch(first, elset, (0.0, 0.0, z), (120.0, 0.0, 0.0), (0.0, 240.0, 0.0), (6, 12), first)
    roots = ", ".join(str(first + j * 7) for j in range(13))
    return f"{quads}*NSET, NSET=ROOT_{elset}\n{roots}\n"


def deck() -> str:
    """Sheets of 1 mm and 1.5 mm, half a millimetre apart."""
    return (
        "*HEADING\ntwo sheets\n"
        + sheet(1, "UPPER", 1.75)
        + sheet(1001, "LOWER", 0.0)
        + STEEL
        + "*SHELL SECTION, ELSET=UPPER, MATERIAL=STEEL\n1.0,\n*SHELL SECTION, ELSET=LOWER, MATERIAL=STEEL\n1.5,\n"
        + "*SURFACE, NAME=UNDER\nUPPER, SNEG\n*SURFACE, NAME=OVER\nLOWER, SPOS\n"
        + "*NSET, NSET=PAIRS, UNSORTED\n1091, 91, 1007, 7\n"
        + "*BOUNDARY\nROOT_LOWER, 1, 6\nROOT_UPPER, 1, 2\nROOT_UPPER, 4, 6\n"
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sheets")
    write_strips(folder, deck(), BASE)
    return folder


@pytest.fixture(scope="module")
def result(folder):
    result = creak.run(creak.read_study(folder / "study.toml"), converge=False)
    result.save(folder / "out")
    return result


def test_the_summary_tells_which_part_of_n5_is_computed_and_its_bar(result):
    sound = result.summary["sound"]
    band = sound["band"]
    assert band["computed"] == band["mesh"] == pytest.approx(683.0, abs=1.0)
    assert (band["computed_limit"], band["limit"], band["high"], band["seed"]) == ("mesh", "statistics", 10_000.0, SEED)
    for heard in (sound, *sound["listeners"][0]["places"]):
        assert 0.0 < heard["n5_computed"] < heard["n5"]
        assert heard["n5_bar"][0] < heard["n5"] < heard["n5_bar"][1]
        assert heard["n10_bar"][0] < heard["n10"] < heard["n10_bar"][1]
    assert all(0 <= p["tie"]["bands"] <= 6 and p["tie"]["scatter"] > 0.0 for p in sound["listeners"][0]["places"])
    assert sound["tie"] is None
    assert sound["third_octaves"][19] > 0.0  # 2 kHz, beyond the mesh
    assert result.summary["warnings"] == []


def test_the_notes_say_which_parts_are_plates_and_which_are_not(result):
    """The thicker sheet has less than a mode in the third octave at 680 Hz."""
    said = " ".join(result.sound.notes)
    assert "beyond 683 Hz, where the mesh ends what is computed, by the statistical energy of UPPER, as noise" in said
    assert "contact also pushes LOWER, no plate there: nothing of it beyond 683 Hz" in said


def test_the_page_and_the_terminal_tell_it(result):
    ways = sound_tables(result.summary)[1]
    assert ways.head[1:3] == ["computed, to 683 Hz", "with statistical energy, to 10000 Hz"]
    assert len(ways.rows) == len(result.summary["runs"]["reduced"]["places"]) + 1
    assert "of it computed" in result.page(0.0)
    lines = answer_lines(result.summary)
    assert any("statistical above 683 Hz" in line for line in lines)
    assert max(map(len, lines)) <= 80


def test_what_was_stored_is_read_back(result, folder):
    again = creak.open_result(folder / "out").findings
    assert again.sound is not None
    assert again.sound.band == result.sound.band
    own = result.findings.sound.listeners[0].heard
    assert [(h.tie, h.n5_bar, h.n5_computed) for h in again.sound.listeners[0].heard] == [
        (h.tie, h.n5_bar, h.n5_computed) for h in own
    ]


def test_the_scatter_is_a_source_of_the_bar_of_n5(result):
    places = followed(result.found.scope, result.main, result.sound)
    heard = result.sound.heard[0][: len(places.scatter)]
    off = [max(h.n5_bar[1] / h.n5 - 1.0, 1.0 - h.n5_bar[0] / h.n5) for h in heard]
    assert places.scatter == pytest.approx(off)


def test_a_repeated_run_is_heard_alike(result):
    """The same run again: noise of the same seed, so that what differs is the run."""
    run, found, sound = result.main, result.found, result.sound
    assert isinstance(sound, Sound)
    groups = [p.channels for p in find_places(found.scope, run)]
    *single, together = n5_of(found.window, run.system, found.gaps, run.history, groups, sound.ear)
    assert [single[k] for k in sound.order] == pytest.approx([h.n5 for h in sound.heard[0][:-1]])
    assert together == pytest.approx(sound.heard[0][-1].n5)
    ear = replace(sound.ear, statistics=None)
    *_, below = n5_of(found.window, run.system, found.gaps, run.history, groups, ear)
    assert below == pytest.approx(sound.heard[0][-1].n5_computed)


def test_places_add_up_with_their_noise(result):
    own = result.sound.pressure[0]
    np.testing.assert_allclose(own[:-1].sum(axis=0), own[-1], atol=1e-3 * np.abs(own[-1]).max())
