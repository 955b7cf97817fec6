"""docs/commands.md from the command line itself: `python -m tools.commands_page`."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer

from creak.cli.main import app

PAGE = Path(__file__).parents[1] / "docs" / "commands.md"
HEAD = """\
# The command line

Made from the program by `python -m tools.commands_page`. `creak COMMAND --help` says the same.

From a deck to a report:

    creak info model.inp                  # what is in it, what was not read, does it float, which units
    creak new model.inp --out study.toml  # a first study: contacts, supports, excitation, outputs, with comments
    creak advise study.toml               # which f_max, step and stiffness, at which error and cost
    creak run study.toml --out results    # reduced and unreduced run, summary.json, results.h5, report.html

## What all of them share

| option | does |
|---|---|
| `--quiet`, `-q` | no progress, no tables, no list of files; warnings and errors stay |
| `--verbose`, `-v` | also the seconds of each phase, sizes, and choices that were made |
| `--json` | the result on stdout as one JSON object, and nothing else there |

`creak schema`, `creak thesis` and `creak example` have fewer of them.

Progress, details, warnings and errors go to stderr, results to stdout. On a terminal every phase has a bar with the
time left. Elsewhere a phase gets a line once it has taken 2 s, then every 10 s and when it ends. Where stdout or stderr
is closed, only what would stand there is lost.

| exit status | meaning |
|---|---|
| 0 | done; warnings may have been printed |
| 1 | failed analysis, unreliable results, no memory, a file that cannot be written, Ctrl-C; what was done is named |
| 2 | wrong input: one message that says what, where, and what to do; nothing was written |

**Inputs** are plain files. A pipe, `<(...)`, a device or a socket is refused at once.

**Outputs** never replace a file that the command reads, by whatever name or link. Another file is replaced if it is
empty or of the kind that is written, so a command may run again over what it wrote before. Decks, studies, JSON, HDF5,
pages and WAV files must be creak's own for that. VTU files, universal files and matrices look alike whoever wrote them.
All else stays, and the command ends with status 2. `run --force` and `new --overwrite` replace what is not creak's too,
but no input.

A file is replaced when the new one is complete. A link stays, and the file that it leads to is replaced. Pipes and
character devices are written into, where the format is a stream (JSON, CSV, universal files, decks, HTML, VTU).
Folders, sockets and block devices are refused before anything is computed.

**Ctrl-C.** `creak run` ends the run under way and writes what it has. An unreduced run goes on from there when the same
command is called again, and from its last checkpoint after a kill ([how](howto_results.md#a-run-that-was-stopped)).
`creak reduce` saves the parts that are reduced. `creak sweep` and `creak thesis` go on from the finished cases.

**Memory.** A sparse factor that does not fit into the free memory is refused before it is made: status 1, with what it
needs and what there is. Swap and a container's limit count. `CREAK_MEMORY_GB=40` in the environment takes the place of
what the system says is free. This is so on Linux with MKL; elsewhere the system decides.

Large models are looked at as soon as their parts are assembled. creak then takes the first of these ways that fits:

1. A factor of the whole model.
2. Factors of the parts alone. The pre-check then comes from the parts.
3. A part in pieces, of which as many stay factorised as fit. Its superelement is the same.

Where none fits, or where the study needs the whole (`[reference] run`, gap modes, `[[static]]`), the study is refused
with the line to change. `creak advise` tells what each stage takes. Modes that memory does not hold are found window by
window and put into a file in TMPDIR.

**Completion.** `creak --install-completion` adds it to the shell in use (bash, zsh, fish, PowerShell); open a new shell
afterwards. `creak --show-completion` prints it instead.

**Warnings.** They stand in `summary.json` too, as `warnings`, a list of sentences. `creak run` warns of what can hardly
be meant:

- size, thickness, mass, first frequency, clearances or vibration that do not fit the units (metres taken for
  millimetres, kg for t), and materials of no solid;
- contact that starts closed, with the depth and the node; a secondary side much coarser than the main one;
- contact that never comes near, with the closest approach;
- a pre-check margin as large as the model;
- forces that the step does not resolve.

A study whose materials are in other units than it says, or in two systems, is an error before anything is assembled.
In red it tells of a study that could not have rattled: it has no contact and no connector, or no gap becomes smaller. A
part that nothing holds is an error in a study and a warning in a deck that is run by itself, with the motions that are
free. `creak info DECK` warns of such parts before there is a study, and of units with `--units mm-t-s`.

**Editors.** `creak schema` prints the JSON schema of the study file. `creak new` writes it beside the study, whose
first line names it (`#:schema ./creak-study.schema.json`): Even Better TOML and taplo then complete and check while you
type.
"""


def page() -> str:
    """The whole page."""
    root: Any = typer.main.get_command(app)
    return "\n".join([HEAD, *_commands(root, "creak")])


def _commands(group: Any, prefix: str) -> Iterator[str]:
    for name, command in group.commands.items():
        if hasattr(command, "commands"):
            yield from _commands(command, f"{prefix} {name}")
        else:
            yield _section(f"{prefix} {name}", command)


def _section(name: str, command: Any) -> str:
    arguments = [p for p in command.params if p.param_type_name == "argument"]
    options = [p for p in command.params if p.param_type_name == "option" and "--help" not in p.opts]
    usage = " ".join([name, *(p.metavar or p.name.upper() for p in arguments), "[OPTIONS]"])
    paragraphs = [" ".join(text.split()) for text in (command.help or "").split("\n\n")]
    text = [f"    {p.removeprefix('Example: ')}" if p.startswith("Example: ") else p for p in paragraphs]
    rows = [f"| `{_cell(p.metavar or p.name.upper())}` | {_cell(p.help)} |" for p in arguments]
    rows += [f"| {_names(p)} | {_cell(p.help)}{_default(p)} |" for p in options]
    return "\n".join([f"## {name}", "", f"`{usage}`", "", "\n\n".join(text), "", "| | |", "|---|---|", *rows, ""])


def _names(option: Any) -> str:
    return ", ".join(f"`{o}`" for o in sorted([*option.opts, *option.secondary_opts], key=len, reverse=True))


def _default(option: Any) -> str:
    if isinstance(option.default, str | int | float | Path) and not isinstance(option.default, bool):
        return f" (default: {option.default})"
    return ""


def _cell(text: str | None) -> str:
    return " ".join((text or "").split()).replace("|", "\\|").replace("*", "\\*")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    sys.stdout.write(f"wrote {PAGE}\n")
