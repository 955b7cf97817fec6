"""A tongue in a slot meets both walls; nodes that meet nothing are counted."""

from __future__ import annotations

import numpy as np
import pytest

from creak.contact.node_to_surface import node_to_surface, overhang
from creak.contact.pair import ContactPair
from creak.model.contact_law import ContactLaw
from creak.model.mesh import Model
from helpers_contact import METHODS, T_HIGH, T_LOW, both, stacked
from helpers_core import block, model_of, plate, shell, whole_block

NEAR, FAR = 0.004, 0.009
"""m from the middle of the tongue to the middles of the walls."""


def slot(tongue: float = 0.0, sides: int = 0) -> Model:
    """A plate TONGUE at z = `tongue` between two plates, WALLS, at -NEAR and FAR; meshes that do not match."""
    low, e_low = plate(5, 4, (0.3, 0.2), -NEAR, "quad4")
    top, e_top = plate(6, 5, (0.3, 0.2), FAR, "quad4")
    middle, e_middle = plate(3, 7, (0.3, 0.2), tongue, "quad4")
    n, m = low.shape[0], low.shape[0] + top.shape[0]
    walls = np.vstack([e_low, e_top + n])
    return model_of(
        np.vstack([low, top, middle]),
        [block("quad4", walls, shell(T_LOW), 0), block("quad4", e_middle + m, shell(T_HIGH), 1, 1000)],
        [("WALLS", range(m)), ("TONGUE", range(m, m + middle.shape[0]))],
        node_sets={"TONGUE_NODES": range(m, m + middle.shape[0])},
        surfaces=[whole_block(0, walls.shape[0], 0, "WALLS"), whole_block(1, e_middle.shape[0], sides, "TONGUE")],
    )


def channels(method: str, model: Model, **changes: object):
    pair = ContactPair(**{"name": "slot", "secondary": "TONGUE", "main": "WALLS", **changes})
    return METHODS[method](model, pair)


@both
@pytest.mark.parametrize("tongue", [0.0, 0.5 * (FAR - NEAR), 0.004])
def test_a_tongue_meets_both_walls(method, tongue):
    """Also in the middle of the slot, where both are equally near."""
    model = slot(tongue)
    gaps, _ = channels(method, model)
    n, half = model.node_sets["TONGUE_NODES"].size, 0.5 * (T_LOW + T_HIGH)
    assert gaps.m == 2 * n
    assert len(set(gaps.names)) == gaps.m
    expected = sorted([tongue + NEAR - half] * n + [FAR - tongue - half] * n)
    np.testing.assert_allclose(np.sort(gaps.gap0), expected, rtol=1e-9)
    u = np.zeros((model.nodes.count, 6))
    u[model.node_sets["TONGUE_NODES"], 2] = 1e-3
    np.testing.assert_allclose(np.abs(gaps.G @ u.ravel()[gaps.labels]), 1e-3, rtol=1e-9)
    closes = gaps.G @ u.ravel()[gaps.labels] < 0.0
    np.testing.assert_allclose(gaps.gap0[closes], FAR - tongue - half, rtol=1e-9)


def test_one_side_of_a_surface_meets_one_wall():
    gaps, _ = channels("surface-to-surface", slot(sides=1))
    np.testing.assert_allclose(gaps.gap0, FAR - 0.5 * (T_LOW + T_HIGH), rtol=1e-9)
    gaps, _ = channels("node-to-surface", slot(sides=-1))
    np.testing.assert_allclose(gaps.gap0, NEAR - 0.5 * (T_LOW + T_HIGH), rtol=1e-9)


@both
def test_a_given_clearance_is_that_of_the_nearer_wall(method):
    gaps, _ = channels(method, slot(), clearance=1e-4)
    half = 0.5 * (T_LOW + T_HIGH)
    np.testing.assert_allclose(np.unique(gaps.gap0.round(9)), [1e-4, FAR - half], rtol=1e-6)


@both
def test_a_given_normal_has_one_wall(method):
    gaps, _ = channels(method, slot(), normal=(0.0, 0.0, 1.0))
    assert gaps.m == slot().node_sets["TONGUE_NODES"].size


@both
@pytest.mark.parametrize("radius", [0.5, 5.0])
def test_smooth_surfaces_have_one_channel_a_node(method, radius):
    """Two plates bent round a cylinder, facets some 2 to 30 degrees apart."""
    flat = stacked((12, 4), (9, 7))
    x, y, z = flat.nodes.coords.T
    bent = np.column_stack([(radius + z) * np.sin(x / radius), y, (radius + z) * np.cos(x / radius) - radius])
    flat.nodes.coords[:] = bent
    gaps, _ = METHODS[method](flat, ContactPair("stack", "TOP", "LOW"))
    assert len(set(gaps.nodes_idx.tolist())) == gaps.m


def test_a_corner_has_two_walls_for_a_node():
    """A node over the floor and beside the wall of an L."""
    floor, e_floor = plate(4, 2, (0.2, 0.1), 0.0, "quad4")
    wall = floor[:, [2, 1, 0]]
    n = floor.shape[0]
    ball = np.array([[0.01, 0.05, 0.02]])
    model = model_of(
        np.vstack([floor, wall, ball]),
        [block("quad4", np.vstack([e_floor, e_floor + n]), shell(T_LOW), 0)],
        [("L", range(2 * n)), ("BALL", [2 * n])],
        node_sets={"BALL_NODE": [2 * n]},
        surfaces=[whole_block(0, 2 * e_floor.shape[0], 0, "L")],
    )
    gaps, notes = node_to_surface(model, ContactPair("ball", "BALL_NODE", "L"))
    np.testing.assert_allclose(gaps.gap0, [0.01 - 0.5 * T_LOW, 0.02 - 0.5 * T_LOW], rtol=1e-9)
    assert gaps.names[1] == gaps.names[0] + ":2"
    assert notes == []


def test_nodes_that_face_nothing_are_found():
    pair = ContactPair("stack", "TOP", "LOW")
    for model, count in ((stacked((6, 4), (6, 4), offset=(0.15, 0.0)), 15), (stacked(), 0)):
        gaps, notes = METHODS["node-to-surface"](model, pair)
        nodes, every = overhang(model, pair, gaps)
        assert notes == []
        assert nodes.size == count
        assert set(nodes.tolist()).isdisjoint(gaps.nodes_idx.tolist())
        assert every == np.union1d(nodes, gaps.nodes_idx).size


@both
def test_what_a_search_found_serves_other_numbers_and_no_other_shape(method):
    """Clearance and law are laid over the same channels; a surface that moved is searched again."""
    found: dict[bytes, dict[str, np.ndarray]] = {}

    def keep(inputs, search):
        key = b"".join(np.ascontiguousarray(A).tobytes() for A in inputs)
        if key not in found:
            found[key] = {name: np.asarray(A, dtype=np.float64) for name, A in search().items()}
        return found[key]

    for changes in ({}, {"clearance": 2e-3}, {"law": ContactLaw(1e4)}):
        pair = ContactPair("slot", "TONGUE", "WALLS", **changes)
        for _ in range(2):
            kept, told = METHODS[method](slot(), pair, keep)
            fresh, also_told = METHODS[method](slot(), pair)
            assert (kept.names, told) == (fresh.names, also_told)
            for name in ("gap0", "stiffness", "area", "size", "labels", "nodes_idx"):
                np.testing.assert_array_equal(getattr(kept, name), getattr(fresh, name))
            for A, B in zip((kept.G, *kept.tangents), (fresh.G, *fresh.tangents), strict=True):
                assert (A != B).nnz == 0
        assert len(found) == 1
    for model, changes in ((slot(0.001), {}), (slot(sides=1), {}), (slot(), {"normal": (0.0, 0.0, 1.0)})):
        METHODS[method](model, ContactPair("slot", "TONGUE", "WALLS", **changes), keep)
    assert len(found) == 4
