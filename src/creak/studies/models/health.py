"""Health of the superelements of a study, and whether joints of a reduced model were lost."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
from pydantic import TypeAdapter

from creak.arrays import FloatArray
from creak.digest import digest, file_stem
from creak.errors import NumericalError
from creak.formats.stored.solved import as_numbers, as_text
from creak.model.mesh import Nodes
from creak.progress import Progress
from creak.reduction.health import Health, health
from creak.studies.models.superelements import Reduced
from creak.studies.prepare.reduction import Band
from creak.studies.solved import solved

OWN_MODES_LIMIT = 40_000
"""Parts with more dofs are not solved again for their own free modes: a factorisation of the part, and as long a search
as a small reduction."""
SOFTER = 0.01
"""Share by which a frequency may lie below that of the unreduced model: those of both have far smaller errors."""
LOW = 1e-3
"""Of the highest frequency that is compared, up to which frequencies may be round-off."""


def checked(
    superelements: Sequence[Reduced],
    nodes: Nodes,
    band: Band,
    progress: Progress,
    store: Path | None = None,
) -> dict[str, Health]:
    """The health of every superelement by name.

    Parameters
    ----------
    nodes : all of the model.
    store : folder of saved superelements, beside which what was found of the same ones before is kept.
    """
    out = {}
    count = len(superelements)
    for k, r in enumerate(superelements):
        progress("check superelements", k, count)
        out[r.system.name] = _kept(r, nodes, band, store)
        r.inside.release()
    progress("check superelements", count, count)
    return out


def _kept(reduced: Reduced, nodes: Nodes, band: Band, store: Path | None) -> Health:
    """`check`, or what it said before of the same superelement."""

    def make() -> dict[str, FloatArray]:
        found = check(reduced, nodes, band.excited)
        return {"health": as_numbers(json.dumps(asdict(found)))}

    part, made_from = reduced.substructure.part, list[str]()
    if store is not None:
        asked = [part.name, band.f_max, band.excited]
        matters = (nodes.coords, nodes.scalar, part.labels, part.rows(part.labels)[0])
        made_from = [json.dumps([asked, sorted(reduced.made_from.items())]), *map(digest, matters)]
    found = solved(store, f"health_{file_stem(part.name)}", made_from, make)
    return TypeAdapter(Health).validate_python(json.loads(as_text(found["health"])))


def check(reduced: Reduced, nodes: Nodes, excited: float) -> Health:
    """The health of one superelement, see `checked`; with the factor that made it where that is still there.

    Parameters
    ----------
    excited : Hz, highest frequency of the excitation; 0: none is known.
    """
    part = reduced.substructure.part
    own_modes = part.n <= OWN_MODES_LIMIT and reduced.inside.in_one()  # they take a factor of the part
    return health(part, reduced.system, reduced.inside, nodes, f_excitation=excited or None, own_modes=own_modes)


def require_no_softer(reduced: FloatArray, unreduced: FloatArray) -> None:
    """Refuse a reduced model whose k-th frequency is below the k-th of the unreduced one.

    A Galerkin basis holds some motions of the structure; the least of Rayleigh's quotient over some is no smaller than
    that over all (Courant, Fischer). Frequencies below say that parts are joined at fewer dofs than they share.

    Parameters
    ----------
    reduced, unreduced : lowest frequencies of both models, Hz; those of the unreduced one rise, rigid ones first.

    Raises
    ------
    NumericalError : with the first mode that is.
    """
    n = min(reduced.size, unreduced.size)
    known, own = unreduced[:n], np.sort(reduced)[:n]
    soft = np.flatnonzero((own < (1.0 - SOFTER) * known) & (known > LOW * known[-1:].max(initial=0.0)))
    if soft.size:
        k = int(soft[0])
        raise NumericalError(
            f"mode {k + 1} of the reduced model has {own[k]:.4g} Hz, and {known[k]:.4g} Hz in the unreduced one: no "
            'reduction is softer, its parts are joined wrongly. Run with [reduction] method = "none", or without '
            "substructures, unreduced and keep_out, and send us the deck"
        )
