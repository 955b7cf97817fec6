"""The door as the text of an Abaqus deck (mm, t, s)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from creak_thesis.arrays import FloatArray, IntArray
from creak_thesis.door import geometry as geo
from creak_thesis.door.assembly import Door
from creak_thesis.door.fasteners import SUPPORTS, Patch

FIRST_ID = {"FRAME": 1, "PANEL": 1_000_001, "CARRIER": 2_000_001, "REFERENCE": 9_000_001}
"""First node and element label of every part; the reference nodes follow their own block."""


@dataclass(frozen=True)
class Sheet:
    """Material and thickness of a part."""

    material: str
    young: float
    """MPa."""
    poisson: float
    density: float
    """t/mm^3."""
    thickness: float
    """mm."""


SHEETS = {
    "FRAME": Sheet("STEEL", 210_000.0, 0.3, 7.85e-9, geo.FRAME_THICKNESS),
    "PANEL": Sheet("PANEL_PLASTIC", 3_500.0, 0.25, 8.3e-10, geo.PANEL_THICKNESS),
    "CARRIER": Sheet("CARRIER_PLASTIC", 4_050.0, 0.4, 1.12e-9, geo.CARRIER_THICKNESS),
}


def rayleigh(ratio: float, f_low: float, f_high: float) -> tuple[float, float]:
    """Rayleigh coefficients with the same damping ratio at two frequencies (Hz).

    ratio = alpha / (2 omega) + beta omega / 2 at both: beta = 2 ratio / (omega_1 + omega_2),
    alpha = beta omega_1 omega_2 (Bathe, Finite Element Procedures, sec. 9.3.3).
    """
    low, high = 2 * math.pi * f_low, 2 * math.pi * f_high
    beta = 2 * ratio / (low + high)
    return beta * low * high, beta


ALPHA, BETA = rayleigh(0.02, 8.0, 80.0)
"""Mass (1/s) and stiffness (s) damping of all parts: 2 % at 8 and 80 Hz."""


def mass(door: Door) -> dict[str, float]:
    """Mass of every part, kg."""
    return {p.name: 1e3 * p.area() * SHEETS[p.name].thickness * SHEETS[p.name].density for p in door.parts}


def deck_text(door: Door, *, loose_hooks: bool = False) -> str:
    """The whole deck.

    Parameters
    ----------
    loose_hooks : the hooks between panel and frame let go in y; the study gives them play there.
    """
    joints = _joints(door, loose_hooks)
    return "\n".join([*_heading(door), *_parts(door), *joints, *_contact(door), *_sheets(), ""])


def hook_ends(door: Door) -> list[tuple[int, Patch, Patch]]:
    """Number of the link and both ends of every link of a hook between panel and frame."""
    links = enumerate(door.links)
    return [(k, a, b) for k, (a, b) in links if {a.part, b.part} == {"PANEL", "FRAME"} and "HOOK" in a.name]


def _heading(door: Door) -> Iterator[str]:
    yield "*HEADING"
    yield f"Front door: frame, carrier and trim panel; mesh size {door.mesh_size:g} mm; units mm, t, s"
    yield "** Written by creak example door."
    yield "** x to the rear, y into the cabin, z upwards."
    yield "** Normals: frame and carrier into the cabin (+y), panel towards the frame (-y)."
    if door.coarsen > 1:
        yield f"** Flange of the frame: {door.coarsen} elements merged into one along the contact line."
    yield f"** {door.n_nodes} nodes, {sum(mass(door).values()):.3f} kg."


def _parts(door: Door) -> Iterator[str]:
    for part in door.parts:
        first = FIRST_ID[part.name]
        yield f"** ---- {part.name.lower()} ----"
        yield f"*NODE, NSET={part.name}_NODES"
        yield from _node_lines(first, part.coords)
        for kind, corners, start in (("S4", part.quads, 0), ("S3", part.tris, part.quads.shape[0])):
            if corners.size:
                yield f"*ELEMENT, TYPE={kind}, ELSET={part.name}"
                yield from _element_lines(first + start, first + corners)
    yield "** ---- reference nodes: supports A to G, then the two ends of every rigid link ----"
    yield "*NODE, NSET=REFERENCE_NODES"
    yield from _node_lines(FIRST_ID["REFERENCE"], np.array([p.ref for p in _patches(door)]))


def _node_lines(first: int, coords: FloatArray) -> Iterator[str]:
    for label, (x, y, z) in enumerate(coords.tolist(), start=first):
        yield f"{label}, {x:.6f}, {y:.6f}, {z:.6f}"


def _element_lines(first: int, corners: IntArray) -> Iterator[str]:
    for label, row in enumerate(corners.tolist(), start=first):
        yield f"{label}, {', '.join(map(str, row))}"


def _patches(door: Door) -> list[Patch]:
    """All patches in the order of their reference nodes."""
    return [*door.supports, *(end for link in door.links for end in link)]


def _joints(door: Door, loose_hooks: bool) -> Iterator[str]:
    ref = FIRST_ID["REFERENCE"]
    yield "** ---- patches: the shell nodes that follow a reference node as a rigid body ----"
    for label, patch in enumerate(_patches(door), start=ref):
        yield from _set_lines(f"NSET, NSET=PATCH_{patch.name}", FIRST_ID[patch.part] + patch.rows)
        yield f"*SURFACE, TYPE=NODE, NAME=GRIP_{patch.name}"
        yield f"PATCH_{patch.name}, 1.0"
        yield f"*COUPLING, CONSTRAINT NAME=COUPLING_{patch.name}, REF NODE={label}, SURFACE=GRIP_{patch.name}"
        yield "*KINEMATIC"
        yield "1, 6"
    start = ref + len(door.supports)
    loose = {k for k, _, _ in hook_ends(door)} if loose_hooks else set()
    yield f"** ---- {len(door.links) - len(loose)} rigid links: follower, leader ----"
    yield "*MPC"
    for k in range(len(door.links)):
        if k not in loose:
            yield f"BEAM, {start + 2 * k + 1}, {start + 2 * k}"
    for k in sorted(loose):
        yield from _loose_link(start + 2 * k, start + 2 * k + 1, door.links[k])
    yield "** ---- supports: A header, B lower hinge, C D latch, E bottom, F upper hinge, G rear post ----"
    for k, support in enumerate(SUPPORTS):
        yield from _set_lines(f"NSET, NSET={support.name}", np.array([ref + k]))
    yield "** The study drives z of F."
    yield "*BOUNDARY"
    for support in SUPPORTS:
        yield from (f"{support.name}, {dof}, {dof}" for dof in support.fixed)


def _loose_link(leader: int, follower: int, ends: tuple[Patch, Patch]) -> Iterator[str]:
    """A rigid link without its y translation: u_f = u_l + theta x r in x and z, the same rotations."""
    x, y, z = (ends[1].ref - ends[0].ref).tolist()
    yield f"** ---- hook with play in y: {ends[0].name}, {ends[1].name} ----"
    for name, label in ((ends[0].name, leader), (ends[1].name, follower)):
        yield from _set_lines(f"NSET, NSET={name}", np.array([label]))
    for dof, arms in ((1, ((5, z), (6, -y))), (3, ((4, y), (5, -x))), *((r, ()) for r in (4, 5, 6))):
        terms = [(follower, dof, 1.0), (leader, dof, -1.0), *((leader, r, -arm) for r, arm in arms if arm)]
        yield "*EQUATION"
        yield f"{len(terms)}"
        yield from (f"{label}, {d}, {value:.9g}" for label, d, value in terms)


def _contact(door: Door) -> Iterator[str]:
    frame, panel, _ = door.parts
    yield "** ---- contact: edge of the panel (secondary) against the flange of the frame (main) ----"
    for name, part in (("PANEL_EDGE", panel), ("FRAME_FLANGE", frame)):
        labels = FIRST_ID[part.name] + np.flatnonzero(part.tags[name])
        yield from _set_lines(f"ELSET, ELSET={name}_ELEMENTS", labels)
        yield f"*SURFACE, TYPE=ELEMENT, NAME={name}"
        yield f"{name}_ELEMENTS"
    yield "** ---- verification pairs: k-th node of MAIN opposite k-th node of SECONDARY ----"
    for name, (main, secondary) in door.pairs.items():
        yield from _set_lines(f"NSET, NSET={name}_MAIN, UNSORTED", FIRST_ID["FRAME"] + main)
        yield from _set_lines(f"NSET, NSET={name}_SECONDARY, UNSORTED", FIRST_ID["PANEL"] + secondary)


def _sheets() -> Iterable[str]:
    yield "** ---- materials (MPa, t/mm^3) and thicknesses; damping 2 % at 8 and 80 Hz ----"
    for part, sheet in SHEETS.items():
        yield f"*MATERIAL, NAME={sheet.material}"
        yield "*ELASTIC"
        yield f"{sheet.young:g}, {sheet.poisson:g}"
        yield "*DENSITY"
        yield f"{sheet.density:g}"
        yield f"*DAMPING, ALPHA={ALPHA:.6g}, BETA={BETA:.6g}"
        yield f"*SHELL SECTION, ELSET={part}, MATERIAL={sheet.material}"
        yield f"{sheet.thickness:g}"


def _set_lines(keyword: str, labels: IntArray) -> Iterator[str]:
    yield f"*{keyword}"
    for start in range(0, labels.size, 16):
        yield ", ".join(map(str, labels[start : start + 16].tolist()))
