"""Model -> Nastran deck."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from creak.arrays import IntArray
from creak.errors import InputError
from creak.formats.nastran.reader import read_nastran
from creak.formats.nastran.write.conditions import (
    MATRICES,
    SET,
    added_matrices,
    constraint_lines,
    matrix_lines,
    support_lines,
)
from creak.formats.nastran.write.elements import Systems, element_lines, is_matrix
from creak.formats.nastran.write.equivalent import equivalent
from creak.formats.nastran.write.fields import card
from creak.formats.nastran.write.materials import Materials, damping_of
from creak.formats.nastran.write.properties import Properties
from creak.formats.nastran.write.sets import (
    labels,
    set_lines,
    with_plain_names,
    with_surface_sets,
    without_matrix_elements,
)
from creak.formats.written_deck import write_checked
from creak.model.comparison import difference
from creak.model.constraints import Equation
from creak.model.materials import BeamSection, GeneralShell
from creak.model.mesh import ElementBlock, Model

KEPT = 1e-12
"""Share of the largest number of an array that writing and reading may change: quotients such as A/T are rounded."""
MASS = {"lumped": -1, "linear": 1}
"""Mass form -> PARAM,COUPMASS."""
LARGEST = 99_999_999
"""Label of Nastran."""


def write_nastran(model: Model, path: str | Path) -> tuple[str, ...]:
    """Write the model data as a Nastran deck, and read it back: the file appears only if nothing is lost.

    Grids in the basic frame, all constraints of one kind by RBE2, RBE3, RBAR or MPC (see `equivalent`), springs along
    turned axes as DMIG (K2GG, B2GG, M2GG). Reals have all their digits (see `card`). Parts are found anew from what is
    connected; names of sets stand in comments. SOL 103 with 20 modes; SOL 109 without times where there are initial
    velocities.

    Returns
    -------
    What has another name in the deck, which element sets lose elements that become matrices, and what is lost because
    it bears on contact only.

    Raises
    ------
    InputError : the model holds what creak does not read from Nastran decks (consistent mass, beams whose shear centre
        is beside the centroid, coupled bushings, materials and masses with different mass-proportional damping);
        nothing is written.
    """
    if model.mass_form not in MASS:
        raise InputError(
            f"the mass of this deck is {model.mass_form}; Nastran has lumped and linear (PARAM,COUPMASS,1) mass",
            where=model.source,
            fix="Take one of them: --mass linear or --mass lumped (the answer changes with it).",
        )
    plain, notes = numbered(model)
    plain, renamed = with_plain_names(plain)
    plain, lost = without_matrix_elements(equivalent(plain))
    plain, surfaces = with_surface_sets(plain)
    text = "\n".join(deck_lines(plain, notes)) + "\n"
    write_checked(
        path, text, lambda copy: _difference(plain, read_nastran(copy)), kind="a Nastran", source=model.source
    )
    return (*notes, *renamed, *lost, *surfaces, *dict.fromkeys(_lost(plain)))


def deck_lines(model: Model, notes: list[str]) -> Iterator[str]:
    """Lines of the deck of an `equivalent` model."""
    damping = damping_of(model)
    materials = Materials(damping)
    properties, systems, matrices = Properties(model, materials), Systems(), added_matrices(model, damping.beta)
    elements = list(element_lines(model, properties, systems))
    yield f"$ written by creak from {Path(model.source).name}"
    yield from (f"$ {note}" for note in notes)
    yield from ["SOL 109" if model.initial_velocity else "SOL 103", "CEND"]
    yield from _case(model, list(matrices))
    yield "BEGIN BULK"
    if not model.initial_velocity:
        yield from card("EIGRL", [SET, None, None, 20])
    yield from card("PARAM", ["COUPMASS", MASS[model.mass_form]])
    yield from damping.lines()
    yield from set_lines(model, properties)
    for identifier, place in zip(model.nodes.ids.tolist(), model.nodes.coords.tolist(), strict=True):
        yield from card("GRID", [identifier, 0, *place])
    yield from elements
    yield from (line for lines in properties.cards.values() for line in lines)
    yield from materials.lines()
    yield from systems.lines()
    yield from constraint_lines(model)
    yield from support_lines(model)
    yield from matrix_lines(model, matrices)
    yield "ENDDATA"


def _case(model: Model, matrices: list[str]) -> Iterator[str]:
    if not model.initial_velocity:
        yield f"METHOD = {SET}"
    if model.fixed:
        yield f"SPC = {SET}"
    if any(isinstance(c, Equation) for c in model.constraints):
        yield f"MPC = {SET}"
    if model.initial_velocity:
        yield f"IC = {SET}"
    yield from (f"{command} = {MATRICES[command]}" for command in matrices)


def _lost(model: Model) -> Iterator[str]:
    """What only contact needs."""
    for section in {id(b.section): b.section for b in model.blocks}.values():
        if isinstance(section, BeamSection) and section.radius:
            yield f"beam section {section.name}: its surface, {section.radius:g} from the axis, is not in the deck"


def _difference(model: Model, copy: Model) -> str:
    bare = [replace(m, blocks=tuple(_bare(b) for b in m.blocks if not is_matrix(b))) for m in (model, copy)]
    found = difference(bare[0], bare[1], names=False, tolerance=KEPT, by_element=True)
    if found:
        return found
    beta = damping_of(model).beta
    one, other = (added_matrices(m, beta) for m in (model, copy))
    if one.keys() != other.keys() or any(abs(one[k] - other[k]).max() > KEPT * abs(one[k]).max() for k in one):
        return "the matrices on nodes"
    for name, rows in model.element_sets.items():
        if name not in copy.element_sets:
            return f"element set {name!r} is missing"
        if set(labels(model, rows).tolist()) != set(labels(copy, copy.element_sets[name]).tolist()):
            return f"element set {name!r}"
    return ""


def _bare(block: ElementBlock) -> ElementBlock:
    """Without what only contact needs, and without coupling of shells that is rounding."""
    s = block.section
    if isinstance(s, BeamSection):
        return replace(block, section=replace(s, radius=0.0, axis1=(0.0, 0.0, 1.0)))
    if isinstance(s, GeneralShell):
        moment = 0.0 if abs(s.first_moment) <= KEPT * s.mass * s.thickness else s.first_moment
        small = np.abs(s.B).max() <= KEPT * np.abs(s.A).max() * s.thickness
        return replace(block, section=replace(s, first_moment=moment, B=0.0 * s.B if small else s.B))
    return block


def numbered(model: Model) -> tuple[Model, list[str]]:
    """The model with labels of its own for every node and element, and what was renumbered in words.

    Labels of a flat deck stay. Where instances use a label twice, those of each instance get a number in front: label +
    k 10^d, d the digits of the largest label.

    Raises
    ------
    InputError : a label that is not 1 to 99999999.
    """
    nodes, notes = model.nodes, list[str]()
    ids = nodes.ids
    if np.unique(ids).size < ids.size:
        step = 10 ** len(str(int(ids.max())))
        ids = ids + step * (nodes.instance_idx + 1)
        for k, name in enumerate(nodes.instance):
            notes.append(f"node n of instance {name} is grid {step * (k + 1)} + n")
    blocks, more = _elements(model)
    _check_labels(model, "node", ids)
    for block in blocks:
        _check_labels(model, "element", block)
    made = tuple(replace(b, ids=new) for b, new in zip(model.blocks, blocks, strict=True))
    flat = replace(nodes, ids=ids, instance=(), instance_idx=np.zeros(0, dtype=np.int64))
    return replace(model, nodes=flat, blocks=made), notes + more


def _elements(model: Model) -> tuple[list[IntArray], list[str]]:
    ids = [b.ids for b in model.blocks]
    every = np.concatenate([*ids, np.zeros(0, dtype=np.int64)])
    if np.unique(every).size == every.size:
        return ids, []
    step, nodes = 10 ** len(str(int(every.max()))), model.nodes
    owner = [nodes.instance_idx[b.nodes_idx].max(axis=1) if nodes.instance else b.ids * 0 - 1 for b in model.blocks]
    made = [i + step * (o + 1) for i, o in zip(ids, owner, strict=True)]
    whole = np.concatenate(made)
    if np.unique(whole).size < whole.size:
        counts = np.cumsum([0, *(i.size for i in ids)])
        anew = [np.arange(a + 1, b + 1) for a, b in pairwise(counts.tolist())]
        return anew, ["elements are numbered anew, in the order of the deck"]
    names = enumerate(nodes.instance, start=1)
    return made, [f"element n of instance {name} is element {step * k} + n" for k, name in names]


def _check_labels(model: Model, what: str, ids: IntArray) -> None:
    if ids.size and not 1 <= int(ids.min()) <= int(ids.max()) <= LARGEST:
        bad = int(ids.min()) if ids.min() < 1 else int(ids.max())
        raise InputError(
            f"{what} {bad} cannot stand in a Nastran deck",
            where=model.source,
            expected=f"labels from 1 to {LARGEST}",
            fix="Renumber the deck.",
        )
