"""Sheets tied over meshes that do not match: rigid motion, constant strain, modes, substructures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

from creak.arrays import to_dense
from creak.assembly.coupling import couple
from creak.assembly.elimination import linear_equations
from creak.assembly.part import common_rayleigh, part_system, split_constraints
from creak.assembly.rigid import unheld_parts
from creak.assembly.system import System
from creak.formats.abaqus.reader import read_deck
from creak.linalg.modes import modes
from creak.model.constraints import Tie
from creak.model.mesh import Model
from creak.reduction.craig_bampton import craig_bampton
from helpers_core import NONE, assembled
from helpers_fem import rigid_modes
from helpers_ties import cut_plate, sections, sheet

WIDE = "*TIE, NAME=SEAM, POSITION TOLERANCE=3.\nRIGHT_X0, LEFT_X1\n"


def model_of_deck(folder: Path, text: str) -> Model:
    path = folder / "deck.inp"
    path.write_text(text, encoding="utf-8")
    return read_deck(path)


def frequencies(system: System, f_max: float) -> np.ndarray:
    """Elastic natural frequencies, Hz."""
    found = np.sqrt(np.maximum(modes(system.K, system.M, f_max=f_max, free=True).omega2, 0.0)) / (2 * np.pi)
    return found[found > 1.0]


def test_equations_of_a_tie():
    x = np.array([[0.0, 0, 0], [2.0, 0, 0], [0.5, 0.1, 0.3]])
    tie = Tie("T", 2, np.array([0, 1]), np.array([0.75, 0.25]), np.array([0.0, 0.1, 0.3]), where="deck.inp:3")
    equations = list(linear_equations(tie, x))
    assert tie.nodes.tolist() == [2, 0, 1]
    assert [e.labels[0] for e in equations] == [12, 13, 14, 15, 16, 17]
    assert {e.where for e in equations} == {"deck.inp:3"}
    for u in rigid_modes(x).T:
        values = [np.dot(e.coefficients, u[list(e.labels)]) for e in equations]
        np.testing.assert_allclose(values, 0.0, atol=1e-15)
    # u = sum w (u_k + theta_k x arm), theta = sum w theta_k, for any motion of the two nodes.
    u = np.random.default_rng(0).standard_normal(18)
    move, turn = u.reshape(3, 6)[:2, :3], u.reshape(3, 6)[:2, 3:]
    u[12:15] = tie.weights @ (move + np.cross(turn, tie.arm))
    u[15:18] = tie.weights @ turn
    np.testing.assert_allclose([np.dot(e.coefficients, u[list(e.labels)]) for e in equations], 0.0, atol=1e-14)
    without = Tie("T", 2, tie.nodes_idx, tie.weights, tie.arm, rotations=False)
    assert [e.labels[0] for e in linear_equations(without, x)] == [12, 13, 14]


@pytest.mark.parametrize(
    ("main", "shift"),
    [("LEFT_X1", (0.0, 0.0, 0.0)), ("LEFT_X1", (0.4, 0.0, 1.5)), ("LEFT_FACE", (-1.0, 2.0, -0.7))],
)
def test_tied_sheets_have_six_rigid_body_modes(main, shift, tmp_path):
    """Exact whatever the offset: the arm turns with the main surface."""
    model = model_of_deck(tmp_path, cut_plate((2, 3), (3, 5), WIDE.replace("LEFT_X1", main), shift))
    system = assembled(model)
    K = to_dense(system.K)
    R = rigid_modes(model.nodes.coords - [60.0, 40.0, 0.0]) / 60.0
    assert np.abs(K @ R[system.coordinates]).max() < 1e-9 * np.abs(K).max()
    every = np.arange(6 * model.nodes.count)
    moved = to_dense(system.rows(every)[0] @ R[system.coordinates])
    np.testing.assert_allclose(moved, R, atol=1e-12)
    spectrum = np.linalg.eigvalsh(K)
    assert np.abs(spectrum[:6]).max() < 1e-9 * spectrum[-1]
    assert spectrum[6] > 1e3 * np.abs(spectrum[:6]).max()


def strain_residual(model: Model, strain: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nodal forces K u of u = strain x (in the plane) and the nodes that they act on; u satisfies the ties."""
    system = assembled(model)
    u = np.zeros((model.nodes.count, 6))
    u[:, :2] = model.nodes.coords[:, :2] @ strain
    q = u.ravel()[system.coordinates]
    np.testing.assert_allclose(system.rows(np.arange(u.size))[0] @ q, u.ravel(), atol=1e-12)
    return np.asarray(system.K @ q).ravel(), system.coordinates // 6


def test_constant_strain_passes_the_seam_of_nested_meshes(tmp_path):
    """Uniaxial stress across the seam: forces act at the far ends only, since each main node meets a secondary one."""
    model = model_of_deck(tmp_path, cut_plate((3, 4), (4, 12)))
    force, node = strain_residual(model, 1e-3 * np.diag([1.0, -0.3]))
    x = model.nodes.coords[node, 0]
    ends = (x < 1e-6) | (x > 120.0 - 1e-6)
    assert np.abs(force[~ends]).max() < 1e-10 * np.abs(force[ends]).max()
    # The resultant is E strain times the area of the section: 210000 x 1e-3 x 80 x 1.
    assert force[(x > 120.0 - 1e-6)].reshape(-1, 6)[:, 0].sum() == pytest.approx(210_000.0 * 1e-3 * 80.0, rel=1e-10)


def test_constant_strain_along_the_seam_passes_for_any_meshes(tmp_path):
    model = model_of_deck(tmp_path, cut_plate((3, 4), (4, 7)))
    force, node = strain_residual(model, 1e-3 * np.diag([-0.3, 1.0]))
    y = model.nodes.coords[node, 1]
    ends = (y < 1e-6) | (y > 80.0 - 1e-6)
    assert np.abs(force[~ends]).max() < 1e-10 * np.abs(force[ends]).max()


def test_force_across_a_seam_of_unrelated_meshes_is_balanced_over_an_element(tmp_path):
    """Node collocation puts the right resultant, not the exact share, on the main nodes (mortar would)."""
    model = model_of_deck(tmp_path, cut_plate((3, 4), (4, 7)))
    force, node = strain_residual(model, 1e-3 * np.diag([1.0, -0.3]))
    x = model.nodes.coords[node, 0]
    seam = np.abs(x - 60.0) < 1e-6
    full = 210_000.0 * 1e-3 * 80.0
    assert abs(force[seam].reshape(-1, 6)[:, 0].sum()) < 1e-9 * full
    # A main node carries full / 4; the trapezoidal rule over 7 intervals errs by a small part of that.
    assert 1e-6 * full < np.abs(force[seam]).max() < 0.1 * full / 4


def test_plate_cut_and_tied_vibrates_as_the_whole_plate(tmp_path):
    whole = "*HEADING\nplate\n" + sheet("PLATE", 1, (24, 16), (0.0, 0.0, 0.0), (120.0, 80.0)) + sections("PLATE")
    reference = frequencies(assembled(model_of_deck(tmp_path, whole)), 1800.0)
    tied = frequencies(assembled(model_of_deck(tmp_path, cut_plate((12, 16), (15, 21)))), 1800.0)
    assert reference.size == tied.size >= 6
    np.testing.assert_allclose(tied, reference, rtol=0.01)


def test_tie_between_parts_holds_the_other_part(tmp_path):
    clamp = "*BOUNDARY\n1, ENCASTRE\n"
    held = model_of_deck(tmp_path, cut_plate((3, 4), (4, 7)) + clamp)
    assert unheld_parts(held, NONE) == []
    loose = model_of_deck(tmp_path, cut_plate((3, 4), (4, 7), tie="") + clamp)
    assert unheld_parts(loose, NONE) == ["RIGHT"]
    assert all(isinstance(c, Tie) for c in split_constraints(held)[1])
    assert len(split_constraints(held)[1]) == 8


def test_springs_hold_a_part_far_from_the_origin(tmp_path):
    """Six springs at three corners: whether they hold the part does not depend on where the axes begin."""
    deck = sheet("PLATE", 1, (3, 2), (0.0, 0.0, 0.0), (120.0, 80.0)) + sections("PLATE")
    for k, (node, dof) in enumerate([(1, 1), (1, 2), (1, 3), (4, 2), (4, 3), (9, 3)]):
        deck += f"*ELEMENT, TYPE=SPRING1, ELSET=K{k}\n{100 + k}, {node}\n*SPRING, ELSET=K{k}\n{dof}\n50.\n"
    model = model_of_deck(tmp_path, "*HEADING\nplate\n" + deck)
    for shift in (0.0, 4e6):
        model.nodes.coords[:] += shift
        assert unheld_parts(model, NONE) == []


def test_substructures_tied_over_their_retained_nodes(tmp_path):
    """Both sides of the seam are retained; the reduced plate has the modes of the full one."""
    model = model_of_deck(tmp_path, cut_plate((6, 8), (8, 11)))
    common = common_rayleigh(model)
    seam = np.unique(
        [
            label
            for c in split_constraints(model)[1]
            for e in linear_equations(c, model.nodes.coords)
            for label in e.labels
        ]
    )
    parts = [part_system(model, i, common) for i in range(2)]
    # 9 + 12 nodes on the seam, six dofs each.
    assert seam.size == 6 * (9 + 12)
    reduced = [
        craig_bampton(p, np.unique(sp.csr_matrix(p.rows(seam)[0]).indices).astype(np.int64), f_max=6000.0)
        for p in parts
    ]
    small, full = couple(reduced, model, NONE, common), couple(parts, model, NONE, common)
    assert small.n < 0.5 * full.n
    # Fixed-interface modes to four times the band: errors of a few (1 / 4)^4 at its end.
    np.testing.assert_allclose(frequencies(small, 1500.0), frequencies(full, 1500.0), rtol=5e-3)
