"""Abaqus and CalculiX matrix files as those programs write them."""

from __future__ import annotations

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.matrices.checks import dense
from creak.formats.matrices.superelements import read_superelement

ELEMENT = """\
**
** GENERATION OF SUBSTRUCTURE Z1
*USER ELEMENT, NODES=         4, LINEAR
** ELEMENT NODES
**         12,          5,
**          7, 1073741825
          1,          3
          3,          6
          4,          1
*MATRIX,TYPE=STIFFNESS
  4.0000000000000    ,
 -.15000000000000E+01,  9.0000000000000
 0.25000000000000    , 0.50000000000000    ,  7.0000000000000
  0.0000000000000    ,  0.0000000000000    , 0.12500000000000    ,  6.0000000000000
  2.0000000000000    , 0.00000000000000    , 0.00000000000000    , 0.30000000000000-100
  8.0000000000000    ,
  0.0000000000000    ,  0.0000000000000    ,  0.0000000000000    ,  0.0000000000000
  1.0000000000000    ,  5.0000000000000
*MATRIX,TYPE=MASS
1., 0., 1., 0., 0., 1., 0., 0., 0., 1.
0., 0., 0., 0., 1.
0., 0., 0., 0., 0., 1.
"""
K = np.array(
    [
        [4.0, -1.5, 0.25, 0.0, 2.0, 0.0],
        [-1.5, 9.0, 0.5, 0.0, 0.0, 0.0],
        [0.25, 0.5, 7.0, 0.125, 0.0, 0.0],
        [0.0, 0.0, 0.125, 6.0, 3e-101, 0.0],
        [2.0, 0.0, 0.0, 3e-101, 8.0, 1.0],
        [0.0, 0.0, 0.0, 0.0, 1.0, 5.0],
    ]
)
NODES, DOFS = [12, 12, 5, 5, 7, 0], [1, 3, 1, 3, 6, 0]


def test_user_element(tmp_path):
    """Nodes 12 and 5 have dofs 1, 3; the third has 6; the fourth is internal: above Abaqus' largest label."""
    path = tmp_path / "sub.mtx"
    path.write_text(ELEMENT)
    part = read_superelement(path)
    assert (part.name, part.node_ids.tolist(), part.dofs.tolist()) == ("sub", NODES, DOFS)
    np.testing.assert_array_equal(part.K, K)
    np.testing.assert_array_equal(part.M, np.eye(6))
    assert part.C is None
    assert part.positions == {}


def test_user_element_written_as_unsymmetric(tmp_path):
    """With UNSYM Abaqus lists the whole stiffness but still a triangle of the mass."""
    head, _, mass = ELEMENT.partition("*MATRIX,TYPE=STIFFNESS")
    whole = "\n".join(f"{v!r}," for v in K.ravel().tolist())
    path = tmp_path / "sub.mtx"
    text = (
        head.replace("LINEAR", "LINEAR, UNSYM")
        + f"*MATRIX,TYPE=STIFFNESS\n{whole}\n*MATRIX"
        + mass.partition("*MATRIX")[2]
    )
    path.write_text(text)
    np.testing.assert_array_equal(read_superelement(path).K, K)
    path.write_text(text.replace("-1.5,", "-1.6,", 1))
    with pytest.raises(InputError, match=r"sub\.mtx: matrix K is not symmetric: largest \|A_ij - A_ji\| is 0\.1"):
        read_superelement(path)


def test_viscous_damping(tmp_path):
    path = tmp_path / "sub.mtx"
    path.write_text(ELEMENT + ELEMENT.partition("*MATRIX,TYPE=MASS")[2].join(["*MATRIX, TYPE=VISCOUS DAMPING", ""]))
    np.testing.assert_array_equal(read_superelement(path).C, np.eye(6))


def test_map_gives_places_and_generalised_rows(tmp_path):
    path = tmp_path / "sub.mtx"
    path.write_text(ELEMENT)
    rows = ["node,dof,x,y,z", "12,1,1,2,3", "12,3,1,2,3", "5,1,,,", "5,3,,,", "0,0,,,", "0,0,,,"]
    (tmp_path / "sub_dofs.csv").write_text("\n".join(rows))
    part = read_superelement(path)
    assert part.node_ids.tolist() == [12, 12, 5, 5, 0, 0]
    np.testing.assert_array_equal(part.positions[12], [1.0, 2.0, 3.0])
    (tmp_path / "marked.csv").write_text("\n".join(rows), encoding="utf-8-sig")
    assert read_superelement(path, tmp_path / "marked.csv").node_ids.tolist() == [12, 12, 5, 5, 0, 0]
    (tmp_path / "other.csv").write_text("\n".join([rows[0], rows[3], *rows[2:]]))
    with pytest.raises(InputError, match="row 1 is dof 1 of node 5 in the map, dof 1 of node 12 in the user element"):
        read_superelement(path, tmp_path / "other.csv")
    (tmp_path / "other.csv").write_text("\n".join(rows[:-1]))
    with pytest.raises(InputError, match="the map has 5 rows, the user element 6"):
        read_superelement(path, tmp_path / "other.csv")


def test_cut_user_element(tmp_path):
    """Every cut at the end of a line is noticed: K and M have a known number of entries."""
    path = tmp_path / "sub.mtx"
    lines = ELEMENT.splitlines(keepends=True)
    for count in range(3, len(lines)):
        path.write_text("".join(lines[:count]))
        with pytest.raises(InputError, match=r"sub\.mtx"):
            read_superelement(path)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("** ELEMENT NODES\n", "", "0 node labels for a user element with 4 nodes"),
        ("          4,          1\n", "          9,          1\n", r"sub\.mtx:9: node position 9"),
        ("1,          3\n", "1,        a\n", r"sub\.mtx:7: .*no list of integers"),
        ("  9.0000000000000\n", "  9.0O000000\n", r"sub\.mtx:12: .*no list of numbers"),
        ("TYPE=MASS", "TYPE=STRUCTURAL DAMPING", r"sub\.mtx:19: \*MATRIX, TYPE=STRUCTURALDAMPING"),
        ("*MATRIX,TYPE=MASS", "*SLOAD", "no mass matrix"),
        ("3,          6\n", "3,          8\n", "dof 8 of node 7"),
        ("         12,", "          5,", "dof 1 of node 5 has more than one row"),
        ("**\n", ELEMENT, r"sub\.mtx:24: there is a second \*USER ELEMENT"),
        (" 0.25000000000000 ", " nan ", "not finite"),
    ],
)
def test_bad_user_element(tmp_path, old, new, message):
    path = tmp_path / "sub.mtx"
    assert old in ELEMENT
    path.write_text(ELEMENT.replace(old, new, 1))
    with pytest.raises(InputError, match=message):
        read_superelement(path)


STIFFNESS = """\
** job
2,1, 2,1, 4.00000000000000e+00
2,3, 2,1, -1.5
2,3, 2,3, 9.0
1,2, 2,1, 0.25
1,2, 1,2, 7.0
-1,1, 1,2, 0.5
-1,1, -1,1, 6.0
-2,1, -2,1, 5.0
"""
MASS = "1,2, 1,2, 1.0\n2,1 2,1 1.0\n"
LABELLED = np.array(
    [
        [7.0, 0.25, 0.0, 0.5, 0.0],
        [0.25, 4.0, -1.5, 0.0, 0.0],
        [0.0, -1.5, 9.0, 0.0, 0.0],
        [0.5, 0.0, 0.0, 6.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 5.0],
    ]
)


def test_matrix_output(tmp_path):
    """Rows sorted by label, internal nodes last; a triangle whose sides mix; any of the files names all."""
    (tmp_path / "job_STIF2.mtx").write_text(STIFFNESS)
    (tmp_path / "job_MASS2.mtx").write_text(MASS)
    (tmp_path / "job_DMPV2.mtx").write_text("2,3, 2,3, 0.5\n")
    part = read_superelement(tmp_path / "job_MASS2.mtx")
    assert (part.name, part.node_ids.tolist(), part.dofs.tolist()) == ("job", [1, 2, 2, 0, 0], [2, 1, 3, 0, 0])
    np.testing.assert_array_equal(dense(part.K), LABELLED)
    np.testing.assert_array_equal(dense(part.M), np.diag([1.0, 1.0, 0.0, 0.0, 0.0]))
    np.testing.assert_array_equal(dense(part.C), np.diag([0.0, 0.0, 0.5, 0.0, 0.0]))


def test_matrix_output_with_both_triangles(tmp_path):
    (tmp_path / "job_STIF1.mtx").write_text("1,1, 1,1, 2.\n1,1, 1,2, 3.\n1,2, 1,1, 3.\n1,2, 1,2, 9.\n")
    (tmp_path / "job_MASS1.mtx").write_text("1,1, 1,1, 2.\n1,2, 1,2, 2.\n")
    np.testing.assert_array_equal(dense(read_superelement(tmp_path / "job_STIF1.mtx").K), [[2.0, 3.0], [3.0, 9.0]])
    (tmp_path / "job_STIF1.mtx").write_text("1,1, 1,1, 2.\n1,1, 1,2, 3.\n1,2, 1,1, 4.\n1,2, 1,2, 9.\n")
    with pytest.raises(InputError, match="not symmetric"):
        read_superelement(tmp_path / "job_STIF1.mtx")


def test_coordinate_format_needs_a_map(tmp_path):
    (tmp_path / "job_STIF1.mtx").write_text("1 1 2.0\n2 1 -1.0\n2 2 4.0\n")
    (tmp_path / "job_MASS1.mtx").write_text("1 1 1.0\n2 2 1.0\n")
    with pytest.raises(InputError, match=r"FORMAT=COORDINATE.*Give a map node,dof,x,y,z"):
        read_superelement(tmp_path / "job_STIF1.mtx")
    table = tmp_path / "rows.csv"
    table.write_text("node,dof\n9,3\n4,1\n")
    part = read_superelement(tmp_path / "job_STIF1.mtx", table)
    assert (part.node_ids.tolist(), part.dofs.tolist()) == ([9, 4], [3, 1])
    np.testing.assert_array_equal(dense(part.K), [[2.0, -1.0], [-1.0, 4.0]])
    table.write_text("node,dof\n9,3\n")
    with pytest.raises(InputError, match="an entry in row 2, column 1; the map has 1 rows"):
        read_superelement(tmp_path / "job_STIF1.mtx", table)


@pytest.mark.parametrize(
    ("stiffness", "mass", "message"),
    [
        (STIFFNESS, None, r"no mass \(job_MASS1\.mtx\) matrix"),
        (STIFFNESS + "3,1, 3,1\n", MASS, r"job_STIF1\.mtx:10: '3,1, 3,1' is no entry"),
        (STIFFNESS + "3,1, 3,1, 1.0e\n", MASS, r"job_STIF1\.mtx:10: .*the file was cut off"),
        (STIFFNESS + "3,1, 3,1, 1.0e36\n", MASS, "constrained dofs"),
        (STIFFNESS + "3,11, 3,11, 1.0\n", MASS, "dof 11 of node 3"),
        (STIFFNESS, "1 1 1.0\n", "one matrix is FORMAT=COORDINATE, another is not"),
        ("** nothing\n", MASS, "there are no entries"),
    ],
)
def test_bad_matrix_output(tmp_path, stiffness, mass, message):
    (tmp_path / "job_STIF1.mtx").write_text(stiffness)
    if mass is not None:
        (tmp_path / "job_MASS1.mtx").write_text(mass)
    with pytest.raises(InputError, match=message):
        read_superelement(tmp_path / "job_STIF1.mtx")


def test_matrix_output_with_an_unknown_name(tmp_path):
    (tmp_path / "job.mtx").write_text(STIFFNESS)
    with pytest.raises(InputError, match=r"job\.mtx: this name does not tell which matrix it is"):
        read_superelement(tmp_path / "job.mtx")


def test_calculix(tmp_path):
    (tmp_path / "job.sti").write_text("  1  1  2.0E+00\n  2  1 -1.0E+00\n  2  2  4.0E+00\n  3  3  1.0\n")
    (tmp_path / "job.mas").write_text("1 1 1.\n2 2 1.\n3 3 1.\n")
    (tmp_path / "job.dof").write_text("12.1\n12.3\n120.2\n")
    part = read_superelement(tmp_path / "job.sti")
    assert (part.node_ids.tolist(), part.dofs.tolist()) == ([12, 12, 120], [1, 3, 2])
    np.testing.assert_array_equal(dense(part.K), [[2.0, -1.0, 0.0], [-1.0, 4.0, 0.0], [0.0, 0.0, 1.0]])
    (tmp_path / "job.dof").write_text("12.1\n12.3\n")
    with pytest.raises(InputError, match="outside the 2 rows"):
        read_superelement(tmp_path / "job.sti")
    (tmp_path / "job.dof").write_text("12.1\n12\n")
    with pytest.raises(InputError, match=r"job\.dof:2: '12'"):
        read_superelement(tmp_path / "job.sti")
