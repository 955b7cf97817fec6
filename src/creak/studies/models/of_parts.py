"""The model before its reduction where memory does not hold it as a whole: parts reduced to what joins them.

The linear pre-check and the modes that are told come from it. Contact is not retained: what moves at the channels are
static shapes and modes of the parts, kept as they were computed. One part is factorised at a time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from creak.arrays import IntArray
from creak.assembly.system import System
from creak.errors import NumericalError
from creak.linalg.factor import LaterFactor, factor, regular_factor
from creak.linalg.memory import OutOfMemory
from creak.linalg.modes import modes
from creak.linalg.scratch import on_disk, set_aside
from creak.model.dofs import node_dofs
from creak.progress import Progress
from creak.reduction.craig_bampton import fixed_interface_basis, reduced_matrices, reduced_system
from creak.reduction.inside import Inside
from creak.reduction.modal import support_motion
from creak.studies.models.outlines import Assembled, assembled
from creak.studies.models.reference import (
    ReferenceModel,
    damped,
    held_factor,
    joined_reference,
    modal_band,
)
from creak.studies.models.room import only_parts_fit
from creak.studies.models.substructures import required_labels, touched
from creak.studies.prepare.reduction import Band, Reduction
from creak.studies.prepare.structure import Structure

SPREAD = 2.0
"""Fixed-interface modes kept over the band whose modes are wanted: frequencies within some 0.1 % there."""


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
