"""Couplings, links and equations: what they tie, what they transmit, what they refuse."""

from __future__ import annotations

import numpy as np
import pytest

from creak.arrays import to_dense
from creak.assembly.coupling import Driven
from creak.assembly.elimination import LinearEquation, eliminate, linear_equations, transformation
from creak.errors import InputError
from creak.model.constraints import DistributingCoupling, Equation, Fixed, KinematicCoupling, RigidLink
from helpers_core import NO_DAMPING, NONE, assembled, block, couple, model_of, part_system, point_mass, spring
from helpers_fem import rigid_modes

CLOUD = np.array([[0.0, 0, 0], [1.0, 0, 0], [1.0, 1, 0], [0.0, 1, 0], [0.3, 0.6, 0.5], [0.2, 0.1, 0.9]])
REF = 5
ALL = (1, 2, 3, 4, 5, 6)


def cloud(constraints=(), coords=CLOUD, parts=None, **more):
    """Point masses of mass 1, 2, 3, ... at the nodes."""
    blocks = []
    for i in range(len(coords)):
        part = 0 if parts is None else next(k for k, (_, rows) in enumerate(parts) if i in rows)
        blocks.append(block("mass", [[i]], point_mass(i + 1.0), part, i + 1))
    return model_of(coords, blocks, parts, constraints=constraints, **more)


def residuals(constraint, u: np.ndarray, coords=CLOUD) -> np.ndarray:
    """Value of each scalar equation under the motion u (6 n_node,)."""
    return np.array([np.dot(e.coefficients, u[list(e.labels)]) for e in linear_equations(constraint, coords)])


LINKS = [
    KinematicCoupling("K", REF, np.arange(5), ALL),
    KinematicCoupling("K", REF, np.arange(5), (1, 2, 3)),
    DistributingCoupling("D", REF, np.arange(5), np.array([1.0, 2.0, 1.0, 0.5, 3.0])),
    RigidLink("beam", 4, REF),
]


@pytest.mark.parametrize("constraint", LINKS, ids=lambda c: type(c).__name__)
def test_rigid_motion_strains_no_link(constraint):
    for u in rigid_modes(CLOUD).T:
        np.testing.assert_allclose(residuals(constraint, u), 0.0, atol=1e-14)  # round-off


def test_tie_and_pin_make_dofs_equal():
    u = np.random.default_rng(0).standard_normal(36)
    assert residuals(RigidLink("tie", 0, 1), u) == pytest.approx(u[:6] - u[6:12])
    assert residuals(RigidLink("pin", 0, 1), u) == pytest.approx(u[:3] - u[6:9])


def test_kinematic_coupling_moves_its_nodes_as_a_rigid_body():
    system = part_system(cloud([KinematicCoupling("K", REF, np.arange(5), ALL)]), 0, NO_DAMPING)
    np.testing.assert_array_equal(system.coordinates, 6 * REF + np.arange(6))
    rigid = rigid_modes(CLOUD - CLOUD[REF])
    R = system.rows(np.arange(36))[0].toarray()
    np.testing.assert_allclose(R, rigid, atol=1e-15)
    # The mass matrix of the reference node is that of the rigid cloud.
    m = np.arange(1.0, 7.0)
    np.testing.assert_allclose(system.M.toarray(), rigid.T @ np.diag(np.repeat(m, 6) * (np.arange(36) % 6 < 3)) @ rigid)
    assert system.stats.mass == pytest.approx(21.0)


def test_distributing_coupling_spreads_a_force_by_weight_and_lever():
    """A force on the reference node becomes w_i F / sum(w) plus the couple that balances its lever (RBE3)."""
    weights = np.array([1.0, 2.0, 1.0, 0.5, 3.0])
    constraint = DistributingCoupling("D", REF, np.arange(5), weights)
    equations = list(linear_equations(constraint, CLOUD))
    T = -np.array([e.coefficients[1:] for e in equations])  # ref = T cloud
    load = np.array([3.0, -2.0, 5.0, 0.4, 0.2, -0.7])
    forces = (T.T @ load).reshape(-1, 3)
    np.testing.assert_allclose(forces.sum(axis=0), load[:3], atol=1e-13)
    arm = CLOUD[:5] - CLOUD[REF]
    np.testing.assert_allclose(np.cross(arm, forces).sum(axis=0), load[3:], atol=1e-13)
    # A force at the weighted centre spreads by weight alone.
    centre = weights @ CLOUD[:5] / weights.sum()
    lever = centre - CLOUD[REF]
    f = np.array([1.0, 2.0, 3.0])
    at_centre = (T.T @ np.concatenate([f, np.cross(lever, f)])).reshape(-1, 3)
    np.testing.assert_allclose(at_centre, np.outer(weights / weights.sum(), f), atol=1e-13)


def test_distributing_coupling_on_a_line_is_refused():
    line = np.array([[0.0, 0, 0], [1.0, 0, 0], [2.0, 0, 0], [0.5, 1.0, 0]])
    with pytest.raises(InputError, match=r"'HINGE' has its 3 node\(s\) on a line"):
        list(linear_equations(DistributingCoupling("HINGE", 3, np.arange(3), np.ones(3)), line))


def test_distributing_coupling_on_a_line_may_turn_about_it():
    """Five equations, which rigid motion satisfies; what they carry is the force and the moment across the line."""
    along, ref = np.array([1.0, 2.0, -2.0]) / 3.0, np.array([0.3, 1.0, 0.4])
    coords = np.vstack([np.outer([0.0, 1.0, 2.5], along), ref])
    constraint = DistributingCoupling("HINGE", 3, np.arange(3), np.array([1.0, 2.0, 1.0]), turns_on_line=True)
    rows = []
    for e in constraint.equations(coords):
        rows.append(np.zeros(24))
        np.add.at(rows[-1], 6 * e.nodes_idx + e.dofs - 1, e.coefficients)
    C = np.array(rows)
    assert np.linalg.matrix_rank(C) == 5
    assert np.abs(C @ rigid_modes(coords)).max() < 1e-14
    on_cloud = C[:, :18].reshape(5, 3, 6)[:, :, :3]
    moment = np.cross(coords[:3], on_cloud).sum(axis=1)
    assert np.abs(moment @ along).max() < 1e-14
    with pytest.raises(InputError, match="in a point"):
        list(constraint.equations(np.zeros((4, 3))))


def test_equation_eliminates_its_first_term():
    model = cloud([Equation(np.array([0, 1, 2]), np.array([1, 1, 2]), np.array([2.0, -1.0, 3.0]))])
    system = part_system(model, 0, NO_DAMPING)
    assert 0 not in system.coordinates
    u = system.rows(np.arange(36))[0] @ np.random.default_rng(1).standard_normal(system.n)
    assert 2.0 * u[0] - u[6] + 3.0 * u[13] == pytest.approx(0.0, abs=1e-14)


def test_chain_of_links_ends_at_the_last_master():
    """0 -> 1 -> 2 -> 3 rigidly: all follow node 3, whatever the order of the links."""
    links = [RigidLink("beam", 0, 1), RigidLink("beam", 1, 2), RigidLink("beam", 2, 3)]
    for order in ([0, 1, 2], [2, 1, 0], [1, 2, 0]):
        system = part_system(cloud([links[i] for i in order], CLOUD[:4]), 0, NO_DAMPING)
        np.testing.assert_array_equal(system.coordinates // 6, 3)
        expected = rigid_modes(CLOUD[:4] - CLOUD[3])
        np.testing.assert_allclose(system.rows(np.arange(24))[0].toarray(), expected, atol=1e-14)


def test_redundant_constraints_are_dropped():
    """A closed ring of rigid links says the same thing twice."""
    ring = [RigidLink("beam", 0, 1), RigidLink("beam", 1, 2), RigidLink("beam", 2, 0), RigidLink("beam", 0, 1)]
    system = part_system(cloud(ring, CLOUD[:3]), 0, NO_DAMPING)
    assert system.n == 6
    m = np.array([1.0, 2.0, 3.0])
    assert system.M.toarray()[0, 0] == pytest.approx(m.sum())


def test_node_in_two_couplings_ties_the_references():
    """A node under two reference nodes makes them one rigid body."""
    model = cloud([RigidLink("beam", 0, 1), RigidLink("beam", 0, 2)], CLOUD[:3])
    system = part_system(model, 0, NO_DAMPING)
    assert system.n == 6
    q = np.random.default_rng(0).standard_normal(6)
    u = np.asarray(system.rows(np.arange(18))[0] @ q)
    for link in (RigidLink("beam", 0, 1), RigidLink("beam", 0, 2), RigidLink("beam", 1, 2)):
        np.testing.assert_allclose(residuals(link, u, CLOUD[:3]), 0.0, atol=1e-13)


def test_elimination_substitutes_fully():
    solved = eliminate(
        [
            LinearEquation([1, 2], [1.0, -2.0]),
            LinearEquation([2, 3, 4], [1.0, -1.0, -1.0]),
            LinearEquation([5, 1], [1.0, 1.0]),
        ]
    )
    assert solved == {1: {3: 2.0, 4: 2.0}, 2: {3: 1.0, 4: 1.0}, 5: {3: -2.0, 4: -2.0}}
    T, free = transformation(np.arange(1, 6), solved)
    np.testing.assert_array_equal(free, [3, 4])
    np.testing.assert_array_equal(T.toarray(), [[2, 2], [1, 1], [1, 0], [0, 1], [-2, -2]])


# --- driven and held dofs -------------------------------------------------------------------------------------


def spring_pair(**more):
    return model_of(
        np.array([[0.0, 0, 0], [1.0, 0, 0], [2.0, 0, 0]]),
        [block("mass", [[0], [1], [2]], point_mass(1.0)), block("spring2", [[0, 1], [1, 2]], spring(100.0), 0, 10)],
        **more,
    )


def test_driven_and_held_dof_conflict():
    model = spring_pair(fixed=[Fixed(np.array([0]), (1, 2), "deck.inp:7")])
    with pytest.raises(InputError, match=r"driven degree of freedom is also constrained"):
        assembled(model, Driven({"hinge": np.array([0])}))


def grounded(**more):
    """A mass at node 0 on a spring in x to node 1, which has neither stiffness nor mass in y and z."""
    blocks = [block("mass", [[0]], point_mass(2.0)), block("spring2", [[1, 0]], spring(100.0), 0, 10)]
    return model_of(np.array([[0.0, 0, 0], [1.0, 0, 0]]), blocks, **more)


def test_a_driven_dof_without_stiffness_follows_what_drives_it():
    """Node 1 moves by s in x and z: the spring gives k s in x, the rows are those of the motion itself."""
    system = assembled(grounded(), Driven({"x": np.array([6]), "z": np.array([8])}))
    R, R_s = system.rows(np.array([0, 6, 7, 8]))
    np.testing.assert_array_equal(R_s, [[0, 0], [1, 0], [0, 0], [0, 1]])
    np.testing.assert_array_equal(to_dense(R)[1:], 0.0)
    np.testing.assert_array_equal(to_dense(system.K).diagonal(), [100.0, 0.0, 0.0])
    np.testing.assert_array_equal(to_dense(system.supports.K_qs), [[-100.0, 0.0], [0.0, 0.0], [0.0, 0.0]])
    moved = system.recover(np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0]))
    np.testing.assert_array_equal(moved[[0, 1, 2, 6, 7, 8]], [1.0, 2.0, 3.0, 4.0, 0.0, 5.0])


def test_a_driven_dof_that_is_held_is_refused_by_node_and_dof():
    model = grounded(fixed=[Fixed(np.array([1]), (3,), "deck.inp:7")])
    with pytest.raises(
        InputError, match=r"\[excitation.road\], node 2 Z: a driven degree of freedom is also constrained"
    ):
        assembled(model, Driven({"road": np.array([8])}))


def test_two_driven_dofs_tied_to_each_other_conflict():
    model = spring_pair(constraints=[RigidLink("tie", 0, 1, "deck.inp:9")])
    with pytest.raises(InputError, match="driven degree of freedom is also constrained"):
        assembled(model, Driven({"a": np.array([0]), "b": np.array([6])}))


def test_dofs_of_one_excitation_tied_to_each_other_are_no_conflict():
    model = spring_pair(constraints=[RigidLink("tie", 0, 1, "deck.inp:9")])
    system = assembled(model, Driven({"a": np.array([0, 6])}))
    assert system.supports.names == ("a",)
    np.testing.assert_array_equal(to_dense(system.rows(np.array([0, 6]))[1]).ravel(), [1.0, 1.0])


def test_driving_a_dependent_node_drives_its_reference():
    model = spring_pair(constraints=[RigidLink("pin", 0, 1)])
    system = assembled(model, Driven({"a": np.array([0])}))
    R, R_s = system.rows(np.array([0, 6]))
    np.testing.assert_array_equal(to_dense(R), 0.0)
    np.testing.assert_array_equal(R_s.ravel(), [1.0, 1.0])


def test_supports_carry_mass_and_stiffness_of_the_driven_dof():
    system = assembled(spring_pair(), Driven({"a": np.array([0])}))
    sup = system.supports
    at = np.flatnonzero(system.coordinates == 6)[0]
    assert to_dense(sup.K_qs)[at, 0] == -100.0
    assert sup.K_ss[0, 0] == 100.0
    assert sup.M_ss[0, 0] == 1.0
    assert sup.count == 1


def test_held_dofs_do_not_move():
    system = assembled(spring_pair(fixed=[Fixed(np.array([0, 2]), (1,))]))
    R = to_dense(system.rows(np.array([0, 6, 12]))[0])
    assert not R[[0, 2]].any()
    assert R[1].any()


def test_reference_node_of_two_parts_belongs_to_neither():
    """A loose node ties two parts: its dofs appear once, and masses add up."""
    parts = [("A", range(2)), ("B", range(2, 4))]
    coords = np.vstack([CLOUD[:4], [[0.5, 0.5, 0.5]]])
    blocks = [block("mass", [[i]], point_mass(1.0 + i), i // 2, i + 1) for i in range(4)]
    model = model_of(coords, blocks, parts, constraints=[KinematicCoupling("K", 4, np.arange(4), ALL)])
    system = assembled(model)
    assert system.n == 6
    np.testing.assert_array_equal(system.coordinates // 6, 4)
    np.testing.assert_allclose(np.diag(to_dense(system.M))[:3], 10.0)
    assert system.stats.mass == pytest.approx(10.0)


def test_links_inside_and_between_parts_give_the_same_assembly():
    """One part or two: the link acts in `part_system` or in `couple`, with the same frequencies."""

    def chain(parts):
        blocks = [
            block("mass", [[0], [1]], point_mass(1.0), 0),
            block("spring2", [[0, 1]], spring(50.0), 0, 5),
            block("mass", [[2], [3]], point_mass(2.0), len(parts) - 1, 10),
            block("spring2", [[2, 3]], spring(80.0), len(parts) - 1, 15),
        ]
        coords = np.column_stack([np.array([0.0, 1.0, 1.0, 2.0]), np.zeros(4), np.zeros(4)])
        return model_of(
            coords, blocks, parts, constraints=[RigidLink("pin", 2, 1)], fixed=[Fixed(np.array([0]), (1, 2, 3))]
        )

    one = assembled(chain([("A", range(4))]))
    two = assembled(chain([("A", range(2)), ("B", range(2, 4))]))
    K1, M1, K2, M2 = (to_dense(x) for x in (one.K, one.M, two.K, two.M))
    a, b = (np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real) for K, M in ((K1, M1), (K2, M2)))
    np.testing.assert_allclose(a, b, atol=1e-9)


def test_spring_between_parts_joins_them():
    model = model_of(
        np.array([[0.0, 0, 0], [1.0, 0, 0]]),
        [
            block("mass", [[0]], point_mass(1.0), 0),
            block("mass", [[1]], point_mass(2.0), 1, 2),
            block("spring2", [[0, 1]], spring(6.0, damping=0.3), -1, 3),
        ],
        [("A", [0]), ("B", [1])],
    )
    system = couple([part_system(model, i, NO_DAMPING) for i in range(2)], model, NONE, NO_DAMPING)
    R = to_dense(system.rows(np.array([0, 6]))[0])
    K = R @ to_dense(system.K) @ R.T
    C = R @ to_dense(system.damping.extra) @ R.T
    np.testing.assert_allclose(K, [[6, -6], [-6, 6]])
    np.testing.assert_allclose(C, [[0.3, -0.3], [-0.3, 0.3]])
