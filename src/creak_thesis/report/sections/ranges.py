"""How many fixed-interface modes are needed (thesis 3.3.3 and 4.1)."""

from __future__ import annotations

from creak_thesis.plan import LOADS
from creak_thesis.report.blocks import Block, Section, TableBlock, absent, agree, differ
from creak_thesis.report.facts import Facts
from creak_thesis.report.figures import range_figure
from creak_thesis.report.tables import RANGES, modes_table, range_table
from creak_thesis.report.words import by_load, fit, not_run

FLAT = 0.01
"""Change of the NRMSE that no longer counts."""
EXCITED = 100.0
"""Hz, highest frequency of the excitation."""


def range_section(facts: Facts) -> Section:
    section = Section("range", "Range of the fixed-interface modes")
    section.blocks += [
        TableBlock("Table 3.6: modes of each substructure", modes_table(facts)),
        range_figure(
            facts,
            "Figure 4.1",
            RANGES,
            "Fit of the frequency response of the relative motion at 44 pairs, all "
            "directions, up to 500 Hz; 1 is perfect.",
        ),
        TableBlock("Table 4.1: CPU time", range_table(facts)),
        *_words(facts),
        *not_run(facts, list(RANGES.values())),
    ]
    return section


def enough(facts: Facts) -> dict[str, int]:
    """Lowest range from which the fit stays within `FLAT` of that of the widest range, by load."""
    found = {}
    ran = [f for f, c in RANGES.items() if facts.case(c) is not None]
    for load in LOADS:
        values = {f: v for f in ran if (v := facts.fit(RANGES[f], load)) is not None}
        if len(values) < 2:
            continue
        last = values[max(values)]
        good = [f for f in values if all(abs(v - last) <= FLAT for g, v in values.items() if g >= f)]
        found[load] = min(good)
    return found


def suffice(found: dict[str, int]) -> bool:
    """Whether the ranges that are enough are those of the thesis or lower: 1100 Hz, under A4 1300 Hz."""
    return all(f <= (1300 if load == "A4" else 1100) for load, f in found.items())


def _words(facts: Facts) -> list[Block]:
    found = enough(facts)
    if not found:
        return [absent("At least two ranges are needed to compare.")]
    factors = by_load({load: f"{f / EXCITED:.0f} times" for load, f in found.items()})
    ends = [n for n in ("F300", "F2000") if facts.fit(n, "A4") is not None]
    text = (
        f"The fit rises with the range and then stays: within {FLAT} of its last value from {factors} the highest "
        "excited frequency on (thesis: 11 times for A1 to A3, 13 times for A4)."
    )
    if len(ends) == 2:
        low, high = (fit(facts.fit(n, "A4")) for n in ends)
        text += f" Under A4 it goes from {low} at 300 Hz to {high} at 2000 Hz."
    return [agree(text, suffice(found)), differ(_differ(facts))]


def _differ(facts: Facts) -> str:
    text = "The numbers of modes in table 3.6 are those of another shape. "
    low, high = facts.own_cpu("F300"), facts.own_cpu("F2000")
    if low and high:
        text += (
            f"In the thesis the widest range costs {10.79 / 8.44:.2f} times the narrowest; in creak's own step, whose "
            "cost grows with the number of coordinates and not with the factorisation of full matrices, "
            f"{high / low:.2f} times."
        )
    return text
