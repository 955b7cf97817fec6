"""Interface graph, node spacing, participation, and interpolation of the nodes in between."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

from creak.errors import InputError
from creak.model.materials import TrussSection
from creak.reduction.interface.interpolation import interpolation, rigid_motions
from creak.reduction.interface.participation import participating
from creak.reduction.interface.spacing import every_nth, interface_graph
from helpers_core import STEEL, beam_section, block, model_of, plate, point_mass, shell


def line(coords: np.ndarray, closed: bool = False) -> sp.csr_matrix:
    """Graph of a chain of nodes."""
    n = len(coords)
    a = np.arange(n if closed else n - 1)
    b = (a + 1) % n
    length = np.linalg.norm(coords[b] - coords[a], axis=1)
    return sp.csr_matrix((np.r_[length, length], (np.r_[a, b], np.r_[b, a])), shape=(n, n))


def straight(n: int) -> np.ndarray:
    return np.column_stack([np.arange(n, dtype=float), np.zeros(n), np.zeros(n)])


def helix(n: int) -> np.ndarray:
    t = np.linspace(0.0, 1.0, n) ** 1.3
    return np.column_stack([700.0 * np.cos(4.0 * t), 400.0 * np.sin(4.0 * t), 300.0 * t * t]) + 1000.0


# --- graph ----------------------------------------------------------------------------------------------


def test_graph_holds_element_edges_and_no_diagonals():
    coords, quads = plate(2, 1, (2.0, 3.0))  # nodes 0 1 / 2 3 / 4 5 along x
    extra = np.array([[2.0, 3.0, 5.0], [2.0, 3.0, 9.0]])
    blocks = [
        block("quad4", quads[:1], shell(1e-3)),
        block("tri3", [[2, 4, 5]], shell(1e-3), 0, 10),
        block("beam2", [[5, 6]], beam_section(), 0, 20),
        block("truss2", [[6, 7]], TrussSection("T", STEEL, 1e-4), 0, 30),
        block("mass", [[3]], point_mass(1.0), 0, 40),
    ]
    nodes = np.array([7, 6, 5, 4, 3, 2, 1])
    graph = interface_graph(model_of(np.vstack([coords, extra]), blocks), nodes)
    # The quadrilateral 0 2 3 1 without node 0, the triangle 2 4 5, beam and truss. Not 3-5: no element.
    expected = {
        (2, 3): 3.0,
        (1, 3): 1.0,
        (2, 4): 1.0,
        (4, 5): 3.0,
        (2, 5): np.hypot(1.0, 3.0),
        (5, 6): 5.0,
        (6, 7): 4.0,
    }
    g = sp.triu(graph).tocoo()
    ends = np.sort(np.stack([nodes[g.row], nodes[g.col]], axis=1), axis=1)
    assert {tuple(e): v for e, v in zip(ends.tolist(), g.data, strict=True)} == pytest.approx(expected)
    assert (abs(graph - graph.T)).nnz == 0


def test_graph_of_200_000_elements_counts_every_edge_once():
    n = 447
    coords, quads = plate(n, n)
    model = model_of(coords, [block("quad4", quads, shell(1e-3))])
    row = np.flatnonzero(coords[:, 0] < 1.5 / n)  # two rows of nodes
    assert interface_graph(model, row).nnz == 2 * (2 * n + (n + 1))


def test_node_listed_twice_is_an_error():
    coords, quads = plate(1, 1)
    with pytest.raises(InputError, match="lists a node twice"):
        interface_graph(model_of(coords, [block("quad4", quads, shell(1.0))]), np.array([0, 1, 0]))


# --- spacing --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("n", "expected"), [(1, range(11)), (2, range(0, 11, 2)), (4, (0, 4, 8, 10)), (10, (0, 10)), (99, (0, 10))]
)
def test_line_keeps_every_nth_node_and_both_ends(n, expected):
    np.testing.assert_array_equal(every_nth(line(straight(11)), n), list(expected))


def test_line_is_counted_along_itself_not_in_order_of_rows():
    order = np.array([5, 2, 7, 0, 3, 1, 6, 4])  # order[i]: position of the i-th node along the line
    graph = line(straight(8)).tocoo()
    shuffled = sp.csr_matrix((graph.data, (order[graph.row], order[graph.col])), shape=(8, 8))
    # Ends are positions 4 and 5; counting starts at 4, which is node 7: nodes 7, 4, 1 and the other end 0.
    np.testing.assert_array_equal(every_nth(shuffled, 3), np.sort(order[[7, 4, 1, 0]]))


@pytest.mark.parametrize(("nodes", "n", "count"), [(12, 3, 4), (13, 3, 5), (1380, 8, 173), (12, 1, 12), (5, 9, 1)])
def test_closed_loop_is_divided_equally(nodes, n, count):
    angle = 2.0 * np.pi * np.arange(nodes) / nodes
    kept = every_nth(line(np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]), closed=True), n)
    assert kept.size == count
    assert kept[0] == 0
    gaps = np.diff(np.r_[kept, nodes])
    assert gaps.max() <= max(n, nodes if count == 1 else 0)
    assert np.ptp(gaps) <= 1


def test_patch_keeps_nodes_apart_and_leaves_no_hole():
    coords, quads = plate(9, 6)
    graph = interface_graph(model_of(coords, [block("quad4", quads, shell(1e-3))]), np.arange(len(coords)))
    edges = sp.csgraph.shortest_path(graph, unweighted=True)
    for n in (2, 3, 4):
        kept = every_nth(graph, n)
        between = edges[np.ix_(kept, kept)] + 1e9 * np.eye(kept.size)
        assert between.min() >= n
        assert edges[:, kept].min(axis=1).max() < n
    np.testing.assert_array_equal(every_nth(graph, 1), np.arange(len(coords)))


def test_pieces_are_independent_and_single_nodes_stay():
    graph = sp.block_diag([line(straight(5)), sp.csr_matrix((1, 1)), line(straight(4))], format="csr")
    np.testing.assert_array_equal(every_nth(graph, 3), [0, 3, 4, 5, 6, 9])


def test_spacing_below_one_is_an_error():
    with pytest.raises(InputError, match="spacing 0"):
        every_nth(line(straight(3)), 0)


# --- participation --------------------------------------------------------------------------------------


def test_participation_follows_the_two_criteria():
    """20 translations of size 1..20 and one dof that moves in one mode only; percentile by hand."""
    size = np.arange(1.0, 21.0)
    shapes = np.column_stack([size, -size])
    # 95th percentile of 1..20, linear between ranks: rank 0.95 x 19 = 18.05 -> 19.05.
    keep = participating(shapes, 0.4, dofs=np.ones(20, dtype=np.int64))
    np.testing.assert_array_equal(keep, size > 0.4 * 19.05)  # 8 and above stay
    spike = shapes.copy()
    spike[0] = [0.0, 12.0]  # mean 6 is below 7.62, the largest 12 is not
    assert participating(spike, 0.4, dofs=np.ones(20, dtype=np.int64))[0]
    assert not participating(spike, 0.65, dofs=np.ones(20, dtype=np.int64))[0]


def test_rotations_are_measured_against_rotations():
    """A change of the unit of length scales translations only and must not change the choice."""
    shapes = np.random.default_rng(3).standard_normal((60, 5))
    unit = np.tile(np.repeat([1000.0, 1.0], 3), 10)[:, None]
    keep = participating(shapes, 0.5)
    assert 0 < np.count_nonzero(~keep) < 30
    np.testing.assert_array_equal(keep, participating(unit * shapes, 0.5))
    rotation = np.arange(60) % 6 >= 3
    order = np.argsort(rotation, kind="stable")
    np.testing.assert_array_equal(keep[order], participating(shapes[order], 0.5, dofs=np.arange(60)[order] % 6 + 1))


def test_participation_refuses_bad_input():
    with pytest.raises(InputError, match=r"eta = 1\.2"):
        participating(np.ones((6, 2)), 1.2)
    with pytest.raises(InputError, match="no modes"):
        participating(np.ones((6, 0)), 0.2)
    with pytest.raises(InputError, match="no whole nodes"):
        participating(np.ones((7, 2)), 0.2)


# --- interpolation --------------------------------------------------------------------------------------


@pytest.mark.parametrize(("nodes", "n"), [(9, 2), (33, 5), (301, 60)])
def test_rigid_motion_of_a_curved_line_is_exact(nodes, n):
    coords = helix(nodes)
    graph = line(coords)
    kept = every_nth(graph, n)
    P = interpolation(graph, coords, kept)
    R = rigid_motions(coords)
    dofs = (6 * kept[:, None] + np.arange(6)).ravel()
    np.testing.assert_allclose(P @ R[dofs], R, atol=1e-12 * np.abs(R).max())
    np.testing.assert_array_equal(P[dofs].toarray(), np.eye(dofs.size))
    # Local: no node follows more than the two kept nodes beside it.
    assert np.diff(sp.csr_matrix(P).indptr).max() <= 12


def test_straight_line_reproduces_linear_and_cubic_motion():
    """Between unequal kept nodes: u_x and twist linear in x, u_z cubic with slope -theta_y, as a thin beam."""
    coords = straight(13) * [3.0, 0.0, 0.0]
    x = coords[:, 0]
    u = np.zeros((13, 6))
    u[:, 0], u[:, 3] = 2.0 + 0.3 * x, 1.0 - 0.1 * x
    u[:, 2], u[:, 4] = x**3 - 5.0 * x**2, -(3.0 * x**2 - 10.0 * x)
    u[:, 1], u[:, 5] = x**2, 2.0 * x
    kept = np.array([0, 5, 7, 12])
    P = interpolation(line(coords), coords, kept)
    np.testing.assert_allclose(P @ u[kept].ravel(), u.ravel(), atol=1e-12 * np.abs(u).max())


def test_arc_bends_instead_of_stretching():
    """One end of a quarter circle turned, the other held, its length stays.

    Stretch against curvature times radius is of the order of (radius of gyration / radius)^2 = (0.1 x 0.08)^2."""
    angle = np.linspace(0.0, 0.5 * np.pi, 21)
    coords = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(21)])
    u = interpolation(line(coords), coords, np.array([0, 20])).toarray()[:, 11].reshape(-1, 6)
    steps = np.diff(coords, axis=0)
    stretch = (np.diff(u[:, :3], axis=0) * steps).sum(axis=1) / (steps**2).sum(axis=1)
    curvature = np.diff(u[:, 5]) / np.linalg.norm(steps, axis=1)
    assert np.abs(curvature).max() > 1.0
    assert np.abs(stretch).max() < 1e-3 * np.abs(curvature).max()


def test_patch_and_unit_of_length():
    """Rigid motion on a warped patch, and the same P in mm and m (rotation columns scaled)."""
    coords, quads = plate(8, 6, (400.0, 300.0))
    coords[:, 2] = 1e-3 * coords[:, 0] * coords[:, 1]
    model = model_of(coords, [block("quad4", quads, shell(1.0))])
    graph = interface_graph(model, np.arange(63))
    kept = every_nth(graph, 3)
    P = interpolation(graph, coords, kept)
    R = rigid_motions(coords)
    dofs = (6 * kept[:, None] + np.arange(6)).ravel()
    np.testing.assert_allclose(P @ R[dofs], R, atol=1e-12 * np.abs(R).max())
    S, S_k = (np.tile(np.repeat([1e-3, 1.0], 3), k) for k in (63, kept.size))
    in_metres = interpolation(1e-3 * graph, 1e-3 * coords, kept)
    # Round-off of the static solve, entries being of order one.
    np.testing.assert_allclose(in_metres.toarray(), S[:, None] * P.toarray() / S_k, atol=1e-9)


def test_all_kept_is_the_identity_and_coincident_nodes_move_together():
    coords = straight(5)
    assert abs(interpolation(line(coords), coords, np.arange(5)) - sp.identity(30)).max() == 0.0
    double = coords[[0, 1, 2, 2, 3]]
    graph = line(double)
    graph[2, 3] = graph[3, 2] = 1e-3
    P = interpolation(sp.csr_matrix(graph), double, np.array([0, 4])).toarray()
    # A joint 1e-3 of an edge long: as stiff as 1e3 (rotation) and 1e9 (displacement) against one.
    np.testing.assert_allclose(P[12:18], P[18:24], atol=5e-3)


def test_piece_without_kept_node_is_an_error():
    graph = sp.block_diag([line(straight(4)), line(straight(3))], format="csr")
    with pytest.raises(InputError, match=r"3 interface nodes are connected to no kept node .*position 4"):
        interpolation(graph, np.vstack([straight(4), straight(3)]), np.array([0, 3]))
