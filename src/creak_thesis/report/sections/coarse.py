"""Coarser mesh along the interface (thesis 3.5.2 and 4.3.2)."""

from __future__ import annotations

from creak.report_tools import number
from creak_thesis.report.blocks import Block, PictureBlock, Section, TableBlock, Text, absent, agree, differ
from creak_thesis.report.facts import Facts
from creak_thesis.report.figures import events_of, fits_figure, loads_of
from creak_thesis.report.tables import agreement_table, coarse_table, cost_table
from creak_thesis.report.words import CLOSE, events_words, not_run, predicts, worst_fit_change

NAMES = ("M1", "M2")
WITHOUT_MESH = ("I2", "I3")
OWN = "M2 own"


def coarse_section(facts: Facts, pictures: dict[str, PictureBlock]) -> Section:
    section = Section("coarse", "Coarser mesh along the interface")
    section.blocks += [
        pictures["coarse"],
        TableBlock("Table 3.9", coarse_table(facts)),
        fits_figure(
            facts,
            "Figure 4.11",
            ("D8", *NAMES),
            "Fit of the frequency responses with the mesh of D8 and the "
            "two coarser ones, all against the unreduced model with the mesh of D8.",
        ),
        events_of(
            facts, "Figure 4.12", loads_of("M2"), "Contact events of M2; markers: unreduced model with the mesh of D8."
        ),
        TableBlock("CPU time", cost_table(facts, ("D8", *NAMES), "Ref StS")),
        *_words(facts),
        Text(
            "The same without a new mesh: creak can retain every second or third interface node and let those between "
            "follow by interpolation (I2, I3); the nodes between are then coupled, not left free."
        ),
        TableBlock("Events and fits", agreement_table(facts, ("D8", *NAMES, *WITHOUT_MESH, OWN))),
        Text(
            f"{OWN}: the same reduced model against the unreduced model of its own, coarser mesh: what the reduction "
            "costs, without what the mesh changes."
        ),
        *not_run(facts, (*NAMES, *WITHOUT_MESH)),
    ]
    return section


def saving(facts: Facts, usual: bool) -> float | None:
    """Share of the CPU time of D8 that M2 saves, with plain Newton or as measured."""
    a, b = (facts.usual_cpu(n) if usual else facts.own_cpu(n) for n in ("D8", "M2"))
    return None if not a or b is None else 1.0 - b / a


def _words(facts: Facts) -> list[Block]:
    if facts.case("M2") is None:
        return [absent("M2 is needed to compare.")]
    change = worst_fit_change(facts, NAMES)
    retained, of = facts.retained("M2", "FRAME"), facts.retained("D8", "FRAME")
    text = f"M2: {events_words(facts, 'M2')}. "
    if change is not None:
        text += f"The NRMSE of M1 and M2 differs from that of D8 by {change:.4f} at most. "
    if retained is not None and of:
        text += f"The frame's retained dofs fall by {100.0 * (1.0 - retained / of):.1f} % (thesis: 52.3 %)."
    usual, own = saving(facts, True), saving(facts, False)
    parts = []
    if usual is not None:
        parts.append(f"With plain Newton M2 saves {number(100.0 * usual, 3)} % of the CPU time of D8 (thesis: 32.5 %)")
    if own is not None:
        parts.append(
            f"in creak's own step {number(100.0 * own, 3)} %, because there the interface dofs no longer enter a "
            "factorisation at every step"
        )
    words = "; ".join(parts) + ". " if parts else ""
    return [
        agree(text, bool(predicts(facts, "M2")) and (change is None or change <= CLOSE)),
        differ(
            words + "The fit also holds what the coarser mesh itself changes: the elements near the contact are "
            "larger, and the reference keeps the finer mesh."
        ),
    ]
