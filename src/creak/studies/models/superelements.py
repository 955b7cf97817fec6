"""Superelements of a study: reduced, or taken from the store where nothing that they depend on has changed."""

from __future__ import annotations

import os
import shutil
import weakref
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.digest import digest
from creak.errors import CreakError, InputError, NumericalError
from creak.formats.deck.command_files import plain_file
from creak.formats.safe_names import file_stem
from creak.formats.stored.boundary import Boundary, boundary_arrays, boundary_of, state_of
from creak.formats.stored.superelement import (
    MAPPED,
    SavedSuperelement,
    read_superelement_file,
    read_where_it_fits,
    write_superelement_file,
)
from creak.later import later
from creak.linalg.memory import GB, OutOfMemory
from creak.linalg.modes import Modes
from creak.linalg.scratch import disk_room
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
from creak.studies.models.dof_names import row_names
from creak.studies.models.outlines import marks_of
from creak.studies.models.substructures import Substructure
from creak.studies.prepare.exterior import Exterior
from creak.studies.prepare.reduction import Band, Reduction
from creak.studies.solved import SOLVED, forget, solved
from creak.version import edition

KEPT = 300_000_000
"""Bytes of a part's factor up to which it stays for the check of the superelement; a larger one is made again."""
SPARED = 3
"""Superelements of a part that runs keep, those made last."""
WORDS = {
    "stiffness": "its stiffness changed",
    "mass": "its mass changed",
    "damping": "its damping changed",
    "dofs": "its dofs changed",
    "retained": "other dofs are retained",
    "interface": "its interface is reduced differently",
    "modes": "other modes are asked for",
    "creak": "it was made by another version of creak",
}


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
    def complete(self) -> bool:
        """Whether it has all modes that there are, and every shape of its boundary: it leaves nothing out."""
        every = self.basis.fixed.next_omega2 == np.inf and self.system.stats.modes == self.basis.fixed.omega2.size
        return bool(every) and self.substructure.shape is None


def reduce_substructure(
    model: Model,
    reduction: Reduction,
    exterior: Exterior,
    sub: Substructure,
    folder: Path | None,
    progress: Progress,
) -> tuple[Reduced, list[str]]:
    """One superelement, from the store or made anew, and notes for people; it still holds the factor that made it.

    Raises
    ------
    InputError : the retained dofs do not hold the part, or its saved file is damaged.
    """
    wanted, band = made_from(reduction, sub), reduction.band
    f_max = None if reduction.table.method == "guyan" else band.first
    found, notes = _from_store(folder, sub.part.name, wanted)
    if found is not None and found.saved.made_from != wanted:
        wider = _wider(found.saved, sub, model)
        sub, found = (sub, None) if wider is None else (wider, found)
    if found is not None and found.saved.made_from != wanted:
        name, wanted = sub.part.name, dict(found.saved.made_from)
        notes = [f"superelement {name}: taken from {file_stem(name)}.h5, which retains more dofs than the run needs"]
    if found is None and folder is not None:
        found, said = _kept(folder, sub.part.name, wanted)
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
        seen = np.intersect1d(exterior.seen(model), sub.part.labels)
        matrices = reduced_matrices(sub.part, basis, progress, watched=seen)
        notes += _in_pieces(inside)
    reduced = Reduced(sub, sub.part, inside, basis, matrices, wanted, found is not None)
    reduced = _with_kept(band.raised_to(0), reduced)
    for k in range(band.raised):
        reduced = raised_once(band.raised_to(k + 1), reduced, progress)
    return reduced, notes


def _with_kept(band: Band, reduced: Reduced) -> Reduced:
    """Its System made of the modes that are kept."""
    kept = truncated(reduced.basis, reduced.matrices, band.kept_modes(reduced.basis.fixed.omega2))
    return replace(reduced, system=reduced_system(reduced.substructure.part, *kept))


def raised_once(band: Band, reduced: Reduced, progress: Progress) -> Reduced:
    """The superelement with f_max raised to that of the band: its further modes are kept, and new ones computed."""
    part = reduced.substructure.part
    basis, matrices = raised(part, reduced.basis, reduced.matrices, band.f_max, progress)
    return _with_kept(band, replace(reduced, basis=basis, matrices=matrices))


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
    return fingerprints(sub, f"{method} {band.first:.17g}{' and further' if band.further else ''}")


def is_saved(folder: Path, name: str, made_from: Mapping[str, str]) -> bool:
    """Whether the folder has the superelement already."""
    path = _path(folder, name)
    if shared_path(folder, name, made_from).exists():
        return True
    return path.exists() and read_where_it_fits(path, lambda _: False)[0] == made_from


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


def _path(folder: Path, name: str) -> Path:
    return folder / f"{file_stem(name)}.h5"


def shared_path(folder: Path, name: str, made_from: Mapping[str, str]) -> Path:
    """File of one of several superelements of a part that lie in one folder, told apart by what they depend on."""
    path = _path(folder, name)
    return path.with_name(f"{path.stem}.{digest(made_from, 8)}.h5")


def _from_store(folder: Path | None, name: str, made_from: Mapping[str, str]) -> tuple[Boundary | None, list[str]]:
    """What fits, or but for its retained dofs does, and notes for people."""
    if folder is None:
        return None, []
    shared = shared_path(folder, name, made_from)
    if shared.exists():
        found = _boundary(folder, shared)
        if found.saved.made_from == made_from:
            return found, [f"superelement {name}: taken from {shared.name}"]
    path = _path(folder, name)
    if not path.exists():
        return None, []
    found = _boundary(folder, path)
    other = {key for key in made_from if found.saved.made_from.get(key) != made_from[key]}
    changed = [WORDS[key] for key in made_from if key in other]
    if not changed:
        return found, [f"superelement {name}: taken from {path.name}"]
    stale = f"superelement {name}: the saved one in {path.name} is stale ({', '.join(changed)}); reduced again"
    return found if other <= {"retained"} else None, [stale]


def _kept(folder: Path, name: str, made_from: Mapping[str, str]) -> tuple[Boundary | None, list[str]]:
    """The very same that a run has kept, and a note; a damaged one is made again."""
    path = shared_path(folder / SOLVED, name, made_from)
    if not path.exists():
        return None, []
    try:
        found = _boundary(folder, path)
    except InputError:
        return None, []
    if found.saved.made_from != made_from:
        return None, []
    return found, [f"superelement {name}: taken from {path.relative_to(folder)}"]


def _boundary(folder: Path, path: Path) -> Boundary:
    """A saved superelement; as long as its file is not touched, its large modes are read only where they are needed.

    Raises
    ------
    InputError : it is no superelement file, or a damaged one.
    """
    whole: list[SavedSuperelement] = []
    try:
        plain_file(path, is_input=False)
    except OSError as error:
        raise InputError(
            f"cannot read {path}: {error.strerror}", fix="Delete it and run `creak reduce` again."
        ) from error
    state, held = state_of(path), os.open(path, os.O_RDONLY) if os.name == "posix" else -1

    def read() -> SavedSuperelement:
        if whole or held < 0 or state_of(path) == state:
            return whole[0] if whole else read_superelement_file(path)
        with NamedTemporaryFile(suffix=".h5") as copy, os.fdopen(os.dup(held), "rb") as file:
            file.seek(0)  # as it was, though another lies in its place now
            shutil.copyfileobj(file, copy)
            copy.flush()
            return read_superelement_file(Path(copy.name))

    if held >= 0:
        weakref.finalize(read, os.close, held)

    def make() -> dict[str, FloatArray]:
        whole.append(read_superelement_file(path))
        return boundary_arrays(whole[0])

    return boundary_of(solved(folder, _boundary_kind(path), [state], make, most=1), read)


def _boundary_kind(path: Path) -> str:
    """First word of the file with the boundary of a superelement."""
    return f"boundary_{path.stem.replace('.', '_')}"


def _wider(saved: SavedSuperelement, sub: Substructure, model: Model) -> Substructure | None:
    """The substructure that a saved superelement is of, where it retains all that is asked for and more.

    It serves as well: contact that a change brings closer than the pre-check allows needs no new reduction then.
    """
    if sub.shape is not None:
        return None
    ids, dofs = row_names(sub.part, model)
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
    path = shared_path(folder, name, reduced.made_from) if shared else _path(folder, name)
    if shared and path.exists():
        return path
    m = reduced.matrices
    matrices = {"K": m.K, "M": m.M, "M_alone": m.M_alone, **({} if m.C is None else {"C": m.C})}
    ids, dofs = row_names(with_all_modes(reduced).system, model)  # the file has those beyond f_max too
    fixed = reduced.basis.fixed
    write_superelement_file(
        path,
        SavedSuperelement(
            name,
            reduced.made_from,
            matrices,
            reduced.basis.P,
            fixed.omega2,
            fixed.shapes,
            fixed.next_omega2,
            ids,
            dofs,
            about,
            m.static.at,
            m.static.values,
        ),
    )
    return path


def kept_of_run(folder: Path, reduced: Reduced, model: Model, band: Band) -> Reduced:
    """The same, saved for the runs to come, which take it where they would make the very same one.

    Where the folder cannot be written, or its disk is nearly full, nothing is saved, which costs time alone.
    """
    name, fixed = reduced.system.name, reduced.basis.fixed
    if reduced.reused or not folder.is_dir() or fixed.shapes.nbytes > disk_room(str(folder)):
        return reduced
    kept = folder / SOLVED
    try:
        path = save_superelement(kept, reduced, model, {"deck": str(model.source)}, shared=True)
    except (OSError, CreakError):
        return reduced
    for old in forget(kept, f"{_path(kept, name).stem}.*.h5", SPARED):
        forget(kept, f"{_boundary_kind(old)}.*.h5", 0)
    return with_modes_of_file(band, reduced, path)


def with_modes_of_file(band: Band, reduced: Reduced, path: Path) -> Reduced:
    """The same, its modes read from its file where they are large: their memory is free for the next part."""
    fixed = reduced.basis.fixed
    if fixed.shapes.nbytes < MAPPED:
        return reduced
    basis = replace(reduced.basis, fixed=replace(fixed, shapes=read_superelement_file(path).modes))
    return _with_kept(band, replace(reduced, basis=basis))
