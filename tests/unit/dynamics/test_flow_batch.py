"""Many runs of one model side by side: each is the run by itself, to the last digit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.dynamics.chunks import march_chunks
from creak.dynamics.flow.batch import Variant, march_many
from creak.dynamics.flow.march import SAMPLES, FlowRun
from creak.dynamics.flow.resolution import Resolution
from creak.dynamics.history import Diverged
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.reduction.diagonal import diagonalise
from helpers_core import chain, channels, system_of

N, STEPS = 10, 8
KEPT = ("time", "gap", "force", "output_index", "displacement")


def row_of_masses(alpha=20.0):
    M, K = chain(N, 0.01, 2e4)
    return diagonalise(system_of(M, K, alpha=alpha))


def pushed(size, frequency=90.0):
    """A force on the middle mass."""
    time = 1e-3 / SAMPLES * np.arange(SAMPLES * STEPS + 1)
    push = size * np.sin(2.0 * np.pi * frequency * time)
    return Loads(time, np.zeros((3, time.size, 0)), push[:, None], (np.array([N // 2]),))


def run_of(system, gaps, loads, longest=0.16):
    return FlowRun(system, gaps, loads, OutputRequest(np.arange(2), every=STEPS), Resolution(0.5, longest, 0.04))


@pytest.fixture(scope="module")
def base():
    G = np.zeros((2, N))
    G[0, 3], G[1, 7] = 1.0, -1.0
    return run_of(row_of_masses(), channels(G, [2e-4, 3e-4], 4e4), pushed(30.0))


def variants(base):
    """Other gaps, loads, stiffness (other steps in contact) and damping."""
    gaps = base.gaps
    return [
        Variant(0, gaps, base.loads),
        Variant(1, replace(gaps, gap0=np.array([4e-4, 1e-4])), base.loads),
        Variant(2, replace(gaps, gap0=np.array([1.0, 2e-4])), pushed(45.0)),
        Variant(3, replace(gaps, stiffness=np.full(2, 4e8)), base.loads),
        Variant(4, gaps, base.loads, row_of_masses(alpha=60.0)),
    ]


@pytest.mark.parametrize("threads", [1, 3])
def test_each_is_the_run_by_itself(base, threads):
    found = dict(march_many(base, variants(base), lambda _, history: history, threads))
    assert sorted(found) == [0, 1, 2, 3, 4]
    for variant in variants(base):
        alone = march_chunks(run_of(variant.system or base.system, variant.gaps, variant.loads), None)
        assert (np.diff((alone.force > 0.0).astype(int), axis=0) > 0).any()
        for key in KEPT:
            np.testing.assert_array_equal(getattr(found[variant.number], key), getattr(alone, key), err_msg=key)


def test_a_run_that_ends_early_costs_no_other(base):
    lost = Variant(1, base.gaps, pushed(1e308))  # a mass that it moves overflows
    found = dict(march_many(base, [variants(base)[0], lost], lambda _, history: history, 2))
    assert isinstance(found[1], Diverged)
    assert "shorten the step" not in str(found[1]), "nobody set one"
    assert found[0].force.any()


def test_a_preload_presses_at_rest_beside_stops_that_are_hit():
    """Ten masses over ten stops: one presses from the start, two are hit, seven are out of reach."""
    stiffness = np.where(np.arange(N) == 0, 1e4, 2e6)
    near, preload = np.isin(np.arange(N), (4, 5)), np.where(np.arange(N) == 0, 5.0, 0.0)
    gap0 = np.where(preload > 0.0, -preload / stiffness, np.where(near, 2e-4, 4e-3))
    gaps = replace(channels(np.eye(N), gap0, stiffness), preload=preload)
    history = march_chunks(run_of(row_of_masses(), gaps, pushed(-40.0, 160.0), 0.25), None)
    assert history.force[0].sum() == pytest.approx(5.0)
    assert (history.force[:, near] > 0.0).any(axis=0).all()
    assert not history.force[:, gap0 == 4e-3].any()
