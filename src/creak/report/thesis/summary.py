"""First screen of the thesis page: each finding of the thesis beside creak's."""

from __future__ import annotations

from creak.report.text import NONE, number, percent
from creak.report.thesis.blocks import Finding, Mark
from creak.report.thesis.facts import Facts
from creak.report.thesis.sections.beyond import interface_words, smallest_good
from creak.report.thesis.sections.coarse import OWN, saving
from creak.report.thesis.sections.cost import saved, slower, timed
from creak.report.thesis.sections.node import method_ratios
from creak.report.thesis.sections.participation import right_and_wrong
from creak.report.thesis.sections.ranges import enough
from creak.report.thesis.sections.spacing import captured_modes, slower_than_reference
from creak.report.thesis.words import (
    CLOSE,
    biases,
    by_load,
    captured,
    fit,
    listed,
    predicts,
    same_events,
    worst_fit_change,
)
from creak.studies.thesis.record import RecordStudy

NOT_RUN = "not run"


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
    if record is None:
        return Finding("signal", told, NOT_RUN, "not run")
    same = record.drift > record.peak and abs(record.mean) < 1e-3 * record.peak
    words = (
        f"Drift {number(record.drift / 1e3, 3)} m, then none; true motion back within {number(record.error_max, 2)} mm."
    )
    return Finding("signal", told, words, "same" if same else "differs")


def _spacing_cost(facts: Facts) -> Finding:
    told = "Too many retained dofs cost more than the unreduced model (C1: 1.25 times)."
    reference, c1 = facts.usual_cpu("Ref C"), facts.usual_cpu("C1")
    if reference is None or c1 is None:
        return Finding("spacing", told, NOT_RUN, "not run")
    over = slower_than_reference(facts)
    words = f"Plain Newton: C1 {number(c1 / reference, 3)} times the unreduced model"
    words += f"; {listed(over)} above it." if over else "; none above it at this mesh size."
    return Finding("spacing", told, words, "same" if over else "explained")


def _spacing_mac(facts: Facts) -> Finding:
    told = "Retaining fewer interface nodes loses modes: C5 keeps 8 to 12."
    first, last = facts.case("C1"), facts.case("C5")
    if first is None or last is None or not last.mac:
        return Finding("spacing", told, NOT_RUN, "not run")
    kept, of = captured_modes(facts, "C5"), len(last.mac)
    words = f"C1 keeps {captured_modes(facts, 'C1')} of {len(first.mac)} modes, C5 {kept} of {of} (MAC 0.9 or more)."
    return Finding("spacing", told, words, "same" if kept < captured_modes(facts, "C1") else "differs")


def _range(facts: Facts) -> Finding:
    told = "Fixed-interface modes up to 11 (A1–A3) or 13 (A4) times the excitation suffice."
    found = enough(facts)
    if not found:
        return Finding("range", told, NOT_RUN, "not run")
    words = by_load({k: f"{f / 100:.0f} times" for k, f in found.items()})
    return Finding(
        "range",
        told,
        f"NRMSE within 0.01 of its last value from {words}.",
        "same" if all(f <= 1300 for f in found.values()) else "differs",
    )


def _distance(facts: Facts) -> Finding:
    told = "More unreduced elements near the contact (D40, D90) gain nothing."
    spread = worst_fit_change(facts, ("D40", "D90"), "D8")
    alike = [same_events(facts, n, "D8") for n in ("D40", "D90")]
    if spread is None or None in alike:
        return Finding("distance", told, NOT_RUN, "not run")
    words = f"NRMSE changes by {spread:.4f} at most; events {'the same' if all(alike) else 'not all the same'}."
    return Finding("distance", told, words, "same" if spread <= CLOSE else "differs")


def _time(facts: Facts) -> Finding:
    told = "D8 finds nearly all contact events within 10 ms (1 missed, 3 extra)."
    reference, common, extra = captured(facts, "D8")
    if not reference:
        return Finding("distance", told, NOT_RUN, "not run")
    words = f"{common} of {reference} events found, {extra or 'none'} extra."
    return Finding("distance", told, words, "same" if predicts(facts, "D8") else "differs")


def _force(facts: Facts) -> Finding:
    told = "The reduced model's forces are higher: +21.7, +18.2, +6.0 %."
    found = [a.force_ratio for a in facts.agreements("D8").values() if a.force_ratio is not None]
    if not found:
        return Finding("distance", told, NOT_RUN, "not run")
    mark: Mark = "same" if all(r > 1.05 for r in found) else "explained" if _step_told(facts) else "differs"
    return Finding("distance", told, f"Mean force {biases(facts, 'D8')}.", mark)


def _step_told(facts: Facts) -> bool:
    """Whether the runs with a quarter of the step are there to explain the forces."""
    return facts.agreement("D8 h/4", "A4") is not None


def _level(facts: Facts) -> Finding:
    told = "The level of contact has little effect on the prediction, though the NRMSE falls from A1 to A4."
    first, last = facts.fit("D8", "A1"), facts.fit("D8", "A4")
    if first is None or last is None:
        return Finding("distance", told, NOT_RUN, "not run")
    return Finding(
        "distance", told, f"NRMSE {fit(first)} (A1), {fit(last)} (A4).", "same" if last <= first else "differs"
    )


def _participation(facts: Facts) -> Finding:
    told = "Leaving out dofs of little participation: right to P35, wrong from P37."
    right, wrong = right_and_wrong(facts)
    if not {"P35", "P37"} <= {*right, *wrong}:
        return Finding("participation", told, NOT_RUN, "not run")
    words = f"Right: {listed(right)}; wrong: {listed(wrong)}."
    same = "P35" in right and wrong[:1] == ["P37"]
    if not same and right and wrong:
        words += f" The loss is as sudden, between {right[-1]} and {wrong[0]}: where it comes depends on the model."
    mark: Mark = "same" if same else "explained" if right and wrong else "differs"
    return Finding("participation", told, words, mark)


def _coarse(facts: Facts) -> Finding:
    told = "A coarser mesh on the interface (M2) keeps the events and saves 32.5 %."
    reference, common, extra = captured(facts, "M2")
    usual, own = saving(facts, True), saving(facts, False)
    if not reference:
        return Finding("coarse", told, NOT_RUN, "not run")
    cost = "; ".join(
        f"{label} {number(100.0 * s, 3)} %"
        for label, s in (("plain Newton saves", usual), ("creak's step", own))
        if s is not None
    )
    words = f"{common} of {reference} events, {extra or 'none'} extra{'; ' + cost if cost else ''}."
    if predicts(facts, "M2") and (usual or 0.0) > 0.1:
        return Finding("coarse", told, words, "same")
    events, found, more = captured(facts, OWN)
    if not events:
        return Finding("coarse", told, words, "differs")
    good = predicts(facts, OWN)
    words += f" Against the unreduced model of its mesh {found} of {events}, {more or 'none'} extra: the mesh moves "
    words += "the events, the reduction loses none." if good else "the events, and so does the reduction."
    return Finding("coarse", told, words, "explained" if good else "differs")


def _methods(facts: Facts) -> Finding:
    told = "Node to surface gives higher forces than surface to surface: +68, +73, +42 %."
    ratios = method_ratios(facts)
    if not ratios:
        return Finding("node", told, NOT_RUN, "not run")
    words = f"Mean force {by_load({k: percent(r) for k, r in ratios.items()})}."
    return Finding("node", told, words, "same" if all(r > 1.05 for r in ratios.values()) else "differs")


def _overshoot(facts: Facts) -> Finding:
    told = "Reduced, node to surface overshoots its reference: +338, +182, +174 %."
    found = [a.force_ratio for a in facts.agreements("Red NtS").values() if a.force_ratio is not None]
    if not found:
        return Finding("node", told, NOT_RUN, "not run")
    words = f"Mean force {biases(facts, 'Red NtS')}."
    return Finding("node", told, words, "same" if all(r > 1.5 for r in found) else "differs")


def _cost(facts: Facts) -> Finding:
    told = "The reduced model takes 97.9 % less CPU time."
    usual, own = saved(facts, "D8", True), saved(facts, "D8", False)
    if usual is None and own is None:
        return Finding("cost", told, NOT_RUN, "not run")
    texts = (NONE if s is None else f"{number(100.0 * s, 3)} %" for s in (usual, own))
    words = f"Plain Newton {next(texts)}, creak's own step {next(texts)} less."
    return Finding("cost", told, words, "same" if max(usual or 0.0, own or 0.0) > 0.9 else "differs")


def _interface(facts: Facts) -> Finding:
    told = "The number of interface dofs decides the CPU time."
    names = [n for n in ("D8", "D40", "D90") if facts.own_cpu(n) is not None]
    usual = [n for n in names if facts.usual_cpu(n) is not None]
    if len(names) < 2:
        return Finding("cost", told, NOT_RUN, "not run")
    own = (facts.own_cpu(names[-1]) or 0.0) / (facts.own_cpu(names[0]) or 1.0)
    words = f"{names[-1]} over {names[0]}: creak's own step {number(own, 3)}"
    if len(usual) > 1:
        words += f", plain Newton {number((facts.usual_cpu(usual[-1]) or 0.0) / (facts.usual_cpu(usual[0]) or 1.0), 3)}"
    behind = slower(facts, timed(facts), False)
    words += f"; slower than unreduced in creak: {listed(behind)}."
    return Finding("cost", f"{told} (D90 over D8: 1.37)", words, "explained" if own < 1.37 else "same")


def _generalised(facts: Facts) -> Finding:
    told = "Generalised interface dofs could help, but the solver could not use them."
    if not facts.ran(("X50", "X100", "X200")):
        return Finding("generalised", told, NOT_RUN, "not run")
    return Finding("generalised", told, interface_words(facts), "explained" if smallest_good(facts) else "differs")
