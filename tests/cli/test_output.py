"""What all commands share: --help, --quiet, --verbose, --json, progress, Ctrl-C."""

from __future__ import annotations

import io
import json
import time

import pytest
from rich.console import Console

from creak.cli import output
from creak.cli.output import Interrupted, Output, ProgressBars
from helpers_decks import STUDY, write_strips

COMMANDS = ("new", "run", "advise", "reduce", "sweep", "info", "modes", "convert")
SHORT = STUDY.replace("periods = 2", "end = 0.02") + "\n[reference]\nrun = false\n[precheck]\nmargin = 0.5\n"


@pytest.fixture
def folder(tmp_path):
    write_strips(tmp_path, study=SHORT)
    (tmp_path / "sweep.toml").write_text('base = "study.toml"\nseeds = [1, 2]\n')
    return tmp_path


def arguments(command, folder):
    deck, study = folder / "strips.inp", folder / "study.toml"
    return {
        "new": [deck, "--out", folder / "made.toml"],
        "run": [study, "--out", folder / "out"],
        "advise": [study],
        "reduce": [study],
        "sweep": [folder / "sweep.toml", "--dry-run"],
        "info": [deck],
        "modes": [deck, "--count", 2],
        "convert": [deck, folder / "copy.inp"],
    }[command]


def ctrl_c(*_, **__):
    raise KeyboardInterrupt


KEYS = {
    "new": "contacts",
    "run": "runs",
    "advise": "reductions",
    "reduce": "superelements",
    "sweep": "cases",
    "info": "parts",
    "modes": "frequencies",
    "convert": "written",
}


@pytest.mark.parametrize("command", COMMANDS)
def test_help_has_an_example_and_the_shared_options(creak, command):
    said = creak(command, "--help").done()
    assert f"Example: creak {command} " in said.words
    assert all(option in said.out for option in ("--quiet", "--verbose", "--json", "-q", "-v"))


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.usefixtures("no_page")
def test_json_is_all_that_stdout_holds(creak, folder, command):
    """Verbose as well: its lines are on stderr."""
    machines = ["--json", "-"] if command == "modes" else ["--json"]
    said = creak(command, *arguments(command, folder), *machines, "--verbose").done()
    assert KEYS[command] in json.loads(said.out)
    assert said.err


@pytest.mark.parametrize("command", ["reduce", "modes", "convert", "new"])
def test_quiet_says_nothing(creak, folder, command):
    said = creak(command, *arguments(command, folder), "--quiet")
    assert (said.status, said.out, said.err) == (0, "", "")


@pytest.mark.usefixtures("no_page")
def test_quiet_run_says_its_one_warning(creak, folder):
    said = creak("run", *arguments("run", folder), "--quiet")
    assert (said.status, said.out) == (0, "")
    (line,) = said.err.splitlines()
    assert line.startswith("warning: nothing touched in the run: ")


@pytest.mark.usefixtures("no_page")
def test_verbose_tells_phases_sizes_and_choices(creak, folder):
    said = creak("run", *arguments("run", folder), "--verbose")
    for words in (
        "read the model and find the contacts: ",
        " s\n",
        "78 nodes, 48 elements",
        "39 channels",
        "craig-bampton to 3000 Hz",
        "steps of 0.0005 s to 0.02 s, hht",
        "excitation: root up to 60 Hz",
    ):
        assert words in said.err
    assert "78 nodes" not in creak("run", *arguments("run", folder)).err


@pytest.mark.parametrize("command", COMMANDS)
def test_quiet_and_verbose_exclude_each_other(creak, folder, command):
    said = creak(command, *arguments(command, folder), "-q", "-v")
    said.refuses("both --quiet and --verbose")


def test_json_of_a_failure_leaves_stdout_empty(creak, folder):
    said = creak("run", folder / "none.toml", "--json")
    assert (said.status, said.out) == (2, "")
    assert "none.toml" in said.err


def test_plain_lines_tell_time_left(monkeypatch):
    """A line after 2 s, then every 10 s, then when the phase ends; none for a phase that is short."""
    now, text = [0.0], io.StringIO()
    monkeypatch.setattr(output.time, "monotonic", lambda: now[0])
    bars = ProgressBars(Console(file=text, force_terminal=False))
    with bars:
        bars("short", 0, 1)
        now[0] = 1.0
        bars("short", 1, 1)
        for done in range(101):
            now[0] = 1.0 + 0.5 * done
            bars("long", done, 100)
    lines = text.getvalue().splitlines()
    assert lines[0] == "long: 4 % after 2 s, about 48 s left"
    assert lines[1] == "long: 24 % after 12 s, about 38 s left"
    assert lines[-1] == "long: 50.0 s"
    assert len(lines) == 6


def test_a_phase_of_the_same_name_begins_anew(monkeypatch):
    """The first was too short to be named; the second has more steps, and is told to have ended once."""
    now, text = [0.0], io.StringIO()
    monkeypatch.setattr(output.time, "monotonic", lambda: now[0])
    bars = ProgressBars(Console(file=text, force_terminal=False))
    with bars:
        bars("modes", 78, 78)
        now[0] = 1000.0
        for done in (0, 100, 200, 200, 200):
            bars("modes", done, 200)
            now[0] += 5.0
    assert text.getvalue().splitlines() == ["modes: 50 % after 5 s", "modes: 10.0 s"]


def test_time_left_is_told_of_steps_that_can_last_alike(monkeypatch):
    """Nothing of three parts that differ in size, and no milliseconds."""
    now, text = [0.0], io.StringIO()
    monkeypatch.setattr(output.time, "monotonic", lambda: now[0])
    bars = ProgressBars(Console(file=text, force_terminal=False))
    with bars:
        for done in range(3):
            bars("check", done, 3)
            now[0] += 5.0
        bars("check", 3, 3)
        bars("modes", 0, 100)
        now[0] += 5.0
        bars("modes", 99, 100)
    assert text.getvalue().splitlines() == ["check: 33 % after 5 s", "check: 15.0 s", "modes: 99 % after 5 s"]


def test_what_the_first_step_waited_for_is_not_counted_as_speed(monkeypatch):
    """Two seconds of compiling, then 200,000 steps in twenty: not the five days that the first step foretells."""
    now, text = [0.0], io.StringIO()
    monkeypatch.setattr(output.time, "monotonic", lambda: now[0])
    bars = ProgressBars(Console(file=text, force_terminal=False))
    with bars:
        bars("spot checks", 0, 200_000)
        for done in range(1, 200_000, 1_000):
            now[0] = 2.0 + 1e-4 * done
            bars("spot checks", done, 200_000)
    lines = text.getvalue().splitlines()
    assert lines == ["spot checks: 0 % after 2 s", "spot checks: 50 % after 12 s, about 10 s left"]


def test_what_an_earlier_run_did_is_not_counted_as_speed(monkeypatch):
    now, text = [0.0], io.StringIO()
    monkeypatch.setattr(output.time, "monotonic", lambda: now[0])
    bars = ProgressBars(Console(file=text, force_terminal=False))
    with bars:
        for done in range(44, 60):
            bars("draws", done, 100)
            now[0] += 1.0
    lines = text.getvalue().splitlines()
    assert lines[0] == "draws: 46 % after 2 s, about 54 s left"
    assert lines[1] == "draws: 56 % after 12 s, about 44 s left"


def test_a_phase_without_steps_is_named_while_it_goes_on(monkeypatch):
    text = io.StringIO()
    monkeypatch.setattr(output, "SHOWN_AFTER", 0.01)
    bars = ProgressBars(Console(file=text, force_terminal=False))
    with bars, bars.phase("read the deck"):
        end = time.monotonic() + 20.0
        while "read the deck ..." not in text.getvalue() and time.monotonic() < end:
            time.sleep(0.01)
    assert text.getvalue().startswith("read the deck ...\nread the deck: ")


def test_a_terminal_gets_bars_with_time_left():
    text = io.StringIO()
    bars = ProgressBars(Console(file=text, force_terminal=True, width=120))
    with bars:
        bars("reduced run", 0, 10)
        bars("reduced run", 5, 10)
        bars("reduced run", 10, 10)
        bars("reduced run", 0, 10)
    shown = text.getvalue()
    assert "reduced run" in shown
    assert "0 %" in shown
    assert "0:00:00" in shown


def test_interruption_names_what_was_written(tmp_path):
    talk = Output()
    talk.wrote(tmp_path / "summary.json")
    with pytest.raises(Interrupted, match=r"written before: .*summary\.json"), talk:
        raise KeyboardInterrupt


def test_ctrl_c_while_the_report_is_written_keeps_the_results(creak, folder, monkeypatch):
    monkeypatch.setattr("creak.report.html.report_text", ctrl_c)
    said = creak("run", *arguments("run", folder))
    assert said.status == 1
    assert "stopped; written before: " in said.err
    assert "summary.json" in said.err
    assert (folder / "out" / "results.h5").exists()


def test_ctrl_c_before_anything_is_written_says_so(creak, folder, monkeypatch):
    monkeypatch.setattr("creak.studies.models.of_parts.assembled", ctrl_c)
    said = creak("run", *arguments("run", folder))
    assert said.status == 1
    assert "stopped; nothing was written" in said.err
    assert not (folder / "out").exists()


@pytest.mark.usefixtures("no_page")
def test_ctrl_c_after_the_reduced_run_keeps_it(creak, folder, monkeypatch):
    monkeypatch.setattr("creak.studies.models.health.checked", ctrl_c)
    said = creak("run", *arguments("run", folder))
    assert said.status == 1
    assert "stopped while the superelements were checked" in said.err
    assert list(json.loads((folder / "out" / "summary.json").read_text())["runs"]) == ["reduced"]


def test_ctrl_c_in_reduce_saves_the_parts_that_are_done(creak, folder, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr("creak.studies.models.health.check", ctrl_c)
        said = creak("reduce", folder / "study.toml")
    assert said.status == 1
    assert "UPPER.h5" in said.err
    again = json.loads(creak("reduce", folder / "study.toml", "--json").out)
    assert {name: part["reused"] for name, part in again["superelements"].items()} == {"UPPER": True, "LOWER": False}
