"""Lumped and linear mass, and the softened shell stiffness that goes with them."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as sla

from creak.elements.block_matrices import block_matrices
from creak.elements.shells import quad4 as shell_quad4
from creak.model.materials import BeamSection, Material, PointMass, ShellSection, SolidSection, TrussSection
from creak.model.mesh import ElementBlock, Own

STEEL = Material("S", 2.0e5, 0.0, 7.8e-9)
SHELL = ShellSection("T", Material("S", 2.0e5, 0.3, 7.8e-9), 0.5)
BEAM = BeamSection("B", STEEL, 12.0, 9.0, 16.0, 20.0, line_mass=1e-8)
QUAD = np.array([[0.0, 0, 0], [3, 0, 0.1], [2.5, 2, 0], [0, 1.5, 0]])
LINE = np.array([[0.0, 0, 0], [2, 1, 2]])
CUBE = np.array([[x, y, z] for z in (0.0, 1.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
CASES = [
    ("quad4", SHELL, QUAD),
    ("tri3", SHELL, QUAD[:3]),
    ("beam2", BEAM, LINE),
    ("truss2", TrussSection("R", STEEL, 2.0), LINE),
    ("hex8", SolidSection("V", STEEL), CUBE),
]


def matrices(kind, section, coords, form, **own):
    block = ElementBlock(kind, np.array([1]), np.arange(len(coords))[None], section, 0, own=Own(**own))
    K, M, _ = block_matrices(block, slice(None), np.asarray(coords, dtype=float), form=form)
    return K[0], M[0]


@pytest.mark.parametrize("form", ["lumped", "linear"])
@pytest.mark.parametrize(("kind", "section", "coords"), CASES)
def test_mass_and_moment_are_kept(kind, section, coords, form):
    """Total mass in each direction; linear mass keeps the first moment too."""
    consistent, M = (matrices(kind, section, coords, f)[1] for f in ("consistent", form))
    for axis in range(3):
        move = np.zeros(len(M))
        move[axis::6] = 1.0
        assert move @ M @ move == pytest.approx(move @ consistent @ move, rel=1e-6 if kind == "quad4" else 1e-12)
    np.testing.assert_allclose(M, M.T)
    assert sla.eigvalsh(M).min() > -1e-12 * np.abs(M).max()


def test_lumped_is_diagonal_on_translations():
    for kind, section, coords in CASES:
        M = matrices(kind, section, coords, "lumped")[1]
        if kind == "beam2":
            continue
        assert np.count_nonzero(M - np.diag(M.diagonal())) == 0
        assert not M.reshape(len(coords), 6, -1)[:, 3:].any()


def test_bar():
    """(5, 1; 1, 5) m/12 along the axis; half the inertia about it at each end, or none where it is given as none."""
    t, length = LINE[1] / 3.0, 3.0
    m = (7.8e-9 * 12.0 + 1e-8) * length
    M = matrices("beam2", BEAM, LINE, "linear")[1].reshape(2, 6, 2, 6)
    along = np.einsum("i,aibj,j->ab", t, M[:, :3, :, :3], t)
    np.testing.assert_allclose(along, m * np.array([[5, 1], [1, 5]]) / 12.0)
    for twist, wanted in ((None, 0.5 * 7.8e-9 * 25.0 * length), (0.0, 0.0)):
        section = BeamSection("B", STEEL, 12.0, 9.0, 16.0, 20.0, twist_inertia=twist)
        M = matrices("beam2", section, LINE, "lumped")[1].reshape(2, 6, 2, 6)
        assert t @ M[0, 3:, 0, 3:] @ t == pytest.approx(wanted, rel=1e-12, abs=1e-20)


def test_points_keep_their_inertia():
    section = PointMass("P", 2.0, (1.0, 2.0, 3.0, 0.0, 0.0, 0.0))
    _, M = matrices("mass", section, LINE[:1], "lumped")
    np.testing.assert_allclose(M.diagonal(), [2, 2, 2, 1, 2, 3])


def test_thickness_at_the_corners():
    """Linear mass of a plate twice as thick at all corners is twice as large."""
    one, two = (matrices("quad4", SHELL, QUAD, "linear", thickness=np.full((1, 4), f))[1] for f in (1.0, 2.0))
    np.testing.assert_allclose(two, 2.0 * one)


def test_softened_stiffness_keeps_constant_states():
    """Constant curvature and stretch have no shear, so nothing changes; rigid motion costs no energy."""
    flat = np.array([[0.0, 0], [3, 0.2], [2.5, 2], [0.1, 1.5]])
    coords = np.column_stack([flat, np.zeros(4)])
    hard, soft = (f(coords[None], SHELL)[0] for f in (shell_quad4.stiffness, shell_quad4.softened_stiffness))
    x, y = flat.T
    u = np.zeros((4, 6))
    u[:, 2], u[:, 3], u[:, 4] = 0.5 * (x * x + x * y + y * y), 0.5 * x + y, -(x + 0.5 * y)
    u[:, 0], u[:, 1] = 0.3 * x + 0.1 * y, 0.1 * x - 0.2 * y
    np.testing.assert_allclose(soft @ u.ravel(), hard @ u.ravel(), atol=1e-9 * np.abs(hard @ u.ravel()).max())
    assert np.linalg.matrix_rank(soft, tol=1e-9 * np.abs(soft).max()) == 18


@pytest.mark.parametrize("n", [1, 2, 5])
def test_softened_cantilever_is_exact(n):
    """P L^3/(3 E I) + P L/(S b) with any number of elements, S = 5/6 G t.

    The other stiffness lacks 1/(4 n^2) of the bending and gives back the most of it that a share p = 1/(1 + phi) of the
    shear strain can: S becomes (1 - p)^2 S + 12 D p^2/h^2, phi = 12 D/(S h^2) + 36 D_t/(S b^2), D_t = D/2 without
    Poisson's ratio.
    """
    length, width, t = 20.0, 2.0, 0.5
    section = ShellSection("T", STEEL, t)
    nodes = np.array([[length * i / n, width * j, 0.0] for i in range(n + 1) for j in range(2)])
    quads = np.array([[2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1] for i in range(n)])
    tips = []
    for stiffness in (shell_quad4.softened_stiffness, shell_quad4.stiffness):
        K = np.zeros((6 * len(nodes),) * 2)
        for quad, Ke in zip(quads, stiffness(nodes[quads], section), strict=True):
            dofs = (6 * quad[:, None] + np.arange(6)).ravel()
            K[np.ix_(dofs, dofs)] += Ke
        f = np.zeros(len(K))
        f[[-10, -4]] = 0.5
        tips.append(np.linalg.solve(K[12:, 12:], f[12:])[-4])
    D, S, h = 2e5 * t**3 / 12.0, 5 / 6 * 1e5 * t, length / n
    p = 1.0 / (1.0 + D / S * (12.0 * h**-2 + 18.0 * width**-2))
    softer = (1.0 - p) ** 2 * S + 12.0 * D * p**2 / h**2
    bending = length**3 / (3 * D * width)
    assert tips[0] == pytest.approx(bending + length / (S * width), rel=1e-7)
    assert tips[1] == pytest.approx(bending * (1.0 - 0.25 / n**2) + length / (softer * width), rel=1e-7)
