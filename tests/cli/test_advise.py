"""`creak advise` through the command."""

import json
import tomllib

import pytest

from creak.cli.main import main
from creak.studies.study_file import read_study
from helpers_decks import STUDY, write_strips


def creak(monkeypatch, *arguments):
    monkeypatch.setattr("sys.argv", ["creak", *map(str, arguments)])
    with pytest.raises(SystemExit) as stop:
        main()
    return stop.value.code


def test_advice_on_two_strips(monkeypatch, capsys, tmp_path):
    study = write_strips(tmp_path)
    before = sorted(p.name for p in tmp_path.iterdir())
    assert creak(monkeypatch, "advise", study) == 0
    shown = capsys.readouterr().out
    for text in ("excitation to 60 Hz (stated)", "UPPER", "gap-modes", "because", "lines of the study file to change"):
        assert text in shown
    assert sorted(p.name for p in tmp_path.iterdir()) == before
    assert creak(monkeypatch, "advise", study, "--json") == 0
    advice = json.loads(capsys.readouterr().out)["advice"]
    assert tomllib.loads(advice["toml"])["reduction"]["method"] == advice["method"] == "gap-modes"
    assert advice["toml"].strip() in shown


def test_the_advised_study_runs_as_it_is(monkeypatch, capsys, tmp_path):
    """The lines, put into the study: nothing is left to change, and creak takes the file."""
    path = write_strips(tmp_path)
    assert creak(monkeypatch, "advise", path, "--quiet") == 0
    lines = tomllib.loads(capsys.readouterr().out.partition("change:\n")[2])
    study = STUDY.replace("f_max = 3000", f'method = "{lines["reduction"]["method"]}"\nf_max = {lines["reduction"]["f_max"]}')
    study = study.replace("step = 5e-4", f"step = {lines['time']['step']}")
    path.write_text(study, encoding="utf-8")
    assert read_study(path).config.reduction.method == "gap-modes"
    assert creak(monkeypatch, "advise", path, "--quiet") == 0
    assert "the study file can stay as it is" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nothing.toml"], "no such study file"),
        (["strips.inp"], "is a deck"),
        (["study.toml", "--quiet", "--verbose"], "both --quiet and --verbose"),
    ],
)
def test_wrong_input_is_one_message_and_status_2(monkeypatch, capsys, tmp_path, arguments, said):
    write_strips(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert creak(monkeypatch, "advise", *arguments) == 2
    captured = capsys.readouterr()
    assert said in captured.err
    assert "Traceback" not in captured.err
