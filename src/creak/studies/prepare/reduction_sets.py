"""The sets that [reduction] names, looked up before anything is built."""

from __future__ import annotations

from creak.arrays import IntArray
from creak.errors import InputError, suggest
from creak.formats.deck.command_files import plain_file
from creak.model.mesh import Model
from creak.studies.file.config import ReductionTable
from creak.studies.file.places import Places


def check_reduction(model: Model, table: ReductionTable, places: Places) -> None:
    """Refuse sets that do not exist, and a coarse deck that is not there.

    Raises
    ------
    InputError : with the key and the names that there are.
    """
    for key, names in (("substructures", table.substructures), ("unreduced", table.unreduced)):
        for name in names:
            reduction_set(model, key, name, places)
    for name in table.retained_sets:
        model.node_set(name, where=places.where("reduction", "retain"))
    coarse = table.interface.deck
    if table.interface.type == "coarse-mesh" and coarse is not None:
        where = places.where("reduction", "interface")
        try:
            plain_file(places.sibling(coarse), where)
        except OSError as error:
            raise InputError(
                f"there is no deck {places.sibling(coarse)}", where=where, fix="Check the path."
            ) from error


def reduction_set(model: Model, key: str, name: str, places: Places) -> IntArray:
    """(n, 2) block and row of the elements of a set that [reduction] `key` names.

    Raises
    ------
    InputError : there is no such set, or it is empty.
    """
    found = model.element_sets.get(name.upper())
    if found is None or found.size == 0:
        raise InputError(
            f"unknown or empty element set {name!r}",
            where=places.where("reduction", key),
            fix=suggest(name, model.element_sets),
        )
    return found
