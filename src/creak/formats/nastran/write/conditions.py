"""Constraints, supports, initial velocities and added matrices -> cards."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy.sparse as sp

from creak.arrays import Matrix
from creak.formats.deck.refusals import unwritable
from creak.formats.nastran.write.elements import is_matrix
from creak.formats.nastran.write.fields import Field, card
from creak.model.constraints import DistributingCoupling, Equation, KinematicCoupling, RigidLink
from creak.model.dofs import PER_NODE, node_and_dof, node_dofs
from creak.model.materials import NodalMatrices
from creak.model.mesh import Model

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
