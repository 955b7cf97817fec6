"""`creak convert`: a deck of one program as a deck of another, or as matrices; motion and histories of a run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from creak.cli.details import model_detail, tell_vain
from creak.cli.output import OUTPUT, Output
from creak.errors import InputError, suggest
from creak.formats.endings import WRITTEN, is_nastran

if TYPE_CHECKING:
    from creak.model.mesh import Model

MATRICES = {"npz": "npz", "mtx": "matrix-market", "op4": "op4", "dmig": "dmig"}
"""What --matrices takes -> name of the format."""
RESULTS = (".h5", ".hdf5")
OF_RESULTS = (".pvd", ".vtu", ".unv", ".uff", ".pch", ".csv")
"""What results are written to."""


def convert(
    deck: Path = typer.Argument(
        ...,
        metavar="IN",
        help="The deck: Abaqus .inp; Nastran .bdf, .dat, .nas, .fem; LS-DYNA .k, .key, .dyn; or results.h5 of a run.",
    ),
    out: Path = typer.Argument(
        ...,
        metavar="OUT",
        help="The deck to write, .inp, .bdf, .dat, .nas; or the matrices; of results .pvd, .vtu, .unv, .pch, .csv.",
    ),
    matrices: str | None = typer.Option(None, "--matrices", help="Write K, M and C instead: npz, mtx, op4 or dmig."),
    mass: str | None = typer.Option(
        None, "--mass", help="consistent, linear or lumped: the mass of elements, instead of what IN asks for."
    ),
    ignore: list[str] = typer.Option([], "--ignore", metavar="KEYWORD", help="Keyword of IN that may get lost."),
    run: str | None = typer.Option(
        None, "--run", help="Of results: reduced or reference; default: the reduced one, of motion the one that has it."
    ),
    output: Output = OUTPUT,
) -> None:
    """Write the model of a deck as another deck, or its stiffness, mass and damping as held by its supports.

    What the new deck cannot say is named and nothing is written. Loads, contact and steps are not carried over.

    Abaqus decks take consistent mass, Nastran decks linear or lumped mass.

    Of results it writes the motion of all nodes for ParaView, around the hardest event or as [output] field_interval
    says: OUT.pvd with the times, and a folder of that name with a VTU for each instant. Of any results it writes the
    histories of watched nodes and gap channels: OUT.csv with all of them, OUT.unv (data set 58) and OUT.pch (Nastran
    punch) with displacements and normal forces, and the relative motion at E-lines; and OUT.vtu, E-lines and places as
    points with their figures.

    Example: creak convert plate.bdf plate.inp --mass consistent

    Example: creak convert results/results.h5 motion.pvd

    Example: creak convert results/results.h5 histories.unv
    """
    from creak.cli.output import writable_file
    from creak.formats.deck.catalogue import stop_on_unread
    from creak.formats.deck.command_files import will_read
    from creak.formats.deck.stops import left_to_a_study
    from creak.formats.decks import read_model

    of_run = deck.suffix.lower() in RESULTS
    _check_results(of_run, out, run, [matrices, mass, *ignore])
    if not of_run:
        _check(out, matrices, mass)
    will_read(deck)
    writable_file(out, stream=matrices is None and out.suffix.lower() != ".pvd")
    if of_run:
        write = {".pvd": _write_motion, ".vtu": _write_points}.get(out.suffix.lower(), _write_histories)
        write(deck, out, run, output)
        return
    with output:
        with output.progress as progress:
            with progress.phase(f"read {deck.name}"):
                model = left_to_a_study(read_model(deck))
            model = model if mass is None else replace(model, mass_form=mass)
            model_detail(output, model)
            out.parent.mkdir(parents=True, exist_ok=True)
            notes: tuple[str, ...] = ()
            if matrices is None:
                with progress.phase(f"write {out.name}"):
                    notes = _write(model, out, ignore)
                output.wrote(out)
            else:
                stop_on_unread(model, ignore)
                with progress.phase(f"assemble and write {matrices}"):
                    written, notes = _write_matrices(model, out, MATRICES[matrices])
                output.wrote(*written)
        tell_vain(output, model, ignore)
        left = [u for u in model.unread if not u.used]
        for u in left:
            output.say(f"not carried over: {u.keyword} ({u.where}): {u.why}")
        for note in notes:
            output.say(f"note: {note}")
        output.tell_written()
        output.result(
            {
                "deck": str(deck),
                "written": [str(path) for path in output.written],
                "not_carried_over": [{"keyword": u.keyword, "where": u.where, "why": u.why} for u in left],
                "notes": list(notes),
            }
        )


def _check_results(of_run: bool, out: Path, run: str | None, others: list[str | None]) -> None:
    """Results go with files of their own and --run, and with nothing else."""
    if of_run and out.suffix.lower() not in OF_RESULTS:
        raise InputError(
            f"cannot write results to {out}",
            expected=".pvd (motion) or .vtu (lines, places) for ParaView, .unv, .pch or .csv (histories)",
        )
    if not of_run and out.suffix.lower() in (".pvd", ".vtu"):
        raise InputError(f"a {out.suffix} holds what a run found", expected="results.h5 as IN")
    if out.suffix.lower() == ".vtu" and run is not None:
        raise InputError(f"--run {run} with {out.name}", expected="none: lines and places are those of the main run")
    if of_run and any(others):
        raise InputError("--matrices, --mass and --ignore are for decks", expected="none of them with results")
    if not of_run and run is not None:
        raise InputError(f"--run {run} with a deck", expected="results.h5 as IN")


def _write_motion(results: Path, out: Path, run: str | None, words: Output) -> None:
    """The motion of a run as a series for ParaView."""
    from creak.formats.measured.motion_series import motion_field, write_series

    with words as output:
        with output.progress as progress:
            field = motion_field(results, run)
            folder = write_series(field, out, lambda done, total: progress(f"write {out.name}", done, total))
            output.wrote(out)
        output.tell_written()
        output.say(f"{field.time.size} instants of the {field.run} run in {folder}")
        output.result({"run": field.run, "instants": field.time.size, "written": [str(out)], "folder": str(folder)})


def _write_points(results: Path, out: Path, run: str | None, words: Output) -> None:
    """E-lines and places as points for ParaView."""
    from creak.formats.vtu import write_points
    from creak.report.found_points import found_points
    from creak.studies.findings.stored import read_findings

    with words as output:
        with output.progress as progress, progress.phase(f"write {out.name}"):
            found, _ = read_findings(results.parent, lambda _: None)
            xyz, arrays = found_points(found)
            write_points(out, xyz, arrays)
            output.wrote(out)
        output.tell_written()
        names = [] if found.elines is None else [line.name for line in found.elines.lines]
        told = ", ".join(f"{k} {name}" for k, name in enumerate(names)) or "none"
        output.say(f"{len(xyz)} points with {len(arrays)} figures each; places: {len(found.places)}; elines: {told}")
        output.result({"points": len(xyz), "figures": list(arrays), "elines": names, "written": [str(out)]})


def _write_histories(results: Path, out: Path, run: str | None, words: Output) -> None:
    """Watched nodes, E-lines and gap channels of a run over time."""
    from creak.formats.measured.histories import read_histories, write_csv, write_punch, write_universal

    with words as output:
        with output.progress as progress:
            histories = read_histories(results, run)
            with progress.phase(f"write {out.name}"):
                write = {".csv": write_csv, ".pch": write_punch}.get(out.suffix.lower(), write_universal)
                write(histories, out)
            output.wrote(out)
        output.tell_written()
        nodes, channels, times = len(histories.node_names), len(histories.channels), histories.time.size
        points = 0 if histories.elines is None or out.suffix.lower() == ".csv" else len(histories.elines.names)
        lines = f", {points} points of E-lines" if points else ""
        output.say(f"{nodes} nodes{lines} and {channels} channels of the {histories.run} run at {times} times")
        for what in histories.renumbered if out.suffix.lower() == ".pch" else ():
            output.say(f"note: several {what} are at one node; they are numbered 1, 2, ..., and $LABEL names each")
        output.result(
            {
                "run": histories.run,
                "nodes": nodes,
                "eline_points": points,
                "channels": channels,
                "times": times,
                "written": [str(out)],
            }
        )


def _check(out: Path, matrices: str | None, mass: str | None) -> None:
    if matrices is not None and matrices not in MATRICES:
        raise InputError(f"--matrices {matrices}", expected=", ".join(MATRICES), fix=suggest(matrices, MATRICES))
    if mass not in (None, "consistent", "linear", "lumped"):
        raise InputError(f"--mass {mass}", expected="consistent, linear or lumped")
    if matrices is None and out.suffix.lower() not in WRITTEN:
        raise InputError(
            f"cannot write a deck that ends in {out.suffix!r}",
            expected=", ".join(WRITTEN),
            where=out,
            fix="Write an Abaqus deck (.inp) or a Nastran deck (.bdf), or give --matrices.",
        )


def _write(model: Model, out: Path, ignore: list[str]) -> tuple[str, ...]:
    """A deck by its ending; returns what is called otherwise in it, or lost."""
    from creak.formats.abaqus.writer import write_deck
    from creak.formats.deck.catalogue import stop_on_unread
    from creak.formats.nastran.writer import write_nastran

    if is_nastran(out):
        stop_on_unread(model, ignore)
        return write_nastran(model, out)
    return write_deck(model, out, ignore)


def _write_matrices(model: Model, out: Path, name: str) -> tuple[list[Path], tuple[str, ...]]:
    """K, M and C of the whole, parts joined and supports held, to files named after `out`; and notes."""
    from creak.formats.matrices.superelements import FORMATS
    from creak.studies.models.deck_modes import deck_matrices

    ending = FORMATS[name].ending
    path = out if ending and out.suffix.lower() == ending else out.with_suffix(ending)
    found, note = deck_matrices(model)
    return FORMATS[name].write(found, path), (note,) if note else ()
