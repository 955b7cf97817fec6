"""Model -> Nastran deck: what `write/` makes of it, and cards of constraints, supports, initial velocities and added
matrices."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from creak.arrays import IntArray, Matrix
from creak.errors import InputError
from creak.formats.deck.refusals import unwritable
from creak.formats.nastran.reader import read_nastran
from creak.formats.nastran.write.elements import Systems, element_lines, is_matrix
from creak.formats.nastran.write.equivalent import equivalent
from creak.formats.nastran.write.fields import Field, card
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
from creak.model.constraints import DistributingCoupling, Equation, KinematicCoupling, RigidLink
from creak.model.dofs import PER_NODE, node_and_dof, node_dofs
from creak.model.materials import BeamSection, GeneralShell, NodalMatrices
from creak.model.mesh import ElementBlock, Model

SET = 1
"""Of SPC, MPC and TIC cards."""
MATRICES = {"K2GG": "KADDED", "M2GG": "MADDED", "B2GG": "BADDED"}


def constraint_lines(model: Model) -> Iterator[str]:
    """RBE2, RBE3, RBAR and MPC.

    Raises
    ------
    InputError : a coupling that the cards do not say as creak reads them.
    """
    after = max([0, *(int(b.ids.max()) for b in model.blocks if b.ids.size), *map(_number, model.constraints)])
    ids = model.nodes.ids
    for c in model.constraints:
        if isinstance(c, KinematicCoupling):
            yield from card("RBE2", [_number(c), int(ids[c.ref_idx]), _digits(c.dofs), *ids[c.nodes_idx].tolist()])
        elif isinstance(c, DistributingCoupling):
            yield from _rbe3(model, c)
        elif isinstance(c, RigidLink):
            after += 1
            ends = [int(ids[c.independent_idx]), int(ids[c.dependent_idx])]
            yield from card("RBAR", [after, *ends, "123456", None, None, "123456"])
        elif isinstance(c, Equation):
            yield from _mpc(model, c)


def _number(c: object) -> int:
    """Id of a coupling named after its card."""
    return int(c.name.split()[1]) if isinstance(c, KinematicCoupling | DistributingCoupling) else 0


def _digits(dofs: tuple[int, ...]) -> str:
    return "".join(map(str, sorted(dofs)))


def _rbe3(model: Model, c: DistributingCoupling) -> Iterator[str]:
    """Nodes of one weight that follow each other share it."""
    if not (c.weights > 0.0).all():
        raise unwritable(f"coupling {c.name!r}", "weights of RBE3 are positive")
    if len({1, 2, 3} & set(c.dofs)) not in (0, 3) or len({4, 5, 6} & set(c.dofs)) not in (0, 3):
        raise unwritable(f"coupling {c.name!r} ({c.where})", "only some of its translations or rotations are coupled")
    fields: list[Field] = [_number(c), None, int(model.nodes.ids[c.ref_idx]), _digits(c.dofs)]
    before = 0.0
    for node, weight in zip(model.nodes.ids[c.nodes_idx].tolist(), c.weights.tolist(), strict=True):
        if weight != before:
            fields += [float(weight), "123"]
        fields.append(node)
        before = weight
    yield from card("RBE3", fields)


def _mpc(model: Model, c: Equation) -> Iterator[str]:
    """G, C, A twice to a line of eight, after a blank."""
    fields: list[Field] = [SET]
    nodes = model.nodes.ids[c.nodes_idx].tolist()
    for k, (node, dof, a) in enumerate(zip(nodes, c.dofs.tolist(), c.coefficients.tolist(), strict=True)):
        if k and k % 2 == 0:
            fields += [None, None]
        fields += [node, dof, float(a)]
    yield from card("MPC", fields)


def support_lines(model: Model) -> Iterator[str]:
    """SPC1 and TIC."""
    ids = model.nodes.ids
    for f in model.fixed:
        for k in range(0, f.nodes_idx.size, 1000):
            yield from card("SPC1", [SET, _digits(f.dofs), *ids[f.nodes_idx[k : k + 1000]].tolist()])
    for node, dof, velocity in model.initial_velocity:
        yield from card("TIC", [SET, int(ids[node]), dof, 0.0, float(velocity)])


def added_matrices(model: Model, beta: float) -> dict[str, Matrix]:
    """K2GG, M2GG, B2GG (6 n, 6 n) of the elements that are given by matrices, those that are not zero.

    `beta` (s) is that of the whole deck, which acts on K2GG too: B2GG holds what an element's own differs by.
    """
    n = PER_NODE * model.nodes.count
    total: dict[str, Matrix] = {name: sp.csr_array((n, n)) for name in MATRICES}
    for block in model.blocks:
        if is_matrix(block) and isinstance(block.section, NodalMatrices):
            for rows in block.nodes_idx:
                dofs = node_dofs(rows)
                i, j = np.repeat(dofs, dofs.size), np.tile(dofs, dofs.size)
                K, C = block.section.stiffness, block.section.damping
                of_block = (K, block.section.mass, C + (block.section.beta - beta) * K)
                for name, matrix in zip(MATRICES, of_block, strict=True):
                    total[name] = total[name] + sp.csr_array((matrix.ravel(), (i, j)), shape=(n, n))
    for matrix in total.values():
        matrix.eliminate_zeros()
    return {name: matrix for name, matrix in total.items() if matrix.nnz}


def matrix_lines(model: Model, matrices: dict[str, Matrix]) -> Iterator[str]:
    """DMIG of the lower triangles, a card to a column."""
    for command, matrix in matrices.items():
        name = MATRICES[command]
        yield from card("DMIG", [name, 0, 6, 2, 0])
        lower = sp.csc_array(sp.tril(matrix))
        lower.sort_indices()
        for j in np.flatnonzero(np.diff(lower.indptr)).tolist():
            node, dof = node_and_dof(j)
            fields: list[Field] = [name, int(model.nodes.ids[node]), dof, None]
            span = slice(lower.indptr[j], lower.indptr[j + 1])
            for i, value in zip(lower.indices[span].tolist(), lower.data[span].tolist(), strict=True):
                node, dof = node_and_dof(i)
                fields += [int(model.nodes.ids[node]), dof, float(value), None]
            yield from card("DMIG", fields)


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
