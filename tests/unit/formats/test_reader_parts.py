"""Which part nodes and elements belong to, and what parts are called."""

from __future__ import annotations

from collections.abc import Callable

from creak.model.mesh import Model, Part

Reader = Callable[[str], Model]


def _ids(model: Model, part: Part) -> list[int]:
    return sorted(model.nodes.ids[part.nodes_idx].tolist())


def test_connected_pieces_are_parts_and_reference_nodes_join_them(read: Reader, flat: str) -> None:
    model = read(flat)
    assert [p.name for p in model.parts] == ["FRAME", "PANEL"]
    assert _ids(model, model.parts[0]) == [10, 20, 30, 110, 120, 130, 901]
    assert _ids(model, model.parts[1]) == [201, 202, 203, 204, 205, 206, 902]


def test_instances_are_parts_also_known_by_their_part(read: Reader, parts: str) -> None:
    model = read(parts)
    assert [(p.name, p.aliases) for p in model.parts] == [("FRAME-1", ("FRAME",)), ("PANEL-1", ("PANEL",))]
    assert _ids(model, model.parts[1]) == [201, 202, 203, 204, 205, 206, 902]


def test_the_smallest_set_that_holds_a_part_names_it(read: Reader, flat: str) -> None:
    sets = "*ELSET, ELSET=HALF\n 7\n*ELSET, ELSET=STEELWORK\n FRAME\n*SHELL SECTION, ELSET=FRAME"
    assert [p.name for p in read(flat.replace("*SHELL SECTION, ELSET=FRAME", sets)).parts] == [
        "FRAME",
        "PANEL",
    ]


def test_a_set_with_elements_of_two_parts_names_neither(read: Reader, flat: str) -> None:
    text = flat.replace("ELSET=PANEL\n 41", "ELSET=SKIN\n 41").replace("ELSET=PANEL\n 42", "ELSET=SKIN\n 42")
    text = text.replace(" ELSET=FRAME\n 7", " ELSET=SKIN\n 7").replace("ELSET=PANEL", "ELSET=SKIN")
    text = text.replace("*SHELL SECTION, ELSET=FRAME, MATERIAL=STEEL\n 0.7, 5\n", "")
    text = text.replace(" FRAME, BALLAST", " SKIN").replace(" FRAME, SPOS", " SKIN, SPOS")
    assert [p.name for p in read(text).parts] == ["PART-1", "PART-2"]


def test_spring_on_one_part_belongs_to_it(read: Reader, flat: str) -> None:
    model = read(flat.replace(" 92, 130, 203", " 92, 130, 10"))
    assert model.blocks[-1].part == 0


def test_link_between_reference_nodes_does_not_merge_parts(read: Reader, flat: str) -> None:
    assert len(read(flat).parts) == 2
    assert len(read(flat.replace(" BEAM, 902, 901", " TIE, 902, 901")).parts) == 2


def test_reference_node_over_two_parts_belongs_to_none(read: Reader, flat: str) -> None:
    both = "*NODE\n 903, 0., 5., 5.\n*KINEMATIC COUPLING, REF NODE=903\n 10\n 201\n*MPC"
    model = read(flat.replace("*MPC", both))
    assert all(903 not in _ids(model, p) for p in model.parts)


def test_mass_on_a_spring_is_a_part_of_its_own(read: Reader, flat: str) -> None:
    text = flat.replace("*ELEMENT, TYPE=MASS, ELSET=BALLAST\n", "*ELEMENT, TYPE=MASS, ELSET=BALLAST\n 93, 904\n")
    text = text.replace(" 92, 130, 203", " 92, 130, 904").replace(" 902, 20.", " 904, 50., 50., 0.\n 902, 20.")
    model = read(text)
    assert [p.name for p in model.parts] == ["FRAME", "PANEL", "PART-1"]
    assert _ids(model, model.parts[2]) == [904]
    assert model.blocks[-1].part == -1


def test_mass_linked_to_a_part_belongs_to_it(read: Reader, flat: str) -> None:
    text = flat.replace(" 91, 902", " 91, 902\n 93, 904").replace(" 902, 20.", " 904, 50., 50., 0.\n 902, 20.")
    model = read(text.replace(" BEAM, 902, 901", " BEAM, 902, 901\n BEAM, 904, 206"))
    assert _ids(model, model.parts[1])[-1] == 904


def test_two_instances_of_one_part_have_no_other_name(read: Reader, parts: str) -> None:
    second = "*Instance, name=Frame-2, part=Frame\n 0., 0., 50.\n*End Instance\n*Node\n 901,"
    model = read(parts.replace("*Node\n 901,", second))
    assert [(p.name, p.aliases) for p in model.parts] == [
        ("FRAME-1", ()),
        ("PANEL-1", ("PANEL",)),
        ("FRAME-2", ()),
    ]
