"""Noise that follows energies: powers of bands, energy of an oscillator, levels and seams."""

from __future__ import annotations

import numpy as np
import pytest

from creak.sound.carriers import Span, along, band_power, carriers, force_lines, stored, third_octave_gain
from creak.sound.forced import high_end
from creak.sound.zwicker_tables import BANDS, RATE


def test_bands_share_all_energy_and_a_span_what_was_given_up():
    freq = np.geomspace(30.0, 10_000.0, 4000)
    total = sum(third_octave_gain(k, freq) ** 2 for k in range(BANDS.size))
    np.testing.assert_allclose(total, 1.0, atol=1e-12)
    span, below = Span(500.0, 10_000.0), freq < 8_000.0
    np.testing.assert_allclose((span.gain(freq) ** 2 + high_end(freq, 500.0) ** 2)[below], 1.0, atol=1e-12)


def test_power_of_a_tone_and_of_a_blow():
    """A tone of 2 N has 2 N^2; a blow as much over time as its spectrum has in the band."""
    time = np.arange(48_000) / RATE
    lines = force_lines(2.0 * np.sin(2 * np.pi * 1000.0 * time)[:, None], 10_000.0)
    at, power = band_power(lines, *lines.of(16), np.ones((1, 1)))
    inside = (at > 0.2) & (at < 0.8)
    assert power[inside] == pytest.approx(2.0 / np.sinc(1000.0 / RATE) ** 2, rel=1e-4)
    blow = np.zeros((24_000, 1))
    blow[12_000] = 1.0
    lines = force_lines(blow, 10_000.0)
    at, power = band_power(lines, *lines.of(20), np.ones((1, 1)))
    width = BANDS[20] * (10**0.05 - 10**-0.05)
    middle = np.sinc(BANDS[20] / RATE) ** -2.0
    assert power.sum() * (at[1] - at[0]) == pytest.approx(2.0 * width * middle / RATE**2, rel=0.02)
    assert at[power.argmax()] == pytest.approx(12_000 / RATE, abs=2.0 / width)


def test_forces_that_last_begin_and_end_without_a_click():
    lines = force_lines(np.full((9_600, 1), 5.0), 10_000.0)
    _, power = band_power(lines, *lines.of(16), np.ones((1, 1)))
    assert power.max() < 1e-10


def test_energy_decays_with_its_rate():
    time = np.linspace(0.0, 0.1, 1001)
    power = np.where(time < 0.05, 3.0, 0.0)
    energy = stored(time, power, 200.0)
    assert energy[490] == pytest.approx(3.0 / 200.0 * (1 - np.exp(-200.0 * time[491])), rel=1e-9)
    assert energy[800] / energy[700] == pytest.approx(np.exp(-200.0 * 0.01), rel=1e-9)


def test_noise_has_the_energy_that_it_is_given_and_a_flat_envelope():
    span = Span(500.0, 10_000.0)
    noise = carriers(span, span.bands, 48_000)
    assert noise.mean(axis=0).std() > 0.0
    np.testing.assert_allclose((noise**2).mean(axis=1), 1.0)
    square = 1e-4 * np.exp(-np.arange(24_000) / 4_000.0)
    out = along(noise, [square] * noise.shape[0], 7_000)
    np.testing.assert_allclose((out**2).sum(axis=1), square.sum())
    # Energy of each tenth of it follows what is given within 1 dB: the noise does not fluctuate by itself.
    parts = (out[8] ** 2).reshape(10, -1).sum(axis=1) / square.reshape(10, -1).sum(axis=1)
    assert np.abs(10 * np.log10(parts)).max() < 1.0
    other = along(noise, [square] * noise.shape[0], 20_000)
    assert abs((out * other).sum()) < 0.1 * (out**2).sum()  # that of another place is another one
