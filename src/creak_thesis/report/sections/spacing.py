"""Retained nodes of the whole flange and the pre-check (thesis 3.3.1 and 3.3.2)."""

from __future__ import annotations

from creak.report_tools import number
from creak_thesis.report.blocks import Block, PictureBlock, Section, TableBlock, Text, absent, agree, differ
from creak_thesis.report.facts import Facts, thesis
from creak_thesis.report.figures import diagonal_figure, mac_figure
from creak_thesis.report.tables import spacing_table
from creak_thesis.report.words import fit, listed, not_run

NAMES = tuple(f"C{k}" for k in range(1, 6))
GOOD = 0.9
"""MAC from which a mode counts as captured."""


def spacing_section(facts: Facts, pictures: dict[str, PictureBlock]) -> Section:
    section = Section("spacing", "Retained dofs on the whole flange")
    section.blocks += [
        Text(
            "Contact on the whole flange, the panel unreduced, and only every n-th node of the frame's interface "
            "retained; the other interface nodes stay uncoupled."
        ),
        pictures["pairs"],
        TableBlock("Table 3.5", spacing_table(facts)),
        mac_figure(facts, "Figure 3.8", ("C1", "C5"), "MAC of the best and the worst configuration, at 15 pairs."),
        diagonal_figure(facts, "Figure 3.9", NAMES, "MAC of the paired modes up to 100 Hz."),
        *_words(facts),
        *not_run(facts, ("Ref C", *NAMES)),
    ]
    return section


def _words(facts: Facts) -> list[Block]:
    first, last = facts.lowest_mac("C1"), facts.lowest_mac("C5")
    if first is None or last is None:
        return [absent("C1 and C5 are needed to compare.")]
    texts = [
        f"With every interface node retained the lowest MAC is {fit(first[0])}, with every 16th {fit(last[0])}: "
        f"{captured_modes(facts, 'C1')} and {captured_modes(facts, 'C5')} modes have a MAC of {GOOD} or more "
        "(thesis: all, and 8 to 12)."
    ]
    slower = slower_than_reference(facts)
    if slower:
        texts.append(
            f"{listed(slower)} cost more than the unreduced model with plain Newton: the reduced matrices are full, "
            "and factorising them anew in every iteration outweighs their smaller number."
        )
    loses = captured_modes(facts, "C5") < captured_modes(facts, "C1")
    return [agree(" ".join(texts), loses), differ(_differ(facts, slower))]


def slower_than_reference(facts: Facts) -> list[str]:
    """Configurations that plain Newton takes longer for than for the unreduced model."""
    reference = facts.usual_cpu("Ref C")
    return [] if reference is None else [n for n in NAMES if (facts.usual_cpu(n) or 0.0) > reference]


def captured_modes(facts: Facts, name: str) -> int:
    found = facts.case(name)
    return 0 if found is None else sum(m >= GOOD for m in found.mac)


def _differ(facts: Facts, slower: list[str]) -> str:
    told = thesis()["spacing"]
    loss = told["cpu"][0] / told["reference_cpu"]
    text = ""
    if facts.usual_cpu("Ref C") is not None and "C1" not in slower:
        text = (
            f"In the thesis C1 costs {loss:.2f} times the reference; here it does not with plain Newton, because the "
            "ratio of retained to unreduced dofs depends on the mesh. "
        )
    d8, base = facts.own_cpu("D8"), facts.own_cpu("Ref StS")
    if d8 is not None and base is not None:
        verdict = "does not have" if d8 < base else "still has"
        text += (
            f"creak {verdict} this penalty in its own step: it factorises once, brings the reduced model to diagonal "
            f"form and iterates on the contact channels alone; D8 then takes {number(d8, 3)} s under A4, the unreduced "
            f"model {number(base, 3)} s."
        )
    return text or "creak's own step does not factorise the matrices anew; its runs are not there to show it."


def precheck_section(facts: Facts, before: int | None, pictures: dict[str, PictureBlock]) -> Section:
    """Section 3.3.2 and figure 3.10."""
    section = Section("precheck", "Pre-check and substructures")
    told = thesis()["precheck"]
    reference, whole, frame = facts.case("Ref StS"), facts.retained("C1", "FRAME"), facts.retained("D8", "FRAME")
    section.blocks.append(pictures["main"])
    if reference is None:
        return Section(section.id, section.title, [*section.blocks, *not_run(facts, ("Ref StS",))])
    text = f"A linear run under A4 keeps {number(reference.channels)} "
    text += f"of {number(before)} channels. " if before else "channels. "
    if whole is not None and frame is not None:
        text += (
            f"The frame's retained dofs fall from {number(whole)} to {number(frame)} "
            f"({100.0 * (1.0 - frame / whole):.0f} % less; thesis: {number(told['before'])} to "
            f"{number(told['after'])}, "
            f"{100.0 * (1.0 - told['after'] / told['before']):.0f} % less)."
        )
    section.blocks += [
        agree(text, whole is None or frame is None or frame < whole),
        differ(
            "The thesis found the closing region by a script after a run and redefined the contact by hand; creak's "
            "pre-check is part of every study and keeps a margin. The number of retained dofs follows the mesh size "
            "and the length of the flange that closes, so it is not the thesis's."
        ),
    ]
    return section
