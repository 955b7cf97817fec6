"""Springs and dashpots along turned axes, which the model has as matrices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.model.materials import NodalMatrices, Spring

ROUND_OFF = 1e-12


@dataclass(frozen=True)
class TurnedSpring:
    """A spring in the axes of an *ORIENTATION."""

    spring: Spring
    axes: FloatArray
    """(2, 3) axis 1, and another one across it."""


def turned_spring(section: NodalMatrices) -> TurnedSpring | None:
    """The spring or dashpot whose matrix k g g' it is, g a direction at one node and, less, one at the other."""
    given = [A for A in (section.stiffness, section.damping) if A.any()]
    if len(given) != 1 or section.mass.any() or section.stiffness.shape[0] > 12:
        return None
    (A,) = given
    k, j = float(np.trace(A[:6, :6])), int(np.abs(np.diag(A)[:6]).argmax())
    if not k * A[j, j] > 0.0:
        return None
    g = A[:, j] / np.sqrt(k * A[j, j])
    ends = [g[:6].reshape(2, 3), *([-g[6:].reshape(2, 3)] if g.size == 12 else [])]
    triples = [np.flatnonzero(end.any(axis=1)) for end in ends]
    if np.abs(k * np.outer(g, g) - A).max() > ROUND_OFF * abs(k) or any(t.size != 1 for t in triples):
        return None
    n = [end[int(t[0])] for end, t in zip(ends, triples, strict=True)]
    along = float(n[0] @ n[-1])
    if any(abs(np.linalg.norm(x) - 1.0) > ROUND_OFF for x in n) or min(abs(along - 1.0), abs(along)) > ROUND_OFF:
        return None
    same = abs(along - 1.0) <= ROUND_OFF
    dofs = [1 + 3 * int(t[0]) + (i and not same) for i, t in enumerate(triples)]
    across = np.cross(n[0], np.eye(3)[int(np.abs(n[0]).argmin())]) if same else n[-1]
    stiffness, damping = (k, 0.0) if section.stiffness.any() else (0.0, k)
    spring = Spring(section.name, dofs[0], dofs[1] if len(dofs) == 2 else 0, stiffness, damping)
    return TurnedSpring(spring, np.array([n[0], across]))
