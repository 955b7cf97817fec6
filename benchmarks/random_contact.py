"""Energy that contact creates in random Systems, and touches: any law, with and without friction, default settings.

    python -m benchmarks.random_contact [count]

Limit: 1e-3 of what contact took up, for every System. Touches, a channel that presses from its closing to its opening,
are counted with the default steps near contact and with half of them: where a scheme chatters, their number grows.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np

from creak.assembly.damping import Damping
from creak.assembly.system import System, no_supports
from creak.contact.gap_operator import ChannelRows, GapOperator
from creak.contact.laws.parameters import Curves, Friction
from creak.dynamics.flow.march import SAMPLES, simulate_flow
from creak.dynamics.flow.resolution import SETTLED, Resolution
from creak.dynamics.history import History
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.linalg.diagonal import Diagonal
from creak.verify.reliability import created_of_contact

LIMIT = 1e-3
END, STEP = 0.2, 1e-3
"""s of a run and of its flight steps."""
CURVE = np.array([[0.0, 0.0], [2e-4, 0.05], [6e-4, 0.3], [1.5e-3, 2.0]])
"""Foam that stiffens: overclosure in m, share of the stiffness in N/m times 1e-3 m."""


def channels(rng: np.random.Generator, m: int, n: int) -> GapOperator:
    """m channels over n labels, of linear, hard or tabular laws, a third of the Systems with dampers."""
    channel, label = (a.ravel() for a in np.indices((m, n)))
    stiffness, zero = 10 ** rng.uniform(3, 8, m), np.zeros(m * n)
    kind = rng.integers(0, 4)
    if kind == 1:
        stiffness = np.where(rng.random(m) < 0.5, np.inf, stiffness)
    damping = rng.uniform(0.0, 30.0, m) if rng.random() < 1 / 3 else np.zeros(m)
    gaps = GapOperator(
        **ChannelRows(channel, label, rng.standard_normal(m * n), zero, zero).motion(m),
        gap0=10 ** rng.uniform(-4, -2, m),
        stiffness=stiffness,
        damping=np.where(np.isinf(stiffness), 0.0, damping),
        step_limited=np.zeros(m, dtype=np.bool_),
        area=np.zeros(m),
        names=tuple(f"stop:{j}" for j in range(m)),
        nodes_idx=np.arange(m, dtype=np.int64),
        group=("stop",) * m,
    )
    if kind == 2:
        gaps = replace(gaps, curves=Curves(np.zeros(m, dtype=np.int64), 1e-3 * stiffness, (CURVE,)))
    if rng.random() < 0.5:
        first, second = (rng.standard_normal(m * n) for _ in range(2))
        along = ChannelRows(channel, label, zero, first, second).motion(m)["tangents"]
        static = rng.uniform(0.1, 0.8, m)
        friction = Friction(static, static * rng.uniform(0.5, 1.0, m), np.zeros(m))
        gaps = replace(gaps, tangents=along, friction=friction)
    return gaps


def random_run(seed: int, resolution: Resolution = SETTLED) -> History:
    """One System of 2 to 11 modes from 3 to 3000 Hz with 1 to 4 channels, thrown and pushed."""
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(2, 12)), int(rng.integers(1, 5))
    omega = 2 * np.pi * 10 ** rng.uniform(0.5, 3.5, n)
    label = np.arange(n, dtype=np.int64)

    def rows(labels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.eye(n)[labels], np.zeros((labels.size, 0))

    damping = Damping(rng.uniform(0.0, 5.0), 0.0)
    if rng.random() < 0.25:
        shape = rng.standard_normal(n)
        damping = Damping(0.0, 0.0, 3.0 * np.outer(shape, shape))
    v = rng.standard_normal(n)
    unit, stiff = Diagonal(np.ones(n)), Diagonal(omega**2)
    system = System("random", unit, stiff, damping, rows, no_supports(n), label, v, labels=label)
    gaps, f = channels(rng, m, n), rng.uniform(5.0, 100.0)
    time = STEP / SAMPLES * np.arange(SAMPLES * round(END / STEP) + 1)
    push = 50.0 * np.sin(2 * np.pi * f * time)[:, None]
    loads = Loads(time, np.zeros((3, time.size, 0)), push, (np.array([0]),))
    return simulate_flow(system, gaps, loads, OutputRequest(label), resolution=resolution)


def touches(run: History) -> int:
    """How often a channel closes."""
    pressed = run.force > 0.0
    return int(np.count_nonzero(pressed[0]) + np.count_nonzero(pressed[1:] & ~pressed[:-1]))


def main() -> None:
    """Print the distribution of the created share and the worst seeds; exit 1 beyond `LIMIT`."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.random_contact")
    options.add_argument("count", type=int, nargs="?", default=1000)
    count = options.parse_args().count
    halved = replace(SETTLED, contact=0.5 * SETTLED.contact, longest=0.5 * SETTLED.longest)
    rows = []
    for seed in range(count):
        run = random_run(seed)
        rows.append((created_of_contact(run), touches(run), touches(random_run(seed, halved))))
    created, base, finer = np.array(rows).T
    median, ninety, worst = np.quantile(created, [0.5, 0.9, 1.0])
    print(f"{count} systems: median {median:.2e}, 90 % below {ninety:.2e}, worst {worst:.2e}; limit {LIMIT:g}")
    print("worst seeds:", ", ".join(f"{s} ({created[s]:.1e})" for s in np.argsort(created)[::-1][:8]))
    other = base != finer
    print(
        f"touches: {base.sum():.0f}, with half the steps {finer.sum():.0f} ({finer.sum() / base.sum() - 1.0:+.2%}); "
        f"as many in {count - np.count_nonzero(other)} systems, median change of the others "
        f"{np.median(np.abs(finer[other] / base[other] - 1.0)):.1%}"
    )
    if not worst < LIMIT:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
