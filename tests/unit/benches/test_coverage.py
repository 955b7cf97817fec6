"""The independent march of the coverage benchmark on closed forms, and one random model from deck to row."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as sla
from benchmarks.coverage import __main__ as command
from benchmarks.coverage.march import Modes, coefficients, march
from benchmarks.coverage.models import write_case
from benchmarks.coverage.prepare import prepared
from benchmarks.coverage.table import lines, summary

pytestmark = pytest.mark.once

NONE = np.zeros((0, 1))


def modes(M, K, G, gap0, k, *, c=0.0, velocity=None, displacement=None, load=None, T=None, T_sig=None, mu=None):
    """Modes of small matrices; one signal, the number 1."""
    omega2, Phi = sla.eigh(K, M)
    n, m = omega2.size, len(G)
    rigid = omega2 < 1e-9 * omega2.max(initial=1e-300)
    start = [np.zeros(n) if x is None else Phi.T @ M @ x for x in (displacement, velocity)]
    rubs = np.zeros(0, dtype=np.int64) if T is None else np.arange(m, dtype=np.int64)
    return Modes(
        omega=np.sqrt(np.where(rigid, 0.0, omega2)),
        c=np.full(n, c),
        load=np.zeros((n, 1)) if load is None else (Phi.T @ load)[:, None],
        normal=np.atleast_2d(G) @ Phi,
        normal_sig=np.zeros((m, 1)),
        gap0=np.atleast_1d(gap0).astype(float),
        stiffness=np.full(m, k),
        tangent=np.zeros((0, n)) if T is None else T @ Phi,
        tangent_sig=np.zeros((0, 1)) if T is None else T_sig,
        rubs=rubs,
        side=np.zeros(m, dtype=np.int64),
        mu=np.zeros((0, 3)) if mu is None else np.array([mu]),
        start=np.array(start),
    )


def run(of, end, parts, longest):
    h = 2.0 * np.pi / of.contact_omega / parts
    return march(of, np.ones((1, 101)), end / 99.0, end, h, longest)


def impulse(course):
    half = 0.5 * np.diff(course.time)
    return (np.concatenate([[0.0], half]) + np.concatenate([half, [0.0]])) @ course.force


def touches(course):
    """Start and end of every touch of the first channel: chords of the gap between the instants on both sides."""
    t, g, on = course.time, course.gap[:, 0], course.force[:, 0] > 0.0
    at = np.flatnonzero(on[1:] != on[:-1])
    cross = t[at] + (t[at + 1] - t[at]) * g[at] / (g[at] - g[at + 1])
    return cross if not on[0] else np.concatenate([[0.0], cross])


@pytest.mark.parametrize(("omega", "c"), [(300.0, 2.0), (300.0, 600.0), (300.0, 5000.0), (0.0, 0.0), (1e-3, 0.0)])
def test_a_step_of_a_mode_is_that_of_its_matrix_exponential(omega, c):
    """Oscillating, critical, creeping, rigid, slow: to the cancellation of 1e-16 over (omega h)^2, or round-off."""
    h = 1e-3
    A = np.zeros((4, 4))
    A[0, 1] = A[1, 2] = A[2, 3] = 1.0
    A[1, 0], A[1, 1] = -(omega**2), -c
    E = sla.expm(h * A)
    x0 = np.array([0.3, -2.0, 5.0, (7.0 - 5.0) / h])
    a = coefficients(np.array([omega]), np.array([c]), h)[:, 0]
    own = [a[0] * 0.3 - a[1] * 2.0 + a[4] * 5.0 + a[5] * 7.0, a[2] * 0.3 - a[3] * 2.0 + a[6] * 5.0 + a[7] * 7.0]
    np.testing.assert_allclose(own, (E @ x0)[:2], rtol=1e-6)


def test_mass_on_a_spring_stop():
    """Contact .0312600153 s, impulse 198.01980; steps of 1 / 200 of the period: (2 pi / 200)^2 / 12 = 8e-5."""
    of = modes(np.eye(1) * 100.0, np.eye(1) * 1e4, [[-1.0]], 0.0, 1e6, velocity=np.ones(1))
    course = run(of, 0.05, 200.0, 1e-3)
    start, stop = touches(course)[:2]
    assert stop - start == pytest.approx(0.0312600153, rel=1e-4)
    assert impulse(course)[0] == pytest.approx(198.01980, rel=1e-4)


def test_a_ball_keeps_its_energy():
    """Ten bounces under its weight: each leaves as fast as it came, but for (omega h)^2 / 8 = 1.2e-4 of a step in which it
    closes, ten times at the most."""
    of = modes(np.eye(1), np.zeros((1, 1)), [[1.0]], 0.01, 1e6, load=np.array([-9.81]))
    course = run(of, 0.9, 200.0, 1e-3)
    starts = touches(course)[::2]
    assert len(starts) == 10
    fall = 2.0 * np.sqrt(2.0 * 0.01 / 9.81)
    assert starts[0] == pytest.approx(0.5 * fall, rel=1e-3)
    contact = np.pi / 1e3 + 2.0 * 9.81 / 1e6 / np.sqrt(2.0 * 9.81 * 0.01)
    np.testing.assert_allclose(np.diff(starts), fall + contact, rtol=1e-3)


def test_bar_on_a_rigid_wall():
    """E = 900, rho = A = 1, L = 10, speed 10: contact 2 L / c = 2 / 3 s, impulse 200; ends smeared over 2 of 100 elements."""
    n, dx = 101, 0.1
    ends = np.eye(n) * np.where(np.isin(np.arange(n), [0, n - 1]), 0.5, 1.0)
    beside = np.eye(n, k=1) + np.eye(n, k=-1)
    K, M = 900.0 / dx * (2.0 * ends - beside), dx / 6.0 * (4.0 * ends + beside)
    of = modes(M, K, [np.eye(n)[0]], 1.0, 900.0 / dx, velocity=np.full(n, -10.0))
    course = run(of, 1.0, 40.0, 1e-3)
    at = touches(course)
    assert at[0] == pytest.approx(0.1, abs=1e-6)
    assert at[-1] - at[0] == pytest.approx(2.0 / 3.0, rel=0.02)
    assert impulse(course)[0] == pytest.approx(200.0, rel=0.01)


def test_belt_and_block():
    """m = 1, k = 1e4, N = 10, mu .5 / .3, belt .01 m/s: a slip takes .04068888 s and .80688788 mm, a cycle 1 / 12.3932817 s.

    Friction brings to rest at the end of a step: errors of a step of some 1e-4 s over .04 s.
    """
    k, normal, stop = 1e4, 10.0, 1e6
    T = np.array([[1.0, 0.0], [0.0, 0.0]])
    of = modes(
        np.eye(2),
        np.diag([k, 1.0]),
        [[0.0, 1.0]],
        0.0,
        stop,
        displacement=np.array([0.0, -normal / (stop + 1.0)]),
        velocity=np.array([0.01, 0.0]),
        load=np.array([0.0, -normal]),
        T=T,
        T_sig=np.array([[-0.01], [0.0]]),
        mu=(0.5, 0.3, 0.0),
    )
    cycles, first = 4, 0.05
    rest = 1.0 / 12.3932817 - 0.04068888
    course = run(of, first + cycles / 12.3932817 - 0.5 * rest, 200.0, 1e-3)
    assert course.slip_time == pytest.approx(cycles * 0.04068888, rel=5e-3)
    assert course.friction_work == pytest.approx(cycles * 0.3 * normal * 0.80688788e-3, rel=5e-3)


def test_two_masses_from_slip_to_stick():
    """They meet at one speed v0 / (mu N (1 / m1 + 1 / m2)) s later; friction takes half of v0^2 over 1 / m1 + 1 / m2."""
    one, other, normal, stop, mu, v0 = 0.5, 2.0, 10.0, 1e6, 0.2, 0.3
    T = np.array([[1.0, -1.0, 0.0], [0.0, 0.0, 0.0]])
    of = modes(
        np.diag([one, other, one]),
        np.diag([0.0, 0.0, 1.0]),
        [[0.0, 0.0, 1.0]],
        0.0,
        stop,
        displacement=np.array([0.0, 0.0, -normal / (stop + 1.0)]),
        velocity=np.array([v0, 0.0, 0.0]),
        load=np.array([0.0, 0.0, -normal]),
        T=T,
        T_sig=np.zeros((2, 1)),
        mu=(mu, mu, 0.0),
    )
    until = v0 / (mu * normal * (1.0 / one + 1.0 / other))
    course = run(of, 2.0 * until, 200.0, 1e-3)
    assert course.slip_time == pytest.approx(until, rel=2e-3)
    assert course.friction_work == pytest.approx(0.5 * v0**2 / (1.0 / one + 1.0 / other), rel=2e-3)


def test_a_model_is_that_of_its_seed(tmp_path):
    """The same twice, nothing numerical said."""
    texts = []
    for folder in ("a", "b"):
        case = write_case(3, tmp_path / folder)
        texts.append(case.study.read_text("utf-8") + (case.folder / "deck.inp").read_text("utf-8"))
    assert texts[0] == texts[1]
    for word in ("step", "integrator", "accuracy", "precheck", "reference", "verification"):
        assert f"[{word}" not in texts[0]
        assert f"\n{word} =" not in texts[0]


@pytest.mark.slow
def test_one_model_from_deck_to_row(tmp_path, monkeypatch, capsys):
    """A second call runs nothing again; what is told follows from the row."""
    out = ["coverage", "--n", "1", "--first", str(SEED), "--out", str(tmp_path)]
    monkeypatch.setattr("sys.argv", out)
    command.main()
    text = capsys.readouterr().out
    assert "1 models, 0 failed" in text
    rows = command.known(tmp_path / "random.jsonl")
    monkeypatch.setattr(command, "row", None)
    command.main()
    assert capsys.readouterr().out.splitlines() == text.splitlines()[1:]
    r = rows[SEED]
    assert r["own"]["settled"]
    assert r["own"]["events"] == r["reduced"]["matched"] + r["reduced"]["missed"] > 0
    told = summary([r])
    assert "\n".join(lines(told)) in text
    assert told["verdicts"] == {r["verdict"]: 1.0}


SEED = 9


def test_the_march_is_that_of_the_unreduced_run(tmp_path):
    """Twice the step, the same blows: the total impulse within 5e-3, as the benchmark asks of itself."""
    _, setup, full = prepared(SEED, tmp_path)
    v = setup.study.config.verification
    fine, coarse = (full.events(full.run(parts), v.merge, v.f_max) for parts in (60.0, 30.0))
    assert len(fine) == len(coarse) > 0
    assert sum(e.impulse for e in coarse) == pytest.approx(sum(e.impulse for e in fine), rel=5e-3)
