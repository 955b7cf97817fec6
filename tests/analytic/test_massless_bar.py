"""Elastic bar on a wall with a massless boundary: ten bounces without chatter, and what brings the chatter back."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import ENERGIES, History
from creak.dynamics.loads import Loads, at_rest
from creak.dynamics.modal.coefficients import MasslessBoundary
from creak.dynamics.modal.march import simulate_modal
from creak.dynamics.modal.massless import massless_substeps
from creak.dynamics.modal.taper import tapered
from creak.linalg.modes import modes
from creak.reduction.massless_boundary import massless_boundary
from creak.reduction.modal import with_modal_damping
from helpers_core import bar, channels, system_of, time_axis

E_A, RHO_A, LENGTH, SPEED, HEIGHT, WEIGHT, C = 900.0, 1.0, 10.0, 10.0, 5.0, 10.0, 30.0
N = 400
DURATION, PERIOD, IMPULSE, ENERGY = 2.0 * LENGTH / C, 16.0 / 3.0, 800.0 / 3.0, RHO_A * LENGTH * WEIGHT * HEIGHT
BOUNCES = 10
END = 53.0
ONSETS = np.array([k * PERIOD + at for k in range(BOUNCES) for at in (1.0, 11.0 / 3.0)])
STEP = 2e-3
"""Step in free flight: a twelfth of the period of the 40th mode."""
FOOT = np.eye(1, N + 1)


def masses() -> np.ndarray:
    """The mean of consistent and lumped mass: phase errors of the fourth order, so that the mesh is no matter."""
    M = bar(N, LENGTH, E_A, RHO_A)[0]
    return 0.5 * (M + np.diag(M.sum(axis=1)))


@cache
def reduced(count: int, fades: bool, zeta: float = 0.0, speed: float = 0.0) -> System:
    """`count` elastic modes, the rigid one, and the massless foot."""
    K = bar(N, LENGTH, E_A, RHO_A)[1]
    full = system_of(masses(), K, velocity=np.full(N + 1, -speed))
    if zeta:
        full = with_modal_damping(full, modes(K, masses(), count=count + 1, free=True), np.zeros((N + 1, 0)), zeta)
    small = massless_boundary(full, FOOT, count=count + 1)
    return tapered(small, small.rows(np.array([0]))[0]) if fades else small


def falling(time: np.ndarray) -> Loads:
    """The weight: one force for the two end nodes, one for all others."""
    w = -WEIGHT * masses().sum(axis=1)
    return Loads(time, np.zeros((3, time.size, 0)), np.tile(w[:2], (time.size, 1)), (np.array([0, N]), np.arange(1, N)))


@cache
def bouncing(count: int, fades: bool = True, zeta: float = 0.0, end: float = END) -> History:
    system, gaps = reduced(count, fades, zeta), foot()
    parts = massless_substeps(system, gaps, STEP)
    time = time_axis(round(end / STEP) * STEP, STEP / parts)
    return simulate_modal(system, gaps, falling(time), MasslessBoundary(), observed=np.array([0]), substeps=parts)


def foot() -> GapOperator:
    return channels(FOOT, HEIGHT, np.inf)


def events(history: History, merge: float = 0.1) -> tuple[np.ndarray, np.ndarray, int]:
    """Onsets, impulses, and the number of contacts before those less than `merge` apart count as one."""
    p, t = history.force[:, 0], history.time
    on = np.flatnonzero(p > 0.0)
    breaks = np.flatnonzero(np.diff(t[on]) > merge)
    first, last = on[np.concatenate([[0], breaks + 1])], on[np.concatenate([breaks, [on.size - 1]])]
    total = np.concatenate([[0.0], np.cumsum(history.weights * p)])
    contacts = 1 + np.count_nonzero(np.diff(on) > 1)
    return t[first], total[last + 1] - total[first], contacts


@pytest.mark.parametrize("count", [8, 15, 25, 40])
def test_bouncing_bar_over_ten_bounces(count, measured):
    """Twenty contacts of twenty, none of them broken up; times .1 % of the run, impulses .5 %, energy .1 %."""
    history = bouncing(count)
    onsets, impulses, contacts = events(history)
    assert onsets.size == contacts == 20
    scheme = history.energy[:, ENERGIES.index("scheme")]
    assert np.abs(scheme).max() < 1e-3 * ENERGY
    stored, work = history.energy[:, :3].sum(axis=1), history.energy[:, ENERGIES.index("external")]
    assert stored[-1] == pytest.approx(work[-1], abs=1e-3 * ENERGY)
    assert history.gap.min() > -1e-9 * HEIGHT
    case = f"ten bounces, massless boundary, {count} modes"
    measured("contact", f"{case}: contacts", contacts, 20, source="closed form")
    measured(
        "contact",
        f"{case}: onset of a contact, worst",
        onsets,
        ONSETS,
        abs=1e-3 * END,
        unit="s",
        source="Doyen, Ern, Piperno 2011",
    )
    measured(
        "contact", f"{case}: impulse, worst", impulses, IMPULSE, rel=5e-3, unit="N s", source="Doyen, Ern, Piperno 2011"
    )
    measured(
        "energy",
        f"{case}: energy not accounted for",
        np.abs(scheme).max() / ENERGY,
        at_most=1e-3,
        source="conservation",
    )


def test_more_modes_are_closer():
    """Onsets after ten bounces, impulses: errors fall with the modes."""
    errors = [np.abs(events(bouncing(count))[0] - ONSETS).max() for count in (8, 15, 25, 40)]
    assert errors == sorted(errors, reverse=True)
    shares = [np.abs(events(bouncing(count))[1] / IMPULSE - 1.0).max() for count in (8, 15, 25, 40)]
    assert shares == sorted(shares, reverse=True)


@pytest.mark.parametrize("count", [8, 15, 25, 40])
def test_modes_of_full_weight_chatter(count):
    """The same bar with its modes cut off sharply: contact breaks up, also where no energy is lost."""
    history = bouncing(count, fades=False)
    onsets, _, contacts = events(history)
    assert contacts > 60
    assert onsets.size > 20
    assert np.abs(history.energy[:, ENERGIES.index("scheme")]).max() < 1.5e-3 * ENERGY


@pytest.mark.parametrize("count", [8, 15, 25, 40])
def test_bar_on_a_rigid_wall(count, measured):
    """Contact .5 to 1.16667, impulse 200, leaves at +10; the front is as wide as the shortest wave, 2 L / count."""
    system = reduced(count, True, speed=SPEED)
    parts = massless_substeps(system, foot(), STEP)
    loads = at_rest(time_axis(1.3, STEP / parts))
    history = simulate_modal(system, foot(), loads, MasslessBoundary(), observed=np.arange(N + 1), substeps=parts)
    onsets, impulses, contacts = events(history)
    pressed = history.time[history.force[:, 0] > 0.0]
    assert contacts == 1
    assert onsets[0] == pytest.approx(0.5, abs=1.01 * STEP / parts)
    middle = (history.time > 0.5 + 0.2 * DURATION) & (history.time < 0.5 + 0.8 * DURATION)
    force, weight = history.force[middle, 0], history.weights[middle]
    assert history.force.max() < 1.6 * 300.0  # first crest of a front in a chain of springs and masses
    case = f"bar on a wall, massless boundary, {count} modes"
    measured(
        "contact",
        f"{case}: duration",
        pressed[-1] - pressed[0],
        DURATION,
        abs=DURATION / (2.0 * count),
        unit="s",
        source="closed form",
    )
    measured("contact", f"{case}: impulse", impulses[0], 200.0, rel=0.05 / count, unit="N s", source="closed form")
    measured(
        "contact",
        f"{case}: force",
        force @ weight / weight.sum(),
        300.0,
        rel=0.15 / count,
        unit="N",
        source="closed form",
    )
    if count == 40:
        near = (history.time > 0.4) & (history.time < 1.3)
        measured.curve("bar", "massless boundary, 40 modes", history.time[near][::8], history.force[near, 0][::8])


@pytest.mark.parametrize(("count", "late", "share"), [(8, 2e-3, 3e-3), (15, 1e-3, 1.5e-3), (25, 8e-4, 8e-4)])
def test_damped_bar_bounces_like_one_with_many_modes(count, late, share, measured):
    """5 % modal damping: six contacts until it rests; onsets, impulses and losses of 60 modes."""
    rich, poor = bouncing(60, zeta=0.05, end=16.0), bouncing(count, zeta=0.05, end=16.0)
    onsets, impulses, contacts = events(poor)
    expected = events(rich)
    assert onsets.size == contacts == expected[0].size == expected[2]
    np.testing.assert_allclose(impulses[:-1], expected[1][:-1], rtol=share)
    lost = [h.energy[-1, ENERGIES.index("damping")] for h in (poor, rich)]
    measured(
        "contact",
        f"damped bouncing bar, {count} modes: onset, worst",
        onsets,
        expected[0],
        abs=late * 16.0,
        unit="s",
        source="60 modes",
    )
    measured(
        "contact",
        f"damped bouncing bar, {count} modes: energy lost",
        lost[0],
        lost[1],
        rel=5e-3,
        unit="J",
        source="60 modes",
    )
    assert np.abs(poor.energy[:, ENERGIES.index("scheme")]).max() < 1e-3 * ENERGY
