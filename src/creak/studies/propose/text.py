"""A proposed study as TOML with comments."""

from __future__ import annotations

from pathlib import PurePath

from creak.assembly.damping import is_damped, undamped_words
from creak.model.mesh import Model
from creak.model.units import UNITS
from creak.studies.file.schema import SCHEMA_FILE
from creak.studies.file.toml_text import toml_value
from creak.studies.prepare.deck_step import connector_table
from creak.studies.prepare.unit_check import materials
from creak.studies.propose.contact_text import contact_lines, key_line, named_nodes
from creak.studies.propose.proposal import Drive, Proposal
from creak.words import first_few

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
        *_connectors(found),
        _joints(found),
        _supports(found),
        _excitation(found),
        _damping(model),
        _reduction(),
        _precheck(),
        _time(found),
        [
            "[reference]",
            key_line("run", "spots", 'single events of the unreduced model; "whole": all of its run; "none"'),
        ],
        _output(found),
        _verification(found),
    ]
    return "\n\n".join("\n".join(lines) for lines in blocks if lines) + "\n"


def _model(found: Proposal, model: Model, deck: str) -> list[str]:
    lines = ["[model]", f"deck = {toml_value(deck)}", key_line("units", found.units.name, found.guess)]
    told = {stop.where for stop in model.stops}
    unread = [u for u in model.unread if u.changes_answer and not u.damps and u.where not in told]
    if unread:
        lines += [
            "# To be decided: the deck says more than creak reads. `creak run` stops at these unless it is told",
            "# --ignore KEYWORD:",
        ]
        lines += [f"#   {u.keyword} ({u.where}): {u.why}" for u in unread[:SHOWN]]
    return lines


def _contacts(found: Proposal) -> list[list[str]]:
    unit = found.units.words[0]
    apart = [f"# {said[0].upper()}{said[1:]}." for said in found.apart]
    if not found.contacts:
        lines = apart or [f"# No surfaces of two parts come within {found.distance:.3g} {unit} of each other."]
        if found.closest is None:
            lines.append("# All elements hang together: contact within a part needs surfaces of it.")
        if found.closest is not None and not apart:
            a, b, gap = found.closest
            lines.append(
                f"# The nearest nodes are those of {a} and {b}: {gap:.3g} {unit}. Look farther with "
                f"`creak new --distance {1.5 * gap:.2g}`."
            )
        if found.stops:
            return [lines]
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
    blocks = [contact_lines(c, unit, found.distance) for c in found.contacts]
    head += apart
    return [[*head, *blocks[0]], *blocks[1:]]


def _connectors(found: Proposal) -> list[list[str]]:
    """Gaps of the deck, each group of them a table."""
    length = found.units.words[0]
    said = {
        "type": "free within the limit, then stiff",
        "name": "of the deck's gaps",
        "nodes": "motion of the second set less that of the first, node by node",
        "dof": "the direction of the gap",
        "axis": "the direction of the gap",
        "lower": f"{length}, where it closes",
        "upper": f"{length}, where it closes",
        "stiffness": "force/length, of each pair of nodes, as the deck says",
        "friction": "across the gap, while it presses",
    }
    tables = [(stop, connector_table(stop)) for stop in found.stops]
    for _, table in tables:
        table["friction"] = table["friction"] or None
    return [
        [
            f"# Gaps of the deck ({PurePath(stop.where).name}), {stop.first.size} pair(s) of nodes. A contact of "
            "the same nodes presses as well.",
            "[[connector]]",
            *(key_line(key, table[key], words) for key, words in said.items() if table[key] is not None),
        ]
        for stop, table in tables
    ]


def _joints(found: Proposal) -> list[str]:
    """What the deck joins is used as it is; the study need not say it."""
    if not found.joints:
        return []
    lines = [
        "# Joints of the deck, used as they are. Nodes of links, couplings and ties are in none of the contacts above:"
    ]
    lines += [f"#   {joint}" for joint in found.joints[:SHOWN]]
    return [*lines, "#   ..."] if len(found.joints) > SHOWN else lines


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
    d, units = found.drive, UNITS[found.units.name]
    force = d.kind == "force"
    unit = units.force if force else units.length
    amplitude = FORCE if force else float(f"{AMPLITUDE / found.units.length:.2g}")
    return [
        f"# Excitation: {d.node_set}, because {d.why}.",
        *([f"# As well: {', '.join(d.others)}{', by a force' if d.freed else ''}."] if d.others else []),
        *(["# To move a support instead, let one direction of it go with [support.NAME]."] if force else []),
        *_let_go(d),
        "[excitation.road]",
        key_line("node_set", d.node_set, "all its nodes get the same signal"),
        key_line("dof", d.dof, "the direction"),
        key_line("kind", d.kind, "on each node" if force else "or velocity, acceleration; force on free nodes"),
        "",
        "[excitation.road.signal]",
        key_line("type", "multisine", "sines of equal amplitude and random phase: a rough road"),
        key_line("f_min", 1.0, "Hz"),
        key_line("f_max", F_MAX, "Hz"),
        key_line(
            "amplitude",
            amplitude,
            f"{unit}, of each sine: raise it until the parts touch",
        ),
        key_line("period", 1.0, "s"),
        key_line("seed", 1, "of the phases"),
    ]


def _let_go(d: Drive) -> list[str]:
    """Of supports that the deck holds along the direction."""
    if not d.freed:
        return []
    comment = "directions that the deck holds and the study lets go"
    return [
        *named_nodes(d.node_set, d.labels),
        "[support.road]",
        key_line("nodes", d.node_set, "node set"),
        key_line("free", [d.dof], comment),
        "",
    ]


def _damping(model: Model) -> list[str]:
    """None where the deck says it, of the structure as well, and creak reads what it says."""
    unread = list(dict.fromkeys(u.keyword for u in model.unread if u.damps))
    bare = undamped_words(model)
    if is_damped(model) and not unread and not bare:
        return []
    damped = {u.share_of for u in model.unread if u.share}
    shares = {u.share: u.keyword for u in model.unread if u.share}
    whole = "" in damped or damped >= {m.name for m in materials(model)}
    if len(shares) == 1 and whole and (bare or not is_damped(model)):
        ((share, keyword),) = shares.items()
        return [
            f"# Damping: {keyword} of the deck, as the share of critical that does the same at resonance.",
            "[damping]",
            key_line("modal", share, "fraction of critical of every mode"),
        ]
    none = f"{bare} of the deck have none" if bare else "the deck has none"
    none += ". Without any no vibration dies out, and each blow decides over all that follow."
    return [
        f"# Damping: {f'creak does not read {first_few(unread, SHOWN)} of the deck.' if unread else none}",
        f"# {100.0 * DAMPING:g} % of critical is usual for trim and sheet metal that are clipped or screwed together; "
        "1 to 5 % is measured.",
        "[damping]",
        key_line("modal", DAMPING, "fraction of critical of every mode"),
    ]


def _reduction() -> list[str]:
    return [
        "# `creak advise` looks closer: retained dofs, f_max and what they cost, with the errors to expect.",
        "[reduction]",
        key_line("method", "craig-bampton", "or guyan, gap-modes, none"),
        key_line("f_max", "auto", "modes kept: as far as it takes until more change nothing; or Hz"),
    ]


def _precheck() -> list[str]:
    return [
        "[precheck]",
        key_line("enabled", True, "keep contact only where a linear run closes the gap"),
        key_line("margin", "auto", "what may stay open without contact: 15 % of each gap; or a length"),
    ]


def _time(found: Proposal) -> list[str]:
    long = key_line("periods", 5, "of the excitation") if found.drive is not None else key_line("end", 1.0, "s")
    return ["[time]", long, key_line("accuracy", "settled", "or quick, fine; steps follow from it")]


def _output(found: Proposal) -> list[str]:
    lines = ["[output]"]
    if found.outputs:
        lines.append(key_line("nodes", list(found.outputs), "node sets whose motion is kept"))
    else:
        lines.append('# nodes = ["NODE SET"]                # sets whose motion is to be kept')
    return [
        *lines,
        "# ParaView: `creak convert OUT/results.h5 motion.pvd` has the motion around the hardest event; of all the run",
        "# with the next line (large).",
        "# field_interval = 0.002              # s",
    ]


def _verification(found: Proposal) -> list[str]:
    lines = ["[verification]"]
    if found.pairs is not None:
        value = found.pairs if isinstance(found.pairs, str) else list(found.pairs)
        lines.append(key_line("pairs", value, "main and secondary nodes in turn: motion and modes are compared there"))
    else:
        lines.append('# pairs = ["MAIN NODES", "SECONDARY NODES"]  # two node sets across a contact, to compare motion')
    return [
        *lines,
        key_line("f_max", 500.0, "Hz, spectra and low-passed forces"),
        key_line("mac_f_max", F_MAX, "Hz, mode shapes"),
    ]
