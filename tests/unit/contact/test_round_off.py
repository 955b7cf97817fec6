"""Contact does not hang on round-off: a deck in millimetres and one in metres give the same channels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.contact.node_to_surface import node_to_surface
from creak.contact.pair import ContactPair
from creak.contact.surface_to_surface import surface_to_surface
from creak.formats.abaqus.reader import read_deck
from creak.model.mesh import Model
from creak_thesis.door import write_door
from helpers_contact import stacked


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
