"""The command, called in this process."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass

import pytest

from creak.cli.main import main
from creak.formats.stored.run_identity import META
from creak.studies.tasks.queue import Runner

EMPTY = f"<!DOCTYPE html><head>{META}<title>x – creak report</title></head>"


@dataclass(frozen=True)
class Said:
    status: int
    out: str
    err: str

    @property
    def words(self) -> str:
        """Both streams, blanks and line ends made one."""
        return " ".join((self.out + self.err).split())

    def done(self) -> Said:
        """Itself, where it ended with status 0."""
        assert self.status == 0, self.words
        return self

    def refuses(self, *words: str) -> None:
        """It ends with status 2 and one message, without a traceback, and these are among its words."""
        assert self.status == 2, self.words
        assert [line.startswith("creak: ") for line in self.err.splitlines()].count(True) == 1, self.words
        assert "Traceback" not in self.words
        told = " ".join(self.err.split())
        for word in words:
            assert " ".join(word.split()) in told, self.words


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


def say(*words: object) -> Said:
    """`creak WORDS` where there is no test yet: for fixtures of a module."""
    out, err = (io.TextIOWrapper(io.BytesIO(), encoding="utf-8", newline="", write_through=True) for _ in range(2))
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(out), redirect_stderr(err):
        patch.setattr("sys.argv", ["creak", *map(str, words)])
        with pytest.raises(SystemExit) as stop:
            main()
    return Said(int(stop.value.code or 0), *(x.buffer.getvalue().decode("utf-8") for x in (out, err)))


@contextmanager
def workers_here(count: int) -> Iterator[Runner]:
    """In place of `local_workers`: jobs are run in this process, one after the other."""
    yield lambda jobs: ((job.name, job.run()) for job in jobs)


def empty_reports(monkeypatch) -> None:
    """Reports of runs have no content: to draw them takes as long as a short run."""
    monkeypatch.setattr("creak.report.html.report_text", lambda findings, _: EMPTY.format(findings.identity.id))
