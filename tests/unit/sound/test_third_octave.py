"""Third-octave levels: tones in every band, energy of noise and of a pulse."""

from __future__ import annotations

import numpy as np
import pytest

from creak.errors import InputError
from creak.sound.third_octave import third_octave_levels
from creak.sound.zwicker_tables import BANDS

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
        "sound",
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


def test_wrong_input_gets_one_clear_message():
    with pytest.raises(InputError, match="one channel"):
        third_octave_levels(np.zeros((3, 2)), RATE)
