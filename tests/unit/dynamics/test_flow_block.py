"""Contact in blocks: channels that cannot close are left out of its steps, and nothing changes by that."""

from __future__ import annotations

import numpy as np
import pytest

from creak.dynamics.flow import march as flow_march
from creak.dynamics.flow.march import SAMPLES, simulate_flow
from creak.dynamics.history import History
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.reduction.diagonal import diagonalise
from creak.verify.events import find_events
from helpers_core import chain, channels, system_of

N = 24


def rattle() -> tuple[History, object]:
    """A row of masses shaken by its middle: a soft stop holds most of the time, stiff ones are hit now and then."""
    M, K = chain(N, 0.01, 2e4)
    system = diagonalise(system_of(M, K, alpha=20.0))
    time = 1e-3 / SAMPLES * np.arange(SAMPLES * 200 + 1)
    push = 30.0 * np.sin(2.0 * np.pi * 31.0 * time) + 20.0 * np.sin(2.0 * np.pi * 83.0 * time) - 40.0
    loads = Loads(time, np.zeros((3, time.size, 0)), push[:, None], (np.array([N // 2]),))
    gaps = channels(np.eye(N), 2e-3 + 2e-3 * np.arange(N) / N, np.where(np.arange(N) % 3 == 0, 1e5, 1e7))
    return simulate_flow(system, gaps, loads, OutputRequest(np.arange(N))), gaps


@pytest.fixture(scope="module")
def histories():
    """Without long steps of lasting contact, which begin elsewhere where there are no blocks."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(flow_march, "SHORTEST", 99)
        found, gaps = rattle()
        patch.setattr(flow_march, "FEWEST", N + 1)
        return found, rattle()[0], gaps


def test_every_event_is_that_of_a_march_that_looks_at_all_channels(histories):
    blocks, whole, gaps = histories
    found, exact = (find_events(h, gaps, merge=1e-4, f_max=500.0) for h in (blocks, whole))
    assert len(found) == len(exact) > 20
    for a, b in zip(found, exact, strict=True):
        assert a.channel == b.channel
        assert a.t_start == pytest.approx(b.t_start, abs=1e-9)
        assert a.impulse == pytest.approx(b.impulse, rel=1e-3)


def test_gaps_that_were_left_out_are_those_of_the_motion(histories):
    """At the ends of flight steps to round-off; between them cubics."""
    blocks, whole, _ = histories
    exact = np.stack([np.interp(blocks.time, whole.time, g) for g in whole.gap.T], axis=1)
    np.testing.assert_allclose(blocks.gap[blocks.output_index], whole.gap[whole.output_index], atol=1e-9)
    assert np.abs(blocks.gap - exact).max() < 2e-4 * np.abs(exact).max()


def test_channels_are_left_out(monkeypatch):
    """Blocks are begun in such a run, else the tests above say nothing."""
    begun = []
    new = flow_march.new_block
    monkeypatch.setattr(flow_march, "new_block", lambda *a: begun.append(new(*a)) or begun[-1])
    rattle()
    assert begun[0].left[1] > 0.0  # when the last one began
