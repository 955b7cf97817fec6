"""A plate of two halves on soft springs, whose thickness, modulus and springs are taken wrong, and tests of the true one."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from creak.studies.models.deck_modes import DeckModes, deck_modes
from helpers_decks import write_study

TRUE = {"thickness": 1.5, "youngs_modulus": 70000.0, "stiffness": 2.0}
WRONG = {"thickness": 1.8, "youngs_modulus": 60000.0, "stiffness": 1.2}
KEYS = ("section.LEFT.thickness", "material.ALU.youngs_modulus", "section.FEET.stiffness")
MODES = 40
NX, NY, SIDE = 14, 8, 20.0
STUDY = '[model]\ndeck = "plate.inp"\n'


def plate_deck(thickness: float, youngs_modulus: float, stiffness: float) -> str:
    """A left half of steel, a right one of aluminium; each node on a spring to ground, held in the plane."""
    at = {(i, j): 1 + i + j * (NX + 1) for j in range(NY + 1) for i in range(NX + 1)}
    lines = ["*NODE", *(f"{k}, {i * SIDE}, {j * SIDE}, 0." for (i, j), k in at.items())]
    for name, columns in (("LEFT", range(NX // 2)), ("RIGHT", range(NX // 2, NX))):
        lines.append(f"*ELEMENT, TYPE=S4, ELSET={name}")
        lines += [
            f"{1 + i + j * NX}, {at[i, j]}, {at[i + 1, j]}, {at[i + 1, j + 1]}, {at[i, j + 1]}"
            for j in range(NY)
            for i in columns
        ]
    lines += ["*ELEMENT, TYPE=SPRING1, ELSET=FEET", *(f"{9000 + k}, {k}" for k in at.values())]
    lines += [f"*SPRING, ELSET=FEET\n3\n{stiffness!r}", "*MATERIAL, NAME=STEEL\n*ELASTIC\n210000., 0.3"]
    lines += ["*DENSITY\n7.85e-9,", f"*MATERIAL, NAME=ALU\n*ELASTIC\n{youngs_modulus!r}, 0.33\n*DENSITY\n2.7e-9,"]
    lines += [f"*SHELL SECTION, ELSET=LEFT, MATERIAL=STEEL\n{thickness!r},"]
    lines += ["*SHELL SECTION, ELSET=RIGHT, MATERIAL=ALU\n1.2,"]
    lines += [f"*NSET, NSET=ALL, GENERATE\n1, {len(at)}, 1\n*BOUNDARY\nALL, 1, 2\nALL, 6, 6"]
    return "\n".join(lines) + "\n"


def write_plate(folder: Path, study: str = STUDY, **changes: float) -> Path:
    """plate.inp with the wrong numbers and study.toml; returns the study's path."""
    return write_study(folder, study, {"plate.inp": plate_deck(**{**WRONG, **changes})})


def true_modes(folder: Path) -> DeckModes:
    """Of the plate as it is."""
    path = folder / "true.inp"
    path.write_text(plate_deck(**TRUE), encoding="utf-8")
    return deck_modes(path, count=MODES)


def write_plate_test(
    found: DeckModes, path: Path, seed: int | None = None, sigma: float = 0.01, mac: float = 0.95, count: int = MODES
) -> Path:
    """The first modes along z at a third of the nodes, with noise of this deviation in frequency and this MAC."""
    rng = np.random.default_rng(seed)
    rows = np.arange(0, found.model.nodes.count, 3)
    lines = ["frequency_hz,sensor,x,y,z,direction,value"]
    for f, u in zip(found.frequencies[:count], found.translations(), strict=False):
        shape = u[rows, 2]
        if seed is not None:
            f *= 1.0 + sigma * rng.standard_normal()
            noise = rng.standard_normal(rows.size)
            shape = shape + noise * np.linalg.norm(shape) / np.linalg.norm(noise) * np.sqrt(1.0 / mac - 1.0)
        for row, value in zip(rows, shape, strict=True):
            x, y, z = found.model.nodes.coords[row]
            lines.append(f"{f:.9g},{found.model.nodes.ids[row]},{x:g},{y:g},{z:g},z,{value:.9g}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path
