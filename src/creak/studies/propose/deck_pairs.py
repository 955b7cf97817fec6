"""Contact that the deck itself describes: its pairs with their laws, and the friction of its general contact."""

from __future__ import annotations

from dataclasses import replace
from pathlib import PurePath
from typing import Any

import numpy as np

from creak.contact.pair import Keep
from creak.errors import InputError
from creak.model.mesh import Model
from creak.studies.prepare.deck_step import contact_table, friction_of
from creak.studies.propose.contacts import Contact, tried

LAW = ("stiffness", "overclosure", "per_area", "friction", "damping")
"""Keys of a contact table that a deck may give."""


def deck_pairs(model: Model, keep: Keep | None) -> list[Contact]:
    """The contact pairs of the deck with their own laws, tried. Hard contact is one of stiffness "auto"."""
    of = model.contact
    if of is None:
        return []
    found = []
    for pair in of.pairs:
        if pair.method == "surface-to-surface" and model.surfaces[pair.secondary].is_node_based:
            pair = replace(pair, method="node-to-surface")
        parts = (_part_of(model, pair.secondary), _part_of(model, pair.main))
        c = Contact("", pair.secondary, pair.main, 0.0, "", 0, 0, 0, None, parts=parts, method=pair.method)
        c = replace(c, clearance=pair.clearance, deck=PurePath(pair.where).name)
        try:
            table = contact_table(model, pair, of.interactions[pair.interaction])
        except InputError as error:
            found.append(replace(c, problem=error.what))
            continue
        law = {key: table[key] for key in LAW if table.get(key) and table[key] != "hard"}
        found.append(tried(model, replace(c, law=law), keep))
    return found


def general_law(model: Model) -> dict[str, Any]:
    """Friction of the deck's general contact, of all contacts that have none of their own."""
    of = model.contact
    friction = friction_of(of.interactions[of.everywhere]) if of is not None and of.everywhere else 0.0
    return {"friction": friction} if friction else {}


def _part_of(model: Model, surface: str) -> str:
    """The part that has most of a surface."""
    s = model.surfaces[surface]
    if s.is_node_based:
        shares = [int(np.isin(s.nodes_idx, p.nodes_idx).sum()) for p in model.parts]
    else:
        parts = np.array([b.part for b in model.blocks])[s.facets[:, 0]]
        shares = np.bincount(parts[parts >= 0], minlength=len(model.parts)).tolist()
    return model.parts[int(np.argmax(shares))].name if any(shares) else surface
