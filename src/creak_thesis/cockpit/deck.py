"""The cockpit as the text of an Abaqus deck (mm, t, s): flat sheets with folded edges, and where they meet.

x runs across the car to the left, y towards the occupants, z upwards. Lengths in mm. Edges lie on a raster of 20 mm
that every mesh divides, so that parts meet at nodes whatever its size.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
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


Parts = Mapping[str, PartMesh]

FIRST = {"CARRIER": 1, "LID": 100_001, "TRIM": 200_001, "DUCT": 300_001, "BEAM": 400_001, "HOLDER": 500_001}
"""First node and element label of every part."""
MATERIALS = {
    "PP_TALC": (2400.0, 0.38, 1.05e-9),
    "ABS": (2300.0, 0.37, 1.05e-9),
    "STEEL": (210_000.0, 0.3, 7.85e-9),
}
"""Young's modulus, MPa; Poisson's ratio; density, t/mm^3."""
MADE_OF = {"CARRIER": "PP_TALC", "LID": "ABS", "TRIM": "ABS", "DUCT": "PP_TALC", "BEAM": "STEEL", "HOLDER": "ABS"}
SEAL, SEAL_LABEL = 1.0, 900_001
"""Stiffness of the seal under the lid's rim, N/mm, at each of its points, and their first label."""
TOP = LID[3]
MIDDLE = 0.5 * (LID[0] + LID[1]) + 10.0
"""x of the latch, on the raster."""
HINGES_X = (220.0, 480.0)
SEAL_X = (220.0, MIDDLE, 480.0)
RIM_X = (260.0, 340.0, 420.0)
SCREWS_X, CLIPS_X, RUBS_X = (60.0, 240.0), (340.0, 440.0, 540.0, 640.0), (600.0,)
"""Of the trim: screws, clips that hold it in y alone, and the rib behind it that rubs."""
BRACKETS_X = (180.0, 200.0, 400.0, 420.0)
"""Rigid brackets of the duct on the carrier: two nodes each."""
POINTS: Mapping[str, tuple[str, tuple[Point, ...]]] = {
    **{
        f"BUMPER_{side}_{part}": (part, ((x, y, TOP),))
        for side, x in (("RIGHT", LID[0] + 20.0), ("LEFT", LID[1] - 20.0))
        for part, y in (("CARRIER", 0.0), ("LID", LID_Y))
    },
    "LID_RIM": ("LID", tuple((x, LID_Y, TOP) for x in RIM_X)),
    "LATCH_CARRIER": ("CARRIER", ((MIDDLE, 0.0, TOP),)),
    "LATCH_LID": ("LID", ((MIDDLE, LID_Y, TOP),)),
    "TRIM_RIB": ("TRIM", tuple((x, TRIM_Y, 0.5 * (TRIM[2] + TRIM[3])) for x in RUBS_X)),
    "DUCT_PAD": ("DUCT", ((300.0, DUCT_Y, DUCT[2]),)),
    "BEAM_PAD": ("BEAM", ((300.0, BEAM_Y, DUCT[2]),)),
    "HOLDER_LID": ("LID", ((HOLDER[0], LID_Y, 0.5 * (HOLDER[2] + HOLDER[3])),)),
    "HOLDER_TIP": ("HOLDER", ((HOLDER[0], HOLDER_Y, 0.5 * (HOLDER[2] + HOLDER[3])),)),
}
"""Node set -> its part and points."""


def deck_text(size: float) -> str:
    """The whole deck, with elements of about `size` mm."""
    parts = cockpit_parts(size)
    count = sum(p.coords.shape[0] for p in parts.values())
    lines = ["*HEADING", f"Piece of a cockpit; {count} nodes; units mm, t, s"]
    lines.append("** Written by creak example cockpit.")
    lines.append("** x across the car to the left, y towards the occupants, z upwards.")
    for name, part in parts.items():
        lines += _part(name, part)
    lines += [*_held(parts), *_joints(parts), *_contact(parts), *_materials()]
    return "\n".join(lines) + "\n"


def _part(name: str, part: PartMesh) -> Iterator[str]:
    first = FIRST[name]
    yield f"*NODE, NSET={name}_NODES"
    yield from (f"{first + i}, {x:.6f}, {y:.6f}, {z:.6f}" for i, (x, y, z) in enumerate(part.coords.tolist()))
    yield f"*ELEMENT, TYPE=S4, ELSET={name}"
    yield from (f"{first + i}, {', '.join(map(str, (first + q).tolist()))}" for i, q in enumerate(part.quads))


def _set(kind: str, name: str, labels: IntArray) -> Iterator[str]:
    yield f"*{kind}, {kind}={name}"
    for start in range(0, labels.size, 12):
        yield ", ".join(map(str, labels[start : start + 12].tolist()))


def _label(parts: Parts, part: str, point: Point) -> int:
    return FIRST[part] + int(nearest(parts[part], [point])[0])


def _held(parts: Parts) -> Iterator[str]:
    """Mounts at the corners of the carrier's folds and at the ends of the beam, which the study shakes."""
    ends = [inside(parts["CARRIER"], (x, -FOLD, 0), (x + 40, -FOLD, HEIGHT)) for x in (0, 660)]
    beam = [inside(parts["BEAM"], (x, -200, 0), (x, 0, 400)) for x in BEAM[:2]]
    mounts = [*(FIRST["CARRIER"] + r for r in ends), *(FIRST["BEAM"] + r for r in beam)]
    yield from _set("NSET", "MOUNTS", np.concatenate(mounts))
    yield "** The study shakes y and z of the mounts."
    yield "*BOUNDARY"
    yield "MOUNTS, 1, 1"
    yield "MOUNTS, 4, 6"


def _joints(parts: Parts) -> Iterator[str]:
    """Hinges and seal of the lid, root of the card holder, screws and clips of the trim, brackets of the duct."""
    low, (c, d) = LID[2], TRIM[2:]
    yield from _tied(parts, "LID", "CARRIER", [(x, 0, low) for x in HINGES_X], (1, 2, 3))
    yield from _tied(parts, "TRIM", "CARRIER", [(x, TRIM_Y, 0.5 * (c + d)) for x in CLIPS_X], (2,))
    root = [(HOLDER[1], z) for z in HOLDER[2:]]
    links = [
        *(("HOLDER", (x, HOLDER_Y, z), "LID", (x, LID_Y, z)) for x, z in root),
        *(("TRIM", (x, TRIM_Y, z), "CARRIER", (x, 0.0, z)) for x in SCREWS_X for z in (c, d)),
        *(("DUCT", (x, 0.0, DUCT[2]), "CARRIER", (x, 0.0, HEIGHT)) for x in BRACKETS_X),
    ]
    yield "*MPC"
    for part, point, leader, at in links:
        yield f"BEAM, {_label(parts, part, point)}, {_label(parts, leader, at)}"
    yield "*ELEMENT, TYPE=SPRING2, ELSET=SEAL"
    for i, x in enumerate(SEAL_X):
        ends = _label(parts, "CARRIER", (x, 0.0, TOP)), _label(parts, "LID", (x, LID_Y, TOP))
        yield f"{SEAL_LABEL + i}, {ends[0]}, {ends[1]}"
    yield "*SPRING, ELSET=SEAL"
    yield "2, 2"
    yield f"{SEAL:g}"


def _tied(parts: Parts, one: str, other: str, points: Sequence[Point], dofs: Sequence[int]) -> Iterator[str]:
    """Equal motion of nodes that lie at one place, but for y."""
    for x, y, z in points:
        pair = _label(parts, one, (x, y, z)), _label(parts, other, (x, 0.0, z))
        for dof in dofs:
            yield "*EQUATION"
            yield "2"
            yield f"{pair[0]}, {dof}, 1., {pair[1]}, {dof}, -1."


def _contact(parts: Parts) -> Iterator[str]:
    """Surfaces and points of the places."""
    for name, (part, points) in POINTS.items():
        labels = FIRST[part] + nearest(parts[part], points)
        yield from _set("NSET", name, labels)
    far = 1e3
    yield from _surface(parts, "CARRIER_FACE", "CARRIER", (0, -1, 0), (far, 1, HEIGHT), towards=1)
    yield from _surface(parts, "BEAM_FACE", "BEAM", (0, BEAM_Y - 1, 0), (far, far, far), towards=1)
    yield from _surface(parts, "LID_BACK", "LID", (0, LID_Y - 1, 0), (far, LID_Y + 1, far), towards=-1)


def _surface(parts: Parts, name: str, part: str, low: Point, high: Point, towards: int) -> Iterator[str]:
    """The upright quads in a box, on the side that looks along y times `towards`."""
    rows = quads_inside(parts[part], low, high)
    corners = parts[part].coords[parts[part].quads[rows[0]]]
    faces = float(np.cross(corners[2] - corners[0], corners[3] - corners[1])[1])
    yield from _set("ELSET", f"{name}_ELEMENTS", FIRST[part] + rows)
    yield f"*SURFACE, TYPE=ELEMENT, NAME={name}"
    yield f"{name}_ELEMENTS, {'SPOS' if faces * towards > 0 else 'SNEG'}"


def _materials() -> Iterator[str]:
    for name, (young, poisson, density) in MATERIALS.items():
        yield f"*MATERIAL, NAME={name}"
        yield "*ELASTIC"
        yield f"{young:g}, {poisson:g}"
        yield "*DENSITY"
        yield f"{density:g}"
    for part, thickness in THICKNESS.items():
        yield f"*SHELL SECTION, ELSET={part}, MATERIAL={MADE_OF[part]}"
        yield f"{thickness:g}"
