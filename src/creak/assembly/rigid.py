"""Does anything hold each part? Rigid-body modes that supports, links and springs leave free, and in words how such a
part can move."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.coupling import Driven
from creak.assembly.drilling import held_drilling
from creak.assembly.elimination import LinearEquation, fixed_equations, linear_equations
from creak.assembly.part import split_constraints
from creak.model.dofs import ALL, dof_label, node_and_dof, node_dofs
from creak.model.faces import FACES, SHELL_FACETS
from creak.model.materials import Discrete, Spring, has_stiffness
from creak.model.mesh import ElementBlock, Model

STRUCTURAL = (*SHELL_FACETS, "beam2", "beam3", *FACES)
FREE = 1e-9
"""A singular value below this share of the largest is a free motion."""


def unheld_parts(model: Model, driven: Driven, stops: Iterable[LinearEquation] = ()) -> list[str]:
    """Names of structural parts that can move as rigid bodies.

    Every part moves as a rigid body, u = c + theta x r; links, supports, driven dofs, springs and stops
    (play connectors) each forbid one combination. What is left free is the null space of that matrix.
    Contact does not hold a part: it may be open.
    """
    structural = [any(b.part == i and b.kind in STRUCTURAL for b in model.blocks) for i in range(len(model.parts))]
    bodies, n_body = _bodies(model)
    coords = model.nodes.coords
    length = max(float(np.ptp(coords, axis=0).max()), 1e-12) if model.nodes.count else 1.0
    places = (coords - coords.mean(axis=0)) / length if model.nodes.count else coords
    rows = [_row(e, bodies, n_body, places, length) for e in _equations(model, driven, stops)]
    if not n_body:
        return []
    E = np.array(rows).reshape(-1, 6 * n_body)
    _, s, Vt = np.linalg.svd(np.linalg.qr(E, mode="r") if E.shape[0] > E.shape[1] else E)
    rank = int(np.count_nonzero(s > FREE * max(s.max(initial=0.0), 1e-300)))
    motion = np.abs(Vt[rank:]).reshape(-1, n_body, 6).max(axis=(0, 2)) if rank < 6 * n_body else np.zeros(n_body)
    return [p.name for i, p in enumerate(model.parts) if structural[i] and motion[i] > 1e-6]


def _bodies(model: Model) -> tuple[dict[int, int], int]:
    """Node row -> body; parts first, then each loose node on its own."""
    bodies: dict[int, int] = {}
    for i, part in enumerate(model.parts):
        bodies.update(dict.fromkeys(part.nodes_idx.tolist(), i))
    n = len(model.parts)
    across = split_constraints(model)[1]
    for constraint in across:
        for equation in linear_equations(constraint, model.nodes.coords):
            for label in equation.labels:
                node = node_and_dof(label)[0]
                if node not in bodies:
                    bodies[node] = n
                    n += 1
    return bodies, n


def _equations(model: Model, driven: Driven, stops: Iterable[LinearEquation]) -> Iterable[LinearEquation]:
    across = [e for c in split_constraints(model)[1] for e in linear_equations(c, model.nodes.coords)]
    yield from _on_bodies(model, [*across, *(e for f in model.fixed for e in fixed_equations(f))])
    for labels in driven.labels.values():
        yield from (LinearEquation([int(x)], [1.0]) for x in labels)
    for block in model.blocks:
        if isinstance(block.section, Spring):
            if block.section.stiffness:
                yield from _spring_equations(block.nodes_idx.tolist(), block.section)
        elif isinstance(block.section, Discrete) and has_stiffness(block.section):
            yield from _resisted_motions(block, model)
    yield from stops


def _on_bodies(model: Model, equations: list[LinearEquation]) -> list[LinearEquation]:
    """The equations; what holds a drilling rotation that shells keep for themselves holds no part by it."""
    drilling = held_drilling(model)
    if drilling is None:
        return equations
    others = np.concatenate(
        [drilling.nodes[:0], *(b.nodes_idx.ravel() for b in model.blocks if b.kind not in SHELL_FACETS)]
    )
    labels = node_dofs(drilling.nodes)
    shells = set(node_dofs(np.setdiff1d(drilling.nodes, others)).tolist())
    mine = [shells.issuperset(e.labels) for e in equations]
    out = [e for e, own in zip(equations, mine, strict=True) if not own]
    return out + drilling.on_shells([e for e, own in zip(equations, mine, strict=True) if own], labels)


def _spring_equations(nodes: list[list[int]], spring: Spring) -> Iterable[LinearEquation]:
    for row in nodes:
        labels = [dof_label(row[0], spring.dof1)]
        if len(row) > 1:
            labels.append(dof_label(row[1], spring.dof2 or spring.dof1))
        yield LinearEquation(labels, [1.0, -1.0][: len(labels)])


def _resisted_motions(block: ElementBlock, model: Model) -> Iterable[LinearEquation]:
    """The motions that each element of bushings and the like resists: eigenvectors of its stiffness."""
    from creak.elements.block_matrices import block_matrices  # see `assembly.part`

    K = block_matrices(block, slice(None), model.nodes.coords)[0]
    values, vectors = np.linalg.eigh(K)
    dofs = node_dofs(block.nodes_idx.ravel()).reshape(len(K), -1)
    for row, k in np.argwhere(values > FREE * values[:, -1:]).tolist():
        yield LinearEquation(dofs[row].tolist(), vectors[row, :, k].tolist())


def _row(e: LinearEquation, bodies: dict[int, int], n_body: int, places: FloatArray, length: float) -> FloatArray:
    """Coefficients of one equation on the rigid motions; `places`: nodes about the middle of all, in `length`."""
    row = np.zeros((n_body, 6))
    for label, c in zip(e.labels, e.coefficients, strict=True):
        node, dof = node_and_dof(label)
        axis = dof - 1
        if node not in bodies:
            continue
        body, r = bodies[node], places[node]
        if axis >= 3:
            row[body, axis] += c / length
        else:
            j, k = (axis + 1) % 3, (axis + 2) % 3
            row[body, axis] += c
            row[body, 3 + j] += c * r[k]
            row[body, 3 + k] -= c * r[j]
    size = np.linalg.norm(row)
    return row.ravel() / size if size else row.ravel()


AXES = ("x", "y", "z")
NAMED = 3
"""Parts whose motions are looked at one by one; the others are only named."""


def free_motions(model: Model, driven: Driven, name: str, stops: Sequence[LinearEquation] = ()) -> list[str]:
    """`along x`, ..., `about z`: the rigid motions of part `name` that nothing resists.

    A translation is free where the part still moves with its other five motions blocked at one of its nodes; a
    rotation where it still moves with the other two, and the free translations, blocked. A motion that is a mixture
    of all, like a screw, shows as none of them.

    Parameters
    ----------
    stops : what holds parts besides supports, links and springs, see `unheld_parts`.
    """
    node = int(next(p for p in model.parts if p.name == name).nodes_idx[0])
    held = [LinearEquation([dof_label(node, dof)], [1.0]) for dof in ALL]

    def moves(blocked: set[int]) -> bool:
        return name in unheld_parts(model, driven, [*stops, *(held[dof] for dof in sorted(blocked))])

    along = {dof for dof in range(3) if moves(set(range(6)) - {dof})}
    about = [dof for dof in range(3, 6) if moves(({3, 4, 5} - {dof}) | along)]
    return [*(f"along {AXES[dof]}" for dof in sorted(along)), *(f"about {AXES[dof - 3]}" for dof in about)]


def loose_motions(
    model: Model, driven: Driven, loose: Sequence[str], stops: Sequence[LinearEquation] = ()
) -> dict[str, list[str]]:
    """Part that nothing holds -> its `free_motions`; empty beyond the first `NAMED` parts."""
    return {name: free_motions(model, driven, name, stops) if k < NAMED else [] for k, name in enumerate(loose)}


def loose_words(motions: Mapping[str, Sequence[str]]) -> str:
    """`UPPER (along z), LOWER (along x, about y)`: parts and how they can move."""
    return ", ".join(f"{name} ({', '.join(words)})" if words else name for name, words in motions.items())
