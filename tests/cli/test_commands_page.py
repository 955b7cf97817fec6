"""docs/commands.md says what the command line says."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def test_the_page_is_up_to_date():
    path = ROOT / "tools" / "commands_page.py"
    if not path.exists():
        pytest.skip("tools/ belongs to the source tree")
    spec = importlib.util.spec_from_file_location("commands_page", path)
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    assert made.PAGE.read_text(encoding="utf-8") == made.page(), "run: python -m tools.commands_page"
