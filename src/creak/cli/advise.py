"""`creak advise`: settings for a study, with their errors and costs, before it is run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from creak.cli.console import printable
from creak.cli.details import setup_detail, tell_notes, tell_setup
from creak.cli.joined import joined
from creak.cli.output import IGNORE, Output, output_of
from creak.cli.run import changed_study
from creak.errors import InputError
from creak.words import duration, percent

if TYPE_CHECKING:
    from creak.studies.advise.choice import Choice
    from creak.studies.advise.contact import StepAdvice
    from creak.studies.advise.facts import Facts, Option, SoundCost

OPTION_HEAD = [
    *("", "f_max, Hz", "x exc.", "retained + modes", "unknowns", "offline", "a step", "frequency", "at most"),
    *("force", "impulse"),
]
STEP_HEAD = [
    *("step, s", "a period", "steps", "period error", "damping", "stiffness", "bounce, s", "in steps"),
    *("reduced run", "unreduced run", "on the door"),
]


def advise(
    study_file: Path = typer.Argument(..., metavar="STUDY.toml", help="The study to look at."),
    changes: list[str] = typer.Option(
        [],
        "--set",
        metavar="KEY=VALUE",
        help="Look at the study with another value, as reduction.f_max=700; the file stays as it is. Repeatable.",
    ),
    ignore: list[str] = IGNORE,
    band: float | None = typer.Option(
        None, "--band", metavar="HZ", help="Say what it takes that sound is believed up to this frequency."
    ),
    output: Output = joined(
        output_of,
        quiet=typer.Option(False, "--quiet", "-q", help="No progress; the lines of the study to change alone."),
    ),
) -> None:
    """Propose retained dofs, f_max, time step and contact stiffness for a study, with estimated error and cost.

    Nothing is reduced or run but the linear pre-check. Errors are those measured on other structures
    (docs/guidelines.md); times are measured here on the model itself, good to a factor of two; the memory of `creak
    reduce` and `creak run` is told stage by stage, good to a fifth.

    Example: creak advise door/door.toml
    """
    from creak.sound.forced import LOWEST
    from creak.sound.rayleigh import HIGHEST
    from creak.sound.zwicker_tables import RATE
    from creak.studies.advise.choice import Settings, as_dict, choose
    from creak.studies.advise.facts import gather
    from creak.studies.prepare.setup import set_up
    from creak.studies.warned import warnings_of

    if band is not None and not LOWEST < band <= HIGHEST * RATE:
        raise InputError(
            f"a band that ends at {band:g} Hz",
            where="--band",
            expected=f"more than {LOWEST:g}, where hearing begins, up to {HIGHEST * RATE:g} Hz",
        )
    told: set[str] = set()
    with output:
        with output.progress as progress:
            with progress.phase("read the model and find the contacts"):
                setup = set_up(changed_study(study_file, changes), ignore)
            setup_detail(output, setup)
            tell_setup(output, setup.no_contact, setup.notes, told)
            facts, c = gather(setup, progress, band), setup.study.config
            own = Settings(setup.reduction, c.time, c.precheck, c.proof, c.reference.until, c.contact)
            advice = choose(own, facts)
        _draw(output, advice)
        tell_notes(output, setup.notes, told)
        for text in advice.warnings:
            output.warn(text)
        if not output.as_json:
            typer.echo(printable(_lines(advice)))
        output.result(
            {
                **as_dict(advice),
                "warnings": [*filter(None, [setup.no_contact]), *warnings_of(setup.notes), *advice.warnings],
            }
        )


def _lines(advice: Choice) -> str:
    from creak.studies.advise.choice import changes_toml

    if not advice.changes:
        return "the study file can stay as it is"
    return "lines of the study file to change:\n\n" + changes_toml(advice.changes)


def _draw(output: Output, choice: Choice) -> None:
    facts = choice.facts
    c, e = facts.channels, facts.excitation
    kept = f"{c.kept} of {c.contacts} contact channels stay"
    closing = "" if c.closing is None else f", {c.closing} of them close in the linear run"
    more = f", {c.connectors} of connectors" if c.connectors else ""
    output.say(f"excitation to {e.frequency:.4g} Hz ({e.source}); {kept}{closing}{more}; run of {facts.end:.4g} s")
    output.table("Parts with Craig-Bampton: retained dofs and modes below f_max", _part_rows(facts))
    options = [OPTION_HEAD, *(_option_row(o, o is choice.option) for o in facts.options)]
    output.table("Ways to reduce (* advised)", options)
    output.say(
        "Frequency, force, impulse: errors on the door with the same multiple. At most: no mode at the end of the "
        "excitation is further off. Times: measured here, to a factor of two."
    )
    if not choice.exact:
        rows = [STEP_HEAD, *(_step_row(s, s is choice.step) for s in facts.steps)]
        output.table("Time step (* advised)", rows, left=(0, len(STEP_HEAD) - 1))
    whole = "of the study as it is" if facts.unreduced is not None else "with the lines changed as advised"
    output.table(f"Memory {whole} (* peak)", _memory_rows(facts), left=(0, 2))
    if facts.sound is not None:
        output.table(f"Sound to {facts.sound.band:g} Hz", _sound_rows(facts.sound), left=(0, 1))
    for text in choice.because:
        output.say(f"- {text}")


def _part_rows(facts: Facts) -> list[list[str]]:
    reasons = list(dict.fromkeys(r for p in facts.sizes.parts for r in p.retained))
    below = sorted({f for p in facts.sizes.parts for f in p.modes.below})
    head = ["part", "dofs", *reasons, "retained", *(f"{f:.4g} Hz" for f in below)]
    return [
        head,
        *(
            [
                p.name,
                f"{p.dofs:,}",
                *(f"{p.retained[r]:,}" if r in p.retained else "-" for r in reasons),
                f"{p.boundary:,}",
                *(f"{p.modes.below.get(f, 0):,}" for f in below),
            ]
            for p in facts.sizes.parts
        ),
    ]


def _sound_rows(s: SoundCost) -> list[list[str]]:
    o = s.option
    mesh = "short enough" if s.finer <= 1.0 else f"{s.finer:.3g} times shorter, some {s.dof_times:.2g} times the dofs"
    return [
        ["", ""],
        ["[reduction] f_max, twice that", f"{o.f_max:g} Hz"],
        ["retained + modes, unknowns", f"{o.retained:,} + {o.modes:,}, {o.unknowns:,}"],
        ["reduction on this mesh", duration(o.offline_s)],
        ["a flight step", duration(o.step_s)],
        *_beyond_rows(s),
        ["this mesh is believed up to", f"{s.mesh:.4g} Hz"],
        ["elements for that band", mesh],
    ]


def _beyond_rows(s: SoundCost) -> list[list[str]]:
    """What it takes without more modes."""
    if s.beyond is None:
        return []
    cost = f"{s.beyond.frequencies} frequencies, {s.beyond.solves:,.0f} back-substitutions of {s.beyond.share:,.0f}"
    return [
        [f"or, as it is, the unreduced model from {s.modes:.4g} Hz", cost if s.beyond.frequencies else "no damping"]
    ]


def _option_row(o: Option, chosen: bool) -> list[str]:
    door = (
        ["-", "-", "-"]
        if o.door is None
        else [_error(x) for x in (o.door.frequency_error, o.door.force_error, o.door.impulse_error)]
    )
    name = f"{'* ' if chosen else ''}{o.method}{'' if o.possible else ' (impossible)'}"
    return [
        name,
        f"{o.f_max:g}",
        f"{o.multiple:.3g}",
        f"{o.retained:,} + {o.modes:,}",
        f"{o.unknowns:,}",
        duration(o.offline_s),
        duration(o.step_s),
        door[0],
        _error(o.bound),
        door[1],
        door[2],
    ]


def _step_row(s: StepAdvice, chosen: bool) -> list[str]:
    b = s.fixed if s.automatic is None else s.automatic
    contact = ["-", "-", "-"]
    if b is not None:
        contact = [f"{b.stiffness:.3g}", f"{b.shortest_s:.2g}", f"{b.shortest_s / s.step:.2g}"]
    return [
        f"{'* ' if chosen else ''}{s.step:g}",
        f"{s.per_period:.3g}",
        f"{s.steps:,}",
        _error(s.period_error),
        _error(s.damping),
        *contact,
        f"< {duration(s.reduced_s)}",
        f"< {duration(s.unreduced_s)}",
        s.hht,
    ]


def _memory_rows(facts: Facts) -> list[list[str]]:
    taken = facts.memory
    peak = taken.run_peak
    rows = [[f"{'* ' if s is peak else ''}{s.what}", f"{s.gb:.3g}", s.why] for s in taken.run]
    rows.append(["creak reduce alone", f"{taken.reduce_peak.gb:.3g}", taken.reduce_peak.what])
    return [["", "GB", "of which"], *rows]


def _error(x: float) -> str:
    return percent(x) if x else "exact"
