"""Glued contact of NX and MSC: two blocks end to end against the same bar in one piece.

RSSCON: shells clamped to solids.
"""

from __future__ import annotations

import numpy as np
import pytest

from creak.assembly.coupling import Driven
from creak.assembly.elimination import linear_equations
from creak.errors import InputError
from creak.studies.models.deck_modes import model_modes
from helpers_fem import rigid_modes
from helpers_nastran import motion, read, row, unread

CASE = "SPC = 1\n{}\n"
MATERIAL = "PSOLID,1,1\nPSOLID,2,1\nMAT1,1,2.+5,,.3,7.8-9\n"


def block(base: int, pid: int, n: int, x0: float, x1: float, cross: int) -> str:
    """A bar of 10 x 10 mm from x0 to x1: n CHEXA along it, cross x cross across it."""
    lines, side = [], cross + 1
    for i in range(n + 1):
        for j in range(side):
            for k in range(side):
                grid = base + side * side * i + side * j + k
                lines.append(f"GRID,{grid},,{x0 + (x1 - x0) * i / n},{10.0 * j / cross},{10.0 * k / cross}")
    for i in range(n):
        for j in range(cross):
            for k in range(cross):
                a = base + side * side * i + side * j + k
                ring = [a, a + side * side, a + side * side + side, a + side]
                grids = [*ring, *(g + 1 for g in ring)]
                lines.append(f"CHEXA,{base + len(lines)},{pid}," + ",".join(str(g) for g in grids[:6]))
                lines.append(",".join(["", *(str(g) for g in grids[6:])]))
    return "\n".join(lines) + "\n"


def bar(gap: float = 0.0, cross: int = 1) -> str:
    held = "SPC1,1,123," + ",".join(str(1001 + i) for i in range(4)) + "\n"
    return block(1001, 1, 5, 0.0, 50.0, 1) + block(5001, 2, 5, 50.0 + gap, 100.0 + gap, cross) + held + MATERIAL


def frequencies(model, count=6):
    return model_modes(model, Driven({}), count=count)[1].frequencies


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    bulk = block(1001, 1, 10, 0.0, 100.0, 1) + "SPC1,1,123,1001,1002,1003,1004\n" + MATERIAL
    return frequencies(read(tmp_path_factory.mktemp("whole"), bulk))


REGIONS = "BCPROPS,11,1\nBCPROPS,12,2\n"
BODIES = "BCBODY,1,3D,DEFORM,11\nBCBODY,2,3D,DEFORM,12\nBCPROP,11,1\nBCPROP,12,2\n"
GLUED = {
    "NX": ("BGSET = 7", REGIONS + "BGSET,7,11,12,.5\n"),
    "NX, sets added": ("BGSET = 9", REGIONS + "BGADD,9,7\nBGSET,7,12,11\n"),
    "MSC table": ("BCONTACT = 3", BODIES + "BCTABLE,3,,,1\n,SLAVE,1,.5,,,,1\n,,0,0,1\n,MASTERS,2\n"),
    "MSC table, new words": ("BCONTACT = 3", BODIES + "BCTABLE,3,,,1\n,SECNDRY,1,,,,,3\n,PRIMARY,2\n"),
    "MSC pairs": (
        "BCONTACT = 3",
        BODIES + "BCTABL1,3,57\nBCONECT,57,90,,2,1\nBCONPRG,90,,ICOORD,1,IGLUE,1\n",
    ),
    "MSC pairs of lists": (
        "BCONTACT = 3",
        BODIES + "BCTABL1,3,57\nBCONECT,57,90\n,SECNDRY,1\n,PRIMARY,2\nBCONPRG,90,,IGLUE,1,ERROR,.4\n",
    ),
}


@pytest.mark.parametrize("form", GLUED)
def test_glued_blocks_are_one_bar(tmp_path, whole, form):
    case, cards = GLUED[form]
    model = read(tmp_path, bar() + cards, CASE.format(case))
    assert not any(unread(model).values())
    assert "regions" in " ".join(unread(model))
    assert frequencies(model) == pytest.approx(whole, rel=1e-9)


@pytest.mark.parametrize("form", ["NX", "MSC pairs of lists"])
def test_glue_bridges_a_gap_and_unlike_meshes(tmp_path, whole, form):
    """The finer side follows the coarser one; the bar is then as long as gap and blocks."""
    case, cards = GLUED[form]
    model = read(tmp_path, bar(0.2, 2) + cards, CASE.format(case))
    assert frequencies(model, 2) == pytest.approx(whole[:2], rel=0.02)
    ids = {int(model.nodes.ids[c.nodes_idx[0]]) for c in model.constraints}
    assert len(ids) == 9
    assert min(ids) > 5000


def test_faces_of_bsurfs(tmp_path, whole):
    """One element's face by three of its grids."""
    faces = "BSURFS,11,,,,1148,1021,1022,1023\nBSURFS,12,,,,5126,5001,5002,5003\n"
    bulk = bar()
    ends = [line.split(",")[1] for line in bulk.splitlines() if line.startswith("CHEXA")]
    faces = faces.replace("1148", ends[4]).replace("5126", ends[5])
    model = read(tmp_path, bulk + faces + "BGSET,7,11,12,.5\n", CASE.format("BGSET = 7"))
    assert frequencies(model) == pytest.approx(whole, rel=1e-9)


def test_glue_that_is_not_taken_or_not_glue(tmp_path):
    """No BGSET in the case control; a table whose pair has IGLUE 0."""
    for case, cards in (
        ("", GLUED["NX"][1]),
        (GLUED["MSC pairs"][0], GLUED["MSC pairs"][1].replace("IGLUE,1", "IGLUE,0")),
    ):
        model = read(tmp_path, bar() + cards, CASE.format(case))
        assert not model.constraints
        assert not any(unread(model).values())


@pytest.mark.parametrize(
    ("case", "cards", "message"),
    [
        ("BGSET = 7", REGIONS + "BGSET,7,11,13,.5\n", "region 13 without shells or solids"),
        ("BGSET = 7", REGIONS + "BGSET,7,11,12,.5\n", "do not meet within 0.5"),
        ("BCONTACT = 3", GLUED["MSC table"][1].replace("2,3D,DEFORM", "2,3D,RIGID"), "body 2, which is RIGID"),
        (
            "BCONTACT = 3",
            GLUED["MSC table"][1].replace("MASTERS,2", "MASTERS,5"),
            "contact body 5, which is not defined",
        ),
    ],
)
def test_glue_that_cannot_be_done_stops(tmp_path, case, cards, message):
    with pytest.raises(InputError, match=message):
        read(tmp_path, bar(5.0) + cards, CASE.format(case))


N, LENGTH, P = 8, 80.0, 0.01
BLOCK = {1: (-10, 0, -1), 2: (0, 0, -1), 3: (0, 10, -1), 4: (-10, 10, -1)}
BLOCK |= {k + 4: (x, y, 1) for k, (x, y, _) in BLOCK.items()}


def deck(card: str) -> str:
    """A strip of N quads on the face x = 0 of a stiff block that is held behind."""
    places = BLOCK | {11 + 2 * i + j: (LENGTH * i / N, 10 * j, 0) for i in range(N + 1) for j in range(2)}
    lines = [f"GRID,{k},,{x:.4f},{y:.1f},{z:.1f}" for k, (x, y, z) in places.items()]
    lines += [f"CQUAD4,{i + 1},1,{11 + 2 * i},{13 + 2 * i},{14 + 2 * i},{12 + 2 * i}" for i in range(N)]
    lines += ["CHEXA,99,2,1,2,3,4,5,6,+", "+,7,8", "PSOLID,2,2", "PSHELL,1,1,1.,1,,1"]
    lines += ["MAT1,1,7.+4,,0.,2.7-9", "MAT1,2,7.+9,,0.,2.7-9", "SPC1,1,123,1,4,5,8", card]
    return "\n".join(lines)


GRIDS = "RSSCON,50,GRID,11,2,6,12,3,7"


def test_a_strip_on_a_stiff_block_is_a_cantilever(tmp_path):
    model = read(tmp_path, deck(GRIDS))
    tips = (11 + 2 * N, 12 + 2 * N)
    sunk = motion(model, {(tip, 3): 0.5 * P for tip in tips})[row(model, tips[0])]
    assert sunk[2] == pytest.approx(P * LENGTH**3 / (3 * 7e4 * 10 / 12), rel=5e-3)
    pulled = motion(model, {(tip, 1): 0.5 * P for tip in tips})[row(model, tips[0])]
    assert pulled[0] == pytest.approx(P * LENGTH / (7e4 * 10), rel=1e-3)


def test_rigid_motion_breaks_no_equation_and_a_kink_does(tmp_path):
    model = read(tmp_path, deck(GRIDS))
    equations = [e for c in model.constraints for e in linear_equations(c, model.nodes.coords)]
    assert len(equations) == 2 * 5
    modes = rigid_modes(model.nodes.coords)
    assert max(abs(modes[list(e.labels)].T @ e.coefficients).max() for e in equations) < 1e-12
    kink = np.zeros((model.nodes.count, 6))
    kink[row(model, 11), 4] = 1.0
    assert max(abs(kink.ravel()[list(e.labels)] @ e.coefficients) for e in equations) == pytest.approx(1.0)


def test_what_cannot_be_joined_is_told(tmp_path):
    with pytest.raises(InputError, match="grid 13 of RSSCON 50 does not lie between grids 2 and 6"):
        read(tmp_path, deck("RSSCON,50,GRID,13,2,6"))
    (found,) = [u for u in read(tmp_path, deck("RSSCON,50,ELEM,1,99")).unread if u.changes_answer]
    assert found.keyword == "RSSCON, TYPE = ELEM"
