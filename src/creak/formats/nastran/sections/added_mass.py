"""NSM, NSM1, NSML, NSML1 and NSMADD: nonstructural mass of elements beside that of their properties."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

import numpy as np

from creak.errors import InputError
from creak.formats.deck.parts import Group
from creak.formats.nastran.text.bulk_data import Card, id_list, id_ranges
from creak.formats.nastran.text.deck import Deck
from creak.model.faces import SHELL_FACETS, facet_areas
from creak.model.materials import BeamSection, GeneralShell, Section, ShellSection, TrussSection

CARDS = ("NSM", "NSM1", "NSML", "NSML1")
READ = {*CARDS, "NSMADD"}
SHELLS = ("PSHELL", "PCOMP", "PCOMPG")
BARS, BEAMS = ("PBAR", "PBARL"), ("PBEAM", "PBEAML")
TYPES = {
    **dict.fromkeys(SHELLS, (*SHELLS, "PCOMPP")),
    **dict.fromkeys(BARS, BARS),
    **dict.fromkeys(BEAMS, BEAMS),
    **{name: (name,) for name in ("PROD", "PTUBE", "CONROD")},
}
"""Property types -> those that Nastran takes with them: it makes PBARL a PBAR, PBEAML a PBEAM, PCOMP a PSHELL."""


@dataclass(frozen=True)
class _Entry:
    """A value for the elements of some ids."""

    card: Card
    kind: str
    """Property type, or ELEMENT."""
    ids: frozenset[int] | None
    """None: ALL."""
    named: frozenset[int]
    """Those of the ids that no THRU spans."""
    value: float
    total: bool
    """Whether the value is spread over the elements; else it is a mass per area or length."""


def add_mass(deck: Deck) -> None:
    """Replace the groups of the elements that the set of the case control (NSM) names by heavier ones.

    Raises
    ------
    InputError : an unknown type or set, a list of both shells and bars with one mass to spread.
    """
    chosen = deck.case.nsm
    there = sorted({card.integer(0) for card in deck.cards(*CARDS, "NSMADD")})
    if chosen not in there and chosen:
        raise InputError(
            f"NSM = {chosen} in the case control, but no card has this set",
            where=deck.case.where,
            expected=f"one of {there}" if there else "NSM cards",
        )
    if there and not chosen and not deck.case.given and len(there) == 1:
        chosen = there[0]
    if not chosen:
        for card in deck.cards(*CARDS):
            deck.note(card, "the case control takes no NSM set, so Nastran adds no mass either", changes=False)
            break
        return
    more: dict[int, float] = {}
    for entry in _entries(deck, chosen):
        sizes = dict(_elements(deck, entry))
        total = sum(size for size, _ in sizes.values())
        if entry.total and len({is_area for _, is_area in sizes.values()}) > 1:
            raise InputError(
                f"{entry.card.name} {entry.card.text(0)} spreads one mass over shells and bars",
                where=entry.card.where,
                expected="elements of one kind",
            )
        if not sizes:
            deck.note(entry.card, "it names no element", changes=False)
        _list_types(deck, entry, sizes)
        for identifier in sizes:
            value = entry.value / total if entry.total else entry.value
            more[identifier] = more.get(identifier, 0.0) + value * deck.mass_factor
    _split(deck, more)


def _entries(deck: Deck, chosen: int) -> Iterator[_Entry]:
    sets, left = set[int](), [chosen]
    while left:
        one = left.pop()
        if one not in sets:
            sets.add(one)
            left += [i for card in deck.cards("NSMADD") if card.integer(0) == one for i in id_list(card, 1)]
    for card in deck.cards(*CARDS):
        if card.integer(0) not in sets:
            continue
        kind = card.text(1).upper()
        if kind not in (*TYPES, "ELEMENT"):
            raise card.wrong(1, f"{', '.join(TYPES)} or ELEMENT")
        total = card.name.startswith("NSML")
        if card.name.endswith("1"):
            every = any(text.upper() == "ALL" for text in card.fields[3:])
            ids = None if every else frozenset(id_list(card, 3))
            named = () if every else (span[0] for span in id_ranges(card, 3) if len(span) == 1)
            yield _Entry(card, kind, ids, frozenset(named), card.real(2), total)
            continue
        for i in range(2, len(card.fields), 2):
            if card.text(i):
                ids = frozenset({card.integer(i)})
                yield _Entry(card, kind, ids, ids, card.real(i + 1, 0.0), total)


def _type_of(group: Group) -> str:
    """Name of the property card, which the name of the section begins with."""
    return group.section.name.partition(" ")[0]


def _list_types(deck: Deck, entry: _Entry, reached: Collection[int]) -> None:
    """Name the types that an entry takes with its own, and its ids that are those of another type alone."""
    if entry.kind == "ELEMENT":
        return
    missing = entry.named - {_owner(deck, entry, identifier) for identifier in reached}
    taken, others = dict[str, None](), dict[int | None, str]()
    for group in deck.groups.values():
        kind = _type_of(group)
        if kind not in TYPES[entry.kind]:
            for owner in (_owner(deck, entry, identifier) for identifier in group.ids if missing):
                if owner in missing:
                    others.setdefault(owner, kind)
        elif kind != entry.kind and any(identifier in reached for identifier in group.ids):
            taken[kind] = None
    title = f"{entry.card.name} {entry.card.text(0)}, {entry.kind}"
    for identifier, kind in others.items():
        why = f"{identifier} is of type {kind}, not {entry.kind}: nothing is added there, as in Nastran"
        deck.note(entry.card, why, changes=False, what=title)
    if taken:
        why = f"{', '.join(taken)} is taken with {entry.kind}, as Nastran does; OptiStruct takes the type that is given"
        deck.note(entry.card, why, changes=False, what=title)


def _elements(deck: Deck, entry: _Entry) -> Iterator[tuple[int, tuple[float, bool]]]:
    """Element id -> area or length, and whether it is an area."""
    for group in deck.groups.values():
        is_area = isinstance(group.section, ShellSection | GeneralShell)
        if not is_area and not isinstance(group.section, BeamSection | TrussSection):
            continue
        if entry.kind != "ELEMENT" and _type_of(group) not in TYPES[entry.kind]:
            continue
        for k, (identifier, nodes) in enumerate(zip(group.ids, group.nodes, strict=True)):
            owner = _owner(deck, entry, identifier)
            if owner is not None and (entry.ids is None or owner in entry.ids):
                x = np.array([deck.grids.place(row) for row in nodes])
                yield identifier, (_area(group.kind, x) if is_area else _length(group, k, x), is_area)


def _owner(deck: Deck, entry: _Entry, identifier: int) -> int | None:
    """What the ids of an entry say of an element: itself, or its property."""
    if entry.kind in ("ELEMENT", "CONROD"):
        return deck.whole.get(identifier, identifier)
    return deck.property_of.get(identifier)


def _area(kind: str, x: np.ndarray) -> float:
    """Of the facets of a shell, from their diagonals."""
    return float(facet_areas(x[np.array(SHELL_FACETS[kind])]).sum())


def _length(group: Group, k: int, x: np.ndarray) -> float:
    """Of a bar between the ends of its offsets."""
    ends = x + group.own["arms"][k] if "arms" in group.own else x
    return float(np.linalg.norm(ends[1] - ends[0]))


def _split(deck: Deck, more: dict[int, float]) -> None:
    """Elements of one group with different added mass become groups of their own."""
    groups: dict[tuple[object, ...], Group] = {}
    for key, group in deck.groups.items():
        values = np.array([more.get(i, 0.0) for i in group.ids])
        for value in dict.fromkeys(values.tolist()):
            rows = np.flatnonzero(values == value).tolist()
            own = {name: [entries[k] for k in rows] for name, entries in group.own.items()}
            ids, nodes = [group.ids[k] for k in rows], [group.nodes[k] for k in rows]
            section = _heavier(group.section, value) if value else group.section
            groups[(*key, "NSM", value) if value else key] = Group(
                group.kind, section, ids, nodes, deck.element_at[ids[0]], own
            )
    deck.groups = groups


def _heavier(section: Section, value: float) -> Section:
    """The section with a further mass per area or length."""
    if isinstance(section, ShellSection | GeneralShell):
        return replace(section, area_mass=section.area_mass + value)
    if isinstance(section, BeamSection):
        return replace(section, line_mass=section.line_mass + value)
    if isinstance(section, TrussSection):
        density = section.material.density + value / section.area
        return replace(section, material=replace(section.material, density=density))
    return section
