"""Beyond the thesis: shorter steps, generalised interface coordinates, hooks with play."""

from __future__ import annotations

from creak.report_tools import NONE, Table, number, percent
from creak_thesis.plan import RATTLING
from creak_thesis.report.blocks import Section, TableBlock, Text, absent
from creak_thesis.report.facts import Facts
from creak_thesis.report.figures import events_of, loads_of
from creak_thesis.report.tables import agreement_table, count
from creak_thesis.report.words import (
    CLOSE,
    biases,
    by_load,
    counted,
    events_words,
    listed,
    not_run,
    seconds,
    worst_fit_change,
)

GENERALISED = ("X50", "X100", "X200")
WHOLE = ("CB", "G700")
PLAY = ("Ref play", "D8 play")


def step_section(facts: Facts) -> Section:
    section = Section("step", "Beyond: the time step")
    fine = facts.agreement("D8 h/4", "A4")
    section.blocks += [
        events_of(
            facts,
            "D8 against the unreduced model, a quarter of the step near contact",
            [("D8 h/4", "A4"), ("D8", "A4")],
            "Bars: reduced, markers: unreduced, each pair with its own step.",
        ),
        TableBlock("Force and events under A4", _steps(facts)),
    ]
    section.blocks.append(Text(step_words(facts)) if fine is not None else absent(step_words(facts)))
    section.blocks += not_run(facts, ("Ref StS h/4", "D8 h/4"))
    return section


def _steps(facts: Facts) -> Table:
    rows = []
    for label, a in (
        ("D8 against Ref, h", facts.agreement("D8", "A4")),
        ("D8 against Ref, h/4", facts.agreement("D8 h/4", "A4")),
        ("Ref h/4 against Ref h", facts.between("Ref StS", "Ref StS h/4", "A4")),
    ):
        if a is None:
            rows.append([label, *[NONE] * 6])
            continue
        rows.append(
            [
                label,
                str(a.reference),
                str(len(a.common)),
                str(a.extra),
                percent(a.force_ratio),
                percent(None if a.largest_error is None else 1.0 + a.largest_error),
                percent(a.impulse_ratio),
            ]
        )
    return Table(
        ["", "events", "common", "extra", "mean force", "largest difference", "impulse"],
        rows,
        note="The thesis: D8 +6.0 % in mean force under A4, at one step.",
    )


def step_words(facts: Facts) -> str:
    """What a quarter of the step does to the force and to the difference between the models."""
    base, fine = facts.agreement("D8", "A4"), facts.agreement("D8 h/4", "A4")
    if base is None or fine is None or base.force_ratio is None or fine.force_ratio is None:
        return "The runs with a quarter of the step are not there, so creak cannot tell here what a shorter step does."
    first, then = abs(base.force_ratio - 1.0), abs(fine.force_ratio - 1.0)
    change = facts.between("Ref StS", "Ref StS h/4", "A4")
    text = (
        f"With a quarter of the step near contact D8 stands {percent(fine.force_ratio)} from the unreduced model in "
        f"mean force, with the whole step {percent(base.force_ratio)}; events: {counted(fine)}, before: "
        f"{counted(base)}. "
    )
    if max(first, then) < 0.05:
        text += "The two models agree at either step: the step is not what separates them. "
    elif then < first:
        text += "The difference shrinks with the step, so part of it comes from too few points in an event. "
    else:
        text += "The difference does not shrink with the step, so the step alone does not explain it. "
    if change is not None and change.force_ratio is not None and change.largest_error is not None:
        text += (
            f"The unreduced model itself changes by {percent(change.force_ratio)} in mean force and by up to "
            f"{100.0 * change.largest_error:.0f} % in a single event when its step is quartered."
        )
    return text


def interface_section(facts: Facts) -> Section:
    section = Section("generalised", "Beyond: interfaces with generalised coordinates")
    names = ("D8", *GENERALISED, *WHOLE)
    section.blocks += [
        Text(
            "What the thesis could not do with its solver: the interface dofs of D8 are replaced by 50, 100 or 200 "
            "characteristic shapes of the interface (X50, X100, X200). Also: contact on retained nodes without "
            "unreduced elements (CB), and a basis of the whole assembly with the shapes of the gaps (G700)."
        ),
        TableBlock("Size and cost", _sizes(facts, names)),
        TableBlock("Events and fits", agreement_table(facts, names)),
        events_of(
            facts,
            "Contact events of X100",
            loads_of("X100"),
            "Bars: 100 interface coordinates, markers: unreduced model.",
        ),
        Text(interface_words(facts)),
        *not_run(facts, names),
    ]
    return section


def _sizes(facts: Facts, names: tuple[str, ...]) -> Table:
    rows = []
    for name in names:
        found = facts.case(name)
        rows.append(
            [
                name,
                count(facts.all_retained(name)),
                count(None if found is None else sum(found.modes.values())),
                count(None if found is None else found.n),
                seconds(None if found is None else found.offline_cpu_s),
                seconds(facts.usual_cpu(name)),
                seconds(facts.own_cpu(name)),
            ]
        )
    return Table(
        ["creak", "retained", "modes", "coordinates", "reduction, s", "plain Newton, s", "measured, s"],
        rows,
        groups=[("", 1), ("model", 3), ("CPU time", 3)],
    )


def smallest_good(facts: Facts) -> str | None:
    """The fewest generalised coordinates whose fits are close to those of D8."""
    for name in GENERALISED:
        change = worst_fit_change(facts, (name,))
        if change is not None and change <= CLOSE:
            return name
    return None


def interface_words(facts: Facts) -> str:
    """How many generalised coordinates suffice."""
    ran = facts.ran(GENERALISED)
    if not ran:
        return "The cases with generalised interface coordinates are not there."
    best, whole = smallest_good(facts), facts.case("D8")
    if best is None:
        spread = worst_fit_change(facts, (ran[-1],))
        return f"None of {listed(ran)} keeps the NRMSE within 0.02 of D8" + (
            "." if spread is None else f" ({ran[-1]}: {spread:.4f} away)."
        )
    few = facts.case(best)
    text = f"{best} keeps the NRMSE within 0.02 of D8 ({events_words(facts, best)}; mean force {biases(facts, best)})"
    if few is not None and whole is not None:
        text += f" with {number(few.n)} coordinates in all instead of {number(whole.n)}"
    usual = [facts.usual_cpu(n) for n in (best, "D8")]
    if usual[0] is not None and usual[1]:
        text += f"; with plain Newton it takes {percent(usual[0] / usual[1], 0)} of the CPU time of D8"
    return text + "."


def play_section(facts: Facts) -> Section:
    section = Section("play", "Beyond: hooks with play")
    if not facts.ran(PLAY):
        section.blocks.append(absent("Not run: hooks with play are no case of this run."))
        return section
    section.blocks += [
        events_of(
            facts,
            "Contact events with play in the hooks",
            loads_of("D8 play"),
            "Bars: reduced, markers: unreduced model, both with play in the hooks of the panel.",
        ),
        TableBlock("Events of the flange, and fits", agreement_table(facts, ("D8", "D8 play"))),
        TableBlock("Events of the hooks' stops", _stops(facts)),
        Text(play_words(facts)),
        *not_run(facts, PLAY),
    ]
    return section


def _stops(facts: Facts) -> Table:
    rows = []
    for load in RATTLING:
        a = facts.stops("D8 play", load)
        if a is not None:
            rows.append(
                [
                    load,
                    number(a.reference),
                    number(len(a.common)),
                    number(a.extra),
                    percent(a.force_ratio),
                    percent(a.impulse_ratio),
                ]
            )
    return Table(["creak", "unreduced model", "found", "extra", "mean force", "impulse"], rows)


def play_words(facts: Facts) -> str:
    """How well the reduced model follows the unreduced one with hooks that have play."""
    if not facts.agreements("D8 play"):
        return "The runs with play in the hooks are not there."
    found = {load: facts.between("Ref StS", "Ref play", load) for load in RATTLING}
    changed = {k: f"{a.own} instead of {a.reference}" for k, a in found.items() if a is not None}
    return (
        f"With play in the hooks D8 finds: {events_words(facts, 'D8 play')}; mean force {biases(facts, 'D8 play')}. "
        f"The play itself changes the events of the flange in the unreduced model: {by_load(changed)} per second."
    )
