"""Four-node shell: MITC4 shear with residual bending, enhanced MITC4+ membrane, stabilised drilling rotation."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import gauss_square, in_chunks
from creak.elements.shells.common import mean_normal, shell_mass, stressed_stiffness, weighted_gram, weighted_sum
from creak.elements.shells.quad4_bending import curvature, layered_shear, sides_of, tied_shear, varying_curvature
from creak.elements.shells.quad4_geometry import (
    Surface,
    evaluate,
    require_convex,
    shape,
    shape_derivatives,
    tangents,
)
from creak.elements.shells.quad4_membrane import condensed, condensed_load, membrane_stiffness, membrane_strains
from creak.elements.shells.rigidity import Rigidity, heat_resultants, rigidity
from creak.model.materials import GeneralShell, ShellSection
from creak.model.mesh import COMMON, Own

DRILLING = 1e-3
"""Drilling stiffness as a share of G t. Up to 1e-3 the pinched hemisphere and a twisted beam of t/L = 1/3750
stay free of locking; at 1e-1 both lock. The drilling rotations have natural frequencies of about
sqrt(12 DRILLING G/(SPIN rho))/(2 pi t): 540 kHz in 1 mm of steel, 50 kHz in 3 mm of a stiff plastic."""
TURN = 0.03
"""The same against its mean over the element, as a share of G t (t/h)^2, at most of G t.

Neighbours on a radius R meet at an angle h/R, and their twisting moments M differ by M h/R about the normal, which
drilling rotations carry: with a share s they give way by (t/R)^2/(6 s) of the twist, and stiffen a curved element by 12
s h^4/(R t)^2 of it. Both now fall with h^2, however thin the shell. With `DRILLING` alone Raasch's hook (t/R = 1/7) is
24 % too soft at last, and softer with every finer mesh. The mean turns with the membrane in plane bending, which the
rotations at the corners do not. 0.01 to 1 do nearly as well. MSC Nastran 70.7 had none: on a thick cylinder it is
within 0.1 % of creak without, and 0.4 % below creak with it."""

DILATION = np.array([1.0, 1.0, 0.0])
"""e11, e22, 2 e12 of a growth by the same share in all directions."""


def stiffness(
    coords: FloatArray, section: ShellSection | GeneralShell, own: Own = COMMON, *, softened: bool = False
) -> FloatArray:
    """Stiffness of four-node shells, flat or warped.

    x = sum h_i x_i + z sum h_i V_i,   u = sum h_i u_i + z sum h_i theta_i x V_i,   |z| <= t/2

    V_i is the element's own normal at node i, so folds need no averaging. The covariant strains are
    e_ab = (x_,a . u_,b + x_,b . u_,a)/2 + z (x_,a . (theta x V)_,b + V_,a . u_,b + ...)/2, all of which
    vanish exactly in rigid-body motion of a warped element. Integrated with 2 x 2 points.

    * membrane: tied against membrane locking of warped elements and enhanced against locking in in-plane
      bending, see `membrane_stiffness`;
    * transverse shear: tied at the middles of the edges, shear correction 5/6 (Dvorkin and Bathe, Eng.
      Comput. 1 (1984) 77); bending within the element takes its share of the mean, see `varying_curvature`, and what
      varies over the element has the energy of the layers at free edges, see `layered_shear`;
    * bending: what varies over the element has the energy of a wave in a plate, see `varying_curvature`;
    * drilling: penalty `DRILLING` G t (theta . n - rotation of the mid-surface about n)^2 (Hughes and Brezzi,
      Comput. Methods Appl. Mech. Eng. 72 (1989) 105), and `TURN` G t (t/h)^2 on its mean, see `drilling`.

    Exact in constant membrane and bending states whatever the shape of flat elements, and in constant shear when
    thick: thin elements give way through the rotation within them, by (element size / t)^2. The angles
    between the directors must stay small (terms of order t/R and z^2 are dropped): use solids where the
    radius is below some five thicknesses. Trapezoidal elements are stiff in in-plane bending, as every
    four-node membrane that passes the patch test without drilling shape functions is (MacNeal, Int. J.
    Numer. Meth. Eng. 24 (1987) 1793).

    Softened: bilinear rotations and shear with S^-1 + h^2/(12 D) along each direction instead of S^-1. A linear element
    of length h lacks the flexibility h^2/(12 D) of the bending that shear forces cause within it, an error of the order
    (k h)^2/12 in the stiffness of a wave of number k. That bending also takes Poisson's ratio times the bending across,
    see `varying_curvature`. Constant states are as exact. It goes with lumped and linear mass, as in decks made for it.
    What varies of the shear over the element is not softened: strips few elements wide would have a sixth of their
    stiffness in torsion.
    Source: MacNeal, Computers and Structures 8 (1978) 175.

    Nodes: counter-clockwise about the positive normal.
    """
    require_convex(coords)
    points, weights = gauss_square(2)

    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        surface = evaluate(piece, points, weights)
        stiff = rigidity(section, surface.axes, mine, shape(points))
        bending, bent = stiff.neutral, curvature(piece, surface)
        if stiff.B is None:
            total = membrane_stiffness(piece, surface, stiff)
        else:
            total = _coupled(piece, surface, replace(stiff, D=stiff.D - bending), bent)
        sides = sides_of(piece, surface, bending, stiff)
        bent, shear = varying_curvature(bent, surface, tied_shear(piece), sides, mine.free_sides, softened=softened)
        sheared = layered_shear(shear.strains(surface), surface, sides)
        total += weighted_gram(bent, bending, surface.weights)
        total += weighted_gram(sheared, stiff.S, surface.weights)
        total += drilling(surface, stiff, shape(surface.points), shape_derivatives(surface.points))
        return total

    return in_chunks(kernel, coords, 24, own)


softened_stiffness = partial(stiffness, softened=True)


def mass(coords: FloatArray, section: ShellSection | GeneralShell, own: Own = COMMON) -> FloatArray:
    """Consistent mass of four-node shells with rotary inertia, see `shell_mass`."""
    require_convex(coords)
    points, weights = gauss_square(3)
    shapes = shape(points)
    r, s = points[:, 0], points[:, 1]
    along_r, along_s = 0.5 * (1 - r * r), 0.5 * (1 - s * s)
    edges = np.column_stack([along_r * (1 - s), along_s * (1 + r), along_r * (1 + s), along_s * (1 - r)])

    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        x_r, x_s = tangents(piece, points)
        area = np.linalg.norm(np.cross(x_r, x_s), axis=2) * weights
        return shell_mass(piece, mean_normal(piece), area, shapes, edges, section, mine)

    return in_chunks(kernel, coords, 24, own)


def geometric_stiffness(
    coords: FloatArray, section: ShellSection | GeneralShell, own: Own, u: FloatArray
) -> FloatArray:
    """Of the membrane force that displacements u (n, 4, 6) leave, see `stressed_stiffness`.

    It is that of the mean strain and curvature of each element, which its enhanced modes do not change.
    """
    points, weights = gauss_square(3)
    surface = evaluate(coords, points, weights)
    stiff = rigidity(section, surface.axes, own, shape(points))
    moved = u.reshape(len(u), 1, 24, 1)
    share = (surface.weights / surface.weights.sum(axis=1, keepdims=True))[:, :, None, None]
    strain = (share * (membrane_strains(coords, surface)[..., :24] @ moved)).sum(axis=1, keepdims=True)
    force = stiff.A @ strain
    if stiff.B is not None:
        force = force + stiff.B @ (share * (curvature(coords, surface) @ moved)).sum(axis=1, keepdims=True)
    mean = (share * np.broadcast_to(force, (len(u), len(points), 3, 1))).sum(axis=1)
    r, s = points.T
    by_r = np.stack([-r * (1 - s), 0.5 * (1 - s * s), -r * (1 + s), -0.5 * (1 - s * s)], axis=1)
    by_s = np.stack([-0.5 * (1 - r * r), -s * (1 + r), 0.5 * (1 - r * r), -s * (1 - r)], axis=1)
    edges = surface.inverse @ np.stack([by_r, by_s], axis=1)
    slopes = surface.inverse @ shape_derivatives(points)
    return stressed_stiffness(
        coords, mean_normal(coords), slopes, edges, mean[:, [[0, 2], [2, 1]], 0], surface.weights, section
    )


def heat_load(
    coords: FloatArray, section: ShellSection | GeneralShell, own: Own, rise: FloatArray, *, softened: bool = False
) -> FloatArray:
    """N on the membrane strains, M on the curvature; the enhanced modes, which see both where B is, condensed out.

    Splitting the energy as the stiffness does, A (e + A^-1 B k)^2 + (D - B A^-1 B) k^2, the first takes N along with
    B A^-1 N, the second M - B A^-1 N. What varies of the curvature within an element has no mean: M, which is all but
    constant there, does no work on it.

    The mean of the strains without stress is a dilation u = m x, which a warped element takes up without stress though
    its assumed strains are not m everywhere: it comes as K u, and what N and M have besides as above.
    """
    points, weights = gauss_square(2)
    surface = evaluate(coords, points, weights)
    stiff = rigidity(section, surface.axes, own, shape(points))
    grown, N, M = dilation(coords, surface, stiff, heat_resultants(section, surface.axes, own, shape(points), rise))
    operator, bent = membrane_strains(coords, surface), curvature(coords, surface)
    if stiff.B is None:
        full, load = weighted_gram(operator, stiff.A, surface.weights), weighted_sum(operator, N, surface.weights)
    else:
        both = np.concatenate([operator, np.pad(bent, ((0, 0), (0, 0), (0, 0), (0, 5)))], axis=2)
        taken = (stiff.B @ np.linalg.solve(stiff.A, N[..., None]))[..., 0]
        full = weighted_gram(both, replace(stiff, D=stiff.D - stiff.neutral).coupled, surface.weights)
        load, M = weighted_sum(both, np.concatenate([N, taken], axis=2), surface.weights), M - taken
    dilated = (stiffness(coords, section, own, softened=softened) @ grown)[..., 0]
    return dilated + condensed_load(full, load, 24) + weighted_sum(bent, M, surface.weights)


softened_heat_load = partial(heat_load, softened=True)


def dilation(
    coords: FloatArray, surface: Surface, stiff: Rigidity, heat: tuple[FloatArray, FloatArray]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(n, 6 k, 1) the mean dilation u = m x of resultants N, M (`heat`), and what is left of these."""
    N, M = heat
    free = np.linalg.solve(np.broadcast_to(stiff.A, (*N.shape, 3)), N[..., None])[..., 0]
    m = (0.5 * surface.weights * (free[..., 0] + free[..., 1])).sum(axis=1) / surface.weights.sum(axis=1)
    grown = np.zeros((*coords.shape[:2], 6))
    grown[:, :, :3] = m[:, None, None] * (coords - coords.mean(axis=1, keepdims=True))
    M = M if stiff.B is None else M - m[:, None, None] * (stiff.B @ DILATION)
    return grown.reshape(len(coords), -1, 1), N - m[:, None, None] * (stiff.A @ DILATION), M


def _coupled(coords: FloatArray, surface: Surface, stiff: Rigidity, bent: FloatArray) -> FloatArray:
    """(n, 24, 24) of membrane and bending together, `bent` the curvature; enhanced modes are condensed out of both."""
    bent = np.pad(bent, ((0, 0), (0, 0), (0, 0), (0, 5)))
    operator = np.concatenate([membrane_strains(coords, surface), bent], axis=2)
    return condensed(weighted_gram(operator, stiff.coupled, surface.weights), 24)


def drilling(surface: Surface, stiff: Rigidity, shapes: FloatArray, slopes: FloatArray) -> FloatArray:
    """(n, 6 k, 6 k): penalty on theta . n - (e2 . u_,1 - e1 . u_,2)/2 in the tangent plane, and on its mean.

    t^2 = 12 tr D / tr A, h^2 the area.

    shapes, slopes : (n_point, k) and (n_point, 2, k) at the points of the surface.
    """
    n, n_point, k = *surface.weights.shape, shapes.shape[1]
    slope = surface.inverse @ slopes
    e1, e2, normal = (surface.axes[:, :, i, None, :] for i in range(3))
    operator = np.empty((n, n_point, 1, k, 6))
    operator[:, :, 0, :, :3] = 0.5 * (slope[:, :, 1, :, None] * e1 - slope[:, :, 0, :, None] * e2)
    operator[:, :, 0, :, 3:] = shapes[:, :, None] * normal
    flat = operator.reshape(n, n_point, 1, 6 * k)
    area = surface.weights.sum(axis=1, keepdims=True)
    mean = weighted_sum(flat, np.ones((1, 1, 1)), surface.weights / area)[:, None, None]
    thickness = 12.0 * np.trace(stiff.neutral, axis1=-2, axis2=-1) / np.trace(stiff.A, axis1=-2, axis2=-1)
    turn = TURN * np.minimum(thickness / area, 1.0)[..., None, None] * stiff.drilling
    each = weighted_gram(flat, DRILLING * stiff.drilling * np.eye(1), surface.weights)
    return each + weighted_gram(mean, turn.mean(axis=1, keepdims=True), area)
