"""The reduced model: parts reduced and joined like the full ones, or the assembly reduced as a whole."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import channel_matrices
from creak.errors import CreakError, InputError
from creak.linalg.diagonal import Diagonal
from creak.linalg.modes import Modes, lowest, modes
from creak.model.dofs import PER_NODE
from creak.model.mesh import Model
from creak.progress import Progress, silent
from creak.reduction.diagonal import Split, all_modes, diagonalise
from creak.reduction.gap_modes import gap_modes
from creak.reduction.interface.characteristic import second_level
from creak.reduction.modal import support_motion
from creak.studies.file.config import InterfaceTable
from creak.studies.file.places import Places
from creak.studies.models.reference import ReferenceModel, damped, held_factor, modal_band, static_shapes
from creak.studies.models.substructures import UNREDUCED, Partition, partition
from creak.studies.models.superelements import (
    KEPT,
    Reduced,
    kept_of_run,
    raised_once,
    reduce_substructure,
    with_all_modes,
)
from creak.studies.prepare.excitation import highest_frequency
from creak.studies.prepare.setup import Setup
from creak.studies.solved import digest_of, solved

DIAGONAL_LIMIT = 6000
"""Coupled models up to this size are diagonalised; larger ones keep their sparse form."""

DENSE = 6
"""Dense matrices of all unknowns while the reduced model is diagonalised."""
FACTOR = 50
"""Back-substitutions that a factorisation takes as long as (shells; solids two to four times as many)."""
OF_A_MODE = 13
"""The same of a fixed-interface mode, measured (docs/benchmarks_modes.md)."""
WHOLE = "gap-modes"
"""The method that reduces the assembly as a whole."""


@dataclass(frozen=True)
class ReducedModel:
    """The coupled superelements and what they cost."""

    superelements: tuple[Reduced, ...]
    """None where the assembly was reduced as a whole."""
    model: Model
    """Parts as they were reduced."""
    system: System
    retained: int
    modes: int
    wall_s: float
    cpu_s: float
    notes: list[str]
    coupled: System | None = None
    """The coupled superelements before they were diagonalised; None where the assembly was reduced as a whole."""
    found: Modes | None = None
    """Modes of the assembly, further ones too, where it was reduced as a whole."""

    @property
    def complete(self) -> bool:
        """Whether it has all modes that there are: nothing is left out."""
        if self.found is not None:
            return self.found.next_omega2 == np.inf and self.modes == self.found.omega2.size
        return all(r.complete for r in self.superelements)

    @property
    def solves(self) -> int:
        """Back-substitutions of the whole model that it is worth."""
        return FACTOR + self.retained + OF_A_MODE * self.modes

    @property
    def unreduced_dof(self) -> int:
        """Dofs of the nodes of elements that [reduction] keep_out leaves as they are."""
        ending = UNREDUCED.format(part="")
        return sum(PER_NODE * p.nodes_idx.size for p in self.model.parts if p.name.endswith(ending))


@dataclass(frozen=True)
class Stage:
    """One model of the stages: what it is, and what its run found."""

    f_max: float
    """Hz, up to which each part has all its modes."""
    modes: int
    events: int
    impulse: float
    """Of all channels over the whole run, force s."""
    wall_s: float
    """What making it and its run took, beyond the stage before."""
    same: bool | None = None
    """Whether the next one, with more modes, finds the same; None: there was no next one to tell."""


def reduce_model(
    setup: Setup,
    reference: ReferenceModel,
    gaps: GapOperator,
    progress: Progress,
    store: Path | None = None,
    made: Callable[[Reduced], Reduced] | None = None,
    *,
    keep: bool = False,
    further: bool | None = None,
) -> ReducedModel:
    """Reduce as [reduction] says.

    Parameters
    ----------
    store : folder of saved superelements to take unchanged ones from.
    keep : save superelements there for the runs to come.
    made : is handed every superelement as soon as it is there, its factor included, and returns what is kept of it.
        With it a part that cannot be reduced does not keep the others from it: the first one's error comes at the end.
    further : whether further modes are computed too; by default as `Setup.further` says.

    Raises
    ------
    InputError : what is asked for does not fit the model.
    """
    wall, cpu = clock.perf_counter(), clock.process_time()
    whole = setup.study.config.reduction.method == WHOLE
    if whole:
        found = _modes_of_whole(replace(setup, raised=0), reference, progress, further)
        for k in range(setup.raised):
            found = _modes_of_whole(replace(setup, raised=k + 1), reference, progress, found=found)
        all_of_it = _whole(setup, reference, gaps, found, setup.kept_modes(found.omega2))
    else:
        found, all_of_it = None, _by_parts(setup, reference, gaps, progress, store, made, keep=keep, further=further)
    return _model_of(all_of_it, found, wall, cpu)


def _model_of(all_of_it: _Made, found: Modes | None, wall: float, cpu: float) -> ReducedModel:
    """With what it has cost since `wall` and `cpu`."""
    superelements, model, system, retained, kept, notes, coupled = all_of_it
    wall, cpu = clock.perf_counter() - wall, clock.process_time() - cpu
    return ReducedModel(superelements, model, system, retained, kept, wall, cpu, notes, coupled, found)


_Made = tuple[tuple[Reduced, ...], Model, System, int, int, list[str], System | None]


def _modes_of_whole(
    setup: Setup,
    reference: ReferenceModel,
    progress: Progress,
    further: bool | None = None,
    found: Modes | None = None,
) -> Modes:
    """Modes of the assembly up to f_max, and further ones, beside those that are known."""
    system = reference.system
    return modes(
        system.K,
        system.M,
        f_max=setup.f_max,
        further=setup.further if further is None else further,
        found=found,
        free=reference.stiffness is None,
        stiffness_factor=reference.stiffness,
        progress=lambda done, total: progress("modes of the assembly for the reduction", done, total),
    )


def _whole(setup: Setup, reference: ReferenceModel, gaps: GapOperator, found: Modes, kept: int) -> _Made:
    """Gap modes of the assembly, with the lowest of its modes."""
    system = reference.system
    found = found if kept == found.omega2.size else lowest(found, kept)
    rows = channel_matrices(system, gaps).rows
    reduced = gap_modes(
        system, rows, modes=found, stiffness=reference.stiffness, static=static_shapes(setup, reference)
    )
    return (), setup.model, reduced, reduced.stats.retained, found.omega2.size, [], None


def _by_parts(
    setup: Setup,
    reference: ReferenceModel,
    gaps: GapOperator,
    progress: Progress,
    store: Path | None,
    made: Callable[[Reduced], Reduced] | None,
    *,
    keep: bool,
    further: bool | None,
) -> _Made:
    cut = partition(setup, reference, gaps)
    superelements, notes, failed = [], [], []
    for sub in cut.substructures:
        if sub.stays:
            continue
        try:
            reduced, more = reduce_substructure(setup, sub, store, progress, further=further)
        except CreakError as error:
            if made is None:
                raise
            failed.append(error)
            continue
        if made is not None:
            reduced = made(reduced)
        elif keep and store is not None:
            reduced = kept_of_run(store, reduced, setup)
        superelements.append(reduced)
        reduced.inside.release(above=KEPT if made is None else 0)  # who was handed it has checked it
        notes += more
    if failed:
        raise failed[0]
    _check_modes(setup, superelements)
    return _together(setup, reference, cut, superelements, notes, progress, store)


def _together(
    setup: Setup,
    reference: ReferenceModel,
    cut: Partition,
    superelements: list[Reduced],
    notes: list[str],
    progress: Progress,
    store: Path | None = None,
) -> _Made:
    """The superelements coupled with what stays unreduced, and diagonalised."""

    def modes_of(K: FloatArray, M: FloatArray) -> Split:
        def make() -> dict[str, FloatArray]:
            return dict(zip(("omega2", "Phi", "N"), all_modes(K, M), strict=True))

        kept = solved(store, "coupled", [digest_of(K), digest_of(M)], make)
        return kept["omega2"], kept["Phi"], kept["N"]

    progress("couple and diagonalise", 0, 1)
    reduced, interface = iter(superelements), setup.study.config.reduction.interface
    own = partial(_own_interface, interface, setup.study.places, cut)
    systems = [sub.part if sub.stays else own(next(reduced)) for sub in cut.substructures]
    coupled = setup.structure.joined(systems, reference.loose, cut.model)
    coupled = _shared_interface(interface, cut, coupled)
    system = with_damping(setup, diagonalise(coupled, modes_of) if coupled.n <= DIAGONAL_LIMIT else coupled)
    progress("couple and diagonalise", 1, 1)
    retained = sum(r.system.stats.retained for r in superelements)
    kept = sum(r.system.stats.modes for r in superelements)
    return tuple(superelements), cut.model, system, retained, kept, notes, coupled


def with_more_modes(
    setup: Setup, reference: ReferenceModel, gaps: GapOperator, reduced: ReducedModel, progress: Progress
) -> ReducedModel:
    """The same with the further modes too, which are computed where the reduction has not done so already."""
    wall, cpu = clock.perf_counter(), clock.process_time()
    if not setup.further:
        reduced = reduce_model(setup, reference, gaps, progress, further=True)
    if reduced.found is not None:
        made = _whole(setup, reference, gaps, reduced.found, reduced.found.omega2.size)
        return _model_of(made, reduced.found, wall, cpu)
    return _joined(setup, reference, gaps, [with_all_modes(r) for r in reduced.superelements], progress)


def raised_model(setup: Setup, reference: ReferenceModel, more: ReducedModel, progress: Progress) -> ReducedModel:
    """A model with all its further modes as the one of a setup that is raised once more: it gets further modes anew."""
    wall, cpu = clock.perf_counter(), clock.process_time()
    found, every = more.found, list[Reduced]()
    if found is not None:
        found = _modes_of_whole(setup, reference, progress, found=found)
    for reduced in more.superelements:
        every.append(raised_once(setup, reduced, progress))
        reduced.inside.release(above=KEPT)
    wall, cpu = clock.perf_counter() - wall, clock.process_time() - cpu
    wall, cpu = more.wall_s + wall, more.cpu_s + cpu
    return replace(more, superelements=tuple(every), found=found, wall_s=wall, cpu_s=cpu)


def coupled_again(setup: Setup, reference: ReferenceModel, gaps: GapOperator, reduced: ReducedModel) -> ReducedModel:
    """The same superelements joined by the links and springs of another setup; nothing is reduced again."""
    return _joined(setup, reference, gaps, list(reduced.superelements), silent)


def _joined(
    setup: Setup, reference: ReferenceModel, gaps: GapOperator, superelements: list[Reduced], progress: Progress
) -> ReducedModel:
    wall, cpu = clock.perf_counter(), clock.process_time()
    all_of_it = _together(setup, reference, partition(setup, reference, gaps), superelements, [], progress)
    return _model_of(all_of_it, None, wall, cpu)


def _check_modes(setup: Setup, superelements: list[Reduced]) -> None:
    """No fixed-interface mode below f_max though the first ones lie near the excitation: a mistake."""
    c = setup.study.config.reduction
    if c.method == "guyan" or setup.auto or any(r.system.stats.modes for r in superelements):
        return
    from creak.reduction.health.verdict import RULE  # its room is not waited for before the run

    first = min((r.system.stats.first_left_out for r in superelements), default=np.inf)
    if first > RULE * highest_frequency(setup.study.driving):
        return
    raise InputError(
        f"f_max = {setup.f_max:g} Hz is below the first fixed-interface mode of every part ({first:.4g} Hz)",
        where=setup.study.places.where("reduction", "f_max"),
        expected=f"more than {first:.4g} Hz",
        fix='Raise f_max, or use method = "guyan" for a static reduction.',
    )


def _own_interface(table: InterfaceTable, places: Places, cut: Partition, reduced: Reduced) -> System:
    """The superelement with characteristic modes of its own interface, where the study asks for them."""
    sub, system = reduced.substructure, reduced.system
    if table.type != "characteristic" or table.level != "local" or not sub.line.size:
        return system
    others = [s.part.labels for s in cut.substructures if s is not sub and not s.stays]
    if others and np.isin(sub.line, np.concatenate(others)).any():
        raise InputError(
            f"substructure {system.name} meets another one: local characteristic modes of the two do not fit together",
            where=places.where("reduction", "interface"),
            fix='Use level = "system".',
        )
    columns = np.flatnonzero(np.isin(system.coordinates, sub.line))
    return second_level(system, columns, count=_count(table, columns.size))


def _shared_interface(table: InterfaceTable, cut: Partition, coupled: System) -> System:
    """The assembly with characteristic modes of all interfaces together, where the study asks for them."""
    if table.type != "characteristic" or table.level != "system":
        return coupled
    lines = [s.line for s in cut.substructures]
    columns = np.flatnonzero(np.isin(coupled.coordinates, np.concatenate(lines)))
    if not columns.size:
        return coupled
    return second_level(coupled, columns, count=_count(table, columns.size))


def _count(table: InterfaceTable, size: int) -> int:
    return min(int(table.n or size), size)


def with_damping(setup: Setup, system: System) -> System:
    """A diagonal or sparse reduced System with the study's modal damping, if it asks for any."""
    if setup.study.config.damping.modal is None:
        return system
    every = isinstance(system.K, Diagonal)
    modes = reduced_modes(system, np.inf if every else modal_band(setup, system.n))
    return damped(setup.structure.modal, system, modes, support_motion(system, held_factor(system)), every=every)


def _own_modes(system: System, f_max: float) -> Modes:
    """Modes of a System that is diagonal already (M = I, or 0 for coordinates without mass): unit vectors."""
    assert isinstance(system.M, Diagonal)
    omega2 = np.asarray(system.K.diagonal())
    keep = np.flatnonzero((omega2 <= (2.0 * np.pi * f_max) ** 2) & (system.M.d > 0.0))
    shapes = np.zeros((system.n, keep.size))
    shapes[keep, np.arange(keep.size)] = 1.0
    return Modes(omega2[keep], shapes, 0.0, True)


def reduced_modes(system: System, f_max: float) -> Modes:
    """Modes of the reduced model up to `f_max`, Hz."""
    if isinstance(system.K, Diagonal):
        return _own_modes(system, f_max)
    return modes(system.K, system.M, f_max=f_max, free=True)
