"""The doors of the thesis, each set up once: model, unreduced System, channels."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from creak.arrays import FloatArray, IntArray
from creak.contact.gap_operator import GapOperator, join
from creak.dynamics.scheme import Scheme
from creak.studies.file.changes import changed as with_changes
from creak.studies.file.config import StudyConfig
from creak.studies.file.reader import Study, read_study
from creak.studies.models.reference import ReferenceModel, build_reference
from creak.studies.prepare.excitation import sample_loads, time_axis
from creak.studies.prepare.setup import Setup, set_up
from creak.studies.run.forced_step import limited
from creak.studies.run.integrate import scheme_of
from creak.studies.run.precheck import precheck
from creak_thesis.door import LOADS, write_door
from creak_thesis.plan import CHECKED_BY, SCHEME, Variant

Progress = Callable[[str, int, int], None]
AMPLITUDE = "excitation.hinge.signal.amplitude"


@dataclass(frozen=True)
class Base:
    """One variant, ready to be reduced and run."""

    variant: Variant
    setup: Setup
    reference: ReferenceModel
    gaps: GapOperator
    checked: int
    """Channels before the pre-check."""

    @property
    def scheme(self) -> Scheme:
        return scheme_of(self.setup.study.config.time)

    def under(self, load: str) -> Setup:
        """The setup with another load."""
        study = changed(self.setup.study, {AMPLITUDE: LOADS[load]})
        loads = sample_loads(self.setup.model, study, time_axis(study))
        return replace(self.setup, study=study, loads=loads)


class Bench:
    """Doors of one mesh size; a variant is set up when it is first asked for."""

    def __init__(self, mesh_size: float, folder: Path, progress: Progress) -> None:
        self.mesh_size, self._folder, self._progress = mesh_size, folder, progress
        self._bases: dict[str, Base] = {}

    def base(self, variant: Variant, others: Mapping[str, Variant]) -> Base:
        """The variant set up; `others` by name, for those whose pre-check is taken over."""
        if variant.name not in self._bases:
            kept = None
            if variant.channels_of:
                source = self.base(others[variant.channels_of], others)
                kept = source.setup.model.nodes.coords[source.gaps.nodes_idx]
            self._bases[variant.name] = self._set_up(variant, kept)
        return self._bases[variant.name]

    def _set_up(self, variant: Variant, kept: FloatArray | None) -> Base:
        hooks = "" if variant.hook_play is None else "_play"
        folder = self._folder / f"door_{self.mesh_size:g}mm_{variant.coarsen}{hooks}"
        write_door(self.mesh_size, folder, variant.coarsen, hook_play=variant.hook_play)
        own = {AMPLITUDE: LOADS[CHECKED_BY], **SCHEME, **variant.changes}
        study = changed(read_study(folder / "door.toml"), own)
        setup = set_up(study)
        reference = build_reference(setup, self._progress)
        if kept is None:
            gaps, _ = precheck(setup, reference, scheme_of(study.config.time), self._progress)
        else:
            gaps = setup.contacts.select(at_positions(setup, kept))
        gaps, _ = limited(setup, reference, join([gaps, setup.connectors]))
        return Base(variant, setup, reference, gaps, setup.contacts.m)


def at_positions(setup: Setup, positions: FloatArray) -> IntArray:
    """Contact channels whose secondary node lies at one of the positions (k, 3)."""
    coords = setup.model.nodes.coords[setup.contacts.nodes_idx]
    away, _ = cKDTree(positions).query(coords)
    return np.flatnonzero(away < 1e-6 * np.ptp(coords)).astype(np.int64)


def changed(study: Study, changes: Mapping[str, Any]) -> Study:
    """The study with dotted keys set to other values.

    Raises
    ------
    InputError : a key on the way is no table.
    """
    data = with_changes(study.config.model_dump(exclude_unset=True), changes, None)
    return replace(study, config=StudyConfig.model_validate(data))
