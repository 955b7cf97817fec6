"""Element matrices of a block as assembled: rigid arms, mass consistent, lumped or with linear shape functions; loads
of heat.

Those are the forces at the nodes that hold an element as it is against a rise in temperature, reversed: f = integral of
B' D alpha dT, with the strains B of the element's own stiffness, so that an element that is free to expand ends without
stress (Zienkiewicz and Taylor, The Finite Element Method, vol. 1 (2000), section 2.2). dT is given at the nodes and
constant through thickness and section."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.elements import beam2, beam3
from creak.elements.discrete import arm_matrix
from creak.elements.geometry import CHUNK, gauss_square
from creak.elements.registry import FORMULATIONS
from creak.elements.shells import quad4_geometry
from creak.elements.shells.rigidity import areal_mass
from creak.model.materials import BeamSection, GeneralShell, Section, ShellSection, Structural, TrussSection
from creak.model.mesh import ElementBlock, Own


def block_matrices(
    block: ElementBlock, rows: slice | IntArray, coords: FloatArray, *, form: str = "consistent"
) -> tuple[FloatArray, FloatArray, FloatArray | None]:
    """K, M and C (None without dashpots) of some elements of a block.

    Where elements have arms, their corners are at node + arm and follow the node as a rigid body:
    K = T' K_corner T with T = diag([I, -(arm x); 0, I]).

    Parameters
    ----------
    rows : which elements.
    coords : (n_node, 3) of all nodes of the model.
    form : of the mass of structural elements, see `mass_matrices`. With lumped or linear mass quadrilateral shells get
        the stiffness that goes with it (`Formulation.softened`).

    Returns
    -------
    (n, d, d) each, node by node (ux, uy, uz, rx, ry, rz) in global axes.

    Raises
    ------
    DegenerateElement : see the formulation.
    """
    formulation, own = FORMULATIONS[block.kind], block.own.take(rows)
    x = coords[block.nodes_idx[rows]]
    if isinstance(block.section, GeneralShell) and block.section.rigid:
        nothing = np.zeros((len(x), 6 * x.shape[1], 6 * x.shape[1]))
        return nothing, nothing, None
    if own.arms is not None:
        x = x + own.arms
    stiffness = formulation.stiffness if form == "consistent" else formulation.softened or formulation.stiffness
    K = stiffness(x, block.section, own)
    M = mass_matrices(block, x, own, form)
    C = formulation.damping(x, block.section, own) if formulation.damping else None
    if own.arms is None:
        return K, M, C
    return _follow(K, own.arms), _follow(M, own.arms), None if C is None else _follow(C, own.arms)


def _follow(matrix: FloatArray, arms: FloatArray) -> FloatArray:
    """T' matrix T, exactly symmetric."""
    n, n_node, _ = arms.shape
    T = np.zeros((n, n_node, 6, n_node, 6))
    each = arm_matrix(arms.reshape(-1, 3)).reshape(n, n_node, 6, 6)
    for i in range(n_node):
        T[:, i, :, i, :] = each[:, i]
    flat = T.reshape(n, 6 * n_node, 6 * n_node)
    out = flat.transpose(0, 2, 1) @ matrix @ flat
    return np.asarray(0.5 * (out + out.transpose(0, 2, 1)), dtype=np.float64)


def mass_matrices(block: ElementBlock, x: FloatArray, own: Own, form: str) -> FloatArray:
    """Mass (n, d, d) of elements with corners x (n, n_node, 3).

    * consistent: the element's own;
    * lumped: on the translations of the nodes, see `lumped`, and the inertia of beams about their axis;
    * linear: translations only, with linear shape functions. Of bars the mean of lumped and linear along the axis,
      (5, 1; 1, 5) m/12, and across it cubic, or lumped where nothing resists bending (trusses, rods); solids,
      and shells with middle nodes, as consistent. This is the coupled mass of Nastran.

    Discrete elements are as they are.
    """
    consistent = FORMULATIONS[block.kind].mass
    if form == "consistent" or not isinstance(block.section, Structural):
        return consistent(x, block.section, own)
    if block.kind == "beam3":
        return beam3.of_halves(x, own, lambda half, mine: _of_form(replace(block, kind="beam2"), half, mine, form))
    return _of_form(block, x, own, form)


def _of_form(block: ElementBlock, x: FloatArray, own: Own, form: str) -> FloatArray:
    """Lumped or linear."""
    consistent = FORMULATIONS[block.kind].mass
    if form == "lumped":
        matrix = lumped(consistent(x, block.section, own))
        return matrix + _lumped_twist(x, block.section) if isinstance(block.section, BeamSection) else matrix
    if isinstance(block.section, ShellSection | GeneralShell) and block.kind in ("quad4", "tri3"):
        return linear_shell_mass(x, block.section, own)
    if isinstance(block.section, BeamSection) and (block.section.i11 or block.section.i22):
        return _bar_mass(x, block.section, own)
    if isinstance(block.section, BeamSection | TrussSection):
        return _rod_mass(x, block.section)
    return consistent(x, block.section, own)


def linear_shell_mass(x: FloatArray, section: ShellSection | GeneralShell, own: Own) -> FloatArray:
    """integral of m h_i h_j on the three translations of triangles or quadrilaterals."""
    n, k, _ = x.shape
    if k == 3:
        shapes = np.array([[4.0, 1.0, 1.0], [1.0, 4.0, 1.0], [1.0, 1.0, 4.0]]) / 6.0
        area = np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1)
        weights = np.repeat(area[:, None] / 6.0, 3, axis=1)
    else:
        points, share = gauss_square(2)
        shapes = quad4_geometry.shape(points)
        along_r, along_s = quad4_geometry.tangents(x, points)
        weights = np.linalg.norm(np.cross(along_r, along_s), axis=2) * share
    density = areal_mass(section, 1.0 if own.thickness is None else own.thickness @ shapes.T)[0]
    products = np.einsum("ng,gi,gj->nij", weights * density, shapes, shapes, optimize=True)
    out = np.zeros((n, k, 6, k, 6))
    for dof in range(3):
        out[:, :, dof, :, dof] = products
    return out.reshape(n, 6 * k, 6 * k)


def _bar_mass(x: FloatArray, section: BeamSection, own: Own) -> FloatArray:
    """The Euler-Bernoulli mass with (5, 1; 1, 5)/12 instead of (4, 2; 2, 4)/12 along the axis."""
    plain = replace(section, shear_area1=0.0, shear_area2=0.0)
    matrix = beam2.mass(x, plain, own).reshape(-1, 2, 6, 2, 6)
    along = _along(x)
    line_mass = section.material.density * section.area + section.line_mass
    sway = np.array([[1.0, -1.0], [-1.0, 1.0]]) / 12.0 * line_mass
    for i in range(2):
        for j in range(2):
            matrix[:, i, :3, j, :3] += sway[i, j] * along
    return matrix.reshape(-1, 12, 12)


def _rod_mass(x: FloatArray, section: BeamSection | TrussSection) -> FloatArray:
    """(5, 1; 1, 5) m/12 along the axis, m/2 at each end across it; the inertia about the axis at the ends."""
    line_mass = section.material.density * section.area
    line_mass += section.line_mass if isinstance(section, BeamSection) else 0.0
    length = np.linalg.norm(x[:, 1] - x[:, 0], axis=1)
    out = np.zeros((x.shape[0], 2, 6, 2, 6))
    for i in range(2):
        out[:, i, :3, i, :3] = 0.5 * line_mass * length[:, None, None] * np.eye(3)
        for j in range(2):
            out[:, i, :3, j, :3] += (-1.0 if i == j else 1.0) / 12.0 * line_mass * _along(x)
    matrix = out.reshape(-1, 12, 12)
    return matrix + _lumped_twist(x, section) if isinstance(section, BeamSection) else matrix


def _lumped_twist(x: FloatArray, section: BeamSection) -> FloatArray:
    """Half of the inertia about the axis at each end."""
    out = np.zeros((x.shape[0], 2, 6, 2, 6))
    for i in range(2):
        out[:, i, 3:, i, 3:] = 0.5 * section.polar_inertia * _along(x)
    return out.reshape(-1, 12, 12)


def _along(x: FloatArray) -> FloatArray:
    """L t t' (n, 3, 3) of bars of length L along t."""
    line = x[:, 1] - x[:, 0]
    return np.asarray(np.einsum("ni,nj->nij", line, line) / np.linalg.norm(line, axis=1)[:, None, None])


def lumped(mass: FloatArray) -> FloatArray:
    """Diagonal masses on the translations of each node, nothing on the rotations.

    The row sums of the consistent mass; where one of them is not positive (quadratic elements) its diagonal scaled
    to the element's mass (Hinton, Rock and Zienkiewicz, Earthquake Eng. Struct. Dyn. 4 (1976) 245). Mass and, for
    elements symmetric about their centre, the centre of mass are kept; moments of inertia change by the order of
    the mesh. Rotations without mass are massless coordinates.

    Parameters
    ----------
    mass : (n, 6 n_node, 6 n_node) consistent mass, node by node (ux, uy, uz, rx, ry, rz).

    Returns
    -------
    (n, 6 n_node, 6 n_node).
    """
    d = mass.shape[1]
    x = np.arange(0, d, 6)
    sums = mass[:, x][:, :, x].sum(axis=2)
    diagonal = mass[:, x, x]
    scaled = diagonal * (sums.sum(axis=1) / np.maximum(diagonal.sum(axis=1), 1e-300))[:, None]
    share = np.where((sums > 0.0).all(axis=1)[:, None], sums, scaled)
    out = np.zeros_like(mass)
    for axis in range(3):
        out[:, x + axis, x + axis] = share
    return out


def block_heat_load(
    block: ElementBlock, coords: FloatArray, rise: FloatArray, *, form: str = "consistent"
) -> FloatArray:
    """(n_elem, d) forces of a block on its nodes, rigid arms (which do not expand) included.

    Parameters
    ----------
    block : of a kind with a `Formulation.heat_load`.
    coords : (n_node, 3) of all nodes of the model. rise : (n_elem, n_node_per_element) above what strains nothing.
    form : of the mass, as of `block_matrices`.
    """
    formulation = FORMULATIONS[block.kind]
    heated = None if form == "consistent" else formulation.softened_heat_load
    heated = heated or formulation.heat_load
    assert heated is not None
    out = np.zeros((block.ids.size, 6 * block.nodes_idx.shape[1]))
    for start in range(0, block.ids.size, CHUNK):
        rows = slice(start, start + CHUNK)
        own, x = block.own.take(rows), coords[block.nodes_idx[rows]]
        x = x if own.arms is None else x + own.arms
        forces = heated(x, block.section, own, rise[rows])
        if own.arms is not None:
            each = arm_matrix(own.arms.reshape(-1, 3)).transpose(0, 2, 1) @ forces.reshape(-1, 6, 1)
            forces = each.reshape(forces.shape)
        out[rows] = forces
    return out


def expands(kind: str, section: Section) -> bool:
    """Whether heat strains elements of a kind with that section."""
    if FORMULATIONS[kind].heat_load is None or (isinstance(section, GeneralShell) and section.rigid):
        return False
    return expansion_of(section) is not None


def expansion_of(section: Section) -> Any:
    """`Expansion` of the section's material, `ShellExpansion` of a shell, None without."""
    source = section if isinstance(section, GeneralShell) else getattr(section, "material", None)
    return getattr(source, "expansion", None)
