"""Draws on a model that was reduced once: what other numbers make of its channels, loads and damping."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator, join
from creak.contact.laws.parameters import Curves, Friction
from creak.contact.play import play_channels
from creak.studies.design.clips import with_clips
from creak.studies.file.case import Touching
from creak.studies.file.contact_tables import ContactTable
from creak.studies.file.design.clip_tables import ClipTable
from creak.studies.file.reader import Study
from creak.studies.prepare.excitation import sample_loads
from creak.studies.prepare.pairs import contact_law, plays_of
from creak.studies.prepare.setup import Setup

OF_CONTACT = ("clearance", "friction", "stiffness", "damping")
OF_SIGNAL = ("amplitude", "seed", "mean")
"""Numbers of a signal that change neither its length nor its frequencies."""


def keeps_model(clips: Sequence[ClipTable], key: str) -> bool:
    """Whether another value leaves the reduced model, its channels and the steps of the run as they are."""
    words = key.split(".")
    if words[0] == "contact" and len(words) > 2:
        return words[2] in OF_CONTACT and (len(words) == 3 or words[2] == "friction")
    if words[0] == "clip" and len(words) > 2 and words[1].isdigit():
        return int(words[1]) < len(clips) and clips[int(words[1])].type not in ("bushing", None)
    if words[0] == "excitation":
        return len(words) == 4 and words[2] == "signal" and words[3] in OF_SIGNAL
    return key == "damping.modal" or words[0] in ("connector", "static")


def changed_setup(
    setup: Setup, study: Study, fields: Mapping[str, FloatArray], factors: Mapping[str, float] | None = None
) -> Setup:
    """The setup of a study that differs in numbers as `keeps_model` lets pass; its deck is not read again.

    Parameters
    ----------
    setup : before its static start. fields : contact -> (m,) gaps of its channels. factors : contact -> factor on the
        stiffness of its channels.
    """
    before = setup.study.config
    by = factors or {}
    other = [n for n, t in study.config.contact.items() if before.contact[n] != t or n in fields or n in by]
    given, now = setup.study.touching, study.touching
    contacts = [_contact(setup.contacts, name, given, now, fields.get(name), by.get(name, 1.0)) for name in other]
    whole = _put(setup.contacts, contacts) if contacts else setup.contacts
    connectors = setup.connectors
    if (before.connector, before.clip) != (study.config.connector, study.config.clip):
        model, clips, _ = with_clips(setup.model, now)
        connectors = join([play_channels(model, p, where) for p, where in [*plays_of(now), *clips]])
    loads = setup.loads
    if before.excitation != study.config.excitation:
        loads = sample_loads(setup.model, study.driving, setup.loads.time)
    config = study.config.model_copy(update={"time": before.time, "output": before.output})
    return replace(
        setup, study=replace(study, config=config), contacts=whole, connectors=connectors, loads=loads, notes=[]
    )


def _of(gaps: GapOperator, name: str) -> IntArray:
    return np.flatnonzero(np.array(gaps.group, dtype=object) == name)


def _put(whole: GapOperator, pieces: Sequence[GapOperator]) -> GapOperator:
    """The channels with those of some contacts in place of theirs, in the same order."""
    given = {piece.group[0]: piece for piece in pieces if piece.m}
    names = dict.fromkeys(whole.group)
    joined = join([given.get(name) or whole.select(_of(whole, name)) for name in names])
    place = {name: k for k, name in enumerate(joined.names)}
    return joined.select(np.array([place[name] for name in whole.names], dtype=np.int64))


def changed_gaps(
    contacts: GapOperator, before: Touching, now: Touching, fields: Mapping[str, FloatArray]
) -> FloatArray:
    """(m,) gaps of the contacts' channels as `changed_setup` makes them, without the rest of it.

    Parameters
    ----------
    fields : as for `changed_setup`.
    """
    gap0 = contacts.gap0.copy()
    for name, new in now.contacts.items():
        old = before.contacts[name]
        if new != old or name in fields:
            own = _of(contacts, name)
            gap0[own] = _gaps(old, new, fields.get(name), gap0[own], press_fit=now.press_fit)
    return gap0


def _gaps(
    old: ContactTable, new: ContactTable, field: FloatArray | None, gap0: FloatArray, *, press_fit: bool
) -> FloatArray:
    """(m,) gaps of one contact by other numbers, given those that it has."""
    if field is not None:
        gap0 = field
    elif isinstance(new.clearance, int | float) and new.clearance != old.clearance:
        gap0 = np.full(gap0.size, float(new.clearance))
    return gap0 if press_fit else np.maximum(gap0, 0.0)


def _contact(
    contacts: GapOperator, name: str, before: Touching, now: Touching, field: FloatArray | None, factor: float
) -> GapOperator:
    """The channels of one contact by the numbers of another study."""
    piece = contacts.select(_of(contacts, name))
    old, new = before.contacts[name], now.contacts[name]
    gap0 = _gaps(old, new, field, piece.gap0, press_fit=now.press_fit)
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


def with_damping(system: System, zeta: float, before: float) -> System:
    """A reduced System all of whose modes have another share of critical damping."""
    by, sup = zeta / before, system.supports
    assert system.damping.modal_values is not None
    damping = replace(system.damping, modal_values=by * system.damping.modal_values)
    return replace(system, damping=damping, supports=replace(sup, C_qs=by * sup.C_qs, C_ss=by * sup.C_ss))
