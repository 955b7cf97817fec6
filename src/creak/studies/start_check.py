"""What a study says that can hardly be meant, seen before it is run, and contact that never happens."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.model.mesh import Model
from creak.studies.config import StudyConfig
from creak.studies.unit_check import SYSTEMS, across, unit_warnings
from creak.studies.warned import Warned

WIDE = 0.1
"""Share of the model's size above which a margin of the pre-check can hardly be meant."""
USUAL = 0.5e-3
"""m: a margin to propose."""


def start_warnings(model: Model, config: StudyConfig) -> list[str]:
    """Units of materials and lengths, and the margin of the pre-check, against the model."""
    units = config.model.units
    return [Warned(text) for text in [*unit_warnings(model, units), *_margin(model, config)]]


def figure_warnings(model: Model, units: str, mass: float, omega2: FloatArray) -> list[str]:
    """Mass and first natural frequency against the units; none where the model itself was warned of.

    Parameters
    ----------
    omega2 : squares of the natural frequencies, rad^2/s^2, in order; rigid-body modes are 0.
    """
    if unit_warnings(model, units):
        return []
    elastic = omega2[omega2 > 0.0]
    frequency = float(np.sqrt(elastic[0]) / (2.0 * np.pi)) if elastic.size else None
    return [Warned(text) for text in unit_warnings(model, units, mass=mass, frequency=frequency)]


def nothing_closes(contacts: GapOperator, smallest: FloatArray, margin: float) -> str:
    """For a pre-check that keeps no channel: the closest approach, and what to do.

    Parameters
    ----------
    smallest : (m,) smallest gap of every channel in the linear run.
    """
    k = int(np.argmin(smallest))
    return Warned(
        f"no contact comes within the pre-check's margin of {margin:g}: the closest approach is {smallest[k]:.3g} at "
        f"{contacts.names[k]}, which starts {contacts.gap0[k]:.3g} open; raise the excitation's amplitude, or look "
        "whether distances and units are as meant"
    )


def never_closed(gaps: GapOperator, history: History) -> str:
    """For runs without a contact event: the closest approach."""
    step, k = np.unravel_index(int(np.argmin(history.gap)), history.gap.shape)
    return Warned(
        f"nothing touched in the run: the closest approach was {history.gap[step, k]:.3g} at {gaps.names[k]}, "
        f"t = {history.time[step]:.4g} s, from {gaps.gap0[k]:.3g} at the start"
    )


def _margin(model: Model, config: StudyConfig) -> list[str]:
    margin, size = config.precheck.margin, across(model)
    if not (config.precheck.enabled and config.contact and size and margin > WIDE * size):
        return []
    system = SYSTEMS[config.model.units]
    unit = system.words[0]
    return [
        f"[precheck] margin = {margin:g} {unit} is {100.0 * margin / size:.0f} % of the model's size: every channel is "
        f"kept; margin = {USUAL / system.length:g} is {1e3 * USUAL:g} mm"
    ]
