"""The reduced model: parts reduced and joined like the full ones, or the assembly reduced as a whole."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.digest import digest
from creak.dynamics.channels import channel_matrices
from creak.errors import CreakError, InputError
from creak.linalg.diagonal import Diagonal
from creak.linalg.modes import Modes, lowest, modes
from creak.model.dofs import PER_NODE
from creak.model.mesh import Model
from creak.progress import Progress, silent
from creak.reduction.diagonal import Split, all_modes, diagonalise
from creak.reduction.gap_modes import gap_modes
from creak.reduction.modal import ModalDamping, support_motion, without_modal_damping
from creak.studies.models.health import require_no_softer
from creak.studies.models.part_jobs import reduce_elsewhere
from creak.studies.models.reference import ReferenceModel, damped, held_factor, modal_band, static_shapes
from creak.studies.models.saved import NO_STORE, Store
from creak.studies.models.substructures import (
    UNREDUCED,
    Partition,
    own_interface,
    partition,
    reach_of_keep_out,
    shared_interface,
)
from creak.studies.models.superelements import (
    KEPT,
    Reduced,
    raised_once,
    reduce_substructure,
    with_all_modes,
)
from creak.studies.prepare.reduction import Band, Reduction
from creak.studies.solved import solved

DIAGONAL_LIMIT = 6000
"""Coupled models up to this size are diagonalised; larger ones keep their sparse form."""

DENSE = 6
"""Dense matrices of all unknowns while the reduced model is diagonalised."""
FACTOR = 50
"""Back-substitutions that a factorisation takes as long as (shells; solids two to four times as many)."""
BLOCKED = 0.2
"""Cost of a back-substitution among the blocks of a reduction over that of one by itself: .3 at 56,000 dofs, .16 at
1.15 million."""
OF_A_MODE = 13
"""The same of a fixed-interface mode, measured (docs/benchmarks_modes.md)."""
NO_INTERFACE = (
    'interface = "characteristic" reduces nothing: no part meets unreduced elements ([reduction] keep_out), another '
    "substructure, or another part by links"
)
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
    freed: int = 0
    """Dofs that parts share and are not joined at, as the study thins their interface."""
    fewer: bool = False
    """Interfaces move in fewer shapes than they have dofs, as the study thins them."""

    @property
    def every_mode(self) -> bool:
        """Whether it has all modes that there are."""
        if self.found is not None:
            return self.found.next_omega2 == np.inf and self.modes == self.found.omega2.size
        return all(r.every_mode for r in self.superelements)

    @property
    def thinned(self) -> bool:
        """Whether its interfaces lack what no mode brings back."""
        return self.fewer or self.freed > 0

    @property
    def complete(self) -> bool:
        """Whether it leaves nothing out: it has all modes, and interfaces have all of their shapes and joints."""
        return self.every_mode and not self.thinned

    @property
    def solves(self) -> int:
        """Back-substitutions of the whole model that it is worth."""
        return solves_for(self.retained, self.modes)

    @property
    def unreduced_dof(self) -> int:
        """Dofs of the nodes of elements that [reduction] keep_out leaves as they are."""
        ending = UNREDUCED.format(part="")
        return sum(PER_NODE * p.nodes_idx.size for p in self.model.parts if p.name.endswith(ending))


def solves_for(retained: int, modes: int) -> int:
    """Back-substitutions of the whole model that a reduction is worth."""
    return FACTOR + retained + OF_A_MODE * modes


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
    proven: bool | None = None
    """Whether the unreduced model makes the same of the events that it marched through; None: it was not asked."""


def reduce_model(
    reduction: Reduction,
    reference: ReferenceModel,
    gaps: GapOperator,
    progress: Progress,
    store: Store = NO_STORE,
    made: Callable[[Reduced], Reduced] | None = None,
) -> ReducedModel:
    """Reduce as [reduction] says.

    Parameters
    ----------
    store : of saved superelements, from which unchanged ones are taken.
    made : is handed every superelement as soon as it is there, its factor included, and returns what is kept of it.
        With it a part that cannot be reduced does not keep the others from it: the first one's error comes at the end.

    Raises
    ------
    InputError : what is asked for does not fit the model.
    """
    wall, cpu, band = clock.perf_counter(), clock.process_time(), reduction.band
    if reduction.table.method == WHOLE:
        found = _modes_of_whole(band.raised_to(0), reference, progress)
        for k in range(band.raised):
            found = _modes_of_whole(band.raised_to(k + 1), reference, progress, found)
        return _with_times(_whole(reduction, reference, gaps, found, band.kept_modes(found.omega2)), wall, cpu)
    cut, superelements, failed = partition(reduction, reference, gaps), [], []
    notes = [*reach_of_keep_out(reduction, gaps), *reduce_elsewhere(reduction, reference, gaps, store, progress)]
    if reduction.table.interface.type == "characteristic" and not any(sub.line.size for sub in cut.substructures):
        notes.append(NO_INTERFACE)
    for sub in cut.substructures:
        if sub.stays:
            continue
        try:
            reduced, more = reduce_substructure(reduction, sub, store, progress)
        except CreakError as error:
            if made is None:
                raise
            failed.append(error)
            continue
        if made is not None:
            reduced = made(reduced)
        superelements.append(reduced)
        reduced.inside.release(above=KEPT if made is None else 0)  # who was handed it has checked it
        notes += more
    if failed:
        raise failed[0]
    _check_modes(reduction, superelements)
    together = _together(reduction, reference.loose, cut, superelements, progress, store.folder)
    known = reference.modes.frequencies
    joined = reduction.table.interface.type == "full" and reference.of_parts is None
    if joined and known.size and isinstance(together.system.K, Diagonal):
        require_no_softer(reduced_modes(together.system, known[-1]).frequencies, known)
    return _with_times(replace(together, notes=notes), wall, cpu)


def _with_times(model: ReducedModel, wall: float, cpu: float) -> ReducedModel:
    """With what it has cost since `wall` and `cpu`."""
    return replace(model, wall_s=clock.perf_counter() - wall, cpu_s=clock.process_time() - cpu)


def _modes_of_whole(band: Band, reference: ReferenceModel, progress: Progress, found: Modes | None = None) -> Modes:
    """Modes of the assembly up to f_max, and further ones, beside those that are known."""
    system = reference.system
    return modes(
        system.K,
        system.M,
        f_max=band.f_max,
        further=band.further,
        found=found,
        free=reference.stiffness is None,
        stiffness_factor=reference.stiffness,
        progress=lambda done, total: progress("modes of the assembly for the reduction", done, total),
    )


def _whole(reduction: Reduction, reference: ReferenceModel, gaps: GapOperator, found: Modes, kept: int) -> ReducedModel:
    """Gap modes of the assembly, with the lowest of its modes and the static shapes of forces.

    Modal damping is that of all modes that are kept, where these are more than those up to the first f_max that the
    assembly is damped by; beyond them it grows with the frequency (`with_modal_damping`).
    """
    system, R, structure = reference.system, reference.support_shapes, reduction.structure
    modal, static = structure.modal, static_shapes(reference, reduction)
    own = found if kept == found.omega2.size else lowest(found, kept)
    if modal is not None and own.omega2.size > reference.modes.omega2.size:
        system = damped(modal, without_modal_damping(system, R), own, R)
    rows = channel_matrices(system, gaps).rows
    reduced = gap_modes(system, rows, modes=own, stiffness=reference.stiffness, static=static)
    size = reduced.stats.retained, own.omega2.size
    return ReducedModel((), structure.model, reduced, *size, 0.0, 0.0, [], None, found)


def _together(
    reduction: Reduction,
    loose: System | None,
    cut: Partition,
    superelements: Sequence[Reduced],
    progress: Progress,
    store: Path | None = None,
) -> ReducedModel:
    """The superelements coupled with what stays unreduced, and diagonalised."""

    def modes_of(K: FloatArray, M: FloatArray) -> Split:
        def make() -> dict[str, FloatArray]:
            return dict(zip(("omega2", "Phi", "N"), all_modes(K, M), strict=True))

        kept = solved(store, "coupled", [digest(K), digest(M)], make)
        return kept["omega2"], kept["Phi"], kept["N"]

    progress("couple and diagonalise", 0, 1)
    structure, interface = reduction.structure, reduction.table.interface
    own = partial(own_interface, interface, reduction.driving.places, cut)
    thinned = [own(r.substructure, r.system) for r in superelements]
    reduced = iter(thinned)
    systems = [sub.part if sub.stays else next(reduced) for sub in cut.substructures]
    coupled = structure.joined(systems, loose, cut.model)
    joined, coupled = coupled.n, shared_interface(interface, cut, coupled)
    own_fewer = any(s.n < r.system.n for s, r in zip(thinned, superelements, strict=True))
    fewer = own_fewer or coupled.n < joined or any(sub.shape is not None for sub in cut.substructures)
    system = diagonalise(coupled, modes_of) if coupled.n <= DIAGONAL_LIMIT else coupled
    system = with_damping(structure.modal, reduction.band, system)
    progress("couple and diagonalise", 1, 1)
    retained = sum(r.system.stats.retained for r in superelements)
    kept = sum(r.system.stats.modes for r in superelements)
    freed = sum(sub.freed for sub in cut.substructures)
    return ReducedModel(
        superelements=tuple(superelements),
        model=cut.model,
        system=system,
        retained=retained,
        modes=kept,
        wall_s=0.0,
        cpu_s=0.0,
        notes=[],
        coupled=coupled,
        freed=freed,
        fewer=fewer,
    )


def with_more_modes(
    reduction: Reduction,
    reference: ReferenceModel,
    gaps: GapOperator,
    reduced: ReducedModel,
    progress: Progress,
    store: Path | None = None,
) -> ReducedModel:
    """The same with the further modes too, which are computed where the reduction has not done so already."""
    wall, cpu = clock.perf_counter(), clock.process_time()
    known, band = reduction.band.further, replace(reduction.band, further=True)
    reduction, found, parts = replace(reduction, band=band), reduced.found, list(reduced.superelements)
    if found is not None:
        found = found if known else _modes_of_whole(band, reference, progress)
        return _with_times(_whole(reduction, reference, gaps, found, found.omega2.size), wall, cpu)
    if not known:
        parts = []
        for sub in partition(reduction, reference, gaps).substructures:
            if not sub.stays:
                parts.append(reduce_substructure(reduction, sub, NO_STORE, progress)[0])
                parts[-1].inside.release(above=KEPT)
    every = [with_all_modes(part) for part in parts]
    return _with_times(coupled_again(reduction, reference, gaps, every, progress, store), wall, cpu)


def raised_model(
    reduction: Reduction,
    reference: ReferenceModel,
    gaps: GapOperator,
    more: ReducedModel,
    progress: Progress,
    store: Store = NO_STORE,
) -> ReducedModel:
    """A model with all its further modes as a reduction that is raised once more has it: it gets further modes anew."""
    wall, cpu, band = clock.perf_counter(), clock.process_time(), reduction.band
    found, every = more.found, list[Reduced]()
    notes = [] if found is not None else reduce_elsewhere(reduction, reference, gaps, store, progress)
    if found is not None:
        found = _modes_of_whole(band, reference, progress, found)
    for reduced in more.superelements:
        every.append(raised_once(band, reduced, reduction.structure.model, progress, store))
        reduced.inside.release(above=KEPT)
    wall, cpu = clock.perf_counter() - wall, clock.process_time() - cpu
    wall, cpu = more.wall_s + wall, more.cpu_s + cpu
    return replace(more, superelements=tuple(every), found=found, wall_s=wall, cpu_s=cpu, notes=[*more.notes, *notes])


def coupled_again(
    reduction: Reduction,
    reference: ReferenceModel,
    gaps: GapOperator,
    superelements: Sequence[Reduced],
    progress: Progress = silent,
    store: Path | None = None,
) -> ReducedModel:
    """Superelements joined by the links and springs of a structure; nothing is reduced again."""
    wall, cpu = clock.perf_counter(), clock.process_time()
    cut = partition(reduction, reference, gaps)
    together = _together(reduction, reference.loose, cut, superelements, progress, store)
    return _with_times(together, wall, cpu)


def _check_modes(reduction: Reduction, superelements: list[Reduced]) -> None:
    """No fixed-interface mode below f_max though the first ones lie near the excitation: a mistake."""
    band = reduction.band
    if reduction.table.method == "guyan" or band.auto or any(r.system.stats.modes for r in superelements):
        return
    from creak.reduction.health.report import RULE  # its room is not waited for before the run

    first = min((r.system.stats.first_left_out for r in superelements), default=np.inf)
    if first > RULE * band.excited:
        return
    raise InputError(
        f"f_max = {band.f_max:g} Hz is below the first fixed-interface mode of every part ({first:.4g} Hz)",
        where=reduction.driving.places.where("reduction", "f_max"),
        expected=f"more than {first:.4g} Hz",
        fix='Raise f_max, or use method = "guyan" for a static reduction.',
    )


def with_damping(zeta: ModalDamping | None, band: Band, system: System) -> System:
    """A diagonal or sparse reduced System with modal damping, share of critical; None: there is none."""
    if zeta is None:
        return system
    every = isinstance(system.K, Diagonal)
    modes = reduced_modes(system, np.inf if every else modal_band(band, system.n))
    return damped(zeta, system, modes, support_motion(system, held_factor(system)), every=every)


def reduced_modes(system: System, f_max: float) -> Modes:
    """Modes of the reduced model up to `f_max`, Hz."""
    if isinstance(system.K, Diagonal):
        # Modes of a System that is diagonal already (M = I, or 0 for coordinates without mass): unit vectors.
        assert isinstance(system.M, Diagonal)
        omega2 = np.asarray(system.K.diagonal())
        keep = np.flatnonzero((omega2 <= (2.0 * np.pi * f_max) ** 2) & (system.M.d > 0.0))
        shapes = np.zeros((system.n, keep.size))
        shapes[keep, np.arange(keep.size)] = 1.0
        return Modes(omega2[keep], shapes, 0.0, True)
    return modes(system.K, system.M, f_max=f_max, free=True)
