"""What a run will take, told before it."""

from __future__ import annotations

import io
import time
from dataclasses import replace

import numpy as np
import pytest

from creak.cli.console import Terminal
from creak.cli.output import ProgressBars
from creak.dynamics.flow.march import simulate_flow
from creak.dynamics.flow.resolution import SETTLED
from creak.dynamics.loads import Loads
from creak.progress import Sentence
from creak.reduction.diagonal import diagonalise
from creak.studies.run.foretold import REPEATS, TOLD, closed_in, run_s, words
from helpers_core import channels, system_of


def test_share_of_time_and_channels_that_are_closed():
    gap = np.array([[1.0, 1.0], [-1.0, 1.0], [0.0, -2.0], [3.0, 3.0]])
    np.testing.assert_allclose(closed_in(gap), [0.5, 1.5])
    np.testing.assert_allclose(closed_in(gap[:1]), [0.0, 0.0])


def test_steps_near_contact_are_what_costs():
    """Twice the time closed costs twice as much, and a free run next to nothing."""
    n = 40
    system = diagonalise(system_of(np.eye(n), np.diag(np.linspace(1e3, 1e6, n)), velocity=np.zeros(n)))
    gaps = channels(np.eye(1, n), 1e-3, 1e9)
    time_axis = np.linspace(0.0, 0.3, 301)
    loads = Loads(time_axis, np.zeros((3, 301, 0)), np.zeros((301, 1)), (np.array([0]),))
    always, half, never = (run_s(system, gaps, loads, SETTLED, np.array([share, 1.0])) for share in (1.0, 0.5, 0.0))
    assert never < 0.01 * always
    assert 0.2 < half / always < 1.2  # each step is timed, on a machine that does other things too
    pressed = replace(gaps, gap0=np.array([-1e-6]), preload=np.array([1e3]))
    simulate_flow(system, pressed, loads, observed=np.zeros(0, dtype=np.int64))  # compiled
    started = time.perf_counter()
    simulate_flow(system, pressed, loads, observed=np.zeros(0, dtype=np.int64))
    assert time.perf_counter() - started < 10.0 * always


@pytest.mark.parametrize("repeated", [True, False])
def test_short_runs_are_not_told(repeated):
    whole = REPEATS if repeated else 1.0
    assert words(0.9 * TOLD / whole, repeated, np.zeros(2)) == ""
    said = words(10.0 * TOLD / whole, repeated, np.array([0.01, 1.0]))
    assert "10 min" in said
    assert ("--quick" in said) == repeated
    assert "tied" not in said
    assert "in some 80 % of the time" in words(10.0 * TOLD / whole, repeated, np.array([0.8, 5.0]))


def test_a_sentence_is_told_at_once_and_is_no_phase():
    out = io.StringIO()
    bars = ProgressBars(Terminal(file=out))
    bars(Sentence("the run will take about 4 min"), 1, 1)
    assert out.getvalue() == "the run will take about 4 min\n"
    quiet = io.StringIO()
    ProgressBars(Terminal(file=quiet), quiet=True)(Sentence("nobody asked"), 1, 1)
    assert quiet.getvalue() == ""
