"""What tells one creak from another."""

from __future__ import annotations

import os

from creak import version


def test_the_edition_of_a_source_tree_changes_with_its_files(tmp_path, monkeypatch):
    here = tmp_path / "src" / "creak"
    here.mkdir(parents=True)
    (here / "version.py").write_text("", encoding="utf-8")
    monkeypatch.setattr(version, "__file__", str(here / "version.py"))
    edition = version.edition.__wrapped__
    assert edition() == version.version()  # installed: no sources of its own
    (tmp_path / "pyproject.toml").write_text("", encoding="utf-8")
    before = edition()
    assert before.startswith(version.version())
    os.utime(here / "version.py", (1e9, 1e9))
    assert edition() != before
