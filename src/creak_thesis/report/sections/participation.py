"""Interface dofs left out by their modal participation (thesis 3.5.1 and 4.3.1)."""

from __future__ import annotations

import itertools

from creak_thesis.plan import ETAS, FINE_ETAS
from creak_thesis.report.blocks import Block, Section, TableBlock, absent, agree, differ
from creak_thesis.report.facts import Facts
from creak_thesis.report.figures import events_of, fits_figure, loads_of
from creak_thesis.report.tables import agreement_table, participation_table
from creak_thesis.report.words import FOUND, fit, listed, not_run, predicts

NAMES = tuple(f"P{eta}" for eta in (*FINE_ETAS, *ETAS))


def participation_section(facts: Facts) -> Section:
    section = Section("participation", "Interface reduction by modal participation")
    section.blocks += [
        TableBlock("Tables 3.8 and 4.5", participation_table(facts)),
        fits_figure(facts, "Figure 4.8", NAMES, "Fit of the frequency responses."),
        events_of(facts, "Figure 4.9", loads_of("P35"), "Contact events of P35."),
        events_of(facts, "Figure 4.10", loads_of("P37"), "Contact events of P37."),
        TableBlock("Events and fits of all configurations", agreement_table(facts, ("D8", *NAMES))),
        *_words(facts),
        *not_run(facts, NAMES),
    ]
    return section


def right_and_wrong(facts: Facts) -> tuple[list[str], list[str]]:
    """Configurations that find most events, and those that lose them."""
    right: list[str] = []
    wrong: list[str] = []
    for name in facts.ran(NAMES):
        good = predicts(facts, name)
        if good is not None:
            (right if good else wrong).append(name)
    return right, wrong


def _words(facts: Facts) -> list[Block]:
    right, wrong = right_and_wrong(facts)
    if not right and not wrong:
        return [absent("No configuration was run.")]
    lowest = {n: m for n in facts.ran(NAMES) if (m := facts.lowest_mac(n)) is not None}
    text = f"{100.0 * FOUND:.0f} % of the events or more, with few extra, have: {listed(right)}. "
    text += f"Fewer: {listed(wrong)}. "
    text += f"Lowest MAC: {listed(f'{fit(m[0])} ({n})' for n, m in lowest.items())}."
    falling = [m[0] for m in lowest.values()]
    if len(falling) > 1 and all(b <= a + 1e-3 for a, b in itertools.pairwise(falling)):
        text += " As in the thesis it falls as more dofs are left uncoupled."
    as_told = "P35" in right and wrong[:1] == ["P37"]
    return [agree(text, as_told), differ(_differ(wrong))]


def _differ(wrong: list[str]) -> str:
    text = "In the thesis everything is right up to P35, and P37 loses 5 of 6 events under A2; "
    if not wrong:
        text += "here no configuration that was run fails. "
    elif wrong[0] == "P37":
        text += "here P37 is the first to fail too. "
    else:
        text += f"here {wrong[0]} is the first to fail. "
    return text + (
        "Which dofs have little participation depends on the shape, and on whether rotations and translations are "
        "measured together as equation 3.3 does: the place of the edge is a property of the model, that there is one "
        "is a property of the method."
    )
