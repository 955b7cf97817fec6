"""Pictures are PNGs that show the model from the side that matters."""

import io

import numpy as np
import pytest
from matplotlib.image import imread

from creak.report.figures.picture import Loaded, contact_picture, model_picture, standard_marks
from creak.report.figures.view import cut_up, facets_of, front, three_quarter

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
