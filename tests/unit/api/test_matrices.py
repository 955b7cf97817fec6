"""Systems from matrices of any program: joined, held, driven, reduced, stepped."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
import scipy.linalg as sla
import scipy.sparse as sp

import creak
from creak.arrays import to_dense
from helpers_core import bar, chain, time_axis

N = 12
M, K = chain(N)
"""12 masses of 1 kg in a row, the first tied to ground."""


def omega2(K: np.ndarray, M: np.ndarray) -> np.ndarray:
    return sla.eigvalsh(K, M)


@pytest.mark.parametrize("kind", [np.asarray, sp.csr_matrix, sp.coo_array])
def test_modes_of_dense_and_sparse_matrices(kind):
    found = creak.modes(kind(K), kind(M), count=4)
    np.testing.assert_allclose(found.omega2, omega2(K, M)[:4], rtol=1e-10)  # round-off of a small dense problem


def test_a_complex_matrix_without_imaginary_parts_is_taken():
    found = creak.modes(K.astype(complex), sp.csr_matrix(M.astype(complex)), count=4)
    np.testing.assert_array_equal(found.omega2, creak.modes(K, sp.csr_matrix(M), count=4).omega2)


def test_modes_find_out_that_a_body_is_free_and_how_many_there_are():
    M_bar, K_bar = bar(8, 1.0, 1.0, 1.0)
    found = creak.modes(K_bar, M_bar)
    assert found.omega2.size == 9
    assert found.omega2[0] == 0.0
    assert creak.modes(K_bar, M_bar, f_max=1e-3).omega2.tolist() == [0.0]


def test_systems_join_where_they_share_labels():
    """Two chains end to end are one chain: the shared mass counts twice."""
    first = creak.system_from_matrices(K, M, labels=np.arange(N))
    M_2, K_2 = bar(5, 5.0, 5e4, 1.0)
    order = np.array([3, 0, 5, 1, 4, 2])
    labels = N - 1 + order
    second = creak.system_from_matrices(K_2[np.ix_(order, order)], M_2[np.ix_(order, order)], labels=labels)
    joined = creak.couple(first, second)
    whole_M, whole_K = np.zeros((N + 5, N + 5)), np.zeros((N + 5, N + 5))
    whole_M[:N, :N], whole_K[:N, :N] = M, K
    whole_M[N - 1 :, N - 1 :] += M_2
    whole_K[N - 1 :, N - 1 :] += K_2
    found = creak.modes(joined.K, joined.M, count=joined.n)
    np.testing.assert_allclose(found.omega2, omega2(whole_K, whole_M), rtol=1e-9)


def test_held_dofs_are_struck_out():
    held = creak.couple(creak.system_from_matrices(K, M), fixed=[4])
    rest = np.delete(np.arange(N), 4)
    found = creak.modes(held.K, held.M, count=5)
    np.testing.assert_allclose(found.omega2, omega2(K[np.ix_(rest, rest)], M[np.ix_(rest, rest)])[:5], rtol=1e-9)
    assert held.recover(np.ones(N - 1)).tolist() == [float(i != 4) for i in range(N)]


def test_an_equation_ties_two_dofs():
    tied = creak.couple(creak.system_from_matrices(K, M), equations=[([11, 0], [1.0, -2.0])])
    T = np.vstack([np.eye(N - 1), np.eye(1, N - 1) * 2.0])
    found = creak.modes(tied.K, tied.M, count=N - 1)
    np.testing.assert_allclose(found.omega2, omega2(T.T @ K @ T, T.T @ M @ T), rtol=1e-9)


def test_rayleigh_numbers_may_differ_between_systems():
    """C of the joined System is the sum of what each brings: dissipation of a unit velocity field."""
    M_2, K_2 = bar(3, 3.0, 1e4, 2.0)
    a = creak.system_from_matrices(K, M, alpha=2.0, beta=1e-4)
    b = creak.system_from_matrices(K_2, M_2, 0.5 * K_2, labels=np.arange(N - 1, N + 3), alpha=5.0, beta=3e-4)
    both = creak.couple(a, b)
    v = np.random.default_rng(3).standard_normal(both.n)
    d = both.damping
    found = v @ (d.alpha * (both.M @ v) + d.beta * (both.K @ v) + d.other(v))
    u = both.recover(v)
    first, second = u[:N], u[N - 1 :]
    exact = first @ ((2.0 * M + 1e-4 * K) @ first) + second @ ((5.0 * M_2 + 3e-4 * K_2 + 0.5 * K_2) @ second)
    assert found == pytest.approx(exact, rel=1e-12)


def test_craig_bampton_retains_by_label_and_is_exact_with_all_modes():
    labels = 100 - 7 * np.arange(N)
    system = creak.system_from_matrices(K, M, labels=labels)
    reduced = creak.craig_bampton(system, [labels[5], labels[0]], count=N - 2)
    assert reduced.coordinates[:2].tolist() == sorted([labels[5], labels[0]], key=lambda x: labels.tolist().index(x))
    found = creak.modes(reduced.K, reduced.M, count=N)
    np.testing.assert_allclose(found.omega2, omega2(K, M), rtol=1e-9)


def test_guyan_is_static_condensation():
    reduced = creak.guyan(creak.system_from_matrices(K, M), [3, 11])
    keep, rest = [3, 11], [i for i in range(N) if i not in (3, 11)]
    exact = K[np.ix_(keep, keep)] - K[np.ix_(keep, rest)] @ np.linalg.solve(
        K[np.ix_(rest, rest)], K[np.ix_(rest, keep)]
    )
    np.testing.assert_allclose(np.asarray(reduced.K), exact, rtol=1e-10)


def test_gap_modes_answer_a_static_channel_force_exactly():
    system = creak.couple(creak.system_from_matrices(K, M))
    gaps = creak.gap_channels(np.eye(N)[[7, 11]], 1.0, 1e5)
    small = creak.gap_modes(system, gaps, count=2)
    assert small.n == 4
    R = np.asarray(small.rows(np.array([7, 11]))[0])
    answer = R @ np.linalg.solve(small.K.toarray(), R.T)
    np.testing.assert_allclose(answer, np.linalg.inv(K)[np.ix_([7, 11], [7, 11])], rtol=1e-9)


# --- stepping ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("prepare", [lambda s: s, creak.diagonalise], ids=["general", "compiled"])
def test_mass_on_a_penalty_stop(prepare):
    """m = 100, k = 1e4, stop 1e6, v0 = 1: F 9950.3719, contact .0312600153 s, impulse 198.01980 (closed form)."""
    system = prepare(creak.system_from_matrices([[1e4]], [[100.0]], velocity=[1.0]))
    stop = creak.gap_channels([[-1.0]], 0.0, 1e6, names=["stop"], group="buffer")
    history = creak.simulate(system, stop, creak.make_loads(system, time_axis(0.05, 2e-4)), observed=[0])
    (event,) = creak.find_events(history, stop, merge=1e-3, f_max=500.0)
    # HHT at h / T = 3e-4: period error (2 pi h / T)^2 / 10 and a damping of 1e-10; the end is known to a step.
    assert event.force_peak == pytest.approx(9950.3719, rel=1e-4)
    assert event.impulse == pytest.approx(198.01980, rel=1e-3)
    assert event.t_end - event.t_start == pytest.approx(0.0312600153, abs=4e-5)
    assert (event.group, event.channel) == ("buffer", "stop")


def test_full_and_reduced_follow_a_driven_base_alike():
    system = creak.system_from_matrices(K, M, beta=1e-4)
    reduced = creak.craig_bampton(system, [0, N - 1], count=N - 2)
    time = time_axis(0.4, 1e-3)
    gaps = creak.gap_channels(-np.eye(N)[[N - 1]], 1e-3, 1e5)
    ends = []
    for s in (creak.couple(system, driven={"base": [0]}), creak.diagonalise(creak.couple(reduced, driven={"base": 0}))):
        loads = creak.make_loads(s, time, motion={"base": creak.Sine(4.0, 1e-3)})
        ends.append(creak.simulate(s, gaps, loads, creak.HHT()))
    assert ends[0].force.max() > 0.0
    np.testing.assert_allclose(ends[1].force, ends[0].force, atol=1e-7 * ends[0].force.max())  # round-off
    np.testing.assert_allclose(ends[1].displacement, ends[0].displacement, atol=1e-9)


def test_forces_as_signals_samples_and_one_for_each_label():
    system = creak.system_from_matrices(K, M)
    time = time_axis(0.1, 1e-3)
    F = np.sin(20.0 * time)
    ways = [
        [([2, 5], creak.Table(time, F))],
        [([2, 5], F)],
        [([2, 5], np.column_stack([F, F]))],
        [([2], F), ([5], F)],
    ]
    runs = [creak.simulate(system, [], creak.make_loads(system, time, forces=w), observed=range(N)) for w in ways]
    for run in runs[1:]:
        np.testing.assert_allclose(run.displacement, runs[0].displacement, atol=1e-15)
    assert np.abs(runs[0].displacement).max() > 1e-5


def test_a_preload_is_in_balance_at_rest():
    system = creak.system_from_matrices([[1e4]], [[1.0]])
    seal = creak.gap_channels([[1.0]], 0.0, 1e5, preload=20.0)
    history = creak.simulate(system, seal, creak.make_loads(system, time_axis(0.02, 1e-4)), observed=[0])
    np.testing.assert_allclose(history.force, 20.0, rtol=1e-12)
    assert np.abs(history.displacement).max() < 1e-12


def test_channels_join_and_group():
    both = creak.join_gaps(
        creak.gap_channels(np.eye(3)[:2], [0.1, 0.2], 1.0, group="a"),
        creak.gap_channels([[1.0, -1.0]], 0.3, np.inf, labels=[9, 4], group="b"),
    )
    assert both.m == 3
    assert both.group == ("a", "a", "b")
    assert both.labels.tolist() == [0, 1, 4, 9]
    assert both.G.toarray()[2].tolist() == [0.0, 0.0, -1.0, 1.0]


# --- wrong input ------------------------------------------------------------------------------------------------------

GOOD = creak.system_from_matrices(K, M)
DRIVEN = creak.couple(GOOD, driven={"base": [0]})
GAPS = creak.gap_channels(np.eye(1, N), 0.0, 1.0)
T = time_axis(0.01, 1e-3)
BAD = {
    "one triangle": (lambda: creak.system_from_matrices(np.triu(K), M), "K is not symmetric"),
    "not square": (lambda: creak.system_from_matrices(K[:3], M), r"K is \(3, 12\)"),
    "two sizes": (lambda: creak.system_from_matrices(K, M[:3, :3]), "one size"),
    "not finite": (lambda: creak.modes(K, np.nan * M), "M has entries that are not finite"),
    "structural damping": (
        lambda: creak.system_from_matrices(K * (1.0 + 0.02j), M),
        "K is complex: imaginary parts up to .*; expected a real matrix.* alpha and beta",
    ),
    "complex modes": (lambda: creak.modes(K, sp.csr_matrix(M + 0.5j * M)), "M is complex: .* up to 0.5; .* as C"),
    "complex rows": (lambda: creak.gap_channels(np.eye(3) * 1j, 0.0, 1.0), "G is complex"),
    "no matrix": (lambda: creak.modes("K", M), "K is no matrix"),
    "negative mass": (lambda: creak.system_from_matrices(K, -M), "M has a negative diagonal"),
    "labels twice": (lambda: creak.system_from_matrices(K, M, labels=np.zeros(N, int)), "labels that repeat"),
    "labels of floats": (lambda: creak.system_from_matrices(K, M, labels=np.arange(N) / 2), "integers"),
    "velocity": (lambda: creak.system_from_matrices(K, M, velocity=[1.0]), "velocity of shape"),
    "both": (lambda: creak.modes(K, M, count=2, f_max=3.0), "both count and f_max"),
    "count": (lambda: creak.modes(K, M, count=0), "count = 0"),
    "unknown boundary": (lambda: creak.craig_bampton(GOOD, [99], count=1), "boundary: there is no dof 99"),
    "neither": (lambda: creak.craig_bampton(GOOD, [0]), "expected one of them"),
    "driven already": (lambda: creak.craig_bampton(DRIVEN, [3], count=1), "driven already"),
    "joined late": (lambda: creak.couple(DRIVEN, GOOD), "prescribed motion or modal damping"),
    "nothing": (creak.couple, "no System"),
    "unknown fixed": (lambda: creak.couple(GOOD, fixed=[50]), "fixed: there is no dof 50"),
    "held and driven": (lambda: creak.couple(GOOD, fixed=[0], driven={"base": [0]}), "driven .* is also constrained"),
    "equation": (lambda: creak.couple(GOOD, equations=[([0, 1], [1.0])]), "2 labels"),
    "gap rows": (lambda: creak.gap_channels(np.eye(3), 0.0, 1.0, labels=[0, 1]), "labels of shape"),
    "gap0": (lambda: creak.gap_channels(np.eye(3), [0.0, 1.0], 1.0), r"gap0 has shape \(2,\)"),
    "stiffness": (lambda: creak.gap_channels(np.eye(3), 0.0, -1.0), "stiffness = -1.0"),
    "friction alone": (lambda: creak.gap_channels(np.eye(3), 0.0, 1.0, friction=0.2), "without tangents"),
    "kinetic": (
        lambda: creak.gap_channels(np.eye(1, 3), 0.0, 1.0, tangents=[np.eye(1, 3)], friction=(0.1, 0.2)),
        "kinetic <= static",
    ),
    "preload": (lambda: creak.gap_channels(np.eye(1, 3), 0.1, 1.0, preload=2.0), "preloaded channel"),
    "names": (lambda: creak.gap_channels(np.eye(3), 0.0, 1.0, names=["a"]), "1 names"),
    "times": (lambda: creak.make_loads(GOOD, [0.0, 1.0, 3.0]), "uneven or falling"),
    "late times": (lambda: creak.make_loads(GOOD, 0.5 + T), r"times that start at 0\.5 s; .* from 0"),
    "early times": (lambda: creak.make_loads(GOOD, T - T[1]), r"times that start at -0\.001 s"),
    "no times": (lambda: creak.make_loads(GOOD, np.full(9, np.nan)), "the time nan among them; .* from 0"),
    "endless": (lambda: creak.make_loads(GOOD, [0.0, np.inf]), "the time inf among them"),
    "one time": (lambda: creak.make_loads(GOOD, [0.0]), r"times of shape \(1,\)"),
    "words": (lambda: creak.make_loads(GOOD, ["now", "then"]), "times that are no numbers"),
    "no motion": (lambda: creak.make_loads(DRIVEN, T), "motion for nothing; .* 'base'"),
    "forces": (lambda: creak.make_loads(GOOD, T, forces=[([0], [1.0, 2.0])]), r"forces of shape \(2,\)"),
    "observed": (lambda: creak.simulate(GOOD, GAPS, creak.make_loads(GOOD, T), observed=[77]), "observed: there is no"),
    "other loads": (lambda: creak.simulate(DRIVEN, GAPS, creak.make_loads(GOOD, T)), "0 prescribed coordinates"),
    "gaps elsewhere": (
        lambda: creak.gap_modes(GOOD, creak.gap_channels([[1.0]], 0.0, 1.0, labels=[40]), count=1),
        "gaps: there is no dof 40",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_wrong_input_gets_one_clear_message(case):
    call, text = BAD[case]
    with pytest.raises(creak.InputError, match=text):
        call()


def test_labels_are_names_however_large():
    """Two chains joined, held and driven under labels of nodes near 1e12: the numbers are those of small labels."""
    far = 6 * 10**12
    spread = far + np.array([0, 7, 14, 15, 600, 6 * 10**9])
    M_3, K_3 = chain(3)
    M_4, K_4 = bar(3, 3.0, 3e4, 1.0)

    def joined(labels):
        parts = [creak.system_from_matrices(K_3, M_3, labels=labels[:3])]
        parts.append(creak.system_from_matrices(K_4, M_4, labels=labels[2:], velocity=np.arange(4.0)))
        link = [([labels[1], labels[4]], [1.0, -0.5])]
        return creak.couple(*parts, fixed=[labels[0]], driven={"end": [labels[5]]}, equations=link)

    large, small = joined(spread), joined(np.arange(6))
    for name in ("K", "M"):
        np.testing.assert_array_equal(to_dense(getattr(large, name)), to_dense(getattr(small, name)))
    np.testing.assert_array_equal(large.labels, spread)
    np.testing.assert_array_equal(large.coordinates, spread[small.coordinates])
    np.testing.assert_array_equal(large.velocity, small.velocity)
    order = np.array([5, 1, 0, 3])
    for ours, theirs in zip(large.rows(spread[order]), small.rows(order), strict=True):
        np.testing.assert_array_equal(to_dense(ours), to_dense(theirs))
    bare = creak.couple(creak.system_from_matrices(np.diag([1.0, 0.0]), np.diag([1.0, 0.0]), labels=spread[2:4]))
    with pytest.raises(creak.InputError, match=f"acts at dof {spread[3]}, but it has neither"):
        bare.bear(spread[3:4])


def test_what_is_no_system_is_not_joined():
    with pytest.raises(creak.InputError, match="a ndarray to couple; expected Systems"):
        creak.couple(np.eye(2))


def test_a_system_of_matrices_goes_to_other_processes():
    """What a pool of workers asks for."""
    system = creak.system_from_matrices(np.diag([3.0, 2.0]), np.eye(2), labels=[7, 5])
    again = pickle.loads(pickle.dumps(system))
    for one, other in zip(again.rows(np.array([5, 7])), system.rows(np.array([5, 7])), strict=True):
        np.testing.assert_array_equal(to_dense(one), to_dense(other))


def test_a_notebook_shows_shapes_instead_of_arrays():
    system = creak.system_from_matrices(np.diag([3.0, 2.0]), np.eye(2))
    gaps = creak.gap_channels([[-1.0]], 0.1, 1e3)
    history = creak.simulate(system, gaps, creak.make_loads(system, np.linspace(0.0, 1.0, 101)))
    assert "time (" in repr(history)
    assert "M (2, 2)" in repr(system)
    assert all("\n" not in repr(one) and len(repr(one)) < 800 for one in (system, gaps, history))
