"""Craig-Bampton and diagonalisation: what they keep exactly."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as sla

from creak.arrays import to_dense
from creak.assembly.part import Rayleigh
from creak.assembly.system import System
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import simulate
from creak.errors import NumericalError
from creak.linalg import memory
from creak.linalg.diagonal import Diagonal
from creak.linalg.modes import modes
from creak.model.constraints import Fixed, RigidLink
from creak.model.mesh import Model
from creak.reduction import constraint_modes
from creak.reduction.craig_bampton import craig_bampton, fixed_interface_basis, reduced_matrices, reduced_system
from creak.reduction.diagonal import diagonalise
from creak.reduction.inside import Inside
from helpers_core import (
    NO_CHANNELS,
    NO_DAMPING,
    NONE,
    assembled,
    beam_section,
    block,
    chain,
    channels,
    couple,
    forces_on,
    free_run,
    model_of,
    part_system,
    plate,
    point_mass,
    shell,
    spring,
    system_of,
    time_axis,
)

RECORDED = {"section": "reduction", "source": "full model"}

EVERY = 10_000


def two_beams(**extra: object) -> Model:
    """Two beams end to end, tied at the middle, clamped at one end; an L so that all motions couple."""
    n = 6
    a = np.column_stack([np.linspace(0.0, 0.5, n + 1), np.zeros(n + 1), np.zeros(n + 1)])
    b = np.column_stack([np.full(n + 1, 0.5), np.linspace(0.0, 0.4, n + 1), np.linspace(0.0, 0.1, n + 1)])
    e = np.column_stack([np.arange(n), np.arange(1, n + 1)])
    return model_of(
        np.vstack([a, b]),
        [block("beam2", e, beam_section(), 0), block("beam2", e + n + 1, beam_section(), 1, 100)],
        [("A", range(n + 1)), ("B", range(n + 1, 2 * n + 2))],
        constraints=[RigidLink("tie", n + 1, n)],
        fixed=[Fixed(np.array([0]), (1, 2, 3, 4, 5, 6))],
        **extra,
    )


END = 13
"""Node row of the free end."""


def joined(model: Model, rayleigh: Rayleigh, count: int | None, retain: tuple[int, ...] = (0, 6, 7, END)) -> System:
    """The assembly, unreduced for None, else with `count` modes per part."""
    parts = [part_system(model, i, rayleigh, override=True) for i in range(2)]
    if count is not None:
        parts = [craig_bampton(p, np.flatnonzero(np.isin(p.coordinates // 6, retain)), count=count) for p in parts]
    return couple(parts, model, NONE, rayleigh, override=True)


def test_all_modes_kept_matches_full_model_frequencies(measured):
    full, reduced = (joined(two_beams(), NO_DAMPING, count) for count in (None, EVERY))
    a = sla.eigh(to_dense(full.K), to_dense(full.M), eigvals_only=True)
    b = sla.eigh(to_dense(reduced.K), to_dense(reduced.M), eigvals_only=True)
    # Round-off: eps x (largest / smallest eigenvalue), which is some 1e7 here.
    measured("two beams, all modes: omega^2 over full, worst", b / a, 1.0, rel=1e-8)


@pytest.mark.parametrize("contact", [False, True])
def test_all_modes_kept_matches_full_model_in_a_transient(contact, measured):
    """A change of basis changes nothing, with Rayleigh damping and with a stop in the way."""
    rayleigh, labels = Rayleigh(3.0, 1e-5), np.array([6 * END + 1, 6 * END + 2, 6 * 7 + 1])
    time = time_axis(0.05, 2e-4)
    loads = forces_on(time, [6 * END + 2], 40.0 * np.sin(2 * np.pi * 60.0 * time))
    tip = np.zeros((1, 6 * 14))
    tip[0, 6 * END + 2] = -1.0
    gaps = channels(tip, 1e-3, 1e5) if contact else NO_CHANNELS
    runs = [
        simulate(s, gaps, loads, HHT(), OutputRequest(labels))
        for s in (joined(two_beams(), rayleigh, None), joined(two_beams(), rayleigh, EVERY))
    ]
    assert contact == bool(runs[0].contact_steps)
    for name in ("displacement", "force"):
        a, b = getattr(runs[0], name), getattr(runs[1], name)
        # Round-off, amplified by the conditioning of K.
        error = np.abs(a - b).max(initial=0.0) / max(np.abs(a).max(initial=0.0), 1e-300)
        measured(
            f"two beams, all modes, transient{' in contact' if contact else ''}: {name}, relative error",
            error,
            at_most=1e-8,
        )


def test_fewer_modes_give_upper_bounds_and_static_response_stays_exact(measured):
    model = two_beams()
    full = joined(model, NO_DAMPING, None)
    exact = sla.eigh(to_dense(full.K), to_dense(full.M), eigvals_only=True)
    labels = 6 * END + np.arange(6)
    flexibility = None
    for count in (0, 2, 5, 9):
        reduced = joined(model, NO_DAMPING, count)
        omega2 = sla.eigh(to_dense(reduced.K), to_dense(reduced.M), eigvals_only=True)
        assert (omega2 >= exact[: omega2.size] * (1 - 1e-8)).all()  # Rayleigh-Ritz, to round-off
        for system in (full, reduced):
            R = to_dense(system.rows(labels)[0])
            answer = R @ np.linalg.solve(to_dense(system.K), R.T)
            flexibility = answer if flexibility is None else flexibility
            # round-off
            error = np.abs(answer - flexibility).max() / np.abs(flexibility).max()
            measured("two beams, 0 to 9 modes: static answer, relative error", error, at_most=1e-9)


def free_plate() -> System:
    coords, quads = plate(5, 3, (0.4, 0.3))
    return part_system(model_of(coords, [block("quad4", quads, shell(1e-3))]), 0, NO_DAMPING)


def rigid_motions(coords: np.ndarray) -> np.ndarray:
    from helpers_fem import rigid_modes

    return rigid_modes(coords)


@pytest.mark.parametrize("count", [0, 4])
def test_rigid_body_mass_and_inertia_are_exact(count, measured):
    """Psi reproduces rigid motion, so mass, centre of gravity and inertia survive any truncation."""
    system = free_plate()
    coords = plate(5, 3, (0.4, 0.3))[0]
    r = rigid_motions(coords)
    r = r[system.coordinates]
    boundary = np.flatnonzero(np.isin(system.coordinates // 6, (0, 3, 20)))
    small = craig_bampton(system, boundary, count=count)
    r_small = np.vstack([r[boundary], np.zeros((small.n - boundary.size, 6))])
    exact = r.T @ (system.M @ r)
    # Round-off of K_ii^-1 K_ib.
    error = np.abs(r_small.T @ small.M @ r_small - exact).max() / np.abs(exact).max()
    measured("free plate: rigid-body mass matrix, relative error", error, at_most=1e-8)
    assert exact[0, 0] == pytest.approx(7850.0 * 1e-3 * 0.12, rel=1e-12)
    # A free part stays ungrounded: no stiffness against rigid motion.
    scale = np.abs(small.K).max()
    np.testing.assert_allclose(small.K @ r_small, 0.0, atol=1e-9 * scale)


def test_internal_motion_comes_back():
    """`rows` gives internal dofs from constraint and fixed-interface modes."""
    system = free_plate()
    boundary = np.flatnonzero(np.isin(system.coordinates // 6, (0, 3, 20)))
    small = craig_bampton(system, boundary, count=EVERY)
    assert small.n == system.n
    u = np.random.default_rng(1).standard_normal(system.n)
    q = np.linalg.solve(small.rows(system.coordinates)[0].toarray(), u)
    np.testing.assert_array_equal(q[: boundary.size].round(9), u[boundary].round(9))
    assert q @ small.M @ q == pytest.approx(u @ (system.M @ u), rel=1e-8)
    assert q @ small.K @ q == pytest.approx(u @ (system.K @ u), rel=1e-8)


def test_reduced_matrices_have_the_craig_bampton_pattern():
    system = free_plate()
    boundary = np.flatnonzero(np.isin(system.coordinates // 6, (0, 3, 20)))
    small = craig_bampton(system, boundary, count=6)
    b = boundary.size
    i = np.setdiff1d(np.arange(system.n), boundary)
    fixed = modes(system.K[i][:, i], system.M[i][:, i], count=6)
    np.testing.assert_array_equal(small.K[:b, b:], 0.0)
    np.testing.assert_allclose(np.diag(small.K)[b:], fixed.omega2, rtol=1e-9)
    np.testing.assert_allclose(small.M[b:, b:], np.eye(6), atol=1e-12)
    assert small.stats.retained == b
    assert small.stats.modes == 6
    assert small.stats.internal == i.size
    np.testing.assert_array_equal(small.coordinates[:b], system.coordinates[boundary])
    np.testing.assert_array_equal(small.coordinates[b:], -1)


def test_frequency_limit_and_count_choose_the_same_modes():
    system = free_plate()
    boundary = np.flatnonzero(np.isin(system.coordinates // 6, (0, 3, 20)))
    by_count = craig_bampton(system, boundary, count=7)
    f = np.sqrt(np.diag(by_count.K)[boundary.size :]) / (2 * np.pi)
    by_limit = craig_bampton(system, boundary, f_max=0.5 * (f[5] + f[6]))
    assert by_limit.stats.modes == 6


def test_boundary_that_does_not_hold_the_part_is_named():
    system = free_plate()
    with pytest.raises(NumericalError, match="part PART cannot be reduced: its 1 retained dofs do not hold it"):
        craig_bampton(system, np.array([0]), count=3)


def test_initial_velocity_keeps_its_momentum():
    M, K = chain(12)
    v = np.linspace(0.0, 1.0, 12)
    system = system_of(M, K, velocity=v)
    small = craig_bampton(system, np.array([0, 11]), count=3)
    V = small.rows(np.arange(12))[0].toarray()
    # Galerkin: V' M (v - V q') = 0, so the momentum along each basis vector is that of the full model.
    np.testing.assert_allclose(V.T @ M @ (V @ small.velocity - v), 0.0, atol=1e-12)
    everything = craig_bampton(system, np.array([0, 11]), count=EVERY)
    np.testing.assert_allclose(everything.rows(np.arange(12))[0] @ everything.velocity, v, atol=1e-12)


def test_dashpot_between_masses_survives_reduction():
    M, K = chain(10)
    C = np.zeros((10, 10))
    C[3:5, 3:5] = 20.0 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    full = system_of(M, K, extra=C, velocity=np.ones(10))
    small = craig_bampton(full, np.array([0, 9]), count=EVERY)
    a, b = (free_run(s, NO_CHANNELS, 0.5, 2e-3).energy for s in (full, small))
    # Round-off.
    np.testing.assert_allclose(b, a, atol=1e-9 * a[0, 0])


# --- diagonalisation ------------------------------------------------------------------------------------


@pytest.mark.parametrize("rayleigh", [NO_DAMPING, Rayleigh(2.0, 1e-5)])
def test_diagonalise_changes_nothing_in_a_transient(rayleigh):
    system = joined(two_beams(), rayleigh, 5)
    time = time_axis(0.05, 2e-4)
    loads = forces_on(time, [6 * END + 2], 40.0 * np.sin(2 * np.pi * 60.0 * time))
    tip = np.zeros((1, 6 * 14))
    tip[0, 6 * END + 2] = -1.0
    gaps = channels(tip, 1e-3, 1e5)
    labels = 6 * END + np.arange(6)
    diagonal = diagonalise(system)
    assert isinstance(diagonal.K, Diagonal)
    assert diagonal.n == system.n
    a, b = (simulate(s, gaps, loads, HHT(), OutputRequest(labels)) for s in (system, diagonal))
    assert a.contact_steps
    scale = np.abs(a.displacement).max()
    # Round-off: all modes are kept, so this is a change of basis only.
    np.testing.assert_allclose(b.displacement, a.displacement, atol=1e-10 * scale)
    np.testing.assert_allclose(b.force, a.force, atol=1e-9 * a.force.max())
    np.testing.assert_allclose(b.energy, a.energy, atol=1e-9 * np.abs(a.energy).max())


def test_a_system_with_dashpots_answers_as_before_in_its_modes():
    M, K = chain(4)
    C = np.diag([0.0, 3.0, 0.0, 1.0])
    modal = diagonalise(system_of(M, K, extra=C, sparse=False))
    m, k = modal.M.diagonal(), modal.K.diagonal()
    shapes = to_dense(modal.rows(np.arange(4))[0])
    for omega in (3.0, 40.0):
        answer = shapes @ np.linalg.inv(np.diag(k - omega**2 * m) + 1j * omega * modal.damping.matrix(m, k)) @ shapes.T
        np.testing.assert_allclose(answer, np.linalg.inv(K - omega**2 * M + 1j * omega * C), rtol=1e-9)


def test_diagonalise_keeps_mass_modes_and_initial_velocity():
    M, K = chain(6)
    M = M + 0.1 * np.eye(6, k=1) + 0.1 * np.eye(6, k=-1)
    v = np.arange(6.0)
    system = diagonalise(system_of(M, K, velocity=v, sparse=False))
    np.testing.assert_allclose(system.K.d, sla.eigh(K, M, eigvals_only=True), rtol=1e-10)
    np.testing.assert_allclose(system.rows(np.arange(6))[0] @ system.velocity, v, atol=1e-12)


def test_free_body_keeps_zero_frequencies_when_diagonalised():
    """Two masses on one spring: round-off must not turn the rigid mode unstable (omega^2 < 0)."""
    model = model_of(
        np.array([[0.0, 0, 0], [1.0, 0, 0]]),
        [block("mass", [[0], [1]], point_mass(2.0)), block("spring2", [[0, 1]], spring(1e4), 0, 10)],
    )
    system = diagonalise(assembled(model))
    assert (system.K.d >= 0.0).all()
    assert np.count_nonzero(system.K.d > 1e-6) == 1


def test_motion_at_watched_dofs_needs_no_factor(monkeypatch):
    system = free_plate()
    boundary = np.flatnonzero(np.isin(system.coordinates // 6, (0, 3, 20)))
    labels = system.labels[np.isin(system.labels // 6, (3, 7, 11, 12))]
    basis = fixed_interface_basis(Inside(system, boundary), None, None, 5)
    plain = reduced_system(system, basis, reduced_matrices(system, basis)).rows(labels)[0]
    watched = reduced_system(system, basis, reduced_matrices(system, basis, watched=labels[:-4]))
    np.testing.assert_allclose(watched.rows(labels)[0].toarray(), plain.toarray(), atol=1e-12)  # some known, some not

    def solve(*_):
        raise AssertionError("a back-substitution")

    monkeypatch.setattr(Inside, "solve", solve)
    np.testing.assert_allclose(watched.rows(labels[:-4])[0].toarray(), plain[:-4].toarray(), atol=1e-12)
    with pytest.raises(AssertionError, match="back-substitution"):
        watched.rows(labels)


def test_a_combination_costs_one_back_substitution(monkeypatch):
    """Of all motion of two joined parts: the same as through the rows, and nothing is solved for each of those."""
    system = diagonalise(joined(two_beams(), NO_DAMPING, 3))
    B = np.random.default_rng(4).standard_normal((2, system.labels.size))
    wanted = B @ to_dense(system.rows(system.labels)[0])
    solve, solved = Inside.solve, []

    def counted(self: Inside, f: np.ndarray) -> np.ndarray:
        solved.append(f.shape[1])
        return solve(self, f)

    monkeypatch.setattr(Inside, "solve", counted)
    found, carried = system.combined(B, system.labels)
    np.testing.assert_allclose(to_dense(found), wanted, rtol=1e-10, atol=1e-12 * np.abs(wanted).max())
    assert carried.shape == (2, 0)
    assert 0 < sum(solved) <= 2 * 2


def test_constraint_modes_in_narrower_blocks_where_memory_is_short(monkeypatch):
    coords, quads = plate(8, 4, (0.3, 0.15))
    part = part_system(model_of(coords, [block("quad4", quads, shell(1e-3))]), 0, NO_DAMPING)
    boundary = np.flatnonzero(np.isin(part.coordinates // 6, np.flatnonzero(coords[:, 0] == 0.0)))
    plenty = craig_bampton(part, boundary, count=8)
    monkeypatch.setattr(memory, "SHARE", 0.0)
    assert [b.stop - b.start for b in constraint_modes.blocks(boundary.size, part.n)] == [16, 14]
    short = craig_bampton(part, boundary, count=8)
    for one, other in ((plenty.K, short.K), (plenty.M, short.M)):
        np.testing.assert_allclose(to_dense(other), to_dense(one), rtol=1e-9, atol=1e-10 * np.abs(to_dense(one)).max())
