"""Hexahedra of twenty nodes and wedges of fifteen: shape functions, hourglass modes, bending, curved edges, mass."""

from __future__ import annotations

import numpy as np
import pytest

from creak.elements.block_matrices import lumped
from creak.elements.geometry import gauss_triangle
from creak.elements.solids import hex20 as solid_hex20
from creak.elements.solids.wedges import quadratic
from creak.model.faces import MIDDLES
from creak.model.materials import Material, SolidSection
from creak.model.mesh import Own
from helpers_fem import dof, frequencies, solve
from helpers_solids import KINDS, block

STEEL = SolidSection("S", Material("STEEL", 2e11, 0.3, 7800.0))
TRIANGLES = np.array([[0, 0, -1], [1, 0, -1], [0, 1, -1], [0, 0, 1], [1, 0, 1], [0, 1, 1]], dtype=float)
SHAPES = {
    "hex20": (solid_hex20.reference, solid_hex20.NODES),
    "wedge15": (
        quadratic,
        np.concatenate([TRIANGLES, TRIANGLES[np.array(MIDDLES["wedge15"])].mean(axis=1)]),
    ),
}
QUADRATIC = pytest.mark.parametrize("kind", ["hex20", "hex20r", "hex20s", "wedge15"])


@pytest.mark.parametrize("kind", SHAPES)
def test_shape_functions_are_one_at_their_node_and_slopes_are_theirs(kind):
    make, nodes = SHAPES[kind]
    at_nodes = make(nodes, np.ones(len(nodes)))
    assert at_nodes.shapes == pytest.approx(np.eye(len(nodes)), abs=1e-15)
    points = np.random.default_rng(2).uniform(0.0, 0.5, (6, 3))
    found = make(points, np.ones(6))
    assert found.shapes.sum(axis=1) == pytest.approx(1.0, abs=1e-14)
    assert found.slopes @ nodes == pytest.approx(np.tile(np.eye(3), (6, 1, 1)), abs=1e-14)
    step = 1e-5
    for axis in range(3):
        ahead, behind = (make(points + sign * step * np.eye(3)[axis], np.ones(6)).shapes for sign in (1, -1))
        # Cubic polynomials: the error is h^2/6 times a third derivative of at most some tens.
        assert found.slopes[:, axis] == pytest.approx((ahead - behind) / (2 * step), abs=1e-8)


def modes_without_energy(mesh) -> int:
    keep = dof(np.arange(len(mesh.coords)), 1, 2, 3)
    energy = np.linalg.eigvalsh(mesh.stiffness(STEEL).toarray()[np.ix_(keep, keep)])
    assert energy[0] > -1e-12 * energy[-1]
    return int(np.count_nonzero(energy < 1e-9 * energy[-1]))


@pytest.mark.parametrize(
    ("kind", "alone", "in_a_row"), [("hex20", 6, 6), ("hex20s", 6, 6), ("hex20r", 12, 9), ("wedge15", 6, 6)]
)
def test_only_reduced_integration_has_hourglass_modes_and_only_alone_or_in_a_row(kind, alone, in_a_row):
    """60 dofs less 8 points of 6 strains are 12 motions without energy, 6 of them rigid; two in a straight row keep
    three of the others, neighbours on two sides stop all."""
    one = block((1, 1, 1), (1.0, 0.8, 0.6), kind)
    one.elements = one.elements[:1]
    used = np.unique(one.elements)
    one.coords, one.elements = one.coords[used], np.searchsorted(used, one.elements)
    one.coords += np.random.default_rng(5).uniform(-0.04, 0.04, one.coords.shape)
    assert modes_without_energy(one) == alone
    assert modes_without_energy(block((2, 1, 1), (2.0, 0.8, 0.6), kind)) == in_a_row
    assert modes_without_energy(block((2, 2, 1), (2.0, 0.8, 0.6), kind)) == 6


@QUADRATIC
@pytest.mark.parametrize("aspect", [0.2, 1.0, 8.0])
def test_pure_bending_of_one_block_is_exact(kind, aspect):
    """Energy E I kappa^2 L/2 x 2 of u = -x y, v = x^2/2 + nu (y^2 - z^2)/2, w = nu y z, which is quadratic."""
    mesh = block((1, 1, 1), (aspect, 1.0, 1.0), kind)
    x, y, z = (mesh.coords - 0.5 * mesh.coords.max(axis=0)).T
    u = np.zeros((len(mesh.coords), 6))
    u[:, 0], u[:, 1], u[:, 2] = -x * y, x * x / 2 + 0.3 * (y * y - z * z) / 2, 0.3 * y * z
    K = mesh.stiffness(SolidSection("S", Material("M", 1e6, 0.3, 1.0)))
    force = (K @ u.ravel()).reshape(-1, 6)
    assert u.ravel() @ force.ravel() == pytest.approx(1e6 / 12 * aspect, rel=1e-9)
    ends = np.isclose(np.abs(x), 0.5 * aspect)
    # Linear stress: no force but at the ends.
    assert np.abs(force[~ends]).max(initial=0.0) < 1e-9 * np.abs(force).max()


@pytest.mark.parametrize("kind", ["hex20", "wedge15"])
def test_constant_strain_is_exact_where_inner_edges_are_curved(kind):
    """B det is of degree five in each coordinate of a hexahedron; prisms curve along their axis only."""
    mesh = block((2, 2, 2), (2.0, 2.0, 2.0), kind)
    border = mesh.nodes(lambda x: (np.isclose(x, 0.0) | np.isclose(x, 2.0)).any(axis=1))
    inner = np.setdiff1d(np.arange(len(mesh.coords)), border)
    shift = np.random.default_rng(8).uniform(-0.15, 0.15, (inner.size, 3))
    mesh.coords[inner] += shift if kind == "hex20" else [0.0, 0.0, 0.1] * np.sign(shift)
    exact = np.zeros((len(mesh.coords), 6))
    exact[:, :3] = mesh.coords @ (1e-3 * np.array([[1.0, 0.5, -0.3], [0.2, -0.7, 0.4], [0.6, 0.1, 0.8]]))
    held = np.union1d(dof(border, 1, 2, 3), dof(np.arange(len(mesh.coords)), 4, 5, 6))
    u = solve(mesh.stiffness(STEEL), np.zeros(mesh.n_dof), held, exact.ravel()[held])
    assert u == pytest.approx(exact.ravel(), abs=1e-10 * np.abs(exact).max())


def tip(kind: str, n: int, poisson: float = 0.25) -> float:
    """Deflection over that of a beam, 10 x 1 x 1 under a unit end force, root free to contract: one layer of n blocks,
    two across the width.

    The force is the parabolic shear of beam theory, spread over the end as its work on the shape functions asks.
    """
    section = SolidSection("S", Material("M", 1e6, poisson, 1.0))
    mesh = block((n, 1, 2), (10.0, 1.0, 1.0), kind)
    x = mesh.coords
    root, end = mesh.nodes(lambda x: np.isclose(x[:, 0], 0.0)), mesh.nodes(lambda x: np.isclose(x[:, 0], 10.0))
    foot = root[np.argmin(np.linalg.norm(x[root], axis=1))]
    other = root[np.argmin(np.linalg.norm(x[root] - [0.0, 0.0, 1.0], axis=1))]
    held = np.concatenate([dof(root, 1), dof(foot, 2, 3), dof(other, 2), dof(np.arange(len(x)), 4, 5, 6)])
    force = np.zeros(mesh.n_dof)
    force[dof(end, 2)] = end_shares(x[end])
    u = solve(mesh.stiffness(section), force, np.unique(held))
    exact = 1e3 / (3 * 1e6 / 12) + 10.0 / (5 / 6 * section.material.shear_modulus)
    return float(force[dof(end, 2)] @ u[dof(end, 2)]) / exact


def end_shares(x: np.ndarray) -> np.ndarray:
    """Forces (n,) that do the work of the stress 6 y (1 - y) on eight polynomials of y and z; their sum is 1."""
    y, z = x[:, 1], x[:, 2]
    at, weight = np.polynomial.legendre.leggauss(4)
    s, t = (v.ravel() for v in np.meshgrid(at, at, indexing="ij"))
    w = np.outer(weight, weight).ravel() / 4.0
    terms = [
        lambda a, b: np.ones_like(a),
        lambda a, b: a,
        lambda a, b: b,
        lambda a, b: a * b,
        lambda a, b: a * a,
        lambda a, b: b * b,
        lambda a, b: a * a * b,
        lambda a, b: a * b * b,
    ]
    V = np.stack([f(2 * y - 1, 2 * z - 1) for f in terms], axis=1)
    work = np.stack([f(s, t) for f in terms]) @ (w * 1.5 * (1.0 - s**2))
    return np.linalg.lstsq(V.T, work, rcond=None)[0]


@QUADRATIC
def test_cantilever_of_few_blocks_follows_beam_theory(kind):
    """One layer. A constant moment is exact; its change along the blocks holds 1/(4 n^2) of the energy: 1 % of it in five
    blocks, of which hexahedra may lose less than a half, and .5 % in seven, all of which wedges may lose."""
    assert tip(kind, 7 if kind == "wedge15" else 5) == pytest.approx(1.0, abs=5e-3)


def test_reduced_integration_bends_nearly_incompressible_material():
    assert tip("hex20r", 5, 0.4999) == pytest.approx(1.0, abs=1e-3)
    assert tip("hex20", 5, 0.4999) < 0.998


@QUADRATIC
def test_bending_frequencies_of_a_free_bar_follow_beam_theory(kind):
    """Shear and rotary inertia lower the frequency by 1e-3; the blocks, 5:1, raise it as in the cantilever."""
    mesh = block((12 if kind == "wedge15" else 8, 1, 2), (2.0, 0.05, 0.05), kind)
    keep = dof(np.arange(len(mesh.coords)), 1, 2, 3)
    K, M = (A[keep][:, keep].tocsc() for A in (mesh.stiffness(STEEL), mesh.mass(STEEL)))
    found = frequencies(K, M, np.zeros(0, dtype=int), 8, -1e4)
    beam = 4.730041**2 / (2 * np.pi * 2.0**2) * np.sqrt(2e11 * 0.05**2 / 12 / 7800)
    assert np.abs(found[:6]).max() < 1e-2 * beam
    assert found[6:8] == pytest.approx(beam, rel=5e-3)


@pytest.mark.parametrize("kind", SHAPES)
def test_mass_of_straight_elements_is_exact(kind):
    """Against a rule of higher degree."""
    mesh = block((1, 1, 1), (1.0, 0.8, 0.6), kind)
    x = mesh.coords[mesh.elements] @ np.array([[1.0, 0.2, 0.0], [0.0, 1.0, 0.1], [0.3, 0.0, 1.0]])
    at, weight = np.polynomial.legendre.leggauss(6)
    r, s, t = (v.ravel() for v in np.meshgrid(at, at, at, indexing="ij"))
    w = np.multiply.outer(np.outer(weight, weight), weight).ravel()
    if kind == "wedge15":  # Duffy's map of the square to the triangle
        r, s, w = (1 + r) / 2, (1 - r) * (1 + s) / 4, w * (1 - r) / 8
    rule = SHAPES[kind][0](np.column_stack([r, s, t]), w)
    det = np.linalg.det(np.einsum("gai,nix->ngax", rule.slopes, x))
    expected = 7800.0 * np.einsum("ng,gi,gj->nij", det * w, rule.shapes, rule.shapes)
    M = mesh.module.mass(x, STEEL)
    assert M[:, ::6, ::6] == pytest.approx(expected, rel=1e-12, abs=1e-12 * expected.max())
    assert M[:, 3::6].any() == np.False_


@QUADRATIC
def test_lumped_masses_are_positive_and_sum_to_the_mass(kind):
    mesh = block((1, 1, 1), (1.0, 0.8, 0.6), kind)
    x = mesh.coords[mesh.elements]
    diagonal = np.diagonal(lumped(mesh.module.mass(x, STEEL)), axis1=1, axis2=2)
    assert diagonal[:, ::6].min() > 0.0
    assert diagonal[:, ::6].sum() == pytest.approx(7800.0 * 0.48, rel=1e-12)
    assert not diagonal[:, 3::6].any()


def test_the_rule_of_the_wedge_mass_is_of_degree_four():
    points, weights = gauss_triangle()
    assert weights @ points[:, 0] ** 2 * 1.0 == pytest.approx(1 / 6)
    assert weights @ (points[:, 0] ** 2 * points[:, 1] ** 2) == pytest.approx(2 * 4 / 720)


@QUADRATIC
def test_numbering_does_not_matter(kind):
    """Turned by a third about its axis a wedge, by a quarter about t a hexahedron, is the same element."""
    if kind == "wedge15":
        order = np.array([1, 2, 0, 4, 5, 3, 7, 8, 6, 10, 11, 9, 13, 14, 12])
    else:
        order = np.array([1, 2, 3, 0, 5, 6, 7, 4, 9, 10, 11, 8, 13, 14, 15, 12, 17, 18, 19, 16])
    mesh = block((1, 1, 1), (1.0, 0.8, 0.6), kind)
    x = mesh.coords[mesh.elements[:1]]
    x = x + np.random.default_rng(9).uniform(-0.05, 0.05, x.shape)
    dofs = (6 * order[:, None] + np.arange(6)).ravel()
    for matrix in (KINDS[kind].stiffness, KINDS[kind].mass):
        K = matrix(x, STEEL, Own())[0]
        turned = matrix(x[:, order], STEEL, Own())[0]
        np.testing.assert_allclose(turned, K[np.ix_(dofs, dofs)], atol=1e-12 * np.abs(K).max(), rtol=0.0)
