"""Damping from the deck, and initial velocities carried into full and reduced Systems."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.assembly.part import Rayleigh, common_rayleigh
from creak.assembly.system import System, to_dense
from creak.errors import InputError
from creak.model.constraints import RigidLink
from creak.reduction.craig_bampton import craig_bampton
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
    with pytest.raises(InputError, match=r"test.inp:1: element\(s\) 42: the two nodes coincide"):
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
