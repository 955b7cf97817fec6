"""Contacts of a study -> gap channels."""

from __future__ import annotations

from pathlib import Path

from creak.contact.gap_operator import GapOperator, join
from creak.contact.node_to_surface import node_to_surface, overhang
from creak.contact.pair import ContactPair, Keep, tied_channels
from creak.contact.surface_to_surface import surface_to_surface
from creak.errors import InputError
from creak.formats.safe_names import file_stem
from creak.model.mesh import Model
from creak.studies.file.case import Touching
from creak.studies.file.places import Places
from creak.studies.prepare.pairs import coarse_side, contact_pair, pressing_twice, sides_meant
from creak.studies.solved import keep_in
from creak.studies.warned import Warned

METHODS = {"surface-to-surface": surface_to_surface, "node-to-surface": node_to_surface}


def contact_channels(
    model: Model, touching: Touching, store: Path | None = None, keep: Keep | None = None
) -> tuple[GapOperator, list[str]]:
    """Gap channels of all contacts, and notes. store: folder in which they are kept; or `keep` holds them.

    Raises
    ------
    InputError : anything wrong in a contact.
    """
    operators: list[GapOperator] = []
    notes: list[str] = []
    for name, t in touching.contacts.items():
        own, said = sides_meant(model, t.secondary, t.main, t.method, f"[contact.{name}]")
        try:
            pair = contact_pair(own, touching, name)
            operator, more = METHODS[t.method](own, pair, keep or keep_in(store, f"contact_{file_stem(name)}"))
        except InputError as error:
            raise _in_file(touching.places, name, error) from error
        notes += [*said, *map(Warned, [*more, *coarse_side(own, pair, operator)]), *_overhang(own, pair, operator)]
        operator, told = _that_can_move(own, pair, operator)
        notes += told
        operators.append(operator)
    gaps = join(operators)
    return gaps, [*notes, *map(Warned, pressing_twice(gaps, touching))]


def _overhang(model: Model, pair: ContactPair, operator: GapOperator) -> list[str]:
    """Nodes that lie beyond the main surface: a matter of course where they are few, a warning where most do."""
    if pair.method != "node-to-surface":
        return []
    nodes, count = overhang(model, pair, operator)
    said = (
        f"{pair.where} {nodes.size} of {count} nodes of {pair.secondary!r} face no facet of {pair.main!r} and touch "
        f"nothing: {model.nodes.first_few(nodes)}"
    )
    return ([Warned(said)] if 2 * nodes.size > count else [said]) if nodes.size else []


def _that_can_move(model: Model, pair: ContactPair, operator: GapOperator) -> tuple[GapOperator, list[str]]:
    """The channels that a tie does not hold, and a note of the others."""
    stuck = tied_channels(model, pair, operator)
    if not stuck.any():
        return operator, []
    said = (
        f"{pair.where} {stuck.sum()} of {stuck.size} channels are left out: a tie holds both sides together there, at "
        f"nodes {model.nodes.first_few(operator.nodes_idx[stuck])}"
    )
    return operator.select((~stuck).nonzero()[0]), [said]


def _in_file(places: Places, name: str, error: InputError) -> InputError:
    """The error of a contact pair with its line in the study or in the deck that it came from."""
    table, _, key = error.where.partition("] ")
    if table.rstrip("]") != f"[contact.{name}":
        return error
    where = f"{places.where('contact', name)} {key}".strip()
    return InputError(error.what, expected=error.expected, where=where, fix=error.fix)
