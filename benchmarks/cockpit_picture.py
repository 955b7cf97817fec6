"""The picture of the cockpit in docs/cockpit.md: `python -m benchmarks.cockpit_picture [--out FILE]`."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from benchmarks.door_picture import LIGHT, finish, view
from creak.arrays import FloatArray
from creak_thesis.cockpit import deck as geo
from creak_thesis.cockpit.deck import POINTS
from creak_thesis.door.mesh import PartMesh

COLORS = {
    "CARRIER": "#a9b4be",
    "LID": "#c9a77c",
    "TRIM": "#7d9471",
    "DUCT": "#8fa8c8",
    "BEAM": "#8a8a8f",
    "HOLDER": "#b58db0",
}
PULLED_APART = {"BEAM": -260.0, "DUCT": -140.0, "CARRIER": 0.0, "HOLDER": 130.0, "TRIM": 150.0, "LID": 260.0}
"""Distance in y between the parts of the exploded view, mm."""
SAID = {
    "BEAM": ("beam", 0.0, 12.0),
    "DUCT": ("air duct", 0.0, 12.0),
    "CARRIER": ("carrier", 0.92, 12.0),
    "TRIM": ("decor trim", 0.0, 12.0),
    "HOLDER": ("card holder", 0.7, -30.0),
    "LID": ("lid", 0.5, -30.0),
}
"""Part -> words, where along it, how far above its upper edge (below: its lower edge)."""
RATTLES, SQUEAKS, ALARM, MISSED = "#d1152b", "#f0821e", "#e8c21a", "#7d3fb8"
PLACES = (
    ("BUMPER_LEFT_LID", "bumper_left", RATTLES, (-55.0, -45.0)),
    ("LATCH_LID", "latch", RATTLES, (0.0, 45.0)),
    ("BUMPER_RIGHT_LID", "bumper_right", RATTLES, (60.0, -50.0)),
    ("DUCT_PAD", "duct", RATTLES, (40.0, 70.0)),
    ("TRIM_RIB", "trim: squeaks only", SQUEAKS, (-20.0, 60.0)),
    ("LID_RIM", "lid_rim: linear alone", ALARM, (60.0, -90.0)),
    ("HOLDER_TIP", "card_holder: contact alone", MISSED, (0.0, -110.0)),
)
"""Node set, what it says, colour, place of the words beside the first point."""


def main() -> None:
    """Draw the cockpit."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.cockpit_picture")
    options.add_argument("--out", type=Path, default=Path("docs/cockpit.png"))
    given = options.parse_args()
    parts = geo.cockpit_parts(10.0)
    figure = Figure(figsize=(13.0, 4.9), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, width_ratios=[1.1, 1.0])
    exploded(left, parts)
    places(right, parts)
    figure.savefig(given.out, dpi=110)


def exploded(axes: Axes, parts: dict[str, PartMesh]) -> None:
    """The parts pulled apart towards the occupants."""
    camera = view(azimuth=-38.0, elevation=22.0)
    for name in sorted(parts, key=PULLED_APART.__getitem__):
        shift = np.array([0.0, PULLED_APART[name], 0.0])
        draw(axes, name, parts[name], camera, shift)
        words, along, up = SAID[name]
        seen = (parts[name].coords + shift) @ camera.T
        x = seen[:, 0].min() + along * np.ptp(seen[:, 0])
        here = seen[np.abs(seen[:, 0] - x) < 15.0, 1]
        axes.text(x, (here.max() if up > 0.0 else here.min()) + up, words, ha="left", fontsize=11, zorder=9)
    finish(axes)


def places(axes: Axes, parts: dict[str, PartMesh]) -> None:
    """Seen by the occupants, the lid left out, with the places."""
    camera = view(azimuth=0.0, elevation=0.0)
    for name in sorted(parts, key=PULLED_APART.__getitem__):
        if name != "LID":
            draw(axes, name, parts[name], camera, np.zeros(3))
    x0, x1, z0, z1 = geo.LID
    axes.plot([-x0, -x1, -x1, -x0, -x0], [z0, z0, z1, z1, z0], color=COLORS["LID"], lw=2.0, zorder=7)
    for name, words, color, (right, up) in PLACES:
        at = np.array([(-x, z) for x, _, z in POINTS[name][1]])
        axes.plot(at[:, 0], at[:, 1], "o", ms=8.0, mfc=color, mec="k", zorder=9)
        axes.annotate(
            words,
            at[0],
            at[0] + (right, up),
            ha="center",
            va="center",
            fontsize=10,
            zorder=10,
            arrowprops={"arrowstyle": "-", "lw": 0.8},
            bbox={"boxstyle": "round,pad=0.25", "fc": "white", "ec": color},
        )
    finish(axes)


def draw(axes: Axes, name: str, part: PartMesh, camera: FloatArray, shift: FloatArray) -> None:
    """Shaded facets, the farthest first."""
    corners = part.coords[part.quads] + shift
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    shade = 0.5 + 0.5 * np.abs(normal @ (LIGHT / np.linalg.norm(LIGHT)))
    seen = corners @ camera.T
    order = np.argsort(seen[:, :, 2].mean(axis=1))
    faces = (np.array(to_rgb(COLORS[name])) * shade[:, None])[order]
    axes.add_collection(
        PolyCollection(list(seen[order, :, :2]), facecolors=faces, edgecolors=0.85 * faces, linewidths=0.25)
    )


if __name__ == "__main__":
    main()
