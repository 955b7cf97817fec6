"""Prominence of impulsive sounds against the formulas of NT ACOU 112 on levels that are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from creak.sound.quality import EVERY, FAST, Onset, adjustment, fast_levels, onsets

RECORDED = {"section": "sound"}

RATE = 48_000


def tone(level: np.ndarray) -> np.ndarray:
    """1 kHz at levels (n,) in dB, which the A weighting leaves as they are."""
    phase = 2 * np.pi * 1000 * np.arange(level.size) / RATE
    return 2e-5 * 2**0.5 * 10 ** (level / 20) * np.sin(phase)


def ramp(rate: float, difference: float, low: float = 40.0) -> np.ndarray:
    """dB: a second of `low`, then a rise, then steady."""
    t = np.arange(3 * RATE) / RATE
    return low + np.clip(rate * (t - 1.0), 0.0, difference)


@pytest.mark.parametrize(
    ("rate", "difference", "prominence", "adjusted"),
    [
        (1000.0, 30.0, 11.954, 12.517),
        (1200.0, 32.0, 12.248, 13.046),
        (300.0, 18.0, 9.942, 8.896),
        (10.0, 10.0, 5.0, 0.0),
    ],
)
def test_prominence_and_adjustment_of_known_onsets(rate, difference, prominence, adjusted):
    assert Onset(0.0, 1.0, rate, difference).prominence == pytest.approx(prominence, abs=1e-3)
    assert adjustment(prominence) == pytest.approx(adjusted, abs=2e-3)


def test_a_straight_rise_has_its_rate_and_height():
    rise = 40.0 + 3.0 * np.arange(1, 11)
    (found,) = onsets(np.concatenate([np.full(50, 40.0), rise, np.full(50, 70.0)]))
    assert (found.rate, found.difference) == pytest.approx((300.0, 30.0))
    assert found.prominence == pytest.approx(10.386, abs=1e-3)


@pytest.mark.parametrize("jump", [20.0, 40.0])
def test_a_jump_rises_as_the_time_weighting_lets_it(jump, measured):
    """L(t) = 10 lg(B + S (1 - e^(-t / 125 ms))), cut where it is flatter than 10 dB/s."""
    found = onsets(fast_levels(tone(ramp(1e9, jump)), RATE, silent=False))
    t = EVERY * np.arange(1, 300)
    power = 10**4.0 + (10 ** (0.1 * (40.0 + jump)) - 10**4.0) * (1.0 - np.exp(-np.maximum(t - 1.0, 0.0) / FAST))
    wanted = onsets(10.0 * np.log10(power))
    assert len(found) == len(wanted) == 1
    assert found[0].start == pytest.approx(wanted[0].start, abs=1.5 * EVERY)
    measured(
        f"NT ACOU 112: prominence of a jump of {jump:.0f} dB",
        found[0].prominence,
        wanted[0].prominence,
        rel=0.01,
        source="closed form",
    )


@pytest.mark.parametrize(("rate", "difference"), [(15.0, 10.0), (20.0, 20.0), (30.0, 30.0)])
def test_a_slow_rise_has_its_own_rate_and_height(rate, difference):
    """Slower than the time weighting's 35 dB/s, its level follows; its rounded ends take some dB."""
    (found,) = onsets(fast_levels(tone(ramp(rate, difference)), RATE, silent=False))
    assert found.rate == pytest.approx(rate, rel=0.1)
    assert difference - 2.2 < found.difference < difference


def test_no_onset_is_found_in_what_is_steady_or_falls_or_rises_slowly():
    for level in (ramp(0.0, 0.0), -ramp(50.0, 20.0) + 100.0, ramp(8.0, 15.0)):
        assert onsets(fast_levels(tone(level), RATE, silent=False)) == ()


def test_short_flat_pieces_do_not_end_an_onset_and_long_ones_do():
    def steps(flat: int) -> np.ndarray:
        rise = 2.0 * np.arange(1, 11)
        return np.concatenate([np.zeros(20), rise, np.full(flat, 20.0), 20.0 + rise, np.full(20, 40.0)])

    (one,) = onsets(steps(4))
    assert one.difference == pytest.approx(40.0)
    assert [o.difference for o in onsets(steps(6))] == pytest.approx([20.0, 20.0])


def test_what_is_there_besides_makes_it_less_prominent():
    x = np.zeros(RATE)
    x[RATE // 2 :] = tone(np.full(RATE // 2, 50.0))
    alone = max(o.prominence for o in onsets(fast_levels(x, RATE)))
    beside = max(o.prominence for o in onsets(fast_levels(x, RATE, steady=40.0)))
    assert beside < alone - 1.0
    assert onsets(fast_levels(x, RATE, steady=70.0)) == ()


def test_silence_has_the_quietest_level_and_time_begins_after_10_ms():
    assert fast_levels(np.zeros(481), RATE) == pytest.approx([0.0, 0.0])
    (only,) = onsets(np.array([0.0, 5.0, 10.0, 10.0]))
    assert (only.start, only.end) == pytest.approx((0.01, 0.03))


def test_a_rise_that_falls_amid_it_is_no_impulse():
    """It goes on higher within 50 ms, so it is one; the line through it falls."""
    levels = np.concatenate([[30.0], np.linspace(90.0, 94.0, 20), [30.0, 30.0, 30.0], [94.1]])
    (found,) = onsets(np.concatenate([np.full(20, 30.0), levels, np.full(20, 94.1)]))
    assert found.rate < 0.0 < found.difference
    assert found.prominence == 0.0
