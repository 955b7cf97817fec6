"""Decks that creak and CalculiX both read, and what CalculiX (`ccx`) finds with them."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from helpers_fem import Mesh, grid, rectangle
from helpers_solids import block

STEEL = "*MATERIAL, NAME=M\n*ELASTIC\n2.1E5, 0.3\n*DENSITY\n7.8E-9\n"
Supports = Sequence[tuple[np.ndarray, str]]
"""Nodes and `first, last` dof that they are held in."""


def modes_deck(mesh: Mesh, element: str, section: str, supports: Supports = (), count: int = 10) -> str:
    """A frequency step for `count` modes."""
    return _model(mesh, element, section, supports) + f"*STEP, PERTURBATION\n*FREQUENCY\n{count}\n*END STEP\n"


def static_deck(mesh: Mesh, element: str, section: str, supports: Supports, node: int, dof: int) -> str:
    """A unit force at a node, of which the displacement is printed."""
    step = f"*STEP\n*STATIC\n*CLOAD\n{node + 1}, {dof}, 1.\n*NODE PRINT, NSET=LOADED\nU\n*END STEP\n"
    return _model(mesh, element, section, supports) + f"*NSET, NSET=LOADED\n{node + 1},\n" + step


def _model(mesh: Mesh, element: str, section: str, supports: Supports) -> str:
    lines = ["*NODE", *(f"{n}, {x:.10g}, {y:.10g}, {z:.10g}" for n, (x, y, z) in enumerate(mesh.coords, 1))]
    lines.append(f"*ELEMENT, TYPE={element}, ELSET=E")
    for label, nodes in enumerate((mesh.elements + 1).tolist(), 1):
        words = [str(w) for w in (label, *nodes)]
        lines += [", ".join(words[:10]) + "," * (len(words) > 10), *([", ".join(words[10:])] if words[10:] else [])]
    for at, dofs in supports:
        lines += ["*BOUNDARY", *(f"{n + 1}, {dofs}" for n in at.tolist())]
    return "\n".join([*lines, section + STEEL])


def shell(thickness: float) -> str:
    return f"*SHELL SECTION, ELSET=E, MATERIAL=M\n{thickness}\n"


SOLID = "*SOLID SECTION, ELSET=E, MATERIAL=M\n"
BEAM = "*BEAM SECTION, ELSET=E, MATERIAL=M, SECTION=RECT\n6., 4.\n0., 1., 0.\n"


def plate(kind: str, n: int, m: int) -> Mesh:
    return rectangle(n, m, 100.0, 60.0, kind)


def panel(kind: str, n: int, m: int) -> Mesh:
    """80 degrees of a cylinder of radius 60, 100 long in x."""

    def shape(xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
        angle = np.deg2rad(80.0) * (eta - 0.5)
        return np.column_stack([100 * xi, 60 * np.sin(angle), 60 * np.cos(angle)])

    return grid(n, m, shape, kind)


def half_roof(kind: str, n: int) -> Mesh:
    """40 degrees from the crown (y = 0), radius 250, 250 long in x."""

    def shape(xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
        angle = np.deg2rad(40.0) * eta
        return np.column_stack([250 * xi, 250 * np.sin(angle), 250 * np.cos(angle)])

    return grid(n, n, shape, kind)


def bow(kind: str, n: int, m: int) -> Mesh:
    """A quarter of a circle of radius 100 from the root at x = 0, 20 wide in z."""

    def shape(xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
        angle = np.pi / 2 * xi
        return np.column_stack([100 * np.sin(angle), 100 * (1 - np.cos(angle)), 20 * eta])

    return grid(n, m, shape, kind)


def brick(kind: str) -> Mesh:
    """40 x 12 x 10, cells moved by up to a fifth of their size."""
    return block((4, 2, 2), (40.0, 12.0, 10.0), kind, 0.2)


def straight_beam(n: int) -> Mesh:
    """n beams of three nodes, 120 long in x."""
    coords = np.zeros((2 * n + 1, 3))
    coords[:, 0] = np.linspace(0.0, 120.0, 2 * n + 1)
    return Mesh(coords, 2 * np.arange(n)[:, None] + np.arange(3), None)


def ccx(deck: str, folder: Path) -> np.ndarray:
    """Frequencies, Hz, or the displacement (3,) of the loaded node."""
    (folder / "job.inp").write_text(deck)
    subprocess.run(["ccx", "-i", "job"], cwd=folder, check=True, capture_output=True, timeout=600)
    rows = [line.split() for line in (folder / "job.dat").read_text().split("P A R T I C I P")[0].splitlines()]
    width, columns = (5, slice(3, 4)) if "*FREQUENCY" in deck else (4, slice(1, 4))
    found = [[float(w) for w in row[columns]] for row in rows if len(row) == width and row[0].isdigit()]
    return np.array(found).ravel()
