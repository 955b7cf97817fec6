"""Contact defined on retained nodes: node to surface (thesis 3.6 and 4.4)."""

from __future__ import annotations

from creak.report_tools import NONE, Table, percent
from creak_thesis.plan import RATTLING
from creak_thesis.report.blocks import Block, Section, TableBlock, Text, absent, agree, differ
from creak_thesis.report.facts import Facts, flange_events, thesis
from creak_thesis.report.figures import Panel, events_figure, events_of, fits_figure, loads_of, spectra_figure
from creak_thesis.report.tables import BOTH, agreement_table, axis_table, cost_table, force_table
from creak_thesis.report.words import biases, by_load, events_words, not_run


def node_section(facts: Facts) -> Section:
    section = Section("node", "Contact on retained nodes: node to surface")
    section.blocks += [
        _references(facts),
        TableBlock("Force of node to surface against surface to surface, unreduced models", method_table(facts)),
        fits_figure(
            facts,
            "Figure 4.14",
            ("D8", "Red NtS", "D8 NtS"),
            "Fit of the frequency responses, each against the unreduced model with the same contact.",
        ),
        TableBlock("Table 4.6: NRMSE by direction, A4", axis_table(facts, "Red NtS", thesis()["nrmse_nts"], ("A4",))),
        spectra_figure(facts, "Figure 4.15", "Red NtS", "A4", "xyz", 500.0, "Relative displacement, node to surface."),
        events_of(
            facts,
            "Figure 4.16",
            loads_of("Red NtS"),
            "Contact events of the reduced model with contact on its "
            "retained nodes (bars) and of the unreduced model with the same contact (markers).",
        ),
        TableBlock(
            "Mean force of the reduced models against their references", force_table(facts, ("Red NtS", "D8 NtS", "D8"))
        ),
        TableBlock("CPU time", cost_table(facts, ("Red NtS",), "Ref NtS")),
        *_words(facts),
        Text(
            "Where the overshoot of the thesis can come from: creak runs both methods with the whole panel reduced "
            "(Red NtS, as the thesis) and with the contact elements unreduced (D8 NtS)."
        ),
        TableBlock("Events and fits", agreement_table(facts, ("Red NtS", "D8 NtS"))),
        *not_run(facts, ("Ref NtS", "Red NtS", "D8 NtS")),
    ]
    return section


def _references(facts: Facts) -> Block:
    panels = []
    for load in RATTLING:
        sts, nts = facts.load("Ref StS", load), facts.load("Ref NtS", load)
        if sts is not None and nts is not None:
            panels.append(Panel(load, flange_events(nts), flange_events(sts)))
    if not panels:
        return events_figure(
            "Figure 4.13", [], ("", ""), f"No contact events to show (Ref NtS: {facts.why_not('Ref NtS')})."
        )
    return events_figure(
        "Figure 4.13",
        panels,
        ("node to surface", "surface to surface"),
        "Contact events of the unreduced models with the two contact definitions.",
    )


def method_ratios(facts: Facts) -> dict[str, float]:
    """Mean force of node to surface over surface to surface, by load."""
    found = {load: facts.between("Ref StS", "Ref NtS", load) for load in RATTLING}
    return {k: a.force_ratio for k, a in found.items() if a is not None and a.force_ratio is not None}


def method_table(facts: Facts) -> Table:
    told, rows = thesis()["force"]["nts_over_sts"], []
    ratios = method_ratios(facts)
    for k, load in enumerate(RATTLING):
        a = facts.between("Ref StS", "Ref NtS", load)
        impulse = None if a is None else a.impulse_ratio
        events = NONE if a is None else f"{len(a.common)} common, {a.missed} fewer, {a.extra} more"
        rows.append([load, percent(1.0 + told[k] / 100.0), percent(ratios.get(load)), percent(impulse), events])
    return Table(
        ["load", *BOTH, "creak", "creak"], rows, groups=[("", 1), ("mean force", 2), ("impulse", 1), ("events", 1)]
    )


def _words(facts: Facts) -> list[Block]:
    ratios = method_ratios(facts)
    if not ratios:
        return [absent("Both unreduced models are needed to compare.")]
    higher = all(r > 1.05 for r in ratios.values())
    told = by_load({k: percent(r) for k, r in ratios.items()})
    same = (
        f"Node to surface gives higher forces than surface to surface: {told} (thesis: +68.4, +73.1 and +42.3 %)."
        if higher
        else f"The two definitions find much the same events in time: {events_between(facts)}."
    )
    other = (
        ""
        if higher
        else (
            f"Node to surface does not raise the force throughout: {told} (thesis: +68.4, +73.1 and +42.3 %). In "
            "both creak's penalty is ten times the stiffness of the softer element, lowered to what the step resolves. "
        )
    )
    if facts.agreements("Red NtS"):
        other += (
            f"The reduced model stands {biases(facts, 'Red NtS')} against its reference (thesis: +338.4, +181.9 and "
            f"+174.2 %); events: {events_words(facts, 'Red NtS')}."
        )
    return [agree(same, higher), differ(other or "Nothing to add: the reduced model was not run.")]


def events_between(facts: Facts) -> str:
    found = {load: facts.between("Ref StS", "Ref NtS", load) for load in RATTLING}
    return by_load({k: f"{len(a.common)} common of {a.reference}" for k, a in found.items() if a is not None})
