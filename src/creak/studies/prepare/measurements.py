"""The measurements of a study, [test.NAME]: what their files hold, and where it is on the model."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from creak.arrays import IntArray
from creak.errors import InputError, suggest
from creak.formats.measured.files import is_measured, read_channels
from creak.formats.measured.histories import AXES, own_name
from creak.formats.measured.mode_files import ModalTest, is_of_modes, read_measured_modes, read_universal
from creak.formats.measured.modes import Channel, Measured, MeasuredFrfs, MeasuredModes
from creak.formats.measured.unit_words import name_and_unit, plain_unit
from creak.formats.wav import read_wav
from creak.model.mesh import Model
from creak.signals.between_samples import even_step
from creak.studies.design.named_nodes import node_labels
from creak.studies.file.excitation_tables import MeasuredTable
from creak.studies.file.places import Places
from creak.studies.file.tables import Rows, header_of, read_header, read_lines, table_column
from creak.studies.prepare.sensors import Sensors, locate, read_sensor_map

TABLES = (".csv", ".txt")
UNIVERSAL = (".unv", ".uff", ".u58", ".u55")
SHORT = 0.05
"""Share of the intervals of a table that may be shorter than its even step: rows that stand twice are no course."""
PER_ROW = 10
"""Even instants for each row of an uneven table."""
MOTION = re.compile(r"(?P<node>.+) (?P<axis>[xyz])", re.IGNORECASE)
OF_SOUND = re.compile(r"(?P<name>.+) pressure", re.IGNORECASE)
OF_CONTACT = re.compile(r"(?P<name>.+?)(:[^:]+)? (gap|force|normal force)", re.IGNORECASE)


@dataclass(frozen=True)
class Measurement:
    """A file of a test; at least one of the three is there."""

    name: str
    path: Path
    modes: tuple[MeasuredModes, Sensors] | None
    frfs: tuple[MeasuredFrfs, Sensors] | None
    channels: tuple[Channel, ...]
    """Time histories, under the names that the run gives what they measure."""
    nodes_idx: IntArray
    """Rows of the nodes whose motion is among these."""

    @property
    def contacts(self) -> frozenset[str]:
        """Names of the contacts and connectors whose gap or force is among these, in small letters."""
        return frozenset(m["name"].lower() for c in self.channels if (m := OF_CONTACT.fullmatch(c.name)))

    @property
    def top(self) -> float:
        """Hz, highest of its modes and functions; 0: it has neither."""
        tops = [0.0 if self.modes is None else float(self.modes[0].frequencies.max())]
        return max([*tops, *(float(f.freq[-1]) for f in ([] if self.frfs is None else self.frfs[0].functions))])


def read_measurements(
    model: Model,
    tables: Mapping[str, MeasuredTable],
    units: str,
    named: tuple[Sequence[str], Sequence[str]],
    places: Places,
) -> tuple[tuple[Measurement, ...], list[str]]:
    """The measurements, and notes on what of them is left out.

    Parameters
    ----------
    units : of the model. named : names of contacts and connectors; of listeners.

    Raises
    ------
    InputError : a file is wrong, its sensors are not on the model, or the run computes nothing of what it holds.
    """
    notes: list[str] = []
    labels: dict[str, int] = {}
    found = []
    for name, table in tables.items():
        one = _read(name, table, places)
        if one.channels and not labels:
            labels = node_labels(model, np.arange(model.nodes.count))
        path = None if table.sensors is None else places.sibling(table.sensors)
        modes = None if one.modes is None else (one.modes, _located(model, one.modes, units, path))
        frfs = None if one.frfs is None else (one.frfs, _located(model, one.frfs, units, path))
        channels = []
        for channel in one.channels:
            if _is_computed(labels, named, channel):
                channels.append(channel)
            else:
                notes.append(f"test {name}: channel {channel.name!r} is nothing that the run computes: it is left out")
        if one.channels and not channels and modes is None and frfs is None:
            raise _nothing_computed(name, one)
        moved = (match["node"].upper() for c in channels if (match := MOTION.fullmatch(c.name)))
        nodes = np.array([labels[node] for node in dict.fromkeys(moved)], dtype=np.int64)
        found.append(Measurement(name, one.path, modes, frfs, tuple(channels), nodes))
    return tuple(found), notes


def _nothing_computed(name: str, one: ModalTest) -> InputError:
    first = one.channels[0]
    heard = plain_unit(first.unit) == "pa"
    return InputError(
        f"the run computes none of its {len(one.channels)} channels, the first of which is {first.name!r}",
        where=one.path,
        expected='names as "1017 Z" (a node), "flange gap" or "flange force" (a contact), "ear pressure" (a listener)',
        fix=f'It is sound: say channels = {{ {json.dumps(first.name)} = "ear pressure" }}, or run the study, then '
        f"creak listen RESULTS --beside {one.path.name}."
        if heard
        else f'Say which is which: [test.{name}] channels = {{ {json.dumps(first.name)} = "1017 Z" }}.',
    )


def _located(model: Model, measured: Measured, units: str, path: Path | None) -> Sensors:
    return locate(model, measured, units, None, read_sensor_map(path, model, measured))


def record_channels(path: Path) -> Iterator[Channel]:
    """The time histories of a file: functions of time of a universal file, RPC III, or a table whose first column is
    time in s. Functions that tell node and direction have them as their name, `1017 Z`.

    Raises
    ------
    InputError : no such file; it is cut short, or not of its kind; it holds no channel.
    """
    if is_measured(path):
        channels = read_channels(path)
        if not channels:
            raise _holds_nothing(path, "it has no channel")
        yield from map(named_by_place, channels)
        return
    yield from table_channels(path, *read_header(path, "", "table"))


def table_channels(path: Path, header: list[str], rows: Rows) -> Iterator[Channel]:
    """Each column of a table that was read, over the first one, evenly sampled: as it is, or where its rows are uneven
    by a short interval (the quantile `SHORT` of all), at `PER_ROW` instants for each row at most.

    Raises
    ------
    InputError : no column beside that of the times, or as `table_column`.
    """
    if len(header) < 2:
        raise _holds_nothing(path, f"the table starts with {','.join(header) or 'nothing'}")
    for column in header[1:]:
        time, values = table_column(path, header, rows, column)
        name, unit = name_and_unit(column)
        if (even := even_step(time)) is not None:
            yield Channel(_plain(name), unit, float(time[0]), even, values)
            continue
        most = PER_ROW * (time.size - 1)
        step = max(float(np.quantile(np.diff(time), SHORT)), float(time[-1] - time[0]) / most)
        at = time[0] + step * np.arange(min(int((time[-1] - time[0]) / step + 0.5), most) + 1)
        yield Channel(_plain(name), unit, float(time[0]), step, np.interp(at, time, values))


def _holds_nothing(path: Path, got: str) -> InputError:
    return InputError(
        f"{got}: no time history, no mode, no frequency response function",
        where=path,
        expected="a table with a first line as time [ms],1017 Z [mm] and numbers below it, between commas, semicolons "
        "or tabs; or a file of a test with one channel at least",
        fix="Export it again.",
    )


def named_by_place(channel: Channel) -> Channel:
    """The channel under its node and direction, where it tells them; creak's own by title."""
    (node, direction), own = channel.at, own_name(channel.name)
    if own is not None or not node or not 1 <= direction <= 3:
        return replace(channel, name=_plain(own or channel.name))
    return replace(channel, name=f"{node} {AXES[direction - 1]}", at=(0, 0))


def _plain(name: str) -> str:
    return re.sub(r"\s+", " ", name.strip())


def _read(name: str, table: MeasuredTable, places: Places) -> ModalTest:
    path, where = places.sibling(table.file), places.where("test", name, "file")
    ending = Path(table.file).suffix.lower()
    if ending not in (*UNIVERSAL, *TABLES, ".wav") and not is_measured(Path(table.file)):
        raise InputError(
            f"[test.{name}] file = {table.file!r}",
            where=where,
            expected="a universal file (.unv, .uff), CSV, RPC III (.rsp, .drv) or WAV",
        )
    if not path.exists():
        raise InputError(f"no such file: {path}", where=where, fix="Check the path.")
    found = ModalTest(path)
    channels: Iterable[Channel]
    if ending in UNIVERSAL:
        found = read_universal(path)
        channels = map(named_by_place, found.channels)
    elif ending in TABLES:
        lines = read_lines(path, where, "file of a test")
        if is_of_modes(lines):
            return ModalTest(path, read_measured_modes(path))
        channels = table_channels(path, *header_of(lines, path))
    elif ending == ".wav":
        channels = _wav_channels(path, table, where)
    else:
        channels = record_channels(path)
    return replace(found, channels=_renamed(tuple(channels), table, name, places))


def _wav_channels(path: Path, table: MeasuredTable, where: str) -> Iterator[Channel]:
    sound = read_wav(path)
    scale = 1.0 if sound.full_scale is not None else table.full_scale
    if scale is None or (sound.full_scale is not None and table.full_scale is not None):
        raise InputError(
            f"{path.name} does not tell what its samples are"
            if scale is None
            else f"{path.name} tells itself that full scale is {sound.full_scale:.4g} Pa",
            where=where,
            expected="full scale in the file, or full_scale and unit in the study",
            fix='Add full_scale = 50.0 and unit = "m/s^2".' if scale is None else "Leave out full_scale and unit.",
        )
    columns = sound.samples.reshape(sound.samples.shape[0], -1).T
    for k, values in enumerate(columns, start=1):
        yield Channel(str(k), table.unit or "Pa", 0.0, 1.0 / sound.rate, scale * values)


def _renamed(channels: tuple[Channel, ...], table: MeasuredTable, name: str, places: Places) -> tuple[Channel, ...]:
    """The channels under the names that the table gives them."""
    names = {c.name.lower(): c.name for c in channels}
    given = dict[str, str]()
    for key, value in table.channels.items():
        whole, bare = (_plain(text).lower() for text in (key, name_and_unit(key)[0]))
        given[whole if whole in names else bare] = _plain(value)
        if whole not in names and bare not in names:
            raise InputError(
                f"{Path(table.file).name} has no channel {key!r}",
                where=places.where("test", name, "channels"),
                fix=suggest(key, list(names.values())),
            )
    return tuple(replace(c, name=given.get(c.name.lower(), c.name)) for c in channels)


def _is_computed(labels: Mapping[str, int], named: tuple[Sequence[str], Sequence[str]], channel: Channel) -> bool:
    if match := MOTION.fullmatch(channel.name):
        return match["node"].upper() in labels
    for pattern, names in zip((OF_CONTACT, OF_SOUND), named, strict=True):
        if match := pattern.fullmatch(channel.name):
            return match["name"].lower() in {name.lower() for name in names}
    return False
