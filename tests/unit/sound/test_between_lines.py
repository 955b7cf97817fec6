"""Frequency response functions between their lines, against the functions themselves."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from creak.sound.between_lines import Lines


def parts(freq: np.ndarray, value: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Real and imaginary part alone, by monotone cubics over log frequency."""
    both = np.column_stack([value.real, value.imag])
    return PchipInterpolator(np.log(freq), both)(np.log(at)) @ [1.0, 1j]


def resonance(freq: np.ndarray, own: float, zeta: float) -> np.ndarray:
    return freq**2 / (own**2 - freq**2 + 2j * zeta * freq * own)


def with_zeros(freq: np.ndarray) -> np.ndarray:
    return 1.0 + 0.5 * resonance(freq, 300.3, 0.02) + 0.7 * resonance(freq, 600.7, 0.02)


def undamped_zero(freq: np.ndarray) -> np.ndarray:
    return np.sin(2 * np.pi * (freq - 303.0) / 900.0) + 0j


def cabin(freq: np.ndarray) -> np.ndarray:
    """Sixty paths that die away over 20 ms."""
    rng = np.random.default_rng(0)
    late = rng.exponential(0.01, 60)
    size = rng.standard_normal(60) * np.exp(-late / 0.02)
    return np.exp(-2j * np.pi * np.outer(freq, late)) @ size


def level(z: np.ndarray) -> float:
    return float(10 * np.log10(np.mean(np.abs(z) ** 2)))


@pytest.mark.parametrize(
    ("function", "apart"),
    [
        (lambda f: resonance(f, 300.3, 0.02), 2.0),
        (lambda f: resonance(f, 300.3, 0.02), 8.0),
        (lambda f: resonance(f, 300.3, 0.05), 10.0),
        (with_zeros, 2.0),
        (with_zeros, 8.0),
        (undamped_zero, 10.0),
        (cabin, 1.0),
        (cabin, 5.0),
        (cabin, 10.0),
    ],
)
def test_resonances_zeros_and_cabins_are_met_no_worse_than_by_their_parts(function, apart):
    freq, at = np.arange(10.0, 1000.0, apart), np.linspace(20.0, 950.0, 5001)
    known, exact = function(freq), function(at)
    plain, found = parts(freq, known, at), Lines(freq, known).at(at)
    for norm in (np.max, np.mean):
        assert norm(np.abs(found - exact)) <= norm(np.abs(plain - exact)) * (1 + 1e-9)
    assert abs(level(found) - level(exact)) <= min(abs(level(plain) - level(exact)) + 1e-9, 0.1)
    assert not Lines(freq, known).unknown.size


@pytest.mark.parametrize("late", [-0.004, 0.003, 0.04])
def test_a_delay_beside_a_resonance_is_taken_off(late):
    """What all is late by, or early, changes nothing of what is met between lines 20 Hz apart."""
    freq, at = np.arange(20.0, 4000.0, 20.0), np.linspace(100.0, 3900.0, 5001)
    still = 1.0 + 0.1 * resonance(freq, 900.0, 0.1)
    found = Lines(freq, still * np.exp(-2j * np.pi * freq * late))
    assert found.delay == pytest.approx(late, abs=3e-4)
    exact = 1.0 + 0.1 * resonance(at, 900.0, 0.1)
    np.testing.assert_allclose(found.at(at), exact * np.exp(-2j * np.pi * at * late), atol=0.02)


def test_known_values_are_met_and_a_few_degrees_of_delay_change_nothing():
    freq = np.array([20.0, 25.0, 31.5, 700.0, 9000.0])
    value = np.random.default_rng(3).standard_normal(10).view(complex)
    np.testing.assert_allclose(Lines(freq, value).at(freq), value, atol=1e-9)
    freq = np.arange(2.0, 500.0, 2.0)
    late = np.exp(-2j * np.pi * freq * 0.01)
    at = np.linspace(2.0, 498.0, 777)
    assert Lines(freq, late).delay == 0.0
    np.testing.assert_array_equal(Lines(freq, late).at(at), parts(freq, late, at))


def test_a_resonance_between_two_lines_is_told():
    """Over 100 Hz its phase turns by almost half a turn; lines an eighth of a turn apart are named."""
    freq = np.arange(50.0, 1000.0, 100.0)
    found = Lines(freq, resonance(freq, 300.0, 0.02))
    assert found.unknown.tolist() == [2]
    assert 20.0 < found.fine(found.unknown) < 35.0
