"""Meshes of the two plastic parts: a band around the edge and a rectangular core inside it."""

from __future__ import annotations

import numpy as np

from creak_thesis.arrays import FloatArray
from creak_thesis.door import geometry as geo
from creak_thesis.door.mesh import Grid, PartMesh, divisions, glue, spread, structured_quads
from creak_thesis.door.outline import Outline, loop

PANEL_CORE = 120.0
"""Inset of the core of the panel from its edge, mm."""
CARRIER_CORE = 122.0
"""Inset of the core of the carrier from its edge, mm."""
LIP_ROWS = (4.0, 10.0)
"""Narrowest and widest row of elements on the panel's edge, mm."""


def panel_mesh(mesh_size: float) -> PartMesh:
    """Mesh the panel; its normals point at the frame (-y). PANEL_EDGE is its two outermost rows."""
    row = float(np.clip(mesh_size, *LIP_ROWS))
    stops, counts = [0.0, 2 * row], [2]
    if 2 * row < geo.LIP_WIDTH:
        stops, counts = [*stops, geo.LIP_WIDTH], [2, divisions(geo.LIP_WIDTH - 2 * row, mesh_size)]
    stops += [64.0, PANEL_CORE]
    counts += [divisions(70.0, mesh_size), divisions(PANEL_CORE - 64.0, mesh_size)]
    ring, core, inset = _band_and_core(geo.PANEL, spread(stops, counts), mesh_size)
    rise = geo.panel_rise(inset)[:, None]
    n = ring.shape[1]
    band = geo.lift(ring, geo.PANEL_OFFSET + geo.panel_height(ring[..., 0], ring[..., 1], rise))
    middle = geo.lift(core, geo.PANEL_OFFSET + geo.panel_height(core[..., 0], core[..., 1], np.array(1.0)))
    quads = structured_quads(inset.size, n, closed=True, flip=False)
    tag = np.arange(quads.shape[0]) < 2 * n
    edge = Grid(band, quads, tags={"PANEL_EDGE": tag}, nodes={"EDGE_LINE": np.arange(n)})
    return glue("PANEL", [edge, Grid(middle, structured_quads(*core.shape[:2], closed=False, flip=False))])


def carrier_mesh(mesh_size: float) -> PartMesh:
    """Mesh the carrier; its normals point into the cabin (+y)."""
    counts = [divisions(48.0, mesh_size), divisions(CARRIER_CORE - 48.0, mesh_size)]
    ring, core, inset = _band_and_core(geo.CARRIER, spread([0.0, 48.0, CARRIER_CORE], counts), mesh_size)
    rim = -geo.SEAT_DEPTH - geo.CARRIER_GAP
    band = geo.lift(ring, rim + geo.carrier_height(ring[..., 0], ring[..., 1], inset[:, None]))
    middle = geo.lift(core, rim + geo.carrier_height(core[..., 0], core[..., 1], np.array(CARRIER_CORE)))
    quads = structured_quads(inset.size, ring.shape[1], closed=True, flip=True)
    inner = structured_quads(*core.shape[:2], closed=False, flip=True)
    return glue("CARRIER", [Grid(band, quads), Grid(middle, inner)])


def _band_and_core(outline: Outline, insets: FloatArray, mesh_size: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points of the band (rows, around, 2) and of the core (n_z, n_x, 2), and the inset of each row."""
    n_x = divisions((outline.length(0) + outline.length(2)) / 2, mesh_size)
    n_z = divisions((outline.length(1) + outline.length(3)) / 2, mesh_size)
    u, v = np.linspace(0.0, 1.0, n_x + 1), np.linspace(0.0, 1.0, n_z + 1)
    inner = Outline(outline.offset(float(insets[-1])).corners, (0.0,) * 4)
    rings = [loop(outline.offset(float(d)), [u, v, u, v]) for d in insets[:-1]]
    ring = np.array([*rings, loop(inner, [u, v, u, v])])
    c = inner.corners
    s, t = u[None, :, None], v[:, None, None]
    core = (1 - t) * ((1 - s) * c[0] + s * c[1]) + t * ((1 - s) * c[3] + s * c[2])
    return ring, core, insets
