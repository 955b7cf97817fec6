"""Held rotations about the normal of shells: the support holds the node, and the shells keep a rotation of their own.

A flat shell has no stiffness against a turn of its nodes about the normal. The drilling rotations of creak's shells are
an aid of their membranes, so a support that holds the node's rotation about the normal must not hold them. A node has
a normal n where its shells lie within `SMOOTH` of each other. Supports hold the directions H of its rotation; of these,
a is the one nearest to n. Where a lies within `SMOOTH` of n, the three rotations s of the node are those of the
shells, and everything else there turns by

    theta = P s,   P = I - n a' / (a . n),   a . P = 0:

beams, springs, masses, couplings, loads and results meet what the supports hold, and the rotation n . s is left to the
shells. Where supports hold both ends of a shell's side across it, in its plane, the edge cannot turn, and a hold of the
drilling rotation says the same: it stays. So does that of the one node by which a structure is held in the plane, or
it would turn about that node. Along a fold the rotation about one shell's normal bends the other. There a
shell keeps a rotation of its own only where supports hold the node about just that normal (to 0.1 degree); the others
at the fold turn by P s.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from creak.arrays import BoolArray, FloatArray, IntArray, Matrix
from creak.assembly.elimination import LinearEquation, through
from creak.assembly.partition import shared_nodes
from creak.elements.free_sides import SHELLS, ending_sides, twisting_sides, with_free_sides
from creak.model.constraints import KinematicCoupling, RigidLink, linked_nodes, oblique_supports
from creak.model.dofs import PER_NODE, ROTATIONS, TRANSLATIONS, dof_label, nodes_of
from creak.model.faces import EXACT, EXACTLY, SHELL_FACETS, SMOOTH, facets_of_shells, normals_at_nodes, unit
from creak.model.materials import Discrete, GeneralShell
from creak.model.mesh import ElementBlock, Model

ROUND_OFF = 1e-12


@dataclass(frozen=True)
class HeldDrilling:
    """Nodes whose shells keep drilling rotations of their own."""

    nodes: IntArray
    """(k,) rows, sorted."""
    real: FloatArray
    """(k, 3, 3) P of the module: rotation of the node from the three rotations that the matrices have there."""
    normals: FloatArray
    """(k, 3, 3) rows n of the shells that have a rotation of their own, zero where there are fewer than three."""
    own: FloatArray
    """(k, 3, 3) rows c: their rotation is c . s."""
    fold: BoolArray
    """(k,) whether other shells meet there."""
    coords: FloatArray
    """(n_node, 3) of the model."""

    def real_rows(self, labels: IntArray) -> Matrix:
        """Z (n, n), u = Z s for all dofs of some nodes; s are what shells have there."""
        of = nodes_of(labels[::PER_NODE])
        there = np.isin(self.nodes, of)
        at = (PER_NODE * np.searchsorted(of, self.nodes[there]) + 3)[:, None] + np.arange(3)
        own = np.ones(labels.size)
        own[at] = 0.0
        rows, columns = np.broadcast_arrays(at[:, :, None], at[:, None])
        turned = sp.csr_matrix((self.real[there].ravel(), (rows.ravel(), columns.ravel())), shape=2 * (labels.size,))
        Z = sp.csr_matrix(sp.diags(own) + turned)
        Z.eliminate_zeros()
        return Z

    def turns(self, block: ElementBlock, rows: slice | IntArray) -> FloatArray | None:
        """(n, k, 3, 3): rotations of the elements' nodes from s; None where all are s."""
        nodes = block.nodes_idx[rows]
        at, there = _found(self.nodes, nodes)
        is_shell = _strains(block)
        shared = there & self.fold[at] if is_shell else there
        if not shared.any():
            return None
        out = np.tile(np.eye(3), (*nodes.shape, 1, 1))
        out[shared] = self.real[at[shared]]
        if is_shell:
            mine = normals_at_nodes(block.kind, nodes, self.coords)[shared]
            near = np.abs(np.einsum("egc,ec->eg", self.normals[at[shared]], mine))
            best = near.argmax(axis=1)
            every = np.arange(best.size)
            n, c = self.normals[at[shared]][every, best], self.own[at[shared]][every, best]
            flat = np.eye(3) - n[:, :, None] * n[:, None]
            turned = flat @ out[shared] + n[:, :, None] * c[:, None]
            out[shared] = np.where((near[every, best] >= SMOOTH)[:, None, None], turned, out[shared])
        return out

    def on_shells(self, equations: list[LinearEquation], labels: IntArray) -> list[LinearEquation]:
        """Equations between dofs of nodes as equations between what the matrices have there."""
        if not equations:
            return []
        Z, place = self.real_rows(labels), {int(x): i for i, x in enumerate(labels)}
        out = []
        for e in equations:
            columns, values = through(e, Z, place)
            if columns:
                out.append(LinearEquation(labels[columns].tolist(), values, e.where))
        return out


def turned(matrix: FloatArray, turns: FloatArray) -> FloatArray:
    """T' A T of matrices (n, 6 k, 6 k), T the turns (n, k, 3, 3) of the rotations."""
    n, k = turns.shape[:2]
    A = matrix.reshape(n, k, 6, k, 6).copy()
    A[:, :, :, :, 3:] = np.einsum("naibj,nbjl->naibl", A[:, :, :, :, 3:], turns)
    A[:, :, 3:] = np.einsum("najbl,naji->naibl", A[:, :, 3:], turns)
    return A.reshape(matrix.shape)


def held_drilling(model: Model, nodes: IntArray | None = None) -> HeldDrilling | None:
    """The nodes (among `nodes`) where supports hold rotations about normals of shells; None: there are none."""
    at, held = held_directions(model, ROTATIONS)
    if nodes is not None:
        mine = np.isin(at, nodes)
        at, held = at[mine], held[mine]
    found = _surfaces(model, at)
    if not found:
        return None
    single = ~found[1][3] if len(found) > 1 else np.ones(at.size, dtype=bool)
    n, free, _, _ = found[0]
    a = np.einsum("kij,kj->ki", held, n)
    size = np.linalg.norm(a, axis=1)
    real, normals, own = np.tile(np.eye(3), (at.size, 1, 1)), np.zeros((at.size, 3, 3)), np.zeros((at.size, 3, 3))
    plain = np.flatnonzero(single & free & (size >= SMOOTH))
    a = a[plain] / size[plain, None]
    n = np.where((size[plain] >= EXACTLY)[:, None], a, n[plain])
    real[plain] -= n[:, :, None] * a[:, None] / np.einsum("ki,ki->k", a, n)[:, None, None]
    normals[plain, 0], own[plain, 0] = n, n
    for i in np.flatnonzero(~single).tolist():
        N = _own_normals(held[i], [of[i] for of, free, _, _ in found if free[i]])
        dual = np.linalg.pinv(N)
        real[i] -= dual @ N
        normals[i, : len(N)], own[i, : len(N)] = N, dual.T
    real[np.abs(real) < ROUND_OFF] = 0.0
    some = normals.any(axis=(1, 2))
    return (
        HeldDrilling(at[some], real[some], normals[some], own[some], ~single[some], model.nodes.coords)
        if some.any()
        else None
    )


def still_edges(model: Model, nodes: IntArray) -> list[LinearEquation]:
    """n . theta = 0 of flat triangles at sides that cannot turn in the plane, where nothing else has that rotation.

    Their drilling rotations bow the sides between the nodes; a side that supports hold neither turns nor bows. What
    the support has of the rotations makes no difference then.
    """
    mine = [nodes[:0], *(b.nodes_idx.ravel() for b in model.blocks if b.kind == "tri3" and _strains(b))]
    others = [linked_nodes(model.constraints, model.fixed)]
    others += [b.nodes_idx.ravel() for b in model.blocks if b.kind not in SHELL_FACETS]
    at = np.intersect1d(np.intersect1d(nodes, np.concatenate(mine)), held_directions(model, TRANSLATIONS)[0])
    at = np.setdiff1d(at, np.concatenate(others))
    found = _surfaces(model, at)
    if not found:
        return []
    n, _, rest, _ = found[0]
    fold = found[1][3] if len(found) > 1 else np.zeros(rest.size, dtype=bool)
    out = []
    for node, normal in zip(at[rest & ~fold], n[rest & ~fold], strict=True):
        order = [int(k) for k in np.argsort(-np.abs(normal)) if abs(normal[k]) > ROUND_OFF]
        out.append(LinearEquation([dof_label(int(node), 4 + k) for k in order], normal[order].tolist()))
    return out


def _own_normals(held: FloatArray, normals: list[FloatArray]) -> FloatArray:
    """Those of the normals (m, 3) at a fold that supports hold exactly, as many as are independent."""
    out = np.zeros((0, 3))
    for n in normals:
        a = held @ n
        size = float(np.linalg.norm(a))
        more = np.vstack([out, a / max(size, ROUND_OFF)])
        if size >= EXACTLY and np.linalg.svd(more, compute_uv=False).min() > 1.0 - SMOOTH:
            out = more
    return out


def held_directions(model: Model, dofs: tuple[int, ...]) -> tuple[IntArray, FloatArray]:
    """Nodes (k,) that supports hold in some of three dofs, sorted; the projection (k, 3, 3) on the held directions."""
    axes = np.zeros((model.nodes.count, 3), dtype=bool)
    for f in model.fixed:
        axes[f.nodes_idx[:, None], np.array([d - dofs[0] for d in f.dofs if d in dofs], dtype=np.int64)] = True
    oblique: dict[int, list[FloatArray]] = {}
    for c in oblique_supports(model.constraints, model.fixed):
        if np.isin(c.dofs, dofs).all():
            oblique.setdefault(int(c.nodes_idx[0]), []).append(
                np.bincount(c.dofs - dofs[0], c.coefficients, 3).astype(np.float64)
            )
    extra = np.array(sorted(oblique), dtype=np.int64)
    nodes = np.union1d(np.flatnonzero(axes.any(axis=1)), extra)
    held = axes[nodes][:, :, None] * np.eye(3)
    for i, node in zip(np.searchsorted(nodes, extra).tolist(), extra.tolist(), strict=True):
        rows = np.array([v / np.linalg.norm(v) for v in oblique[node] if v.any()]).reshape(-1, 3)
        _, s, V = np.linalg.svd(np.vstack([np.eye(3)[axes[node]], rows]))
        V = V[: np.count_nonzero(s > ROUND_OFF)]
        held[i] = V.T @ V
    return nodes, held


def _surfaces(model: Model, nodes: IntArray) -> list[tuple[FloatArray, BoolArray, BoolArray, BoolArray]]:
    """Of the first, second, ... smooth surface at each node: normals (k, 3); whether it may turn in its plane; whether
    a side of it there cannot; whether it is there."""
    of, normals, resting = [np.zeros(0, dtype=np.int64)], [np.zeros((0, 3))], [np.zeros(0, dtype=bool)]
    supports = held_directions(model, TRANSLATIONS)
    for block in model.blocks:
        if _strains(block):
            at, there = _found(nodes, block.nodes_idx)
            some = there.any(axis=1)
            at, there, own = at[some], there[some], block.nodes_idx[some]
            of.append(at[there])
            normals.append(normals_at_nodes(block.kind, own, model.nodes.coords)[there])
            resting.append(_resting(block.kind, own, model.nodes.coords, *supports)[there])
    at, n, rest = np.concatenate(of), np.concatenate(normals), np.concatenate(resting)
    alone = _only_hold(model, nodes, *supports)
    out = []
    while at.size:
        which, first = np.unique(at, return_index=True)
        reference = np.zeros((nodes.size, 3))
        reference[which] = n[first]
        along = np.einsum("ei,ei->e", n, reference[at])
        same = np.abs(along) >= SMOOTH
        same[first] = True
        mean, held = np.zeros((nodes.size, 3)), np.zeros(nodes.size, dtype=bool)
        np.add.at(mean, at[same], np.sign(along[same])[:, None] * n[same])
        held[at[same & rest]] = True
        fixed = held | alone(unit(mean))
        there = np.zeros(nodes.size, dtype=bool)
        there[which] = True
        out.append((unit(mean), there & ~fixed, held, there))
        at, n, rest = at[~same], n[~same], rest[~same]
    return out


def _only_hold(
    model: Model, nodes: IntArray, held: IntArray, projection: FloatArray
) -> Callable[[FloatArray], BoolArray]:
    """Normals (k, 3) at `nodes` -> whether the node is pinned in the plane, and nothing else holds its structure."""
    body, grounded = _bodies(model)
    pins = held[(np.trace(projection, axis1=1, axis2=2) > 2.0 - EXACT) & ~np.isin(body[held], grounded)]
    single = pins[np.bincount(body[pins], minlength=1)[body[pins]] == 1]

    def alone(normals: FloatArray) -> BoolArray:
        out = np.zeros(nodes.size, dtype=bool)
        for i in np.flatnonzero(np.isin(nodes, single) & normals.any(axis=1)).tolist():
            mine = body[held] == body[nodes[i]]
            flat = np.eye(3) - np.outer(normals[i], normals[i])
            in_plane = np.einsum("ij,kij->k", flat, projection[mine])
            own = held[mine] == nodes[i]
            out[i] = (in_plane[own] > 2.0 - EXACT).all() and not (in_plane[~own] > EXACT).any()
        return out

    return alone


def _bodies(model: Model) -> tuple[IntArray, IntArray]:
    """(n_node,) number of the connected structure of each node, links included; those that springs hold to ground."""
    n, grounded = model.nodes.count, [np.zeros(0, dtype=np.int64)]
    pairs = [np.zeros((0, 2), dtype=np.int64)]
    for k, part in enumerate(model.parts):
        pairs.append(np.stack([part.nodes_idx, np.full(part.nodes_idx.size, n + k)], axis=1))
    for c in model.constraints:
        pairs.append(np.stack([c.nodes, np.full(c.nodes.size, c.nodes[0])], axis=1))
    for block in model.blocks:
        if isinstance(block.section, Discrete):
            pairs.append(block.nodes_idx[:, [0, -1]])
            if block.nodes_idx.shape[1] == 1:
                grounded.append(block.nodes_idx.ravel())
    a, b = np.concatenate(pairs).T
    size = n + len(model.parts)
    body = connected_components(sp.coo_matrix((np.ones(a.size), (a, b)), shape=(size, size)), directed=False)[1]
    return body.astype(np.int64), body[np.concatenate(grounded)]


def _resting(kind: str, nodes: IntArray, coords: FloatArray, held: IntArray, projection: FloatArray) -> BoolArray:
    """(n, k) ends of sides that supports hold at both ends across the side, in the plane of the shell."""
    facets = facets_of_shells(kind, nodes)
    x = coords[facets]
    along = np.roll(x, -1, axis=2) - x
    across = unit(np.cross(unit(np.cross(x[:, :, 2] - x[:, :, 0], x[:, :, 3] - x[:, :, 1]))[:, :, None], along))
    out = np.zeros(nodes.shape, dtype=bool)
    if held.size:
        for facet, places in enumerate(SHELL_FACETS[kind]):
            for i in range(4):
                both = across[:, facet, i].any(axis=1)
                for end in (places[i], places[(i + 1) % 4]):
                    at, there = _found(held, nodes[:, end])
                    share = np.linalg.norm(np.einsum("eij,ej->ei", projection[at], across[:, facet, i]), axis=1)
                    both &= there & (share >= EXACTLY)
                out[both, places[i]] = out[both, places[(i + 1) % 4]] = True
    return out


def _strains(block: ElementBlock) -> bool:
    """Whether it is a shell that has stiffness."""
    return block.kind in SHELL_FACETS and not (isinstance(block.section, GeneralShell) and block.section.rigid)


def _found(nodes: IntArray, wanted: IntArray) -> tuple[IntArray, BoolArray]:
    """Places in sorted `nodes` of the wanted ones, and whether each is there."""
    at = np.minimum(np.searchsorted(nodes, wanted), max(nodes.size - 1, 0))
    return at, nodes[at] == wanted if nodes.size else np.zeros(wanted.shape, dtype=bool)


BEAMS = ("beam2", "beam3")


def with_edges(model: Model, blocks: Sequence[ElementBlock], nodes: IntArray) -> list[ElementBlock]:
    """The blocks, whose nodes are `nodes`, with the free sides of their shells.

    Of quadrilaterals these are the sides that no other shell of the model has, of triangles those along which a
    twisting moment falls to nothing: see `elements.free_sides`. Ties and equations join the edges of shells as a fold
    does, and leave them that.
    """
    beside = _shells_beside(model, blocks, nodes)
    out = with_free_sides(blocks, beside)
    shells = [k for k, block in enumerate(out) if block.kind in SHELLS]
    if all(out[k].kind != "tri3" for k in shells):
        return out
    coords = model.nodes.coords
    at, held = _held_rotations(model)
    for k, ends in zip(shells, ending_sides(coords, [*(out[k].nodes_idx for k in shells), *beside]), strict=False):
        block = out[k]
        if block.kind == "tri3":
            free = twisting_sides(coords, block.nodes_idx, ends, at, held)
            out[k] = replace(block, own=replace(block.own, free_sides=free))
    return out


def _held_rotations(model: Model) -> tuple[IntArray, FloatArray]:
    """Nodes (k,), sorted, and the projection (k, 3, 3) on the rotations that supports, rigid bodies and beams hold."""
    rigid = [c.nodes for c in model.constraints if isinstance(c, KinematicCoupling | RigidLink)]
    beams = [block.nodes_idx.ravel() for block in model.blocks if block.kind in BEAMS]
    supported, held = held_directions(model, ROTATIONS)
    stiff = np.unique(np.concatenate([supported[:0], *rigid, *beams]))
    nodes = np.union1d(supported, stiff)
    out = np.zeros((nodes.size, 3, 3))
    out[np.searchsorted(nodes, supported)] = held
    out[np.searchsorted(nodes, stiff)] = np.eye(3)
    return nodes, out


def _shells_beside(model: Model, blocks: Sequence[ElementBlock], nodes: IntArray) -> list[IntArray]:
    """Corner nodes of the shells of other parts that may have a side in common with the blocks."""
    shared = np.zeros(model.nodes.count, dtype=bool)
    shared[np.intersect1d(shared_nodes(model), nodes)] = True
    if not shared.any():
        return []
    parts = {block.part for block in blocks}
    others = [block.nodes_idx for block in model.blocks if block.kind in SHELLS and block.part not in parts]
    return [corners[np.count_nonzero(shared[corners], axis=1) >= 2] for corners in others]
