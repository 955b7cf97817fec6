"""A proposed contact as TOML with comments: a table, or a question that is commented out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from creak.studies.file.toml_text import toml_value
from creak.studies.propose.contacts import EDGES, FAR, OVERLAP, PRESSED, SIDE, UNEVEN, Contact

IN_A_LINE = 12
"""Labels of nodes in a line of the study."""
STOP = 1000.0
"""N/mm: of the stop that a pair of edges is offered as."""


def key_line(key: str, value: object, comment: str) -> str:
    """`key = value      # comment`."""
    return f"{f'{key} = {toml_value(value)}':<37} # {comment}"


def contact_lines(c: Contact, unit: str, distance: float) -> list[str]:
    """Where the two come near each other, then the table."""
    if c.question:
        return [*_where(c, unit), *_asked(c, unit, distance)]
    lines = [*_where(c, unit), *_size(c)]
    if c.problem:
        return [*lines, f"# To be filled in, because {c.problem}.", *_commented(_table(c, unit))]
    return [*lines, f"# {c.channels} gap channels, {_start(c, unit)}; {PRECHECK}", *_table(c, unit)]


PRECHECK = "the pre-check keeps those that a linear run all but closes."


def _where(c: Contact, unit: str) -> list[str]:
    if c.deck:
        return [f"# Contact pair of the deck ({c.deck}): {c.how_far(unit)} at node {c.place}."]
    first = f"The edge of {c.parts[0]}" if c.edge else c.secondary
    second = f"that of {c.main}" if c.question == EDGES else c.main
    lines = [f"# {first} and {second}: {c.how_far(unit)} at node {c.place}; {c.near} {_counted(c)}."]
    if c.clearance == 0.0 and c.edge and not c.question:
        lines.append("# An edge that is drawn inside the plate's thickness stands on it: the gap is zero.")
    return lines


def _counted(c: Contact) -> str:
    if c.edge or c.method == "node-to-surface":
        return "nodes are near"
    return f"elements are near, {c.secondary} has {c.elements}"


def _size(c: Contact) -> list[str]:
    if c.method == "surface-to-surface" and not c.edge and c.elements > 3 * c.near:
        return ["# A surface or element set of the near elements alone would make the study faster."]
    return []


def _start(c: Contact, unit: str) -> str:
    return f"open by {c.start:.3g} {unit} or more" if c.start else "closed at the start"


def _table(c: Contact, unit: str) -> list[str]:
    lines = named_nodes(c.secondary, c.labels)
    lines += [
        f"[contact.{c.name}]",
        key_line("secondary", c.secondary, "its nodes become the gap channels"),
        key_line("main", c.main, "what they may touch"),
    ]
    if c.method == "node-to-surface" and c.deck:
        lines.append(key_line("method", c.method, "as the deck says"))
    elif c.method == "node-to-surface":
        why = "an edge has no area" if c.edge else "a node set has no area"
        lines.append(key_line("method", c.method, f"{why}: its nodes are looked at one by one"))
    if c.table:
        lines.append(key_line("clearance", c.table, f"{unit}, of each node, instead of the drawn gap"))
    elif c.clearance is not None:
        lines.append(key_line("clearance", c.clearance, f"{unit}, of all channels, instead of the drawn gap"))
    if c.normal is not None:
        lines.append(key_line("normal", list(c.normal), f"from {c.main} to the side on which the other stands"))
    law = {**({} if "overclosure" in c.law else {"stiffness": "auto"}), "friction": 0.0, **c.law}
    return [*lines, *(key_line(key, value, _of_law(c, key, value)) for key, value in law.items())]


def _of_law(c: Contact, key: str, value: object) -> str:
    """What a comment says of a key of the law."""
    if key == "stiffness" and value == "auto":
        return "from the elements, no stiffer than the step resolves"
    if key == "friction" and key not in c.law:
        return "coefficient; the deck has none for it, squeak needs one" if c.deck else "coefficient; squeak needs one"
    return "as the deck says"


def named_nodes(name: str, labels: Sequence[str]) -> list[str]:
    """Nodes that the deck has no set of."""
    if not labels:
        return []
    if len(labels) == 1:
        return [f"[nodes.{name}]", f"labels = {toml_value(list(labels))}", ""]
    rows = [labels[k : k + IN_A_LINE] for k in range(0, len(labels), IN_A_LINE)]
    return [
        f"[nodes.{name}]",
        "labels = [",
        *("    " + " ".join(f"{toml_value(label)}," for label in row) for row in rows),
        "]",
        "",
    ]


def _asked(c: Contact, unit: str, distance: float) -> list[str]:
    """The question in a sentence, the picture, what to uncomment."""
    first, second = c.parts
    inside = f"{-c.gap:.3g} {unit} inside each other, deeper than half a shell"
    questions = {
        FAR: f"Can {first} and {second} touch? They are {c.gap:.3g} {unit} apart, farther than {distance:.3g} {unit}.",
        OVERLAP: f"Do {first} and {second} touch at rest? They are drawn {inside}.",
        SIDE: f"On which side of {second} does the edge of {first} stand? Parts of it lie on both sides, or along it.",
        EDGES: f"Can the edge of {first} hit that of {second}? Shells have no contact of edge on edge.",
        UNEVEN: f"Is the gap between {first} and {second} the same everywhere? A node set has one clearance for all.",
        PRESSED: f"Can {first} and {second} part where they are joined? {c.closed} places there touch at rest.",
    }
    answers = {
        FAR: "If they can, uncomment the lines below.",
        OVERLAP: "If they do, uncomment the lines below: the gap starts at zero. If not, move them apart in the deck.",
        SIDE: "Look at normal below, turn its sign if it points to the wrong side, and uncomment the lines.",
        EDGES: "If it can, uncomment the lines below: a stop between the nearest two nodes.",
        UNEVEN: "If it nearly is, uncomment the lines below. If not, put the elements there into an element set.",
        PRESSED: "Bolted faces press all the time, which costs hours. If they can part, uncomment the lines below.",
    }
    lines = [f"# QUESTION: {questions[c.question]}"]
    if c.picture:
        lines.append(f"# Picture: {c.picture}")
    if c.problem:
        return [*lines, f"# As it is, it cannot be used, because {c.problem}.", *_commented(_table(c, unit))]
    table = _stop(c, unit) if c.question == EDGES else _table(c, unit)
    return [*lines, f"# {answers[c.question]}", *_commented(table)]


def _stop(c: Contact, unit: str) -> list[str]:
    """A play connector between the nearest nodes of two edges: motion of the second less that of the first."""
    axis = int(np.argmax(np.abs(c.toward)))
    toward = -c.toward[axis]
    limit = ("upper", max(c.gap, 0.0)) if toward < 0.0 else ("lower", 0.0 - max(c.gap, 0.0))
    return [
        *named_nodes("EDGE_1", c.ends[:1]),
        *named_nodes("EDGE_2", c.ends[1:]),
        "[[connector]]",
        key_line("type", "play", "free within the limit, then stiff"),
        key_line("nodes", ["EDGE_1", "EDGE_2"], "motion of the second less that of the first"),
        key_line("dof", "xyz"[axis], "the direction nearest to that between them"),
        key_line(limit[0], float(f"{limit[1]:.4g}"), f"{unit}, where they touch"),
        key_line("stiffness", STOP, "force/length of the edges: a guess"),
    ]


def _commented(lines: Sequence[str]) -> list[str]:
    return [f"# {line}".rstrip() for line in lines]
