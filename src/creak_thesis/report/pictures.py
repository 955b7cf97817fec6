"""Pictures of the door for the thesis page."""

from __future__ import annotations

import numpy as np

from creak import Model, RigidLink, near_elements
from creak.report_tools import (
    Facets,
    Marks,
    Panel,
    View,
    data_uri,
    facets_of,
    front,
    model_picture,
    outward,
    palette,
    panels_picture,
)
from creak_thesis.arrays import FloatArray, IntArray
from creak_thesis.doors import POINTS, Doors, middle_of
from creak_thesis.report.blocks import PictureBlock

CONTACT, DRIVEN, INK, PARTS = palette.CONTACT, palette.DRIVEN, palette.INK, palette.PARTS
PALE = "#d9dee3"
PANEL_EDGE, FLANGE, LINE = "#d55e00", "#0072b2", "#003e78"
UNREDUCED = {"PANEL": "#d55e00", "FRAME": "#0072b2"}
DISTANCES = (8.0, 40.0, 90.0)
ZOOM = 6.5
"""Half the width of the local mesh that is shown, in mesh sizes."""


def parts_picture(doors: Doors) -> PictureBlock:
    """Figure 3.4: the three parts side by side."""
    model, view = doors.setup.model, _view(doors)
    panels = []
    for k, part in enumerate(model.parts):
        facets = _of_part(facets_of(model), k)
        if facets.count:
            panels.append(Panel(part.name.lower(), model, facets, (PARTS[k % len(PARTS)],), view))
    return _block(
        "Figure 3.4",
        panels_picture(panels, []),
        "The three parts of the simplified door, as creak's parametric surrogate makes them.",
    )


def supports_picture(doors: Doors) -> PictureBlock:
    """Figure 3.5: supports, driven point and contact surfaces."""
    setup = doors.setup
    points = np.array([int(setup.model.node_set(p)[0]) for p in POINTS])
    driven = setup.structure.driven.nodes_idx
    marks = [
        Marks("contact surface of the panel", _surface(setup.model, "PANEL_EDGE"), PANEL_EDGE, "o", 5.0),
        Marks("contact surface of the frame", _surface(setup.model, "FRAME_FLANGE"), FLANGE, "o", 2.5),
        Marks("supports A to G", points, INK, "^", 46.0),
        Marks("driven (F)", driven, DRIVEN, "D", 46.0),
    ]
    png = model_picture(setup.model, marks, outward(setup.contacts, setup.model.nodes.coords))
    assert png is not None
    return _block("Figure 3.5", png, "Supports, the driven upper hinge and the contact surfaces.")


def pairs_picture(doors: Doors) -> PictureBlock:
    """Figure 3.7: interface of the frame along the whole flange, and the 15 verification pairs."""
    model = doors.setup.model
    frame = _of_part(facets_of(model), 0)
    line = _border(model, "FRAME_FLANGE", 0)
    pairs = np.unique(np.concatenate([model.node_set("PAIRS15_MAIN"), model.node_set("PAIRS15_SECONDARY")]))
    many = np.unique(np.concatenate([model.node_set("PAIRS_MAIN"), model.node_set("PAIRS_SECONDARY")]))
    on_line = Marks("interface of the frame", line, LINE, "o", 5.0)
    view = _view(doors)
    panels = [
        Panel("(a) interface line", model, frame, (PALE,), view, [on_line]),
        Panel("(b) 15 verification pairs", model, frame, (PALE,), view, [Marks("pairs", pairs, CONTACT, "o", 16.0)]),
        Panel("44 pairs (figure C.1)", model, frame, (PALE,), view, [Marks("pairs", many, CONTACT, "o", 16.0)]),
    ]
    return _block(
        "Figure 3.7 and C.1",
        panels_picture(panels, []),
        "The line along which the frame's substructure meets its contact elements when the whole flange is in contact, "
        "and the node pairs at which motion is compared.",
    )


def main_model_picture(doors: Doors, kept: IntArray) -> PictureBlock:
    """Figure 3.10: the elements that stay in the main model D8, and the retained nodes of the substructures."""
    setup, view = doors.setup, _view(doors)
    model = setup.model
    contact = setup.contacts.select(kept)
    facets, held = facets_of(model), np.array([int(model.node_set(p)[0]) for p in POINTS])
    ends = [(c.dependent_idx, c.independent_idx) for c in model.constraints if isinstance(c, RigidLink)]
    links = np.unique(np.array(ends, dtype=np.int64))
    stays = _stays(model, contact.retained_nodes, DISTANCES[0])
    panels = []
    for k, part in enumerate(model.parts):
        of_part = _of_part(facets, k)
        if not of_part.count:
            continue
        mine = np.intersect1d(links, part.nodes_idx)
        marks = [Marks("links", mine, CONTACT, "o", 14.0)]
        if np.intersect1d(held, part.nodes_idx).size:
            marks.append(Marks("supports", held, INK, "^", 30.0))
        panels.append(Panel(f"({'abc'[k]}) {part.name.lower()}", model, of_part, (PALE,), view, marks))
    main = _coloured(model, facets, stays, only=True)
    panels.append(Panel("(d) main model, D8", model, main, list(UNREDUCED.values()), view))
    return _block(
        "Figure 3.10",
        panels_picture(panels, [(c, f"{p.lower()}, unreduced") for p, c in UNREDUCED.items()]),
        "The substructures with the reference nodes of the links (red) and supports (black), and what stays of the "
        "mesh in the main model D8: the elements at the channels that the pre-check keeps.",
    )


def distance_picture(doors: Doors, kept: IntArray) -> PictureBlock:
    """Figure 3.11: unreduced elements of D8, D40 and D90."""
    model, view = doors.setup.model, _view(doors)
    contact, facets = doors.setup.contacts.select(kept), facets_of(model)
    panels = []
    for distance in DISTANCES:
        stays = _stays(model, contact.retained_nodes, distance)
        shown = _coloured(model, facets, stays)
        panels.append(Panel(f"D{distance:g}", model, shown, [PALE, *UNREDUCED.values()], view))
    return _block(
        "Figure 3.11",
        panels_picture(panels, [(c, f"{p.lower()}, unreduced") for p, c in UNREDUCED.items()]),
        "Elements that stay unreduced when those within 8, 40 and 90 mm of the contact are kept out of the "
        "substructures (both parts; the thesis varies the panel's alone).",
    )


def coarse_picture(doors: Doors, mesh_size: float) -> PictureBlock:
    """Figure 3.12: the mesh along the flange, and with two or three of its elements merged."""
    view, panels = _view(doors), []
    base = doors.setup.model
    centre = view.flat(middle_of(base.nodes.coords[base.node_set("PAIRS_MAIN")])[None, :])[0]
    half = ZOOM * mesh_size * np.array([1.0, 0.55])
    window = np.stack([centre - half, centre + half])
    for name, model in {"M0 (the mesh of D8)": base, **doors.coarse}.items():
        panels.append(Panel(name, model, _around(model, view, window), (PALE, FLANGE), view, window=window))
    return _block(
        "Figure 3.12",
        panels_picture(panels, [(FLANGE, "contact elements of the frame")]),
        "A piece of the frame's flange as meshed, and with two (M1) or three (M2) contact elements merged into one.",
    )


def _around(model: Model, view: View, window: FloatArray) -> Facets:
    """Facets of the frame within a window, those of the flange in colour 1."""
    facets = _of_part(facets_of(model), 0)
    xy = view.flat(model.nodes.coords)[facets.nodes_idx].mean(axis=1)
    margin = 0.2 * (window[1] - window[0])
    inside = ((xy > window[0] - margin) & (xy < window[1] + margin)).all(axis=1)
    flange = np.zeros(model.nodes.count, dtype=bool)
    flange[_surface(model, "FRAME_FLANGE")] = True
    nodes = facets.nodes_idx[inside]
    return Facets(nodes, flange[nodes].all(axis=1).astype(np.int64))


def _stays(model: Model, nodes: IntArray, distance: float) -> set[tuple[int, ...]]:
    """Corner rows of the elements that stay unreduced."""
    found: set[tuple[int, ...]] = set()
    for block, rows in zip(model.blocks, near_elements(model, nodes, distance), strict=True):
        found.update(tuple(r) for r in block.nodes_idx[rows].tolist())
    return found


def _coloured(model: Model, facets: Facets, stays: set[tuple[int, ...]], *, only: bool = False) -> Facets:
    """Facets coloured by part where they stay, pale elsewhere; `only` those that stay."""
    colour = np.zeros(facets.count, dtype=np.int64)
    row = {name: k + 1 for k, name in enumerate(UNREDUCED)}
    for k, corners in enumerate(facets.nodes_idx.tolist()):
        key = tuple(corners) if corners[2] != corners[3] else tuple(corners[:3])
        if key in stays:
            colour[k] = row.get(model.parts[int(facets.part[k])].name, 0)
    if only:
        return Facets(facets.nodes_idx[colour > 0], colour[colour > 0] - 1)
    return Facets(facets.nodes_idx, colour)


def _border(model: Model, surface: str, part: int) -> IntArray:
    """Nodes that elements of a contact surface share with other elements of the part."""
    inside: set[int] = set()
    outside: set[int] = set()
    mine = {(int(b), int(e)) for b, e in model.surfaces[surface].facets}
    for k, block in enumerate(model.blocks):
        if block.part != part:
            continue
        for e, corners in enumerate(block.nodes_idx.tolist()):
            (inside if (k, e) in mine else outside).update(corners)
    return np.array(sorted(inside & outside), dtype=np.int64)


def _surface(model: Model, name: str) -> IntArray:
    """Nodes of an element surface."""
    rows = model.surfaces[name].facets
    return np.unique(np.concatenate([model.blocks[int(b)].nodes_idx[int(e)] for b, e in rows]))


def _of_part(facets: Facets, part: int) -> Facets:
    """Facets of one part, all in colour 0."""
    mine = facets.part == part
    return Facets(facets.nodes_idx[mine], np.zeros(int(mine.sum()), dtype=np.int64))


def _view(doors: Doors) -> View:
    return front(doors.setup.model.nodes.coords, outward(doors.setup.contacts, doors.setup.model.nodes.coords))


def _block(title: str, png: bytes, caption: str) -> PictureBlock:
    return PictureBlock(title, data_uri(png), caption)
