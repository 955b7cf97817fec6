"""Membrane of the four-node shell: MITC4+ assumed strains with five enhanced strain modes."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.shells.common import weighted_gram
from creak.elements.shells.quad4_geometry import (
    CORNERS,
    Surface,
    shape_derivatives,
    strain_transform,
    tangents,
    zero_mean,
)
from creak.elements.shells.rigidity import Rigidity

TYING = np.array([[0.0, 1.0], [0.0, -1.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 0.0]])
"""e_rr is sampled at the first two points, e_ss at the next two, 2 e_rs at the centre."""


def membrane_stiffness(coords: FloatArray, surface: Surface, rigidity: Rigidity) -> FloatArray:
    """K = K_uu - K_ua K_aa^-1 K_au with strains B u + M alpha.

    B: the assumed strains of `tied_strains` (equal to the displacement-based ones on flat elements).
    M = (j0/j) T0 E(r, s): five enhanced modes with zero mean, so that constant strains stay exact on any
    shape (Simo and Rifai, Int. J. Numer. Meth. Eng. 29 (1990) 1595).

    Parameters
    ----------
    coords : (n, 4, 3) global coordinates.
    surface : the mid-surface at the 2 x 2 points.
    rigidity : of the section at these points.

    Returns
    -------
    (n, 24, 24) in global axes.
    """
    return condensed(weighted_gram(membrane_strains(coords, surface), rigidity.A, surface.weights), 24)


def membrane_strains(coords: FloatArray, surface: Surface) -> FloatArray:
    """(n, n_point, 3, 29): B for the 24 dofs, then M for the five enhanced modes."""
    compatible = strain_transform(surface.inverse) @ tied_strains(coords, surface.points)
    return np.concatenate([compatible, _enhanced_modes(coords, surface)], axis=3)


def condensed(full: FloatArray, n_kept: int) -> FloatArray:
    """(n, n_kept, n_kept): matrices (n, d, d) with the dofs from `n_kept` on free of force."""
    kept, coupling, inner = full[:, :n_kept, :n_kept], full[:, n_kept:, :n_kept], full[:, n_kept:, n_kept:]
    return np.asarray(kept - coupling.transpose(0, 2, 1) @ np.linalg.solve(inner, coupling), dtype=np.float64)


def condensed_load(full: FloatArray, load: FloatArray, n_kept: int) -> FloatArray:
    """(n, n_kept): loads (n, d) that act on what `condensed` keeps."""
    kept, coupling, inner = load[:, :n_kept], full[:, n_kept:, :n_kept], full[:, n_kept:, n_kept:]
    held = np.linalg.solve(inner, load[:, n_kept:, None])
    return np.asarray(kept - (coupling.transpose(0, 2, 1) @ held)[..., 0], dtype=np.float64)


def tied_strains(coords: FloatArray, points: FloatArray) -> FloatArray:
    """Covariant membrane strains that do not lock on warped elements.

    With e_rr = a + s b + s^2 p, e_ss = c + r d + r^2 p, 2 e_rs = g + r b + s d + 2 r s p the strain
    p = x_d . u_d of the hourglass mode is what locks. Flat elements have x_d = c_r x_r + c_s x_s, and p
    is then a combination of the strains A, B (e_rr at s = 1, -1), C, D (e_ss at r = 1, -1) and g (centre):

    p = [c_r(c_r-1)/2 A + c_r(c_r+1)/2 B + c_s(c_s-1)/2 C + c_s(c_s+1)/2 D + c_r c_s g] / (c_r^2 + c_s^2 - 1)

    That combination is used on warped elements too (Ko, Lee and Bathe, Comput. Struct. 182 (2017) 404,
    the MITC4+ membrane).

    Parameters
    ----------
    coords : (n, 4, 3) global coordinates.
    points : (n_point, 2) natural coordinates.

    Returns
    -------
    (n, n_point, 3, 24): rows e_rr, e_ss, 2 e_rs.
    """
    slopes = shape_derivatives(TYING)
    x_r, x_s = (x[:, :, None] for x in tangents(coords, TYING))
    h_r, h_s = slopes[:, 0, :, None], slopes[:, 1, :, None]
    a, b = (h_r[k] * x_r[:, k] for k in (0, 1))
    c, d = (h_s[k] * x_s[:, k] for k in (2, 3))
    g = h_s[4] * x_r[:, 4] + h_r[4] * x_s[:, 4]
    c_r, c_s = _distortion(coords)
    p = 0.5 * (c_r * ((c_r - 1) * a + (c_r + 1) * b) + c_s * ((c_s - 1) * c + (c_s + 1) * d)) + c_r * c_s * g
    p /= c_r * c_r + c_s * c_s - 1.0
    out = np.zeros((coords.shape[0], len(points), 3, 4, 6))
    for k, (r, s) in enumerate(points):
        out[:, k, 0, :, :3] = 0.5 * ((1 + s) * a + (1 - s) * b) + (s * s - 1) * p
        out[:, k, 1, :, :3] = 0.5 * ((1 + r) * c + (1 - r) * d) + (r * r - 1) * p
        out[:, k, 2, :, :3] = g + 0.5 * r * (a - b) + 0.5 * s * (c - d) + 2 * r * s * p
    return out.reshape(coords.shape[0], len(points), 3, 24)


def _distortion(coords: FloatArray) -> tuple[FloatArray, FloatArray]:
    """c_r, c_s (n, 1, 1): in-plane components of x_d = sum r_i s_i x_i / 4 along x_r and x_s."""
    r, s = CORNERS.T
    x_r, x_s, x_d = (np.einsum("i,nic->nc", sign, coords) for sign in (r, s, r * s))
    normal = np.cross(x_r, x_s)
    size = np.einsum("nc,nc->n", normal, normal)
    c_r = np.einsum("nc,nc->n", np.cross(x_d, x_s), normal) / size
    c_s = np.einsum("nc,nc->n", np.cross(x_r, x_d), normal) / size
    return c_r[:, None, None], c_s[:, None, None]


def _enhanced_modes(coords: FloatArray, surface: Surface) -> FloatArray:
    """(n, n_point, 3, 5): r in e_rr, s in e_ss, r and s in 2 e_rs, and r s in e_rr - e_ss."""
    r, s = surface.points[:, 0], surface.points[:, 1]
    modes = np.zeros((len(r), 3, 5))
    modes[:, 0, 0], modes[:, 1, 1] = r, s
    modes[:, 2, 2], modes[:, 2, 3] = r, s
    modes[:, 0, 4], modes[:, 1, 4] = r * s, -r * s
    return zero_mean(coords, surface, modes)
