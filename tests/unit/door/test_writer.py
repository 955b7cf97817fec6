"""The deck and the study that `write_door` writes."""

from __future__ import annotations

import math
import re
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from creak.cli.main import app
from creak.errors import InputError
from creak_thesis.door import LOAD, LOADS, write_door
from creak_thesis.door.deck import ALPHA, BETA, deck_text
from helpers_door import door


def test_writes_a_deck_and_a_study_and_nothing_else(tmp_path: Path) -> None:
    out = tmp_path / "new" / "door"
    assert write_door(40.0, out) == [out / "door.inp", out / "door.toml"]
    assert sorted(p.name for p in out.iterdir()) == ["door.inp", "door.toml"]


def test_same_text_every_time(tmp_path: Path) -> None:
    first = [p.read_bytes() for p in write_door(40.0, tmp_path / "a")]
    assert first == [p.read_bytes() for p in write_door(40.0, tmp_path / "b")]


@pytest.mark.parametrize("mesh_size", [0.0, -5.0, 1.9, 41.0, math.nan, math.inf])
def test_bad_mesh_size_is_refused_and_nothing_is_written(mesh_size: float, tmp_path: Path) -> None:
    out = tmp_path / "door"
    with pytest.raises(InputError, match=r"mesh size .* expected a number from 2 to 40"):
        write_door(mesh_size, out)
    assert not out.exists()


def test_a_file_in_place_of_the_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "door").write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match=r"door: this is a file; expected a folder"):
        write_door(40.0, tmp_path / "door")
    assert (tmp_path / "door").read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize("ratio_at", [8.0, 80.0])
def test_damping_is_two_percent_at_both_frequencies(ratio_at: float) -> None:
    omega = 2 * math.pi * ratio_at
    assert ALPHA / (2 * omega) + BETA * omega / 2 == pytest.approx(0.02)


def test_study_drives_the_upper_hinge_and_checks_the_pairs(tmp_path: Path) -> None:
    study = tomllib.loads(write_door(40.0, tmp_path)[1].read_text(encoding="utf-8"))
    assert study["model"] == {"deck": "door.inp", "units": "mm-t-s"}
    assert study["contact"]["flange"]["secondary"] == "PANEL_EDGE"
    assert study["excitation"]["hinge"]["signal"]["amplitude"] == LOADS[LOAD]
    assert study["verification"]["pairs"] == "PAIRS"


@pytest.mark.parametrize("load", LOADS)
def test_study_says_what_load_it_has(load: str, tmp_path: Path) -> None:
    text = write_door(40.0, tmp_path, load=load)[1].read_text(encoding="utf-8")
    signal = tomllib.loads(text)["excitation"]["hinge"]["signal"]
    assert signal["amplitude"] == LOADS[load]
    assert f"load {load};" in text
    # The loads of the reference: 1 Hz lines up to 100 Hz, repeated every second.
    assert (signal["f_max"], signal["period"], signal["type"]) == (100, 1.0, "multisine")


def test_loads_rise() -> None:
    assert list(LOADS) == ["A1", "A2", "A3", "A4"]
    assert list(LOADS.values()) == sorted(set(LOADS.values()))


def test_unknown_load_is_refused_and_nothing_is_written(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"load of the door: there is no load 'A5'; expected A1, A2, A3, A4"):
        write_door(40.0, tmp_path / "door", load="A5")
    assert not (tmp_path / "door").exists()


@pytest.mark.parametrize(("given", "load"), [([], LOAD), (["--load", "A4"], "A4")])
def test_command_takes_the_load(given: list[str], load: str, tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["example", "door", "--mesh-size", "40", *given, "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    study = tomllib.loads((tmp_path / "door.toml").read_text(encoding="utf-8"))
    assert study["excitation"]["hinge"]["signal"]["amplitude"] == LOADS[load]


def test_deck_defines_everything_once_and_refers_to_nothing_unknown() -> None:
    text = deck_text(door(40.0))
    node_sets = re.findall(r"^\*NSET, NSET=(\w+)", text, re.M)
    assert len(set(node_sets)) == len(node_sets)
    assert set("ABCDEFG") <= set(node_sets)
    assert len(re.findall(r"^\*COUPLING", text, re.M)) == 7 + 2 * 26
    assert len(re.findall(r"^BEAM, ", text, re.M)) == 26
    surfaces = re.findall(r"^\*SURFACE, TYPE=NODE, NAME=(\w+)\n(\w+), 1.0", text, re.M)
    assert {patch for _, patch in surfaces} <= set(node_sets)
    assert {name for name, _ in surfaces} == set(re.findall(r"SURFACE=(\w+)", text))


def test_deck_numbers_every_node_and_element_once() -> None:
    text = deck_text(door(40.0))
    blocks = re.findall(r"^\*(NODE|ELEMENT), [^\n]*\n((?:\d[^\n]*\n)+)", text, re.M)
    for kind, count in (
        ("NODE", door(40.0).n_nodes),
        ("ELEMENT", sum(p.quads.shape[0] + p.tris.shape[0] for p in door(40.0).parts)),
    ):
        labels = [line.split(",")[0] for k, body in blocks if k == kind for line in body.splitlines()]
        assert len(labels) == len(set(labels)) == count


def test_lines_are_short_enough_for_other_readers() -> None:
    lines = deck_text(door(40.0)).splitlines()
    # Abaqus: 256 characters a line, 16 entries a data line, 80 characters a label.
    assert max(map(len, lines)) <= 256
    assert max(line.count(",") for line in lines if not line.startswith("*")) <= 15
