"""The lowest versions that pyproject.toml declares, as constraints for pip: `python -m tools.lowest > FILE`.

    pip install --constraint FILE -e '.[report,cluster,dev,docs]'

installs exactly these; what they bring along is the newest that fits.
"""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path
from typing import Any

PROJECT = Path(__file__).parents[1] / "pyproject.toml"
BOUND = re.compile(r"(?P<name>[\w.-]+)(\[[\w,]+\])?>=(?P<version>[\d.]+)")
"""A requirement as pyproject.toml has them: name, extras, lowest version; then upper bounds and markers."""


def extras() -> list[str]:
    return list(_project()["optional-dependencies"])


def requirements(extra: str | None = None) -> list[str]:
    """Requirements of creak, or of one of its extras, as pyproject.toml has them."""
    project = _project()
    found: list[str] = project["dependencies"] if extra is None else project["optional-dependencies"][extra]
    return found


def _project() -> dict[str, Any]:
    found: dict[str, Any] = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]
    return found


def lowest() -> dict[str, str]:
    """Package -> lowest version, of creak and all extras.

    Raises
    ------
    ValueError : a requirement has no lower bound.
    """
    found = {}
    for requirement in (r for extra in (None, *extras()) for r in requirements(extra)):
        bound = BOUND.match(requirement)
        if bound is None:
            raise ValueError(f"pyproject.toml: {requirement!r} has no lower bound; write NAME>=VERSION")
        found[bound["name"]] = bound["version"]
    return found


if __name__ == "__main__":
    sys.stdout.writelines(f"{name}=={version}\n" for name, version in lowest().items())
