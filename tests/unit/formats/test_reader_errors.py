"""Every mistake in a deck ends in one message that says where, what and what to do."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from creak.errors import InputError
from creak.model.mesh import Model

Reader = Callable[[str], Model]

LINE = "*SHELL SECTION, ELSET=FRAME, MATERIAL=STEEL"
MISTAKES = {
    "element on unknown node": (" 7, 10, 20,", " 7, 10, 21,", "element 7 uses node 21, which is not defined"),
    "repeated element": (" 5, 20, 30", " 7, 20, 30", "element 7 is defined twice, first at .*:22"),
    "moved node": (" 201, 0., 13.7", " 30, 0., 13.7", r"node 30 is defined twice .*\(20, 0, 0\) at .*:8"),
    "no section": (f"{LINE}\n 0.7, 5\n", "", "2 elements of type S4R have no section: 7, 5"),
    "two sections": (f"{LINE}", f"{LINE}\n 0.7\n{LINE}", "element 7 gets a second section"),
    "wrong section": ("*MASS, ELSET=BALLAST", "*MASS, ELSET=CLIP", "holds element 92 of type SPRING2"),
    "unknown material": (
        "MATERIAL=STEEL",
        "MATERIAL=STELL",
        "unknown material 'STELL'. Did you mean 'STEEL'",
    ),
    "no elastic": ("*Elastic\n 210000., 0.3\n", "", r"material 'Steel' .* has no \*ELASTIC"),
    "no density": ("*Density\n 7.85e-9,\n", "", r"material 'Steel' .* has no \*DENSITY"),
    "temperature": (" 210000., 0.3", " 210000., 0.3, 20.\n 2.e5, 0.3, 10.", "temperatures of .ELASTIC do not rise"),
    "orthotropic": ("*Elastic, type=ISOTROPIC", "*Elastic, type=COUPLED TRACTION", r"\*ELASTIC, TYPE=COUPLED TRACTION"),
    "lamina": ("*Elastic, type=ISOTROPIC", "*Elastic, type=LAMINA", "constant 4 of material .* is missing"),
    "zero thickness": (" 0.7, 5", " 0., 5", "shell thickness is 0.; expected a number greater than zero"),
    "negative density": (" 7.85e-9,", " -7.85e-9,", "density of material 'Steel' is -7.85e-9"),
    "negative modulus": (" 210000., 0.3", " -1., 0.3", "Young's modulus of material 'Steel' is -1."),
    "incompressible": (" 210000., 0.3", " 1., 0.5", "Poisson's ratio of material 'Steel' is 0.5"),
    "element type": (
        "TYPE=S4R",
        "TYPE=S9R5",
        "unknown element type 'S9R5': creak has no shell of nine nodes.*Did you mean 'S8R'",
    ),
    "section on unknown set": (
        "ELSET=FRAME, MAT",
        "ELSET=FRAM, MAT",
        "unknown element set 'FRAM'. Did you mean 'FRAME'",
    ),
    "unknown surface": ("SURFACE=EDGE", "SURFACE=EDGES", "unknown surface 'EDGES'. Did you mean 'EDGE'"),
    "surface of unknown set": (
        " FRAME, SPOS",
        " FRMAE, SPOS",
        "unknown element set 'FRMAE'. Did you mean 'FRAME'",
    ),
    "unknown side": (" FRAME, SPOS", " FRAME, TOP", "unknown side 'TOP'"),
    "boundary of unknown set": (
        " 110, 2, 3",
        " PANEL_NODE, 2",
        "unknown node set 'PANEL_NODE'. Did you mean 'PANEL_N",
    ),
    "boundary of unknown node": (" 110, 2, 3", " 111, 2, 3", "there is no node 111"),
    "boundary type": ("ENCASTRE", "ENCASTER", "unknown type 'ENCASTER'.*Did you mean 'ENCASTRE'"),
    "boundary dof": (" 110, 2, 3", " 110, 2, 9", "last degree of freedom is 9; expected 1 to 6"),
    "boundary of no motion": (
        " 110, 2, 3",
        " 110, 11, 11",
        "is 11.* 11 is the temperature, which creak does not have: del",
    ),
    "boundary value": (" 110, 2, 3", " 110, 2, 3, 1.9", r"prescribes 1.9; expected 0.*\[excitation\]"),
    "malformed coordinate": (
        " 201, 0., 13.7",
        " 201, 0.x, 13.7",
        "coordinate of node 201 is '0.x'; expected a number",
    ),
    "coordinate not finite": (
        " 201, 0.,",
        " 201, nan,",
        "coordinate of node 201 is 'nan'; expected a finite number",
    ),
    "infinite coordinate": (" 201, 0.,", " 201, 1e999,", "coordinate of node 201 is '1e999'"),
    "underscore in a number": (" 201, 0.,", " 2_1, 0.,", "node label is '2_1'"),
    "malformed label": (" 7, 10, 20,", " 7, 10, 2o,", "node of element 7 is '2o'; expected an integer"),
    "truncated element": (
        " 7, 10, 20, 120, 110",
        " 7, 10, 20, 120",
        "element 7 of type S4R has 3 nodes; expected 4",
    ),
    "collapsed element": (
        " 7, 10, 20, 120, 110",
        " 7, 10, 20, 110, 110",
        "element 7 has the same node twice",
    ),
    "flat element": (" 206, 20., 13.7, 10.", " 206, 20., 13.7, 0.", r"element 42 \(S3\) has zero area"),
    "unknown reference node": (
        "REF NODE=901",
        "REF NODE=911",
        r"REF NODE= of \*COUPLING: there is no node 911",
    ),
    "reference set": ("REF NODE=901", "REF NODE=PAIRS", "REF NODE=PAIRS is a set of 3 nodes"),
    "coupling without kind": ("*KINEMATIC\n", "", r"\*COUPLING is followed by 0 of"),
    "range backwards": (" 41, 43", " 43, 41", "the range 43 to 41"),
    "range that misses its end": (" 41, 43", " 41, 44, 2", "does not end on its last number"),
    "range step zero": (" 41, 43", " 41, 43, 0", "in steps of 0"),
    "range of nothing": (" 41, 43", " 1041, 1043", "no element has a label in the range"),
    "composite": (LINE, LINE + ", COMPOSITE", "unknown material ''"),
    "offset": (LINE, LINE + ", OFFSET=EDGE", "OFFSET of the shell section is 'EDGE'"),
    "no material name": ("*Material, name=Steel", "*Material", r"\*MATERIAL has no NAME="),
    "orphan option": ("*Material, name=Steel\n", "", r"\*ELASTIC without \*MATERIAL"),
    "step not closed": ("*END STEP\n", "", r"\*STEP is not closed"),
    "nonlinear spring": ("*SPRING, ELSET=CLIP", "*SPRING, NONLINEAR, ELSET=CLIP", r"\*SPRING with NONLINEAR"),
    "negative mass": (" 1.e-4", " -1.e-4", "mass is -1.e-4"),
    "mpc with one node": (" BEAM, 902, 901", " BEAM, 902", r"\*MPC BEAM with 1 nodes"),
    "mpc sets": (" BEAM, 902, 901", " BEAM, 901, PAIRS", "links 1 to 3 nodes"),
    "unknown node in a set": (" 203, 130, 20\n", " 203, 131, 20\n", "there is no node 131"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistake_is_explained(read: Reader, flat: str, mistake: str) -> None:
    old, new, message = MISTAKES[mistake]
    assert old in flat
    with pytest.raises(InputError, match=message) as caught:
        read(flat.replace(old, new, 1))
    assert "deck.inp:" in caught.value.where
    assert caught.value.fix


def test_the_line_is_named(read: Reader, flat: str) -> None:
    text = flat.replace(" 110, 2, 3", " 999, 2, 3")
    line = text.split("\n").index(" 999, 2, 3") + 1
    with pytest.raises(InputError, match=rf"deck\.inp:{line}: there is no node 999"):
        read(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the deck is empty"),
        ("** nothing but a comment\n", "the deck is empty"),
        ("*HEADING\n", "the deck has no nodes"),
        ("*NODE\n 1, 0.\n", "the deck has no elements"),
        ("*NODE\n 1\n", "the deck has no elements"),
        ("*NODE\n 1, 0., 0., 0., 0., 0., 1., 2.\n", "node 1 has 7 numbers"),
        ("*\n", "a keyword line without a keyword"),
        ("*PART, NAME=P\n*NODE\n 1, 0.\n*END PART\n", r"the deck has parts \(P\) but no \*INSTANCE"),
    ],
)
def test_decks_with_nothing_in_them(read: Reader, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        read(text)
    assert "deck.inp" in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("part=Panel", "part=Pannel", "unknown part 'PANNEL'. Did you mean 'PANEL'"),
        ("*End Part\n", "", r"\*PART Frame is not closed"),
        ("*End Instance\n", "", r"\*INSTANCE Frame-1 is not closed"),
        ("instance=Panel-1", "instance=Panel-2", "unknown instance 'PANEL-2'. Did you mean 'PANEL-1'"),
        ("Panel-1.203\n", "Panel-1.999\n", "element 92 uses node Panel-1.999"),
        (" 0., 0., 0., 0., 0., 1., 90.", " 0., 0., 0., 0., 0., 0., 90.", "the rotation axis coincide"),
        ('name="Panel-1"', "name=Frame-1", "instance 'FRAME-1' is defined twice"),
        ("Frame-1.10, ENCASTRE", "10, ENCASTRE", "write INSTANCE.LABEL"),
        (" 7, 10, 20,", " 7, 10, 21,", "element 7 uses node 21, which is not defined in instance 'FRAME-1'"),
    ],
)
def test_mistakes_with_instances(read: Reader, parts: str, old: str, new: str, message: str) -> None:
    assert old in parts
    with pytest.raises(InputError, match=message):
        read(parts.replace(old, new, 1))


def test_generated_nodes_are_the_reason_and_not_the_element_without_them(read: Reader, flat: str) -> None:
    text = flat.replace(" 7, 10, 20,", " 7, 10, 21,") + "*NGEN\n 20, 30, 1\n"
    with pytest.raises(InputError, match=r"\*NGEN is not read, so that nodes are missing .*element 7 uses node 21"):
        read(text)


def test_a_misspelled_keyword_is_pointed_out_with_the_error_it_causes(read: Reader, flat: str) -> None:
    with pytest.raises(
        InputError, match=r"uses node 10.*\*NODES at .*:4 is not a keyword that creak knows. Did you mean 'NODE'"
    ):
        read(flat.replace("*NODE, NSET=FRAME_NODES", "*NODES, NSET=FRAME_NODES"))


def test_beam_along_its_own_axis(read: Reader, flat: str) -> None:
    beam = (
        "*ELEMENT, TYPE=B31, ELSET=ROD\n 60, 201, 204\n"
        "*BEAM SECTION, ELSET=ROD, MATERIAL=STEEL, SECTION=CIRC\n 1.\n*MPC"
    )
    with pytest.raises(InputError, match=r"element 60 \(B31\) lies along the direction of its section axis 1"):
        read(flat.replace("*MPC", beam))
