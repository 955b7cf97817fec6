"""The `creak` command."""

from __future__ import annotations

import errno
import os
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

import typer

from creak.api.extras import REPORT, no_report_text
from creak.cli import (
    advise,
    compare,
    convert,
    example,
    info,
    listen,
    modes,
    new,
    reduce,
    report,
    robust,
    run,
    schema,
    screen,
    sweep,
    thesis,
    update,
)
from creak.cli.console import Terminal, drop
from creak.cli.joined import command
from creak.cli.output import Interrupted
from creak.errors import CreakError, InputError, Unreliable, WriteError, shortened
from creak.formats.deck.command_files import one_command
from creak.studies.unraised import none_ignored
from creak.version import version

DONE, FAILED, WRONG_INPUT = 0, 1, 2
OF_THE_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EBADF)
OF_A_NAME = (errno.ENAMETOOLONG, errno.ELOOP, errno.ENOTDIR, errno.EISDIR, errno.EACCES, errno.EPERM, errno.EROFS)
"""What the system says of a path that was given."""
NO_ROOM = ("cannot allocate memory", "failed to map segment")
"""What the loader says of a library that memory does not hold."""
CTRL_C = 130
"""What Typer returns for it where no command has a word to say."""

app = typer.Typer(
    name="creak",
    help="Squeak and rattle: where, when and how hard two parts touch.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
COMMANDS: dict[Callable[..., None], str] = {
    new.new: "Write a first study for a deck, with comments.",
    run.run: "Run a study, or a deck by its own step.",
    report.report: "Write report.html from the results of an earlier run.",
    listen.listen: "Write the sound of an earlier run as WAV files.",
    compare.compare: "Put two results side by side.",
    robust.robust: "How likely it rattles when gaps, friction and loads scatter.",
    advise.advise: "Propose settings for a study, with errors and costs.",
    screen.screen: "Rank gaps by margin and in-plane motion, from modes alone.",
    reduce.reduce: "Make and save the superelements of a study.",
    sweep.sweep: "Run many cases of a study.",
    info.info: "Tell what a deck holds.",
    modes.modes: "Natural frequencies and mode shapes of a deck.",
    update.update: "Bring the modes of a study to those of a test.",
    convert.convert: "Write a deck as another deck or as matrices; motion for ParaView.",
    schema.schema: "JSON schema of the study file, for editors.",
    thesis.thesis: "Run the studies of a thesis on a car door.",
}
for call, words in COMMANDS.items():
    app.command(call.__name__, short_help=words)(command(call))
app.add_typer(example.app, name="example")


def _version(shown: bool) -> None:
    if shown:
        typer.echo(f"creak {version()}")
        raise typer.Exit


@app.callback()
def _root(
    version: bool = typer.Option(False, "--version", callback=_version, is_eager=True, help="Print the version."),
) -> None:
    pass


def main() -> NoReturn:
    """Run the command line; wrong input ends with status 2, a failed analysis with 1, one message each."""
    _open_streams()
    try:
        _run()
    except BrokenPipeError:
        drop(sys.stdout)
        sys.exit(FAILED)
    except OSError as error:
        if error.errno == errno.ENOMEM:
            _end(f"the analysis failed: {_out_of_memory(error)}")
        if error.errno in OF_A_NAME and error.filename:
            _end(f"cannot use {shortened(str(error.filename))}: {str(error.strerror).lower()}", WRONG_INPUT)
        if error.errno not in OF_THE_DISK:
            raise
        drop(sys.stdout)
        what = error.filename or "the output"
        _end(f"cannot write {what}: {str(error.strerror).lower()}")
    sys.exit(DONE)


def _run() -> None:
    try:
        with none_ignored(), one_command():
            if app(prog_name="creak", standalone_mode=False) == CTRL_C:
                raise Interrupted("nothing was written")
        sys.stdout.flush()
    except InputError as error:
        _end(str(error), WRONG_INPUT)
    except Interrupted as stop:
        _end(f"stopped; {stop}")
    except Unreliable as error:
        _end(f"error: unreliable: {error}")
    except WriteError as error:
        _end(str(error))
    except CreakError as error:
        _end(f"the analysis failed: {error}")
    except KeyboardInterrupt:
        _end("stopped; nothing was written")
    except MemoryError as error:
        _end(f"the analysis failed: {_out_of_memory(error)}")
    except ImportError as error:
        if any(words in str(error).lower() for words in NO_ROOM):
            _end(f"the analysis failed: out of memory ({error})")
        if not isinstance(error, ModuleNotFoundError) or error.name not in REPORT:
            raise
        _end(no_report_text(), WRONG_INPUT)
    except OSError:
        raise
    except Exception as error:
        if type(error).__name__ == "NoArgsIsHelpError":
            typer.echo(str(error))
            sys.exit(WRONG_INPUT)
        if type(error).__name__ == "Abort":  # Ctrl-C, as older versions of Typer tell it
            _end("stopped; nothing was written")
        if hasattr(error, "format_message"):  # a usage error of the command line itself
            said = error.format_message().replace("Value error, ", "").rstrip(".") + "."
            context = getattr(error, "ctx", None)
            _end(f"{said} Try: {'creak' if context is None else context.command_path} --help", WRONG_INPUT)
        raise


def _open_streams() -> None:
    """What is closed becomes the null device: else the next file that is opened takes its number, and the words."""
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free
        if getattr(sys, name) is None:
            setattr(sys, name, open(number, mode, encoding="utf-8", closefd=False))  # noqa: SIM115 -- as long as the program


def _end(words: str, status: int = FAILED) -> NoReturn:
    Terminal(stderr=True, soft_wrap=True).print(f"creak: {words}", style="red")
    sys.exit(status)


def _out_of_memory(error: MemoryError | OSError) -> str:
    """What was to be held, and where."""
    own = [
        f for f in traceback.extract_tb(error.__traceback__) if {"creak", "creak_thesis"} & {*Path(f.filename).parts}
    ]
    at = f" in {Path(own[-1].filename).stem}, {own[-1].name}" if own else ""
    what = f" ({str(error)[:1].lower()}{str(error)[1:]}{at})" if str(error) else at
    return f"out of memory{what}; fewer contact channels, output instants, modes or nodes take less"


if __name__ == "__main__":
    main()
