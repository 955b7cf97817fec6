"""`creak new`: a first study for a deck, with comments."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

import typer

from creak.cli.details import model_detail, tell_warnings
from creak.cli.output import IGNORE, OUTPUT, Output, writable_file
from creak.errors import InputError
from creak.model.units import UnitsName

if TYPE_CHECKING:
    from creak.cli.output import ProgressBars
    from creak.contact.pair import Keep
    from creak.model.mesh import Model
    from creak.studies.propose.proposal import Proposal


def new(
    deck: Path = typer.Argument(
        ..., metavar="DECK", help="The deck: Abaqus .inp; Nastran .bdf, .dat, .nas, .fem; LS-DYNA .k, .key, .dyn."
    ),
    out: Path | None = typer.Option(None, "--out", help="The study to write; default: beside the deck, ending .toml."),
    distance: float | None = typer.Option(
        None,
        "--distance",
        help="Surfaces nearer than this may touch; default: a hundredth of the model's size, "
        "and up to twice that is asked about.",
    ),
    units: UnitsName | None = typer.Option(
        None, "--units", help="Units of the deck; default: guessed from materials and size."
    ),
    overwrite: bool = typer.Option(False, "--overwrite", help="Write over a study that is there."),
    ignore: list[str] = IGNORE,
    output: Output = OUTPUT,
) -> None:
    """Look at a deck and write a study for it: contacts, supports, excitation, outputs, each with a comment.

    Beside it the schema for editors, clearances that the deck gives by node, and a picture of each contact that is
    doubtful: too far, overlapping, or on an unsure side. The study asks about these in comments. What the deck has no
    names for is named there, or left to be filled in.

    Example: creak new car.inp --out car.toml --distance 5
    """
    from creak.formats.decks import read_model
    from creak.studies.file.schema import SCHEMA_FILE
    from creak.studies.propose.proposal import propose, with_files
    from creak.studies.propose.text import proposal_text
    from creak.studies.solved import keep_here

    path = _study_path(deck, out, overwrite)
    if distance is not None and not 0.0 < distance < float("inf"):
        raise InputError(f"--distance {distance:g}", expected="a length greater than zero")
    with output:
        with output.progress as progress:
            with progress.phase("read the deck"):
                model = read_model(deck)
            _study_path(deck, out, overwrite)  # once more: what has been read meanwhile stays
            model_detail(output, model)
            keep = keep_here()
            found = with_files(propose(model, distance, units, progress, keep), path.stem)
            relative = Path(os.path.relpath(deck, path.parent)).as_posix()
            beside = [*_tables(found, model, path), *_pictures(found, model, path, progress)]
            _write(path, proposal_text(found, model, relative, deck.stem))
            with progress.phase("check the study"):
                missing, warnings = _missing(path, ignore, model, keep)
                undriven = f"no excitation: {found.undriven}" if found.undriven else ""
                missing = ". ".join(filter(None, (found.untouched, missing or undriven)))
            if missing:
                _write(path, proposal_text(found, model, relative, deck.stem, " ".join(missing.split())))
            output.wrote(path, path.with_name(SCHEMA_FILE), *beside)
        _tell(output, found, path, missing)
        warnings = [*found.beams, *found.flaws, *warnings]
        tell_warnings(output, warnings, set())
        output.result(
            {
                **_data(found),
                "warnings": [str(w) for w in warnings],
                "study": str(path),
                "ready": not missing,
                "to_fill_in": missing or None,
                "written": [str(p) for p in output.written],
            }
        )


def _study_path(deck: Path, out: Path | None, overwrite: bool) -> Path:
    from creak.formats.deck.command_files import replace_foreign, will_read
    from creak.studies.file.schema import SCHEMA_FILE

    path = out if out is not None else deck.with_suffix(".toml")
    if path.suffix.lower() != ".toml":
        raise InputError(f"--out {path}", expected="a file name that ends in .toml")
    replace_foreign("--overwrite", overwrite)
    will_read(deck)
    if path.exists() and not overwrite:
        raise InputError(f"{path} is there already", fix="Name another file with --out, or add --overwrite.")
    writable_file(path, stream=False)
    writable_file(path.with_name(SCHEMA_FILE), stream=False)
    return path


def _write(path: Path, text: str) -> None:
    """The study, and the schema beside it."""
    from creak.formats.complete_file import write_text
    from creak.studies.file.schema import SCHEMA_FILE, schema_text

    path.parent.mkdir(parents=True, exist_ok=True)
    for file, content in ((path, text), (path.with_name(SCHEMA_FILE), schema_text())):
        write_text(file, content)


def _tables(found: Proposal, model: Model, path: Path) -> list[Path]:
    """Clearances by node, a table beside the study of each contact that names one."""
    from creak.formats.complete_file import write_text

    written = []
    for c in found.contacts:
        if isinstance(c.clearance, Mapping):
            rows = (f"{model.nodes.label(row)},{gap!r}" for row, gap in c.clearance.items())
            written.append(path.with_name(c.table))
            write_text(written[-1], "\n".join(["node,clearance", *rows]) + "\n")
    return written


def _pictures(found: Proposal, model: Model, path: Path, progress: ProgressBars) -> list[Path]:
    """A picture beside the study of each question that names one."""
    asked = [c for c in found.contacts if c.picture]
    if not asked:
        return []
    import numpy as np

    from creak.formats.complete_file import files_together
    from creak.report.figures.question import question_picture

    with progress.phase("draw the questions"), files_together() as together:
        for c in asked:
            png = question_picture(model, c.parts, c.nodes, np.array(c.at), np.array(c.toward), c.gap)
            with together.file(path.with_name(c.picture)) as file:
                file.write_bytes(png)
        together.appear()
    return [path.with_name(c.picture) for c in asked]


def _missing(path: Path, ignore: list[str], model: Model, keep: Keep) -> tuple[str, list[str]]:
    """What keeps the study from running, empty if nothing does; and what it is warned of."""
    from creak.studies.file.reader import read_study
    from creak.studies.prepare.setup import set_up
    from creak.studies.warned import warnings_of

    try:
        setup = set_up(read_study(path), ignore, model=model, keep=keep)
    except InputError as error:
        return str(error), []
    return "", warnings_of(setup.notes)


def _tell(output: Output, found: Proposal, path: Path, missing: str) -> None:
    unit = found.units.words[0]
    output.say(f"units: {found.units.name} ({found.guess})")
    for c in found.contacts:
        by = ", a pair of the deck" if c.deck else ""
        state = f"left out, because {c.problem}" if c.problem else f"{c.channels} channels"
        if c.question:
            state = f"asked in the study ({c.question})" + (f", see {c.picture}" if c.picture else "")
        output.say(f"contact {c.name}: {c.secondary} - {c.main}, {c.how_far(unit)} at node {c.place}, {state}{by}")
    for said in found.apart:
        output.say(said)
    for joint in found.joints:
        output.say(f"joined by the deck: {joint}")
    for stop in found.stops:
        output.say(f"connector {stop.name}: {stop.first.size} gap(s) of the deck")
    if not found.contacts and not found.stops:
        near = "" if found.closest is None else "; nearest: {} and {}, {:.3g} {}".format(*found.closest, unit)
        output.say(f"no contact: no surfaces within {found.distance:.3g} {unit}{near}")
    output.say(f"supports: {found.n_held} held nodes")
    d = found.drive
    output.say("excitation: to be filled in" if d is None else f"excitation: {d.kind} of {d.node_set} along {d.dof}")
    output.tell_written()
    if missing:
        output.say(f"to be filled in before it runs: {missing}")
    else:
        output.say("a first look comes next; the same without --quick gives the checked answer")
        output.command(f"next: creak run {quote(str(path))} --quick")


def _data(found: Proposal) -> dict[str, Any]:
    from creak.studies.prepare.deck_step import connector_table

    return {
        "units": found.units.name,
        "units_guess": found.guess,
        "distance": found.distance,
        "contacts": [asdict(c) for c in found.contacts],
        "connectors": [connector_table(stop) for stop in found.stops],
        "kept_apart": list(found.apart),
        "joints": list(found.joints),
        "held": found.held,
        "held_nodes": found.n_held,
        "excitation": None if found.drive is None else asdict(found.drive),
        "no_excitation": found.undriven or None,
        "pairs": found.pairs,
        "outputs": list(found.outputs),
    }
