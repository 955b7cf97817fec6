"""Extras and citation: what a release says about itself is true."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def name_of(requirement: str) -> str:
    return re.split(r"[\s\[<>=!;~]", requirement.strip(), maxsplit=1)[0].lower()


def test_extras_are_what_the_report_asks_for():
    from creak.api.extras import REPORT

    assert [name_of(r) for r in PROJECT["optional-dependencies"]["report"]] == list(REPORT)
    assert not set(REPORT) & {name_of(r) for r in PROJECT["dependencies"]}


def test_citation_file_has_what_its_format_requires():
    """Citation File Format 1.2.0: required keys and the closed lists of the ones used here."""
    yaml = pytest.importorskip("yaml")
    cff = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert cff["cff-version"] == "1.2.0"
    assert {"message", "title", "authors"} <= cff.keys()
    assert cff["type"] in ("software", "dataset")
    assert cff["version"] == PROJECT["version"]
    assert cff["license"] == PROJECT["license"]
    assert cff["authors"] == [{"name": PROJECT["authors"][0]["name"]}]
    known = {
        *("abstract", "authors", "cff-version", "commit", "contact", "date-released", "doi", "identifiers"),
        *("keywords", "license", "license-url", "message", "preferred-citation", "references", "repository"),
        *("repository-artifact", "repository-code", "title", "type", "url", "version"),
    }
    assert set(cff) <= known
    (thesis,) = cff["references"]
    assert {"authors", "title", "type"} <= thesis.keys()
    assert thesis["type"] == "thesis"
    assert [a["family-names"] for a in thesis["authors"]] == ["Valiyakath Basheer", "Godborg"]
    assert thesis["year"] == 2019
