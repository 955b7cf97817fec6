"""Rounded outlines: length, offset and continuity in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from creak_thesis.door.geometry import Outline

SQUARE = Outline(np.array([[0.0, 0.0], [100.0, 0.0], [100.0, 100.0], [0.0, 100.0]]), (20.0, 20.0, 20.0, 20.0))


def test_length_of_a_rounded_square() -> None:
    total = sum(SQUARE.length(k) for k in range(4))
    assert total == pytest.approx(4 * 60 + 2 * np.pi * 20)


@pytest.mark.parametrize("distance", [-7.0, 5.0])
def test_offset_changes_the_length_by_a_full_turn(distance: float) -> None:
    inner = SQUARE.offset(distance)
    change = sum(inner.length(k) - SQUARE.length(k) for k in range(4))
    assert change == pytest.approx(-2 * np.pi * distance)


def test_points_are_equally_far_apart_on_line_and_arc() -> None:
    points = SQUARE.walk(np.linspace(0.0, 1.0, 4001))
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    # A chord of an arc is shorter than the arc by (step / radius)^2 / 24.
    np.testing.assert_allclose(steps, steps.max(), rtol=1e-5)
    np.testing.assert_allclose(points[0], points[-1], atol=1e-9)


def test_arc_keeps_its_distance_from_the_centre() -> None:
    points = SQUARE.point(0, np.linspace(0.0, 0.1, 5))
    np.testing.assert_allclose(np.linalg.norm(points - [20.0, 20.0], axis=1), 20.0, rtol=1e-12)


def test_sharp_corners_stay_sharp() -> None:
    sharp = Outline(SQUARE.corners, (0.0,) * 4)
    np.testing.assert_allclose(sharp.offset(10.0).corners, [[10, 10], [90, 10], [90, 90], [10, 90]])
    np.testing.assert_allclose(sharp.point(1, np.array([0.0, 1.0])), [[100, 0], [100, 100]])
