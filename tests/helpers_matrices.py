"""Small superelements for tests of matrix files."""

from __future__ import annotations

import numpy as np

from creak.formats.matrices.checks import dense
from creak.model.superelement import Superelement


def random_superelement(seed: int = 0, damping: bool = True) -> Superelement:
    """Nodes 7 and 1203 with six dofs, three generalised coordinates, entries over 24 decades, some of them zero."""
    rng = np.random.default_rng(seed)

    def symmetric() -> np.ndarray:
        half = rng.standard_normal((15, 15)) * 10.0 ** rng.integers(-12, 12, (15, 15))
        half[rng.random((15, 15)) < 0.3] = 0.0
        return half + half.T

    nodes = np.concatenate([np.repeat([7, 1203], 6), np.zeros(3, int)])
    dofs = np.concatenate([np.tile(np.arange(1, 7), 2), np.zeros(3, int)])
    positions = {7: rng.standard_normal(3), 1203: 1e3 * rng.standard_normal(3)}
    K, M, C = symmetric(), symmetric(), symmetric() if damping else None
    return Superelement("part", nodes, dofs, K, M, C, positions)


def assert_same(got: Superelement, expected: Superelement) -> None:
    """Same rows, places and matrices, bit by bit."""
    np.testing.assert_array_equal(got.node_ids, expected.node_ids)
    np.testing.assert_array_equal(got.dofs, expected.dofs)
    assert got.positions.keys() == expected.positions.keys()
    for node, place in expected.positions.items():
        np.testing.assert_array_equal(got.positions[node], place)
    for key in "KM":
        np.testing.assert_array_equal(dense(getattr(got, key)), dense(getattr(expected, key)), err_msg=key)
    assert (got.C is None) == (expected.C is None)
    if expected.C is not None:
        np.testing.assert_array_equal(dense(got.C), dense(expected.C))
