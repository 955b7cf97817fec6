"""Energy created is held against the work of the loads and against what contact took up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import creak
from creak.dynamics.history import ENERGIES, History
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.record.watch import Extremes
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import simulate
from creak.reduction.diagonal import diagonalise
from creak.verify.reliability import CONTACT_BAR, ENERGY_BAR, created_of_contact, reasons_against
from helpers_core import channels, forces_on, system_of, time_axis

TAKEN = 0.5 * 50.0 * 0.1**2
"""mJ: a spring of 50 N/mm pressed in by 0.1 mm."""


def bounce(
    share: float, work: float = 1e4, scheme: float | None = None, held: float = 0.0, lost: float = 0.0
) -> History:
    """Ten steps into the spring and ten out of it with a force larger by `share`, in a run with `work` mJ from outside.

    Parameters
    ----------
    scheme : what the balance leaves over at the end; default: what the contact made. held, lost : energy of the springs
        at the start, and in dampers by the end.
    """
    depth = 0.1 * np.concatenate([np.linspace(0.0, 1.0, 11), np.linspace(1.0, 0.0, 11)])
    force = 50.0 * depth * np.repeat([1.0, 1.0 + share], 11)
    energy = np.zeros((22, len(ENERGIES)))
    energy[:, ENERGIES.index("external")] = np.linspace(0.0, work, 22)
    energy[0, ENERGIES.index("contact")] = held
    energy[-1, ENERGIES.index("contact_damping")] = lost
    energy[-1, ENERGIES.index("scheme")] = -share * TAKEN if scheme is None else scheme
    none = np.zeros((0, 0))
    return History(
        1e-4 * np.arange(22), -depth[:, None], force[:, None], none, np.zeros(0, dtype=np.int64), none, energy, 20, 0.0
    )


def test_a_bounce_that_gives_back_what_it_took_created_nothing():
    assert created_of_contact(bounce(0.0)) == 0.0
    assert reasons_against(bounce(0.0)) == []


def test_a_light_part_on_a_heavy_one_is_held_against_its_contact():
    """Half as much again comes back: 50 % of what contact took up, some 1e-5 of the work that moves the heavy part."""
    history = bounce(0.5)
    assert history.energy_created < 0.01 * ENERGY_BAR
    assert created_of_contact(history) == pytest.approx(0.5)
    (reason,) = reasons_against(history)
    assert "50 % of the energy that contact took up (at most 10 % is sound)" in reason
    assert "work of the loads" not in reason
    assert "step" in reason
    assert "step" not in reasons_against(history, forced=False)[0]  # nobody has set one


def test_damping_that_gives_energy_is_told():
    history = bounce(0.0)
    energy = history.energy.copy()
    energy[-1, ENERGIES.index("damping")] = -0.2 * history.energy_scale
    (reason,) = reasons_against(replace(history, energy=energy))
    assert "20 % of the work of the loads by what damps the structure" in reason
    untouched = replace(history, energy=energy, force=0.0 * history.force)
    (reason,) = reasons_against(untouched, forced=False)
    assert "soften" not in reason
    assert "one system of units" in reason


def test_both_bars_and_what_is_just_below_them():
    assert reasons_against(bounce(0.99 * CONTACT_BAR)) == []
    assert len(reasons_against(bounce(1.01 * CONTACT_BAR))) == 1
    work = 0.5 * CONTACT_BAR * TAKEN / ENERGY_BAR
    assert reasons_against(bounce(0.49 * CONTACT_BAR, work)) == []
    (reason,) = reasons_against(bounce(0.51 * CONTACT_BAR, work))
    assert "0.51 % of the work of the loads (at most 0.5 % is sound)" in reason


def test_what_the_scheme_dissipates_again_is_not_created():
    assert created_of_contact(bounce(0.5, scheme=0.1)) == 0.0
    assert created_of_contact(bounce(0.5, scheme=-0.2 * TAKEN)) == pytest.approx(0.2)


def test_created_energy_away_from_contact_is_not_of_contact():
    """The balance of a heavy part may be off by far more than a light one ever holds."""
    assert created_of_contact(bounce(0.0, scheme=-20.0)) == pytest.approx(0.0, abs=1e-12)


def test_springs_that_start_pressed_give_back_what_they_held():
    assert created_of_contact(bounce(0.5, held=0.5 * TAKEN)) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("preload", [0.0, 10.0])
def test_what_a_preload_holds_hides_nothing(preload):
    """One mass into a stop with steps far too long: what it gained is its speed after over its speed before.

    Beside the stop a channel of next to no stiffness holds P^2 / 2k = 5000 J with its preload, all the time.
    """
    time = time_axis(0.6, 0.01)
    gaps = creak.gap_channels([[1.0], [1.0]], [2.3e-3, 0.0], [1e5, 0.01], preload=[0.0, preload])
    loads = forces_on(time, [0], np.zeros(time.size))
    system = system_of(np.eye(1), np.zeros((1, 1)), velocity=[-1.0])
    history = simulate(system, gaps, loads, HHT(0.0), OutputRequest(np.array([0])))
    x = history.displacement[:, 0]
    made = ((x[-1] - x[-2]) / 0.01) ** 2 - 1.0
    assert made > 0.4
    assert history.energy_created == pytest.approx(made, rel=0.03)  # of the weak spring
    assert created_of_contact(history) == pytest.approx(made, rel=0.03)  # all of it went into contact
    assert history.energy[0, :3].tolist() == [0.5, 0.0, 0.0]
    (reason,) = reasons_against(history)
    assert "of the work of the loads" in reason
    assert "of the energy that contact took up" in reason


def test_the_strain_of_static_loads_hides_nothing():
    history = bounce(0.0, work=10.0, scheme=-1.0)
    history.energy[:, ENERGIES.index("strain")] += 1e6
    assert history.energy_created == pytest.approx(0.1)


def test_what_dampers_lost_came_from_somewhere():
    assert created_of_contact(bounce(0.0, scheme=-0.3 * TAKEN, lost=0.3 * TAKEN)) == pytest.approx(0.3)


def test_round_off_of_a_touch_that_took_nothing_is_no_alarm():
    history = bounce(0.0)
    tiny = replace(history, force=1e-12 * history.force * np.repeat([[1.0], [2.0]], 11, axis=0))
    tiny.energy[-1, ENERGIES.index("scheme")] = -1.0
    assert created_of_contact(tiny) < 1e-6


def test_runs_without_channels_or_with_one_instant():
    free = replace(bounce(0.0), gap=np.zeros((22, 0)), force=np.zeros((22, 0)))
    assert created_of_contact(free) == 0.0
    one = bounce(0.0)
    one = replace(one, time=one.time[:1], gap=one.gap[:1], force=one.force[:1], energy=one.energy[:1])
    assert created_of_contact(one) == 0.0


@pytest.mark.parametrize("table", ["force", "gap", "energy"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_figures_that_are_not_finite(table, value):
    history = bounce(0.0)
    getattr(history, table)[3, 0] = value
    (reason,) = reasons_against(history)
    assert "not finite" in reason
    assert np.isnan(created_of_contact(history))


def test_channels_that_were_dropped_and_closed_are_a_reason():
    one = np.zeros(1)
    seen = Extremes(
        one,
        one,
        ("back:7", "back:8"),
        np.array([0.1, -0.3]),
        np.array([0.2, 0.4]),
        np.array([0.1, -0.3]),
        (),
        one[:0],
        one[:0],
    )
    (reason,) = reasons_against(replace(bounce(0.0), extremes=seen), unit="mm")
    assert reason.startswith("parts pass through each other: 1 channel(s) that the pre-check dropped closed")
    assert "farthest back:8, by 0.3 mm at t = 0.4 s" in reason
    assert reasons_against(replace(bounce(0.0), extremes=replace(seen, gap=np.array([0.1, 0.01])))) == []


def test_a_light_strip_on_a_frame_of_one_tonne_does_not_pass():
    """Steps too long for its spring throw the strip about; the frame's own work hides that, contact's does not."""
    frame, strip, k = 1.0, 1e-7, 1.0
    stiffness = np.diag([frame * (2.0 * np.pi * 5.0) ** 2, strip * (2.0 * np.pi * 20.0) ** 2])
    system = diagonalise(system_of(np.diag([frame, strip]), stiffness, sparse=False))
    gaps, none = channels(np.array([[-1.0, 1.0]]), 0.5, k), np.zeros(0, dtype=np.int64)
    runs = []
    for step in (1e-3, 1e-4):
        time = time_axis(0.65, step)
        loads = forces_on(time, [0], 2e3 * np.sin(2.0 * np.pi * 5.0 * time))
        runs.append(simulate(system, gaps, loads, HHT(0.0), OutputRequest(none)))
    coarse, fine = runs
    assert (coarse.weights @ coarse.force).sum() > 3.0 * (fine.weights @ fine.force).sum()
    assert coarse.energy_created < ENERGY_BAR
    (reason,) = reasons_against(coarse)
    assert "of the energy that contact took up" in reason
    assert reasons_against(fine) == []
