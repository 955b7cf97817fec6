"""Modes: dense and Lanczos agree, free bodies, repeated frequencies, none missed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy.linalg as sla
import scipy.sparse as sp

from creak.errors import NumericalError
from creak.linalg import modes as linalg_modes
from creak.linalg import windows
from creak.linalg.modes import DENSE_LIMIT, MANY, modes
from helpers_cantilever import SECTION, planar
from helpers_core import NO_DAMPING, block, model_of, part_system, plate, shell, straight_beam


def long_chain(n: int = 800, held: bool = True) -> tuple[sp.csr_matrix, sp.csr_matrix, np.ndarray]:
    """K, M and exact eigenvalues of n equal masses, the first held by a spring (or none)."""
    d = np.full(n, 2.0)
    d[-1] = 1.0
    if not held:
        d[0] = 1.0
    K = sp.diags_array([d, -np.ones(n - 1), -np.ones(n - 1)], offsets=[0, 1, -1]).tocsr() * 1e6
    k = np.arange(n)
    theta = (2 * k + 1) * np.pi / (2 * (2 * n + 1)) if held else k * np.pi / (2 * n)
    return K, sp.identity(n, format="csr"), 4e6 * np.sin(theta) ** 2


def test_lanczos_finds_the_lowest_modes_of_a_chain():
    K, M, exact = long_chain()
    assert K.shape[0] > DENSE_LIMIT
    found = modes(K, M, count=40)
    # Lanczos residual 1e-9, so eigenvalues to its square; factorisation of a 1e6 conditioned K.
    np.testing.assert_allclose(found.omega2, exact[:40], rtol=1e-8)
    np.testing.assert_allclose(found.shapes.T @ found.shapes, np.eye(40), atol=1e-10)
    assert found.sturm_ok
    assert found.residual < 1e-6
    np.testing.assert_allclose(found.frequencies, np.sqrt(exact[:40]) / (2 * np.pi), rtol=1e-8)


def test_frequency_limit_gives_all_modes_below_it_and_no_more():
    K, M, exact = long_chain()
    f = np.sqrt(exact) / (2 * np.pi)
    for n in (0, 1, 17, 60):
        limit = 0.5 * (f[n - 1] + f[n]) if n else 0.5 * f[0]
        found = modes(K, M, f_max=limit)
        assert found.omega2.size == n
        np.testing.assert_allclose(found.omega2, exact[:n], rtol=1e-8)


def test_free_body_has_exactly_zero_rigid_frequencies():
    K, M, exact = long_chain(held=False)
    found = modes(K, M, count=6, free=True)
    assert found.omega2[0] == 0.0
    np.testing.assert_allclose(found.omega2[1:], exact[1:6], rtol=1e-7)


def test_plate_floating_in_space_has_six_rigid_modes():
    coords, quads = plate(12, 10, (0.3, 0.25))
    part = part_system(model_of(coords, [block("quad4", quads, shell(1e-3))]), 0, NO_DAMPING)
    assert part.n > DENSE_LIMIT
    found = modes(part.K, part.M, count=12, free=True)
    np.testing.assert_array_equal(found.omega2[:6], 0.0)
    assert (found.omega2[6:] > 0.0).all()
    assert found.sturm_ok


def test_repeated_frequencies_are_all_found():
    """Twenty equal chains side by side: every frequency twenty times; more than a block of Lanczos vectors."""
    K, M, exact = long_chain(40)
    K20, M20 = (sp.block_diag([A] * 20, format="csr") for A in (K, M))
    found = modes(K20, M20, count=60)
    np.testing.assert_allclose(found.omega2, np.repeat(exact[:3], 20), rtol=1e-8)
    np.testing.assert_allclose(found.shapes.T @ found.shapes, np.eye(60), atol=1e-9)
    f = np.sqrt(exact[:4]) / (2 * np.pi)
    assert modes(K20, M20, f_max=0.5 * (f[1] + f[2])).omega2.size == 40


def test_square_plate_has_its_twin_modes():
    coords, quads = plate(14, 14, (0.3, 0.3))
    part = part_system(model_of(coords, [block("quad4", quads, shell(1e-3))]), 0, NO_DAMPING)
    f = modes(part.K, part.M, count=12, free=True).frequencies
    # Modes 4 and 5 of a free square plate are twins by symmetry.
    assert f[9] == pytest.approx(f[10], rel=1e-7)


def test_dense_and_lanczos_agree():
    K, M, _ = long_chain(DENSE_LIMIT + 1)
    rng = np.random.default_rng(2)
    M = sp.csr_matrix(sp.diags_array(rng.uniform(0.5, 2.0, K.shape[0])))
    lanczos = modes(K, M, count=10)
    exact = sla.eigh(K.toarray(), M.toarray(), eigvals_only=True, subset_by_index=(0, 9))
    np.testing.assert_allclose(lanczos.omega2, exact, rtol=1e-8)


def test_massless_dofs_have_no_mode():
    K, M, _ = long_chain(20)
    M = M.tolil()
    M[3, 3] = M[11, 11] = 0.0
    found = modes(K, sp.csr_matrix(M), count=20)
    assert found.omega2.size == 18
    # The same as after condensing the massless ones out.
    keep = np.setdiff1d(np.arange(20), [3, 11])
    Kd = K.toarray()
    gone = np.array([3, 11])
    small = Kd[np.ix_(keep, keep)] - Kd[np.ix_(keep, gone)] @ np.linalg.solve(
        Kd[np.ix_(gone, gone)], Kd[np.ix_(gone, keep)]
    )
    np.testing.assert_allclose(found.omega2, np.linalg.eigvalsh(small), rtol=1e-8)


def test_directions_with_neither_mass_nor_stiffness_take_part_in_no_mode():
    """Two massless dofs joined to each other alone, as the twist of a bar that turns freely about itself."""
    K, M, _ = long_chain(20)
    pair, noise = np.array([[1.0, -1.0], [-1.0, 1.0]]), 1e-33 * np.ones((3, 3))
    loose = sp.block_diag([K, sp.csr_array(pair), sp.csr_array(noise)])
    both = modes(loose, sp.csr_matrix(sp.block_diag([M, sp.csr_array((5, 5))])), count=30)
    np.testing.assert_allclose(both.omega2, modes(K, M, count=30).omega2, rtol=1e-9)


def test_negative_mass_or_stiffness_is_an_error():
    K, M, _ = long_chain(20)
    for k, m in ((-1.0, 0.0), (0.0, -1.0)):
        loose, light = (sp.csr_matrix(sp.block_diag([A, sp.csr_array([[x]])])) for A, x in ((K, k), (M, m)))
        with pytest.raises(NumericalError, match="not positive"):
            modes(loose, light, count=3)


def test_zero_stiffness_of_a_body_called_clamped_is_an_error():
    K = sp.csr_matrix(sp.block_diag([long_chain(700)[0], np.zeros((1, 1))]))
    with pytest.raises(NumericalError, match="is the body held"):
        modes(K, sp.identity(701, format="csr"), count=3)


def test_either_limit_or_count():
    K, M, _ = long_chain(5)
    for arguments in ({}, {"f_max": 1.0, "count": 2}):
        with pytest.raises(ValueError, match="either f_max or count"):
            modes(K, M, **arguments)


def test_slow_elastic_modes_of_a_fine_mesh_are_not_taken_for_rigid():
    """A free beam of 400 Hermite elements: f1 is (4.73 / 400 h)^2 of the mesh's own frequencies, and not zero."""
    n = 400
    coords, elements = straight_beam(n, float(n))
    part = planar(part_system(model_of(coords, [block("beam2", elements, SECTION)]), 0, NO_DAMPING))
    found = modes(part.K, part.M, count=5, free=True)
    exact = np.array([4.730041, 7.853205, 10.995608]) ** 2 / n**2 / np.sqrt(420.0)
    assert (found.omega2[:2] == 0.0).all()
    np.testing.assert_allclose(np.sqrt(found.omega2[2:]), exact, rtol=1e-3)


def test_progress_is_reported():
    K, M, _ = long_chain()
    seen = []
    modes(K, M, count=30, progress=lambda done, total: seen.append((done, total)))
    done = [now for now, _ in seen]
    assert all(total == 30 for _, total in seen)
    assert done == sorted(done)
    assert done[0] >= 0
    assert done[-1] == 30


def held_plate(cells: tuple[int, int], size: tuple[float, float]) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """K and M of a flat shell, one edge clamped; small enough for a dense solver, too large for `modes` to take it."""
    coords, quads = plate(*cells, size)
    part = part_system(model_of(coords, [block("quad4", quads, shell(1e-3))]), 0, NO_DAMPING)
    inside = np.flatnonzero(~np.isin(part.coordinates // 6, np.flatnonzero(coords[:, 0] == coords[:, 0].min())))
    K, M = (sp.csr_matrix(A)[inside][:, inside] for A in (part.K, part.M))
    assert K.shape[0] > DENSE_LIMIT
    return K, M


@pytest.fixture(scope="module")
def shell_case() -> tuple[sp.csr_matrix, sp.csr_matrix, np.ndarray]:
    K, M = held_plate((13, 9), (0.4, 0.25))
    return K, M, sla.eigh(K.toarray(), M.toarray(), eigvals_only=True)


@pytest.mark.parametrize("n", [0, 1, 30, 140])
def test_shell_modes_agree_with_the_dense_solver(shell_case, n):
    K, M, exact = shell_case
    limit = 0.5 * (exact[n - 1] + exact[n]) if n else 0.5 * exact[0]
    found = modes(K, M, f_max=float(np.sqrt(limit)) / (2.0 * np.pi))
    # Both solvers are backward stable: round-off of 1e-16 times the ratio of the extreme to the found eigenvalue
    # (1e10 for the dense one at the bottom, so the lowest are compared to the residual instead).
    safe = exact[:n] > 1e-6 * exact[-1]
    np.testing.assert_allclose(found.omega2[safe], exact[:n][safe], rtol=1e-9)
    np.testing.assert_allclose(found.omega2, exact[:n], rtol=1e-5)
    np.testing.assert_allclose(found.shapes.T @ (M @ found.shapes), np.eye(n), atol=1e-9)
    assert found.next_omega2 == pytest.approx(exact[n], rel=1e-5)
    assert found.columns >= n
    assert found.sturm_ok


def test_residuals_are_those_of_the_rayleigh_quotient(shell_case):
    K, M, exact = shell_case
    found = modes(K, M, f_max=float(np.sqrt(0.5 * (exact[59] + exact[60]))) / (2.0 * np.pi))
    x = found.shapes
    np.testing.assert_allclose(np.einsum("ij,ij->j", x, K @ x), found.omega2, rtol=1e-9)
    gap = np.linalg.norm(K @ x - (M @ x) * found.omega2, axis=0) / np.linalg.norm(K @ x, axis=0)
    assert found.residual == pytest.approx(gap.max(), rel=0.5)  # both are round-off of K x, summed in another order
    assert found.residual < 1e-6


def test_limit_may_cut_through_a_cluster():
    """Chains side by side whose frequencies differ by 1e-6: the limit lies between the 7th and the 8th of twelve."""
    K, _, exact = long_chain(80)
    scale = 1.0 + 1e-6 * np.arange(12)
    K12, M12 = sp.block_diag([s * K for s in scale], format="csr"), sp.identity(960, format="csr")
    every = np.sort(np.outer(scale, exact).ravel())
    n = 5 * 12 + 7
    limit = 0.5 * (every[n - 1] + every[n])
    found = modes(K12, M12, f_max=float(np.sqrt(limit)) / (2.0 * np.pi))
    # Neighbours are 1e-6 apart, so an error of 1e-9 leaves no doubt about which is which.
    np.testing.assert_allclose(found.omega2, every[:n], rtol=1e-9)
    assert found.next_omega2 == pytest.approx(every[n], rel=1e-9)
    np.testing.assert_allclose(found.shapes.T @ found.shapes, np.eye(n), atol=1e-9)


def test_more_twins_than_a_block_is_wide():
    K, M, exact = long_chain(20)
    K40, M40 = (sp.block_diag([A] * 40, format="csr") for A in (K, M))
    f = np.sqrt(exact) / (2.0 * np.pi)
    found = modes(K40, M40, f_max=0.5 * (f[1] + f[2]))
    np.testing.assert_allclose(found.omega2, np.repeat(exact[:2], 40), rtol=1e-9)
    np.testing.assert_allclose(found.shapes.T @ found.shapes, np.eye(80), atol=1e-9)
    assert found.next_omega2 == pytest.approx(exact[2], rel=1e-9)


@pytest.mark.parametrize("n", [30, 800])
def test_nothing_is_left_above_the_last_mode(n):
    """A single mass in a chain of massless ones: one mode, infinity after it; dense and Lanczos."""
    K, _, _ = long_chain(n)
    mass = np.zeros(n)
    mass[n // 2] = 1.0
    M = sp.csr_matrix(sp.diags_array(mass))
    flexibility = np.linalg.solve(K.toarray(), mass)[n // 2]
    found = modes(K, M, f_max=float(np.sqrt(2.0 / flexibility)) / (2.0 * np.pi))
    np.testing.assert_allclose(found.omega2, [1.0 / flexibility], rtol=1e-9)
    assert found.next_omega2 == np.inf


def test_massless_dofs_of_a_large_matrix():
    """Every second mass is missing; the others move as after static condensation."""
    K, _, _ = long_chain(700)
    M = sp.csr_matrix(sp.diags_array(np.tile([1.0, 0.0], 350)))
    Kd = K.toarray()
    a, b = np.arange(0, 700, 2), np.arange(1, 700, 2)
    small = Kd[np.ix_(a, a)] - Kd[np.ix_(a, b)] @ np.linalg.solve(Kd[np.ix_(b, b)], Kd[np.ix_(b, a)])
    exact = np.linalg.eigvalsh(small)
    found = modes(K, M, f_max=float(np.sqrt(0.5 * (exact[24] + exact[25]))) / (2.0 * np.pi))
    np.testing.assert_allclose(found.omega2, exact[:25], rtol=1e-8)  # condition 1e5 of the dense one
    assert found.next_omega2 == pytest.approx(exact[25], rel=1e-8)


def test_free_shell_has_a_next_eigenvalue():
    coords, quads = plate(12, 10, (0.3, 0.25))
    part = part_system(model_of(coords, [block("quad4", quads, shell(1e-3))]), 0, NO_DAMPING)
    many = modes(part.K, part.M, count=12, free=True)
    assert np.isnan(many.next_omega2)
    found = modes(part.K, part.M, f_max=float(many.frequencies[8:10].mean()), free=True)
    assert found.omega2.size == 9
    assert found.next_omega2 == pytest.approx(many.omega2[9], rel=1e-7)  # the shift is near the rigid modes


def test_same_input_same_output(shell_case):
    K, M, _ = shell_case
    first, second = (modes(K, M, count=40) for _ in range(2))
    np.testing.assert_array_equal(first.omega2, second.omega2)
    np.testing.assert_array_equal(first.shapes, second.shapes)


def test_shift_amid_the_modes_of_a_free_shell():
    """Many modes: the factor lies amid them, and the lowest are refined by the one below them."""
    coords, quads = plate(12, 10, (0.3, 0.25))
    part = part_system(model_of(coords, [block("quad4", quads, shell(1e-3))]), 0, NO_DAMPING)
    below = modes(part.K, part.M, count=51, free=True)
    amid = modes(part.K, part.M, f_max=float(below.frequencies[49:51].mean()), free=True)
    np.testing.assert_array_equal(amid.omega2[:6], 0.0)
    # Round-off of K^-1 grows with the ratio of its eigenvalues, 1e9 here.
    np.testing.assert_allclose(amid.omega2[6:], below.omega2[6:50], rtol=1e-7)
    np.testing.assert_allclose(amid.shapes.T @ (part.M @ amid.shapes), np.eye(50), atol=1e-9)
    assert amid.residual < 1e-6
    assert amid.next_omega2 == pytest.approx(below.omega2[50], rel=1e-7)
    assert amid.columns < 50 * 6


@pytest.mark.parametrize("by", ["f_max", "count"])
def test_a_large_share_of_all_modes_goes_to_the_dense_solver(by, shell_case, monkeypatch):
    """The lowest come as Lanczos gives them: one inverse iteration takes the round-off of the dense solver away."""
    K, M, exact = shell_case
    n = int(0.32 * K.shape[0])
    wanted: dict[str, Any] = {"count": n}
    if by == "f_max":
        wanted = {"f_max": float(np.sqrt(0.5 * (exact[n - 1] + exact[n]))) / (2.0 * np.pi)}
    sparse = modes(K, M, count=40)
    with monkeypatch.context() as within:
        within.setattr(linalg_modes, "lanczos", lambda *_, **__: pytest.fail("Lanczos"))
        found = modes(K, M, **wanted)
    np.testing.assert_allclose(found.omega2, exact[:n], rtol=1e-5)
    np.testing.assert_allclose(found.omega2[:40], sparse.omega2, rtol=1e-9)
    np.testing.assert_allclose(found.shapes.T @ (M @ found.shapes), np.eye(n), atol=1e-9)
    assert found.next_omega2 == pytest.approx(exact[n], rel=1e-9)
    np.testing.assert_allclose(modes(K.toarray(), M.toarray(), **wanted).omega2, found.omega2, rtol=1e-5)
    monkeypatch.setattr(linalg_modes, "fits", lambda _: False)
    assert not linalg_modes.dense_is_faster(K.shape[0], n)


@pytest.mark.parametrize("kept", [0, 1, 20, 60])
@pytest.mark.parametrize("short", [False, True])
def test_further_modes_are_those_that_there_are(shell_case, kept, short, monkeypatch):
    """All up to 1.5 f_max, half as many again as lie below it, and three: from Lanczos, and window by window."""
    K, M, exact = shell_case
    if short:
        monkeypatch.setattr(windows, "WINDOWS", 0.0)
    limit = 0.5 * (exact[kept - 1] + exact[kept]) if kept else 0.5 * exact[0]
    wanted = max(int((exact <= 2.25 * limit).sum()), kept + max(3, (kept + 1) // 2))
    found = modes(K, M, f_max=float(np.sqrt(limit)) / (2.0 * np.pi), further=True)
    np.testing.assert_allclose(found.omega2, exact[:wanted], rtol=1e-5)  # as the dense solver has the lowest
    np.testing.assert_allclose(found.shapes.T @ (M @ found.shapes), np.eye(wanted), atol=1e-9)
    assert found.next_omega2 == pytest.approx(exact[wanted], rel=1e-8)


@pytest.mark.parametrize("held", [True, False])
@pytest.mark.parametrize("step", [1.2, 1.5])
def test_modes_that_are_known_are_gone_on_from(held, step):
    """From some 50 or 75 modes of a chain to a band that has at least MANY more: those of the closed form."""
    n = 1500
    K, M, exact = long_chain(n, held=held)
    f = 0.5 * (np.sqrt(exact[49]) + np.sqrt(exact[50])) / (2.0 * np.pi)
    known = modes(K, M, f_max=f, further=True, free=not held)
    found = modes(K, M, f_max=step * 1.5 * f, further=True, free=not held, found=known)
    count = found.omega2.size
    assert count - known.omega2.size >= MANY
    assert found.sturm_ok
    start = 0 if held else 1
    np.testing.assert_allclose(found.omega2[start:], exact[start:count], rtol=1e-9)
    np.testing.assert_allclose(found.shapes.T @ (M @ found.shapes), np.eye(count), atol=1e-8)
    at_once = modes(K, M, f_max=step * 1.5 * f, further=True, free=not held)
    assert found.columns - known.columns < at_once.columns


@pytest.mark.parametrize("n", [30, 800])
@pytest.mark.parametrize("masses", [1, 3, 40])
def test_a_body_that_has_no_further_modes_gives_those_that_it_has(n, masses):
    """A few masses in a chain of massless ones: three modes where none lies below f_max, or all that there are."""
    masses = min(masses, n)
    K, _, _ = long_chain(n)
    mass = np.zeros(n)
    mass[np.linspace(0, n - 1, masses).astype(int)] = 1.0
    found = modes(K, sp.csr_matrix(sp.diags_array(mass)), f_max=1e-9, further=True)
    assert found.omega2.size == min(masses, 3)
    assert (found.next_omega2 == np.inf) == (masses <= 3)


def test_round_off_of_a_singular_mass_matrix_makes_no_rigid_modes():
    """A free chain with points without mass in between: omega^2 = 2 k / m sin^2(pi j / 2N), one of them 0."""
    count, k, m = 60, 1e5, 1e-3
    n = 2 * count - 1
    K, M = np.zeros((n, n)), np.zeros((n, n))
    for i in range(n - 1):
        K[i : i + 2, i : i + 2] += k * np.array([[1.0, -1.0], [-1.0, 1.0]])
    M[::2, ::2] = m * np.eye(count)
    noise = np.random.default_rng(0).standard_normal((n, n))
    found = modes(K, M + 1e-15 * m * 0.5 * (noise + noise.T), count=30, free=True)
    exact = 2.0 * k / m * np.sin(0.5 * np.pi * np.arange(30) / count) ** 2
    assert found.omega2[0] == 0.0
    np.testing.assert_allclose(found.omega2[1:], exact[1:], rtol=1e-9)
