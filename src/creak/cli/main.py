"""The `creak` command."""

from __future__ import annotations

import os
import sys
from typing import NoReturn

import typer
from rich.console import Console

import creak
from creak.cli import advise, convert, example, info, modes, reduce, run, sweep, thesis
from creak.errors import CreakError, InputError

DONE, FAILED, WRONG_INPUT = 0, 1, 2

app = typer.Typer(
    name="creak",
    help="Squeak and rattle: where, when and how hard two parts touch.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
app.command("run")(run.run)
app.command("advise")(advise.advise)
app.command("reduce")(reduce.reduce)
app.command("sweep")(sweep.sweep)
app.command("info")(info.info)
app.command("modes")(modes.modes)
app.command("convert")(convert.convert)
app.command("thesis")(thesis.thesis)
app.add_typer(example.app, name="example")


def _version(shown: bool) -> None:
    if shown:
        typer.echo(f"creak {creak.__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: bool = typer.Option(False, "--version", callback=_version, is_eager=True, help="Print the version."),
) -> None:
    pass


def main() -> NoReturn:
    """Run the command line; wrong input ends with status 2, a failed analysis with 1, one message each."""
    console = Console(stderr=True, highlight=False, soft_wrap=True)
    try:
        app(standalone_mode=False)
    except InputError as error:
        console.print(f"creak: {error}", style="red", markup=False)
        sys.exit(WRONG_INPUT)
    except CreakError as error:
        console.print(f"creak: the analysis failed: {error}", style="red", markup=False)
        sys.exit(FAILED)
    except KeyboardInterrupt:
        console.print("creak: stopped; nothing was written", style="red")
        sys.exit(FAILED)
    except MemoryError:
        console.print("creak: the analysis failed: out of memory; use a coarser mesh or fewer outputs", style="red")
        sys.exit(FAILED)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(FAILED)
    except Exception as error:
        if type(error).__name__ == "NoArgsIsHelpError":
            typer.echo(str(error))
            sys.exit(WRONG_INPUT)
        if hasattr(error, "format_message"):  # a usage error of the command line itself
            console.print(f"creak: {error.format_message()} Try: creak --help", style="red", markup=False)
            sys.exit(WRONG_INPUT)
        raise
    sys.exit(DONE)


if __name__ == "__main__":
    main()
