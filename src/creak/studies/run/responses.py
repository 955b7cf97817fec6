"""Relative motion of the verification pairs without contact, by the frequency responses of both models."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from creak.arrays import ComplexArray, FloatArray
from creak.assembly.system import System, to_dense
from creak.dynamics.flow.coupled import coupled_damping
from creak.dynamics.modal.coefficients import is_modal, modal_matrices
from creak.dynamics.state import LinearTerms
from creak.linalg.diagonal import Diagonal
from creak.model.dofs import TRANSLATIONS, node_dofs
from creak.reduction.modal import modal_system
from creak.signals.spectra import spectrum
from creak.studies.models.reduced import ReducedModel
from creak.studies.models.reference import ReferenceModel, static_shapes
from creak.studies.prepare.excitation import highest_frequency
from creak.studies.prepare.setup import Setup
from creak.studies.run.agreement import SpectraComparison
from creak.verify.nrmse import nrmse_by_axis

BAND = 3.0
"""Highest known mode of the unreduced model over the highest line: modes beyond it answer as at rest, to a ninth."""
COUPLED = 4.0
"""Modes up to so many times the highest line are coupled by damping; those beyond are damped by themselves."""


def with_response_fit(
    spectra: SpectraComparison,
    setup: Setup,
    reference: ReferenceModel,
    reduced: ReducedModel,
    window: tuple[float, float],
) -> SpectraComparison:
    """Spectra of a reduced run alone with `response_fit`."""
    return replace(spectra, nrmse=response_fit(setup, reference, reduced, window), linear=True)


def response_fit(
    setup: Setup, reference: ReferenceModel, reduced: ReducedModel, window: tuple[float, float]
) -> dict[str, float | None]:
    """NRMSE by axis of reduced over unreduced relative motion, both X(f) = H(f) S(f) of the loads' spectrum S.

    H = A (K + i w C - w^2 M)^-1 (B - (K_qs + i w C_qs - w^2 M_qs)): of the unreduced model by its modes on the static
    answers to supports and forces (mode acceleration), so that no factor is made for it. Lines are those of the window,
    up to the highest frequency of the excitation and a third of the highest known mode. Empty: there is no such line,
    or the reduced model is not diagonal.
    """
    loads, v = setup.loads, setup.study.config.verification
    f_max = min(
        v.f_max, highest_frequency(setup.study) or v.f_max, float(reference.modes.frequencies[-1:].sum()) / BAND
    )
    rows = slice(*np.searchsorted(loads.time, [window[0], window[1] * (1.0 - 1e-12)]))
    freq, moved = spectrum(loads.support[0, rows], loads.step, f_max)
    _, pushed = spectrum(loads.force[rows], loads.step, f_max)
    if not freq.size or not isinstance(reduced.system.K, Diagonal):
        return {}
    whole = reference.system
    small = modal_system(whole, reference.modes, reference.support_shapes, static_shapes(setup, reference))
    both = [_relative(setup, system, freq, moved, pushed) for system in (small, reduced.system)]
    return nrmse_by_axis(*both)


def _relative(
    setup: Setup, system: System, freq: FloatArray, moved: ComplexArray, pushed: ComplexArray
) -> ComplexArray:
    """(n_freq, n_pair, 3) secondary minus main."""
    terms, i_omega = LinearTerms(system, setup.loads), np.asarray(2j * np.pi * freq, dtype=np.complex128)
    sides = [terms.on_all(side) for side in (terms.K_qs, terms.C_qs, terms.M_qs, terms.B)]
    loads = pushed @ sides[3].T - sum((i_omega**r)[:, None] * (moved @ side.T) for r, side in enumerate(sides[:3]))
    q = _answers(system, i_omega, np.asarray(loads, dtype=complex))
    main, secondary = (node_dofs(setup.pairs[:, k], TRANSLATIONS) for k in (0, 1))
    (A, A_s), (B, B_s) = system.rows(secondary), system.rows(main)
    u = q @ to_dense(A - B).T + moved @ to_dense(A_s - B_s).T
    return np.asarray(u.reshape(freq.size, -1, 3))


def _answers(system: System, i_omega: ComplexArray, loads: ComplexArray) -> ComplexArray:
    """(n_freq, n) coordinates of a diagonal System under loads (n_freq, n)."""
    if is_modal(system):
        m, c, k = modal_matrices(system)
        return np.asarray(loads / (k + i_omega[:, None] * c + (i_omega**2)[:, None] * m))
    m, k, C = np.asarray(system.M.diagonal()), np.asarray(system.K.diagonal()), coupled_damping(system)
    q = loads / (k + i_omega[:, None] * C.diagonal() + (i_omega**2)[:, None] * m)
    low = np.flatnonzero(k <= m * (COUPLED * abs(i_omega).max()) ** 2)
    for j, s in enumerate(i_omega):
        q[j, low] = np.linalg.solve(np.diag(k[low] + s**2 * m[low]) + s * C[np.ix_(low, low)], loads[j, low])
    return np.asarray(q)
