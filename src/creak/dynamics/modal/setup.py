"""A diagonal System with its channels and loads as contiguous arrays for compiled code."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.system import to_dense
from creak.contact.gap_operator import GapOperator
from creak.dynamics.books import SIZE
from creak.dynamics.channels import ChannelMatrices
from creak.dynamics.loads import Loads
from creak.dynamics.modal.model import ACCELERATION, CONSTANT, DISPLACEMENT, FORCE, VELOCITY, MarchState, ModalModel
from creak.dynamics.state import LinearTerms


def modal_model(
    m: FloatArray, c: FloatArray, k: FloatArray, on: ChannelMatrices, terms: LinearTerms, gaps: GapOperator
) -> ModalModel:
    """Contiguous arrays for the kernels; load columns that are zero are left out."""
    sup, preload = terms.system.supports, np.zeros(gaps.m) if gaps.preload is None else gaps.preload
    blocks = [
        (ACCELERATION, terms.on_all(-terms.M_qs)),
        (VELOCITY, terms.on_all(-terms.C_qs)),
        (DISPLACEMENT, terms.on_all(-terms.K_qs)),
        (FORCE, terms.on_all(terms.B)),
        (CONSTANT, -np.column_stack([np.asarray(on.G.T @ preload), np.asarray(on.T.T @ gaps.resting[gaps.m :])])),
    ]
    columns = [(order, j, A[:, j]) for order, A in blocks for j in range(A.shape[1]) if A[:, j].any()]
    X = np.ascontiguousarray([x for _, _, x in columns]) if columns else np.zeros((0, m.size))
    rows = np.ascontiguousarray(np.vstack([to_dense(on.G), to_dense(on.T)]), dtype=np.float64)
    return ModalModel(
        m,
        c,
        k,
        rows,
        np.ascontiguousarray(np.vstack([on.G_s, on.T_s])),
        gaps.gap0.astype(float),
        preload,
        bool(gaps.presses),
        bool(gaps.damping.any()),
        X,
        np.array([o for o, _, _ in columns], dtype=np.int64),
        np.array([j for _, j, _ in columns], dtype=np.int64),
        *(
            np.ascontiguousarray(A, dtype=float)
            for A in (sup.M_ss, terms.C_ss, sup.K_ss, terms.loads.support, terms.loads.force)
        ),
    )


def empty_state(model: ModalModel, loads: Loads) -> MarchState:
    """An instant at rest without supports' motion."""
    n, m, f2, n_s = model.m.size, model.gap0.size, model.rows.shape[0] - model.gap0.size, loads.support.shape[2]
    n_x = model.order.size
    return MarchState(
        np.zeros((3, n)),
        np.zeros(n),
        np.zeros(m + f2),
        np.zeros(m),
        np.zeros(m),
        np.zeros(f2),
        np.ones(f2 // 2, dtype=np.bool_),
        np.zeros((3, n_s)),
        np.zeros(n_x),
        np.zeros((2, n_x)),
        np.zeros(n_s),
        np.zeros(n_s),
        np.zeros(n_s),
        np.zeros(SIZE),
        np.zeros(1, dtype=np.bool_),
    )
