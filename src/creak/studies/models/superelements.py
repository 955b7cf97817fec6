"""Superelements of a study: reduced, or taken from the store where nothing that they depend on has changed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from creak.assembly.system import System, row_names
from creak.digest import digest, file_stem
from creak.errors import CreakError, InputError, NumericalError
from creak.formats.stored.superelement import (
    MAPPED,
    Boundary,
    SavedSuperelement,
    read_superelement_file,
    write_superelement_file,
)
from creak.later import later
from creak.linalg.memory import GB, OutOfMemory, disk_room
from creak.linalg.modes import Modes
from creak.model.dofs import PER_NODE
from creak.model.mesh import Model
from creak.progress import Progress
from creak.reduction.craig_bampton import (
    Basis,
    Matrices,
    StaticRows,
    fixed_interface_basis,
    reduced_matrices,
    reduced_system,
    truncated,
)
from creak.reduction.inside import Inside
from creak.reduction.raised import raised
from creak.studies.models.reference import marks_of
from creak.studies.models.saved import NO_STORE, Store, boundary_kind, from_store, part_path, shared_path, very_same
from creak.studies.models.substructures import Substructure
from creak.studies.prepare.reduction import Band, Reduction
from creak.studies.solved import SOLVED, forget
from creak.version import edition

KEPT = 300_000_000
"""Bytes of a part's factor up to which it stays for the check of the superelement; a larger one is made again."""
RAISED = ", raised"
"""Of what the modes of a superelement are, each time that f_max was."""
SPARED = 4
"""Superelements of a part that runs keep, those made last."""


@dataclass(frozen=True)
class Reduced:
    """A reduced substructure with all that it came from."""

    substructure: Substructure
    system: System
    inside: Inside
    basis: Basis
    """With the further modes, beyond f_max, that the look at what it leaves out takes."""
    matrices: Matrices
    """In the coordinates of `basis`."""
    made_from: Mapping[str, str]
    reused: bool

    @property
    def every_mode(self) -> bool:
        """Whether it has all modes that there are."""
        fixed = self.basis.fixed
        return bool(fixed.next_omega2 == np.inf and self.system.stats.modes == fixed.omega2.size)

    @property
    def complete(self) -> bool:
        """Whether it has all modes that there are, and every shape of its boundary: it leaves nothing out."""
        return self.every_mode and self.substructure.shape is None


def reduce_substructure(
    reduction: Reduction, sub: Substructure, store: Store, progress: Progress
) -> tuple[Reduced, list[str]]:
    """One superelement, from the store or made anew, and notes for people; it still holds the factor that made it.

    Raises
    ------
    InputError : the retained dofs do not hold the part, or its saved file is damaged.
    """
    model, band, folder = reduction.structure.model, reduction.band, store.folder
    first = band.raised_to(0)
    wanted = made_from(replace(reduction, band=first), sub)
    f_max = None if reduction.table.method == "guyan" else band.first
    if folder is not None and band.raised:
        again = _raised_before(band, sub, folder, wanted)
        if again is not None:
            return again
    found, notes = from_store(folder, sub.part.name, wanted)
    if found is not None and found.saved.made_from != wanted:
        wider = _wider(found.saved, sub, model)
        sub, found = (sub, None) if wider is None else (wider, found)
    if found is not None and found.saved.made_from != wanted:
        name, wanted = sub.part.name, dict(found.saved.made_from)
        notes = [f"superelement {name}: taken from {file_stem(name)}.h5, which retains more dofs than the run needs"]
    if found is None and folder is not None:
        found, said = very_same(folder, sub.part.name, wanted)
        notes = said or notes
    inside = Inside(sub.part, sub.boundary)
    if found is not None:
        basis, matrices = _restored(inside, found)
    else:
        try:
            count = 0 if f_max is None else None
            basis = fixed_interface_basis(
                inside, sub.shape, f_max, count, progress, further=f_max is not None and band.further
            )
        except OutOfMemory:
            raise
        except NumericalError as error:
            raise InputError(
                str(error),
                where=reduction.driving.places.where("reduction"),
                expected="retained dofs that hold every part",
                fix="Couple it at more nodes, or add a node set to [reduction] retain.",
            ) from error
        seen = np.intersect1d(reduction.exterior.seen(model), sub.part.labels)
        matrices = reduced_matrices(sub.part, basis, progress, watched=seen)
        notes += _in_pieces(inside)
    reduced = Reduced(sub, sub.part, inside, basis, matrices, wanted, found is not None)
    on_the_way = replace(store, keep="nothing")
    reduced = _kept(on_the_way if band.raised else store, _with_kept(first, reduced), model, first)
    for k in range(1, band.raised + 1):
        reduced = raised_once(band.raised_to(k), reduced, model, progress, on_the_way if k < band.raised else store)
    return reduced, notes


def _raised_before(
    band: Band, sub: Substructure, folder: Path, wanted: Mapping[str, str]
) -> tuple[Reduced, list[str]] | None:
    """The superelement with f_max raised as often, where a run has kept it: those on the way need not be there."""
    wanted = {**wanted, "modes": wanted["modes"] + RAISED * band.raised}
    found, notes = very_same(folder, sub.part.name, wanted)
    if found is None:
        return None
    inside = Inside(sub.part, sub.boundary)
    basis, matrices = _restored(inside, found)
    reduced = Reduced(sub, sub.part, inside, basis, matrices, wanted, reused=True)
    return _with_kept(band, reduced), notes


def _with_kept(band: Band, reduced: Reduced) -> Reduced:
    """Its System made of the modes that are kept."""
    kept = truncated(reduced.basis, reduced.matrices, band.kept_modes(reduced.basis.fixed.omega2))
    return replace(reduced, system=reduced_system(reduced.substructure.part, *kept))


def raised_once(band: Band, reduced: Reduced, model: Model, progress: Progress, store: Store = NO_STORE) -> Reduced:
    """The superelement with f_max raised to that of the band: its further modes are kept, and new ones computed, or
    taken from the store."""
    part = reduced.substructure.part
    wanted = {**reduced.made_from, "modes": reduced.made_from["modes"] + RAISED}
    found = None if store.folder is None else very_same(store.folder, part.name, wanted)[0]
    if found is not None:
        basis, matrices = _restored(reduced.inside, found)
    else:
        basis, matrices = raised(part, reduced.basis, reduced.matrices, band.f_max, progress)
    again = replace(reduced, basis=basis, matrices=matrices, made_from=wanted, reused=found is not None)
    return _kept(store, _with_kept(band, again), model, band)


def _in_pieces(inside: Inside) -> list[str]:
    """What became of a part whose factor does not fit."""
    cut = inside.pieces
    if cut is None:
        return []
    free = max(cut.left, 0.0) / GB
    return [
        f"part {inside.name} does not fit: {cut.instead / GB:.2g} GB for its factor, {free:.2g} GB free for it. "
        f"It is cut into {cut.count} pieces that {cut.joint:,} dofs join, of which as many stay factorised as fit "
        f"(one at least, {cut.bytes / GB:.2g} GB): its superelement is the same, and takes longer"
    ]


def with_all_modes(reduced: Reduced) -> Reduced:
    """The superelement with every mode that was computed."""
    return replace(reduced, system=reduced_system(reduced.substructure.part, reduced.basis, reduced.matrices))


def made_from(reduction: Reduction, sub: Substructure) -> dict[str, str]:
    """What the superelement of a substructure depends on in this study, each as a hash."""
    method, band = reduction.table.method, reduction.band
    if method == "guyan":
        return fingerprints(sub, method)
    further = " and further" if band.further else ""
    return fingerprints(sub, f"{method} {band.first:.17g}{further}{RAISED * band.raised}")


def fingerprints(sub: Substructure, modes: str) -> dict[str, str]:
    """What a superelement depends on, each as a hash."""
    part, extra, marks = sub.part, sub.part.damping.extra, sub.marks or marks_of(sub.part)
    return {
        "stiffness": marks.K,
        "mass": marks.M,
        "damping": "" if extra is None else digest(extra),
        "dofs": digest(part.coordinates),
        "retained": digest(sub.boundary),
        "interface": "" if sub.shape is None else digest(sub.shape),
        "modes": modes,
        "creak": edition(),
    }


def _wider(saved: SavedSuperelement, sub: Substructure, model: Model) -> Substructure | None:
    """The substructure that a saved superelement is of, where it retains all that is asked for and more.

    It serves as well: contact that a change brings closer than the pre-check allows needs no new reduction then.
    """
    if sub.shape is not None:
        return None
    ids, dofs = row_names(sub.part, model.nodes.ids)
    own, named = PER_NODE * ids + dofs, (PER_NODE * saved.node_ids + saved.dofs)[saved.node_ids > 0]
    order = np.argsort(own, kind="stable")
    row = order[np.maximum(np.searchsorted(own, named, side="right", sorter=order) - 1, 0)]
    boundary = np.unique(np.where(own[row] == named, row, -1)).astype(np.int64)
    if not np.isin(sub.boundary, boundary).all() or digest(boundary) != saved.made_from["retained"]:
        return None
    return replace(sub, boundary=boundary)


def _restored(inside: Inside, found: Boundary) -> tuple[Basis, Matrices]:
    saved = found.saved
    if (saved.shape.shape[0], found.inner) != (inside.b.size, inside.i.size):
        raise InputError(
            f"the saved superelement {saved.name} is of a part of another size",
            fix="Delete it and reduce the part again.",
        )
    known: dict[str, Any] = {"omega2": saved.omega2, "residual": 0.0, "sturm_ok": True, "columns": 0}
    known["next_omega2"] = saved.first_left_out
    fixed = later(Modes, lambda: Modes(shapes=saved.modes, **known), **known)
    m, static = saved.matrices, StaticRows(saved.static_at, saved.static_rows, found.modes)
    return Basis(inside, sp.csr_matrix(saved.shape), fixed), Matrices(m["K"], m["M"], m["M_alone"], m.get("C"), static)


def save_superelement(
    folder: Path, reduced: Reduced, model: Model, about: Mapping[str, Any], *, shared: bool = False
) -> Path:
    """Write one superelement; returns its file.

    Parameters
    ----------
    shared : beside others of the same part instead of in their place; one that is there already is left alone.
    """
    name = reduced.system.name
    path = shared_path(folder, name, reduced.made_from) if shared else part_path(folder, name)
    if shared and path.exists():
        return path
    m = reduced.matrices
    matrices = {"K": m.K, "M": m.M, "M_alone": m.M_alone, **({} if m.C is None else {"C": m.C})}
    ids, dofs = row_names(with_all_modes(reduced).system, model.nodes.ids)  # the file has those beyond f_max too
    fixed = reduced.basis.fixed
    write_superelement_file(
        path,
        SavedSuperelement(
            name=name,
            made_from=reduced.made_from,
            matrices=matrices,
            shape=reduced.basis.P,
            omega2=fixed.omega2,
            modes=fixed.shapes,
            first_left_out=fixed.next_omega2,
            node_ids=ids,
            dofs=dofs,
            about=about,
            static_at=m.static.at,
            static_rows=m.static.values,
        ),
    )
    return path


def _kept(store: Store, reduced: Reduced, model: Model, band: Band) -> Reduced:
    """The same, saved where the runs to come take it if they would make the very same one.

    Where the folder cannot be written, or its disk is nearly full, nothing is saved, which costs time alone.
    """
    name, fixed, folder, keep = reduced.system.name, reduced.basis.fixed, store.folder, store.keep
    if keep == "nothing" or folder is None or reduced.reused or not (keep == "all" or folder.is_dir()):
        return reduced
    place = folder if keep == "all" else folder / SOLVED
    try:
        place.mkdir(parents=True, exist_ok=True)
        if fixed.shapes.nbytes > disk_room(str(place)):
            return reduced
        path = save_superelement(place, reduced, model, {"deck": str(model.source)}, shared=True)
    except (OSError, CreakError):
        return reduced
    if keep == "last":
        for old in forget(place, f"{part_path(place, name).stem}.*.h5", SPARED):
            forget(place, f"{boundary_kind(old)}.*.h5", 0)
    return with_modes_of_file(band, reduced, path)


def with_modes_of_file(band: Band, reduced: Reduced, path: Path) -> Reduced:
    """The same, its modes read from its file where they are large: their memory is free for the next part."""
    fixed = reduced.basis.fixed
    if fixed.shapes.nbytes < MAPPED:
        return reduced
    basis = replace(reduced.basis, fixed=replace(fixed, shapes=read_superelement_file(path).modes))
    return _with_kept(band, replace(reduced, basis=basis))
