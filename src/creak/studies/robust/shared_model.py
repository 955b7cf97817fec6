"""A reduced model on which many draws of a study are marched."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator, join
from creak.dynamics.chunks import march_chunks
from creak.dynamics.flow.batch import Variant, march_many
from creak.dynamics.flow.march import SAMPLES, FlowRun
from creak.dynamics.history import History, Stopped
from creak.dynamics.record.recorder import OutputRequest
from creak.errors import InputError, NumericalError
from creak.progress import Progress, silent
from creak.studies.converge.repeats import not_looked_at
from creak.studies.file.changes import with_changes
from creak.studies.models.of_parts import reference_that_fits
from creak.studies.models.reduced import reduce_model
from creak.studies.models.reference import ReferenceModel
from creak.studies.models.saved import NO_STORE, Store
from creak.studies.prepare.setup import Setup
from creak.studies.prepare.varied import changed_gaps
from creak.studies.prepare.watched import doubtful_channels, silent_channels
from creak.studies.robust.changes import at_start, with_damping
from creak.studies.robust.draws import Draw, Drawn
from creak.studies.robust.linear import (
    FACTORS,
    Linear,
    Plain,
    closes,
    dropped_of,
    linear_of,
    multiple,
    own_linear,
    plain_of,
    pressed,
)
from creak.studies.run.integrate import flowing
from creak.studies.run.precheck import WITHOUT_WHOLE, with_linear_gaps
from creak.studies.run.static_start import started
from creak.studies.unraised import none_ignored
from creak.studies.warned import Warned
from creak.verify.events import counted_instants, events_in, find_events
from creak.verify.reliability import reasons_against

FIGURES = ("events", "impulse", "force", "speed", "before")
"""Of each place in a draw: number, sum, largest low-passed force of the place, largest closing speed in the window;
number of events that end before it."""
FAILED = 1.0
LEFT_OUT = 2.0
"""A channel that the pre-check dropped closed."""
FORETOLD = 3.0
"""Nothing touches for sure: it was not marched."""
CREATED = 4.0
"""Its march created energy, by which a run counts as unreliable (`verify.reliability`)."""
NOTHING = np.zeros(0, dtype=np.int64)
TRIED = 8
"""Draws of the load whose linear runs the pre-check looks at, and the one of least damping."""


@dataclass(frozen=True)
class Seen:
    """What is kept of a draw."""

    state: float
    """0, `FAILED`, `LEFT_OUT` or `CREATED`; of a draw that was not marched `FORETOLD`."""
    figures: FloatArray
    """(n_place, 5) `FIGURES`"""
    slack: FloatArray
    """(n_place, n_factor) smallest gap of a place without contact, the load times each of `FACTORS`; not a number where
    channels press from the start."""
    impulse: FloatArray
    """(n_channel,) in the window, of all channels of the study."""

    def record(self) -> FloatArray:
        """All of it in a row."""
        return np.concatenate([[self.state], self.figures.ravel(), self.slack.ravel(), self.impulse])


def record_width(channels: GapOperator) -> int:
    """Numbers of a record of a study with these channels."""
    return 1 + len(places_of(channels)) * (len(FIGURES) + len(FACTORS)) + channels.m


def parts_of(records: FloatArray, channels: GapOperator) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """State (k,), figures (k, n_place, 5), slack (k, n_place, n_factor) and impulse (k, n_channel) of `Seen` of several
    draws, from their records (k, width)."""
    k, n = len(records), len(places_of(channels))
    state, figures, slack, impulse = np.split(records, np.cumsum([1, len(FIGURES) * n, len(FACTORS) * n]), axis=1)
    return state[:, 0], figures.reshape(k, n, len(FIGURES)), slack.reshape(k, n, len(FACTORS)), impulse


@dataclass(frozen=True)
class SharedModel:
    """The model of a study, reduced once."""

    setup: Setup
    """Before its static start."""
    reference: ReferenceModel
    gaps: GapOperator
    """Channels that are kept, at rest in the study's own state."""
    system: System
    base: FlowRun
    silent: FlowRun
    """The same without contact."""
    window: tuple[float, float]
    linear: Linear
    """In the study's own load."""
    notes: tuple[str, ...]
    lowest: FloatArray
    """(m,) what it was made for: `lowest_of` its draws."""
    plain: Plain | None = None
    """What its draws have in common, where it was made for `Drawn` that have it."""


def lowest_of(setup: Setup, reference: ReferenceModel, draws: Sequence[Draw] | Plain) -> FloatArray:
    """(m,) how far the gap of each contact channel falls below that of the study in any draw, 0 or less.

    Parameters
    ----------
    setup : before its static start. reference : with the linear gaps after it.
    """
    linear = reference.linear_gaps
    if isinstance(draws, Plain):
        return draws.lowest(linear)
    lowest = np.zeros(setup.contacts.m)
    loaded = any(not key.startswith(("contact.", "connector.", "clip.")) for d in draws for key in d.values)
    least = min(range(len(draws)), key=lambda k: draws[k].values.get("damping.modal", np.inf), default=0)
    for k, draw in enumerate(draws):
        of_gaps = {key: x for key, x in draw.values.items() if key.startswith(("contact.", "static."))}
        if draw.fields or of_gaps:
            now = with_changes(setup.study, of_gaps).touching
            gap0 = changed_gaps(setup.contacts, setup.model.nodes, setup.study.touching, now, draw.fields)
            lowest = np.minimum(lowest, gap0 - setup.contacts.gap0)
        if loaded and (k < TRIED or k == least) and linear is not None:
            other = at_start(setup, reference, draw)
            of = other.study.config.precheck, other.reduction, other.marching
            gaps = with_linear_gaps(*of, reference, silent).linear_gaps
            lowest = lowest if gaps is None else np.minimum(lowest, gaps - linear)
    return lowest


@none_ignored()
def shared_model(
    setup: Setup,
    draws: FloatArray | Sequence[Draw] | Drawn,
    progress: Progress,
    store: Store = NO_STORE,
    further: Drawn | None = None,
) -> SharedModel:
    """The model of a study with the channels that its draws need, and the arrays that they share.

    Parameters
    ----------
    draws : all of them, or (m,) `lowest_of` them.
    store : of superelements, beside which what was solved is kept.
    further : `draws` and, behind them, more that are foretold alone; they count where all of them are `Plain`.

    Raises
    ------
    InputError : a study whose reduced model is not marched by exact flow. NumericalError : the reduction failed.
    """
    c = setup.study.config
    if not c.time.exact or c.reduction.method == "none":
        raise InputError(
            "draws are marched by exact flow on the reduced model",
            where=setup.study.places.where("time" if not c.time.exact else "reduction"),
            expected="[time] without step, integrator, alpha or substeps, and a [reduction] method",
            fix="Leave them out.",
        )
    reference = reference_that_fits(setup.reduction, setup.unproven.takes_whole, progress, store.folder)
    before, setup = setup, started(setup, reference, progress)
    reference = with_linear_gaps(c.precheck, setup.reduction, setup.marching, reference, progress)
    plain = plain_of(partial(at_start, before, reference), further or draws) if isinstance(draws, Drawn) else None
    if isinstance(draws, Drawn):
        draws = [draws.draw(k) for k in range(draws.total)] if plain is None else []
    lowest = draws if isinstance(draws, np.ndarray) else lowest_of(before, reference, plain or draws)
    kept, notes = setup.contacts, [] if reference.of_parts is None else [WITHOUT_WHOLE]
    if reference.linear_gaps is not None:
        enough = c.precheck.near(setup.contacts.gap0 + lowest)
        left = reference.linear_gaps + lowest
        can_close = np.flatnonzero(left <= enough)
        # Where nothing comes near, the closest channel tells how much more load it would take.
        watched = can_close if can_close.size or setup.connectors.presses else np.argsort(left)[:1]
        kept = setup.contacts.select(watched)
        notes.append(f"pre-check: {can_close.size} of {setup.contacts.m} channels can close in some draw")
    gaps = join([kept, setup.connectors])
    if not gaps.presses:
        raise NumericalError("no contact and no connector of the study presses: there is nothing to rattle")
    reduced = reduce_model(setup.reduction, reference, gaps, progress, store)
    system, why_not = flowing(reduced.system)
    if system is None:
        raise NumericalError(f"the reduced model cannot be marched by exact flow{why_not}")
    resolution, every = setup.marching.resolution, setup.loads.n_step // SAMPLES
    dropped = silent_channels(setup.contacts, gaps)
    base = FlowRun(system, gaps, setup.loads, OutputRequest(NOTHING, every, watched=dropped), resolution)
    window = setup.marching.window
    unhindered = partial(FlowRun, system, gaps.without_force(), setup.loads, resolution=resolution, solver=base.solver)
    linear = own_linear(system, gaps, dropped.silent, setup.loads, window)
    silent = unhindered(OutputRequest(NOTHING, every))
    notes = [*reduced.notes, *map(Warned, not_looked_at(setup.reduction.table, reduced)), *notes]
    return SharedModel(
        setup=before,
        reference=reference,
        gaps=gaps,
        system=system,
        base=base,
        silent=silent,
        window=window,
        linear=linear,
        notes=tuple(notes),
        lowest=lowest,
        plain=plain,
    )


def foretold(model: SharedModel, channels: GapOperator, total: int) -> Iterator[tuple[int, FloatArray]]:
    """Number and record of each of `total` draws in which nothing touches for sure: it moves as without contact.

    Parameters
    ----------
    channels : as for `march_draws`.
    """
    places = places_of(channels)
    figures, impulse = np.zeros((len(places), len(FIGURES))), np.zeros(channels.m)
    for first, clear, slack in without_contact(model, channels, 0, total):
        for k in np.flatnonzero(clear).tolist():
            yield first + k, Seen(FORETOLD, figures, slack[k], impulse).record()


def without_contact(
    model: SharedModel, channels: GapOperator, first: int, last: int | None
) -> Iterator[tuple[int, BoolArray, FloatArray]]:
    """Draws of `model.plain` from `first` to before `last`, some at a time: the number of the first, whether nothing
    touches in them for sure (n,), and what is left of their gaps without contact, (n, n_place, n_factor).

    Nothing where draws have too little in common, or press from the start.
    """
    plain, at = model.plain, _kept(model, channels)
    if plain is None or pressed(model.gaps) or (plain.load is not None and model.system.velocity.any()):
        return
    of_places, can_press = [model.gaps.of_groups({name}) for name in places_of(channels)], model.gaps.can_press()
    for rows in plain.blocks(first, last):
        gap0, factors = plain.gaps(rows)[:, at], plain.factors(rows)
        clear = model.linear.clear_of(gap0, factors) & (gap0[:, can_press] >= 0.0).all(axis=1)
        yield rows.start, clear, model.linear.slack(gap0, factors, of_places)


def march_draws(
    model: SharedModel, channels: GapOperator, draws: Iterable[Draw], threads: int | None = None
) -> Iterator[tuple[int, Seen]]:
    """Number of a draw and what was seen in it, in the order in which they end.

    A draw in which nothing touched needs no run without contact to tell its slack.

    Parameters
    ----------
    channels : all of the study, kept or not: what figures and impulses stand for.
    """
    places, at = places_of(channels), _kept(model, channels)
    v = model.setup.study.config.verification

    def look(variant: Variant, history: History | Stopped) -> Seen:
        figures, impulse = np.zeros((len(places), len(FIGURES))), np.zeros(channels.m)
        if isinstance(history, Stopped):
            nothing = [np.full(shape, np.nan) for shape in (figures.shape, (len(places), len(FACTORS)), impulse.shape)]
            return Seen(FAILED, *nothing)
        every = find_events(history, variant.gaps, v.merge, v.f_max)
        events = events_in(every, model.window)
        for event in events:
            own = figures[places.index(event.group)]
            own[:2] += 1.0, event.impulse
            own[2:4] = max(own[2], event.force_place), max(own[3], event.closing_speed)
        for event in every:
            figures[places.index(event.group), 4] += event.t_end < model.window[0]
        inside = counted_instants(history.time, events, model.window)
        impulse[at] = history.weights[inside] @ history.force[inside]
        closed = closes(dropped_of(history, model.linear.dropped[0])) or _rung_shut(model, variant, history)
        state = LEFT_OUT if closed else CREATED if reasons_against(history) else 0.0
        known = _foretold(model, variant)
        if known is None and not history.force.any():
            known = _linear(model, variant, history)
        return Seen(state, figures, _slack(model, variant, places, known), impulse)

    return march_many(model.base, (variant_of(model, draw) for draw in draws), look, threads)


def _rung_shut(model: SharedModel, variant: Variant, history: History) -> bool:
    """Does a dropped channel close that contact may have rung shut between two steps? The draw is marched with it."""
    seen = history.extremes
    if seen is None or not seen.doubtful.size:
        return False
    dropped = doubtful_channels(model.setup.contacts, seen)
    dropped = replace(dropped, gap0=model.linear.dropped[0][seen.doubtful])
    gaps, asked = join([variant.gaps, dropped]), OutputRequest(NOTHING, model.base.n_step)
    system, resolution = variant.system or model.system, model.setup.marching.resolution
    try:
        again = march_chunks(FlowRun(system, gaps, variant.loads, asked, resolution, model.base.solver), None)
    except Stopped:
        return True
    return bool(again.force[:, variant.gaps.m : gaps.m].any())


def places_of(channels: GapOperator) -> tuple[str, ...]:
    """Contacts and connectors."""
    return tuple(dict.fromkeys(channels.group))


def _kept(model: SharedModel, channels: GapOperator) -> IntArray:
    """Rows of the model's channels among all of the study: by name, or in turn where a place has other nodes there.

    Raises
    ------
    InputError : a place with another number of channels than in the study.
    """
    place = {name: k for k, name in enumerate(channels.names)}
    own = join([model.setup.contacts, model.setup.connectors])
    for group in places_of(own):
        rows, every = np.flatnonzero(channels.of_groups({group})), np.flatnonzero(own.of_groups({group})).tolist()
        names = [own.names[k] for k in every]
        if place.keys() >= {*names}:
            continue
        if len(names) != rows.size:
            raise InputError(
                f"{group} has {len(names)} channels in some draws and {rows.size} in the study",
                where=model.setup.study.places.where("scatter"),
                expected="draws that leave the number of channels as it is: figures are told of each",
            )
        place.update(zip(names, rows.tolist(), strict=True))
    return np.array([place[name] for name in model.gaps.names])


def _slack(model: SharedModel, variant: Variant, places: tuple[str, ...], known: Linear | None) -> FloatArray:
    gaps = variant.gaps
    if pressed(gaps):
        return np.full((len(places), len(FACTORS)), np.nan)
    if known is None:
        alone = model.silent.again(gaps.without_force(), variant.loads, variant.system)
        known = _linear(model, variant, march_chunks(alone, None))
    return known.slack(gaps.gap0[None], np.ones(1), [gaps.of_groups({place}) for place in places])[0]


def _linear(model: SharedModel, variant: Variant, history: History) -> Linear:
    """That of a draw whose history has no contact."""
    return linear_of(history, variant.gaps, model.window, model.linear.dropped[0])


def _foretold(model: SharedModel, variant: Variant) -> Linear | None:
    """The run without contact where it follows from that of the study: the same loads, or from rest a multiple."""
    if variant.system is not None:
        return None
    if variant.loads is model.base.loads:
        return model.linear
    factor = None if model.system.velocity.any() else multiple(variant.loads, model.base.loads)
    return None if factor is None else model.linear.times(factor)


def variant_of(model: SharedModel, draw: Draw) -> Variant:
    """Channels, loads and, where its damping is another, the System of a draw."""
    setup = at_start(model.setup, model.reference, draw)
    place = {name: k for k, name in enumerate(setup.contacts.names)}
    kept = [place[name] for name in model.gaps.names if name in place]
    gaps = join([setup.contacts.select(np.array(kept, dtype=np.int64)), setup.connectors])
    zeta, before = setup.study.config.damping.modal, model.setup.study.config.damping.modal
    system = None
    if zeta != before:
        assert zeta is not None
        assert before
        system = with_damping(model.system, zeta, before)
    return Variant(draw.number, gaps, setup.loads, system)
