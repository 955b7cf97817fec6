"""What a run will take, told before it."""

from __future__ import annotations

import io
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import creak
from creak.cli.console import Terminal
from creak.cli.output import ProgressBars
from creak.contact.laws.parameters import Friction
from creak.dynamics.channels import channel_matrices
from creak.dynamics.flow.march import SAMPLES, form_of
from creak.dynamics.flow.resolution import SETTLED, flow_steps
from creak.dynamics.loads import Loads
from creak.dynamics.record.watch import Watched
from creak.dynamics.state import LinearTerms
from creak.progress import Sentence
from creak.reduction.diagonal import diagonalise
from creak.studies.file.config import VerificationTable
from creak.studies.prepare.elines import NO_ELINES
from creak.studies.prepare.marching import Observed
from creak.studies.run.foretold import REPEATS, TOLD, closed_in, kept_s, run_s, words
from helpers_core import channels, system_of
from helpers_decks import STOP, stop_study, write_study


def test_share_of_time_and_channels_that_are_closed():
    gap = np.array([[1.0, 1.0], [-1.0, 1.0], [0.0, -2.0], [3.0, 3.0]])
    np.testing.assert_allclose(closed_in(gap), [0.5, 1.5])
    np.testing.assert_allclose(closed_in(gap[:1]), [0.0, 0.0])


def test_steps_near_contact_are_what_costs(monkeypatch):
    """Twice the time closed costs four times as much; a free run takes its flights alone, and its step is a timed one.
    Few channels press at once, however many are closed without contact."""
    n = 40
    system = diagonalise(system_of(np.eye(n), np.diag(np.linspace(1e3, 1e6, n)), velocity=np.zeros(n)))
    gaps = channels(np.eye(10, n), 1e-3, 1e9)
    time_axis = np.linspace(0.0, 0.3, 301)
    loads = Loads(time_axis, np.zeros((3, 301, 0)), np.zeros((301, 1)), (np.array([0]),))
    assert run_s(system, gaps, loads, SETTLED, np.array([1.0, 1.0])) > 0.0
    monkeypatch.setattr("creak.studies.run.foretold.step_s", lambda unknowns, rows: 1e-6 * unknowns * rows)
    form = form_of(system, channel_matrices(system, gaps), LinearTerms(system, loads), gaps)
    levels, n_flight = flow_steps(form, gaps.laws, SAMPLES * loads.step, SETTLED).levels, loads.n_step // SAMPLES
    shares = (1.0, 0.5, 0.0)
    always, half, never = (run_s(system, gaps, loads, SETTLED, np.array([share, 1.0])) for share in shares)
    assert levels > 5
    np.testing.assert_allclose([always, half], [1e-6 * n * n_flight * (1 + s * s * 2**levels) for s in shares[:2]])
    assert never == pytest.approx(always / (1 + 2**levels))
    assert run_s(system, gaps, loads, SETTLED, np.array([1.0, 3.0])) == pytest.approx(3.0 * always)
    assert run_s(system, gaps, loads, SETTLED, np.array([1.0, 9.0])) == pytest.approx(4.0 * always)
    along, across = (channels(np.eye(10, n, k), 0.0, 0.0).G for k in (10, 20))
    rubs = replace(gaps, tangents=(along, across), friction=Friction(*(np.full(10, x) for x in (0.3, 0.3, 0.0))))
    assert run_s(system, rubs, loads, SETTLED, np.array([1.0, 1.0])) > 1.01 * always


def test_modes_that_damping_couples_move_in_pairs_with_two_rows_each(monkeypatch):
    """Twice the numbers, and each channel sees displacements and speeds of them by rows of their own."""
    n = 12
    K = np.diag(np.linspace(1e3, 1e6, n))
    dashpot = 0.1 * np.outer(np.ones(n), np.ones(n))
    alone, together = (diagonalise(system_of(np.eye(n), K, extra=C, velocity=np.zeros(n))) for C in (None, dashpot))
    gaps = channels(np.eye(4, n), 1e-3, 1e9)
    loads = Loads(np.linspace(0.0, 0.3, 301), np.zeros((3, 301, 0)), np.zeros((301, 1)), (np.array([0]),))
    monkeypatch.setattr("creak.studies.run.foretold.step_s", lambda unknowns, rows: 1e-6 * unknowns * rows)
    one, pairs = (run_s(system, gaps, loads, SETTLED, np.array([0.0, 3.0])) for system in (alone, together))
    assert pairs == pytest.approx(4.0 * one)


def test_what_a_run_keeps_costs_as_well(monkeypatch):
    """Outputs of 2 nodes at every other of 10 steps, 3 silent gaps, 4 turns and the slip of 5 channels at all of them;
    6 points of lines at 8 steps, and their measures."""
    monkeypatch.setattr("creak.studies.run.foretold.written_s", lambda unknowns, rows: 1e-6 * unknowns * rows)
    monkeypatch.setattr("creak.studies.run.foretold.median_s", lambda work: 1e-3)
    monkeypatch.setattr("creak.studies.run.foretold.output_every", lambda course: 2)
    monkeypatch.setattr("creak.studies.run.foretold.line_steps", lambda marching, n: np.arange(8))
    gaps, none = channels(np.eye(5, 7), 1e-3, 1e9), np.zeros(0, dtype=np.int64)
    marching = SimpleNamespace(course=None, ends=np.arange(10.0))
    lines = replace(NO_ELINES, points=channels(np.eye(6, 7), 1.0, 0.0))
    bare = Observed(VerificationTable(), None, np.array([3, 4]))
    assert kept_s(marching, bare, gaps, 7) == pytest.approx(7e-6 * 10 * 6)
    seen = Watched(channels(np.eye(3, 7), 1.0, 0.0), np.zeros((4, 7)), none, ())
    watched = replace(bare, seen=seen)
    assert kept_s(marching, watched, gaps, 7) == pytest.approx(7e-6 * 10 * (6 + 3 + 4 + 2 * 5))
    told = kept_s(marching, replace(watched, lines=lines), gaps, 7)
    assert told == pytest.approx(7e-6 * (10 * 23 + 8 * 18) + 6e-3)


@pytest.mark.parametrize("repeated", [True, False])
def test_short_runs_are_not_told(repeated):
    whole = REPEATS if repeated else 1.0
    assert words(0.9 * TOLD / whole, repeated, np.zeros(2)) == ""
    said = words(10.0 * TOLD / whole, repeated, np.array([0.01, 1.0]))
    assert "10 min" in said
    assert said.startswith("the reduced run will take about")
    assert ("and more where f_max" in said) == repeated
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


@pytest.mark.parametrize(("upper", "told"), [(1.6, None), (0.4, "in some 37 % of the time")])
def test_a_stop_is_closed_where_the_motion_without_contact_has_it_closed(tmp_path, monkeypatch, upper, told):
    """No pre-check looks at stops. A weight on a spring, pulled far below its resonance, moves as sin(w t): it is beyond
    .4 for the share 1/2 - asin(.4) / pi of the time, .369, and never beyond 1.6."""
    monkeypatch.setattr("creak.studies.run.foretold.TOLD", 0.0)
    text = (
        stop_study(0.1, 40.0, "craig-bampton").replace("step = 0.1\n", "").replace("alpha = 0.0", "")
        + '[excitation.pull]\nnode_set = "TIP"\ndof = "x"\nkind = "force"\n'
        + 'signal = { type = "sine", frequency = 0.05, amplitude = 1e4 }\n'
    )
    deck = STOP.partition("*INITIAL")[0]
    path = write_study(tmp_path, text.replace("upper = 0.0", f"upper = {upper}"), {"strips.inp": deck})
    said: list[str] = []
    creak.run(
        path,
        converge=False,
        progress=lambda stage, done, total: said.append(stage) if isinstance(stage, Sentence) else None,
    )
    assert said[0].startswith("the reduced run will take about")
    assert (told in said[0]) if told else ("of the time" not in said[0])
