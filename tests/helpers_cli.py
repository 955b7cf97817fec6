"""The command, called in this process."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from creak.cli.main import main


@dataclass(frozen=True)
class Said:
    status: int
    out: str
    err: str

    @property
    def words(self) -> str:
        """Both streams, blanks and line ends made one."""
        return " ".join((self.out + self.err).split())


def caller(monkeypatch, capsys):
    """A function that runs `creak WORDS` and returns what it said."""

    def call(*words: object) -> Said:
        monkeypatch.setattr("sys.argv", ["creak", *map(str, words)])
        capsys.readouterr()
        with pytest.raises(SystemExit) as stop:
            main()
        printed = capsys.readouterr()
        return Said(int(stop.value.code or 0), printed.out, printed.err)

    return call
