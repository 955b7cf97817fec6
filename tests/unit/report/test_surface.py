"""The surface of the 3-D view: whole where it is small, coarser but true to the mesh where it is large.

Pictures are PNGs that show the model from the side that matters.
"""

import io

import numpy as np
import pytest
from matplotlib.image import imread

from creak.report.figures.picture import Loaded, contact_picture, model_picture, standard_marks
from creak.report.figures.view import cut_up, facets_of, front, surface_of, three_quarter

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


NO_SIDE = np.zeros(3)


def test_model_picture_is_a_png_with_the_colour_of_the_marks(result_of):
    model = result_of("both runs").setup.model
    nodes = np.array([3], dtype=np.int64)
    png = model_picture(model, standard_marks(nodes, nodes[:0], nodes[:0], nodes[:0]), NO_SIDE)
    assert png is not None
    assert png.startswith(b"\x89PNG")
    pixels = imread(io.BytesIO(png))[:, :, :3]
    red = (pixels[:, :, 0] > 0.7) & (pixels[:, :, 1] < 0.2)
    assert red.any()
    assert not np.allclose(pixels, 1.0)


def test_contact_picture_is_a_png(result_of):
    model = result_of("both runs").setup.model
    png = contact_picture(model, Loaded(np.array([3, 4]), np.array([0.0, 2.5]), "impulse, N s", "N s"), NO_SIDE)
    assert png is not None
    assert png.startswith(b"\x89PNG")


def test_a_model_without_extent_has_no_picture(result_of):
    model = result_of("mass on a spring").setup.model
    assert model_picture(model, [], NO_SIDE) is None


def test_facets_know_their_parts(result_of):
    facets = facets_of(result_of("both runs").setup.model)
    assert facets.count == 16
    assert np.bincount(facets.part).tolist() == [8, 8]


def test_views_are_right_handed_and_look_at_the_outward_side():
    coords = np.array([[0.0, 0.0, 0.0], [100.0, 5.0, 80.0]])
    for outward, toward in ((np.array([0.0, 1.0, 0.0]), 1.0), (np.array([0.0, -1.0, 0.0]), -1.0)):
        view = front(coords, outward)
        np.testing.assert_array_equal(view.matrix[:, 2], [0.0, toward, 0.0])
        np.testing.assert_array_equal(view.matrix[:, 1], [0.0, 0.0, 1.0])
        for v in (view, three_quarter(view)):
            np.testing.assert_allclose(v.matrix.T @ v.matrix, np.eye(3), atol=1e-15)
            np.testing.assert_allclose(np.linalg.det(v.matrix), 1.0, rtol=1e-14)


@pytest.mark.parametrize(("size", "up"), [((200.0, 150.0, 90.0), 2), ((200.0, 150.0, 20.0), 1), ((0.0, 0.0, 9.0), 2)])
def test_z_is_up_but_on_what_lies_flat(size, up):
    view = front(np.array([np.zeros(3), size]), np.zeros(3))
    np.testing.assert_array_equal(view.matrix[:, 1], np.eye(3)[up])


def test_pieces_of_a_facet_cover_it_exactly():
    corners = np.array([[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]]])
    inner, edges = cut_up(corners, 3)
    assert inner.shape == (9, 4, 3)
    assert edges.shape == (12, 4, 3)
    diagonals = inner[:, 2] - inner[:, 0], inner[:, 3] - inner[:, 1]
    area = 0.5 * np.abs(np.cross(*diagonals)[:, 2]).sum()
    np.testing.assert_allclose(area, 2.0, rtol=1e-14)
