"""Static loads that the deck has: which of them a study takes, and what they free."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from creak.errors import InputError, suggest
from creak.model.constraints import without
from creak.model.mesh import Model
from creak.model.steps import StaticLoads
from creak.studies.file.case import Driving


def deck_loads(model: Model, driving: Driving, place: int) -> StaticLoads | None:
    """The loads of the deck that a [[static]] table names; None where it names none.

    Raises
    ------
    InputError : the deck has none of that name, or creak cannot read them.
    """
    given = driving.statics[place].deck_loads
    if given is None:
        return None
    name = str(given)
    if name not in model.static_loads:
        raise InputError(
            f"the deck has no static loads {name!r}",
            where=driving.places.where("static", place, "deck_loads"),
            expected=", ".join(model.static_loads) or "a Nastran deck with load sets",
            fix=suggest(name, model.static_loads),
        )
    loads = model.static_loads[name]
    if loads.flaw is not None:
        raise loads.flaw
    return loads


def loads_taken(model: Model, driving: Driving) -> Iterator[tuple[int, StaticLoads]]:
    """Place of each [[static]] table that names loads of the deck, and these."""
    for k in range(len(driving.statics)):
        loads = deck_loads(model, driving, k)
        if loads is not None:
            yield k, loads


def freed_where_moved(model: Model, driving: Driving) -> Model:
    """The model without the supports at dofs that loads of the deck move: they hold them at another place."""
    labels = [m.labels for _, loads in loads_taken(model, driving) for m in loads.moved]
    if not labels:
        return model
    freed = np.unique(np.concatenate(labels))
    return replace(model, fixed=without(model.fixed, freed))
