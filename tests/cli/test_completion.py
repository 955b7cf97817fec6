"""Completion of commands, options and values in bash and zsh.

`creak schema`: a valid JSON schema that takes what creak takes and refuses a misspelt key.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from creak_thesis.door.writer import study_text
from helpers_decks import STUDY

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
        ("creak new deck.inp --units ", ["mm-t-s", "m-kg-s", "in-lbf-s"]),
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


jsonschema = pytest.importorskip("jsonschema", reason="pip install jsonschema")


@pytest.fixture
def schema(creak):
    return json.loads(creak("schema").out)


def problems(schema, text):
    return list(jsonschema.Draft202012Validator(schema).iter_errors(tomllib.loads(text)))


def test_it_is_a_schema(schema):
    jsonschema.Draft202012Validator.check_schema(schema)


@pytest.mark.parametrize("text", [study_text(), STUDY])
def test_studies_fit(schema, text):
    assert problems(schema, text) == []


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ("secondary", "secondry", "secondry"),
        ('"surface-to-surface"', '"mortar"', "mortar"),
        ("f_max = 3000", "f_max = -1", "-1"),
        ("step = 5e-4", 'step = "short"', "short"),
        ('deck = "strips.inp"', "", "deck"),
        ('"multisine"', '"noise"', "noise"),
    ],
)
def test_mistakes_do_not(schema, old, new, word):
    assert old in STUDY
    found = problems(schema, STUDY.replace(old, new, 1))
    assert found
    assert any(word in str(e) for e in found)


def test_every_key_is_described(schema):
    tables = [schema, *schema["$defs"].values()]
    bare = [
        key for t in tables for key, value in t["properties"].items() if key != "type" and "description" not in value
    ]
    assert bare == []
    assert "Hz" in schema["$defs"]["ReductionTable"]["properties"]["f_max"]["description"]


def test_out_writes_a_file(creak, tmp_path, schema):
    creak("schema", "--out", tmp_path / "s.json").done()
    assert json.loads((tmp_path / "s.json").read_text()) == schema
