"""THIRD_PARTY_LICENCES.md from what is installed: `python -m tools.licences_page`.

Every package that creak or one of its extras asks for, and what those ask for in turn, is a row. Which they are differs
with platform, Python and date: rows of packages that are not installed here are kept (delete what nothing needs any
more), so run it in each environment that counts; `make licences` does.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from tools.lowest import extras, requirements

PAGE = Path(__file__).parents[1] / "THIRD_PARTY_LICENCES.md"
ROW = re.compile(r"^\| (?P<name>[\w.-]+) \| (?P<brought>[^|]+) \| (?P<licence>[^|]+) \|$", re.MULTILINE)
SPDX = {
    "BSD License": "BSD",
    "MIT License": "MIT",
    "Apache Software License": "Apache-2.0",
    "ISC License (ISCL)": "ISC",
    "Mozilla Public License 2.0 (MPL 2.0)": "MPL-2.0",
    "Apache 2.0": "Apache-2.0",
    "ISC License": "ISC",
    "Python Software Foundation License": "PSF-2.0",
}
"""How packages that have no SPDX expression call the same licences."""
FROM_THE_FILE = {
    "contourpy": "BSD-3-Clause",
    "cycler": "BSD-3-Clause",
    "jinja2": "BSD-3-Clause",
    "kiwisolver": "BSD-3-Clause",
    "numba": "BSD-2-Clause",
    "partd": "BSD-3-Clause",
    "scipy": "BSD-3-Clause",
    "colorama": "BSD-3-Clause",
    "zict": "BSD-3-Clause",
    "pypardiso": "BSD-3-Clause",
    "matplotlib": "Matplotlib (PSF)",
    "umf": "Apache-2.0 WITH LLVM-exception",
    "intel-openmp": "Intel EULA for Developer Tools",
    "intel-cmplr-lib-ur": "Intel EULA for Developer Tools",
}
"""Packages whose metadata say only BSD, another family or the whole text; read from the licence that they install."""
NOT_PERMISSIVE = {
    "hypothesis": ("MPL-2.0", "runs the tests"),
    "certifi": ("MPL-2.0", "is fetched with the documentation's tools"),
    "pathspec": ("MPL-2.0", "is fetched with the documentation's tools and the type checker"),
}
"""File-level copyleft, and what such a package is for; none of it is distributed with creak."""
INTEL = ("mkl", "tbb", "tcmlib", "intel-openmp", "intel-cmplr-lib-ur")
HEAD = """\
# Licences of what creak uses

creak itself is BSD-3-Clause ([LICENSE](LICENSE)). It contains no code of others; pip installs these packages beside it.
All are permissive, but for those that the notes below name. `make licences` makes this page from what is installed; a
package that is not needed on every platform, Python or release of another package has its row too.

| package | comes with | licence |
|---|---|---|
"""
TAIL = """
{notes}
- `pypardiso`, on x86-64 only, loads Intel oneMKL, which pip installs as packages of its own ({intel})
  under licences of Intel: free to use and redistribute, not open source. Without it creak solves with SuperLU, which
  comes with SciPy.
- Where `report.html` draws with plotly, it contains plotly.js (MIT), so that it opens offline.
"""


@dataclass(frozen=True)
class Row:
    """A package of the table."""

    name: str
    """Lower case, words joined by hyphens."""
    brought: str
    """`creak`, `creak[EXTRA]`, or the packages that ask for it."""
    licence: str


def needed() -> dict[str, str]:
    """Package -> what asks for it, of all that is installed and creak or an extra needs, here and now."""
    direct: dict[str, str] = {}
    askers: dict[str, set[str]] = {}
    todo = []
    for extra in (None, *extras()):
        for one in map(Requirement, requirements(extra)):
            direct.setdefault(canonicalize_name(one.name), "creak" if extra is None else f"creak[{extra}]")
            todo.append(one)
    done = set()
    while todo:
        one = todo.pop()
        name = canonicalize_name(one.name)
        for asked in _asked_by(one):
            askers.setdefault(canonicalize_name(asked.name), set()).add(name)
            if str(asked) not in done:
                done.add(str(asked))
                todo.append(asked)
    installed = {name for name in {*direct, *askers} if _is_installed(name)}
    return {name: direct.get(name) or ", ".join(sorted(askers[name])) for name in installed}


def _asked_by(requirement: Requirement) -> Iterator[Requirement]:
    """What an installed package, with the extras of the requirement, asks for here."""
    if not _is_installed(requirement.name):
        return
    for text in metadata.requires(requirement.name) or []:
        asked = Requirement(text)
        if asked.marker is None or any(asked.marker.evaluate({"extra": e}) for e in ("", *requirement.extras)):
            yield asked


def _is_installed(name: str) -> bool:
    try:
        metadata.distribution(name)
    except metadata.PackageNotFoundError:
        return False
    return True


def licence_of(name: str) -> str:
    """SPDX expression of an installed package, as near as its metadata say it."""
    if name in FROM_THE_FILE:
        return FROM_THE_FILE[name]
    info = metadata.metadata(name)
    if expression := info.get("License-Expression"):
        return str(expression)
    words = [c.split(" :: ")[-1] for c in info.get_all("Classifier") or [] if c.startswith("License ::")]
    line = str(info.get("License") or "").strip().split("\n")[0]
    family = SPDX.get(words[0], "") if words else ""
    exact = SPDX.get(line, line)
    if family and not (exact.startswith(family) and " " not in exact):
        return family
    return exact or "not said"


def told() -> dict[str, Row]:
    """The rows of the page as it is."""
    rows = (Row(m["name"], m["brought"], m["licence"]) for m in ROW.finditer(PAGE.read_text(encoding="utf-8")))
    return {row.name: row for row in rows if row.name != "package"}


def rows() -> list[Row]:
    """Rows of what is installed here, and those told of what is not; what creak asks for itself comes first."""
    here = {name: Row(name, brought, licence_of(name)) for name, brought in needed().items()}
    away = {name: row for name, row in told().items() if name not in here and not _is_installed(name)}
    order = ["creak", *(f"creak[{extra}]" for extra in extras())]
    return sorted(
        {**here, **away}.values(),
        key=lambda r: (order.index(r.brought) if r.brought in order else len(order), r.name),
    )


def page(lines: list[Row]) -> str:
    names = {row.name for row in lines}
    notes = [
        f"- `{name}` ({licence}, file-level copyleft) {purpose}; nothing of it is distributed with creak."
        for name, (licence, purpose) in NOT_PERMISSIVE.items()
        if name in names
    ]
    intel = ", ".join(f"`{name}`" for name in INTEL if name in names)
    table = "\n".join(f"| {r.name} | {r.brought} | {r.licence} |" for r in lines)
    return HEAD + table + "\n" + TAIL.format(notes="\n".join(notes), intel=intel)


if __name__ == "__main__":
    PAGE.write_text(page(rows()), encoding="utf-8")
