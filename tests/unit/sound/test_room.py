"""The diffuse field of a room against Sabine: its level, its decay, and what two ears have in common of it."""

from __future__ import annotations

import numpy as np
import pytest

from creak.sound.carriers import Span, along, carriers, lines_of
from creak.sound.rayleigh import AIR
from creak.sound.room import Room, diffuse_squares, ear_noise
from creak.sound.third_octave import third_octave_levels
from creak.sound.zwicker_tables import BANDS

RECORDED = {"section": "sound"}

RATE = 48_000
DISTANCE = 0.7
"""m"""
KHZ = 16
"""Row of the third octave of 1 kHz."""


def room(time: float, volume: float = 3.0) -> Room:
    return Room(volume, np.full(BANDS.size, time))


def noise(seconds: float, freq: float = 1000.0) -> np.ndarray:
    """A third octave of noise of 1 Pa, between silences of .2 s."""
    n = int(seconds * RATE)
    white = np.random.default_rng(3).standard_normal(n)
    lines = np.fft.rfftfreq(n, 1 / RATE)
    x = np.fft.irfft(np.fft.rfft(white) * ((lines > 0.9 * freq) & (lines < 1.11 * freq)), n)
    return np.pad(x / np.sqrt(np.mean(x**2)), int(0.2 * RATE))


@pytest.mark.parametrize("time", [0.06, 0.3])
def test_a_source_of_known_power_has_sabines_level(time, measured):
    """4 rho c P (1 - alpha) / (S alpha), P = 2 pi r^2 p^2 / (rho c) of a source before a wall."""
    cabin, x, span = room(time), noise(2.0), Span(20.0, 8000.0)
    squares = diffuse_squares(cabin, x, DISTANCE**-2, span.bands)
    out = along(carriers(span, span.bands, x.size + 40), squares, 1000).sum(axis=0)
    power = 2 * np.pi * DISTANCE**2 / (AIR.density * AIR.speed)
    area = 55.26 * 3.0 / (AIR.speed * time)
    walls = 6 * 3.0 ** (2 / 3)
    sabine = 4 * AIR.density * AIR.speed * power * (1 - area / walls) / area
    assert cabin.absorption[KHZ] == pytest.approx(area, rel=1e-4)
    found = third_octave_levels(out, RATE, (0.7, 2.1)) - third_octave_levels(x, RATE, (0.7, 2.1))
    measured(f"room of {time:g} s: level", found[KHZ], 10 * np.log10(sabine), abs=0.2, unit="dB")


def test_after_the_source_it_falls_by_60_db_in_the_reverberation_time(measured):
    cabin, x = room(0.5), np.pad(noise(1.0), (0, RATE))
    (square,) = diffuse_squares(cabin, x, 1.0, np.array([KHZ]))
    at = np.array([1.25, 1.65])
    level = 10 * np.log10(np.interp(at, np.arange(x.size) / RATE, square))
    measured("room: decay in its reverberation time", (level[0] - level[1]) * 0.5 / 0.4, 60.0, abs=0.5)
    assert square[: int(0.15 * RATE)].max() < 1e-6 * square.max()  # nothing before the sound itself


def test_each_third_octave_has_its_own_time():
    times = np.where(BANDS < 1500.0, 0.2, 0.1)
    click = np.zeros(RATE)
    click[9_600] = 1.0
    low, high = (diffuse_squares(Room(3.0, times), click, 1.0, np.array([k])) for k in (KHZ, 22))
    level = [10 * np.log10(x[0][[12_000, 14_400]]) for x in (low, high)]
    assert [a - b for a, b in level] == pytest.approx([15.0, 30.0], abs=0.5)


def test_schroeders_frequency_and_walls_that_absorb_all():
    assert room(0.12).schroeder == pytest.approx(2000 * np.sqrt(0.12 / 3.0))
    assert room(1e-3).absorbed[0] > 1.0
    assert room(200.0, 1e-3).schroeder == np.inf


def test_two_ears_have_the_coherence_of_a_diffuse_field():
    """sin(kd) / (kd), d = 3 a; each ear as loud as the middle."""
    span, size = Span(20.0, 9000.0), 4 * RATE
    own = carriers(span, span.bands, size)
    left, right = (ear_noise(own, span.bands, 0.0875, side) for side in (1, -1))
    for row, band in enumerate(span.bands.tolist()):
        if BANDS[band] < 60.0 or BANDS[band] > 8000.0:
            continue
        kd = 2 * np.pi * BANDS[band] / AIR.speed * 3 * 0.0875
        same = np.mean(left[row] * right[row])
        assert same == pytest.approx(np.sin(kd) / kd, abs=0.12)
        assert np.mean(left[row] ** 2) == pytest.approx(1.0, abs=0.12)
    assert ear_noise(own, span.bands, 0.0875, 0) is own
    assert lines_of(KHZ, 1.0, 24_001)[0].start > 800
