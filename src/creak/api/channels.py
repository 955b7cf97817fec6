"""Gap channels from rows of a matrix."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from creak.api.matrices import rows_over
from creak.arrays import FloatArray, IntArray
from creak.contact.gap_operator import ChannelRows, GapOperator, join
from creak.contact.laws.parameters import Friction
from creak.errors import InputError, shortened
from creak.given import array_of, number, of_kind, table_of, texts
from creak.model.dofs import nodes_of

TANGENTS = "a list of one or two: tangents=[T]"


def gap_channels(
    G: Any,
    gap0: ArrayLike,
    stiffness: ArrayLike,
    *,
    labels: ArrayLike | None = None,
    damping: ArrayLike = 0.0,
    preload: ArrayLike = 0.0,
    tangents: Sequence[Any] = (),
    friction: float | Sequence[float] = 0.0,
    names: Sequence[str] | None = None,
    group: str = "contact",
) -> GapOperator:
    """m scalar contacts g = gap0 + G u: open for g > 0; for g < 0 the force p = -stiffness g - damping g' >= 0 acts.

    The force on the structure is G' p, and T' tau along the tangents w = T u of channels that rub, with
    |tau| <= mu p, mu(v) = kinetic + (static - kinetic) exp(-v / decay).

    Parameters
    ----------
    G : (m, n) SciPy sparse or dense: a row for each channel, +1 on what moves away and -1 on what it moves from.
    gap0 : clearance at u = 0, length; one number or (m,).
    stiffness : penalty, force / length; one number or (m,). inf: no penetration at all; 0: watched only.
    labels : (n,) dof labels of the columns of G; default 0 to n - 1.
    damping : force time / length, acts while closed.
    preload : force with which a channel presses at rest, which the rest of the structure balances; gap0 must be 0.
    tangents : a list of one or two matrices like G, the sliding of each channel.
    friction : coefficient, or (static, kinetic), or (static, kinetic, decay speed).
    names : m channel names. group : what the channels belong to: contact in a group counts as one event.

    Returns
    -------
    GapOperator; several are joined by `join_gaps`.

    Raises
    ------
    InputError : shapes that do not fit, negative stiffness, damping, preload or friction, friction without tangents,
        tangents that are no list.
    """
    of_kind(tangents, (Sequence, np.ndarray, sp.sparray, sp.spmatrix), "tangents", TANGENTS)
    n = G.shape[-1] if sp.issparse(G) else (0, *array_of(G).shape)[-1]
    if not n:
        raise InputError(f"G = {shortened(repr(G))}", expected="a matrix with a row for each channel")
    own = np.arange(n, dtype=np.int64) if labels is None else array_of(labels)
    if own.shape != (n,) or not np.issubdtype(own.dtype, np.integer) or np.unique(own).size != n or own.min() < 0:
        raise InputError(f"labels of shape {own.shape}, {own.dtype}", expected=f"({n},) integers, each once")
    A = rows_over(G, own, "G")
    m = A.shape[0]
    k, c, P = _each(stiffness, m, "stiffness"), _each(damping, m, "damping"), _each(preload, m, "preload")
    gap = _each(gap0, m, "gap0", any_sign=True)
    _check_preload(gap, P, k)
    sliding = _tangents(tangents, own, m)
    return GapOperator(
        **_triplets([A, *sliding], own).motion(m),
        gap0=gap - np.divide(P, k, out=np.zeros(m), where=P > 0.0),
        stiffness=k,
        damping=c,
        step_limited=np.zeros(m, dtype=np.bool_),
        area=np.zeros(m),
        names=tuple(_names(names, group, m)),
        nodes_idx=_nodes(A, own),
        group=(group,) * m,
        friction=_friction(friction, m, bool(len(tangents))),
        preload=P if P.any() else None,
    )


def join_gaps(*gaps: GapOperator) -> GapOperator:
    """All channels of several operators as one."""
    for one in gaps:
        of_kind(one, GapOperator, "one of the gaps", "channels of creak.gap_channels")
    return join(gaps)


def _each(x: ArrayLike, m: int, name: str, any_sign: bool = False) -> FloatArray:
    values = table_of(x, name)
    if values.shape not in ((), (1,), (m,)):
        raise InputError(f"{name} has shape {values.shape}", expected=f"a number, or ({m},): one for each channel")
    if name in ("damping", "preload") and not np.isfinite(values).all():
        raise InputError(f"{name} = {values.max()}", expected="a finite number")
    if np.isnan(values).any() or (not any_sign and (values < 0.0).any()):
        raise InputError(f"{name} = {values.min()}", expected="a number" if any_sign else "zero or more")
    return np.broadcast_to(values, (m,)).copy()


def _check_preload(gap: FloatArray, preload: FloatArray, stiffness: FloatArray) -> None:
    pressed = preload > 0.0
    if (pressed & (gap != 0.0)).any() or (pressed & ~((stiffness > 0.0) & np.isfinite(stiffness))).any():
        raise InputError(
            "a preloaded channel with a clearance, or without a finite stiffness",
            expected="gap0 = 0 and a stiffness",
            fix="With a preload the channel is closed at rest; it opens once it has moved by preload / stiffness.",
        )


def _tangents(tangents: Any, labels: IntArray, m: int) -> list[Any]:
    if sp.issparse(tangents) or (isinstance(tangents, np.ndarray) and tangents.ndim != 3):
        raise InputError(f"tangents is a matrix of shape {tangents.shape}", expected=TANGENTS)
    if len(tangents) > 2:
        raise InputError(f"{len(tangents)} tangents", expected="one or two")
    found = [rows_over(T, labels, "a tangent") for T in tangents]
    if any(T.shape[0] != m for T in found):
        raise InputError("a tangent with another number of rows than G", expected=f"{m} rows")
    return found + [sp.csr_matrix((m, labels.size))] * (2 - len(found))


def _triplets(matrices: Sequence[Any], labels: IntArray) -> ChannelRows:
    """Entries of G and both tangents side by side."""
    pieces = [A.tocoo() for A in matrices]
    size = [A.data.size for A in pieces]
    values = [
        np.concatenate([A.data if i == j else np.zeros(s) for j, s in enumerate(size)]) for i, A in enumerate(pieces)
    ]
    channel = np.concatenate([A.row for A in pieces]).astype(np.int64)
    column = np.concatenate([A.col for A in pieces]).astype(np.int64)
    return ChannelRows(channel, labels[column].astype(np.int64), *values)


def _names(names: Sequence[str] | None, group: str, m: int) -> tuple[str, ...]:
    if names is None:
        return tuple(f"{group}:{j}" for j in range(m))
    told = texts(names, "names")
    if len(told) != m:
        raise InputError(f"{len(told)} names", expected=f"{m}, one for each channel")
    return tuple(map(str, told))


def _nodes(A: Any, labels: IntArray) -> IntArray:
    """Node of the largest entry of each row."""
    largest = [int(np.argmax(np.abs(A[[i]].toarray()[0]))) for i in range(A.shape[0])]
    return nodes_of(labels[largest])


def _friction(friction: Any, m: int, tangents: bool) -> Friction | None:
    told = list(friction) if array_of(friction).ndim else [friction] * 2
    if len(told) not in (2, 3):
        raise InputError(
            f"friction of {len(told)} numbers", expected="one, (static, kinetic) or (static, kinetic, decay speed)"
        )
    found = Friction(*(np.full(m, number(x, "friction")) for x in (*told, 0.0)[:3]))
    if not found.static.any():
        return None
    if not tangents:
        raise InputError(f"friction = {friction} without tangents", fix="Give tangents=[T]: w = T u is the sliding.")
    return found
