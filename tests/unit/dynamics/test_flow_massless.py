"""Exact flow with coordinates without mass, as rotations of shells' nodes whose neighbours are retained: closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import creak
from creak.dynamics.flow.march import SAMPLES, simulate_flow
from creak.dynamics.history import ENERGIES, History
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.reduction.diagonal import diagonalise
from helpers_core import NO_CHANNELS, system_of


def fly(system, gaps, end, step, force=None, label=0) -> History:
    time = step / SAMPLES * np.arange(SAMPLES * round(end / step) + 1)
    values, labels = (np.zeros((time.size, 0)), ()) if force is None else (force(time)[:, None], (np.array([label]),))
    loads = Loads(time, np.zeros((3, time.size, 0)), values, labels)
    return simulate_flow(diagonalise(system), gaps, loads, OutputRequest(np.arange(system.n)))


def booked(history: History) -> dict[str, float]:
    return dict(zip(ENERGIES, history.energy[-1].tolist(), strict=True))


def test_a_push_on_a_coordinate_without_mass_is_no_damping():
    """m = 1, springs of 1e4 to ground, to a massless node, and of 5e3 from there to ground; a push on the node."""
    K = np.array([[2e4, -1e4], [-1e4, 1.5e4]])
    history = fly(system_of(np.diag([1.0, 0.0]), K), NO_CHANNELS, 0.5, 1e-3, lambda t: 50.0 * np.sin(60.0 * t), 1)
    t, w2, f = history.time[history.output_index], 2e4 - 1e8 / 1.5e4, 60.0
    a = 50.0 * (1e4 / 1.5e4) / (w2 - f * f)
    x = a * (np.sin(f * t) - f / np.sqrt(w2) * np.sin(np.sqrt(w2) * t))
    np.testing.assert_allclose(history.displacement[:, 0], x, atol=1e-4 * np.abs(x).max())
    node = (50.0 * np.sin(f * t) + 1e4 * history.displacement[:, 0]) / 1.5e4
    np.testing.assert_allclose(history.displacement[:, 1], node, atol=1e-9 * np.abs(node).max())
    energy = booked(history)
    most = np.abs(history.energy[:, ENERGIES.index("strain")]).max()
    assert abs(energy["damping"]) < 2e-3 * most  # the book's rule for the work of loads
    assert energy["external"] == pytest.approx(energy["kinetic"] + energy["strain"], abs=2e-3 * most)
    assert history.energy_created < 2e-3


@pytest.mark.parametrize("arm", [0.0, 0.5, -2.0])
def test_friction_on_a_side_that_turns_without_mass(arm):
    """A mass pressed on a wall slides against a spring, and turns a massless coordinate that moves its side along:
    w = x + arm theta, theta = .4 x. x'' = -w2 x - mu N c, c = 1 + .4 arm, until it stops."""
    K = np.array([[1e6, 0.0, 0.0], [0.0, 4e4, -4e3], [0.0, -4e3, 1e4]])
    system = system_of(np.diag([1.0, 1.0, 0.0]), K, velocity=np.array([0.0, 2.0, 0.0]))
    wall = creak.gap_channels(
        np.array([[1.0, 0.0, 0.0]]), 0.0, 1e6, preload=100.0, tangents=[np.array([[0.0, 1.0, arm]])], friction=0.3
    )
    w2, c = 4e4 - 4e3**2 / 1e4, 1.0 + 0.4 * arm
    back, w = 30.0 * c / w2, np.sqrt(w2)
    stops = (np.pi / 2.0 - np.arctan2(back, 2.0 / w)) / w
    end = round(0.9 * stops, 5)
    history = fly(system, wall, end, 1e-5)
    x = (back * np.cos(w * end) + 2.0 / w * np.sin(w * end)) - back
    np.testing.assert_allclose(history.displacement[-1, 1], x, rtol=1e-4)
    np.testing.assert_allclose(history.displacement[-1, 2], 0.4 * x, rtol=1e-3)
    energy = booked(history)
    assert energy["friction"] == pytest.approx(30.0 * abs(c) * x, rel=1e-3, abs=1e-9)
    assert abs(energy["scheme"]) < 1e-3 * energy["kinetic"]
    assert history.energy_created < 1e-6


@pytest.mark.parametrize("diagonal", [True, False], ids=["flow", "flight"])
def test_a_side_that_is_driven_rubs_though_it_gives_to_no_force(diagonal):
    """A pad pressed on a floor and dragged to and fro, free along its normal alone: four strokes of 1 mm a period."""
    pad = creak.couple(creak.system_from_matrices(1e4 * np.eye(2), np.eye(2), labels=[0, 1]), driven={"x": [0]})
    floor = creak.gap_channels(
        [[0.0, 1.0]], 0.0, 1e6, labels=[0, 1], preload=10.0, tangents=[[[1.0, 0.0]]], friction=0.3
    )
    loads = creak.make_loads(pad, np.linspace(0.0, 0.1, 2001), motion={"x": creak.Sine(10.0, 1e-3)})
    history = creak.simulate(creak.diagonalise(pad) if diagonal else pad, floor, loads)
    path = np.abs(history.sliding).T @ history.weights
    assert path[0] == pytest.approx(4e-3, rel=1e-4)
    assert booked(history)["friction"] == pytest.approx(0.3 * 10.0 * 4e-3, rel=1e-4)
    assert np.abs(history.slip[:, 0]).max() == pytest.approx(1e-3, rel=1e-3)
