"""Channels that can neither open nor close, because a tie joins their two sides there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from creak.arrays import BoolArray
from creak.contact.gap_operator import GapOperator
from creak.contact.pair import ContactPair, main_facets
from creak.model.constraints import Constraint, Equation, Tie
from creak.model.dofs import TRANSLATIONS, nodes_of
from creak.model.mesh import Model


def tied_channels(model: Model, pair: ContactPair, operator: GapOperator) -> BoolArray:
    """(m,) channels whose node is tied to the main surface opposite it, or whose main nodes are all tied to the
    secondary surface.

    A gap there is sum_k w_k (u_s - u_k) . n with u_s = sum_k w_k u_k: it stays as it is, and what is seen of it is
    round-off.

    Parameters
    ----------
    operator : the channels of the pair.
    """
    leaders = dict(_ties(model.constraints, set(nodes_of(operator.labels).tolist())))
    tied = np.zeros(operator.m, dtype=bool)
    if not leaders:
        return tied
    surface, G = set(main_facets(model, pair).nodes.ravel().tolist()), operator.G.tocsr()
    for k, node in enumerate(operator.nodes_idx.tolist()):
        row = set(nodes_of(operator.labels[G.indices[G.indptr[k] : G.indptr[k + 1]]]).tolist())
        opposite, own = row & surface, row - surface
        if node in leaders:
            tied[k] = leaders[node] <= surface and not leaders[node].isdisjoint(opposite)
        else:
            tied[k] = bool(opposite) and all(not leaders.get(n, set()).isdisjoint(own) for n in opposite)
    return tied


def _ties(constraints: Sequence[Constraint], of: set[int]) -> Iterator[tuple[int, set[int]]]:
    """Nodes among `of` that ties join to several others in all three directions, and those others."""
    dofs: dict[int, set[int]] = {}
    nodes: dict[int, set[int]] = {}
    for c in constraints:
        if isinstance(c, Tie) and c.node_idx in of:
            yield c.node_idx, set(c.nodes_idx.tolist())
        elif isinstance(c, Equation) and int(c.nodes_idx[0]) in of:
            node = int(c.nodes_idx[0])
            dofs.setdefault(node, set()).add(int(c.dofs[0]))
            nodes.setdefault(node, set()).update(c.nodes_idx[1:].tolist())
    yield from ((n, nodes[n]) for n in dofs if set(TRANSLATIONS) <= dofs[n] and len(nodes[n]) > 1)
