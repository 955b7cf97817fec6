"""Contact of a deck in words, and as tables of a study have it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from creak.errors import InputError
from creak.model.mesh import Model
from creak.model.steps import Interaction, SurfacePair
from creak.studies.warned import Warned


def contact_facts(model: Model) -> dict[str, str]:
    """`OVER - UNDER`: `friction 0.3, clearance 0.4`, of each pair; general contact and what it keeps apart."""
    of, found = model.contact, dict[str, str]()
    if of is None:
        return found
    for p in of.pairs:
        gap = "by node" if isinstance(p.clearance, Mapping) else p.clearance
        found[f"{p.secondary} - {p.main}"] = _law_words(of.interactions[p.interaction], gap)
    if of.everywhere:
        found["all that is near"] = _law_words(of.interactions[of.everywhere], None)
    return found | {f"{a or 'all'} - {b}": "kept apart" for a, b in of.apart}


def _law_words(law: Interaction, gap: str | float | None) -> str:
    static, kinetic, _ = law.friction
    falls = f" to {kinetic:g}" if kinetic < static else ""
    return f"friction {static:g}{falls}" + ("" if gap is None else f", clearance {gap}")


def contact_flaw(said: str) -> Warned:
    """Of what `DeckContact.flaws` tells."""
    return Warned(f"contact of the deck that is not taken over as it stands: {said}")


def contact_table(model: Model, pair: SurfacePair, law: Interaction) -> dict[str, Any]:
    """A pair of the deck as a [contact.NAME] table.

    Raises
    ------
    InputError : damping beside a stiffness from the elements, node by node.
    """
    table: dict[str, Any] = {
        "secondary": pair.secondary,
        "main": pair.main,
        "method": pair.method,
        "clearance": pair.clearance,
        "damping": law.damping,
        "friction": friction_of(law.friction),
    }
    if law.law == "tabular":
        table["overclosure"] = law.curve
    else:
        table["stiffness"] = law.stiffness if law.law == "linear" else _enforced(pair, law)
    has_facets = not model.surfaces[pair.secondary].is_node_based
    if pair.method == "node-to-surface" and has_facets and law.law in ("linear", "tabular"):
        table["per_area"] = True
    elif law.damping and pair.method == "node-to-surface" and has_facets and table["stiffness"] == "auto":
        raise InputError(
            f"interaction {law.name!r} damps node-to-surface contact with a stiffness from the elements",
            where=law.where,
            expected="a pressure-overclosure law beside *CONTACT DAMPING",
            fix="Give PRESSURE-OVERCLOSURE=LINEAR with a stiffness, or TYPE=SURFACE TO SURFACE.",
        )
    return table


def friction_of(law: tuple[float, float, float]) -> float | dict[str, float]:
    """Static and kinetic coefficient and decay speed as a contact table has them."""
    static, kinetic, decay = law
    return static if static == kinetic else {"static": static, "kinetic": kinetic, "decay": decay}


def _enforced(pair: SurfacePair, law: Interaction) -> str:
    """Hard contact as Abaqus enforces it unless told otherwise: finite sliding between surfaces by a penalty."""
    if law.law == "penalty":
        return "auto"
    by_penalty = pair.method == "surface-to-surface" and not pair.small_sliding
    return "auto" if law.law == "default" and by_penalty else "hard"
