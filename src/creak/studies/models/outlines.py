"""The parts of a model: assembled, or known from an earlier run and assembled when somebody asks for their matrices."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.part import loose_system, outlined_part
from creak.assembly.system import System
from creak.digest import digest
from creak.elements.free_sides import SHELLS
from creak.formats.stored.solved import as_numbers, as_text
from creak.later import is_made
from creak.model.mesh import Model
from creak.progress import Progress
from creak.studies.prepare.structure import Structure
from creak.studies.solved import solved


@dataclass(frozen=True)
class Marks:
    """What is asked of the matrices of a part that may not be there yet."""

    K: str
    """Digest of its entries."""
    M: str
    loose: IntArray
    """Coordinates without stiffness."""


@dataclass(frozen=True)
class Assembled:
    """The unreduced parts."""

    parts: list[System]
    loose: System | None
    """Nodes between parts."""
    marks: tuple[Marks, ...] = ()
    """Of each part; none where nothing is kept."""
    key: str = ""
    """Digest of all that stiffness and mass of the joined parts depend on; empty where nothing is kept."""

    @property
    def later(self) -> bool:
        """Whether a part is still to be assembled."""
        return not all(is_made(part) for part in self.parts)


def assembled(structure: Structure, progress: Progress, store: Path | None = None) -> Assembled:
    """The parts of the model; where an earlier run of the same one has left their outlines, matrices come later."""
    model, loose = structure.model, loose_system(structure.model, structure.rayleigh)
    if store is None or not store.is_dir():
        return Assembled(_assembled(structure, progress), loose)
    made: list[System] = []

    def make() -> dict[str, FloatArray]:
        made.extend(_assembled(structure, progress))
        return {f"{k}.{name}": A for k, part in enumerate(made) for name, A in _outline(part).items()}

    kept = solved(store, "parts", [_key_of_parts(model)], make)
    marks = [_marks(kept, k) for k in range(len(model.parts))]
    if not made:
        for k in range(len(model.parts)):
            at, mass = kept[f"{k}.coordinates"].astype(np.int64), float(kept[f"{k}.mass"][0])
            made.append(outlined_part(model, k, structure.rayleigh, at, mass, override=structure.override_damping))
    return Assembled(made, loose, tuple(marks), _key(structure))


def marks_of(part: System) -> Marks:
    """Of a part that is there."""
    return Marks(digest(part.K), digest(part.M), np.flatnonzero(part.K.diagonal() == 0.0))


def _assembled(structure: Structure, progress: Progress) -> list[System]:
    count, parts = len(structure.model.parts), list[System]()
    for i in range(count):
        progress("assemble", i, count)
        parts.append(structure.part(i))
    return parts


def _key_of_parts(model: Model) -> str:
    """Of what the parts are made of; names, and links of their own such as clips, are not among it."""
    own = tuple(block for block in model.blocks if block.part >= 0 or block.kind in SHELLS)
    return digest(_nameless(replace(model, blocks=own)))


def _key(structure: Structure) -> str:
    # rows of a part that came as matrices pick coordinates by their labels
    imported = [[s.name, s.M, s.K, s.damping, s.coordinates, s.velocity, s.labels] for s in structure.superelements]
    return digest([_nameless(structure.model), structure.driven, imported])


def _nameless(model: Model) -> Model:
    """Without the names of nodes, elements and surfaces, and without loads."""
    names: dict[str, Any] = {"node_sets": {}, "element_sets": {}, "surfaces": {}, "untyped": ()}
    return replace(model, source="", unread=(), prestress=None, static_loads={}, contact=None, **names)


def _outline(part: System) -> dict[str, FloatArray]:
    marks = marks_of(part)
    numbers = {"coordinates": part.coordinates, "mass": np.array([part.stats.mass]), "loose": marks.loose}
    texts = {"K": as_numbers(marks.K), "M": as_numbers(marks.M)}
    return {name: np.asarray(A, dtype=np.float64) for name, A in {**numbers, **texts}.items()}


def _marks(kept: dict[str, FloatArray], k: int) -> Marks:
    return Marks(as_text(kept[f"{k}.K"]), as_text(kept[f"{k}.M"]), kept[f"{k}.loose"].astype(np.int64))
