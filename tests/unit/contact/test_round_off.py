"""Contact does not hang on round-off: a deck in millimetres and one in metres give the same channels.

Friction acts on the sides of shells and beams: their nodes' rotations move these along each other.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.contact.node_to_surface import node_to_surface
from creak.contact.pair import ContactPair
from creak.contact.surface_to_surface import surface_to_surface
from creak.formats.abaqus.reader import read_deck
from creak.model.dofs import ROTATIONS, dofs_of
from creak.model.mesh import Model
from creak_thesis.door import write_door
from helpers_contact import METHODS, T_HIGH, T_LOW, both, pair, stacked
from helpers_fem import random_rotation, rigid_modes


@pytest.fixture(scope="module")
def door(tmp_path_factory) -> Model:
    folder = tmp_path_factory.mktemp("door")
    write_door(40.0, folder)
    return read_deck(folder / "door.inp")


def scaled(model: Model, factor: float) -> Model:
    """The same in another unit of length; the modulus stays, so stiffness over area grows by 1 / factor."""
    blocks = tuple(
        replace(b, section=replace(b.section, thickness=b.section.thickness * factor))
        if hasattr(b.section, "thickness")
        else b
        for b in model.blocks
    )
    return replace(model, nodes=replace(model.nodes, coords=model.nodes.coords * factor), blocks=blocks)


def shaken(model: Model, seed: int) -> Model:
    """Coordinates off by some 1e-12 of the model's size, as other digits in a deck give."""
    noise = np.random.default_rng(seed).uniform(-1.0, 1.0, model.nodes.coords.shape)
    size = np.ptp(model.nodes.coords, axis=0).max()
    return replace(model, nodes=replace(model.nodes, coords=model.nodes.coords + 1e-12 * size * noise))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("search", [surface_to_surface, node_to_surface])
def test_last_digits_change_nothing(door, search, seed):
    pair = ContactPair("flange", "PANEL_EDGE", "FRAME_FLANGE", method=search.__name__.replace("_", "-"))
    a, _ = search(door, pair)
    b, _ = search(shaken(door, seed), pair)
    np.testing.assert_allclose(b.gap0, a.gap0, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(b.stiffness, a.stiffness, rtol=1e-7)


def graded(seed: int) -> Model:
    """Two plates with the same graded mesh: integration points lie over the edges of facets of unequal area."""
    model = stacked((6, 4), (3, 2))
    x = model.nodes.coords.copy()
    x[:, 0] = 0.3 * (x[:, 0] / 0.3) ** 1.7
    return shaken(replace(model, nodes=replace(model.nodes, coords=x)), seed)


def test_points_over_an_edge_always_meet_the_same_facet():
    pair = ContactPair("plates", "LOW", "TOP")
    a, *others = (surface_to_surface(graded(seed), pair)[0] for seed in range(8))
    for b in others:
        np.testing.assert_allclose(b.stiffness, a.stiffness, rtol=1e-7)


@pytest.mark.parametrize("factor", [1e-3, 1.0 / 25.4, 0.3])
@pytest.mark.parametrize("search", [surface_to_surface, node_to_surface])
def test_unit_of_length_changes_nothing(door, search, factor):
    pair = ContactPair("flange", "PANEL_EDGE", "FRAME_FLANGE", method=search.__name__.replace("_", "-"))
    a, _ = search(door, pair)
    b, _ = search(scaled(door, factor), pair)
    assert a.names == b.names
    np.testing.assert_allclose(b.gap0, a.gap0 * factor, rtol=1e-7, atol=1e-9 * factor)
    np.testing.assert_allclose(b.stiffness, a.stiffness * factor, rtol=1e-7)
    np.testing.assert_allclose(b.G.toarray(), a.G.toarray(), atol=1e-7)


RUBS = (0.3, 0.3)
TOUCHING = 0.5 * (T_LOW + T_HIGH)
"""Height at which the plates lie on each other."""


def slip(operator, u: np.ndarray) -> np.ndarray:
    """(m, 2) along both tangents under the nodal motion u (6 n_node,)."""
    return np.stack([t @ u[operator.labels] for t in operator.tangents], axis=1)


@both
@pytest.mark.parametrize("kinds", [("quad4", "quad4"), ("tri3", "quad4")])
def test_plates_that_lie_on_each_other_turn_together_without_slip(method, kinds):
    """All six rigid motions, however the stack lies in space."""
    model = stacked(kinds=kinds, height=TOUCHING, rotation=random_rotation(3))
    operator, _ = METHODS[method](model, pair(friction=RUBS))
    for u in rigid_modes(model.nodes.coords).T:
        np.testing.assert_allclose(slip(operator, u), 0.0, atol=1e-12 * np.abs(u).max())


@both
def test_two_strips_that_bend_alike_slip_by_their_rotation_times_the_distance_of_their_middles(method):
    """A leaf spring: theta (t_1 + t_2) / 2, all nodes turning by theta where they are."""
    model = stacked(height=TOUCHING)
    operator, _ = METHODS[method](model, pair(friction=RUBS))
    for axis in (0, 1):
        u = np.zeros(6 * model.nodes.count)
        u[3 + axis :: 6] = 0.01
        moved = np.linalg.norm(slip(operator, u), axis=1)
        np.testing.assert_allclose(moved, 0.01 * TOUCHING, rtol=1e-12)
    np.testing.assert_allclose(operator.G @ u[operator.labels], 0.0, atol=1e-15)


@both
def test_what_does_not_rub_takes_no_rotations(method):
    operator, _ = METHODS[method](stacked(height=TOUCHING), pair())
    assert not np.isin(dofs_of(operator.labels), ROTATIONS).any()


@pytest.mark.parametrize(("clearance", "moved"), [(0.0, TOUCHING), (None, 0.5 * T_LOW)])
def test_a_set_of_nodes_has_half_its_shells_thickness_where_its_gap_is_given(clearance, moved):
    """Without a given gap the nodes themselves touch the main side, as their gap says."""
    model = stacked(height=TOUCHING)
    given = pair(friction=RUBS, secondary="TOP_NODES", clearance=clearance)
    operator, _ = METHODS["node-to-surface"](model, given)
    u = np.zeros(6 * model.nodes.count)
    u[4::6] = 0.01
    np.testing.assert_allclose(np.linalg.norm(slip(operator, u), axis=1), 0.01 * moved, rtol=1e-12)
