"""A deck's own step as a study: what `creak run DECK.inp` (*DYNAMIC) or `creak run DECK.bdf` (SOL 109, 112) runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from creak.arrays import IntArray
from creak.errors import InputError
from creak.formats.deck.membranes import with_held_membranes
from creak.formats.decks import format_of
from creak.model.mesh import Model
from creak.model.steps import (
    EVERY_NODE,
    Amplitude,
    DeckRun,
    DynamicStep,
    PointLoad,
    Prescribed,
    Stop,
)
from creak.model.units import UnitsName
from creak.studies.file.config import StudyConfig
from creak.studies.file.paths import digests_of
from creak.studies.file.places import Keys, Places, dotted
from creak.studies.file.reader import Study
from creak.studies.file.table import DOFS
from creak.studies.prepare.deck_contact import contact_table, friction_of
from creak.studies.prepare.modal_step import damped_in, tables_in_modes
from creak.studies.prepare.setup import Setup, set_up_model
from creak.studies.prepare.unit_check import units_of_study
from creak.studies.unraised import none_ignored

ALPHA = {"TRANSIENT FIDELITY": -0.05, "MODERATE DISSIPATION": -0.41421}
"""HHT's alpha of each APPLICATION, as Abaqus has it (Analysis User's Guide, 6.3.2)."""
WATCHED = 1000
"""Nodes of an output set up to which their motion is kept."""
LOWEST = 1e-3
"""Hz; a run that is not compared with a reduced one needs no modes."""
STATIC = "STATIC"
"""Name of the loads that a deck's own run starts under."""
WHOLE = 1e-6
"""Share of an increment by which the period may miss a whole number of them."""


@none_ignored()
def set_up_deck(path: Path, ignore: Sequence[str] = (), units: UnitsName | None = None) -> Setup:
    """Read a deck and make its own step ready to run: the first *DYNAMIC step of an Abaqus deck or SOL 109, 112 or 129
    of a Nastran deck, unreduced, with all its contact channels; of an Abaqus deck without any the first *MODAL DYNAMIC
    step, reduced as a study is.

    Unlike in a study, parts may move freely: they start with the deck's initial velocity.

    Parameters
    ----------
    ignore : keywords of the deck that may go unread although they change the answer.
    units : of the deck; None: those that its materials and size fit.

    Raises
    ------
    InputError : anything wrong with the deck, or no step in it that creak can run.
    """
    model, run = format_of(path).read_run(path)
    model = with_held_membranes(model)
    _check_start(model, run.step.moved)
    sets: dict[str, IntArray] = {}
    places: dict[Keys, str] = {
        ("time",): run.step.places["time"],
        ("time", "integrator"): run.step.places["dynamic"],
        ("excitation",): run.step.where,
        ("contact",): run.step.where,
    }
    notes: list[str] = []
    tables = {
        "title": run.step.name if run.step.name != "1" else path.stem,
        "model": {"deck": path.name, "units": units or units_of_study(model)},
        "contact": _contacts(model, run, places, notes),
        "connector": _connectors(run, sets, places),
        "excitation": _excitations(run, sets, places),
        "static": _static(run, places),
        "time": _time(run, notes) if run.step.modes is None else {},
        "output": {"nodes": _watched(model, run.step, sets, notes)},
        "reduction": {"method": "none"},
        "precheck": {"enabled": False},
        "verification": {"mac_f_max": LOWEST},
    }
    if run.step.modes is not None:
        tables |= tables_in_modes(run.step, run.step.modes, notes)
    written = Places(path, of_deck=places)
    config = _checked(tables, written)
    study = Study(config, config.model_dump_json(indent=2, exclude_defaults=True), written)
    loads = model.static_loads if run.static is None else {STATIC: run.static}
    model = replace(model, node_sets={**model.node_sets, **sets}, static_loads=loads)
    setup = set_up_model(study, model, ignore, free=True)
    if run.step.modes is not None:
        setup = replace(setup, structure=damped_in(setup.structure, run.step.modes))
    notes = [*_steps_note(run), *notes, *setup.notes]
    return replace(setup, notes=notes, digests=digests_of(study))


def _checked(tables: dict[str, Any], places: Places) -> StudyConfig:
    try:
        return StudyConfig.model_validate(tables)
    except ValidationError as error:
        problem = error.errors()[0]
        keys = problem["loc"]
        raise InputError(f"{dotted(keys)}: {problem['msg']}", where=places.where(*keys)) from error


def _check_start(model: Model, moved: Sequence[Prescribed]) -> None:
    """A dof whose acceleration is prescribed starts from rest."""
    starts = {(row, dof) for row, dof, value in model.initial_velocity if value}
    for m in moved:
        both = [int(n) for n in m.nodes_idx if (int(n), m.dof) in starts]
        if m.kind == "acceleration" and both:
            raise InputError(
                f"node {model.nodes.label(both[0])} has an initial velocity and a prescribed acceleration in dof "
                f"{m.dof}",
                where=m.where,
                expected="one of them",
                fix="Prescribe its velocity instead.",
            )


def _steps_note(run: DeckRun) -> list[str]:
    notes, kind = [], "*DYNAMIC" if run.step.modes is None else "*MODAL DYNAMIC"
    if run.before:
        notes.append(f"steps before the {kind} step, which change nothing: {', '.join(run.before)}")
    if run.after:
        notes.append(f"steps after the first {kind} step were not run: {', '.join(run.after)}")
    moved = [run.amplitudes[m.amplitude] for m in run.step.moved if m.amplitude and m.kind != "acceleration"]
    if any(a.kind == "tabular" and a.rounding and len(a.points) > 2 for a in moved):
        why = "(SMOOTH, 0.25 unless the deck says it), as in Abaqus; CalculiX has them sharp: for that give SMOOTH=0"
        notes.append(f"corners of the tables that move supports are rounded {why}")
    return notes


def _time(run: DeckRun, notes: list[str]) -> dict[str, Any]:
    step = run.step
    count = ceil(step.period / step.increment - WHOLE)
    if abs(count * step.increment - step.period) > WHOLE * step.increment:
        notes.append(
            f"the period of {step.period:g} s is no multiple of the increment, {step.increment:g} s: the run ends at "
            f"{count * step.increment:g} s"
        )
    if not step.direct:
        notes.append(
            f"creak has no automatic increments: all have the size of the first, {step.increment:g} s; compare with a "
            "smaller one"
        )
    return {
        "step": step.increment,
        "end": count * step.increment,
        "integrator": "hht",
        "alpha": _alpha(run, notes),
    }


def _alpha(run: DeckRun, notes: list[str]) -> float:
    if run.step.alpha is not None:
        return run.step.alpha
    application = run.step.application
    if not application:
        application = "MODERATE DISSIPATION" if run.pairs else "TRANSIENT FIDELITY"
    if not run.step.application and run.pairs:
        notes.append(
            "the deck has contact and gives neither ALPHA nor APPLICATION: as in Abaqus the step is one of moderate "
            f"dissipation, alpha = {ALPHA[application]:g}; ALPHA=-0.05 on *DYNAMIC damps less"
        )
    return ALPHA[application]


def _watched(model: Model, step: DynamicStep, sets: dict[str, IntArray], notes: list[str]) -> list[str]:
    """The node sets whose motion is kept; all nodes of the structure become one where the deck asks for them."""
    names = []
    for name in step.output_sets:
        if name == EVERY_NODE:
            sets[name] = np.unique(np.concatenate([p.nodes_idx for p in model.parts]))
        count = (sets[name] if name == EVERY_NODE else model.node_set(name, where=step.where)).size
        if count <= WATCHED:
            names.append(name)
        else:
            what = (
                f"the motion of all {count} nodes" if name == EVERY_NODE else f"that of node set {name}, {count} nodes"
            )
            notes.append(f"the step asks for {what}; it is kept of up to {WATCHED} nodes: name a set of fewer")
    if not step.output_sets:
        notes.append(
            "the step asks for the output of no node set, so no motion is kept: add *NODE OUTPUT, NSET= for it "
            "(Nastran: DISPLACEMENT = n with SET n)"
        )
    return names


def _excitations(run: DeckRun, sets: dict[str, IntArray], places: dict[Keys, str]) -> dict[str, dict[str, Any]]:
    """Prescribed motion and loads; the nodes of each become a node set of the name of the excitation."""
    result: dict[str, dict[str, Any]] = {}
    entries: list[Prescribed | PointLoad] = [*run.step.moved, *run.step.loads]
    for entry in entries:
        kind = entry.kind if isinstance(entry, Prescribed) else "force"
        base = f"{entry.name} {DOFS[entry.dof - 1]} {kind}"
        name = base if base not in result else f"{base} {len(result) + 1}"
        signal = _signal(run, entry)
        sets[name.upper()] = entry.nodes_idx
        places["excitation", name] = entry.where
        result[name] = {"node_set": name, "dof": DOFS[entry.dof - 1], "kind": kind, "signal": signal}
    return result


def _static(run: DeckRun, places: dict[Keys, str]) -> list[dict[str, Any]]:
    """Loads of the steps before, which the model has under `STATIC`."""
    if run.static is None:
        return []
    places["static",] = run.static.where
    return [{"deck_loads": STATIC}]


def _signal(run: DeckRun, entry: Prescribed | PointLoad) -> dict[str, Any]:
    """Value times amplitude; without amplitude constant, or a line over the step."""
    if not entry.amplitude:
        if run.step.ramped:
            values = [(0.0, 0.0), (run.step.period, entry.value)]
            return {"type": "table", "values": values, "rounding": 0.0}
        return {"type": "step", "amplitude": entry.value}
    return _scaled(run.amplitudes[entry.amplitude], entry.value)


def _scaled(a: Amplitude, factor: float) -> dict[str, Any]:
    if a.kind == "periodic" and len(a.sine) == 1 and not (a.cosine[0] or a.mean or a.start):
        return {"type": "sine", "frequency": a.frequency, "amplitude": factor * a.sine[0]}
    if a.kind == "periodic":
        cosine, sine = ([factor * x for x in c] for c in (a.cosine, a.sine))
        return {
            "type": "periodic",
            "frequency": a.frequency,
            "cosine": cosine,
            "sine": sine,
            "mean": factor * a.mean,
            "start": a.start,
        }
    values = [(t, factor * x) for t, x in a.points.tolist()]
    if a.kind == "smooth step":
        return {"type": "smooth-step", "values": values}
    return {"type": "table", "values": values, "rounding": a.rounding}


def _contacts(model: Model, run: DeckRun, places: dict[Keys, str], notes: list[str]) -> dict[str, dict[str, Any]]:
    """A contact table for each pair, named by its surfaces."""
    result: dict[str, dict[str, Any]] = {}
    for pair in run.pairs:
        base = f"{pair.secondary}-{pair.main}"
        name = base if base not in result else f"{base}-{len(result) + 1}"
        places["contact", name] = pair.where
        if pair.method == "surface-to-surface" and model.surfaces[pair.secondary].is_node_based:
            notes.append(f"{pair.secondary} is a surface of nodes: its contact is node-to-surface")
            pair = replace(pair, method="node-to-surface")
        result[name] = contact_table(model, pair, run.interactions[pair.interaction])
    large = sum(not p.small_sliding for p in run.pairs)
    if large:
        notes.append(f"{large} contact pair(s) without SMALL SLIDING: creak takes all sliding as small")
    return result


def _connectors(run: DeckRun, sets: dict[str, IntArray], places: dict[Keys, str]) -> list[dict[str, Any]]:
    """A play connector for each group of stops, between two node sets of its name."""
    result = []
    for k, stop in enumerate(run.stops):
        sets |= stop.node_sets
        places["connector", k] = stop.where
        result.append(connector_table(stop))
    return result


def connector_table(stop: Stop) -> dict[str, Any]:
    """Gaps of the deck between pairs of nodes as a [[connector]] table."""
    return {
        "type": "play",
        "name": stop.name,
        "nodes": list(stop.node_sets),
        "dof": DOFS[stop.dof - 1] if stop.direction is None else None,
        "axis": stop.direction,
        "lower": stop.lower,
        "upper": stop.upper,
        "stiffness": "hard" if stop.stiffness == np.inf else stop.stiffness,
        "friction": friction_of(stop.friction),
    }
