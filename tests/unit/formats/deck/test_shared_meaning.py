"""What decks share: cross-sections, the catalogue of keywords, connected pieces."""

from __future__ import annotations

import numpy as np
import pytest

from creak.formats.abaqus.sections.beam_shapes import SHAPES as ABAQUS
from creak.formats.deck.catalogue import Catalogue, Meaning, listed
from creak.formats.deck.cross_section import composed, principal
from creak.formats.deck.parts import NO_LINKS, Rows, join_neighbours, number_points
from creak.formats.nastran.sections.bar_shapes import SHAPES as NASTRAN


@pytest.mark.parametrize(
    ("abaqus", "nastran"),
    [
        (("BOX", (20.0, 30.0, 2.0, 3.0, 2.0, 3.0)), ("BOX", (30.0, 20.0, 2.0, 3.0))),
        (("I", (15.0, 30.0, 20.0, 24.0, 2.0, 3.0, 1.5)), ("I", (30.0, 20.0, 24.0, 1.5, 2.0, 3.0))),
        (("CIRC", (4.0,)), ("ROD", (4.0,))),
        (("PIPE", (4.0, 0.5)), ("TUBE2", (4.0, 0.5))),
    ],
)
def test_one_section_has_the_same_moments_in_both_formats(abaqus, nastran):
    """The height of Nastran's I lies along axis 1, of Abaqus's along axis 2; the box is given turned."""
    a, n = ABAQUS[abaqus[0]][1](abaqus[1]), NASTRAN[nastran[0]][1](*nastran[1])
    turned = (n.area, n.i22, n.i11, n.torsion) if abaqus[0] == "I" else (n.area, n.i11, n.i22, n.torsion)
    assert (a.area, a.i11, a.i22, a.torsion) == pytest.approx(turned, rel=1e-12)


def test_unequal_angle_is_turned_to_its_principal_axes():
    """Moments of a fine grid of points about axes through the centroid, turned by the angle."""
    angle = composed([(0.5, 5.0, 1.0, 10.0), (3.5, 0.5, 5.0, 1.0)])
    i1, i2, turn = principal(angle.i11, angle.i22, angle.i12)
    x, y = np.meshgrid(np.arange(0.005, 6.0, 0.01), np.arange(0.005, 10.0, 0.01))
    inside = (x < 1.0) | (y < 1.0)
    x, y = x[inside] - x[inside].mean(), y[inside] - y[inside].mean()
    along, across = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
    assert (i1, i2) == pytest.approx((1e-4 * (across**2).sum(), 1e-4 * (along**2).sum()), rel=1e-4)
    assert abs((along * across).sum()) < 1e-6 * (across**2).sum()


CATALOGUE = Catalogue("word", {"MASS": Meaning("read"), **listed("harmless", {"it draws": "PLOT, PAINT"})})


@pytest.mark.parametrize(
    ("name", "role", "why"),
    [
        ("MASS", "read", ""),
        ("PAINT", "harmless", "it draws"),
        ("MASSS", "changes", "creak does not know this word. Did you mean 'MASS'?"),
        ("XYZZY", "changes", "creak does not know this word"),
    ],
)
def test_an_unknown_word_changes_the_answer(name, role, why):
    assert (CATALOGUE.meaning(name).role, CATALOGUE.meaning(name).why) == (role, why)


def test_the_first_misspelled_word_is_hinted_at():
    named = [("XYZZY", "Xyzzy", "a:1"), ("PLOTT", "Plott", "a:2"), ("MASSS", "Masss", "a:3"), ("PLOTT", "Plott", "a:4")]
    assert CATALOGUE.misspelled(named) == "Note that Plott at a:2 is not a word that creak knows. Did you mean 'PLOT'?"
    assert CATALOGUE.misspelled(named[:1]) == ""


def test_loose_nodes_join_the_one_part_that_they_reach():
    """0, 1 are part 0 and 2 is part 1: 3-4 hang on part 0, 5 on both, 6 on none, 7 has mass and a spring to part 1."""
    of_node = np.array([0, 0, 1, -1, -1, -1, -1, -1])
    join_neighbours(Rows.of_lists([[0, 3], [4, 3], [1, 5], [2, 5]]), of_node)
    assert of_node.tolist() == [0, 0, 1, 0, 0, -1, -1, -1]
    count = number_points(Rows.of_lists([[6], [2, 7]]), NO_LINKS, np.array([7]), of_node, 2)
    assert (count, of_node.tolist()) == (4, [0, 0, 1, 0, 0, -1, 2, 3])
