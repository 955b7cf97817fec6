"""The health report: right figures on sound superelements, and a warning for each way of breaking one."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg as sla
import scipy.sparse as sp

from creak.arrays import to_dense
from creak.assembly.system import System
from creak.errors import InputError
from creak.linalg import modes as linalg_modes
from creak.linalg import pencil
from creak.linalg.factor import factor
from creak.linalg.mkl import has_pardiso
from creak.model.mesh import rigid_vectors
from creak.reduction.craig_bampton import craig_bampton
from creak.reduction.health import Health, health, health_rows
from creak.reduction.health.free import _own_modes, error_bound, error_of, first_left_out, residual_energy
from creak.reduction.health.rigid import rigid_motion
from creak.reduction.inside import Inside
from helpers_core import (
    NO_DAMPING,
    STEEL,
    bar,
    beam_section,
    block,
    model_of,
    nodes_of,
    part_system,
    plate,
    point_mass,
    shell,
    spring,
    straight_beam,
    system_of,
)

RECORDED = {"section": "reduction", "source": "exact"}

SIZE = (0.5, 0.3)
THICKNESS = 1e-3
N_X, N_Y = 8, 5
CORNERS = (0, N_Y, N_X * (N_Y + 1), (N_X + 1) * (N_Y + 1) - 1)
COORDS, QUADS = plate(N_X, N_Y, SIZE)
NODES = nodes_of(COORDS)
BAND = (0.9, 1.15)
"""Estimated over actual error where it is below 3 % and the mode below half of the first frequency left out."""


def free_plate() -> System:
    return part_system(model_of(COORDS, [block("quad4", QUADS, shell(THICKNESS))]), 0, NO_DAMPING)


def cut_at(part: System, nodes: tuple[int, ...]) -> Inside:
    return Inside(part, np.flatnonzero(np.isin(part.coordinates // 6, nodes)))


def reduced_plate(count: int) -> tuple[System, System, Inside]:
    part = free_plate()
    inside = cut_at(part, CORNERS)
    return part, craig_bampton(part, inside.b, count=count, inside=inside), inside


def frequency_error(full: System, small: System, inside: Inside, q: np.ndarray, omega2: np.ndarray) -> np.ndarray:
    energy = residual_energy(full, small, inside, q, omega2)
    return error_of(energy, omega2, first_left_out(small, inside))


def report(count: int, f_excitation: float | None = 100.0, **options: object) -> Health:
    return health(*reduced_plate(count), NODES, f_excitation=f_excitation, **options)


def warned(h: Health, words: str) -> bool:
    return any(words in text for text in h.findings.warnings)


# --- what a sound superelement shows --------------------------------------------------------------------


def test_sound_superelement_is_called_good():
    h = report(30)
    assert h.good, h.findings.warnings
    assert h.verdict[0].startswith(f"good to {h.free.usable:,.0f} Hz (estimated frequency error below 1 %)")
    assert any(text.startswith("first mode left out at") and "x the excitation" in text for text in h.verdict)
    assert h.free.usable_tight < h.free.usable < h.fixed.first_left_out
    assert (h.retained, h.modes, h.internal) == (24, 30, 6 * 54 - 24)


def test_mass_properties_are_those_of_the_plate(measured):
    """Rectangle a x b of mass m: J = m b^2/12, m a^2/12, m (a^2 + b^2)/12, and rotary inertia m t^2/12."""
    h = report(4)
    m = STEEL.density * THICKNESS * SIZE[0] * SIZE[1]
    np.testing.assert_allclose(h.rigid.cog, (0.25, 0.15, 0.0), atol=1e-12)
    a2, b2, t2 = SIZE[0] ** 2, SIZE[1] ** 2, THICKNESS**2
    # Consistent mass of a rectangle integrates x^2 exactly; the rotary inertia of a shell is t^2 / 12.
    np.testing.assert_allclose(h.rigid.inertia[:2], [m * (b2 + t2) / 12, m * (a2 + t2) / 12], rtol=1e-4)
    measured("health report: mass of a plate", h.rigid.mass, m, rel=1e-12, unit="kg")
    measured(
        "health report: inertia of a plate about its normal",
        h.rigid.inertia[2],
        m * (a2 + b2) / 12,
        rel=1e-3,
        unit="kg m2",
    )
    np.testing.assert_allclose(h.rigid.inertia[3:], 0.0, atol=1e-12 * m)
    # Round-off of K_ii^-1 K_ib: eps x condition of K_ii, some 1e8 here.
    assert max(h.rigid.mass_error, h.rigid.cog_error, h.rigid.inertia_error) < 1e-7


def test_rigid_vectors_about_a_point():
    """u = theta x (x - c)."""
    coords, about = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]), np.array([0.5, 0.0, -1.0])
    R = rigid_vectors(np.arange(12), nodes_of(coords), about)
    theta = np.array([0.3, -0.2, 0.7])
    u = (R[:, 3:] @ theta).reshape(2, 6)
    np.testing.assert_allclose(u[:, :3], np.cross(theta, coords - about), atol=1e-15)
    np.testing.assert_allclose(u[:, 3:], [theta, theta], atol=1e-15)


def test_centre_of_gravity_and_inertia_of_point_masses():
    coords = np.array([[0.0, 0, 0], [3.0, 0, 0], [0.0, 1.0, 0.0]])
    beams = block("beam2", [[0, 1], [0, 2]], beam_section(area=1e-12))
    masses = [block("mass", [[k]], point_mass(m), 0, 10 + k) for k, m in enumerate((1.0, 2.0, 3.0))]
    part = part_system(model_of(coords, [beams, *masses]), 0, NO_DAMPING)
    inside = cut_at(part, (0,))
    h = health(part, craig_bampton(part, inside.b, count=0, inside=inside), inside, nodes_of(coords))
    np.testing.assert_allclose(h.rigid.cog, (1.0, 0.5, 0.0), atol=1e-7)  # beams weigh 3e-8
    # J_zz = sum m r^2 about the centre = 1 x 1.25 + 2 x 4.25 + 3 x 1.25; J_xy = -sum m x y = 3.
    np.testing.assert_allclose([h.rigid.inertia[2], h.rigid.inertia[3]], [13.5, 3.0], rtol=1e-6)


def test_frequencies_and_measured_errors(measured):
    part, small, inside = reduced_plate(12)
    h = health(part, small, inside, NODES)
    exact, ritz = (
        np.sqrt(sla.eigh(to_dense(s.K), to_dense(s.M), eigvals_only=True)[6:16]) / (2 * np.pi) for s in (part, small)
    )
    np.testing.assert_allclose(h.free.full, exact, rtol=1e-7)
    # A difference of two frequencies, each good to eps x the spread of eigenvalues (1e9).
    measured(
        "health report: measured frequency error, worst deviation",
        np.abs(h.free.error - (ritz / exact - 1.0)).max(),
        at_most=1e-7,
        source="full part",
    )
    np.testing.assert_allclose(h.fixed.frequencies, np.sqrt(small.K.diagonal()[24:34]) / (2 * np.pi), rtol=1e-12)
    assert (h.free.rigid_full, h.free.rigid_reduced) == (6, 6)


def test_first_mode_left_out_of_a_guyan_model():
    """No mode is kept, so subspace iteration finds the first; nine steps of the ratio (lambda_1 / lambda_17)."""
    part, _, inside = reduced_plate(0)
    h = health(part, craig_bampton(part, inside.b, count=0, inside=inside), inside, NODES, f_excitation=50.0)
    first = sla.eigh(to_dense(inside.K_ii), to_dense(inside.M_ii), eigvals_only=True)[0]
    assert h.fixed.first_left_out == pytest.approx(np.sqrt(first) / (2 * np.pi), rel=1e-3)
    assert h.fixed.frequencies == ()
    assert warned(h, "not good enough: the excitation reaches 50 Hz")
    assert warned(h, "raise f_max to")


def test_effective_mass_of_all_modes_is_the_whole_inside():
    h = report(10_000)
    # Phi Phi' = M_ii^-1, to round-off.
    np.testing.assert_allclose(h.fixed.effective_mass, 1.0, rtol=1e-6)
    share = np.array(h.fixed.cumulative_mass)
    assert (np.diff(share, axis=0) >= -1e-12).all()
    assert (np.array(report(12).fixed.effective_mass) < 1.0).all()


def test_effective_mass_of_a_clamped_bar(measured):
    """A bar held at one end: mode k carries 8 / ((2k - 1) pi)^2 of its mass (uniform bar, exact)."""
    n = 100
    M, K = bar(n, 1.0, 1.0, 1.0)
    full = system_of(np.kron(M, np.diag([1.0, 0, 0, 0, 0, 0])), np.kron(K, np.diag([1.0, 0, 0, 0, 0, 0])))
    keep = np.arange(0, 6 * (n + 1), 6)
    full = replace(
        full,
        M=full.M[keep][:, keep],
        K=full.K[keep][:, keep],
        coordinates=keep,
        labels=keep,
        rows=lambda labels: (sp.identity(n + 1, format="csr")[labels // 6], np.zeros((labels.size, 0))),
        velocity=np.zeros(n + 1),
    )
    inside = Inside(full, np.array([0]))
    small = craig_bampton(full, np.array([0]), count=3, inside=inside)
    coords = np.column_stack([np.linspace(0.0, 1.0, n + 1), np.zeros((n + 1, 2))])
    h = health(full, small, inside, nodes_of(coords))
    k = np.arange(1, 4)
    # Mesh error of a linear element: (omega dx / c)^2 / 24 and the half element at the wall, below 1 %.
    exact = np.cumsum(8 / ((2 * k - 1) * np.pi) ** 2)
    measured(
        "health report: effective mass of a clamped bar, {} modes",
        np.array(h.fixed.cumulative_mass)[:, 0],
        exact,
        rel=0.01,
        source="closed form",
    )
    assert h.fixed.effective_mass[1:] == (1.0,) * 5  # nothing to carry


# --- the error estimate ---------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["quad4", "tri3"])
@pytest.mark.parametrize("count", [6, 15, 40])
def test_estimate_is_close_to_the_actual_error_and_never_far_below(kind, count, measured):
    """Ratio within BAND where the error is small, above 0.8 up to 0.8 of the first frequency left out.

    Close modes change places when corrected, so the corrected frequencies are sorted before they are compared.
    Actual errors are differences of eigenvalues, each good to eps x the largest: those below 100 x that are unknown.
    """
    coords, elements = plate(N_X, N_Y, SIZE, kind=kind)
    part = part_system(model_of(coords, [block(kind, elements, shell(THICKNESS))]), 0, NO_DAMPING)
    inside = cut_at(part, CORNERS)
    small = craig_bampton(part, inside.b, count=count, inside=inside)
    exact = sla.eigh(to_dense(part.K), to_dense(part.M), eigvals_only=True)[6:]
    ritz, q = sla.eigh(to_dense(small.K), to_dense(small.M))
    error = frequency_error(part, small, inside, q[:, 6:], ritz[6:])
    known = np.flatnonzero(ritz[6:] < 0.64 * small.K.diagonal()[-1])
    largest = exact[-1]
    ritz, error, exact = ritz[6:][known], error[known], exact[: known.size]
    actual = np.sqrt(ritz / exact) - 1.0
    estimate = np.sqrt(ritz) / np.sort(np.sqrt(ritz) / (1.0 + error)) - 1.0
    seen = actual > 100.0 * np.finfo(float).eps * largest / ritz
    assert (estimate[seen] > 0.8 * actual[seen]).all()
    little = seen & (actual < 0.03) & (ritz < 0.25 * small.K.diagonal()[-1])
    assert np.count_nonzero(little) >= 2
    ratio = estimate[little] / actual[little]
    measured("health report: estimated over actual error, worst", ratio, 1.0, between=BAND, source="full part")


@pytest.mark.parametrize("count", [0, 6, 25])
def test_error_bound_holds_for_every_mode(count):
    """1 / lambda <= 1 / lambda_reduced + 1 / lambda_cut, with the exact first eigenvalue left out."""
    part, small, inside = reduced_plate(count)
    cut = sla.eigh(to_dense(inside.K_ii), to_dense(inside.M_ii), eigvals_only=True)[count]
    exact = sla.eigh(to_dense(part.K), to_dense(part.M), eigvals_only=True)[6:]
    ritz = sla.eigh(to_dense(small.K), to_dense(small.M), eigvals_only=True)[6:]
    actual = np.sqrt(ritz / exact[: ritz.size]) - 1.0
    assert (actual <= error_bound(np.sqrt(ritz), np.sqrt(cut)) + 1e-7).all()


def test_errors_of_two_parts_add_up():
    """Two plates that share an edge, one reduced well and one badly; modes mass-normalised on the whole."""
    n, m = N_X // 2, N_Y + 1
    whole = free_plate()
    parts, smalls, insides = [], [], []
    for columns, count in ((range(n + 1), 25), (range(n, N_X + 1), 6)):
        nodes = [c * m + r for c in columns for r in range(m)]
        mine = QUADS[np.isin(QUADS, nodes).all(axis=1)]
        part = part_system(model_of(COORDS, [block("quad4", mine, shell(THICKNESS))], [("P", nodes)]), 0, NO_DAMPING)
        inside = cut_at(part, tuple(range(n * m, (n + 1) * m)))
        parts.append(part)
        insides.append(inside)
        smalls.append(craig_bampton(part, inside.b, count=count, inside=inside))
    size, n_b = sum(s.n for s in smalls) - insides[0].b.size, insides[0].b.size
    maps = [np.r_[np.arange(n_b), np.arange(n_b, smalls[0].n)], np.r_[np.arange(n_b), np.arange(smalls[0].n, size)]]
    K, M = np.zeros((size, size)), np.zeros((size, size))
    for small, at in zip(smalls, maps, strict=True):
        K[np.ix_(at, at)] += to_dense(small.K)
        M[np.ix_(at, at)] += to_dense(small.M)
    ritz, q = sla.eigh(K, M)
    exact = sla.eigh(to_dense(whole.K), to_dense(whole.M), eigvals_only=True)
    some = slice(6, 14)
    shares = [
        frequency_error(p, s, i, q[at, some], ritz[some])
        for p, s, i, at in zip(parts, smalls, insides, maps, strict=True)
    ]
    actual = np.sqrt(ritz[some] / exact[some]) - 1.0
    ratio = sum(shares) / actual
    assert BAND[0] < ratio.min() <= ratio.max() < BAND[1]
    assert (shares[1] > shares[0]).all()  # the badly reduced part is to blame


def test_estimate_is_infinite_beyond_the_first_mode_left_out():
    part, small, inside = reduced_plate(6)
    ritz, q = sla.eigh(to_dense(small.K), to_dense(small.M))
    error = frequency_error(part, small, inside, q, ritz)
    assert np.isinf(error[-1])
    assert np.abs(ritz[:6]).max() < 1e-6 * ritz[6]
    assert error[:6].max() < 1e-6  # rigid motion is not lost: zero but for round-off


def test_usable_frequency_lies_between_the_modes_that_pass_and_fail():
    h = report(15)
    error = np.array(h.free.error)
    first_bad = int(np.flatnonzero(error > 0.01)[0]) if (error > 0.01).any() else error.size
    assert h.free.full[first_bad - 1] < h.free.usable
    if first_bad < error.size:
        assert h.free.usable <= h.free.reduced[first_bad]


# --- broken superelements -------------------------------------------------------------------------------


def broken(**changes: object) -> Health:
    part, small, inside = reduced_plate(30)
    new = {name: change(to_dense(getattr(small, name)).copy()) for name, change in changes.items()}
    return health(part, replace(small, **new), inside, NODES, f_excitation=100.0)


def test_spring_to_ground_is_found():
    def ground(K: np.ndarray) -> np.ndarray:
        K[2, 2] += 1e-3 * K[2, 2]
        return K

    h = broken(K=ground)
    assert not h.rigid.passes_grounding
    assert h.rigid.grounding_frequency > 0.0
    assert warned(h, "ties the part to ground")


def test_lost_mass_is_found():
    h = broken(M=lambda M: 0.97 * M)
    assert h.rigid.mass_error == pytest.approx(0.03, rel=1e-6)
    assert warned(h, "rigid-body properties are wrong: mass by 3 %")


def test_shifted_mass_is_found():
    """Mass on one corner: the centre of gravity moves by dm r / (m + dm), here over half a radius of gyration."""

    def heavier(M: np.ndarray) -> np.ndarray:
        M[[0, 1, 2], [0, 1, 2]] += 1.0
        return M

    h = broken(M=heavier)
    m, r = 1.1775, np.hypot(0.25, 0.15)
    gyration = np.sqrt(sum(h.rigid.inertia[:3]) / (2 * m))
    assert h.rigid.cog_error == pytest.approx(r / (m + 1.0) / gyration, rel=1e-6)
    assert warned(h, "centre of gravity by")


def test_negative_mass_is_found():
    def lighter(M: np.ndarray) -> np.ndarray:
        M[2, 2] -= 10.0
        return M

    assert warned(broken(M=lighter), "its mass or stiffness is not positive")


def test_rows_of_modes_with_other_signs_are_found():
    """Every tenth mode turned round against the boundary: mass, stiffness and each free mode below 100 Hz still pass."""

    def turn(M: np.ndarray) -> np.ndarray:
        rows = np.arange(len(M) - 30, len(M), 10)
        M[rows, :-30] *= -1.0
        M[:-30, rows] *= -1.0
        return M

    h = broken(M=turn)
    assert h.energy.kinetic > 1e-3
    assert warned(h, "not those of its own motion in the full part: kinetic energy by")
    assert max(report(30).energy.kinetic, report(30).energy.strain) < 1e-9


def test_a_part_on_one_node_has_no_strain_energy_to_be_off():
    """Its boundary moves as a rigid body; what both energies are is round-off."""
    part = free_plate()
    inside = cut_at(part, CORNERS[:1])
    h = health(part, craig_bampton(part, inside.b, count=0, inside=inside), inside, NODES)
    assert max(h.energy.kinetic, h.energy.strain) < 1e-6
    assert not warned(h, "own motion")


def test_scaled_mode_is_found():
    def softer(K: np.ndarray) -> np.ndarray:
        K[24, 24] *= 0.5
        return K

    h = broken(K=softer)
    assert h.fixed.residual > 0.1
    assert warned(h, "is no mode of the full part")
    assert warned(h, "a free mode of the part below 100 Hz is off by")


def test_lost_stiffness_is_found():
    """A mode without stiffness: one motion more than the six of a free part."""

    def loose(K: np.ndarray) -> np.ndarray:
        K[24, 24] = 0.0
        return K

    assert warned(broken(K=loose), "the superelement has 7 motions without stiffness, the part 6")


def test_too_low_a_limit_is_told_with_a_better_one():
    h = report(6, f_excitation=100.0)
    assert warned(h, "not good enough: the excitation reaches 100 Hz but the estimated frequency error passes 1 % at")
    assert warned(h, "the rule of thumb is 3 x, with contact 5 x: 300 Hz or 500 Hz")


# --- parts with springs to ground, reduced boundaries, no inside -----------------------------------------


def test_springs_to_ground_of_the_part_itself_are_not_held_against_the_reduction():
    ground = block("spring1", [[k] for k in (10, 20, 33)], spring(2e3, dof=3), 0, 500)
    part = part_system(model_of(COORDS, [block("quad4", QUADS, shell(THICKNESS)), ground]), 0, NO_DAMPING)
    inside = cut_at(part, CORNERS)
    h = health(part, craig_bampton(part, inside.b, count=30, inside=inside), inside, NODES, f_excitation=50.0)
    assert h.rigid.grounded
    assert h.rigid.passes_grounding
    assert h.good, h.findings.warnings
    assert h.free.rigid_full == h.free.rigid_reduced == 3  # in-plane motion stays free


def test_reduced_boundary_that_holds_rigid_motion_is_exact():
    part = free_plate()
    inside = cut_at(part, CORNERS)
    R = rigid_vectors(part.coordinates[inside.b], NODES, np.zeros(3))
    P = np.hstack([R @ np.random.default_rng(2).standard_normal((6, 6)), np.eye(24)[:, :3]])
    h = health(part, craig_bampton(part, inside.b, count=20, shape=P, inside=inside), inside, NODES)
    assert h.rigid.boundary_misfit < 1e-9
    assert h.rigid.mass_error < 1e-7
    assert h.rigid.passes_grounding


def test_reduced_boundary_that_cannot_move_rigidly_is_told():
    part = free_plate()
    inside = cut_at(part, CORNERS)
    R = rigid_vectors(part.coordinates[inside.b], NODES, np.zeros(3))
    P = R[:, :5].copy()
    h = health(part, craig_bampton(part, inside.b, count=20, shape=P, inside=inside), inside, NODES, own_modes=False)
    assert h.rigid.boundary_misfit > 0.5
    assert warned(h, "the reduced boundary cannot move rigidly")


def test_part_without_an_inside():
    coords, elements = straight_beam(2, 1.0)
    part = part_system(model_of(coords, [block("beam2", elements, beam_section())]), 0, NO_DAMPING)
    inside = Inside(part, np.arange(part.n))
    h = health(
        part, craig_bampton(part, inside.b, f_max=100.0, inside=inside), inside, nodes_of(coords), f_excitation=100.0
    )
    assert h.good, h.findings.warnings
    assert h.internal == h.modes == 0
    assert "good to any frequency" in h.verdict[0]
    assert max(h.free.estimate) == 0.0


def test_single_retained_node():
    """A statically determinate boundary: K_r is nothing but round-off, and that is no grounding."""
    part = free_plate()
    inside = cut_at(part, (0,))
    h = health(part, craig_bampton(part, inside.b, count=40, inside=inside), inside, NODES, f_excitation=20.0)
    assert h.rigid.passes_grounding
    assert h.good, h.findings.warnings


# --- form ------------------------------------------------------------------------------------------------


def test_a_part_of_loose_masses_has_as_many_rigid_motions_as_its_superelement():
    """Masses that only springs beyond the part hold: more motions without stiffness than a free body has."""
    coords = np.column_stack([np.arange(9.0), np.zeros((9, 2))])
    masses = [block("mass", [[k]], point_mass(1.0), 0, 10 + k) for k in range(9)]
    held = block("spring2", [[0, 1]], spring(1e4, 1), 0, 30)
    part = part_system(model_of(coords, [*masses, held]), 0, NO_DAMPING)
    inside = cut_at(part, tuple(range(9)))
    h = health(part, craig_bampton(part, inside.b, count=0, inside=inside), inside, nodes_of(coords))
    assert h.free.rigid_full == h.free.rigid_reduced == 26
    assert not warned(h, "motions without stiffness")


def test_own_modes_can_be_skipped():
    h = report(30, own_modes=False)
    assert h.free.full == h.free.error == ()
    assert h.free.rigid_full == -1
    assert h.good
    assert h.free.usable == report(30).free.usable


def test_dictionary_holds_plain_finite_values():
    d = report(15).as_dict()
    assert json.loads(json.dumps(d, allow_nan=False)) == d
    assert d["rigid_mass"] == pytest.approx(1.1775)
    assert d["good"] is False
    assert len(d["free_estimate"]) == len(d["free_reduced"])
    assert "fixed_first_left_out" not in report(10_000, f_excitation=None).as_dict()


def test_rows_are_text():
    rows = health_rows(report(15))
    assert all(len(row) == 3 and all(isinstance(cell, str) for cell in row) for row in rows)
    labels = [row[0] for row in rows]
    for label in (
        "mass",
        "ground check",
        "first mode left out",
        "effective mass of kept modes",
        "usable to",
        "verdict",
    ):
        assert label in labels


def test_progress_names_its_stages():
    seen: list[tuple[str, int, int]] = []
    report(15, progress=lambda *a: seen.append(a))
    assert {stage for stage, _, _ in seen} >= {"error estimate"}
    assert all(0 <= done <= max(total, done) for _, done, total in seen)


def test_generalised_coordinates_of_the_part_are_refused():
    part, small, inside = reduced_plate(4)
    odd = replace(part, coordinates=np.r_[part.coordinates[:-1], -1])
    with pytest.raises(InputError, match="1 generalised coordinates"):
        health(odd, small, inside, NODES)


def test_excitation_must_be_positive():
    with pytest.raises(InputError, match=r"0\.0 Hz; expected a positive frequency"):
        report(4, f_excitation=0.0)


def test_rigid_motion_of_the_superelement_is_that_of_the_part():
    part, small, _ = reduced_plate(4)
    motions = rigid_motion(part, small, NODES)
    # Psi reproduces rigid motion to the round-off of K_ii^-1 K_ib.
    np.testing.assert_allclose(motions.u, motions.R, atol=1e-7)


def test_own_modes_cost_one_factorisation(monkeypatch):
    made = []

    def counted(A, **options):
        made.append(A.shape)
        return factor(A, **options)

    monkeypatch.setattr(linalg_modes, "DENSE_LIMIT", 100)
    monkeypatch.setattr(pencil, "factor", counted)
    part, reduced, inside = reduced_plate(20)
    made.clear()
    found = health(part, reduced, inside, NODES)
    assert made == [(part.n, part.n)]
    exact = linalg_modes.modes(part.K, part.M, count=12, free=True).frequencies[6:]
    np.testing.assert_allclose(found.free.full[:6], exact, rtol=1e-9)


def test_a_small_factor_stays_for_the_check():
    part = free_plate()
    inside = cut_at(part, CORNERS)
    first = inside.factor.made
    inside.release(above=10**9)
    assert (inside.factor.made is first) == has_pardiso()  # other factors do not know their size
    inside.release(above=0)
    assert inside.factor.made is not first


def test_a_dof_without_stiffness_and_mass_in_the_part_costs_no_frequency():
    """The reference node of a bolt that another part stiffens: a free chain of 700 masses with an empty row before it."""
    n = 700
    K = sp.diags([[-1.0] * (n - 1), [1.0, *[2.0] * (n - 2), 1.0], [-1.0] * (n - 1)], [-1, 0, 1])
    empty = sp.csr_matrix((1, 1))
    part = SimpleNamespace(K=sp.block_diag([empty, K], format="csr"), M=sp.block_diag([empty, sp.eye(n)], format="csr"))
    found, rigid = _own_modes(part, 3, 1, None)
    assert rigid == 1
    expected = 2.0 * np.sin(np.pi * np.arange(1, 4) / (2.0 * n)) / (2.0 * np.pi)
    np.testing.assert_allclose(found, expected, rtol=1e-8)
