"""The page of `creak robust`: odds by place and by node, odds over the load, causes."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from creak.formats.complete_file import write_text
from creak.model.units import UNITS
from creak.report.figures import palette
from creak.report.tables.robust import index_rows, place_rows, sentence
from creak.report.tables.run import Table
from creak.report.templates import page_templates
from creak.studies.robust.findings import Robustness
from creak.studies.robust.linear import FACTORS
from creak.studies.warned import plain_notes, warnings_of
from creak.version import version

FILES = Path(__file__).parent
MOST = 12
"""Bars of a picture."""
PER_LINE = 6
"""Words of a legend."""


def write_robust(found: Robustness, path: Path) -> None:
    """Write the page as one self-contained HTML file; it appears whole or not at all."""
    d = found.draws
    places, causes = place_rows(found), index_rows(found) if found.indices else []
    rows = []
    for c in found.draws.design.causes:
        given = c.of.model_dump(exclude_none=True, exclude_defaults=True, exclude={"type"})
        rows.append([c.key, c.of.type, ", ".join(f"{k} {v}" for k, v in given.items())])
    text = (
        page_templates("creak.report")
        .get_template("robust.html.j2")
        .render(
            version=version(),
            title=d.setup.study.config.title or d.setup.study.path.name,
            sentence=sentence(found) + ".",
            notes=plain_notes(found.notes),
            warnings=warnings_of(found.notes),
            places=Table(places[0], places[1:]),
            causes=Table(causes[0], causes[1:]) if causes else None,
            drawn=Table(["number", "distribution", ""], rows, text_columns=3),
            heat=Markup(_heat(found)),
            fragility=Markup(_fragility(found)),
            tornado=Markup(_tornado(found)),
            css=Markup((FILES / "report.css").read_text(encoding="utf-8")),
        )
    )
    write_text(path, text)


def _axes(width: float, height: float) -> tuple[Any, Any]:
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    drawing = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasSVG(drawing)
    axes = drawing.add_subplot()
    axes.spines[["top", "right"]].set_visible(False)
    return drawing, axes


def _legend(drawing: Any, title: str | None = None) -> None:
    """Clear of what is drawn."""
    drawing.legend(frameon=False, loc="outside upper right", ncols=PER_LINE, title=title)


def _svg(drawing: Any) -> str:
    text = io.StringIO()
    drawing.savefig(text, format="svg", metadata={"Date": None})
    drawn = text.getvalue()
    return drawn[drawn.index("<svg") :]


def _heat(found: Robustness) -> str:
    """Channels in the plane in which they spread most, coloured by their odds."""
    d = found.draws
    xyz = d.setup.model.nodes.coords[d.channels.nodes_idx]
    centred = xyz - xyz.mean(axis=0)
    widest = np.linalg.svd(centred, full_matrices=False)[2][:2] if len(xyz) > 1 else np.eye(2, 3)
    forward = np.take_along_axis(widest, np.abs(widest).argmax(axis=1)[:, None], axis=1) > 0.0
    plane = centred @ np.where(forward, widest, -widest).T  # what is up in the deck is not down in the picture
    drawing, axes = _axes(11.0, 4.2)
    odds = 100.0 * palette.touched(found.node_odds)
    order = np.argsort(odds)
    dots = axes.scatter(
        plane[order, 0],
        plane[order, 1],
        c=odds[order],
        cmap="viridis",
        vmin=0.0,
        vmax=odds.max(initial=0.0) or 100.0,
        s=36,
    )
    axes.set_aspect("equal", adjustable="datalim")
    unit = UNITS[d.setup.study.config.model.units].length
    axes.set_xlabel(f"along the widest direction of the contacts, {unit}")
    axes.set_ylabel(f"across it, {unit}")
    drawing.colorbar(dots, ax=axes, label="draws in which the node is hit, %")
    return _svg(drawing)


def _fragility(found: Robustness) -> str:
    drawing, axes = _axes(11.0, 3.4)
    for place in [p for p in found.places if p.fragility is not None][:MOST]:
        odds = place.fragility or ()
        line = axes.plot(FACTORS, [100.0 * o.p for o in odds], "o-", markersize=3, label=place.name.replace("$", r"\$"))
        axes.fill_between(
            FACTORS,
            [100.0 * o.low for o in odds],
            [100.0 * o.high for o in odds],
            color=line[0].get_color(),
            alpha=0.15,
            linewidth=0.0,
        )
    axes.axvline(1.0, color=palette.MUTED, linewidth=0.8)
    axes.set_xlabel("load, times that of the study")
    axes.set_ylabel("contact closes, % of draws")
    axes.set_ylim(0.0, 100.0)
    if axes.lines[:-1]:
        _legend(drawing)
    return _svg(drawing)


def _tornado(found: Robustness) -> str:
    """Mean of the largest force over the lowest and the highest quarter of each cause, about the mean of all."""
    bars = found.tornado.get("force", {})
    order = sorted(bars, key=lambda key: abs(bars[key][1] - bars[key][0]))[-MOST:]
    drawing, axes = _axes(11.0, 1.2 + 0.4 * max(len(order), 1))
    n = found.draws.design.n
    force = found.draws.figures[:n, :, 2].max(axis=1)
    middle = float(np.nanmean(force)) if np.isfinite(force).any() else 0.0
    for k, key in enumerate(order):
        for value, colour, name in zip(bars[key], (palette.REDUCED, palette.REFERENCE), ("low", "high"), strict=True):
            axes.barh(k, value - middle, left=middle, color=colour, label=name if k == 0 else None)
    axes.axvline(middle, color=palette.INK, linewidth=0.8)
    axes.set_yticks(range(len(order)), [key.replace("$", r"\$") for key in order])
    axes.set_xlabel(f"mean of the largest force, {UNITS[found.draws.setup.study.config.model.units].force}")
    if order:
        _legend(drawing, "quarter of the values")
    return _svg(drawing)
