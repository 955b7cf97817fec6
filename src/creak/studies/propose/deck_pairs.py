"""Contact that the deck itself describes: its pairs with their laws, and the friction of its general contact."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import PurePath
from typing import Any

import numpy as np

from creak.errors import InputError
from creak.model.mesh import Model
from creak.model.steps import SurfacePair
from creak.progress import Progress
from creak.studies.prepare.deck_contact import contact_table, friction_of
from creak.studies.propose.contacts import Contact, Tools, tried
from creak.studies.propose.opposite import element_numbers
from creak.studies.propose.proximity import Near, looks_at, numbers_of

LAW = ("stiffness", "overclosure", "per_area", "friction", "damping")
"""Keys of a contact table that a deck may give."""


def deck_pairs(model: Model, progress: Progress, tools: Tools) -> list[Contact]:
    """The contact pairs of the deck with their own laws, tried. Hard contact is one of stiffness "auto"."""
    of = model.contact
    if of is None:
        return []
    found = []
    for k, pair in enumerate(of.pairs):
        progress("try the contacts of the deck", k, len(of.pairs))
        if pair.method == "surface-to-surface" and model.surfaces[pair.secondary].is_node_based:
            pair = replace(pair, method="node-to-surface")
        parts = (_part_of(model, pair.secondary), _part_of(model, pair.main))
        c = Contact(
            name="",
            secondary=pair.secondary,
            main=pair.main,
            gap=0.0,
            place="",
            near=0,
            elements=0,
            channels=0,
            start=None,
            parts=parts,
            method=pair.method,
        )
        c = replace(c, clearance=_clearance(model, pair), deck=PurePath(pair.where).name)
        try:
            table = contact_table(model, replace(pair, clearance=None), of.interactions[pair.interaction])
        except InputError as error:
            found.append(replace(c, problem=error.what))
            continue
        law = {key: table[key] for key in LAW if table.get(key) and table[key] != "hard"}
        found.append(tried(model, replace(c, law=law), tools))
    progress("try the contacts of the deck", len(of.pairs), len(of.pairs))
    return found


def general_law(model: Model) -> dict[str, Any]:
    """Friction of the deck's general contact, of all contacts that have none of their own."""
    of = model.contact
    friction = friction_of(of.interactions[of.everywhere].friction) if of is not None and of.everywhere else 0.0
    return {"friction": friction} if friction else {}


def kept_apart(model: Model, near: Sequence[Near]) -> tuple[list[Near], list[str]]:
    """What is near without what the deck keeps out of contact, and a sentence of each that it keeps out or cuts."""
    left, said = list[Near](), list[str]()
    pairs = () if model.contact is None else model.contact.apart
    every = np.arange(element_numbers(model)[-1])
    members = {name: numbers_of(model, name) if name else every for two in pairs for name in two}
    for n in near:
        out = np.zeros(len(n.touching), dtype=bool)
        for two in [*pairs, *((b, a) for a, b in pairs)]:
            both = np.isin(n.touching[:, 0], members[two[0]]) & np.isin(n.touching[:, 1], members[two[1]])
            if both.any() and all(looks_at(model, name, n.met, side) for side, name in enumerate(two) if name):
                out |= both
        if not out.all():
            left.append(n)
        if out.any():
            some = f" at {np.count_nonzero(out)} of {out.size} pairs of near elements, the study at none"
            said.append(f"the deck keeps {n.parts[0]} and {n.parts[1]} out of contact{'' if out.all() else some}")
    return left, said


def _clearance(model: Model, pair: SurfacePair) -> float | Mapping[int, float] | None:
    """By node where the deck has several; of nodes that are not on the secondary surface none."""
    if not isinstance(pair.clearance, Mapping):
        return pair.clearance
    rows = model.surfaces[pair.secondary].nodes_idx.tolist()
    of = {row: pair.clearance[row] for row in rows if row in pair.clearance}
    return of[rows[0]] if len(of) == len(rows) and len(set(of.values())) == 1 else of


def _part_of(model: Model, surface: str) -> str:
    """The part that has most of a surface."""
    s = model.surfaces[surface]
    if s.is_node_based:
        shares = [int(np.isin(s.nodes_idx, p.nodes_idx).sum()) for p in model.parts]
    else:
        parts = np.array([b.part for b in model.blocks])[s.facets[:, 0]]
        shares = np.bincount(parts[parts >= 0], minlength=len(model.parts)).tolist()
    return model.parts[int(np.argmax(shares))].name if any(shares) else surface
