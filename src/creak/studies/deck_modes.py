"""Natural frequencies of a deck, parts joined, contact left out."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from creak.assembly.coupling import Driven, couple
from creak.assembly.part import Rayleigh, loose_system, part_system
from creak.assembly.system import System
from creak.linalg.factor import regular_factor
from creak.linalg.modes import Modes, modes
from creak.model.mesh import Model
from creak.studies.setup import read_model


@dataclass(frozen=True)
class DeckModes:
    """Frequencies in Hz, rigid-body modes first (0), and checks."""

    frequencies: list[float]
    mass: float
    rigid: int
    residual: float
    sturm_ok: bool


def deck_modes(path: Path, *, f_max: float | None = None, count: int | None = None) -> DeckModes:
    """Modes of the structure as its *BOUNDARY conditions hold it.

    Raises
    ------
    InputError : the deck is wrong. NumericalError : the modes could not be found.
    """
    system, found = model_modes(read_model(path), Driven({}), f_max=f_max, count=count)
    rigid = int((found.omega2 == 0.0).sum())
    return DeckModes(found.frequencies.tolist(), system.stats["mass"], rigid, found.residual, found.sturm_ok)


def model_modes(
    model: Model, driven: Driven, *, f_max: float | None = None, count: int | None = None
) -> tuple[System, Modes]:
    """The undamped assembly, held at its supports and driven dofs, and its modes."""
    rayleigh = Rayleigh(0.0, 0.0)
    parts = [part_system(model, i, rayleigh, override=True) for i in range(len(model.parts))]
    loose = loose_system(model, rayleigh)
    system = couple([*parts, loose] if loose else parts, model, driven, rayleigh, override=True)
    stiffness = regular_factor(system.K)
    found = modes(system.K, system.M, f_max=f_max, count=count, free=stiffness is None, stiffness_factor=stiffness)
    return system, found
