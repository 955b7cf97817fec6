"""Contact and friction by exact flow at the default accuracy: nothing but the physics is given."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.integrate import solve_ivp

from creak.contact.gap_operator import GapOperator
from creak.contact.laws.parameters import Friction
from creak.dynamics.flow.march import SAMPLES, simulate_flow
from creak.dynamics.history import ENERGIES, History
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.reduction.diagonal import diagonalise
from creak.verify.events import Event, find_events
from creak.verify.peaks import peak_forces
from creak.verify.reliability import created_of_contact
from helpers_core import bar, channels, system_of

RECORDED = {"section": "contact, exact flow", "source": "closed form"}

STEP = 1e-3


def fly(system, gaps: GapOperator, end: float, pull=(), labels=(), step: float = STEP) -> History:
    time = step / SAMPLES * np.arange(SAMPLES * round(end / step) + 1)
    values = np.stack([f(time) for f in pull], axis=1) if pull else np.zeros((time.size, 0))
    loads = Loads(time, np.zeros((3, time.size, 0)), values, tuple(np.array([x]) for x in labels))
    return simulate_flow(diagonalise(system), gaps, loads, OutputRequest(np.arange(system.n)))


def one_mass(m: float, k: float, v0: float):
    return system_of(np.array([[m]]), np.array([[k]]), velocity=np.array([v0]))


def touches(history: History, gaps: GapOperator, merge: float = 0.0) -> list[Event]:
    return find_events(history, gaps, merge=merge, f_max=1e6)


def work(history: History, name: str) -> float:
    return float(history.energy[-1, ENERGIES.index(name)])


# --- one mass -------------------------------------------------------------------------------------------------------


def test_mass_on_a_penalty_stop(measured):
    """m = 100, k = 1e4, stop 1e6, no gap, v0 = 1: F 9950.3719, duration .0312600153, impulse 198.01980."""
    gaps = channels([[1.0]], 0.0, 1e6)
    history = fly(one_mass(100.0, 1e4, -1.0), gaps, 0.045)
    event = touches(history, gaps)[0]
    # (omega h)^2 / 24 with h <= 1e-5, and the instants that are kept: lines within 1e-5 of all.
    for name, found, exact, unit in (
        ("peak force", event.force_peak, 9950.3719, "N"),
        ("duration", event.t_end - event.t_start, 0.0312600153, "s"),
        ("impulse", event.impulse, 198.01980, "N s"),
    ):
        measured(f"mass on a penalty stop: {name}", found, exact, rel=1e-5, unit=unit)
    assert created_of_contact(history) < 1e-5


def test_mass_with_gravity_on_a_spring_stop(measured):
    gaps = channels([[1.0]], 0.0, 1e4)
    history = fly(one_mass(1.0, 0.0, -1.0), gaps, 0.06, [lambda t: -9.81 + 0.0 * t], [0])
    event = touches(history, gaps)[0]
    measured("mass with gravity on a spring stop: peak force", event.force_peak, 110.290, abs=5e-4, unit="N")
    measured("mass with gravity on a spring stop: duration", event.t_end, 0.0333717, abs=1e-7, unit="s")


def test_bilinear_oscillator_period(measured):
    m, k, stop = 2.0, 800.0, 7200.0
    period = np.pi * (1.0 / np.sqrt(k / m) + 1.0 / np.sqrt((k + stop) / m))
    gaps = channels([[1.0]], 0.0, stop)
    starts = np.array([e.t_start for e in touches(fly(one_mass(m, k, 1.0), gaps, 4.2 * period), gaps)])
    measured("bilinear oscillator: period", np.diff(starts), period, rel=1e-6, unit="s")


def test_play_between_two_stops():
    """A free mass rattles between two stops: one round 2 d / v + 2 pi / omega."""
    m, k, d, v = 0.5, 5e5, 2e-3, 0.5
    gaps = channels([[-1.0], [1.0]], d / 2, k)
    history = fly(one_mass(m, 0.0, v), gaps, 0.1)
    upper = [e.t_start for e in touches(history, gaps) if e.channel == "stop:0"]
    np.testing.assert_allclose(np.diff(upper), 2 * d / v + 2 * np.pi / np.sqrt(k / m), rtol=1e-4)
    assert abs(work(history, "kinetic") + work(history, "contact") - 0.5 * m * v * v) < 1e-5


def test_ball_comes_to_rest(measured):
    """Dropped on a spring and dashpot: bounces without end in finite time, then the weight alone presses."""
    m, g, k, zeta = 0.2, 9.81, 1e6, 0.1
    c = 2.0 * zeta * np.sqrt(k * m)
    gaps = channels([[1.0]], 0.01, k, c)
    history = fly(one_mass(m, 0.0, 0.0), gaps, 1.0, [lambda t: -m * g + 0.0 * t], [0])
    late = history.time > 0.95
    np.testing.assert_allclose(history.force[late, 0], m * g, rtol=1e-3)
    measured(
        "ball that came to rest: force",
        float(np.median(history.force[late, 0])),
        m * g,
        rel=1e-3,
        unit="N",
        source="statics",
    )
    bounces = touches(history, gaps)
    assert len(bounces) > 5
    speeds = np.array([e.closing_speed for e in bounces[:4]])
    # Damper and spring as one force without tension: restitution falls a little short of exp(-pi zeta / sqrt(1 - zeta^2)).
    np.testing.assert_allclose(speeds[1:] / speeds[:-1], 0.74, atol=0.03)
    lost = work(history, "contact_damping")
    assert lost == pytest.approx(m * g * (0.01 + m * g / k), rel=5e-3)


def rebound(zeta: float) -> tuple[float, float]:
    """Speed and phase omega t at which a mass leaves a damped spring that cannot pull, thrown at it with speed 1.

    x = exp(-zeta t) sin(w t) / w, w^2 = 1 - zeta^2; it leaves where x + 2 zeta x' = 0.
    """
    w = np.sqrt(1.0 - zeta**2)
    phase = (np.pi - np.arctan2(2.0 * zeta * w, 1.0 - 2.0 * zeta**2)) / w
    speed = np.exp(-zeta * phase) * (np.cos(w * phase) - zeta / w * np.sin(w * phase))
    return float(-speed), float(phase)


@pytest.mark.parametrize("zeta", [0.2, 0.6, 0.8])
def test_rebound_from_a_damped_spring(zeta, measured):
    """Ten masses that touch at ten phases of a step: a damper's force is there at once, and never pulls."""
    m, w, v, count = 1e-4, 1e5, 1.0, 10
    h = 1e-3 / 512
    # Steps near contact: a quarter of 1 / w, as a power of two of the flight step.
    gaps = channels(np.eye(count), 1e-4 + np.arange(count) / count * v * h, w * w * m, 2.0 * zeta * w * m)
    system = system_of(m * np.eye(count), np.zeros((count, count)), velocity=np.full(count, -v))
    history = fly(system, gaps, 0.004)
    leaving = (history.displacement[-1] - history.displacement[-2]) / STEP
    exact, phase = rebound(zeta)
    # By another way: LSODA on the same law.
    law = lambda t, z: [z[1], -max(0.0, z[0] + 2.0 * zeta * z[1]) if z[0] > 0.0 else 0.0]  # noqa: E731
    other = solve_ivp(law, (0.0, 2.0 * phase), [1e-9, 1.0], method="LSODA", rtol=1e-9, atol=1e-12, max_step=0.01)
    assert exact == pytest.approx(-other.y[1, -1], rel=1e-3)
    assert np.ptp(leaving) < 0.04 * exact
    assert work(history, "contact_damping") == pytest.approx(0.5 * m * count * v**2 * (1.0 - exact**2), rel=0.01)
    assert history.energy_created < 1e-3
    measured(
        f"rebound from a spring with {zeta:g} of critical damping", leaving, np.full(count, exact), rel=0.06, unit="m/s"
    )


def peak_of_damped_spring(zeta: float) -> float:
    """Largest force that a spring (1) with a damper (2 zeta) has against a mass 1 of speed 1, by complex exponentials."""
    roots = np.array([-zeta + s * np.sqrt(complex(zeta**2 - 1.0)) for s in (1, -1)])
    t = np.linspace(0.0, 3.0, 30001)
    x, v = (np.outer([1.0, -1.0], np.ones(t.size)) * roots[:, None] ** k * np.exp(np.outer(roots, t)) for k in (0, 1))
    return float(((x + 2.0 * zeta * v).sum(axis=0) / (roots[0] - roots[1])).real.max())


@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("zeta", [0.05, 0.3, 0.6, 2.0])
@pytest.mark.parametrize(("omega", "step"), [(100.0, 1e-3), (1e4, 2e-4), (1e4, 5e-3)])
def test_raw_peak_of_a_damper_that_is_there_at_once(omega, step, zeta, mu):
    """Seven masses that touch at seven phases of a step: c v at the touch, and no row has the impulse of a kick."""
    v, n = 1.0, 7
    h = step * 2.0 ** -np.ceil(np.log2(max(100.0, step * omega / 0.25)))
    gaps = channels(np.eye(n, 2 * n), 2e-3 + np.arange(n) / n * v * h, omega**2, 2.0 * zeta * omega)
    along = sp.csr_matrix(np.eye(n, 2 * n, n)), sp.csr_matrix((n, 2 * n))
    gaps = replace(gaps, tangents=along, friction=Friction(np.full(n, mu), np.full(n, mu), np.zeros(n)))
    start = np.repeat([-v, 3.0 * v], n)
    end = step * np.ceil((0.012 + 4.0 / omega) / step)
    history = fly(system_of(np.eye(2 * n), np.zeros((2 * n, 2 * n)), velocity=start), gaps, end, step=step)
    exact = omega * v * peak_of_damped_spring(zeta)
    np.testing.assert_allclose(peak_forces(history, gaps).max(axis=0), exact, rtol=0.01)
    assert history.force.max() < 1.01 * exact
    assert max(e.force_peak for e in touches(history, gaps)) == pytest.approx(exact, rel=0.01)
    gained = (history.displacement[-1] - history.displacement[-2]) / step - start
    np.testing.assert_allclose(history.weights @ history.force, gained[:n], rtol=1e-3)
    if mu:
        rubbed = history.tangential[:, ::2]
        assert rubbed.min() > -1.01 * mu * exact
        np.testing.assert_allclose(history.weights @ rubbed, -mu * gained[:n], rtol=1e-3)
    assert history.energy_created < 1e-3


# --- bars -----------------------------------------------------------------------------------------------------------

N, LENGTH, SPEED = 200, 10.0, 10.0
M, K = bar(N, LENGTH, 900.0, 1.0)
FOOT = np.eye(1, N + 1)


@pytest.mark.parametrize("penalty", [10.0, 100.0, np.inf], ids=["10 EA/dx", "100 EA/dx", "hard"])
def test_bar_on_a_rigid_wall(penalty, measured):
    """Contact .5 to 1.16667, impulse 200, whatever the law: no setting goes with it, and no energy comes of it."""
    gaps = channels(FOOT, 5.0, penalty * 900.0 * N / LENGTH)
    history = fly(system_of(M, K, velocity=np.full(N + 1, -SPEED)), gaps, 1.4)
    (event,) = touches(history, gaps, merge=0.05)
    # The wave runs through the mesh with its dispersion: a few elements of 200 at the end of the contact.
    assert event.t_start == pytest.approx(0.5, abs=1e-6)
    assert created_of_contact(history) < 1e-3
    law = "hard" if np.isinf(penalty) else f"penalty {penalty:g} EA/dx"
    measured(f"bar on a wall, {law}: impulse", event.impulse, 200.0, rel=0.005, unit="N s")
    measured(f"bar on a wall, {law}: end of contact", event.t_end, 7.0 / 6.0, rel=0.01, unit="s")


PERIOD, DURATION, IMPULSE = 16.0 / 3.0, 2.0 / 3.0, 800.0 / 3.0
ONSETS = np.array([k * PERIOD + at for k in range(5) for at in (1.0, 11.0 / 3.0)])


def test_bar_bounces_ten_times(measured):
    """Doyen, Ern, Piperno 2011: dropped from 5, two contacts of impulse 266.667 a period, at 1 and 11/3 of the first.

    The mesh spreads the wave fronts a little more with each blow, so that contact breaks up into touches and single
    ones drift; what all of them push, and the energy, stay. Later contacts hang on how numbers are rounded: a stiffness
    changed by 1e-13 moves the fifteenth by some per cent.
    """
    mass = 0.5 * (M + np.diag(M.sum(axis=1)))  # phase errors of the fourth order
    weight, gaps = -10.0 * mass.sum(axis=1), channels(FOOT, 5.0, 10.0 * 900.0 * N / LENGTH)
    step, end = 5e-3, 26.5
    time = step / SAMPLES * np.arange(SAMPLES * round(end / step) + 1)
    pulls = np.tile(weight[:2], (time.size, 1))
    loads = Loads(time, np.zeros((3, time.size, 0)), pulls, (np.array([0, N]), np.arange(1, N)))
    history = simulate_flow(diagonalise(system_of(mass, K)), gaps, loads, OutputRequest(np.array([0])))
    given = np.concatenate([[0.0], np.cumsum(history.weights * history.force[:, 0])])
    between = np.concatenate([0.5 * (ONSETS[1:] + ONSETS[:-1] + DURATION), [end]])
    impulses = np.diff(given[np.searchsorted(history.time, between)], prepend=0.0)
    touched = history.time[history.force[:, 0] > 0.0]
    first = np.array([touched[touched > at].min() for at in (0.0, between[0], between[1], between[2])])
    case, source = "bar that bounces ten times", "Doyen, Ern, Piperno 2011"
    for what, found, exact, bars in (
        ("onsets of the first four contacts, worst", first, ONSETS[:4], {"abs": 2e-3 * end, "unit": "s"}),
        ("impulses of the first four contacts, worst", impulses[:4], IMPULSE, {"rel": 5e-3, "unit": "N s"}),
        ("impulse of all ten contacts", given[-1], 10.0 * IMPULSE, {"rel": 5e-3, "unit": "N s"}),
    ):
        measured(f"{case}: {what}", found, exact, source=source, **bars)
    scheme = history.energy[:, ENERGIES.index("scheme")]
    assert np.abs(scheme).max() < 1e-3 * LENGTH * 10.0 * 5.0


def test_two_bars():
    """Short bar (L / 2, speed V) on a resting one of length L: contact 2 L1 / c, the short bar stops."""
    n1, n2 = N // 2, N
    M1, K1 = bar(n1, LENGTH / 2, 900.0, 1.0)
    M2, K2 = bar(n2, LENGTH, 900.0, 1.0)
    size = n1 + n2 + 2
    Mb, Kb = np.zeros((size, size)), np.zeros((size, size))
    Mb[: n1 + 1, : n1 + 1], Kb[: n1 + 1, : n1 + 1] = M1, K1
    Mb[n1 + 1 :, n1 + 1 :], Kb[n1 + 1 :, n1 + 1 :] = M2, K2
    v = np.concatenate([np.full(n1 + 1, SPEED), np.zeros(n2 + 1)])
    G = np.zeros((1, size))
    G[0, n1], G[0, n1 + 1] = -1.0, 1.0
    gaps = channels(G, 1.0, 1e5)
    history = fly(system_of(Mb, Kb, velocity=v), gaps, 0.7)
    event = touches(history, gaps, merge=0.01)[0]  # the faces stay together at rest: later touches are round-off
    assert event.t_start == pytest.approx(0.1, abs=1e-6)
    # The end of the pulse is a ramp of a few elements, dispersed on its way.
    assert event.t_end - event.t_start == pytest.approx(LENGTH / 30.0, rel=0.05)
    assert event.impulse == pytest.approx(LENGTH / 2 * SPEED, rel=0.01)


def test_steel_bar_in_si():
    """A steel rod of 100 mm at 1 m/s on a hard wall: 2 L / c = 38.7 us, far below the written 1 ms; impulse 2 m v."""
    E, rho, A, L, n = 210e9, 7850.0, 1e-4, 0.1, 100
    Ms, Ks = bar(n, L, E * A, rho * A)
    gaps = channels(np.eye(1, n + 1), 1e-3, 10.0 * E * A * n / L)
    history = fly(system_of(Ms, Ks, velocity=np.full(n + 1, -1.0)), gaps, 0.003)
    (event,) = touches(history, gaps, merge=1e-5)
    assert event.t_start == pytest.approx(1e-3, abs=1e-8)
    assert event.t_end - event.t_start == pytest.approx(2.0 * L / np.sqrt(E / rho), rel=0.02)
    assert event.impulse == pytest.approx(2.0 * rho * A * L, rel=0.01)


# --- friction -------------------------------------------------------------------------------------------------------

STIFF = 1e4
hardness = pytest.mark.parametrize("press", [1e6, 1e12], ids=["soft", "hard"])
"""N/m of the contact: the stiff one is followed by steps of lasting contact, 64 times as long as those of its spring."""


def pressed(force: float, static: float, kinetic: float, press: float) -> GapOperator:
    """Dof 1 is pressed to the ground with a preload; dof 0 rubs along it, dof 2 across."""
    g = channels([[0.0, 1.0, 0.0]], -force / press, press)
    along, across = (channels([row], 0.0, 0.0).G for row in ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]))
    friction = Friction(*(np.array([x]) for x in (static, kinetic, 0.0)))
    return replace(g, tangents=(along, across), friction=friction, preload=np.array([force]))


def rub(gaps: GapOperator, pull, end: float) -> History:
    return fly(system_of(np.eye(3), STIFF * np.eye(3), velocity=np.zeros(3)), gaps, end, [pull], [0])


@hardness
def test_coulomb_friction_takes_the_same_from_every_swing(press, measured):
    """m = 1, k = 1e4, mu N = 1, released at .85 mm: turns at -.65, .45, -.25, .05 mm, sticks at .1256637 s."""
    x0 = 0.85e-3
    history = rub(pressed(1.0, 1.0, 1.0, press), lambda t: -STIFF * x0 + 0.0 * t, 0.16)
    x, v = history.displacement[:, 0] + x0, history.sliding[:, 0]
    last = history.time[np.flatnonzero(v)[-1]]
    # A turning point is flat: the instant written next to it misses it by up to a h^2 / 8.
    for n, exact in enumerate((-0.65e-3, 0.45e-3, -0.25e-3, 0.05e-3), start=1):
        near = np.abs(history.time[history.output_index] - n * np.pi / 100.0) < 1e-3
        found = float(x[near][np.abs(x[near]).argmax()])
        measured(
            f"Coulomb oscillator: turning point {n}, contact of {press:.0e} N/m",
            found,
            exact,
            abs=1.5e-6,
            unit="m",
            section="friction, exact flow",
        )
    took = 0.5 * STIFF * (0.85e-3**2 - 0.05e-3**2)
    assert abs(work(history, "scheme")) < 1e-4 * took
    measured(
        f"Coulomb oscillator: time when it sticks, contact of {press:.0e} N/m",
        last,
        0.1256637,
        abs=2e-5,
        unit="s",
        section="friction, exact flow",
    )
    measured(
        f"Coulomb oscillator: energy taken, contact of {press:.0e} N/m",
        work(history, "friction"),
        took,
        rel=1e-6,
        unit="J",
        section="friction, exact flow",
    )


@hardness
def test_belt_squeaks(press, measured):
    """m = 1, k = 1e4, N = 10, mu .5 / .3, belt .01 m/s: stick .04 s, slip .04068888 s, 12.3932817 Hz."""
    history = rub(pressed(10.0, 0.5, 0.3, press), lambda t: STIFF * 0.01 * t, 0.4)
    slides = history.sliding[:, 0] != 0.0
    starts, ends = (history.time[np.flatnonzero(np.diff(slides.astype(int)) == s) + 1] for s in (1, -1))
    assert len(starts) >= 4
    # Slip begins and ends within a step near contact, 8 us.
    measured(
        f"block on a belt: period of 12.3932817 Hz, contact of {press:.0e} N/m",
        np.diff(starts)[1:],
        1 / 12.3932817,
        abs=2e-5,
        unit="s",
        section="friction, exact flow",
    )
    measured(
        f"block on a belt: slip, contact of {press:.0e} N/m",
        (ends - starts[: ends.size])[1:],
        0.04068888,
        abs=2e-5,
        unit="s",
        section="friction, exact flow",
    )


def test_oblique_impact_slides_and_leaves(measured):
    """A mass at 30 degrees on a stop with mu = .2: the tangential impulse is mu times the normal one, to the end."""
    gaps = channels([[0.0, 1.0, 0.0]], 1e-3, 1e6)
    along, across = (channels([row], 0.0, 0.0).G for row in ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]))
    gaps = replace(gaps, tangents=(along, across), friction=Friction(np.array([0.2]), np.array([0.2]), np.array([0.0])))
    v = np.array([np.sin(np.pi / 3), -np.cos(np.pi / 3), 0.0])
    history = fly(system_of(np.eye(3), 1e-9 * np.eye(3), velocity=v), gaps, 0.02)
    slope = np.diff(history.displacement, axis=0)[-1] / STEP
    np.testing.assert_allclose(slope, [v[0] - 0.2 * 2 * 0.5, 0.5, 0.0], atol=1e-4)
    measured(
        "oblique impact: speed along after it",
        slope[0],
        v[0] - 0.2,
        abs=1e-4,
        unit="m/s",
        section="friction, exact flow",
    )
