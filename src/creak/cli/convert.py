"""`creak convert`: a deck of one program as a deck of another, or as matrices."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from rich.console import Console

from creak.errors import InputError, suggest

if TYPE_CHECKING:
    from creak.model.mesh import Model

MATRICES = {"npz": "npz", "mtx": "matrix-market", "op4": "op4", "dmig": "dmig"}
"""What --matrices takes -> name of the format."""
DECK_ENDINGS = (".inp",)


def convert(
    deck: Path = typer.Argument(..., metavar="IN", help="The deck: Abaqus .inp; Nastran .bdf, .dat, .nas."),
    out: Path = typer.Argument(..., metavar="OUT", help="The Abaqus deck to write, .inp; or the file of the matrices."),
    matrices: str | None = typer.Option(None, "--matrices", help="Write K, M and C instead: npz, mtx, op4 or dmig."),
    mass: str | None = typer.Option(
        None, "--mass", help="consistent, linear or lumped: the mass of elements, instead of what IN asks for."
    ),
    ignore: list[str] = typer.Option([], "--ignore", help="Keyword of IN that may get lost."),
) -> None:
    """Write the model of a deck as another deck, or its stiffness, mass and damping as held by its supports.

    What the new deck cannot say is named and nothing is written. Loads, contact and steps are not carried over.

    Example: creak convert plate.bdf plate.inp --mass consistent
    """
    from creak.cli.output import writable_folder
    from creak.formats.abaqus.writer import stop_on_unread, write_deck
    from creak.studies.setup import read_model

    _check(deck, out, matrices, mass)
    writable_folder(out.parent)
    model = read_model(deck)
    model = model if mass is None else replace(model, mass_form=mass)
    out.parent.mkdir(parents=True, exist_ok=True)
    if matrices is None:
        write_deck(model, out, ignore)
        written = [out]
    else:
        stop_on_unread(model, ignore)
        written = _write_matrices(model, out, MATRICES[matrices])
    console = Console()
    for u in model.unread:
        console.print(f"not carried over: {u.keyword} ({u.where}): {u.why}", markup=False, soft_wrap=True)
    for path in written:
        console.print(f"wrote {path}", markup=False, soft_wrap=True)


def _check(deck: Path, out: Path, matrices: str | None, mass: str | None) -> None:
    if matrices is not None and matrices not in MATRICES:
        raise InputError(f"--matrices {matrices}", expected=", ".join(MATRICES), fix=suggest(matrices, MATRICES))
    if mass not in (None, "consistent", "linear", "lumped"):
        raise InputError(f"--mass {mass}", expected="consistent, linear or lumped")
    if matrices is None and out.suffix.lower() not in DECK_ENDINGS:
        raise InputError(
            f"cannot write a deck that ends in {out.suffix!r}", expected=", ".join(DECK_ENDINGS), where=out,
            fix="Write an Abaqus deck (.inp), or give --matrices.",
        )  # fmt: skip
    if out.exists() and deck.exists() and out.samefile(deck):
        raise InputError("IN and OUT are the same file", where=out, fix="Give OUT another name.")


def _write_matrices(model: Model, out: Path, name: str) -> list[Path]:
    """K, M and C of the whole, parts joined and supports held, to files named after `out`."""
    from creak.formats.matrices.superelements import FORMATS
    from creak.studies.deck_matrices import deck_matrices

    ending = FORMATS[name].ending
    path = out if ending and out.suffix.lower() == ending else out.with_suffix(ending)
    return FORMATS[name].write(deck_matrices(model), path)
