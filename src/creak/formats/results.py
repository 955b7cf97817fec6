"""results.h5: time histories with units and axes as attributes; complete or absent."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.formats.complete_file import complete_file

UNITS = {
    "mm-t-s": {"length": "mm", "force": "N", "energy": "mJ", "time": "s"},
    "m-kg-s": {"length": "m", "force": "N", "energy": "J", "time": "s"},
}


@dataclass(frozen=True)
class Field:
    """Motion of all nodes, produced block by block while it is written."""

    time: FloatArray
    """(n_field,)"""
    blocks: Iterator[tuple[slice, FloatArray]]
    """(instants, (k, n_node, 3) translations)."""
    node_ids: IntArray
    coords: FloatArray
    """(n_node, 3)"""


@dataclass(frozen=True)
class RunRecord:
    """Arrays of one run as they are stored."""

    time: FloatArray
    """(n_out,)"""
    gap: FloatArray
    """(n_out, n_channel)"""
    normal_force: FloatArray
    """(n_out, n_channel)"""
    slip: FloatArray
    """(n_out, n_channel)"""
    displacement: FloatArray
    """(n_out, n_node, 6)"""
    node_ids: IntArray
    """(n_node,) labels of the deck."""
    node_names: Sequence[str]
    channels: Sequence[str]
    channel_nodes: IntArray
    """(n_channel,) label of the secondary node."""
    energy: FloatArray
    """(n_out, n_term)"""
    energy_terms: Sequence[str]
    field: Field | None = None


def write_results(path: Path, runs: Mapping[str, RunRecord], attributes: Mapping[str, str], units: str) -> None:
    """Write all runs to one HDF5 file, first under a temporary name, then renamed."""
    with complete_file(path) as partial, h5py.File(partial, "w") as file:
        for key, value in attributes.items():
            file.attrs[key] = value
        for name, run in runs.items():
            _write_run(file.create_group(f"runs/{name}"), run, UNITS[units])


def _write_run(group: h5py.Group, run: RunRecord, unit: Mapping[str, str]) -> None:
    length, force = unit["length"], unit["force"]
    _put(group, "time", run.time, unit["time"], "time")
    _put(group, "gap", run.gap, length, "time, channel")
    _put(group, "normal_force", run.normal_force, force, "time, channel")
    _put(group, "slip", run.slip, length, "time, channel")
    _put(group, "displacement", run.displacement, f"{length} (X Y Z), rad (RX RY RZ)", "time, node, dof")
    _put(group, "node_ids", run.node_ids, "", "node")
    _put(group, "energy", run.energy, unit["energy"], "time, term")
    group["energy"].attrs["terms"] = list(run.energy_terms)
    text = h5py.string_dtype()
    group.create_dataset("node_names", data=np.array(list(run.node_names), dtype=object), dtype=text)
    group.create_dataset("channels", data=np.array(list(run.channels), dtype=object), dtype=text)
    _put(group, "channel_nodes", run.channel_nodes, "", "channel")
    if run.field is not None:
        _write_field(group.create_group("field"), run.field, unit)


def _write_field(group: h5py.Group, field: Field, unit: Mapping[str, str]) -> None:
    _put(group, "time", field.time, unit["time"], "time")
    _put(group, "node_ids", field.node_ids, "", "node")
    _put(group, "coordinates", field.coords, unit["length"], "node, axis")
    n = field.node_ids.size
    motion = group.create_dataset("displacement", (field.time.size, n, 3), dtype="f8", chunks=(1, n, 3))
    motion.attrs["unit"], motion.attrs["axes"] = unit["length"], "time, node, axis"
    for here, block in field.blocks:
        motion[here] = block


def _put(group: h5py.Group, name: str, data: FloatArray | IntArray, unit: str, axes: str) -> None:
    big = data.size > 10_000
    options = {"compression": "gzip", "compression_opts": 4, "shuffle": True} if big else {}
    dataset = group.create_dataset(name, data=data, **options)
    dataset.attrs["unit"] = unit
    dataset.attrs["axes"] = axes
