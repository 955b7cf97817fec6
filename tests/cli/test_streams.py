"""Streams that are closed or full, and names that no file can have: one message, a status that says which, no traceback."""

from __future__ import annotations

import subprocess
import sys

import pytest

from creak.api.decks import read_deck
from creak.cli.main import main
from creak.errors import InputError
from creak.studies.file.reader import read_study
from helpers_decks import two_strips

CREAK = f"{sys.executable} -m creak.cli.main"
LONG = "a" * 300
ON_LINUX = pytest.mark.skipif(sys.platform != "linux", reason="a shell, /dev/full")


def shell(folder, line):
    ran = subprocess.run(["sh", "-c", line], cwd=folder, capture_output=True, text=True, check=False)
    assert "Traceback" not in ran.stderr
    return ran


@ON_LINUX
@pytest.mark.parametrize(
    ("line", "status"),
    [
        ("info d.inp >&-", 0),
        ("--help <&- >&- 2>&-", 0),
        ("info none.inp 2>/dev/full", 2),
        (">/dev/full", 1),
        ("schema 1</dev/null", 1),
    ],
)
def test_streams(tmp_path, line, status):
    """Nobody listens on a closed stream; a stream that cannot be written fails; what stderr cannot take costs nothing."""
    (tmp_path / "d.inp").write_text(two_strips(), encoding="utf-8")
    assert shell(tmp_path, f"{CREAK} {line}").returncode == status


@pytest.mark.parametrize(
    "words",
    [
        ["info", LONG],
        ["modes", f"{LONG}.inp"],
        ["new", f"{LONG}/x.bdf"],
        ["convert", "d.inp", f"{LONG}.bdf"],
        ["listen", LONG],
        ["example", "door", "--out", LONG],
        ["info", "inc.bdf"],
    ],
)
def test_names_of_no_file(tmp_path, monkeypatch, capsys, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "d.inp").write_text(two_strips(), encoding="utf-8")
    (tmp_path / "inc.bdf").write_text(f"INCLUDE '{LONG}'\nBEGIN BULK\nENDDATA\n", encoding="utf-8")
    monkeypatch.setattr(sys, "argv", ["creak", *words])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 2
    assert "name too long" in capsys.readouterr().err.lower()


@pytest.mark.parametrize("name", [LONG, f"{LONG}.inp", "a\0b", "."])
@pytest.mark.parametrize("read", [read_deck, read_study])
def test_so_in_python(read, name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=r"cannot read|no deck|is a deck|no file can be called"):
        read(tmp_path / name)
