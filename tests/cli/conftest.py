"""The command for tests of it."""

from __future__ import annotations

import pytest

from helpers_cli import caller, empty_reports


@pytest.fixture
def creak(monkeypatch, capsys):
    """Runs `creak WORDS`; returns what it said."""
    return caller(monkeypatch, capsys)


@pytest.fixture
def no_page(monkeypatch):
    empty_reports(monkeypatch)
