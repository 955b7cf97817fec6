"""How the answer was computed, in words and as a list of parameters."""

from __future__ import annotations

from typing import Any

from creak.report.text import Units, number, share
from creak.studies.config import ExcitationTable, MultisineTable, RecordTable, SineTable, StepTable
from creak.studies.run import StudyResult

KINDS = {
    "displacement": "enforced displacement",
    "force": "force",
    "acceleration": "base motion (acceleration)",
}


def paragraph(result: StudyResult) -> str:
    """The method of this study in a few sentences."""
    c = result.setup.study.config
    words = ["The structure is linear; only the gaps between parts, one scalar channel each, are not."]
    if c.reduction.method != "none":
        words.append(
            "Each part was reduced by Craig-Bampton component mode synthesis to the degrees of freedom at links, supports, "
            f"loads, contact and watched nodes, and its fixed-interface modes up to {number(c.reduction.f_max)} Hz; the coupled "
            "parts were then diagonalised, keeping all modes."
        )
    if result.setup.contacts.m and c.precheck.enabled:
        words.append(
            "A linear run decided beforehand which contact channels can close at all; the others were left out of both runs."
        )
    words.append(
        f"Time integration is HHT-alpha with alpha = {number(c.time.alpha)} and a step of {number(1e3 * c.time.step)} ms. "
        "The contact forces of each step are solved for exactly on the channels alone (penalty springs that act in "
        "compression only)."
    )
    words.append(
        f"Touches less than {number(1e3 * c.verification.merge)} ms apart count as one event. The raw peak of a penalty contact "
        "depends on step and stiffness; the peak low-passed at "
        f"{number(c.verification.f_max)} Hz and the impulse do not, so these are compared."
    )
    return " ".join(words)


def parameters(result: StudyResult, summary: dict[str, Any], units: Units) -> list[tuple[str, str]]:
    """Name and value of what decides the answer."""
    c, setup = result.setup.study.config, result.setup
    rows = [
        ("Study file", setup.study.path.name),
        ("Deck", c.model.deck),
        ("Units", f"{c.model.units}: lengths in {units.length}, forces in {units.force}, time in s, energies in {units.energy}"),
        ("Damping", _damping(result)),
        *((f"Excitation {name}", _excitation(table, units)) for name, table in c.excitation.items()),
        *((f"Contact {name}", _contact(result, name, units)) for name in c.contact),
        *((f"Connector {t.name or '-'.join(t.node_sets)}", _connector(t, units)) for t in c.connector),
        ("Reduction", _reduction(result, units)),
        ("Pre-check", f"margin {number(c.precheck.margin)} {units.length}" if c.precheck.enabled else "off"),
        ("Time", f"step {number(1e3 * c.time.step)} ms, {c.time.integrator}, alpha {number(c.time.alpha)}"),
        ("Verification", _verification(result)),
    ]
    if summary.get("seeds"):
        rows.append(("Seeds", ", ".join(f"{name} {seed}" for name, seed in summary["seeds"].items())))
    return [*rows, ("creak", str(summary["creak"]))]


def _damping(result: StudyResult) -> str:
    table, r = result.setup.study.config.damping, result.setup.rayleigh
    if table.modal is not None:
        return f"modal, {share(table.modal)} of critical"
    source = "" if table.rayleigh is not None else " (deck)"
    if not (r.alpha or r.beta):
        return f"none{source}"
    return f"Rayleigh, alpha {number(r.alpha)} 1/s, beta {number(r.beta)} s{source}"


def _excitation(table: ExcitationTable, units: Units) -> str:
    unit = {"displacement": units.length, "force": units.force, "acceleration": f"{units.length}/s²"}[table.kind]
    turning = table.dof.startswith("r")
    unit = {"displacement": "rad", "force": f"{units.force} {units.length}", "acceleration": "rad/s²"}[table.kind] if turning else unit
    return f"{KINDS[table.kind]} of {table.node_set} along {table.dof}: {_signal(table, unit)}"


def _signal(table: ExcitationTable, unit: str) -> str:
    s = table.signal
    if isinstance(s, MultisineTable):
        return (f"multisine {number(s.f_min)} to {number(s.f_max)} Hz, {number(s.amplitude)} {unit} a line, period "
                f"{number(s.period)} s, seed {s.seed}")  # fmt: skip
    if isinstance(s, SineTable):
        return f"sine, {number(s.frequency)} Hz, {number(s.amplitude)} {unit}"
    if isinstance(s, StepTable):
        return f"step of {number(s.amplitude)} {unit}"
    if isinstance(s, RecordTable):
        return f"record {s.file}, above {number(s.high_pass)} Hz"
    return f"table {s.file}"


def _contact(result: StudyResult, name: str, units: Units) -> str:
    t = result.setup.study.config.contact[name]
    if t.stiffness == "auto":
        stiffness = "automatic, from the shells"
    else:
        per = f"{units.force}/{units.length}³" if t.method == "surface-to-surface" else units.stiffness
        stiffness = f"{number(t.stiffness)} {per}"
    clearance = "" if t.clearance is None else f", clearance set to {number(t.clearance)} {units.length}"
    return f"{t.secondary} on {t.main}, {t.method}, stiffness {stiffness}{clearance}, friction {number(t.friction)}"


def _connector(t: Any, units: Units) -> str:
    ends = " to ".join(t.node_sets) if len(t.node_sets) == 2 else f"{t.node_sets[0]} to ground"
    lower, upper = (number(x) if x is not None else "free" for x in (t.lower, t.upper))
    return f"{ends}, {t.dof} from {lower} to {upper}, stiffness {number(t.stiffness)} {units.stiffness}"


def _reduction(result: StudyResult, units: Units) -> str:
    t = result.setup.study.config.reduction
    if t.method == "none":
        return "none: the unreduced model alone"
    kept = f", mesh within {number(t.keep_out)} {units.length} of the contact left unreduced" if t.keep_out else ""
    return f"{t.method}, modes up to {number(t.f_max)} Hz, interface {t.interface.type}{kept}"


def _verification(result: StudyResult) -> str:
    v = result.setup.study.config.verification
    start, end = result.window
    return (
        f"window {number(start)} to {number(end)} s, spectra and low-pass to {number(v.f_max)} Hz, modes to {number(v.mac_f_max)} Hz, "
        f"events within {number(1e3 * v.event_tolerance)} ms, {result.setup.pairs.shape[0]} node pairs"
    )
