"""A factor of the stiffness of what may move freely: with as much mass as it takes."""

from __future__ import annotations

import numpy as np
import pytest

from creak.linalg.factor import SingularMatrixError
from creak.studies.models.reference import held_factor
from helpers_core import system_of


@pytest.mark.parametrize("sparse", [True, False])
def test_a_body_whose_stiffness_is_round_off_has_a_factor(sparse):
    """Links make it rigid: what is left of K is of either sign, and larger than a trace of mass."""
    M = np.diag([2.0, 2.0, 2.0, 0.1])
    K = 1e-9 * np.array([[1.0, 0.3, 0.0, 0.0], [0.3, -0.5, 0.1, 0.0], [0.0, 0.1, 2.0, 0.2], [0.0, 0.0, 0.2, -0.1]])
    found = held_factor(system_of(M, K, sparse=sparse))
    assert np.isfinite(found.solve(np.ones(4))).all()


def test_motion_without_stiffness_and_mass_has_none():
    with pytest.raises(SingularMatrixError, match="row 1"):
        held_factor(system_of(np.diag([1.0, 0.0]), np.diag([1.0, 0.0]), sparse=False))
