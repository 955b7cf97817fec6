"""Plates cut in two with a reduced interface: what each way of reducing it does to the frequencies."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as sla

from creak.arrays import to_dense
from creak.assembly.system import System, project
from creak.errors import InputError, NumericalError
from creak.linalg.modes import modes
from creak.model.mesh import Model
from creak.reduction.craig_bampton import craig_bampton
from creak.reduction.interface.characteristic import characteristic_modes
from creak.reduction.interface.coarse_mesh import coarse_basis, linked
from creak.reduction.interface.interpolation import interpolation, rigid_motions
from creak.reduction.interface.spacing import every_nth, interface_graph
from helpers_core import NO_DAMPING, NONE, block, couple, model_of, part_system, plate, shell

RECORDED = {"section": "reduction", "source": "whole interface"}

SIZE, CUT = (0.4, 0.4), 0.2
RIGID = 6
ELASTIC = slice(RIGID, RIGID + 6)
MODES = 15
"""Fixed-interface modes of each part."""


def cut_plate(n_x: int = 8, n_y: int = 12) -> tuple[Model, np.ndarray]:
    """A free plate of two parts that share the nodes of the line x = CUT, and the rows of these nodes."""
    coords, quads = plate(n_x, n_y, SIZE)
    left = coords[quads].mean(axis=1)[:, 0] < CUT
    blocks = [block("quad4", quads[left], shell(1e-3), 0), block("quad4", quads[~left], shell(1e-3), 1, 1000)]
    x = coords[:, 0]
    parts = [("A", np.flatnonzero(x < CUT + 1e-9)), ("B", np.flatnonzero(x > CUT - 1e-9))]
    return model_of(coords, blocks, parts), np.flatnonzero(np.abs(x - CUT) < 1e-9)


def reduced_parts(model: Model, line: np.ndarray, shape: object = None) -> list[System]:
    parts = [part_system(model, i, NO_DAMPING) for i in range(2)]
    return [
        craig_bampton(p, np.flatnonzero(np.isin(p.coordinates // 6, line)), count=MODES, shape=shape) for p in parts
    ]


def coupled(parts: list[System], model: Model) -> System:
    return couple(parts, model, NONE, NO_DAMPING)


def in_basis(system: System, P: np.ndarray) -> System:
    """The System whose boundary moves as P xi, all other coordinates as before."""
    boundary = system.coordinates >= 0
    V = np.zeros((system.n, np.count_nonzero(~boundary) + P.shape[1]))
    V[~boundary, : -P.shape[1]] = np.eye(np.count_nonzero(~boundary))
    V[boundary, -P.shape[1] :] = to_dense(P)
    return project(system, V)


def omega2(system: System) -> np.ndarray:
    return sla.eigh(to_dense(system.K), to_dense(system.M), eigvals_only=True)[ELASTIC]


@pytest.fixture(scope="module")
def full() -> tuple[Model, np.ndarray, System, list[System]]:
    """The cut plate with every dof of the interface, 13 nodes, 78 dofs: whole, and its parts."""
    model, line = cut_plate()
    parts = reduced_parts(model, line)
    return model, line, coupled(parts, model), parts


ROUND_OFF = 1e-7
"""Of omega^2: eps times the ratio of the highest to the lowest eigenvalue, some 1e9."""


# --- interpolation --------------------------------------------------------------------------------------


def test_interpolated_interface_gives_upper_bounds_that_converge(full, measured):
    model, line, whole, _ = full
    graph, coords = interface_graph(model, line), model.nodes.coords[line]
    exact, error = omega2(whole), []
    for n in (12, 6, 2, 1):
        P = interpolation(graph, coords, every_nth(graph, n))
        small = coupled(reduced_parts(model, line, P), model)
        assert small.n == P.shape[1] + 2 * MODES
        at_once = in_basis(whole, P)
        np.testing.assert_allclose(omega2(small), omega2(at_once), rtol=ROUND_OFF)
        ratio = omega2(small) / exact
        assert (ratio >= 1.0 - ROUND_OFF).all()
        error.append(np.sqrt(ratio.max()) - 1.0)
    # Nested spaces (12 | 6 | 2 | 1): no coarser one is better.
    assert error[0] >= error[1] >= error[2] >= error[3] - ROUND_OFF
    measured("interpolated interface, every node: frequency, relative error", error[3], at_most=ROUND_OFF)
    # A third of the spacing: a linear rate would give a third.
    assert error[2] < error[1] / 5.0
    measured("interpolated interface, every second node: frequency, relative error", error[2], at_most=0.01)


# --- characteristic constraint modes --------------------------------------------------------------------


def test_all_characteristic_modes_change_nothing_and_fewer_give_upper_bounds(full, measured):
    """System level: one eigenproblem of the coupled boundary."""
    whole = full[2]
    c = np.flatnonzero(whole.coordinates >= 0)
    K, M, exact = to_dense(whole.K), to_dense(whole.M), omega2(whole)
    worst = []
    for count in (12, 16, 24, 40, 78):
        Phi = characteristic_modes(K[np.ix_(c, c)], M[np.ix_(c, c)], count=count)
        assert Phi.shape == (78, count)
        small = in_basis(whole, Phi)
        ratio = omega2(small) / exact
        assert (ratio >= 1.0 - ROUND_OFF).all()
        worst.append(ratio.max())
    assert (np.diff(worst) <= ROUND_OFF).all()
    assert worst[0] > 1.0 + 1e-4
    measured("all characteristic constraint modes: omega^2 ratio, worst", worst[-1], 1.0, rel=ROUND_OFF)
    measured(
        "24 of 78 characteristic constraint modes: frequency, relative error", np.sqrt(worst[2]) - 1.0, at_most=0.01
    )


def test_characteristic_modes_are_the_lowest_eigenvectors():
    """A free chain of springs: known frequencies, the rigid mode first and kept."""
    n, k, m = 9, 2e4, 0.5
    K = k * (2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    K[0, 0] = K[-1, -1] = k
    f = np.sqrt(k / m) / np.pi * np.sin(0.5 * np.pi * np.arange(n) / n)
    Phi = characteristic_modes(K, m * np.eye(n), count=4)
    assert Phi.shape == (n, 4)
    np.testing.assert_allclose(m * Phi.T @ Phi, np.eye(4), atol=1e-10)
    scale = (2 * np.pi * f[3]) ** 2
    np.testing.assert_allclose(Phi.T @ K @ Phi, np.diag((2 * np.pi * f[:4]) ** 2), atol=1e-10 * scale)
    assert characteristic_modes(K, m * np.eye(n), count=99).shape == (n, n)


def test_massless_boundary_dofs_come_last_and_are_not_lost():
    M = np.diag([1.0, 0.0, 2.0, 0.0])
    K = np.array([[3.0, -1, 0, 0], [-1, 2.0, -1, 0], [0, -1, 4.0, -1], [0, 0, -1, 2.0]])
    Phi = characteristic_modes(K, M, count=4)
    assert np.linalg.matrix_rank(Phi) == 4
    np.testing.assert_allclose(Phi.T @ M @ Phi, np.diag([1.0, 1, 0, 0]), atol=1e-12)
    # The two modes with mass are those of the statically condensed matrix.
    i, o = [0, 2], [1, 3]
    condensed = K[np.ix_(i, i)] - K[np.ix_(i, o)] @ np.linalg.solve(K[np.ix_(o, o)], K[np.ix_(o, i)])
    expected = sla.eigh(condensed, M[np.ix_(i, i)], eigvals_only=True)
    np.testing.assert_allclose(np.diag(Phi.T @ K @ Phi)[:2], expected, rtol=1e-12)
    with pytest.raises(NumericalError, match="coordinate 2 has neither stiffness nor mass"):
        characteristic_modes(np.diag([1.0, 1, 0]), np.diag([1.0, 0, 0]), count=3)


# --- coarse mesh ----------------------------------------------------------------------------------------


def coarse_modes(n_x: int, n_y: int, kind: str, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coordinates, elements and modes of the whole plate, coarsely meshed."""
    coords, elements = plate(n_x, n_y, SIZE, kind=kind)
    system = part_system(model_of(coords, [block(kind, elements, shell(1e-3))]), 0, NO_DAMPING)
    shapes = np.zeros((6 * len(coords), count))
    shapes[system.coordinates] = modes(system.K, system.M, count=count, free=True).shapes
    if kind == "tri3":
        elements = np.column_stack([elements, np.full(len(elements), -1)])
    return coords, elements, shapes


@pytest.mark.parametrize("kind", ["quad4", "tri3"])
def test_modes_of_a_mesh_twice_as_coarse_carry_the_interface(full, kind):
    """Less than half of the dofs, frequencies within 1 %."""
    model, line, whole, _ = full
    B = coarse_basis(*coarse_modes(4, 6, kind, 20), model.nodes.coords[line])
    assert B.shape[1] < 0.5 * 6 * line.size
    small = in_basis(whole, B)
    ratio = np.sqrt(omega2(small) / omega2(whole))
    assert (ratio >= 1.0 - ROUND_OFF).all()
    assert ratio.max() < 1.01


def test_coarse_basis_holds_rigid_motion_and_truncates(full):
    model, line, _, _ = full
    fine = model.nodes.coords[line]
    coarse = coarse_modes(4, 6, "quad4", 20)
    B = coarse_basis(*coarse, fine)
    edge = 0.5 * (SIZE[0] / 4 + SIZE[1] / 6)
    S = np.tile(np.repeat([1.0, edge], 3), line.size)[:, None]
    np.testing.assert_allclose((S * B).T @ (S * B), np.eye(B.shape[1]), atol=1e-12)
    R = rigid_motions(fine)
    np.testing.assert_allclose(B[:, :6] @ ((S * B[:, :6]).T @ (S * R)), R, atol=1e-12)
    few = coarse_basis(*coarse, fine, count=9)
    np.testing.assert_array_equal(few, B[:, :9])
    with pytest.raises(InputError, match="coarse modes of 6 rows"):
        coarse_basis(coarse[0], coarse[1], np.ones((6, 1)), fine)
    with pytest.raises(InputError, match="no elements"):
        coarse_basis(coarse[0], np.zeros((0, 4), dtype=np.int64), coarse[2], fine)


def test_linked_interpolation_is_exact_for_rigid_and_quadratic_motion():
    """Nodes off the surface and weights that miss x: rigid motion. Bilinear weights: constant curvature."""
    rng = np.random.default_rng(4)
    sources, coords = rng.standard_normal((4, 3)), rng.standard_normal((7, 3))
    W = rng.random((7, 4))
    W /= W.sum(axis=1)[:, None]
    R = rigid_motions
    np.testing.assert_allclose(linked(W, coords, sources) @ R(sources), R(coords), atol=1e-13)
    corners = np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]])
    r, s = 2.0 * rng.random(7), rng.random(7)
    W = np.column_stack([(1 - r / 2) * (1 - s), r / 2 * (1 - s), r / 2 * s, (1 - r / 2) * s])
    H = np.array([[0.7, -0.3], [-0.3, 0.4]])

    def bent(x: np.ndarray) -> np.ndarray:
        """w = x' H x / 2, theta_x = w,y and theta_y = -w,x."""
        gradient = x[:, :2] @ H
        u = np.zeros((len(x), 6))
        u[:, 2] = 0.5 * (x[:, :2] * gradient).sum(axis=1)
        u[:, 3], u[:, 4] = gradient[:, 1], -gradient[:, 0]
        return u.ravel()

    inside = np.column_stack([r, s, np.zeros(7)])
    np.testing.assert_allclose(linked(W, inside, corners) @ bent(corners), bent(inside), atol=1e-13)
