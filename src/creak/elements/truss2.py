"""Two-node bar that carries axial force only."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.elements.geometry import in_chunks, require_sound
from creak.model.materials import TrussSection
from creak.model.mesh import COMMON, Own

TRANSLATIONS = np.array([0, 1, 2, 6, 7, 8])


def stiffness(coords: FloatArray, section: TrussSection, own: Own = COMMON) -> FloatArray:
    """K = EA/L [t t', -t t'; -t t', t t'] on the translations, zero on the rotations."""
    K = along_line(coords)
    length = np.linalg.norm(coords[:, 1] - coords[:, 0], axis=1)
    K *= (section.material.youngs_modulus * section.area / length)[:, None, None]
    return K


def along_line(coords: FloatArray) -> FloatArray:
    """(n, 12, 12) [t t', -t t'; -t t', t t'] on the translations, t the unit vector from node 1 to node 2."""
    _require_length(coords)

    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        line = piece[:, 1] - piece[:, 0]
        both = np.concatenate([-line, line], axis=1) / np.linalg.norm(line, axis=1)[:, None]
        out = np.zeros((piece.shape[0], 12, 12))
        out[:, TRANSLATIONS[:, None], TRANSLATIONS] = both[:, :, None] * both[:, None, :]
        return out

    return in_chunks(kernel, coords, 12)


def mass(coords: FloatArray, section: TrussSection, own: Own = COMMON) -> FloatArray:
    """Consistent mass rho A L/6 [2, 1; 1, 2] on each of the three translations."""
    _require_length(coords)
    pattern = np.kron(np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0, np.eye(3))

    def kernel(piece: FloatArray, mine: Own) -> FloatArray:
        length = np.linalg.norm(piece[:, 1] - piece[:, 0], axis=1)
        local = np.zeros((piece.shape[0], 12, 12))
        weight = section.material.density * section.area * length[:, None, None]
        local[:, TRANSLATIONS[:, None], TRANSLATIONS] = weight * pattern
        return local

    return in_chunks(kernel, coords, 12)


def _require_length(coords: FloatArray) -> None:
    """Raise `DegenerateElement` for bars whose nodes coincide."""
    require_sound(~(np.linalg.norm(coords[:, 1] - coords[:, 0], axis=1) > 0.0), "the two nodes coincide")


def geometric_stiffness(coords: FloatArray, section: TrussSection, own: Own, u: FloatArray) -> FloatArray:
    """N/L [G, -G; -G, G] with G = I - t t' on the translations, N = EA/L t . (u_2 - u_1)."""
    line = coords[:, 1] - coords[:, 0]
    length = np.linalg.norm(line, axis=1)
    t = line / length[:, None]
    young = section.material.youngs_modulus * section.area
    force = young / length * np.einsum("ni,ni->n", t, u[:, 1, :3] - u[:, 0, :3])
    G = (force / length)[:, None, None] * (np.eye(3) - t[:, :, None] * t[:, None, :])
    out = np.zeros((len(coords), 12, 12))
    out[:, TRANSLATIONS[:, None], TRANSLATIONS] = np.block([[G, -G], [-G, G]])
    return out


def heat_load(coords: FloatArray, section: TrussSection, own: Own, rise: FloatArray) -> FloatArray:
    """EA alpha dT [-t; t] on the translations, dT the mean."""
    line = coords[:, 1] - coords[:, 0]
    t = line / np.linalg.norm(line, axis=1)[:, None]
    expansion = section.material.expansion
    alpha = 0.0 if expansion is None else expansion.strain[0]
    force = section.material.youngs_modulus * section.area * alpha * rise.mean(axis=1)
    out = np.zeros((len(coords), 12))
    out[:, TRANSLATIONS] = force[:, None] * np.concatenate([-t, t], axis=1)
    return out
