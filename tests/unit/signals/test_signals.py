"""Excitation signals against closed forms, omega arithmetic on periodic records, spectra."""

from __future__ import annotations

import numpy as np
import pytest

from creak.signals.signal import RAMP
from creak.signals.sources import (
    APART,
    Multisine,
    Record,
    Sine,
    Step,
    Table,
    acceleration_motion,
    displacement_motion,
    integrate_twice,
)
from creak.signals.spectra import low_pass, spectrum

RECORDED = {"section": "signals", "source": "closed form"}

T = np.linspace(0.0, 2.0, 2001)
H = 1e-3
W = 2 * np.pi * 3.0


def derivatives_agree(motion, t: np.ndarray, *, skip: int = 2, tolerance: float = 1e-4) -> None:
    """v = du/dt and a = dv/dt by central differences, away from the ends; O(h^2) of the differences."""
    h = t[1] - t[0]
    inside = slice(skip, -skip)
    for x, dx in ((motion.displacement, motion.velocity), (motion.velocity, motion.acceleration)):
        np.testing.assert_allclose(np.gradient(x, h)[inside], dx[inside], atol=tolerance * np.abs(dx).max())


def test_sine_force_and_motion():
    sine = Sine(3.0, 2.0)
    np.testing.assert_allclose(sine.values(T), 2 * np.sin(W * T))
    motion = displacement_motion(sine, T)
    np.testing.assert_allclose(motion.displacement, 2 * np.sin(W * T))
    np.testing.assert_allclose(motion.velocity, 2 * W * np.cos(W * T))
    np.testing.assert_allclose(motion.acceleration, -2 * W**2 * np.sin(W * T))


def test_sine_acceleration_starts_from_rest():
    """u = A/w (t - sin(wt)/w): the base drifts, as a base with that acceleration from rest does."""
    motion = acceleration_motion(Sine(3.0, 2.0), T)
    np.testing.assert_allclose(motion.acceleration, 2 * np.sin(W * T))
    assert motion.velocity[0] == motion.displacement[0] == 0.0
    np.testing.assert_allclose(motion.velocity, 2 / W * (1 - np.cos(W * T)), atol=1e-14)
    derivatives_agree(motion, T)


def test_step_force_and_base_acceleration():
    np.testing.assert_array_equal(Step(4.0).values(T), 4.0)
    still = displacement_motion(Step(4.0), T)
    np.testing.assert_array_equal(still.displacement, 4.0)
    assert not still.velocity.any()
    assert not still.acceleration.any()
    falling = acceleration_motion(Step(-9.81), T)
    np.testing.assert_allclose(falling.displacement, -0.5 * 9.81 * T**2)
    np.testing.assert_allclose(falling.velocity, -9.81 * T)


def test_table_force_is_linear_between_rows_and_constant_outside():
    table = Table(np.array([0.5, 1.0, 1.5]), np.array([0.0, 2.0, -1.0]))
    t = np.array([0.0, 0.5, 0.75, 1.0, 1.25, 1.5, 9.0])
    np.testing.assert_allclose(table.values(t), [0.0, 0.0, 1.0, 2.0, 0.5, -1.0, -1.0])


def test_table_acceleration_is_integrated_exactly(measured):
    """A ramp of slope 2 from t = .5 to 1.5: v = (t-.5)^2, u = (t-.5)^3 / 3; then constant acceleration 2."""
    table = Table(np.array([0.5, 1.5]), np.array([0.0, 2.0]))
    motion = acceleration_motion(table, T)
    ramp = np.clip(T - 0.5, 0.0, 1.0)
    after = np.maximum(T - 1.5, 0.0)
    np.testing.assert_allclose(motion.velocity, ramp**2 + 2 * after, atol=1e-13)
    error = np.abs(motion.displacement - (ramp**3 / 3 + after + after**2)).max()
    measured("table of accelerations: displacement, error", error, at_most=1e-13, unit="m")


def test_table_displacement_passes_its_rows_and_rests_outside():
    rows = np.array([0.2, 0.5, 0.9, 1.4]), np.array([0.0, 1.0, -0.5, 0.25])
    motion = displacement_motion(Table(*rows), T)
    np.testing.assert_allclose(np.interp(rows[0], T, motion.displacement), rows[1], atol=1e-6)
    outside = (T < 0.2) | (T > 1.4)
    assert not motion.velocity[outside].any()
    assert not motion.acceleration[outside].any()
    flat = displacement_motion(Table(rows[0], np.full(4, 2.0)), T)
    np.testing.assert_allclose(flat.displacement, 2.0)


@pytest.mark.parametrize("count", [12, 20, 200])
def test_a_table_of_a_sine_has_its_acceleration(count, measured):
    """h^2 w^2 / 12 of its amplitude, count points to a period; twice that in the first and last intervals."""
    time = np.arange(10 * count + 1) / (50.0 * count)
    w, t = 2.0 * np.pi * 50.0, np.linspace(0.0, 0.2, 5001)
    motion = displacement_motion(Table(time, np.sin(w * time + 0.4)), t)
    inside = (t > 0.02) & (t < 0.18)
    off = np.abs(motion.acceleration / w**2 + np.sin(w * t + 0.4))[inside].max()
    measured(
        f"acceleration of a sine given by {count} places to a period, share of its amplitude",
        off,
        at_most=1.1 * (2.0 * np.pi / count) ** 2 / 12.0,
    )


@pytest.mark.parametrize(
    "value",
    [
        np.clip(np.linspace(-1.0, 2.0, 61), 0.0, 1.0),
        (np.linspace(-1.0, 2.0, 61) > 0.2) * 1.0,
        np.maximum(np.sin(np.linspace(0.0, 20.0, 201)), 0.0),
    ],
    ids=["ramp", "step", "half sines"],
)
def test_a_table_with_corners_does_not_overshoot(value):
    """Beyond a small part of what it changes by from point to point."""
    time = np.linspace(0.0, 1.0, value.size)
    motion = displacement_motion(Table(time, value), np.linspace(0.0, 1.0, 20001))
    allowed = 1.1 * APART * np.abs(np.diff(value)).max()
    assert motion.displacement.max() <= 1.0 + allowed
    assert motion.displacement.min() >= -allowed


def test_a_displacement_table_of_one_row_is_constant():
    motion = displacement_motion(Table(np.array([0.5]), np.array([2.0])), T)
    np.testing.assert_array_equal(motion.displacement, 2.0)
    assert not motion.velocity.any()
    assert not motion.acceleration.any()


# --- multisine ------------------------------------------------------------------------------------------------


def test_multisine_is_the_same_for_the_same_seed_and_another_for_another():
    a, b, c = (Multisine(1, 100, 1.9, 1.0, seed).values(T) for seed in (1, 1, 2))
    np.testing.assert_array_equal(a, b)
    assert np.abs(a - c).max() > 1.0


def test_multisine_has_a_flat_spectrum_with_uniform_phases(measured):
    m = Multisine(1.0, 100.0, 1.9, 1.0, 7)
    t = np.arange(1000) / 1000.0
    freq, lines = spectrum(m.values(t), 1e-3, 499.0)
    inside = (freq >= 1.0) & (freq <= 100.0)
    # Exact: whole periods.
    measured(
        "multisine: amplitude of a line, worst",
        np.abs(lines[inside]),
        1.9,
        rel=1e-10,
        unit="m",
        source="its definition",
    )
    np.testing.assert_allclose(np.abs(lines[~inside]), 0.0, atol=1e-10)
    np.testing.assert_allclose(np.angle(lines[inside]), np.angle(np.exp(1j * m.lines[1])), atol=1e-9)
    # 100 uniform phases: mean resultant below .3 with 99.99 % (Rayleigh: exp(-100 x .09)).
    measured(
        "multisine: mean resultant of 100 phases",
        abs(np.exp(1j * m.lines[1]).mean()),
        at_most=0.3,
        source="Rayleigh's test",
    )


def test_multisine_repeats_with_its_period():
    m = Multisine(2.0, 30.0, 1.0, 0.5, 3)
    t = np.linspace(0, 0.5, 301)
    np.testing.assert_allclose(m.values(t + 0.5), m.values(t), atol=1e-10)


@pytest.mark.parametrize(
    ("f_min", "f_max", "period", "first", "last"),
    [
        (1, 100, 1.0, 1, 100),
        (0, 10, 1.0, 1, 10),
        (0.3, 1.0, 10.0, 3, 10),
        (1.05, 2.95, 2.0, 3, 5),
    ],
)
def test_multisine_lines_lie_in_the_band(f_min, f_max, period, first, last):
    omega, _ = Multisine(f_min, f_max, 1.0, period).lines
    np.testing.assert_allclose(omega * period / (2 * np.pi), np.arange(first, last + 1))


@pytest.mark.parametrize("t", [0.3 + 1.25e-4 * np.arange(5003), np.sort(np.random.default_rng(1).random(900))])
@pytest.mark.parametrize("order", [-1, 0, 2])
def test_a_multisine_is_its_sum_of_cosines(t, order):
    """At even instants, which are computed together, and at others."""
    m = Multisine(2.0, 200.0, 0.7, 0.5, 5)
    omega, phase = m.lines
    wanted = sum(0.7 * w**order * np.cos(w * t + p + 0.5 * np.pi * order) for w, p in zip(omega, phase, strict=True))
    np.testing.assert_allclose(m.derivative(t, order), wanted, atol=1e-11 * np.abs(wanted).max())


def test_multisine_displacement_fades_in_from_rest(measured):
    m = Multisine(1.0, 40.0, 1.9, 1.0, 1)
    t = np.arange(0.0, 1.0, 1e-4)
    motion = displacement_motion(m, t)
    assert motion.displacement[0] == motion.velocity[0] == motion.acceleration[0] == 0.0
    late = t >= RAMP
    error = np.abs(motion.displacement[late] - m.values(t)[late]).max()
    measured(
        "multisine as base motion: after fading in, error", error, at_most=1e-12, unit="m", source="its definition"
    )
    derivatives_agree(motion, t, tolerance=1e-3)


def test_multisine_acceleration_is_integrated_line_by_line():
    m = Multisine(5.0, 40.0, 1.0, 1.0, 1)
    t = np.arange(0.0, 1.0, 1e-4)
    motion = acceleration_motion(m, t)
    late = t >= RAMP
    np.testing.assert_allclose(motion.acceleration[late], m.values(t)[late], atol=1e-10)
    derivatives_agree(motion, t, tolerance=1e-3)


# --- records and omega arithmetic -------------------------------------------------------------------------------


def test_omega_arithmetic_is_exact_on_periodic_signals(measured):
    """a = sum A_k cos(w_k t + phi): u = -sum A_k / w_k^2 cos(w_k t + phi), to round-off."""
    n, h = 1000, 1e-3
    t = np.arange(n) * h
    lines = [(3, 1.0, 0.4), (17, 2.0, 2.0), (120, 0.5, 5.0)]
    a = sum(A * np.cos(2 * np.pi * k * t + p) for k, A, p in lines)
    u, v, same = integrate_twice(a, h, 1.0)
    w = [2 * np.pi * k for k, _, _ in lines]
    exact_u = sum(-A / w**2 * np.cos(w * t + p) for (_, A, p), w in zip(lines, w, strict=True))
    exact_v = sum(A / w * np.sin(w * t + p) for (_, A, p), w in zip(lines, w, strict=True))
    measured("omega arithmetic, three lines: displacement, error", np.abs(u - exact_u).max(), at_most=1e-14, unit="m")
    measured("omega arithmetic, three lines: velocity, error", np.abs(v - exact_v).max(), at_most=1e-13, unit="m/s")
    np.testing.assert_allclose(same, a, atol=1e-12)


@pytest.mark.parametrize("n", [1000, 1001])
def test_omega_arithmetic_drops_the_mean_and_everything_below_the_cut_off(n, measured):
    h = 1.0 / n
    t = np.arange(n) * h
    a = 5.0 + 3.0 * np.cos(2 * np.pi * 4 * t) + np.cos(2 * np.pi * 20 * t)
    u, v, kept = integrate_twice(a, h, 7.0)
    measured(
        "omega arithmetic: bins below the cut-off, error",
        np.abs(kept - np.cos(2 * np.pi * 20 * t)).max(),
        at_most=1e-12,
        unit="m/s2",
    )
    np.testing.assert_allclose(u, -np.cos(2 * np.pi * 20 * t) / (2 * np.pi * 20) ** 2, atol=1e-14)
    assert abs(v.mean()) < 1e-14


@pytest.mark.parametrize("begin", [0.0, 1.0])
def test_a_record_shorter_than_the_run_leaves_the_base_at_rest(begin):
    """Velocity is the rate of displacement, and acceleration that of velocity, before it, in it and after it."""
    own = begin + 1e-3 * np.arange(500)
    record = Record(own, np.sin(2.0 * np.pi * 7.3 * own + 0.4), 5.0)
    t = np.linspace(0.0, 3.0, 30_001)
    motion = acceleration_motion(record, t)
    outside = (t < begin) | (t > own[-1])
    assert outside.any()
    for moved in (motion.displacement, motion.velocity, motion.acceleration):
        assert not moved[outside].any()
    for moved, rate in ((motion.displacement, motion.velocity), (motion.velocity, motion.acceleration)):
        np.testing.assert_allclose(np.gradient(moved, t), rate, atol=5e-3 * np.abs(rate).max())
    inside = (t > begin + 0.2) & (t < own[-1] - 0.2)
    whole = acceleration_motion(Record(own - begin, record.value, 5.0), own - begin).acceleration
    np.testing.assert_allclose(motion.acceleration[inside], np.interp(t[inside], own, whole), atol=1e-3)


def test_record_moves_the_base_like_its_acceleration(measured):
    t = np.arange(0.0, 4.0, 1e-3)
    a = 2.0 * np.sin(2 * np.pi * 12.0 * t)
    motion = displacement_motion(Record(t, a, 5.0), t)
    late = (t > 0.5) & (t < 3.5)
    w = 2 * np.pi * 12.0
    np.testing.assert_allclose(motion.acceleration[late], a[late], atol=1e-8)
    error = np.abs(motion.displacement[late] + a[late] / w**2).max()
    measured("record as base motion: displacement, error", error, at_most=1e-10, unit="m")
    assert motion.displacement[0] == motion.velocity[0] == 0.0
    same = acceleration_motion(Record(t, a, 5.0), t)
    np.testing.assert_array_equal(same.displacement, motion.displacement)


# --- spectra ----------------------------------------------------------------------------------------------------


def test_spectrum_of_whole_periods_gives_amplitude_and_phase():
    t = np.arange(500) * 2e-3
    x = np.column_stack([1.5 * np.cos(2 * np.pi * 10 * t + 0.7), 0.2 * np.sin(2 * np.pi * 33 * t)])
    freq, lines = spectrum(x, 2e-3, 50.0)
    np.testing.assert_allclose(freq, np.arange(1, 51))
    assert lines.shape == (50, 2)
    assert lines[9, 0] == pytest.approx(1.5 * np.exp(0.7j))
    assert lines[32, 1] == pytest.approx(-0.2j)
    assert np.abs(np.delete(lines[:, 0], 9)).max() < 1e-12


def test_low_pass_keeps_slow_and_drops_fast_without_delay(measured):
    t = np.arange(4000) * 1e-4
    slow, fast = np.sin(2 * np.pi * 20 * t), np.sin(2 * np.pi * 2000 * t)
    x = low_pass(slow + fast, 1e-4, 200.0)
    inside = slice(500, -500)
    # Butterworth of order 4, twice: (20/200)^16 in the band, (200/2000)^8 above.
    measured(
        "low pass: what it leaves of 2000 Hz and changes at 20 Hz",
        np.abs(x[inside] - slow[inside]).max(),
        at_most=1e-4,
        source="Butterworth",
    )


def test_low_pass_leaves_what_the_sampling_cannot_exceed():
    x = np.random.default_rng(0).standard_normal(100)
    assert low_pass(x, 1e-3, 500.0) is x
    assert low_pass(x[:10], 1e-3, 100.0).size == 10
