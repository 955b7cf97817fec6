"""`creak modes`: natural frequencies of a deck."""

from __future__ import annotations

import json
from pathlib import Path

import typer
from rich.console import Console
from rich.table import Table

from creak.errors import InputError

DEFAULT_COUNT = 20


def modes(
    deck: Path = typer.Argument(..., metavar="DECK", help="The deck."),
    f_max: float | None = typer.Option(None, "--f-max", help="All modes up to this frequency, Hz."),
    count: int | None = typer.Option(None, "--count", help=f"The lowest modes; default {DEFAULT_COUNT}."),
    json_file: Path | None = typer.Option(None, "--json", help="Write frequencies, mass and rigid modes here."),
) -> None:
    """Natural frequencies of the linear structure, contact left out."""
    from creak.cli.output import writable_folder
    from creak.formats.complete_file import complete_file
    from creak.studies.deck_modes import deck_modes

    if f_max is not None and count is not None:
        raise InputError("both --f-max and --count", expected="one of them")
    if (f_max is not None and not f_max > 0.0) or (count is not None and count < 1):
        raise InputError(f"--f-max {f_max}, --count {count}", expected="a positive number")
    if json_file is not None:
        writable_folder(json_file.parent)
    if f_max is None and count is None:
        count = DEFAULT_COUNT
    found = deck_modes(deck, f_max=f_max, count=count)
    table = Table("mode", "Hz")
    for i, f in enumerate(found.frequencies, start=1):
        table.add_row(f"{i}", f"{f:.6g}")
    console = Console()
    console.print(table)
    console.print(f"mass {found.mass:.6g}, {found.rigid} rigid-body mode(s), largest residual {found.residual:.1e}, "
                  f"Sturm count {'agrees' if found.sturm_ok else 'DOES NOT AGREE'}")  # fmt: skip
    if json_file is not None:
        data = {"frequencies": found.frequencies, "mass": found.mass, "rigid": found.rigid}
        json_file.parent.mkdir(parents=True, exist_ok=True)
        with complete_file(json_file) as partial:
            partial.write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
