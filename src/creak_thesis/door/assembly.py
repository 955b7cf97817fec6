"""The whole door at one mesh size: parts, links, supports and verification pairs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

from creak import InputError
from creak_thesis.arrays import FloatArray, IntArray
from creak_thesis.door import geometry as geo
from creak_thesis.door.fasteners import Patch, link_patches, support_patches
from creak_thesis.door.frame import frame_mesh
from creak_thesis.door.geometry import Outline, loop
from creak_thesis.door.mesh import Grid, PartMesh, divisions, glue, spread, structured_quads

MESH_SIZE_RANGE = (2.0, 40.0)
"""Smallest and largest mesh size, mm: 2.03 is five million dofs; larger does not resolve the relief."""
FINEST_MESH_SIZE = 4.22
"""Mesh size (mm) at which the door has 1,169,910 dof (the benchmark: 1,169,406)."""
COARSEN = (1, 2, 3)
"""How many elements of the flange may be merged into one along the contact line."""
PAIRS = {"PAIRS": (44, *geo.CONTACT_AREA), "PAIRS15": (15, 0.0, 1.0)}
"""Sets of verification pairs: how many, from where to where along the panel's edge (fractions of its length)."""
PANEL_CORE = 120.0
"""Inset of the core of the panel from its edge, mm."""
CARRIER_CORE = 122.0
"""Inset of the core of the carrier from its edge, mm."""
LIP_ROWS = (4.0, 10.0)
"""Narrowest and widest row of elements on the panel's edge, mm."""


@dataclass(frozen=True)
class Door:
    """Everything that the deck describes."""

    mesh_size: float
    coarsen: int
    """Elements of the frame's flange merged into one along the contact line."""
    parts: tuple[PartMesh, PartMesh, PartMesh]
    """Frame, panel, carrier."""
    links: tuple[tuple[Patch, Patch], ...]
    """The two ends of every rigid link; the second follows the first."""
    supports: tuple[Patch, ...]
    """Patches A to G on the frame."""
    pairs: dict[str, tuple[IntArray, IntArray]]
    """Name -> rows on the frame's flange, rows on the panel's edge."""

    @property
    def n_nodes(self) -> int:
        """Number of nodes, reference nodes included."""
        return sum(p.coords.shape[0] for p in self.parts) + 2 * len(self.links) + len(self.supports)

    @property
    def n_dof(self) -> int:
        """Six for every node, before the couplings and supports take some away."""
        return 6 * self.n_nodes


def build_door(mesh_size: float, coarsen: int = 1) -> Door:
    """Mesh the door.

    Parameters
    ----------
    mesh_size : length of the elements' sides, mm, from 2 to 40.
    coarsen : 1, 2 or 3; so many elements of the frame's flange become one along the contact line, the rest of
        the mesh and its joints stay. What is left over at the end of a side becomes one element too. Corners
        are rounded by fewer elements: the frame loses up to 0.05 % of its area at 20 mm, 0.15 % at 40 mm.

    Raises
    ------
    InputError : the mesh size is outside that range or no number; `coarsen` is another number.
    """
    size, merge = checked_mesh_size(mesh_size), checked_coarsen(coarsen)
    frame, panel, carrier = frame_mesh(size, merge), panel_mesh(size), carrier_mesh(size)
    meshes = {m.name: m for m in (frame, panel, carrier)}
    flange, edge = frame.nodes_of("FRAME_FLANGE"), panel.nodes_of("PANEL_EDGE")
    contact = {"FRAME": flange, "PANEL": edge, "CARRIER": np.zeros(0, dtype=np.int64)}
    pairs = {name: _pairs(frame, panel, pair_points(*span)) for name, span in PAIRS.items()}
    links = link_patches(meshes, contact)
    return Door(size, merge, (frame, panel, carrier), links, support_patches(frame, flange), pairs)


def checked_mesh_size(mesh_size: float) -> float:
    """The mesh size as a float, or an error that says what is allowed."""
    low, high = MESH_SIZE_RANGE
    if math.isfinite(mesh_size) and low <= mesh_size <= high:
        return float(mesh_size)
    raise InputError(
        f"mesh size {mesh_size:g} mm cannot be meshed",
        expected=f"a number from {low:g} to {high:g}",
        where="mesh size of the door",
        fix=f"Take 20 for a first run, {FINEST_MESH_SIZE:g} for the benchmark.",
    )


def checked_coarsen(coarsen: int) -> int:
    """The number of merged elements, or an error that says what is allowed."""
    if coarsen in COARSEN:
        return int(coarsen)
    raise InputError(
        f"{coarsen} elements of the flange cannot be merged into one",
        expected="1, 2 or 3",
        where="coarsening of the door",
        fix="Take 1 for the plain mesh.",
    )


def _pairs(frame: PartMesh, panel: PartMesh, points: FloatArray) -> tuple[IntArray, IntArray]:
    """Nodes of the contact surfaces at the points: those of the panel first, then those of the frame behind them.

    Where the panel's outermost row has too few nodes, those of its next two are taken too; where the frame's flange
    has, because it is coarsened, those of the frame beside it.
    """
    secondary = nearest(panel, panel.nodes_of("PANEL_EDGE"), points)
    return nearest(frame, np.arange(frame.coords.shape[0]), panel.coords[secondary]), secondary


def pair_points(count: int, start: float, end: float) -> FloatArray:
    """Places (count, 3) along the panel's edge, equally far apart between two fractions of its length."""
    xz = geo.PANEL.walk(start + (end - start) * (np.arange(count) + 0.5) / count)
    y = geo.base(xz[:, 0], xz[:, 1]) + geo.PANEL_OFFSET
    return np.stack([geo.bow(xz[:, 0], xz[:, 1]), y, xz[:, 1]], axis=1)


def nearest(mesh: PartMesh, rows: IntArray, points: FloatArray) -> IntArray:
    """The row among `rows` whose node is nearest to each point; no row twice."""
    return rows[linear_sum_assignment(cdist(points, mesh.coords[rows]))[1]]


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
