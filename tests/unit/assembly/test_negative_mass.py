"""A point with a negative mass, as decks have that balance another one: refused where it is the larger of the two."""

from __future__ import annotations

import numpy as np
import pytest

from creak.errors import InputError
from helpers_core import assembled, block, model_of, point_mass, spring


def two_points(less: float):
    masses = [block("mass", [[0], [1]], point_mass(2.0)), block("mass", [[1]], point_mass(less), 0, 10)]
    links = [block("spring2", [[0, 1]], spring(1e3), 0, 20)]
    return model_of(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), [*masses, *links], [("A", [0, 1])])


def test_a_mass_below_zero_is_refused_with_its_node():
    with pytest.raises(
        InputError, match=r"the mass at node 2 [XYZ] is -1, with what is tied to it; expected zero or more"
    ):
        assembled(two_points(-3.0))


def test_one_that_only_lightens_another_is_taken():
    system = assembled(two_points(-0.5))
    assert sorted(set(np.round(system.M.diagonal(), 12).tolist()) - {0.0}) == [1.5, 2.0]
