"""How the answer was computed, in words and as a list of parameters."""

from __future__ import annotations

from typing import Any

from creak.model.units import Units
from creak.report.words.text import number, plural, share, tidy
from creak.studies.file.config import ReductionTable, TimeTable, VerificationTable
from creak.studies.file.contact_tables import ClipTable, ConnectorTable, ContactTable, FrictionTable, connector_names
from creak.studies.file.excitation_tables import ExcitationTable
from creak.studies.file.model_tables import SupportTable
from creak.studies.findings.tree import Findings
from creak.words import duration

KINDS = {
    "displacement": "enforced displacement",
    "force": "force",
    "velocity": "enforced velocity",
    "acceleration": "base motion (acceleration)",
}


def paragraph(result: Findings) -> str:
    """The method of this study in a few sentences."""
    c = result.setup.study.config
    words = ["The structure is linear; only the gaps between parts, one scalar channel each, are not."]
    words += _reduced(c.reduction)
    if result.linear_gaps is not None:
        words.append(
            "A linear run decided beforehand which contact channels can close at all; the others were left out of all "
            "runs."
        )
    laws = _laws(list(c.contact.values()))
    if c.time.exact:
        given = (
            c.connector or c.clip or any(t.stiffness != "auto" or t.overclosure is not None for t in c.contact.values())
        )
        by_itself = "step" if given else "step, stiffness"  # what follows from the model alone
        words.append(
            "Between contacts the modes move exactly; where a gap may close, steps are halved down to the time scale "
            f"of the contact itself ({laws}). No {by_itself} or scheme was chosen by hand; the accuracy asked for "
            f"is {c.time.accuracy!r}."
        )
    else:
        words.append(
            f"Time integration is {_scheme(c.time)} and a step of {tidy(1e3 * c.time.step)} ms, as the study says. The "
            f"contact forces of each step are solved for exactly on the channels alone ({laws})."
        )
    words.append(
        f"{_merging(c.verification)} count as one event. The raw peak of a penalty contact depends on step and "
        f"stiffness; the peak low-passed at {tidy(c.verification.f_max)} Hz and the impulse do not, so these are "
        "compared."
    )
    return " ".join(words)


def _merging(v: VerificationTable) -> str:
    """Which touches are one event."""
    if v.merge is not None:
        return f"Touches of one side less than {tidy(1e3 * v.merge)} ms apart"
    return (
        f"Touches of one side that are parted for less than {tidy(500.0 / v.f_max)} ms, which the low-pass cannot "
        "show, or for less than they last"
    )


def _time(t: TimeTable) -> str:
    """Accuracy, or step and scheme."""
    return f"accuracy {t.accuracy}" if t.exact else f"step {tidy(1e3 * t.step)} ms, {_scheme(t)}"


def _scheme(t: TimeTable) -> str:
    """The time integration with its parameter."""
    if t.integrator == "generalised-alpha":
        return f"generalised-alpha with rho = {tidy(t.rho_inf)} at infinite frequency"
    return f"HHT-alpha with alpha = {tidy(t.alpha)}" if t.integrator == "hht" else f"the {t.integrator} scheme"


def _laws(contacts: list[ContactTable]) -> str:
    """The laws that the channels of a study follow."""
    words = ["springs that act in compression only"]
    if any(t.overclosure is not None for t in contacts):
        words.append("measured curves of pressure")
    if any(t.stiffness == "hard" for t in contacts):
        words.append("hard contact without penetration")
    if any(isinstance(t.friction, FrictionTable) or t.friction for t in contacts):
        words.append("Coulomb friction with sticking and sliding")
    return ", ".join(words)


def _up_to(t: ReductionTable, summary: dict[str, Any] | None = None) -> str:
    """How far its modes go."""
    if t.f_max != "auto":
        return f"up to {tidy(t.f_max)} Hz"
    found = (summary or {}).get("runs", {}).get("reduced", {}).get("f_max")
    return "as far as it took until more of them changed nothing" if found is None else f"up to {tidy(found)} Hz (auto)"


def _reduced(t: ReductionTable) -> list[str]:
    """What the reduction did."""
    diagonal = "The result was then diagonalised, keeping all its coordinates."
    if t.method == "none":
        return []
    if t.method == "gap-modes":
        return [
            f"The assembly was reduced to its modes {_up_to(t)} and one static shape per gap channel, so that "
            f"contact is exact in statics. {diagonal}"
        ]
    modes = "nothing else (Guyan)" if t.method == "guyan" else f"its fixed-interface modes {_up_to(t)}"
    return [
        f"Each part was reduced to the degrees of freedom at links, supports, loads, contact and watched nodes, "
        f"and {modes}. {diagonal}"
    ]


def parameters(result: Findings, summary: dict[str, Any], units: Units) -> list[tuple[str, str]]:
    """Name and value of what decides the answer."""
    c, setup = result.setup.study.config, result.setup
    connectors = connector_names(c.connector)
    rows = [
        ("Study file", setup.study.path.name),
        ("Deck", c.model.deck),
        ("Units", f"{c.model.units}: {units.length}, {units.force}, s, energies in {units.energy}"),
        ("Damping", _damping(result)),
        *((f"Excitation {name}", _excitation(table, units)) for name, table in c.excitation.items()),
        *((f"Contact {name}", _contact(result, name, units)) for name in c.contact),
        *((f"Connector {name}", _connector(t, units)) for name, t in zip(connectors, c.connector, strict=True)),
        *((f"Clip {t.name or i}", _clip(t, units)) for i, t in enumerate(c.clip, start=1)),
        *((f"Support {name}", _support(t)) for name, t in c.support.items()),
        ("Reduction", _reduction(result, summary, units)),
        *_stages(summary),
        ("Pre-check", f"margin {c.precheck.words(units.length)}" if c.precheck.enabled else "off"),
        ("Time", _time(c.time)),
        ("Verification", _verification(result)),
    ]
    if summary.get("seeds"):
        rows.append(("Seeds", ", ".join(f"{name} {seed}" for name, seed in summary["seeds"].items())))
    return [*rows, ("creak", str(summary["creak"]))]


def _damping(result: Findings) -> str:
    table, r = result.setup.study.config.damping, result.setup.rayleigh
    if table.modal is not None:
        return f"modal, {share(table.modal)} of critical"
    if table.from_test is not None:
        return f"modal, measured: {table.from_test}"
    source = "" if table.rayleigh is not None else " (deck)"
    if not (r.alpha or r.beta):
        return f"none{source}"
    return f"Rayleigh, alpha {number(r.alpha)} 1/s, beta {number(r.beta)} s{source}"


def _excitation(table: ExcitationTable, units: Units) -> str:
    length, force = units.length, units.force
    if table.dof.startswith("r"):
        length, force = "rad", f"{units.force} {units.length}"
    unit = {"displacement": length, "force": force, "acceleration": f"{length}/s²", "velocity": f"{length}/s"}[
        table.kind
    ]
    return f"{KINDS[table.kind]} of {table.node_set} along {table.dof}: {table.signal.words(unit, tidy)}"


def _contact(result: Findings, name: str, units: Units) -> str:
    t = result.setup.study.config.contact[name]
    words = [f"{t.secondary} on {t.main}", t.method, _law(t, units)]
    if t.damping and t.stiffness != "hard":
        words.append(f"damping {tidy(t.damping)} {_per_area(t, f'{units.force} s/{units.length}', units)}")
    if isinstance(t.clearance, str):
        words.append(f"clearances of the table {t.clearance}")
    elif t.clearance is not None:
        words.append(f"clearance set to {tidy(t.clearance)} {units.length}")
    if t.normal is not None:
        words.append(f"normal ({', '.join(tidy(x) for x in t.normal)})")
    return ", ".join([*words, _friction(t, units)])


def _law(t: ContactTable, units: Units) -> str:
    """How the contact answers to being closed."""
    if t.overclosure is not None:
        what = "pressure" if t.method == "surface-to-surface" else "force"
        deep = f"{tidy(t.overclosure[-1][0])} {units.length}"
        return f"{what} by a curve of {len(t.overclosure)} points up to {deep} deep"
    if t.stiffness == "hard":
        return "hard: no penetration at all"
    if t.stiffness == "auto":
        return "stiffness automatic, from the parent elements"
    return f"stiffness {tidy(t.stiffness)} {_per_area(t, units.stiffness, units)}"


def _per_area(t: ContactTable, unit: str, units: Units) -> str:
    """The unit, per area for surface-to-surface: N/mm becomes N/mm³."""
    return unit.replace(f"/{units.length}", f"/{units.length}³") if t.method == "surface-to-surface" else unit


def _friction(t: ContactTable | ConnectorTable, units: Units) -> str:
    if not isinstance(t.friction, FrictionTable):
        return f"friction {tidy(t.friction)}" if t.friction else "no friction"
    fall = f", falling over {tidy(t.friction.decay)} {units.length}/s" if t.friction.decay else ""
    return f"friction {tidy(t.friction.static)} sticking, {tidy(t.friction.kinetic)} sliding{fall}"


def _connector(t: ConnectorTable, units: Units) -> str:
    ends = " to ".join(t.node_sets) if len(t.node_sets) == 2 else f"{t.node_sets[0]} to ground"
    unit, force = units.of_motion(t.turns)
    lower, upper = (f"{tidy(x)} {unit}" if x is not None else "free" for x in (t.lower, t.upper))
    along = f"along ({', '.join(tidy(x) for x in t.axis)})" if t.axis is not None else str(t.dof)
    law = "hard" if t.stiffness == "hard" else f"stiffness {tidy(t.stiffness)} {force}/{unit}"
    preload = f", preload {tidy(t.preload)} {force}" if t.preload else ""
    rubs = f", {_friction(t, units)}" if t.friction else ""
    return f"{ends}, {along} from {lower} to {upper}, {law}{preload}{rubs}"


def _clip(t: ClipTable, units: Units) -> str:
    what = f"{t.use} of the library" if t.use else f"{t.type}"
    ends = " to ".join(t.node_sets or t.part_names)
    where = f"{ends}{'' if len(t.node_sets or t.part_names) == 2 else ' to ground'}"
    unit = {"stiffness": units.stiffness, "pull_out": units.force}
    given = [f"{key} {tidy(value)} {unit[key]}" for key in unit if isinstance(value := getattr(t, key), float)]
    aged = [f"{100.0 * t.ageing:g} % left by age"] if t.ageing != 1.0 else []
    return ", ".join([f"{what}, {where}", *given, *aged])


def _support(t: SupportTable) -> str:
    said = [f"{', '.join(t.free)} freed"] if t.free else []
    said += [f"{', '.join(t.hold)} held"] if t.hold else []
    return f"{t.nodes}: {' and '.join(said)}"


def _reduction(result: Findings, summary: dict[str, Any], units: Units) -> str:
    t = result.setup.study.config.reduction
    if t.method == "none":
        return "none: the unreduced model alone"
    kept = f", mesh within {tidy(t.keep_out)} {units.length} of the contact left unreduced" if t.keep_out else ""
    return f"{t.method}, modes {_up_to(t, summary)}, interface {t.interface.type}{kept}"


def _stages(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """In which stages f_max was found."""
    run = summary.get("runs", {}).get("reduced", {})
    told = [
        f"{tidy(s['f_max'])} Hz, {number(s['modes'])} modes: {plural(s['events'], 'event')}, {duration(s['wall_s'])}"
        for s in run.get("stages", [])
    ]
    if not told:
        return []
    ended = run.get("stages_ended")
    return [("Stages of f_max", "; ".join(told) + (f"; {ended}" if ended else ""))]


def _verification(result: Findings) -> str:
    v = result.setup.study.config.verification
    start, end = result.window
    return (
        f"window {tidy(start)} to {tidy(end)} s, spectra and low-pass to {tidy(v.f_max)} Hz, modes to "
        f"{tidy(v.mac_f_max)} Hz, events within {tidy(1e3 * v.event_tolerance)} ms, "
        f"{result.setup.pairs.shape[0]} node pairs"
    )
