"""Volumes of elements, from their nodes and section."""

from __future__ import annotations

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.model.materials import BeamSection, GeneralShell, Section, ShellSection, TrussSection
from creak.model.shell_facets import N_CORNER, SHELL_FACETS, facet_areas, facets_of_shells
from creak.model.solid_faces import FACES, faces_of, volumes

LINES = {"beam2": 2, "truss2": 2, "beam3": 3}
"""Nodes along the element."""


def element_volumes(
    kind: str, nodes_idx: IntArray, coords: FloatArray, section: Section, thickness: FloatArray | None = None
) -> FloatArray:
    """(n,) volumes of structural elements, length^3: of shells area times thickness, of beams length times area.

    Elements without a volume of their own, as springs and layers of glue, have 0.

    Parameters
    ----------
    nodes_idx : (n, n_node) rows into coords. coords : (n_node, 3), length.
    section : of all of them.
    thickness : (n, n_node) of shells over that of the section, whose mean at the corners counts; None: as the section.
    """
    if kind in FACES:
        return np.abs(volumes(coords[faces_of(kind, nodes_idx)]))
    if kind in SHELL_FACETS and isinstance(section, ShellSection | GeneralShell):
        areas = facet_areas(coords[facets_of_shells(kind, nodes_idx)]).sum(axis=1)
        return section.thickness * areas * (1.0 if thickness is None else thickness[:, : N_CORNER[kind]].mean(axis=1))
    if kind in LINES and isinstance(section, BeamSection | TrussSection):
        pieces = np.diff(coords[nodes_idx[:, : LINES[kind]]], axis=1)
        return np.asarray(section.area * np.linalg.norm(pieces, axis=2).sum(axis=1), dtype=np.float64)
    return np.zeros(nodes_idx.shape[0])
