"""E-lines from files as pre-processors and spreadsheets write them, and files that cannot be used."""

from __future__ import annotations

import numpy as np
import pytest

from creak.errors import InputError
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from helpers_decks import STUDY, two_strips, write_strips

GAP = 0.3
LINE = '\n[eline.a]\npoints = "lines.csv"\n'
SIDES = f'{LINE}main = "TIP_LOWER"\nsecondary = "TIP_UPPER"\n'
"""Nodes 13 and 39 of the upper strip lie above 1013 and 1039 of the lower one, at x = 120 and y = 0 and 20."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("files")
    write_strips(folder, two_strips(GAP), STUDY)
    return folder


def made(folder, data, more=LINE):
    (folder / "lines.csv").write_bytes(data if isinstance(data, bytes) else data.encode())
    (folder / "study.toml").write_text(STUDY + more)
    e = set_up(read_study(folder / "study.toml")).watch.lines
    mine = e.line_of == [line.name for line in e.lines].index("a")
    keep = np.flatnonzero(mine)
    return e.points.select(keep), e.frames[keep]


@pytest.fixture(scope="module")
def heights(folder):
    """z of the lower and of the upper nodes."""
    nodes = set_up(read_study(folder / "study.toml")).model.nodes
    return [float(nodes.coords[nodes.ids.tolist().index(i), 2]) for i in (1013, 13)]


def places(heights, form="{:g},{:g},{:g},{:g},{:g},{:g}", scale=1.0):
    low, high = heights
    rows = [(120.0, y, low, 120.0, y, high) for y in (0.0, 20.0)]
    return [form.format(*(scale * x for x in row)) for row in rows]


def test_pairs_of_nodes_by_many_names(folder):
    expected, frames = made(folder, "main,secondary\n1013,13\n1039,39\n")
    assert [name.split(":")[1] for name in expected.names] == ["13", "39"]
    for text in (
        "node1,node2\n1013,13\n1039,39\n",
        "\ufeffID;Node 1;Node 2;Part\n13;1013;13;LID\n39;1039;39;LID\n",
        "# exported by a pre-processor, 3 columns\n\n# No\tNode_A\tNode_B\n13\t1013\t13\n# the end\n39\t1039\t39\n",
        'export, with "a quote\nname,slave node,master node\n"13","13","1013"\n39,39,1039\n\n',
    ):
        points, turned = made(folder, text)
        assert points.names == expected.names, text
        assert points.nodes_idx.tolist() == expected.nodes_idx.tolist()
        np.testing.assert_array_equal(points.gap0, expected.gap0)
        np.testing.assert_array_equal(turned, frames)
    utf16 = "Name\tN1\tN2\r\n13\t1013\t13\r\n39\t1039\t39\r\n".encode("utf-16")
    latin = "Länge;Knoten oben;Knoten unten\n1;13;1013\n2;39;1039\n".encode("latin-1")
    named = f'{LINE}columns = {{ main = "Knoten unten", secondary = "knoten  oben" }}\n'
    for data, more in ((utf16, LINE), (latin, named)):
        points, _ = made(folder, data, more)
        assert points.names == expected.names
        np.testing.assert_array_equal(points.gap0, expected.gap0)


def test_pairs_of_places_in_any_unit_and_with_decimal_commas(folder, heights):
    expected, frames = made(folder, "main,secondary\n1013,13\n1039,39\n")
    comma = [row.replace(".", ",") for row in places(heights, ";".join(["{:.6f}"] * 6))]
    metres = places(heights, "\t".join(["{:.9g}"] * 6), 1e-3)
    inches = places(heights, ";".join(["{:.9g}"] * 6), 1.0 / 25.4)
    for rows in (
        ["x1,y1,z1,x2,y2,z2", *places(heights)],
        ["X1 [mm];Y1 [mm];Z1 [mm];X2 [mm];Y2 [mm];Z2 [mm]", *comma],
        ["x1 [in];y1 [in];z1 [in];x2 [in];y2 [in];z2 [in]", *inches],
        ["x1 [inch];y1 (Inches);z1 [in];x2 [inch];y2 [inch];z2 [inch]", *inches],
        ["units: inch", "x1;y1;z1;x2;y2;z2", *inches],
        ["units in mm", "x1;y1;z1;x2;y2;z2", *places(heights, ";".join(["{:g}"] * 6))],
        ["Units;m;kg;s", "node1_x\tnode1_y\tnode1_z\tnode2_x\tnode2_y\tnode2_z", *metres],
        ["xa_m\tya_m\tza_m\txb (m)\tyb (m)\tzb (m)", *metres],
        ["x1\ty1\tz1\tx2\ty2\tz2", "\t".join(["m"] * 6), *metres],
    ):
        for more in (LINE, SIDES):
            points, turned = made(folder, "\n".join(rows), more)
            assert points.names == expected.names, rows[0]
            np.testing.assert_array_equal(points.gap0, expected.gap0)
            np.testing.assert_array_equal(turned, frames)


def test_places_along_a_line_in_metres(folder):
    points, _ = made(folder, "Nr;x [m];y [m];z [m]\n1;0,12;0;0,001\n2;0,12;0,02;0,001\n", SIDES)
    assert [name.split(":")[1] for name in points.names] == ["13", "39"]


def test_ids_name_the_points_and_directions_turn_them(folder):
    head = "id,node1,node2,direction\n"
    points, frames = made(folder, f"{head}lock,1013,13,\nlock,1039,39,z\n")
    assert points.names == ("a:lock:13", "a:lock:39")
    plain = frames[:, 2]
    for down in ("-z", "(0 0 -2)", '"0,0,-1"'):
        with pytest.raises(InputError, match=r"lines.csv:2: node 13 lies \S+ mm behind its main node"):
            made(folder, f"{head}lock,1013,13,{down}\n")
    # An axis without a sign leads from the main to the secondary side, whichever way that is.
    _, frames = made(folder, f"{head}p,13,1013,Z\nq,1039,39,+z\n")
    np.testing.assert_allclose(frames[:, 2], [-plain[0], plain[1]], atol=1e-12)
    points, frames = made(folder, "nx;ny;nz;node1;node2\n0,6;0;0,8;1013;13\n;;;1039;39\n")
    np.testing.assert_allclose(frames[:, 2], [[0.6, 0.0, 0.8], plain[1]], atol=1e-12)
    assert points.gap0[0] == pytest.approx(0.8 * points.gap0[1], rel=1e-12)


PAIR = "x1,y1,z1,x2,y2,z2\n"
WRONG = {
    "other columns": ("a;b\n1;2\n", LINE, ["lines.csv:1", "a;b", "x1,y1,z1,x2,y2,z2", "columns"]),
    "a column is not there": (
        "a;b\n1;2\n",
        f'{LINE}columns = {{ main = "a", secondary = "c" }}\n',
        ["study.toml", "eline.a.points", "'a', 'c'"],
    ),
    "one side": ("node1,part\n13,LID\n", LINE, ["lines.csv:1", "node1,part"]),
    "one meaning": ("node1,n1,node2\n13,13,1013\n", LINE, ["lines.csv:1", "'node1' and 'n1'", "columns = { main"]),
    "no rows": ("top\nnode1,node2\n\n", LINE, ["lines.csv", "no rows"]),
    "unknown node": ("top\n\nid;node1;node2\n1;13;99999\n", LINE, ["lines.csv:4", "'99999'"]),
    "decimal commas between commas": (f"{PAIR}120,0,0,5,120,0,1,5\n", LINE, ["lines.csv:2", "8 cells", "semicolons"]),
    "no number": (f"{PAIR}120,0,here,120,0,1\n", LINE, ["lines.csv:2", "120,0,here", "three finite numbers: x1,y1,z1"]),
    "infinite": (f"{PAIR}120,0,inf,120,0,1\n", LINE, ["lines.csv:2"]),
    "off the mesh": (f"{PAIR}0.12,0,5,0.12,0,5.0018\n", LINE, ["lines.csv:2", "no node within", "x1 [mm]"]),
    "feet": ("x1 [ft];y1;z1;x2;y2;z2\n1;2;3;4;5;6\n", LINE, ["lines.csv:1", "'ft'", "um, mm, cm, m, in"]),
    "declared feet": (f"Units: ft\n{PAIR}1,2,3,4,5,6\n", LINE, ["lines.csv:2", "'ft'"]),
    "no direction": ("node1,node2,dir\n1013,13,up\n", LINE, ["lines.csv:2", "'up'", "-z"]),
    "half a direction": ("node1,node2,nx,ny,nz\n1013,13,1,,0\n", LINE, ["lines.csv:2", "'1 0'"]),
    "two directions": (
        "node1,node2,dir\n1013,13,z\n",
        f"{LINE}normal = [0, 0, 1]\n",
        ["study.toml", "Leave out normal"],
    ),
    "directions of places": ("x,y,z,dir\n120,0,1,z\n", SIDES, ["study.toml", "directions of pairs"]),
    "one place": ("node1,node2\n13,13\n", LINE, ["lines.csv:2", "one place"]),
    "columns of no file": ("", '\n[eline.a]\ncolumns = { main = "a" }\n', ["eline.a", "columns are those of a file"]),
    "no such column": ("", f'{LINE}columns = {{ master = "a" }}\n', ["eline.a.columns", "master"]),
    "a quote": ('node1,node2\n"13,1013\n' + "x" * 140_000, LINE, ["lines.csv:3", "quote"]),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_file_is_one_message(folder, case):
    text, more, words = WRONG[case]
    with pytest.raises(InputError, match=r"\w") as error:
        made(folder, text, more)
    for word in words:
        assert word in str(error.value)


def test_nodes_in_one_place_are_told_apart_by_the_sides(tmp_path):
    """Middle surfaces that coincide: nodes of both strips lie at each point."""
    text = STUDY.replace('main = "OVER"\n', 'main = "OVER"\nclearance = 0.3\n')
    write_strips(tmp_path, two_strips(-1.25), text)
    (tmp_path / "lines.csv").write_text("x1,y1,z1,x2,y2,z2\n120,0,0,120,0,0\n")
    for more, words in ((LINE, "both lie at .*Give main and secondary"), (SIDES, "one place.*Give normal")):
        (tmp_path / "study.toml").write_text(text + more)
        with pytest.raises(InputError, match=rf"lines\.csv:2: .*{words}"):
            set_up(read_study(tmp_path / "study.toml"))
    (tmp_path / "study.toml").write_text(f"{text}{SIDES}normal = [0, 0, 1]\nclearance = 0.3\n")
    e = set_up(read_study(tmp_path / "study.toml")).watch.lines
    assert [name for name in e.points.names if name.startswith("a:")] == ["a:13"]
    assert e.points.gap0[-1] == 0.3
