"""The door is a valid mesh at every size: proper elements, right mass, right gap."""

from __future__ import annotations

import numpy as np
import pytest

from creak.arrays import FloatArray, IntArray
from creak_thesis.door import FINEST_MESH_SIZE, Door, build_door
from creak_thesis.door import geometry as geo
from creak_thesis.door.assembly import carrier_mesh, checked_mesh_size
from creak_thesis.door.deck import mass
from creak_thesis.door.mesh import PartMesh
from helpers_door import door

pytestmark = pytest.mark.once

TOTAL_MASS = 10.05
BENCHMARK_DOF = 1_169_406
sizes = pytest.mark.parametrize("mesh_size", [40.0, 20.0, 10.0])


def corner_products(part: PartMesh) -> FloatArray:
    """Sine of every corner's angle, measured against the mean normal of its quad: (m, 4)."""
    q = part.coords[part.quads]
    normal = np.cross(q[:, 2] - q[:, 0], q[:, 3] - q[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    out = []
    for k in range(4):
        a, b = q[:, (k + 1) % 4] - q[:, k], q[:, k - 1] - q[:, k]
        out.append((np.cross(a, b) * normal).sum(1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1))
    return np.array(out).T


def directed_edges(part: PartMesh) -> IntArray:
    """Edges (n, 2) of all elements in the sense in which each walks them."""
    return np.concatenate(
        [np.stack([c, np.roll(c, -1, axis=1)], axis=-1).reshape(-1, 2) for c in (part.quads, part.tris)]
    )


@sizes
def test_quads_are_convex_and_not_squashed(mesh_size: float) -> None:
    for part in door(mesh_size).parts:
        assert corner_products(part).min() > 0.5
        q = part.coords[part.quads]
        side = np.linalg.norm(np.roll(q, -1, axis=1) - q, axis=2)
        assert (side.max(axis=1) / side.min(axis=1)).max() < 6.5
        assert 0.7 * mesh_size < side.mean() < 1.2 * mesh_size


@sizes
def test_triangles_are_few_and_not_flat(mesh_size: float) -> None:
    frame = door(mesh_size).parts[0]
    assert 0 < frame.tris.shape[0] < 0.01 * frame.quads.shape[0]
    t = frame.coords[frame.tris]
    a, b = t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]
    area = 0.5 * np.linalg.norm(np.cross(a, b), axis=1)
    assert area.min() > 0.1 * mesh_size**2


@sizes
def test_every_node_is_used_once(mesh_size: float) -> None:
    for part in door(mesh_size).parts:
        used = np.unique(np.concatenate([part.quads.ravel(), part.tris.ravel()]))
        np.testing.assert_array_equal(used, np.arange(part.coords.shape[0]))
        # No node lies within a micrometre of another: rounded to 1e-3 mm they all differ.
        assert np.unique(part.coords.round(3), axis=0).shape == part.coords.shape


@sizes
def test_sheets_are_manifold_and_face_one_side(mesh_size: float) -> None:
    for part in door(mesh_size).parts:
        edges = directed_edges(part)
        # Neighbours of equal orientation walk their common edge in opposite senses.
        assert np.unique(edges, axis=0).shape == edges.shape
        assert np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)[1].max() == 2


@sizes
def test_parts_are_in_one_piece_with_the_right_holes(mesh_size: float) -> None:
    for part, euler in zip(door(mesh_size).parts, (-1, 1, 1), strict=True):
        n_edges = np.unique(np.sort(directed_edges(part), axis=1), axis=0).shape[0]
        n_faces = part.quads.shape[0] + part.tris.shape[0]
        # Euler characteristic: 1 for a sheet, one less for each hole (aperture and window).
        assert part.coords.shape[0] - n_edges + n_faces == euler


@sizes
def test_normals_point_where_the_deck_says(mesh_size: float) -> None:
    for part, sign in zip(door(mesh_size).parts, (1, -1, 1), strict=True):
        q = part.coords[part.quads]
        normal = np.cross(q[:, 2] - q[:, 0], q[:, 3] - q[:, 1])
        if part.name == "FRAME":
            normal = normal[part.tags["FRAME_FLANGE"]]
        assert (sign * normal[:, 1] > 0).all()


@sizes
def test_door_weighs_ten_kilograms(mesh_size: float) -> None:
    parts = mass(door(mesh_size))
    assert sum(parts.values()) == pytest.approx(TOTAL_MASS, rel=0.01 if mesh_size <= 20 else 0.02)
    # One geometry: the coarse facets only lose a little of the area of the relief.
    fine = mass(door(10.0))
    for name, kilograms in parts.items():
        assert kilograms == pytest.approx(fine[name], rel=0.02 if mesh_size <= 20 else 0.025)


@pytest.mark.parametrize("mesh_size", [20.0, 10.0])
def test_clear_gap_is_the_same_all_along_the_edge(mesh_size: float) -> None:
    frame, panel, _ = door(mesh_size).parts
    quads = frame.quads[frame.tags["FRAME_FLANGE"]]
    edge = panel.coords[panel.nodes_of("PANEL_EDGE")]
    distance = edge[:, 1] - height_under(frame, quads, edge)
    clear = distance - geo.FRAME_THICKNESS / 2 - geo.PANEL_THICKNESS / 2
    np.testing.assert_allclose(clear, geo.GAP, atol=0.15)


def height_under(part: PartMesh, quads: IntArray, points: FloatArray) -> FloatArray:
    """y of the facets straight behind each point (n,), each quad cut into two triangles."""
    height = np.full(points.shape[0], np.nan)
    for corners in (quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]):
        t = part.coords[corners]
        plane = np.stack([t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]], axis=2)[:, [0, 2], :]
        inverse = np.linalg.inv(plane)
        for k, p in enumerate(points):
            ab = np.einsum("nij,nj->ni", inverse, (p - t[:, 0])[:, [0, 2]])
            inside = np.flatnonzero((ab.min(axis=1) > -1e-6) & (ab.sum(axis=1) < 1 + 1e-6))
            if inside.size:
                n = inside[0]
                height[k] = t[n, 0, 1] + ab[n] @ (t[n, 1:, 1] - t[n, 0, 1])
    return height


def test_edge_of_the_tray_is_the_only_one_without_a_wall() -> None:
    panel = door(10.0).parts[1]
    x, z = panel.coords[:, 0], panel.coords[:, 2]
    height = panel.coords[:, 1] - geo.base(x, z) - geo.PANEL_OFFSET
    floor = (x > 200.0) & (x < 570.0) & (z > 670.0)
    assert np.abs(height[floor]).max() < 5.0
    # Anywhere else the panel has risen to its main surface 100 mm from its edge: 72 mm less the map pocket of 26.
    for place in ((900.0, 640.0), (600.0, 130.0), (130.0, 400.0), (1040.0, 400.0)):
        assert height[np.argmin(np.hypot(x - place[0], z - place[1]))] > 45.0


def test_node_count_grows_with_the_inverse_square_of_the_mesh_size() -> None:
    coarse, fine = door(20.0), door(10.0)
    # Rows and columns are whole numbers, at most 7 % off each way.
    assert fine.n_nodes / coarse.n_nodes == pytest.approx(4.0, rel=0.15)


def test_the_smallest_elements_are_sound() -> None:
    """The whole door has five million dofs at 2.03 mm; its carrier alone is quickly made."""
    carrier = carrier_mesh(checked_mesh_size(2.03))
    assert 6 * len(carrier.coords) > 600_000
    assert corner_products(carrier).min() > 0.3


def test_finest_mesh_has_the_size_of_the_benchmark() -> None:
    assert door(FINEST_MESH_SIZE).n_dof == pytest.approx(BENCHMARK_DOF, rel=0.02)


def test_panel_edge_is_two_rows_along_the_same_line_at_every_size() -> None:
    for mesh_size in (40.0, 10.0, 6.0):
        panel = door(mesh_size).parts[1]
        line = panel.nodes["EDGE_LINE"]
        assert panel.tags["PANEL_EDGE"].sum() == 2 * line.size
        target = geo.PANEL.walk(np.linspace(0.0, 1.0, 20001))
        target[:, 0] = geo.bow(target[:, 0], target[:, 1])
        for node in panel.coords[line]:
            # Half the spacing of the sampled line bounds the distance.
            assert np.hypot(*(target - node[[0, 2]]).T).min() < 0.1


def test_same_mesh_size_gives_the_same_mesh() -> None:
    first, again = build_door(20.0), build_door(20.0)
    for a, b in zip(first.parts, again.parts, strict=True):
        np.testing.assert_array_equal(a.coords, b.coords)
        np.testing.assert_array_equal(a.quads, b.quads)


def test_dof_counts_reference_nodes() -> None:
    d: Door = door(40.0)
    shells = sum(p.coords.shape[0] for p in d.parts)
    assert d.n_dof == 6 * (shells + 2 * 26 + 7)
