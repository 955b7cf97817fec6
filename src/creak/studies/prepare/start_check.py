"""What a study says that can hardly be meant, seen before it is run, and contact that never happens."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.coupling import Driven
from creak.assembly.damping import is_damped, undamped_words
from creak.assembly.elimination import LinearEquation
from creak.assembly.part import Rayleigh
from creak.assembly.rigid import loose_motions, loose_words, unheld_parts
from creak.assembly.system import System
from creak.contact.crossing import crossing_warnings
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.dynamics.loads import Loads
from creak.errors import InputError
from creak.formats.endings import is_deck
from creak.model.dofs import TRANSLATIONS, node_and_dof, node_dofs
from creak.model.faces import vector_areas
from creak.model.mesh import Model
from creak.model.units import UNITS, Units
from creak.studies.file.case import Driving, Touching
from creak.studies.file.config import DampingTable, PrecheckTable, TimeTable
from creak.studies.file.contact_tables import ConnectorTable
from creak.studies.file.signals.tables import RecordTable, TableTable
from creak.studies.prepare.amount_check import evened_notes, record_warnings
from creak.studies.prepare.imported import resistance
from creak.studies.prepare.massless import massless_words
from creak.studies.prepare.unit_check import SYSTEMS, across, unit_warnings
from creak.studies.warned import Warned

WIDE = 0.1
"""Share of the model's size above which a margin of the pre-check can hardly be meant."""
STEPS = 10
"""In a period of the highest excitation frequency: with fewer, vibration itself goes wrong."""
MODAL = 0.2
"""Fraction of critical of all modes above which per cent may have been meant."""
CRITICAL = 1.0
"""Fraction of critical from Rayleigh damping, at the highest excitation frequency, that can hardly be meant."""
UNUSED = 0.01
"""Share of a table that a run must reach before the rest is taken for a mistake in its unit of time."""
ALONG = 1e-3
"""Share of a node's motion in a gap from which on it moves along the normal of the contact."""
WARPED = 0.2
"""Distance of the corners from their mean plane over the root of the area: one corner of a square folded up by some
50 degrees; coarse meshes of sharp bends have less."""


def start_warnings(model: Model, touching: Touching, precheck: PrecheckTable) -> list[str]:
    """Units of materials and lengths, and the margin of the pre-check, against the model."""
    units = touching.units
    texts = [
        *unit_warnings(model, units),
        *massless_words(model),
        *_margin(model, touching, precheck),
        *_warped(model),
        *crossing_warnings(model, UNITS[units].length),
        *_squeezed(touching.connectors, UNITS[units]),
    ]
    return [Warned(text) for text in texts]


def drive_warnings(model: Model, driving: Driving, loads: Loads, driven: Driven, contacts: GapOperator) -> list[str]:
    """Excitations that move nothing, or what contact should move."""
    texts = [*_idle(driving, loads), *record_warnings(driving, loads), *_stuck(model, driving, loads, driven)]
    return [*evened_notes(driving), *[Warned(text) for text in (*texts, *_driven_contact(model, driven, contacts))]]


def pace_warnings(time: TimeTable, modal: float | None, rayleigh: Rayleigh, highest: float) -> list[str]:
    """Steps too long, damping that lets nothing vibrate.

    Parameters
    ----------
    modal : share of critical that the study asks for.
    highest : frequency that the excitations hold, Hz; 0 where it is not known.
    """
    return [Warned(text) for text in (*_coarse(time, highest), *_damped(modal, rayleigh, highest))]


def undamped_warnings(
    model: Model, damping: DampingTable, touching: Touching, superelements: Sequence[System]
) -> list[str]:
    """A model in which nothing damps, or hardly any element: neither the deck nor the study says how, nor that nothing
    does."""
    if any(given is not None for given in (damping.modal, damping.rayleigh, damping.from_test)):
        return []
    laws = [*(t.damping for t in touching.connectors), *(t.damping for t in touching.contacts.values())]
    fix = (
        "give the study the line damping.modal = 0.02 above its first table (or modal = 0.02 under [damping]; a deck "
        "*DAMPING): 2 % of critical in every mode; 0 says that none is meant"
    )
    if bare := undamped_words(model):
        return [
            Warned(
                f"{bare} are undamped: the deck damps other elements alone, and no study says how, so that vibration "
                f"hardly dies out; {fix}"
            )
        ]
    if any(laws) or is_damped(model) or any(s.damping.extra is not None for s in superelements):
        return []
    return [
        Warned(
            "nothing is damped: neither the deck nor a study says how, so that no vibration dies out and each blow "
            f"decides over all that follow; {fix}"
        )
    ]


def figure_warnings(model: Model, units: str, mass: float, omega2: FloatArray) -> list[str]:
    """Mass and first natural frequency against the units; none where the model itself was warned of.

    Parameters
    ----------
    omega2 : squares of the natural frequencies, rad^2/s^2, in order; rigid-body modes are 0.
    """
    if unit_warnings(model, units):
        return []
    elastic = omega2[omega2 > 0.0]
    frequency = float(np.sqrt(elastic[0]) / (2.0 * np.pi)) if elastic.size else None
    return [Warned(text) for text in unit_warnings(model, units, mass=mass, frequency=frequency)]


def nothing_rattles(path: Path, channels: int, contacts: int) -> str:
    """For a study, or a deck that is run by itself, without channels that press.

    Parameters
    ----------
    channels : that there are. contacts : that it has, which ties may have left without any.
    """
    of, fix = "study", "fill in a [contact.NAME] or a [[connector]]"
    if is_deck(path):
        of, fix = "deck", f"write a study for it by creak new {path.name}"
    what = "contacts and connectors without any stiffness" if channels else "no contact and no connector"
    if contacts and not channels:
        what, fix = "contacts only where ties hold both sides together", "take the ties out, or name other surfaces"
    return f"the {of} has {what}, so nothing can rattle: {fix}"


def nothing_closes(contacts: GapOperator, smallest: FloatArray, margin: str, unit: str) -> str:
    """For a pre-check that keeps no channel: the closest approach, and what to do.

    Parameters
    ----------
    smallest : (m,) smallest gap of every channel in the linear run.
    margin : what it had to fall to, in words. unit : of length.
    """
    k = int(np.argmin(smallest))
    return Warned(
        f"no contact comes within the pre-check's margin of {margin}: the closest approach is {smallest[k]:.3g} {unit} "
        f"at {contacts.names[k]}, which starts {contacts.gap0[k]:.3g} {unit} open; raise the excitation's amplitude, "
        "or look whether distances and units are as meant"
    )


def never_closed(gaps: GapOperator, history: History, unit: str) -> str:
    """For runs without a contact event: the closest approach."""
    step, k = np.unravel_index(int(np.argmin(history.gap)), history.gap.shape)
    return Warned(
        f"nothing touched in the run: the closest approach was {history.gap[step, k]:.3g} {unit} at {gaps.names[k]}, "
        f"t = {history.time[step]:.4g} s, from {gaps.gap0[k]:.3g} {unit} at the start"
    )


def check_held(
    model: Model, driven: Driven, connectors: GapOperator, superelements: Sequence[System], free: bool
) -> list[str]:
    """A note of the parts that nothing holds, where they are `free` to move.

    Raises
    ------
    InputError : they are not.
    """
    G = connectors.G
    stops = [
        LinearEquation(connectors.labels[G.indices[a:b]].tolist(), G.data[a:b].tolist())
        for a, b in zip(G.indptr[:-1], G.indptr[1:], strict=True)
    ]
    stops += [e for s in superelements for e in resistance(s)]
    loose = unheld_parts(model, driven, stops)
    if not loose:
        return []
    how = loose_words(loose_motions(model, driven, loose, stops))
    if not free:
        raise InputError(
            f"nothing holds part(s) {how}: they can move as rigid bodies once coupled",
            where=model.source,
            expected="supports, links, springs or connectors that hold every part",
            fix="Add supports (*BOUNDARY, SPC), couple them to a part that is held, or prescribe their motion by an "
            "[excitation].",
        )
    note = f"nothing holds part(s) {how}: they move freely"
    return [note] if model.initial_velocity else [Warned(f"{note}; *BOUNDARY conditions would hold them")]


def _margin(model: Model, touching: Touching, precheck: PrecheckTable) -> list[str]:
    margin, size = precheck.margin, across(model)
    if margin == "auto" or not (precheck.enabled and touching.contacts and size and margin > WIDE * size):
        return []
    unit = SYSTEMS[touching.units].words[0]
    return [
        f"[precheck] margin = {margin:g} {unit} is {100.0 * margin / size:.0f} % of the model's size: every channel is "
        "kept; leave it out, and it is a share of each gap"
    ]


def _squeezed(connectors: Sequence[ConnectorTable], units: Units) -> list[str]:
    """Play connectors that are not at rest at rest."""
    out = []
    for number, t in enumerate(connectors, start=1):
        beyond = max(t.lower or 0.0, -(t.upper or 0.0))
        length, force = units.of_motion(t.turns)
        presses = "it is hard and throws its nodes apart"
        if not isinstance(t.stiffness, str):
            presses = f"it presses with {beyond * t.stiffness:g} {force}"
        if beyond > 0.0:
            out.append(
                f"connector {t.name or number} is squeezed by {beyond:g} {length} where the model is at rest, as 0 "
                f"lies outside its limits: {presses} at once; are signs and order of the nodes as meant?"
            )
    return out


def _idle(driving: Driving, loads: Loads) -> list[str]:
    """Excitations that are zero at every step, or are tables far longer than the run; records are told elsewhere."""
    told = {name for name, t in driving.moving.items() if isinstance(t.signal, RecordTable)}
    still = [n for j, n in enumerate(driving.moving) if n not in told and not loads.support[:, :, j].any()]
    still += [name for j, name in enumerate(driving.forcing) if not loads.force[:, j].any()]
    texts = [f"[excitation.{name}] is zero throughout the run: look at its amplitude and times" for name in still]
    end = float(loads.time[-1])
    for name, t in driving.excitations.items():
        points = (t.signal.values or []) if isinstance(t.signal, TableTable) else []
        if points and end < UNUSED * points[-1][0]:
            texts.append(
                f"the table of [excitation.{name}] reaches to {points[-1][0]:g} s, the run to {end:g} s: are its "
                "times in s?"
            )
    return texts


def _stuck(model: Model, driving: Driving, loads: Loads, driven: Driven) -> list[str]:
    """Forces on supports and prescribed motion alone."""
    forced = driving.forcing
    if not forced:
        return []
    held = _held(model, driven)
    return [
        f"[excitation.{name}] is a force where the model is held or its motion prescribed: it moves nothing"
        for name, labels in zip(forced, loads.force_labels, strict=True)
        if np.isin(labels, held).all()
    ]


def _driven_contact(model: Model, driven: Driven, contacts: GapOperator) -> list[str]:
    """Prescribed motion of contact nodes along the contact's normal: no contact force can push them back.

    Motion along the surface, as that of a belt under a tip, is left alone, and so are nodes that are clamped otherwise:
    those are where a part is held.
    """
    pressed = contacts.labels[np.unique(contacts.G.indices[np.abs(contacts.G.data) > ALONG])]
    held, texts = _held(model, driven), []
    for name, labels in driven.labels.items():
        nodes = np.unique([node_and_dof(label)[0] for label in labels[np.isin(labels, pressed)].tolist()])
        nodes = nodes[~np.isin(node_dofs(nodes, TRANSLATIONS), held).reshape(nodes.size, 3).all(axis=1)]
        if nodes.size:
            texts.append(
                f"[excitation.{name}] moves {nodes.size} node(s) of a contact along its normal, the first "
                f"{model.nodes.label(int(nodes[0]))}: they give way to no blow. Move nodes away from the contact, or "
                "push these by a force; leave it as it is where they are carried along, as by a rigid fixture"
            )
    return texts


def _held(model: Model, driven: Driven) -> IntArray:
    """Labels of the dofs that supports hold or excitations move."""
    fixed = [node_dofs(f.nodes_idx, f.dofs) for f in model.fixed]
    return np.concatenate([*fixed, *driven.labels.values(), np.zeros(0, dtype=np.int64)])


def _coarse(time: TimeTable, highest: float) -> list[str]:
    """A forced step that cannot follow the vibration."""
    step = time.step
    if time.exact or STEPS * step * highest <= 1.0 + 1e-9:
        return []
    long = (2.0 * np.pi * highest * step) ** 2 / 12.0
    return [
        f"[time] step = {step:g} s is {1.0 / (step * highest):.2g} steps in a period of the highest excitation "
        f"frequency, {highest:g} Hz: the periods of such vibration come out some {100.0 * long:.2g} % too long; "
        f"{1.0 / (STEPS * highest):.2g} s is the longest step to use"
    ]


def _damped(modal: float | None, rayleigh: Rayleigh, highest: float) -> list[str]:
    """Fraction of critical: alpha / (4 pi f) + pi f beta."""
    if modal is not None and modal > MODAL:
        return [f"[damping] modal = {modal:g} is {100.0 * modal:g} % of critical; {modal / 100.0:g} is {modal:g} %"]
    if modal is not None or not highest:
        return []
    share = rayleigh.alpha / (4.0 * np.pi * highest) + np.pi * highest * rayleigh.beta
    if share <= CRITICAL:
        return []
    return [
        f"Rayleigh damping with alpha = {rayleigh.alpha:g} 1/s and beta = {rayleigh.beta:g} s is {share:.2g} times "
        f"critical at {highest:g} Hz: are the two swapped?"
    ]


def _warped(model: Model) -> list[str]:
    """Four-node shells whose corners lie far off a plane."""
    worst, count, label = WARPED, 0, 0
    for block in model.blocks:
        if block.kind == "quad4":
            # Distance of the corners from their mean plane over the root of the area.
            corners = model.nodes.coords[block.nodes_idx]
            normal = vector_areas(corners)
            area = np.linalg.norm(normal, axis=1)
            off = 0.25 * np.einsum("nk,nk->n", corners[:, 0] - corners[:, 1] + corners[:, 2] - corners[:, 3], normal)
            warp = np.divide(np.abs(off), area**1.5, out=np.zeros_like(area), where=area > 0.0)
            count += int((warp > WARPED).sum())
            if warp.max() > worst:
                worst, label = float(warp.max()), int(block.ids[warp.argmax()])
    if not count:
        return []
    return [
        f"{count} four-node shell(s) are strongly warped, the worst is element {label}: its corners lie "
        f"{100.0 * worst:.2g} % of its size off their mean plane; look at its nodes, or divide it into triangles"
    ]
