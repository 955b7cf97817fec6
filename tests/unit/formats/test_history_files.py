"""Histories in punch and universal files where several points are at one node, and names that are no plain text."""

from __future__ import annotations

import numpy as np
import pytest

from creak.formats.measured.histories import Histories, write_punch, write_universal
from creak.formats.stored.results import LineRecord
from helpers_punch import punched
from helpers_uff import data_sets

TIME = np.linspace(0.0, 0.3, 4)
MOTION = np.random.default_rng(5).standard_normal((2, 3, 3)).astype(np.float32)
LINES = LineRecord(TIME[2:], MOTION, ("lid:7", "lid:9", "Tür\nlinks:7"), np.array([7, 9, 7]))


@pytest.fixture
def histories():
    force = np.arange(8.0).reshape(4, 2)
    nodes = np.array([3]), ("LID.3",), np.ones((4, 1, 6))
    return Histories(
        "reduced", "m-kg-s", TIME, *nodes, ("a:9", "b:8"), np.array([9, 8]), force, force, force, "two\nlines", LINES
    )


def test_points_at_one_node_are_numbered_and_named(histories, tmp_path):
    assert histories.renumbered == ("E-line points",)
    write_punch(histories, tmp_path / "h.pch")
    node, *lines, a, b = punched(tmp_path / "h.pch")
    assert node.after("$TITLE   =") == "two lines"
    assert node.after("$SUBTITLE=") == "written by creak: m, N, s"
    assert [x.after("$POINT ID =").split()[0] for x in lines] == ["1", "2", "3"]
    assert [x.after("$LABEL   =").split(" of ")[1] for x in lines] == ["lid:7", "lid:9", "T?r links:7"]
    for k, line in enumerate(lines):
        np.testing.assert_allclose([*line.rows], TIME[2:], rtol=5.1e-7)
        np.testing.assert_allclose(np.array([*line.rows.values()])[:, :3], MOTION[:, k], rtol=5.1e-7)
    assert [x.after("$POINT ID =").split()[0] for x in (a, b)] == ["9", "8"]
    assert np.array([*b.rows.values()])[:, 2].tolist() == [1.0, 3.0, 5.0, 7.0]


def test_the_line_is_the_entity_of_a_universal_function(histories, tmp_path):
    write_universal(histories, tmp_path / "h.unv")
    units, *functions = data_sets(tmp_path / "h.unv")
    assert float(units[1][1][:25].replace("D", "E")) == 1.0
    of = [(lines[5][30:40].strip(), int(lines[5][41:51]), int(lines[5][51:55])) for _, lines in functions]
    assert of[:3] == [("NONE", 3, 1), ("NONE", 3, 2), ("NONE", 3, 3)]
    assert of[3:6] == [("lid", 7, 1), ("lid", 7, 2), ("lid", 7, 3)]
    assert of[9:12] == [("T?r links", 7, 1), ("T?r links", 7, 2), ("T?r links", 7, 3)]
    assert of[12:] == [("NONE", 9, 0), ("NONE", 8, 0)]
    label, unit = functions[4][1][8][26:46].strip(), functions[4][1][8][47:67].strip()
    assert (label, unit) == ("Relative motion", "m")
