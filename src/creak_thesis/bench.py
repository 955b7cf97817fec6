"""The doors of the thesis, each set up once: model, unreduced System, channels."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path

from creak import Bench, change_study, make_bench, make_study
from creak_thesis.door import LOADS, write_door
from creak_thesis.plan import CHECKED_BY, SCHEME, Setting

Progress = Callable[[str, int, int], None]
AMPLITUDE = "excitation.hinge.signal.amplitude"


class Benches:
    """Doors of one mesh size; a variant is set up when it is first asked for."""

    def __init__(self, mesh_size: float, folder: Path, progress: Progress) -> None:
        self.mesh_size, self._folder, self._progress = mesh_size, folder, progress
        self._made: dict[str, Bench] = {}

    def of(self, variant: Setting, others: Mapping[str, Setting]) -> Bench:
        """The variant set up; `others` by name, for those whose pre-check is taken over."""
        if variant.name not in self._made:
            source = self.of(others[variant.channels_of], others) if variant.channels_of else None
            self._made[variant.name] = self._set_up(variant, source)
        return self._made[variant.name]

    def _set_up(self, variant: Setting, source: Bench | None) -> Bench:
        hooks = "" if variant.hook_play is None else "_play"
        folder = self._folder / f"door_{self.mesh_size:g}mm_{variant.coarsen}{hooks}"
        write_door(self.mesh_size, folder, variant.coarsen, hook_play=variant.hook_play)
        own = {AMPLITUDE: LOADS[CHECKED_BY], **SCHEME, **variant.changes}
        tables = tomllib.loads((folder / "door.toml").read_text(encoding="utf-8"))
        tables["time"].pop("accuracy", None)  # the thesis forces its own step
        study = change_study(make_study(tables, folder), own)
        return make_bench(study, self._progress, at=None if source is None else source.positions)


def under(bench: Bench, load: str) -> Bench:
    """The bench with another load."""
    return bench.under({AMPLITUDE: LOADS[load]})
