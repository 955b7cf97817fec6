"""Modes of two models, or of a model and a test, compared: assurance criteria, partners, complex modes as real ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from creak.errors import InputError
from creak.given import table_of

ROUND_OFF = 1e-9
"""Of the highest frequency: what rigid modes may be apart."""
CLOSE = 2e-3
"""Modes nearer than this relative distance form one subspace: their shapes may rotate in it."""
BAND = 0.15
"""A reduced mode can pair with a reference mode within this relative distance."""
ALIKE = 0.6
"""MAC from which a measured mode and one of a model can be a pair: from random shapes at 20 sensors none comes near."""
APART = 0.5
"""Square of the cosine of two shapes within a subspace from which they are one measured twice."""
OCTAVES, PER_OCTAVE = 1.0, 0.1
"""How far their frequencies may be apart, and what an octave between them costs in MAC: at few sensors a mode far above
looks like one below."""


@dataclass(frozen=True)
class ModePairs:
    """Reference modes with their partners."""

    mac: FloatArray
    """(n_ref,) diagonal value of each pair; within close modes, the share in the partners' subspace."""
    matrix: FloatArray
    """(n_ref, n_red) plain MAC."""
    partner: IntArray
    """(n_ref,) column of the partner, -1 for none (MAC 0)."""


def mac_matrix(reference: FloatArray, reduced: FloatArray) -> FloatArray:
    """(phi_i' psi_j)^2 / (|phi_i|^2 |psi_j|^2) for shapes (n_dof, n_ref) and (n_dof, n_red).

    Allemang and Brown, Proc. IMAC 1, 1982.

    Raises
    ------
    InputError : shapes that are no real matrices of as many rows.
    """
    reference, reduced = table_of(reference, "reference"), table_of(reduced, "reduced")
    if reference.ndim != 2 or reduced.ndim != 2 or reference.shape[0] != reduced.shape[0]:
        raise InputError(f"shapes {reference.shape} and {reduced.shape}", expected="a column for each mode, rows alike")
    cross = (reference.T @ reduced) ** 2
    size = np.outer((reference**2).sum(axis=0), (reduced**2).sum(axis=0))
    return np.divide(cross, size, out=np.zeros_like(cross), where=size > 0.0)


def frac(test: ComplexArray, model: ComplexArray) -> float:
    """Frequency response assurance criterion |H_t^H H_m|^2 / (|H_t|^2 |H_m|^2) of two functions (n_freq,), 0 to 1; nan
    where one of them is zero.

    Level and sign do not change it. Heylen and Lammens, Int. Conf. on Identification in Engineering Systems, 1996.
    """
    size = float(np.vdot(test, test).real) * float(np.vdot(model, model).real)
    return float(abs(np.vdot(test, model)) ** 2) / size if size > 0.0 else float("nan")


def pair_modes(freq_ref: FloatArray, shapes_ref: FloatArray, freq_red: FloatArray, shapes_red: FloatArray) -> ModePairs:
    """Pair the modes by MAC among those of similar frequency, each reduced mode once."""
    matrix = mac_matrix(shapes_ref, shapes_red)
    n_ref = freq_ref.size
    if n_ref == 0 or freq_red.size == 0:
        return ModePairs(np.zeros(n_ref), matrix, np.full(n_ref, -1, dtype=np.int64))
    allowed = np.abs(freq_red - freq_ref[:, None]) <= BAND * freq_ref[:, None] + ROUND_OFF * max(
        freq_ref.max(), freq_red.max()
    )
    partner = _partners(matrix, allowed)
    mac = np.where(partner >= 0, matrix[np.arange(n_ref), partner], 0.0)
    for i in np.flatnonzero(partner >= 0).tolist():
        near = np.flatnonzero(np.abs(freq_ref - freq_ref[i]) <= CLOSE * freq_ref[i])
        mates = partner[near][partner[near] >= 0]
        if mates.size > 1:
            mac[i] = _share(shapes_ref[:, i], shapes_red[:, mates])
    return ModePairs(np.minimum(mac, 1.0), matrix, partner)


def pair_measured(matrix: FloatArray, freq_test: FloatArray, freq_model: FloatArray) -> IntArray:
    """Partner of each measured mode among those of a model, -1 for none; each mode of the model once.

    The sum of MAC, less `PER_OCTAVE` for each octave between the frequencies, is as large as it can be (assignment
    problem). Partners have a MAC of `ALIKE` at least and lie within `OCTAVES`.

    Parameters
    ----------
    matrix : (n_test, n_model) MAC. freq_test : (n_test,) Hz. freq_model : (n_model,) Hz; no mode at 0 Hz has a partner.
    """
    known = (freq_test[:, None] > 0.0) & (freq_model > 0.0)
    ratio = np.divide(freq_model, freq_test[:, None], out=np.ones(matrix.shape), where=known)
    octaves = np.abs(np.log2(np.where(known, ratio, 1.0)))
    return _partners(matrix - PER_OCTAVE * octaves, known & (matrix >= ALIKE) & (octaves <= OCTAVES))


def turned_twins(test: FloatArray, model: FloatArray, freq_test: FloatArray, freq_model: FloatArray) -> FloatArray:
    """(n_model, n_model) orthogonal: how modes of one frequency are to be combined to look as they were measured.

    Modes nearer to each other than `CLOSE` have no shapes of their own: any orthogonal combination of mass-normalised
    ones is as good. Wanted are those nearest to the measured shapes that lie in their subspace with a share of `ALIKE`
    or more: the polar factor of the coefficients of these (Schoenemann, Psychometrika 31, 1966, orthogonal Procrustes).

    Parameters
    ----------
    test : (n_channel, n_test). model : (n_channel, n_model). freq_test, freq_model : Hz, those of the model rising.
    """
    turn = np.eye(freq_model.size)
    starts = np.flatnonzero(np.diff(freq_model, prepend=-np.inf) > CLOSE * freq_model)
    for group in np.split(np.arange(freq_model.size), starts[1:]):
        if group.size < 2 or freq_model[group[0]] <= 0.0:
            continue
        positive = freq_test > 0.0
        octaves = np.abs(np.log2(np.where(positive, freq_test, 1.0) / freq_model[group[0]]))
        wanted = _directions_in(model[:, group], test[:, positive & (octaves <= OCTAVES)])
        if wanted.size:
            u, _, v = np.linalg.svd(wanted)
            few = wanted.shape[1]
            turn[np.ix_(group, group)] = np.hstack([u[:, :few] @ v, u[:, few:]])
    return turn


def _directions_in(space: FloatArray, shapes: FloatArray) -> FloatArray:
    """(n, at most n) coefficients of size 1 of the shapes that a space of n columns holds, those it holds best; of two
    that are alike one."""
    c = np.linalg.lstsq(space, shapes, rcond=None)[0]
    size, inside = (shapes**2).sum(axis=0), ((space @ c) ** 2).sum(axis=0)
    share = np.divide(inside, size, out=np.zeros(size.size), where=size > 0.0)
    c = np.divide(c, np.linalg.norm(c, axis=0), out=np.zeros_like(c), where=np.linalg.norm(c, axis=0) > 0.0)
    kept: list[int] = []
    for k in np.argsort(-share, kind="stable").tolist():
        if share[k] >= ALIKE and len(kept) < len(c) and np.all((c[:, kept].T @ c[:, k]) ** 2 < APART):
            kept.append(k)
    return np.asarray(c[:, kept])


def _partners(score: FloatArray, allowed: BoolArray) -> IntArray:
    """(n_row,) column of each row, -1 for none, so that the sum of the scores is largest."""
    from scipy.optimize import linear_sum_assignment  # see `signals.spectra.low_pass`

    row, col = linear_sum_assignment(-np.where(allowed, score, -1.0))
    partner = np.full(score.shape[0], -1, dtype=np.int64)
    good = allowed[row, col]
    partner[row[good]] = col[good]
    return partner


def _share(x: FloatArray, space: FloatArray) -> float:
    """cos^2 of the angle between a vector and a subspace."""
    Q, _ = np.linalg.qr(space)
    return float(((Q.T @ x) ** 2).sum() / (x @ x))


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
