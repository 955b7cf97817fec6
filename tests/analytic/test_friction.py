"""Coulomb friction against closed forms: a decaying oscillator and a block on a belt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.contact.gap_operator import GapOperator
from creak.contact.laws.parameters import Friction
from creak.dynamics.history import ENERGIES, History
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import simulate
from helpers_core import channels, system_of

RECORDED = {"section": "friction", "source": "closed form"}

pytestmark = pytest.mark.slow

M, K, PRESS = 1.0, 1e4, 1e6
"""kg, N/m, and the stiffness of the contact in its normal direction."""


def pressed(
    force: float, static: float, kinetic: float, decay: float = 0.0, shares: tuple[float, ...] = (1.0,)
) -> GapOperator:
    """Dof 1 is pressed to the ground with a preload; dof 0 rubs along it, dof 2 across. shares: of each channel."""
    own = force * np.array(shares)
    g = channels([[0.0, 1.0, 0.0]] * own.size, -own / PRESS, PRESS)
    along = channels([[1.0, 0.0, 0.0]] * own.size, 0.0, 0.0).G
    across = channels([[0.0, 0.0, 1.0]] * own.size, 0.0, 0.0).G
    friction = Friction(*(np.full(own.size, x) for x in (static, kinetic, decay)))
    return replace(g, tangents=(along, across), friction=friction, preload=own)


def rub(gaps: GapOperator, pull: np.ndarray, time: np.ndarray) -> History:
    """A mass on springs K along and across, with a force `pull` (n_time,) along."""
    system = system_of(M * np.eye(3), K * np.eye(3), velocity=np.zeros(3))
    loads = Loads(time, np.zeros((3, time.size, 0)), pull[:, None], (np.array([0]),))
    return simulate(system, gaps, loads, HHT(), OutputRequest(np.arange(3)))


def test_coulomb_friction_takes_the_same_from_every_swing(measured):
    """m = 1, k = 1e4, mu N = 1, released at .85 mm: turns at -.65, .45, -.25, .05 mm, sticks at .1256637 s."""
    x0, h = 0.85e-3, 2e-5
    time = h * np.arange(round(0.16 / h) + 1)
    history = rub(pressed(1.0, 1.0, 1.0), np.full(time.size, -K * x0), time)
    x = history.displacement[:, 0] + x0
    v = history.sliding[:, 0]
    turns = [float(x[i]) for i in np.flatnonzero((v[1:-1] * v[2:] <= 0.0) & (v[1:-1] != 0.0)) + 1]
    stuck = np.flatnonzero(v == 0.0)
    stop = time[stuck[np.flatnonzero(np.diff(stuck) == 1)[1]]]
    # It takes the scheme a few steps to let the acceleration of the last slide die out.
    assert not v[round(0.127 / h) :].any()
    took = history.energy[-1, ENERGIES.index("friction")]
    case = "Coulomb oscillator"
    # Turning points are flat: a step that straddles one misses it by a h^2 / 2, and HHT takes 2 zeta per turn.
    measured(f"{case}: turning point {{}}", turns[:4], [-0.65e-3, 0.45e-3, -0.25e-3, 0.05e-3], abs=2e-7, unit="m")
    measured(f"{case}: time when it sticks", stop, 0.1256637, abs=4 * h, unit="s")
    measured(f"{case}: energy taken", took, 0.5 * K * (0.85e-3**2 - 0.05e-3**2), rel=1e-3, unit="J")
    assert abs(history.energy[-1, ENERGIES.index("scheme")]) < 1e-3 * took


def cycles(history: History) -> tuple[list[float], list[float]]:
    """Times at which sliding starts and ends, by rows of the history."""
    moving = np.any(history.sliding != 0.0, axis=1)
    change = np.flatnonzero(np.diff(moving.astype(int)))
    starts = [float(history.time[i]) for i in change if not moving[i]]
    ends = [float(history.time[i + 1]) for i in change if moving[i]]
    return starts, ends


def test_belt_squeaks(measured):
    """m = 1, k = 1e4, N = 10, mu .5 / .3, belt .01 m/s, in the frame of the belt.

    Stick .04 s, slip .04068888 s, 12.3932817 Hz, .80688788 mm of belt a cycle: to four digits with the short step.
    """
    h = 1e-5
    time = h * np.arange(round(0.14 / h) + 1)  # the second slip starts at .1307 s
    history = rub(pressed(10.0, 0.5, 0.3), -K * 0.01 * time, time)
    starts, ends = cycles(history)
    assert starts[0] == pytest.approx(0.05, abs=2 * h)
    # Slip ends where the speeds meet: the step in which they do is known to one h.
    period = starts[1] - starts[0]
    case = "block on a belt"
    measured(f"{case}: stick", starts[1] - ends[0], 0.04, abs=3 * h, unit="s")
    measured(f"{case}: slip", ends[0] - starts[0], 0.04068888, abs=2 * h, unit="s")
    measured(f"{case}: period of 12.3932817 Hz", period, 1 / 12.3932817, abs=2 * h, unit="s")
    measured(f"{case}: belt of a cycle", 0.01 * period, 0.80688788e-3, abs=0.02 * h, unit="m")


def test_rigidly_linked_nodes_rub_as_one(measured):
    """The same block on four nodes that press unevenly: those at their limit are held by the others until all slip.

    How they share the friction is not determined, and decides nothing.
    """
    h = 2e-5
    time = h * np.arange(round(0.14 / h) + 1)
    history = rub(pressed(10.0, 0.5, 0.3, shares=(0.1, 0.2, 0.3, 0.4)), -K * 0.01 * time, time)
    starts, ends = cycles(history)
    assert starts[0] == pytest.approx(0.05, abs=2 * h)
    case = "block on a belt, four nodes"
    measured(f"{case}: stick", starts[1] - ends[0], 0.04, abs=3 * h, unit="s")
    measured(f"{case}: slip", ends[0] - starts[0], 0.04068888, abs=2 * h, unit="s")


def test_friction_acts_against_the_sliding_in_the_plane(measured):
    """A mass that slides at 30 degrees is braked along its path."""
    h, angle = 1e-4, np.pi / 6
    time = h * np.arange(501)
    speed = 0.2 * np.array([np.cos(angle), 0.0, np.sin(angle)])
    system = system_of(M * np.eye(3), np.diag([1e-9, 1e3, 1e-9]), velocity=speed)
    loads = Loads(time, np.zeros((3, time.size, 0)), np.zeros((time.size, 0)))
    history = simulate(system, pressed(10.0, 0.3, 0.3), loads, HHT(), OutputRequest(np.arange(3)))
    u = history.displacement
    np.testing.assert_allclose(u[1:, 2] / u[1:, 0], np.tan(angle), rtol=1e-9)
    way = np.hypot(u[-1, 0], u[-1, 2])
    # v t - mu N t^2 / 2; the first step knows no friction at its start: an error of order h v.
    measured("mass that slides at 30 degrees: way", way, 0.2 * 0.05 - 0.5 * 3.0 * 0.05**2, rel=1e-2, unit="m")


def test_stribeck_friction_falls_with_the_speed(measured):
    """While it slides at v the force is p (kinetic + (static - kinetic) exp(-v / decay))."""
    h = 1e-4
    time = h * np.arange(2001)
    history = rub(pressed(10.0, 0.5, 0.2, 0.05), 40.0 * time / time[-1] + 2.0, time)
    v, tau, p = history.sliding[:, 0], history.tangential[:, 0], history.force[:, 0]
    slides = np.flatnonzero(v != 0.0)
    assert slides.size > 100
    mu = 0.2 + 0.3 * np.exp(-np.abs(v[slides]) / 0.05)
    measured(
        "Stribeck law: friction force, worst instant",
        np.abs(tau[slides]),
        mu * p[slides],
        rel=1e-9,
        unit="N",
        source="the law",
    )
    assert (np.sign(tau[slides]) == -np.sign(v[slides])).all()
