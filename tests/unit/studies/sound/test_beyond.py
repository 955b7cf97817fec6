"""Sound beyond the modes of a reduction: a simply supported plate against its own modes, to convergence.

A run whose mesh ends at 680 Hz: what is told of its statistical part, from the summary to the page and back.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import creak
from creak.dynamics.channels import channel_matrices
from creak.dynamics.diagonal import modal_matrices
from creak.linalg.complex_factor import complex_factor
from creak.linalg.modes import modes
from creak.model.skin import skin_of
from creak.reduction.band_modes import Losses, band_modes, count_for
from creak.report.sound_parts import sound_tables
from creak.report.words.terminal import answer_lines
from creak.sound.answering import Modes
from creak.sound.carriers import SEED
from creak.sound.forced import lead, sound_of_forces
from creak.studies.findings.histories import followed
from creak.studies.findings.places import find_places
from creak.studies.models.reference import ReferenceModel
from creak.studies.sound.band import mesh_band
from creak.studies.sound.beyond import Beyond, beyond_modes, hearing
from creak.studies.sound.ear import Ear, n5_of, records_of
from creak.studies.sound.heard import Sound
from creak.studies.sound.listeners import Listener
from creak.studies.sound.loud import heard_of
from creak.studies.sound.radiation import Source
from helpers_core import assembled, channels
from helpers_decks import STEEL, STUDY, patch, write_strips
from helpers_plate import SIDES, ZETA, kept, own_modes, own_rows, supported_plate

RECORDED = {"section": "sound"}

RATE = 48_000
N = (40, 32)
AT = (13, 22)
"""Column and row of the node that is struck."""
EAR = np.array([0.35, 0.1, 0.6])
HANDOVER = 500.0


@pytest.fixture(scope="module")
def model():
    return supported_plate(N)


@pytest.fixture(scope="module")
def system(model):
    return assembled(model)


def blow() -> np.ndarray:
    """(n, 1) N: a half sine of .2 ms."""
    t = np.arange(9_600) / RATE
    return np.where((t > 0.05) & (t < 0.0502), 20.0 * np.sin(np.pi * (t - 0.05) / 2e-4), 0.0)[:, None]


def converged(high: float, far: float) -> np.ndarray:
    """Pressure of its own modes up to `far`, with the band's lead before it."""
    own = own_modes(far, (AT[0] * SIDES[0] / N[0], AT[1] * SIDES[1] / N[1]))
    rows = own_rows(far, tuple(EAR), float(RATE))
    return sound_of_forces(own, blow(), RATE, [np.array([0])], rows, high, around=True)[0, 0]


def test_a_struck_plate_to_the_end_of_its_mesh_against_its_own_modes(model, system, measured):
    """Six elements per wavelength at the end; within 1 dB(A) and 5 % of N5."""
    skin = skin_of(model)
    listener = Listener("ear", EAR, skin, ("PART",), True)
    node = AT[0] * (N[1] + 1) + AT[1]
    G = np.zeros((1, 6 * len(model.nodes.coords)))
    G[0, 6 * node + 2] = 1.0
    gaps = channels(G, 0.0, 1.0)
    small, high = kept(system, 2 * HANDOVER), mesh_band(model, skin, 1.0)
    rows = np.asarray(channel_matrices(small, gaps).rows)
    source = Source(Modes(*modal_matrices(small), rows), blow(), np.array([0]), np.array([0]), gaps)
    reference = ReferenceModel((), None, system, modes(system.K, system.M, f_max=100.0), np.zeros((system.n, 0)), None)
    beyond = beyond_modes(reference, ZETA, source, [listener], 1.0, (HANDOVER, high), 1e5)
    assert isinstance(beyond, Beyond)
    assert beyond.high == high
    assert high > 3000.0
    assert beyond.found.freq.size <= count_for(Losses(zeta=ZETA), HANDOVER, high) + 8
    ear = Ear(listener, HANDOVER, 1.0, beyond)
    records = records_of(source, [np.array([0])], ear, small)
    window = (0.0, 0.2)
    found, alone, sooner = (
        heard_of(x[0], window, None, ear.start) for x in (records.whole, records.modes, records.sooner)
    )
    start = lead(RATE, high)
    true = heard_of(converged(high, 4 * high), window, None, start)
    further = heard_of(converged(high, 6 * high), window, None, start)
    assert further.n5 == pytest.approx(true.n5, rel=1e-3)  # converged
    measured("struck plate to the mesh's end: level", found.level, true.level, abs=1.0, unit="dB(A)")
    measured("struck plate to the mesh's end: N5", found.n5, true.n5, rel=0.05, unit="sone")
    assert alone.n5 < 0.8 * true.n5  # what the modes alone leave out
    assert sooner.n5 == pytest.approx(found.n5, rel=0.01)
    plain = records_of(source, [np.array([0])], replace(ear, beyond=None), small)
    np.testing.assert_array_equal(records.modes, plain.whole)  # nothing changes below


def test_what_a_listener_hears_of_a_force_and_the_other_way_round(model, system):
    """Both solves tell the same to round-off, and the Galerkin model what a solve says anywhere in its band."""
    at = hearing(system, Listener("ear", EAR, skin_of(model), ("PART",), True), 1.0)
    column = int(np.flatnonzero(system.coordinates == 6 * (AT[0] * (N[1] + 1) + AT[1]) + 2)[0])
    push = np.zeros((system.n, 1))
    push[column] = 1.0

    def weights(freq: float) -> np.ndarray:
        return at(freq)[:, None]

    losses = Losses(alpha=20.0, beta=5e-6)
    found = band_modes(system.K, system.M, losses, push, weights, (500.0, 1500.0), 40)
    assert found.high == 1500.0
    assert found.reciprocity < 1e-9
    for freq in np.random.default_rng(1).uniform(500.0, 1500.0, 5):
        k, m = losses.factors(freq)
        true = complex_factor((k * system.K + m * system.M).tocsr()).solve(push.astype(complex))[:, 0] @ at(freq)
        q = (found.shapes.T @ push)[:, 0] / (k * found.omega2 + m)
        assert abs(at(freq) @ (found.shapes @ q) - true) < 0.05 * abs(true)
    for most in (5, 6, 7):
        less = band_modes(system.K, system.M, losses, push, weights, (500.0, 1500.0), most)
        assert less is None or less.error < 0.05  # the last of them checks
    less = band_modes(system.K, system.M, losses, push, weights, (500.0, 1500.0), 6)
    assert less is not None
    assert 500.0 < less.high < 1500.0  # as far as it goes
    assert band_modes(system.K, system.M, Losses(), push, weights, (500.0, 1500.0), 40) is None


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
