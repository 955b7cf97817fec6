"""The first three lines of `creak info`: how large the deck is, what it is made of, whether it can be run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from creak.errors import shortened

if TYPE_CHECKING:
    from creak.model.mesh import ElementBlock, Model
    from creak.studies.prepare.unit_check import UnitSystem

SHOWN = 5
"""Names in a list that is folded."""


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
    shown = ", ".join(shortened(name, 48) for name in names[:most])
    return shown if len(names) <= most else f"{shown}, and {len(names) - most} more"
