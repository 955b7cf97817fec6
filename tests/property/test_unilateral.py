"""The contact solve of a step: whatever the gaps, it ends and its result satisfies the law."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from creak.contact.unilateral import solve_channels

SAME = 1e-9


@st.composite
def channel_problems(draw: st.DrawFn) -> tuple[np.ndarray, ...]:
    """SPD compliance of any size and coupling, gaps of both signs and of very different size, some dampers."""
    m = draw(st.integers(1, 14))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    rank = draw(st.integers(1, m + 2))
    B = rng.standard_normal((m, rank))
    A = B @ B.T + draw(st.sampled_from([1e-6, 1e-3, 1.0])) * np.eye(m)
    A *= 10.0 ** draw(st.integers(-6, 2))
    gap = rng.standard_normal(m) * 10.0 ** rng.uniform(-3, 1, m)
    rate = rng.standard_normal(m) * 10.0 ** draw(st.integers(-2, 3))
    stiffness = 10.0 ** rng.uniform(0, 8, m)
    damping = np.where(rng.random(m) < draw(st.sampled_from([0.0, 0.5, 1.0])), 10.0 ** rng.uniform(-2, 4, m), 0.0)
    return A, gap, rate, np.array(10.0 ** draw(st.integers(0, 4))), stiffness, damping


@settings(max_examples=300, deadline=None)
@given(channel_problems())
def test_forces_obey_the_law_of_the_channels(problem):
    """p >= 0; p = max(0, -k g - c g') below zero gap; none above; anything up to the jump at zero gap."""
    A, gap_free, rate_free, gain, k, c = problem
    p = solve_channels(A, gap_free, rate_free, float(gain), k, c)
    assert (p >= 0.0).all()
    g = gap_free + A @ p
    rate = rate_free + gain * (g - gap_free)
    wanted = np.maximum(0.0, -k * g - c * rate)
    # Round-off of the gap: that of the largest term that makes it up, and of a solve with A + 1/k.
    slack = SAME * (np.abs(gap_free).max() + (np.abs(A) @ p).max())
    slack_force = SAME * (p.max() + 1.0) + (k + c * gain) * slack
    jump = np.maximum(0.0, -c * rate)
    pressed = p > 0.0
    assert (pressed | (g >= -slack) | (wanted <= slack_force)).all()
    assert (g[pressed] <= slack).all()
    at_zero = np.abs(g) <= slack
    follows = np.abs(p - wanted) <= slack_force
    held = at_zero & (p <= jump + slack_force)
    assert (~pressed | follows | held).all()


@settings(max_examples=100, deadline=None)
@given(channel_problems())
def test_springs_alone_give_the_minimum_of_a_convex_function(problem):
    """Without dampers p minimises p' A p / 2 + sum p^2 / 2k + p' g_free over p >= 0: the optimality conditions."""
    A, gap_free, rate_free, gain, k, _ = problem
    p = solve_channels(A, gap_free, rate_free, float(gain), k, np.zeros_like(k))
    gradient = A @ p + p / k + gap_free
    scale = SAME * (np.abs(gap_free).max() + (np.abs(A) @ p).max())
    assert (gradient >= -scale).all()
    assert np.abs(gradient[p > 0.0]).max(initial=0.0) <= scale


@settings(max_examples=50, deadline=None)
@given(channel_problems())
def test_numbering_of_the_channels_does_not_matter(problem):
    A, gap_free, rate_free, gain, k, c = problem
    p = solve_channels(A, gap_free, rate_free, float(gain), k, c)
    turn = np.arange(k.size)[::-1]
    q = solve_channels(A[np.ix_(turn, turn)].copy(), gap_free[turn], rate_free[turn], float(gain), k[turn], c[turn])
    # Unique solution; forces are as sharp as the conditioning of A (1e-6) allows.
    np.testing.assert_allclose(A @ q[turn], A @ p, atol=1e-9 * (np.abs(A @ p).max() + np.abs(gap_free).max()))


def test_one_channel_by_hand():
    """g = g_free + A p, p = -k g: p = -g_free k / (1 + k A)."""
    p = solve_channels(np.array([[2e-6]]), np.array([-1e-3]), np.zeros(1), 1e3, np.array([1e6]), np.zeros(1))
    assert p[0] == pytest.approx(1e-3 * 1e6 / 3.0, rel=1e-14)


def test_fast_closing_holds_the_gap_at_zero():
    """With a damper that could press harder than needed, the channel stops the gap exactly at zero."""
    A, gap, rate, gain, c = 1e-6, -1e-4, -1.0, 2e3, 1e4
    p = solve_channels(np.array([[A]]), np.array([gap]), np.array([rate]), gain, np.array([1.0]), np.array([c]))
    assert gap + A * p[0] == pytest.approx(0.0, abs=1e-18)
    assert p[0] <= -c * (rate - gain * gap)


def test_opening_damper_never_pulls():
    """Below zero gap but opening fast: -k g - c g' < 0, so no force."""
    p = solve_channels(np.array([[1e-6]]), np.array([-1e-4]), np.array([5.0]), 2e3, np.array([1e4]), np.array([1e2]))
    assert p[0] == 0.0
