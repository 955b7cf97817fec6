"""Normalised root mean square error of stacked spectra."""

from __future__ import annotations

import numpy as np

from creak.arrays import ComplexArray, FloatArray
from creak.errors import InputError
from creak.given import spectra_of

AXES = ("x", "y", "z")
AT_REST = 1e-6
"""Share of the largest axis below which an axis counts as not moving."""


def nrmse_fit(reference: ComplexArray | FloatArray, x: ComplexArray | FloatArray) -> float:
    """1 - |ref - x| / |ref - mean(ref)| over all entries: 1 is perfect, 0 no better than a constant.

    This is the fit of the thesis, equation 2.22; MATLAB's goodnessOfFit now returns its complement. Complex
    spectra are compared with their phase. A reference that does not vary gives 1 if x equals it, else -inf.

    Raises
    ------
    InputError : no finite numbers, none, or other ones than as many of both.
    """
    reference = spectra_of(reference, "reference")
    r, y = reference.ravel(), spectra_of(x, "x", reference.shape).ravel()
    if not r.size:
        raise InputError("reference is empty", expected="one number or more")
    spread = float(np.linalg.norm(r - r.mean()))
    error = float(np.linalg.norm(r - y))
    if spread == 0.0:
        return 1.0 if error == 0.0 else -np.inf
    return 1.0 - error / spread


def nrmse_by_axis(reference: ComplexArray, x: ComplexArray) -> dict[str, float | None]:
    """Fit per axis and over all; None along axes without motion. Spectra are (n_freq, n_pair, 3).

    Raises
    ------
    InputError : as `nrmse_fit`; another shape.
    """
    reference = spectra_of(reference, "reference")
    if reference.shape[2:] != (len(AXES),):
        raise InputError(f"reference is of shape {reference.shape}", expected="(n_freq, n_pair, 3)")
    x = spectra_of(x, "x", reference.shape)
    moving = moving_axes(reference)
    fits = {a: nrmse_fit(reference[:, :, i], x[:, :, i]) if a in moving else None for i, a in enumerate(AXES)}
    return {**fits, "all": nrmse_fit(reference, x) if moving else None}


def moving_axes(spectra: ComplexArray) -> list[str]:
    """Axes along which (n_freq, n_pair, 3) spectra hold more than round-off of the others, whose fit means nothing."""
    if spectra.size == 0:
        return []
    size = np.linalg.norm(spectra, axis=(0, 1))
    return [a for a, s in zip(AXES, size.tolist(), strict=True) if s > AT_REST * size.max()]
