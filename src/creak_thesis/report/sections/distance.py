"""Elements near the contact that stay unreduced (thesis 3.4 and 4.2)."""

from __future__ import annotations

from creak.report_tools import percent
from creak_thesis.plan import LOADS
from creak_thesis.report.blocks import Block, PictureBlock, Section, TableBlock, absent, agree, differ
from creak_thesis.report.facts import Facts, thesis
from creak_thesis.report.figures import events_of, fits_figure, spectra_figure
from creak_thesis.report.tables import axis_table, cost_table, distance_table, force_table, grade_table
from creak_thesis.report.words import (
    CLOSE,
    biases,
    captured,
    events_words,
    not_run,
    predicts,
    same_events,
    worst_fit_change,
)

NAMES = ("D8", "D40", "D90")


def distance_section(facts: Facts, pictures: dict[str, PictureBlock]) -> Section:
    section = Section("distance", "Distance from the contact to the substructures")
    bars = "Bars: reduced model, markers: unreduced model; largest channel force, low-passed at 500 Hz."
    section.blocks += [
        pictures["distance"],
        TableBlock("Table 3.7", distance_table(facts)),
        fits_figure(facts, "Figure 4.2", NAMES, "Fit of the frequency responses for the three distances."),
        TableBlock("Table 4.2: NRMSE of D8 by direction", axis_table(facts, "D8", thesis()["nrmse"], LOADS)),
        spectra_figure(facts, "Figure 4.3", "D8", "A1", "x", 250.0, "Relative displacement in X without contact."),
        spectra_figure(facts, "Figure 4.4", "D8", "A4", "x", 250.0, "The same under the reference load."),
        *(
            events_of(facts, f"Figure 4.{5 + k}", [(n, load) for n in NAMES], f"Contact events under {load}. {bars}")
            for k, load in enumerate(("A2", "A3", "A4"))
        ),
        TableBlock("Table 4.3: forces of D8 against the unreduced model", grade_table(facts, "D8")),
        TableBlock("Mean force of the three distances (section 4.2)", force_table(facts, NAMES)),
        TableBlock("Table 4.4: CPU time", cost_table(facts, NAMES[::-1], "Ref StS")),
        *_words(facts),
        *not_run(facts, ("Ref StS", *NAMES)),
    ]
    return section


def _words(facts: Facts) -> list[Block]:
    reference, common, extra = captured(facts, "D8")
    if not reference:
        return [absent("D8 and its unreduced runs are needed to compare.")]
    texts = [
        f"Time: D8 finds {common} of {reference} events within 10 ms, {extra} extra ({events_words(facts, 'D8')})."
    ]
    spread = worst_fit_change(facts, ("D40", "D90"))
    others = [n for n in ("D40", "D90") if same_events(facts, n) is not None]
    if spread is not None and others:
        alike = all(same_events(facts, n) for n in others)
        texts.append(
            f"Distance: the NRMSE changes by {spread:.4f} at most"
            + (" and the events found are the same" if alike else "; the events found are not all the same")
            + (": more elements near the contact gain nothing, as in the thesis." if spread <= CLOSE and alike else ".")
        )
    so = bool(predicts(facts, "D8")) and (spread is None or spread <= CLOSE)
    return [agree(" ".join(texts), so), differ(_differ(facts))]


def _differ(facts: Facts) -> str:
    told = thesis()["force"]["D8"]
    text = (
        f"Mean force of D8 against the unreduced model: {biases(facts, 'D8')}; thesis: "
        f"{percent(1 + told[0] / 100)}, {percent(1 + told[1] / 100)} and {percent(1 + told[2] / 100)}. "
    )
    worst = max((abs((a.force_ratio or 1.0) - 1.0) for a in facts.agreements("D8").values()), default=0.0)
    if worst < 0.05:
        text += (
            "creak's reduced model keeps the force: the same contact law, channels and step act on both models, so "
            "only the reduction itself is left to differ. The thesis notes that its own peaks consist of few data "
            "points."
        )
    else:
        text += (
            "At one step per millisecond an event holds few points, and a small shift in time changes its peak; the "
            "section on the time step shows how much of this remains with a quarter of the step."
        )
    return text
