"""HHT-alpha: period error and numerical damping, prescribed motion, order, errors."""

from __future__ import annotations

import numpy as np
import pytest

from creak.assembly.coupling import Driven
from creak.assembly.part import Rayleigh
from creak.dynamics.history import ENERGIES, Interrupted
from creak.dynamics.loads import Loads, at_rest, follow
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import simulate
from creak.errors import InputError, NumericalError
from creak.linalg.factor import factor
from creak.linalg.modes import modes
from creak.reduction.craig_bampton import craig_bampton
from creak.reduction.diagonal import diagonalise
from creak.reduction.modal import modal_system, support_motion, with_modal_damping
from helpers_core import (
    NO_CHANNELS,
    NO_DAMPING,
    assembled,
    block,
    chain,
    channels,
    couple,
    forces_on,
    free_run,
    model_of,
    part_system,
    point_mass,
    spring,
    system_of,
    time_axis,
)

RECORDED = {"section": "time", "source": "closed form"}

PI2 = 2.0 * np.pi


def swing(alpha: float, steps_per_period: int, periods: int) -> tuple[float, float]:
    """Relative period error and damping ratio of a free oscillator, from its complex amplitude."""
    omega = PI2
    h = 1.0 / steps_per_period
    system = system_of(np.eye(1), np.array([[omega**2]]), velocity=np.ones(1))
    history = free_run(system, NO_CHANNELS, periods, h, alpha)
    u = history.displacement[:, 0]
    # The principal roots rule after a few steps: u_{n+1} = a u_n - b u_{n-1} has roots exp(-(zeta +- i) Omega_h).
    x, y = np.column_stack([u[20:-1], u[19:-2]]), u[21:]
    (a, minus_b), *_ = np.linalg.lstsq(x, y, rcond=None)
    root = np.roots([1.0, -a, -minus_b])[0]
    decay, turn = -np.log(abs(root)), abs(np.angle(root))
    return PI2 * h / turn - 1.0, decay / turn


def formulas(alpha: float, Omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Leading terms of period error and damping ratio."""
    return Omega**2 * (1 / 12 - alpha / 4 - 3 * alpha**2 / 8), -alpha * (1 + alpha) ** 2 * Omega**3 / 8


def draw(measured, alpha: float) -> None:
    """Points for the pictures of the manual."""
    steps = np.array([8, 10, 14, 20, 28, 40, 56])
    found, exact = np.array([swing(alpha, n, 30) for n in steps]).T, formulas(alpha, PI2 / steps)
    for name, x, y in zip(("period", "damping"), found, exact, strict=True):
        if y.all():
            measured.curve(f"hht {name}", f"alpha = {alpha:.3g}", 1.0 / steps, x, y)


@pytest.mark.parametrize(
    ("alpha", "period_error", "damping_ratio"), [(-0.05, 0.0361, 1.18e-3), (1.0 - np.sqrt(2.0), 0.0458, 3.64e-3)]
)
def test_period_error_and_damping_ratio_at_a_tenth_of_the_period(alpha, period_error, damping_ratio, measured):
    """h / T = .1: two rows of the published table, to half of their last digit."""
    period, damping = swing(alpha, 10, 40)
    case = f"HHT {alpha:.3g}, h/T = .1"
    measured(f"{case}: period error", period, period_error, abs=5e-5, source="published table")
    measured(f"{case}: damping ratio", damping, damping_ratio, abs=5e-6, source="published table")


def amplification(alpha: float, Omega: float) -> tuple[float, float]:
    """Period error and damping ratio of the principal roots of the scheme's matrix on (u, h v, h^2 a)."""
    beta, gamma = (1.0 - alpha) ** 2 / 4.0, 0.5 - alpha
    new = np.array([[1.0, 0.0, -beta], [0.0, 1.0, -gamma], [(1.0 + alpha) * Omega**2, 0.0, 1.0]])
    old = np.array([[1.0, 1.0, 0.5 - beta], [0.0, 1.0, 1.0 - gamma], [alpha * Omega**2, 0.0, 0.0]])
    roots = np.linalg.eigvals(np.linalg.solve(new, old))
    root = roots[np.argmax(roots.imag)]
    return Omega / np.angle(root) - 1.0, -np.log(abs(root)) / np.angle(root)


@pytest.mark.parametrize("alpha", [0.0, -0.05, -0.2, 1.0 - np.sqrt(2.0)])
@pytest.mark.parametrize("steps", [10, 30])
def test_period_error_and_damping_ratio_are_those_of_the_amplification_matrix(alpha, steps):
    np.testing.assert_allclose(swing(alpha, steps, 40), amplification(alpha, PI2 / steps), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("alpha", [0.0, -0.05, -0.2, 1.0 - np.sqrt(2.0)])
def test_period_error_and_damping_ratio_approach_their_leading_terms(alpha, measured):
    """Omega^2 (1/12 - a/4 - 3 a^2/8) and -a (1+a)^2 Omega^3 / 8."""
    Omega = PI2 / 60
    period, damping = swing(alpha, 60, 30)
    # The next terms are smaller by Omega^2 = 1 %.
    measured(
        f"HHT {alpha:.3g}, h/T = 1/60: period error",
        period,
        Omega**2 * (1 / 12 - alpha / 4 - 3 * alpha**2 / 8),
        rel=0.02,
        source="closed form, leading term",
    )
    measured(
        f"HHT {alpha:.3g}, h/T = 1/60: damping ratio",
        damping,
        -alpha * (1 + alpha) ** 2 * Omega**3 / 8,
        rel=0.05,
        abs=1e-9,
        source="closed form, leading term",
    )
    if measured.writing:
        draw(measured, alpha)


@pytest.mark.parametrize("alpha", [-0.05, -0.2, 1.0 - np.sqrt(2.0)])
def test_high_frequencies_die_with_the_spectral_radius(alpha, measured):
    """rho_inf = max((1+a)/(1-a), |a|/(1+a)): decay per step of a mode far above the step's band."""
    physical, spurious = (1 + alpha) / (1 - alpha), abs(alpha) / (1 + alpha)
    system = system_of(np.eye(1), np.array([[1e10]]), velocity=np.ones(1))
    u = np.abs(free_run(system, NO_CHANNELS, 20.0, 1.0, alpha).displacement[:, 0])
    # The physical root is double at infinity: it decays as n rho^n. From step 10 to 20 the others are .2 % of it.
    expected = physical * 2.0**0.1 if physical > spurious else spurious
    measured(
        f"HHT {alpha:.3g}: spectral radius at high frequency, ten steps", (u[20] / u[10]) ** 0.1, expected, rel=0.005
    )


@pytest.mark.parametrize("alpha", [0.0, -0.05, 1.0 - np.sqrt(2.0)])
def test_second_order_under_a_force(alpha, measured):
    """m u'' + c u' + k u = F sin(w t) from rest: the error falls by four with half the step."""
    m, zeta, w0, w = 2.0, 0.05, 20.0, 13.0
    k, c = m * w0**2, 2 * zeta * m * w0
    exact = driven_from_rest(m, c, k, 3.0, w)
    errors = []
    for h in (4e-3, 2e-3, 1e-3):
        time = time_axis(1.0, h)
        system = system_of(np.eye(1) * m, np.eye(1) * k, extra=np.eye(1) * c)
        history = simulate(
            system, NO_CHANNELS, forces_on(time, [0], 3.0 * np.sin(w * time)), HHT(alpha), OutputRequest(np.array([0]))
        )
        errors.append(np.abs(history.displacement[:, 0] - exact(time)).max())
    measured(
        f"HHT {alpha:.3g}, forced oscillator: order in the step",
        np.log2(np.array(errors[:-1]) / errors[1:]),
        2.0,
        abs=0.15,
    )


def driven_from_rest(m: float, c: float, k: float, force: float, w: float):
    """u(t) of m u'' + c u' + k u = force sin(w t), u(0) = u'(0) = 0."""
    H = force / (k - m * w**2 + 1j * c * w)
    w0, zeta = np.sqrt(k / m), c / (2 * np.sqrt(k * m))
    wd = w0 * np.sqrt(1 - zeta**2)
    u0, v0 = -H.imag, -(H * 1j * w).imag

    def u(t: np.ndarray) -> np.ndarray:
        free = np.exp(-zeta * w0 * t) * (u0 * np.cos(wd * t) + (v0 + zeta * w0 * u0) / wd * np.sin(wd * t))
        return (H * np.exp(1j * w * t)).imag + free

    return u


def test_step_force_overshoots_to_twice_the_static_deflection(measured):
    w0, h = 30.0, 1e-3
    time = time_axis(PI2 / w0, h)
    system = system_of(np.eye(1), np.eye(1) * w0**2)
    u = simulate(
        system, NO_CHANNELS, forces_on(time, [0], np.full(time.size, 5.0)), HHT(), OutputRequest(np.array([0]))
    )
    static = 5.0 / w0**2
    # (omega h)^2 / 12 of phase over one period: 6e-4 at most.
    measured(
        "step force: deflection over static, worst instant",
        u.displacement[:, 0] / static,
        1 - np.cos(w0 * time),
        abs=1e-3,
    )


@pytest.mark.parametrize("alpha", [-0.6, 0.1, np.nan])
def test_alpha_outside_its_range_is_refused(alpha):
    with pytest.raises(InputError, match=r"HHT alpha = .*from -1/2 to 0"):
        HHT(alpha)


def test_divergence_is_reported_with_its_time():
    """A negative stiffness grows without bound."""
    system = system_of(np.eye(1), -1e6 * np.eye(1), velocity=np.ones(1))
    with np.errstate(over="ignore", invalid="ignore"), pytest.raises(NumericalError, match=r"no longer finite at t ="):
        free_run(system, NO_CHANNELS, 2.0, 1e-3)


def test_output_interval_keeps_every_nth_step():
    M, K = chain(3)
    system = system_of(M, K, velocity=np.ones(3))
    loads = at_rest(time_axis(0.02, 1e-3))
    every, third = (
        simulate(system, NO_CHANNELS, loads, HHT(), OutputRequest(np.array([2, 0]), every=k)) for k in (1, 3)
    )
    np.testing.assert_array_equal(third.output_index, np.arange(0, 21, 3))
    np.testing.assert_array_equal(third.displacement, every.displacement[::3])
    assert third.energy.shape == every.energy.shape


# --- prescribed motion --------------------------------------------------------------------------------------


def base_driven(c: float = 0.0, rayleigh: Rayleigh = NO_DAMPING):
    """A mass on a spring whose other end is driven along x."""
    model = model_of(
        np.array([[0.0, 0, 0], [1.0, 0, 0]]),
        [block("mass", [[1]], point_mass(2.0)), block("spring2", [[0, 1]], spring(800.0, damping=c), 0, 10)],
    )
    return assembled(model, Driven({"base": np.array([0])}), rayleigh)


def moved(time: np.ndarray, s: np.ndarray, v: np.ndarray, a: np.ndarray) -> Loads:
    return Loads(time, np.stack([s, v, a])[:, :, None], np.zeros((time.size, 0)))


def sine_base(time: np.ndarray, w: float, amplitude: float = 1.0) -> Loads:
    x = w * time
    return moved(time, amplitude * np.sin(x), amplitude * w * np.cos(x), -amplitude * w**2 * np.sin(x))


@pytest.mark.parametrize("alpha", [0.0, -0.05])
def test_mass_on_a_driven_spring_follows_the_closed_form(alpha, measured):
    """m u'' + k (u - s) = 0 with s = sin(w t): u = (sin wt - (w/w0) sin w0 t) / (1 - (w/w0)^2)."""
    w0, w = 20.0, 7.0
    errors = []
    for h in (4e-3, 2e-3):
        time = time_axis(1.0, h)
        history = simulate(base_driven(), NO_CHANNELS, sine_base(time, w), HHT(alpha), OutputRequest(np.array([0, 6])))
        exact = (np.sin(w * time) - w / w0 * np.sin(w0 * time)) / (1 - (w / w0) ** 2)
        np.testing.assert_allclose(history.displacement[:, 0], np.sin(w * time), atol=1e-14)
        errors.append(np.abs(history.displacement[:, 1] - exact).max())
    # Period error (w0 h)^2 / 12 (1 + 3 |alpha|) over 3 periods, times 1.4: at most .002; second order.
    assert errors[1] < 5e-3
    measured(
        f"HHT {alpha:.3g}, mass on a driven spring: order in the step", np.log2(errors[0] / errors[1]), 2.0, abs=0.15
    )


def test_damper_and_mass_terms_of_the_support_reach_the_mass():
    """Spring and dashpot to the driven node, Rayleigh damping on top: transmissibility in the steady state."""
    c, alpha, beta, m, k, w = 18.0, 3.0, 8e-3, 2.0, 800.0, 25.0
    system = base_driven(c, Rayleigh(0.0, 0.0))
    time = time_axis(3.55, 1e-3)
    history = simulate(system, NO_CHANNELS, sine_base(time, w), HHT(), OutputRequest(np.array([6])))
    H = (k + 1j * c * w) / (k - m * w**2 + 1j * c * w)
    late = time > 3.25
    # Transients: exp(-c / 2m t) = 4e-7 at 3.25 s; (omega h)^2 / 4 / (2 zeta) of the response near resonance: 5e-4.
    expected = (H * np.exp(1j * w * time[late])).imag
    np.testing.assert_allclose(history.displacement[late, 0], expected, atol=3e-3 * abs(H))
    # Rayleigh damping is on absolute motion for alpha, on relative motion for beta.
    model = model_of(
        np.array([[0.0, 0, 0], [1.0, 0, 0]]),
        [block("mass", [[1]], point_mass(m)), block("spring2", [[0, 1]], spring(k), 0, 10)],
    )
    rayleigh = Rayleigh(alpha, beta)
    part = part_system(model, 0, rayleigh, override=True)
    overridden = couple([part], model, Driven({"base": np.array([0])}), rayleigh, override=True)
    history = simulate(overridden, NO_CHANNELS, sine_base(time, w), HHT(), OutputRequest(np.array([6])))
    H = (k + 1j * beta * k * w) / (k - m * w**2 + 1j * w * (beta * k + alpha * m))
    expected = (H * np.exp(1j * w * time[late])).imag
    np.testing.assert_allclose(history.displacement[late, 0], expected, atol=3e-3 * abs(H))


def test_work_of_the_support_is_its_reaction_times_way():
    """Undamped and unpressed: external work equals the stored energy, to HHT's own dissipation."""
    time = time_axis(1.0, 1e-3)
    w = 7.0
    rise = 0.5 * (1 - np.cos(w * time))
    loads = moved(time, rise, 0.5 * w * np.sin(w * time), 0.5 * w**2 * np.cos(w * time))
    history = simulate(base_driven(), NO_CHANNELS, loads, HHT(0.0), OutputRequest(np.array([6])))
    # Trapezoidal work is exact for alpha = 0.
    np.testing.assert_allclose(history.energy[:, ENERGIES.index("scheme")], 0.0, atol=1e-9 * history.energy_scale)
    assert history.energy[:, ENERGIES.index("external")].max() > 0.0


def from_rest(time: np.ndarray, w: float = 60.0, amplitude: float = 5e-3) -> Loads:
    """s = A sin^3(w t): speed and acceleration start at zero."""
    sin, cos = np.sin(w * time), np.cos(w * time)
    return moved(
        time, amplitude * sin**3, 3 * amplitude * w * sin**2 * cos, 3 * amplitude * w**2 * (2 * sin * cos**2 - sin**3)
    )


def plucked_chain(n: int = 16, extra: bool = False):
    """A chain of masses and springs along x, driven at node 0, free at the other end."""
    coords = np.column_stack([np.arange(float(n)), np.zeros(n), np.zeros(n)])
    links = np.column_stack([np.arange(n - 1), np.arange(1, n)])
    blocks = [
        block("mass", np.arange(n)[:, None], point_mass(0.2)),
        block("spring2", links, spring(2e4, damping=0.5 if extra else 0.0), 0, 100),
        *[block("spring1", np.arange(n)[:, None], spring(1e3, dof), 0, 100 * dof) for dof in (2, 3)],
    ]
    return model_of(coords, blocks, [("CHAIN", range(n))])


@pytest.mark.parametrize(("extra", "contact"), [(False, False), (False, True), (True, True)])
def test_all_modes_kept_equals_full_under_prescribed_motion(extra, contact):
    """The support's motion obeys Newmark's rule like the free dofs, so the change of basis loses nothing.

    With the support's exact derivatives the two differ by the scheme's error: this is why
    `loads.follow` exists.
    """
    n = 16
    model = plucked_chain(n, extra)
    drive, rayleigh = Driven({"base": np.array([0])}), Rayleigh(0.4, 2e-5)
    part = part_system(model, 0, rayleigh, override=True)
    boundary = np.flatnonzero(np.isin(part.coordinates, (0, 6 * (n - 1))))
    small = craig_bampton(part, boundary, count=10 * n)
    systems = [couple([p], model, drive, rayleigh, override=True) for p in (part, small)]
    systems.append(diagonalise(systems[1]))
    time = time_axis(0.3, 1e-3)
    tip = np.zeros((1, 6 * n))
    tip[0, 6 * (n - 1)] = -1.0
    gaps = channels(tip, 6e-3, 1e5) if contact else NO_CHANNELS
    observed = 6 * np.arange(n)
    runs = [simulate(s, gaps, from_rest(time), HHT(), OutputRequest(observed)) for s in systems]
    if contact:
        assert runs[0].contact_steps
    for other in runs[1:]:
        # Round-off. (Work at the supports is left out: its rule is trapezoidal, which depends on the coordinates.)
        for name in ("displacement", "force"):
            x, y = getattr(runs[0], name), getattr(other, name)
            np.testing.assert_allclose(y, x, rtol=0, atol=1e-8 * np.abs(x).max(initial=1e-300), err_msg=name)
        x, y = runs[0].energy[:, :5], other.energy[:, :5]
        np.testing.assert_allclose(y, x, rtol=0, atol=1e-8 * np.abs(x).max())


def test_work_at_a_support_is_the_same_in_absolute_and_in_relative_coordinates():
    """Modes on top of the static motion of the support hold all its inertia in M_qs, absolute coordinates none.

    Both march alike. The works differ by the trapezoidal rule's (omega h)^2 / 12 of what flows to and fro.
    """
    n, external, damping = 16, ENERGIES.index("external"), ENERGIES.index("damping")
    model, drive, rayleigh = plucked_chain(n), Driven({"base": np.array([0])}), Rayleigh(0.4, 2e-5)
    full = couple([part_system(model, 0, rayleigh, override=True)], model, drive, rayleigh, override=True)
    found = modes(full.K, full.M, count=full.n)
    relative = modal_system(full, found, support_motion(full, factor(full.K)), np.zeros((full.n, 0)))
    runs = [
        simulate(s, NO_CHANNELS, from_rest(time_axis(1.2, 1e-3)), HHT(), OutputRequest(6 * np.arange(n)))
        for s in (full, relative)
    ]
    first = runs[0].energy[-1]
    assert first[damping] > 0.1 * first[external] > 0.0
    for other in runs[1:]:
        np.testing.assert_allclose(other.energy[-1], first, rtol=0, atol=2e-3 * first[external])
    assert max(run.energy_created for run in runs) < 1e-5


def test_all_modes_kept_equals_full_when_the_support_starts_with_a_speed():
    """A sine as prescribed displacement starts with the speed A w, and a step with the displacement A."""
    n = 16
    model, drive = plucked_chain(n), Driven({"base": np.array([0])})
    part = part_system(model, 0, NO_DAMPING)
    small = craig_bampton(part, np.flatnonzero(np.isin(part.coordinates, (0, 6 * (n - 1)))), count=10 * n)
    a, b = (
        simulate(
            couple([p], model, drive, NO_DAMPING),
            NO_CHANNELS,
            sine_base(time_axis(0.3, 1e-3), 60.0),
            HHT(),
            OutputRequest(6 * np.arange(n)),
        ).displacement
        for p in (part, small)
    )
    np.testing.assert_allclose(b, a, rtol=0, atol=1e-8 * np.abs(a).max())


def test_consistent_motion_keeps_the_displacement_and_obeys_newmark():
    time = time_axis(0.5, 1e-2)
    loads, scheme = sine_base(time, 9.0), HHT()
    h = 1e-2
    followed = [loads.support[:, 0]]
    for displacement in loads.support[0, 1:]:
        followed.append(follow(followed[-1], displacement, scheme, h))
    s, v, a = np.array(followed)[:, :, 0].T
    np.testing.assert_array_equal(s, loads.support[0, :, 0])
    np.testing.assert_allclose(
        s[1:], s[:-1] + h * v[:-1] + h**2 * ((0.5 - scheme.beta) * a[:-1] + scheme.beta * a[1:]), atol=1e-13
    )
    np.testing.assert_allclose(v[1:], v[:-1] + h * ((1 - scheme.gamma) * a[:-1] + scheme.gamma * a[1:]), atol=1e-12)
    # Velocity stays second order: (w h)^2 / 6 of w.
    np.testing.assert_allclose(v, loads.support[1, :, 0], atol=9.0 * 0.09**2)


def test_full_and_reduced_agree_with_modal_damping():
    """zeta on the same modes of both: M Phi diag(2 zeta omega) Phi' M."""
    n = 12
    model = plucked_chain(n)
    drive = Driven({"base": np.array([0])})
    part = part_system(model, 0, NO_DAMPING)
    boundary = np.flatnonzero(np.isin(part.coordinates, (0, 6 * (n - 1))))
    runs = []
    for p in (part, craig_bampton(part, boundary, count=10 * n)):
        system = couple([p], model, drive, NO_DAMPING)
        K, M = (np.asarray(A.toarray() if hasattr(A, "toarray") else A) for A in (system.K, system.M))
        found = modes(K, M, count=system.n)
        damped = with_modal_damping(system, found, support_motion(system, factor(K)), 0.03)
        runs.append(
            simulate(damped, NO_CHANNELS, from_rest(time_axis(0.3, 1e-3)), HHT(), OutputRequest(6 * np.arange(n)))
        )
    scale = np.abs(runs[0].displacement).max()
    np.testing.assert_allclose(runs[1].displacement, runs[0].displacement, atol=1e-8 * scale)  # round-off


@pytest.mark.parametrize("sparse", [True, False])
def test_modal_damping_gives_each_mode_its_fraction(sparse, measured):
    """Free decay of one mode: u = exp(-zeta w t) sin(w_d t), on full and dense Systems alike."""
    M, K = chain(6)
    omega2, Phi = np.linalg.eigh(K)
    zeta, mode = 0.04, 2
    system = system_of(M, K, velocity=Phi[:, mode], sparse=sparse)
    found = modes(system.K, system.M, count=6)
    damped = with_modal_damping(system, found, np.zeros((6, 0)), zeta)
    w = np.sqrt(omega2[mode])
    h = PI2 / w / 400
    history = free_run(damped, NO_CHANNELS, 6 * PI2 / w, h)
    wd = w * np.sqrt(1 - zeta**2)
    exact = np.exp(-zeta * w * history.time) * np.sin(wd * history.time) / wd
    amplitude = history.displacement @ Phi[:, mode]
    # Phase error (w h)^2 / 10 x 2 pi 6 = 1e-3.
    measured("modal damping of 4 %: amplitude of a mode, error", np.abs(amplitude - exact).max() * w, at_most=1.5e-3)
    others = np.delete(history.displacement @ Phi, mode, axis=1)
    np.testing.assert_allclose(others, 0.0, atol=1e-10 / w)


def test_ctrl_c_keeps_what_was_computed():
    """The interrupt comes with a call of progress; all instants before it are there."""
    system = diagonalise(system_of(np.eye(2), np.diag([1e4, 2e4]), velocity=np.ones(2), sparse=False))

    def interrupt(done: int, total: int) -> None:
        if done >= 2000:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted, match=r"^stopped at t = 2 s$") as stop:
        simulate(
            system, NO_CHANNELS, at_rest(time_axis(5.0, 1e-3)), HHT(), OutputRequest(np.arange(2)), progress=interrupt
        )
    history = stop.value.history
    assert history.time.size == 2001
    assert history.displacement.shape == (2001, 2)
    assert np.isfinite(history.displacement).all()
    assert np.abs(history.displacement[-100:]).max() > 0.0
