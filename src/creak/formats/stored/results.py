"""results.h5: time histories with units and axes as attributes; complete or absent."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from creak.arrays import FloatArray, IntArray, SingleArray
from creak.errors import InputError, suggest
from creak.formats.deck.command_files import plain_file
from creak.formats.stored.run_identity import RESULTS, SUMMARY, identity_in, identity_of, of_two_runs
from creak.formats.stored.sealed import Damaged, Hdf5, hdf5_file, read_sealed
from creak.formats.stored.tree import BIG, COMPRESSED
from creak.model.units import UNITS, Units

MEAN = "mean over the output interval around each time, so that the sum times the interval keeps the integral"
PEAK = "largest normal force within the output interval around each time, raw: see normal_force for its mean"
BLOCK = 4_000_000
"""Numbers copied at a time."""


def require_run(path: Path, run: str, runs: Iterable[str]) -> None:
    """Check that a results.h5 with these runs has the one that is asked for.

    Raises
    ------
    InputError : it has not.
    """
    if run not in (known := list(runs)):
        raise InputError(f"{path} has no run {run!r}", fix=suggest(run, known))


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
class ContactRecord:
    """Contact quantities at full resolution, kept at the instants near contact; copied block by block when written."""

    rows: IntArray
    """(n_near,) instants that are stored, numbered from the start of the run."""
    time: FloatArray
    """(n_time,) all instants of the run."""
    channels: IntArray
    """(n_touched,) channels that pressed at some time."""
    gap: FloatArray
    """(n_time, n_channel)"""
    force: FloatArray
    """(n_time, n_channel)"""
    rubbing: IntArray
    """(n_rub,) channels that rub."""
    tangential: FloatArray
    """(n_time, 2 n_rub)"""
    sliding: FloatArray
    """(n_time, 2 n_rub)"""


@dataclass(frozen=True)
class LineRecord:
    """Relative motion at the points of E-lines over the verification window."""

    time: FloatArray
    """(k,) s, evenly spaced."""
    motion: SingleArray
    """(k, n_point, 3) along x, y, z of each point, length."""
    names: Sequence[str]
    node_ids: IntArray
    """(n_point,) label of the secondary node."""


@dataclass(frozen=True)
class RunRecord:
    """Arrays of one run as they are stored."""

    time: FloatArray
    """(n_out,)"""
    gap: FloatArray
    """(n_out, n_channel)"""
    normal_force: FloatArray
    """(n_out, n_channel) means over the output intervals."""
    peak_force: FloatArray
    """(n_out, n_channel) largest values within the output intervals."""
    slip: FloatArray
    """(n_out, n_channel)"""
    friction_force: FloatArray
    """(n_out, 2 n_rub) means over the output intervals; no columns without friction."""
    slip_speed: FloatArray
    """(n_out, 2 n_rub) means over the output intervals."""
    contact: ContactRecord
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
    elines: LineRecord | None = None


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """While results are read: one message for a file that is not there, is cut short, or is something else.

    Raises
    ------
    InputError : instead of what h5py and the reading of a tree raise.
    """
    try:
        plain_file(path)
    except OSError as error:
        missing, file = isinstance(error, FileNotFoundError | NotADirectoryError), path.parent.is_file()
        raise InputError(
            f"no such results: {path.parent if file else path}" if missing else f"cannot read {path}: {error.strerror}",
            expected="what creak run wrote: summary.json and results.h5 in one folder",
            fix=f"Give the folder, {path.parent.parent}." if file else "Check the path.",
        ) from error
    try:
        yield
    except (OSError, LookupError, TypeError, ValueError, ArithmeticError, RuntimeError, AttributeError) as error:
        why = f" ({error})" if isinstance(error, Damaged) else ""
        raise InputError(
            f"{path} is cut short or damaged{why}", expected="a file as creak run writes it", fix="Run the study again."
        ) from error


def check_beside(path: Path, file: h5py.File) -> None:
    """Check that the summary.json beside a results.h5, where there is one, is of the same run.

    Raises
    ------
    InputError : it is not, or cannot be read.
    """
    text = path.with_name(SUMMARY)
    if path.name != RESULTS or not text.is_file():
        return
    with reading(text):
        beside = identity_of(read_sealed(text))
    if beside != identity_in(file):
        raise of_two_runs(path.parent)


def put_results(
    partial: Path,
    runs: Mapping[str, RunRecord],
    attributes: Mapping[str, str],
    units: str,
    more: Callable[[h5py.File], None] | None = None,
) -> None:
    """Write all runs to one HDF5 file.

    Parameters
    ----------
    more : writes what else belongs into the file.
    """
    with hdf5_file(partial) as out:
        out.file.attrs.update(attributes)
        for name, run in runs.items():
            _write_run(out, out.file.create_group(f"runs/{name}"), run, UNITS[units])
        if more is not None:
            more(out.file)


def _write_run(out: Hdf5, group: h5py.Group, run: RunRecord, unit: Units) -> None:
    length, force = unit.length, unit.force
    _put(group, "time", run.time, unit.time, "time")
    _put(group, "gap", run.gap, length, "time, channel")
    _put(group, "normal_force", run.normal_force, force, "time, channel", MEAN)
    _put(group, "peak_force", run.peak_force, force, "time, channel", PEAK)
    _put(group, "slip", run.slip, length, "time, channel")
    _put(group, "displacement", run.displacement, f"{length} (X Y Z), rad (RX RY RZ)", "time, node, dof")
    _put(group, "node_ids", run.node_ids, "", "node")
    _put(group, "energy", run.energy, unit.energy, "time, term")
    group["energy"].attrs["terms"] = list(run.energy_terms)
    _put_names(group, "node_names", run.node_names)
    _put_names(group, "channels", run.channels)
    _put(group, "channel_nodes", run.channel_nodes, "", "channel")
    if run.contact.rubbing.size:
        rub, axes = run.contact.rubbing, "time, rubbing channel, tangent"
        _put(group, "rubbing_channels", rub, "", "rubbing channel", "columns of gap and normal_force that rub")
        for name, data, label in (
            ("friction_force", run.friction_force, force),
            ("slip_speed", run.slip_speed, f"{length}/{unit.time}"),
        ):
            _put(group, name, data.reshape(data.shape[0], rub.size, 2), label, axes, MEAN)
    _write_contact(group.create_group("contact"), run.contact, unit)
    if run.field is not None:
        _write_field(out, group.create_group("field"), run.field, unit)
    if run.elines is not None:
        _write_lines(group.create_group("elines"), run.elines, unit)


def _put_names(group: h5py.Group, name: str, names: Sequence[str]) -> None:
    group.create_dataset(name, data=np.array(list(names), dtype=object), dtype=h5py.string_dtype())


def _write_lines(group: h5py.Group, lines: LineRecord, unit: Units) -> None:
    _put(group, "time", lines.time, unit.time, "time")
    _put(group, "motion", lines.motion, unit.length, "time, point, axis", "axes x, y, z of each point; z opens the gap")
    _put_names(group, "points", lines.names)
    _put(group, "node_ids", lines.node_ids, "", "point")


def _write_contact(group: h5py.Group, c: ContactRecord, unit: Units) -> None:
    group.attrs["content"] = "every instant near contact, steps uneven where they are shorter there"
    _put(group, "time", c.time[c.rows], unit.time, "time")
    _put(group, "instant", c.rows, "", "time", "number of the instant in the run; a jump is time without contact")
    _put(group, "channel", c.channels, "", "channel", "columns of the run's gap and normal_force that touched")
    speed = f"{unit.length}/{unit.time}"
    _put_rows(group, "gap", c.gap, c.rows, c.channels, unit.length, "time, channel")
    _put_rows(group, "force", c.force, c.rows, c.channels, unit.force, "time, channel")
    if c.rubbing.size:
        columns, axes = np.arange(2 * c.rubbing.size), "time, two tangents of each rubbing channel in turn"
        _put(group, "rubbing_channels", c.rubbing, "", "rubbing channel")
        _put_rows(group, "tangential", c.tangential, c.rows, columns, unit.force, axes)
        _put_rows(group, "sliding", c.sliding, c.rows, columns, speed, axes)


def _put_rows(
    group: h5py.Group, name: str, data: FloatArray, rows: IntArray, columns: IntArray, unit: str, axes: str
) -> None:
    """Some rows and columns of a large array, copied a bounded number at a time."""
    shape = (rows.size, columns.size)
    dataset = group.create_dataset(name, shape, dtype="f8", **(COMPRESSED if rows.size * columns.size > BIG else {}))
    dataset.attrs["unit"], dataset.attrs["axes"] = unit, axes
    few = max(1, BLOCK // max(columns.size, 1))
    for k in range(0, rows.size if columns.size else 0, few):
        dataset[k : k + few] = data[np.ix_(rows[k : k + few], columns)]


def _write_field(out: Hdf5, group: h5py.Group, field: Field, unit: Units) -> None:
    _put(group, "time", field.time, unit.time, "time")
    _put(group, "node_ids", field.node_ids, "", "node")
    _put(group, "coordinates", field.coords, unit.length, "node, axis")
    n = field.node_ids.size
    motion = group.create_dataset("displacement", (field.time.size, n, 3), dtype="f8", chunks=(1, n, 3))
    motion.attrs["unit"], motion.attrs["axes"] = unit.length, "time, node, axis"
    for here, block in field.blocks:
        motion[here] = block
        out.check(motion.dtype.itemsize * 3 * n * (field.time.size - here.stop))


def _put(
    group: h5py.Group, name: str, data: FloatArray | IntArray | SingleArray, unit: str, axes: str, note: str = ""
) -> None:
    dataset = group.create_dataset(name, data=data, **(COMPRESSED if data.size > BIG else {}))
    dataset.attrs["unit"] = unit
    dataset.attrs["axes"] = axes
    if note:
        dataset.attrs["note"] = note
