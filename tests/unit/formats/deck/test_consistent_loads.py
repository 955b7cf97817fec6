"""Pressure on faces with and without middle nodes, held to integrals of their shape functions.

The shape functions stand on their own here: polynomials that are 1 at one node and 0 at the others.
"""

from __future__ import annotations

import numpy as np
import pytest

from creak.formats.deck.pressure import Pressed, nodal_forces
from creak.model.face_shapes import FaceShapes, faces_of_facets, facets_alone
from creak.model.shell_facets import SHELL_FACETS

SQUARE = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [0, -1], [1, 0], [0, 1], [-1, 0]], dtype=float)
TRIANGLE = np.array([[0, 0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5]], dtype=float)
POWERS = {"quad4": "00 10 01 11", "quad8": "00 10 01 20 11 02 21 12", "tri3": "00 10 01", "tri6": "00 10 01 20 11 02"}


def terms(kind: str, points: np.ndarray) -> np.ndarray:
    return np.stack([points[:, 0] ** int(a) * points[:, 1] ** int(b) for a, b in POWERS[kind].split()], axis=1)


def consistent(kind: str, nodes: np.ndarray, pressure: np.ndarray, J: np.ndarray) -> np.ndarray:
    """int N (N p) dA of an affine face with Jacobian J, by many Gauss points."""
    x, w = np.polynomial.legendre.leggauss(8)
    points, weights = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2), np.outer(w, w).ravel()
    if kind.startswith("tri"):  # the square folded onto the triangle
        u, v = 0.5 * (1.0 + points.T)
        points, weights = np.stack([u, v * (1.0 - u)], axis=1), 0.25 * weights * (1.0 - u)
    N = terms(kind, points) @ np.linalg.inv(terms(kind, nodes))
    few = kind[:-1] + ("3" if kind.startswith("tri") else "4")
    p = terms(few, points) @ np.linalg.inv(terms(few, nodes[: int(few[-1])])) @ pressure
    return N.T @ (weights * p) * abs(np.linalg.det(J))


def pressed(kind: str, corner_pressure: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Forces along z on one face in the plane, its natural nodes and its Jacobian."""
    n = len(corner_pressure)
    natural = (SQUARE if n == 4 else TRIANGLE)[: int(kind[-1])]
    J = np.array([[3.0, 0.7], [-0.4, 2.0]])
    coords = np.column_stack([natural @ J.T + 5.0, np.full(len(natural), 2.0)])
    middles = 0.5 * (corner_pressure + np.roll(corner_pressure, -1))
    at = np.concatenate([corner_pressure, middles])
    corners = np.array(SHELL_FACETS[kind])
    shapes = faces_of_facets(kind, np.tile(np.arange(len(natural)), (len(corners), 1)), corners)
    rows, forces = nodal_forces(Pressed(corners, at[corners], np.full((len(corners), 3), np.nan), shapes), coords)
    assert rows.tolist() == list(range(len(natural)))
    np.testing.assert_allclose(forces[:, :2], 0.0, atol=1e-12)
    return forces[:, 2], natural, J


@pytest.mark.parametrize(
    ("kind", "shares"),
    [
        ("quad4", [1 / 4] * 4),
        ("quad8", [-1 / 12] * 4 + [1 / 3] * 4),
        ("tri3", [1 / 3] * 3),
        ("tri6", [0.0] * 3 + [1 / 3] * 3),
    ],
)
def test_even_pressure_has_the_known_shares(kind, shares):
    """Cook, Malkus, Plesha and Witt, Concepts and Applications of Finite Element Analysis, section 3.11."""
    forces, _, J = pressed(kind, np.full(4 if kind.startswith("quad") else 3, 2.0))
    area = abs(np.linalg.det(J)) * (4.0 if kind.startswith("quad") else 0.5)
    np.testing.assert_allclose(forces, 2.0 * area * np.array(shares), rtol=0.0, atol=1e-12 * area)


@pytest.mark.parametrize(("kind", "exact"), [("quad4", 1e-12), ("quad8", 0.02), ("tri3", 1e-12), ("tri6", 1e-12)])
def test_pressure_that_varies(kind, exact):
    """Of a square with middle nodes it is linear on each facet, where the corners alone would have it bilinear."""
    pressure = np.array([1.0, 3.0, -2.0, 5.0])[: 4 if kind.startswith("quad") else 3]
    forces, natural, J = pressed(kind, pressure)
    expected = consistent(kind, natural, pressure, J)
    np.testing.assert_allclose(forces, expected, rtol=0.0, atol=exact * np.abs(expected).max())
    assert forces.sum() == pytest.approx(expected.sum(), rel=1e-12)


def test_a_direction_takes_the_place_of_the_normal():
    corners = np.array([[0, 1, 2, 3]])
    coords = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 3.0, 0.0], [0.0, 3.0, 0.0]])
    along = np.array([[0.6, 0.0, 0.8]])
    shapes: FaceShapes = facets_alone(corners)
    _, forces = nodal_forces(Pressed(corners, np.full((1, 4), 2.0), along, shapes), coords)
    np.testing.assert_allclose(forces, np.tile(along * 2.0 * 6.0 / 4.0, (4, 1)), rtol=1e-12)
