"""Figures of a sound over a window: what each is, and why it is none where it does not hold."""

from __future__ import annotations

import numpy as np
import pytest

from creak.sound.loudness import loudness, steady_loudness
from creak.sound.quality import STEADY, TOO_FAINT, TOO_LOUD, TOO_LOW, TOO_SHORT, quality_of
from creak.sound.third_octave import a_weighted_level, a_weighted_sum, third_octave_levels

RECORDED = {"section": "sound"}

RATE = 48_000
A_WEIGHTS = {31.5: -39.4, 63: -26.2, 125: -16.1, 250: -8.6, 500: -3.2, 1000: 0.0, 2000: 1.2, 4000: 1.0, 8000: -1.1}
"""dB of the octaves, IEC 61672-1, table 3; 16 kHz below."""


def tone(freq: float, level: float, seconds: float = 1.0) -> np.ndarray:
    return 2e-5 * 2**0.5 * 10 ** (level / 20) * np.sin(2 * np.pi * freq * np.arange(int(seconds * RATE)) / RATE)


def band(low: float, high: float, level: float, seconds: float = 4.0) -> np.ndarray:
    """Periodic noise of random phases."""
    freq = np.fft.rfftfreq(int(seconds * RATE), 1 / RATE)
    lines = np.exp(2j * np.pi * np.random.default_rng(3).random(freq.size)) * ((freq >= low) & (freq < high))
    x = np.fft.irfft(lines)
    return x * (2e-5 * 10 ** (level / 20) / x.std())


def quality(x, window=(0.0, np.inf), **how):
    return quality_of(x, loudness(x, RATE), window, **how)


def test_one_acum_is_noise_of_a_critical_band_at_1_khz_and_60_db(measured):
    """DIN 45692, 920 to 1080 Hz."""
    found = steady_loudness(band(920, 1080, 60), RATE).sharpness
    measured("DIN 45692: one acum", found, 1.0, rel=0.01, unit="acum", source="DIN 45692")


def test_a_weighting_is_that_of_the_standard_up_to_16_khz(measured):
    """Exact middles of the octaves; the table is rounded to .1 dB."""
    for nominal, weight in (*A_WEIGHTS.items(), (16_000, -6.6)):
        freq = 1000.0 * 10 ** (0.3 * np.rint(np.log10(nominal / 1000.0) / 0.3))
        found = a_weighted_level(tone(freq, 60.0, 2.0), RATE, (0.5, 1.5)) - 60.0  # without the click of its start
        measured("A weighting: worst octave", found, weight, abs=0.06, unit="dB", source="IEC 61672-1, table 3")


def test_level_of_third_octaves_is_about_that_of_the_sound():
    x = band(200, 5000, 60)
    assert a_weighted_sum(third_octave_levels(x, RATE)) == pytest.approx(a_weighted_level(x, RATE), abs=0.3)


def test_figures_of_a_sharp_burst_in_silence():
    """.2 s of 4 kHz in a second: its sharpness is that of the tone, for as long as it is heard."""
    x = np.zeros(RATE)
    x[RATE // 4 : RATE // 4 + RATE // 5] = tone(4000, 70, 0.2)
    found = quality(x)
    steady = steady_loudness(tone(4000, 70), RATE).sharpness
    assert found.sharpness == pytest.approx(steady, rel=0.1)
    assert 0.2 < found.sharp_time < 0.4
    assert quality(x, sharp=10.0).sharp_time == 0.0
    assert found.prominence > 10.0
    assert found.impulse_adjustment == pytest.approx(1.8 * (found.prominence - 5.0))
    assert not found.missing


def test_only_the_window_counts():
    x = np.concatenate([tone(4000, 70, 0.5), np.zeros(RATE), tone(500, 70, 1.0)])
    late = quality(x, (2.0, 2.5))
    assert late.sharp_time == 0.0
    assert late.prominence is None
    assert late.missing == {"prominence": STEADY}
    assert late.impulse_adjustment == 0.0
    assert late.n10 == pytest.approx(steady_loudness(tone(500, 70), RATE).total, rel=0.03)
    assert quality(x, (0.0, 0.5)).sharp_time == pytest.approx(0.5, abs=0.01)


def test_figures_that_do_not_hold_are_none_and_say_why():
    faint = quality(tone(1000, 5))
    assert faint.sharpness is faint.roughness is None
    assert faint.missing["sharpness"] == faint.missing["roughness"] == TOO_FAINT
    short = quality(tone(1000, 60, 0.19))
    assert short.roughness is None
    assert short.missing["roughness"] == TOO_SHORT
    assert quality(tone(1000, 130)).missing["roughness"] == TOO_LOUD
    assert quality(tone(80, 80)).missing["roughness"] == TOO_LOW
    beyond = quality_of(tone(30, 130), None, (0.0, 1.0))
    assert beyond.n10 is beyond.sharpness is beyond.sharp_time is None
    assert all("120 dB" in beyond.missing[name] for name in ("n10", "sharpness", "sharp_time"))
