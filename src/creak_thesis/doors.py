"""The doors of the thesis, set up once: model, channels, size, and what of them the configurations concern."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from creak import Bench, Model, Setup, change_study, make_bench, make_study, read_study, set_up
from creak_thesis.arrays import FloatArray, IntArray
from creak_thesis.door import LOADS, build_door, write_door
from creak_thesis.door.deck import SHEETS, mass
from creak_thesis.plan import CHECKED_BY, SCHEME, Setting

POINTS = "ABCDEFG"
"""Supports of table 3.3."""
DOF_NAMES = ("x", "y", "z", "rx", "ry", "rz")
Progress = Callable[[str, int, int], None]
AMPLITUDE = "excitation.hinge.signal.amplitude"


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
    setup = setups[0]
    door = build_door(mesh_size)
    sheets = {part: (s.young / 1e3, s.poisson, s.density * 1e12, s.thickness) for part, s in SHEETS.items()}
    gap = float(np.median(setup.contacts.gap0)) if setup.contacts.m else float("nan")
    held = {point: _held(setup, point) for point in POINTS}
    facts = DoorFacts(sum(mass(door).values()), door.n_dof, gap, len(door.links), sheets, held)
    kept = np.flatnonzero(np.isin(setups[0].contacts.names, list(channels))) if channels else None
    return Doors(facts, setups[0], kept, {"M1": setups[1].model, "M2": setups[2].model})


def _written(mesh_size: float, folder: Path, merge: int) -> Path:
    folder = folder / f"door_{mesh_size:g}mm_{merge}"
    if not (folder / "door.toml").exists():
        write_door(mesh_size, folder, merge)
    return folder / "door.toml"


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


class Benches:
    """Doors of one mesh size; a variant is set up when it is first asked for."""

    def __init__(self, mesh_size: float, folder: Path, progress: Progress) -> None:
        self.mesh_size, self._folder, self._progress = mesh_size, folder, progress
        self._made: dict[str, Bench] = {}

    def of(self, variant: Setting, others: Mapping[str, Setting]) -> Bench:
        """The variant set up; `others` by name, for those whose pre-check is taken over."""
        if variant.name not in self._made:
            source = self.of(others[variant.channels_of], others) if variant.channels_of else None
            self._made[variant.name] = self._set_up(variant, source)
        return self._made[variant.name]

    def _set_up(self, variant: Setting, source: Bench | None) -> Bench:
        hooks = "" if variant.hook_play is None else "_play"
        folder = self._folder / f"door_{self.mesh_size:g}mm_{variant.coarsen}{hooks}"
        write_door(self.mesh_size, folder, variant.coarsen, hook_play=variant.hook_play)
        own = {AMPLITUDE: LOADS[CHECKED_BY], **SCHEME, **variant.changes}
        tables = tomllib.loads((folder / "door.toml").read_text(encoding="utf-8"))
        tables["time"].pop("accuracy", None)  # the thesis forces its own step
        study = change_study(make_study(tables, folder), own)
        return make_bench(study, self._progress, at=None if source is None else source.positions)


def under(bench: Bench, load: str) -> Bench:
    """The bench with another load."""
    return bench.under({AMPLITUDE: LOADS[load]})
