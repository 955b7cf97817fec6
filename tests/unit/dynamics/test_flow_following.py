"""Exact flow where modes that the filter takes off the gaps follow what the supports do."""

from __future__ import annotations

import numpy as np
import pytest

import creak
from creak.dynamics.diagonal import is_modal
from creak.dynamics.flow.march import SAMPLES, simulate_flow
from creak.dynamics.history import ENERGIES
from creak.dynamics.record.recorder import OutputRequest
from creak.reduction.diagonal import diagonalise

RECORDED = {"section": "time"}


@pytest.mark.parametrize("dashpot", [0.0, 1e-4], ids=["single", "coupled"])
def test_a_stiff_part_and_the_support_it_stands_on_keep_their_gap(dashpot, measured):
    """A grain of 1e-7 on a spring of 1e5 (160 kHz) on a base that goes 60 to and fro; beside it a mass of 70 Hz. The
    stop stands on the base as well: their gap changes by s'' / omega^2, 1e-8 of the way. The filter of what contact cannot
    resolve takes the grain's motion off the gap; what it has in common with the base must stay."""
    K = np.array([[1e5 + 200.0, -200.0, -1e5], [-200.0, 200.0, 0.0], [-1e5, 0.0, 1e5]])
    C = dashpot * np.array([[2.0, -1.0, -1.0], [-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
    free = creak.system_from_matrices(K, np.diag([1.0, 1e-3, 1e-7]), C=C if dashpot else None, alpha=1.0)
    system = diagonalise(creak.couple(free, driven={"base": [0]}))
    assert is_modal(system) is (dashpot == 0.0)
    stop = creak.gap_channels([[-1.0, 0.0, 1.0]], 0.05, 200.0)
    time = np.linspace(0.0, 0.5, 1500 * SAMPLES + 1)
    way = creak.Table(time, 30.0 * (1.0 - np.cos(4.0 * np.pi * time)))
    loads = creak.make_loads(system, time, motion={"base": way})
    history = simulate_flow(system, stop, loads, OutputRequest(np.array([1])))
    measured(
        f"gap of a stiff part and the support it stands on, {'coupled' if dashpot else 'single'} modes: share of the way",
        np.abs(history.gap[:, 0] - 0.05).max() / 60.0,
        at_most=1e-6,
        source="s'' / omega^2",
    )


BELT_SPEED, PULL = 2.0, 1.0
SPRINGS = np.diag([0.0, 1.0, 0.0, 10.0])
"""Of the mass along the belt and across it."""


def carried_along(beta, dashpot):
    """A mass on a spring of 1 that sticks, by a force of 2 and a coefficient of .5, on a grain (32 kHz, seen by contact
    in part) that stands on a base; the base comes to speed in .1 s."""
    along = np.array([[1.0, 0.0, -1.0, 0.0], [0.0] * 4, [-1.0, 0.0, 1.0, 0.0], [0.0] * 4])
    beside = np.diag([0.0, 1.0, 1.0, 0.0])
    beside[1, 2] = beside[2, 1] = -1.0
    C = dashpot * beside if dashpot else None
    free = creak.system_from_matrices(4e3 * along + SPRINGS, np.diag([1.0, 1e-6, 1e-7, 1e-6]), C=C, beta=beta)
    system = diagonalise(creak.couple(free, driven={"base": [0]}))
    assert is_modal(system) is (dashpot == 0.0)
    tangents = [[[0.0, 1.0, -1.0, 0.0]], [[0.0] * 4]]
    gaps = creak.gap_channels([[0, 0, 0, 1.0]], 0.0, 200.0, preload=2.0, tangents=tangents, friction=(0.5, 0.3, 0.3))
    time = np.linspace(0.0, 1.0, 1000 * SAMPLES + 1)
    x = np.minimum(time / 0.1, 1.0)
    way = BELT_SPEED * np.where(x < 1.0, 0.1 * (x**3 - 0.5 * x**4), time - 0.05)
    loads = creak.make_loads(system, time, motion={"base": creak.Table(time, way)})
    history = simulate_flow(system, gaps, loads, OutputRequest(np.arange(4)))
    sliding = history.time[history.sliding.any(axis=1)]
    steps = np.zeros(1001, dtype=bool)
    steps[np.searchsorted(time[::SAMPLES], sliding)] = True
    return way[::SAMPLES], history, steps


@pytest.mark.parametrize(("beta", "dashpot"), [(0.0, 0.0), (5e-7, 0.0), (0.0, 1e-5)], ids=["free", "damped", "coupled"])
def test_what_sticks_on_a_part_that_is_carried_along_goes_with_it(beta, dashpot):
    """It slips where the spring pulls as hard as friction holds, and goes with the base again after that: neither creeps.

    A part that gives by F / k moves the mass by 1 / 4000 of its way at most; so may a step of a slip of two."""
    way, history, slides = carried_along(beta, dashpot)
    mass = history.displacement[:, 1]
    first = int(slides.argmax())
    np.testing.assert_allclose(mass[:first], way[:first], rtol=0, atol=PULL / 2000.0)
    assert way[first] == pytest.approx(PULL, abs=2.0 * BELT_SPEED * 1e-3)
    again = first + np.flatnonzero(~slides[first:])[0]
    sticks = slice(again, again + int(np.append(slides[again:], True).argmax()))
    moved = (mass - way)[sticks]
    assert sticks.stop - sticks.start > 20
    np.testing.assert_allclose(moved, moved[0], rtol=0, atol=PULL / 2000.0)
    energy = dict(zip(ENERGIES, history.energy[-1], strict=True))
    assert history.energy_created < 1e-4
    assert 0.0 <= energy["damping"] < 0.01 * energy["external"]
