"""The cockpit as the text of an Abaqus deck (mm, t, s)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from creak_thesis.arrays import IntArray
from creak_thesis.cockpit import geometry as geo
from creak_thesis.cockpit.geometry import Point
from creak_thesis.door.mesh import PartMesh

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
TOP = geo.LID[3]
MIDDLE = 0.5 * (geo.LID[0] + geo.LID[1]) + 10.0
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
        for side, x in (("RIGHT", geo.LID[0] + 20.0), ("LEFT", geo.LID[1] - 20.0))
        for part, y in (("CARRIER", 0.0), ("LID", geo.LID_Y))
    },
    "LID_RIM": ("LID", tuple((x, geo.LID_Y, TOP) for x in RIM_X)),
    "LATCH_CARRIER": ("CARRIER", ((MIDDLE, 0.0, TOP),)),
    "LATCH_LID": ("LID", ((MIDDLE, geo.LID_Y, TOP),)),
    "TRIM_RIB": ("TRIM", tuple((x, geo.TRIM_Y, 0.5 * (geo.TRIM[2] + geo.TRIM[3])) for x in RUBS_X)),
    "DUCT_PAD": ("DUCT", ((300.0, geo.DUCT_Y, geo.DUCT[2]),)),
    "BEAM_PAD": ("BEAM", ((300.0, geo.BEAM_Y, geo.DUCT[2]),)),
    "HOLDER_LID": ("LID", ((geo.HOLDER[0], geo.LID_Y, 0.5 * (geo.HOLDER[2] + geo.HOLDER[3])),)),
    "HOLDER_TIP": ("HOLDER", ((geo.HOLDER[0], geo.HOLDER_Y, 0.5 * (geo.HOLDER[2] + geo.HOLDER[3])),)),
}
"""Node set -> its part and points."""


def deck_text(size: float) -> str:
    """The whole deck, with elements of about `size` mm."""
    parts = geo.cockpit_parts(size)
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
    return FIRST[part] + int(geo.nearest(parts[part], [point])[0])


def _held(parts: Parts) -> Iterator[str]:
    """Mounts at the corners of the carrier's folds and at the ends of the beam, which the study shakes."""
    ends = [geo.inside(parts["CARRIER"], (x, -geo.FOLD, 0), (x + 40, -geo.FOLD, geo.HEIGHT)) for x in (0, 660)]
    beam = [geo.inside(parts["BEAM"], (x, -200, 0), (x, 0, 400)) for x in geo.BEAM[:2]]
    mounts = [*(FIRST["CARRIER"] + r for r in ends), *(FIRST["BEAM"] + r for r in beam)]
    yield from _set("NSET", "MOUNTS", np.concatenate(mounts))
    yield "** The study shakes y and z of the mounts."
    yield "*BOUNDARY"
    yield "MOUNTS, 1, 1"
    yield "MOUNTS, 4, 6"


def _joints(parts: Parts) -> Iterator[str]:
    """Hinges and seal of the lid, root of the card holder, screws and clips of the trim, brackets of the duct."""
    low, (c, d) = geo.LID[2], geo.TRIM[2:]
    yield from _tied(parts, "LID", "CARRIER", [(x, 0, low) for x in HINGES_X], (1, 2, 3))
    yield from _tied(parts, "TRIM", "CARRIER", [(x, geo.TRIM_Y, 0.5 * (c + d)) for x in CLIPS_X], (2,))
    root = [(geo.HOLDER[1], z) for z in geo.HOLDER[2:]]
    links = [
        *(("HOLDER", (x, geo.HOLDER_Y, z), "LID", (x, geo.LID_Y, z)) for x, z in root),
        *(("TRIM", (x, geo.TRIM_Y, z), "CARRIER", (x, 0.0, z)) for x in SCREWS_X for z in (c, d)),
        *(("DUCT", (x, 0.0, geo.DUCT[2]), "CARRIER", (x, 0.0, geo.HEIGHT)) for x in BRACKETS_X),
    ]
    yield "*MPC"
    for part, point, leader, at in links:
        yield f"BEAM, {_label(parts, part, point)}, {_label(parts, leader, at)}"
    yield "*ELEMENT, TYPE=SPRING2, ELSET=SEAL"
    for i, x in enumerate(SEAL_X):
        ends = _label(parts, "CARRIER", (x, 0.0, TOP)), _label(parts, "LID", (x, geo.LID_Y, TOP))
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
        labels = FIRST[part] + geo.nearest(parts[part], points)
        yield from _set("NSET", name, labels)
    far = 1e3
    yield from _surface(parts, "CARRIER_FACE", "CARRIER", (0, -1, 0), (far, 1, geo.HEIGHT), towards=1)
    yield from _surface(parts, "BEAM_FACE", "BEAM", (0, geo.BEAM_Y - 1, 0), (far, far, far), towards=1)
    yield from _surface(parts, "LID_BACK", "LID", (0, geo.LID_Y - 1, 0), (far, geo.LID_Y + 1, far), towards=-1)


def _surface(parts: Parts, name: str, part: str, low: Point, high: Point, towards: int) -> Iterator[str]:
    """The upright quads in a box, on the side that looks along y times `towards`."""
    rows = geo.quads_inside(parts[part], low, high)
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
    for part, thickness in geo.THICKNESS.items():
        yield f"*SHELL SECTION, ELSET={part}, MATERIAL={MADE_OF[part]}"
        yield f"{thickness:g}"
