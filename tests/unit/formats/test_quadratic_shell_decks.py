"""Shells and beams with middle nodes in Abaqus and Nastran decks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.contact.facets import facets_of
from creak.contact.node_to_surface import nodes_of
from creak.errors import InputError
from creak.formats.decks import read_model
from creak.formats.measured.uff import DESCRIPTORS, ORDER
from creak.formats.nastran.writer import write_nastran
from creak.formats.vtu import CELLS
from creak.model.faces import FACES, SHELL_FACETS, facets_of_shells
from creak.studies.models.deck_modes import deck_modes

RECORDED = {"section": "decks"}

N, SIDE, THICK = 4, 100.0, 1.0
BENDING = 7e4 * THICK**3 / 12 / 0.91
EXACT = np.array([2.0, 5.0, 5.0, 8.0]) * np.pi / (2 * SIDE**2) * np.sqrt(BENDING / (2.7e-9 * THICK))
"""Navier: simply supported square plate, Hz."""
STEEL = "*MATERIAL, NAME=M\n*ELASTIC\n7e4, 0.3\n*DENSITY\n2.7e-9\n"


def plate() -> tuple[dict[int, tuple[float, float]], list[list[int]], list[list[int]]]:
    """Nodes of a (2 N + 1)^2 grid by label, quadrilaterals of eight and triangles of six of them."""
    wide = 2 * N + 1
    place = {1 + i * wide + j: (SIDE * i / (2 * N), SIDE * j / (2 * N)) for i in range(wide) for j in range(wide)}
    quads, triangles = [], []
    for i in range(0, 2 * N, 2):
        for j in range(0, 2 * N, 2):
            at = [[1 + (i + a) * wide + j + b for b in range(3)] for a in range(3)]
            quads.append([at[0][0], at[2][0], at[2][2], at[0][2], at[1][0], at[2][1], at[1][2], at[0][1]])
            triangles.append([at[0][0], at[2][0], at[2][2], at[1][0], at[2][1], at[1][1]])
            triangles.append([at[0][0], at[2][2], at[0][2], at[1][1], at[1][2], at[0][1]])
    return place, quads, triangles


def edges(place: dict[int, tuple[float, float]], used: set[int]) -> dict[str, list[int]]:
    on = {"X": 0, "Y": 1}
    return {
        name: [n for n, x in place.items() if n in used and (x[a] < 1e-9 or x[a] > SIDE - 1e-9)]
        for name, a in on.items()
    }


def abaqus(kind: str) -> str:
    place, quads, triangles = plate()
    elements = quads if kind == "S8R" else triangles
    used = {n for e in elements for n in e}
    lines = ["*NODE", *(f"{n}, {x}, {y}, 0" for n, (x, y) in place.items() if n in used)]
    lines += [
        f"*ELEMENT, TYPE={kind}, ELSET=P",
        *(f"{k}, " + ", ".join(map(str, e)) for k, e in enumerate(elements, 1)),
    ]
    for name, nodes in edges(place, used).items():
        lines += [f"*NSET, NSET={name}", *(f"{n}," for n in nodes)]
    every = [f"*NSET, NSET=ALL\n{n}," for n in sorted(used)]
    held = "*BOUNDARY\nALL, 1, 2\nALL, 6\nX, 3, 4\nY, 3\nY, 5\n"
    return "\n".join([*lines, *every]) + f"\n*SHELL SECTION, ELSET=P, MATERIAL=M\n{THICK},\n{STEEL}{held}"


def nastran(kind: str) -> str:
    place, quads, triangles = plate()
    elements = quads if kind == "CQUAD8" else triangles
    used = {n for e in elements for n in e}
    side = edges(place, used)
    lines = [
        "SOL 103",
        "CEND",
        "SPC = 1",
        "BEGIN BULK",
        "PARAM,COUPMASS,1",
        "MAT1,1,7.+4,,.3,2.7-9",
        "PSHELL,1,1,1.,1,,1",
    ]
    lines += [f"GRID,{n},,{x},{y},0." for n, (x, y) in place.items() if n in used]
    for k, e in enumerate(elements, 1):
        lines += [f"{kind},{k},1," + ",".join(map(str, e[:6])) + ",+", "+," + ",".join(map(str, e[6:]))]
    lines += [f"SPC1,1,126,{n}" for n in sorted(used)]
    lines += [f"SPC1,1,34,{n}" for n in side["X"]] + [f"SPC1,1,35,{n}" for n in side["Y"]]
    return "\n".join([*lines, "ENDDATA", ""])


@pytest.mark.parametrize(("kinds", "limit"), [(("S8R", "CQUAD8"), 0.035), (("STRI65", "CTRIA6"), 0.045)])
def test_a_plate_of_either_format_vibrates_as_navier_says(kinds, limit, tmp_path, measured):
    (tmp_path / "a.inp").write_text(abaqus(kinds[0]))
    (tmp_path / "a.bdf").write_text(nastran(kinds[1]))
    ours, theirs = (np.array(deck_modes(tmp_path / f"a.{end}", count=4).frequencies) for end in ("inp", "bdf"))
    assert ours == pytest.approx(theirs, rel=1e-9), "PSHELL without MID3 would be rigid in shear: both have it"
    measured(
        f"simply supported plate of {kinds[0]}, {kinds[1]}, 4 x 4: largest error of four frequencies",
        float(np.abs(ours / EXACT - 1.0).max()),
        at_most=limit,
        source="Navier",
    )


def test_a_cantilever_of_three_node_beams_follows_beam_theory(tmp_path, measured):
    n, length = 4, 400.0
    nodes = "".join(f"{k + 1}, {length * k / (2 * n)}, 0, 0\n" for k in range(2 * n + 1))
    beams = "".join(f"{k + 1}, {2 * k + 1}, {2 * k + 2}, {2 * k + 3}\n" for k in range(n))
    section = "*BEAM SECTION, SECTION=RECT, ELSET=P, MATERIAL=M\n10., 4.\n0, 1, 0\n"
    (tmp_path / "a.inp").write_text(
        f"*NODE\n{nodes}*ELEMENT, TYPE=B32, ELSET=P\n{beams}{section}{STEEL}*BOUNDARY\n1, 1, 6\n"
    )
    found = deck_modes(tmp_path / "a.inp", count=2).frequencies
    exact = 1.875104**2 / (2 * np.pi * length**2) * np.sqrt(7e4 / 2.7e-9 / 12) * np.array([4.0, 10.0])
    measured("cantilever of B32, first frequency", found[0], exact[0], rel=2e-3, unit="Hz", source="beam theory")
    assert found[1] == pytest.approx(exact[1], rel=2e-3)


SQUARE = (
    "*NODE\n1, 0, 0, 0\n2, 10, 0, 0\n3, 10, 10, 0\n4, 0, 10, 0\n5, 5, 0, 0\n6, 10, 5, 0\n7, 5, 10, 0\n8, 0, 5, 0\n"
    "9, 5, 5, 0\n*ELEMENT, TYPE=S8R, ELSET=P\n1, 1,2,3,4,5,6,7,8\n"
)
SHELL = "*SHELL SECTION, ELSET=P, MATERIAL=M\n0.5,\n" + STEEL


def test_surfaces_reach_the_middle_nodes(tmp_path):
    text = SQUARE + SHELL + "*SURFACE, NAME=TOP\nP, SPOS\n*SURFACE, NAME=RIM\nP, E2\n"
    (tmp_path / "a.inp").write_text(text)
    model = read_model(tmp_path / "a.inp")
    assert model.surfaces["TOP"].facets.tolist() == [[0, 0]]
    assert model.nodes.ids[model.surfaces["RIM"].nodes_idx].tolist() == [2, 6, 3]
    found = facets_of(model, "TOP", where="")
    areas = found.area_normals
    assert found.count == 5
    assert areas[:, 2].sum() == pytest.approx(100.0)
    assert (areas[:, 2] > 0.0).all()
    assert found.node_rows.size == 8
    assert nodes_of(model, "P", where="").thickness == pytest.approx(0.5)


@pytest.mark.parametrize(("kind", "n"), [("quad8", 8), ("tri6", 6)])
def test_facets_tile_the_element_once(kind, n):
    x = np.array([[0.0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1]])
    x = x if n == 8 else np.array([[0.0, 0], [2, 0], [0, 2], [1, 0], [1, 1], [0, 1]])
    corners = x[facets_of_shells(kind, np.arange(n)[None])[0]]
    first, second = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    area = 0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    assert (area > 0.0).all()
    assert area.sum() == pytest.approx(4.0 if n == 8 else 2.0)


def test_a_tied_patch_moves_with_the_middle_nodes_of_its_main_shell(tmp_path):
    """The node lies over the middle of the main shell: -1/4 of each corner, 1/2 of each middle node."""
    text = SQUARE + "*ELEMENT, TYPE=MASS, ELSET=W\n2, 9\n*MASS, ELSET=W\n1.\n" + SHELL
    text += "*SURFACE, NAME=MAIN\nP, SPOS\n*SURFACE, NAME=ONE, TYPE=NODE\n9,\n*TIE, NAME=T\nONE, MAIN\n"
    (tmp_path / "a.inp").write_text(text)
    (tie,) = read_model(tmp_path / "a.inp").constraints
    assert tie.nodes_idx.tolist() == list(range(8))
    assert tie.weights == pytest.approx([-0.25] * 4 + [0.5] * 4)


def card(name: str, grids: list[int]) -> str:
    place = ["0.,0.,0.", "10.,0.,0.", "10.,10.,0.", "0.,10.,0.", "5.,0.,0.", "10.,5.,0.", "5.,10.,0.", "0.,5.,0."]
    lines = ["SOL 103", "CEND", "BEGIN BULK", "MAT1,1,7.+4,,.3,2.7-9", "PSHELL,1,1,1.,1,,1"]
    lines += [f"GRID,{k},,{x}" for k, x in enumerate(place, 1)]
    fields = [str(g) if g else "" for g in grids]
    return "\n".join([*lines, f"{name},1,1,{','.join(fields[:6])},+", f"+,{','.join(fields[6:])}", "ENDDATA", ""])


def test_without_middle_grids_it_is_the_shell_of_four(tmp_path):
    path = tmp_path / "a.bdf"
    path.write_text(card("CQUAD8", [1, 2, 3, 4, 0, 0, 0, 0]))
    assert [b.kind for b in read_model(path).blocks] == ["quad4"]
    path.write_text(card("CQUAD8", [1, 2, 3, 4, 5, 0, 7, 8]))
    assert [b.kind for b in read_model(path).blocks] == ["quad8"]


def test_offset_and_thickness_of_quadratic_cards(tmp_path):
    """T1 to T4, THETA and ZOFFS after the grids; middle nodes take the mean of their corners."""
    path = tmp_path / "a.bdf"
    path.write_text(
        card("CQUAD8", [1, 2, 3, 4, 5, 6, 7, 8, 1, 2, 3, 2, 0, 4]).replace(",1,2,3,2,,4", ",1.,2.,3.,2.,,.25")
    )
    (block,) = read_model(path).blocks
    assert block.own.thickness[0].tolist() == [1.0, 2.0, 3.0, 2.0, 1.5, 2.5, 2.5, 1.5]
    assert block.own.arms[0] == pytest.approx(np.tile([0.0, 0.0, 0.25], (8, 1)))


@pytest.mark.parametrize("kind", ["S8R", "STRI65"])
def test_quadratic_shells_go_to_nastran_and_back(kind, tmp_path):
    (tmp_path / "a.inp").write_text(abaqus(kind).replace("*SHELL SECTION,", "*SHELL SECTION, OFFSET=0.5,"))
    model = read_model(tmp_path / "a.inp")
    write_nastran(replace(model, mass_form="linear"), tmp_path / "b.bdf")
    back = read_model(tmp_path / "b.bdf")
    assert [b.kind for b in back.blocks] == [b.kind for b in model.blocks]
    assert np.array_equal(back.blocks[0].nodes_idx, model.blocks[0].nodes_idx)


def test_viewers_know_every_shape_that_has_faces():
    """A kind without a cell would be drawn as a line; one without a descriptor would be left out."""
    assert {*FACES, *SHELL_FACETS} <= CELLS.keys()
    assert {*FACES, *SHELL_FACETS} <= DESCRIPTORS.keys()


def test_files_for_viewers_have_quadratic_cells():
    assert [CELLS[kind] for kind in ("quad8", "tri6", "beam3")] == [23, 22, 4], (
        "VTK_QUADRATIC_QUAD, _TRIANGLE, POLY_LINE"
    )
    assert [DESCRIPTORS[kind] for kind in ("quad8", "tri6")] == [95, 92], "thin shell, parabolic"
    assert [ORDER[kind] for kind in ("quad8", "tri6")] == [[0, 4, 1, 5, 2, 6, 3, 7], [0, 3, 1, 4, 2, 5]]


def test_beams_whose_middle_node_stands_last_are_refused(tmp_path):
    text = "*NODE\n1, 0, 0, 0\n2, 10, 0, 0\n3, 20, 0, 0\n*ELEMENT, TYPE=B32, ELSET=P\n7, 1, 3, 2\n"
    (tmp_path / "a.inp").write_text(f"{text}*BEAM SECTION, SECTION=RECT, ELSET=P, MATERIAL=M\n1., 2.\n0, 1, 0\n{STEEL}")
    with pytest.raises(InputError, match=r"element 7 \(B32\) goes back on itself: its second node is the one in the"):
        read_model(tmp_path / "a.inp")
