"""The first commands of the page for Abaqus decks, run as they stand on a small deck."""

from __future__ import annotations

import runpy

import pytest

from helpers_cli import caller
from helpers_docs import ROOT, commands

PAGE = ROOT / "docs" / "howto_abaqus.md"
QUICK = ("info", "modes", "new")


@pytest.mark.parametrize("name", QUICK)
def test_command_runs(name, tmp_path, monkeypatch, capsys):
    if not (ROOT / "examples").exists():
        pytest.skip("examples/ belongs to the source tree")
    deck = runpy.run_path(str(ROOT / "examples" / "two_strips.py"))["deck"]
    (tmp_path / "model.inp").write_text(deck())
    monkeypatch.chdir(tmp_path)
    found = [words for words in commands(PAGE) if words[0] == name and len(words) > 1]
    assert found
    for words in found:
        said = caller(monkeypatch, capsys)(*words)
        assert said.status == 0, said.words
        for file in (w for w in words if w.endswith((".toml", ".vtu"))):
            assert (tmp_path / file).exists()
