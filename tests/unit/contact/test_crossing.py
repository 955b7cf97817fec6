"""Parts that are drawn through each other are told, by how far and where."""

from __future__ import annotations

import pytest

from creak.contact.crossing import crossings
from creak.formats.decks import read_model
from helpers_decks import two_strips
from helpers_ribs import rib_on_plate


def found(folder, text):
    (folder / "own.inp").write_text(text)
    return crossings(read_model(folder / "own.inp"))


def test_a_rib_through_a_plate(tmp_path):
    """A rib of rows 5 mm high, drawn from 2 mm below a plate 2 mm thick: 2 mm less half of the plate lie beyond it."""
    (c,) = found(tmp_path, rib_on_plate(-2.0))
    assert (c.part, c.other, c.edges) == ("RIB", "PLATE", 3)  # its ends are at the border of the plate
    assert c.depth == pytest.approx(1.0)
    assert set(c.nodes) == {"1002", "1003", "1004"}


@pytest.mark.parametrize(("thickness", "depth"), [(1.0, [1.5]), (3.0, [0.5]), (5.0, [])])
def test_the_thickness_of_the_plates_nodes_counts(tmp_path, thickness, depth):
    """2 mm below the middle, less half of it."""
    text = rib_on_plate(-2.0, f"*NSET, NSET=OF_PLATE, GENERATE\n1, 25, 1\n*NODAL THICKNESS\nOF_PLATE, {thickness}\n")
    text = text.replace("ELSET=PLATE, MATERIAL=STEEL", "ELSET=PLATE, MATERIAL=STEEL, NODAL THICKNESS")
    assert [c.depth for c in found(tmp_path, text)] == pytest.approx(depth)


def test_a_rib_with_a_row_of_nodes_in_the_plate(tmp_path):
    """The same from 5 mm below: the second row lies in the middle of the plate, so no single edge pierces it."""
    (c,) = found(tmp_path, rib_on_plate(-5.0))
    assert (c.part, c.other, c.depth) == ("RIB", "PLATE", pytest.approx(4.0))
    assert set(c.nodes) == {"1002", "1003", "1004"}


def test_of_two_parts_the_one_that_reaches_less_deep_is_named(tmp_path):
    """Moved into a row of the plate's nodes, the rib is crossed by edges of the plate 10 mm long as well."""
    moved = rib_on_plate(-2.0).replace(", 21.000000, ", ", 20.000000, ")
    (c,) = found(tmp_path, moved)
    assert (c.part, c.depth) == ("RIB", pytest.approx(1.0))


@pytest.mark.parametrize("height", [1.3, 1.0, 0.0, -0.9, -20.0, -21.5])
def test_what_ends_at_the_plate_or_in_it_does_not_pierce_it(tmp_path, height):
    assert found(tmp_path, rib_on_plate(height)) == []


def test_the_legs_of_a_t_do_not_pierce_each_other(tmp_path):
    """A rib that ends in the middle of the plate, where rows of the plate's nodes go on to both sides of it."""
    assert found(tmp_path, rib_on_plate(0.0).replace(", 21.000000, ", ", 20.000000, ")) == []


def test_what_is_tied_where_it_passes_is_meant(tmp_path):
    weld = "".join(f"*MPC\nBEAM, {1000 + k}, {k}\n" for k in range(1, 6))
    assert found(tmp_path, rib_on_plate(-2.0, weld)) == []


def test_strips_that_overlap_in_their_thickness_do_not_pierce(tmp_path):
    assert found(tmp_path, two_strips(gap=-0.2)) == []


def blocks(gap, inset=0.0):
    """A block of 20 x 20 x 10 on one of 30 x 30 x 10, of bricks of 10; inset: moved down into it by so much."""
    lines, element = [], 0
    for name, n, x0, z0, first in (("LOW", 3, -5.0, 0.0, 0), ("UPP", 2, 0.0, 10.0 + gap - inset, 1000)):
        row = {}
        lines.append("*NODE")
        for k in range(2):
            for j in range(n + 1):
                for i in range(n + 1):
                    row[i, j, k] = first + len(row) + 1
                    lines.append(f"{row[i, j, k]}, {x0 + 10 * i}, {x0 + 10 * j}, {z0 + 10 * k}")
        lines.append(f"*ELEMENT, TYPE=C3D8, ELSET={name}")
        for j in range(n):
            for i in range(n):
                element += 1
                ring = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
                nodes = [row[a, b, k] for k in range(2) for a, b in ring]
                lines.append(f"{element}, " + ", ".join(map(str, nodes)))
        lines.append(f"*SOLID SECTION, ELSET={name}, MATERIAL=M")
    return "\n".join([*lines, "*MATERIAL, NAME=M", "*ELASTIC", "2000., 0.", "*DENSITY", "1.E-9,", ""])


@pytest.mark.parametrize("gap", [0.1, 0.0, -0.01])
def test_a_block_that_stands_on_a_larger_one_is_not_pierced_by_its_edges(tmp_path, gap):
    """Edges in the plane between them pass under the side walls of the upper one."""
    assert found(tmp_path, blocks(gap)) == []


def test_a_block_that_stands_in_another_one_is_pierced(tmp_path):
    (c,) = found(tmp_path, blocks(0.0, inset=4.0))
    assert {c.part, c.other} == {"LOW", "UPP"}
