"""Play connectors: free within limits, then stiff."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import IntArray
from creak.contact.gap_operator import ChannelRows, GapOperator, gap_operator
from creak.errors import InputError
from creak.model.mesh import Model


@dataclass(frozen=True)
class Play:
    """u_B - u_A in one dof stays free between `lower` and `upper`; beyond, a spring and a dashpot push back.

    With one node set the nodes are stopped against ground (u_A = 0).
    """

    name: str
    nodes: tuple[str, ...]
    dof: int
    lower: float | None
    upper: float | None
    stiffness: float
    damping: float = 0.0


def play_channels(model: Model, play: Play, where: str) -> GapOperator:
    """Up to two channels per node (pair): gap = upper - r and gap = r - lower with r = u_B - u_A.

    Raises
    ------
    InputError : unknown sets, sets of different size, no limit at all, lower > upper.
    """
    ends = [model.node_set(name, where=where) for name in play.nodes]
    if len(ends) == 2 and ends[0].size != ends[1].size:
        raise InputError(
            f"node sets {play.nodes[0]!r} and {play.nodes[1]!r} have {ends[0].size} and {ends[1].size} nodes",
            where=where, expected="the same number, node by node", fix="Make the sets equally long.",
        )  # fmt: skip
    limits = [("upper", -1.0, play.upper), ("lower", 1.0, play.lower)]
    sides = [(name, sign, value) for name, sign, value in limits if value is not None]
    if not sides:
        raise InputError("a play connector without limits", where=where, fix="Give lower, upper or both.")
    if play.lower is not None and play.upper is not None and play.lower > play.upper:
        raise InputError(f"lower = {play.lower} lies above upper = {play.upper}", where=where, fix="Swap them.")
    moving = ends[-1]
    channel: list[int] = []
    label: list[int] = []
    value: list[float] = []
    gap0: list[float] = []
    names: list[str] = []
    nodes: list[int] = []
    for k in range(moving.size):
        for side, sign, limit in sides:
            row = len(gap0)
            terms = [(int(moving[k]), sign)] + ([(int(ends[0][k]), -sign)] if len(ends) == 2 else [])
            for node, c in terms:
                channel.append(row)
                label.append(6 * int(node) + play.dof - 1)
                value.append(c)
            gap0.append(-sign * limit)
            names.append(f"{play.name}:{side}" + (f":{model.nodes.label(int(moving[k]))}" if moving.size > 1 else ""))
            nodes.append(int(moving[k]))
    n = len(gap0)
    zero = np.zeros(len(value))
    rows = ChannelRows(_ints(channel), _ints(label), np.array(value), zero, zero)
    return gap_operator(
        rows,
        gap0=np.array(gap0),
        stiffness=np.full(n, play.stiffness),
        damping=np.full(n, play.damping),
        area=np.zeros(n),
        names=names,
        nodes_idx=_ints(nodes),
        group=play.name,
    )


def _ints(values: list[int]) -> IntArray:
    return np.array(values, dtype=np.int64)
