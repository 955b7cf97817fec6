"""Where the parts are joined and held, and the patches of nodes that take the load."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from creak_thesis.arrays import BoolArray, FloatArray, IntArray
from creak_thesis.door import geometry as geo
from creak_thesis.door.mesh import PartMesh

PATCH_RADIUS = 12.0
"""Radius of the patch that a hook or a screw grips, mm."""
MOUNT_RADIUS = 20.0
"""Radius of the patch of a support, mm."""
LEG = 45.0
"""Half the distance of the two links of a double hook, mm."""
N_SCREWS = 13


@dataclass(frozen=True)
class Fastener:
    """A hook or a screw between two parts: one rigid link at each point."""

    name: str
    first: str
    """Part whose reference node leads."""
    second: str
    """Part whose reference node follows."""
    points: FloatArray
    """(n_link, 2) places (x, z) in the template, mm."""


@dataclass(frozen=True)
class Support:
    """A point where the frame is bolted to the car body."""

    name: str
    fixed: tuple[int, ...]
    """Dofs 1..6 held at zero."""
    side: int
    """Side of `geometry.PERIMETER`."""
    fraction: float
    """Place along that side."""


@dataclass(frozen=True)
class Patch:
    """A reference node and the nodes of one part that follow it."""

    name: str
    part: str
    ref: FloatArray
    """(3,) place of the reference node."""
    rows: IntArray
    """Rows of the part's nodes, sorted."""


SUPPORTS = (
    Support("A", (2,), 3, 0.5),
    Support("B", (1, 2, 3, 4, 5, 6), 5, 0.72),
    Support("C", (2, 6), 1, 0.66),
    Support("D", (2, 6), 1, 0.48),
    Support("E", (2,), 0, 0.5),
    Support("F", (2,), 5, 0.24),
    Support("G", (2,), 2, 0.3),
)
"""A header, B lower hinge, C and D latch, E bottom, F upper hinge (its z is driven), G rear post."""

SUPPORT_PLACE = (17.5, 73.0)
"""(outwards, depth) of the supports on the outer return, mm: the middle of its deep wall."""


def fasteners() -> tuple[Fastener, ...]:
    """The 22 fasteners: 2 + 1 between panel and frame, 6 between panel and carrier, 13 screws.

    Four wide hooks (both hooks to the frame, the two upper outer hooks to the carrier) grip with two
    links each, so there are 26 rigid links.
    """
    legs = np.array([[-LEG, 0.0], [LEG, 0.0]])
    upright = np.array([[0.0, -LEG], [0.0, LEG]])
    to_frame = [
        Fastener("HOOK_FRONT", "PANEL", "FRAME", np.array([118.0, 500.0]) + upright),
        Fastener("HOOK_REAR", "PANEL", "FRAME", np.array([1048.0, 500.0]) + upright),
        Fastener("SCREW_PANEL", "PANEL", "FRAME", np.array([[590.0, 104.0]])),
    ]
    places = [(420.0, 450.0), (595.0, 450.0), (770.0, 455.0), (400.0, 310.0), (595.0, 310.0), (790.0, 310.0)]
    clips = [
        Fastener(f"HOOK_{k}", "PANEL", "CARRIER", np.array(p) + (legs if k in (1, 3) else 0 * legs[:1]))
        for k, p in enumerate(places, start=1)
    ]
    ring = geo.SCREW_LINE.walk((np.arange(N_SCREWS) + 0.5) / N_SCREWS)
    screws = [Fastener(f"SCREW_{k}", "CARRIER", "FRAME", p[None, :]) for k, p in enumerate(ring, start=1)]
    return (*to_frame, *clips, *screws)


def support_point(support: Support) -> FloatArray:
    """Place (3,) of a support on the outer return."""
    out, deep = SUPPORT_PLACE
    at = np.array([support.fraction])
    top = geo.PERIMETER.point(support.side, at)
    x, z = geo.PERIMETER.offset(-out).point(support.side, at)[0]
    y = float(geo.base(top[:, 0], top[:, 1])[0]) - deep
    return np.array([float(geo.bow(x, z)), y, z])


def face_point(mesh: PartMesh, place: FloatArray, free: BoolArray) -> FloatArray:
    """Point (3,) of a part's face at a place (x, z) of the template; y is that of the nearest quad."""
    x, z = float(geo.bow(place[0], place[1])), float(place[1])
    distance = np.where(free, (mesh.centres[:, 0] - x) ** 2 + (mesh.centres[:, 2] - z) ** 2, np.inf)
    return np.array([x, mesh.centres[int(np.argmin(distance)), 1], z])


def free_quads(mesh: PartMesh, contact: IntArray) -> BoolArray:
    """Quads (m,) with no node in the contact."""
    touches = np.isin(mesh.quads, contact)
    return ~np.asarray(touches.any(axis=1), dtype=bool)


def grip(name: str, mesh: PartMesh, point: FloatArray, radius: float, contact: IntArray, free: BoolArray) -> Patch:
    """Patch around a point: the nodes within `radius` and those of the nearest free quad, none in contact."""
    nearest = int(np.argmin(np.where(free, np.linalg.norm(mesh.centres - point, axis=1), np.inf)))
    near = np.flatnonzero(np.linalg.norm(mesh.coords - point, axis=1) <= radius)
    rows = np.union1d(np.setdiff1d(near, contact), mesh.quads[nearest])
    return Patch(name, mesh.name, point, rows.astype(np.int64))


def link_patches(meshes: Mapping[str, PartMesh], contact: Mapping[str, IntArray]) -> tuple[tuple[Patch, Patch], ...]:
    """The two patches of every rigid link, fastener by fastener."""
    free = {name: free_quads(mesh, contact[name]) for name, mesh in meshes.items()}
    links = []
    for fastener in fasteners():
        for k, place in enumerate(fastener.points):
            suffix = f"_{k + 1}" if len(fastener.points) > 1 else ""
            pair = [
                grip(
                    f"{fastener.name}{suffix}_{part}",
                    meshes[part],
                    face_point(meshes[part], place, free[part]),
                    PATCH_RADIUS,
                    contact[part],
                    free[part],
                )
                for part in (fastener.first, fastener.second)
            ]
            links.append((pair[0], pair[1]))
    return tuple(links)


def support_patches(frame: PartMesh, contact: IntArray) -> tuple[Patch, ...]:
    """The patch of every support, in the order of `SUPPORTS`."""
    free = free_quads(frame, contact)
    return tuple(grip(s.name, frame, support_point(s), MOUNT_RADIUS, contact, free) for s in SUPPORTS)
