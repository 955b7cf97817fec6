"""The parts of the cockpit: flat sheets with folded edges, and where they meet.

x runs across the car to the left, y towards the occupants, z upwards. Lengths in mm. Edges lie on a raster of 20 mm
that every mesh divides, so that parts meet at nodes whatever its size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from creak_thesis.arrays import FloatArray, IntArray
from creak_thesis.door.mesh import Grid, PartMesh, divisions, glue, structured_quads

Point = tuple[float, float, float]

RASTER = 20.0
THICKNESS = {"CARRIER": 2.8, "LID": 3.0, "TRIM": 2.5, "DUCT": 2.0, "BEAM": 2.0, "HOLDER": 1.6}
WIDTH, HEIGHT, FOLD = 700.0, 320.0, 40.0
"""Of the carrier, and depth of its folds above and below."""
OPENING = (180.0, 520.0, 40.0, 220.0)
"""Of the glove box in the carrier: x from, to; z from, to. So are the others."""
LID = (160.0, 540.0, 20.0, 240.0)
TRIM = (60.0, 640.0, 260.0, 300.0)
DUCT = (160.0, 440.0, 340.0, 380.0)
BEAM = (100.0, 600.0, 340.0, 380.0)
HOLDER = (440.0, 500.0, 200.0, 220.0)
"""Card holder: a tongue inside the lid, held at its left end."""
RIM_GAP, BEAM_GAP, HOLDER_GAP = 0.8, 0.8, 0.4
"""Between the faces of lid and carrier, duct and beam, tongue and lid."""
LID_Y = RIM_GAP + 0.5 * (THICKNESS["CARRIER"] + THICKNESS["LID"])
TRIM_Y = 0.5 * (THICKNESS["CARRIER"] + THICKNESS["TRIM"])
HOLDER_Y = LID_Y - HOLDER_GAP - 0.5 * (THICKNESS["LID"] + THICKNESS["HOLDER"])
DUCT_Y = -40.0
BEAM_Y = DUCT_Y - BEAM_GAP - 0.5 * (THICKNESS["DUCT"] + THICKNESS["BEAM"])


@dataclass(frozen=True)
class Cut:
    """Elements of the mesh on one edge of the raster."""

    pieces: int

    def sheet(
        self, corner: Point, along: Point, across: Point, opening: tuple[float, float, float, float] | None = None
    ) -> Grid:
        """A flat rectangle of quads; `opening`: without those whose centres lie in it (x from, to; z from, to)."""
        n, m = (divisions(float(np.linalg.norm(edge)), RASTER) * self.pieces for edge in (along, across))
        s, t = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, m + 1))
        coords = np.array(corner) + s.ravel()[:, None] * np.array(along) + t.ravel()[:, None] * np.array(across)
        quads = structured_quads(m + 1, n + 1, closed=False, flip=False)
        if opening is not None:
            x, z = coords[quads].mean(axis=1)[:, [0, 2]].T
            quads = quads[~((x > opening[0]) & (x < opening[1]) & (z > opening[2]) & (z < opening[3]))]
        used, rows = np.unique(quads, return_inverse=True)
        return Grid(coords[used], rows.reshape(quads.shape))

    def upright(
        self, box: tuple[float, float, float, float], y: float, opening: tuple[float, float, float, float] | None = None
    ) -> Grid:
        """A sheet that faces the occupants."""
        x0, x1, z0, z1 = box
        return self.sheet((x0, y, z0), (x1 - x0, 0, 0), (0, 0, z1 - z0), opening)

    def shelf(self, box: tuple[float, float, float, float], z: float, y0: float, y1: float) -> Grid:
        """A level sheet over the same x."""
        return self.sheet((box[0], y0, z), (box[1] - box[0], 0, 0), (0, y1 - y0, 0))


def cockpit_parts(size: float) -> dict[str, PartMesh]:
    """All parts by name, with elements of about `size` mm."""
    cut, whole = Cut(divisions(RASTER, size)), (0.0, WIDTH, 0.0, HEIGHT)
    parts = {
        "CARRIER": [
            cut.upright(whole, 0.0, OPENING),
            cut.shelf(whole, HEIGHT, 0.0, -FOLD),
            cut.shelf(whole, 0.0, -FOLD, 0.0),
        ],
        "LID": [
            cut.upright(LID, LID_Y),
            cut.shelf(LID, LID[3], LID_Y, LID_Y + 20.0),
            cut.shelf(LID, LID[2], 0.0, LID_Y),
        ],
        "TRIM": [cut.upright(TRIM, TRIM_Y)],
        "DUCT": [
            cut.upright(DUCT, DUCT_Y),
            cut.shelf(DUCT, DUCT[3], DUCT_Y, 0.0),
            cut.upright(DUCT, 0.0),
        ],
        "BEAM": [cut.upright(BEAM, BEAM_Y), cut.shelf(BEAM, BEAM[2], BEAM_Y, BEAM_Y - FOLD)],
        "HOLDER": [cut.upright(HOLDER, HOLDER_Y)],
    }
    return {name: glue(name, grids) for name, grids in parts.items()}


def nearest(part: PartMesh, points: Sequence[Point]) -> IntArray:
    """Row of the node nearest to each point."""
    return np.array([np.linalg.norm(part.coords - np.array(p), axis=1).argmin() for p in points], dtype=np.int64)


def inside(part: PartMesh, low: Point, high: Point) -> IntArray:
    """Rows of the nodes in a box."""
    return np.flatnonzero(((part.coords >= np.array(low) - 1e-6) & (part.coords <= np.array(high) + 1e-6)).all(axis=1))


def quads_inside(part: PartMesh, low: Point, high: Point) -> IntArray:
    """Rows of the quads whose centres lie in a box."""
    centre: FloatArray = part.coords[part.quads].mean(axis=1)
    return np.flatnonzero(((centre >= np.array(low)) & (centre <= np.array(high))).all(axis=1))
