"""*CONTACT PAIR and *CLEARANCE."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from creak.errors import InputError, suggest
from creak.formats.abaqus.joints.interactions import OPTIONS
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.names import Registry, qualified
from creak.formats.abaqus.text.numbers import to_float
from creak.formats.abaqus.text.outline import Outline, list_params
from creak.model.steps import Interaction, SurfacePair

KEYWORDS = ("CONTACT PAIR", "SURFACE INTERACTION", "CLEARANCE", *OPTIONS)
EDGES = ("E1", "E2", "E3", "E4")
_METHODS = {"NODE TO SURFACE": "node-to-surface", "SURFACE TO SURFACE": "surface-to-surface"}
_PAIR = (
    "TYPE, INTERACTION, SMALL SLIDING, ADJUST, CPSET, MECHANICAL CONSTRAINT, HCRIT, EXTENSION ZONE, SMOOTH,"
    "SUPPLEMENTARY CONSTRAINTS, TRACKING, WEIGHT"
)


def read_pairs(
    deck: Outline, blocks: Sequence[Block], interactions: Mapping[str, Interaction], surfaces: Iterable[str]
) -> tuple[SurfacePair, ...]:
    """Contact pairs with their clearances.

    Raises
    ------
    InputError : unknown interaction or surface, a pair of one surface, an unknown TYPE, a clearance without pair.
    """
    known = set(surfaces)
    pairs: list[SurfacePair] = []
    sets: dict[str, list[int]] = {}
    for block in blocks:
        if block.name != "CONTACT PAIR":
            continue
        first = len(pairs)
        pairs += some_pairs(deck, block, interactions, known)
        sets.setdefault(block.get("CPSET").upper(), []).extend(range(first, len(pairs)))
    for block in blocks:
        if block.name == "CLEARANCE":
            clear(deck, block, pairs, sets, known)
    return tuple(pairs)


def some_pairs(
    deck: Outline, block: Block, interactions: Mapping[str, Interaction], surfaces: set[str]
) -> list[SurfacePair]:
    name = block.need("INTERACTION").upper()
    if name not in interactions:
        raise block.error(f"unknown surface interaction {name!r}", fix=suggest(name, interactions))
    kind = block.option("TYPE", "NODE TO SURFACE")
    if kind not in _METHODS:
        raise block.error(f"*CONTACT PAIR has TYPE={kind}", expected=" or ".join(_METHODS), fix=suggest(kind, _METHODS))
    list_params(deck, block, _PAIR)
    _check_adjust(deck, block)
    result = []
    for fields, where in block.rows():
        if len(fields) < 2:
            raise InputError(
                "*CONTACT PAIR names one surface",
                expected="secondary surface, main surface",
                where=where,
                fix="Name both; creak has no self-contact.",
            )
        secondary, main = (surface_name(deck, f, surfaces, where) for f in fields[:2])
        if secondary == main:
            raise InputError(
                f"surface {secondary!r} touches itself",
                expected="two surfaces",
                where=where,
                fix="creak has no self-contact.",
            )
        if any(fields[2:]):
            deck.note(block, "creak does not read the orientation of a contact pair", changes=False)
        result.append(SurfacePair(secondary, main, name, _METHODS[kind], block.has("SMALL SLIDING"), where=where))
    return result


def _check_adjust(deck: Outline, block: Block) -> None:
    """ADJUST=0 only removes overclosure, as creak does; a band or a set moves nodes that are apart."""
    given = block.option("ADJUST", "NO")
    if given == "NO":
        return
    try:
        moves = to_float(given, block.where, "ADJUST") != 0.0
    except InputError:
        moves = True
    if moves:
        deck.note(
            block,
            "creak does not move nodes onto the main surface; give the gap as *CLEARANCE",
            changes=True,
            what="*CONTACT PAIR, ADJUST",
        )


def surface_name(deck: Outline, name: str, surfaces: set[str], where: str) -> str:
    """The name of a surface as the model has it.

    Raises
    ------
    InputError : there is none of this name.
    """
    key = name.upper()
    if key not in surfaces and deck.assembly:
        key = key.removeprefix(f"{deck.assembly}.")
    if key not in surfaces:
        raise InputError(f"unknown surface {name!r}", where=where, fix=suggest(name, surfaces))
    return key


def list_node_areas(deck: Outline, pairs: Iterable[SurfacePair], interactions: Mapping[str, Interaction]) -> None:
    """List surfaces of nodes with areas of their own, and of edges, where a law of pressure would need an area."""
    pressed = {p.secondary for p in pairs if interactions[p.interaction].law in ("linear", "tabular")}
    for scope, block in deck.blocks("SURFACE"):
        key = qualified(scope.name, block.get("NAME"))
        if not pressed & {key, block.get("NAME").upper()}:
            continue
        if block.option("TYPE") != "NODE":
            if any(len(fields) > 1 and fields[1].upper() in EDGES for fields, _ in block.rows()):
                deck.note(block, "creak gives an edge no area", changes=True, what="*SURFACE of edges")
        elif any(len(fields) > 1 and to_float(fields[1], where, "area") != 1.0 for fields, where in block.rows()):
            deck.note(
                block,
                "creak gives every node of a node surface the area 1",
                changes=True,
                what="*SURFACE, TYPE=NODE with areas",
            )


def clear(
    deck: Outline,
    block: Block,
    pairs: list[SurfacePair],
    sets: Mapping[str, Sequence[int]],
    surfaces: set[str],
    nodes: Registry | None = None,
) -> None:
    """Give the pairs of a *CLEARANCE its value, or (TABULAR) those of its nodes.

    Parameters
    ----------
    sets : rows of pairs by their CPSET.
    nodes : what nodes are called; None: TABULAR is not used.
    """
    known = "CPSET, VALUE, MASTER, SLAVE, MAIN, SECONDARY"
    list_params(deck, block, f"{known}, TABULAR" if nodes else known)
    if block.has("TABULAR") and not block.has("VALUE"):
        if nodes is None:
            return
        rows = list(block.rows())
        if any(len(fields) > 2 for fields, _ in rows):
            deck.note(block, "creak takes the direction from the surfaces", changes=True, what="*CLEARANCE, normals")
        each = [(nodes.find(f[0], "", where), to_float("".join(f[1:2]), where, "clearance")) for f, where in rows]
        value: float | dict[int, float] = {row: gap for found, gap in each for row in found.tolist()}
        least = min((gap for _, gap in each), default=0.0)
    else:
        value = least = to_float(block.need("VALUE"), block.where, "clearance")
    if block.has("CPSET"):
        chosen = list(sets.get(block.get("CPSET").upper(), []))
    else:
        main = surface_name(deck, block.get("MAIN") or block.need("MASTER"), surfaces, block.where)
        other = surface_name(deck, block.get("SECONDARY") or block.need("SLAVE"), surfaces, block.where)
        chosen = [i for i, p in enumerate(pairs) if (p.secondary, p.main) == (other, main)]
    if not chosen:
        raise block.error(
            "*CLEARANCE for a contact pair that the deck does not have",
            expected="CPSET= or the surfaces of a *CONTACT PAIR",
            fix="Check the names.",
        )
    if least < 0.0:
        raise block.error(f"clearance of {least:g}", expected="zero or more", fix="creak has no press fits.")
    for i in chosen:
        pairs[i] = replace(pairs[i], clearance=value)
