"""Plate frequencies against converged Ritz values (NAFEMS FV12, FV16, FV32) and exact Mindlin values.

A bending wave of number k on elements of length h is off by (kh)^2/24: 0.5 % for the seventh mode on 20 x 20.
"""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks_shell import cantilever_plate, free_plate, tapered_membrane, thick_plate

kinds = pytest.mark.parametrize("kind", ["quad", "tri"])


@kinds
def test_free_square_plate_within_one_percent(kind):
    assert free_plate(20, kind) == pytest.approx(np.ones(8), abs=0.01)


@kinds
def test_cantilevered_square_plate_within_one_percent(kind):
    assert cantilever_plate(20, kind) == pytest.approx(np.ones(6), abs=0.01)


@kinds
def test_thick_plate_matches_mindlin_theory_within_one_percent(kind):
    assert thick_plate(20, kind) == pytest.approx(np.ones(4), abs=0.01)


@pytest.mark.parametrize(("kind", "limit"), [("quad", 0.01), ("tri", 0.02)])
def test_tapered_membrane_converges_with_the_square_of_element_size(kind, limit):
    """Consistent membrane mass overestimates by (kh)^2/24 and more on coarse meshes."""
    coarse, fine = tapered_membrane(16, 8, kind) - 1, tapered_membrane(32, 16, kind) - 1
    assert np.abs(fine).max() < limit
    assert np.abs(fine[-3:]).max() < 0.4 * np.abs(coarse[-3:]).max()
