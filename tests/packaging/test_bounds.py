"""The versions that pyproject.toml declares are those that are tested."""

from __future__ import annotations

import os
import re
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
from tools.lowest import extras, lowest, requirements

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
UPPER = {"mkdocs": "2 drops the plugins and themes that the site is made with"}
"""Packages with an upper bound, and the break that asks for it."""
BROKEN = {
    "typer": ((0, 18), "every command ends in a traceback"),
    "scipy": (
        (1, 13, 0),
        "eigh of a 1 x 1 matrix fails; before 1.12 no eye_array, wrong connected_components in 1.11.2",
    ),
}
"""Versions known not to work, with what happens there; the bound lies above."""
TESTED = os.environ.get("CREAK_TESTED", "")
"""`lowest` or `newest`, as the Makefile says what it installed; empty elsewhere."""


def numbers(version: str) -> tuple[int, ...]:
    return tuple(int(n) for n in re.findall(r"\d+", version)[:3])


def every() -> list[str]:
    return [r for extra in (None, *extras()) for r in requirements(extra)]


def test_every_dependency_has_a_lower_bound_that_names_a_release():
    """Three numbers: `8` is not a version that pip could be asked for."""
    assert len(lowest()) == len(every())
    assert [v for v in lowest().values() if not re.fullmatch(r"\d+\.\d+\.\d+", v)] == []


def test_upper_bounds_are_those_of_known_breaks():
    capped = [r for r in every() if re.search("<|==|!=|~=", r.split(";")[0])]
    assert {re.split(r"\W", r)[0] for r in capped} == set(UPPER)


@pytest.mark.parametrize("name", sorted(BROKEN))
def test_lower_bounds_lie_above_known_breaks(name):
    version, what = BROKEN[name]
    assert numbers(lowest()[name]) > version, what


@pytest.mark.skipif(TESTED != "lowest", reason="for make test-lowest")
def test_the_lowest_versions_are_installed():
    optional = set(lowest()) - {
        re.split(r"\W", r)[0] for extra in (None, "report", "cluster", "dev") for r in requirements(extra)
    }
    found = {name: metadata.version(name) for name in lowest() if name not in optional and is_installed(name)}
    assert {name: numbers(version) for name, version in found.items()} == {
        name: numbers(lowest()[name]) for name in found
    }
    assert len(found) >= len(every()) - len(optional) - 1  # no pypardiso beside x86-64


def is_installed(name: str) -> bool:
    try:
        metadata.version(name)
    except metadata.PackageNotFoundError:
        return False
    return True


def test_pythons_told_are_those_that_ci_tests():
    """Classifiers, README and .ci/run name the same versions of Python."""
    told = re.findall(r"Python :: (3\.\d+)", " ".join(PROJECT["classifiers"]))
    assert PROJECT["requires-python"] == f">={told[0]}"
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert f"Tested on Python {told[0]} to {told[-1]}" in readme
