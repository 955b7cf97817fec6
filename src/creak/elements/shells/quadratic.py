"""What the shells with middle nodes share: strains of curved elements, sampled at few points, and what they give."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import DEGENERATE, in_chunks, require_sound, unit
from creak.elements.shells.common import shell_mass, weighted_gram, weighted_sum
from creak.elements.shells.quad4 import dilation, drilling
from creak.elements.shells.quad4_geometry import Surface, bending_strains, strain_transform, surface_of
from creak.elements.shells.quad4_membrane import condensed
from creak.elements.shells.rigidity import heat_resultants, rigidity
from creak.elements.solids.common import Reference
from creak.model.materials import GeneralShell, ShellSection
from creak.model.mesh import COMMON, Own

Monomials = Callable[[FloatArray], FloatArray]
STABLE = 1e-4
"""Share of the membrane energy beyond the sampled strains that is kept, so that an element alone has no hourglass mode.
Membrane locking of curved elements takes shares above some 1e-3."""


@dataclass(frozen=True)
class Shape:
    """A kind of element with k nodes; n_corner of them are corners, and come first."""

    n_corner: int
    nodes: Reference
    """Shape functions at the nodes."""
    full: Reference
    """At the points of integration."""
    few: Reference
    """At the points where membrane strains are sampled."""
    spread: FloatArray
    """What is sampled at `few`, at the points of `full`: (n_full, n_few) for the strains in local axes, or
    (n_full, 3, n_few, 3) for the covariant ones (e_rr, e_ss, 2 e_rs)."""
    bubble: FloatArray
    """(n_full, 3) value, slope by r and by s of the function of the inner rotations."""
    tied: Reference
    """At the points where transverse shear strains are sampled."""
    tied_bubble: FloatArray
    """(n_tied,) value of the bubble there."""
    tying: FloatArray
    """(n_full, 2, n_tied, 2): covariant shear strains at the points of `full` from those at the points of `tied`."""


def shear_tying(space: Monomials, at: FloatArray, sampled: FloatArray, conditions: FloatArray) -> FloatArray:
    """(n_at, 2, n_sampled, 2) of `Shape.tying`: the shear strains of a space that have the same moments.

    Parameters
    ----------
    space : points (n, 2) -> (n, 2, m), the m fields (g_r, g_s) that make the space.
    at, sampled : (n_at, 2), (n_sampled, 2) points.
    conditions : (m, n_sampled, 2) each a sum of g_r and g_s over the points.
    """
    moments = np.einsum("mpa,pak->mk", conditions, space(sampled))
    return np.asarray(np.einsum("gak,kpb->gapb", space(at), np.tensordot(np.linalg.inv(moments), conditions, 1)))


def stiffness(shape: Shape, coords: FloatArray, section: ShellSection | GeneralShell, own: Own = COMMON) -> FloatArray:
    """integral of [e k]' [A B; B D] [e k] + g' S g.

    x = sum h_i x_i + z sum h_i V_i,   u = sum h_i u_i + z (sum h_i theta_i x V_i + b beta),   |z| <= t/2

    V_i is the element's own normal at node i, beta are two inner rotations with a bubble b, condensed out. The
    covariant strains are those of the four-node shell, see `shells.quad4.stiffness`, and vanish exactly in rigid motion
    of a curved element. Against locking e is sampled at few points, of what that leaves out the share `STABLE` of the
    energy is kept, and g has the moments of the sampled one in a smaller space (Bathe, Brezzi and Cho, Comput. Struct.
    32 (1989) 797: MITC7, MITC9). The drilling penalty is that of the four-node shell.
    """
    coords = np.asarray(coords, dtype=np.float64)
    _require_sound(shape, coords)
    n_dof = 6 * coords.shape[1]

    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        surface, normals = surface_at(piece, shape, shape.full), _directors(shape, piece)
        stiff = rigidity(section, surface.axes, mine, shape.full.shapes)
        direct = membrane(piece, shape.full, surface)
        e = _sampled(shape, piece, surface)
        bent = bending_strains(normals, shape.full.slopes, surface)
        k = np.concatenate([bent, _inner_curvature(shape, piece, surface)], axis=3)
        if stiff.B is None:
            K = weighted_gram(k, stiff.D, surface.weights)
            K[:, :n_dof, :n_dof] += weighted_gram(e, stiff.A, surface.weights)
        else:
            both = np.concatenate([np.pad(e, ((0, 0), (0, 0), (0, 0), (0, 2))), k], axis=2)
            K = weighted_gram(both, stiff.coupled, surface.weights)
        K += weighted_gram(_shear(shape, piece, normals, surface), stiff.S, surface.weights)
        K[:, :n_dof, :n_dof] += weighted_gram(direct - e, STABLE * stiff.A, surface.weights)
        K[:, :n_dof, :n_dof] += drilling(surface, stiff, shape.full.shapes, shape.full.slopes)
        return condensed(K, n_dof)

    return in_chunks(kernel, coords, n_dof, own)


def mass(shape: Shape, coords: FloatArray, section: ShellSection | GeneralShell, own: Own = COMMON) -> FloatArray:
    """Consistent mass with rotary inertia, see `shell_mass`; the shape functions themselves are quadratic."""
    coords = np.asarray(coords, dtype=np.float64)
    _require_sound(shape, coords)
    no_edges = np.zeros_like(shape.full.shapes)

    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        surface = surface_at(piece, shape, shape.full)
        middle = _mean_axes(shape, piece)[1]
        return shell_mass(piece, middle, surface.weights, shape.full.shapes, no_edges, section, mine)

    return in_chunks(kernel, coords, 6 * coords.shape[1], own)


def geometric_stiffness(
    shape: Shape, coords: FloatArray, section: ShellSection | GeneralShell, own: Own, u: FloatArray
) -> FloatArray:
    """integral of N_ab u_,a . u_,b, of the membrane force N that displacements u (n, k, 6) leave."""
    n, k, _ = coords.shape
    surface, moved = surface_at(coords, shape, shape.full), u.reshape(n, 1, 6 * k, 1)
    stiff = rigidity(section, surface.axes, own, shape.full.shapes)
    force = stiff.A @ (_sampled(shape, coords, surface) @ moved)
    if stiff.B is not None:
        force = force + stiff.B @ (bending_strains(_directors(shape, coords), shape.full.slopes, surface) @ moved)
    slopes = surface.inverse @ shape.full.slopes
    pairs = weighted_gram(slopes, force[..., [[0, 2], [2, 1]], 0], surface.weights)
    out = np.zeros((n, k, 6, k, 6))
    for axis in range(3):
        out[:, :, axis, :, axis] = pairs
    return out.reshape(n, 6 * k, 6 * k)


def heat_load(
    shape: Shape, coords: FloatArray, section: ShellSection | GeneralShell, own: Own, rise: FloatArray
) -> FloatArray:
    """N on the membrane strains, M on the curvature; the mean dilation u = m x as K u, as of the four-node shell."""
    surface = surface_at(coords, shape, shape.full)
    stiff = rigidity(section, surface.axes, own, shape.full.shapes)
    grown, N, M = dilation(coords, surface, stiff, heat_resultants(section, surface.axes, own, shape.full.shapes, rise))
    dilated = (stiffness(shape, coords, section, own) @ grown)[..., 0]
    bent = bending_strains(_directors(shape, coords), shape.full.slopes, surface)
    load = weighted_sum(_sampled(shape, coords, surface), N, surface.weights)
    return np.asarray(dilated + load + weighted_sum(bent, M, surface.weights), dtype=np.float64)


def surface_at(coords: FloatArray, shape: Shape, rule: Reference) -> Surface:
    """Base vectors, area, and local axes: those of the middle after the smallest rotation to the normal."""
    return surface_of(rule.points, rule.weights, _tangents(coords, rule), _mean_axes(shape, coords))


def membrane(coords: FloatArray, rule: Reference, surface: Surface) -> FloatArray:
    """(n, n_point, 3, 6 k): e11, e22, 2 e12."""
    covariant = _covariant_membrane(coords, rule, surface.x_r, surface.x_s)
    return np.asarray(strain_transform(surface.inverse) @ covariant, dtype=np.float64)


def _covariant_membrane(coords: FloatArray, rule: Reference, x_r: FloatArray, x_s: FloatArray) -> FloatArray:
    """(n, n_point, 3, 6 k): e_rr, e_ss, 2 e_rs."""
    n, k, _ = coords.shape
    h_r, h_s = rule.slopes[:, 0, :, None], rule.slopes[:, 1, :, None]
    operator = np.zeros((n, len(rule.points), 3, k, 6))
    operator[:, :, 0, :, :3], operator[:, :, 1, :, :3] = h_r * x_r[:, :, None], h_s * x_s[:, :, None]
    operator[:, :, 2, :, :3] = h_s * x_r[:, :, None] + h_r * x_s[:, :, None]
    return operator.reshape(n, -1, 3, 6 * k)


def _covariant_shear(coords: FloatArray, normals: FloatArray, rule: Reference) -> FloatArray:
    """(n, n_point, 2, 6 k): x_,a . (theta x V) + V . u_,a."""
    n, k, _ = coords.shape
    director = np.einsum("gi,nic->ngc", rule.shapes, normals)
    operator = np.empty((n, len(rule.points), 2, k, 6))
    for axis, tangent in enumerate(_tangents(coords, rule)):
        operator[:, :, axis, :, :3] = rule.slopes[:, axis, :, None] * director[:, :, None]
        operator[:, :, axis, :, 3:] = rule.shapes[:, :, None] * np.cross(normals[:, None], tangent[:, :, None])
    return operator.reshape(n, -1, 2, 6 * k)


def _inner_curvature(shape: Shape, coords: FloatArray, surface: Surface) -> FloatArray:
    """(n, n_point, 3, 2) of the inner rotations."""
    b_r, b_s = shape.bubble[:, 1, None], shape.bubble[:, 2, None]
    beta = _inner_axes(shape, coords)
    along_r, along_s = (np.einsum("npc,njc->npj", x, beta) for x in (surface.x_r, surface.x_s))
    covariant = np.stack([b_r * along_r, b_s * along_s, b_s * along_r + b_r * along_s], axis=2)
    return np.asarray(strain_transform(surface.inverse) @ covariant, dtype=np.float64)


def _shear(shape: Shape, coords: FloatArray, normals: FloatArray, surface: Surface) -> FloatArray:
    """(n, n_point, 2, 6 k + 2) shear strains in local axes, tied."""
    nodal = _covariant_shear(coords, normals, shape.tied)
    beta = _inner_axes(shape, coords)
    inner = np.stack([np.einsum("npc,njc->npj", x, beta) for x in _tangents(coords, shape.tied)], axis=2)
    sampled = np.concatenate([nodal, shape.tied_bubble[:, None, None] * inner], axis=3)
    return np.asarray(surface.inverse @ np.einsum("gapb,npbd->ngad", shape.tying, sampled, optimize=True))


def _inner_axes(shape: Shape, coords: FloatArray) -> FloatArray:
    """(n, 2, 3) directions of the inner rotations' displacement, in the mean plane."""
    first, normal = _mean_axes(shape, coords)
    return np.stack([first, np.cross(normal, first)], axis=1)


def _sampled(shape: Shape, coords: FloatArray, surface: Surface) -> FloatArray:
    """(n, n_full, 3, 6 k) membrane strains at the points of `surface` from those at few points."""
    if shape.spread.ndim == 4:
        covariant = _covariant_membrane(coords, shape.few, *_tangents(coords, shape.few))
        spread = np.einsum("gapb,npbd->ngad", shape.spread, covariant, optimize=True)
        return np.asarray(strain_transform(surface.inverse) @ spread, dtype=np.float64)
    operator = membrane(coords, shape.few, surface_at(coords, shape, shape.few))
    n, n_few, m, d = operator.shape
    return np.asarray((shape.spread @ operator.reshape(n, n_few, m * d)).reshape(n, -1, m, d), dtype=np.float64)


def _tangents(coords: FloatArray, rule: Reference) -> tuple[FloatArray, FloatArray]:
    """dx/dr, dx/ds, (n, n_point, 3) each."""
    both = np.einsum("gai,nic->angc", rule.slopes, coords)
    return both[0], both[1]


def _directors(shape: Shape, coords: FloatArray) -> FloatArray:
    """Unit normals (n, k, 3) of the element's own surface at its nodes."""
    return unit(np.cross(*_tangents(coords, shape.nodes)))


def _mean_axes(shape: Shape, coords: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(n, 3) axis 1 and normal of the corners' plane: along side 1-2 of a triangle, else between the diagonals."""
    corners = coords[:, : shape.n_corner]
    first, second = corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1]
    normal = unit(np.cross(first, second))
    return unit(corners[:, 1] - corners[:, 0] if shape.n_corner == 3 else unit(first) - unit(second)), normal


def _require_sound(shape: Shape, coords: FloatArray) -> None:
    """Raise `DegenerateElement` where the surface has no area, or is folded at a point or node."""
    corners = coords[:, : shape.n_corner]
    first, second = corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1]
    middle = np.cross(first, second)
    size, extent = np.linalg.norm(middle, axis=1), (first**2).sum(axis=1) + (second**2).sum(axis=1)
    require_sound(~(size > DEGENERATE * extent), "the element has no area")
    for rule in (shape.nodes, shape.full):
        area = np.einsum("nic,nc->ni", np.cross(*_tangents(coords, rule)), middle / size[:, None]).min(axis=1)
        require_sound(~(area > 0.1 * DEGENERATE * extent), "the element is folded: look at its middle nodes")
