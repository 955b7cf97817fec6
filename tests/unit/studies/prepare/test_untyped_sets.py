"""Nastran sets whose numbers are those of grids and of elements: what a contact takes of them."""

from __future__ import annotations

import pytest

from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import Setup, set_up

CASE = 'SPC = 1\nSET 5 = 11, 12\n$HMSET 5 1 "rim"\nSET 6 = 1\n'
BULK = """\
GRID,1
GRID,2,,2.
GRID,3,,2.,2.
GRID,4,,,2.
GRID,11,,,,.5
GRID,12,,1.,,.5
GRID,13,,1.,1.,.5
GRID,14,,,1.,.5
CQUAD4,1,1,1,2,3,4
CQUAD4,11,1,11,12,13,14
PSHELL,1,1,.1,1,,1
MAT1,1,2.+5,,.3,6.
SPC1,1,123456,1,2,3,4
SPC1,1,123456,11,12,13,14
SET3,8,GRID,11,12,13
SET3,9,ELEM,11
"""
STUDY = """[model]
deck = "deck.bdf"
units = "m-kg-s"
[damping]
modal = 0.02
[contact.c]
secondary = "{secondary}"
main = "{main}"
method = "{method}"
[eline.l]
secondary = "{secondary}"
main = "{main}"
[support.base]
nodes = "SPC_1"
free = ["z"]
[excitation.base]
node_set = "SPC_1"
dof = "z"
kind = "acceleration"
signal = {{ type = "sine", frequency = 1.0, amplitude = 1.0 }}
[time]
end = 0.1
[output]
nodes = ["SET_8"]
"""


def ready(folder, secondary: str, main: str, method: str) -> Setup:
    (folder / "deck.bdf").write_text(f"SOL 103\nCEND\n{CASE}BEGIN BULK\n{BULK}ENDDATA\n", encoding="utf-8")
    text = STUDY.format(secondary=secondary, main=main, method=method)
    (folder / "study.toml").write_text(text, encoding="utf-8")
    return set_up(read_study(folder / "study.toml"))


def said(setup: Setup, table: str, key: str) -> list[str]:
    return [n for n in setup.notes if table in n and f"{key}: the numbers of" in n]


@pytest.mark.parametrize("name", ["SET_5", "rim"])
def test_nodes_are_taken_where_the_method_takes_nodes(tmp_path, name):
    """Its grids are two corners of the plate, its element has four."""
    setup = ready(tmp_path, name, "SET_6", "node-to-surface")
    touching = setup.model.nodes.ids[setup.contacts.nodes_idx].tolist()
    assert touching == [11, 12]
    (note,) = said(setup, "[contact.c]", "secondary")
    assert f"'{name}'" in note
    assert "its nodes are taken" in note
    (note,) = said(setup, "[contact.c]", "main")
    assert "its elements are taken" in note
    points = setup.watch.lines.points.nodes_idx[[group == "l" for group in setup.watch.lines.points.group]]
    assert setup.model.nodes.ids[points].tolist() == [11, 12]
    assert len(said(setup, "[eline.l]", "secondary")) == 1


def test_elements_are_taken_where_the_method_takes_facets(tmp_path):
    setup = ready(tmp_path, "SET_5", "SET_6.SPOS", "surface-to-surface")
    assert sorted(setup.model.nodes.ids[setup.contacts.nodes_idx].tolist()) == [11, 12, 13, 14]
    (note,) = said(setup, "[contact.c]", "secondary")
    assert "its elements are taken" in note
    assert not said(setup, "[contact.c]", "main")


@pytest.mark.parametrize(("name", "grids"), [("SET_8", [11, 12, 13]), ("SET_9", [11, 12, 13, 14])])
def test_sets_of_a_kind_are_taken_as_they_are(tmp_path, name, grids):
    setup = ready(tmp_path, name, "SET_6.SPOS", "node-to-surface")
    assert setup.model.nodes.ids[setup.contacts.nodes_idx].tolist() == grids
    assert not said(setup, "[contact.c]", "secondary")
