"""Element matrices summed piece by piece: the same matrix whatever the size of the pieces, little memory, all faults."""

from __future__ import annotations

import tracemalloc
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from creak.assembly import node_blocks, part
from creak.assembly.node_blocks import NodeBlocks
from creak.assembly.part import assemble_blocks
from creak.elements.block_matrices import block_matrices
from creak.errors import InputError
from creak.linalg import threads
from creak.model.dofs import node_dofs
from creak.model.mesh import Model
from helpers_core import NO_DAMPING, block, model_of, plate, shell


def folded(across: int) -> Model:
    """A folded square of `across` x `across` quadrilaterals."""
    coords, quads = plate(across, across)
    coords[:, 2] = 0.1 * np.abs(coords[:, 0] - 0.5)
    return model_of(coords, [block("quad4", quads, shell(0.001))], [("PLATE", range(coords.shape[0]))])


def labels(model: Model) -> np.ndarray:
    return node_dofs(np.arange(model.nodes.count))


def test_sums_are_those_of_dense_matrices(monkeypatch):
    model = folded(4)
    monkeypatch.setattr(part, "CHUNK", 5 * 24**2)  # five elements at a time, sixteen in all
    found = assemble_blocks(model, model.blocks, labels(model), NO_DAMPING, override=True)
    K, M, _ = block_matrices(model.blocks[0], slice(None), model.nodes.coords)
    for A, Ae in ((found.K, K), (found.M, M)):
        dense = np.zeros(A.shape)
        for nodes, matrix in zip(model.blocks[0].nodes_idx, Ae, strict=True):
            dofs = node_dofs(nodes)
            dense[np.ix_(dofs, dofs)] += matrix
        np.testing.assert_allclose(A.toarray(), dense, rtol=0, atol=1e-15 * np.abs(dense).max())
        assert A.nnz == np.count_nonzero(dense)
        assert A.has_canonical_format
        assert (A != A.T).nnz == 0


def test_an_element_that_names_a_node_twice_and_nodes_without_elements():
    nodes = np.array([[2, 2], [2, 0]])
    Ae = np.arange(288.0).reshape(2, 12, 12)
    pattern = NodeBlocks([nodes], 4)
    total = pattern.zeros()
    pattern.add(total, nodes, Ae, -2.0)
    dense = np.zeros((24, 24))
    for row, matrix in zip(nodes, Ae, strict=True):
        for a in range(2):
            for b in range(2):
                i, j = 6 * row[a], 6 * row[b]
                dense[i : i + 6, j : j + 6] -= 2.0 * matrix[6 * a : 6 * a + 6, 6 * b : 6 * b + 6]
    np.testing.assert_array_equal(pattern.matrix(total).toarray(), dense)


def test_the_same_to_the_last_bit_on_any_number_of_cores(monkeypatch):
    model = folded(12)
    monkeypatch.setattr(part, "CHUNK", 7 * 24**2)
    found = []
    for cores in (1, 3):
        on_cores(monkeypatch, cores)
        found.append(assemble_blocks(model, model.blocks, labels(model), NO_DAMPING, override=True))
    for one, three in zip((found[0].K, found[0].M), (found[1].K, found[1].M), strict=True):
        for name in ("data", "indices", "indptr"):
            np.testing.assert_array_equal(getattr(one, name), getattr(three, name))


def on_cores(monkeypatch, count: int) -> None:
    pool = ThreadPoolExecutor(count)
    for module in (threads, node_blocks):
        monkeypatch.setattr(module, "cores", lambda: count)
        monkeypatch.setattr(module, "pool", lambda: pool)


def test_memory_does_not_hold_all_element_matrices(monkeypatch):
    """3,600 quadrilaterals: 19 MB of summed blocks; some 35 MB of scratch and pieces, however many elements there are.

    All of them at once are 33 MB besides.
    """
    on_cores(monkeypatch, 2)
    model = folded(60)
    every = labels(model)
    tracemalloc.start()
    assemble_blocks(model, model.blocks, every, NO_DAMPING, override=True)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 60e6


def test_every_bad_element_is_counted_whatever_the_pieces(monkeypatch):
    model = folded(6)
    coords = model.nodes.coords.copy()
    coords[:14] = 0.0  # the first two rows of nodes fall together: six quadrilaterals without area
    broken = model_of(coords, model.blocks, [("PLATE", range(coords.shape[0]))])
    monkeypatch.setattr(part, "CHUNK", 2 * 24**2)
    with pytest.raises(InputError, match=r"elements 1, 2, 3, 4, 5 and 1 more"):
        assemble_blocks(broken, broken.blocks, labels(broken), NO_DAMPING, override=True)
