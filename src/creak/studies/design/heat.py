"""Temperatures of the static start: of which nodes, above which temperature without strain, and their loads."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.assembly.drilling import held_drilling
from creak.elements.block_matrices import block_heat_load, expands, expansion_of
from creak.elements.registry import FORMULATIONS
from creak.errors import InputError
from creak.model.constraints import KinematicCoupling, RigidLink
from creak.model.dofs import PER_NODE
from creak.model.mesh import ElementBlock, Model
from creak.model.steps import NodeTemperatures
from creak.studies.design.named_nodes import Column, nodal_values, nodes_of_part
from creak.studies.design.supports import deck_loads
from creak.studies.file.case import Driving
from creak.studies.warned import Warned

UNUSUAL = 200.0
"""Degrees above or below the temperature without strain at which a unit may be wrong."""


@dataclass(frozen=True, eq=False)
class Heat:
    """Temperatures of all nodes, (n_node,) each; nan: none is given."""

    value: FloatArray
    reference: FloatArray
    """Without strain, as the study says; it goes before that of materials."""
    otherwise: FloatArray
    """Where neither study nor material says it."""
    table: IntArray
    """Which [[static]] table gives the temperature, from 0; -1: none."""


def heat_of(model: Model, driving: Driving) -> Heat | None:
    """What the [[static]] tables heat; None where they heat nothing.

    Raises
    ------
    InputError : an unknown node set, part or node; a file that cannot be used.
    """
    nothing = np.full(model.nodes.count, np.nan)
    heat = Heat(nothing, nothing.copy(), nothing.copy(), np.full(nothing.size, -1, dtype=np.int64))
    _put(heat.otherwise, model.initial_temperature)
    found, of_deck = False, np.zeros(model.nodes.count, dtype=bool)
    for k, table in enumerate(driving.statics):
        if table.temperature is not None:
            nodes, value = _given(model, driving, k)
            heat.value[nodes] = value
            heat.reference[nodes] = np.nan if table.reference is None else table.reference
            heat.table[nodes], of_deck[nodes], found = k, False, True
        loads = deck_loads(model, driving, k)
        if loads is not None and loads.temperature is not None:
            _put(heat.value, loads.temperature)
            heat.reference[loads.temperature.nodes_idx] = np.nan
            at = loads.temperature.nodes_idx
            heat.table[at], of_deck[at], found = k, True, True
    heat.otherwise[of_deck & np.isnan(heat.otherwise)] = 0.0
    return heat if found else None


def _put(into: FloatArray, given: NodeTemperatures | None) -> None:
    if given is not None:
        into[given.nodes_idx] = given.value


def _given(model: Model, driving: Driving, k: int) -> tuple[IntArray, FloatArray]:
    """Nodes of a table and their temperatures."""
    table = driving.statics[k]
    if isinstance(table.temperature, str):
        column = Column("temperature", "of the deck", "a node of the deck", "it without a temperature")
        every = np.arange(model.nodes.count)
        where = driving.places.where("static", k, "temperature")
        values = nodal_values(driving.places.sibling(table.temperature), model, every, column, where)
        return np.array(list(values), dtype=np.int64), np.array(list(values.values()))
    if table.node_set is not None:
        nodes = model.node_set(table.node_set, where=driving.places.where("static", k, "node_set"))
    else:
        nodes = nodes_of_part(model, table.part, driving.places.where("static", k, "part"))
    return nodes, np.full(nodes.size, table.temperature)


def heat_forces(model: Model, heat: Heat) -> FloatArray:
    """(6 n_node,) forces of the heated elements on their nodes, at held drilling rotations on those of the shells."""
    forces = np.zeros((model.nodes.count, PER_NODE))
    drilling = held_drilling(model)
    for block, rise in _heated(model, heat):
        each = block_heat_load(block, model.nodes.coords, rise, form=model.mass_form)
        each = each.reshape(*block.nodes_idx.shape, PER_NODE)
        turns = None if drilling is None else drilling.turns(block, slice(None))
        if turns is not None:
            each[..., 3:] = np.einsum("najb,naj->nab", turns, each[..., 3:])
        np.add.at(forces, block.nodes_idx, each)
    return forces.ravel()


def _heated(model: Model, heat: Heat) -> Iterator[tuple[ElementBlock, FloatArray]]:
    """Blocks that expand, with the rise (n_elem, n_node_per_element) at their nodes."""
    for block in model.blocks:
        if expands(block.kind, block.section):
            # nan where there is a temperature, and none without strain; 0 where there is no temperature.
            own = expansion_of(block.section).reference
            material = heat.otherwise if own is None else np.full(heat.value.size, own)
            rise = heat.value - np.where(np.isnan(heat.reference), material, heat.reference)
            rise = np.where(np.isnan(heat.value), 0.0, rise)[block.nodes_idx]
            if rise.any():
                yield block, rise


def check_heat(model: Model, driving: Driving, superelements: bool) -> list[str]:
    """Notes on what is heated.

    Raises
    ------
    InputError : as `heat_of`; a temperature that strains nothing, without one that it is counted from, or on a material
        whose expansion creak cannot use.
    """
    heat = heat_of(model, driving)
    if heat is None:
        return []
    rises = []
    for block, rise in _heated(model, heat):
        tables = heat.table[block.nodes_idx]
        where = driving.places.where("static", int(tables[np.isnan(rise) if np.isnan(rise).any() else tables >= 0][0]))
        if np.isnan(rise).any():
            raise InputError(
                f"no temperature without strain is known of {_material(block)}",
                where=where,
                expected="reference, or one in the deck (TREF, *INITIAL CONDITIONS, TYPE=TEMPERATURE)",
                fix="Add reference = ... to the table, the temperature at which the parts were made or assembled.",
            )
        flaw = expansion_of(block.section).flaw
        if flaw:
            raise InputError(
                f"creak cannot heat {_material(block)}: {flaw}",
                where=where,
                expected="expansion by constants",
                fix="Give the mean coefficient between both temperatures.",
            )
        rises.append(rise)
    if not rises and all(t.temperature is None for t in driving.statics):
        return [Warned("the temperature of the deck strains nothing: no material that it reaches expands")]
    if not rises:
        raise InputError(
            "the temperature strains nothing: no element that it reaches expands, or none is warmer or colder than "
            "without strain",
            where=driving.places.where("static", max(int(heat.table.max()), 0)),
            expected="materials with expansion (*EXPANSION; A of MAT1, A1 of MAT8 and MAT9)",
            fix="Add it to the materials, or leave the temperature out.",
        )
    least, most = min(float(r.min()) for r in rises), max(float(r.max()) for r in rises)
    notes = [f"heat: elements are {least:g} to {most:g} degrees above the temperature without strain"]
    if max(-least, most) > UNUSUAL:
        notes = [Warned(f"{notes[0]}: are temperature and reference of one unit?")]
    return notes + _cold(model, heat, superelements)


def _cold(model: Model, heat: Heat, superelements: bool) -> list[str]:
    """What is heated and does not expand."""
    warm = ~np.isnan(heat.value)
    notes: list[str] = []
    without = dict.fromkeys(
        _material(b) for b in model.blocks if _solid(b) and expansion_of(b.section) is None and _reached(b, warm)
    )
    if without:
        notes.append(f"without thermal expansion in the deck, and so not expanding: {', '.join(without)}")
    rigid = sum(isinstance(c, KinematicCoupling | RigidLink) and bool(warm[c.nodes].any()) for c in model.constraints)
    rigid += sum(b.own.arms is not None and _reached(b, warm) for b in model.blocks)
    rigid += sum(getattr(b.section, "rigid", False) and _reached(b, warm) for b in model.blocks)
    if rigid:
        notes.append("rigid elements, couplings and offsets of elements do not expand: they keep their length")
    if superelements:
        notes.append(Warned("superelements do not expand in heat: their matrices do not say how they would"))
    return notes


def _solid(block: ElementBlock) -> bool:
    """Whether elements are of a material that could expand."""
    return FORMULATIONS[block.kind].heat_load is not None and not getattr(block.section, "rigid", False)


def _reached(block: ElementBlock, warm: BoolArray) -> bool:
    return bool(warm[block.nodes_idx].any())


def _material(block: ElementBlock) -> str:
    name = getattr(getattr(block.section, "material", None), "name", "")
    return f"material {name}" if name else f"section {block.section.name}"
