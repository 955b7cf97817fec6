"""A proposed study as TOML with comments."""

from __future__ import annotations

from creak.assembly.part import is_damped
from creak.model.mesh import Model
from creak.studies.file.schema import SCHEMA_FILE
from creak.studies.file.toml_text import toml_value
from creak.studies.propose.proposal import Contact, Proposal

F_MAX = 100.0
"""Hz up to which a road excites."""
DAMPING = 0.02
"""Fraction of critical."""
AMPLITUDE = 5e-6
"""m: of each sine of the proposed motion."""
FORCE = 0.1
"""N: of each sine of the proposed force."""
SHOWN = 12
"""Sets of supports that a comment names."""


def proposal_text(found: Proposal, model: Model, deck: str, title: str, missing: str = "") -> str:
    """The study file: it reads and sets up as it is where the deck has what is needed.

    Parameters
    ----------
    deck : path of the deck, relative to the study file.
    missing : what keeps the study from running as it is; empty: nothing does.
    """
    blocks = [
        [f"#:schema ./{SCHEMA_FILE}", f"title = {toml_value(title)}"],
        [f"# To be filled in before it runs: {missing}"] if missing else [],
        _model(found, model, deck),
        *_contacts(found),
        _supports(found),
        _excitation(found),
        _damping(model),
        _reduction(),
        _precheck(found),
        _time(found),
        ["[reference]", _line("run", "spots", 'single events of the unreduced model; "whole": all of its run; "none"')],
        _output(found),
        _verification(found),
    ]
    return "\n\n".join("\n".join(lines) for lines in blocks if lines) + "\n"


def _line(key: str, value: object, comment: str) -> str:
    return f"{f'{key} = {toml_value(value)}':<37} # {comment}"


def _model(found: Proposal, model: Model, deck: str) -> list[str]:
    lines = ["[model]", f"deck = {toml_value(deck)}", _line("units", found.units.name, found.guess)]
    unread = [u for u in model.unread if u.changes_answer]
    if unread:
        lines += [
            "# To be decided: the deck says more than creak reads. `creak run` stops at these unless it is told",
            "# --ignore KEYWORD:",
        ]
        lines += [f"#   {u.keyword} ({u.where}): {u.why}" for u in unread[:SHOWN]]
    return lines


def _contacts(found: Proposal) -> list[list[str]]:
    unit = found.units.words[0]
    if not found.contacts:
        lines = [f"# No surfaces of two parts come within {found.distance:.3g} {unit} of each other."]
        if found.closest is None:
            lines.append("# All elements hang together: contact within a part needs surfaces of it.")
        if found.closest is not None:
            a, b, gap = found.closest
            lines.append(
                f"# The nearest nodes are those of {a} and {b}: {gap:.3g} {unit}. Look farther with "
                f"`creak new --distance {1.5 * gap:.2g}`."
            )
        return [
            [
                *lines,
                "# To be filled in by hand:",
                "# [contact.NAME]",
                '# secondary = "SURFACE OR ELEMENT SET"',
                '# main = "SURFACE OR ELEMENT SET"',
            ]
        ]
    head = [
        f"# Contacts: surfaces of different parts nearer than {found.distance:.3g} {unit} (`creak new --distance`), by "
        "the names",
        "# in the deck that fit best. Delete those that cannot touch.",
    ]
    blocks = [_contact(c, found) for c in found.contacts]
    return [[*head, *blocks[0]], *blocks[1:]]


def _contact(c: Contact, found: Proposal) -> list[str]:
    unit = found.units.words[0]
    how = f"{c.gap:.3g} {unit} apart" if c.gap >= 0.0 else f"{-c.gap:.3g} {unit} inside each other"
    lines = [
        f"# {c.secondary} and {c.main}: {how} at node {c.place}; "
        f"{c.near} elements are near, {c.secondary} has {c.elements}."
    ]
    if c.elements > 3 * c.near:
        lines.append("# A *SURFACE or *ELSET of the near elements alone would make the study faster.")
    if c.problem:
        lines += [f"# To be filled in, because {c.problem}.", f"# [contact.{c.name}]"]
        return [*lines, f"# secondary = {toml_value(c.secondary)}", f"# main = {toml_value(c.main)}"]
    return [
        *lines,
        f"# {c.channels} gap channels, open by {c.start:.3g} {unit} or more; the pre-check keeps those that a "
        "linear run all but closes.",
        f"[contact.{c.name}]",
        _line("secondary", c.secondary, "its nodes become the gap channels"),
        _line("main", c.main, "what they may touch"),
        _line("stiffness", "auto", "from the elements, no stiffer than the step resolves"),
        _line("friction", 0.0, "coefficient; squeak needs one"),
    ]


def _supports(found: Proposal) -> list[str]:
    if not found.n_held:
        return ["# Supports: the deck holds nothing (no *BOUNDARY, no SPC). Every part must be held, linked or driven."]
    lines = [f"# Supports: the deck holds {found.n_held} node(s)."]
    lines += [f"#   {name}: {dofs}" for name, dofs in list(found.held.items())[:SHOWN]]
    return [*lines, "#   ..."] if len(found.held) > SHOWN else lines


def _excitation(found: Proposal) -> list[str]:
    if found.drive is None:
        return [
            f"# Excitation: to be filled in, because {found.undriven}.",
            "# [excitation.road]",
            '# node_set = "NODE SET"',
            '# dof = "z"',
            '# kind = "displacement"',
            f'# signal = {{ type = "multisine", f_min = 1, f_max = {F_MAX:g}, amplitude = '
            f"{AMPLITUDE / found.units.length:g} }}",
        ]
    d, unit = found.drive, found.units.words[0]
    force = d.kind == "force"
    amplitude = FORCE if force else AMPLITUDE / found.units.length
    return [
        f"# Excitation: {d.node_set}, because {d.why}.",
        *([f"# As well: {', '.join(d.others)}."] if d.others else []),
        *(["# Prescribed motion needs a support of which the deck leaves one direction free."] if force else []),
        "[excitation.road]",
        _line("node_set", d.node_set, "all its nodes get the same signal"),
        _line("dof", d.dof, "the direction"),
        _line("kind", d.kind, "on each node" if force else "or velocity, acceleration; force on free nodes"),
        "",
        "[excitation.road.signal]",
        _line("type", "multisine", "sines of equal amplitude and random phase: a rough road"),
        _line("f_min", 1.0, "Hz"),
        _line("f_max", F_MAX, "Hz"),
        _line("amplitude", amplitude, f"{'N' if force else unit}, of each sine: raise it until the parts touch"),
        _line("period", 1.0, "s"),
        _line("seed", 1, "of the phases"),
    ]


def _damping(model: Model) -> list[str]:
    """None where the deck says it."""
    if is_damped(model):
        return []
    return [
        "# Damping: the deck has none. Without any no vibration dies out, and each blow decides over all that follow.",
        f"# {100.0 * DAMPING:g} % of critical is usual for trim and sheet metal that are clipped or screwed together; "
        "1 to 5 % is measured.",
        "[damping]",
        _line("modal", DAMPING, "fraction of critical of every mode"),
    ]


def _reduction() -> list[str]:
    return [
        "# `creak advise` looks closer: retained dofs, f_max and what they cost, with the errors to expect.",
        "[reduction]",
        _line("method", "craig-bampton", "or guyan, gap-modes, none"),
        _line("f_max", "auto", "modes kept: as far as it takes until more change nothing; or Hz"),
    ]


def _precheck(found: Proposal) -> list[str]:
    return [
        "[precheck]",
        _line("enabled", True, "keep contact only where a linear run closes the gap"),
        _line("margin", "auto", "what may stay open without contact: 15 % of each gap; or a length"),
    ]


def _time(found: Proposal) -> list[str]:
    long = _line("periods", 5, "of the excitation") if found.drive is not None else _line("end", 1.0, "s")
    return ["[time]", long, _line("accuracy", "settled", "or quick, fine; steps follow from it")]


def _output(found: Proposal) -> list[str]:
    if not found.outputs:
        return ["# [output]", '# nodes = ["NODE SET"]                # sets whose motion is to be kept']
    return ["[output]", _line("nodes", list(found.outputs), "node sets whose motion is kept")]


def _verification(found: Proposal) -> list[str]:
    lines = ["[verification]"]
    if found.pairs is not None:
        value = found.pairs if isinstance(found.pairs, str) else list(found.pairs)
        lines.append(_line("pairs", value, "main and secondary nodes in turn: motion and modes are compared there"))
    else:
        lines.append('# pairs = ["MAIN NODES", "SECONDARY NODES"]  # two node sets across a contact, to compare motion')
    return [
        *lines,
        _line("f_max", 500.0, "Hz, spectra and low-passed forces"),
        _line("mac_f_max", F_MAX, "Hz, mode shapes"),
    ]
