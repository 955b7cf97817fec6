"""Nastran files as Nastran writes them: OUTPUT4 variants, displacement frames, points, DMIG fields."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.matrices.nastran_dmig import read_dmig
from creak.formats.matrices.nastran_op4 import read_op4
from creak.formats.matrices.op4_file import read_op4_matrices, write_op4_matrices
from creak.formats.nastran.text.bulk_data import read_cards

K = np.array([[4.0, -1.5, 0.0, 2.0], [-1.5, 9.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 7.5]])


def op4_bytes(matrix, name, layout, order="<", word=4, kind=2):
    """A matrix as OUTPUT4 writes it, from the format's description; strings of equal neighbours."""
    i, value = ("i", "d" if kind == 2 or word == 8 else "f") if word == 4 else ("q", "d")

    def framed(payload):
        length = struct.pack(order + "i", len(payload))
        return length + payload + length

    n = len(matrix)
    per_value = struct.calcsize(value) // word
    rows = -n if layout == "bigmat" else n
    data = framed(struct.pack(f"{order}4{i}", n, rows, 6, kind) + name.ljust(2 * word).encode())
    for j in range(n):
        filled = np.flatnonzero(matrix[:, j])
        if not filled.size:
            continue
        if layout == "dense":
            values = matrix[filled[0] : filled[-1] + 1, j]
            body = struct.pack(f"{order}{values.size}{value}", *values)
            head = (j + 1, filled[0] + 1, values.size * per_value)
        else:
            body = b""
            for run in np.split(filled, np.flatnonzero(np.diff(filled) > 1) + 1):
                words = run.size * per_value
                start = [words + 1, run[0] + 1] if layout == "bigmat" else [run[0] + 1 + 65536 * (words + 1)]
                body += struct.pack(f"{order}{len(start)}{i}", *start)
                body += struct.pack(f"{order}{run.size}{value}", *matrix[run, j])
            head = (j + 1, 0, len(body) // word)
        data += framed(struct.pack(f"{order}3{i}", *head) + body)
    return data + framed(struct.pack(f"{order}3{i}", n + 1, 1, per_value) + struct.pack(order + value, 1.0))


@pytest.mark.parametrize("layout", ["dense", "bigmat", "nonbigmat"])
@pytest.mark.parametrize(("order", "word", "kind"), [("<", 4, 2), (">", 4, 2), ("<", 4, 1), ("<", 8, 2), (">", 8, 2)])
def test_binary_op4(tmp_path, layout, order, word, kind):
    """Both endiannesses, single and double precision, 32- and 64-bit words; the entries are exact in single."""
    path = tmp_path / "a.op4"
    parts = [(np.ones((2, 2)), "SKIPPED"), (K, "KXX"), (2 * K, "MXX")]
    path.write_bytes(b"".join(op4_bytes(m, name, layout, order, word, kind) for m, name in parts))
    found = read_op4_matrices(path, {"KXX", "MXX"})
    assert found.keys() == {"KXX", "MXX"}
    np.testing.assert_array_equal(found["KXX"], K)
    np.testing.assert_array_equal(found["MXX"], 2 * K)


TEXT = {
    "dense": """\
       2       2       6       2KXX     1P,3E23.16
       1       1       2
 4.0000000000000000E+00-1.5000000000000000E+00
       2       1       2
-1.5000000000000000E+00 9.0000000000000000E-110
       3       1       1
 1.0000000000000000E+00
""",
    "double words": """\
       2       2       6       2KXX     1P,3D23.16
       1       1       4
 4.0000000000000000D+00-1.5000000000000000D+00
       2       1       4
-1.5000000000000000D+00 9.0000000000000000-110
       3       1       2
 1.0000000000000000D+00
""",
    "bigmat": """\
       2      -2       6       2KXX     1P,3E23.16
       1       0       6
       5       1
 4.0000000000000000E+00-1.5000000000000000E+00
       2       0       8
       3       1
-1.5000000000000000E+00
       3       2
 9.0000000000000000E-110
       3       1       1
 1.0000000000000000E+00
""",
    "nonbigmat": f"""\
       2       2       6       2KXX     1P,3E23.16
       1       0       5
{1 + 65536 * 5:8d}
 4.0000000000000000E+00-1.5000000000000000E+00
       2       0       5
{1 + 65536 * 5:8d}
-1.5000000000000000E+00 9.0000000000000000E-110
       3       1       1
 1.0000000000000000E+00
""",
}


@pytest.mark.parametrize("layout", TEXT)
def test_text_op4(tmp_path, layout):
    """Numbers that touch, exponents of three digits with and without their letter."""
    path = tmp_path / "a.op4"
    path.write_text(TEXT[layout] + TEXT[layout].replace("KXX", "MXX"))
    found = read_op4_matrices(path, {"KXX", "MXX"})
    np.testing.assert_array_equal(found["KXX"], [[4.0, -1.5], [-1.5, 9e-110]])
    np.testing.assert_array_equal(found["MXX"], found["KXX"])


@pytest.mark.parametrize("layout", TEXT)
def test_cut_text_op4(tmp_path, layout):
    path = tmp_path / "a.op4"
    lines = TEXT[layout].splitlines(keepends=True)
    for count in range(len(lines)):
        path.write_text("".join(lines[:count]))
        with pytest.raises(InputError, match=r"a\.op4: this is no complete OUTPUT4 file"):
            read_op4_matrices(path, {"KXX"})


def test_complex_op4_is_refused(tmp_path):
    path = tmp_path / "a.op4"
    data = op4_bytes(np.eye(2), "KXX", "dense")
    path.write_bytes(data[:16] + struct.pack("<i", 4) + data[20:])
    with pytest.raises(InputError, match="KXX is complex"):
        read_op4_matrices(path, {"KXX"})


FRAMES = """\
$ a grid in each kind of frame; by hand, directions (1, 2, 3) of each are
CORD2C         4       0      0.      0.      0.      0.      0.      1.
              1.      0.      0.
CORD2S,        5,0,0.,0.,0.,0.,0.,1.
,1.,0.,0.
CORD2R*                6               4             1.0            90.0
*                    0.0             1.0            90.0             1.0
*                  2.D+0            90.0              0.
$ y, -x, z at (0, 2, 1)
GRID          10       4      2.     90.      1.       4
$ x, -z, y at (2, 0, 0)
GRID,11,5,2.,90.,0.,5
$ y, -x, z at (-3, 2, 1): system 6 has its origin at (0, 1, 0)
GRID*                 12               6             1.0             3.0
*                    1.0               6
SPOINT,13,THRU,14
"""
STIFFNESS = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
BY_HAND = {10: [2.0, 1.0, 3.0, 5.0, 4.0, 6.0], 11: [1.0, 3.0, 2.0, 4.0, 6.0, 5.0], 12: [2.0, 1.0, 3.0, 5.0, 4.0, 6.0]}
PLACES = {10: [0.0, 2.0, 1.0], 11: [2.0, 0.0, 0.0], 12: [-3.0, 2.0, 1.0]}


def test_frames_of_grids(tmp_path):
    """Diagonal stiffnesses 1 to 6 in each frame land on the basic direction that was found by hand."""
    (tmp_path / "a.asm").write_text(FRAMES)
    local = np.diag([*STIFFNESS * 3, 7.0, 8.0])
    write_op4_matrices({"KXX": local, "MXX": local}, tmp_path / "a.op4")
    part = read_op4(tmp_path / "a.op4")
    np.testing.assert_array_equal(part.node_ids, [*np.repeat([10, 11, 12], 6), 0, 0])
    expected = np.diag([*BY_HAND[10], *BY_HAND[11], *BY_HAND[12], 7.0, 8.0])
    np.testing.assert_allclose(part.K, expected, atol=1e-14)
    for node, place in PLACES.items():
        np.testing.assert_allclose(part.positions[node], place, atol=1e-14)


def test_coupling_terms_turn_on_both_sides(tmp_path):
    """A spring between basic x of grid 10 (-2 of its frame) and a scalar point changes sign once."""
    (tmp_path / "a.asm").write_text(FRAMES)
    local = np.eye(20) * 9.0
    local[1, 18] = local[18, 1] = 2.5
    write_op4_matrices({"KXX": local, "MXX": local}, tmp_path / "a.op4")
    part = read_op4(tmp_path / "a.op4")
    assert part.K[0, 18] == pytest.approx(-2.5)
    assert part.K[18, 0] == pytest.approx(-2.5)
    assert abs(part.K[1, 18]) < 1e-14


def test_seconct_gives_exterior_labels_in_interior_order(tmp_path):
    """Interior 1, 2, 5 (rows in this order) are 900, 3, 40 outside; 40 is a scalar point."""
    (tmp_path / "a.asm").write_text(
        "SECONCT,101,0,,NO\n,5,40,1,900,2,3\nGRID,900,,1.,0.,0.\nGRID,3,,2.,0.,0.\nSPOINT,40\nGRID,77,,0.,0.,0.\n"
    )
    K = np.diag(np.arange(1.0, 14.0))
    write_op4_matrices({"KAA": K, "MAA": K}, tmp_path / "a.op4")
    part = read_op4(tmp_path / "a.op4")
    np.testing.assert_array_equal(part.node_ids, [*[900] * 6, *[3] * 6, 0])
    np.testing.assert_array_equal(part.positions[900], [1.0, 0.0, 0.0])


def test_seconct_with_ranges(tmp_path):
    (tmp_path / "a.asm").write_text("SECONCT,101,0\n,1,THRU,2,11,THRU,12\nSPOINT,11\nGRID,12\n")
    write_op4_matrices({"KXX": np.eye(7), "MXX": np.eye(7)}, tmp_path / "a.op4")
    assert read_op4(tmp_path / "a.op4").node_ids.tolist() == [0, *[12] * 6]
    (tmp_path / "a.asm").write_text("SECONCT,101,0\n,1,THRU,2,11,THRU,13\nSPOINT,11\nGRID,12\n")
    with pytest.raises(InputError, match=r"a\.asm:1: SECONCT connects 2 points to 3"):
        read_op4(tmp_path / "a.op4")


def test_damping(tmp_path):
    """One-by-one placeholders and zero matrices are no damping; structural damping is refused."""
    (tmp_path / "a.asm").write_text("SPOINT,1,2\n")
    K, B, K4 = np.eye(2), np.array([[2.0, 1.0], [1.0, 3.0]]), np.array([[4.0, 0.0], [0.0, 8.0]])
    path = tmp_path / "a.op4"
    write_op4_matrices({"KXX": K, "MXX": K, "BXX1": np.zeros((1, 1)), "K4XX1": np.zeros((1, 1))}, path)
    assert read_op4(path).C is None
    write_op4_matrices({"KXX": K, "MXX": K, "BXX1": B}, path)
    np.testing.assert_array_equal(read_op4(path).C, B)
    write_op4_matrices({"KXX": K, "MXX": K, "BXX1": B, "K4XX1": K4}, path)
    with pytest.raises(InputError, match=r"structural damping matrix(.|\n)*without it \(K4\)"):
        read_op4(path)


def test_a_table_instead_of_the_asm_file(tmp_path):
    write_op4_matrices({"KXX": np.eye(2), "MXX": np.eye(2)}, tmp_path / "a.op4")
    (tmp_path / "rows.csv").write_text("node,dof,x,y,z\n12,3,1,2,3\n0,0,,,\n")
    part = read_op4(tmp_path / "a.op4", tmp_path / "rows.csv")
    assert (part.node_ids.tolist(), part.dofs.tolist()) == ([12, 0], [3, 0])
    np.testing.assert_array_equal(part.positions[12], [1.0, 2.0, 3.0])


def test_extrn_gives_the_dofs(tmp_path):
    (tmp_path / "a.asm").write_text("GRID,1\nGRID,2\nGRID,3\nSPOINT,9\nEXTRN,1,THRU,2,13,3,6,9,0\n")
    write_op4_matrices({"KXX": np.eye(6), "MXX": np.eye(6)}, tmp_path / "a.op4")
    part = read_op4(tmp_path / "a.op4")
    assert list(zip(part.node_ids.tolist(), part.dofs.tolist(), strict=True)) == [
        (1, 1),
        (1, 3),
        (2, 1),
        (2, 3),
        (3, 6),
        (0, 0),
    ]


DMIG = {
    "small": """\
DMIG    KAAX           0       6       2       0
DMIG    KAAX           1       1               1       1     4.5
               2             -.5
DMIG    KAAX           2                       2            2.+1
""",
    "large": """\
DMIG    KAAX           0       6       2       0                       2
DMIG*   KAAX                           1               1
*                      1               1        4.5D+00
*                      2               0      -5.00D-01
DMIG*   KAAX                           2               0
*                      2               0       2.00D+01
""",
    "free": "DMIG,KAAX,0,6,2\nDMIG,KAAX,1,1,,1,1,4.5\n,2,,-.5\nDMIG,KAAX,2,,,2,0,20.\n",
    "square": "DMIG,KAAX,0,1,2\nDMIG,KAAX,1,1,,1,1,4.5\n,2,,-.5\nDMIG,KAAX,2,0,,1,1,-.5\n,2,0,20.\n",
}


@pytest.mark.parametrize("layout", DMIG)
def test_dmig_fields(tmp_path, layout):
    path = tmp_path / "a.pch"
    path.write_text(f"$ punched\n{DMIG[layout]}{DMIG[layout].replace('KAAX', 'MAAX')}")
    part = read_dmig(path)
    np.testing.assert_array_equal(part.K, [[4.5, -0.5], [-0.5, 20.0]])
    assert (part.node_ids.tolist(), part.dofs.tolist()) == ([1, 0], [1, 0])


def test_dmig_turns_with_the_frame_of_its_grid(tmp_path):
    """Direction 1 of the cylindrical frame of grid 10 is basic y."""
    rows = "".join(f"DMIG,KAAX,10,{c},,10,{c},{float(c)}\n" for c in range(1, 7))
    text = "DMIG,KAAX,0,6,2\n" + rows
    (tmp_path / "a.pch").write_text(FRAMES + text + text.replace("KAAX", "MAAX"))
    np.testing.assert_allclose(np.diag(read_dmig(tmp_path / "a.pch").K.toarray()), BY_HAND[10], atol=1e-14)


def test_dmig_with_part_of_a_frame_is_refused(tmp_path):
    text = "DMIG,KAAX,0,6,2\nDMIG,KAAX,10,1,,10,1,1.\n"
    (tmp_path / "a.pch").write_text(FRAMES + text + text.replace("KAAX", "MAAX"))
    with pytest.raises(InputError, match="only some of its dofs"):
        read_dmig(tmp_path / "a.pch")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("DMIG,KAAX,1,1,,1,1,4.5\n", r"a\.pch:1: a column of DMIG KAAX comes before its header"),
        ("DMIG,KAAX,0,6,2\nDMIG,KAAX,1,1,,1,1,4.5\nDMIG,KAAX,1,1,,1,1,4.5\n", r"a\.pch:3: entry .* given twice"),
        ("DMIG,KAAX,0,6,2\nDMIG,KAAX,1,1,,2,1,4.5\nDMIG,KAAX,2,1,,1,1,4.5\n", r"a\.pch:3: entry .* one triangle"),
        ("DMIG,KAAX,0,6,4\n", r"a\.pch:1: .*type 4"),
        ("DMIG,KAAX,0,9,2\n", r"a\.pch:1: .*form 9"),
        ("DMIG,KAAX,0,6,2\nDMIG,KAAX,1,1,,1,1,abc\n", r"a\.pch:2: field 8 of DMIG is 'abc'"),
        ("DMIG,KAAX,0,6,2\nDMIG,KAAX,1,1,,1,1,4.5\n", "no mass matrix"),
        ("GRID,1\n", "no stiffness matrix"),
        (
            "GRID,1,0,0.,0.,0.,8\n" + DMIG["free"] + DMIG["free"].replace("KAAX", "MAAX"),
            "GRID 1 needs coordinate system 8",
        ),
        (
            "CORD2R,8,8,0.,0.,0.,0.,0.,1.\n,1.\n" + DMIG["free"] + DMIG["free"].replace("K", "M"),
            "CORD2R 8 refers to system 8",
        ),
        ("CORD2R,8,,0.,0.,0.,0.,0.,1.\n,0.,0.,2.\n" + DMIG["free"] + DMIG["free"].replace("K", "M"), "lie on a line"),
    ],
)
def test_bad_dmig(tmp_path, text, message):
    path = tmp_path / "a.pch"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        read_dmig(path)


def test_cards_before_begin_bulk_are_skipped(tmp_path):
    path = tmp_path / "a.bdf"
    path.write_text("SOL 103\nSPOINT,5\nCEND\nBEGIN BULK\nSPOINT,6 $ comment\n")
    assert [(card.name, card.fields[0], card.where) for card in read_cards(path)] == [("SPOINT", "6", f"{path}:5")]
