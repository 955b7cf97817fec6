"""The model before its reduction where memory does not hold it as a whole: parts reduced to what joins them.

The linear pre-check and the modes that are told come from it. Contact is not retained: what moves at the channels are
static shapes and modes of the parts, kept as they were computed. One part is factorised at a time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.assembly.system import System
from creak.errors import NumericalError
from creak.linalg.factor import LaterFactor, factor, factor_bytes, regular_factor
from creak.linalg.memory import ENTRY, GB, OVERRIDE, OutOfMemory, free_bytes, on_disk, set_aside
from creak.linalg.modes import modes
from creak.linalg.pieces.factor import Pieces
from creak.model.dofs import node_dofs
from creak.progress import Progress
from creak.reduction.craig_bampton import fixed_interface_basis, reduced_matrices, reduced_system
from creak.reduction.inside import Inside, beside_factor, beside_pieces, pieces_of, plenty
from creak.reduction.modal import support_motion
from creak.studies.models.reference import (
    Assembled,
    ReferenceModel,
    assembled,
    damped,
    held_factor,
    joined_reference,
    modal_band,
)
from creak.studies.models.substructures import required_labels, touched
from creak.studies.prepare.reduction import Band, Reduction
from creak.studies.prepare.structure import Structure
from creak.studies.solved import solved

SPREAD = 2.0
"""Fixed-interface modes kept over the band whose modes are wanted: frequencies within some 0.1 % there."""
JOIN = 1.2
"""Memory of joining the parts over that of K and M of the whole."""


def reference_that_fits(
    reduction: Reduction, takes: Sequence[tuple[str, str]], progress: Progress, store: Path | None = None
) -> ReferenceModel:
    """The unreduced model joined, or its parts reduced to what joins them where memory holds no factor of the whole.

    Parameters
    ----------
    takes : what of the study needs the whole, as `Setup.takes_whole`.

    Raises
    ------
    OutOfMemory : not even those of its parts, or the study needs the whole.
    """
    structure, band, exterior = reduction.structure, reduction.band, reduction.exterior
    of = assembled(structure, progress, store)
    if not only_parts_fit(takes, of.parts, store, of.key):
        return joined_reference(structure, band, of, progress, store)
    must = required_labels(reduction, structure.model)
    seen = np.unique(np.concatenate([exterior.contacts.labels, exterior.connectors, node_dofs(exterior.watch.nodes)]))
    return reference_of_parts(structure, band, of, must, seen, progress, store)


def reference_of_parts(
    structure: Structure,
    band: Band,
    of: Assembled,
    must: IntArray,
    seen: IntArray,
    progress: Progress,
    store: Path | None = None,
) -> ReferenceModel:
    """Reduced parts, joined, with their modes in the band of the study.

    The matrices of the unreduced parts go to disk; in `of.parts` too, so that no one holds them in memory.

    Parameters
    ----------
    must : physical dofs that stay. seen : those whose motion is looked at.

    Raises
    ------
    NumericalError : links and supports do not hold every part.
    """
    parts = of.parts
    for k, part in enumerate(parts):
        parts[k] = replace(part, K=on_disk(part.K), M=on_disk(part.M))
    del part
    f_max = modal_band(band, sum(part.n for part in parts))
    try:
        small = [_reduced(part, must, seen, SPREAD * f_max, progress) for part in parts]
    except OutOfMemory:
        raise
    except NumericalError as error:
        raise NumericalError(f"memory does not hold a factor of the whole model, and without it {error}") from error
    system = structure.joined(small, of.loose)
    free = system.n + sum(s.stats.internal - s.stats.modes for s in small)
    regular = regular_factor(system.K)
    stiffness = None if regular is None else LaterFactor(lambda: factor(system.K), regular)
    found = modes(system.K, system.M, f_max=f_max, free=stiffness is None, stiffness_factor=stiffness)
    R = support_motion(system, stiffness or held_factor(system))
    system = damped(structure.modal, system, found, R)
    kept = (None, store if of.key else None, free, of.marks, of.key)
    return ReferenceModel(tuple(parts), of.loose, system, found, R, stiffness, *kept)


def _reduced(part: System, must: IntArray, seen: IntArray, f_max: float, progress: Progress) -> System:
    inside = Inside(part, touched(part, np.intersect1d(must, part.labels)))
    basis = fixed_interface_basis(inside, None, f_max, None, progress)
    if basis.fixed.shapes.size:  # they stay while the parts are reduced to their contacts
        basis = replace(basis, fixed=replace(basis.fixed, shapes=set_aside(basis.fixed.shapes)))
    matrices = reduced_matrices(part, basis, progress, watched=np.intersect1d(seen, part.labels))
    inside.release()
    return reduced_system(part, basis, matrices)


@dataclass(frozen=True)
class Room:
    """Least memory that the work takes beyond what is held now, modes window by window and stored on disk; bytes."""

    whole: float
    """With a factor of the whole model."""
    part: float
    """With factors of one part at a time."""
    largest: str
    """The part that takes most."""
    pieces: Pieces | None = None
    """Those that it is cut into, where memory does not hold its factor."""


def room(parts: Sequence[System], store: Path | None = None, key: str = "") -> Room | None:
    """None where there is plainly enough. Costs the analysis of the parts, a third of the time of their factors.

    Parameters
    ----------
    store : folder of saved superelements, beside which the analysis is kept. key : digest of all that the parts are.
    """
    if plenty(*(part.n for part in parts)):
        return None
    sizes = solved(store if key else None, "room", [key], lambda: {"sizes": _sizes(parts)})["sizes"]
    n, K, M, factors = sizes.sum(axis=0).tolist()
    whole = JOIN * ENTRY * (K + M) + factors + beside_factor(int(n), K, M)
    back = ENTRY * (K + M)  # the matrices of the parts go to disk then
    each = [(*_of_part(part, own, back), part.name) for part, own in zip(parts, sizes.tolist(), strict=True)]
    most, pieces, name = max(each, key=lambda part: part[0])
    return Room(whole, most, name, pieces)


def _sizes(parts: Sequence[System]) -> FloatArray:
    """(n_part, 4) dofs, entries of K and M, bytes of a factor of K."""
    return np.array([[p.n, p.K.nnz, p.M.nnz, factor_bytes(p.K)] for p in parts], dtype=np.float64)


def _of_part(part: System, sizes: Sequence[float], back: float) -> tuple[float, Pieces | None]:
    """With its factor, or with that of the pieces that it is cut into."""
    _, K, M, factor = sizes
    matrices, free = ENTRY * (K + M) - back, free_bytes()
    whole = matrices + factor + beside_factor(part.n, K, M)
    cut = None if whole <= free else pieces_of(part.K, part.M, free - matrices)
    return (whole, None) if cut is None else (matrices + cut.bytes + beside_pieces(part.n, M), cut)


def only_parts_fit(
    takes: Sequence[tuple[str, str]], parts: Sequence[System], store: Path | None = None, key: str = ""
) -> bool:
    """Whether memory holds the factors of the parts, one at a time, but not that of the whole.

    Parameters
    ----------
    takes : what of the study needs the unreduced model, as `Setup.takes_whole`.

    Raises
    ------
    OutOfMemory : it does not hold what the study takes.
    """
    needed, free = room(parts, store, key), free_bytes()
    if needed is None or needed.whole <= free:
        return False
    if not takes and needed.part <= free:
        return True
    if takes:
        words, ways = zip(*takes, strict=True)
        what, least = (
            f"a factor of the whole model, which {' and '.join(words)} {'takes' if len(words) == 1 else 'take'}",
            needed.whole,
        )
        alone = f"parts alone take {needed.part / GB:.3g} GB"
        fix = f"Use a coarser mesh or a machine with more memory, or do without it: {', '.join(ways)}; {alone}."
    else:
        what, least = f"the reduction of part {needed.largest}{_cut(needed)}", needed.part
        fix = (
            "Cut it into element sets by [reduction] substructures, use a coarser mesh, or a machine with more memory."
        )
    raise OutOfMemory(
        f"memory does not hold {what}: at least {least / GB:.3g} GB are needed, {free / GB:.3g} GB are free. {fix} To "
        f"try all the same, set {OVERRIDE}={least / GB * 1.01:.3g} in the environment."
    )


def _cut(needed: Room) -> str:
    return "" if needed.pieces is None else f", cut into {needed.pieces.count} pieces"
