"""What a reader meets first is short, and the pages of the site are built of what is stored."""

from __future__ import annotations

import re

from helpers_docs import PAGES, ROOT, of_the_source, text_of


def test_the_readme_is_read_in_three_minutes():
    assert len(text_of(ROOT / "README.md").split()) <= 600


def test_the_changes_of_the_first_version_fit_a_page():
    assert len(text_of(of_the_source("CHANGELOG.md")).split("\n## 0.1.0")[1].split("\n## ")[0].splitlines()) <= 60


def recipe(target: str) -> str:
    found = re.search(rf"^{target}:.*\n((?:\t.*\n)+)", text_of(of_the_source("Makefile")), re.MULTILINE)
    assert found
    return found[1]


def test_docs_are_built_of_stored_figures():
    """What computes figures, benchmarks and the examples of the gallery, belongs to `make evidence`."""
    assert "mkdocs build" in recipe("docs")
    for made in ("benchmarks", "tools.gallery"):
        assert made not in recipe("docs")
        assert made in recipe("evidence")


def test_the_pages_tell_what_is_and_not_what_was():
    """No page compares the program with its own drafts: that belongs to the history of the changes."""
    for page in PAGES:
        found = re.findall(r"\(before\)|[\d.]+ \w* ?before\)|\s\(now\)|\bbefore, \d", text_of(page))
        assert not found, f"{page.name}: {found}"
