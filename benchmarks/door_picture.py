"""The picture of the door in docs/door.md: `python -m benchmarks.door_picture [--out FILE]`."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from creak.arrays import FloatArray
from creak_thesis.door import Door, build_door
from creak_thesis.door import geometry as geo
from creak_thesis.door.mesh import PartMesh

COLORS = {"FRAME": "#a9b4be", "PANEL": "#c9a77c", "CARRIER": "#7d9471"}
FLANGE, EDGE, TOUCH = "#2f6fb5", "#f0821e", "#d1152b"
PULLED_APART = {"FRAME": 0.0, "CARRIER": 620.0, "PANEL": 1300.0}
"""Distance in y between the parts of the exploded view, mm."""
LIGHT = np.array([-0.35, 0.8, 0.5])


def main() -> None:
    """Draw the door."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.door_picture")
    options.add_argument("--out", type=Path, default=Path("docs/door.png"))
    given = options.parse_args()
    door = build_door(12.0)
    figure = Figure(figsize=(13.0, 5.6), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, width_ratios=[1.75, 1.0])
    exploded(left, door)
    cabin_side(right, door)
    figure.savefig(given.out, dpi=110)


def exploded(axes: Axes, door: Door) -> None:
    """The three parts pulled apart along y, seen from the cabin."""
    camera = view(azimuth=52.0, elevation=14.0)
    for part in sorted(door.parts, key=lambda p: PULLED_APART[p.name]):
        shift = np.array([0.0, PULLED_APART[part.name], 0.0])
        draw(axes, part, camera, shift)
        top = (part.coords + shift) @ camera.T
        axes.text(top[:, 0].mean(), top[:, 1].min() - 45.0, part.name.lower(), ha="center", va="top", fontsize=11)
    finish(axes)


def cabin_side(axes: Axes, door: Door) -> None:
    """The door put together, with its links, supports and contact area."""
    camera = view(azimuth=0.0, elevation=0.0)
    for part in sorted(door.parts, key=lambda p: PULLED_APART[p.name]):
        draw(axes, part, camera, np.zeros(3))
    area = geo.PANEL.walk(np.linspace(*geo.CONTACT_AREA, 60))
    axes.plot(-geo.bow(area[:, 0], area[:, 1]), area[:, 1], color=TOUCH, lw=5.0, solid_capstyle="butt", zorder=6)
    for leader, follower in door.links:
        to_frame = (leader.part, follower.part) == ("PANEL", "FRAME")
        style = {"marker": "o", "ms": 7.0, "mfc": "k"} if to_frame else {"marker": "o", "ms": 5.0, "mfc": "w"}
        axes.plot(-leader.ref[0], leader.ref[2], mec="k", ls="none", zorder=7, **style)
    for support in door.supports:
        axes.plot(-support.ref[0], support.ref[2], marker="^", ms=8.0, mfc="k", mec="w", ls="none", zorder=7)
        place = support.ref[[0, 2]] * np.array([-1.0, 1.0])
        away = place - np.array([-590.0, 560.0])
        x, z = place + 42.0 * away / np.linalg.norm(away)
        axes.text(x, z, support.name, ha="center", va="center", fontsize=11, weight="bold")
    axes.legend(handles=key(), loc="upper center", bbox_to_anchor=(0.5, 0.0), fontsize=9, frameon=False, ncols=3)
    finish(axes)


def key() -> list[Line2D]:
    """The legend of the assembled view."""
    return [
        Line2D([], [], color=FLANGE, lw=5.0, label="flange of the frame"),
        Line2D([], [], color=EDGE, lw=5.0, label="edge of the panel"),
        Line2D([], [], color=TOUCH, lw=5.0, label="contact area"),
        Line2D([], [], marker="o", ls="none", ms=7.0, color="k", label="panel to frame"),
        Line2D([], [], marker="o", ls="none", ms=5.0, mec="k", mfc="w", label="to the carrier"),
        Line2D([], [], marker="^", ls="none", ms=8.0, color="k", label="supports"),
    ]


def view(azimuth: float, elevation: float) -> FloatArray:
    """Rows right, up and towards the viewer (3, 3), who looks from the cabin; degrees."""
    a, e = np.radians([azimuth, elevation])
    towards = np.array([np.sin(a) * np.cos(e), np.cos(a) * np.cos(e), np.sin(e)])
    right = np.array([-np.cos(a), np.sin(a), 0.0])
    return np.array([right, np.cross(towards, right), towards])


def draw(axes: Axes, part: PartMesh, camera: FloatArray, shift: FloatArray) -> None:
    """Shaded facets, the farthest first."""
    triangles = part.tris[:, [0, 1, 2, 2]]
    corners = part.coords[np.concatenate([part.quads, triangles])] + shift
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    shade = 0.45 + 0.55 * np.abs(normal @ (LIGHT / np.linalg.norm(LIGHT)))
    color = np.tile(to_rgb(COLORS[part.name]), (corners.shape[0], 1))
    for tag, paint in (("FRAME_FLANGE", FLANGE), ("PANEL_EDGE", EDGE)):
        if tag in part.tags:
            color[np.flatnonzero(part.tags[tag])] = to_rgb(paint)
    seen = corners @ camera.T
    order = np.argsort(seen[:, :, 2].mean(axis=1))
    faces = (color * shade[:, None])[order]
    axes.add_collection(
        PolyCollection(list(seen[order, :, :2]), facecolors=faces, edgecolors=0.82 * faces, linewidths=0.25)
    )


def finish(axes: Axes) -> None:
    """Equal scales, no frame."""
    axes.autoscale_view()
    axes.margins(0.04)
    axes.set_aspect("equal")
    axes.set_axis_off()


if __name__ == "__main__":
    main()
