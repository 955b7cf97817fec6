"""Random vibration against its density and Miles's equation, sweeps and shocks against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.signal import welch

from creak.signals.sources import Table, acceleration_motion, displacement_motion
from creak.signals.vibration import HalfSine, RandomVibration, SineSweep, trapezoid

RECORDED = {"section": "signals"}

NAVMAT = RandomVibration(np.array([20.0, 80.0, 350.0, 2000.0]), np.array([0.01, 0.04, 0.04, 0.007]), 4.0, seed=3)


def test_density_between_its_points_is_a_power_of_the_frequency(measured):
    f = np.array([20.0, 40.0, 80.0, 200.0])
    expected = [0.01, 0.02, 0.04, 0.04]  # +3 dB an octave from 20 to 80 Hz
    measured("density between points, {}", NAVMAT.at(f), expected, rel=1e-12, source="closed form")
    zero = RandomVibration(np.array([10.0, 20.0]), np.array([0.0, 1.0]), 1.0)
    np.testing.assert_allclose(zero.at(np.array([15.0])), 0.5)


def test_rms_is_the_root_of_the_area(measured):
    area = sum(quad(lambda f: NAVMAT.at(np.array([f]))[0], a, b)[0] for a, b in ((20, 80), (80, 350), (350, 2000)))
    measured("random vibration: rms", NAVMAT.rms, np.sqrt(area), rel=2e-3, source="integral of the density")


def test_periodogram_is_the_density():
    t = np.arange(0.0, 4.0, 1.0 / 8192.0)
    x = NAVMAT.values(t)
    lines = np.fft.rfft(x) * 2.0 / t.size
    f = np.fft.rfftfreq(t.size, 1.0 / 8192.0)
    inside = (f >= 20.0) & (f <= 2000.0)
    np.testing.assert_allclose(0.5 * np.abs(lines[inside]) ** 2 * 4.0, NAVMAT.at(f[inside]), rtol=1e-9)
    assert np.abs(lines[~inside]).max() < 1e-12


def test_segments_scatter_as_chi_square():
    """Welch's estimate over 64 segments: within the band of 99.9 % of chi-square with 128 degrees of freedom."""
    signal = RandomVibration(np.array([10.0, 1000.0]), np.array([2.0, 2.0]), 64.0, seed=1)
    t = np.arange(0.0, 64.0, 1.0 / 4096.0)
    f, found = welch(signal.values(t), 4096.0, window="boxcar", nperseg=4096, noverlap=0, detrend=False)
    some = found[(f > 20.0) & (f < 980.0)] / 2.0
    assert np.mean((some > 0.64) & (some < 1.46)) > 0.99  # chi2.ppf([.0005, .9995], 128) / 128
    assert some.mean() == pytest.approx(1.0, abs=0.02)


def test_oscillator_answers_as_miles_says(measured):
    """Base acceleration of 1 (m/s2)2/Hz, 60 Hz, 2 %: rms of the absolute acceleration, in closed form per line."""
    f0, zeta = 60.0, 0.02
    signal = RandomVibration(np.array([1.0, 2000.0]), np.array([1.0, 1.0]), 40.0)
    omega, amplitude, _ = signal.lines
    r = omega / (2.0 * np.pi * f0)
    gain = (1.0 + (2.0 * zeta * r) ** 2) / ((1.0 - r**2) ** 2 + (2.0 * zeta * r) ** 2)
    rms = np.sqrt(0.5 * (amplitude**2 * gain).sum())
    miles = np.sqrt(0.5 * np.pi * f0 / (2.0 * zeta) * (1.0 + 4.0 * zeta**2))
    measured("oscillator on a shaken base: rms", rms, miles, rel=0.01, source="Miles 1954", unit="m/s2")


def test_samples_that_do_not_divide_the_period_lie_on_the_same_curve():
    """Against the sum of cosines itself."""
    t = np.linspace(0.0, 5.0, 301) * 0.97
    omega, amplitude, phase = NAVMAT.lines
    for order in (-2, 0):
        exact = np.cos(np.outer(t, omega) + phase + 0.5 * np.pi * order) @ (amplitude * omega**order)
        np.testing.assert_allclose(NAVMAT.derivative(t, order), exact, atol=1e-4 * np.abs(exact).max())


def test_integrals_of_the_sum_are_its_motion():
    t = np.linspace(0.0, 1.0, 20001)
    signal = RandomVibration(np.array([5.0, 50.0]), np.array([1.0, 1.0]), 1.0)
    motion = acceleration_motion(signal, t)
    h = t[1]
    np.testing.assert_allclose(np.gradient(motion.velocity, h)[5:-5], motion.acceleration[5:-5], atol=2e-3)
    np.testing.assert_allclose(np.gradient(motion.displacement, h)[5:-5], motion.velocity[5:-5], atol=2e-5)
    assert motion.displacement[0] == motion.velocity[0] == 0.0


@pytest.mark.parametrize(("logarithmic", "half"), [(False, 52.5), (True, np.sqrt(5.0 * 100.0))])
def test_a_sweep_is_at_its_frequency(logarithmic, half):
    """Half way: the arithmetic or the geometric mean; afterwards it stays at the last."""
    sweep = SineSweep(5.0, 100.0, 2.0, 10.0, logarithmic)
    for at, frequency in ((0.0, 5.0), (5.0, half), (12.0, 100.0)):
        t = np.array([at, at + 1e-6])
        phase = np.diff(sweep._phase(t)[0])[0] / 1e-6
        assert phase / (2.0 * np.pi) == pytest.approx(frequency, rel=1e-4)


def test_motion_of_a_sweep_follows_from_its_acceleration():
    sweep = SineSweep(5.0, 40.0, 3.0, 1.0)
    t = np.linspace(0.0, 1.5, 1501)
    motion = acceleration_motion(sweep, t)
    for at in (0.3, 0.9, 1.4):
        exact = quad(lambda x: sweep.derivative(np.array([x]), 0)[0], 0.0, at, limit=500, points=[1.0])[0]
        assert motion.velocity[round(at * 1000)] == pytest.approx(exact, abs=1e-7)
    prescribed = displacement_motion(sweep, t)
    fine = np.gradient(prescribed.displacement, t[1])
    np.testing.assert_allclose(fine[2:-2], prescribed.velocity[2:-2], atol=0.02 * np.abs(fine).max())


def test_shocks_change_velocity_by_their_area(measured):
    t = np.linspace(0.0, 0.05, 501)
    half = acceleration_motion(HalfSine(1000.0, 0.011, 0.01), t)
    measured("half-sine: change of velocity", half.velocity[-1], 2000.0 * 0.011 / np.pi, rel=1e-12)
    exact = 2000.0 * 0.011 / np.pi * (0.05 - 0.01 - 0.0055)
    measured("half-sine: displacement", half.displacement[-1], exact, rel=1e-12)
    block = acceleration_motion(Table(*trapezoid(1000.0, 0.002, 0.005, 0.004, 0.01)), t)
    measured("trapezoid: change of velocity", block.velocity[-1], 1000.0 * (0.005 + 0.003), rel=1e-12)
    assert HalfSine(2.0, 0.01).values(np.array([0.005, 0.02])).tolist() == [2.0, 0.0]
