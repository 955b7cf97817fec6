"""Frequency response functions of two masses have their closed form, however the file of the test holds it."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.measured.mode_files import read_test
from creak.reduction.transfer_modes import receptances, transfer_model
from creak.studies.models.beside_test import deck_beside_test
from creak.studies.models.deck_modes import deck_modes
from helpers_decks import STEEL, strip
from helpers_frfs import FREQ, accelerance, function, masses_deck, points, receptance, units
from helpers_modal import data_set, e13

EXACT = 1e-6
SIX_DIGITS = 1e-4
"""Of functions in single precision, near a resonance too."""
UNEVEN = np.unique(np.round(np.geomspace(1.0, 50.0, 60), 4))


@pytest.fixture(scope="module")
def deck(tmp_path_factory):
    return masses_deck(tmp_path_factory.mktemp("masses"))


def beside(deck, tmp_path, *parts, ending="unv", **options):
    path = tmp_path / f"test.{ending}"
    path.write_bytes(b"".join(p.encode() if isinstance(p, str) else p for p in parts))
    return deck_beside_test(deck, path, **options).frfs


def one(found):
    (pair,) = found.pairs
    return pair


@pytest.mark.parametrize(("response", "reference"), [(2, 2), (3, 2), (2, 3), (3, 3)])
@pytest.mark.parametrize(("order", "quantity"), [(0, 8), (1, 11), (2, 12)])
def test_functions_of_two_damped_masses_are_their_closed_form(deck, tmp_path, response, reference, order, quantity):
    exact = receptance(response, reference) * (2j * np.pi * FREQ) ** order
    pair = one(
        beside(
            deck, tmp_path, units(1.0), points(1e-3), function(exact, (response, 1), (reference, 1), quantity=quantity)
        )
    )
    worst = float(np.abs(pair.model / exact - 1.0).max())
    assert worst <= EXACT
    assert pair.measured.values == pytest.approx(exact, rel=1e-11)
    assert pair.frac == pytest.approx(1.0, abs=1e-12)
    assert (pair.level, pair.phase) == pytest.approx((0.0, 0.0), abs=1e-5)


FORMS = {
    "single": {"data": 5},
    "double": {"data": 6},
    "uneven single": {"data": 5, "even": False, "freq": UNEVEN},
    "uneven double": {"data": 6, "even": False, "freq": UNEVEN},
    "binary": {"binary": "<"},
    "binary single, other byte order": {"binary": ">", "data": 5},
    "binary uneven": {"binary": "<", "even": False, "freq": UNEVEN},
    "binary uneven single": {"binary": ">", "even": False, "data": 5, "freq": UNEVEN},
    "binary uneven, wide abscissa": {"binary": ">", "even": False, "freq": UNEVEN, "wide_abscissa": True},
    "over a reaction force": {"over": 9},
    "its abscissa not told": {"abscissa": 0},
}


@pytest.mark.parametrize("name", FORMS)
def test_every_form_of_a_function_is_read(deck, tmp_path, name):
    form = FORMS[name]
    freq = form.get("freq", FREQ)
    exact = accelerance(3, 2, freq)
    pair = one(beside(deck, tmp_path, units(1.0), points(1e-3), function(exact, **form)))
    assert pair.measured.freq == pytest.approx(freq, rel=1e-5)
    assert (
        np.abs(pair.measured.values - exact).max()
        <= (SIX_DIGITS if form.get("data") == 5 else 1e-11) * np.abs(exact).max()
    )
    assert pair.frac == pytest.approx(1.0, abs=1e-6)


HERTZ = {"Hz": 1.0, "hertz": 1.0, "": 1.0, "kHz": 1e-3, "rad/sec": 2.0 * np.pi, "RPM": 60.0}
"""Label -> numbers that 1 Hz is."""


@pytest.mark.parametrize("unit", HERTZ)
@pytest.mark.parametrize("form", [{}, {"even": False}, {"binary": "<"}, {"abscissa": 0}])
def test_frequencies_are_in_the_unit_of_their_axis(deck, tmp_path, unit, form):
    """The function is the closed form at what was read, and so is its coherence's place beside it."""
    told = {"freq": HERTZ[unit] * FREQ, "over_unit": unit, **form}
    gamma = function(np.full(FREQ.size, 0.9), kind=6, data=4, quantity=0, over=0, **told)
    pair = one(beside(deck, tmp_path, units(1.0), points(1e-3), function(accelerance(3, 2), **told), gamma))
    assert pair.measured.freq == pytest.approx(FREQ, rel=1e-5)
    assert pair.model == pytest.approx(accelerance(3, 2, pair.measured.freq), rel=EXACT)
    assert pair.frac == pytest.approx(1.0, abs=1e-6)
    assert pair.measured.coherence == pytest.approx(np.full(FREQ.size, 0.9))


def test_several_sets_binary_and_text_follow_each_other(deck, tmp_path):
    """Bytes that look like marks do not end a binary set; lines are counted on behind it."""
    tricky = accelerance(2, 2)
    tricky[3] = np.frombuffer(b"\n    -1\n\n    -1\n", "<c16")[0]
    found = read(
        tmp_path, points(1e-3).encode() + function(tricky, (2, 1), binary="<") + function(accelerance(3, 2), (3, 1))
    )
    assert [f.name for f in found.functions] == ["2 X / 2 X", "3 X / 2 X"]
    assert found.functions[0].values == pytest.approx(tricky, nan_ok=True)


def test_a_binary_set_may_have_more_bytes_than_its_head_says(tmp_path):
    """As pyuff writes complex ones: half their number, and no end of line before the mark."""
    one = function(accelerance(3, 2), binary="<").replace(b"\n    -1\n", b"    -1\n")
    told = 16 * FREQ.size
    assert b"%12d" % told in one
    found = read(tmp_path, points(1e-3).encode() + one.replace(b"%12d" % told, b"%12d" % (told // 2)) * 2)
    assert len(found.functions) == 2
    assert found.functions[1].values == pytest.approx(accelerance(3, 2), rel=1e-15)


def read(tmp_path, data):
    path = tmp_path / "test.unv"
    path.write_bytes(data)
    return read_test(path).frfs


SIGNS = [((3, -1), (2, 1), 180.0), ((3, 1), (2, -1), 180.0), ((3, -1), (2, -1), 0.0)]


@pytest.mark.parametrize(("response", "reference", "turned"), SIGNS)
def test_the_sign_of_a_direction_turns_the_function(deck, tmp_path, response, reference, turned):
    """A file whose values have the sign that its directions say fits; one that has not is told."""
    sign = -1.0 if turned else 1.0
    right = one(
        beside(deck, tmp_path, units(1.0), points(1e-3), function(sign * accelerance(3, 2), response, reference))
    )
    assert right.phase == pytest.approx(0.0, abs=1e-5)
    assert right.model == pytest.approx(sign * accelerance(3, 2), rel=EXACT)
    found = beside(deck, tmp_path, units(1.0), points(1e-3), function(-sign * accelerance(3, 2), response, reference))
    assert abs(one(found).phase) == pytest.approx(180.0, abs=1e-5)
    assert one(found).frac == pytest.approx(1.0, abs=1e-12)
    assert any("opposite signs" in note for note in found.notes)


INCH, LBF = 1.0 / 0.0254, 1.0 / 4.4482216152605
UNITS = {
    "m and N": (units(1.0), 1e-3, 1.0, ("m/s^2", "N")),
    "mm and N": (units(1000.0), 1.0, 1e3, ("mm/s2", "N")),
    "inches and pounds": (units(INCH, LBF), INCH * 1e-3, INCH / LBF, ("(in/sec**2)/lbf", "lbf")),
    "labels alone": ("", 1.0, 1.0 / 9.80665, ("g", "N")),
    "a label of both": ("", 1.0, 1e3, ("mm/s^2/N", "")),
    "nothing told: those of the deck": ("", 1.0, 1e3, ("NONE", "NONE")),
}


@pytest.mark.parametrize("name", UNITS)
def test_units_are_those_that_the_file_tells(deck, tmp_path, name):
    head, length, factor, labels = UNITS[name]
    found = beside(deck, tmp_path, head, points(length), function(factor * accelerance(3, 2), labels=labels))
    assert one(found).level == pytest.approx(0.0, abs=1e-4)
    assert one(found).measured.values == pytest.approx(accelerance(3, 2), rel=1e-4)


def test_labels_that_no_data_set_explains_are_refused(tmp_path):
    """A kilopond is 9.8 N and no newton; where data set 164 tells units it counts, and a note says so."""
    kiloponds = function(accelerance(3, 2) * 9.80665, labels=("m/s^2", "kp"))
    for one_function, words in (
        (kiloponds, "a frequency response in m/s^2 over kp"),
        (function(accelerance(3, 2), labels=("V", "N")), "a frequency response in V over N"),
        (function(accelerance(3, 2), labels=("NONE", "lbf")), "a frequency response in NONE over lbf"),
    ):
        with pytest.raises(InputError, match=re.escape(words)):
            read(tmp_path, points().encode() + one_function)
    found = read(tmp_path, (units(1.0, 1.0 / 9.80665) + points()).encode() + kiloponds)
    assert found.functions[0].values == pytest.approx(accelerance(3, 2), rel=1e-5)
    assert found.notes == ("units kp of functions are not known: those of data set 164 are taken",)


@pytest.mark.parametrize(
    ("factor", "words"),
    [(1e-3, "60.0 dB above"), (1e3, "60.0 dB below"), (1.0 / 9.80665, "g and m/s^2"), (1.0 / 4.4482, "lbf and N")],
)
def test_a_wrong_unit_is_told(deck, tmp_path, factor, words):
    found = beside(deck, tmp_path, units(1.0), points(1e-3), function(factor * accelerance(3, 2)))
    assert any(words in note for note in found.notes)


@pytest.mark.parametrize(
    ("written", "words"),
    [
        (lambda h: h, ""),
        (lambda h: -3.0 * h, ""),
        (np.conj, "are conjugate"),
        (lambda h: h / (2j * np.pi * FREQ), "are mobility, not accelerance"),
        (lambda h: h / (2j * np.pi * FREQ) ** 2, "are receptance, not accelerance"),
    ],
)
def test_another_convention_or_quantity_is_asked_about(deck, tmp_path, written, words):
    exact = receptance(2, 3) * (2j * np.pi * FREQ) ** 2
    found = beside(deck, tmp_path, units(1.0), points(1e-3), function(written(exact), (2, 1), (3, 1), quantity=12))
    told = [note for note in found.notes if "functions of the test would be" in note]
    assert [f"those of the model if they {words}: check" in note for note in told] == ([True] if words else [])


def test_directions_are_those_of_the_frames(deck, tmp_path):
    """Motion along y of a frame whose y is the deck's x."""
    axes = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    frame = data_set(
        2420,
        f"{1:10d}",
        "PART",
        f"{7:10d}{0:10d}{8:10d}",
        "CS7",
        *("".join(f"{v:25.16E}" for v in row) for row in axes),
    )
    found = beside(
        deck, tmp_path, units(1.0), frame, points(1e-3, frame=7), function(accelerance(3, 2), (3, 2), (2, 2))
    )
    assert one(found).model == pytest.approx(accelerance(3, 2), rel=EXACT)


def test_coherence_stands_beside_its_function(deck, tmp_path):
    gamma = 1.0 - 0.5 * np.exp(-(((FREQ - 14.0) / 3.0) ** 2))
    data = (function(gamma, kind=6, data=4, quantity=0, over=0), function(accelerance(3, 2)))
    for order in (data, data[::-1]):
        found = beside(deck, tmp_path, units(1.0), points(1e-3), *order)
        assert one(found).measured.coherence == pytest.approx(gamma, abs=1e-11)


def mode(frequency: float, damping: float, shape: tuple[float, float]) -> str:
    head = "".join(f"{v:10d}" for v in (1, 2, 2, 8, 2, 3))
    third = f"{2:10d}{4:10d}{1:10d}{1:10d}\n" + e13([frequency, 1.0, damping, 0.0])
    rows = [line for n, x in zip((2, 3), shape, strict=True) for line in (f"{n:10d}", e13([x, 0.0, 0.0]))]
    return data_set(55, "TEST", "NONE", "NONE", "NONE", "NONE", head, third, *rows)


def test_measured_damping_of_modes_in_the_file_is_taken(deck, tmp_path):
    """sum of phi_i phi_j / (omega^2 - w^2 + 2 i zeta omega w), damping of the second mode unknown: that of the first."""
    found = deck_modes(deck, count=2)
    shapes = np.stack([u[1:, 0] for u in found.translations()], axis=1)
    modes = "".join(mode(f, z, tuple(u)) for f, z, u in zip(found.frequencies, (0.03, 0.0), shapes.T, strict=True))
    omega, w = 2.0 * np.pi * np.array(found.frequencies), 2.0 * np.pi * FREQ[:, None]
    terms = shapes[0] * shapes[1] / (omega**2 - w**2 + 2j * 0.03 * omega * w)
    both = beside(deck, tmp_path, units(1.0), points(1e-3), modes, function(accelerance(3, 2)))
    assert one(both).model == pytest.approx(-1e-3 * w[:, 0] ** 2 * terms.sum(axis=1), rel=EXACT)
    assert any("1 modes have that of their partners" in note or "damping is measured" in note for note in both.notes)


def strip_of(tmp_path, held: bool, damping: str = ""):
    """120 x 20 x 1 mm shells, clamped at x = 0 or free."""
    support = "*BOUNDARY\nROOT_S, 1, 6\n" if held else ""
    path = tmp_path / "strip.inp"
    material = STEEL.partition("*DAMPING")[0] + damping
    path.write_text(
        f"*HEADING\nstrip\n{strip(1, 1, 'S', 0.0)}{material}*SHELL SECTION, ELSET=S, MATERIAL=STEEL\n1.0,\n{support}"
    )
    return path


@pytest.mark.parametrize("held", [True, False])
@pytest.mark.parametrize("damping", ["", "*DAMPING, ALPHA=20., BETA=1e-5\n"])
def test_few_solves_replace_the_modes_that_are_left_out(tmp_path, held, damping):
    """Against the unreduced dynamic stiffness all over the band, of the largest transfer at each frequency."""
    top = 2000.0
    found = deck_modes(strip_of(tmp_path, held, damping), f_max=1.3 * top)
    system = found.damped or found.system
    assert system.damping.alpha == (20.0 if damping else 0.0)
    rows = np.zeros((3, system.n))
    free = np.flatnonzero(system.coordinates % 6 == 2)
    rows[[0, 1, 2], free[[-1, len(free) // 2, -4]]] = 1.0
    modes = (2.0 * np.pi * np.array(found.frequencies)) ** 2, found.shapes
    modal = transfer_model(system, modes, rows, np.array([0, 1]), top)
    freq = np.linspace(13.0, top, 41)
    response, reference = np.repeat([0, 1, 2], 2), np.tile([0, 1], 3)
    H = receptances(modal, freq, response, reference)
    K, M = system.K.toarray(), system.M.toarray()
    worst, plain = 0.0, 0.0
    few = replace(modal, omega2=modes[0], rows=rows @ modes[1], C=modal.C[: modes[0].size, : modes[0].size])
    for f, h, without in zip(freq, H, receptances(few, freq, response, reference), strict=True):
        s = 2j * np.pi * f
        A = (1.0 + s * system.damping.beta) * K + (s**2 + s * system.damping.alpha) * M
        true = (rows @ np.linalg.solve(A, rows[:2].T)).ravel()
        worst = max(worst, float(np.abs(h - true).max() / np.abs(true).max()))
        plain = max(plain, float(np.abs(without - true).max() / np.abs(true).max()))
    assert worst <= EXACT
    assert plain > 1e3 * EXACT
    assert modal.freq.size <= 5
