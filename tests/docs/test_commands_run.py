"""Every command of README.md and docs/ that can be run as it stands is run, on stand-ins for the files that it names.

`make` and what it needs (`pip`, `apt-get`) are run by hand and where creak is built and tested; here their targets,
files and extras are held to exist. Benchmarks take minutes: here they read their arguments.
"""

from __future__ import annotations

import argparse
import importlib
import re
import shutil
import subprocess
import sys
import tomllib

import pytest

from helpers_cli import caller, empty_reports, workers_here
from helpers_commands import Command, Workshop, all_commands, concrete, inputs, outputs, shorten_thesis
from helpers_docs import PAGES, ROOT, of_the_source, shell_words

pytestmark = pytest.mark.slow

FOUND = all_commands()
RUN = [c for c in FOUND if concrete(c.words)]
OTHERS = sorted({tuple(w) for p in PAGES for w in shell_words(p, r"(make|python3?|\S*pip|apt-get|dask) [a-z-]")})
MODULES = [w[2:] for w in OTHERS if w[0] == "python" and w[1] == "-m"]


@pytest.fixture(scope="module")
def workshop(tmp_path_factory):
    return Workshop(RUN, lambda: tmp_path_factory.mktemp("command"))


@pytest.fixture
def say(monkeypatch, capsys):
    """Runs a command in a folder. The shell is bash and its files are in that folder; the thesis is short, reports empty,
    and workers are this process."""
    call = caller(monkeypatch, capsys)
    monkeypatch.setattr("creak.studies.tasks.queue.local_workers", workers_here)
    empty_reports(monkeypatch)
    shorten_thesis(monkeypatch)

    def run(folder, words):
        monkeypatch.chdir(folder)
        if words[0].startswith("-"):
            monkeypatch.setenv("HOME", str(folder))
            monkeypatch.setattr("shellingham.detect_shell", lambda: ("bash", "/bin/bash"))
        return call(*words)

    return run


@pytest.mark.parametrize("command", RUN, ids=str)
def test_command_runs(command, workshop, say):
    workshop.run(command, say)


@pytest.mark.parametrize("command", [c for c in RUN if "--ignore" in c.words], ids=str)
def test_what_is_ignored_would_stop_the_command(command, workshop, say):
    folder = workshop.run(command, say)
    said = say(folder, command.words[: command.words.index("--ignore")])
    said.refuses(f"--ignore '{command.words[-1]}'")


def test_a_file_that_is_not_written_is_seen(tmp_path, say):
    here = Workshop([], lambda: tmp_path)
    with pytest.raises(AssertionError, match=r"study\.toml was not written"):
        here.run(Command(("new", "model.inp", "--out", "study.toml")), lambda folder, words: say(folder, ["schema"]))
    with pytest.raises(AssertionError, match=r"ends in \.vtu"):
        here.run(Command(("modes", "model.inp", "--vtk", "modes.txt")), say)


@pytest.mark.parametrize(
    ("line", "runs"),
    [
        ("run deck.inp", True),
        ("run study.toml --ignore CGAP", True),
        ("schema", True),
        ("--show-completion", True),
        ("example door --load A4", True),
        ("convert model.bdf model --matrices npz", True),
        ("run", False),
        ("run --converge", False),
        ("run STUDY.toml", False),
        ("run DECK --ignore CGAP", False),
        ("example", False),
        ("example door --mesh-size H", False),
        ("convert IN OUT.inp", False),
        ("convert model.inp OUT", False),
        ("modes model.inp [--json FILE]", False),
        ("info door.inp --units mm-t-s | m-kg-s", False),
    ],
)
def test_commands_that_are_left_out(line, runs):
    assert concrete(line.split()) == runs


def test_most_commands_are_run():
    """A synopsis and one or two mentions of each command are left out, but no command with options."""
    left = [c for c in FOUND if c not in RUN]
    assert len(RUN) >= 45
    assert len(left) <= 3 * len({c.words[0] for c in left})
    of_rattling = {"listen"}  # needs a run whose parts touch: tests/unit/studies/sound/test_sound.py
    assert {c.words[0] for c in RUN} | of_rattling >= {c.words[0] for c in left}


@pytest.mark.parametrize(
    ("line", "reads", "writes"),
    [
        (
            "modes model.inp --f-max 100 --vtk a.vtu --uff b.unv --json c.json",
            ["model.inp"],
            ["a.vtu", "b.unv", "c.json"],
        ),
        ("convert a.bdf b.inp --mass linear", ["a.bdf"], ["b.inp"]),
        ("convert a.bdf b --matrices npz", ["a.bdf"], ["b.npz"]),
        ("run study.toml --json", ["study.toml"], []),
        ("run study.toml --out results --superelements kept", ["study.toml"], ["results"]),
        ("example door --mesh-size 20 --out door", [], ["door"]),
    ],
)
def test_files_of_a_command(line, reads, writes):
    assert inputs(line.split()) == reads
    assert outputs(line.split()) == writes


def test_targets_of_make_exist():
    text = of_the_source("Makefile").read_text(encoding="utf-8")
    targets = {w[1] for w in OTHERS if w[0] == "make"}
    assert len(targets) > 3
    for target in targets:
        assert re.search(rf"^{target}:", text, flags=re.MULTILINE), target


def test_what_pip_installs_exists():
    """Extras of creak and files of requirements."""
    extras = tomllib.loads(of_the_source("pyproject.toml").read_text(encoding="utf-8"))["project"][
        "optional-dependencies"
    ]
    installs = [w[w.index("install") + 1 :] for w in OTHERS if w[0].endswith("pip")]
    assert len(installs) > 4
    for words in installs:
        if words[0] == "-r":
            assert (ROOT / words[1]).exists(), words
        else:
            of = re.fullmatch(r"(?:creak|\.|creak-VERSION-py3-none-any\.whl)\[(.*)\]", words[0])
            assert of, words
            assert set(of[1].split(",")) <= set(extras), words


@pytest.mark.parametrize("words", [w for w in MODULES if w[0].startswith("benchmarks")], ids=" ".join)
def test_a_benchmark_takes_its_arguments(words, monkeypatch):
    """Nothing but the arguments is read."""
    of_the_source("benchmarks")
    monkeypatch.syspath_prepend(ROOT)
    module = importlib.import_module(words[0])
    if hasattr(module, "__path__"):
        module = importlib.import_module(f"{words[0]}.__main__")
    parse, given = argparse.ArgumentParser.parse_args, []

    def stop(parser, *arguments):
        given.append(parse(parser, *arguments))
        raise KeyboardInterrupt

    monkeypatch.setattr(argparse.ArgumentParser, "parse_args", stop)
    monkeypatch.setattr("sys.argv", list(words))
    with pytest.raises(KeyboardInterrupt):
        module.main()
    assert len(given) == 1


@pytest.mark.parametrize("words", [w for w in MODULES if w[0].startswith("tools")], ids=" ".join)
def test_a_page_is_made_anew(words, tmp_path):
    """In a copy of the tools and pages; the page that comes out is the one in docs/."""
    shutil.copytree(of_the_source("tools"), tmp_path / "tools", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "docs").mkdir()
    subprocess.run([sys.executable, "-m", *words], cwd=tmp_path, check=True, capture_output=True, timeout=300)
    (page,) = (tmp_path / "docs").iterdir()
    assert page.read_bytes() == (ROOT / "docs" / page.name).read_bytes()


def test_other_commands_are_of_known_kinds():
    """A module of another package, or another program, would need a test of its own kind."""
    assert len(MODULES) > 10
    for words in MODULES:
        assert words[0].split(".")[0] in {"benchmarks", "tools", "creak"}, words
    for words in OTHERS:
        assert words[0] in {"make", "python", "apt-get"} or words[0].endswith("pip") or words[1:3] == ("-m", "venv"), (
            words
        )
