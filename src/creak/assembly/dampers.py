"""Dofs that nothing but dampers hold: they follow the others; and what may press on them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.sparse as sp

from creak.arrays import BoolArray, FloatArray, IntArray, Matrix, to_dense
from creak.errors import InputError
from creak.model.dofs import dof_label, node_and_dof
from creak.model.mesh import Model

NOTHING = 1e-12
"""What is left of a damping coefficient counts as round-off below this share of it."""


def led_by_dampers(C: Matrix, C_s: FloatArray, led: IntArray, rest: IntArray) -> tuple[Matrix, Matrix, Matrix]:
    """How dofs without stiffness and mass follow the others, and the damping that those then have.

    Their equations are C_ll v_l + C_lr v_r + C_ls s' = 0 as long as nothing presses on them. From rest on that is
    u_l = X u_r + X_s s with X = -C_ll^+ C_lr, X_s = -C_ll^+ C_ls, exactly; the damping of the rest is
    C_rr + C_rl X. Dofs that dampers join to each other alone stay where they are (C_ll is singular there).

    Parameters
    ----------
    C : (n, n) damping. C_s : (n, n_support) the same against prescribed motion.
    led, rest : the dofs that follow, and the others, ascending.

    Returns
    -------
    X (n_led, n_rest), X_s (n_led, n_support), C (n_rest, n_rest), all sparse.
    """
    C = sp.csr_matrix(C)
    scale = 1.0 / np.sqrt(C.diagonal()[led])
    across = sp.csr_matrix(C[led][:, rest])
    near = np.unique(across.indices)
    inverse = scale[:, None] * np.linalg.pinv(scale[:, None] * C[led][:, led].toarray() * scale, hermitian=True) * scale
    C_lr, C_rr = across[:, near].toarray(), sp.csr_matrix(C[rest][:, rest])
    X = -inverse @ C_lr
    before = C_rr[near][:, near].toarray()
    after = before + C_lr.T @ X
    after[np.abs(after) <= NOTHING * np.abs(before)] = 0.0
    place = sp.csr_matrix((np.ones(near.size), (np.arange(near.size), near)), shape=(near.size, rest.size))
    change = 0.5 * (after + after.T) - before
    damping = sp.csr_matrix(C_rr + place.T @ sp.csr_matrix(change) @ place)
    damping.eliminate_zeros()
    return sp.csr_matrix(X) @ place, sp.csr_matrix(-inverse @ to_dense(C_s)[led]), damping


def bearing(
    rows: Callable[[IntArray], Matrix], left: Matrix, damped: BoolArray, model: Model
) -> Callable[[IntArray], None]:
    """`System.bear` of a joined System.

    Parameters
    ----------
    rows : labels -> their motion in the coordinates of all Systems.
    left : the latter's motion with the dofs that have neither stiffness nor mass.
    damped : (n_left,) which of these have dampers.
    """
    on_dampers, on_nothing = abs(left[:, damped]), abs(left[:, ~damped])

    def bear(labels: IntArray) -> None:
        A = abs(sp.csr_matrix(rows(labels)))
        for found, what in (
            (A @ on_dampers, "only dampers hold it: it has neither stiffness nor mass"),
            (A @ on_nothing, "it has neither stiffness nor mass, and nothing holds it"),
        ):
            bad = np.flatnonzero(np.asarray(found.sum(axis=1)).ravel() > 0.0)
            if bad.size:
                raise _unborne(labels[bad], what, model)
        bare = np.flatnonzero(np.asarray(A.sum(axis=1)).ravel() == 0.0)
        if bare.size:
            raise _unborne(labels[bare], "it has neither stiffness nor mass, and nothing holds it", model)

    return bear


def _unborne(labels: IntArray, what: str, model: Model) -> InputError:
    others = f" ({labels.size} such dofs)" if labels.size > 1 else ""
    return InputError(
        f"a load or a contact channel acts at {place_of(int(labels[0]), model)}{others}, but {what}",
        expected="a dof with stiffness or mass, or one that is held or driven",
        where=str(model.source or ""),
        fix="Give the node a mass or a stiffness there, or hold it.",
    )


def place_of(label: int, model: Model) -> str:
    """`node 17 RZ`, or the dof's label where the Systems came without a deck."""
    label = ~label if label < 0 else label
    if model.parts:
        return model.nodes.dof_name(label)
    node, dof = node_and_dof(label)
    return f"dof {dof_label(int(model.nodes.ids[node]), dof)}"
