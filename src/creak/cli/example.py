"""`creak example`: decks to start from."""

from __future__ import annotations

from pathlib import Path
from shlex import quote

import typer

app = typer.Typer(help="Write an example deck and study.", no_args_is_help=True)


@app.callback()
def _group() -> None:
    pass


@app.command("door")
def door(
    mesh_size: float = typer.Option(20.0, "--mesh-size", help="Element size, mm (2 to 40)."),
    coarsen: int = typer.Option(
        1, "--coarsen", help="Elements of the frame's flange merged into one along the contact line: 1, 2 or 3."
    ),
    load: str = typer.Option("A3", "--load", help="A1 (no contact), A2, A3 or A4 (most contact)."),
    hook_play: float | None = typer.Option(
        None, "--hook-play", help="Play of the panel's hooks to either side, mm; without it they are rigid."
    ),
    out: Path = typer.Option(Path("door"), "--out", help="Folder to write door.inp and door.toml into."),
) -> None:
    """Write the parametric car door: door.inp (Abaqus syntax) and door.toml.

    Example: creak example door --mesh-size 20 --out door
    """
    from creak.cli.output import writable_file, writable_folder
    from creak_thesis.door import write_door

    writable_folder(out)
    for name in ("door.inp", "door.toml"):
        writable_file(out / name, stream=False)
    for path in write_door(mesh_size, out, coarsen, load, hook_play):
        typer.echo(f"wrote {path}")
    typer.echo(f"next: creak run {quote(str(out / 'door.toml'))}")


@app.command("cockpit")
def cockpit(
    mesh_size: float = typer.Option(10.0, "--mesh-size", help="Element size, mm (20 to 4)."),
    load: float = typer.Option(1.0, "--load", help="Factor on the road's acceleration."),
    seed: int = typer.Option(1, "--seed", help="Of the road's random phases."),
    out: Path = typer.Option(Path("cockpit"), "--out", help="Folder to write cockpit.inp and the study into."),
) -> None:
    """Write a piece of a cockpit on a rough road: several places that rattle or squeak, to be ranked.

    Example: creak example cockpit --out cockpit
    """
    from creak.cli.output import writable_file, writable_folder
    from creak_thesis.cockpit import FILES, write_cockpit

    writable_folder(out)
    for name in FILES:
        writable_file(out / name, stream=False)
    for path in write_cockpit(mesh_size, out, load, seed):
        typer.echo(f"wrote {path}")
    typer.echo(f"next: creak run {quote(str(out / 'cockpit.toml'))}")
