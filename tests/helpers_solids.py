"""Blocks of solid elements."""

from __future__ import annotations

import numpy as np

from creak.elements.registry import FORMULATIONS
from creak.model.faces import FACES, MIDDLES
from helpers_fem import Mesh

KINDS = {kind: FORMULATIONS[kind] for kind in FACES}
EDGES = {
    "tet10": MIDDLES["tet10"],
    **dict.fromkeys(("hex20", "hex20r", "hex20s"), MIDDLES["hex20"]),
    "wedge15": MIDDLES["wedge15"],
}
WEDGES = np.array([[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]])
TETRAHEDRA = np.array([[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]])


def solid_mesh(
    n: tuple[int, int, int], size: tuple[float, float, float], kind: str = "hex8", distortion: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and elements of a box from the origin; inner nodes are moved by up to `distortion` of a cell."""
    axes = [np.linspace(0.0, length, k + 1) for length, k in zip(size, n, strict=True)]
    coords = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    row = np.arange(coords.shape[0]).reshape(tuple(k + 1 for k in n))
    low = [row[:-1, :-1], row[1:, :-1], row[1:, 1:], row[:-1, 1:]]
    hexes = np.stack([a[:, :, :-1].ravel() for a in low] + [a[:, :, 1:].ravel() for a in low], axis=1)
    cell = np.array(size) / np.array(n)
    shift = np.random.default_rng(4).uniform(-1.0, 1.0, coords.shape) * distortion * cell
    outer = np.isclose(coords, 0.0) | np.isclose(coords, size)
    coords = coords + np.where(outer, 0.0, shift)
    if kind == "pyramid5":
        centres = coords.shape[0] + np.arange(len(hexes))
        bases = np.array([face[::-1] for face in FACES["hex8"]])
        elements = np.concatenate([hexes[:, bases], np.tile(centres[:, None, None], (1, 6, 1))], axis=2).reshape(-1, 5)
        return np.concatenate([coords, coords[hexes].mean(axis=1)]), elements
    table = {"h": np.arange(8)[None], "w": WEDGES, "t": TETRAHEDRA}[kind[0]]
    elements = hexes[:, table].reshape(-1, table.shape[1])
    return with_middle_nodes(coords, elements, EDGES[kind]) if kind in EDGES else (coords, elements)


def with_middle_nodes(
    coords: np.ndarray, elements: np.ndarray, edges: tuple[tuple[int, int], ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Quadratic elements with straight edges from linear ones."""
    ends = np.sort(elements[:, np.array(edges)], axis=2)
    pairs, at = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
    middle = len(coords) + at.reshape(len(elements), len(edges))
    return np.concatenate([coords, coords[pairs].mean(axis=1)]), np.concatenate([elements, middle], axis=1)


def block(
    n: tuple[int, int, int], size: tuple[float, float, float], kind: str = "hex8", distortion: float = 0.0
) -> Mesh:
    """The box as a mesh of one of the solid elements."""
    return Mesh(*solid_mesh(n, size, kind, distortion), KINDS[kind])


def in_place(mesh: Mesh, coords: np.ndarray) -> Mesh:
    """The same elements at other places."""
    return Mesh(coords, mesh.elements, mesh.module)
