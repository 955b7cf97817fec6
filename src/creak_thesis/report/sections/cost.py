"""Computational time (thesis 4.5)."""

from __future__ import annotations

from creak.report_tools import number, times
from creak_thesis.plan import plan
from creak_thesis.report.blocks import Block, Section, TableBlock, absent, agree, differ
from creak_thesis.report.facts import Facts, against, thesis, thesis_cpu
from creak_thesis.report.figures import cost_figure
from creak_thesis.report.tables import cost_table, summary_table
from creak_thesis.report.words import listed, not_run

NAMES = ("D8", "D40", "D90", "P35", "M2", "I3", "X100", "Red NtS")


def cost_section(facts: Facts) -> Section:
    section = Section("cost", "Computational time")
    section.blocks += [
        TableBlock("Table 4.7: size and CPU time", summary_table(facts)),
        cost_figure(
            "CPU time over that of the unreduced model",
            NAMES,
            ratios(facts),
            "Left of the line: faster than the unreduced model; logarithmic.",
        ),
        TableBlock("All timed cases", cost_table(facts, timed(facts), "Ref StS")),
        *_words(facts),
        *not_run(facts, ("Ref StS", *thesis()["summary"]["names"][1:])),
    ]
    return section


def timed(facts: Facts) -> list[str]:
    """Reduced cases whose plain Newton was timed or that have a run under A4, except those of other references."""
    names = [c.name for c in plan() if c.reduction is not None and c.against == "Ref StS"]
    return [n for n in names if facts.usual_cpu(n) is not None or facts.own_cpu(n) is not None]


def ratios(facts: Facts) -> dict[str, list[float | None]]:
    """CPU time over that of the unreduced model: thesis, plain Newton, creak."""
    return {
        "thesis": [_over(thesis_cpu(n), thesis_cpu(against(n))) for n in NAMES],
        "creak, plain Newton": [_over(facts.usual_cpu(n), facts.usual_cpu(against(n))) for n in NAMES],
        "creak, measured": [_over(facts.own_cpu(n), facts.own_cpu(against(n))) for n in NAMES],
    }


def _over(value: float | None, reference: float | None) -> float | None:
    return None if value is None or not reference else float(f"{value / reference:.4g}")


def saved(facts: Facts, name: str, usual: bool) -> float | None:
    """Share of the unreduced model's CPU time that a case saves."""
    of = facts.usual_cpu if usual else facts.own_cpu
    value, reference = of(name), of(against(name))
    return None if value is None or not reference else 1.0 - value / reference


def slower(facts: Facts, names: list[str], usual: bool) -> list[str]:
    """Cases that take longer than their unreduced model."""
    return [n for n in names if (s := saved(facts, n, usual)) is not None and s < 0.0]


def _words(facts: Facts) -> list[Block]:
    usual, own = saved(facts, "D8", True), saved(facts, "D8", False)
    if usual is None and own is None:
        return [absent("D8 and its unreduced model are needed to compare.")]
    out: list[Block] = []
    if usual is not None:
        text = f"With plain Newton D8 takes {number(100.0 * usual, 3)} % less CPU time than the unreduced model "
        text += "(thesis: 97.9 %)"
        behind = slower(facts, timed(facts), True)
        text += f"; slower than the unreduced model are {listed(behind)}." if behind else "; no reduced case is slower."
        out.append(agree(text, usual > 0.9))
    if own is not None:
        reference = facts.own_cpu("Ref StS")
        plain = facts.usual_cpu("Ref StS")
        text = f"As creak runs them, D8 takes {number(100.0 * own, 3)} % less than the unreduced model"
        behind = slower(facts, timed(facts), False)
        text += f", and slower than it are {listed(behind)}. " if behind else ", and no reduced case is slower. "
        if reference and plain:
            text += (
                f"The unreduced model itself, factorised once and condensed to the contact channels, runs "
                f"{times(plain / reference)} faster than by plain Newton. "
            )
        text += (
            "The thesis's law that the interface dofs decide the cost is one of the general solver, which factorises "
            "full matrices at every iteration; in creak they only enter the reduction, once."
        )
        if facts.mesh_size > 10.0:
            text += (
                f" On a mesh of {facts.mesh_size:g} mm the unreduced model is small and cheap to factorise, so that "
                "plain Newton gains less by the reduction than at the thesis's 1.17 million dofs."
            )
        out.append(differ(text))
    return out
