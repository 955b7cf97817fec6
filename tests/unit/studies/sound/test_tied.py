"""Levels beyond third octaves that are known twice, against draws of what they are taken for."""

from __future__ import annotations

import numpy as np
import pytest

from creak.studies.sound.loud import OCTAVE, UNTIED, Levels, tied

RECORDED = {"section": "sound"}

NONE = Levels(np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros(0))
FURTHER = np.arange(14, 26)
EVEN = np.ones(FURTHER.size)


def test_tied_to_nothing_a_level_is_believed_as_it_is():
    tie, corrected = tied(NONE, FURTHER[:1], np.array([3.0]), EVEN[:1])
    assert (tie.bands, tie.offset) == (0, 0.0)
    assert tie.scatter == pytest.approx(np.hypot(UNTIED, 3.0))
    np.testing.assert_array_equal(corrected, 0.0)
    many, _ = tied(NONE, FURTHER, np.zeros(FURTHER.size), EVEN)
    assert 0.5 * UNTIED < many.scatter < 0.8 * UNTIED  # several octaves are off in different ways


def test_a_correction_is_forgotten_over_octaves():
    """One third octave that is known without scatter: its neighbours follow, those far away do not."""
    seen = Levels(np.array([13]), np.array([-6.0]), np.zeros(1))
    tie, corrected = tied(seen, FURTHER, np.zeros(FURTHER.size), EVEN)
    np.testing.assert_allclose(corrected, -6.0 * np.exp(-(FURTHER - 13) / OCTAVE))
    assert tie.offset == pytest.approx(corrected.mean())
    _, less = tied(Levels(seen.band, seen.apart, np.array([20.0])), FURTHER, np.zeros(FURTHER.size), EVEN)
    assert np.abs(less).max() < 0.1 * np.abs(corrected).max()


def test_levels_that_are_right_below_are_believed_more_beyond():
    seen = np.arange(8, 14)
    right, wrong = (
        tied(Levels(seen, apart, np.full(6, 1.0)), FURTHER, np.ones(FURTHER.size), EVEN)[0]
        for apart in (np.zeros(6), 9.0 * (-1.0) ** seen)
    )
    assert right.scatter < 0.75 * UNTIED < UNTIED < wrong.scatter


def test_a_part_that_stands_still_far_below_does_not_spoil_what_is_beyond():
    seen = np.arange(8, 14)
    still, off = (
        tied(Levels(seen, np.array([below, 0.0, 0.0, 0.0, 0.0, 0.0]), np.full(6, 3.0)), FURTHER, 3.0 * EVEN, EVEN)[0]
        for below in (-60.0, -15.0)
    )
    assert still == off
    assert still.scatter < UNTIED


@pytest.mark.parametrize(("sd", "least"), [(2.0, 0.95), (5.0, 0.92), (9.0, 0.8)])
def test_scatter_covers_draws_of_the_random_function(sd, least, measured):
    """Two standard deviations of the mean level beyond, of 2,000 random functions that scatter by 2, 5 and 9 dB."""
    rng, seen = np.random.default_rng(7), np.arange(8, 14)
    every = np.concatenate([seen, FURTHER])
    root = np.linalg.cholesky(sd**2 * np.exp(-np.abs(every[:, None] - every) / OCTAVE))
    inside = 0
    for _ in range(2000):
        off = root @ rng.standard_normal(every.size)
        scatter = np.where(every < 14, 1.5, 2.0)
        found = off + scatter * rng.standard_normal(every.size)
        tie, _ = tied(Levels(seen, found[:6], scatter[:6]), FURTHER, scatter[6:], EVEN)
        inside += abs(found[6:].mean() - tie.offset) <= 2.0 * tie.scatter
    measured(f"share of random functions of {sd:g} dB within two standard deviations", inside / 2000, at_least=least)
