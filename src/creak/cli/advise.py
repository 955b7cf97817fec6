"""`creak advise`: settings for a study, with their errors and costs, before it is run."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from rich.console import Console
from rich.table import Table

from creak.cli.output import ProgressBars
from creak.errors import InputError

if TYPE_CHECKING:
    from creak.studies.advise import Advice
    from creak.studies.advise_contact import StepAdvice
    from creak.studies.advise_facts import Facts, Option


def advise(
    study_file: Path = typer.Argument(..., metavar="STUDY.toml", help="The study to look at."),
    out: Path | None = typer.Option(None, "--json", help="Also write everything to this file."),
    quiet: bool = typer.Option(False, "--quiet", help="No progress; the lines of the study file to change alone."),
    ignore: list[str] = typer.Option([], "--ignore", help="Keyword of the deck that may go unread."),
) -> None:
    """Propose retained dofs, f_max, time step and contact stiffness for a study, with estimated error and cost.

    Nothing is reduced or run but the linear pre-check. Errors are those measured on other structures
    (docs/guidelines.md); times are measured here on the model itself, good to a factor of two.
    """
    from creak.studies.advise import advise as look
    from creak.studies.advise import as_dict
    from creak.studies.setup import set_up
    from creak.studies.study_file import read_study

    if study_file.suffix.lower() in (".inp", ".bdf", ".dat", ".nas"):
        raise InputError(f"{study_file.name} is a deck", expected="a study file (.toml)",
                         fix="Write a study that names the deck in [model].")  # fmt: skip
    if out is not None:
        _writable(out)
    setup = set_up(read_study(study_file), ignore)
    with ProgressBars(quiet) as progress:
        advice = look(setup, progress)
    console = Console(highlight=False)
    if not quiet:
        _draw(console, advice)
        for note in setup.notes:
            console.print(f"note: {note}", markup=False)
    for text in advice.choice.warnings:
        console.print(f"warning: {text}", markup=False, style="yellow")
    console.print(_lines(advice), markup=False, soft_wrap=True)
    if out is not None:
        out.write_text(json.dumps(as_dict(advice), indent=1, allow_nan=False), encoding="utf-8")
        console.print(f"wrote {out}", markup=False, soft_wrap=True)


def _writable(path: Path) -> None:
    """Raise InputError where a file cannot be written, before any work is done."""
    if path.is_dir():
        raise InputError(f"cannot write to {path}: it is a folder", fix="Name a file with --json.")
    if not path.parent.is_dir() or not os.access(path if path.exists() else path.parent, os.W_OK):
        raise InputError(f"cannot write to {path}", expected="a file in a folder that exists and can be written",
                         fix="Name another one with --json.")  # fmt: skip


def _lines(advice: Advice) -> str:
    if not advice.choice.changes:
        return "the study file can stay as it is"
    return "lines of the study file to change:\n\n" + advice.toml


def _draw(console: Console, advice: Advice) -> None:
    facts, choice = advice.facts, advice.choice
    console.print(_head(facts), markup=False)
    console.print(_table("Parts with Craig-Bampton: retained dofs and modes below f_max", _part_rows(facts)))
    options = [OPTION_HEAD, *(_option_row(o, o is choice.option) for o in facts.options)]
    console.print(_table("Ways to reduce (* advised)", options))
    console.print(
        "Frequency, force, impulse: errors on the door with the same multiple. At most: no mode at the end of the "
        "excitation is further off. Times: measured here, to a factor of two.", markup=False,
    )  # fmt: skip
    console.print(_table("Time step (* advised)", [STEP_HEAD, *(_step_row(s, s is choice.step) for s in facts.steps)]))
    for text in choice.because:
        console.print(f"- {text}", markup=False)


def _head(facts: Facts) -> str:
    c, e = facts.channels, facts.excitation
    kept = f"{c.kept} of {c.contacts} contact channels stay"
    closing = "" if c.closing is None else f", {c.closing} of them close in the linear run"
    more = f", {c.connectors} of connectors" if c.connectors else ""
    return f"excitation to {e.frequency:.4g} Hz ({e.source}); {kept}{closing}{more}; run of {facts.end:.4g} s"


def _part_rows(facts: Facts) -> list[list[str]]:
    reasons = list(dict.fromkeys(r for p in facts.sizes.parts for r in p.retained))
    below = sorted({f for p in facts.sizes.parts for f in p.modes.below})
    head = ["part", "dofs", *reasons, "retained", *(f"{f:.4g} Hz" for f in below)]
    return [head, *(
        [p.name, f"{p.dofs:,}", *(f"{p.retained[r]:,}" if r in p.retained else "-" for r in reasons),
         f"{p.boundary:,}", *(f"{p.modes.below.get(f, 0):,}" for f in below)]
        for p in facts.sizes.parts
    )]  # fmt: skip


OPTION_HEAD = ["", "f_max, Hz", "x exc.", "retained + modes", "unknowns", "offline", "a step", "frequency", "at most",
               "force", "impulse"]  # fmt: skip


def _option_row(o: Option, chosen: bool) -> list[str]:
    from creak.studies.advise_words import duration

    door = ["-", "-", "-"] if o.door is None else [
        _percent(x) for x in (o.door.frequency_error, o.door.force_error, o.door.impulse_error)]  # fmt: skip
    name = f"{'* ' if chosen else ''}{o.method}{'' if o.possible else ' (impossible)'}"
    return [name, f"{o.f_max:g}", f"{o.multiple:.3g}", f"{o.retained:,} + {o.modes:,}", f"{o.unknowns:,}",
            duration(o.offline_s), duration(o.step_s), door[0], _percent(o.bound), door[1], door[2]]  # fmt: skip


STEP_HEAD = ["step, s", "a period", "steps", "period error", "damping", "stiffness", "bounce, s", "in steps",
             "reduced run", "unreduced run", "on the door"]  # fmt: skip


def _step_row(s: StepAdvice, chosen: bool) -> list[str]:
    from creak.studies.advise_words import duration

    b = s.fixed if s.automatic is None else s.automatic
    contact = ["-", "-", "-"]
    if b is not None:
        contact = [f"{b.stiffness:.3g}", f"{b.shortest_s:.2g}", f"{b.shortest_s / s.step:.2g}"]
    return [
        f"{'* ' if chosen else ''}{s.step:g}", f"{s.per_period:.3g}", f"{s.steps:,}", _percent(s.period_error),
        _percent(s.damping), *contact, f"< {duration(s.reduced_s)}", f"< {duration(s.unreduced_s)}", s.hht,
    ]  # fmt: skip


def _percent(x: float) -> str:
    return "exact" if x == 0.0 else f"{100.0 * x:.2g} %"


def _table(title: str, rows: Sequence[Sequence[str]]) -> Table:
    table = Table(title=title, title_justify="left")
    for i, text in enumerate(rows[0]):
        table.add_column(text, justify="left" if i == 0 or text == STEP_HEAD[-1] else "right", no_wrap=i == 0)
    for row in rows[1:]:
        table.add_row(*row)
    return table
