"""A setup under other tables of its study: nothing is read, found or assembled again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.gap_operator import GapOperator, join
from creak.contact.laws.parameters import Curves, Friction
from creak.contact.play import play_channels
from creak.model.mesh import Model, Nodes
from creak.studies.design.clips import with_clips
from creak.studies.file.case import Touching
from creak.studies.file.contact_tables import ContactTable
from creak.studies.prepare.excitation import loads_over
from creak.studies.prepare.pairs import contact_channels, contact_law, plays_of
from creak.studies.prepare.setup import Setup

OF_CONTACT = ("connector", "clip")
OF_LOADS = ("excitation", "time", "output")


def varied(
    setup: Setup,
    tables: Mapping[str, Any],
    fields: Mapping[str, FloatArray] | None = None,
    factors: Mapping[str, float] | None = None,
) -> Setup:
    """The setup with other tables of its study, and channels and loads by them; model and pairs of nodes stay.

    Numbers that setting up derived stay in all other tables. Channels of contacts whose table stays are those that the
    setup has, of a static state where it has one.

    Parameters
    ----------
    tables : name -> table, as the configuration has them. They may differ in numbers of contact, connectors and clips
        with play, signals, static loads, damping, time and output, and in what setting up does not look at.
    fields : contact -> (m,) gaps of its channels. factors : contact -> factor on the stiffness of its channels.

    Raises
    ------
    InputError : as setting up, for these numbers.
    """
    changed = setup.with_tables(**tables)
    before, now = setup.study.config, changed.study.config
    fields, factors = fields or {}, factors or {}
    other = [n for n, t in now.contact.items() if before.contact[n] != t or n in fields or n in factors]
    given, touching = setup.study.touching, changed.study.touching
    pieces = []
    for n in other:
        own = setup.contacts.select(_of(setup.contacts, n))
        if own.friction is None and contact_law(touching.contacts[n], "").friction.static > 0.0:
            own = _rubbing(setup.model, given, touching, n, own)
        nearest = at_nearest_wall(own, setup.model.nodes)
        pieces.append(_contact(own, nearest, n, given, touching, fields.get(n), factors.get(n, 1.0)))
    if pieces:
        changed = replace(changed, contacts=_put(setup.contacts, pieces))
    if any(getattr(before, name) != getattr(now, name) for name in OF_CONTACT):
        model, clips, _ = with_clips(setup.model, touching)
        plays = [play_channels(model, p, where) for p, where in [*plays_of(touching), *clips]]
        changed = replace(changed, connectors=join(plays))
    if any(getattr(before, name) != getattr(now, name) for name in OF_LOADS):
        changed = replace(changed, loads=loads_over(setup.model, changed.study.driving, changed.study.course))
    return changed


def _of(gaps: GapOperator, name: str) -> IntArray:
    return np.flatnonzero(np.array(gaps.group, dtype=object) == name)


def _put(whole: GapOperator, pieces: Sequence[GapOperator]) -> GapOperator:
    """The channels with those of some contacts in place of theirs, in the same order."""
    given = {piece.group[0]: piece for piece in pieces if piece.m}
    names = dict.fromkeys(whole.group)
    joined = join([given.get(name) or whole.select(_of(whole, name)) for name in names])
    place = {name: k for k, name in enumerate(joined.names)}
    return joined.select(np.array([place[name] for name in whole.names], dtype=np.int64))


def at_nearest_wall(contacts: GapOperator, nodes: Nodes) -> BoolArray:
    """(m,) channels to the wall that the clearance of their contact holds for; those to further ones are NAME:2."""
    named = zip(contacts.names, contacts.group, contacts.nodes_idx.tolist(), strict=True)
    return np.array([name == f"{group}:{nodes.label(node)}" for name, group, node in named], dtype=bool)


def changed_gaps(
    contacts: GapOperator, nodes: Nodes, before: Touching, now: Touching, fields: Mapping[str, FloatArray]
) -> FloatArray:
    """(m,) gaps of the contacts' channels as `varied` makes them, without the rest of it.

    Parameters
    ----------
    fields : as for `varied`.
    """
    gap0 = contacts.gap0.copy()
    for name, new in now.contacts.items():
        old = before.contacts[name]
        if new != old or name in fields:
            own = _of(contacts, name)
            nearest = at_nearest_wall(contacts.select(own), nodes)
            gap0[own] = _gaps(old, new, fields.get(name), gap0[own], nearest, press_fit=now.press_fit)
    return gap0


def _gaps(
    old: ContactTable,
    new: ContactTable,
    field: FloatArray | None,
    gap0: FloatArray,
    nearest: BoolArray,
    *,
    press_fit: bool,
) -> FloatArray:
    """(m,) gaps of one contact by other numbers, given those that it has; a clearance holds for the nearest wall."""
    if field is not None:
        gap0 = field
    elif isinstance(new.clearance, int | float) and new.clearance != old.clearance:
        gap0 = np.where(nearest, float(new.clearance), gap0)
    return gap0 if press_fit else np.maximum(gap0, 0.0)


def _rubbing(model: Model, before: Touching, now: Touching, name: str, own: GapOperator) -> GapOperator:
    """The channels of a contact on which something begins to rub: its sides, which the nodes' rotations move."""
    table = before.contacts[name].model_copy(update={"friction": now.contacts[name].friction})
    whole, _ = contact_channels(model, replace(before, contacts={name: table}))
    place = {channel: k for k, channel in enumerate(whole.names)}
    whole = whole.select(np.array([place[channel] for channel in own.names], dtype=np.int64))
    return replace(own, labels=whole.labels, G=whole.G, tangents=whole.tangents)


def _contact(
    piece: GapOperator,
    nearest: BoolArray,
    name: str,
    before: Touching,
    now: Touching,
    field: FloatArray | None,
    factor: float,
) -> GapOperator:
    """The channels of one contact by the numbers of another study."""
    old, new = before.contacts[name], now.contacts[name]
    gap0 = _gaps(old, new, field, piece.gap0, nearest, press_fit=now.press_fit)
    piece = replace(piece, gap0=gap0, stiffness=factor * piece.stiffness)
    if new == old:
        return piece
    where = now.places.where("contact", name)
    law, law_before = contact_law(new, where), contact_law(old, where)
    scale = piece.area if new.method == "surface-to-surface" or new.per_area else np.ones(piece.m)
    stiffness, curves = piece.stiffness, piece.curves
    if law.stiffness is not None and law.stiffness != law_before.stiffness:
        stiffness = law.stiffness * scale
    elif law.curve is not None and new.overclosure != old.overclosure:
        stiffness = float(law.steepest or 0.0) * scale
        curves = Curves(np.zeros(piece.m, dtype=np.int64), scale.copy(), (law.curve,))
    friction = Friction(*(np.full(piece.m, x) for x in law.friction)) if law.friction.static > 0.0 else None
    damping = law.damping * scale
    return replace(piece, stiffness=stiffness, curves=curves, friction=friction, damping=damping)
