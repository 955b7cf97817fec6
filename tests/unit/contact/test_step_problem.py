"""Contact steps that can be solved by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.optimize import brentq

from creak.contact.gap_operator import GapOperator
from creak.contact.laws.parameters import Curves, Friction
from creak.contact.step_problem import contact_energy, spring_energy
from creak.errors import InputError, NumericalError
from helpers_step_problem import StepProblem, check, problem, solve, springs

HARD = np.inf


def pressed_block(mu=0.5, *, slide, load=100.0, kinetic=None, decay=0.0, stuck=True, step=1e-3) -> StepProblem:
    """A hard contact with uncoupled compliances 1e-6 (normal) and 2e-6 (tangents): p = load."""
    laws = springs([HARD], friction=[(0, mu, mu if kinetic is None else kinetic, decay)])
    return problem(np.diag([1e-6, 2e-6, 2e-6]), [-1e-6 * load], laws, slip_free=slide, stuck=[stuck], step=step)


def test_one_spring_by_hand():
    """g = g_free + A p, p = -k g: p = -g_free k / (1 + k A)."""
    force, _ = solve(problem([[2e-6]], [-1e-3], springs([1e6])))
    assert force[0] == pytest.approx(1e-3 * 1e6 / 3.0, rel=1e-14)


def test_fast_closing_holds_the_gap_at_zero():
    """With a damper that could press harder than needed, the channel stops the gap exactly at zero."""
    q = problem([[1e-6]], [-1e-4], springs([1.0], damping=1e4), rate_free=[-1.0], rate_gain=2e3)
    force, _ = solve(q)
    assert q.motion(force)[0][0] == pytest.approx(0.0, abs=1e-18)
    assert force[0] <= -1e4 * (-1.0 - 2e3 * -1e-4)


def test_opening_damper_never_pulls():
    """Below zero gap but opening fast: -k g - c g' < 0, so no force."""
    q = problem([[1e-6]], [-1e-4], springs([1e4], damping=1e2), rate_free=[5.0], rate_gain=2e3)
    assert solve(q)[0][0] == 0.0


def test_hard_contact_stops_at_zero_gap_whatever_its_damper():
    q = problem([[2e-6]], [-1e-3], springs([HARD], damping=1e3), rate_free=[7.0])
    force, _ = solve(q)
    assert force[0] == pytest.approx(500.0, rel=1e-15)


def test_table_by_hand():
    """f = 1e5 y up to 1 mm, then 1e6: gap_free = -2 mm, A = 1e-6: 2e-3 = y + 1e-6 f -> y = 1e-3 + 0.9e-3 / 2."""
    laws = springs([0.0], curves=[[[0.0, 0.0], [1e-3, 100.0], [2e-3, 1100.0]]], curve=[0])
    q = problem([[1e-6]], [-2e-3], laws)
    force, _ = solve(q)
    assert force[0] == pytest.approx(550.0, rel=1e-13)
    assert contact_energy(laws, q.motion(force)[0]) == pytest.approx(0.05 + 0.45e-3 * 325.0, rel=1e-12)


def test_redundant_hard_channels_share_the_force():
    """Three times the same row: only the sum is determined, and the solution of least norm shares it evenly."""
    q = problem(np.full((3, 3), 1e-6), [-1e-3] * 3, springs([HARD] * 3))
    force, _ = solve(q)
    assert force.sum() == pytest.approx(1000.0, rel=1e-12)
    assert force == pytest.approx(np.full(3, 1000.0 / 3.0), rel=1e-4)


def test_of_parallel_hard_channels_the_nearer_one_presses():
    q = problem(np.full((2, 2), 1e-6), [-1e-3, -2e-3], springs([HARD] * 2))
    assert solve(q)[0] == pytest.approx([0.0, 2000.0], abs=1e-9)


def test_hard_channels_that_shut_each_other_in_are_an_error():
    """Opposite channels, both penetrated: opening one closes the other."""
    q = problem([[1e-6, -1e-6], [-1e-6, 1e-6]], [-1e-3, -1e-3], springs([HARD] * 2))
    with pytest.raises(NumericalError, match="no solution"):
        solve(q)


@pytest.mark.parametrize("rub", [False, True])
def test_hard_contact_with_what_cannot_move_is_an_error(rub):
    laws = springs([HARD], friction=[(0, 0.3, 0.3, 0.0)] if rub else [])
    with pytest.raises(NumericalError, match="no solution"):
        solve(problem(np.diag([0.0, 1e-6, 1e-6][: 3 if rub else 1]), [-1e-3], laws))


def test_a_channel_closed_by_another_is_found():
    """Upper and lower stop of one node: the stiff push of one closes the other, open at first."""
    q = problem([[1e-6, -1e-6], [-1e-6, 1e-6]], [-1e-3, 4e-4], springs([1e6, 1e6]))
    force, _ = solve(q)
    check(q, force, np.zeros(0, dtype=bool))
    # Relative motion x = 1e-6 (p1 - p2), p1 = 1e6 (1e-3 - x), p2 = 1e6 (x - 4e-4): x = 1.4e-3 / 3.
    assert force == pytest.approx([1e6 * (1e-3 - 1.4e-3 / 3), 1e6 * (1.4e-3 / 3 - 4e-4)], rel=1e-12)


def test_watched_channels_never_press_and_open_ones_forget():
    q = problem(np.eye(2), [-1.0, 1.0], springs([0.0, 1.0]))
    assert not solve(q, guess=np.array([3.0, 4.0]))[0].any()
    rubbing = pressed_block(slide=[0.0, 0.0], load=-1.0, stuck=False)
    force, stuck = solve(rubbing, guess=np.ones(3))
    assert not force.any()
    assert stuck.all()


def test_block_sticks_below_the_limit():
    """Stopping the sliding needs |d| / A_t = 40 < mu p = 50."""
    force, stuck = solve(pressed_block(slide=[48e-6, 64e-6]))
    assert force == pytest.approx([100.0, -24.0, -32.0], rel=1e-12)
    assert stuck.all()


def test_block_slides_above_the_limit():
    """Needed 80 > 50: friction 50 against the sliding, which is shortened to (80 - 50) A_t."""
    q = pressed_block(slide=[96e-6, 128e-6])
    force, stuck = solve(q)
    assert force == pytest.approx([100.0, -30.0, -40.0], rel=1e-12)
    assert q.motion(force)[2][0] == pytest.approx([36e-6, 48e-6], rel=1e-11)
    assert not stuck.any()


def test_slip_gain_scales_the_sliding_by_forces():
    q = replace(pressed_block(slide=[96e-6, 128e-6]), slip_gain=2.0)
    force, stuck = solve(q)
    assert force == pytest.approx([100.0, -24.0, -32.0], rel=1e-12)
    assert stuck.all()


def test_released_channel_slides_with_kinetic_friction():
    """Static 0.5, kinetic 0.3, needed force 40: held if it was stuck, sliding against 30 if it was not."""
    slide = [48e-6, 64e-6]
    held, stuck = solve(pressed_block(0.5, kinetic=0.3, slide=slide))
    assert np.hypot(*held[1:]) == pytest.approx(40.0, rel=1e-12)
    assert stuck.all()
    moving, stuck = solve(pressed_block(0.5, kinetic=0.3, slide=slide, stuck=False))
    assert np.hypot(*moving[1:]) == pytest.approx(30.0, rel=1e-12)
    assert not stuck.any()
    torn, stuck = solve(pressed_block(0.5, kinetic=0.3, slide=[2e-6 * 51.0, 0.0]))
    assert torn[1] == pytest.approx(-30.0, rel=1e-12)
    assert not stuck.any()
    caught, stuck = solve(pressed_block(0.5, kinetic=0.3, slide=[2e-6 * 29.0, 0.0], stuck=False))
    assert caught[1] == pytest.approx(-29.0, rel=1e-12)
    assert stuck.all()


def test_coefficient_belongs_to_the_speed_of_the_same_step():
    """Stribeck: d = d_free - A_t mu(d / step) p, solved as one equation."""
    q = pressed_block(0.5, kinetic=0.2, decay=0.05, slide=[3e-4, 0.0], step=1e-3)
    force, stuck = solve(q)

    def mu(d: float) -> float:
        return 0.2 + 0.3 * np.exp(-d / 1e-3 / 0.05)

    d = brentq(lambda d: d - 3e-4 + 2e-6 * 100.0 * mu(d), 0.0, 3e-4, xtol=1e-20, rtol=1e-15)
    assert force[1] == pytest.approx(-100.0 * mu(d), rel=1e-11)
    assert not stuck.any()


def test_friction_opposes_the_sliding_also_with_different_compliances():
    """Compliances 1e-6 and 5e-6 along the tangents and coupled to the normal: the direction is not that of slip_free."""
    A = np.array([[2e-6, 3e-7, -4e-7], [3e-7, 1e-6, 2e-7], [-4e-7, 2e-7, 5e-6]])
    laws = springs([1e6], friction=[(0, 0.4, 0.4, 0.0)])
    q = problem(A, [-1e-3], laws, slip_free=[3e-4, 9e-4])
    force, stuck = solve(q)
    assert not stuck.any()
    d = q.motion(force)[2][0]
    assert force[1:] == pytest.approx(-0.4 * force[0] * d / np.hypot(*d), rel=1e-11)
    assert abs(d[0] / d[1] - 3e-4 / 9e-4) > 0.05, "this problem would not notice a wrong direction"


def test_channels_without_tangents_have_no_friction_force():
    """Connectors have zero tangents."""
    laws = springs([1e6], friction=[(0, 0.4, 0.4, 0.0)])
    force, stuck = solve(problem(np.diag([1e-6, 0.0, 0.0]), [-1e-3], laws))
    assert force == pytest.approx([500.0, 0.0, 0.0], rel=1e-13)
    assert stuck.all()


def test_units_of_length_do_not_matter():
    """m -> mm: compliances, gaps and sliding times 1000, stiffness over 1000."""
    laws = springs([1e6, HARD], friction=[(0, 0.4, 0.3, 0.2), (1, 0.6, 0.6, 0.0)])
    B = np.random.default_rng(3).standard_normal((6, 8))
    q = problem(B @ B.T * 1e-6, [-1e-3, -2e-3], laws, slip_free=[1e-3, 2e-3, -1e-4, 0.0])
    mm = replace(
        q,
        A=1e3 * q.A,
        gap_free=1e3 * q.gap_free,
        slip_free=1e3 * q.slip_free,
        laws=laws._replace(stiffness=1e-3 * laws.stiffness, decay=1e3 * laws.decay),
    )
    assert solve(mm)[0] == pytest.approx(solve(q)[0], rel=1e-10)


def operator(**law) -> GapOperator:
    """Two channels without geometry."""
    row = sp.csr_matrix(np.zeros((2, 6)))
    ones = np.ones(2)
    return GapOperator(
        labels=np.arange(6),
        G=row,
        tangents=(row, row),
        gap0=ones,
        stiffness=np.array([1e6, HARD]),
        damping=0.0 * ones,
        step_limited=np.zeros(2, dtype=bool),
        area=ones,
        names=("a", "b"),
        nodes_idx=np.zeros(2, dtype=np.int64),
        group=("g", "g"),
        **law,
    )


def test_laws_of_a_gap_operator():
    curve = np.array([[0.0, 0.0], [1.0, 5.0]])
    friction = Friction(np.array([0.0, 0.5]), np.array([0.0, 0.3]), np.array([0.0, 0.1]))
    curves = Curves(np.array([-1, 1]), np.array([1.0, 4.0]), (2 * curve, curve))
    laws = operator(curves=curves, friction=friction).laws
    assert laws.start.tolist() == [0, 2, 4]
    assert laws.curve.tolist() == [-1, 1]
    assert laws.x[2:].tolist() == [0.0, 1.0]
    assert laws.y[2:].tolist() == [0.0, 5.0]
    assert laws.rubs.tolist() == [1]
    assert [a[0] for a in (laws.mu_static, laws.mu_kinetic, laws.decay)] == [0.5, 0.3, 0.1]
    energies = [spring_energy(laws, 0, -2e-3), spring_energy(laws, 1, -0.5)]
    assert energies == pytest.approx([2.0, 4.0 * 0.5 * 0.5 * 2.5], rel=1e-13)
    assert contact_energy(laws, np.array([-2e-3, -0.5])) == pytest.approx(sum(energies), rel=1e-13)
    plain = operator().laws
    assert plain.rubs.size == plain.x.size == 0
    assert contact_energy(plain, np.array([1.0, -1.0])) == 0.0


@pytest.mark.parametrize(
    "points", [[[0, 0]], [[0, 1], [1, 2]], [[0, 0], [1, 2], [1, 3]], [[0, 0], [1, 2], [2, 1]], [[0, 0], [1, 0]]]
)
def test_curves_that_do_not_rise_are_refused(points):
    with pytest.raises(InputError, match=r"overclosure curve 1: .*expected \[\[0, 0\], .*both rising"):
        Curves(np.array([0, -1]), np.ones(2), (np.array(points, dtype=float),))


def test_kinetic_above_static_is_refused():
    with pytest.raises(InputError, match=r"static = 0.2, kinetic = 0.3, .*kinetic <= static"):
        Friction(np.array([0.0, 0.2]), np.array([0.0, 0.3]), np.zeros(2))


@pytest.mark.parametrize("rub", [False, True])
def test_a_matrix_that_is_not_finite_is_never_solved(rub):
    laws = springs([1e6], friction=[(0, 0.3, 0.3, 0.0)] if rub else [])
    with pytest.raises(NumericalError, match="contact has no solution"):
        solve(
            problem(np.full((3, 3) if rub else (1, 1), np.nan), [-1e-3], laws, slip_free=[1e-3, 0.0] if rub else None)
        )
