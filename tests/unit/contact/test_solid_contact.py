"""Contact of solids and beams: free faces, mixed surfaces, stiffness, edges, overclosure."""

from __future__ import annotations

import numpy as np
import pytest

from creak.contact.facets import corner_normals, facets_of, nodal_normals
from creak.contact.node_to_surface import node_to_surface, nodes_of
from creak.contact.pair import ContactPair
from creak.contact.surface_to_surface import surface_to_surface
from creak.errors import InputError
from creak.model.contact_law import ContactLaw
from creak.model.faces import FACES, faces_of, volumes
from creak.model.materials import BeamSection, SolidSection
from creak.model.mesh import Model, Surface
from helpers_core import STEEL, block, model_of, plate, shell, straight_beam
from helpers_fem import random_rotation
from helpers_solids import solid_mesh

METHODS = {"surface-to-surface": surface_to_surface, "node-to-surface": node_to_surface}
both = pytest.mark.parametrize("method", sorted(METHODS))
SOLID = SolidSection("SOLID", STEEL)
SIZE = (0.3, 0.2, 0.1)


def members(row: int, count: int) -> np.ndarray:
    return np.column_stack([np.full(count, row), np.arange(count)])


def blocks_apart(gap: float, kinds=("hex8", "hex8"), rotation: np.ndarray | None = None, rim: float = 0.0) -> Model:
    """Block TOP above block LOW, inside its outline by `rim`; element sets LOW and TOP hold all their elements."""
    x_low, e_low = solid_mesh((4, 3, 2), SIZE, kinds[0])
    x_top, e_top = solid_mesh((3, 4, 2), (SIZE[0] - 2 * rim, SIZE[1] - 2 * rim, SIZE[2]), kinds[1])
    n = len(x_low)
    x = np.vstack([x_low, x_top + [rim, rim, SIZE[2] + gap]])
    return model_of(
        x if rotation is None else x @ rotation.T,
        [block(kinds[0], e_low, SOLID, 0), block(kinds[1], e_top + n, SOLID, 1, 1000)],
        [("LOW", range(n)), ("TOP", range(n, len(x)))],
        element_sets={"LOW": members(0, len(e_low)), "TOP": members(1, len(e_top))},
        node_sets={"TOP_NODES": range(n, len(x))},
    )


@pytest.mark.parametrize("kind", sorted(FACES))
def test_faces_look_outward_and_close_the_element(kind):
    x, elements = solid_mesh((2, 2, 1), SIZE, kind, distortion=0.1)
    every = x[faces_of(kind, elements)]
    normal = 0.5 * np.cross(every[:, :, 2] - every[:, :, 0], every[:, :, 3] - every[:, :, 1])
    np.testing.assert_allclose(normal.sum(axis=1), 0.0, atol=1e-15)
    middle = x[elements].mean(axis=1)
    assert (((every.mean(axis=2) - middle[:, None]) * normal).sum(axis=2) > 0.0).all()
    assert volumes(every).sum() == pytest.approx(np.prod(SIZE), rel=1e-12)


@pytest.mark.parametrize("kind", sorted(FACES))
def test_set_of_solids_is_its_free_surface(kind):
    model = blocks_apart(0.01, (kind, "hex8"))
    facets = facets_of(model, "LOW", where="")
    area = 2 * (0.3 * 0.2 + 0.3 * 0.1 + 0.2 * 0.1)
    assert np.linalg.norm(facets.area_normals, axis=1).sum() == pytest.approx(area, rel=1e-12)
    np.testing.assert_allclose(facets.area_normals.sum(axis=0), 0.0, atol=1e-15)
    assert (facets.side == 1).all()
    assert not facets.thickness.any()


def test_part_of_a_body_leaves_its_cut_faces_out():
    """Of the lower layer of elements the top is shared with the upper layer."""
    x, elements = solid_mesh((2, 2, 2), SIZE)
    low = np.flatnonzero(x[elements][:, :, 2].max(axis=1) < 0.06)
    model = model_of(x, [block("hex8", elements, SOLID)], element_sets={"LAYER": np.column_stack([0 * low, low])})
    facets = facets_of(model, "LAYER", where="")
    assert np.linalg.norm(facets.area_normals, axis=1).sum() == pytest.approx(0.06 + 2 * 0.05 * 0.5, rel=1e-12)


@pytest.mark.parametrize("kind", ["hex8", "hex20", "tet10", "wedge6"])
def test_area_of_a_node_is_that_of_the_faces_that_look_at_the_other_side(kind):
    """A set of solids has all of its free faces; at its edges only the lower ones meet the block below."""
    rotation = random_rotation(4)
    model = blocks_apart(0.01, ("hex8", kind), rotation, rim=0.02)
    law = ContactLaw(stiffness=7.0, where="[contact.stack]")
    pair = ContactPair(name="stack", secondary="TOP", main="LOW", law=law, per_area=True)
    operator, _ = node_to_surface(model, pair)
    below = (model.nodes.coords @ rotation)[operator.nodes_idx, 2] < SIZE[2] + 0.02
    assert operator.stiffness[below].sum() == pytest.approx(7.0 * 0.26 * 0.16, rel=1e-12)
    assert (operator.stiffness > 0.0).all()


def test_normals_are_not_averaged_round_the_edges_of_a_block():
    facets = facets_of(blocks_apart(0.01), "LOW", where="")
    unit = facets.area_normals / np.linalg.norm(facets.area_normals, axis=1)[:, None]
    np.testing.assert_allclose(corner_normals(facets), np.repeat(unit[:, None], 4, axis=1), atol=1e-12)
    corner = nodal_normals(facets)[0]  # node (0, 0, 0)
    np.testing.assert_allclose(corner, -corner.mean() * np.array([-1.0, -1.0, -1.0]), atol=0.3)


@both
@pytest.mark.parametrize("kinds", [("hex8", "hex8"), ("wedge6", "tet4")])
@pytest.mark.parametrize("seed", [None, 3])
def test_whole_bodies_find_the_faces_that_look_at_each_other(method, kinds, seed):
    """Channels at the nodes of the lower face of TOP alone, gaps as meshed, no thickness."""
    model = blocks_apart(0.01, kinds, None if seed is None else random_rotation(seed))
    secondary = "TOP" if method == "surface-to-surface" else "TOP_NODES"
    operator, notes = METHODS[method](model, ContactPair("c", secondary, "LOW", method))
    assert notes == []
    facing = operator.gap0 < 0.05
    np.testing.assert_allclose(operator.gap0[facing], 0.01, rtol=1e-9)
    lowest = blocks_apart(0.01, kinds).nodes.coords[operator.nodes_idx[facing], 2]
    np.testing.assert_allclose(lowest, 0.11, rtol=1e-9)
    assert facing.sum() == 20
    if method == "surface-to-surface":
        assert facing.all()
        assert operator.area.sum() == pytest.approx(0.06, rel=1e-9)


@both
def test_surface_of_shells_and_solids(method):
    """A skin of shells over one half of a block's top stands half its thickness nearer."""
    x_low, e_low = solid_mesh((4, 2, 1), SIZE)
    x_top, e_top = plate(8, 4, (0.3, 0.2), 0.12)
    n, m = len(x_low), len(x_low) + len(x_top)
    skin = e_low[4:, [4, 5, 6, 7]]
    faces = Surface(
        "LOW",
        np.concatenate([members(0, 4), members(2, len(skin))]),
        np.array([2] * 4 + [0] * len(skin)),
        np.zeros(0, dtype=np.int64),
    )
    model = model_of(
        np.vstack([x_low, x_top]),
        [
            block("hex8", e_low, SOLID),
            block("quad4", e_top + n, shell(2e-3), 1, 100),
            block("quad4", skin, shell(4e-3), 0, 500),
        ],
        [("LOW", range(n)), ("TOP", range(n, m))],
        element_sets={"TOP": members(1, len(e_top))},
        surfaces=[faces],
    )
    operator, _ = METHODS[method](model, ContactPair("c", "TOP", "LOW", method))
    x = model.nodes.coords[operator.nodes_idx, 0]
    bare, covered = operator.gap0[x < 0.1], operator.gap0[x > 0.2]
    np.testing.assert_allclose(bare, 0.02 - 1e-3, rtol=1e-9)
    np.testing.assert_allclose(covered, 0.02 - 1e-3 - 2e-3, rtol=1e-9)


def test_shells_beside_solids_are_turned_to_the_side_of_the_solids():
    x, e = solid_mesh((2, 1, 1), SIZE)
    skin = e[1:, [7, 6, 5, 4]]  # looks into the block
    surface = Surface("S", np.array([[0, 0], [1, 0]]), np.array([2, 0]), np.zeros(0, dtype=np.int64))
    model = model_of(x, [block("hex8", e, SOLID), block("quad4", skin, shell(1e-3))], surfaces=[surface])
    np.testing.assert_allclose(nodal_normals(facets_of(model, "S", where=""))[:, 2], 1.0, rtol=1e-12)


def test_automatic_stiffness_of_solids_is_ten_times_confined_compression():
    """10 E_c / h per area and 10 E_c A / h per node, E_c = E (1 - nu) / ((1 + nu) (1 - 2 nu)), h = 50 mm."""
    confined = STEEL.youngs_modulus * 0.7 / (1.3 * 0.4)
    model = blocks_apart(0.01)
    sts, _ = surface_to_surface(model, ContactPair("c", "TOP", "LOW"))
    np.testing.assert_allclose(sts.stiffness / sts.area, 10 * confined / 0.05, rtol=1e-9)
    assert sts.step_limited.all()
    nts, _ = node_to_surface(model, ContactPair("c", "TOP_NODES", "LOW"))
    near = nts.gap0 < 0.05
    np.testing.assert_allclose(nts.stiffness[near], 10 * confined * (0.06 / 12) / 0.05, rtol=1e-9)


@both
def test_shallow_overclosure_of_solids_is_noted_and_deep_one_refused(method):
    """Elements are 50 mm high: up to 25 mm inside is set to zero, more is an error."""
    secondary = "TOP" if method == "surface-to-surface" else "TOP_NODES"
    build, contact = METHODS[method], ContactPair("c", secondary, "LOW", method)
    operator, notes = build(blocks_apart(-0.02, rim=0.04), contact)
    assert np.count_nonzero(operator.gap0 == 0.0) == 20
    assert "20 channel(s) start closed, by up to 0.02 at node" in notes[0]
    with pytest.raises(InputError, match=r"starts 0.03 inside the main surface.*half an element's height"):
        build(blocks_apart(-0.03, rim=0.04), contact)


@both
def test_given_normal_takes_the_faces_that_look_along_it(method):
    model = blocks_apart(0.01)
    secondary = "TOP" if method == "surface-to-surface" else "TOP_NODES"
    operator, _ = METHODS[method](model, ContactPair("c", secondary, "LOW", method, normal=(0.0, 0.0, 2.0)))
    near = operator.gap0 < 0.05
    assert near.sum() == 20
    np.testing.assert_allclose(operator.gap0[near], 0.01, rtol=1e-9)
    with pytest.raises(InputError, match="never face each other"):
        surface_to_surface(model, ContactPair("c", "TOP", "LOW", normal=(0.0, 0.0, -1.0)))


# --- beams ----------------------------------------------------------------------------------------------------


def beam_over_plate(radius: float, *, skin: bool = False) -> Model:
    x_low, e_low = plate(6, 4, (0.3, 0.2), 0.0)
    x_beam, e_beam = straight_beam(5, 0.25, 0.1)
    n = len(x_low)
    x_beam += [0.02, 0.0, 0.03]
    blocks = [
        block("quad4", e_low, shell(1e-3)),
        block("beam2", e_beam + n, BeamSection("B", STEEL, 1e-4, 1e-9, 1e-9, 2e-9, radius=radius), 1, 100),
    ]
    if skin:
        blocks.append(block("tri3", [[n, n + 1, 0]], shell(1e-3), 1, 200))
    return model_of(
        np.vstack([x_low, x_beam]),
        blocks,
        [("LOW", range(n)), ("WIRE", range(n, n + 6))],
        element_sets={"LOW": members(0, len(e_low)), "WIRE": members(1, 5)},
        node_sets={"WIRE_NODES": range(n, n + 6)},
    )


@pytest.mark.parametrize("secondary", ["WIRE", "WIRE_NODES"])
@pytest.mark.parametrize("radius", [0.004, 0.0])
def test_nodes_of_beams_stand_off_by_their_radius(secondary, radius):
    operator, _ = node_to_surface(beam_over_plate(radius), ContactPair("c", secondary, "LOW", "node-to-surface"))
    assert operator.m == 6
    np.testing.assert_allclose(operator.gap0, 0.03 - 0.5e-3 - radius, rtol=1e-9)
    assert np.isfinite(operator.stiffness).all()
    assert np.isfinite(operator.size).all()


def test_nodes_that_shells_share_have_no_thickness_in_a_set_of_nodes():
    nodes = nodes_of(beam_over_plate(0.004, skin=True), "WIRE_NODES", where="")
    np.testing.assert_allclose(nodes.thickness, [0.0, 0.0, 0.008, 0.008, 0.008, 0.008])


def test_beams_have_no_facets():
    with pytest.raises(InputError, match=r"surface 'WIRE' holds beam2 elements.*nodes of beams may be secondary"):
        surface_to_surface(beam_over_plate(0.004), ContactPair("c", "WIRE", "LOW"))


# --- wrong facets ---------------------------------------------------------------------------------------------


def test_facet_without_area_is_named():
    x, e = plate(2, 2)
    x[e[1, 2]], x[e[1, 3]] = x[e[1, 1]] + [1e-13, 0, 0], x[e[1, 0]]
    model = model_of(x, [block("quad4", e, shell(1e-3), first=11)], element_sets={"S": members(0, 4)})
    with pytest.raises(InputError, match=r"surface 'S' has \d facet\(s\) without area.*of element 12"):
        facets_of(model, "S", where="[contact.c] main")


def test_set_without_free_faces_is_empty():
    x, e = solid_mesh((3, 3, 3), SIZE)
    inner = np.flatnonzero((np.abs(x[e].mean(axis=1) - np.array(SIZE) / 2) < 1e-9).all(axis=1))
    model = model_of(x, [block("hex8", e, SOLID)], element_sets={"CORE": np.column_stack([0 * inner, inner])})
    with pytest.raises(InputError, match="surface 'CORE' is empty; expected shell elements or free faces of solids"):
        facets_of(model, "CORE", where="")
