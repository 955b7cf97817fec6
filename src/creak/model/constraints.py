"""Linear constraints between degrees of freedom; dof numbers are 1..6 as in the deck.

Each knows `nodes`, the rows of all nodes that it touches; `dependents`, the rows of those whose motion follows from the
others; and `equations(coords)`, what it says as `Equation`s, with coords (n_node, 3), the first term the dependent one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.errors import InputError
from creak.given import check_fields, one_of, whole
from creak.model.dofs import ALL, TRANSLATIONS, dof_labels, dofs_of, node_dofs, nodes_of


def rigid_at(r: FloatArray) -> FloatArray:
    """S_k = [I, -(r_k x)] (k, 3, 6): translations at arms r (k, 3) of a rigid motion (u, theta)."""
    S = np.zeros((len(r), 3, 6))
    S[:, :, :3] = np.eye(3)
    S[:, 0, 4], S[:, 0, 5] = r[:, 2], -r[:, 1]
    S[:, 1, 3], S[:, 1, 5] = -r[:, 2], r[:, 0]
    S[:, 2, 3], S[:, 2, 4] = r[:, 1], -r[:, 0]
    return S


@dataclass(frozen=True)
class Equation:
    """sum_k coefficient_k u(node_k, dof_k) = 0; the first term is eliminated."""

    nodes_idx: IntArray
    dofs: IntArray
    coefficients: FloatArray
    where: str = ""

    @property
    def nodes(self) -> IntArray:
        return self.nodes_idx

    @property
    def dependents(self) -> IntArray:
        return self.nodes_idx[:1]

    def equations(self, coords: FloatArray) -> Iterator[Equation]:
        yield self


@dataclass(frozen=True)
class KinematicCoupling:
    """The coupled nodes follow the reference node as a rigid body in the listed dofs."""

    name: str
    ref_idx: int
    nodes_idx: IntArray
    dofs: tuple[int, ...]
    where: str = ""

    @property
    def nodes(self) -> IntArray:
        return _with(self.ref_idx, self.nodes_idx)

    @property
    def dependents(self) -> IntArray:
        return self.nodes_idx

    def equations(self, coords: FloatArray) -> Iterator[Equation]:
        for node in self.nodes_idx.tolist():
            yield from _follow(node, [self.ref_idx], [1.0], coords[node] - coords[self.ref_idx], self.dofs, self.where)


@dataclass(frozen=True)
class DistributingCoupling:
    """The reference node follows the weighted mean motion of the coupled nodes (RBE3)."""

    name: str
    ref_idx: int
    nodes_idx: IntArray
    weights: FloatArray
    dofs: tuple[int, ...] = ALL
    where: str = ""
    turns_on_line: bool = False
    """Whether nodes on a line leave the reference node free to turn about it, as in Abaqus; else they are refused."""

    @property
    def nodes(self) -> IntArray:
        return _with(self.ref_idx, self.nodes_idx)

    @property
    def dependents(self) -> IntArray:
        return np.array([self.ref_idx])

    def equations(self, coords: FloatArray) -> Iterator[Equation]:
        """Weighted least-squares rigid motion of the cloud, moved to the reference node.

        With S_k = [I, -(r_k x)] and A = sum w_k S_k' S_k: (u, theta)_ref = A^-1 sum w_k S_k' u_k. Of nodes on a line
        A has a null vector n, the turn about it: the same less n/n_j times row j, whose turn is free (|n_j| largest).

        Raises
        ------
        InputError : the nodes lie on a line (unless `turns_on_line`) or in a point.
        """
        r = coords[self.nodes_idx] - coords[self.ref_idx]
        S = rigid_at(r)
        weighted = S * self.weights[:, None, None]
        A = np.einsum("kia,kib->ab", weighted, S)
        length = float(np.sqrt((r**2).sum(axis=1).mean())) or 1.0
        scale = np.array([1.0, 1.0, 1.0, length, length, length])
        values, vectors = np.linalg.eigh(A / np.outer(scale, scale))
        held = values > 1e-12 * values[-1]
        if np.count_nonzero(held) < (5 if self.turns_on_line else 6):
            raise InputError(
                f"distributing coupling {self.name!r} has its {self.nodes_idx.size} node(s) on a line or in a point",
                where=self.where,
                expected="at least three nodes that span an area",
                fix="Couple more nodes, or use a kinematic coupling.",
            )
        basis = vectors[:, held] / scale[:, None]
        weights = (basis / values[held]) @ (basis.T @ weighted.transpose(2, 0, 1).reshape(6, -1))
        nodes = _with(self.ref_idx, np.repeat(self.nodes_idx, 3))
        others = np.tile(TRANSLATIONS, self.nodes_idx.size).tolist()
        if held.all():
            for dof in self.dofs:
                yield Equation(nodes, np.array([dof, *others]), np.array([1.0, *-weights[dof - 1]]), self.where)
            return
        turn = vectors[:, 0] / scale
        free = 3 + int(np.abs(turn[3:]).argmax())
        share = turn / turn[free]
        nodes = _with(self.ref_idx, nodes)
        for dof in (d for d in self.dofs if d != free + 1):
            follow = weights[dof - 1] - share[dof - 1] * weights[free]
            factors = np.array([1.0, -share[dof - 1], *-follow])
            yield Equation(nodes, np.array([dof, free + 1, *others]), factors, self.where)


def on_a_line(coords: FloatArray) -> bool:
    """Whether points (n, 3) lie on a line or in a point, to 1e-6 of their extent."""
    size = np.linalg.svd(coords - coords.mean(axis=0), compute_uv=False)
    return bool(size.size < 2 or size[1] <= 1e-6 * size[0])


@dataclass(frozen=True)
class RigidLink:
    """Two-node link. `beam`: dependent follows as a rigid body; `tie`: all six dofs equal;
    `pin`: the three translations equal."""

    kind: str
    dependent_idx: int
    independent_idx: int
    where: str = ""

    def __post_init__(self) -> None:
        one_of(self.kind, ("beam", "tie", "pin"), "RigidLink: kind")
        check_fields(self, dict.fromkeys(("dependent_idx", "independent_idx"), partial(whole, least=0)))

    @property
    def nodes(self) -> IntArray:
        return np.array([self.dependent_idx, self.independent_idx])

    @property
    def dependents(self) -> IntArray:
        return np.array([self.dependent_idx])

    def equations(self, coords: FloatArray) -> Iterator[Equation]:
        if self.kind == "beam":
            arm = coords[self.dependent_idx] - coords[self.independent_idx]
            yield from _follow(self.dependent_idx, [self.independent_idx], [1.0], arm, ALL, self.where)
            return
        for dof in TRANSLATIONS if self.kind == "pin" else ALL:
            yield Equation(self.nodes, np.array([dof, dof]), np.array([1.0, -1.0]), self.where)


@dataclass(frozen=True)
class Tie:
    """A node joined to a point of a facet (or edge) between other nodes: u = sum_k w_k (u_k + theta_k x arm)."""

    name: str
    node_idx: int
    """The secondary node; its dofs are eliminated."""
    nodes_idx: IntArray
    """(k,) main nodes."""
    weights: FloatArray
    """(k,) shape functions of the face at the point; they sum to one."""
    arm: FloatArray
    """(3,) from the point to the secondary node."""
    rotations: bool = True
    """Whether theta = sum_k w_k theta_k as well."""
    where: str = ""

    @property
    def nodes(self) -> IntArray:
        return _with(self.node_idx, self.nodes_idx)

    @property
    def dependents(self) -> IntArray:
        return np.array([self.node_idx])

    def equations(self, coords: FloatArray) -> Iterator[Equation]:
        dofs = ALL if self.rotations else TRANSLATIONS
        yield from _follow(self.node_idx, self.nodes_idx.tolist(), self.weights.tolist(), self.arm, dofs, self.where)


Constraint = KinematicCoupling | DistributingCoupling | RigidLink | Equation | Tie


@dataclass(frozen=True)
class Fixed:
    """Dofs held at zero."""

    nodes_idx: IntArray
    dofs: tuple[int, ...]
    where: str = ""


def held_labels(fixed: Sequence[Fixed]) -> IntArray:
    """Dof labels that supports hold, as they come."""
    return np.concatenate([np.zeros(0, dtype=np.int64), *(node_dofs(f.nodes_idx, f.dofs) for f in fixed)])


def held_nodes(fixed: Sequence[Fixed]) -> IntArray:
    """Rows of the nodes that supports hold in all translations."""
    labels = np.unique(held_labels(fixed))
    rows, count = np.unique(nodes_of(labels[dofs_of(labels) <= 3]), return_counts=True)
    return rows[count == 3]


def supported_nodes(constraints: Sequence[Constraint], fixed: Sequence[Fixed]) -> IntArray:
    """Rows of the nodes that supports hold in any direction, along global axes or others."""
    oblique = [c.nodes_idx for c in oblique_supports(constraints, fixed)]
    return np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *(f.nodes_idx for f in fixed), *oblique]))


def oblique_supports(constraints: Sequence[Constraint], fixed: Sequence[Fixed]) -> Iterator[Equation]:
    """Equations that hold one node alone, along no global axis; what is fixed has no term in them."""
    held = np.unique(held_labels(fixed))
    for c in constraints:
        if isinstance(c, Equation):
            free = ~np.isin(dof_labels(c.nodes_idx, c.dofs), held)
            if free.any() and (c.nodes_idx[free] == c.nodes_idx[free][0]).all():
                yield Equation(c.nodes_idx[free], c.dofs[free], c.coefficients[free], c.where)


def linked_nodes(constraints: Sequence[Constraint], fixed: Sequence[Fixed]) -> IntArray:
    """Rows of the nodes that constraints join to others that are not fixed."""
    held = np.unique(held_labels(fixed))
    found = [np.zeros(0, dtype=np.int64)]
    for c in constraints:
        nodes = c.nodes
        if isinstance(c, Equation):
            nodes = nodes[~np.isin(dof_labels(nodes, c.dofs), held)]
        if np.unique(nodes).size > 1:
            found.append(nodes)
    return np.unique(np.concatenate(found))


def tied_nodes(constraints: Sequence[Constraint], count: int) -> BoolArray:
    """(count,) nodes that any link, coupling, tie or equation names."""
    tied = np.zeros(count, dtype=bool)
    for c in constraints:
        tied[c.nodes] = True
    return tied


def without(fixed: Sequence[Fixed], freed: IntArray) -> tuple[Fixed, ...]:
    """What is left of supports without the dof labels `freed`: nodes that keep the same dofs together."""
    out: list[Fixed] = []
    for f in fixed:
        left: dict[tuple[int, ...], list[int]] = {}
        gone = np.isin(node_dofs(f.nodes_idx, f.dofs), freed).reshape(-1, len(f.dofs))
        for node, row in zip(f.nodes_idx.tolist(), gone.tolist(), strict=True):
            left.setdefault(tuple(d for d, away in zip(f.dofs, row, strict=True) if not away), []).append(node)
        pieces = [Fixed(np.array(nodes, dtype=np.int64), dofs, f.where) for dofs, nodes in left.items() if dofs]
        out += pieces if gone.any() else [f]
    return tuple(out)


def _with(node: int, nodes_idx: IntArray) -> IntArray:
    return np.concatenate([[node], nodes_idx]).astype(np.int64)


def _follow(
    node: int, main: Sequence[int], weights: Sequence[float], arm: FloatArray, dofs: Sequence[int], where: str
) -> Iterator[Equation]:
    """u_node = sum_k w_k (u_k + theta_k x arm), theta_node = sum_k w_k theta_k."""
    for dof in dofs:
        nodes, numbers, c = [node], [dof], [1.0]
        j, k = dof % 3, (dof + 1) % 3
        levers = [(axis, v) for axis, v in ((j, -arm[k]), (k, arm[j])) if v != 0.0] if dof <= 3 else []
        for other, w in zip(main, weights, strict=True):
            nodes += [other] * (1 + len(levers))
            numbers += [dof, *(4 + axis for axis, _ in levers)]
            c += [-w, *(float(w * lever) for _, lever in levers)]
        yield Equation(np.array(nodes), np.array(numbers), np.array(c), where)
