"""Solid elements, their sections and their surfaces."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from creak.assembly.part import Rayleigh, part_system
from creak.contact.facets import facets_of
from creak.errors import InputError
from creak.model.materials import BeamSection, SolidSection, TrussSection
from creak.model.mesh import Model

Reader = Callable[[str], Model]

DECK = """\
*NODE
 1, 0., 0., 0.
 2, 2., 0., 0.
 3, 2., 2., 0.
 4, 0., 2., 0.
 5, 0., 0., 3.
 6, 2., 0., 3.
 7, 2., 2., 3.
 8, 0., 2., 3.
 9, 4., 0., 0.
 10, 4., 0., 3.
 11, 0., 0., 5.
 12, 1., 1., 7.
*ELEMENT, TYPE=C3D8R, ELSET=BODY
 1, 1, 2, 3, 4, 5,
 6, 7, 8
*ELEMENT, TYPE=C3D6, ELSET=BODY
 2, 2, 9, 3, 6, 10, 7
*ELEMENT, TYPE=C3D4, ELSET=BODY
 3, 5, 6, 7, 11
*ELEMENT, TYPE=T3D2, ELSET=ROD
 4, 11, 12
*ELEMENT, TYPE=S4, ELSET=SKIN
 5, 1, 4, 8, 5
*SOLID SECTION, ELSET=BODY, MATERIAL=STEEL, ORIENTATION=O
 1.,
*SOLID SECTION, ELSET=ROD, MATERIAL=STEEL
 0.5
*SHELL SECTION, ELSET=SKIN, MATERIAL=STEEL
 0.1
*MATERIAL, NAME=STEEL
*ELASTIC
 210000., 0.3
*DENSITY
 1e-3
*SURFACE, NAME=TOP
 1, S2
 3, S1
*SURFACE, NAME=FREE
 BODY
*SURFACE, NAME=MIXED
 SKIN, SPOS
 BODY, S3
"""


def areas(model: Model, name: str) -> dict[tuple[float, ...], float]:
    """Outward direction -> area of a surface."""
    out: dict[tuple[float, ...], float] = {}
    for normal in facets_of(model, name, where="").area_normals:
        area = float(np.linalg.norm(normal))
        key = tuple((np.round(normal / area, 6) + 0.0).tolist())
        out[key] = out.get(key, 0.0) + area
    return out


def test_solids_are_read_with_their_section_and_mass(read: Reader) -> None:
    model = read(DECK)
    assert [(b.kind, b.nodes_idx.shape) for b in model.blocks] == [
        ("hex8", (1, 8)),
        ("wedge6", (1, 6)),
        ("tet4", (1, 4)),
        ("truss2", (1, 2)),
        ("quad4", (1, 4)),
    ]
    assert all(isinstance(b.section, SolidSection) for b in model.blocks[:3])
    assert isinstance(model.blocks[3].section, TrussSection)
    assert model.nodes.ids[model.blocks[0].nodes_idx[0]].tolist() == list(range(1, 9))
    system = part_system(model, 0, Rayleigh(0.0, 0.0))
    rod = 0.5 * np.sqrt(1 + 1 + 4)
    assert system.stats.mass == pytest.approx(1e-3 * (12 + 6 + 2 * 2 * 2 / 6 + rod + 0.6), rel=1e-12)


def test_what_is_computed_otherwise_than_in_abaqus_is_noted(read: Reader) -> None:
    notes = {u.keyword: u.why for u in read(DECK).unread if not u.changes_answer}
    assert "no hourglass modes" in notes["*ELEMENT, TYPE=C3D8R"]
    assert not any(u.changes_answer for u in read(DECK).unread)


def test_faces_by_number_look_outward(read: Reader) -> None:
    model = read(DECK)
    assert model.surfaces["TOP"].side.tolist() == [2, 1]
    # The tetrahedron's face S1 lies on the hexahedron's S2.
    assert areas(model, "TOP") == pytest.approx({(0.0, 0.0, 1.0): 4.0, (0.0, 0.0, -1.0): 2.0})
    mixed = areas(model, "MIXED")
    assert mixed[1.0, 0.0, 0.0] == pytest.approx(6.0)  # the skin's positive side, of 1-4-8-5
    assert mixed[0.0, -1.0, 0.0] == pytest.approx(6.0 + 6.0)  # S3 of hexahedron and wedge


def test_surface_without_faces_is_all_that_is_free(read: Reader) -> None:
    """The quadrilateral between hexahedron and wedge is gone; triangles on quadrilaterals stay."""
    model = read(DECK)
    free = areas(model, "FREE")
    assert free[0.0, -1.0, 0.0] == pytest.approx(12.0 + 2.0)
    assert free[-1.0, 0.0, 0.0] == pytest.approx(6.0)
    assert (1.0, 0.0, 0.0) not in free
    by_set = areas(model, "BODY")
    assert by_set == pytest.approx(free)


def test_a_coupling_of_nodes_on_a_line_is_told(read: Reader) -> None:
    text = DECK + "*NODE\n 90, 1., 1., 0.\n*NSET, NSET=TWO\n 1, 2\n*SURFACE, NAME=EDGE, TYPE=NODE\n TWO\n"
    model = read(text + "*COUPLING, CONSTRAINT NAME=C, REF NODE=90, SURFACE=EDGE\n*DISTRIBUTING\n")
    assert model.constraints[0].turns_on_line
    (note,) = (u for u in model.unread if "on a line" in u.keyword)
    assert not note.changes_answer


def test_coupling_to_a_face_of_solids_weighs_by_area(read: Reader) -> None:
    text = DECK + "*NODE\n 90, 1., 1., 0.\n*SURFACE, NAME=FOOT\n 1, S1\n 2, S1\n"
    text += "*COUPLING, CONSTRAINT NAME=C, REF NODE=90, SURFACE=FOOT\n*DISTRIBUTING\n"
    coupling = read(text).constraints[0]
    weights = dict(zip((coupling.nodes_idx + 1).tolist(), coupling.weights.tolist(), strict=True))
    assert weights == pytest.approx({1: 1.0, 4: 1.0, 2: 1.0 + 2 / 3, 3: 1.0 + 2 / 3, 9: 2 / 3})


@pytest.mark.parametrize("parameter", ["COUPLING", "ROTATIONAL COUPLING"])
@pytest.mark.parametrize("shells", [False, True])
def test_structural_coupling_of_nodes_without_rotations_is_that_of_the_continuum(
    read: Reader, parameter: str, shells: bool
) -> None:
    """On solids it is read; at a shell, with rotations to couple, it changes the answer."""
    faces = " 1, S1\n 2, S1\n" if shells else " 2, S1\n"
    text = DECK + f"*NODE\n 90, 1., 1., 0.\n*SURFACE, NAME=FOOT\n{faces}"
    text += "*COUPLING, CONSTRAINT NAME=C, REF NODE=90, SURFACE=FOOT\n*DISTRIBUTING"
    plain, model = read(text + "\n"), read(f"{text}, {parameter}=STRUCTURAL\n")
    np.testing.assert_array_equal(model.constraints[0].weights, plain.constraints[0].weights)
    (note,) = (u for u in model.unread if "STRUCTURAL" in u.keyword)
    assert note.changes_answer == shells
    assert ("no published source" if shells else "the coupled nodes have no rotations") in note.why


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (" 1, S2\n", " 1, S7\n", "unknown face 'S7' of a solid; expected S1 to S6"),
        (" 3, S1\n", " 3, S5\n", r"element 3 \(C3D4\) has no face S5"),
        (" 1, S2\n", " ROD, S2\n", r"element 4 \(T3D2\) of 'ROD' is not a shell or a solid"),
        (
            "*SOLID SECTION, ELSET=BODY",
            "*ELSET, ELSET=ALL\n BODY, ROD\n*SOLID SECTION, ELSET=ALL",
            "holds both solids and",
        ),
        ("MATERIAL=STEEL, ORIENTATION=O", "COMPOSITE", "COMPOSITE is not supported"),
        (" 6, 7, 8\n", " 6, 7, 7\n", "element 1 has the same node twice.*C3D6"),
        ("TYPE=C3D8R", "TYPE=C3D27", "unknown element type 'C3D27'"),
    ],
)
def test_wrong_solids_are_refused_with_their_line(read: Reader, old: str, new: str, message: str) -> None:
    assert old in DECK
    with pytest.raises(InputError, match=r"deck.inp:\d+: .*" + message):
        read(DECK.replace(old, new, 1))


def test_inverted_solid_is_named(read: Reader) -> None:
    model = read(DECK.replace(" 1, 1, 2, 3, 4, 5,\n 6, 7, 8\n", " 1, 5, 6, 7, 8, 1,\n 2, 3, 4\n"))
    with pytest.raises(InputError, match=r"element 1: no volume, or nodes in the wrong order"):
        part_system(model, 0, Rayleigh(0.0, 0.0))


@pytest.mark.parametrize(
    ("section", "radius"),
    [
        ("*BEAM SECTION, SECTION=CIRC, ELSET=WIRE, MATERIAL=STEEL\n 0.3\n", 0.3),
        ("*BEAM SECTION, SECTION=PIPE, ELSET=WIRE, MATERIAL=STEEL\n 3D-1, 0.1\n", 0.3),
        ("*BEAM SECTION, SECTION=RECT, ELSET=WIRE, MATERIAL=STEEL\n 0.3, 0.2\n", 0.1),
        ("*BEAM GENERAL SECTION, ELSET=WIRE, DENSITY=1.\n 1., 1., 0., 1., 2.\n\n 2.6, 1.\n", 0.0),
    ],
)
def test_beams_know_how_far_their_surface_is(read: Reader, section: str, radius: float) -> None:
    model = read(DECK + "*ELEMENT, TYPE=B31, ELSET=WIRE\n 60, 11, 12\n" + section)
    found = [b.section.radius for b in model.blocks if isinstance(b.section, BeamSection)]
    assert found == [radius]
