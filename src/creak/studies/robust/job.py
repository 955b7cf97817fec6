"""All draws of a study: marched, or taken from the file of those that were finished before."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.contact.gap_operator import GapOperator, join
from creak.digest import digest
from creak.formats.stored.record_log import log_path, read_records, record_log
from creak.model.mesh import Nodes
from creak.model.units import UNITS, UnitsName
from creak.progress import Progress, silent
from creak.studies.design.clips import clips_of
from creak.studies.file.changes import with_changes
from creak.studies.file.paths import store_of
from creak.studies.file.places import Places
from creak.studies.file.reader import Study
from creak.studies.file.scatter_tables import SIGMAS, Distribution, read_tolerances, table_of
from creak.studies.models.saved import Store
from creak.studies.prepare.setup import Setup, set_up
from creak.studies.prepare.tolerances import Points, no_row, points_of, rows_hit, spread
from creak.studies.prepare.varied import at_nearest_wall
from creak.studies.robust.band import with_band_of_run
from creak.studies.robust.batches import batches, march_batches
from creak.studies.robust.changes import check_ends, damped_by_modes, keeps_model
from creak.studies.robust.draws import ContactGaps, Design, Draw, Drawn, make_causes, whole_power
from creak.studies.robust.further import Further, further_draws, keep, kept, told_of
from creak.studies.robust.shared_model import (
    FIGURES,
    FORETOLD,
    SharedModel,
    foretold,
    march_draws,
    parts_of,
    places_of,
    record_width,
    shared_model,
)
from creak.studies.solved import opened
from creak.studies.tasks.queue import Runner
from creak.studies.warned import Warned, add_warnings
from creak.version import edition

LOG = "draws"
"""Stem of the file of finished draws."""


@dataclass(frozen=True)
class Draws:
    """What all draws came to."""

    setup: Setup
    design: Design
    channels: GapOperator
    """All of the study: contacts, then connectors, as the study has them."""
    drawn: Drawn
    """What each cause is in them."""
    state: FloatArray
    """(total,) 0, or one of `FAILED`, `LEFT_OUT`, `CREATED` and `FORETOLD` of `shared_model`."""
    figures: FloatArray
    """(total, n_place, 5) `FIGURES`"""
    slack: FloatArray
    """(total, n_place, n_factor)"""
    impulse: FloatArray
    """(total, n_channel)"""
    further: Further | None
    """Draws that were not marched, and that count in the odds; None: there are none."""
    taken: int
    """Draws that were there from before."""
    reduced_again: tuple[str, ...]
    """Keys that need a model of their own for each draw."""
    notes: tuple[str, ...]

    @property
    def marched(self) -> int:
        """Draws that had to be marched."""
        return int(np.count_nonzero(self.state != FORETOLD))

    @property
    def places(self) -> tuple[str, ...]:
        return places_of(self.channels)


def run_draws(
    study: Study,
    n: int,
    progress: Progress,
    out: Path | None = None,
    *,
    indices: bool = True,
    threads: int | None = None,
    runner: Runner | None = None,
) -> Draws:
    """Draw and march; with `out`, each finished draw is kept there and never marched again.

    Parameters
    ----------
    n : draws behind probabilities, made a power of two; indices take half as many more for each cause.
    threads : of this process. runner : marches batches of draws elsewhere instead; its workers see `out`.

    Raises
    ------
    InputError : anything wrong in the study, the deck or [scatter].
    """
    progress("read the model and find the contacts", 0, 1)
    setup = set_up(study)
    progress("read the model and find the contacts", 1, 1)
    channels = join([setup.contacts, setup.connectors])
    design, again = _design(study, setup, n, indices=indices)
    drawn = Drawn.at(design.causes, design.points())
    check_ends(setup, drawn)
    places, width = places_of(channels), record_width(channels)
    made_from = _made_from(setup, design)
    path = None if out is None else log_path(out, LOG, made_from, width)
    found, used = read_records(path, made_from, width) if path is not None else ({}, 0)
    taken = sum(k < design.total for k in found)
    notes = list[str]()
    beyond = None if again else further_draws(design, drawn, channels, partial(check_ends, setup))
    further = None if beyond is None or out is None else kept(out, made_from, len(places), design, beyond[1])
    wanted = {*range(design.total), *_further_numbers(further, design)}
    marched: Iterator[tuple[int, FloatArray]] = iter(())
    store = Store(store_of(setup.study.path)) if out is None else Store(out / "superelements", "all")
    with opened(store.folder if store.keep == "all" else None):
        if not wanted <= found.keys():
            setup, said = with_band_of_run(setup, progress, store)
            notes += said
        if again and not wanted <= found.keys():
            missing = wanted - found.keys()
            models = _models(setup.study, [drawn.draw(k) for k in range(design.total)], missing, again)
            who = f"{' and '.join(again)} change{'s' if len(again) == 1 else ''}"
            anew = f"it is set up {len(models)} times for these draws, and the parts that change are reduced as often"
            notes.append(Warned(f"{who} the model: {anew}"))
            progress(f"{len(models)} models, as {who} it", 0, 1)
            marched = _on_models_of_their_own(models, channels, setup.raised, threads, runner, store, notes)
        elif not wanted <= found.keys():
            every, more = beyond or (drawn, None)
            made = shared_model(setup, drawn, progress, store, every)
            notes.extend(made.notes)
            if more is not None and further is None:
                further = told_of(made, channels, design, more)
                wanted.update(_further_numbers(further, design))
                if further is not None and out is not None:
                    keep(further, out, made_from)
            missing = wanted - found.keys()

            def march(left: list[Draw]) -> Iterator[tuple[int, FloatArray]]:
                if runner is None:
                    return _marched(made, channels, left, threads)
                return (
                    march_batches(runner, batches(setup.study, setup.raised, left, made.lowest, store), notes)
                    if left
                    else iter(())
                )

            marched = _on_one_model(made, every, design.total, missing, channels, march, progress)
        if path is None:
            found.update(marched)
        elif not wanted <= found.keys():
            with record_log(path, made_from, width, used) as log:
                for number, record in marched:
                    log.add(number, record)
                    found[number] = record
                    progress("draws", len(found), len(wanted))
    if further is not None:
        rows = np.array([found[k] for k in _further_numbers(further, design)]).reshape(-1, width)
        state, figures, _, _ = parts_of(rows, channels)
        further = replace(further, events=figures[:, :, FIGURES.index("events")], state=state)
    parts = parts_of(np.stack([found[k] for k in range(design.total)]), channels)
    return Draws(setup, design, channels, drawn, *parts, further, taken, again, (*setup.notes, *notes))


def _design(study: Study, setup: Setup, n: int, *, indices: bool) -> tuple[Design, tuple[str, ...]]:
    """What is drawn of a study, and the keys that need a model of their own for each draw."""
    config, clips = study.config, clips_of(study.touching)
    data = config.model_dump(mode="json", by_alias=True)
    data["clip"] = [clip.model_dump(mode="json") for clip in clips]
    fields = fields_of(setup.contacts, setup.model.nodes)
    given, points = tomllib.loads(study.text), points_of(setup.watch.lines.points, setup.model)
    deviations = deviations_of(points, config.scatter.vary, study.places, config.model.units)
    causes = make_causes(config.scatter, data, given, fields, study.places, deviations)
    modal = damped_by_modes(setup.structure, config.damping.modal)
    again = tuple(c.key for c in causes if not keeps_model(clips, c.key, modal=modal))
    return Design(causes, whole_power(n), indices, config.scatter.seed), again


def _made_from(setup: Setup, design: Design) -> dict[str, Any]:
    """What draws are made from: neither comments nor title, nor the probability that is aimed at."""
    study = setup.study
    told = study.config.model_dump_json(by_alias=True, exclude={"title": True, "scatter": {"target"}})
    return {
        "creak": edition(),
        "study": digest(told),
        "deck": setup.digests[0],
        "files": setup.digests[1],
        "design": [design.n, design.indices, design.seed],
    }


def _further_numbers(further: Further | None, design: Design) -> list[int]:
    """Numbers of the further draws that are marched."""
    return [] if further is None else [design.total + k for k in further.rows.tolist()]


def _on_one_model(
    made: SharedModel,
    drawn: Drawn,
    total: int,
    missing: Set[int],
    channels: GapOperator,
    march: Callable[[list[Draw]], Iterator[tuple[int, FloatArray]]],
    progress: Progress,
) -> Iterator[tuple[int, FloatArray]]:
    """Number and record of each missing draw; those that need no march first."""
    known = set[int]()
    for number, record in foretold(made, channels, total):
        known.add(number)
        if number in missing:
            yield number, record
    left = [drawn.draw(k) for k in sorted(missing - known)]
    if made.plain is not None:
        progress(f"{len(left)} of {len(missing)} draws come near enough to be marched", 0, 1)
    yield from march(left)


def _on_models_of_their_own(
    models: Sequence[_Model],
    channels: GapOperator,
    raised: int,
    threads: int | None,
    runner: Runner | None,
    store: Store,
    notes: list[str],
) -> Iterator[tuple[int, FloatArray]]:
    """The same of draws whose numbers change the model; raised: how often f_max is. Warnings join the notes.

    Each takes the superelements of parts that its numbers do not change from those before it: the last ones stay, in
    a folder of their own where none are kept.
    """
    last = replace(store, keep="last") if store.keep == "all" else store
    if runner is not None:
        every = [batch for one in models for batch in batches(one.study, raised, one.left, one.draws, last)]
        yield from march_batches(runner, every, notes)
        return
    with TemporaryDirectory() as scratch:
        if last.folder is None or not last.folder.is_dir():
            last = Store(Path(scratch), "last")
        for one in models:
            setup = replace(set_up(one.study), raised=raised)
            made = shared_model(setup, one.draws, silent, last)
            add_warnings(notes, made.notes)
            yield from _marched(made, channels, one.left, threads)


def _marched(
    model: SharedModel, channels: GapOperator, draws: Sequence[Draw], threads: int | None
) -> Iterator[tuple[int, FloatArray]]:
    for number, seen in march_draws(model, channels, draws, threads):
        yield number, seen.record()


@dataclass(frozen=True)
class _Model:
    """Draws that share a model."""

    study: Study
    draws: list[Draw]
    """All of them: the model is the one that all need, missing or not."""
    left: list[Draw]
    """Those that are still to be marched."""


def _models(study: Study, draws: Sequence[Draw], missing: Set[int], again: Sequence[str]) -> list[_Model]:
    """The models on which missing draws are marched: one for each set of the values of keys that change it."""
    groups: dict[tuple[Any, ...], list[Draw]] = {}
    for draw in draws:
        groups.setdefault(tuple(draw.values[key] for key in again), []).append(draw)
    models = []
    for own, group in groups.items():
        every = [replace(d, values={k: v for k, v in d.values.items() if k not in again}) for d in group]
        left = [d for d in every if d.number in missing]
        if left:
            models.append(_Model(with_changes(study, dict(zip(again, own, strict=True))), every, left))
    return models


def fields_of(contacts: GapOperator, nodes: Nodes) -> dict[str, ContactGaps]:
    """Contact -> its channels."""
    group, nearest, found = np.array(contacts.group, dtype=object), at_nearest_wall(contacts, nodes), {}
    for name in dict.fromkeys(contacts.group):
        own = np.flatnonzero(group == name)
        names = tuple(contacts.names[k] for k in own.tolist())
        found[name] = ContactGaps(names, nodes.coords[contacts.nodes_idx[own]], contacts.gap0[own], nearest[own])
    return found


def deviations_of(
    points: Points, vary: Mapping[str, Distribution], places: Places, units: UnitsName
) -> dict[str, FloatArray]:
    """Key of a field whose tolerances a table has -> standard deviation (m,) of the gaps of its contact.

    Raises
    ------
    InputError : a table that cannot be used (`studies.prepare.tolerances`).
    """
    found = {}
    for key, of in vary.items():
        table, name = table_of(of.tolerance), key.split(".")[1:2]
        own = points.of(name)
        if table is None or not own.any():
            continue
        where = places.where("scatter", "vary", key)
        rows = read_tolerances(places.sibling(table.file), where, table.columns, units)
        at = spread(rows_hit(rows, points, name, UNITS[units].length), points, name)[own]
        if at.min() < 0:
            raise no_row(table.file, points, name[0], where)
        found[key] = np.array([row.below for row in rows])[at] / SIGMAS
    return found
