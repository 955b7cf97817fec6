"""Element matrices summed over pairs of nodes: one pattern of 6 x 6 blocks for all matrices of a part."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from creak.arrays import Csr, FloatArray, IntArray, Matrix
from creak.jit import njit
from creak.linalg.threads import cores, pool
from creak.model.dofs import PER_NODE


class NodeBlocks:
    """Pairs of nodes that an element joins, row by row of the matrix."""

    def __init__(self, elements: Sequence[IntArray], n_node: int) -> None:
        """`elements`: places (n, k) of the elements' nodes, one array a block, in a model of `n_node`."""
        self.n_node = n_node
        pattern = sp.csr_matrix((n_node, n_node), dtype=np.int32)
        for nodes in elements:
            n, k = nodes.shape
            belongs = sp.csr_matrix((np.ones(n * k, np.int32), nodes.ravel(), np.arange(n + 1) * k), (n, n_node))
            pattern = pattern + belongs.T @ belongs
        pattern.sort_indices()
        self._starts, self._columns = pattern.indptr.astype(np.int64), pattern.indices.astype(np.int64)

    def zeros(self) -> FloatArray:
        """(n_pair, 6, 6), nothing summed yet."""
        return np.zeros((self._columns.size, PER_NODE, PER_NODE))

    def add(self, total: FloatArray, nodes: IntArray, Ae: FloatArray, factor: float = 1.0) -> None:
        """Add `factor` times Ae (n, 6 k, 6 k) of elements with nodes (n, k) to `total`, in their order."""
        _add(self._starts, self._columns, total, np.ascontiguousarray(nodes), np.ascontiguousarray(Ae), factor)

    def matrix(self, total: FloatArray) -> Matrix:
        """The sum as a sparse matrix (6 n_node, 6 n_node) without stored zeros, by all cores."""
        n = PER_NODE * self.n_node
        indptr = np.zeros(n + 1, dtype=np.int64)
        share = np.searchsorted(self._starts, np.linspace(0, self._columns.size, cores() + 1)[1:-1])
        cuts = [0, *share.tolist(), self.n_node]
        list(pool().map(lambda a, b: _count(self._starts, total, indptr, a, b), cuts[:-1], cuts[1:]))
        np.cumsum(indptr, out=indptr)
        kind = np.int32 if indptr[-1] < np.iinfo(np.int32).max else np.int64
        indices, data = np.empty(indptr[-1], dtype=kind), np.empty(indptr[-1])
        blocks, rows = (self._starts, self._columns, total), (indptr, indices, data)
        list(pool().map(lambda a, b: _fill(blocks, rows, a, b), cuts[:-1], cuts[1:]))
        A = sp.csr_matrix((data, indices, indptr.astype(kind)), shape=(n, n))
        A.has_sorted_indices = A.has_canonical_format = True
        return A


@njit(nogil=True)
def _add(starts: IntArray, columns: IntArray, total: FloatArray, nodes: IntArray, Ae: FloatArray, c: float) -> None:
    k = nodes.shape[1]
    for e in range(nodes.shape[0]):
        for a in range(k):
            first, end = starts[nodes[e, a]], starts[nodes[e, a] + 1]
            for b in range(k):
                p = first + np.searchsorted(columns[first:end], nodes[e, b])
                for i in range(PER_NODE):
                    for j in range(PER_NODE):
                        total[p, i, j] += c * Ae[e, PER_NODE * a + i, PER_NODE * b + j]


@njit(nogil=True)
def _count(starts: IntArray, total: FloatArray, indptr: IntArray, start: int, stop: int) -> None:
    """Entries of the rows of nodes `start` to `stop` go to indptr, one place on."""
    for node in range(start, stop):
        for i in range(PER_NODE):
            found = 0
            for p in range(starts[node], starts[node + 1]):
                for j in range(PER_NODE):
                    if total[p, i, j] != 0.0:
                        found += 1
            indptr[PER_NODE * node + i + 1] = found


@njit(nogil=True)
def _fill(blocks: Csr, rows: Csr, start: int, stop: int) -> None:
    """Entries of the blocks that are not 0 go to the rows of nodes `start` to `stop`."""
    starts, columns, total = blocks
    indptr, indices, data = rows
    for node in range(start, stop):
        for i in range(PER_NODE):
            at = indptr[PER_NODE * node + i]
            for p in range(starts[node], starts[node + 1]):
                for j in range(PER_NODE):
                    if total[p, i, j] != 0.0:
                        indices[at], data[at] = PER_NODE * columns[p] + j, total[p, i, j]
                        at += 1
