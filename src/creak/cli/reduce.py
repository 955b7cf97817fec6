"""`creak reduce`: the superelements of a study, saved for reuse."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from creak.cli.cluster import (
    Distribution,
    check_cluster,
    check_method,
    distribution_of,
    workers_of,
)
from creak.cli.details import setup_detail, tell_notes, tell_warnings
from creak.cli.joined import joined
from creak.cli.output import IGNORE, OUTPUT, Output, writable_file, writable_folder
from creak.cli.run import changed_study
from creak.errors import CreakError, InputError, NumericalError, suggest

if TYPE_CHECKING:
    from creak.model.mesh import Model
    from creak.reduction.health import Health
    from creak.studies.file.config import ReductionTable
    from creak.studies.models.part_jobs import PartJob
    from creak.studies.models.reduced import ReducedModel
    from creak.studies.models.superelements import Reduced
    from creak.studies.prepare.setup import Setup


def reduce(
    study_file: Path = typer.Argument(..., metavar="STUDY.toml", help="The study whose parts to reduce."),
    out: Path | None = typer.Option(
        None, "--out", help="Folder for the superelements; default: superelements/ beside the study, where run looks."
    ),
    changes: list[str] = typer.Option(
        [],
        "--set",
        metavar="KEY=VALUE",
        help="Reduce the study with another value, as contact.flange.clearance=2.5: runs with larger clearances take "
        "the superelements too. Repeatable.",
    ),
    export: list[str] = typer.Option(
        [], "--export", help="Also write them as op4, dmig, abaqus, matrix-market or npz, into the same folder."
    ),
    where: Distribution = joined(distribution_of),
    ignore: list[str] = IGNORE,
    output: Output = OUTPUT,
) -> None:
    """Reduce the parts of a study and save them; parts that did not change since the last time are kept.

    Each part is saved as soon as it is reduced: after Ctrl-C, a kill or a part that cannot be reduced, the same
    command goes on from there. Workers, here or on a cluster, save into the same folder.

    Example: creak reduce door/door.toml --export op4
    """
    from creak.studies.file.paths import store_of
    from creak.studies.prepare.setup import set_up

    _check_formats(export)
    study = changed_study(study_file, changes)
    check_method(study.config.reduction.method, study.places)
    folder = out if out is not None else store_of(study.path)
    writable_folder(folder)
    told: set[str] = set()
    with output:
        check_cluster(where, output)
        with output.progress as progress:
            with progress.phase("read the model and find the contacts"):
                setup = set_up(study, ignore, folder)
            _check_outputs(setup.model, setup.reduction.table, folder, export)
            setup_detail(output, setup)
            tell_warnings(output, setup.notes, told)
            model, checks, notes = _reduced(setup, folder, output, where, tuple(ignore))
            _export(setup.model, model, folder, export, output)
        tell_notes(output, [*setup.notes, *notes, *model.notes], told)
        for r in model.superelements:
            stats, before = r.system.stats, ", taken from before" if r.reused else ""
            size = f"{stats.retained:,.0f} retained dofs + {stats.modes:,.0f} modes"
            output.detail(f"{r.system.name}: {size}{before}")
        _tell_health(output, checks)
        output.tell_written()
        output.result(_data(model, checks, [*setup.notes, *notes, *model.notes], output))


def _check_formats(export: Sequence[str]) -> None:
    from creak.formats.matrices.superelements import FORMATS

    unknown = [e for e in export if e not in FORMATS]
    if unknown:
        expected, fix = ", ".join(FORMATS), suggest(unknown[0], FORMATS)
        raise InputError(f"unknown format {unknown[0]!r}", expected=expected, fix=fix)


def _check_outputs(model: Model, table: ReductionTable, folder: Path, export: Sequence[str]) -> None:
    """Raise InputError for a file that has to stay where one of a part is to be written, before anything is reduced."""
    from creak.formats.matrices.superelements import files_of
    from creak.studies.models.saved import part_path

    stays = {name.upper() for name in table.unreduced}
    for name in ({p.name for p in model.parts} | {n.upper() for n in table.substructures}) - stays:
        writable_file(part_path(folder, name), stream=False, kept=True)
        for form in export:
            for file in files_of(name, form):
                writable_file(folder / file, stream=False)


def _reduced(
    setup: Setup, folder: Path, output: Output, where: Distribution, ignore: tuple[str, ...]
) -> tuple[ReducedModel, dict[str, Health], list[str]]:
    """The superelements, their health, and notes.

    Each is checked and saved as soon as it is made: what stops the command later does not cost it.
    """
    from creak.studies.models.health import check
    from creak.studies.models.part_jobs import part_jobs
    from creak.studies.models.reduced import reduce_model
    from creak.studies.models.saved import Store, is_saved
    from creak.studies.models.superelements import save_superelement, with_modes_of_file
    from creak.studies.run.precheck import ready

    checks: dict[str, Health] = {}

    def made(reduced: Reduced) -> Reduced:
        name, about = reduced.system.name, dict[str, Any](deck=str(setup.model.source))
        try:
            if name not in checks:
                output.progress(f"{name}: check", 0, 1)
                checks[name] = check(reduced, setup.model.nodes, setup.band.excited)
                output.progress(f"{name}: check", 1, 1)
            about["health"] = checks[name].as_dict()
        finally:
            path = None
            if not (reduced.reused and is_saved(folder, name, reduced.made_from)):
                path = save_superelement(folder, reduced, setup.model, about)
            if path is not None:
                output.wrote(path)
        return reduced if path is None else with_modes_of_file(setup.band, reduced, path)

    setup, reference, gaps, notes = ready(setup.unproven, output.progress)
    try:
        fresh = set[str]()
        if where.workers is not None or where.scheduler is not None:
            jobs = part_jobs(setup.reduction, reference, gaps, Store(folder, study=setup.study, ignore=ignore))
            found = _elsewhere(jobs, output, where)
            fresh, checks = set(found), checks | found
        reduced = reduce_model(setup.reduction, reference, gaps, output.progress, Store(folder), made)
        return _told(reduced, fresh), checks, notes
    except CreakError:
        if checks:
            output.warn(f"saved: {', '.join(checks)}. The same command goes on from there")
        raise


def _told(model: ReducedModel, fresh: set[str]) -> ReducedModel:
    """The model, whose parts that workers have just saved do not count as taken from before."""
    parts = tuple(replace(r, reused=r.reused and r.system.name not in fresh) for r in model.superelements)
    taken = tuple(f"superelement {name}: taken from" for name in fresh)
    return replace(model, superelements=parts, notes=[n for n in model.notes if not n.startswith(taken)])


def _elsewhere(jobs: Sequence[PartJob], output: Output, where: Distribution) -> dict[str, Health]:
    """The health of the parts that workers reduced and saved.

    Raises
    ------
    NumericalError : a part could not be reduced; the others are saved.
    """
    from creak.studies.models.part_jobs import ended

    if not jobs:
        return {}
    checks: dict[str, Health] = {}
    failed: dict[str, str] = {}
    with workers_of(where, min(where.workers or 1, len(jobs))) as runner:
        for name, saved in ended(runner, jobs, output.progress):
            if saved.error:
                failed[name] = saved.error
            tell_notes(output, saved.notes, set())
            if saved.health is not None:
                checks[name] = saved.health
            if saved.path is not None:
                output.wrote(saved.path)
    if failed:
        if checks:
            output.warn(f"saved: {', '.join(checks)}. The same command goes on from there")
        lines = [f"  {name}: {error}" for name, error in failed.items()]
        raise NumericalError("\n".join([f"{len(failed)} of {len(jobs)} parts could not be reduced", *lines]))
    return checks


def _export(deck: Model, model: ReducedModel, folder: Path, export: Sequence[str], output: Output) -> None:
    from creak.formats.matrices.superelements import write_superelement
    from creak.studies.models.deck_modes import named_rows

    for reduced in model.superelements:
        given = named_rows(reduced.system, reduced.system.name, deck)
        for form in export:
            output.wrote(*write_superelement(given, folder, form))


def _tell_health(output: Output, checks: Mapping[str, Health]) -> None:
    from creak.reduction.health import health_rows

    for name, health in checks.items():
        output.table(name, [["", "value", "remark"], *health_rows(health)], left=(0, 1, 2))


def _data(model: ReducedModel, checks: Mapping[str, Health], notes: Sequence[str], output: Output) -> dict[str, Any]:
    from creak.studies.warned import warnings_of

    parts = {
        r.system.name: {
            "retained": r.system.stats.retained,
            "modes": r.system.stats.modes,
            "reused": r.reused,
            "health": checks[r.system.name].as_dict(),
        }
        for r in model.superelements
    }
    return {
        "superelements": parts,
        "wall_s": model.wall_s,
        "cpu_s": model.cpu_s,
        "notes": [str(n) for n in notes],
        "warnings": warnings_of(notes),
        "written": [str(path) for path in output.written],
    }
