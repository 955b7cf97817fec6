"""The doors behind the outcomes: their size, and which elements and channels the configurations concern."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from creak.arrays import FloatArray, IntArray
from creak.door import build_door, write_door
from creak.door.deck import SHEETS, mass
from creak.model.mesh import Model
from creak.studies.setup import Setup, set_up
from creak.studies.study_file import read_study

POINTS = "ABCDEFG"
"""Supports of table 3.3."""
DOF_NAMES = ("x", "y", "z", "rx", "ry", "rz")


@dataclass(frozen=True)
class DoorFacts:
    """What tables 3.1 to 3.3 say of a door."""

    mass: float
    """kg"""
    n_dof: int
    gap: float
    """mm, median clearance of the channels."""
    links: int
    sheets: dict[str, tuple[float, float, float, float]]
    """Part -> Young's modulus GPa, Poisson's ratio, density kg/m^3, thickness mm."""
    supports: dict[str, str]


@dataclass(frozen=True)
class Doors:
    """The door of the studies and its coarser flanges."""

    facts: DoorFacts
    setup: Setup
    kept: IntArray | None
    """Channels that the pre-check keeps; None where no run tells."""
    coarse: dict[str, Model]
    """M1 and M2."""


def open_doors(mesh_size: float, folder: Path) -> Doors:
    """Build the doors of a mesh size in `folder`/doors, as the runs do.

    The kept channels are read from the unreduced run under the reference load, where that is there.
    """
    setups = [set_up(read_study(_written(mesh_size, folder / "doors", merge))) for merge in (1, 2, 3)]
    facts = _facts(mesh_size, setups[0])
    return Doors(facts, setups[0], _kept(setups[0], folder / "runs"), {"M1": setups[1].model, "M2": setups[2].model})


def _written(mesh_size: float, folder: Path, merge: int) -> Path:
    folder = folder / f"door_{mesh_size:g}mm_{merge}"
    if not (folder / "door.toml").exists():
        write_door(mesh_size, folder, merge)
    return folder / "door.toml"


def _facts(mesh_size: float, setup: Setup) -> DoorFacts:
    door = build_door(mesh_size)
    sheets = {part: (s.young / 1e3, s.poisson, s.density * 1e12, s.thickness) for part, s in SHEETS.items()}
    gap = float(np.median(setup.contacts.gap0)) if setup.contacts.m else float("nan")
    held = {point: _held(setup, point) for point in POINTS}
    return DoorFacts(sum(mass(door).values()), door.n_dof, gap, len(door.links), sheets, held)


def _held(setup: Setup, point: str) -> str:
    """Dofs held and driven at a support, in words."""
    node = int(setup.model.node_set(point)[0])
    held = sorted({d for f in setup.model.fixed if node in f.nodes_idx for d in f.dofs})
    driven = sorted({int(x) % 6 for labels in setup.driven.labels.values() for x in labels if int(x) // 6 == node})
    names = " ".join(DOF_NAMES[d - 1] for d in held)
    moved = " ".join(DOF_NAMES[d] for d in driven)
    return f"{names} held, {moved} driven" if moved else names


def _kept(setup: Setup, runs: Path) -> IntArray | None:
    """Channels of the unreduced run under A4, by name."""
    for path in sorted(runs.glob("Ref StS_A4_*.npz")):
        with np.load(path) as data:
            names = set(data["channels"].tolist())
        rows = np.flatnonzero([n in names for n in setup.contacts.names])
        if rows.size:
            return rows.astype(np.int64)
    return None


def near(model: Model, nodes: IntArray, distance: float) -> list[IntArray]:
    """Rows of the elements of each block whose nodes all lie within `distance` of `nodes`: they stay unreduced."""
    away, _ = cKDTree(model.nodes.coords[nodes]).query(model.nodes.coords, distance_upper_bound=1.000001 * distance)
    close = np.isfinite(away)
    return [
        np.flatnonzero(close[b.nodes_idx].all(axis=1)) if b.part >= 0 else np.zeros(0, np.int64) for b in model.blocks
    ]


def middle_of(points: FloatArray) -> FloatArray:
    """The point (3,) among (n, 3) with the shortest way to the others."""
    return np.asarray(points[int(np.linalg.norm(points - np.median(points, axis=0), axis=1).argmin())])
