"""One study set up once and then reduced and loaded in many ways."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from creak.api.study import change_study, plain, set_up
from creak.arrays import ComplexArray, FloatArray, IntArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator, join
from creak.dynamics.scheme import Scheme
from creak.errors import InputError
from creak.given import table_of
from creak.progress import told_to
from creak.studies.file.reader import Study, checked_study
from creak.studies.models.reduced import ReducedModel, reduce_model
from creak.studies.models.reference import ReferenceModel, build_reference
from creak.studies.prepare.flight_steps import with_flight_steps
from creak.studies.prepare.marching import excitation_window
from creak.studies.prepare.reduction import check_reduction
from creak.studies.prepare.setup import Setup, check_frequencies
from creak.studies.prepare.varied import OF_LOADS, varied
from creak.studies.run.agreement import ModeComparison, compare_modes, compare_spectra
from creak.studies.run.integrate import limited
from creak.studies.run.job import ReferenceRun
from creak.studies.run.kernels import compiling
from creak.studies.run.one_run import Run, march_run
from creak.studies.run.precheck import prechecked, with_closed, with_linear_gaps
from creak.studies.sweep.case import SharedReference
from creak.verify.events import Event, events_in

Progress = Callable[[str, int, int], None]
SAME_PLACE = 1e-6
"""Share of the model's size within which two nodes lie at one place."""


@dataclass(frozen=True)
class Bench:
    """A study with its unreduced model and its channels, made once, for many reductions and loads (`make_bench`).

    Where the study forces a time step, all runs share the contact stiffness that a step of the unreduced model
    resolves.
    """

    setup: Setup
    reference: ReferenceModel
    """The unreduced parts, their assembly and its modes."""
    gaps: GapOperator
    """Channels that are kept: contacts first, connectors after."""
    progress: Progress = field(repr=False)
    model: ReducedModel | None = None
    """What `reduced` made; None: the unreduced model is run."""
    chosen: bool = False
    """Whether the channels are those at given places, and no others are asked for."""

    @property
    def system(self) -> System:
        """What is run."""
        return self.reference.system if self.model is None else self.model.system

    @property
    def frequencies(self) -> FloatArray:
        """(n,) Hz of the unreduced model, without contact."""
        return self.reference.modes.frequencies

    @property
    def scheme(self) -> Scheme:
        """The step that the study's [time] names, for those who march a System themselves."""
        return self.setup.marching.scheme

    @property
    def window(self) -> tuple[float, float]:
        """s, first and last instant of the stretch that is compared: the last period, or the whole run."""
        return excitation_window(self.setup.study.course, self.setup.marching.ends)

    @property
    def positions(self) -> FloatArray:
        """(m, 3) where the channels' secondary nodes lie."""
        return self.setup.model.nodes.coords[self.gaps.nodes_idx]

    def under(self, changes: Mapping[str, Any]) -> Bench:
        """The same under other signals, `{"excitation.hinge.signal.amplitude": 2.0}`.

        Raises
        ------
        InputError : a key that does not belong to a signal, a wrong value, or a frequency that modes or steps do not
            reach.
        """
        for key in changes:
            if key.split(".")[::2][:2] != ["excitation", "signal"]:
                raise InputError(
                    f"{key} is no key of a signal",
                    expected="excitation.NAME.signal.KEY",
                    fix="Change the study before the bench is made.",
                )
        other, _ = with_flight_steps(change_study(self.setup.study, changes))
        check_frequencies(self.setup.study.config.reduction, other.config.time, other.driving)
        setup = varied(self.setup, {name: getattr(other.config, name) for name in OF_LOADS})
        return replace(self, setup=replace(setup, study=replace(other, config=setup.study.config)))

    def reduced(self, table: Mapping[str, Any]) -> Bench:
        """The same with a reduced model.

        Parameters
        ----------
        table : keys and values of [reduction], in place of those of the study.

        Raises
        ------
        InputError : an unknown key, a wrong value, or one that does not fit the model.
        NumericalError : the reduction failed.
        """
        study = self.setup.study
        data = {**tomllib.loads(study.text), "reduction": plain(table)}
        setup = self.setup.with_tables(reduction=checked_study(study.path, data, study.text).config.reduction)
        check_frequencies(setup.study.config.reduction, study.config.time, study.driving)
        check_reduction(setup.model, setup.study.config.reduction, setup.study.places)
        return replace(self, setup=setup, model=reduce_model(setup.reduction, self.reference, self.gaps, self.progress))

    def run(self, name: str = "reduced", *, keep: str | Path | None = None) -> Run:
        """March the model through its loads; a run that stops early has `Run.stopped`.

        Parameters
        ----------
        name : of a reduced run, for the progress.
        keep : file of the run of an unreduced model: taken from there, else written there. Name it after all that the
            run depends on.

        Raises
        ------
        InputError : `keep` of a reduced run; with margin = "auto" a channel closed that the pre-check of the bench's
            own load has dropped.
        NumericalError : a step matrix is singular.
        """
        setup, observed = self.setup, self.setup.observed(self.gaps)
        if self.model is not None:
            if keep is not None:
                raise InputError(f"{keep} would keep a reduced run", expected="the run of an unreduced model")
            table = setup.study.config.precheck
            watch = table.enabled and table.margin == "auto" and not self.chosen  # with a number the user decides
            observed = observed if watch else replace(observed, seen=None)
            run = march_run(name, setup.marching, observed, self.model, self.gaps, self.progress)
            if with_closed(table, setup.contacts, setup.connectors, "", self.gaps, run.history) is not None:
                raise InputError(
                    "channels closed that the pre-check has dropped under the load that the bench was made with",
                    expected="channels that come near under every load",
                    fix="Make the bench with the largest load, or give [precheck] a margin that keeps more.",
                )
            return run
        make: ReferenceRun = partial(march_run, "reference") if keep is None else SharedReference(Path(keep))
        return make(setup.marching, observed, self.reference, self.gaps, self.progress)

    def events(self, run: Run) -> list[Event]:
        """Contact events of a run that count in the `window`."""
        return events_in(run.events, self.window)

    def modes(self) -> ModeComparison | None:
        """Modes of the reduced model against those of the unreduced one, up to [verification] mac_f_max."""
        f_max = self.setup.study.config.verification.mac_f_max
        return compare_modes(self.setup.watch, f_max, self.reference, self.model, self.gaps)

    def spectra(self, run: Run) -> tuple[FloatArray, ComplexArray]:
        """Hz (n_freq,) and relative motion (n_freq, n_pair, 3) of the verification pairs in the `window`.

        Raises
        ------
        InputError : the study names no pairs.
        """
        f_max = self.setup.study.config.verification.f_max
        found = compare_spectra(self.setup.watch, f_max, {run.name: run}, self.window)
        if found is None:
            where = self.setup.study.places.where("verification", "pairs")
            raise InputError("the study names no pairs of nodes", where=where, expected="one or two node sets")
        return found.freq, found.spectra[run.name]


def make_bench(
    study: Study | str | Path,
    progress: Progress | None = None,
    *,
    at: ArrayLike | None = None,
    ignore: Sequence[str] = (),
) -> Bench:
    """Set a study up: unreduced model with its modes, and the channels that its pre-check keeps.

    Parameters
    ----------
    progress : called with (stage, done, total).
    at : (k, 3) positions: contact channels whose secondary node lies at one of them are kept, in place of those of the
        pre-check (`Bench.positions` of another bench).
    ignore : keywords of the deck that may go unread although they change the answer.

    Raises
    ------
    InputError : anything wrong in the study or the deck, or no channel at `at`. NumericalError : the modes could not
        be found.
    """
    report = told_to(progress)
    setup = set_up(study, ignore)
    positions = None if at is None else _positions(at)
    with compiling(setup.marching, solves_steps=setup.solves_steps) as compiled:
        compiled(report, steps=True)
    reference = build_reference(setup.structure, setup.band, report)
    if positions is None:
        table = setup.study.config.precheck
        smallest = with_linear_gaps(table, setup.reduction, setup.marching, reference, report).linear_gaps
        kept, _ = prechecked(table, setup.contacts, smallest, "")
    else:
        kept = setup.contacts.select(_at(setup.model.nodes.coords[setup.contacts.nodes_idx], positions))
    coords = setup.model.nodes.coords
    gaps, _ = limited(setup.marching, coords, reference.system, "", join([kept, setup.connectors]))
    return Bench(setup, reference, gaps, report, chosen=positions is not None)


def _positions(at: ArrayLike) -> FloatArray:
    found = table_of(at, "at")
    if found.ndim != 2 or found.shape[1] != 3 or not np.isfinite(found).all():
        raise InputError(f"at has shape {found.shape}", expected="(k, 3) finite coordinates")
    return found


def _at(coords: FloatArray, positions: FloatArray) -> IntArray:
    """Contact channels whose secondary node, at these coordinates (m, 3), lies at one of the positions."""
    if not positions.size or not coords.size:
        return np.zeros(0, dtype=np.int64)
    away, _ = cKDTree(positions).query(coords)
    found = np.flatnonzero(away < SAME_PLACE * np.ptp(coords)).astype(np.int64)
    if not found.size:
        raise InputError("no contact channel has its secondary node at a position of `at`")
    return found
