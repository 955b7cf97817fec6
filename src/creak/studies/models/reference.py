"""The unreduced model: parts, their assembly, its modes, and the linear pre-check.

A part is assembled, or known from an earlier run and assembled when somebody asks for its matrices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.part import loose_system, outlined_part
from creak.assembly.system import Stats, System
from creak.digest import digest
from creak.elements.free_sides import SHELLS
from creak.errors import InputError
from creak.formats.stored.solved import as_numbers, as_text
from creak.later import is_made, later
from creak.linalg.factor import Factor, LaterFactor, SingularMatrixError, factor, regular_factor
from creak.linalg.modes import Modes, modes, small_shift
from creak.model.mesh import Model
from creak.progress import Progress
from creak.reduction.modal import ModalDamping, modal_system, support_motion, with_modal_damping
from creak.studies.prepare.reduction import Band, Reduction
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


SMALL = 40_000
"""Dofs up to which modes up to [reduction] f_max are computed for the sake of modal damping alone."""
TRIALS, MORE = 5, 1e3
"""Traces of mass that are tried, each so many times the one before."""


@dataclass(frozen=True)
class ReferenceModel:
    """Unreduced parts and what was computed of their assembly."""

    parts: tuple[System, ...]
    loose: System | None
    """Nodes between parts."""
    system: System
    modes: Modes
    support_shapes: FloatArray
    """R = -K^-1 K_qs; free motions of a structure that is not held do not follow."""
    stiffness: Factor | None
    """A factor of K, made again where its memory was given back; None where the structure can move freely."""
    linear_gaps: FloatArray | None = None
    """(m,) smallest gap of every contact channel in the pre-check, taken on to where its motion repeats; None:
    there was none."""
    store: Path | None = None
    """Folder in which what was solved is kept (`solved`)."""
    of_parts: int | None = None
    """Free dofs of the whole where memory does not hold that: `system` are its parts, reduced to what joins them."""
    marks: tuple[Marks, ...] = ()
    """Of each part; none where nothing is kept."""
    key: str = ""
    """Digest of all that stiffness and mass depend on; empty where nothing is kept."""
    linear_closed: FloatArray | None = None
    """(2,) share of the pre-check's time in which a gap is closed, and how many are then; None where there was none."""

    @property
    def free_dof(self) -> int:
        """Dofs of the whole that can move."""
        return self.system.n if self.of_parts is None else self.of_parts

    def release(self) -> None:
        """Give the memory of the factor back until somebody asks for it again."""
        if isinstance(self.stiffness, LaterFactor):
            self.stiffness.release()


def build_reference(structure: Structure, band: Band, progress: Progress, store: Path | None = None) -> ReferenceModel:
    """Assemble the parts, join them, and find the modes of the whole, or take them from a run before (`solved`)."""
    return joined_reference(structure, band, assembled(structure, progress, store), progress, store)


def joined_reference(
    structure: Structure, band: Band, of: Assembled, progress: Progress, store: Path | None = None
) -> ReferenceModel:
    """Join the parts and find the modes of the whole; parts that are assembled later are joined later."""
    store = store if of.key else None
    mass = sum(s.stats.mass for s in (*of.parts, *structure.superelements))

    def join() -> System:
        return structure.joined(of.parts, of.loose)

    system = later(System, join, stats=Stats(mass)) if of.later else join()
    progress("assemble", len(of.parts), len(of.parts))
    stiffness, found, R = _solved(modal_band(band, sum(part.n for part in of.parts)), system, of, progress, store)
    whole = later(System, lambda: damped(structure.modal, system, found, R), stats=system.stats)
    kept = (None, store, None, of.marks, of.key)
    return ReferenceModel(tuple(of.parts), of.loose, whole, found, R, stiffness, *kept)


def _solved(
    f_max: float, system: System, of: Assembled, progress: Progress, store: Path | None
) -> tuple[Factor | None, Modes, FloatArray]:
    """A factor of K where it is regular, the modes, and the motion with the supports."""
    made, every = list[Factor | None](), dict[str, FloatArray]()

    def again() -> Factor:
        return factor(system.K)

    def solve() -> dict[str, FloatArray]:
        regular = regular_factor(system.K)
        stiffness = None if regular is None else LaterFactor(again, regular)
        del regular
        made.append(stiffness)
        found = modes(
            system.K,
            system.M,
            f_max=f_max,
            free=stiffness is None,
            stiffness_factor=stiffness,
            progress=lambda done, total: progress("modes of the assembly", done, total),
        )
        told = [found.residual, found.sturm_ok, found.next_omega2, found.columns, stiffness is not None]
        R = support_motion(system, stiffness or held_factor(system))
        every.update(shapes=found.shapes)
        return {"omega2": found.omega2, "R": R, "told": np.array(told, dtype=float)}

    def shapes() -> dict[str, FloatArray]:
        if not every:
            solve()
            made.clear()
        return every

    kept = solved(store, "assembly", [of.key, repr(f_max)], solve)
    residual, sturm_ok, following, columns, held = kept["told"].tolist()
    known: dict[str, Any] = {"omega2": kept["omega2"], "residual": residual, "sturm_ok": bool(sturm_ok)}
    known |= {"next_omega2": following, "columns": int(columns)}

    def whole() -> Modes:
        return Modes(shapes=solved(store, "shapes", [of.key, repr(f_max)], shapes)["shapes"], **known)

    found = later(Modes, whole, **known)
    if every:
        _ = found.shapes  # kept at once
    stiffness = made.pop() if made else LaterFactor(again) if held else None
    return stiffness, found, kept["R"]


def rejoined(structure: Structure, reference: ReferenceModel, parts: Sequence[int]) -> ReferenceModel:
    """The model joined as another structure has it, with its factor; only some parts are assembled again.

    Modes and shapes stay those of before.
    """
    every = [structure.part(i) if i in parts else part for i, part in enumerate(reference.parts)]
    system = structure.joined(every, reference.loose)
    return replace(reference, parts=tuple(every), system=system, stiffness=regular_factor(system.K))


def held_factor(system: System) -> Factor:
    """A factor of K, or of K with a trace of mass where the structure can move freely.

    Of a body that links make rigid K is nothing but round-off, of either sign: it takes more than a trace.

    Raises
    ------
    SingularMatrixError : motion without stiffness and mass.
    """
    found, shift = regular_factor(system.K), small_shift(system.K, system.M)
    if found is not None:
        return found
    for _ in range(TRIALS - 1):
        try:
            return factor(system.K + shift * system.M)
        except SingularMatrixError:
            shift *= MORE
    return factor(system.K + shift * system.M)


def damped(zeta: ModalDamping | None, system: System, found: Modes, R: FloatArray, *, every: bool = False) -> System:
    """The System with modal damping.

    Parameters
    ----------
    zeta : share of critical; None: there is none.
    every : `found` are all modes of the System. Else what lies beyond them is damped in proportion to its stiffness.
    """
    if zeta is None:
        return system
    return with_modal_damping(system, found, R, zeta, beyond=not every)


def modal_band(band: Band, n: int) -> float:
    """Highest frequency of the modes of an assembly of n dofs that the study needs, Hz.

    With modal damping the modes that the reduction keeps need it too, in models where they cost little.
    """
    if band.damped is None:
        return band.assembly
    return max(band.assembly, band.damped, band.f_max if n <= SMALL else 0.0)


def in_modes(reference: ReferenceModel, reduction: Reduction, system: System | None = None) -> System:
    """The modes of the assembly on the quasi-static motion of its supports and forces, as a small System.

    Parameters
    ----------
    system : in place of the model's own, with other damping.

    Raises
    ------
    InputError : as `static_shapes`.
    """
    shapes = static_shapes(reference, reduction)
    whole = reference.system if system is None else system
    return modal_system(whole, reference.modes, reference.support_shapes, shapes)


def static_shapes(reference: ReferenceModel, reduction: Reduction) -> FloatArray:
    """K^-1 B of the force excitations, (n, n_force).

    Raises
    ------
    InputError : there are forces, and only contact holds the structure.
    """
    system, forces = reference.system, reduction.exterior.forces
    B = np.zeros((system.n, len(forces)))
    for j, labels in enumerate(forces):
        B[:, j] = np.asarray(system.rows(labels)[0].sum(axis=0)).ravel()
    if not B.shape[1]:
        return B
    if reference.stiffness is None:
        raise InputError(
            f"method = {reduction.table.method!r} takes the static shape of each force, but only contact holds the "
            "structure",
            where=reduction.driving.places.where("reduction", "method"),
            expected="supports that hold it without contact",
            fix='Use method = "craig-bampton".',
        )
    return reference.stiffness.solve(np.asfortranarray(B))
