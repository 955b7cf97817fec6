"""Properties that every shell element must have whatever its shape."""

from __future__ import annotations

import numpy as np
import pytest

from creak.elements.geometry import CHUNK, DegenerateElement
from creak.elements.shells.common import SPIN
from creak.errors import CreakError
from helpers_fem import (
    KINDS,
    macneal_patch,
    random_rotation,
    rectangle,
    rigid_modes,
    shell_section,
)

ROUND_OFF = 1e-12
SECTION = shell_section(0.005, 1e6, 0.25, 7.0)
kinds = pytest.mark.parametrize("kind", sorted(KINDS))


def warped_patch(kind: str):
    mesh = macneal_patch(kind)
    mesh.coords[:, 2] += 0.01 * np.random.default_rng(1).standard_normal(8)
    return mesh


def warped_element(kind: str) -> np.ndarray:
    mesh = warped_patch(kind)
    return mesh.coords[mesh.elements[:1]]


@kinds
def test_rigid_body_motion_of_warped_patch_is_strain_free(kind):
    mesh = warped_patch(kind)
    stiffness = mesh.stiffness(SECTION)
    assert abs(stiffness @ rigid_modes(mesh.coords)).max() < ROUND_OFF * abs(stiffness).max()


@kinds
def test_free_warped_patch_has_six_zero_energy_modes_and_no_more(kind):
    mesh = warped_patch(kind)
    energy = np.linalg.eigvalsh(mesh.stiffness(SECTION).toarray())
    assert np.all(np.abs(energy[:6]) < ROUND_OFF * energy[-1])
    assert energy[6] > 1e-9 * energy[-1]


@kinds
@pytest.mark.parametrize("warp", [0.0, 0.01, 0.03])
def test_single_element_has_six_zero_energy_modes_and_no_more(kind, warp):
    mesh = macneal_patch(kind)
    coords = mesh.coords[mesh.elements[:1]] + warp * np.array([0, 0, 1.0]) * (mesh.elements[:1, :, None] == 5)
    energy = np.linalg.eigvalsh(KINDS[kind].stiffness(coords, SECTION)[0])
    assert np.all(np.abs(energy[:6]) < ROUND_OFF * energy[-1])
    assert energy[6] > 1e3 * np.abs(energy[:6]).max()
    assert energy[6] > 1e-13 * energy[-1]


@kinds
def test_matrices_are_exactly_symmetric(kind):
    mesh = warped_patch(kind)
    for compute in (mesh.module.stiffness, mesh.module.mass):
        blocks = compute(mesh.coords[mesh.elements], SECTION)
        assert np.array_equal(blocks, blocks.transpose(0, 2, 1))


@kinds
def test_rotating_the_model_leaves_eigenvalues_unchanged(kind):
    coords = warped_element(kind)
    turned = coords @ random_rotation(3).T + np.array([5.0, -2.0, 1.0])
    for compute in (KINDS[kind].stiffness, KINDS[kind].mass):
        before, after = (np.linalg.eigvalsh(compute(x, SECTION)[0]) for x in (coords, turned))
        assert after == pytest.approx(before, abs=1e-11 * before[-1])


@kinds
@pytest.mark.parametrize("reverse", [False, True])
def test_first_node_and_side_do_not_matter(kind, reverse):
    """K and M are those of the same nodes listed in another order."""
    coords = warped_element(kind)
    order = np.roll(np.arange(coords.shape[1]), 1)[:: -1 if reverse else 1]
    rows = (6 * order[:, None] + np.arange(6)).ravel()
    for compute in (KINDS[kind].stiffness, KINDS[kind].mass):
        expected = compute(coords, SECTION)[0][np.ix_(rows, rows)]
        assert compute(coords[:, order], SECTION)[0] == pytest.approx(expected, abs=1e-11 * expected.max())


@kinds
def test_mass_matrix_carries_mass_and_inertia_of_a_plate(kind):
    mesh = rectangle(4, 3, 2.0, 1.0, kind)
    mass, modes = mesh.mass(SECTION), rigid_modes(mesh.coords - np.array([1.0, 0.5, 0.0]))
    t, total = 0.005, 7.0 * 0.005 * 2.0
    got = modes.T @ (mass @ modes)
    assert np.diag(got)[:3] == pytest.approx(3 * [total], rel=1e-12)
    thin = t * t / 12
    expected = total * np.array([1 / 12 + thin, 4 / 12 + thin, 5 / 12 + (SPIN if kind == "quad" else 1.0) * thin])
    assert np.diag(got)[3:] == pytest.approx(expected, rel=1e-12)
    assert np.abs(got - np.diag(np.diag(got))).max() < 1e-12 * total


@kinds
def test_mass_matrix_of_warped_element_is_positive_definite(kind):
    mass = KINDS[kind].mass(warped_element(kind), SECTION)[0]
    assert np.linalg.eigvalsh(mass)[0] > 0


@kinds
def test_block_larger_than_a_chunk_equals_single_elements(kind):
    one = warped_element(kind)
    scale = 1.0 + 1e-4 * np.arange(CHUNK + 3)
    block = KINDS[kind].stiffness(one * scale[:, None, None], SECTION)
    for row in (0, CHUNK - 1, CHUNK, CHUNK + 2):
        alone = KINDS[kind].stiffness(one * scale[row], SECTION)[0]
        assert block[row] == pytest.approx(alone, abs=1e-12 * alone.max())


@kinds
def test_empty_block_gives_no_matrices(kind):
    n_node = {"quad": 4, "tri": 3}[kind]
    assert KINDS[kind].stiffness(np.zeros((0, n_node, 3)), SECTION).shape == (0, 6 * n_node, 6 * n_node)


@kinds
@pytest.mark.parametrize("matrix", ["stiffness", "mass"])
def test_element_without_area_is_named_by_row(kind, matrix):
    coords = np.repeat(warped_element(kind), 5, axis=0)
    coords[3, :, 1:] = 0.0
    with pytest.raises(DegenerateElement, match=r"no area \(rows 3 of the block\)") as caught:
        getattr(KINDS[kind], matrix)(coords, SECTION)
    assert caught.value.rows.tolist() == [3]
    assert isinstance(caught.value, CreakError)


@pytest.mark.parametrize(
    "last",
    [(0.3, 0.3, 0.0), (1.0, 1.0, 0.0), (0.5, 0.5, 0.0)],
    ids=["concave", "two nodes coincide", "corner on a line"],
)
def test_quad_with_impossible_corner_is_refused(last):
    good = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    bad = np.array([[0, 0, 0], [1, 0, 0], last, [0, 1, 0.0]])
    if last == (1.0, 1.0, 0.0):
        bad[3] = bad[2]
    with pytest.raises(DegenerateElement, match="corner angle") as caught:
        KINDS["quad"].stiffness(np.stack([good, bad, good, bad]), SECTION)
    assert caught.value.rows.tolist() == [1, 3]


@kinds
def test_not_a_number_in_coordinates_is_refused(kind):
    coords = warped_element(kind)
    coords[0, 1, 2] = np.nan
    with pytest.raises(DegenerateElement, match="the element has no area"):
        KINDS[kind].stiffness(coords, SECTION)
