"""Which main facet lies opposite a point: tree search and projection onto bilinear facets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.contact.facets import Facets
from creak.model.projection import meet_facets

CANDIDATES = 16
"""Facets tried per point: those with the nearest centroids."""


@dataclass(frozen=True)
class Projection:
    """Where points meet the main surface; rows with `found` False have no partner."""

    found: BoolArray
    facet: IntArray
    shape: FloatArray
    """(n, 4) shape functions of the facet's nodes at the meeting point."""
    distance: FloatArray
    """(n,) signed, along `direction` from the point to the facet."""
    direction: FloatArray
    """(n, 3) unit vectors."""


def project_along(points: FloatArray, directions: FloatArray, main: Facets, limit: float) -> Projection:
    """Meet the main facets along given directions (both ways), nearest first."""
    return _best(points, main, limit, directions)


def project_closest(points: FloatArray, main: Facets, limit: float) -> Projection:
    """Meet the main facets along their own normals."""
    return _best(points, main, limit, None)


def _best(points: FloatArray, main: Facets, limit: float, directions: FloatArray | None) -> Projection:
    n, k = points.shape[0], min(CANDIDATES, main.count)
    _, near = cKDTree(main.coords.mean(axis=1)).query(points, k=k)
    near = near.reshape(n, k)
    best = Projection(
        np.zeros(n, dtype=bool), np.zeros(n, dtype=np.int64), np.zeros((n, 4)), np.full(n, np.inf), np.zeros((n, 3))
    )
    for column in range(k):
        facet = near[:, column]
        shape, distance, normal, inside = meet_facets(points, main.coords[facet], main.is_triangle[facet], directions)
        better = inside & (np.abs(distance) < np.abs(best.distance)) & (np.abs(distance) <= limit)
        best.found[better] = True
        best.facet[better] = facet[better]
        best.shape[better] = shape[better]
        best.distance[better] = distance[better]
        best.direction[better] = normal[better]
    return best
