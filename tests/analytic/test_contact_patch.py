"""Contact patch test: two blocks with meshes that do not match, pressed together evenly, stay evenly strained.

Taylor and Papadopoulos, On a patch test for contact problems in two dimensions (1991); here in space.
"""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from creak.contact.node_to_surface import node_to_surface
from creak.contact.pair import ContactPair
from creak.contact.surface_to_surface import surface_to_surface
from creak.model.faces import FACES, face_numbers, faces_of
from creak.model.materials import SolidSection
from creak.model.mesh import Model, Surface
from helpers_core import NO_DAMPING, STEEL, block, model_of, part_system
from helpers_solids import EDGES, solid_mesh

RECORDED = {"section": "contact", "source": "uniform pressure"}

METHODS = {"surface-to-surface": surface_to_surface, "node-to-surface": node_to_surface}
SIZE, PRESSURE = (1.0, 1.0, 0.5), 1e6
NON_MATCHING = [((3, 3, 2), (4, 4, 2)), ((4, 4, 2), (3, 3, 2)), ((5, 4, 2), (3, 7, 2)), ((3, 7, 1), (5, 4, 2))]


def two_blocks(
    low: tuple[int, int, int],
    high: tuple[int, int, int],
    *,
    kinds: tuple[str, str] = ("hex8", "hex8"),
    rotation: np.ndarray | None = None,
) -> Model:
    """Block TOP on block LOW, without a gap."""
    x_low, e_low = solid_mesh(low, SIZE, kinds[0])
    x_high, e_high = solid_mesh(high, SIZE, kinds[1])
    n = x_low.shape[0]
    coords = np.vstack([x_low, x_high + [0.0, 0.0, SIZE[2]]])
    section = SolidSection("S", STEEL)
    blocks = [block(kinds[0], e_low, section, 0), block(kinds[1], e_high + n, section, 1, 10_000)]
    surfaces = [face_at(0, blocks[0], coords, SIZE[2], "LOW"), face_at(1, blocks[1], coords, SIZE[2], "TOP")]
    turned = coords if rotation is None else coords @ rotation.T
    parts = [("LOW", range(n)), ("TOP", range(n, coords.shape[0]))]
    return model_of(turned, blocks, parts, surfaces=surfaces)


def face_at(row: int, elements, coords: np.ndarray, z: float, name: str) -> Surface:
    """The faces of a block of elements in the plane z."""
    faces = faces_of(elements.kind, elements.nodes_idx)
    element, face = np.nonzero((np.abs(coords[faces][..., 2] - z) < 1e-9).all(axis=2))
    pairs = np.column_stack([np.full(element.size, row), element])
    return Surface(name, pairs, face + 1, np.zeros(0, dtype=np.int64))


def even_load(model: Model, block_row: int, z: float, coords: np.ndarray) -> np.ndarray:
    """(n_node,) int N dA over the faces in the plane z (rectangles or their halves).

    With middle nodes: of rectangles A / 3 there and -A / 12 at the corners, of triangles A / 3 there alone (Cook,
    Malkus, Plesha and Witt, Concepts and Applications of Finite Element Analysis, section 3.11).
    """
    elements = model.blocks[block_row]
    if elements.kind in EDGES:
        return even_load_with_middles(model, block_row, z, coords)
    faces = faces_of(elements.kind, elements.nodes_idx)
    faces = faces[(np.abs(coords[faces][..., 2] - z) < 1e-9).all(axis=2)]
    x = coords[faces]
    area = 0.5 * np.linalg.norm(np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]), axis=1)
    share = np.zeros(model.nodes.count)
    for k in range(4):
        real = (faces[:, 2] != faces[:, 3]) if k == 3 else np.ones(len(faces), dtype=bool)
        corners = np.where(faces[:, 2] == faces[:, 3], 3, 4)
        np.add.at(share, faces[real, k], (area / corners)[real])
    return share


def even_load_with_middles(model: Model, block_row: int, z: float, coords: np.ndarray) -> np.ndarray:
    kind, nodes = model.blocks[block_row].kind, model.blocks[block_row].nodes_idx
    facets, number, share = np.array(FACES[kind]), face_numbers(kind), np.zeros(model.nodes.count)
    first_middle = 1 + max(max(pair) for pair in EDGES[kind])
    for face in np.unique(number):
        places = np.unique(facets[number == face])
        mine = nodes[(np.abs(coords[nodes[:, places]][..., 2] - z) < 1e-9).all(axis=1)]
        corners, middles = mine[:, places[places < first_middle]], mine[:, places[places >= first_middle]]
        area = np.ptp(coords[corners][..., :2], axis=1).prod(axis=1) * (0.5 if corners.shape[1] == 3 else 1.0)
        np.add.at(share, middles, area[:, None] / 3.0)
        np.add.at(share, corners, area[:, None] * (0.0 if corners.shape[1] == 3 else -1.0 / 12.0))
    return share


def pressed(model: Model, operator, coords: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Channel forces and displacements under PRESSURE on the top: smooth walls below and on two sides.

    Penalty with an active set that is iterated to the end; contact forces are zero where the channel is open.
    """
    n = 6 * model.nodes.count
    K = sp.lil_matrix((n, n))
    for i in range(2):
        part = part_system(model, i, NO_DAMPING)
        K[np.ix_(part.coordinates, part.coordinates)] = part.K.toarray()
    held = [6 * np.flatnonzero(np.abs(coords[:, axis]) < 1e-9) + axis for axis in range(3)]
    free = np.setdiff1d(np.flatnonzero(K.diagonal() != 0.0), np.concatenate(held))
    f = np.zeros(n)
    f[2::6] = -PRESSURE * even_load(model, 1, 2 * SIZE[2], coords)
    G = sp.csr_matrix((operator.G.data, operator.labels[operator.G.indices], operator.G.indptr), shape=(operator.m, n))
    K, G = sp.csc_matrix(K)[free][:, free], G[:, free]
    active = np.ones(operator.m, dtype=bool)
    for _ in range(20):
        k = np.where(active, operator.stiffness, 0.0)
        u = spla.spsolve(sp.csc_matrix(K + G.T @ sp.diags(k) @ G), f[free])
        gap = operator.gap0 + G @ u
        if (active == (gap < 0.0)).all():
            break
        active = gap < 0.0
    else:
        raise AssertionError("the active set did not settle")
    whole = np.zeros(n)
    whole[free] = u
    return np.where(active, -operator.stiffness * gap, 0.0), whole.reshape(-1, 6)[:, :3]


def run(low, high, method: str, **options):
    model = two_blocks(low, high, **options)
    operator, notes = METHODS[method](model, ContactPair("c", "TOP", "LOW", method))
    assert notes == []
    force, u = pressed(model, operator, model.nodes.coords)
    return model, operator, force, u


@pytest.mark.parametrize(("low", "high"), NON_MATCHING)
def test_pressure_between_hexahedra_is_even(low, high, measured):
    """Surface-to-surface with the automatic penalty: within 1 % of the exact even pressure at every channel."""
    _, operator, force, _ = run(low, high, "surface-to-surface")
    assert operator.area.sum() == pytest.approx(1.0, rel=1e-9)
    assert force.sum() == pytest.approx(PRESSURE, rel=1e-9)
    measured(
        f"contact patch, {low} under {high} hexahedra: pressure, worst",
        force / operator.area,
        PRESSURE,
        rel=0.01,
        unit="Pa",
    )


def test_strain_is_even_too(measured):
    """Displacements of an even stress, up to the penetration: errors of 1 % in the pressure bend the blocks a little."""
    model, operator, _, u = run((3, 3, 2), (4, 4, 2), "surface-to-surface")
    E, nu, x = STEEL.youngs_modulus, STEEL.poisson_ratio, model.nodes.coords
    penetration = PRESSURE / (operator.stiffness / operator.area).mean()
    exact = PRESSURE / E * np.column_stack([nu * x[:, 0], nu * x[:, 1], -x[:, 2]])
    exact[model.parts[1].nodes_idx, 2] -= penetration
    error = np.abs(u - exact).max() / np.abs(exact).max()
    measured("contact patch: displacements, relative error", error, at_most=0.01, source="uniform stress")


OTHERS = [("tet4", "hex8"), ("hex8", "wedge6"), ("wedge6", "tet4")]
OTHERS += [("hex20", "hex20"), ("hex8", "hex20r"), ("tet10", "hex20"), ("wedge15", "tet10"), ("hex20", "wedge15")]


@pytest.mark.parametrize("kinds", OTHERS)
def test_pressure_between_other_solids_is_even(kinds, measured):
    """To 1.5 %: the points do not see where the facets of the other side begin."""
    _, operator, force, _ = run((4, 4, 2), (3, 3, 2), "surface-to-surface", kinds=kinds)
    measured(
        f"contact patch, {kinds[0]} under {kinds[1]}: pressure, worst",
        force / operator.area,
        PRESSURE,
        rel=0.015,
        unit="Pa",
    )


@pytest.mark.parametrize("kind", ["hex20", "hex20r", "hex20s", "tet10", "wedge15"])
def test_pressure_between_faces_with_middle_nodes_that_match_is_exact(kind, measured):
    _, operator, force, _ = run((2, 2, 1), (2, 2, 1), "surface-to-surface", kinds=(kind, kind))
    worst = np.abs(force / operator.area / PRESSURE - 1.0).max()
    measured(f"contact patch, {kind}: pressure, relative error", worst, at_most=1e-9)


def test_node_to_surface_is_uneven_on_non_matching_meshes():
    """Nodal forces over tributary areas are off by tens of per cent; their sum is right. Matching meshes are even."""
    model, operator, force, _ = run((4, 4, 2), (3, 3, 2), "node-to-surface")
    area = even_load(model, 1, SIZE[2], model.nodes.coords)[operator.nodes_idx]
    assert force.sum() == pytest.approx(PRESSURE, rel=1e-9)
    uneven = np.abs(force / area / PRESSURE - 1.0).max()
    assert 0.05 < uneven < 1.0
    model, operator, force, _ = run((3, 4, 2), (3, 4, 2), "node-to-surface")
    area = even_load(model, 1, SIZE[2], model.nodes.coords)[operator.nodes_idx]
    # One penalty per node, whatever its area, so nodes of the rim give way less: even as far as contact is stiff.
    np.testing.assert_allclose(force / area, PRESSURE, rtol=0.03)
