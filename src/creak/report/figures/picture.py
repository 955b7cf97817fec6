"""Pictures of the model: shaded shells by the painter's algorithm, with marks on top."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Colormap, LinearSegmentedColormap, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from PIL import Image

from creak.arrays import FloatArray, IntArray
from creak.model.faces import unit, vector_areas
from creak.model.plain_mesh import Mesh
from creak.report.figures.palette import CONTACT, DRIVEN, INK, MUTED, PARTS, touched
from creak.report.figures.view import EDGES_UP_TO, Facets, View, cut_up, facets_of, front, lines_of, three_quarter

PATCHES = 40000
"""Patches that a coarse mesh is cut into for the order of painting."""
DPI = 140
COLOURS = 256
"""Of a picture; rare ones, as those of marks and bars, are kept apart."""
LIGHT = np.array([-0.35, 0.45, 0.82])
"""Direction to the light in the view: right, up, toward the reader."""


@dataclass(frozen=True)
class Marks:
    """Nodes drawn on top of the mesh."""

    label: str
    nodes_idx: IntArray
    colour: str
    shape: str
    size: float


@dataclass(frozen=True)
class Loaded:
    """Nodes coloured by how hard they were hit."""

    nodes_idx: IntArray
    values: FloatArray
    label: str
    unit: str


@dataclass(frozen=True)
class Panel:
    """A mesh, or some of it, seen from one side."""

    title: str
    model: Mesh
    facets: Facets
    """What is painted; `part` is the row into `colours`."""
    colours: Sequence[str]
    view: View
    marks: Sequence[Marks] = ()
    window: FloatArray | None = None
    """(2, 2) lowest and highest corner that is shown, in the view; None: all facets."""


def model_picture(model: Mesh, marks: Sequence[Marks], outward: FloatArray) -> bytes | None:
    """PNG of the model from three-quarters and from the front; None for a model without extent."""
    views = _views(model, outward)
    if views is None:
        return None
    facets = facets_of(model)
    fig, axes = _canvas(model, views)
    for ax, view in zip(axes, views, strict=True):
        _draw_mesh(ax, model, facets, view, PARTS)
        _draw_marks(ax, model, view, marks)
    seen = [p for p in np.unique(facets.part).tolist() if p >= 0]
    shown = seen if len(seen) <= 10 else seen[:9]
    patches = [Patch(color=PARTS[p % len(PARTS)], label=model.parts[p].name) for p in shown]
    if len(shown) < len(seen):
        patches.append(Patch(color="white", label=f"and {len(seen) - len(shown)} more parts"))
    _legend(fig, [*patches, *_mark_handles(marks)])
    return _png(fig)


def contact_picture(model: Mesh, loaded: Loaded, outward: FloatArray) -> bytes | None:
    """PNG of the model with its contact nodes coloured and sized by a value; None for a model without extent."""
    views = _views(model, outward)
    if views is None:
        return None
    facets = facets_of(model)
    fig, axes = _canvas(model, views)
    loaded = replace(loaded, values=touched(loaded.values))
    scale = float(loaded.values.max(initial=0.0)) or 1.0
    for ax, view in zip(axes, views, strict=True):
        _draw_mesh(ax, model, facets, view, ("#d9dee3", "#e6e2da"))
        _draw_loaded(ax, model, view, loaded, scale)
    _name_hardest(axes[1], model, views[1], loaded)
    height = fig.get_size_inches()[1]
    bar = fig.add_axes((0.36, 0.22 / height, 0.28, 0.11 / height))
    bar.imshow(np.linspace(0.0, 1.0, 256)[None, :], aspect="auto", cmap=_scale_colours(), extent=(0.0, scale, 0.0, 1.0))
    bar.set_yticks([])
    bar.locator_params(axis="x", nbins=5)
    bar.tick_params(labelsize=8, length=2, colors=MUTED, pad=1)
    fig.text(0.35, 0.275 / height, loaded.label, ha="right", va="center", fontsize=9, color=INK)
    fig.text(0.65, 0.275 / height, "open: never touched", ha="left", va="center", fontsize=9, color=MUTED)
    return _png(fig)


def panels_picture(panels: Sequence[Panel], legend: Sequence[tuple[str, str]]) -> bytes:
    """PNG of meshes side by side, a title above each.

    Parameters
    ----------
    legend : (colour, words) of the facets; the marks of the first panel that has some are listed after them.
    """
    shapes = [_extent(p) for p in panels]
    widths = [max(float(s[1, 0] - s[0, 0]), 0.2 * float(s[1, 1] - s[0, 1])) for s in shapes]
    ratios = [min(w / max(float(s[1, 1] - s[0, 1]), 1e-9), 2.5) for w, s in zip(widths, shapes, strict=True)]
    height = float(np.clip(10.0 / sum(ratios), 1.6, 5.6)) + 0.85
    fig = Figure(figsize=(11.0, height), dpi=DPI)
    FigureCanvasAgg(fig)
    grid = fig.add_gridspec(
        1,
        len(panels),
        width_ratios=ratios,
        left=0.01,
        right=0.99,
        top=1.0 - 0.34 / height,
        bottom=0.55 / height,
        wspace=0.04,
    )
    for k, (panel, shape) in enumerate(zip(panels, shapes, strict=True)):
        ax = fig.add_subplot(grid[0, k])
        ax.set_aspect("equal")
        ax.axis("off")
        ax.set_title(panel.title, fontsize=10, color=INK)
        _draw_mesh(ax, panel.model, panel.facets, panel.view, panel.colours)
        _draw_marks(ax, panel.model, panel.view, panel.marks)
        pad = 0.03 * float((shape[1] - shape[0]).max())
        ax.set_xlim(shape[0, 0] - pad, shape[1, 0] + pad)
        ax.set_ylim(shape[0, 1] - pad, shape[1, 1] + pad)
    marks = next((p.marks for p in panels if p.marks), ())
    _legend(fig, [*(Patch(color=c, label=words) for c, words in legend), *_mark_handles(marks)])
    return _png(fig)


def _extent(panel: Panel) -> FloatArray:
    """(2, 2) lowest and highest corner of what the panel shows."""
    if panel.window is not None:
        return panel.window
    nodes = np.unique(panel.facets.nodes_idx)
    xy = panel.view.flat(panel.model.nodes.coords[nodes])
    return np.stack([xy.min(axis=0), xy.max(axis=0)])


def standard_marks(contact: IntArray, verification: IntArray, driven: IntArray, held: IntArray) -> list[Marks]:
    """The marks of the model picture, from node rows; empty ones are left out."""
    marks = [
        Marks("contact nodes", contact, CONTACT, "o", 9.0),
        Marks("verification nodes", verification, "white", "o", 16.0),
        Marks("held", held, INK, "^", 38.0),
        Marks("driven", driven, DRIVEN, "D", 46.0),
    ]
    return [m for m in marks if m.nodes_idx.size]


def _views(model: Mesh, outward: FloatArray) -> tuple[View, View] | None:
    coords = model.nodes.coords
    if coords.shape[0] < 2 or float(np.ptp(coords, axis=0).max()) == 0.0:
        return None
    straight = front(coords, outward)
    return three_quarter(straight), straight


def _canvas(model: Mesh, views: Sequence[View]) -> tuple[Figure, list[Axes]]:
    spans = [np.ptp(v.flat(model.nodes.coords), axis=0) for v in views]
    widths = [max(float(s[0]), 0.25 * float(s.max())) for s in spans]
    tall = max(float(s[1]) for s in spans)
    height = float(np.clip(10.2 * tall / sum(widths), 1.8, 5.6)) + 0.85
    fig = Figure(figsize=(11.0, height), dpi=DPI)
    FigureCanvasAgg(fig)
    below = 0.8 / height
    grid = fig.add_gridspec(1, 2, width_ratios=widths, left=0.01, right=0.99, top=0.995, bottom=below, wspace=0.03)
    axes = [fig.add_subplot(grid[0, k]) for k in range(2)]
    for ax, view in zip(axes, views, strict=True):
        ax.set_aspect("equal")
        ax.axis("off")
        _triad(ax, view)
    return fig, axes


def _draw_mesh(ax: Axes, model: Mesh, facets: Facets, view: View, colours: Sequence[str]) -> None:
    coords = view.rotate(model.nodes.coords)
    if facets.count:
        corners = coords[facets.nodes_idx]
        patches, shade = _patches(corners, _shaded(corners, facets.part, colours))
        order = np.argsort(patches[:, :, 2].mean(axis=1), kind="stable")
        flat: Any = patches[order][:, :, :2]
        painted = PolyCollection(flat, facecolors=shade[order], edgecolors=shade[order], linewidths=0.3)
        ax.add_collection(painted, autolim=False)  # looks at each patch
        ax.update_datalim(corners[:, :, :2].reshape(-1, 2))
    lines = lines_of(model)
    if lines.size:
        ax.add_collection(LineCollection(list(coords[lines][:, :, :2]), colors=MUTED, linewidths=1.0))
    if not facets.count:
        ax.scatter(coords[:, 0], coords[:, 1], s=6.0, color=MUTED, linewidths=0.0)
    ax.autoscale_view()
    ax.margins(0.03)


def _patches(corners: FloatArray, shade: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What is painted, far to near by its middle, (n, 4, 3) and its colours (n, 3).

    Few and large facets are cut up, so that the order by middles holds where parts lie close together; their
    edges are then painted as patches without width, a little nearer than the facets.
    """
    count = corners.shape[0]
    if count > EDGES_UP_TO:
        return corners, shade
    cuts = int(np.clip(np.sqrt(PATCHES / count), 1, 5))
    inner, edges = cut_up(corners, cuts)
    edges[:, :, 2] += 0.22 / cuts * float(np.linalg.norm(corners[:, 2] - corners[:, 0], axis=1).mean())
    colour = [np.repeat(shade, cuts * cuts, axis=0), np.repeat(0.74 * shade, 4 * cuts, axis=0)]
    return np.concatenate([inner, edges]), np.concatenate(colour)


def _shaded(corners: FloatArray, part: IntArray, colours: Sequence[str]) -> FloatArray:
    """(n, 3) colour of each facet under a light, the same on both of its sides."""
    normal = unit(vector_areas(corners))
    normal *= np.where(normal[:, 2] < 0.0, -1.0, 1.0)[:, None]
    bright = 0.58 + 0.46 * np.clip(normal @ (LIGHT / np.linalg.norm(LIGHT)), 0.0, 1.0)
    bright = np.round(64.0 * bright) / 64.0
    base = np.array([to_rgb(c) for c in colours])[part % len(colours)]
    return np.clip(base * bright[:, None], 0.0, 1.0)


def _draw_marks(ax: Axes, model: Mesh, view: View, marks: Sequence[Marks]) -> None:
    for k, m in enumerate(marks):
        xy = view.flat(model.nodes.coords[m.nodes_idx])
        line = 0.7 if m.colour == "white" or m.shape != "o" else 0.0
        edge = INK if m.colour != INK else "white"
        ax.scatter(
            xy[:, 0],
            xy[:, 1],
            s=m.size,
            c=m.colour,
            marker=m.shape,
            edgecolors=edge,
            linewidths=line,
            zorder=5 + k,
            clip_on=False,
        )


def _scale_colours() -> Colormap:
    return LinearSegmentedColormap.from_list("impact", ["#f7c948", "#e8743b", "#b5173a", "#4a0d42"])


def _draw_loaded(ax: Axes, model: Mesh, view: View, loaded: Loaded, scale: float) -> None:
    xy = view.flat(model.nodes.coords[loaded.nodes_idx])
    idle = loaded.values <= 0.0
    ax.scatter(xy[idle, 0], xy[idle, 1], s=5.0, c="white", edgecolors=MUTED, linewidths=0.5, zorder=5, clip_on=False)
    order = np.flatnonzero(~idle)[np.argsort(loaded.values[~idle])]
    ax.scatter(
        xy[order, 0],
        xy[order, 1],
        s=14.0 + 110.0 * loaded.values[order] / scale,
        c=loaded.values[order],
        cmap=_scale_colours(),
        vmin=0.0,
        vmax=scale,
        edgecolors=INK,
        linewidths=0.4,
        zorder=6,
        clip_on=False,
    )


def _name_hardest(ax: Axes, model: Mesh, view: View, loaded: Loaded) -> None:
    if loaded.values.max(initial=0.0) <= 0.0:
        return
    node = int(loaded.nodes_idx[int(loaded.values.argmax())])
    x, y = view.flat(model.nodes.coords[[node]])[0]
    middle = view.flat(model.nodes.coords).mean(axis=0)
    inward = np.array([1.0 if x < middle[0] else -1.0, 1.0 if y < middle[1] else -1.0])
    ax.annotate(
        f"node {model.nodes.label(node)}: {loaded.values.max():.3g} {loaded.unit}",
        (float(x), float(y)),
        xytext=(30.0 * inward[0], 46.0 * inward[1]),
        textcoords="offset points",
        fontsize=9,
        color=INK,
        zorder=8,
        ha="left" if inward[0] > 0 else "right",
        va="center",
        bbox={"boxstyle": "round,pad=0.3", "fc": "white", "ec": MUTED, "lw": 0.6},
        arrowprops={"arrowstyle": "-", "color": INK, "lw": 0.8},
    )


def _mark_handles(marks: Sequence[Marks]) -> list[Line2D]:
    return [
        Line2D(
            [],
            [],
            linestyle="",
            marker=m.shape,
            color=m.colour,
            label=f"{m.label} ({m.nodes_idx.size})",
            markeredgecolor=INK if m.colour == "white" else m.colour,
            markersize=6.0,
        )
        for m in marks
    ]


def _legend(fig: Figure, handles: Sequence[Patch | Line2D]) -> None:
    if handles:
        fig.legend(
            handles=list(handles),
            loc="lower center",
            ncols=min(len(handles), 8),
            frameon=False,
            fontsize=9,
            handlelength=1.2,
            columnspacing=1.6,
            handletextpad=0.5,
            labelcolor=INK,
        )


def _triad(ax: Axes, view: View) -> None:
    """Small coordinate axes in the lower left corner."""
    origin = np.array([18.0, -22.0])
    arrow = {"arrowstyle": "-|>", "color": MUTED, "lw": 0.9, "shrinkA": 0, "shrinkB": 0}
    for k, name in enumerate("xyz"):
        tip = view.matrix[k, :2]
        if np.hypot(*tip) < 0.15:
            continue
        for text, length in (("", 22.0), (name, 30.0)):
            end = (float(origin[0] + length * tip[0]), float(origin[1] + length * tip[1]))
            ax.annotate(
                text,
                end,
                xytext=end if text else (18.0, -22.0),
                xycoords="axes points",
                textcoords="axes points",
                arrowprops=None if text else dict(arrow),
                ha="center",
                va="center",
                fontsize=8,
                color=MUTED,
                annotation_clip=False,
            )


def _png(fig: Figure) -> bytes:
    """In `COLOURS` colours: a quarter of the bytes, and it looks the same."""
    whole, data = io.BytesIO(), io.BytesIO()
    fig.savefig(whole, format="png", dpi=DPI, facecolor="white", pil_kwargs={"compress_level": 0})
    picture = Image.open(whole).convert("RGB")
    picture.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(
        data, format="png", optimize=True
    )
    return data.getvalue()


def data_uri(png: bytes) -> str:
    """A PNG as an address that holds the picture itself."""
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")
