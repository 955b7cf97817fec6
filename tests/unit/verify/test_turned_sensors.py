"""Sensors that lie otherwise than the file of a test says are found, and named; of right ones nothing is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.verify.turned_sensors import TURNS, Channels, find_turned

AXES = np.eye(3)
TURNED = {
    "x reversed": np.diag([-1, 1, 1]),
    "x and y exchanged": np.array([[0, 1, 0], [1, 0, 0], [0, 0, 1]]),
    "all axes": np.array([[0, 0, -1], [1, 0, 0], [0, 1, 0]]),
}


def waves(seed=0, sensors=20, modes=8, noise=0.02, axes=AXES):
    """Plane waves in a box as modes of a model, and a test of them with sensors along some axes, 3 % too high."""
    rng = np.random.default_rng(seed)
    x = rng.random((sensors, 3)) * [3.0, 2.0, 1.0]
    motion = np.sin(x @ rng.normal(size=(modes, 3, 3)) * 2.0 + 6.0 * rng.random((modes, 1, 3)))
    motion = (motion * rng.normal(size=(modes, 1, 3))).transpose(1, 2, 0)
    freq = 100.0 * np.cumsum(0.3 + rng.random(modes))
    at = np.repeat(np.arange(sensors), len(axes))
    directions, motion = np.tile(axes, (sensors, 1)), motion[at]
    test = np.einsum("ci,cim->cm", directions, motion)
    test = test + noise * np.abs(test).max() * rng.normal(size=test.shape)
    return Channels(test, motion, directions, tuple(f"S{k}" for k in at), 1.03 * freq, freq)


def rows(c, sensor):
    return [k for k, name in enumerate(c.sensors) if name == sensor]


@pytest.mark.parametrize("axes", [AXES, AXES[2:]], ids=["triaxial", "z alone"])
def test_nothing_is_said_of_right_sensors_nor_of_another_structure(axes):
    for seed in range(20):
        right = waves(seed, sensors=8, modes=4, noise=0.1, axes=axes)
        assert find_turned(right) is None
        other = np.random.default_rng(seed).normal(size=right.test.shape)
        assert find_turned(replace(right, test=other)) is None


@pytest.mark.parametrize("turn", TURNED.values(), ids=TURNED)
def test_axes_of_all_sensors(turn):
    c = waves()
    found = find_turned(replace(c, test=np.einsum("ci,cim->cm", c.directions @ turn.T, c.motion)))
    assert np.array_equal(found.axes, turn) or np.array_equal(found.axes, -turn)
    assert found.after == pytest.approx(1.0)
    assert found.before < 0.6
    assert (found.reversed, found.turned, found.exchanged) == ((), {}, ())


@pytest.mark.parametrize("axes", [AXES, AXES[2:]], ids=["triaxial", "z alone"])
def test_reversed_channels(axes):
    c, lost = waves(axes=axes, noise=0.005), (1, 7, 11, 18)
    test = c.test.copy()
    test[list(lost)] *= -1.0
    found = find_turned(replace(c, test=test))
    assert found.reversed == lost
    assert found.axes is None


def test_exchanged_sensors_and_one_that_is_turned_by_itself():
    c = waves()
    a, b, d = rows(c, "S4"), rows(c, "S9"), rows(c, "S13")
    test = c.test.copy()
    test[a], test[b] = c.test[b], c.test[a]
    test[d] = c.test[d][[1, 2, 0]]
    found = find_turned(replace(c, test=test))
    assert found.exchanged == (("S4", "S9"),)
    (turn,) = found.turned.values()
    assert list(found.turned) == ["S13"]
    assert np.array_equal(turn, [[0, 0, 1], [1, 0, 0], [0, 1, 0]])


def test_every_turn_is_there_once():
    assert len({turn.tobytes() for turn in TURNS}) == 48
    assert all(np.array_equal(turn @ turn.T, np.eye(3)) for turn in TURNS)
    assert np.array_equal(TURNS[0], np.eye(3))
