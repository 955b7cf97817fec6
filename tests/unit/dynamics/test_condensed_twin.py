"""The condensed step gives the result of plain Newton iterations with refactorisation, to round-off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.assembly.coupling import Driven
from creak.assembly.part import Rayleigh
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.contact.laws.parameters import Curves
from creak.dynamics.history import History
from creak.dynamics.loads import Loads, at_rest
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import HHT, generalised_alpha
from creak.dynamics.simulate import simulate
from creak.reduction.craig_bampton import craig_bampton
from creak.reduction.diagonal import diagonalise
from helpers_core import (
    NO_CHANNELS,
    assembled,
    chain,
    channels,
    forces_on,
    simulate_plain_newton,
    system_of,
    time_axis,
)

RECORDED = {"section": "contact"}

N = 24
SAME = 1e-8
"""Relative; both solve the same equations exactly, round-off is amplified by contact over some hundred steps."""


def two_chains(*, sparse: bool = True, beta: float = 2e-5) -> System:
    """Two grounded chains of masses side by side, tuned apart."""
    M1, K1 = chain(N // 2)
    M2, K2 = chain(N // 2, stiffness=2.3e4)
    M, K = np.zeros((N, N)), np.zeros((N, N))
    M[: N // 2, : N // 2], M[N // 2 :, N // 2 :] = M1, M2
    K[: N // 2, : N // 2], K[N // 2 :, N // 2 :] = K1, K2
    return system_of(M, K, alpha=0.5, beta=beta, sparse=sparse)


def between_the_chains(damping: float = 0.0) -> GapOperator:
    """Six channels between facing masses, of different gap and stiffness, one of them starting closed."""
    G = np.zeros((6, N))
    for j, mass in enumerate((1, 3, 5, 7, 9, 11)):
        G[j, mass], G[j, N // 2 + mass] = 1.0, -1.0
    gap0 = np.array([1e-3, -2e-4, 2e-3, 1e-3, 3e-3, 5e-4])
    return channels(G, gap0, np.array([1e5, 2e5, 5e4, 1e6, 1e5, 3e5]), damping)


def loads(end: float = 1.0) -> Loads:
    time = time_axis(end, 2e-3)
    push = -60.0 * np.sin(2 * np.pi * 3.0 * time) + 25.0 * np.sin(2 * np.pi * 11.3 * time)
    return forces_on(time, [N // 2 - 1], push)


def same(a: History, b: History) -> None:
    assert a.contact_steps > 50
    assert abs(a.contact_steps - b.contact_steps) <= 1  # a gap of exactly zero may count or not
    for name in ("displacement", "force", "gap", "energy"):
        x, y = getattr(a, name), getattr(b, name)
        np.testing.assert_allclose(y, x, rtol=0.0, atol=SAME * np.abs(x).max(), err_msg=name)


@pytest.mark.parametrize("alpha", [0.0, -0.05, 1.0 - np.sqrt(2.0)])
def test_condensed_step_equals_plain_newton_on_the_full_model(alpha, measured):
    arguments = two_chains(), between_the_chains(), loads(), HHT(alpha)
    a, b = (run(*arguments, OutputRequest(np.arange(N))) for run in (simulate, simulate_plain_newton))
    same(a, b)
    measured(
        f"condensed contact, alpha {alpha:.3g}: force, relative difference",
        np.abs(a.force - b.force).max() / a.force.max(),
        at_most=SAME,
        source="plain Newton, whole model",
    )


def with_laws(kind: str) -> GapOperator:
    """The same channels with other laws; some keep their stiffness."""
    gaps = between_the_chains()
    if kind == "preload":
        force = np.array([0.0, 30.0, 0.0, 10.0, 0.0, 0.0])
        return replace(gaps, gap0=np.where(force > 0.0, -force / gaps.stiffness, gaps.gap0), preload=force)
    curve = np.array([[0.0, 0.0], [1e-5, 0.4], [5e-5, 8.0], [2e-4, 30.0]])
    return replace(
        gaps, curves=Curves(np.array([0, -1, 0, 0, -1, 0]), np.array([1.0, 1.0, 2.0, 0.5, 1.0, 1.0]), (curve,))
    )


@pytest.mark.parametrize("scheme", [HHT(), generalised_alpha(0.9), generalised_alpha(0.5)], ids=["hht", "ga.9", "ga.5"])
@pytest.mark.parametrize("kind", ["tabular", "preload"])
def test_condensed_step_equals_plain_newton_for_every_law_and_scheme(kind, scheme):
    # Half as long: every touch amplifies round-off, and preloaded stops touch more often.
    arguments = two_chains(), with_laws(kind), loads(0.5), scheme
    same(
        simulate(*arguments, OutputRequest(np.arange(N))),
        simulate_plain_newton(*arguments, OutputRequest(np.arange(N))),
    )


def test_generalised_alpha_with_its_extremes_is_a_known_rule():
    """rho_inf = 1: alpha_m = alpha_f = 1/2, the midpoint rule, keeps the energy of a linear system; 0 takes the most."""
    kept = []
    for rho in (1.0, 0.9, 0.0):
        system = system_of(np.eye(1), 1e4 * np.eye(1), velocity=np.ones(1))
        run = simulate(
            system, NO_CHANNELS, at_rest(time_axis(1.0, 2e-3)), generalised_alpha(rho), OutputRequest(np.array([0]))
        )
        kept.append(float(run.energy[-1, :2].sum() / run.energy[0, :2].sum()))
    assert kept[0] == pytest.approx(1.0, abs=1e-9)
    assert kept[0] > kept[1] > kept[2]


@pytest.mark.slow
def test_steps_divided_near_contact_give_what_short_steps_give():
    """Free flight in whole steps, contact in tenths: the forces are those of tenths throughout, to the error of the
    whole steps in between, while most of the steps stay whole."""
    system, gaps = two_chains(), between_the_chains()
    gaps = replace(gaps, gap0=np.abs(gaps.gap0) + 2e-3)
    time = time_axis(0.4, 5e-5)
    push = -160.0 * np.sin(2 * np.pi * 3.0 * time) * np.sin(2 * np.pi * 0.5 * time)
    fine = forces_on(time, [N // 2 - 1], push)
    short = simulate(system, gaps, fine, HHT(0.0), OutputRequest(np.arange(N), every=10))
    mixed = simulate(system, gaps, fine, HHT(0.0), OutputRequest(np.arange(N)), substeps=10)
    assert mixed.contact_steps > 0
    assert mixed.time.size < 0.6 * short.time.size
    np.testing.assert_array_equal(mixed.time[mixed.output_index], short.time[short.output_index])
    impulse = [h.weights @ h.force for h in (short, mixed)]
    np.testing.assert_allclose(impulse[1].sum(), impulse[0].sum(), rtol=0.02)


def test_condensed_step_equals_plain_newton_on_the_reduced_model():
    boundary = np.array([1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23])
    reduced = diagonalise(craig_bampton(two_chains(), boundary, count=4))
    arguments = reduced, between_the_chains(), loads(), HHT()
    same(
        simulate(*arguments, OutputRequest(np.arange(N))),
        simulate_plain_newton(*arguments, OutputRequest(np.arange(N))),
    )


def test_condensed_step_equals_plain_newton_on_a_dense_model():
    arguments = two_chains(sparse=False), between_the_chains(), loads(), HHT()
    same(
        simulate(*arguments, OutputRequest(np.arange(N))),
        simulate_plain_newton(*arguments, OutputRequest(np.arange(N))),
    )


def test_all_modes_kept_equals_the_full_model_in_contact():
    """Sparse full, dense Craig-Bampton and diagonal System: three bases, one motion."""
    boundary = np.array([1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23])
    full = two_chains()
    dense = craig_bampton(full, boundary, count=N)
    runs = [
        simulate(s, between_the_chains(), loads(), HHT(), OutputRequest(np.arange(N)))
        for s in (full, dense, diagonalise(dense))
    ]
    same(runs[0], runs[1])
    same(runs[0], runs[2])


def test_channels_that_never_press_change_nothing():
    system, drive = two_chains(), loads()
    silent = simulate(system, between_the_chains().without_force(), drive, HHT(), OutputRequest(np.arange(N)))
    alone = simulate(system, NO_CHANNELS, drive, HHT(), OutputRequest(np.arange(N)))
    np.testing.assert_array_equal(silent.displacement, alone.displacement)
    assert silent.contact_steps == 0
    assert silent.gap.min() < 0.0


def test_two_runs_give_the_same_numbers():
    arguments = two_chains(), between_the_chains(), loads(), HHT()
    a, b = (simulate(*arguments, OutputRequest(np.arange(N))) for _ in range(2))
    np.testing.assert_array_equal(a.displacement, b.displacement)
    np.testing.assert_array_equal(a.force, b.force)


def test_condensed_step_equals_plain_newton_under_prescribed_motion():
    """A channel between two masses and one driven node: the support's own motion enters gap and inertia."""
    from helpers_core import block, model_of, point_mass, spring

    model = model_of(
        np.column_stack([np.arange(4.0), np.zeros(4), np.zeros(4)]),
        [
            block("mass", [[1], [2], [3]], point_mass(0.5)),
            block("spring2", [[0, 1], [1, 2]], spring(4e3, damping=0.4), 0, 10),
            block("spring1", [[3]], spring(9e3), 0, 20),
        ],
    )
    system = assembled(model, Driven({"base": np.array([0])}), Rayleigh(0.3, 1e-5))
    time = time_axis(0.6, 1e-3)
    w = 2 * np.pi * 6.0
    s = np.stack([5e-3 * np.sin(w * time), 5e-3 * w * np.cos(w * time), -5e-3 * w**2 * np.sin(w * time)])
    drive = Loads(time, s[:, :, None], np.zeros((time.size, 0)))
    G = np.zeros((2, 24))
    G[0, 12], G[0, 18] = -1.0, 1.0  # third mass against the fourth
    G[1, 0], G[1, 12] = -1.0, 1.0  # driven node against the third mass
    gaps = channels(G, np.array([2e-3, 4e-3]), 5e4)
    observed = np.array([0, 6, 12, 18])
    a = simulate(system, gaps, drive, HHT(), OutputRequest(observed))
    b = simulate_plain_newton(system, gaps, drive, HHT(), OutputRequest(observed))
    assert (a.force > 0.0).any(axis=0).all()
    same(a, b)
    np.testing.assert_allclose(a.displacement[:, 0], s[0], atol=1e-15)
