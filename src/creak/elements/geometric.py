"""Geometric stiffness: what the stress of a static state adds to the stiffness of elements.

K_g = integral of sigma_ij u_k,i u_k,j, with the stress of linear displacements on the undeformed shape (Zienkiewicz and
Taylor, The Finite Element Method, vol. 2 (2000), chapter 10). Of shells the membrane forces count, of beams the axial
force: moments and transverse shear change frequencies only to second order.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.elements import beam2, beam3, truss2
from creak.elements.shells import quad4, quad8, tri3, tri6
from creak.elements.solids import hex8, hex20
from creak.elements.solids.common import VOIGT, Reference, elasticity, jacobians, strains, with_rotations
from creak.elements.solids.rules import SOLID_RULES
from creak.model.materials import SolidSection
from creak.model.mesh import Own

Stressed = Callable[[FloatArray, Any, Own, FloatArray], FloatArray]
"""(coords, section, own, u) -> (n, d, d), as `stiffness` of an element; u (n, n_node, 6) displacements."""


def _solid(reference: Reference) -> Stressed:
    """Of solids whose stiffness is the integral of B' D B."""

    def made(coords: FloatArray, section: SolidSection, own: Own, u: FloatArray) -> FloatArray:
        inverse, det = jacobians(coords, reference.slopes)
        gradient = inverse @ reference.slopes
        strain = strains(gradient) @ u[:, None, :, :3].reshape(len(u), 1, -1, 1)
        stress = (elasticity(section.material, own) @ strain)[..., 0]
        return _of_stress(gradient, stress, det * reference.weights)

    return made


def _hex8(coords: FloatArray, section: SolidSection, own: Own, u: FloatArray) -> FloatArray:
    inverse, det = jacobians(coords, hex8.GAUSS.slopes)
    stress = hex8.stress(coords, section, own, u[:, :, :3].reshape(len(u), 24))
    return _of_stress(inverse @ hex8.GAUSS.slopes, stress, det)


def _of_stress(gradient: FloatArray, stress: FloatArray, volume: FloatArray) -> FloatArray:
    """From gradients (n, n_point, 3, k), stresses (n, n_point, 6) and volumes of the points."""
    tensor = np.zeros((*stress.shape[:2], 3, 3))
    for k, (i, j) in enumerate(VOIGT):
        tensor[..., i, j] = tensor[..., j, i] = stress[..., k]
    scaled = (tensor * volume[:, :, None, None]) @ gradient
    pairs = np.einsum("ngia,ngib->nab", gradient, scaled)
    return with_rotations(_on_translations(pairs))


def _on_translations(pairs: FloatArray) -> FloatArray:
    """(n, 3 k, 3 k) from (n, k, k): the same for each translation."""
    return np.asarray(np.einsum("nab,ij->naibj", pairs, np.eye(3)).reshape(len(pairs), 3 * pairs.shape[1], -1))


GEOMETRIC: dict[str, Stressed] = {
    "quad4": quad4.geometric_stiffness,
    "tri3": tri3.geometric_stiffness,
    "quad8": quad8.geometric_stiffness,
    "tri6": tri6.geometric_stiffness,
    "beam2": beam2.geometric_stiffness,
    "beam3": beam3.geometric_stiffness,
    "truss2": truss2.geometric_stiffness,
    "hex8": _hex8,
    "hex20s": _solid(hex20.EIGHT),
    **{kind: _solid(rule) for kind, rule in SOLID_RULES.items()},
}
"""Kinds of elements that have it; others must have none (`UNSTRESSED`) or stop."""

UNSTRESSED = ("mass", "rotary", "spring1", "spring2", "bush1", "nodal1")
"""Kinds that no load changes: points, and springs along fixed directions."""
