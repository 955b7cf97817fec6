"""A superelement: a part of the model given by its reduced matrices instead of elements."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from creak.arrays import FloatArray, IntArray, Matrix


@dataclass(frozen=True)
class Superelement:
    """M q'' + C q' + K q = f of a reduced part, with the node and dof of every row.

    All displacement dofs are in the global (basic) frame, but for those of `in_deck_frames`.
    """

    name: str
    node_ids: IntArray
    """(n,) label of the node as written in the deck; 0 for generalised coordinates."""
    dofs: IntArray
    """(n,) 1..6; 0 for generalised coordinates (fixed-interface modes)."""
    K: Matrix
    """(n, n) symmetric, both triangles."""
    M: Matrix
    """(n, n)"""
    C: Matrix | None = None
    """(n, n) viscous damping, None if there is none."""
    positions: dict[int, FloatArray] = field(default_factory=dict)
    """Node label -> (3,) global coordinates, for the nodes whose place is known."""
    source: str = ""
    """File it came from, for messages."""
    in_deck_frames: frozenset[int] = frozenset()
    """Labels of nodes that move in the displacement frames (CD) of the Nastran deck they join, which the file does not
    give; in the basic frame where the deck gives none."""

    @property
    def n(self) -> int:
        """Number of rows."""
        return int(self.node_ids.size)

    @property
    def generalised(self) -> IntArray:
        """Rows of the generalised coordinates."""
        return np.flatnonzero(self.node_ids == 0)
