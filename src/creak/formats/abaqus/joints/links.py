"""*MPC and *EQUATION."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError
from creak.formats.abaqus.joints.couplings import note_rotated
from creak.formats.abaqus.mesh.directions import Transforms
from creak.formats.abaqus.text.fields import Registry, to_dof, to_float, to_int
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, Scope
from creak.model.constraints import Constraint, Equation, RigidLink

_LINKS = {"BEAM": "beam", "TIE": "tie", "PIN": "pin", "LINK": "link"}


def read_links(deck: Outline, nodes: Registry, coords: FloatArray, transforms: Transforms) -> list[Constraint]:
    """Two-node links and equations, in the nodes' own axes where *TRANSFORM gives them.

    *MPC types other than BEAM, TIE, PIN and LINK are listed as unread.

    Raises
    ------
    InputError : unknown node or set, sets of different length, a truncated equation.
    """
    result: list[Constraint] = []
    for scope, block in deck.blocks("MPC"):
        for fields, where in block.rows():
            result += _mpc_line(deck, scope, block, fields, where, nodes, coords)
    for scope, block in deck.blocks("EQUATION"):
        note_rotated(deck, scope, block)
        result += _equations(scope, block, nodes, transforms)
    return result


def _mpc_line(
    deck: Outline, scope: Scope, block: Block, fields: list[str], where: str, nodes: Registry, coords: FloatArray
) -> list[Constraint]:
    kind = _LINKS.get(fields[0].upper())
    if kind is None:
        deck.note(block, "creak reads BEAM, TIE, PIN and LINK", changes=True, what=f"*MPC, {fields[0]} ({where})")
        return []
    if len(fields) != 3:
        raise InputError(
            f"*MPC {fields[0]} with {len(fields) - 1} nodes",
            expected="type, dependent node, independent node",
            where=where,
            fix="Correct the line.",
        )
    first, second = (nodes.find(f, scope.name, where) for f in fields[1:])
    if second.size not in (1, first.size):
        raise InputError(
            f"*MPC {fields[0]} links {first.size} to {second.size} nodes",
            expected="sets of equal length",
            where=where,
            fix="Correct the sets; their order pairs the nodes.",
        )
    pairs = list(zip(first, np.broadcast_to(second, first.shape), strict=True))
    if any(a == b for a, b in pairs):
        raise InputError(f"*MPC {fields[0]} links a node to itself", where=where, fix="Name two nodes.")
    if kind == "link":
        return [_link(int(a), int(b), coords, where) for a, b in pairs]
    return [RigidLink(kind, int(a), int(b), where) for a, b in pairs]


def _link(a: int, b: int, coords: FloatArray, where: str) -> Equation:
    """t . (u_a - u_b) = 0: the distance of the nodes is kept."""
    line = coords[b] - coords[a]
    length = float(np.linalg.norm(line))
    if not length > 0.0:
        raise InputError("*MPC LINK joins coincident nodes", where=where, fix="Use PIN.")
    order = np.argsort(-np.abs(line), kind="stable")
    order = order[np.abs(line[order]) > 1e-12 * length]
    t, dofs = line[order] / length, order + 1
    nodes_idx = np.repeat(np.array([a, b], dtype=np.int64), order.size)
    return Equation(nodes_idx, np.concatenate([dofs, dofs]), np.concatenate([t, -t]), where)


def _equations(scope: Scope, block: Block, nodes: Registry, transforms: Transforms) -> list[Constraint]:
    rows = [(f, where) for f, where in block.rows()]
    result: list[Constraint] = []
    k = 0
    while k < len(rows):
        fields, where = rows[k]
        n_terms = to_int(fields[0], where, "number of terms")
        if n_terms < 1 or len(fields) > 1:
            raise InputError(
                f"*EQUATION begins with {', '.join(fields)}",
                expected="the number of terms, alone on its line",
                where=where,
                fix="Correct the line.",
            )
        k += 1
        terms: list[str] = []
        while k < len(rows) and len(terms) < 3 * n_terms:
            terms += rows[k][0]
            k += 1
        if len(terms) != 3 * n_terms:
            raise InputError(
                f"*EQUATION of {n_terms} terms has {len(terms)} values",
                expected="node, dof, coefficient each",
                where=where,
                fix="Complete its lines.",
            )
        result += _equation(scope, terms, where, nodes, transforms)
    return result


def _equation(scope: Scope, terms: list[str], where: str, nodes: Registry, transforms: Transforms) -> list[Constraint]:
    sets: list[IntArray] = [nodes.find(t, scope.name, where) for t in terms[::3]]
    dofs = np.array([to_dof(t, where) for t in terms[1::3]], dtype=np.int64)
    factors = np.array([to_float(t, where, "coefficient") for t in terms[2::3]])
    length = sets[0].size
    if any(s.size not in (1, length) for s in sets):
        raise InputError(
            f"*EQUATION with sets of {', '.join(str(s.size) for s in sets)} nodes",
            expected="sets of equal length or single nodes",
            where=where,
            fix="Correct the sets.",
        )
    if factors[0] == 0.0:
        raise InputError(
            "the first coefficient of *EQUATION is zero",
            expected="not zero: this dof is eliminated",
            where=where,
            fix="Reorder or remove the term.",
        )
    table = np.stack([np.broadcast_to(s, (length,)) for s in sets], axis=1)
    return [_in_global_dofs(row, dofs, factors, where, transforms) for row in table]


def _in_global_dofs(row: IntArray, dofs: IntArray, factors: FloatArray, where: str, transforms: Transforms) -> Equation:
    if not transforms.touched(row):
        return Equation(row.copy(), dofs, factors, where)
    terms = [
        (node, dof, f * c)
        for node, d, f in zip(row.tolist(), dofs.tolist(), factors.tolist(), strict=True)
        for dof, c in transforms.terms(node, d)
    ]
    nodes_idx, all_dofs = (np.array([t[k] for t in terms], dtype=np.int64) for k in (0, 1))
    return Equation(nodes_idx, all_dofs, np.array([t[2] for t in terms]), where)
