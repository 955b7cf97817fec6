"""What was measured, [test.NAME], beside what the run computed: modes, frequency response functions, histories."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.damping import Damping
from creak.assembly.system import System
from creak.errors import InputError
from creak.formats.measured.histories import Histories
from creak.model.mesh import Model, Nodes
from creak.model.units import UnitsName
from creak.progress import Progress
from creak.reduction.modal import ModalDamping
from creak.sound.zwicker_tables import RATE
from creak.studies.findings.beside_records import RecordFits, fit_pressures, fit_records
from creak.studies.findings.histories import record_of
from creak.studies.findings.tree import FoundTest
from creak.studies.models.correlation import fit_modes
from creak.studies.models.frfs import FrfFit, fit_frfs
from creak.studies.models.reference import ReferenceModel
from creak.studies.prepare.marching import Marching
from creak.studies.prepare.measurements import OF_SOUND, Measurement
from creak.studies.prepare.reduction import Watch
from creak.studies.run.job import StudyResult
from creak.studies.run.one_run import Run
from creak.studies.sound.heard import Sound
from creak.studies.warned import Warned, attempted, warnings_of
from creak.verify.mode_fit import ModeFit
from creak.verify.records import Course


@dataclass(frozen=True)
class _Structure:
    """The unreduced structure of a study and its modes, contact left out."""

    model: Model
    system: System
    damped: System | None
    """None: its damping is modal."""
    frequencies: Sequence[float]
    rigid: int
    shapes: FloatArray


def beside_tests(
    result: StudyResult, sound: Sound | str | None, progress: Progress, notes: list[str]
) -> tuple[FoundTest, ...]:
    """The measurements of the study over what was computed; what cannot be compared becomes a note."""
    s, reduced, found = result.setup, result.reduced, []
    tests, main, c = s.tests, result.main, s.study.config
    units, f_max = c.model.units, c.verification.f_max
    if any(test.top for test in tests) and result.reference.of_parts is not None:
        notes.append("modes and functions of tests: memory does not hold the unreduced model, they are not compared")
        tests = tuple(replace(test, modes=None, frfs=None) for test in tests)
    moved = any(not OF_SOUND.fullmatch(c.name) for test in tests for c in test.channels)
    histories = None
    if main is not None and moved:
        of_run = partial(_histories, main, units, s.model.nodes, s.watch, s.marching)
        histories = attempted("time histories beside the tests", of_run, None, notes)
    structure = partial(_structure, s.model, result.reference, s.structure.modal)
    of_frfs = structure, s.structure.modal, None if reduced is None else reduced.system, progress
    for k, test in enumerate(tests):
        progress("beside the tests", k, len(tests))
        what = f"test {test.name}"
        modes = attempted(what, partial(_modes, structure, s.structure.modal, test), None, notes)
        frfs = attempted(what, partial(_frfs, *of_frfs, test), None, notes)
        records = None
        if main is not None:
            records = attempted(what, partial(_records, histories, sound, test, f_max), None, notes)
        told = [note for one in (modes, frfs, records) if one is not None for note in one.notes]
        notes += [Warned(f"{what}: {note}") for note in warnings_of(told)]
        found.append(FoundTest(test.name, test.path.name, modes, frfs, records))
    return tuple(found)


def _structure(model: Model, reference: ReferenceModel, modal: ModalDamping | None) -> _Structure:
    """As the study holds and drives it."""
    system, modes = reference.system, reference.modes
    if modal is not None:
        system = replace(system, damping=Damping(0.0, 0.0))
    rigid = int((modes.omega2 == 0.0).sum())
    damped = system if modal is None else None
    return _Structure(model, system, damped, modes.frequencies.tolist(), rigid, modes.shapes)


def _modes(structure: Callable[[], _Structure], modal: ModalDamping | None, test: Measurement) -> ModeFit | None:
    return None if test.modes is None else fit_modes(structure(), *test.modes, modal)[0]


def _frfs(
    structure: Callable[[], _Structure],
    modal: ModalDamping | None,
    reduced: System | None,
    progress: Progress,
    test: Measurement,
) -> FrfFit | None:
    if test.frfs is None:
        return None
    top, damping = max(float(f.freq[-1]) for f in test.frfs[0].functions), (modal, ["damping is that of the study"])
    return fit_frfs(structure(), *test.frfs, top, damping, reduced=reduced, progress=progress)


def _records(
    histories: Histories | None, sound: Sound | str | None, test: Measurement, f_max: float
) -> RecordFits | None:
    heard = [c for c in test.channels if OF_SOUND.fullmatch(c.name)]
    moved = [c for c in test.channels if not OF_SOUND.fullmatch(c.name)]
    found = fit_records(histories, moved, test.path, f_max) if histories is not None and moved else None
    if not heard:
        return found
    if not isinstance(sound, Sound):
        raise InputError(
            "the run has no sound to lay its pressure over", where=test.path, expected="a run that is heard"
        )
    time = np.arange(sound.pressure.shape[2]) / RATE
    courses = {
        f"{listener.name} pressure".lower(): Course(time, sound.pressure[k, -1].astype(np.float64))
        for k, listener in enumerate(sound.listeners)
    }
    shift = None if found is None else found.shift
    more = fit_pressures(courses, heard, test.path, sound.band.computed, sound.run, shift)
    if found is None:
        return more
    return replace(found, pairs=(*found.pairs, *more.pairs), notes=(*found.notes, *more.notes))


def _histories(main: Run, units: UnitsName, nodes: Nodes, watch: Watch, marching: Marching) -> Histories:
    """Motion, gaps and forces of the run as results.h5 holds them."""
    record = record_of(main, nodes, watch, marching)
    return Histories(
        run=main.name,
        units=units,
        time=record.time,
        node_ids=record.node_ids,
        node_names=tuple(record.node_names),
        displacement=record.displacement,
        channels=tuple(record.channels),
        channel_nodes=record.channel_nodes,
        gap=record.gap,
        normal_force=record.normal_force,
        peak_force=record.peak_force,
    )
