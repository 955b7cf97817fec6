"""Play connectors: free within limits, then stiff."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.gap_operator import ChannelRows, GapOperator
from creak.contact.laws.parameters import laid_over
from creak.contact.pair import tangents_of
from creak.errors import InputError
from creak.model.contact_law import ContactLaw
from creak.model.dofs import dof_label
from creak.model.mesh import Model

BESIDE = 0.5
"""A node that is nearer than this share of the distance to the one that another is joined to."""


@dataclass(frozen=True)
class Play:
    """u_B - u_A in one dof stays free between `lower` and `upper`; beyond, a spring and a dashpot push back.

    With one node set the nodes are stopped against ground (u_A = 0).

    A one-sided stop with a `preload` P (a bumper under compression, a seal) presses with P at rest. Its spring is
    squeezed by P / stiffness then, gap0 = -P / stiffness, and it lets go once the nodes have parted by that much.
    What holds the preload is not in the model's displacements: the rest of the structure balances it at t = 0, so
    the channels push with p - P and the model starts in equilibrium, undeformed. The limit must be 0, the place at
    rest.
    """

    name: str
    nodes: tuple[str, ...]
    dof: int
    lower: float | None
    upper: float | None
    law: ContactLaw
    """Of each channel."""
    direction: tuple[float, float, float] | None = None
    """Unit vector of the motion; None: `dof`. Across it both nodes rub on each other where the law has friction."""


def nodes_of_ends(model: Model, names: tuple[str, ...], where: str) -> list[IntArray]:
    """(n,) nodes of each end: one of each set belong together.

    Raises
    ------
    InputError : unknown sets, sets of different size, a node joined to itself.
    """
    ends = [model.node_set(name, where=where) for name in names]
    if len(ends) == 2 and ends[0].size != ends[1].size:
        raise InputError(
            f"node sets {names[0]!r} and {names[1]!r} have {ends[0].size} and {ends[1].size} nodes",
            where=where,
            expected="the same number, node by node",
            fix="Make the sets equally long.",
        )
    if len(ends) == 2 and (same := ends[0] == ends[1]).any():
        label = model.nodes.label(int(ends[0][same.argmax()]))
        raise InputError(
            f"node {label} of {names[0]!r} is joined to itself in {names[1]!r}",
            where=where,
            expected="two nodes, which can move against each other",
            fix="Name other nodes; one set alone joins its nodes to ground.",
        )
    return ends


def crossed(model: Model, play: Play, where: str, unit: str) -> list[str]:
    """In words, nodes that are joined by the order of their sets to others than those that lie beside them."""
    ends = nodes_of_ends(model, play.nodes, where)
    if len(ends) < 2 or ends[0].size < 2:
        return []
    from scipy.spatial import cKDTree

    a, b = (model.nodes.coords[end] for end in ends)
    apart, (near, other) = np.linalg.norm(a - b, axis=1), cKDTree(b).query(a)
    k = int(np.argmax(apart - near / BESIDE))
    if near[k] >= BESIDE * apart[k]:
        return []
    first, second, beside = (model.nodes.label(int(i)) for i in (ends[0][k], ends[1][k], ends[1][other[k]]))
    return [
        f"{where}: sets of nodes are joined in turn, so node {first} of {play.nodes[0]!r} to {second} of "
        f"{play.nodes[1]!r}, {apart[k]:.4g} {unit} away, though {beside} lies {near[k]:.4g} {unit} away: list both in "
        "the same order (Abaqus: *NSET, UNSORTED), or give a connector for each pair"
    ]


def play_channels(model: Model, play: Play, where: str) -> GapOperator:
    """Up to two channels per node (pair): gap = upper - r and gap = r - lower with r = u_B - u_A.

    Raises
    ------
    InputError : unknown sets, sets of different size, no limit at all, lower > upper; a preload with two limits, or
        with a limit other than zero.
    """
    ends = nodes_of_ends(model, play.nodes, where)
    check_play(play, where)
    limits = [("upper", -1.0, play.upper), ("lower", 1.0, play.lower)]
    sides = [(name, sign, value) for name, sign, value in limits if value is not None]
    moving, law = ends[-1], play.law
    axes = _axes(play)
    squeezed = law.preload / law.stiffness if law.preload and law.stiffness else 0.0
    channel: list[int] = []
    label: list[int] = []
    value: list[FloatArray] = []
    gap0: list[float] = []
    names: list[str] = []
    nodes: list[int] = []
    for k in range(moving.size):
        for side, sign, limit in sides:
            row = len(gap0)
            terms = [(int(moving[k]), sign)] + ([(int(ends[0][k]), -sign)] if len(ends) == 2 else [])
            for node, c in terms:
                for dof, along, across in axes:
                    channel.append(row)
                    label.append(dof_label(node, dof))
                    # Friction acts on the motion of the second node against the first, on whichever side it presses.
                    value.append(np.array([c * along, *(c * sign * across)]))
            gap0.append(-sign * limit - squeezed)
            names.append(f"{play.name}:{side}" + (f":{model.nodes.label(int(moving[k]))}" if moving.size > 1 else ""))
            nodes.append(int(moving[k]))
    n = len(gap0)
    rows = ChannelRows(_ints(channel), _ints(label), *np.array(value).reshape(-1, 3).T)
    return GapOperator(
        **rows.motion(n),
        gap0=np.array(gap0),
        area=np.zeros(n),
        names=tuple(names),
        nodes_idx=_ints(nodes),
        group=(play.name,) * n,
        **laid_over(law, np.ones(n)),
    )


def _axes(play: Play) -> list[tuple[int, float, FloatArray]]:
    """Dof, its share in the motion, and (2,) its shares in both tangents, which are zero where nothing rubs."""
    if play.direction is None and (play.law.friction.static == 0.0 or play.dof > 3):
        return [(play.dof, 1.0, np.zeros(2))]
    normal = np.eye(3)[play.dof - 1] if play.direction is None else np.array(play.direction)
    rubs = float(play.law.friction.static > 0.0)
    across = rubs * np.stack([t[0] for t in tangents_of(normal[None])], axis=1)
    return [(k + 1, float(normal[k]), across[k]) for k in range(3) if normal[k] or across[k].any()]


def check_play(play: Play, where: str) -> None:
    """Raise InputError for limits that are none, or do not go together."""
    limits = [value for value in (play.upper, play.lower) if value is not None]
    if not limits:
        raise InputError("a play connector without limits", where=where, fix="Give lower, upper or both.")
    if play.lower is not None and play.upper is not None and play.lower > play.upper:
        raise InputError(f"lower = {play.lower} lies above upper = {play.upper}", where=where, fix="Swap them.")
    if play.law.hard and play.law.damping:
        raise InputError(
            f"damping = {play.law.damping:g} beside hard contact",
            where=where,
            expected="damping = 0: what does not penetrate has no speed of closing to damp",
            fix="Leave it out, or give a stiffness.",
        )
    if play.law.preload and len(limits) != 1:
        raise InputError(
            "a play connector with a preload and two limits",
            where=where,
            expected="lower or upper, not both",
            fix="Leave out the limit that does not press, or make two connectors.",
        )
    if play.law.preload and limits[0] != 0.0:
        raise InputError(
            f"a preloaded stop with its limit at {limits[0]:g}",
            where=where,
            expected="0: with a preload the limit is the place at rest, where the stop presses with it",
            fix="Set the limit to 0, or leave out the preload.",
        )


def _ints(values: list[int]) -> IntArray:
    return np.array(values, dtype=np.int64)
