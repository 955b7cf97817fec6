"""Licences, citation and package data: what a release says about itself is true."""

from __future__ import annotations

import re
import tomllib
from importlib import metadata
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
PERMISSIVE = {
    "BSD-3-Clause", "BSD-2-Clause", "MIT", "Matplotlib (PSF)", "Apache-2.0", "0BSD", "Zlib", "CC0-1.0", "PSF-2.0",
    "ISC",
}  # fmt: skip
TESTS_ONLY = {"hypothesis": "MPL-2.0"}
FAMILY = {"BSD": ("BSD",), "MIT": ("MIT",), "Apache": ("Apache",), "PSF": ("Python Software Foundation", "PSF"), "MPL": ("MPL", "Mozilla"), "ISC": ("ISC",)}
"""How the same licences are called in the metadata of packages."""


def name_of(requirement: str) -> str:
    return re.split(r"[\s\[<>=!;~]", requirement.strip(), maxsplit=1)[0].lower()


def wanted() -> dict[str, str]:
    """Package -> what needs it, from pyproject.toml."""
    found = {name_of(r): "creak" for r in PROJECT["dependencies"]}
    for extra, requirements in PROJECT["optional-dependencies"].items():
        found |= {name_of(r): f"creak[{extra}]" for r in requirements}
    return found


def told() -> dict[str, tuple[str, str]]:
    """Package -> what needs it and licence, from the table."""
    text = (ROOT / "THIRD_PARTY_LICENCES.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([\w.-]+) \| ([^|]+) \| ([^|]+) \|$", text, flags=re.MULTILINE)
    return {name: (needed.strip(), licence.strip()) for name, needed, licence in rows if name != "package"}


def installed_licence(name: str) -> str:
    """What the package says itself: an SPDX expression, else the classifier, else a word."""
    info = metadata.metadata(name)
    classifiers = [c for c in info.get_all("Classifier") or [] if c.startswith("License ::")]
    return info.get("License-Expression") or " ".join(classifiers) or (info.get("License") or "").splitlines()[0]


def test_every_direct_dependency_has_a_line_and_no_line_is_left_over():
    lines = {name: needed.split(",")[0] for name, (needed, _) in told().items()}
    assert lines == wanted()


@pytest.mark.parametrize("name", sorted(told()))
def test_the_licence_is_that_of_the_installed_package(name):
    try:
        said = installed_licence(name)
    except metadata.PackageNotFoundError:
        pytest.skip(f"{name} is not installed")
    licence = told()[name][1]
    family = next(words for key, words in FAMILY.items() if key in licence)
    assert any(word in said for word in family), f"{name}: {said}"


def test_licences_are_permissive():
    for name, (_, licence) in told().items():
        assert licence in PERMISSIVE or TESTS_ONLY.get(name) == licence


def test_extras_are_what_the_report_asks_for():
    from creak.api.extras import REPORT

    assert [name_of(r) for r in PROJECT["optional-dependencies"]["report"]] == list(REPORT)
    assert not set(REPORT) & {name_of(r) for r in PROJECT["dependencies"]}


def test_every_dependency_has_a_lower_bound():
    every = [*PROJECT["dependencies"], *(r for x in PROJECT["optional-dependencies"].values() for r in x)]
    assert [r for r in every if ">=" not in r] == []


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
        "abstract", "authors", "cff-version", "commit", "contact", "date-released", "doi", "identifiers", "keywords",
        "license", "license-url", "message", "preferred-citation", "references", "repository", "repository-artifact",
        "repository-code", "title", "type", "url", "version",
    }  # fmt: skip
    assert set(cff) <= known
    (thesis,) = cff["references"]
    assert {"authors", "title", "type"} <= thesis.keys()
    assert thesis["type"] == "thesis"
    assert [a["family-names"] for a in thesis["authors"]] == ["Valiyakath Basheer", "Godborg"]
    assert thesis["year"] == 2019
