"""Damping from the deck, and initial velocities carried into full and reduced Systems."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg as sla
import scipy.sparse as sp

import creak
from creak.arrays import to_dense
from creak.assembly.part import Rayleigh, common_rayleigh
from creak.assembly.system import System
from creak.errors import InputError
from creak.model.constraints import RigidLink
from creak.reduction.craig_bampton import craig_bampton
from creak.studies.run.precheck import velocity_warnings
from helpers_core import (
    NONE,
    STEEL,
    assembled,
    beam_section,
    block,
    couple,
    model_of,
    part_system,
    point_mass,
    spring,
    straight_beam,
)

SOFT = replace(STEEL, name="SOFT", youngs_modulus=2e9, alpha=7.0, beta=3e-4)
HARD = replace(STEEL, name="HARD", alpha=2.0, beta=1e-5)


def damping_matrix(system: System) -> np.ndarray:
    d = system.damping
    C = d.alpha * to_dense(system.M) + d.beta * to_dense(system.K)
    return C if d.extra is None else C + to_dense(d.extra)


def two_materials():
    """Six beams of one material, two of another, a spring with a dashpot and a damped point mass."""
    coords, e = straight_beam(8, 1.0)
    return model_of(
        coords,
        [
            block("beam2", e[:6], beam_section(material=HARD), 0),
            block("beam2", e[6:], beam_section(material=SOFT), 0, 7),
            block("spring1", [[8]], spring(500.0, 3, damping=12.0), 0, 20),
            block("mass", [[4]], point_mass(0.3, alpha=9.0), 0, 30),
        ],
    )


def test_each_material_keeps_its_own_rayleigh_damping():
    """C = sum over elements of alpha_e M_e + beta_e K_e, plus dashpots; springs and masses carry their own."""
    model = two_materials()
    system = part_system(model, 0, common_rayleigh(model))
    expected = np.zeros((54, 54))
    for b, (alpha, beta) in zip(model.blocks, ((2.0, 1e-5), (7.0, 3e-4), (0.0, 0.0), (9.0, 0.0)), strict=True):
        alone = part_system(replace(model, blocks=(b,)), 0, Rayleigh(0.0, 0.0), override=True)
        at = np.ix_(alone.coordinates, alone.coordinates)
        expected[at] += alpha * to_dense(alone.M) + beta * to_dense(alone.K)
    expected[6 * 8 + 2, 6 * 8 + 2] += 12.0
    np.testing.assert_allclose(damping_matrix(system), expected, atol=1e-9 * expected.max())


def test_common_numbers_are_those_of_most_elements():
    assert common_rayleigh(two_materials()) == Rayleigh(2.0, 1e-5)
    assert common_rayleigh(model_of(np.zeros((1, 3)), [block("mass", [[0]], point_mass(1.0))])) == Rayleigh(0.0, 0.0)


def test_one_material_needs_no_explicit_matrix():
    coords, e = straight_beam(4, 1.0)
    model = model_of(coords, [block("beam2", e, beam_section(material=HARD))])
    damping = part_system(model, 0, common_rayleigh(model)).damping
    assert damping.is_rayleigh
    assert (damping.alpha, damping.beta) == (2.0, 1e-5)


def test_study_damping_replaces_materials_but_not_dashpots():
    model = two_materials()
    system = part_system(model, 0, Rayleigh(1.0, 1e-6), override=True)
    expected = 1.0 * to_dense(system.M) + 1e-6 * to_dense(system.K)
    expected[6 * 8 + 2, 6 * 8 + 2] += 12.0
    np.testing.assert_allclose(damping_matrix(system), expected, atol=1e-9 * expected.max())


def test_reduction_keeps_material_damping_exactly():
    """With all modes kept the reduced C is the full one in another basis."""
    model = two_materials()
    full = part_system(model, 0, common_rayleigh(model))
    small = craig_bampton(full, np.flatnonzero(np.isin(full.coordinates // 6, (0, 8))), count=1000)
    V = small.rows(full.coordinates)[0].toarray()
    C = damping_matrix(full)
    np.testing.assert_allclose(damping_matrix(small), V.T @ C @ V, atol=1e-8 * np.abs(V.T @ C @ V).max())


# --- elements that cannot be -----------------------------------------------------------------------------------


def test_degenerate_elements_are_named_by_their_labels():
    coords, e = straight_beam(3, 1.0)
    coords[2] = coords[1]
    model = model_of(coords, [block("beam2", e, beam_section(), 0, 41)])
    with pytest.raises(InputError, match=r"test.inp:1: element 42: the two nodes coincide"):
        part_system(model, 0, Rayleigh(0.0, 0.0))


# --- initial velocity -------------------------------------------------------------------------------------------


def flying_beam(velocity, constraints=()):
    coords, e = straight_beam(6, 1.0)
    return model_of(coords, [block("beam2", e, beam_section())], constraints=constraints, initial_velocity=velocity)


def test_initial_velocity_reaches_the_assembly():
    system = assembled(flying_beam([(3, 2, 5.0), (4, 1, -1.0)]))
    v = system.rows(np.arange(42))[0] @ system.velocity
    assert v[3 * 6 + 1] == 5.0
    assert v[4 * 6] == -1.0
    assert np.count_nonzero(v) == 2


@pytest.mark.parametrize("count", [0, 3, 1000])
def test_rigid_flight_survives_any_reduction(count):
    """All nodes at one velocity: the reduced body flies on with the same momentum and no strain."""
    model = flying_beam([(i, 2, -4.0) for i in range(7)])
    full = part_system(model, 0, Rayleigh(0.0, 0.0))
    ends = np.flatnonzero(np.isin(full.coordinates // 6, (0, 6)))
    system = couple([craig_bampton(full, ends, count=count)], model, NONE, Rayleigh(0.0, 0.0))
    v = (system.rows(np.arange(42))[0] @ system.velocity).reshape(-1, 6)
    np.testing.assert_allclose(v[:, 1], -4.0, rtol=1e-9)
    np.testing.assert_allclose(np.delete(v, 1, axis=1), 0.0, atol=1e-8)


def test_velocity_of_nodes_under_a_coupling_is_not_lost():
    """A rigid part thrown as a whole: its nodes follow a reference node, and so does their velocity."""
    link = [RigidLink("beam", i, 6) for i in range(6)]
    model = flying_beam([(i, 2, -4.0) for i in range(7)], link)
    system = assembled(model)
    v = (system.rows(np.arange(42))[0] @ system.velocity).reshape(-1, 6)
    np.testing.assert_allclose(v[:, 1], -4.0)


def test_velocity_of_nodes_tied_to_a_loose_reference_is_not_lost():
    """The reference node belongs to no part; all nodes, itself included, are given the velocity."""
    coords, e = straight_beam(2, 1.0)
    coords = np.vstack([coords, [[0.5, 0.5, 0.0]]])
    model = model_of(
        coords,
        [block("beam2", e, beam_section())],
        [("A", range(3))],
        constraints=[RigidLink("beam", 0, 3), RigidLink("beam", 2, 3)],
        initial_velocity=[(i, 2, -4.0) for i in range(4)],
    )
    system = assembled(model)
    v = (system.rows(np.arange(24))[0] @ system.velocity).reshape(-1, 6)
    np.testing.assert_allclose(v[:, 1], -4.0)


HALVES, AT = (slice(0, 4), slice(4, 8)), ([0, 1, 2, 3], [3, 4, 5, 6])
X_2, X_3 = 6, 12
MASSES = (1.0, 3.0)


def linked(velocity):
    """Masses of 1 and 3 kg at nodes 2 and 3, one part, on a spring from node 1; node 2 follows node 3."""
    blocks = [
        block("spring2", [[0, 1]], spring(1e3, 1)),
        block("mass", [[1]], point_mass(MASSES[0]), 0, 5),
        block("mass", [[2]], point_mass(MASSES[1]), 0, 6),
    ]
    coords = np.array([[0.0, 0, 0], [1.0, 0, 0], [2.0, 0, 0]])
    model = model_of(coords, blocks, constraints=[RigidLink("beam", 1, 2)], initial_velocity=velocity)
    system = assembled(model)
    return model, system, np.asarray(system.rows(np.array([X_2, X_3]))[0] @ system.velocity)


@pytest.mark.parametrize(
    ("velocity", "expected", "warned"),
    [
        ([(1, 1, 8.0), (2, 1, 8.0)], 8.0, 0),
        ([(2, 1, 8.0)], 8.0, 0),  # what follows and is given none has that of the others
        ([(1, 1, 8.0)], MASSES[0] * 8.0 / sum(MASSES), 1),
        ([(1, 1, 8.0), (2, 1, 4.0)], (MASSES[0] * 8.0 + MASSES[1] * 4.0) / sum(MASSES), 1),
    ],
)
def test_velocities_of_linked_masses_keep_their_momentum(velocity, expected, warned):
    model, system, v = linked(velocity)
    np.testing.assert_allclose(v, expected, rtol=1e-10)
    assert len(velocity_warnings(model, system, "m/s")) == warned


def test_the_warning_names_the_node_and_both_velocities():
    model, system, _ = linked([(1, 1, 8.0)])
    (text,) = velocity_warnings(model, system, "m/s")
    assert text.startswith("node 2 X of part ")
    assert "starts with 2 instead of 8 m/s" in text


def test_a_body_thrown_at_dependent_nodes_alone_flies_and_turns():
    """Two masses on a rigid bar whose reference has none: momentum and angular momentum are those given."""
    coords = np.array([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    links = [RigidLink("beam", 0, 2), RigidLink("beam", 1, 2)]
    model = model_of(
        coords,
        [block("mass", [[0], [1]], point_mass(2.0))],
        constraints=links,
        initial_velocity=[(0, 1, 3.0), (1, 1, 5.0)],
    )
    system = assembled(model)
    v = np.asarray(system.rows(np.arange(18))[0] @ system.velocity)
    np.testing.assert_allclose(v[[0, 6, 12, 17]], [3.0, 5.0, 4.0, -1.0], atol=1e-9)  # v = 4 - y, turning about Z


@pytest.mark.parametrize("kind", [np.asarray, sp.csr_matrix])
def test_systems_that_meet_at_unequal_speeds_share_their_momentum(kind):
    one = creak.system_from_matrices(kind([[0.0]]), kind([[1.0]]), labels=[5], velocity=[1.0])
    other = creak.system_from_matrices(kind([[0.0]]), kind([[3.0]]), labels=[5])
    for joined in (creak.couple(one, other), creak.couple(other, one)):
        np.testing.assert_allclose(joined.velocity, [0.25], rtol=1e-12)


def test_a_fit_over_consistent_mass_is_that_of_full_matrices():
    rng = np.random.default_rng(3)
    M = sla.block_diag(*(a @ a.T for a in rng.normal(size=(2, 4, 4))))
    v = rng.normal(size=8)
    parts = [
        creak.system_from_matrices(M[k, k], M[k, k], labels=at, velocity=v[k]) for k, at in zip(HALVES, AT, strict=True)
    ]
    joined = creak.couple(*parts, equations=[([1, 5], [1.0, -2.0])])
    T = np.zeros((8, 6))  # 0, 2, 3, 4, 5, 6 of the labels 0 to 6; 1 = 2 x 5
    T[[0, 2, 3], [0, 1, 2]] = T[[4, 5, 6, 7], [2, 3, 4, 5]] = 1.0
    T[1, 4] = 2.0
    expected = np.linalg.solve(T.T @ M @ T, T.T @ M @ v)
    found = joined.rows(np.array([0, 2, 3, 4, 5, 6]))[0] @ joined.velocity
    np.testing.assert_allclose(found, expected, atol=1e-8 * np.abs(expected).max())
