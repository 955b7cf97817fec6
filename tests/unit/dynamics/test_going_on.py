"""Marches that are taken up where another one was: the same run to the last bit, by either stepper, through a file."""

from __future__ import annotations

import copy
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

from creak.assembly.part import Rayleigh
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.contact.laws.parameters import Friction
from creak.dynamics.flight.contact_steps import IN_CONTACT
from creak.dynamics.flight.stepper import FlightStepper
from creak.dynamics.history import ENERGIES, History, Interrupted
from creak.dynamics.instant import Saved
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.record.watch import Watched
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import CondensedStepper, march
from creak.formats.stored.sealed import Damaged
from creak.studies.run.checkpoint import read_checkpoint, write_checkpoint
from helpers_core import time_axis
from helpers_gap import LABELS, N, cantilevers, gaps_between, multisine_base

TIP = 6 * N + 1
PARTS = 10
STEPS = 100
END = 0.1


class Kill(Exception):
    """The process is gone."""


class Keep:
    """Takes the march from where `saved` is, and keeps a copy of it at each of the rows `at` that it can."""

    def __init__(self, at: Callable[[Saved], bool] = lambda _: True, saved: Saved | None = None) -> None:
        self.at, self.saved, self.kept = at, saved, list[Saved]()

    def wanted(self, last: bool) -> bool:
        return True

    def keep(self, saved: Saved) -> None:
        if self.at(saved):
            self.kept.append(copy.deepcopy(saved))

    def heeding(self):
        return nullcontext()


def system() -> System:
    return cantilevers(Rayleigh(5.0, 1e-6), dashpot=0.4)


def channels() -> GapOperator:
    """Springs with dampers, the second with friction: across, and along by the turning of the beams."""
    gaps = gaps_between(2e-4, 3e4, 0.5)
    tangents = []
    for dof, arm in ((5, 0.02), (2, 1.0)):
        T = np.zeros((2, LABELS))
        for row, node in enumerate((N // 2, N)):
            T[row, 6 * node + dof], T[row, 6 * (N + 1 + node) + dof] = -arm, 0.7 * arm
        tangents.append(sp.csr_matrix(T))
    mu = np.array([0.0, 0.3])
    return replace(gaps, tangents=tuple(tangents), friction=Friction(mu, mu, np.zeros(2)))


def loads() -> Loads:
    """A moving base and a force at a tip."""
    base = multisine_base(time_axis(END, END / STEPS / PARTS), 20.0, 60.0, 6e-4)
    force = 0.5 * np.sin(2.0 * np.pi * 70.0 * base.time)
    return replace(base, force=force[:, None], force_labels=(np.array([TIP]),))


def flights(like: Saved | None = None) -> FlightStepper:
    return FlightStepper(system(), channels(), loads(), IN_CONTACT, PARTS, like=None if like is None else like.stepper)


def forced(like: Saved | None = None) -> CondensedStepper:
    return CondensedStepper(system(), channels(), loads(), HHT(), PARTS)


STEPPERS: dict[str, Callable[..., FlightStepper | CondensedStepper]] = {"flights": flights, "forced": forced}


def run(kind: str, keeper: Keep | None = None, progress=None) -> History:
    turns = sp.csr_matrix(np.eye(3, LABELS, k=6 * N + 3))
    watched = Watched(gaps_between(1e-3).without_force(), turns, np.arange(LABELS), ("tip",))
    stepper = STEPPERS[kind](None if keeper is None else keeper.saved)
    return march(
        stepper,
        OutputRequest(np.array([TIP, TIP - 6]), every=3, whole_at=np.array([0, 31, 77]), watched=watched),
        progress=progress,
        keeper=keeper,
    )


def assert_identical(a: History, b: History) -> None:
    """All that a run leaves behind but the time that its setup took."""
    for x, y in ((a, b), (a.extremes, b.extremes)):
        for name in (f.name for f in fields(x) if f.name not in ("setup_s", "extremes")):
            np.testing.assert_array_equal(getattr(y, name), getattr(x, name), err_msg=name)


@pytest.fixture(scope="module", params=sorted(STEPPERS))
def whole(request) -> tuple[str, History, list[Saved]]:
    """A run that nothing stops, and what it was at every instant that it can be taken up from."""
    keeper = Keep()
    history = run(request.param, keeper)
    return request.param, history, keeper.kept


def test_keeping_changes_nothing(whole):
    kind, history, _ = whole
    assert_identical(run(kind), history)


def test_a_run_can_be_taken_up_in_flight_and_amid_contact(whole):
    """Never more than three output steps go by without a place to go on from; it may lie within one."""
    kind, history, kept = whole
    rows = np.array([s.now.row for s in kept])
    assert np.diff(rows).max() <= 3 * PARTS
    assert rows[-1] == STEPS * PARTS
    assert any(s.now.force.any() for s in kept)
    assert not all(s.now.force.any() for s in kept)
    work = history.energy[-1]
    assert all(abs(work[ENERGIES.index(name)]) > 0.0 for name in ("contact_damping", "friction", "damping"))
    if kind == "flights":
        assert any(row % PARTS for row in rows)


def chosen(kept: list[Saved]) -> list[Saved]:
    """Soon after the start, in flight, sticking and sliding amid contact, in the last step, at the end."""
    pressed = [s for s in kept if s.now.p[1] > 0.0]
    sliding = next(s for s in pressed if s.now.sliding.any())
    sticking = next((s for s in pressed if s.now.stuck.any()), sliding)
    free = [s for s in kept if not s.now.force.any()]
    return [kept[1], free[len(free) // 2], sliding, sticking, pressed[len(pressed) // 2], kept[-2], kept[-1]]


def test_it_goes_on_as_if_it_had_not_been_stopped(whole, tmp_path):
    kind, history, kept = whole
    for k, saved in enumerate(chosen(kept)):
        path = tmp_path / f"{k}.h5"
        write_checkpoint(path, "this", saved)
        found = read_checkpoint(path, "this", Saved)
        assert found is not None
        assert_identical(run(kind, Keep(saved=found)), history)


def test_stopped_twice_at_any_step(whole):
    """Killed in the callback, taken up from the last state that was kept, killed again, and so to the end."""
    kind, history, _ = whole
    saved: Saved | None = None
    for kill in (17, 58):

        def killed(done: int, total: int, kill: int = kill) -> None:
            if done == kill:
                raise Kill

        keeper = Keep(lambda s: s.now.row % 7 == 0, saved)
        with pytest.raises(Kill):
            run(kind, keeper, killed)
        saved = keeper.kept[-1]
    assert_identical(run(kind, Keep(saved=saved)), history)


def test_a_run_that_is_asked_to_end_while_it_is_kept_has_what_it_computed(whole):
    kind, history, kept = whole

    class Ends(Keep):
        def keep(self, saved: Saved) -> None:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted, match="stopped at t = ") as stop:
        run(kind, Ends(saved=copy.deepcopy(kept[20])))
    found = stop.value.history
    assert kept[20].log.time < found.time[-1] < END
    np.testing.assert_array_equal(found.force, history.force[: found.time.size])


def test_the_rule_of_the_flights_stays_whatever_memory_there_is_now(whole, monkeypatch):
    kind, history, kept = whole
    if kind != "flights":
        pytest.skip("a forced scheme has no rule to choose")
    monkeypatch.setattr("creak.dynamics.flight.step.free_bytes", lambda: 1.0)
    assert flights().rule.stages == 3
    assert flights(kept[0]).rule.stages == 5
    assert_identical(run(kind, Keep(saved=copy.deepcopy(kept[30]))), history)


# --- the file --------------------------------------------------------------------------------------------------------


def test_what_belongs_to_something_else_is_not_taken(whole, tmp_path):
    write_checkpoint(tmp_path / "one.h5", "this", whole[2][5])
    assert read_checkpoint(tmp_path / "one.h5", "that", Saved) is None
    assert read_checkpoint(tmp_path / "other.h5", "this", Saved) is None


@pytest.mark.parametrize("at", [0.0, 0.3, 0.6, 0.99])
def test_a_damaged_file_says_so(whole, tmp_path, at):
    path: Path = tmp_path / "one.h5"
    write_checkpoint(path, "this", whole[2][5])
    content = bytearray(path.read_bytes())
    content[int(at * len(content))] ^= 1
    path.write_bytes(content)
    with pytest.raises(Damaged, match="checksum"):
        read_checkpoint(path, "this", Saved)
    path.write_bytes(content[: len(content) // 2])
    with pytest.raises(Damaged, match="checksum"):
        read_checkpoint(path, "this", Saved)
