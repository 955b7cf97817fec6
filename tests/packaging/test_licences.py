"""THIRD_PARTY_LICENCES.md and what is installed agree."""

from __future__ import annotations

import re
from functools import cache
from importlib import metadata

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from tools import licences_page
from tools.licences_page import INTEL, NOT_PERMISSIVE, needed, page, told
from tools.lowest import extras, requirements

PERMISSIVE = {
    *("BSD-3-Clause", "BSD-2-Clause", "BSD", "MIT", "MIT-CMU", "Matplotlib (PSF)", "Apache-2.0"),
    *("LLVM-exception", "0BSD", "Zlib", "CC0-1.0", "PSF-2.0", "ISC", "CNRI-Python"),
}
AGAIN = "run: make licences"
WORDS = {
    "BSD": ("BSD", "Redistribution and use in source and binary forms"),
    "Matplotlib": ("Python Software Foundation",),
    "PSF": ("PSF", "Python Software Foundation"),
    "MPL": ("MPL", "Mozilla"),
}
"""Family -> what metadata may say instead of its name."""


@cache
def here() -> dict[str, str]:
    """What is needed here; the same for every test."""
    return needed()


def missing() -> set[str]:
    """Packages that creak or an extra needs here and the page lacks."""
    return set(here()) - set(told())


def roots(name: str) -> set[str]:
    """`creak` and its extras that a package comes with, by the page."""
    found: set[str] = set()
    todo, seen = [name], set()
    while todo:
        for asker in told()[todo.pop()].brought.split(", "):
            if asker.startswith("creak"):
                found.add(asker)
            elif asker not in seen:
                seen.add(asker)
                todo.append(asker)
    return found


def test_every_package_that_creak_needs_has_a_row():
    assert missing() == set(), AGAIN


def test_a_package_without_a_row_is_found(tmp_path, monkeypatch):
    """Direct ones and those that others bring."""
    lines = [r for r in told().values() if r.name not in ("numpy", "llvmlite", "iniconfig")]
    monkeypatch.setattr(licences_page, "PAGE", tmp_path / "page.md")
    licences_page.PAGE.write_text(page(lines), encoding="utf-8")
    assert missing() == {"numpy", "llvmlite", "iniconfig"}
    assert {r.name for r in licences_page.rows()} >= {"numpy", "llvmlite", "iniconfig"}


def test_what_creak_asks_for_itself_is_told_so_and_nothing_else():
    wanted = {}
    for extra in (None, *extras()):
        for text in requirements(extra):
            wanted.setdefault(
                canonicalize_name(Requirement(text).name), "creak" if extra is None else f"creak[{extra}]"
            )
    assert {n: r.brought for n, r in told().items() if r.brought.startswith("creak")} == wanted, AGAIN


def test_no_row_is_left_of_a_package_that_is_here_and_not_needed():
    left = [
        n for n in set(told()) - set(here()) if any(canonicalize_name(d.name) == n for d in metadata.distributions())
    ]
    assert left == [], "delete these rows"


def test_every_row_leads_back_to_creak():
    assert [name for name in told() if not roots(name)] == []


@pytest.mark.parametrize("name", sorted(told()))
def test_the_licence_is_that_of_the_installed_package(name):
    """Its family: how a package words it changes from release to release."""
    if name not in here():
        pytest.skip(f"{name} is not needed here")
    family = re.split(r"[-\s(]", told()[name].licence)[0]
    info = metadata.metadata(name)
    classifiers = [c for c in info.get_all("Classifier") or [] if c.startswith("License ::")]
    said = " ".join([info.get("License-Expression") or "", *classifiers, info.get("License") or ""])
    assert any(words in said for words in WORDS.get(family, (family,))), f"{name}: {said}; {AGAIN}"


def test_licences_are_permissive_but_for_those_that_the_page_names():
    for name, row in told().items():
        if name in INTEL:
            assert row.licence.startswith("Intel ")
        elif name in NOT_PERMISSIVE:
            assert row.licence == NOT_PERMISSIVE[name][0]
        else:
            assert set(re.split(" AND | OR | WITH ", row.licence)) <= PERMISSIVE, f"{name}: {row.licence}"


@pytest.mark.parametrize("name", sorted(set(NOT_PERMISSIVE) & set(told())))
def test_copyleft_comes_with_tools_of_developers_alone(name):
    assert roots(name) <= {"creak[dev]", "creak[docs]"}


def test_the_page_is_as_its_tool_writes_it():
    assert licences_page.PAGE.read_text(encoding="utf-8") == page(list(told().values())), AGAIN
