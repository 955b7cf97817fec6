"""Instants that are left out where contact chatters: impulses stay, memory has an end, and it is told."""

from __future__ import annotations

import numpy as np
import pytest

from creak.dynamics.chunks import march_chunks
from creak.dynamics.flow.march import SAMPLES, FlowRun, simulate_flow
from creak.dynamics.flow.resolution import SETTLED
from creak.dynamics.history import History, Stopped
from creak.dynamics.loads import Loads
from creak.dynamics.record import recorder, thinning
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.record.thinning import LONGEST, spacing_for, spacing_words, thin
from creak.linalg.memory import OutOfMemory
from creak.reduction.diagonal import diagonalise
from creak.verify.events import find_events
from helpers_core import chain, channels, system_of

N, END, KEPT = 12, 0.2, 1_000
GAPS = channels(np.eye(N), np.zeros(N), 1e9)


def drive() -> tuple:
    """A row of masses that lies on a stop under each of them, shaken by 37 and 61 Hz: it leaves them and comes back."""
    M, K = chain(N, 0.01, 1e5)
    time = 1e-3 / SAMPLES * np.arange(round(SAMPLES * END / 1e-3) + 1)
    push = 5.0 * np.sin(2.0 * np.pi * 37.0 * time) + 3.0 * np.sin(2.0 * np.pi * 61.0 * time)
    labels = tuple(np.array([k]) for k in range(N))
    loads = Loads(time, np.zeros((3, time.size, 0)), np.outer(push, np.linspace(0.5, 1.5, N)), labels)
    return diagonalise(system_of(M, K, alpha=20.0)), loads


def chatter() -> History:
    system, loads = drive()
    return simulate_flow(system, GAPS, loads, OutputRequest(np.arange(N)), resolution=SETTLED)


def impulses(history: History) -> np.ndarray:
    return np.asarray(history.weights @ history.force)


def test_impulses_and_what_is_not_force_stay():
    """In two parts, as chunks come: the sum over both is that of all instants, to round-off."""
    rng = np.random.default_rng(3)
    time = np.cumsum(rng.uniform(0.5, 1.5, 400))
    table = np.column_stack(
        [time, rng.standard_normal((400, 2)), np.abs(rng.standard_normal((400, 3))), np.arange(400)]
    )
    before, forces = table.copy(), slice(3, 6)
    used, at = thin(table, 400, 1, np.array([50, 120, 199]), forces, 7.0)
    assert table[at, 6].tolist() == [50, 120, 199]
    assert used == at[-1] + 1 + 200
    assert np.array_equal(table[at[-1] + 1 : used], before[200:])
    first = used - 200
    used, at = thin(table, used, first, np.array([used - 150, used - 1]), forces, 11.0)
    assert used < 95
    kept = table[:used]
    assert np.array_equal(kept[:, [0, 1, 2]], before[kept[:, 6].astype(int)][:, [0, 1, 2]])
    assert table[at, 6].tolist() == [250, 399]

    def sums(rows: np.ndarray) -> np.ndarray:
        half = 0.5 * np.diff(rows[:, 0])
        return (np.concatenate([[0.0], half]) + np.concatenate([half, [0.0]])) @ rows[:, forces]

    np.testing.assert_allclose(sums(kept), sums(before), rtol=1e-13)
    assert thin(table, used, 1, at, forces, 0.1)[0] == used  # nothing is closer than that


def test_chatter_is_kept_with_a_bound_and_the_same_impulses(monkeypatch):
    """The march does not know of it: motion and impulses are those of the run that keeps all."""
    whole = chatter()
    assert whole.time.size > 4 * KEPT
    assert whole.spacing == 0.0
    width = 1 + 2 * N + 8
    monkeypatch.setattr(thinning, "LONGEST", 0.2)
    monkeypatch.setattr(thinning, "BUDGET", 8.0 * width * KEPT)
    few = chatter()
    assert 0.0 < few.spacing <= 2e-4
    assert 0.5 * KEPT < few.time.size < 1.5 * KEPT
    assert np.array_equal(few.displacement, whole.displacement)
    assert np.array_equal(few.time[few.output_index], whole.time[whole.output_index])
    np.testing.assert_allclose(impulses(few), impulses(whole), rtol=1e-12)
    found, exact = (find_events(h, GAPS, merge=5e-3, f_max=500.0) for h in (few, whole))
    assert len(found) == len(exact) > 3
    for a, b in zip(found, exact, strict=True):
        assert a.t_start == pytest.approx(b.t_start, abs=2.0 * few.spacing)
        assert a.impulse == pytest.approx(b.impulse, rel=0.01)
        assert a.force_place == pytest.approx(b.force_place, rel=0.01)


def test_nothing_is_told_where_a_large_table_lost_no_instant(monkeypatch):
    """Free motion: a table beyond its budget of whole steps alone, all of which stay."""
    system, loads = drive()
    monkeypatch.setattr(thinning, "BUDGET", 1.0)
    far = channels(np.eye(N), np.full(N, 1e3), 1e9)
    history = simulate_flow(system, far, loads, OutputRequest(np.arange(N)), resolution=SETTLED)
    assert history.spacing == 0.0
    assert history.time.size == round(END / 1e-3) + 1


def test_a_spacing_is_as_short_as_there_is_room_and_no_longer_than_events_allow():
    time = np.concatenate([np.linspace(0.1, 0.101, 1000), np.linspace(0.5, 0.501, 1000)])
    assert spacing_for(time, 100, 1e-3) == pytest.approx(1e-3 * LONGEST / 2)
    assert spacing_for(time, 1000, 1e-3) == pytest.approx(1e-3 * LONGEST / 16)
    assert spacing_for(time, 10, 1e-3) == spacing_for(time, -5, 1e-3) == 1e-3 * LONGEST
    assert "43 us apart" in spacing_words(4.3e-5)[0]
    assert spacing_words(0.0) == ()


def test_a_table_that_memory_does_not_hold_ends_the_run_with_what_it_has(monkeypatch):
    system, loads = drive()
    run = FlowRun(system, GAPS, loads, OutputRequest(np.arange(N)), SETTLED)

    def full(needed: float, what: str, fix: str) -> None:
        raise OutOfMemory(f"memory does not hold {what}. {fix}")

    monkeypatch.setattr(recorder, "require", full)
    with pytest.raises(
        Stopped, match=r"memory does not hold .* instants of 12 channels\. Let the run end earlier"
    ) as end:
        march_chunks(run, None)
    assert end.value.history.time.size > 0
