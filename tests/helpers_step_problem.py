"""Random problems of one contact step, and the laws checked one by one without the solver's own tools."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from creak.contact.laws.parameters import LawArrays
from creak.contact.step_problem import Unpressed, solve_channels

EXACT = 1e-10
"""What the laws may be missed by, relative to the terms that make them up."""


@dataclass(frozen=True)
class StepProblem:
    A: np.ndarray
    gap_free: np.ndarray
    rate_free: np.ndarray
    rate_gain: float
    slip_free: np.ndarray
    slip_gain: float
    step: float
    laws: LawArrays
    stuck: np.ndarray

    @property
    def m(self) -> int:
        return self.gap_free.size

    def motion(self, force: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Gaps, their rates and the sliding (f, 2)."""
        g = self.gap_free + self.A[: self.m] @ force
        rate = self.rate_free + self.rate_gain * (g - self.gap_free)
        return g, rate, (self.slip_free + self.slip_gain * self.A[self.m :] @ force).reshape(-1, 2)

    def round_off(self, force: np.ndarray) -> np.ndarray:
        """Size of the terms that make up each gap and each sliding / slip_gain."""
        free = np.concatenate([self.gap_free, self.slip_free / self.slip_gain])
        return np.abs(free) + np.abs(self.A) @ np.abs(force)


def springs(stiffness, damping=0.0, friction=(), curves=(), curve=None, scale=None) -> LawArrays:
    """Laws of channels; friction: (channel, static, kinetic, decay) of those that rub."""
    stiffness = np.array(stiffness, dtype=float)
    m = stiffness.size
    table = np.array(friction, dtype=float).reshape(-1, 4)
    points = np.concatenate([np.zeros((0, 2)), *[np.array(c, dtype=float) for c in curves]])
    return LawArrays(
        stiffness,
        np.broadcast_to(np.array(damping, dtype=float), m).copy(),
        np.full(m, -1) if curve is None else np.array(curve, dtype=np.int64),
        np.cumsum([0, *[len(c) for c in curves]]).astype(np.int64),
        points[:, 0].copy(),
        points[:, 1].copy(),
        np.ones(m) if scale is None else np.array(scale, dtype=float),
        table[:, 0].astype(np.int64),
        *(table[:, i].copy() for i in (1, 2, 3)),
    )


def problem(A, gap_free, laws, *, rate_free=None, rate_gain=1e3, slip_free=None, slip_gain=1.0, step=1e-3, stuck=None):
    m, f = len(gap_free), laws.rubs.size
    return StepProblem(
        np.ascontiguousarray(A, dtype=float),
        np.array(gap_free, dtype=float),
        np.zeros(m) if rate_free is None else np.array(rate_free, dtype=float),
        rate_gain,
        np.zeros(2 * f) if slip_free is None else np.array(slip_free, dtype=float),
        slip_gain,
        step,
        laws,
        np.ones(f, dtype=bool) if stuck is None else np.array(stuck),
    )


def solve(q: StepProblem, guess: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Forces and which channels stick at the end."""
    force = np.zeros(q.A.shape[0]) if guess is None else guess.copy()
    stuck = q.stuck.copy()
    free = Unpressed(q.gap_free, q.rate_free, q.slip_free, q.rate_gain, q.slip_gain, q.step)
    solve_channels(q.A, free, q.laws, stuck, force)
    return force, stuck


def wanted_force(q: StepProblem, i: int, g: float, rate: float) -> tuple[float, float]:
    """Least and largest force that the normal law allows at a gap; gap must not be penetrated by hard channels."""
    laws = q.laws
    if g > 0.0:
        return 0.0, 0.0
    spring = -laws.stiffness[i] * g
    if laws.curve[i] >= 0:
        c = laws.curve[i]
        x, y = (a[laws.start[c] : laws.start[c + 1]] for a in (laws.x, laws.y))
        beyond = max(0.0, -g - x[-1]) * (y[-1] - y[-2]) / (x[-1] - x[-2])
        spring = laws.scale[i] * (np.interp(-g, x, y) + beyond)
    return max(0.0, spring - laws.damping[i] * rate), max(0.0, spring - laws.damping[i] * rate)


def check_normal_laws(q: StepProblem, force: np.ndarray) -> None:
    """Every channel on the graph of its law: some gap within round-off of g has the force p."""
    g, rate, _ = q.motion(force)
    size = EXACT * q.round_off(force)[: q.m]
    p = force[: q.m]
    assert (p >= 0.0).all()
    largest = EXACT * np.abs(force).max()
    for i in range(q.m):
        if q.laws.curve[i] < 0 and np.isinf(q.laws.stiffness[i]):
            assert g[i] >= -size[i]
            assert p[i] <= largest or g[i] <= size[i]
            continue
        # The law falls with g; the rate belongs to the gap.
        low = wanted_force(q, i, g[i] + size[i], rate[i] + q.rate_gain * size[i])[0]
        high = wanted_force(q, i, g[i] - size[i], rate[i] - q.rate_gain * size[i])[1]
        assert low - largest <= p[i] <= high + largest, f"channel {i}: {low} <= {p[i]} <= {high}"


def check_friction(q: StepProblem, force: np.ndarray, stuck: np.ndarray) -> None:
    """Cone, sliding against the force at mu(v) (maximum dissipation), sticking without motion."""
    _, _, slide = q.motion(force)
    laws = q.laws
    tau = force[q.m :].reshape(-1, 2)
    size = q.round_off(force)[q.m :].reshape(-1, 2).max(axis=1) * q.slip_gain
    largest = np.abs(force).max()
    for k, i in enumerate(laws.rubs):
        p, d, t = force[i], np.hypot(*slide[k]), np.hypot(*tau[k])
        assert p > 0.0 or t == 0.0
        decays = laws.decay[k] > 0.0
        limit = laws.mu_static[k] if q.stuck[k] or decays else laws.mu_kinetic[k]
        if stuck[k]:
            assert t <= limit * p + EXACT * largest
            assert p == 0.0 or d <= EXACT * size[k], f"channel {i} sticks but moves {d}"
            continue
        speed = d / q.step
        drop = laws.mu_static[k] - laws.mu_kinetic[k]
        mu = laws.mu_kinetic[k] + (drop * np.exp(-speed / laws.decay[k]) if decays else 0.0)
        # Round-off of d moves mu by at most its slope.
        shake = EXACT * size[k] * (drop / (laws.decay[k] * q.step) if decays else 0.0) * p
        assert abs(t - mu * p) <= EXACT * largest + shake
        work = tau[k] @ slide[k] + mu * p * d
        assert work <= EXACT * (largest * d + t * size[k]) + shake * d, "not the largest dissipation"


def check(q: StepProblem, force: np.ndarray, stuck: np.ndarray) -> None:
    check_normal_laws(q, force)
    check_friction(q, force, stuck)


def random_problem(
    rng: np.random.Generator, *, m_most=8, rub=True, hard=True, redundant=True, damped=True
) -> StepProblem:
    """Any mixture of laws; some motion opens the gaps without sliding, so that hard channels have a solution."""
    m = int(rng.integers(1, m_most + 1))
    channels = np.flatnonzero(rng.random(m) < rng.choice([0.0, 0.5, 1.0])) if rub else np.zeros(0, dtype=int)
    f = channels.size
    size = m + 2 * f
    rank = int(rng.integers(1, size + 3)) if redundant else size + int(rng.integers(0, 3))
    G = rng.standard_normal((size, rank)) * 10.0 ** rng.uniform(-1, 1, rank)
    if m > 1 and redundant and rng.random() < 0.4:
        copy, of = rng.choice(m, 2, replace=False)
        G[copy] = G[of]
        where = {int(c): k for k, c in enumerate(channels)}
        if int(copy) in where and int(of) in where:
            a, b = m + 2 * where[int(copy)], m + 2 * where[int(of)]
            G[a : a + 2] = G[b : b + 2]
    A = G @ G.T + rng.choice([0.0, 0.0, 1e-6, 1e-2]) * np.eye(size) * (not redundant or rng.random() < 0.5)
    A *= 10.0 ** rng.integers(-6, 2)
    scale = np.sqrt(np.diag(A)[:m])
    rest = G @ rng.standard_normal(rank) * np.sqrt(np.diag(A).mean() / np.diag(G @ G.T).mean())
    shape = rng.choice(["hard", "soft", "mixed"]) if hard else "soft"
    opening = np.abs(rng.standard_normal(m)) * scale * rng.choice([0.0, 0.3, 1.0], m)
    if rng.random() < 0.3:
        opening[rng.random(m) < 0.5] = 0.0
    is_hard = np.full(m, shape == "hard") | ((shape == "mixed") & (rng.random(m) < 0.5))
    rest *= rng.choice([1e-3, 1.0])
    gap_free = rest[:m] + opening
    soft = 10.0 ** rng.uniform(-2, 5, m) / np.maximum(np.diag(A)[:m], 1e-300)
    damping = np.where(rng.random(m) < rng.choice([0.0, 0.5]), 10.0 ** rng.uniform(-2, 2, m) * soft * 1e-3, 0.0)
    curves = [
        np.array([[0.0, 0.0], [1.0, 0.2], [1.5, 2.0], [3.0, 2.5]]),
        np.array([[0.0, 0.0], [0.5, 3.0], [1.0, 3.1]]),
    ]
    curve = np.where(~is_hard & (rng.random(m) < rng.choice([0.0, 0.4])), rng.integers(0, 2, m), -1)
    curves = [c * [np.median(scale), 1.0] for c in curves]
    friction = []
    for c in channels:
        kinetic = rng.choice([0.0, 0.1, 0.3, 0.6, 1.2])
        static = kinetic * rng.choice([1.0, 1.5]) + rng.choice([0.0, 0.05])
        if static > 0.0:
            friction.append((c, static, kinetic, rng.choice([0.0, 0.0, 10.0 ** rng.uniform(-2, 2)])))
    if len(friction) < f:
        keep = [c for c, *_ in friction]
        rows = [i for k, c in enumerate(channels) for i in (m + 2 * k, m + 2 * k + 1) if c in keep]
        rows = np.array([*range(m), *rows], dtype=int)
        A, rest, f = A[np.ix_(rows, rows)].copy(), rest[rows], len(friction)
    slip_gain = float(rng.choice([1.0, 2.0]))
    more = 0.0 if redundant else np.median(scale) * rng.choice([0.0, 0.1, 1.0, 10.0])
    laws = springs(
        np.where(is_hard, np.inf, soft),
        np.where(damped, damping, 0.0),
        friction,
        curves,
        curve,
        soft * np.median(scale),
    )
    return problem(
        A,
        gap_free,
        laws,
        rate_free=rng.standard_normal(m) * scale * 1e3,
        rate_gain=1e3,
        slip_free=slip_gain * (rest[m:] + more * rng.standard_normal(2 * f)),
        slip_gain=slip_gain,
        step=1e-3,
        stuck=rng.random(f) < 0.5,
    )


def without_friction(q: StepProblem) -> StepProblem:
    none = np.zeros(0)
    laws = q.laws._replace(rubs=np.zeros(0, dtype=np.int64), mu_static=none, mu_kinetic=none, decay=none)
    return replace(q, A=q.A[: q.m, : q.m].copy(), laws=laws, slip_free=none, stuck=np.zeros(0, dtype=bool))
