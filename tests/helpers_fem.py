"""Small meshes, a tiny assembler and a dense or sparse solver for tests of the elements alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from creak.elements.free_sides import ending_sides, free_sides, twisting_sides
from creak.elements.shells import quad4 as shell_quad4
from creak.elements.shells import quad8 as shell_quad8
from creak.elements.shells import tri3 as shell_tri3
from creak.elements.shells import tri6 as shell_tri6
from creak.model.materials import Material, ShellSection
from creak.model.mesh import Own

KINDS = {"quad": shell_quad4, "tri": shell_tri3}
NONE = np.zeros(0, dtype=int)
QUADRATIC = {"quad8": shell_quad8, "tri6": shell_tri6}


@dataclass
class Mesh:
    """Nodes (n_node, 3), elements (n_elem, n_node_per_element) and the module that computes them."""

    coords: np.ndarray
    elements: np.ndarray
    module: object

    @property
    def n_dof(self) -> int:
        return 6 * len(self.coords)

    def nodes(self, select: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        return np.flatnonzero(select(self.coords))

    def assemble(self, blocks: np.ndarray) -> sp.csc_matrix:
        dofs = (6 * self.elements[:, :, None] + np.arange(6)).reshape(len(self.elements), -1)
        rows = np.repeat(dofs, dofs.shape[1], axis=1).ravel()
        cols = np.tile(dofs, (1, dofs.shape[1])).ravel()
        return sp.coo_matrix((blocks.ravel(), (rows, cols)), shape=(self.n_dof, self.n_dof)).tocsc()

    def stiffness(self, section: ShellSection, held: np.ndarray = NONE) -> sp.csc_matrix:
        """Of the elements beside supports that hold the dof rows `held`."""
        if self.elements.shape[1] == 3:
            axes = np.zeros((len(self.coords), 6))
            axes.ravel()[np.asarray(held, dtype=int)] = 1.0
            at = np.flatnonzero(axes[:, 3:].any(axis=1))
            ends = ending_sides(self.coords, [self.elements])[0]
            free = twisting_sides(self.coords, self.elements, ends, at, axes[at, 3:, None] * np.eye(3))
        else:
            free = free_sides([self.elements])[0]
        own = Own(free_sides=free)
        return self.assemble(self.module.stiffness(self.coords[self.elements], section, own))

    def mass(self, section: ShellSection) -> sp.csc_matrix:
        return self.assemble(self.module.mass(self.coords[self.elements], section))


def shell_section(thickness: float, youngs_modulus: float, poisson_ratio: float, density: float = 1.0) -> ShellSection:
    return ShellSection("S", Material("M", youngs_modulus, poisson_ratio, density), thickness)


def grid(n_x: int, n_y: int, shape: Callable[[np.ndarray, np.ndarray], np.ndarray], kind: str = "quad") -> Mesh:
    """Structured mesh of the unit square mapped by `shape(xi, eta)` -> (..., 3)."""
    if kind in QUADRATIC:
        return _quadratic(n_x, n_y, shape, kind)
    xi, eta = np.meshgrid(np.linspace(0, 1, n_x + 1), np.linspace(0, 1, n_y + 1), indexing="ij")
    coords = np.asarray(shape(xi.ravel(), eta.ravel()), dtype=float)
    first = (np.arange(n_x)[:, None] * (n_y + 1) + np.arange(n_y)).ravel()
    quads = np.column_stack([first, first + n_y + 1, first + n_y + 2, first + 1])
    return with_kind(coords, quads, kind)


def _quadratic(n_x: int, n_y: int, shape: Callable[[np.ndarray, np.ndarray], np.ndarray], kind: str) -> Mesh:
    """Elements with middle nodes, which are where `shape` puts them."""
    xi, eta = np.meshgrid(np.linspace(0, 1, 2 * n_x + 1), np.linspace(0, 1, 2 * n_y + 1), indexing="ij")
    row = np.arange(xi.size).reshape(xi.shape)
    at = [row[i : i + 2 * n_x - 1 : 2, j : j + 2 * n_y - 1 : 2].ravel() for i in range(3) for j in range(3)]
    order = [[0, 6, 8, 2, 3, 7, 5, 1]] if kind == "quad8" else [[0, 6, 8, 3, 7, 4], [0, 8, 2, 4, 5, 1]]
    elements = np.concatenate([np.stack([at[k] for k in one], axis=1) for one in order])
    used, inverse = np.unique(elements, return_inverse=True)
    coords = np.asarray(shape(xi.ravel(), eta.ravel()), dtype=float)[used]
    return Mesh(coords, inverse.reshape(elements.shape), QUADRATIC[kind])


def with_kind(coords: np.ndarray, quads: np.ndarray, kind: str) -> Mesh:
    """The quads as they are, or each cut in two triangles along its first diagonal."""
    if kind == "tri":
        elements = quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    else:
        elements = quads
    return Mesh(coords, elements, KINDS[kind])


def rectangle(n_x: int, n_y: int, length: float, width: float, kind: str = "quad") -> Mesh:
    return grid(n_x, n_y, lambda x, y: np.column_stack([length * x, width * y, 0 * x]), kind)


def macneal_patch(kind: str = "quad") -> Mesh:
    """The patch of MacNeal and Harder (1985): 0.24 x 0.12, four inner nodes, five quads."""
    plane = [
        (0, 0),
        (0.24, 0),
        (0.24, 0.12),
        (0, 0.12),
        (0.04, 0.02),
        (0.18, 0.03),
        (0.16, 0.08),
        (0.08, 0.08),
    ]
    coords = np.column_stack([np.array(plane), np.zeros(8)])
    quads = np.array([[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7], [4, 5, 6, 7]])
    return with_kind(coords, quads, kind)


def dof(nodes: np.ndarray | int, *numbers: int) -> np.ndarray:
    """Rows of dofs 1..6 of the nodes."""
    return (6 * np.atleast_1d(nodes)[:, None] + np.array(numbers) - 1).ravel()


def solve(
    stiffness: sp.csc_matrix, force: np.ndarray, held: np.ndarray, values: np.ndarray | float = 0.0
) -> np.ndarray:
    """u of K u = f with u[held] = values."""
    free = np.setdiff1d(np.arange(stiffness.shape[0]), held)
    u = np.zeros(stiffness.shape[0])
    u[held] = values
    right = force[free] - stiffness[free][:, held] @ u[held]
    u[free] = spla.spsolve(stiffness[free][:, free], right)
    return u


def frequencies(
    stiffness: sp.csc_matrix, mass: sp.csc_matrix, held: np.ndarray, count: int, shift: float
) -> np.ndarray:
    """The lowest natural frequencies in Hz; `shift` < 0 is in (rad/s)^2."""
    free = np.setdiff1d(np.arange(stiffness.shape[0]), held)
    k, m = stiffness[free][:, free], mass[free][:, free]
    start = np.random.default_rng(0).standard_normal(len(free))
    lam = spla.eigsh(k, k=count, M=m, sigma=shift, v0=start, return_eigenvectors=False)
    return np.sqrt(np.sort(np.maximum(lam, 0.0))) / (2 * np.pi)


def rigid_modes(coords: np.ndarray) -> np.ndarray:
    """(6 n_node, 6): three translations and the three rotations about the origin."""
    modes = np.zeros((len(coords), 6, 6))
    modes[:, :3, :3] = modes[:, 3:, 3:] = np.eye(3)
    for axis, direction in enumerate(np.eye(3)):
        modes[:, :3, 3 + axis] = np.cross(direction, coords)
    return modes.reshape(-1, 6)


def random_rotation(seed: int) -> np.ndarray:
    q, _ = scipy.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    return q * np.sign(np.linalg.det(q))
