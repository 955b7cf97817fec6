"""The compiled march of diagonal Systems: the same run as `simulate`, to round-off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from creak.assembly.damping import Damping
from creak.assembly.part import Rayleigh
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.contact.laws.parameters import Curves, Friction
from creak.dynamics.history import ENERGIES, History
from creak.dynamics.loads import Loads, at_rest
from creak.dynamics.modal.coefficients import MasslessBoundary, exact_step, is_modal
from creak.dynamics.modal.march import simulate_modal
from creak.dynamics.modal.taper import participation, tapered
from creak.dynamics.scheme import HHT, Scheme, generalised_alpha
from creak.dynamics.simulate import simulate
from creak.dynamics.stopped import Diverged
from creak.errors import InputError, NumericalError
from creak.linalg.diagonal import Diagonal
from creak.reduction.diagonal import diagonalise
from creak.reduction.massless_boundary import massless_boundary
from helpers_core import chain, channels, system_of, time_axis
from helpers_gap import N, cantilevers, gap_rows, gaps_between, multisine_base

TIP, OTHER = 6 * N + 1, 6 * (2 * N + 1) + 1
OBSERVED = np.array([TIP, TIP - 6, OTHER])
SAME = {"rtol": 0.0}


def driven(velocity: bool = False, modal: bool = False) -> System:
    """Two beams on a moving base in their own modes."""
    full = cantilevers(Rayleigh(5.0, 1e-6))
    if velocity:
        full = replace(full, velocity=np.linspace(0.0, 0.3, full.n))
    small = diagonalise(full)
    if modal:
        n = small.n
        values = 0.04 * np.sqrt(small.K.d[:10])
        small = replace(small, damping=Damping(2.0, 0.0, None, np.eye(n, 10), values))
    return small


def loads_of(end: float = 0.1, step: float = 2e-4) -> Loads:
    """A moving base and a force at a tip."""
    base = multisine_base(time_axis(end, step), 20.0, 400.0, 2e-4)
    force = 0.5 * np.sin(2.0 * np.pi * 70.0 * base.time)
    return replace(base, force=force[:, None], force_labels=(np.array([TIP]),))


def rubbing(gaps: GapOperator, static: float = 3.0, kinetic: float = 2.0, decay: float = 0.0) -> GapOperator:
    """The same channels with friction in the second: along x by the turning of the thick beams, and along z."""
    tangents = []
    for dof, arm in ((5, 0.02), (2, 1.0)):
        T = np.zeros(gaps.G.shape)
        for row, node in enumerate((N // 2, N)):
            T[row, 6 * node + dof], T[row, 6 * (N + 1 + node) + dof] = -arm, 0.7 * arm
        tangents.append(sp.csr_matrix(T))
    friction = Friction(np.array([0.0, static]), np.array([0.0, kinetic]), np.array([0.0, decay]))
    return replace(gaps, tangents=tuple(tangents), friction=friction)


def assert_same(a: History, b: History, tol: float = 1e-10) -> None:
    """All that a run leaves behind, relative to its largest value."""
    np.testing.assert_array_equal(a.time, b.time)
    np.testing.assert_array_equal(a.output_index, b.output_index)
    assert a.contact_steps == b.contact_steps
    for name in ("gap", "force", "displacement", "slip", "tangential", "sliding", "coordinates", "energy"):
        x, y = getattr(a, name), getattr(b, name)
        assert x.shape == y.shape, name
        scale = np.abs(x).max(initial=0.0)
        np.testing.assert_allclose(y, x, rtol=0.0, atol=tol * max(scale, 1e-9), err_msg=name)


def both(system: System, gaps: GapOperator, loads: Loads, scheme: Scheme, **options: object) -> tuple[History, History]:
    assert is_modal(system)
    a, b = (run(system, gaps, loads, scheme, observed=OBSERVED, **options) for run in (simulate, simulate_modal))
    return a, b


# --- the same as the general integrator ---------------------------------------------------------------------


@pytest.mark.parametrize(
    "scheme", [HHT(0.0), HHT(-0.05), HHT(1.0 - np.sqrt(2.0)), generalised_alpha(0.9), generalised_alpha(0.2)]
)
def test_equals_simulate(scheme, measured):
    """Contact with dampers, moving base, force and initial velocity."""
    a, b = both(driven(velocity=True), gaps_between(2e-4, 3e4, 0.5), loads_of(), scheme)
    assert 20 < a.contact_steps < 480
    assert_same(a, b)
    measured(
        "time",
        "compiled march: force, relative difference",
        np.abs(a.force - b.force).max() / a.force.max(),
        at_most=1e-10,
        source="general march",
    )


def test_equals_simulate_with_modal_damping_and_sparse_output():
    gaps, at = gaps_between(2e-4, 3e4), np.array([0, 7, 500])
    a, b = both(driven(modal=True), gaps, loads_of(), HHT(), output_every=3, whole_at=at)
    assert a.contact_steps > 20
    assert a.displacement.shape == (167, 3)
    assert_same(a, b)


@pytest.mark.parametrize("decay", [0.0, 0.05])
def test_equals_simulate_with_friction_and_hard_contact(decay, measured):
    gaps = rubbing(gaps_between(2e-4, np.array([np.inf, 3e4])), decay=decay)
    a, b = both(driven(), gaps, loads_of(), HHT(1.0 - np.sqrt(2.0)))
    slides = np.abs(a.sliding).max(axis=1) > 1e-6
    pressed = a.force[:, 1] > 0.0
    assert 5 < np.count_nonzero(slides) < np.count_nonzero(pressed) - 5
    assert a.energy[-1, ENERGIES.index("friction")] > 0.0
    assert_same(a, b, 1e-8)  # forces of hard contact are a quotient of small numbers
    error = np.abs(a.tangential - b.tangential).max() / np.abs(a.tangential).max()
    measured(
        "time",
        "compiled march, friction and hard contact: friction force, relative difference",
        error,
        at_most=1e-8,
        source="general march",
    )


def test_equals_simulate_with_curves_and_preload():
    points = np.array([[0.0, 0.0], [1e-5, 1.0], [2e-5, 4.0]])
    curves = Curves(np.array([0, -1]), np.array([0.5, 1.0]), (points,))
    gaps = replace(gaps_between(np.array([2e-4, -1e-5]), 3e4), curves=curves, preload=np.array([0.0, 0.3]))
    a, b = both(driven(), gaps, loads_of(), HHT())
    assert a.force.min(axis=0).max() == 0.0
    assert (a.force.max(axis=0) > 0.1).all()
    assert_same(a, b)


@pytest.mark.parametrize("scheme", [HHT(-0.05), generalised_alpha(0.8)])
def test_divided_steps_equal_simulate(scheme):
    """Whole steps in free flight, ten parts each near contact."""
    loads = loads_of(0.1, 2e-5)
    a, b = both(driven(), gaps_between(2e-4, 3e5, 0.5), loads, scheme, substeps=10, output_every=5)
    steps = np.unique(np.round(np.diff(a.time) / 2e-5))
    np.testing.assert_array_equal(steps, [1.0, 10.0])
    assert_same(a, b)


def test_massless_coordinates_equal_simulate():
    full, gaps = cantilevers(Rayleigh(5.0, 1e-6)), gaps_between(2e-4, 3e5)
    small = massless_boundary(full, gap_rows(full, gaps), count=9)
    a, b = both(small, gaps, loads_of(), HHT())
    assert a.contact_steps > 20
    assert_same(a, b)


def test_many_chunks_are_one_run(monkeypatch):
    one = simulate_modal(driven(), gaps_between(2e-4, 3e5), loads_of(), HHT(), observed=OBSERVED, output_every=4)
    monkeypatch.setattr("creak.dynamics.record.recorder.CHUNK", 7)
    seen: list[tuple[int, int]] = []
    many = simulate_modal(
        driven(),
        gaps_between(2e-4, 3e5),
        loads_of(),
        HHT(),
        observed=OBSERVED,
        output_every=4,
        progress=lambda done, total: seen.append((done, total)),
    )
    assert_same(one, many, 1e-14)  # output is turned into motion by products of another size
    assert seen[0] == (7, 500)
    assert seen[-1] == (500, 500)
    assert len(seen) == 72


def test_instants_one_by_one_are_the_output_of_many_chunks(monkeypatch):
    """The general march: parts of steps near contact, output every fourth step, all coordinates at some."""
    given = {"substeps": 5, "output_every": 4, "whole_at": np.array([0, 4, 48, 97])}
    one, twin = both(driven(), gaps_between(2e-4, 3e5), loads_of(), HHT(), **given)
    monkeypatch.setattr("creak.dynamics.record.recorder.CHUNK", 7)
    many, _ = both(driven(), gaps_between(2e-4, 3e5), loads_of(), HHT(), **given)
    assert one.contact_steps > 5
    assert one.coordinates.shape[1] == 4
    assert_same(one, many, 1e-14)
    assert_same(many, twin)


# --- failures -------------------------------------------------------------------------------------------------


def test_what_was_computed_survives_a_divergence():
    loads = loads_of()
    force = loads.force.copy()
    force[300:] = np.inf
    with pytest.raises(Diverged, match=r"t = 0\.06 s") as caught:
        simulate_modal(driven(), gaps_between(), replace(loads, force=force), HHT(), observed=OBSERVED)
    history = caught.value.history
    assert isinstance(caught.value, NumericalError)
    assert history.time.size == 300
    assert history.displacement.shape == (300, 3)
    assert np.isfinite(history.energy).all()


def test_damping_that_couples_modes_is_refused():
    system = driven()
    mixed = replace(system, damping=Damping(0.0, 0.0, None, np.ones((system.n, 1)), np.ones(1)))
    assert not is_modal(mixed)
    with pytest.raises(InputError, match="diagonal"):
        simulate_modal(mixed, gaps_between(), loads_of(), HHT(), observed=OBSERVED)


def test_samples_must_be_whole_steps():
    with pytest.raises(InputError, match="multiple of 3"):
        simulate_modal(driven(), gaps_between(), loads_of(), HHT(), observed=OBSERVED, substeps=3)


# --- the exact step -------------------------------------------------------------------------------------------


def one_mode(m: float, c: float, k: float) -> System:
    damping = Damping(0.0, 0.0, None, np.eye(1), np.array([c]))
    return replace(
        system_of(np.eye(1), np.eye(1)), M=Diagonal(np.array([m])), K=Diagonal(np.array([k])), damping=damping
    )


@pytest.mark.parametrize("c", [0.0, 0.4, 24.0, 48.0, 60.0])
@pytest.mark.parametrize("h", [1e-3, 0.02, 0.5, 3.0])
def test_exact_step_is_the_matrix_exponential(c, h):
    """Under-, critically and overdamped mode under a load that is linear over the step, against many small steps."""
    m, k = 2.0, 288.0
    whole, part = (exact_step(np.array([m]), np.array([c]), np.array([k]), x).free[:, 0] for x in (h, h / 4096))
    u, v, area, E0, E1 = 0.3, -1.7, 0.0, 5.0, -2.0
    x, y = u, v
    for n in range(4096):
        e0, e1 = (E0 + (E1 - E0) * j / 4096 for j in (n, n + 1))
        area += part[4] * x + part[5] * y + part[10] * e0 + part[11] * e1
        x, y = (
            part[0] * x + part[1] * y + part[6] * e0 + part[7] * e1,
            part[2] * x + part[3] * y + part[8] * e0 + part[9] * e1,
        )
    np.testing.assert_allclose(whole[0] * u + whole[1] * v + whole[6] * E0 + whole[7] * E1, x, atol=1e-10)
    np.testing.assert_allclose(whole[2] * u + whole[3] * v + whole[8] * E0 + whole[9] * E1, y, atol=1e-9)
    np.testing.assert_allclose(whole[4] * u + whole[5] * v + whole[10] * E0 + whole[11] * E1, area, atol=1e-10)


@pytest.mark.parametrize("step", [1e-4, 0.01, 0.2])
def test_free_flight_and_its_energies_are_exact_for_any_step(step, measured):
    """x = cos / exp of a damped mode; what it lost is in the column of damping, the scheme makes nothing."""
    m, c, k = 2.0, 3.0, 800.0
    system = replace(one_mode(m, c, k), velocity=np.array([1.0]))
    gaps = channels(np.eye(1), 1e3, 0.0)
    history = simulate_modal(system, gaps, at_rest(time_axis(0.8, step)), MasslessBoundary(), observed=np.array([0]))
    t, d = history.time, c / (2.0 * m)
    w = np.sqrt(k / m - d * d)
    np.testing.assert_allclose(history.displacement[:, 0], np.exp(-d * t) * np.sin(w * t) / w, atol=1e-12)
    error = np.abs(history.displacement[:, 0] - np.exp(-d * t) * np.sin(w * t) / w).max()
    measured(
        "time", "massless march, free flight: displacement, error", error, at_most=1e-12, unit="m", source="closed form"
    )
    np.testing.assert_allclose(history.energy[:, ENERGIES.index("scheme")], 0.0, atol=1e-12)
    assert history.energy[-1, ENERGIES.index("damping")] == pytest.approx(1.0 - history.energy[-1, :2].sum())


def test_external_work_is_exact_for_any_step():
    """Moving base and a force, no contact: steps of 2e-3 s book the energies of steps of 1e-5 s."""
    system, gaps = driven(), gaps_between()
    fine = loads_of(0.1, 1e-5)
    kinked = np.interp(fine.time, fine.time[::200], fine.force[::200, 0])[:, None]
    still = replace(fine, support=np.zeros_like(fine.support), force=kinked)
    coarse = replace(still, time=still.time[::200], support=still.support[:, ::200], force=still.force[::200])
    a, b = (simulate_modal(system, gaps, x, MasslessBoundary(), observed=OBSERVED) for x in (still, coarse))
    scale = np.abs(a.energy).max()
    np.testing.assert_allclose(b.energy, a.energy[::200], atol=1e-9 * scale)
    np.testing.assert_allclose(a.energy[:, -1], 0.0, atol=1e-9 * scale)
    np.testing.assert_allclose(b.displacement, a.displacement[::200], atol=1e-10 * np.abs(a.displacement).max())


def test_moving_base_balances_its_energy():
    """The trapezoidal work at the supports and the exact one agree as the step falls."""
    system, gaps = driven(), gaps_between()
    loads = loads_of(0.05, 5e-6)
    a = simulate_modal(system, gaps, loads, HHT(0.0), observed=OBSERVED)
    b = simulate_modal(system, gaps, loads, MasslessBoundary(), observed=OBSERVED)
    scale = np.abs(a.energy).max()
    np.testing.assert_allclose(b.energy, a.energy, atol=2e-3 * scale)
    np.testing.assert_allclose(b.energy[:, -1], 0.0, atol=1e-9 * scale)


# --- the massless boundary --------------------------------------------------------------------------------------


def chain_on_stop(count: int = 20) -> tuple[System, GapOperator]:
    M, K = chain(30)
    full = system_of(M, K, velocity=-np.linalg.eigh(K)[1][:, 0])
    return massless_boundary(full, np.eye(30)[[29]], count=count), channels(np.eye(30)[[29]], 0.01, np.inf)


def test_hard_contact_is_converged_hht():
    """Steps of HHT a hundred times finer agree on the impulse (its force rings where the massless one does)."""
    system, gaps = chain_on_stop()
    start = replace(system, velocity=-np.abs(system.velocity[0]) * np.eye(system.n)[0])
    exact = simulate_modal(start, gaps, at_rest(time_axis(0.3, 1e-4)), MasslessBoundary(), observed=np.arange(30))
    hht = simulate_modal(start, gaps, at_rest(time_axis(0.3, 1e-5)), HHT(), observed=np.arange(30))
    assert 100 < exact.contact_steps < exact.time.size
    impulses = [h.weights @ h.force[:, 0] for h in (exact, hht)]
    assert impulses[0] == pytest.approx(impulses[1], rel=5e-3)
    assert exact.gap.min() > -1e-12
    assert np.abs(exact.energy[:, -1]).max() < 1e-3 * exact.energy[0, 0]


def test_coulomb_friction_turns_and_sticks_where_it_should():
    """m = 1, k = 1e4, mu N = 1: turns at .65, -.45, .25, -.05 mm and sticks; friction takes all that was not left."""
    stiff = 1e8
    coordinates = replace(
        system_of(np.eye(4), np.eye(4), velocity=[np.sqrt(1e4 * 0.65e-3**2 + 2.0 * 0.65e-3), 0.0, 0.0, 0.0]),
        M=Diagonal(np.array([1.0, 0.0, 0.0, 0.0])),
        K=Diagonal(np.array([1e4, stiff, stiff, 1e6])),
    )
    rows = np.eye(4)
    gaps = channels(rows[[3]], -1e-5, np.inf)
    friction = Friction(np.array([0.1]), np.array([0.1]), np.array([0.0]))
    gaps = replace(gaps, tangents=(sp.csr_matrix(rows[[0]] + rows[[1]]), sp.csr_matrix(rows[[2]])), friction=friction)
    loads = at_rest(time_axis(0.13, 1e-5))
    history = simulate_modal(coordinates, gaps, loads, MasslessBoundary(), observed=np.arange(1))
    x = history.displacement[:, 0]
    turns = x[1:-1][(np.diff(x)[1:] * np.diff(x)[:-1]) < 0.0]
    # Half a step of friction is missed at the start and where it changes sign: h / 2 mu N / (m omega) = 5e-8.
    np.testing.assert_allclose(turns[:4], [0.65e-3, -0.45e-3, 0.25e-3, -0.05e-3], atol=1e-7)
    # Stuck, it hangs on the tangent's flexibility: stiff / (stiff + k) of its force, an elastic tremble of mu N / stiff.
    assert np.abs(x[-300:] - x[-300:].mean()).max() < 2.0 / stiff
    assert x[-300:].mean() == pytest.approx(-0.05e-3, abs=1e-7 + 2.0 / stiff)
    np.testing.assert_allclose(history.force[1:, 0], 10.0, rtol=1e-12)
    friction_work = history.energy[-1, ENERGIES.index("friction")]
    assert friction_work == pytest.approx((0.65 + 1.1 + 0.7 + 0.3) * 1e-3, rel=1e-3)
    assert np.abs(history.energy[:, ENERGIES.index("scheme")]).max() < 1e-3 * history.energy[0, 0]


def test_channel_without_residual_flexibility_is_refused():
    M, K = chain(10)
    small = diagonalise(system_of(M, K))
    gaps = channels(np.eye(10)[[9]], 0.1, np.inf)
    with pytest.raises(InputError, match=r"no residual flexibility, the first stop:0"):
        simulate_modal(small, gaps, at_rest(time_axis(0.1, 1e-3)), MasslessBoundary(), observed=np.arange(10))


def test_step_that_does_not_follow_the_contact_springs_is_refused():
    system, gaps = chain_on_stop()
    with pytest.raises(InputError, match="times the time scale of the contact springs"):
        simulate_modal(system, gaps, at_rest(time_axis(0.1, 2e-2)), MasslessBoundary(), observed=np.arange(3))


# --- fading modes -----------------------------------------------------------------------------------------------


def test_fading_modes_keep_static_answers():
    """Channel forces find the full flexibility, and the motion they cause is that of the whole structure."""
    M, K = chain(30)
    G = np.eye(30)[[29, 11]]
    small = massless_boundary(system_of(M, K), G, count=6)
    soft = tapered(small, small.rows(np.array([29, 11]))[0])
    V = soft.rows(np.arange(30))[0]
    static = V @ ((V.T @ G.T) / soft.K.d[:, None])
    np.testing.assert_allclose(static, np.linalg.solve(K, G.T), rtol=1e-9)
    np.testing.assert_allclose(soft.recover(np.eye(soft.n)), V, atol=1e-12)
    np.testing.assert_allclose(soft.combined(G, np.arange(30))[0], G @ V, atol=1e-12)
    assert soft.combine is not None
    assert soft.n == small.n + 2
    sigma = participation(np.sqrt(small.K.d[:6]), 2.0 * np.pi * small.stats.first_left_out)
    np.testing.assert_allclose(V[:, :6], small.rows(np.arange(30))[0][:, :6] * np.sqrt(sigma), rtol=1e-12)


def test_fading_rigid_body_is_untouched():
    system = driven(velocity=True)
    soft = tapered(system, np.zeros((0, system.n)), cut=1e12)
    np.testing.assert_allclose(soft.velocity, system.velocity, rtol=1e-6)
    with pytest.raises(InputError, match="columns"):
        tapered(system, np.zeros((1, 3)))
