"""The linear structure of a model: parts, joined by links and supports, contact left out; its modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from creak.assembly.coupling import Driven, couple
from creak.assembly.part import Rayleigh, part_system
from creak.assembly.system import System
from creak.linalg.factor import regular_factor
from creak.linalg.modes import Modes, modes
from creak.model.mesh import Model
from creak.reduction.modal import ModalDamping


@dataclass(frozen=True)
class Structure:
    """All that stiffness, mass and damping of the joined parts depend on."""

    model: Model
    driven: Driven
    rayleigh: Rayleigh
    override_damping: bool
    """Whether the numbers of `rayleigh` replace all damping of the deck."""
    superelements: tuple[System, ...]
    """Parts that came as matrices."""
    modal: ModalDamping | None
    """Share of critical damping of every mode, where the study says it or a test."""

    def part(self, k: int, model: Model | None = None) -> System:
        """System of part k of the model, or of another one that it was cut into."""
        return part_system(model or self.model, k, self.rayleigh, override=self.override_damping)

    def joined(self, parts: Sequence[System], loose: System | None, model: Model | None = None) -> System:
        """Parts, full or reduced, and those that came as matrices, coupled by links and supports.

        Parameters
        ----------
        loose : nodes between parts. model : whose links they are, where parts were cut.
        """
        systems = [*parts, *self.superelements, *([loose] if loose is not None else [])]
        return couple(systems, model or self.model, self.driven, self.rayleigh, override=self.override_damping)


def modes_up_to(system: System, f_max: float) -> Modes:
    """All undamped modes K x = omega^2 M x of a joined structure up to f_max (Hz), held or free.

    Raises
    ------
    NumericalError : the modes could not be found.
    """
    regular = regular_factor(system.K)
    return modes(system.K, system.M, f_max=f_max, free=regular is None, stiffness_factor=regular)
