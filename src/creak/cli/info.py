"""`creak info`: what a deck holds, and what of it was not read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

import typer

from creak.cli.output import OUTPUT, Output
from creak.errors import shortened
from creak.model.units import UnitsName

if TYPE_CHECKING:
    from creak.model.mesh import ElementBlock, Model
    from creak.studies.prepare.unit_check import UnitSystem

SHOWN = 5
"""Names in a list that is folded."""


def info(
    deck: Path = typer.Argument(..., metavar="DECK", help="The deck to look at."),
    units: UnitsName | None = typer.Option(
        None, "--units", help="Units that the deck should be in: its materials, size and mass are checked for them."
    ),
    all_sets: bool = typer.Option(False, "--sets", help="All sets and surfaces; default: the first few of each."),
    output: Output = OUTPUT,
) -> None:
    """What a deck is, in three lines; then what of it was not used, parts, supports, and sets.

    Example: creak info door/door.inp
    """
    from creak.formats.decks import read_model

    with output:
        with output.progress as progress:
            with progress.phase("read the deck"):
                model = read_model(deck)
            facts = _facts(deck, model, units, progress)
        _print(output, facts, [units] if units else facts["units"], None if all_sets or output.verbose else SHOWN)
        for text in facts["warnings"]:
            output.warn(text)
        if len(facts["parts"]) > 1:
            output.command(f"next: creak new {quote(str(deck))}")
        output.result(facts)


def _facts(deck: Path, model: Model, units: str | None, progress: Any) -> dict[str, Any]:
    """All of it as plain numbers, strings and lists."""
    from creak.contact.crossing import crossing_warnings
    from creak.model.constraints import supported_nodes
    from creak.studies.prepare.deck_contact import contact_facts, contact_flaw
    from creak.studies.prepare.massless import massless_words
    from creak.studies.prepare.unit_check import guessed_units, named_systems

    parts = _parts(model, progress)
    mass = sum(p["mass"] for p in parts.values())
    with progress.phase("look at supports and units"):
        loose, guess = _loose(model), [s.name for s in guessed_units(model)]
        length = shared_words(named_systems([units] if units else guess))[0] or "units of length"
        warnings = [*_unit_warnings(model, units, mass, guess), *massless_words(model), *_loose_warning(loose)]
        warnings += crossing_warnings(model, length)
        warnings += [contact_flaw(said) for said in (() if model.contact is None else model.contact.flaws)]
    surfaces = {k: _extent(s) for k, s in model.surfaces.items() if not k.startswith("_")}
    return {
        "deck": str(deck),
        **size_facts(model),
        "nodes": model.nodes.count,
        "elements": model.n_elements,
        "constraints": len(model.constraints),
        "parts": parts,
        "mass": mass,
        "units": guess,
        "held_nodes": int(supported_nodes(model.constraints, model.fixed).size),
        "free_parts": loose,
        "node_sets": {k: int(v.size) for k, v in model.node_sets.items() if not k.startswith("_")},
        "element_sets": {k: len(v) for k, v in model.element_sets.items() if not k.startswith("_")},
        "surfaces": surfaces,
        "contact": contact_facts(model),
        "unread": [asdict(u) for u in model.unread],
        "warnings": warnings,
    }


def _parts(model: Model, progress: Any) -> dict[str, dict[str, Any]]:
    from creak.assembly.part import Rayleigh, part_system

    found = {}
    for i, part in enumerate(model.parts):
        progress("assemble the parts", i, len(model.parts))
        system = part_system(model, i, Rayleigh(0.0, 0.0), override=True)
        kinds = sorted({b.kind for b in model.blocks if b.part == i})
        found[part.name] = {
            "nodes": int(part.nodes_idx.size),
            "elements": system.stats.elements,
            "kinds": kinds,
            "dof": system.n,
            "mass": system.stats.mass,
        }
    progress("assemble the parts", len(model.parts), len(model.parts))
    return found


def _extent(surface: Any) -> dict[str, int]:
    return {"nodes": int(surface.nodes_idx.size)} if surface.is_node_based else {"facets": len(surface.facets)}


def _loose(model: Model) -> dict[str, list[str]]:
    """Part -> rigid motions that the deck's supports and links leave free."""
    from creak.assembly.coupling import Driven
    from creak.assembly.rigid import loose_motions, unheld_parts

    driven = Driven({})
    return loose_motions(model, driven, unheld_parts(model, driven))


def _loose_warning(loose: dict[str, list[str]]) -> list[str]:
    from creak.assembly.rigid import loose_words

    if not loose:
        return []
    return [f"the deck's supports leave rigid-body motion of {loose_words(loose)}: a study has to hold or drive it"]


def _unit_warnings(model: Model, units: str | None, mass: float, guess: list[str]) -> list[str]:
    from creak.studies.prepare.unit_check import materials, unit_warnings

    if units is not None:
        return unit_warnings(model, units, mass=mass)
    if guess or not materials(model):
        return []
    return unit_warnings(model, "mm-t-s", mass=mass)


def _print(output: Output, facts: dict[str, Any], systems: list[str], most: int | None) -> None:
    """`systems` are those that the units may be; of sets `most` are shown, None: all."""
    from creak.studies.prepare.unit_check import named_systems

    length, mass = shared_words(named_systems(systems))
    for line in head_lines(facts, length, mass):
        output.say(line)
    _tell_unread(output, facts["unread"], most)
    rows = [["part", "nodes", "elements", "dof", f"mass, {mass}" if mass else "mass", "kinds"]]
    for name, p in facts["parts"].items():
        figures = (f"{p['nodes']}", f"{p['elements']}", f"{p['dof']}", f"{p['mass']:.6g}", ", ".join(p["kinds"]))
        rows.append([name, *figures])
    output.table("Parts", rows, left=(0, 5))
    output.say(f"held nodes: {facts['held_nodes']}")
    _listing(output, "contact that `creak new` takes over", facts["contact"], most)
    _listing(output, "node sets", {k: f"{v}" for k, v in facts["node_sets"].items()}, most)
    _listing(output, "element sets", {k: f"{v}" for k, v in facts["element_sets"].items()}, most)
    extents = {k: " ".join(f"{n} {what}" for what, n in v.items()) for k, v in facts["surfaces"].items()}
    _listing(output, "surfaces", extents, most)


def _tell_unread(output: Output, unread: list[dict[str, Any]], most: int | None) -> None:
    """What was not read: first what changes the answer, a line each; then the rest by reasons, and what became of
    ties."""
    if all(u["used"] for u in unread):
        output.say("every keyword was read")
    alike: dict[str, list[str]] = {}
    for u in unread:
        if u["changes_answer"] and not u["used"]:
            output.say(f"not read: {u['keyword']} ({u['where']}), changes the answer: {u['why']}")
        elif not u["used"]:
            alike.setdefault(u["why"], []).append(f"{u['keyword']} ({u['where']})")
    for why, names in alike.items():
        output.say(f"not read: {folded(names, most or len(names))}, does not change the answer: {why}")
    for u in unread:
        if u["used"]:
            output.say(f"read: {u['keyword']} ({u['where']}): {u['why']}")


def _listing(output: Output, title: str, entries: dict[str, str], most: int | None) -> None:
    if not entries:
        return
    names = [f"{k} ({v})" for k, v in entries.items()]
    more = "" if most is None or len(names) <= most else " (--sets: all)"
    output.say(f"{title}: {folded(names, len(names) if most is None else most)}{more}")


def size_facts(model: Model) -> dict[str, Any]:
    """Extent (3,) of the nodes that elements use, materials by name with their elements, range of shell thickness."""
    import numpy as np

    used = [b.nodes_idx.ravel() for b in model.blocks]
    at = model.nodes.coords[np.unique(np.concatenate(used))] if used else np.zeros((1, 3))
    bounds = [t for b in model.blocks if (t := _thickness(b)) is not None]
    return {
        "size": np.ptp(at, axis=0).tolist(),
        "materials": _materials(model),
        "thickness": [min(t[0] for t in bounds), max(t[1] for t in bounds)] if bounds else None,
    }


def _thickness(block: ElementBlock) -> tuple[float, float] | None:
    """Least and largest thickness of a block of shells."""
    from creak.model.materials import GeneralShell, ShellSection

    if not isinstance(block.section, ShellSection | GeneralShell) or not block.section.thickness > 0.0:
        return None
    if isinstance(block.section, GeneralShell) and block.section.rigid:
        return None
    t, share = block.section.thickness, block.own.thickness
    return (t, t) if share is None else (t * float(share.min()), t * float(share.max()))


def _materials(model: Model) -> dict[str, int]:
    """Elements of each material, the most frequent first."""
    from creak.model.materials import GeneralShell

    count: dict[str, int] = {}
    for block in model.blocks:
        section = block.section
        if isinstance(section, GeneralShell):
            made_of = section.made_of
            names = [m.name for m in made_of.materials] if made_of else [] if section.rigid else [section.name]
        else:
            material = getattr(section, "material", None)
            names = [] if material is None else [material.name]
        for name in dict.fromkeys(names):
            count[name] = count.get(name, 0) + int(block.ids.size)
    return dict(sorted(count.items(), key=lambda item: -item[1]))


def shared_words(systems: Sequence[UnitSystem]) -> tuple[str, str]:
    """Units of length and mass on which all that fit agree; empty where they do not, or nothing fits."""
    length, mass = ({s.words[i] for s in systems} for i in (0, 3))
    return (length.pop() if len(length) == 1 else "", mass.pop() if len(mass) == 1 else "")


def head_lines(facts: dict[str, Any], length: str, mass: str) -> list[str]:
    """The three lines of the facts that `info` found; `length` and `mass` are unit labels, or empty."""
    x, y, z = facts["size"]
    count = f"{facts['nodes']} nodes, {facts['elements']} elements, {facts['constraints']} constraints"
    first = f"{facts['deck']}: {count}; {x:.4g} x {y:.4g} x {z:.4g} {length or 'long'}, mass {facts['mass']:.4g} {mass}"
    second = [_named("part", list(facts["parts"])), _named("material", list(facts["materials"]))]
    if facts["thickness"] is not None:
        thin, thick = (f"{t:.4g}" for t in facts["thickness"])
        second.append(f"shells {thin if thin == thick else f'{thin} to {thick}'} {length}".rstrip() + " thick")
    fit = (
        f"materials and size fit {' or '.join(facts['units'])}" if facts["units"] else "they fit no system creak knows"
    )
    return [first.rstrip(), "; ".join([*second, f"units: {fit}"]), _ready(facts)]


def _ready(facts: dict[str, Any]) -> str:
    """Whether all of the model is read, and the first thing to look at."""
    changing = list(dict.fromkeys(u["keyword"] for u in facts["unread"] if u["changes_answer"]))
    told = "the model is whole: nothing that changes the answer is left out"
    if changing:
        told = f"does not run as it is: {folded(changing)} not used, and the answer would be another"
    warnings = facts["warnings"]
    if warnings:
        more = f" ({len(warnings)} in all)" if len(warnings) > 1 else ""
        told += f"; look at{more}: {shortened(warnings[0], 160)}"
    return told


def _named(what: str, names: list[str]) -> str:
    return f"{len(names)} {what}{'' if len(names) == 1 else 's'}" + (f" ({folded(names)})" if names else "")


def folded(names: Sequence[str], most: int = SHOWN) -> str:
    """The first names, and how many more there are."""
    shown = ", ".join(shortened(name, 48) if len(names) > 1 else name for name in names[:most])
    return shown if len(names) <= most else f"{shown}, and {len(names) - most} more"
