"""The wheel and the sdist hold all that creak needs; built from a copy of the tree, without the network."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import sys
import tarfile
import zipfile
from importlib import metadata
from pathlib import Path

import pytest

pytestmark = [pytest.mark.slow, pytest.mark.once]

ROOT = Path(__file__).parents[2]
META = (
    *("pyproject.toml", "MANIFEST.in", "README.md", "LICENSE", "THIRD_PARTY_LICENCES.md", "CITATION.cff"),
    *("ARCHITECTURE.md", "CHANGELOG.md", "CONTRIBUTING.md", "Makefile"),
)
LEFT_OUT = ("__pycache__", "*.pyc", "*.nbi", "*.nbc", "*.egg-info")


def can_build() -> str:
    """Why no wheel can be built here; empty where one can."""
    if importlib.util.find_spec("build") is None:
        return "build is not installed (pip install 'creak[dev]')"
    major = int(metadata.version("setuptools").split(".")[0])
    return "" if major >= 77 else f"setuptools {major} is older than 77 (pip install 'creak[dev]')"


@pytest.fixture(scope="module")
def built(tmp_path_factory) -> Path:
    """Folder with a wheel and an sdist."""
    if why := can_build():
        pytest.skip(why)
    tree, out = tmp_path_factory.mktemp("tree"), tmp_path_factory.mktemp("dist")
    shutil.copytree(ROOT / "src", tree / "src", ignore=shutil.ignore_patterns(*LEFT_OUT))
    shutil.copytree(ROOT / "examples", tree / "examples", ignore=shutil.ignore_patterns(*LEFT_OUT))
    for name in META:
        shutil.copy(ROOT / name, tree / name)
    command = [sys.executable, "-m", "build", "--no-isolation", "--sdist", "--wheel", "--outdir", str(out), str(tree)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return out


def sources() -> set[str]:
    """Files below src, caches left out."""
    found = (p for package in ("creak", "creak_thesis") for p in (ROOT / "src" / package).rglob("*") if p.is_file())
    return {
        p.relative_to(ROOT / "src").as_posix()
        for p in found
        if "__pycache__" not in p.parts and p.suffix not in (".pyc", ".nbi", ".nbc")
    }


def test_the_wheel_holds_every_source_and_data_file_and_nothing_else(built):
    (wheel,) = built.glob("*.whl")
    with zipfile.ZipFile(wheel) as file:
        names = set(file.namelist())
    inside = {n for n in names if not n.split("/")[0].endswith(".dist-info")}
    assert inside == sources()
    assert {".py", ".j2", ".js", ".css", ".toml", ".json", ".typed"} >= {Path(n).suffix or Path(n).name for n in inside}


def test_the_wheel_says_who_what_and_under_which_licence(built):
    (wheel,) = built.glob("*.whl")
    with zipfile.ZipFile(wheel) as file:
        (name,) = (n for n in file.namelist() if n.endswith(".dist-info/METADATA"))
        text = file.read(name).decode()
        (entry,) = (n for n in file.namelist() if n.endswith("entry_points.txt"))
        assert "creak = creak.cli.main:main" in file.read(entry).decode()
        licences = {Path(n).name for n in file.namelist() if "/licenses/" in n}
    assert "License-Expression: BSD-3-Clause" in text
    assert licences == {"LICENSE", "THIRD_PARTY_LICENCES.md"}
    assert "Provides-Extra: report" in text
    assert 'Requires-Dist: plotly>=5.20.0; extra == "report"' in text


def test_the_sdist_holds_what_it_takes_to_build_cite_and_try(built):
    (sdist,) = built.glob("*.tar.gz")
    with tarfile.open(sdist) as file:
        names = {n.split("/", 1)[1] for n in file.getnames() if "/" in n}
    assert {f"src/{n}" for n in sources()} <= names
    assert set(META) <= names
    assert {"examples/door.py", "examples/two_strips.py"} <= names
    assert not [n for n in names if "__pycache__" in n]
