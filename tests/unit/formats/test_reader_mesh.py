"""Nodes, elements, sets, surfaces and sections, flat and with instances."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from creak.arrays import FloatArray
from creak.model.constraints import DistributingCoupling, KinematicCoupling, RigidLink
from creak.model.materials import PointMass, ShellSection, Spring
from creak.model.mesh import Model

Reader = Callable[[str], Model]


def _by_id(model: Model) -> dict[int, FloatArray]:
    return dict(zip(model.nodes.ids.tolist(), model.nodes.coords, strict=True))


def _labels(model: Model, name: str) -> list[str]:
    return [model.nodes.label(int(i)) for i in model.node_set(name)]


def test_flat_and_instanced_decks_have_the_same_geometry(read: Reader, flat: str, parts: str) -> None:
    one, two = read(flat), read(parts)
    a, b = _by_id(one), _by_id(two)
    assert a.keys() == b.keys()
    for label, xyz in a.items():
        assert_allclose(b[label], xyz, atol=1e-12 * 25.0)  # round-off of one rotation of 25 mm
    for p, q in zip(one.blocks, two.blocks, strict=True):
        assert (p.kind, p.part) == (q.kind, q.part)
        assert_array_equal(p.ids, q.ids)
        assert_array_equal(one.nodes.ids[p.nodes_idx], two.nodes.ids[q.nodes_idx])


def test_labels_with_gaps_in_any_order_become_rows(read: Reader, flat: str) -> None:
    model = read(flat)
    assert model.nodes.ids[:3].tolist() == [130, 10, 20]
    assert model.nodes.ids[model.blocks[0].nodes_idx].tolist() == [[10, 20, 120, 110], [20, 30, 130, 120]]


def test_coordinates_that_a_line_leaves_out_are_zero(read: Reader) -> None:
    """A cube written short; CalculiX 2.20 gives back the same coordinates (job.frd)."""
    cube = "*NODE\n1\n2, 10.\n3, 10., 10.\n4, , 10.\n5,,,10.\n6, 10.,, 10.\n7, 10., 10., 10.\n8, , 10., 10.\n"
    cube += "*ELEMENT, TYPE=C3D8, ELSET=E\n1, 1, 2, 3, 4, 5, 6, 7, 8\n*SOLID SECTION, ELSET=E, MATERIAL=M\n"
    found = read(cube + "*MATERIAL, NAME=M\n*ELASTIC\n2.1E5, 0.3\n*DENSITY\n7.8E-9\n").nodes.coords / 10.0
    square = [[0, 0], [1, 0], [1, 1], [0, 1]]
    assert found.tolist() == [[*xy, z] for z in (0, 1) for xy in square]


def test_blocks_have_one_kind_section_and_part(read: Reader, flat: str) -> None:
    model = read(flat)
    assert [(b.kind, b.part) for b in model.blocks] == [
        ("quad4", 0),
        ("quad4", 1),
        ("tri3", 1),
        ("mass", 1),
        ("spring2", -1),
    ]
    shell, mass, spring = (model.blocks[k].section for k in (0, 3, 4))
    assert isinstance(shell, ShellSection)
    assert (shell.thickness, shell.material.name, shell.material.alpha) == (0.7, "Steel", 1.5)
    assert isinstance(mass, PointMass)
    assert mass.mass == 1e-4
    assert isinstance(spring, Spring)
    assert (spring.dof1, spring.dof2, spring.stiffness) == (2, 2, 100.0)


def test_fortran_exponents(read: Reader, flat: str) -> None:
    section = read(flat).blocks[1].section
    assert isinstance(section, ShellSection)
    assert section.material.density == 8.3e-10


def test_node_sets_keep_deck_order(read: Reader, flat: str, parts: str) -> None:
    assert _labels(read(flat), "pairs") == ["203", "130", "20"]
    assert _labels(read(parts), "Pairs") == ["PANEL-1.203", "FRAME-1.130", "FRAME-1.20"]


def test_sets_of_sets_and_generated_sets(read: Reader, flat: str) -> None:
    model = read(flat)
    assert model.element_sets["ALL"].tolist() == [[1, 0], [2, 0], [2, 1], [0, 0], [0, 1], [3, 0]]


def test_sets_of_a_part_are_found_with_and_without_the_instance(read: Reader, parts: str) -> None:
    model = read(parts)
    assert_array_equal(model.node_set("FRAME-1.FRAME_NODES"), model.node_set("FRAME_NODES"))
    assert _labels(model, "TIP") == ["PANEL-1.203", "PANEL-1.206"]


def test_short_set_name_is_left_out_when_two_instances_have_it(read: Reader, parts: str) -> None:
    second = "*Instance, name=Frame-2, part=Frame\n 0., 0., 50.\n*End Instance\n*Node\n 901,"
    model = read(parts.replace("*Node\n 901,", second))
    assert "FRAME_NODES" not in model.node_sets
    frames = [model.nodes.coords[model.node_set(f"FRAME-{k}.FRAME_NODES")] for k in (1, 2)]
    assert_allclose(frames[1] - frames[0], np.tile([0.0, 0.0, 50.0], (6, 1)))


def test_generate_leaves_out_labels_in_gaps_and_says_so(read: Reader, flat: str) -> None:
    model = read(flat.replace("*MPC", "*NSET, NSET=G, GENERATE\n 10, 50, 10\n*MPC"))
    assert _labels(model, "G") == ["10", "20", "30"]
    assert any("2 of the labels" in u.why and not u.changes_answer for u in model.unread)


def test_surfaces(read: Reader, flat: str) -> None:
    surfaces = read(flat).surfaces
    assert surfaces["FLANGE"].facets.tolist() == [[0, 0], [0, 1]]
    assert surfaces["FLANGE"].side.tolist() == [1, 1]
    assert surfaces["EDGE"].is_node_based
    assert not surfaces["FLANGE"].is_node_based


def test_surface_sides(read: Reader, flat: str) -> None:
    lines = "*SURFACE, NAME=FLANGE\n FRAME, SPOS\n 5, SNEG\n 41\n"
    surface = read(flat.replace("*SURFACE, NAME=FLANGE\n FRAME, SPOS\n", lines)).surfaces["FLANGE"]
    assert surface.side.tolist() == [1, 0, 0]


def test_couplings(read: Reader, flat: str) -> None:
    model = read(flat)
    kinematic, distributing, link = model.constraints
    assert isinstance(kinematic, KinematicCoupling)
    assert model.nodes.ids[kinematic.nodes_idx].tolist() == [30, 130]
    assert kinematic.dofs == (1, 2, 3, 4, 5, 6)
    assert isinstance(distributing, DistributingCoupling)
    assert distributing.weights.tolist() == [2.0, 1.0]
    assert distributing.dofs == (1, 2, 3)
    assert isinstance(link, RigidLink)
    assert model.nodes.ids[[link.dependent_idx, link.independent_idx]].tolist() == [902, 901]


def test_distributing_weights_of_facets_are_tributary_areas(read: Reader, flat: str) -> None:
    model = read(flat.replace("SURFACE=EDGE", "SURFACE=FLANGE"))
    coupling = model.constraints[1]
    assert isinstance(coupling, DistributingCoupling)
    weights = dict(zip(model.nodes.ids[coupling.nodes_idx].tolist(), coupling.weights, strict=True))
    assert weights == {10: 25.0, 20: 50.0, 120: 50.0, 110: 25.0, 30: 25.0, 130: 25.0}


def test_boundaries_of_the_model_and_of_the_first_step(read: Reader, flat: str) -> None:
    model = read(flat)
    held = [(model.nodes.ids[f.nodes_idx].tolist(), f.dofs) for f in model.fixed]
    assert held == [([10], (1, 2, 3, 4, 5, 6)), ([110], (2, 3)), ([30], (1,))]
    assert model.initial_velocity[0] == (6, 2, -1000.0)


def test_what_is_not_read_is_listed(read: Reader, flat: str) -> None:
    extra = "*EMBEDDED ELEMENT, HOST ELSET=FRAME\n PANEL,\n*NODEE\n*CONTACT PAIR"
    unread = {u.keyword: u for u in read(flat.replace("*CONTACT PAIR", extra)).unread}
    assert not unread["*CONTACT PAIR"].changes_answer
    assert not unread["*STEP"].changes_answer
    assert "*DYNAMIC" in unread["*STEP"].why
    assert unread["*EMBEDDED ELEMENT"].changes_answer
    assert unread["*NODEE"].changes_answer
    assert "Did you mean 'NODE'?" in unread["*NODEE"].why
    assert unread["*EMBEDDED ELEMENT"].where.endswith("deck.inp:79")


def test_unknown_parameter_is_listed(read: Reader, flat: str) -> None:
    model = read(flat.replace("REF NODE=901", "REF NODE=901, ADJUST=YES"))
    assert [u.keyword for u in model.unread if u.changes_answer] == ["*COUPLING, ADJUST"]


@pytest.mark.parametrize("kind", ["B31", "STRI3"])
def test_approximated_element_types_are_noted(read: Reader, flat: str, kind: str) -> None:
    if kind == "STRI3":
        text = flat.replace("TYPE=S3,", "TYPE=STRI3,")
    else:
        beam = (
            "*ELEMENT, TYPE=B31, ELSET=ROD\n 60, 10, 30\n"
            "*BEAM SECTION, ELSET=ROD, MATERIAL=STEEL, SECTION=CIRC\n 1.\n*MPC"
        )
        text = flat.replace("*MPC", beam)
    notes = [u for u in read(text).unread if kind in u.keyword]
    assert len(notes) == 1
    assert not notes[0].changes_answer


def test_large_coordinate_block_in_slow_and_fast_form_agree(read: Reader, flat: str) -> None:
    regular = read(flat)
    irregular = read(flat.replace(" 20, 10., 0., 0.", " 20, 10."))
    assert_array_equal(regular.nodes.coords, irregular.nodes.coords)
