"""Superelements of a study: the damping that they bring, and the nodes that they join."""

from __future__ import annotations

import numpy as np
import pytest

from creak.arrays import FloatArray, to_dense
from creak.assembly.system import System
from creak.errors import InputError
from creak.formats.matrices.npz import write_npz
from creak.formats.matrices.op4_file import write_op4_matrices
from creak.model.superelement import Superelement
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import Setup, set_up
from helpers_decks import write_study

DECK = """*NODE, NSET=ALL
 1, 0., 0., 0.
 2, 3., 0., 0.
*ELEMENT, TYPE=SPRING2, ELSET=S
 1, 1, 2
*ELEMENT, TYPE=MASS, ELSET=M
 2, 2
*SPRING, ELSET=S
 1, 1
 90.
*MASS, ELSET=M{alpha}
 .4
*BOUNDARY
 1, 1, 6
 2, 2, 3
"""
STUDY = """[model]
deck = "deck.inp"
units = "m-kg-s"
{damping}
[nodes.P]
labels = [2]
[excitation.f]
node_set = "P"
dof = "x"
kind = "force"
signal = {{ type = "sine", frequency = 1.0, amplitude = 1.0 }}
[time]
end = 0.1
[output]
nodes = ["P"]
[superelement.S]
file = "s.npz"
{more}
"""
K, M, C = (np.array([[a, -b], [-b, b]]) for a, b in ((50.0, 20.0), (0.3, 0.1), (6.0, 2.0)))
"""Of node 2 along x and a generalised coordinate."""


def ready(folder, deck: str, study: str, place: list[float] | None = None) -> Setup:
    """With a superelement of node 2, which may say where that lies."""
    positions: dict[int, FloatArray] = {} if place is None else {2: np.array(place)}
    write_npz(Superelement("S", np.array([2, 0]), np.array([1, 0]), K, M, C, positions), folder / "s.npz")
    return set_up(read_study(write_study(folder, study, {"deck.inp": deck})))


def damping_of(system: System) -> np.ndarray:
    d = system.damping
    whole = d.alpha * to_dense(system.M) + d.beta * to_dense(system.K)
    return whole if d.extra is None else whole + to_dense(d.extra)


@pytest.mark.parametrize(
    ("damping", "alpha", "expected"),
    [
        ("", "", C),
        ("", ", ALPHA=7.", C),
        ("[damping]\nrayleigh = { alpha = 3.0, beta = 0.01 }", "", 3.0 * M + 0.01 * K),
        ("[damping]\nmodal = 0.02", "", 0.0 * M),
    ],
    ids=["none", "of the deck", "rayleigh", "modal"],
)
def test_damping_of_a_study_replaces_that_of_a_superelement(tmp_path, damping, alpha, expected):
    setup = ready(tmp_path, DECK.format(alpha=alpha), STUDY.format(damping=damping, more=""))
    np.testing.assert_allclose(damping_of(setup.structure.superelements[0]), expected, rtol=1e-14, atol=1e-14)
    said = [note for note in setup.notes if "superelement S: its own damping is left out" in note]
    assert len(said) == (1 if damping else 0)


INSTANCES = """*PART, NAME=P
*NODE, NSET=ALL
 1, 0., 0., 0.
 2, 3., 0., 0.
*ELEMENT, TYPE=SPRING2, ELSET=S
 1, 1, 2
*ELEMENT, TYPE=MASS, ELSET=M
 2, 2
*SPRING, ELSET=S
 1, 1
 90.
*MASS, ELSET=M
 .4
*END PART
*ASSEMBLY, NAME=A
*INSTANCE, NAME=A-1, PART=P
*END INSTANCE
*INSTANCE, NAME=B-1, PART=P
 0., {apart}, 0.
*END INSTANCE
*NSET, NSET=ROOT, INSTANCE=A-1
 1
*NSET, NSET=ROOT, INSTANCE=B-1
 1
*NSET, NSET=P, INSTANCE=A-1
 2
*NSET, NSET=P, INSTANCE=B-1
 2
*END ASSEMBLY
*BOUNDARY
 ROOT, 1, 6
 P, 2, 3
"""


def joined(folder, place: list[float] | None, more: str = "", apart: float = 2.0) -> str:
    """The node of a deck with two instances that a superelement of node 2 joins."""
    text = STUDY.format(damping="", more=more).replace("[nodes.P]\nlabels = [2]\n", "")
    setup = ready(folder, INSTANCES.format(apart=apart), text, place)
    return setup.model.nodes.label(int(setup.structure.superelements[0].coordinates[0]) // 6)


def test_a_superelement_joins_the_instance_where_it_lies(tmp_path):
    assert joined(tmp_path, [3.0, 0.0, 0.0]) == "A-1.2"
    assert joined(tmp_path, [3.0, 2.0, 0.0]) == "B-1.2"
    assert joined(tmp_path, [3.0, 2e-4, 0.0], apart=2e-4) == "B-1.2"  # skins closer than nodes may be off


def test_a_superelement_joins_the_instance_that_the_study_names(tmp_path):
    assert joined(tmp_path, None, 'instance = "A-1"') == "A-1.2"
    assert joined(tmp_path, None, 'instance = "b-1"') == "B-1.2"
    assert joined(tmp_path, [3.0, 0.0, 0.0], 'instance = "B-1"', apart=0.0) == "B-1.2"


@pytest.mark.parametrize(
    ("place", "more", "apart", "message"),
    [
        (None, "", 2.0, r"node 2, of which the deck has 2 \(A-1\.2, B-1\.2\), and does not say .*instance = \"A-1\""),
        ([3.0, 0.0, 0.0], "", 0.0, r"\(A-1\.2, B-1\.2\), and has more than one of them at its place"),
        ([3.0, 1.6, 0.0], "", 2.0, r"node B-1\.2 lies at .* None of A-1\.2, B-1\.2 lies there"),
        ([3.0, 2.0, 0.0], 'instance = "A-1"', 2.0, r"node A-1\.2 lies at \[3\.0, 0\.0, 0\.0\]"),
        (None, 'instance = "C-1"', 2.0, r"study\.toml:\d+.* unknown instance 'C-1'"),
    ],
    ids=["no place", "one place", "elsewhere", "other instance", "unknown"],
)
def test_a_superelement_that_could_join_more_nodes_is_refused(tmp_path, place, more, apart, message):
    with pytest.raises(InputError, match=message):
        joined(tmp_path, place, more, apart)


DISPLACED = """CORD2R,6,,0.,0.,0.,{z}
,{x}
GRID,1,,0.,0.,0.
GRID,2,,3.,0.,0.,6
CELAS2,1,90.,2,1
CELAS2,3,90.,2,2
CELAS2,4,90.,2,3
CONM2,2,2,,.4
SPC1,1,123456,1
SPC1,1,456,2
ENDDATA
"""
"""Grid 2 moves in a frame of its own."""
FRAMES = {
    "about z": ("0.,0.,1.", ".8,.6,0.", np.array([[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])),
    "oblique": ("0.,.6,.8", "1.,0.,0.", np.array([[1.0, 0.0, 0.0], [0.0, 0.8, 0.6], [0.0, -0.6, 0.8]])),
}
OF_GRID = np.array([[80.0, 10.0], [10.0, 30.0]])
"""Stiffness along directions 1 and 2 of grid 2; a tenth of it is the mass, and a point 50 is tied to direction 2."""
DMIG = "".join(
    f"DMIG,{name},0,6,1,0\nDMIG,{name},2,1,,2,1,{80.0 * f},,,\n,2,2,{10.0 * f}\nDMIG,{name},2,2,,2,2,{30.0 * f},,,\n"
    f",50,0,{-4.0 * f}\nDMIG,{name},50,0,,50,0,{20.0 * f}\n"
    for name, f in (("KAAX", 1.0), ("MAAX", 0.1))
)
POINTS = {
    "no cards": ("s.pch", "", True),
    "cards of its own, basic": ("s.pch", "GRID,2,,3.,0.,0.\n", False),
    "table of OP4": ("s.op4", "", True),
    "npz": ("s.npz", "", False),
}


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("way", POINTS)
def test_rows_are_along_the_frame_of_the_grid_where_the_file_gives_none(tmp_path, way, frame):
    """Nastran's matrices are along the displacement frames (CD): A = R A' R' with R the directions of the grid.

    Directions 1 and 2 are all the superelement has, so that along global axes it has those they have a part of.
    """
    file, cards, turned = POINTS[way]
    z, x, R = FRAMES[frame]
    whole = np.zeros((3, 3))
    whole[:2, :2] = OF_GRID
    whole[2, 2], whole[1, 2], whole[2, 1] = 20.0, -4.0, -4.0
    nodes, dofs = np.array([2, 2, 0]), np.array([1, 2, 0])
    (tmp_path / "s.pch").write_text(cards + DMIG)
    write_op4_matrices({"KXX": whole, "MXX": 0.1 * whole}, tmp_path / "s.op4")
    (tmp_path / "s_dofs.csv").write_text("node,dof\n2,1\n2,2\n0,0\n")
    write_npz(Superelement("S", nodes, dofs, whole, 0.1 * whole), tmp_path / "s.npz")
    bulk = DISPLACED.format(z=z, x=x)
    (tmp_path / "deck.bdf").write_text(f"SOL 103\nCEND\nSPC = 1\nBEGIN BULK\n{bulk}")
    study = STUDY.format(damping="", more="").replace("deck.inp", "deck.bdf").replace("s.npz", file)
    (tmp_path / "study.toml").write_text(study)
    setup = set_up(read_study(tmp_path / "study.toml"))
    system = setup.structure.superelements[0]
    row = 6 * setup.model.nodes.ids.tolist().index(2)
    order = [system.coordinates.tolist().index(row + k) if row + k in system.coordinates else -1 for k in range(3)]
    order = [k for k in order if k >= 0] + np.flatnonzero(system.coordinates < 0).tolist()
    T = np.eye(4)
    T[:3, :3] = R if turned else np.eye(3)
    local = np.zeros((4, 4))
    local[np.ix_([0, 1, 3], [0, 1, 3])] = whole
    expected = T @ local @ T.T
    kept = np.flatnonzero(expected.any(axis=1))
    for A, factor in ((system.K, 1.0), (system.M, 0.1)):
        np.testing.assert_allclose(to_dense(A)[np.ix_(order, order)], factor * expected[np.ix_(kept, kept)], atol=1e-13)
    assert any("along the displacement frames (CD) of the deck" in note for note in setup.notes) == turned
