"""*TIE: which nodes are tied, to what, and what is said about the others.

Ties to faces with middle nodes: motion of second degree is followed exactly, and so is rigid motion of bowed ones.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.abaqus.reader import read_deck
from creak.model.constraints import Tie
from creak.model.faces import FACES, face_numbers
from creak.model.mesh import Model
from helpers_nastran import read
from helpers_solids import solid_mesh
from helpers_ties import cut_plate, sections, sheet

Reader = Callable[[str], Model]
SEAM = "*TIE, NAME=SEAM\nRIGHT_X0, LEFT_X1\n"


def ties(model: Model) -> list[Tie]:
    return [c for c in model.constraints if isinstance(c, Tie)]


def check_points(model: Model) -> None:
    """Each node is its point of the main surface plus the arm."""
    x = model.nodes.coords
    for tie in ties(model):
        assert tie.weights.sum() == pytest.approx(1.0, abs=1e-14)
        np.testing.assert_allclose(tie.weights @ x[tie.nodes_idx] + tie.arm, x[tie.node_idx], atol=1e-9)


@pytest.mark.parametrize("main", ["LEFT_X1", "LEFT_FACE"])
def test_edge_is_tied_to_the_edge_that_it_meets(read: Reader, main: str) -> None:
    model = read(cut_plate((3, 4), (3, 6), f"*TIE, NAME=SEAM\nRIGHT_X0, {main}\n"))
    found = ties(model)
    assert len(found) == 7
    check_points(model)
    for tie in found:
        y = model.nodes.coords[tie.node_idx, 1]
        # Main nodes stand every 20 mm at x = 60; a node between two of them hangs on these two.
        assert (model.nodes.coords[tie.nodes_idx, 0] == 60.0).all()
        assert tie.nodes_idx.size == (1 if y % 20 == 0 else 2)
        assert not tie.arm.any()
        assert tie.rotations
        assert tie.name == "SEAM"
    assert found[1].where.endswith(f"deck.inp:{len(cut_plate((3, 4), (3, 6)).splitlines())}")
    assert [p.name for p in model.parts] == ["LEFT", "RIGHT"]


@pytest.mark.parametrize("kind", ["facets", "nodes"])
def test_whole_surface_may_be_secondary(read: Reader, kind: str) -> None:
    surface = "" if kind == "facets" else "*SURFACE, NAME=CLOUD, TYPE=NODE\nRIGHT_NODES\n"
    name = "RIGHT_FACE" if kind == "facets" else "CLOUD"
    model = read(cut_plate((3, 4), (3, 6), f"{surface}*TIE, NAME=SEAM\n{name}, LEFT_X1\n"))
    assert sorted(t.node_idx for t in ties(model)) == sorted(t.node_idx for t in ties(read(cut_plate((3, 4), (3, 6)))))
    notes = [u for u in model.unread if "NAME=SEAM" in u.keyword]
    assert len(notes) == 1
    assert not notes[0].changes_answer
    # The 21 nodes of the other three columns; the first five are named.
    assert "21 of 28 nodes of 'RIGHT_FACE'".replace("RIGHT_FACE", name) in notes[0].why
    assert "node 100002, 100003, 100004, 100006" in notes[0].why
    assert "and 16 more" in notes[0].why


def test_offset_becomes_a_rigid_arm(read: Reader) -> None:
    tie = SEAM.replace("=SEAM", "=SEAM, POSITION TOLERANCE=2.")
    model = read(cut_plate((3, 4), (3, 6), tie, shift=(0.5, 0.0, 1.5)))
    check_points(model)
    for t in ties(model):
        np.testing.assert_allclose(t.arm, [0.5, 0.0, 1.5], atol=1e-9)
    notes = [u for u in model.unread if "ADJUST" in u.keyword]
    assert len(notes) == 1
    assert "rigid arms up to 1.58 long" in notes[0].why
    kept = read(cut_plate((3, 4), (3, 6), tie.replace("2.", "2., ADJUST=NO"), shift=(0.5, 0.0, 1.5)))
    assert not [u for u in kept.unread if "ADJUST" in u.keyword]


@pytest.mark.parametrize(("shift", "count"), [(0.9, 7), (1.05, 0)])
def test_default_tolerance_is_five_percent_of_the_main_edges(read: Reader, shift: float, count: int) -> None:
    """Main edges of 20 mm reach 1 mm."""
    text = cut_plate((3, 4), (3, 6), shift=(shift, 0.0, 0.0))
    if count:
        assert len(ties(read(text))) == count
    else:
        with pytest.raises(InputError, match=r"joins no node of 'RIGHT_X0': 7 lie farther than 1 from 'LEFT_X1'"):
            read(text)


def lap(gap: float, options: str = "") -> str:
    """A sheet of 2 mm over another one, `gap` between their faces."""
    return (
        "*HEADING\nlap\n"
        + sheet("LOWER", 1, (4, 4), (0.0, 0.0, 0.0), (40.0, 40.0))
        + sheet("UPPER", 10_001, (3, 3), (5.0, 5.0, 2.0 + gap), (30.0, 30.0))
        + sections("LOWER", "UPPER", thickness=2.0)
        + f"*TIE, NAME=LAP{options}\nUPPER_FACE, LOWER_FACE\n"
    )


def test_lapped_shells_are_tied_face_to_face(read: Reader) -> None:
    # 5 % of 10 mm: the faces may be 0.5 mm apart.
    model = read(lap(0.45))
    assert len(ties(model)) == 16
    check_points(model)
    np.testing.assert_allclose([t.arm for t in ties(model)], np.tile([0.0, 0.0, 2.45], (16, 1)), atol=1e-9)
    assert max(t.nodes_idx.size for t in ties(model)) == 4
    for text in (lap(0.55), lap(0.45, ", NO THICKNESS")):
        with pytest.raises(InputError, match="joins no node"):
            read(text)


@pytest.mark.parametrize(
    ("lower", "upper", "count"),
    [("SNEG", "SNEG", 16), ("SPOS", "SPOS", 16), ("SPOS", "SNEG", 0), ("SNEG", "SPOS", 16)],
)
def test_shells_beside_their_nodes_are_tied_where_their_skins_meet(
    read: Reader, lower: str, upper: str, count: int
) -> None:
    """The nodes lie 2.45 apart and the sheets are 2 thick: .45 between skins, 2.45 where both lie away, and across each
    other where both lie between."""
    text = lap(0.45)
    for name, offset in (("LOWER", lower), ("UPPER", upper)):
        text = text.replace(f"SECTION, ELSET={name}", f"SECTION, ELSET={name}, OFFSET={offset}")
    if count:
        assert len(ties(read(text))) == count
    else:
        with pytest.raises(InputError, match=r"joins no node of .UPPER_FACE.: 16 lie farther than 0\.5"):
            read(text)


def test_no_rotation_and_tied_nset(read: Reader) -> None:
    extra = "*NSET, NSET=CORNERS\n100001, 100025\n"
    tie = SEAM.replace("=SEAM", "=SEAM, TIED NSET=CORNERS, NO ROTATION, TYPE=NODE TO SURFACE")
    model = read(cut_plate((3, 4), (3, 6), extra + tie, shift=(4.0, 0.0, 0.0)))
    assert model.nodes.ids[[t.node_idx for t in ties(model)]].tolist() == [100001, 100025]
    assert not any(t.rotations for t in ties(model))
    assert [u.keyword for u in model.unread] == ["*TIE, NAME=SEAM, ADJUST=YES"]


def test_shared_nodes_are_passed_over(read: Reader) -> None:
    """The secondary surface holds the main one's own edge as well."""
    extra = "*SURFACE, NAME=BOTH, TYPE=NODE\nRIGHT_NODES\n4,\n8,\n"
    model = read(cut_plate((3, 4), (3, 6), extra + "*TIE, NAME=SEAM\nBOTH, LEFT_X1\n"))
    assert len(ties(model)) == 7
    assert any("2 node(s) of 'BOTH' and 'LEFT_X1' belong to both" in u.why for u in model.unread)


@pytest.mark.parametrize(
    ("tie", "words"),
    [
        ("*TIE, NAME=T\nRIGHT_X0, LEFT_X\n", "unknown surface 'LEFT_X'.*Did you mean 'LEFT_X"),
        ("*TIE, NAME=T\nRIGHT_X0\n", "names one surface only"),
        ("*TIE, NAME=T\n", "without surfaces"),
        ("*TIE, NAME=T, POSITION TOLERANCE=-1.\nRIGHT_X0, LEFT_X1\n", "position tolerance is -1"),
        ("*TIE, NAME=T, POSITION TOLERANCE=x\nRIGHT_X0, LEFT_X1\n", "position tolerance"),
        ("*TIE, NAME=T\nLEFT_X1, LEFT_FACE\n", r"joins no node.*5 node\(s\) belong to both"),
        ("*TIE, NAME=T, TIED NSET=LEFT_NODES\nRIGHT_X0, LEFT_X1\n", "TIED NSET= holds none of them"),
        ("*SURFACE, NAME=N, TYPE=NODE\nLEFT_NODES\n*TIE, NAME=T\nRIGHT_X0, N\n", "'N' of .TIE is a surface of nodes"),
    ],
)
def test_mistakes_are_named(read: Reader, tie: str, words: str) -> None:
    with pytest.raises(InputError, match=words) as error:
        read(cut_plate((3, 4), (3, 6), tie))
    assert "deck.inp:" in str(error.value)


def test_parameters_that_creak_does_not_read_are_listed(read: Reader) -> None:
    model = read(cut_plate((3, 4), (3, 6), SEAM.replace("=SEAM", "=SEAM, CYCLIC SYMMETRY")))
    assert [u.keyword for u in model.unread if u.changes_answer] == ["*TIE, CYCLICSYMMETRY"]


def test_cyclic_symmetry_is_told_as_what_it_is(read: Reader) -> None:
    """A sector tied to itself, turned: no tie of this mesh, whatever its surfaces are."""
    cloud = "*SURFACE, NAME=CLOUD, TYPE=NODE\nRIGHT_NODES\n"
    model = read(cut_plate((3, 4), (3, 6), f"{cloud}*TIE, CYCLIC SYMMETRY, NAME=SEAM\nCLOUD, CLOUD\n"))
    assert not ties(model)
    assert [(u.keyword, u.changes_answer) for u in model.unread] == [("*TIE, CYCLICSYMMETRY", True)]


SIZE = (3.0, 2.0, 1.0)
TYPES = {"hex20": "C3D20", "tet10": "C3D10", "wedge15": "C3D15"}
CARDS = {"hex20": "CHEXA", "tet10": "CTETRA", "wedge15": "CPENTA"}
MIDDLE_ORDER = {"hex20": [*range(12), *range(16, 20), *range(12, 16)], "wedge15": [*range(9), 12, 13, 14, 9, 10, 11]}


def two_blocks(kind: str, bow: float) -> tuple[np.ndarray, list[np.ndarray]]:
    """Nodes and elements of a fine block on a coarse one, whose upper middle nodes are off by `bow`."""
    (x, low), (y, high) = solid_mesh((2, 1, 1), SIZE, kind), solid_mesh((3, 4, 1), SIZE, kind)
    middles = low[:, {"hex20": 8, "tet10": 4, "wedge15": 6}[kind] :]
    upper = np.intersect1d(middles, np.flatnonzero(np.isclose(x[:, 2], SIZE[2])))
    x[upper] += bow * np.random.default_rng(5).uniform(-1.0, 1.0, (upper.size, 3))
    return np.concatenate([x, y + [0.0, 0.0, SIZE[2]]]), [low, high + len(x)]


def faces_at(kind: str, coords: np.ndarray, elements: np.ndarray, z: float) -> list[tuple[int, int]]:
    facets, number = np.array(FACES[kind]), face_numbers(kind)
    return [
        (k, int(face))
        for k, nodes in enumerate(elements)
        for face in np.unique(number)
        if np.isclose(coords[nodes[facets[number == face][:, 0]]][:, 2], z, atol=0.1).all()
        and np.isclose(coords[nodes[facets[number == face]]][..., 2], z, atol=0.1).all()
    ]


def abaqus(
    folder: Path, kind: str, bow: float, tie: str = "*TIE, NAME=T, POSITION TOLERANCE=0.2", gap: float = 0.0
) -> Model:
    coords, blocks = two_blocks(kind, bow)
    coords[blocks[1].min() :, 2] += gap
    lines = ["*NODE", *(f"{k + 1}, {x:.12g}, {y:.12g}, {z:.12g}" for k, (x, y, z) in enumerate(coords))]
    for name, start, elements in zip(("LOW", "TOP"), (1, 1001), blocks, strict=True):
        lines.append(f"*ELEMENT, TYPE={TYPES[kind]}, ELSET={name}")
        for k, nodes in enumerate(elements):
            fields = [str(k + start), *(str(n + 1) for n in nodes)]
            lines.append(", ".join(fields[:16]) + (",\n" + ", ".join(fields[16:]) if fields[16:] else ""))
        lines += [f"*SOLID SECTION, ELSET={name}, MATERIAL=M", f"*SURFACE, NAME=S_{name}"]
        lines += [f"{k + start}, S{face}" for k, face in faces_at(kind, coords, elements, SIZE[2])]
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", "2000., 0.3", "*DENSITY", "1e-9"]
    lines += [tie, "S_TOP, S_LOW"]
    (folder / "a.inp").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return read_deck(folder / "a.inp")


def nastran(folder: Path, kind: str, bow: float) -> Model:
    coords, blocks = two_blocks(kind, bow)
    lines = [f"GRID,{k + 1},,{x:.12g},{y:.12g},{z:.12g}" for k, (x, y, z) in enumerate(coords)]
    for start, elements in zip((1, 1001), blocks, strict=True):
        for k, nodes in enumerate(elements):
            order = MIDDLE_ORDER.get(kind, range(len(nodes)))
            fields = [str(k + start), "1", *(str(n + 1) for n in nodes[order])]
            lines.append(CARDS[kind] + "\n".join("," + ",".join(fields[i : i + 8]) for i in range(0, len(fields), 8)))
    lines += [
        f"BSURF,{i},{start},THRU,{start + len(b) - 1}" for i, start, b in zip((1, 2), (1, 1001), blocks, strict=True)
    ]
    lines += ["BGSET,5,1,2,0.2", "PSOLID,1,1", "MAT1,1,2000.,,.3,1.-9"]
    return read(folder, "\n".join(lines), "BGSET = 5\n")


Motion = Callable[[np.ndarray], np.ndarray]


def second_degree(x: np.ndarray) -> np.ndarray:
    a, b = x[:, 0], x[:, 1]
    return np.column_stack([1 + a - 2 * b + a * a, a * b - 0.5 * b * b, 3 * a * a + b * b - a * b + b])


def turned(x: np.ndarray) -> np.ndarray:
    return np.cross([0.3, -0.7, 0.5], x)


@pytest.mark.parametrize("kind", list(TYPES))
@pytest.mark.parametrize("deck", [abaqus, nastran])
@pytest.mark.parametrize(("bow", "motion"), [(0.0, second_degree), (0.04, turned)])
def test_tied_nodes_follow(tmp_path, kind, deck, bow, motion: Motion):
    model = deck(tmp_path, kind, bow)
    x = model.nodes.coords
    u = np.pad(motion(x), ((0, 0), (0, 3)))
    equations = [e for c in model.constraints for e in (c.equations(x) if hasattr(c, "equations") else [c])]
    assert len(equations) >= 3 * 30
    left = [e.coefficients @ u[e.nodes_idx, e.dofs - 1] for e in equations]
    assert np.abs(left).max() < 1e-9 * np.abs(u).max()


@pytest.mark.parametrize("kind", list(TYPES))
def test_the_default_tolerance_is_of_whole_faces(tmp_path, kind):
    """5 % of edges between 1.5 and 2.5 long, which middle nodes do not halve: a gap of .07 is closed."""
    closed, at = (abaqus(tmp_path, kind, 0.0, "*TIE, NAME=T", gap).constraints for gap in (0.07, 0.0))
    tied, met = ({c.node_idx if isinstance(c, Tie) else int(c.nodes_idx[0]) for c in found} for found in (closed, at))
    assert tied == met != set()


@pytest.mark.parametrize(
    ("option", "told"), [("", "*TIE without TYPE"), (", TYPE=SURFACE TO SURFACE", "*TIE, TYPE=SURFACE TO SURFACE")]
)
def test_what_is_listed_of_a_tie_is_what_the_deck_says(read: Reader, option: str, told: str) -> None:
    model = read(cut_plate((3, 4), (3, 6), f"*TIE, NAME=SEAM{option}\nRIGHT_X0, LEFT_X1\n"))
    (found,) = model.unread
    assert (found.keyword, found.changes_answer) == (told, False)
