"""Third-octave levels: tones in every band, energy of noise and of a pulse."""

from __future__ import annotations

import numpy as np
import pytest

from creak.errors import InputError
from creak.sound.third_octave import SILENCE, a_weighted_level, third_octave_levels
from creak.sound.zwicker_tables import BANDS

RECORDED = {"section": "sound"}

RATE = 48_000


@pytest.mark.parametrize("band", range(28))
def test_a_tone_in_the_middle_of_a_band_has_its_level_there(band, measured):
    """94 dB within .1; the filters to either side are 20 dB down, those beyond 38; a tone of two seconds that starts and
    ends at once has 2 and 10 dB more there in the lowest bands."""
    x = 2**0.5 * np.sin(2 * np.pi * BANDS[band] * np.arange(2 * RATE) / RATE)
    levels = third_octave_levels(x, RATE)
    assert (levels[[b for b in (band - 1, band + 1) if 0 <= b < 28]] < 94 - 17).all()
    assert (levels[[b for b in range(28) if abs(b - band) > 1]] < 94 - 28).all()
    measured(
        "third octaves: a tone in the middle, worst band",
        levels[band],
        93.98,
        abs=0.1,
        unit="dB",
        source="its definition",
    )


def test_names_of_the_bands_are_their_frequencies_rounded():
    assert BANDS[[0, 10, 16, 27]] == pytest.approx([25, 250, 1000, 12_500], rel=0.01)


def test_white_noise_rises_3_db_an_octave_and_its_bands_hold_its_energy():
    x = np.random.default_rng(2).standard_normal(20 * RATE)
    levels = third_octave_levels(x, RATE)
    width = BANDS * (10**0.05 - 10**-0.05)
    wanted = 93.98 + 10 * np.log10(width / (RATE / 2))
    assert levels[6:] == pytest.approx(wanted[6:], abs=0.5)


def test_a_pulse_keeps_its_energy_whatever_silence_follows():
    """Ten times the record is 10 dB less, also for the band that rings on beyond the shorter one."""
    pulse = np.zeros(RATE // 10)
    pulse[100] = 20.0
    short = third_octave_levels(pulse, RATE)
    long = third_octave_levels(np.concatenate([pulse, np.zeros(9 * pulse.size)]), RATE)
    assert short - long == pytest.approx(10.0, abs=0.01)


def test_other_rates_have_the_same_levels():
    def tones(rate: float) -> np.ndarray:
        t = np.arange(int(rate)) / rate
        return np.sin(2 * np.pi * 100 * t) + 0.1 * np.sin(2 * np.pi * 3150 * t)

    loud = [6, 21]
    wanted = third_octave_levels(tones(RATE), RATE)[loud]
    for rate in (12_000, 44_100, 200_000):
        assert third_octave_levels(tones(rate), rate)[loud] == pytest.approx(wanted, abs=0.02)


@pytest.mark.parametrize("freq", [25.0, 63.0, 1000.0, 5000.0])
@pytest.mark.parametrize("phase", [0.0, 1.3])
def test_a_tone_that_goes_on_through_a_window_is_in_its_own_band_alone(freq, phase):
    """As an endless tone: level within .1 dB, and what is left of other bands are the skirts of the filters, which fall
    18 dB an octave; the click of a cut would fall by 6."""
    x = 2**0.5 * np.sin(2 * np.pi * freq * np.arange(3 * RATE) / RATE + phase)
    levels, own = third_octave_levels(x, RATE, (1.0, 2.013)), np.abs(BANDS / freq - 1).argmin()
    assert levels[own] == pytest.approx(93.98, abs=0.1)
    octaves = np.abs(np.log2(BANDS / BANDS[own]))
    assert (levels[octaves > 2] < np.maximum(79.0 - 18.0 * octaves[octaves > 2], SILENCE + 3.0)).all()


@pytest.mark.parametrize("freq", [63.0, 1000.0, 8000.0])
@pytest.mark.parametrize("at", [1.0, 1.3, 1.75])
def test_a_burst_keeps_its_energy_wherever_it_lies_in_a_window(freq, at):
    """int sin^4(pi t / T) sin^2 dt = 3 T / 16, from the first instant of the window to its last: within .15 dB, as the
    bands overlap."""
    t = np.arange(3 * RATE) / RATE - at
    x = np.where((t > 0) & (t < 0.25), np.sin(4 * np.pi * t) ** 2 * np.sin(2 * np.pi * freq * t), 0.0)
    wanted = 10 * np.log10(3 * 0.25 / 16 / 4e-10)
    found = third_octave_levels(x, RATE, (1.0, 2.0))
    assert 10 * np.log10((10 ** (found / 10)).sum()) == pytest.approx(wanted, abs=0.15)
    gain = a_weighted_level(np.sin(2 * np.pi * freq * np.arange(RATE) / RATE), RATE, (0.25, 0.75)) - 90.97
    assert a_weighted_level(x, RATE, (1.0, 2.0)) == pytest.approx(wanted + gain, abs=0.1)


def test_noise_of_a_band_is_in_that_band_whatever_part_is_looked_at():
    """250 to 500 Hz with sharp ends: the density over each band within 1 dB, as 8 s of .23 f width spread; none outside."""
    rng, n = np.random.default_rng(3), 12 * RATE
    freq = np.fft.rfftfreq(n, 1 / RATE)
    inside = (freq > 250) & (freq < 500)
    x = np.fft.irfft(np.where(inside, np.exp(2j * np.pi * rng.random(freq.size)), 0.0) * n / 2e3, n)
    levels = third_octave_levels(x, RATE, (2.0, 10.0))
    width = BANDS[12] * (10**0.05 - 10**-0.05)
    density = (x**2).mean() / 250.0
    assert levels[12] == pytest.approx(10 * np.log10(density * width / 4e-10), abs=1.0)
    assert levels[12] - levels[5] > 45.0
    assert levels[20:].max() < levels[12] - 60.0


@pytest.mark.parametrize(
    ("freq", "weight"),
    [(25, -44.7), (63, -26.2), (250, -8.6), (1000, 0), (4000, 1.0), (8000, -1.1), (12_500, -4.3), (16_000, -6.6)]
    + [(20_000, -9.3)],
)
def test_a_weighting_of_tones(freq, weight):
    """IEC 61672-1, table 3, at the exact frequencies that are meant: its tenths of a dB."""
    exact = 10 ** (round(10 * np.log10(freq)) / 10)
    x = 2**0.5 * np.sin(2 * np.pi * exact * np.arange(2 * RATE) / RATE)
    assert a_weighted_level(x, RATE, (0.5, 1.5)) == pytest.approx(93.98 + weight, abs=0.06)


def test_wrong_input_gets_one_clear_message():
    with pytest.raises(InputError, match="one channel"):
        third_octave_levels(np.zeros((3, 2)), RATE)
