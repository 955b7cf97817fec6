"""Play connectors as gap channels."""

from __future__ import annotations

import numpy as np
import pytest

from creak.contact.play import Play, crossed, play_channels
from creak.errors import InputError
from creak.model.contact_law import ContactLaw, Coulomb
from helpers_core import block, model_of, point_mass


def model():
    return model_of(
        np.zeros((4, 3)),
        [block("mass", [[0], [1], [2], [3]], point_mass(1.0))],
        node_sets={"A": [0, 1], "B": [2, 3], "ONE": [2]},
    )


def test_two_sided_play_between_two_nodes():
    """gap = upper - (u_B - u_A) and (u_B - u_A) - lower."""
    op = play_channels(model(), Play("hook", ("A", "B"), 2, -0.2, 0.3, ContactLaw(1e4, damping=5.0)), "[[connector]]")
    assert op.names == ("hook:upper:3", "hook:lower:3", "hook:upper:4", "hook:lower:4")
    np.testing.assert_array_equal(op.gap0, [0.3, 0.2, 0.3, 0.2])
    np.testing.assert_array_equal(op.stiffness, 1e4)
    np.testing.assert_array_equal(op.damping, 5.0)
    u = np.zeros(24)
    u[6 * 2 + 1], u[1] = 0.5, 0.1
    np.testing.assert_allclose(op.gap0 + op.G @ u[op.labels], [0.3 - 0.4, 0.4 + 0.2, 0.3, 0.2])


def test_one_set_is_stopped_against_ground():
    op = play_channels(model(), Play("stop", ("ONE",), 1, None, 0.1, ContactLaw(1e4)), "")
    assert op.m == 1
    assert op.names == ("stop:upper",)
    np.testing.assert_array_equal(op.labels, [12])
    np.testing.assert_array_equal(op.G.toarray(), [[-1.0]])


def test_rotational_play_uses_its_own_dof():
    op = play_channels(model(), Play("stop", ("ONE",), 5, -0.01, None, ContactLaw(1e2)), "")
    np.testing.assert_array_equal(op.labels, [6 * 2 + 4])
    np.testing.assert_array_equal(op.gap0, [0.01])


def test_a_stop_with_friction_rubs_across_its_direction():
    """The tangents are the relative motion across (1, 0, 1), the same on both sides of the play."""
    law = ContactLaw(1e4, friction=Coulomb(0.3, 0.2))
    n = np.array([1.0, 0.0, 1.0]) / np.sqrt(2.0)
    op = play_channels(model(), Play("hook", ("A", "B"), 1, -0.2, 0.3, law, tuple(n)), "")
    u = np.zeros((4, 6))
    u[2, :3], u[0, :3] = [0.5, 0.2, -0.1], [0.1, 0.0, 0.1]
    slip = np.stack([t @ u.ravel()[op.labels] for t in op.tangents], axis=1)
    moved = u[2, :3] - u[0, :3]
    np.testing.assert_allclose(np.linalg.norm(slip[:2], axis=1), np.linalg.norm(moved - (moved @ n) * n))
    np.testing.assert_array_equal(slip[0], slip[1])
    np.testing.assert_allclose(op.G[:2] @ u.ravel()[op.labels], [-moved @ n, moved @ n])
    assert op.rubbing == 4


@pytest.mark.parametrize(
    ("play", "message"),
    [
        (Play("p", ("A", "ONE"), 1, -1.0, 1.0, ContactLaw(1.0)), "have 2 and 1 nodes"),
        (Play("p", ("A",), 1, None, None, ContactLaw(1.0)), "without limits"),
        (Play("p", ("A",), 1, 1.0, -1.0, ContactLaw(1.0)), r"lower = 1.0 lies above upper = -1.0"),
        (Play("p", ("A",), 1, -1.0, 1.0, ContactLaw(1.0, preload=5.0)), "preload and two limits"),
        (Play("p", ("A",), 1, -1.0, None, ContactLaw(np.inf, damping=5.0)), "damping = 5 beside hard contact"),
        (Play("p", ("A",), 1, None, 0.3, ContactLaw(1.0, preload=5.0)), "limit at 0.3; expected 0"),
        (Play("p", ("AA",), 1, -1.0, 1.0, ContactLaw(1.0)), r"unknown node set 'AA'.*'A'"),
    ],
)
def test_wrong_play_is_refused(play, message):
    with pytest.raises(InputError, match=message):
        play_channels(model(), play, "study.toml:12 [connector]")


@pytest.mark.parametrize(("lower", "upper"), [(None, 0.0), (0.0, None)])
def test_a_preloaded_stop_presses_at_rest_and_lets_go_when_its_spring_is_relieved(lower, upper):
    """p = -k g is the preload at u = 0 and zero once the nodes have parted by preload / k."""
    op = play_channels(model(), Play("bumper", ("ONE",), 3, lower, upper, ContactLaw(200.0, preload=30.0)), "")
    np.testing.assert_array_equal(op.preload, [30.0])
    np.testing.assert_allclose(-op.stiffness * op.gap0, 30.0, rtol=1e-14)
    away = -op.G.toarray()[0] * op.gap0[0]  # opens the gap by what it is squeezed
    np.testing.assert_allclose(op.gap0 + op.G @ away, 0.0, atol=1e-15)


def test_no_preload_is_no_array():
    assert play_channels(model(), Play("p", ("ONE",), 1, None, 0.1, ContactLaw(1e4)), "").preload is None


def test_nodes_joined_to_far_ones_are_told():
    """Sets whose orders run against each other; in the same order, and on a fine row across a wide gap, nothing is."""
    x = np.array([0.0, 10.0, 20.0])
    row = np.column_stack([x, 0.0 * x, 0.0 * x])
    masses = [block("mass", np.arange(6)[:, None], point_mass(1.0))]
    for lies, order, told in ((5.0, [5, 4, 3], True), (5.0, [3, 4, 5], False), (40.0, [4, 5, 3], False)):
        coords = np.vstack([row, row + [0.0, lies, 0.0]])
        parts = model_of(coords, masses, node_sets={"A": [0, 1, 2], "B": order})
        said = crossed(parts, Play("hook", ("A", "B"), 2, -0.2, None, ContactLaw(1e4)), "[[connector]]", "mm")
        assert bool(said) == told
        if told:
            assert "node 1 of 'A' to 6 of 'B', 20.62 mm away, though 4 lies 5 mm away" in said[0]
