"""A point with a negative mass, as decks have that balance another one: refused where it is the larger of the two.

Does anything hold each part? Supports, links, springs and stops do; contact does not.
"""

from __future__ import annotations

import numpy as np
import pytest

from creak.assembly.coupling import Driven
from creak.assembly.elimination import LinearEquation
from creak.assembly.rigid import unheld_parts
from creak.contact.play import Play, play_channels
from creak.errors import InputError
from creak.model.constraints import DistributingCoupling, Fixed, KinematicCoupling, RigidLink
from creak.model.contact_law import ContactLaw
from creak.model.mesh import Model
from helpers_core import NONE, assembled, beam_section, block, model_of, point_mass, spring, straight_beam


def two_points(less: float):
    masses = [block("mass", [[0], [1]], point_mass(2.0)), block("mass", [[1]], point_mass(less), 0, 10)]
    links = [block("spring2", [[0, 1]], spring(1e3), 0, 20)]
    return model_of(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), [*masses, *links], [("A", [0, 1])])


def test_a_mass_below_zero_is_refused_with_its_node():
    with pytest.raises(
        InputError, match=r"the mass at node 2 [XYZ] is -1, with what is tied to it; expected zero or more"
    ):
        assembled(two_points(-3.0))


def test_one_that_only_lightens_another_is_taken():
    system = assembled(two_points(-0.5))
    assert sorted(set(np.round(system.M.diagonal(), 12).tolist()) - {0.0}) == [1.5, 2.0]


ALL = (1, 2, 3, 4, 5, 6)
CLAMP = Fixed(np.array([0]), ALL)


def two_beams(**more) -> Model:
    """FRAME (nodes 0..4) and PANEL (nodes 5..9) beside it; node 10 is loose."""
    a, e = straight_beam(4, 1.0)
    b, _ = straight_beam(4, 1.0, y=0.3)
    blocks = [block("beam2", e, beam_section(), 0), block("beam2", e + 5, beam_section(), 1, 50)]
    blocks += more.pop("more_blocks", [])
    return model_of(
        np.vstack([a, b, [[0.5, 0.15, 0.1]]]),
        blocks,
        [("FRAME", range(5)), ("PANEL", range(5, 10))],
        node_sets={"A": [2], "B": [7]},
        **more,
    )


def test_nothing_holds_anything():
    assert unheld_parts(two_beams(), NONE) == ["FRAME", "PANEL"]


def test_clamped_part_is_held_and_its_neighbour_is_not():
    assert unheld_parts(two_beams(fixed=[CLAMP]), NONE) == ["PANEL"]


def test_rigid_link_holds_the_neighbour():
    for kind in ("beam", "tie"):
        assert unheld_parts(two_beams(fixed=[CLAMP], constraints=[RigidLink(kind, 5, 0)]), NONE) == []


def test_one_pin_leaves_rotations_and_three_hold():
    pins = [RigidLink("pin", 5, 0), RigidLink("pin", 9, 4), RigidLink("pin", 7, 2)]
    assert unheld_parts(two_beams(fixed=[CLAMP], constraints=pins[:1]), NONE) == ["PANEL"]
    # A straight beam pinned along its line can still turn about it.
    assert unheld_parts(two_beams(fixed=[CLAMP], constraints=pins), NONE) == ["PANEL"]
    held = [*pins, RigidLink("tie", 6, 1)]
    assert unheld_parts(two_beams(fixed=[CLAMP], constraints=held), NONE) == []


def test_link_between_two_free_parts_holds_neither():
    assert unheld_parts(two_beams(constraints=[RigidLink("beam", 5, 0)]), NONE) == ["FRAME", "PANEL"]


def test_support_of_the_second_part_holds_the_first_through_the_link():
    model = two_beams(fixed=[Fixed(np.array([9]), ALL)], constraints=[RigidLink("beam", 5, 0)])
    assert unheld_parts(model, NONE) == []


def test_loose_reference_node_carries_the_link():
    couplings = [KinematicCoupling("K", 10, np.array([0, 4]), ALL), KinematicCoupling("L", 10, np.array([5, 9]), ALL)]
    assert unheld_parts(two_beams(fixed=[CLAMP], constraints=couplings), NONE) == []
    assert unheld_parts(two_beams(fixed=[CLAMP], constraints=couplings[:1]), NONE) == ["PANEL"]


def test_springs_hold_in_all_six_directions_and_not_in_five():
    def model(dofs):
        springs = [block("spring2", [[2, 7]], spring(100.0, d), -1, 100 + d) for d in dofs]
        return two_beams(fixed=[CLAMP], more_blocks=springs)

    assert unheld_parts(model(ALL), NONE) == []
    assert unheld_parts(model(ALL[:5]), NONE) == ["PANEL"]


def test_dashpot_alone_holds_nothing():
    dashpots = [block("spring2", [[2, 7]], spring(0.0, d, damping=5.0), -1, 100 + d) for d in ALL]
    assert unheld_parts(two_beams(fixed=[CLAMP], more_blocks=dashpots), NONE) == ["PANEL"]


def test_driven_dofs_hold():
    labels = {f"d{d}": np.array([6 * 7 + d - 1]) for d in ALL}
    assert unheld_parts(two_beams(fixed=[CLAMP]), Driven(labels)) == []


def test_play_connectors_hold():
    model = two_beams(fixed=[CLAMP])
    stops = []
    for dof in ALL:
        G = play_channels(model, Play(f"p{dof}", ("A", "B"), dof, -0.1, 0.1, ContactLaw(1e4)), "")
        row = G.G[0]
        stops.append(LinearEquation(G.labels[row.indices].tolist(), row.data.tolist()))
    assert unheld_parts(model, NONE, stops) == []
    assert unheld_parts(model, NONE, stops[:5]) == ["PANEL"]


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_units_do_not_matter(scale):
    model = two_beams(fixed=[CLAMP], constraints=[RigidLink("tie", 6, 1)])
    model.nodes.coords[:] *= scale
    assert unheld_parts(model, NONE) == []


def test_distributing_coupling_to_a_held_reference_holds():
    coords = np.array([[0.0, 0, 0], [1.0, 0, 0], [0.0, 1, 0], [0.3, 0.3, 1.0]])
    elements = np.array([[0, 1], [1, 2]])
    model = model_of(
        coords,
        [block("beam2", elements, beam_section())],
        [("A", range(3))],
        constraints=[DistributingCoupling("D", 3, np.arange(3), np.ones(3))],
        fixed=[Fixed(np.array([3]), ALL)],
    )
    assert unheld_parts(model, NONE) == []
