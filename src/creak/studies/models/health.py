"""Health of the superelements of a study."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from pydantic import TypeAdapter

from creak.arrays import FloatArray
from creak.digest import digest
from creak.formats.safe_names import file_stem
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
