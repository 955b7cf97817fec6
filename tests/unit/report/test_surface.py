"""The surface of the 3-D view: whole where it is small, coarser but true to the mesh where it is large."""

import numpy as np
import pytest

from creak.report.figures.surface import surface_of
from creak.report.figures.view import facets_of

NONE = np.zeros(0, dtype=np.int64)


@pytest.fixture(scope="module")
def model(result_of):
    return result_of("both runs").setup.model


def area(xyz, triangles):
    cross = np.cross(xyz[triangles[:, 1]] - xyz[triangles[:, 0]], xyz[triangles[:, 2]] - xyz[triangles[:, 0]])
    return 0.5 * float(np.linalg.norm(cross, axis=1).sum())


def test_a_small_model_is_drawn_whole(model):
    surface = surface_of(model, NONE)
    # Two strips of 4 x 2 quadrilaterals: 32 triangles; each strip has 4 * 3 + 5 * 2 = 22 edges.
    assert not surface.coarsened
    assert surface.triangles.shape == (32, 3)
    assert surface.edges.shape == (44, 2)
    assert surface.parts.tolist() == [[0, 0, 16, 0, 22], [1, 16, 16, 22, 22]]
    xyz = model.nodes.coords[surface.nodes_idx]
    assert area(xyz, surface.triangles) == pytest.approx(2 * 80.0 * 20.0)
    # The outline of a flat strip is its border, 12 edges.
    assert surface.outline.shape == (24, 2)


def test_a_large_model_is_drawn_on_few_of_its_own_nodes(model):
    surface = surface_of(model, NONE, most=20)
    assert surface.coarsened
    assert 8 <= surface.nodes_idx.size <= 20
    assert np.isin(surface.nodes_idx, facets_of(model).nodes_idx).all()
    # Parts stay apart: no triangle has corners on both strips.
    z = model.nodes.coords[surface.nodes_idx][surface.triangles][:, :, 2]
    assert (np.ptp(z, axis=1) == 0.0).all()
    assert area(model.nodes.coords[surface.nodes_idx], surface.triangles) > 0.3 * 2 * 80.0 * 20.0


def test_marked_nodes_are_kept_whatever_is_left_out(model):
    marked = np.array([3, 7, 12, 18], dtype=np.int64)
    surface = surface_of(model, marked, most=12)
    assert np.array_equal(surface.nodes_idx[surface.rows(marked)], marked)


def test_line_elements_stand_alone(result_of):
    assert surface_of(result_of("mass on a spring").setup.model, NONE) is None
