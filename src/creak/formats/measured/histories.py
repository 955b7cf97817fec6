"""The time histories of results.h5: watched nodes, E-lines and gap channels, as CSV, universal file and punch file."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from creak.arrays import FloatArray, IntArray
from creak.formats.complete_file import complete_file
from creak.formats.measured.csv_rows import plain_row, unique_labels
from creak.formats.measured.punch import DISPLACEMENTS, MPCF, PointHistory, write_history_punch
from creak.formats.measured.uff import DISPLACEMENT, REACTION_FORCE, Function, write_functions
from creak.formats.stored.results import LineRecord, check_beside, reading, require_run
from creak.formats.stored.sealed import Damaged, opened_hdf5
from creak.model.units import UNITS, UnitsName

AXES = ("X", "Y", "Z", "RX", "RY", "RZ")
WATCHED, ELINES, CONTACTS = 1, 2, 3
"""Subcases of a punch file."""
OWN_TITLE = re.compile(r"\w+ run: (displacement (?P<axis>[XYZ])|(?P<what>relative [xyz]|normal force)) of (?P<name>.+)")


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
    """(n_time, n_channel) means over the output intervals."""
    peak_force: FloatArray
    """(n_time, n_channel) largest values within them."""
    title: str = ""
    """Of the study."""
    elines: LineRecord | None = None
    """None: the run has none, or was stored without their motion."""

    @property
    def renumbered(self) -> tuple[str, ...]:
        """What is numbered 1, 2, ... in a punch file, for several of its points are at one node."""
        ids = {"E-line points": () if self.elines is None else self.elines.node_ids, "contacts": self.channel_nodes}
        return tuple(what for what, nodes in ids.items() if np.unique(nodes).size < len(nodes))


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
            run=run,
            units=file.attrs["units"],
            time=group["time"][()],
            node_ids=group["node_ids"][()],
            node_names=names_of_nodes,
            displacement=group["displacement"][()],
            channels=channels,
            channel_nodes=group["channel_nodes"][()],
            gap=group["gap"][()],
            normal_force=group["normal_force"][()],
            peak_force=group["peak_force"][()],
            title=str(file.attrs.get("title", "")),
            elines=_lines(group["elines"]) if "elines" in group else None,
        )
        _check(found)
        return found


def _lines(group: h5py.Group) -> LineRecord:
    time, motion, ids = (group[name][()] for name in ("time", "motion", "node_ids"))
    return LineRecord(time, motion, tuple(map(str, group["points"].asstr()[()])), ids)


def _check(h: Histories) -> None:
    """Raise Damaged where the arrays do not fit each other."""
    n, nodes, channels = h.time.size, len(h.node_names), len(h.channels)
    shapes: dict[str, tuple[NDArray[Any], tuple[int, ...]]] = {
        "time": (h.time, (n,)),
        "node_ids": (h.node_ids, (nodes,)),
        "displacement": (h.displacement, (n, nodes, 6)),
        "channel_nodes": (h.channel_nodes, (channels,)),
        "gap": (h.gap, (n, channels)),
        "normal_force": (h.normal_force, (n, channels)),
        "peak_force": (h.peak_force, (n, channels)),
    }
    if h.elines is not None:
        k, points = h.elines.time.size, len(h.elines.names)
        shapes |= {
            "elines/time": (h.elines.time, (k,)),
            "elines/motion": (h.elines.motion, (k, points, 3)),
            "elines/node_ids": (h.elines.node_ids, (points,)),
        }
    wrong = [key for key, (array, shape) in shapes.items() if array.shape != shape or array.dtype.kind not in "iuf"]
    if wrong:
        raise Damaged(f"{wrong[0]} does not fit the other arrays")
    times = [h.time] if h.elines is None else [h.time, h.elines.time]
    if any(not np.isfinite(t).all() or (np.diff(t) <= 0.0).any() for t in times) or h.units not in UNITS:
        raise Damaged("its time does not increase, or its units are not known")


def write_csv(histories: Histories, out: Path) -> None:
    """A row for each time: time, the six displacements of each watched node, gap, mean and peak normal force of each
    channel.

    The head names each column and its unit. Numbers have all their digits.
    """
    unit, h = UNITS[histories.units], histories
    length, force = unit.length, unit.force
    units = [length] * 3 + ["rad"] * 3
    head = ["time [s]"]
    head += [f"{name} {axis} [{u}]" for name in h.node_names for axis, u in zip(AXES, units, strict=True)]
    head += [f"{name} gap [{length}]" for name in h.channels]
    head += [f"{name} {what} force [{force}]" for what in ("normal", "peak") for name in h.channels]
    n, forces = h.time.size, (h.normal_force, h.peak_force)
    table = np.concatenate([h.time[:, None], h.displacement.reshape(n, -1), h.gap, *forces], axis=1)
    with complete_file(out) as partial, partial.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(plain_row(head))
        writer.writerows(table.tolist())


def write_universal(histories: Histories, out: Path) -> None:
    """Data sets 58: translations of the watched nodes, relative motion of the E-lines, normal force of each channel."""
    write_functions(out, _functions(histories), histories.units)


def _functions(h: Histories) -> Iterator[Function]:
    """Directions of an E-line are those of its own frame: its name is that of the response. Forces carry no direction:
    they act along the normal of the contact."""
    length, force = UNITS[h.units].length, UNITS[h.units].force
    for k, (label, name) in enumerate(zip(h.node_ids.tolist(), h.node_names, strict=True)):
        for axis in range(3):
            title = f"{h.run} run: displacement {AXES[axis]} of {name}"
            moved = h.displacement[:, k, axis]
            yield Function(title, label, axis + 1, DISPLACEMENT, "Displacement", length, h.time, moved)
    for label, name, time, moved in _relative(h):
        for axis in range(3):
            title, line = f"{h.run} run: relative {AXES[axis].lower()} of {name}", name.partition(":")[0]
            yield Function(
                title=title,
                node=label,
                direction=axis + 1,
                kind=DISPLACEMENT,
                label="Relative motion",
                unit=length,
                time=time,
                values=moved[:, axis],
                entity=line,
            )
    for k, (label, name) in enumerate(zip(h.channel_nodes.tolist(), h.channels, strict=True)):
        title = f"{h.run} run: normal force of {name}"
        yield Function(title, label, 0, REACTION_FORCE, "Normal force", force, h.time, h.normal_force[:, k])


def own_name(title: str) -> str | None:
    """What a title of `write_universal` names, as the channels of a run are named: `LID.3 X`, `flange:3 normal force`,
    and `lid:7 relative x`, which is no motion of a node. None: another program wrote it."""
    match = OWN_TITLE.fullmatch(title)
    return None if match is None else f"{match['name']} {match['axis'] or match['what']}"


def _relative(h: Histories, *, unique: bool = False) -> Iterator[tuple[int, str, FloatArray, FloatArray]]:
    """Label of the node, name, times and relative motion (k, 3) of each point of an E-line.

    Parameters
    ----------
    unique : number them where labels repeat.
    """
    if h.elines is not None:
        labels = unique_labels(h.elines.node_ids) if unique else h.elines.node_ids
        for k, (label, name) in enumerate(zip(labels.tolist(), h.elines.names, strict=True)):
            yield label, name, h.elines.time, h.elines.motion[:, k].astype(np.float64)


def write_punch(histories: Histories, out: Path) -> None:
    """Points over time: `$DISPLACEMENTS` of the watched nodes (subcase 1) and, relative, of the E-lines (subcase 2),
    T1 T2 T3 along x, y, z of the point's own frame; `$MPCF` of the contacts (subcase 3), T3 the normal force.

    A point of an E-line or a contact has the label of its secondary node; where several are at one node
    (`Histories.renumbered`), all of that subcase are numbered 1, 2, ... in the order of results.h5. `$LABEL` names
    each.
    """
    unit = UNITS[histories.units]
    names = f"{unit.length}, {unit.force}, {unit.time}"
    write_history_punch(out, _point_histories(histories), title=histories.title, units=names)


def _point_histories(h: Histories) -> Iterator[PointHistory]:
    for k, (label, name) in enumerate(zip(h.node_ids.tolist(), h.node_names, strict=True)):
        told = f"{h.run} run: displacement of {name}"
        yield PointHistory(DISPLACEMENTS, WATCHED, label, told, h.time, h.displacement[:, k])
    for point, name, time, moved in _relative(h, unique=True):
        told = f"{h.run} run: relative x, y, z of {name}"
        yield PointHistory(DISPLACEMENTS, ELINES, point, told, time, np.pad(moved, ((0, 0), (0, 3))))
    for k, (point, name) in enumerate(zip(unique_labels(h.channel_nodes).tolist(), h.channels, strict=True)):
        force = np.pad(h.normal_force[:, k, None], ((0, 0), (2, 3)))
        yield PointHistory(MPCF, CONTACTS, point, f"{h.run} run: normal force of {name}", h.time, force)
