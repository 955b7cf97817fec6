"""Interface dofs that take part in the modes of the assembly."""

from __future__ import annotations

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.errors import InputError
from creak.model.dofs import PER_NODE, dofs_of

PERCENTILE = 95.0


def participating(shapes: FloatArray, eta: float, *, dofs: IntArray | None = None) -> BoolArray:
    """Interface dofs that move in the modes; the others may be dropped (left uncoupled).

    With mean_i and max_i the mean and the largest |phi_ij| over the modes j, dof i is dropped where

        mean_i <= eta mean_95   and   max_i <= eta max_95,

    mean_95 and max_95 being 95th percentiles over the interface dofs of the same kind. Translations and rotations
    have different units, so that one percentile for both would drop either all rotations or all translations
    depending on the deck's unit of length; each kind is measured against its own percentile. (The source does not
    say; only this agrees with its counts: with lengths in mm one percentile would drop half of the dofs, it drops 6 %.)

    Parameters
    ----------
    shapes : (n_dof, n_mode) eigenvectors of the whole assembly in the frequency range of interest, at the interface
        dofs. Normalised over the whole model (Phi' M Phi = I, or largest entry 1), not over the interface: a mode
        that leaves the interface at rest must not count.
    eta : share of the percentile, 0..1. 0 drops only dofs at rest.
    dofs : (n_dof,) 1..6 of each row; default: node by node 1..6.

    Returns
    -------
    (n_dof,) True for the dofs to keep.

    Raises
    ------
    InputError : eta outside 0..1; no modes; `dofs` missing though the rows are no whole nodes.

    Source: equations 3.1-3.3 of Valiyakath Basheer and Godborg, Chalmers 2019. It depends on the model, its modes and
    their range; there the answer was good to eta = 0.35 and broke down at 0.37. Dropped dofs are free cuts.
    """
    if not 0.0 <= eta <= 1.0:
        raise InputError(f"participation factor eta = {eta:g}", expected="0..1")
    n_dof, n_mode = shapes.shape
    if n_mode == 0:
        raise InputError("there are no modes to measure participation with", fix="Raise the frequency limit.")
    rotation = _dofs(n_dof, dofs) > 3
    size = np.abs(shapes)
    mean, largest = size.mean(axis=1), size.max(axis=1)
    keep = np.ones(n_dof, dtype=bool)
    for kind in (np.flatnonzero(~rotation), np.flatnonzero(rotation)):
        keep[kind] = _above(mean[kind], eta) | _above(largest[kind], eta)
    return keep


def _above(values: FloatArray, eta: float) -> BoolArray:
    if values.size == 0:
        return np.zeros(0, dtype=bool)
    return np.asarray(values > eta * np.percentile(values, PERCENTILE))


def _dofs(n_dof: int, dofs: IntArray | None) -> IntArray:
    if dofs is not None:
        return dofs
    if n_dof % PER_NODE:
        raise InputError(f"{n_dof} interface dofs are no whole nodes", fix="Give the dof 1..6 of every row.")
    return dofs_of(np.arange(n_dof))
