"""The unreduced model in the motion of the reduced one, and damped as that is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.linalg as sla

from creak.arrays import FloatArray, IntArray
from creak.assembly.system import System
from creak.errors import InputError
from creak.linalg.diagonal import Diagonal
from creak.reduction.modal import ModalDamping, with_modal_damping, without_modal_damping
from creak.studies.models.reduced import ReducedModel, reduced_modes
from creak.studies.models.reference import ReferenceModel

LARGEST = 8e6
"""Dofs times modes: each step goes through all shapes some five times, 30 ms or so."""


def recovered_on(
    unreduced: System, reduced: System, q: FloatArray, s: FloatArray, kept: IntArray | None = None
) -> FloatArray:
    """(n, k) coordinates of the unreduced System in the motion (q, s) of the reduced one; velocities alike.

    Parameters
    ----------
    kept : of the coordinates, those that are asked for; default: all.

    Raises
    ------
    InputError : the unreduced System has coordinates that are no dofs of nodes.
    """
    at = np.searchsorted(reduced.labels, unreduced.coordinates)
    if np.any(reduced.labels[np.minimum(at, reduced.labels.size - 1)] != unreduced.coordinates):
        raise InputError("the unreduced model has coordinates that are no motion of nodes", expected="full matrices")
    return reduced.recover(q, s, at if kept is None else at[kept])


def damped_alike(zeta: ModalDamping | None, raised: bool, reference: ReferenceModel, reduced: ReducedModel) -> System:
    """The unreduced System for a short march, with the modal damping of a reduced one that has more modes than it.

    C = M Phi diag(2 zeta omega - beta omega^2) Phi' M + beta K with the modes of the reduced model, recovered, in place
    of those of the whole up to the first f_max. A share of critical is that of every mode. Beyond known modes damping
    grows with the frequency (`with_modal_damping`), so a blow that excites modes up to many times the first f_max loses
    up to a tenth of its impulse to that.

    It stays as it is where the damping is another, where f_max was not raised and modes are left, beyond `LARGEST`, and
    where the shapes are not independent.
    All shapes take part in each step, which a march of the whole time cannot afford.

    Shapes of a reduced model are mass-normalised by its own mass, which is off where its last modes are known to few
    digits. They are made orthonormal by that of the whole, the lowest first: a product of two that are not would damp
    low modes as the highest are.
    """
    whole, small = reference.system, reduced.system
    n, k = whole.n, small.n
    if zeta is None or not (raised or reduced.complete) or not isinstance(small.K, Diagonal) or n * k > LARGEST:
        return whole
    own, R = reduced_modes(small, np.inf), reference.support_shapes
    at_rest = np.zeros((small.supports.count, own.omega2.size))
    shapes = recovered_on(whole, small, own.shapes, at_rest)
    try:
        upper = sla.cholesky(shapes.T @ np.asarray(whole.M @ shapes))
    except np.linalg.LinAlgError:
        return whole
    known = replace(own, shapes=np.ascontiguousarray(sla.solve_triangular(upper, shapes.T, trans="T").T))
    return with_modal_damping(without_modal_damping(whole, R), known, R, zeta, beyond=not reduced.complete)
