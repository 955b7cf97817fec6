"""How a study asks to be reduced: what, and what meets it; by which table and sets, and up to which frequencies."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.gap_operator import GapOperator
from creak.errors import InputError, suggest
from creak.formats.deck.command_files import plain_file
from creak.linalg.modes import BAND, with_further
from creak.model.dofs import node_dofs
from creak.model.mesh import Model
from creak.studies.file.case import Driving
from creak.studies.file.config import ReductionTable
from creak.studies.file.places import Places
from creak.studies.prepare.elines import Elines
from creak.studies.prepare.structure import Structure
from creak.studies.prepare.watched import watched_labels


@dataclass(frozen=True)
class Band:
    """Frequencies up to which parts and their assembly have modes, Hz."""

    first: float
    """[reduction] f_max; of "auto" the one that it begins with."""
    raised: int
    """How often "auto" has gone half as high again."""
    auto: bool
    """Whether f_max follows from what more modes change."""
    further: bool
    """Whether a reduction computes further modes at once: what the run with more modes takes."""
    excited: float
    """Highest frequency that the excitations are known to hold; 0: none is known."""
    assembly: float
    """Up to which modes of the assembly are looked at."""
    damped: float | None
    """Up to which modal damping needs them at least; None: there is none."""

    @property
    def f_max(self) -> float:
        """Up to which each part has all its modes."""
        return self.first * BAND**self.raised

    def raised_to(self, times: int) -> Band:
        """The same with f_max raised so often."""
        return replace(self, raised=times)

    def kept_modes(self, omega2: FloatArray) -> int:
        """How many of these a reduction keeps: those below f_max, and the further ones each time that it was raised."""
        kept = 0
        for k in range(self.raised + 1):
            below = int(np.count_nonzero(omega2 <= (2.0 * np.pi * self.first * BAND**k) ** 2))
            kept = with_further(kept, below) if k else below
        return min(kept, omega2.size)


@dataclass(frozen=True)
class Reduction:
    """What is reduced, and how: as [reduction] says, with the band that follows from it."""

    structure: Structure
    exterior: Exterior
    table: ReductionTable
    band: Band
    driving: Driving


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


@dataclass(frozen=True)
class Watch:
    """What is watched of the motion."""

    pairs: IntArray
    """(n_pair, 2) node rows: main, secondary."""
    nodes: IntArray
    """Node rows whose motion is kept."""
    lines: Elines
    """Points between parts whose relative motion is looked at."""


@dataclass(frozen=True)
class Exterior:
    """Where something outside of a part acts on it or looks at it; links, supports and superelements are the
    structure's."""

    forces: tuple[IntArray, ...]
    """Of each force, the physical dofs that it acts on."""
    connectors: IntArray
    """Those of the connectors' channels."""
    contacts: GapOperator
    """Channels of the contact pairs, before the pre-check."""
    watch: Watch

    def seen(self, model: Model) -> IntArray:
        """Physical dofs that a run writes down or looks at, whatever channels are kept."""
        every = [node_dofs(self.watch.nodes), watched_labels(model, self.contacts), self.watch.lines.points.labels]
        return np.unique(np.concatenate(every)).astype(np.int64)
