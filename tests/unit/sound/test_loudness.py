"""Loudness after ISO 532-1:2017 against the standard's own numbers, its definition of the sone, and another program."""

from __future__ import annotations

import wave
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import creak
from creak.errors import InputError
from creak.sound.loudness import added_loudness, loudness, loudness_level, loudness_of_levels, steady_loudness
from creak.sound.third_octave import third_octave_levels
from creak.sound.zwicker_tables import BARK

RECORDED = {"section": "sound", "source": "ISO 532-1"}

SIGNALS = Path(__file__).resolve().parents[4] / "shared" / "sound"
RATE = 48_000
MACHINE = [
    *(-60, -60, 78, 79, 89, 72, 80, 89, 75, 87, 85, 79, 86, 80, 71, 70, 72, 71, 72, 74, 69, 65, 67, 77, 68, 58),
    *(45, 30),
]
"""dB, third octaves of the standard's signal 1."""
CRITICAL = [
    *(200, 300, 400, 510, 630, 770, 920, 1080, 1270, 1480, 1720, 2000, 2320, 2700, 3150, 3700, 4400, 5300),
    *(6400, 7700, 9500, 12000),
]
ACUM = [
    *(0.38, 0.49, 0.60, 0.71, 0.82, 0.93, 1.00, 1.13, 1.26, 1.35, 1.49, 1.64, 1.78, 2.06, 2.40, 2.82, 3.48),
    *(4.43, 5.52, 6.81, 8.55),
]
"""Sharpness of noise between two `CRITICAL` frequencies, DIN 45692, table A.2."""
ABOVE = {250: 2.70, 570: 2.85, 1000: 3.05, 2150: 3.53, 4000: 4.49, 7000: 6.47}
"""Sharpness of noise from a frequency up to 10 kHz, DIN 45692, table A.3."""


def tone(freq: float, level: float, seconds: float = 1.0, rate: float = RATE) -> np.ndarray:
    """Sine of `level` dB."""
    return 2e-5 * 10 ** (level / 20) * 2**0.5 * np.sin(2 * np.pi * freq * np.arange(int(seconds * rate)) / rate)


def noise(low: float, high: float, slope: float = 0.0, seconds: float = 4.0, seed: int = 3) -> np.ndarray:
    """Periodic noise of 60 dB: lines of random phase with power f^slope between `low` and `high`."""
    n = int(seconds * RATE)
    freq = np.fft.rfftfreq(n, 1 / RATE)
    inside = (freq >= low) & (freq < high)
    lines = np.zeros(freq.size, dtype=complex)
    phases = np.random.default_rng(seed).uniform(0, 2 * np.pi, inside.sum())
    lines[inside] = freq[inside] ** (slope / 2) * np.exp(1j * phases)
    x = np.fft.irfft(lines, n)
    return x * (2e-5 * 10**3 / x.std())


def iso(number: int) -> tuple[np.ndarray, np.ndarray]:
    """Pressure in Pa and the standard's loudness every 2 ms."""
    if not SIGNALS.is_dir():
        pytest.skip(f"the standard's signals are not at {SIGNALS}")
    with wave.open(str(SIGNALS / f"signal_{number:02d}.wav")) as file:
        assert file.getframerate() == RATE
        samples = np.frombuffer(file.readframes(file.getnframes()), "<i2")
    table = np.loadtxt(SIGNALS / f"signal_{number:02d}_loudness.csv", delimiter=",", skiprows=1)
    return samples / 32768 * 2 * 2**0.5, table[:, 1]


@pytest.mark.parametrize("number", range(6, 14))
def test_signals_of_the_standard_over_time(number, measured):
    """Within 5 % or .1 sone, which the standard asks for, at every instant and without its shift of 2 ms; in truth the
    standard's numbers are rounded to .001 sone, above 16 sone .01, and the curves agree to .02."""
    pressure, wanted = iso(number)
    found = loudness(pressure, RATE)
    assert found.total.shape == wanted.shape
    assert np.allclose(found.time, 0.002 * np.arange(wanted.size))
    miss = np.abs(found.total - wanted)
    assert (miss <= np.maximum(0.05 * wanted, 0.1)).all()
    measured(f"ISO 532-1 signal {number}: largest error of N(t)", miss.max(), at_most=0.02, unit="sone")


@pytest.mark.parametrize(
    ("number", "n_max", "n5", "n10"),
    [
        (6, 14.359, 11.802, 9.703),
        (8, 23.950, 20.062, 16.736),
        (9, 29.314, 24.090, 20.670),
        (10, 4.300, 0.745, 0.338),
        (13, 9.976, 3.410, 2.971),
    ],
)
def test_percentiles_are_those_of_the_standards_curve(number, n_max, n5, n10):
    found = loudness(iso(number)[0], RATE)
    assert found.n_max == pytest.approx(n_max, rel=1e-3)
    assert found.n5 == pytest.approx(n5, rel=1e-3)
    assert found.n10 == pytest.approx(n10, rel=1e-3)


@pytest.mark.parametrize(("freq", "level", "sone"), [(250, 80, 14.655), (1000, 60, 4.019), (4000, 40, 1.549)])
def test_tones_of_the_standard(freq, level, sone, measured):
    found = steady_loudness(tone(freq, level), RATE).total
    measured(f"ISO 532-1, tone of {freq} Hz and {level} dB", found, sone, rel=0.01, unit="sone")


def test_levels_of_the_standards_machine(measured):
    found = loudness_of_levels(MACHINE).total
    measured("ISO 532-1, signal 1 from its levels", found, 83.296, rel=1e-4, unit="sone")


def test_one_sone_is_a_tone_of_40_db_and_ten_more_double_it():
    for level, sone in [(40, 1), (50, 2), (60, 4), (70, 8), (80, 16)]:
        found = steady_loudness(tone(1000, level), RATE)
        assert found.total == pytest.approx(sone, rel=0.02)
        assert found.level == pytest.approx(level, abs=0.3)


def test_a_steady_tone_is_as_loud_over_time_as_the_steady_method_says():
    over_time = loudness(tone(1000, 70, seconds=1.5), RATE)
    assert over_time.total[-1] == pytest.approx(steady_loudness(tone(1000, 70), RATE).total, rel=0.01)
    assert over_time.n_max == pytest.approx(over_time.total[-1], rel=0.01)


def test_loudness_levels():
    assert loudness_level(np.array([1.0, 2.0, 16.0])) == pytest.approx([40.0, 50.0, 80.0])
    assert loudness_level(np.array([0.0, 0.1])) == pytest.approx([3.0, 40 * 0.1005**0.35])


def test_total_is_the_integral_of_the_specific_loudness():
    found = loudness_of_levels(MACHINE)
    assert found.specific.shape == BARK.shape
    assert 0.1 * found.specific.sum() == pytest.approx(found.total, rel=0.01)


def test_nothing_is_heard_of_silence_and_time_starts_at_the_record():
    found = loudness(np.zeros(4801), RATE)
    assert found.total.shape == found.time.shape == found.level.shape == found.sharpness.shape == (51,)
    assert found.time[[0, 1, -1]] == pytest.approx([0.0, 0.002, 0.1])
    assert found.n_max == 0.0
    assert not found.specific.any()
    assert not found.sharpness.any()
    assert (found.level == 3.0).all()


def test_a_long_sound_dies_away_more_slowly_than_a_short_one():
    """Loudness 50 ms after the end over the loudness at the end: a third less after 10 ms than after half a second."""
    left = []
    for seconds in (0.01, 0.5):
        x = np.concatenate([tone(1000, 80, seconds), np.zeros(RATE // 4)])
        instant, end = loudness(x, RATE).specific.sum(axis=1), round(seconds / 0.002)
        left.append(instant[end + 25] / instant[end - 1])
    assert left[0] < 0.67 * left[1]


@pytest.mark.parametrize("rate", [16_000, 44_100, 96_000, 3e5 / 7])
def test_other_rates_hear_the_same(rate):
    """But for the first milliseconds: sampled slowly, a tone cannot begin as suddenly."""
    found = loudness(tone(1000, 60, 0.5, rate), rate)
    wanted = loudness(tone(1000, 60, 0.5), RATE)
    n = min(found.total.size, wanted.total.size)
    assert abs(found.total.size - wanted.total.size) <= 1
    assert found.total[: n - 5] == pytest.approx(wanted.total[: n - 5], rel=0.01, abs=0.05)


def test_twice_the_sampling_adds_nothing_above_the_first_half():
    """A tone near half of the slow rate leaves no image in the bands above it: 80 dB make none that is heard."""
    slow = steady_loudness(tone(3000, 80, 1.0, 8000), 8000)
    assert slow.specific == pytest.approx(steady_loudness(tone(3000, 80), RATE).specific, abs=0.05)


@pytest.mark.parametrize("index", range(1, len(ACUM)))
def test_sharpness_of_narrow_noise(index, measured):
    """Noise a critical band wide and 4 sone loud: within the larger of 5 % and .05 acum, as DIN 45692 asks.

    Not the lowest band: its .38 is that of a tone at 250 Hz (.376), where noise with edges at 200 and 300 Hz has .43.
    """
    found = sharpness_at_4_sone(noise(CRITICAL[index], CRITICAL[index + 1]))
    allowed = max(0.05, 0.05 * ACUM[index])
    measured(
        "DIN 45692, narrow noise: sharpness, worst band",
        found,
        ACUM[index],
        abs=allowed,
        unit="acum",
        source="DIN 45692",
    )


@pytest.mark.parametrize("low", ABOVE)
def test_sharpness_of_broad_noise(low):
    assert sharpness_at_4_sone(noise(low, 10e3)) == pytest.approx(ABOVE[low], rel=0.05)


def sharpness_at_4_sone(x: np.ndarray) -> float:
    levels = third_octave_levels(x, RATE)
    shift = brentq(lambda db: loudness_of_levels(levels + db).total - 4.0, -60, 40)
    return loudness_of_levels(levels + shift).sharpness


def test_sharpness_over_time_is_that_of_the_steady_sound():
    x = noise(2000, 2320)
    assert np.median(loudness(x[:RATE], RATE).sharpness[100:]) == pytest.approx(
        steady_loudness(x, RATE).sharpness, rel=0.05
    )


def test_what_a_tone_adds_to_a_background_is_the_loudness_of_both_less_the_backgrounds():
    x, background = tone(1000, 60), np.full(28, 50.0)
    own = third_octave_levels(x, RATE)
    both = 10.0 * np.log10(10.0 ** (0.1 * background) + 10.0 ** (0.1 * own))
    expected = loudness_of_levels(both).total - loudness_of_levels(background).total
    added = added_loudness(x, RATE, background)
    assert np.median(added[added.size // 2 :]) == pytest.approx(expected, rel=0.01)
    alone = loudness(x, RATE).total
    assert added_loudness(x, RATE, np.full(28, -100.0)) == pytest.approx(alone, abs=1e-9)
    assert added_loudness(np.zeros(RATE // 4), RATE, background).max() < 1e-4


@pytest.mark.parametrize("field", ["free", "diffuse"])
def test_mosqito_hears_the_same(field):
    """Over time, but for its ends: there it takes the sample after the last, and before the first, for another."""
    ends = slice(5, -2)
    metrics = pytest.importorskip(
        "mosqito.sq_metrics", reason="mosqito is not installed: pip install 'creak[dev,report]'"
    )
    rng = np.random.default_rng(7)
    x = rng.standard_normal(RATE // 2) * np.repeat([0.02, 0.5, 0.0, 0.005], RATE // 8)
    total, specific, bark, _ = metrics.loudness_zwtv(x, RATE, field)
    found = loudness(x, RATE, field=field)
    assert found.total[ends] == pytest.approx(total[ends], rel=2e-3, abs=2e-3)
    assert bark == pytest.approx(BARK)
    apart = np.abs(found.specific - specific.T)[ends]
    assert np.quantile(apart, 0.995) < 2e-3
    assert apart.max() < 0.1  # at single points, where a slope turns


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: loudness(np.zeros((2, 5)), RATE), "shape"),
        (lambda: loudness(np.zeros(0), RATE), "shape"),
        (lambda: loudness([0.0, np.nan], RATE), "nan at sample 1"),
        (lambda: loudness([1e300, 0.0], RATE), "1e.300 at sample 0"),
        (lambda: loudness(["loud"], RATE), "no number"),
        (lambda: loudness([0.1j], RATE), "complex"),
        (lambda: loudness([0.1], "48 kHz"), "sampling rate = '48 kHz'; expected a number"),
        (lambda: loudness(np.zeros(9), 100.0), "100 Hz"),
        (lambda: loudness(np.zeros(9), np.nan), "nan Hz"),
        (lambda: loudness(np.zeros(9), RATE, field="near"), "near"),
        (lambda: loudness(tone(30, 130), RATE), "120 dB"),
        (lambda: steady_loudness(np.zeros(4800), RATE), "0.1 s"),
        (lambda: steady_loudness(np.zeros(4800), RATE, skip=-1.0), "skip = -1; expected seconds"),
        (lambda: loudness_of_levels(np.zeros(27)), "28"),
        (lambda: loudness(np.zeros(9), RATE).exceeded(101), "101"),
    ],
)
def test_wrong_input_gets_one_clear_message(call, message):
    with pytest.raises(InputError, match=message):
        call()


def test_it_is_public():
    assert creak.loudness is loudness
    assert creak.steady_loudness is steady_loudness
