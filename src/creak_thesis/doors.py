"""The doors behind the outcomes: their size, and which elements and channels the configurations concern."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from creak import Model, Setup, read_study, set_up
from creak_thesis.arrays import FloatArray, IntArray
from creak_thesis.door import build_door, write_door
from creak_thesis.door.deck import SHEETS, mass

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


def open_doors(mesh_size: float, folder: Path, channels: Sequence[str]) -> Doors:
    """Build the doors of a mesh size in `folder`/doors, as the runs do.

    Parameters
    ----------
    channels : names of those that the pre-check keeps; empty: not known.
    """
    setups = [set_up(read_study(_written(mesh_size, folder / "doors", merge))) for merge in (1, 2, 3)]
    facts = _facts(mesh_size, setups[0])
    kept = np.flatnonzero(np.isin(setups[0].contacts.names, list(channels))) if channels else None
    return Doors(facts, setups[0], kept, {"M1": setups[1].model, "M2": setups[2].model})


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
    driven = setup.structure.driven.dofs_at(node)
    names = " ".join(DOF_NAMES[d - 1] for d in held)
    moved = " ".join(DOF_NAMES[d - 1] for d in driven)
    return f"{names} held, {moved} driven" if moved else names


def middle_of(points: FloatArray) -> FloatArray:
    """The point (3,) among (n, 3) with the shortest way to the others."""
    return np.asarray(points[int(np.linalg.norm(points - np.median(points, axis=0), axis=1).argmin())])
