"""Sensors of a test on the nodes of a model: by label, by place or by a map, and whether units and axes fit."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.errors import InputError, suggest
from creak.formats.measured.modes import PER_METRE, Measured
from creak.model.mesh import Model
from creak.studies.design.named_nodes import node_labels
from creak.studies.file.tables import read_rows
from creak.studies.prepare.unit_check import across, likely_units

REACH = 0.02
"""Share of the model's size that a sensor may lie off its node, where elements are smaller: half a thickness, and how
well places are measured."""
BETWEEN = 0.75
"""Of the longest side of an element: the most that a point on the mesh is off the nearest node."""
SAME = 1e-3
"""Share of the model's size up to which a node and a sensor with one label are at one place."""
SMALL = 0.05
"""Share of the model's size below which the extent of all points asks for other units: round an origin that is on the
model points in m are on a model in mm."""
COVERED = (0.2, 1.1)
"""Of the model's size: extent of points in units that may be the right ones."""
BY_LABEL, BY_PLACE, BY_MAP = "label", "place", "map"


@dataclass(frozen=True)
class Sensors:
    """Where each channel of a test is on the model."""

    nodes_idx: IntArray
    """(n_channel,)"""
    points: FloatArray
    """(n_channel, 3) in the length of the model; those of the nodes where a map names them, or the file has none."""
    distance: FloatArray
    """(n_channel,) from point to node; 0 where the file has no points."""
    how: tuple[str, ...]
    """(n_channel,) `BY_LABEL`, `BY_PLACE` or `BY_MAP`."""
    scale: float
    """Length of the model in one of the test."""
    twins_idx: IntArray
    """(n_channel,) node of another part that is as near to a sensor as the one it was put on; -1: there is none."""
    choices: tuple[str, ...]
    """(n_channel,) `66 or 1009`: the node that was taken and its twin; empty where there is none."""
    units: str
    """Of the model where its materials leave them open."""
    test_units: str | None
    """Of the test where they were given, a key of `PER_METRE`."""


def locate(
    model: Model,
    measured: Measured,
    units: str = "mm-t-s",
    test_units: str | None = None,
    mapped: Mapping[str, int] = MappingProxyType({}),
) -> Sensors:
    """The node of each channel.

    Parameters
    ----------
    units, test_units : as `Sensors` has them; without those of the test its points are in what the file tells, or in
        those of the model.
    mapped : sensor -> row of a node, which goes before label and place.

    Raises
    ------
    InputError : a sensor without place whose label is no node; one too far from the model, with the units or axes that
        would fit.
    """
    scale = _scale(model, measured, units, test_units)
    points = measured.points * scale
    known: BoolArray = np.isfinite(points.sum(axis=1))
    labels = node_labels(model, np.arange(model.nodes.count))
    rows = np.array([mapped.get(s, labels.get(s.upper(), -1)) for s in measured.sensors], dtype=np.int64)
    by_map = np.array([s in mapped for s in measured.sensors])
    lost = ~known & (rows < 0)
    if lost.any():
        sensor = measured.sensors[int(lost.argmax())]
        raise InputError(
            f"sensor {sensor} has no place, and no node has its label",
            where=measured.path,
            expected="points (data sets 15 or 2411, columns x,y,z), or labels of nodes",
            fix="Name its node in a table with the columns sensor,node: --sensors FILE.csv.",
        )
    used, size = _used_nodes(model), across(model)
    nearest, off, twins = _near(model, used, points, known, SAME * size)
    away = np.linalg.norm(points - model.nodes.coords[rows], axis=1)
    by_label = ~by_map & (rows >= 0) & (~known | (away <= np.maximum(SAME * size, off * (1.0 + 1e-9))))
    by_place = ~by_map & ~by_label
    bad = by_place & (off > _reach(model, nearest, size))
    if bad.any():
        hint = next(_hints(model, points[known], scale, units), "")
        unit = likely_units(model, units).words[0]
        raise _off_the_model(model, measured, points, np.where(bad, off, 0.0), nearest, hint, unit)
    if by_place.any() and 0.0 < _span(points[known]) < SMALL * size:
        _require_size(model, measured, points[known], scale, units)
    rows = np.where(by_place, nearest, rows)
    distance = np.where(known, np.linalg.norm(points - model.nodes.coords[rows], axis=1), 0.0)
    how = np.where(by_map, BY_MAP, np.where(by_label, BY_LABEL, BY_PLACE)).tolist()
    shown = np.where((known & ~by_map)[:, None], points, model.nodes.coords[rows])
    twins = np.where(by_place, twins, -1)
    name = model.nodes.label
    choices = (f"{name(a)} or {name(b)}" if b >= 0 else "" for a, b in zip(rows.tolist(), twins.tolist(), strict=True))
    return Sensors(
        nodes_idx=rows,
        points=shown,
        distance=distance,
        how=tuple(how),
        scale=scale,
        twins_idx=twins,
        choices=tuple(choices),
        units=units,
        test_units=test_units,
    )


def read_sensor_map(path: Path | None, model: Model, measured: Measured) -> dict[str, int]:
    """Sensor -> node row of a CSV file with the header sensor,node; empty without a file.

    Raises
    ------
    InputError : no such file, wrong header; an unknown sensor or node, a sensor twice.
    """
    if path is None:
        return {}
    labels, found = node_labels(model, np.arange(model.nodes.count)), {}
    for line, row in read_rows(path, "--sensors", "table of sensors", ["sensor", "node"]):
        sensor, node = row[0].strip(), row[1].strip() if len(row) > 1 else ""
        where = f"{path}:{line}"
        if sensor not in measured.sensors:
            raise InputError(
                f"sensor {sensor!r} is not in {measured.path.name}", where=where, fix=suggest(sensor, measured.sensors)
            )
        if sensor in found:
            raise InputError(f"sensor {sensor!r} has a second row", where=where, fix="Remove one of them.")
        if node.upper() not in labels:
            raise InputError(f"unknown node {node!r}", where=where, expected="17, or FRAME-1.17 with instances")
        found[sensor] = labels[node.upper()]
    return found


def _scale(model: Model, measured: Measured, units: str, test_units: str | None) -> float:
    """Length of the model in one of the test."""
    per_metre = PER_METRE[test_units] if test_units is not None else measured.per_metre
    if per_metre is None:
        return 1.0
    return 1.0 / (likely_units(model, units).length * per_metre)


def _used_nodes(model: Model) -> IntArray:
    used = [b.nodes_idx.ravel() for b in model.blocks]
    return np.unique(np.concatenate(used)) if used else np.arange(model.nodes.count)


def _near(
    model: Model, used: IntArray, points: FloatArray, known: BoolArray, beside: float
) -> tuple[IntArray, FloatArray, IntArray]:
    """Nearest node of an element and its distance, of points that are known; and a node of another part that is not
    farther by more than `beside`, -1 where there is none."""
    from scipy.spatial import cKDTree  # see `signals.spectra.low_pass`

    off, at = np.zeros(len(points)), np.zeros(len(points), dtype=np.int64)
    twins, where = np.full(len(points), -1, dtype=np.int64), np.flatnonzero(known)
    if not where.size:
        return used[at], off, twins
    tree, part = cKDTree(model.nodes.coords[used]), np.full(model.nodes.count, -1)
    for k, one in enumerate(model.parts):
        part[one.nodes_idx] = k
    off[where], at[where] = tree.query(points[where])
    for k, around in zip(where.tolist(), tree.query_ball_point(points[where], off[where] + beside), strict=True):
        others = used[around][part[used[around]] != part[used[at[k]]]]
        if others.size:
            twins[k] = others[np.linalg.norm(model.nodes.coords[others] - points[k], axis=1).argmin()]
    return used[at], off, twins


def _reach(model: Model, nodes_idx: IntArray, size: float) -> FloatArray:
    """(n,) how far a point may lie off its node."""
    side = np.zeros(model.nodes.count)
    for block in model.blocks:
        if block.nodes_idx.shape[1] > 1:
            corners = model.nodes.coords[block.nodes_idx]
            longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
            np.maximum.at(side, block.nodes_idx.ravel(), np.repeat(longest, block.nodes_idx.shape[1]))
    return np.asarray(np.maximum(REACH * size, BETWEEN * side[nodes_idx]))


def _off_the_model(
    model: Model, measured: Measured, points: FloatArray, off: FloatArray, nearest: IntArray, hint: str, length: str
) -> InputError:
    """The message for sensors that are off the model, `off` 0 for the others."""
    worst = int(off.argmax())
    few = len({s for s, d in zip(measured.sensors, off.tolist(), strict=True) if d})
    return InputError(
        f"{few} of {len(set(measured.sensors))} sensors are not on the model: sensor {measured.sensors[worst]} at "
        f"{_words(points[worst])} is {off[worst]:.3g} {length} from its nearest node, "
        f"{model.nodes.label(int(nearest[worst]))}",
        where=measured.path,
        expected="points on the model, in its axes",
        fix=hint
        or "Correct their places, or name their nodes in a table with the columns sensor,node: --sensors FILE.csv.",
    )


def _hints(model: Model, points: FloatArray, scale: float, units: str) -> Iterator[str]:
    """Units, a turn or a shift that puts the points on the model."""
    coords = model.nodes.coords[_used_nodes(model)]

    def on_model(x: FloatArray) -> bool:
        return bool(_distances(model, x).max() <= REACH * across(model))

    length = likely_units(model, units).words[0]
    if unit := _fitting_unit(model, points, scale, units):
        spans = f"The points span {_span(points):.3g} {length}, the model {across(model):.3g} {length}"
        yield f"{spans}, and they fit {unit}."
    ends = np.stack([coords.min(axis=0) - points.min(axis=0), coords.max(axis=0) - points.max(axis=0)])
    for weights in itertools.product((0.5, 0.0, 1.0), repeat=3):  # middles, lower or upper ends at one place
        shift = ends[0] + np.array(weights) * (ends[1] - ends[0])
        if on_model(points + shift):
            yield f"They fit moved by {_words(shift)} {length}: give places from the origin of the deck."
    for order in itertools.permutations(range(3)):
        for signs in itertools.product((1.0, -1.0), repeat=3):
            turn = np.array(signs)[:, None] * np.eye(3)[list(order)]
            if np.linalg.det(turn) > 0.0 and on_model(points @ turn.T):
                axes = ", ".join(("-" if s < 0.0 else "") + "xyz"[k] for s, k in zip(signs, order, strict=True))
                yield f"They fit with their {axes} as x, y, z of the deck: turn points and directions in the file."


def _span(points: FloatArray) -> float:
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def _require_size(model: Model, measured: Measured, points: FloatArray, scale: float, units: str) -> None:
    """Raise InputError where points lie together on a spot, and all over the model in other units."""
    if unit := _fitting_unit(model, points, scale, units):
        length = likely_units(model, units).words[0]
        raise InputError(
            f"all sensors are on one spot of the model: their points span {_span(points):.3g} {length}, the model "
            f"{across(model):.3g} {length}",
            where=measured.path,
            expected="points in the units of the deck",
            fix=f"They fit {unit}.",
        )


def _fitting_unit(model: Model, points: FloatArray, scale: float, units: str) -> str:
    """`times 25.4: say --test-units in`, of the units that put the points on the model best; empty: none does."""
    size, found = across(model), []
    for a, b in itertools.permutations(PER_METRE, 2):
        factor = PER_METRE[a] / PER_METRE[b]
        if COVERED[0] <= factor * _span(points) / size <= COVERED[1]:
            off = _distances(model, points * factor).max()
            if off <= REACH * size:
                found.append((off, factor))
    if not found:
        return ""
    factor = min(found)[1]
    return f"times {factor:.6g}: say --test-units {_unit(factor * scale, model, units)}"


def _distances(model: Model, points: FloatArray) -> FloatArray:
    """(n,) from each point to the nearest node of an element."""
    from scipy.spatial import cKDTree  # see `signals.spectra.low_pass`

    return np.asarray(cKDTree(model.nodes.coords[_used_nodes(model)]).query(points)[0])


def _unit(scale: float, model: Model, units: str) -> str:
    """The unit of a test of which one length is so many of the model's."""
    return min(PER_METRE, key=lambda name: abs(math.log(scale * PER_METRE[name] * likely_units(model, units).length)))


def _words(x: FloatArray) -> str:
    return f"({', '.join(f'{value:.4g}' for value in x)})"
