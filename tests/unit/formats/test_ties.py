"""*TIE: which nodes are tied, to what, and what is said about the others."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from creak.errors import InputError
from creak.model.constraints import Tie
from creak.model.mesh import Model
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
    # The 21 nodes of the other three columns; the first eight are named.
    assert "21 of 28 nodes of 'RIGHT_FACE'".replace("RIGHT_FACE", name) in notes[0].why
    assert "node 100002, 100003, 100004, 100006" in notes[0].why
    assert "and 13 more" in notes[0].why


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
