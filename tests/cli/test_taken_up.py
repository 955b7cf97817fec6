"""`creak run` of an unreduced model that was killed or asked to end: the same command goes on, to the same results."""

from __future__ import annotations

import json
import os
import shutil
import signal
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest

from creak.api.study import run_setup, set_up
from creak.cli.output import ProgressBars
from creak.errors import WriteError
from creak.studies.run import checkpoint
from creak.studies.run.checkpoint import ENDING, Checkpoint
from helpers_cli import Said, empty_reports
from helpers_decks import STUDY, write_strips

UNREDUCED = (
    STUDY.replace("f_max = 3000", 'method = "none"')
    .replace('"surface-to-surface"', '"surface-to-surface"\nfriction = 0.3\nclearance = 0.5')
    .replace("step = 5e-4\nperiods = 2", 'accuracy = "quick"\nend = 0.06')
    .replace("amplitude = 0.05", "amplitude = 0.3")
    + """
[output]
interval = 1e-3

[[connector]]
type = "play"
nodes = ["TIP_UPPER", "TIP_LOWER"]
dof = "z"
lower = -0.3
upper = 0.3
stiffness = 20.0
damping = 0.01

[support.side]
nodes = "ROOT_UPPER"
free = ["x"]

[excitation.side]
node_set = "ROOT_UPPER"
dof = "x"
kind = "displacement"
signal = { type = "sine", frequency = 40, amplitude = 0.1 }
"""
)
PLAIN = ("--animation-mb", "0", "--no-converge")
TIMINGS = ("wall_s", "cpu_s", "setup_s", "offline_cpu_s", "offline_wall_s", "peak_rss_gb")


NEVER = 1_000_000


class Kill(BaseException):
    """The process is gone."""


@pytest.fixture(autouse=True)
def heard():
    """Ctrl-C as in a terminal: who was started in the background ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(autouse=True)
def soon(monkeypatch, no_page):
    """A checkpoint every now and then, and no page."""
    monkeypatch.setattr(checkpoint, "EVERY", 0.4)
    monkeypatch.setattr(checkpoint, "DEAR", 0.0)


@pytest.fixture
def stop_at(monkeypatch):
    """Something that happens once a number of steps of the unreduced run is done; told are the stages' names."""
    stages: list[str] = []
    show = ProgressBars.__call__

    def at(step: int, what, ready=lambda: True) -> list[str]:
        stages.clear()
        done_it: list[int] = []

        def watch(self: ProgressBars, stage: str, done: int, total: int) -> None:
            if stage not in stages:
                stages.append(stage)
            show(self, stage, done, total)
            if stage.startswith("reference run") and done >= step and not done_it and ready():
                done_it.append(done)
                what()

        monkeypatch.setattr(ProgressBars, "__call__", watch)
        return stages

    return at


def kill() -> None:
    raise Kill


def ask(number: signal.Signals):
    return lambda: os.kill(os.getpid(), number)


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Iterator[Path]:
    """The results of a run that nothing stopped."""
    study = write_strips(tmp_path_factory.mktemp("whole"), study=UNREDUCED)
    with pytest.MonkeyPatch.context() as patch:
        empty_reports(patch)
        run_setup(set_up(study), converge=False, record=False).save(study.parent / "results")
    yield study.parent
    shutil.rmtree(study.parent)


@pytest.fixture
def folder(tmp_path) -> Path:
    write_strips(tmp_path, study=UNREDUCED)
    return tmp_path


def again(creak, folder: Path, *words: object) -> Said:
    return creak("run", folder / "study.toml", *PLAIN, *words)


def left(folder: Path) -> list[Path]:
    return sorted((folder / "results").glob(f"*{ENDING}"))


def summary(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "results" / "summary.json").read_text(encoding="utf-8"))


def assert_same_results(folder: Path, whole: Path) -> None:
    """Every array of the run to the last bit, and all figures of the summary but times and notes."""
    with h5py.File(folder / "results/results.h5") as a, h5py.File(whole / "results/results.h5") as b:
        names: list[str] = []
        b["runs/reference"].visit(names.append)
        assert {"time", "gap", "normal_force", "friction_force", "displacement", "energy"} <= set(names)
        for name in names:
            if isinstance(b["runs/reference"][name], h5py.Dataset):
                np.testing.assert_array_equal(a["runs/reference"][name][()], b["runs/reference"][name][()], name)
    figures = [summary(one)["runs"]["reference"] for one in (folder, whole)]
    for run in figures:
        for key in TIMINGS:
            run.pop(key, None)
    assert figures[0] == figures[1]


def test_the_run_has_all_that_can_be_lost(whole):
    """Contact, friction, a damper that was met, and no checkpoint when it is done."""
    with h5py.File(whole / "results/results.h5") as file:
        run = file["runs/reference"]
        assert np.abs(run["friction_force"][()]).max() > 0.0
        assert np.count_nonzero(run["normal_force"][()].max(axis=0)) > 3
    assert summary(whole)["runs"]["reference"]["events"]
    assert left(whole) == []


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_killed_and_asked_to_end_it_is_the_same_run_in_the_end(creak, folder, whole, stop_at):
    """Killed amid contact: nothing is left but the checkpoint. Taken up, and asked to end by a batch system: results
    up to there. Taken up to the end: those of a run that nothing stopped, and no checkpoint."""
    stop_at(40, kill, lambda: left(folder))
    with pytest.raises(Kill):
        again(creak, folder)
    assert len(left(folder)) == 1
    assert list((folder / "results").iterdir()) == left(folder)

    before = signal.getsignal(signal.SIGTERM)
    stop_at(30, ask(signal.SIGTERM))
    said = again(creak, folder)
    assert said.status == 1
    assert "reference run: stopped at t = 0.0" in said.words
    assert "reference run: the same command goes on at 0.0" in said.words
    assert summary(folder)["stopped"]
    (path,) = left(folder)
    assert str(path) in said.words
    assert signal.getsignal(signal.SIGTERM) is before

    stages = stop_at(NEVER, kill)
    said = again(creak, folder)
    assert said.status == 0
    assert_same_results(folder, whole)
    assert left(folder) == []
    (stage,) = (s for s in stages if s.startswith("reference run"))
    assert stage.startswith("reference run goes on at 0.0")
    assert stage.endswith(" s of 0.06 s")
    assert f"{stage}, where an earlier one was stopped" in said.words
    assert any(stage in note for note in summary(folder)["notes"])
    cost, alone = (summary(one)["runs"]["reference"]["cpu_s"] for one in (folder, whole))
    assert cost > 0.5 * alone  # of all three parts


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_a_damaged_checkpoint_is_told_and_the_run_starts_anew(creak, folder, stop_at):
    stop_at(10, ask(signal.SIGINT))
    again(creak, folder)
    (path,) = left(folder)
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    stages = stop_at(5, ask(signal.SIGINT))
    said = again(creak, folder)
    assert said.err.count("is damaged (") == 1
    assert f"warning: reference run starts anew, its checkpoint {path} is damaged" in said.words
    assert "reference run anew (its checkpoint is damaged)" in stages
    assert left(folder) == [path]  # a whole one in its place
    assert "goes on at" in again_at_once(creak, folder, stop_at)


def again_at_once(creak, folder: Path, stop_at) -> str:
    """What is said when the same command is called once more and asked to end in its first step."""
    stop_at(1, ask(signal.SIGINT))
    return again(creak, folder).words


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_that_of_another_study_stays_where_it_is(creak, folder, stop_at):
    """A changed value, into the same folder: nothing is taken from it, and it is not replaced."""
    stop_at(10, ask(signal.SIGINT))
    again(creak, folder)
    (path,) = left(folder)
    content = path.read_bytes()
    stop_at(5, ask(signal.SIGINT))
    said = again(creak, folder, "--set", "contact.tip.friction=0.2", "--out", folder / "results")
    assert f"reference run starts anew, {path.name} in {path.parent} belongs to another study" in said.words
    assert any("belongs to another study" in text for text in summary(folder)["warnings"])
    assert path.read_bytes() == content
    assert len(left(folder)) == 2


# --- one file ------------------------------------------------------------------------------------------------------


def one(tmp_path: Path, notes: list[str]) -> Checkpoint:
    return Checkpoint(tmp_path / f"x{ENDING}", "reference", 5.0, notes, [])


SAVED: Any = SimpleNamespace(log=SimpleNamespace(time=1.25))


def test_a_checkpoint_that_cannot_be_written_costs_one_warning(tmp_path, monkeypatch):
    def full(*_: object) -> None:
        raise WriteError("cannot write x: no space left on device")

    monkeypatch.setattr(checkpoint, "write_checkpoint", full)
    notes: list[str] = []
    found = one(tmp_path, notes)
    found.keep(SAVED)
    found.keep(SAVED)
    assert notes == ["reference run goes on without a checkpoint: cannot write x: no space left on device"]
    assert not found.wanted(last=True)


def test_ctrl_c_in_the_middle_of_the_file_writes_it_once_more(tmp_path, monkeypatch):
    tries = []

    def write(*_: object) -> None:
        tries.append(1)
        if len(tries) == 1:
            raise KeyboardInterrupt

    monkeypatch.setattr(checkpoint, "write_checkpoint", write)
    notes: list[str] = []
    with pytest.raises(KeyboardInterrupt):
        one(tmp_path, notes).keep(SAVED)
    assert len(tries) == 2
    assert notes == [f"reference run: the same command goes on at 1.25 s ({tmp_path / f'x{ENDING}'})"]


def test_files_that_take_long_are_written_less_often(tmp_path, monkeypatch):
    now = [0.0]
    monkeypatch.setattr(checkpoint, "EVERY", 300.0)
    monkeypatch.setattr(checkpoint, "DEAR", 50.0)
    monkeypatch.setattr(checkpoint.time, "monotonic", lambda: now[0])
    found = one(tmp_path, [])
    monkeypatch.setattr(checkpoint, "write_checkpoint", lambda *_: now.__setitem__(0, now[0] + 20.0))
    assert not found.wanted(last=False)
    assert not found.wanted(last=True)
    now[0] = 300.0
    assert found.wanted(last=False)
    found.keep(SAVED)
    now[0] += 999.0
    assert not found.wanted(last=False)
    assert found.wanted(last=True)  # there is a file: the end belongs into it too
    now[0] += 2.0
    assert found.wanted(last=False)


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_the_second_ctrl_c_does_not_wait(tmp_path):
    found = one(tmp_path, [])
    went_on = []

    def twice() -> None:
        with found.heeding():
            os.kill(os.getpid(), signal.SIGINT)
            went_on.append(found.wanted(last=False))
            os.kill(os.getpid(), signal.SIGINT)
            went_on.append(False)

    with pytest.raises(KeyboardInterrupt):
        twice()
    assert went_on == [True]
