"""Complex modes of a test as the real ones that they stand for, and how real they are."""

from __future__ import annotations

import numpy as np

from creak.arrays import ComplexArray, FloatArray


def phase_collinearity(shapes: ComplexArray) -> FloatArray:
    """Modal phase collinearity |phi' phi|^2 / (phi^H phi)^2 of each mode: 1 where all points move in phase.

    With S_xx, S_yy, S_xy of real and imaginary parts this is ((S_xx - S_yy)^2 + 4 S_xy^2) / (S_xx + S_yy)^2 (Pappa,
    Elliott and Schenk, J. Guid. Control Dyn. 16, 1993). It is also the MAC of a mode and its conjugate. A wave that
    travels round a disk has 0.

    Parameters
    ----------
    shapes : (n_channel, n_mode), any scale and phase.

    Returns
    -------
    (n_mode,) from 0 to 1; 0 for a mode that does not move.
    """
    z = _of_size_one(shapes)
    size = (np.abs(z) ** 2).sum(axis=0) ** 2
    same = np.abs((z**2).sum(axis=0)) ** 2
    return np.divide(same, size, out=np.zeros(shapes.shape[1]), where=size > 0.0)


def real_shapes(shapes: ComplexArray) -> FloatArray:
    """Re(exp(-i theta) phi) with the phase theta of each mode that makes it largest: theta = arg(phi' phi) / 2.

    Parameters
    ----------
    shapes : (n_channel, n_mode), any scale and phase.

    Returns
    -------
    (n_channel, n_mode), the largest value of each complex shape having size 1.
    """
    z = _of_size_one(shapes)
    theta = 0.5 * np.angle((z**2).sum(axis=0))
    return np.ascontiguousarray((z * np.exp(-1j * theta)).real)


def _of_size_one(shapes: ComplexArray) -> ComplexArray:
    """Shapes whose squares are numbers; those that do not move stay."""
    largest = np.maximum(np.abs(shapes.real), np.abs(shapes.imag)).max(axis=0, initial=0.0)
    z = shapes / np.where(largest > 0.0, largest, 1.0)
    return np.asarray(z / np.where(largest > 0.0, np.abs(z).max(axis=0, initial=0.0), 1.0))
