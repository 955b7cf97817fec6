"""First screen of the thesis page: each finding of the thesis beside creak's, marked by a rule that data can break.

Every finding states its rule. "Same" and "explained" are both conditions on figures of the runs; what meets neither
differs.
"""

from __future__ import annotations

import math

from creak.report_tools import number, percent
from creak_thesis.record import RecordStudy
from creak_thesis.report.blocks import Finding, Mark
from creak_thesis.report.facts import Facts, thesis
from creak_thesis.report.sections.beyond import interface_words, smallest_good
from creak_thesis.report.sections.coarse import OWN, saving
from creak_thesis.report.sections.cost import saved, slower, timed
from creak_thesis.report.sections.node import method_ratios
from creak_thesis.report.sections.participation import right_and_wrong
from creak_thesis.report.sections.ranges import enough, suffice
from creak_thesis.report.sections.spacing import captured_modes, slower_than_reference
from creak_thesis.report.words import (
    CLOSE,
    FOUND,
    bias,
    biases,
    by_load,
    captured,
    fit,
    listed,
    predicts,
    same_events,
    worst_fit_change,
)

NOT_RUN = "not run"
FORCE = 0.05
"""Difference of a force that counts (thesis 3.7.3)."""
GROWS = 1.1
"""Cost of the largest over that of the smallest interface from which on the interface dofs are what costs."""
DECIDES = 1.2
"""The same where they decide it; the thesis has 1.37 for D90 over D8."""
SAVES = 0.9
"""Share of the CPU time that a reduction is worth."""
SUDDEN = 0.5
"""Share of the events that the first configuration beyond an edge finds at most."""
FELL = 0.1
"""Most that the NRMSE may fall from A1 to A4; by direction the thesis's falls by .008 to .067."""


def mark_of(same: bool, explained: bool = False) -> Mark:
    """Of a rule's two conditions."""
    return "same" if same else "explained" if explained else "differs"


def findings(facts: Facts, record: RecordStudy | None) -> list[Finding]:
    """The lines of the summary, in the order of the page."""
    return [
        _record(record),
        _spacing_cost(facts),
        _spacing_mac(facts),
        _range(facts),
        _distance(facts),
        _time(facts),
        _force(facts),
        _level(facts),
        _participation(facts),
        _coarse(facts),
        _methods(facts),
        _overshoot(facts),
        _cost(facts),
        _interface(facts),
        _generalised(facts),
    ]


def _record(record: RecordStudy | None) -> Finding:
    told = "Integrated twice the record drifts; dropping all below 7 Hz gives zero mean."
    rule = (
        "Same: the drift is above the true peak, the mean then below .1 % of it, and the true motion back within 5 %."
    )
    if record is None:
        return Finding("signal", told, NOT_RUN, "not run", rule)
    same = record.drift > record.peak and abs(record.mean) < 1e-3 * record.peak
    same = same and record.error_max < 0.05 * record.true_peak
    words = (
        f"Drift {number(record.drift / 1e3, 3)} m, then none; true motion back within {number(record.error_max, 2)} mm."
    )
    return Finding("signal", told, words, mark_of(same), rule)


def _spacing_cost(facts: Facts) -> Finding:
    told = "Too many retained dofs cost more than the unreduced model (C1: 1.25 times)."
    rule = (
        f"Plain Newton. Same: C1 costs more than the unreduced model and {GROWS:g} times C5 or more. Explained: less "
        f"than it, on a mesh with fewer dofs for each one retained than the thesis's, but {GROWS:g} times C5 or more."
    )
    reference, c1, c5 = (facts.usual_cpu(n) for n in ("Ref C", "C1", "C5"))
    if reference is None or c1 is None or c5 is None:
        return Finding("spacing", told, NOT_RUN, "not run", rule)
    over, grows = slower_than_reference(facts), c1 >= GROWS * c5
    words = f"Plain Newton: C1 {number(c1 / reference, 3)} times the unreduced model, {number(c1 / c5, 3)} times C5"
    words += f"; {listed(over)} above the unreduced model." if over else "; none above the unreduced model."
    denser = _unreduced_dofs_each(facts) < thesis()["model"]["dof"] / thesis()["spacing"]["retained"][0]
    return Finding("spacing", told, words, mark_of(c1 > reference and grows, grows and denser), rule)


def _unreduced_dofs_each(facts: Facts) -> float:
    """Dofs of the unreduced model for each that C1 retains in the frame."""
    reference, retained = facts.case("Ref C"), facts.retained("C1", "FRAME")
    return math.inf if reference is None or not retained else reference.n / retained


def _spacing_mac(facts: Facts) -> Finding:
    told = "Retaining fewer interface nodes loses modes: C5 keeps 8 to 12."
    rule = f"Same: C1 keeps {SAVES:.0%} of the modes or more, C5 two thirds of C1's or fewer."
    first, last = facts.case("C1"), facts.case("C5")
    if first is None or last is None or not last.mac:
        return Finding("spacing", told, NOT_RUN, "not run", rule)
    all_kept, kept = captured_modes(facts, "C1"), captured_modes(facts, "C5")
    words = f"C1 keeps {all_kept} of {len(first.mac)} modes, C5 {kept} of {len(last.mac)} (MAC 0.9 or more)."
    return Finding(
        "spacing", told, words, mark_of(all_kept >= SAVES * len(first.mac) and 3 * kept <= 2 * all_kept), rule
    )


def _range(facts: Facts) -> Finding:
    told = "Fixed-interface modes up to 11 (A1–A3) or 13 (A4) times the excitation suffice."
    rule = (
        "Same: the NRMSE is within 0.01 of its last value from 11 times on under A1 to A3, from 13 times on under A4."
    )
    found = enough(facts)
    if not found:
        return Finding("range", told, NOT_RUN, "not run", rule)
    words = by_load({k: f"{f / 100:.0f} times" for k, f in found.items()})
    return Finding("range", told, f"NRMSE within 0.01 of its last value from {words}.", mark_of(suffice(found)), rule)


def _distance(facts: Facts) -> Finding:
    told = "More unreduced elements near the contact (D40, D90) gain nothing."
    rule = f"Same: the NRMSE changes by {CLOSE:g} at most, and no load gains or loses an event."
    spread = worst_fit_change(facts, ("D40", "D90"))
    alike = [same_events(facts, n) for n in ("D40", "D90")]
    if spread is None or None in alike:
        return Finding("distance", told, NOT_RUN, "not run", rule)
    words = f"NRMSE changes by {spread:.4f} at most; events {'the same' if all(alike) else 'not all the same'}."
    return Finding("distance", told, words, mark_of(spread <= CLOSE and all(alike)), rule)


def _time(facts: Facts) -> Finding:
    told = "D8 finds nearly all contact events within 10 ms (1 missed, 3 extra)."
    rule = f"Same: {FOUND:.0%} of the events are found, and at most a tenth and one more are extra."
    reference, common, extra = captured(facts, "D8")
    if not reference:
        return Finding("distance", told, NOT_RUN, "not run", rule)
    words = f"{common} of {reference} events found, {extra or 'none'} extra."
    return Finding("distance", told, words, mark_of(bool(predicts(facts, "D8"))), rule)


def _force(facts: Facts) -> Finding:
    told = "The reduced model's forces are higher: +21.7, +18.2, +6.0 %."
    rule = (
        "Same: more than 5 % higher under every load. Explained: within 5 % under every load, and with a quarter of "
        "the step too, so that neither the reduction nor the step raises them."
    )
    found = [a.force_ratio for a in facts.agreements("D8").values() if a.force_ratio is not None]
    if not found:
        return Finding("distance", told, NOT_RUN, "not run", rule)
    fine = facts.agreement("D8 h/4", "A4")
    step = None if fine is None else fine.force_ratio
    agree = step is not None and all(abs(r - 1.0) <= FORCE for r in (*found, step))
    words = f"Mean force {biases(facts, 'D8')}; {bias(fine)} with a quarter of the step."
    return Finding("distance", told, words, mark_of(all(r > 1.0 + FORCE for r in found), agree), rule)


def _level(facts: Facts) -> Finding:
    told = "The level of contact has little effect on the prediction, though the NRMSE falls from A1 to A4."
    rule = f"Same: the NRMSE falls from A1 to A4, by {FELL:g} at most, and the events are found."
    first, last = facts.fit("D8", "A1"), facts.fit("D8", "A4")
    if first is None or last is None:
        return Finding("distance", told, NOT_RUN, "not run", rule)
    same = 0.0 <= first - last <= FELL and bool(predicts(facts, "D8"))
    return Finding("distance", told, f"NRMSE {fit(first)} (A1), {fit(last)} (A4).", mark_of(same), rule)


def _participation(facts: Facts) -> Finding:
    told = "Leaving out dofs of little participation: right to P35, wrong from P37."
    rule = (
        "Same: right up to P35, wrong from P37 on. Explained: one edge elsewhere, all below it right and all above it "
        f"wrong, and the first above it finds {SUDDEN:.0%} of the events or fewer: the loss is as sudden."
    )
    right, wrong = right_and_wrong(facts)
    if not {"P35", "P37"} <= {*right, *wrong}:
        return Finding("participation", told, NOT_RUN, "not run", rule)
    words = f"Right: {listed(right)}; wrong: {listed(wrong)}."
    edge = bool(right) and bool(wrong) and _eta(right[-1]) < _eta(wrong[0])
    same = edge and right[-1] == "P35" and wrong[0] == "P37"
    sudden = edge and _lost(facts, wrong)
    if edge and not same:
        words += f" The edge is between {right[-1]} and {wrong[0]}, the loss {'as sudden' if sudden else 'gradual'}."
    return Finding("participation", told, words, mark_of(same, sudden), rule)


def _eta(name: str) -> int:
    return int(name.removeprefix("P"))


def _lost(facts: Facts, wrong: list[str]) -> bool:
    """Whether the first beyond the edge finds `SUDDEN` of the events or fewer."""
    reference, common, _ = captured(facts, wrong[0])
    return common <= SUDDEN * reference


def _coarse(facts: Facts) -> Finding:
    told = "A coarser mesh on the interface (M2) keeps the events and saves 32.5 %."
    rule = (
        "Same: the events of the fine mesh are found and plain Newton saves a tenth or more. Explained: it saves so, "
        "the events of the unreduced model of its own mesh are found, and those of the fine mesh are not."
    )
    reference, common, extra = captured(facts, "M2")
    usual, own = saving(facts, True), saving(facts, False)
    if not reference or usual is None:
        return Finding("coarse", told, NOT_RUN, "not run", rule)
    words = f"{common} of {reference} events, {extra or 'none'} extra; plain Newton saves {number(100.0 * usual, 3)} %"
    words += "." if own is None else f"; creak's step {number(100.0 * own, 3)} %."
    cheaper, kept = usual >= 0.1, bool(predicts(facts, "M2"))
    events, found, more = captured(facts, OWN)
    if kept or not events:
        return Finding("coarse", told, words, mark_of(cheaper and kept), rule)
    good = bool(predicts(facts, OWN))
    words += f" Against the unreduced model of its mesh {found} of {events}, {more or 'none'} extra: the mesh moves "
    words += "the events, the reduction loses none." if good else "the events, and so does the reduction."
    return Finding("coarse", told, words, mark_of(False, cheaper and good), rule)


def _methods(facts: Facts) -> Finding:
    told = "Node to surface gives higher forces than surface to surface: +68, +73, +42 %."
    rule = "Same: more than 5 % higher under every load."
    ratios = method_ratios(facts)
    if not ratios:
        return Finding("node", told, NOT_RUN, "not run", rule)
    words = f"Mean force {by_load({k: percent(r) for k, r in ratios.items()})}."
    return Finding("node", told, words, mark_of(all(r > 1.0 + FORCE for r in ratios.values())), rule)


def _overshoot(facts: Facts) -> Finding:
    told = "Reduced, node to surface overshoots its reference: +338, +182, +174 %."
    rule = "Same: by more than 50 % under every load."
    found = [a.force_ratio for a in facts.agreements("Red NtS").values() if a.force_ratio is not None]
    if not found:
        return Finding("node", told, NOT_RUN, "not run", rule)
    words = f"Mean force {biases(facts, 'Red NtS')}."
    return Finding("node", told, words, mark_of(all(r > 1.5 for r in found)), rule)


def _cost(facts: Facts) -> Finding:
    told = "The reduced model takes 97.9 % less CPU time."
    rule = (
        f"Same: D8 saves {SAVES:.0%} or more with plain Newton, as the thesis's solver works. Explained: less, on a "
        f"coarser mesh than the thesis's, but {SAVES:.0%} or more in creak's own step."
    )
    usual, own = saved(facts, "D8", True), saved(facts, "D8", False)
    reference = facts.case("Ref StS")
    if usual is None or own is None or reference is None:
        return Finding("cost", told, NOT_RUN, "not run", rule)
    words = f"Plain Newton {number(100.0 * usual, 3)} %, creak's own step {number(100.0 * own, 3)} % less."
    coarser = reference.n < 0.5 * thesis()["model"]["dof"]
    return Finding("cost", told, words, mark_of(usual >= SAVES, coarser and usual > 0.0 and own >= SAVES), rule)


def _interface(facts: Facts) -> Finding:
    told = "The number of interface dofs decides the CPU time (D90 over D8: 1.37)."
    rule = (
        f"D90 over D8. Same: {DECIDES:g} or more both with plain Newton and in creak's own step. Explained: so with "
        "plain Newton, which factorises full matrices, not in creak's own step, which is diagonal."
    )
    pairs = [(of("D8"), of("D90")) for of in (facts.usual_cpu, facts.own_cpu)]
    ratios = [b / a for a, b in pairs if a and b is not None]
    if len(ratios) < 2:
        return Finding("cost", told, NOT_RUN, "not run", rule)
    usual, own = ratios
    words = f"D90 over D8: plain Newton {number(usual, 3)}, creak's own step {number(own, 3)}"
    words += f"; slower than unreduced in creak: {listed(slower(facts, timed(facts), False))}."
    return Finding("cost", told, words, mark_of(usual >= DECIDES and own >= DECIDES, usual >= DECIDES), rule)


def _generalised(facts: Facts) -> Finding:
    told = "Generalised interface dofs could help, but the solver could not use them."
    rule = "Explained: a model with fewer coordinates than D8 finds its events and keeps its NRMSE."
    if not facts.ran(("X50", "X100", "X200")):
        return Finding("generalised", told, NOT_RUN, "not run", rule)
    best, d8 = facts.case(smallest_good(facts) or ""), facts.case("D8")
    smaller = best is not None and d8 is not None and best.n < d8.n
    return Finding("generalised", told, interface_words(facts), mark_of(False, smaller), rule)
