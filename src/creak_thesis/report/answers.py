"""The thesis's questions, recommendations and open points, answered from creak's runs."""

from __future__ import annotations

from creak.report_tools import number, percent
from creak_thesis.report.blocks import Answer
from creak_thesis.report.facts import Facts
from creak_thesis.report.sections.beyond import interface_words, play_words, smallest_good, step_words
from creak_thesis.report.sections.coarse import saving
from creak_thesis.report.sections.cost import saved, timed
from creak_thesis.report.sections.node import method_ratios
from creak_thesis.report.sections.participation import right_and_wrong
from creak_thesis.report.sections.ranges import enough
from creak_thesis.report.sections.spacing import captured_modes
from creak_thesis.report.words import (
    CLOSE,
    biases,
    by_load,
    captured,
    events_words,
    fits,
    listed,
    predicts,
    same_events,
    worst_fit_change,
)

NO_RUN = "The cases that would tell were not run."


def questions(facts: Facts) -> list[Answer]:
    """The five of section 1.2."""
    return [
        Answer(
            "Can the Craig-Bampton method be used for squeak and rattle with contact without losing the prediction?",
            "Yes in time; forces come out higher.",
            _accuracy(facts),
        ),
        Answer(
            "How sensitive is the area around the interface?",
            "Very sensitive to dofs left uncoupled, not to how many elements stay unreduced.",
            _sensitivity(facts),
        ),
        Answer(
            "How close to the interface can dofs be removed?",
            "Up to the contact elements: D8 is as good as D40 and D90.",
            _closeness(facts),
        ),
        Answer(
            "Can the reduction be adjusted to make the simulation more efficient?",
            "Yes: coarser mesh −32.5 %, fewer fixed-interface modes −3.5 %, dofs of little participation −3.2 %.",
            _efficiency(facts),
        ),
        Answer(
            "What is the correlation between cost, number of dofs and accuracy?",
            "Cost follows the interface dofs; accuracy does not grow with the dofs near the contact.",
            _correlation(facts),
        ),
    ]


def recommendations(facts: Facts) -> list[Answer]:
    """The four of section 5.2."""
    return [
        Answer("Use surface to surface contact; the method then works well.", "", _accuracy(facts)),
        Answer("Do not define the contact on the retained dofs (node to surface).", "", _nodes(facts)),
        Answer("Couple the substructures directly to the contact elements.", "", _closeness(facts)),
        Answer("Coarsen the mesh along the interface to have fewer interface dofs.", "", _coarsen(facts)),
    ]


def open_points(facts: Facts) -> list[Answer]:
    """The four of section 5.3."""
    return [
        Answer("Would a smaller time step remove the differences in force?", "", step_words(facts)),
        Answer("Does the method hold for other nonlinearities, such as the hooks with play?", "", play_words(facts)),
        Answer("Can generalised interface dofs make it faster still?", "", interface_words(facts)),
        Answer("Why does the reduced node to surface model overshoot?", "", _overshoot(facts)),
    ]


def _accuracy(facts: Facts) -> str:
    reference, common, extra = captured(facts, "D8")
    if not reference:
        return NO_RUN
    text = "Yes. " if predicts(facts, "D8") else "Not without loss on this door. "
    return text + (
        f"D8 finds {common} of {reference} events within 10 ms, {extra or 'none'} extra; mean force "
        f"{biases(facts, 'D8')}; "
        f"NRMSE {fits(facts)}."
    )


def _sensitivity(facts: Facts) -> str:
    parts = []
    if facts.case("C1") is not None and facts.case("C5") is not None:
        few, every = captured_modes(facts, "C5"), captured_modes(facts, "C1")
        parts.append(f"With every 16th interface node coupled {few} modes survive, with every one {every}.")
    right, wrong = right_and_wrong(facts)
    if right or wrong:
        parts.append(f"Of the participation cases {listed(right)} keep the events and {listed(wrong)} do not.")
    if facts.case("I3") is not None:
        parts.append(f"With every third node retained and the others interpolated (I3): {events_words(facts, 'I3')}.")
    if predicts(facts, "I3") and wrong:
        parts.append("What counts is that every interface dof moves with the substructure, not how many are retained.")
    return " ".join(parts) if parts else NO_RUN


def _closeness(facts: Facts) -> str:
    spread = worst_fit_change(facts, ("D40", "D90"))
    if spread is None:
        return NO_RUN
    alike = all(bool(same_events(facts, n)) for n in facts.ran(("D40", "D90")))
    events = "the same" if alike else "not all the same"
    text = f"From D8 to D90 the NRMSE changes by {spread:.4f} at most and the events are {events}. "
    change = worst_fit_change(facts, ("CB",))
    if change is not None:
        text += (
            f"creak can go further: without any unreduced element (CB, contact on retained nodes of the panel and the "
            f"frame, surface to surface) the NRMSE differs from D8 by {change:.4f} at most."
        )
    return text


def _efficiency(facts: Facts) -> str:
    parts = []
    for label, usual in (("with plain Newton", True), ("in creak's own step", False)):
        s = saving(facts, usual)
        if s is not None:
            parts.append(f"M2 saves {number(100.0 * s, 3)} % of D8 {label}")
    of = facts.usual_cpu("D8")
    for name in ("P35", "I3", "X100"):
        cpu = facts.usual_cpu(name)
        if cpu is not None and of:
            parts.append(f"{name} changes the cost of D8 by {percent(cpu / of)} with plain Newton")
    found = enough(facts)
    if found:
        parts.append(f"modes up to {max(found.values())} Hz suffice for all loads")
    return f"{'; '.join(parts)}." if parts else NO_RUN


def _correlation(facts: Facts) -> str:
    names = timed(facts)
    usual, own = saved(facts, "D8", True), saved(facts, "D8", False)
    if not names or (usual is None and own is None):
        return NO_RUN
    most, least = (f(names, key=lambda n: facts.all_retained(n) or 0) for f in (max, min))
    text = f"Retained coordinates range from {number(facts.all_retained(least) or 0)} ({least}) to "
    text += f"{number(facts.all_retained(most) or 0)} ({most}). "
    pairs = (
        ("plain Newton", facts.usual_cpu(least), facts.usual_cpu(most)),
        ("creak's own step", facts.own_cpu(least), facts.own_cpu(most)),
    )
    for label, a, b in pairs:
        if a and b is not None:
            text += f"The larger costs {number(b / a, 3)} times the smaller with {label}. "
    spread = worst_fit_change(facts, ("D40", "D90"))
    if spread is not None and spread <= CLOSE and captured_modes(facts, "C5") < captured_modes(facts, "C1"):
        text += "Accuracy depends on whether the interface is coupled fully, not on the number of dofs near it."
    return text.rstrip()


def _nodes(facts: Facts) -> str:
    ratios = method_ratios(facts)
    found = facts.agreements("Red NtS")
    if not ratios and not found:
        return NO_RUN
    text = ""
    if ratios:
        higher = by_load({k: percent(r) for k, r in ratios.items()})
        text = f"Node to surface against surface to surface, unreduced: {higher}. "
    if found:
        text += f"Reduced against its reference: {biases(facts, 'Red NtS')}; {events_words(facts, 'Red NtS')}. "
        worst, usual = _worst(facts, "Red NtS"), _worst(facts, "D8")
        if worst < 0.1:
            text += "Here the reduced model keeps the force with this contact too: the advice is not about the method."
        elif worst > 2.0 * usual:
            text += "The advice holds here too: surface to surface (D8) is closer to its reference."
        else:
            text += "Surface to surface (D8) is not clearly closer to its reference."
    return text


def _worst(facts: Facts, name: str) -> float:
    """Largest deviation of the mean force from the reference's, over the loads."""
    return max((abs((a.force_ratio or 1.0) - 1.0) for a in facts.agreements(name).values()), default=0.0)


def _coarsen(facts: Facts) -> str:
    usual, own = saving(facts, True), saving(facts, False)
    if usual is None and own is None:
        return NO_RUN
    text = _efficiency(facts).split(";")[0] + ". "
    if own is not None:
        text += f"In creak's own step M2 saves {number(100.0 * own, 3)} % of D8. "
    best = smallest_good(facts)
    if best:
        text += f"Where the solver takes generalised interface coordinates, {best} does the same without a new mesh."
    return text


def _overshoot(facts: Facts) -> str:
    found = facts.agreements("Red NtS")
    if not found:
        return NO_RUN
    worst = _worst(facts, "Red NtS")
    text = f"In creak the reduced model stands {biases(facts, 'Red NtS')} from its reference. "
    if worst < 0.1:
        text += (
            "With the same channels, the same stiffness and the same step on both models there is no overshoot, so "
            "what the thesis saw does not follow from the reduction itself; how its solver sets the contact "
            "stiffness of a substructure's nodes is the place to look. "
        )
    elif facts.agreements("D8 NtS"):
        text += f"With the contact elements unreduced (D8 NtS) it is {biases(facts, 'D8 NtS')}. "
    return text
