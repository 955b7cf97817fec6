"""From a study to what the analysis needs: model, channels, driven dofs, nodes to watch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path

import numpy as np

from creak.arrays import IntArray
from creak.contact.gap_operator import GapOperator, join
from creak.contact.pair import Keep
from creak.contact.play import crossed, play_channels
from creak.dynamics.flow.resolution import finer
from creak.dynamics.loads import Loads
from creak.errors import InputError
from creak.formats.decks import read_model
from creak.model.mesh import Model
from creak.model.units import UNITS
from creak.studies.design.heat import check_heat
from creak.studies.design.supports import check_driven
from creak.studies.file.case import Driving
from creak.studies.file.config import ReductionTable, TimeTable
from creak.studies.file.paths import digests_of
from creak.studies.file.places import Places
from creak.studies.file.reader import Study
from creak.studies.file.sound_tables import UNNAMED
from creak.studies.file.table import Table
from creak.studies.prepare.amount_check import (
    clearance_warnings,
    drift_warnings,
    file_unit_notes,
    jump_warnings,
    motion_warnings,
)
from creak.studies.prepare.elines import NO_ELINES, make_elines
from creak.studies.prepare.excitation import (
    driven_dofs,
    excitation_of,
    first_f_max,
    highest_frequency,
    loads_over,
    sample_loads,
    time_axis,
)
from creak.studies.prepare.flight_steps import RESOLUTIONS, bandwidth, with_flight_steps
from creak.studies.prepare.imported import imported_superelements
from creak.studies.prepare.linear_model import designed_model, own_damping
from creak.studies.prepare.marching import Marching, Observed, check_outputs, output_nodes, unmoved_warnings
from creak.studies.prepare.measured_damping import ABOVE, measured_damping
from creak.studies.prepare.measurements import Measurement, read_measurements
from creak.studies.prepare.pairs import contact_channels, plays_of
from creak.studies.prepare.reduction import Band, Exterior, Reduction, Watch, check_reduction
from creak.studies.prepare.rotation_check import check_rotations
from creak.studies.prepare.start_check import (
    check_held,
    drive_warnings,
    nothing_rattles,
    pace_warnings,
    start_warnings,
    undamped_warnings,
)
from creak.studies.prepare.static_loads import StaticStart, check_static, gravity_warnings, press_fit_warnings
from creak.studies.prepare.structure import Structure
from creak.studies.prepare.watched import watched
from creak.studies.unraised import none_ignored
from creak.studies.warned import Warned

PRECHECK_BAND = 3.0
"""The linear pre-check uses the modes up to this multiple of the excitation's highest frequency."""


@dataclass(frozen=True)
class Setup:
    """A checked study with its model."""

    study: Study
    structure: Structure
    """What stiffness, mass and damping depend on."""
    contacts: GapOperator
    """Channels of the contact pairs, before the pre-check."""
    connectors: GapOperator
    loads: Loads
    watch: Watch
    notes: list[str]
    refined: float = 1.0
    """How much finer than the study's accuracy says contact is resolved."""
    harder: float = 1.0
    """Times the springs that stand for hard contact."""
    static: StaticStart | None = None
    """What the run starts from, once it was solved: contacts and connectors are then those of that state."""
    digests: tuple[str, str] = ("", "")
    """Of the decks, and of the other files that the study names (`digests_of`); empty: the model came from no file."""
    tests: tuple[Measurement, ...] = ()
    """What was measured, beside what the run computes."""
    raised: int = 0
    """How often [reduction] f_max = "auto" has gone half as high again."""

    @property
    def model(self) -> Model:
        """The deck's, as the study changes it."""
        return self.structure.model

    @cached_property
    def band(self) -> Band:
        """Up to which frequencies there are modes."""
        c, excited = self.study.config, highest_frequency(self.study.driving)
        v, auto = c.verification, c.reduction.f_max == "auto"
        reach = partial(excitation_of, self.study.driving, self.loads, v.mac_f_max)
        first = first_f_max(c.reduction.f_max, reach, self.study.course.end)
        measured = (ABOVE * test.top for test in self.tests)
        assembly = max(1.1 * v.mac_f_max, PRECHECK_BAND * excited if c.precheck.enabled else 0.0, *measured)
        damped = None if self.structure.modal is None else v.f_max
        return Band(first, self.raised, auto, c.time.exact or auto, excited, assembly, damped)

    @property
    def reduction(self) -> Reduction:
        """What is reduced, and how."""
        exterior = Exterior(self.loads.force_labels, self.connectors.labels, self.contacts, self.watch)
        return Reduction(self.structure, exterior, self.study.config.reduction, self.band, self.study.driving)

    @cached_property
    def marching(self) -> Marching:
        """How it is marched."""
        driving, course = self.study.driving, self.study.course
        resolution = finer(RESOLUTIONS[course.time.accuracy], self.refined, self.harder)
        solver = any(gaps.rubbing or gaps.has_dampers for gaps in (self.contacts, self.connectors))
        sampled = partial(loads_over, self.model, driving)
        return Marching(course, self.loads, sampled, highest_frequency(driving), resolution, solver)

    def observed(self, gaps: GapOperator, *, lines: bool = False, record: bool = False) -> Observed:
        """What is looked at in a run of these channels.

        Parameters
        ----------
        lines : whether motion is measured at the E-lines. record : whether that around the hardest events is kept.
        """
        points, seen = self.watch.lines if lines else NO_ELINES, watched(self.model, self.contacts, gaps)
        return Observed(self.study.config.verification, self.static, self.watch.nodes, seen, points, record)

    @property
    def solves_rest(self) -> bool:
        """Whether a state at rest is solved for."""
        pressed = any((g.gap0 < 0.0).any() or g.resting.any() for g in (self.contacts, self.connectors))
        return bool(self.study.config.static) or pressed

    @property
    def solves_steps(self) -> bool:
        """Whether a state at rest, or steps of the unreduced model, are solved for."""
        c = self.study.config
        return c.proof != "none" or c.reduction.method == "none" or self.solves_rest

    @property
    def takes_whole(self) -> list[tuple[str, str]]:
        """Words of the study that need the unreduced model as a whole, and what to say instead of each."""
        c = self.study.config
        method, by_modes = c.reduction.method, c.reduction.interface.type == "participation"
        causes = [
            (method in ("none", "gap-modes"), f'[reduction] method = "{method}"', 'method = "craig-bampton"'),
            (c.proof == "whole", '[reference] run = "whole"', '[reference] run = "spots"'),
            (bool(c.static), "[[static]]", "no [[static]]"),
            (not c.time.exact, "a forced [time] scheme", "[time] without step and integrator"),
            (by_modes, '[reduction] interface = "participation"', 'interface = { type = "full" }'),
        ]
        return [(words, instead) for there, words, instead in causes if there]

    @property
    def origin(self) -> tuple[str, ...]:
        """All that a march hangs on but its channels and what is kept of it."""
        config = repr(self.study.config.model_dump())
        return config, *self.digests, repr((self.refined, self.harder))

    @property
    def no_contact(self) -> str | None:
        """Why nothing of the study can touch, in a sentence; None: something can."""
        presses = self.contacts.presses or self.connectors.presses
        count, named = self.contacts.m + self.connectors.m, len(self.study.touching.contacts)
        return None if presses else nothing_rattles(self.study.path, count, named)

    def unstarted(self) -> Setup:
        """The setup before its static loads."""
        if self.static is None:
            return self
        contacts, connectors = self.static.before
        watch = replace(self.watch, lines=replace(self.watch.lines, static=None))
        return replace(self, contacts=contacts, connectors=connectors, static=None, watch=watch)

    @property
    def unproven(self) -> Setup:
        """The same without runs of the unreduced model."""
        return self.with_tables(reference=self.study.config.reference.model_copy(update={"run": "none"}))

    def with_tables(self, **tables: Table) -> Setup:
        """The same setup with other tables of its study, of those that setting up does not look at."""
        return replace(self, study=self.study.with_tables(**tables))


@none_ignored()
def set_up(
    study: Study,
    ignore: Sequence[str] = (),
    store: Path | None = None,
    *,
    model: Model | None = None,
    keep: Keep | None = None,
) -> Setup:
    """Read the deck, check the study against it, build the gap channels.

    Parameters
    ----------
    ignore : keywords of the deck that may go unread although they change the answer.
    store : folder of saved superelements, beside which the channels of contacts are kept.
    model : of the deck, where it was read already. keep : has what was searched of the contacts before.

    Raises
    ------
    InputError : anything wrong in the study or the deck.
    """
    model = read_model(study.places.sibling(study.config.model.deck)) if model is None else model
    setup = replace(set_up_model(study, model, ignore, store=store, keep=keep), digests=digests_of(study))
    c = study.config
    if any((c.excitation, c.connector, c.clip, c.static, setup.model.initial_velocity)):
        return setup
    idle = Warned("nothing drives the model: the study has no [excitation]")
    return replace(setup, notes=[*setup.notes, idle])


def set_up_model(
    study: Study,
    model: Model,
    ignore: Sequence[str] = (),
    *,
    free: bool = False,
    store: Path | None = None,
    keep: Keep | None = None,
) -> Setup:
    """The same for a model that was read already.

    Parameters
    ----------
    free : whether parts may move as rigid bodies; a note names them.

    Raises
    ------
    InputError : as `set_up`.
    """
    places, driving, touching = study.places, study.driving, study.touching
    model, clips, designed = designed_model(study, model, ignore)
    amounts = [*clearance_warnings(model, touching), *file_unit_notes(driving)]
    contacts, notes = contact_channels(model, touching, store, keep)
    verification, banded = bandwidth(study.config.verification, study.course, model, contacts)
    study = study.with_tables(verification=verification)
    study, unfollowed = with_flight_steps(study)
    c, course = study.config, study.course
    check_frequencies(c.reduction, c.time, driving)
    time = time_axis(driving, course)
    driven = driven_dofs(model, driving)
    check_driven(model, driving, driven)
    loads = sample_loads(model, driving, time, store, exact=c.time.exact)
    notes += [*designed, *banded, *unfollowed, *amounts]
    notes += [*start_warnings(model, touching, c.precheck), *motion_warnings(driving, loads)]
    notes += [*jump_warnings(driven.names, loads.support[0]), *drift_warnings(model, driving, driven, loads)]
    plays = [*plays_of(touching), *clips]
    notes += [Warned(text) for p, where in plays for text in crossed(model, p, where, UNITS[c.model.units].length)]
    connectors = join([play_channels(model, p, where) for p, where in plays])
    rayleigh, override = own_damping(model, c.damping)
    notes += drive_warnings(model, driving, loads, driven, contacts)
    notes += pace_warnings(c.time, c.damping.modal, rayleigh, highest_frequency(driving))
    superelements, said_of = imported_superelements(model, c.superelement, places, rayleigh, override)
    notes += said_of
    check_rotations(model, driving, driven, plays, superelements)
    check_static(model, driving, driven)
    notes += gravity_warnings(model, driving)
    notes += press_fit_warnings(driving, contacts, connectors)
    notes += check_heat(model, driving, bool(superelements))
    if not connectors.has_dampers:
        notes += undamped_warnings(model, c.damping, touching, superelements)
    notes += check_held(model, driven, connectors, superelements, free)
    pairs = _pairs(model, c.verification.pairs, places)
    notes += check_outputs(course, time[:: c.time.substeps], len(pairs))
    check_reduction(model, c.reduction, places)
    named = [*contacts.group, *connectors.group], [*c.listener] or [UNNAMED]
    tests, left = read_measurements(model, c.test, c.model.units, named, places)
    notes += left
    structure = Structure(model, driven, rayleigh, override, superelements, c.damping.modal)
    if c.damping.from_test is not None:
        test, where = places.sibling(c.damping.from_test), places.where("damping", "from_test")
        modal, said = measured_damping(structure, test, c.model.units, where)
        structure = replace(structure, modal=modal)
        notes += said
    lines = make_elines(model, study.lines, contacts)
    kept = output_nodes(model, c.output.node_sets, pairs, [test.nodes_idx for test in tests], places)
    notes += unmoved_warnings(model, kept, driven, superelements)
    return Setup(
        study,
        structure,
        contacts,
        connectors,
        loads,
        Watch(pairs, kept, lines),
        [*notes, *lines.notes],
        tests=tests,
    )


def check_frequencies(reduction: ReductionTable, time: TimeTable, driving: Driving) -> None:
    """Raise InputError where modes or steps do not reach the excitation's highest frequency."""
    f_max, highest, places = reduction.f_max, highest_frequency(driving), driving.places
    if reduction.method != "none" and f_max != "auto" and f_max <= highest:
        raise InputError(
            f"f_max = {f_max:g} Hz is not above the excitation, which reaches {highest:g} Hz",
            where=places.where("reduction", "f_max"),
            expected="5 to 15 times the excitation",
            fix=f"Raise f_max to {15 * highest:g}.",
        )
    if not time.exact and highest > 0.5 / time.step:
        raise InputError(
            f"step = {time.step:g} s cannot follow an excitation of {highest:g} Hz",
            where=places.where("time", "step"),
            expected=f"at most {0.1 / highest:g} s",
            fix="Shorten the step.",
        )


def _pairs(model: Model, named: str | Sequence[str] | None, places: Places) -> IntArray:
    """Verification node pairs (n, 2)."""
    where = places.where("verification", "pairs")
    if named is None:
        return np.zeros((0, 2), dtype=np.int64)
    if isinstance(named, str):
        split = [f"{named}_MAIN", f"{named}_SECONDARY"]
        if named.upper() not in model.node_sets and all(s.upper() in model.node_sets for s in split):
            named = split
    if isinstance(named, str):
        nodes = model.node_set(named, where=where)
        if nodes.size % 2:
            raise InputError(
                f"node set {named!r} has {nodes.size} nodes",
                where=where,
                expected="an even number: pairs in turn",
                fix="Use *NSET, UNSORTED with main and secondary nodes in turn, or two sets.",
            )
        return nodes.reshape(-1, 2)
    if len(named) != 2:
        raise InputError(f"pairs names {len(named)} sets", where=where, expected="one or two")
    main, secondary = (model.node_set(n, where=where) for n in named)
    if main.size != secondary.size:
        raise InputError(
            f"{named[0]!r} and {named[1]!r} have {main.size} and {secondary.size} nodes",
            where=where,
            expected="the same number",
            fix="Make the sets equally long.",
        )
    return np.column_stack([main, secondary])
