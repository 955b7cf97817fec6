"""Systems from matrices, joined, held and driven without a deck."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from creak.arrays import FloatArray, IntArray, Matrix, to_dense
from creak.assembly import coupling
from creak.assembly.damping import Damping
from creak.assembly.part import Rayleigh
from creak.assembly.system import System, no_supports
from creak.errors import InputError
from creak.given import array_of, number, of_kind, pairs_of, positive, table_of, whole
from creak.linalg import modes as linalg_modes
from creak.linalg.factor import regular_factor
from creak.linalg.modes import Modes
from creak.linalg.pencil import require_positive
from creak.model.constraints import Equation, Fixed
from creak.model.dofs import PER_NODE, dof_labels, dofs_of, node_and_dof, nodes_of
from creak.model.mesh import Model, Nodes

SYMMETRIC = 1e-8
"""Largest |A_ij - A_ji| over the largest |A_ij| of a matrix that counts as symmetric."""
DEFAULT_COUNT = 20
Rename = Callable[[IntArray], IntArray]
"""Labels of dofs -> other labels, in the same order."""


A_SYSTEM = "a System: creak.system_from_matrices(K, M) makes one"


def modes(K: Any, M: Any, *, count: int | None = None, f_max: float | None = None) -> Modes:
    """Undamped modes K x = omega^2 M x of symmetric matrices, held or free.

    Parameters
    ----------
    K, M : (n, n) SciPy sparse or dense, positive semidefinite; M may be singular where K is not.
    count : the lowest modes (default 20). f_max : all modes up to this frequency, Hz, if K and M are in consistent
        units with the second.

    Returns
    -------
    Modes: `frequencies` (Hz), `omega2` (rad^2/s^2, 0 for rigid-body modes), `shapes` (n, n_mode) with
    shapes' M shapes = I, and the checks `residual` and `sturm_ok`.

    Raises
    ------
    InputError : both count and f_max, one of them no positive number, or matrices that are not square, real, symmetric,
        finite, positive or of one size.
    NumericalError : a dof has neither mass nor stiffness, or a mode was missed.

    Method: shift-invert block Lanczos with a Sturm count; dense up to 600 dofs.
    """
    if count is not None and f_max is not None:
        raise InputError("both count and f_max", expected="one of them")
    if f_max is not None:
        f_max = positive(f_max, "f_max")
    count = DEFAULT_COUNT if count is None else whole(count, "count", 1)
    K, M = symmetric_matrix(K, "K"), symmetric_matrix(M, "M")
    _same_size(K, M, "M")
    wanted = min(count, K.shape[0]) if f_max is None else None
    factor = regular_factor(K)
    found = linalg_modes.modes(K, M, f_max=f_max, count=wanted, free=factor is None, stiffness_factor=factor)
    require_positive("K", K, found.shapes[:, found.omega2 < 0.0])
    return found


def system_from_matrices(
    K: Any,
    M: Any,
    C: Any = None,
    *,
    labels: ArrayLike | None = None,
    alpha: float = 0.0,
    beta: float = 0.0,
    velocity: ArrayLike | None = None,
    name: str = "model",
) -> System:
    """M q'' + (C + alpha M + beta K) q' + K q = f as a System, the form that all steps of creak take.

    Parameters
    ----------
    K, M, C : (n, n) symmetric, SciPy sparse or dense, both triangles stored; C beside Rayleigh damping, or None.
    labels : (n,) integers that name the dofs, each once; default 0 to n - 1. Dofs of several Systems with one label
        are one when they are joined (`couple`). With nodes, 6 node + dof - 1 (dof 1 to 6) is creak's own choice.
    alpha, beta : Rayleigh damping, 1/s and s.
    velocity : (n,) initial velocity; the System starts from q = 0.

    Returns
    -------
    System; any consistent units.

    Raises
    ------
    InputError : matrices that are not square, real, symmetric, finite or of one size; wrong labels; negative alpha or
        beta.
    """
    K, M = symmetric_matrix(K, "K"), symmetric_matrix(M, "M")
    _same_size(K, M, "M")
    if C is not None:
        C = symmetric_matrix(C, "C")
        _same_size(K, C, "C")
    alpha, beta = number(alpha, "alpha"), number(beta, "beta")
    if not (0.0 <= alpha < np.inf and 0.0 <= beta < np.inf):
        raise InputError(f"alpha = {alpha}, beta = {beta}", expected="Rayleigh numbers of zero or more")
    n = K.shape[0]
    own = np.arange(n, dtype=np.int64) if labels is None else _checked_labels(labels, n)
    start = np.zeros(n) if velocity is None else table_of(velocity, "velocity")
    if start.shape != (n,) or not np.isfinite(start).all():
        raise InputError(f"velocity of shape {start.shape}", expected=f"({n},) finite numbers")
    order = np.argsort(own)
    known = own[order]
    rows = partial(_rows, order, known)
    return System(name, M, K, Damping(alpha, beta, C), rows, no_supports(n), own, start, labels=known)


def couple(
    *systems: System,
    fixed: ArrayLike = (),
    driven: Mapping[str, ArrayLike] | None = None,
    equations: Iterable[tuple[ArrayLike, ArrayLike]] = (),
) -> System:
    """Join Systems at the labels they share, hold dofs, prescribe motion: one System.

    u_all = T q + T_s s(t), M = T' blkdiag(M_k) T and K, C alike (primal assembly: Klerk, Rixen, Voormeeren, AIAA J.
    46, 2008). Full and reduced Systems are joined alike.

    Parameters
    ----------
    fixed : labels that stay at zero.
    driven : name -> labels that follow the prescribed motion of that name; `make_loads` gives it.
    equations : (labels, coefficients) each: sum of coefficient times motion = 0; the first label is eliminated.

    Returns
    -------
    System in the dofs that stay free; the motion of every label can still be asked for. Its initial velocity has the
    momentum of those of the Systems, T' M T q' = T' M v, which is theirs where they fit together.

    Raises
    ------
    InputError : a label that no System has; a dof both held and driven; a System that is driven already.
    """
    if not systems:
        raise InputError("no System to couple", expected="one or more")
    for other in (s for s in systems if not isinstance(s, System)):
        raise InputError(
            f"a {type(other).__name__} to couple",
            expected="Systems, as creak.system_from_matrices and creak.craig_bampton make them",
            fix="Give its parts one by one, or run a study of the deck.",
        )
    if any(s.supports.count or s.damping.modal_shapes is not None for s in systems):
        raise InputError(
            "a System with prescribed motion or modal damping is joined",
            expected="free Systems",
            fix="Couple first, then drive.",
        )
    known = np.unique(np.concatenate([s.labels for s in systems]))
    held = known_labels(fixed, known, "fixed")
    driven = {} if driven is None else driven
    of_kind(driven, Mapping, "driven", 'a mapping, as {"base": [6]}')
    ends = {str(name): known_labels(x, known, f"driven {name!r}") for name, x in driven.items()}
    numbers = _Numbered(known)
    rows = [_equation(x, c, known, numbers) for x, c in pairs_of(equations, "equations", "(labels, coefficients)")]
    model = Model(
        source="couple",
        nodes=numbers.nodes,
        blocks=(),
        parts=(),
        node_sets={},
        element_sets={},
        surfaces={},
        constraints=tuple(rows),
        fixed=tuple(Fixed(np.array([node]), (dof,)) for node, dof in map(node_and_dof, numbers.rows(held))),
    )
    common = Rayleigh(systems[0].damping.alpha, systems[0].damping.beta)
    own = [numbers.numbered(_with_common(s, common)) for s in systems]
    driving = coupling.Driven({name: numbers.rows(labels) for name, labels in ends.items()})
    return numbers.labelled(coupling.couple(own, model, driving, common))


# --- checks ---------------------------------------------------------------------------------------------------------


def symmetric_matrix(A: Any, name: str) -> Matrix:
    """A as CSR matrix of floats.

    Raises
    ------
    InputError : no matrix, not square, complex, not finite, not symmetric, or with a negative diagonal entry.
    """
    B = _real(A, name)
    if B.ndim != 2 or B.shape[0] != B.shape[1] or B.shape[0] == 0:
        raise InputError(f"{name} is {B.shape}", expected="a square matrix")
    if not np.isfinite(B.data).all():
        raise InputError(f"{name} has entries that are not finite", expected="numbers")
    largest = float(np.abs(B.data).max(initial=0.0))
    if float(abs(B - B.T).max()) > SYMMETRIC * largest:
        raise InputError(
            f"{name} is not symmetric",
            expected="both triangles stored",
            fix=f"Of one triangle: {name} + {name}.T - diag({name}).",
        )
    if float(B.diagonal().min()) < -SYMMETRIC * largest:
        raise InputError(f"{name} has a negative diagonal entry", expected="a positive semidefinite matrix")
    return B


def _real(A: Any, name: str) -> Matrix:
    """A as CSR matrix of floats: nothing is dropped."""
    try:
        A = A if sp.issparse(A) else to_dense(A)
        if A.dtype.kind == "O":
            raise TypeError("it holds objects")
        B = sp.csr_matrix(A, dtype=np.complex128 if np.iscomplexobj(A) else np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} is no matrix: {error}", expected="a SciPy sparse or dense matrix") from error
    if not np.iscomplexobj(A):
        return B
    if np.any(B.data.imag != 0.0):
        raise InputError(
            f"{name} is complex: imaginary parts up to {np.abs(B.data.imag).max():g}",
            expected="a real matrix",
            fix="Leave them out: damping is given as C, or as alpha and beta, to creak.system_from_matrices.",
        )
    return B.real


def known_labels(labels: ArrayLike, known: IntArray, what: str) -> IntArray:
    """Labels as integers.

    Parameters
    ----------
    known : sorted labels that there are. what : for the message.

    Raises
    ------
    InputError : a label that is not among them.
    """
    found = np.atleast_1d(array_of(labels))
    if found.size and not np.issubdtype(found.dtype, np.integer):
        raise InputError(f"{what}: labels of type {found.dtype}", expected="integers")
    found = found.ravel().astype(np.int64)
    missing = np.setdiff1d(found, known)
    if missing.size:
        span = f"{known.size} labels from {known[0]} to {known[-1]}" if known.size else "none"
        raise InputError(f"{what}: there is no dof {missing[0]}", expected=f"labels of the System ({span})")
    return found


def _same_size(K: Matrix, A: Matrix, name: str) -> None:
    if A.shape != K.shape:
        raise InputError(f"K is {K.shape} and {name} is {A.shape}", expected="matrices of one size")


def _checked_labels(labels: ArrayLike, n: int) -> IntArray:
    found = array_of(labels)
    if found.shape != (n,) or not np.issubdtype(found.dtype, np.integer):
        raise InputError(f"labels of shape {found.shape}, {found.dtype}", expected=f"({n},) integers")
    if np.unique(found).size != n or found.min() < 0:
        raise InputError("labels that repeat or are negative", expected="each dof with a label of its own, from 0 on")
    return found.astype(np.int64)


# --- parts of the Systems -------------------------------------------------------------------------------------------


def _rows(order: IntArray, known: IntArray, labels: IntArray) -> tuple[Matrix, FloatArray]:
    """`System.rows` of a System with the labels `known`, sorted by `order`; no closure, so that it can be pickled."""
    columns = order[np.searchsorted(known, known_labels(labels, known, "motion"))]
    shape = (columns.size, known.size)
    pick = sp.csr_matrix((np.ones(columns.size), (np.arange(columns.size), columns)), shape=shape)
    return pick, np.zeros((columns.size, 0))


class _Numbered:
    """The labels of dofs, numbered anew without gaps between the nodes: 6 row + dof - 1. Their order stays."""

    def __init__(self, known: IntArray) -> None:
        self._nodes = np.unique(nodes_of(known))

    @property
    def nodes(self) -> Nodes:
        return Nodes(self._nodes, np.zeros((self._nodes.size, 3)))

    def rows(self, labels: IntArray) -> IntArray:
        """The new numbers of labels; of those that are not known, one that no System has."""
        plain = np.where(labels < 0, ~labels, labels)
        at = np.searchsorted(self._nodes, nodes_of(plain))
        there = self._nodes[np.minimum(at, self._nodes.size - 1)] == nodes_of(plain)
        new = np.where(there, _moved_to(at, plain), PER_NODE * self._nodes.size)
        return np.asarray(np.where(labels < 0, ~new, new), dtype=np.int64)

    def labels(self, rows: IntArray) -> IntArray:
        """The labels of new numbers."""
        plain = np.where(rows < 0, ~rows, rows)
        old = _moved_to(self._nodes[nodes_of(plain)], plain)
        return np.asarray(np.where(rows < 0, ~old, old), dtype=np.int64)

    def numbered(self, system: System) -> System:
        """The System with the new numbers for labels."""
        return _renamed(system, self.rows, self.labels)

    def labelled(self, system: System) -> System:
        """The System with labels for the new numbers."""
        return _renamed(system, self.labels, self.rows)


def _moved_to(nodes: IntArray, labels: IntArray) -> IntArray:
    """The dofs of `labels` at other nodes."""
    return np.asarray(dof_labels(nodes, dofs_of(labels)), dtype=np.int64)


def _renamed(system: System, new: Rename, old: Rename) -> System:
    combine, bear = system.combine, system.bear
    at = system.coordinates
    return replace(
        system,
        rows=lambda x: system.rows(old(x)),
        combine=None if combine is None else lambda A, x: combine(A, old(x)),
        bear=None if bear is None else lambda x: bear(old(x)),
        coordinates=np.where(at < 0, at, new(np.maximum(at, system.labels[0]))),
        labels=new(system.labels),
        interface=None if system.interface is None else new(system.interface),
    )


def _equation(labels: ArrayLike, coefficients: ArrayLike, known: IntArray, numbers: _Numbered) -> Equation:
    found, values = known_labels(labels, known, "equations"), table_of(coefficients, "coefficients").ravel()
    if found.size != values.size or not found.size or values[0] == 0.0:
        raise InputError(
            f"an equation with {found.size} labels and coefficients {values.tolist()}",
            expected="as many of each, the first coefficient not zero",
        )
    rows = numbers.rows(found)
    return Equation(nodes_of(rows), dofs_of(rows), values)


def _with_common(system: System, common: Rayleigh) -> System:
    """The System with the common Rayleigh numbers, the difference to its own as a matrix."""
    d = system.damping
    da, db = d.alpha - common.alpha, d.beta - common.beta
    if da == 0.0 and db == 0.0:
        return system
    extra = da * system.M + db * system.K
    return replace(system, damping=Damping(common.alpha, common.beta, extra if d.extra is None else d.extra + extra))


def rows_over(A: Any, labels: Sequence[int] | IntArray, what: str) -> Matrix:
    """Rows (m, len(labels)) as CSR matrix.

    Raises
    ------
    InputError : another number of columns, complex entries, or entries that are not finite.
    """
    B = _real(A if sp.issparse(A) else np.atleast_2d(array_of(A)), what)
    if B.shape[1] != len(labels) or not np.isfinite(B.data).all():
        raise InputError(f"{what} is {B.shape}", expected=f"(m, {len(labels)}) finite numbers, a column for each label")
    return B
