"""[contact.NAME] and [[connector]] tables -> contact pairs, play and gap channels; tables of clearances."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from creak.arrays import IntArray
from creak.contact.gap_operator import GapOperator, join
from creak.contact.node_to_surface import node_to_surface, nodes_of, overhang
from creak.contact.pair import ContactPair, Keep, tied_channels
from creak.contact.play import Play
from creak.contact.surface_to_surface import surface_to_surface
from creak.digest import file_stem
from creak.errors import InputError
from creak.model.contact_law import ContactLaw, Coulomb
from creak.model.mesh import Model
from creak.model.units import UNITS
from creak.studies.design.named_nodes import Column, nodal_values
from creak.studies.file.case import Touching
from creak.studies.file.contact_tables import ContactTable, FrictionTable, connector_names
from creak.studies.file.places import Places
from creak.studies.file.table import DOFS
from creak.studies.solved import keep_in
from creak.studies.warned import Warned

COARSER = 2.0
"""Width of secondary over that of main elements from which on the two are better swapped."""
STIFFNESS = {"auto": None, "hard": math.inf}


def contact_pair(model: Model, touching: Touching, name: str) -> ContactPair:
    """What the study says of one contact, with its table of clearances read.

    Raises
    ------
    InputError : an unknown surface or node; a table that cannot be used; a stiffness beside an overclosure curve; a
        clearance below zero without press_fit.
    """
    t = touching.contacts[name]
    return ContactPair(
        name,
        t.secondary,
        t.main,
        t.method,
        _clearance(model, touching, name),
        t.normal,
        t.per_area,
        contact_law(t, touching.places.where("contact", name)),
        press_fit=touching.press_fit,
        unit=UNITS[touching.units].length,
    )


def sides_meant(model: Model, secondary: str, main: str, method: str, where: str) -> tuple[Model, list[str]]:
    """The model in which a secondary set whose numbers fit nodes and elements is one of nodes where the method takes
    nodes, and notes of what is taken of such sets.

    Parameters
    ----------
    where : of the table that names the two, for the notes.
    """
    notes, as_nodes = list[str](), method == "node-to-surface" and secondary.upper() != main.upper()
    for key, name in (("secondary", secondary), ("main", main)):
        if name.upper() not in model.untyped:
            continue
        nodes = as_nodes and key == "secondary"
        notes.append(
            f"{where} {key}: the numbers of {name!r} are those of nodes and of elements, and its "
            f"{'nodes' if nodes else 'elements'} are taken; give the others a set of their own (SET3) if they are meant"
        )
        if nodes:
            others = {n: rows for n, rows in model.element_sets.items() if n != name.upper()}
            surfaces = {n: surface for n, surface in model.surfaces.items() if n != name.upper()}
            model = replace(model, element_sets=others, surfaces=surfaces)
    return model, notes


def contact_law(table: ContactTable, where: str) -> ContactLaw:
    """The law of a contact table.

    Raises
    ------
    InputError : numbers that are no law; a stiffness beside an overclosure curve.
    """
    return ContactLaw(
        _stiffness(table.stiffness),
        None if table.overclosure is None else np.array(table.overclosure, dtype=np.float64).reshape(-1, 2),
        table.damping,
        coulomb_of(table.friction),
        where=where,
    )


def coulomb_of(friction: float | FrictionTable) -> Coulomb:
    """The friction of a contact or connector table."""
    if isinstance(friction, FrictionTable):
        return Coulomb(friction.static, friction.kinetic, friction.decay)
    return Coulomb(friction, friction)


def coarse_side(model: Model, pair: ContactPair, channels: GapOperator) -> list[str]:
    """A secondary surface that is much coarser than the main one where they meet: what lies between its nodes touches
    nothing. Nodes without facets say nothing of it."""
    secondary = nodes_of(model, pair.secondary, where=f"{pair.where} secondary")
    width = secondary.width[np.searchsorted(secondary.rows, channels.nodes_idx)]
    if channels.size is None or not np.isfinite(width).all() or not width.size:
        return []
    coarser = float(np.median(width / channels.size))
    if coarser <= COARSER:
        return []
    turned = "" if pair.normal is None else ", and turn the normal round"
    return [
        f"{pair.where} the elements of its secondary side {pair.secondary!r} are {coarser:.2g} times as wide as those "
        f"of {pair.main!r} opposite, which press in between its {channels.m} gap channels unseen: swap them (secondary "
        f'= "{pair.main}", main = "{pair.secondary}"{turned}), or mesh {pair.secondary!r} finer'
    ]


def pressing_twice(gaps: GapOperator, touching: Touching) -> list[str]:
    """Contacts that share channels, the same motion from the same gap, or surfaces, secondary and main changed over: in
    words. From another gap a channel is a second spring, which begins later.

    Raises
    ------
    InputError : all channels of a contact are those of another.
    """
    G, seen = sp.csr_matrix(gaps.G), dict[tuple[bytes, bytes, float], str]()
    shared = Counter[tuple[str, str]]()
    for j, name in enumerate(gaps.group):
        row = slice(G.indptr[j], G.indptr[j + 1])
        other = seen.setdefault((G.indices[row].tobytes(), G.data[row].tobytes(), float(gaps.gap0[j])), name)
        shared[other, name] += other != name
    said, size, pairs = list[str](), Counter(gaps.group), dict[tuple[str, str], str]()
    for (other, name), count in shared.items():
        if count == size[name]:
            raise InputError(
                f"contact {name} is the same as contact {other}: both would press, each with all of its stiffness",
                where=touching.places.where("contact", name),
                expected="a pair of surfaces once",
                fix="Leave one of them out.",
            )
        if count:
            said.append(f"{count} channels of contact {name} are those of contact {other}, too: there both press")
    for name, t in touching.contacts.items():
        own = t.secondary.upper(), t.main.upper()
        pairs.setdefault(own, name)
        if own[0] != own[1] and own[::-1] in pairs:
            said.append(
                f"contacts {pairs[own[::-1]]} and {name} are of the same surfaces, secondary and main changed over: "
                "both press, so that contact is about twice as stiff as each says. Leave one out, or halve both"
            )
    return said


def plays_of(touching: Touching) -> list[tuple[Play, str]]:
    """The connectors of a study with their places in it."""
    out = []
    names = connector_names(touching.connectors)
    for i, (name, t) in enumerate(zip(names, touching.connectors, strict=True)):
        where = touching.places.where("connector", i)
        law = ContactLaw(
            _stiffness(t.stiffness), None, t.damping, coulomb_of(t.friction), preload=t.preload, where=where
        )
        play = Play(name, t.node_sets, DOFS.index(t.dof or "x") + 1, t.lower, t.upper, law)
        if t.axis is not None:
            play = replace(play, direction=tuple((np.array(t.axis) / np.linalg.norm(t.axis)).tolist()))
        out.append((play, where))
    return out


def _stiffness(given: str | float) -> float | None:
    return STIFFNESS[given] if isinstance(given, str) else given


def _clearance(model: Model, touching: Touching, name: str) -> float | dict[int, float] | None:
    t = touching.contacts[name]
    if not isinstance(t.clearance, str):
        if t.clearance is not None and t.clearance < 0.0 and not touching.press_fit:
            raise InputError(
                f"clearance = {t.clearance:g}",
                expected="zero or more: the length by which the two are apart",
                where=touching.places.where("contact", name, "clearance"),
                fix="Parts that overlap are pressed apart with [[static]] press_fit = true beside it. Where this is a "
                "coordinate or points the other way, give its length alone.",
            )
        return t.clearance
    rows = nodes_of(model, t.secondary, where=f"[contact.{name}] secondary").rows
    where = touching.places.where("contact", name, "clearance")
    return read_clearances(touching.places.sibling(t.clearance), model, rows, t.secondary, where)


def read_clearances(path: Path, model: Model, nodes: IntArray, surface: str, where: str) -> dict[int, float]:
    """Clearances by node row, from a CSV file with the header node,clearance (further columns are not used).

    Parameters
    ----------
    nodes : rows of the nodes of the secondary surface; in decks with instances the label alone will do where it is
        unique among them.

    Raises
    ------
    InputError : no such file, wrong header, no rows; a row without node, with an unknown node, with one that is not
        on the surface or was there before, or with a clearance that is no finite number.
    """
    column = Column("clearance", f"on {surface!r}", f"a node of the secondary surface {surface!r}", "the geometric gap")
    return nodal_values(path, model, nodes, column, where)


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
