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
