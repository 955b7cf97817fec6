"""The gap that a place has to have, where the middle of its distribution is not the number of the study."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from benchmarks.odds import DECK, STOPPED_BEAM, reach
from scipy.stats import norm, truncnorm

import creak
from creak.report.tables.robust import place_rows
from creak.report.words.text import number
from creak.studies.robust.findings import PlaceFindings, Robustness, _unlike
from creak.studies.robust.linear import FACTORS
from creak.verify.odds import odds
from helpers_decks import write_study

LOAD, SIGMA, SHARE = 0.7, 1.5, 0.05
STOP = '[[clip]]\nname = "seat"\ntype = "{}"\nnodes = "TIP"\naxis = [0, 0, 1]\nstiffness = 40.0\n{}\n'
NORMAL = '{{ type = "normal", mean = {}, sigma = 1.5 }}'


def beam(folder: Path, vary: str, clip: str = "", upper: float = 20.0) -> Path:
    text = STOPPED_BEAM.replace("upper = 10.0", f"upper = {upper}")
    return write_study(folder, f"{text}{clip}[scatter.vary]\n{vary}\n", {"beam.inp": DECK})


@pytest.mark.parametrize(
    ("key", "clip", "place"),
    [
        ("connector.0.upper", "", "stop"),
        ("clip.0.gap", STOP.format("stop", "gap = 14.0"), "seat"),
        ("clip.0.upper", STOP.format("play", "upper = 14.0"), "seat"),
    ],
)
def test_needed_gap_is_that_of_the_distribution(tmp_path, key, clip, place):
    """The quantile of a normal distribution behind the largest motion: all of it may grow until SHARE of it is hit."""
    path = beam(tmp_path, f'"{key}" = {NORMAL.format(9.0)}', clip, upper=30.0 if clip else 20.0)
    found = creak.robust(path, 16, indices=False, threads=1)
    needed = LOAD * reach(path) + SIGMA * norm.isf(SHARE)
    own = next(p for p in found.places if p.name == place)
    assert own.need.gap == pytest.approx(9.0 + own.need.shift)
    assert own.need.gap == pytest.approx(needed, abs=0.1)


def test_middles_of_two_limits_that_differ_are_no_single_gap(tmp_path):
    """The study says 14 to both sides, the draws 9 to one of them."""
    clip = STOP.format("play", "lower = -14.0\nupper = 14.0")
    vary = f'"clip.0.upper" = {NORMAL.format(9.0)}'
    found = creak.robust(beam(tmp_path, vary, clip, upper=30.0), 8, indices=False, threads=1)
    stop, seat = found.places
    assert stop.need.gap == pytest.approx(30.0 + stop.need.shift)
    assert seat.need.gap is None
    both = f'{vary}\n"clip.0.lower" = {NORMAL.format(-9.0)}'
    found = creak.robust(beam(tmp_path, both, clip, upper=30.0), 8, indices=False, threads=1)
    assert found.places[1].need.gap == pytest.approx(9.0 + found.places[1].need.shift)
    assert np.isfinite(found.places[1].need.shift)


@pytest.mark.parametrize(("key", "sign", "end"), [("clip.0.upper", 1.0, "low"), ("clip.0.lower", -1.0, "high")])
def test_a_truncated_distribution_moves_as_a_whole(tmp_path, key, sign, end):
    """The gap that is told is its mean with the shift at which SHARE of the truncated normal lies below the motion."""
    clip = STOP.format("play", f"{key[7:]} = {14.0 * sign}")
    vary = f'"{key}" = {{ type = "normal", mean = {9.0 * sign}, sigma = {SIGMA}, {end} = {8.5 * sign} }}'
    path = beam(tmp_path, vary, clip, upper=30.0)
    if sign < 0.0:
        path.write_text(path.read_text().replace('"step", amplitude = 0.7', '"step", amplitude = -0.7'))
    found = creak.robust(path, 16, indices=False, threads=1)
    need, cut = found.places[1].need, (8.5 - 9.0) / SIGMA
    shift = LOAD * reach(path) - truncnorm.ppf(SHARE, cut, np.inf, 9.0, SIGMA)
    assert need.low <= shift <= need.high
    assert need.shift == pytest.approx(shift, abs=0.05)
    assert need.gap == pytest.approx(9.0 + need.shift)
    told = {f"{key}.mean": sign * (9.0 + need.shift), f"{key}.{end}": sign * (8.5 + need.shift)}
    assert found.as_dict()["places"][1]["need"]["numbers"] == pytest.approx(told)
    mean, cut_at = (number(x) for x in told.values())
    assert place_rows(found)[2][-1].endswith(f", mean = {mean}, {end} = {cut_at}")
    assert found.places[0].need.numbers == {}


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_study_that_says_the_numbers_of_the_need_needs_no_more(tmp_path, sign):
    """The odds of the study with them are the target: one distribution moves, the motion stays."""
    key = "clip.0.upper" if sign > 0.0 else "clip.0.lower"
    end = "low" if sign > 0.0 else "high"

    def found(limit: float, cut: float) -> Robustness:
        clip = STOP.format("play", f"{key[7:]} = {limit}")
        path = beam(tmp_path, f'"{key}" = {{ type = "normal", sigma = {SIGMA}, {end} = {cut} }}', clip, upper=30.0)
        path.write_text(path.read_text().replace('"step", amplitude = 0.7', f'"step", amplitude = {sign * LOAD}'))
        return creak.robust(path, 16, indices=False, threads=1)

    first = found(sign * 9.0, sign * 8.5).places[1].need
    again = found(first.numbers[key], first.numbers[f"{key}.{end}"]).places[1].need
    assert first.shift > SIGMA
    assert abs(again.shift) < 1e-6 * first.shift


@pytest.mark.parametrize(
    ("of", "words"),
    [
        ('type = "uniform", low = 8.0, high = 12.0', " everywhere, low = {low}, high = {high}"),
        ('type = "lognormal", sigma = 0.1', " everywhere"),
        ('type = "normal", sigma = 0.1, relative = true', " everywhere"),
        ('type = "normal", mean = 7.0, sigma = 1.5, low = 8.0', " everywhere, low = {low}"),
    ],
)
def test_a_number_that_shapes_its_distribution_is_no_gap(tmp_path, of, words):
    """Another one in the study would make the distribution wider, or move nothing: the shift alone is told."""
    found = creak.robust(beam(tmp_path, f'"connector.0.upper" = {{ {of} }}', upper=10.0), 8, indices=False, threads=1)
    assert found.places[0].need.gap is None
    shift = found.places[0].need.shift
    told = words.format(low=number(8.0 + shift), high=number(12.0 + shift))
    assert place_rows(found)[1][-1] == f"{shift:+.3g}{told}"


@pytest.mark.parametrize(("hits", "reached", "told"), [(97, 70, True), (97, 95, False), (5, 30, True)])
def test_hits_that_the_window_alone_does_not_explain_are_told(hits, reached, told):
    """Of 256 draws: marched, and by their motion without contact in the window."""
    curve = tuple(odds(reached, 256) for _ in FACTORS)
    place = PlaceFindings("RIB", odds(hits, 256), {}, {}, {}, None, curve)
    notes = _unlike([place, replace(place, fragility=None)])
    assert bool(notes) == told
    assert all(note.startswith("RIB rattles in ") for note in notes)
