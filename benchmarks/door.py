"""The door as the benchmarks use it."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

from creak.contact.gap_operator import GapOperator
from creak.dynamics.scheme import HHT
from creak.studies.file.changes import with_changes
from creak.studies.file.reader import Study, read_study
from creak.studies.models.reduced import ReducedModel, reduce_model
from creak.studies.models.reference import ReferenceModel, build_reference
from creak.studies.prepare.setup import Setup, set_up
from creak.studies.run.integrate import limited
from creak.studies.run.precheck import prechecked, with_linear_gaps
from creak_thesis.door import write_door
from creak_thesis.plan import F_MAX

SCHEME = HHT(-0.05)


def silent(stage: str, done: int, total: int) -> None:
    """No progress: nothing may disturb the clock."""


@dataclass(frozen=True)
class Door:
    """A door, set up, with its channels after the pre-check."""

    setup: Setup
    reference: ReferenceModel
    gaps: GapOperator

    def reduced(self) -> ReducedModel:
        """Its Craig-Bampton model."""
        return reduce_model(self.setup.reduction, self.reference, self.gaps, silent)


def door_study(folder: Path) -> Study:
    """That of the door in a folder, with the modes of the thesis: what is timed and compared does not find its own."""
    return with_changes(read_study(folder / "door.toml"), {"reduction.f_max": F_MAX})


def door(mesh_size: float) -> Door:
    """Write, read and set up a door."""
    with tempfile.TemporaryDirectory() as folder:
        write_door(mesh_size, Path(folder))
        setup = set_up(door_study(Path(folder)))
    reference = build_reference(setup.structure, setup.band, silent)
    table = setup.study.config.precheck
    smallest = with_linear_gaps(table, setup.reduction, setup.marching, reference, silent).linear_gaps
    gaps, _ = prechecked(table, setup.contacts, smallest)
    return Door(setup, reference, limited(setup.marching, setup.model.nodes.coords, reference.system, gaps)[0])
