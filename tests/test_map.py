"""ARCHITECTURE.md and the tree agree: rooms, files, and the way of the data of each command."""

from __future__ import annotations

import importlib
import pkgutil
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import typer

import creak
import creak_thesis
from creak.cli.main import app
from creak.formats.measured.uff import write_uff
from helpers_cli import caller
from helpers_decks import STUDY, write_strips
from helpers_frfs import function

SRC = Path(creak.__file__).parent
HOMES = (SRC, Path(creak_thesis.__file__).parent)
PAGE = (Path(__file__).parents[1] / "ARCHITECTURE.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| `creak (\w+)` \| (.*) \|$", PAGE, re.MULTILINE)
WAYS = {command: re.findall(r"`([\w/]+\.py)`", files) for command, files in ROWS}
SCATTER = STUDY.replace("step = 5e-4\nperiods = 2", "end = 0.01") + (
    '[scatter.vary]\n"contact.tip.clearance" = { type = "uniform", low = 0.0, high = 0.2 }\n'
)
SHORT = STUDY.replace("periods = 2", "end = 0.02\n[reference]\nrun = false\n")


def rooms_of(heading: str) -> list[str]:
    """Folders of the first column of the table below a line."""
    table = PAGE[PAGE.index(heading) :].split("\n\n")[1]
    return [
        name.rstrip("/")
        for cells in re.findall(r"^\| (`.*?) \|", table, re.MULTILINE)
        for name in re.findall(r"`(.*?)`", cells)
    ]


def folders(folder: Path) -> set[str]:
    return {p.name for p in folder.iterdir() if any(p.glob("*.py"))}


def test_every_room_is_on_the_map_and_there():
    assert sorted(rooms_of("## The rooms")) == sorted(folders(SRC))
    assert sorted(rooms_of("`studies/` has rooms of its own")) == sorted(folders(SRC / "studies"))
    assert sorted(rooms_of("`src/creak_thesis` is a package")) == sorted(folders(HOMES[1]))


def test_tests_lie_in_the_rooms_of_what_they_test():
    tests = Path(__file__).parent / "unit"
    assert folders(tests) - {"benches", "cockpit", "door", "thesis"} <= folders(SRC)
    assert folders(tests / "studies") <= folders(SRC / "studies")


def test_every_command_has_its_way():
    assert set(WAYS) == set(typer.main.get_command(app).commands)


def test_every_file_on_the_map_is_there():
    named = {*re.findall(r"`([\w/]+\.py)`", PAGE), *(f for way in WAYS.values() for f in way)}
    # Short names stand in a row that names their folder.
    roots = (SRC, SRC.parent, SRC.parents[1])
    missing = [n for n in named if "/" in n and not any((root / n).exists() for root in roots)]
    assert missing == []


# --- the ways -------------------------------------------------------------------------------------------------------


HERE = tuple(f"{home}/" for home in HOMES)


def named(file: Path) -> str:
    """As the map writes it: below creak, or below src."""
    return file.relative_to(SRC if SRC in file.parents else SRC.parent).as_posix()


@contextmanager
def called() -> Iterator[list[str]]:
    """Files of creak in the order in which a function of each was first called."""
    files: dict[str, None] = {}

    def look(frame, event, _):
        code = frame.f_code
        if event == "call" and code.co_flags & 1 and code.co_filename.startswith(HERE):  # no class, no module
            files.setdefault(code.co_filename)

    found: list[str] = []
    sys.setprofile(look)
    try:
        yield found
    finally:
        sys.setprofile(None)
        found += [named(Path(f)) for f in files]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two strips; every module is imported before, so that no call of an import counts."""
    for package in (creak, creak_thesis):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            importlib.import_module(module.name)
    folder = tmp_path_factory.mktemp("ways")
    write_strips(folder, study=SHORT)
    (folder / "scatter.toml").write_text(SCATTER)
    modes = creak.deck_modes(folder / "strips.inp", count=2)
    test, tip = folder / "test.unv", int(np.abs(next(modes.translations())[:, 2]).argmax())
    write_uff(test, modes.model, modes.frequencies, modes.translations())
    end = (int(modes.model.nodes.ids[tip]), 3)
    freq = np.linspace(0.1, 0.9, 9) * modes.frequencies[-1]
    test.write_bytes(test.read_bytes() + function(np.ones(9) + 0j, end, end, freq=freq, labels=("mm/s^2", "N")))
    (folder / "sweep.toml").write_text('base = "study.toml"\nseeds = [1]\n')
    return folder


COMMANDS = {
    "new": ["new", "strips.inp", "--out", "made.toml"],
    "run": ["run", "study.toml", "--out", "out"],
    "report": ["report", "out"],
    "compare": ["compare", "out", "out2"],
    "advise": ["advise", "study.toml"],
    "robust": ["robust", "scatter.toml", "--n", "4", "--no-indices", "--threads", "1"],
    "reduce": ["reduce", "study.toml"],
    "info": ["info", "strips.inp"],
    "modes": ["modes", "strips.inp", "--count", "2", "--vtk", "modes.vtu", "--test", "test.unv", "--page", "page.html"],
    "update": [
        *("update", "study.toml", "--test", "test.unv", "--parameter", "section.LOWER.thickness"),
        *("--page", "u.html"),
    ],
    "convert": ["convert", "strips.inp", "strips.bdf", "--mass", "linear"],
    "schema": ["schema"],
    "example": ["example", "door", "--mesh-size", "40", "--out", "door"],
}
"""`sweep` runs in other processes, `thesis` for minutes, `listen` wants a run that is long enough to be heard."""


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_data_go_the_way_of_the_map(command, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    say = caller(monkeypatch, capsys)
    for result in {"out", "out2"} & set(COMMANDS[command]) if command != "run" else ():
        if not (folder / result).exists():
            assert say("run", "study.toml", "--out", result).status == 0
    with called() as files:
        said = say(*COMMANDS[command])
    assert said.status == 0, said.err
    way = WAYS[command]
    assert [f for f in files if f in way] == way
