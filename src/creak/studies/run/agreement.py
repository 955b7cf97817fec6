"""How far a reduced run agrees with the unreduced one: modes, and spectra of relative motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from creak.arrays import ComplexArray, FloatArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.model.dofs import TRANSLATIONS, node_dofs
from creak.signals.spectra import spectrum
from creak.studies.models.reduced import ReducedModel, reduced_modes
from creak.studies.models.reference import ReferenceModel
from creak.studies.prepare.setup import Setup
from creak.verify.mac import ModePairs, pair_modes
from creak.verify.nrmse import nrmse_by_axis

STILL = 1e-9
"""Share of the largest motion of the compared nodes below which a mode is not seen there."""


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
    nrmse: dict[str, float | None]
    """Fit by axis x, y, z, and all; None where nothing moves."""
    linear: bool = False
    """The fit is that of the frequency responses of both models, where the unreduced one was not run."""


def compare_modes(
    setup: Setup, reference: ReferenceModel, reduced: ReducedModel | None, gaps: GapOperator
) -> ModeComparison | None:
    """MAC at the verification pairs, or at the watched and channel nodes where the study names no pairs.

    Modes that do not move these nodes are left out. None without a reduced model, or without modes of the whole.
    """
    if reduced is None or reference.of_parts is not None:
        return None
    f_max = setup.study.config.verification.mac_f_max
    nodes = np.unique(setup.pairs) if setup.pairs.size else np.union1d(setup.watched, gaps.retained_nodes)
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


def compare_spectra(
    setup: Setup, runs: Mapping[str, HasHistory], window: tuple[float, float]
) -> SpectraComparison | None:
    if not setup.pairs.size or not runs:
        return None
    spectra: dict[str, ComplexArray] = {}
    freq = np.zeros(0)
    for name, run in runs.items():
        relative, step = _relative_motion(setup, run.history, window)
        freq, spectra[name] = spectrum(relative, step, setup.study.config.verification.f_max)
    both = "reference" in spectra and "reduced" in spectra
    fit = nrmse_by_axis(spectra["reference"], spectra["reduced"]) if both else {}
    return SpectraComparison(freq, spectra, fit)


def _relative_motion(setup: Setup, history: History, window: tuple[float, float]) -> tuple[FloatArray, float]:
    """(n_out in the window, n_pair, 3) secondary minus main, and the output step."""
    row = {int(n): i for i, n in enumerate(setup.watched)}
    u = history.displacement.reshape(history.displacement.shape[0], -1, 6)[:, :, :3]
    main, secondary = ([row[int(n)] for n in setup.pairs[:, k]] for k in (0, 1))
    time = history.time[history.output_index]
    step = float(time[1] - time[0])
    end = int(np.searchsorted(time, window[1] + 0.5 * step))
    n = round((window[1] - window[0]) / step)
    return (u[:, secondary] - u[:, main])[end - n : end], step
