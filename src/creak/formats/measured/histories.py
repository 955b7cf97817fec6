"""The time histories of results.h5: watched nodes and gap channels, as CSV and as functions of a universal file."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.formats.complete_file import complete_file
from creak.formats.measured.csv_rows import plain_row
from creak.formats.measured.uff import DISPLACEMENT, REACTION_FORCE, Function, write_functions
from creak.formats.stored.results import check_beside, reading, require_run
from creak.formats.stored.sealed_hdf5 import Damaged, opened_hdf5
from creak.model.units import UNITS, UnitsName

AXES = ("X", "Y", "Z", "RX", "RY", "RZ")


@dataclass(frozen=True)
class Histories:
    """One run at its output times."""

    run: str
    units: UnitsName
    time: FloatArray
    """(n_time,) s, evenly spaced."""
    node_ids: IntArray
    node_names: tuple[str, ...]
    displacement: FloatArray
    """(n_time, n_node, 6) X Y Z RX RY RZ of the watched nodes."""
    channels: tuple[str, ...]
    channel_nodes: IntArray
    """(n_channel,) label of the secondary node."""
    gap: FloatArray
    """(n_time, n_channel)"""
    normal_force: FloatArray
    """(n_time, n_channel)"""


def read_histories(path: Path, run: str | None = None) -> Histories:
    """The histories that a results.h5 holds.

    Parameters
    ----------
    run : reduced or reference; None: the reduced one where there are both.

    Raises
    ------
    InputError : the file is missing or not whole, or has no such run.
    """
    with reading(path), opened_hdf5(path) as file:
        check_beside(path, file)
        names = [str(name) for name in file["runs"]]
        if run is None:
            run = "reduced" if "reduced" in names else next(iter(names), "")
        require_run(path, run, names)
        group = file["runs"][run]
        names_of_nodes, channels = (tuple(map(str, group[key].asstr()[()])) for key in ("node_names", "channels"))
        found = Histories(
            run,
            file.attrs["units"],
            group["time"][()],
            group["node_ids"][()],
            names_of_nodes,
            group["displacement"][()],
            channels,
            group["channel_nodes"][()],
            group["gap"][()],
            group["normal_force"][()],
        )
        _check(found)
        return found


def _check(h: Histories) -> None:
    """Raise Damaged where the arrays do not fit each other."""
    n, nodes, channels = h.time.size, len(h.node_names), len(h.channels)
    shapes = {
        "time": (h.time, (n,)),
        "node_ids": (h.node_ids, (nodes,)),
        "displacement": (h.displacement, (n, nodes, 6)),
        "channel_nodes": (h.channel_nodes, (channels,)),
        "gap": (h.gap, (n, channels)),
        "normal_force": (h.normal_force, (n, channels)),
    }
    wrong = [key for key, (array, shape) in shapes.items() if array.shape != shape or array.dtype.kind not in "iuf"]
    if wrong:
        raise Damaged(f"{wrong[0]} does not fit the other arrays")
    if not np.isfinite(h.time).all() or (np.diff(h.time) <= 0.0).any() or h.units not in UNITS:
        raise Damaged("its time does not increase, or its units are not known")


def write_csv(histories: Histories, out: Path) -> None:
    """A row for each time: time, the six displacements of each watched node, gap and normal force of each channel.

    The head names each column and its unit. Numbers have all their digits.
    """
    unit, h = UNITS[histories.units], histories
    length, force = unit.length, unit.force
    units = [length] * 3 + ["rad"] * 3
    head = ["time [s]"]
    head += [f"{name} {axis} [{u}]" for name in h.node_names for axis, u in zip(AXES, units, strict=True)]
    head += [f"{name} gap [{length}]" for name in h.channels]
    head += [f"{name} normal force [{force}]" for name in h.channels]
    n = h.time.size
    table = np.concatenate([h.time[:, None], h.displacement.reshape(n, -1), h.gap, h.normal_force], axis=1)
    with complete_file(out) as partial, partial.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(plain_row(head))
        writer.writerows(table.tolist())


def write_universal(histories: Histories, out: Path) -> None:
    """Data sets 58: the translations of the watched nodes and the normal force of each channel over time."""
    write_functions(out, histories.time, _functions(histories), histories.units)


def _functions(h: Histories) -> Iterator[Function]:
    """Forces carry no direction: they act along the normal of the contact."""
    length, force = UNITS[h.units].length, UNITS[h.units].force
    for k, (label, name) in enumerate(zip(h.node_ids.tolist(), h.node_names, strict=True)):
        for axis in range(3):
            title = f"{h.run} run: displacement {AXES[axis]} of {name}"
            yield Function(title, label, axis + 1, DISPLACEMENT, "Displacement", length, h.displacement[:, k, axis])
    for k, (label, name) in enumerate(zip(h.channel_nodes.tolist(), h.channels, strict=True)):
        title = f"{h.run} run: normal force of {name}"
        yield Function(title, label, 0, REACTION_FORCE, "Normal force", force, h.normal_force[:, k])
