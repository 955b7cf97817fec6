"""How far a reduced run agrees with the unreduced one: modes, and spectra of relative motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from creak.arrays import ComplexArray, FloatArray, IntArray, to_dense
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.diagonal import is_modal, modal_matrices
from creak.dynamics.history import History
from creak.dynamics.loads import Loads
from creak.dynamics.state import LinearTerms
from creak.linalg.diagonal import Diagonal
from creak.model.dofs import TRANSLATIONS, node_dofs
from creak.signals.spectra import spectrum
from creak.studies.models.health import LOW
from creak.studies.models.reduced import ReducedModel, reduced_modes
from creak.studies.models.reference import ReferenceModel, in_modes
from creak.studies.prepare.reduction import Reduction, Watch
from creak.studies.warned import Warned
from creak.verify.mac import ModePairs, pair_modes
from creak.verify.nrmse import nrmse_by_axis
from creak.words import first_few

BAND = 3.0
"""Highest known mode of the unreduced model over the highest line: modes beyond it answer as at rest, to a ninth."""
COUPLED = 4.0
"""Modes up to so many times the highest line are coupled by damping; those beyond are damped by themselves."""
STILL = 1e-9
"""Share of the largest motion of the compared nodes below which a mode is not seen there."""
Fit = dict[str, float | None]
"""NRMSE by axis x, y, z, and all; None where nothing moves."""


class HasHistory(Protocol):
    """A run."""

    @property
    def history(self) -> History: ...


@dataclass(frozen=True)
class ModeComparison:
    """Modes of the reference and the reduced model up to the verification's mac_f_max."""

    pairs: ModePairs
    freq_reference: FloatArray
    freq_reduced: FloatArray


@dataclass(frozen=True)
class SpectraComparison:
    """Relative motion of the verification pairs over the window, by frequency."""

    freq: FloatArray
    spectra: dict[str, ComplexArray]
    """Run -> (n_freq, n_pair, 3)."""
    nrmse: Fit
    linear: bool = False
    """The fit is that of the frequency responses of both models, where the unreduced one was not run."""


def compare_modes(
    watch: Watch, f_max: float, reference: ReferenceModel, reduced: ReducedModel | None, gaps: GapOperator
) -> ModeComparison | None:
    """MAC at the verification pairs, or at the watched and channel nodes where the study names no pairs.

    Modes that do not move these nodes are left out. None without a reduced model, or without modes of the whole.

    Parameters
    ----------
    f_max : Hz, of the modes that are compared.
    """
    if reduced is None or reference.of_parts is not None:
        return None
    nodes = np.unique(watch.pairs) if watch.pairs.size else np.union1d(watch.nodes, gaps.retained_nodes)
    if nodes.size == 0:
        return None
    labels = node_dofs(nodes, TRANSLATIONS)
    freq = reference.modes.frequencies
    below = freq <= f_max
    other = reduced_modes(reduced.system, 1.2 * f_max)
    shapes = np.asarray(reference.system.rows(labels)[0] @ reference.modes.shapes[:, below])
    shapes_reduced = np.asarray(reduced.system.rows(labels)[0] @ other.shapes)
    size = np.linalg.norm(shapes, axis=0)
    seen = size > STILL * size.max(initial=0.0)
    pairs = pair_modes(freq[below][seen], shapes[:, seen], other.frequencies, shapes_reduced)
    return ModeComparison(pairs, freq[below][seen], other.frequencies)


def lost_modes(modes: ModeComparison | None, reduction: Reduction) -> list[Warned]:
    """Modes up to f_max of which a reduced model with a thinned interface has none near: more modes do not bring them
    back. Rigid ones, whose frequencies are round-off, aside."""
    interface, f_max = reduction.table.interface.type, reduction.band.f_max
    if modes is None or interface == "full":
        return []
    f = modes.freq_reference
    lost = f[(modes.pairs.partner < 0) & (f > LOW * f.max(initial=0.0)) & (f <= f_max)].tolist()
    named = first_few(lost, name=lambda hz: f"{hz:.4g} Hz")
    lacks = f'with interface = "{interface}" the reduced model lacks modes of the unreduced one ({named})'
    better = 'set [reduction] interface = { type = "full" }, or keep more of it'
    return [Warned(f"{lacks}, so what its run finds may be far off: {better}")] if lost else []


def compare_spectra(
    watch: Watch,
    f_max: float,
    runs: Mapping[str, HasHistory],
    window: tuple[float, float],
    linear: Callable[[], Fit] | None = None,
) -> SpectraComparison | None:
    """Spectra of the pairs up to f_max (Hz) in each run, and their fit; None without pairs or runs.

    Parameters
    ----------
    linear : gives the fit where only the reduced model was run: that of the models' `response_fit`.
    """
    if not watch.pairs.size or not runs:
        return None
    spectra: dict[str, ComplexArray] = {}
    freq = np.zeros(0)
    for name, run in runs.items():
        relative, step = _relative_motion(watch, run.history, window)
        freq, spectra[name] = spectrum(relative, step, f_max)
    both = "reference" in spectra and "reduced" in spectra
    if both:
        return SpectraComparison(freq, spectra, nrmse_by_axis(spectra["reference"], spectra["reduced"]))
    fit = linear() if linear is not None and "reduced" in spectra else {}
    return SpectraComparison(freq, spectra, fit, linear=bool(fit))


def _relative_motion(watch: Watch, history: History, window: tuple[float, float]) -> tuple[FloatArray, float]:
    """(n_out in the window, n_pair, 3) secondary minus main, and the output step."""
    row = {int(n): i for i, n in enumerate(watch.nodes)}
    u = history.displacement.reshape(history.displacement.shape[0], -1, 6)[:, :, :3]
    main, secondary = ([row[int(n)] for n in watch.pairs[:, k]] for k in (0, 1))
    time = history.time[history.output_index]
    step = float(time[1] - time[0])
    end = int(np.searchsorted(time, window[1] + 0.5 * step))
    n = round((window[1] - window[0]) / step)
    return (u[:, secondary] - u[:, main])[end - n : end], step


def response_fit(
    pairs: IntArray,
    f_max: float,
    loads: Loads,
    reduction: Reduction,
    reference: ReferenceModel,
    reduced: System,
    window: tuple[float, float],
) -> Fit:
    """NRMSE by axis of reduced over unreduced relative motion, both X(f) = H(f) S(f) of the loads' spectrum S.

    H = A (K + i w C - w^2 M)^-1 (B - (K_qs + i w C_qs - w^2 M_qs)): of the unreduced model by its modes on the static
    answers to supports and forces (mode acceleration), so that no factor is made for it. Lines are those of the window,
    up to f_max (Hz), the highest frequency of the excitation and a third of the highest known mode. Empty: there is no
    such line, or the reduced model is not diagonal.
    """
    highest = reduction.band.excited or f_max
    f_max = min(f_max, highest, float(reference.modes.frequencies[-1:].sum()) / BAND)
    rows = slice(*np.searchsorted(loads.time, [window[0], window[1] * (1.0 - 1e-12)]))
    freq, moved = spectrum(loads.support[0, rows], loads.step, f_max)
    _, pushed = spectrum(loads.force[rows], loads.step, f_max)
    if not freq.size or not isinstance(reduced.K, Diagonal):
        return {}
    small = in_modes(reference, reduction)
    both = [_relative(LinearTerms(system, loads), pairs, freq, moved, pushed) for system in (small, reduced)]
    return nrmse_by_axis(*both)


def _relative(
    terms: LinearTerms, pairs: IntArray, freq: FloatArray, moved: ComplexArray, pushed: ComplexArray
) -> ComplexArray:
    """(n_freq, n_pair, 3) secondary minus main."""
    system, i_omega = terms.system, np.asarray(2j * np.pi * freq, dtype=np.complex128)
    sides = [terms.on_all(side) for side in (terms.K_qs, terms.C_qs, terms.M_qs, terms.B)]
    loads = pushed @ sides[3].T - sum((i_omega**r)[:, None] * (moved @ side.T) for r, side in enumerate(sides[:3]))
    q = _answers(system, i_omega, np.asarray(loads, dtype=complex))
    main, secondary = (node_dofs(pairs[:, k], TRANSLATIONS) for k in (0, 1))
    (A, A_s), (B, B_s) = system.rows(secondary), system.rows(main)
    u = q @ to_dense(A - B).T + moved @ to_dense(A_s - B_s).T
    return np.asarray(u.reshape(freq.size, -1, 3))


def _answers(system: System, i_omega: ComplexArray, loads: ComplexArray) -> ComplexArray:
    """(n_freq, n) coordinates of a diagonal System under loads (n_freq, n)."""
    if is_modal(system):
        m, c, k = modal_matrices(system)
        return np.asarray(loads / (k + i_omega[:, None] * c + (i_omega**2)[:, None] * m))
    m, k = np.asarray(system.M.diagonal()), np.asarray(system.K.diagonal())
    C = system.damping.matrix(m, k)
    q = loads / (k + i_omega[:, None] * C.diagonal() + (i_omega**2)[:, None] * m)
    low = np.flatnonzero(k <= m * (COUPLED * abs(i_omega).max()) ** 2)
    for j, s in enumerate(i_omega):
        q[j, low] = np.linalg.solve(np.diag(k[low] + s**2 * m[low]) + s * C[np.ix_(low, low)], loads[j, low])
    return np.asarray(q)
