"""Completion of commands, options and values in bash and zsh."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

COMMAND = Path(sys.executable).with_name("creak")


def bash(creak, monkeypatch, words):
    """What bash would be offered."""
    monkeypatch.setenv("_CREAK_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", str(len(words.split(" ")) - 1))
    return creak().out.split()


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ("creak r", ["run", "report", "robust", "reduce"]),
        ("creak mo", ["modes"]),
        ("creak run --conv", ["--converge"]),
        ("creak new deck.inp --units ", ["mm-t-s", "m-kg-s"]),
        ("creak example ", ["door", "cockpit"]),
    ],
)
def test_bash(creak, monkeypatch, words, offered):
    assert bash(creak, monkeypatch, words) == offered


def test_zsh(creak, monkeypatch):
    monkeypatch.setenv("_CREAK_COMPLETE", "complete_zsh")
    monkeypatch.setenv("_TYPER_COMPLETE_ARGS", "creak sch")
    said = creak()
    assert said.out.startswith("_arguments")
    assert '"schema"' in said.out


def test_help_names_completion_once_and_commands_not_at_all(creak):
    assert creak("--help").out.count("--install-completion") == 1
    assert "completion" not in creak("run", "--help").out


@pytest.mark.skipif(not COMMAND.exists() or shutil.which("bash") is None, reason="needs bash and the installed command")
def test_the_script_works_in_bash():
    """The script that --install-completion installs, taken into bash and asked."""
    ask = (
        'eval "$(_CREAK_COMPLETE=source_bash creak)"; complete -p creak; '
        'COMP_WORDS=(creak ad); COMP_CWORD=1; _creak_completion creak; echo "offered: ${COMPREPLY[@]}"'
    )
    environment = {**os.environ, "PATH": f"{COMMAND.parent}{os.pathsep}{os.environ['PATH']}"}
    said = subprocess.run(["bash", "-c", ask], capture_output=True, text=True, check=False, env=environment)
    assert "complete -o default -F _creak_completion creak" in said.stdout, said.stderr
    assert "offered: advise" in said.stdout
