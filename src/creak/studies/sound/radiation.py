"""From contact forces to a listener by the modes of a run: forces, sampled, with their work on the modes; panels by
Rayleigh's integral, compact bodies by their acceleration noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import scipy.sparse as sp

from creak.arrays import BoolArray, ComplexArray, FloatArray, IntArray, Matrix, to_dense
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator, join
from creak.dynamics.channels import channel_matrices
from creak.dynamics.diagonal import is_modal, modal_matrices
from creak.dynamics.history import History
from creak.model.dofs import TRANSLATIONS, node_dofs
from creak.model.skin import Skin
from creak.signals.spectra import cell_means
from creak.sound.acceleration_noise import acceleration_noise, equivalent_radius
from creak.sound.answering import Answering, CoupledModes, Modes, transfer
from creak.sound.forced import LOWEST, Gain, smooth, sound_of_forces, velocity_of_forces, without_lows
from creak.sound.head import Head
from creak.sound.rayleigh import AIR, PressureRows, equivalent_power, pressure_weights
from creak.sound.zwicker_tables import RATE
from creak.studies.sound.listeners import Listener
from creak.studies.sound.rims import product, without_wall
from creak.studies.sound.transfers import Transfer
from creak.verify.intervals import in_window

NO_GAPS = join([])


@dataclass(frozen=True)
class Source:
    """Forces of the channels that touched, less what rests on them: normal ones, then tangents."""

    modes: Answering
    force: FloatArray
    """(n, n_force) means over the intervals of 48 kHz."""
    channel: IntArray
    """(n_force,) the channel of each."""
    row: IntArray
    """(n_force,) of each into `channel_matrices`."""
    gaps: GapOperator = NO_GAPS
    """The channels; none where no contact makes the forces."""

    def groups(self, places: Sequence[IntArray]) -> list[IntArray]:
        """Columns of each place's channels; last those of all other channels."""
        own = [np.flatnonzero(np.isin(self.channel, place)) for place in places]
        rest = np.setdiff1d(np.arange(self.channel.size), np.concatenate([*own, np.zeros(0, dtype=np.int64)]))
        return [*own, rest]


def source_of(system: System, gaps: GapOperator, history: History) -> Source:
    """The forces of a run on its System, whose M and K are diagonal."""
    touched = np.flatnonzero((history.force > 0.0).any(axis=0)).astype(np.int64)
    rubbing = np.zeros(0, dtype=np.int64) if gaps.friction is None else gaps.friction.channels
    along = np.flatnonzero(np.repeat(np.isin(rubbing, touched), 2))
    n = max(2, int(np.floor((history.time[-1] - history.time[0]) * RATE * (1.0 + 1e-12))) + 1)
    at = np.minimum(history.time[0] + np.arange(n) / RATE, history.time[-1])
    resting = gaps.resting[touched]
    normal = cell_means(history.time, history.force[:, touched], at) - resting
    force = np.hstack([normal, cell_means(history.time, history.tangential[:, along], at)]) if along.size else normal
    row = np.concatenate([touched, gaps.m + along])
    channel = np.concatenate([touched, np.repeat(rubbing, 2)[along]])
    return Source(_modes(system, gaps, row), force, channel, row, gaps)


def on_system(source: Source, system: System) -> Source:
    """The same forces on another System of the structure, likewise."""
    return replace(source, modes=_modes(system, source.gaps, source.row))


def _modes(system: System, gaps: GapOperator, row: IntArray) -> Answering:
    return answering(system, to_dense(channel_matrices(system, gaps).rows[row]))


def answering(system: System, push: FloatArray) -> Answering:
    """A System with diagonal M and K under forces, their rows (n_force, n) on its coordinates."""
    if is_modal(system):
        return Modes(*modal_matrices(system), push)
    pairs = system.complex_modes
    return CoupledModes(pairs.blocks, pairs.basis, push @ pairs.push.T)


def of_modes(system: System, A: Matrix, labels: IntArray) -> FloatArray:
    """(k, n_mode) of combinations A (k, n_label) of the motion of dof labels; what is held does not move."""
    moves = np.isin(labels, system.labels)
    return to_dense(system.combined(sp.csr_matrix(sp.csr_matrix(A)[:, np.flatnonzero(moves)]), labels[moves])[0])


PER_BAND = 4.0
"""Samples per second of a listener's rows over the band: few, as each costs a back-substitution in every part."""
COMPACT, LARGE = 1.0, 2.0
"""Circumference of the sphere of a body's volume over the wavelength, ka, up to which it is heard as that sphere, and
from which on as faces in a wall. On its axis an oscillating sphere sends the same both ways within 1 dB in between."""
LONG = 2.0
"""Largest dimension of such a body over the diameter of that sphere, at most."""
SHARE = 1e-9
"""Of an area, below which it is round-off."""
CLOSED = 1e-6
"""Share of its area by which its faces may fail to close."""
SAMPLES = 24
"""Facets of each part that stand for all of it: its level within 1 dB or so."""
REFERENCE = 1e-12
"""W of 0 dB."""
NOTHING = 1e-9
"""Of the motion of the part that moves most, what round-off leaves of one that nothing joins to the contacts."""


@dataclass(frozen=True)
class Body:
    """A solid part that is heard as the sphere of its volume at frequencies at which it is compact."""

    part: int
    radius: float
    """m"""
    centre: FloatArray
    """(3,) m"""
    length: float
    """m, its largest dimension."""

    @property
    def highest(self) -> float:
        """Hz up to which it is compact."""
        return COMPACT * AIR.speed / (2.0 * np.pi * self.radius)

    def compact(self, freq: FloatArray) -> FloatArray:
        """Share of the sphere in what is heard of it at each frequency, Hz; the rest is that of faces in a wall."""
        return smooth((LARGE - COMPACT * freq / self.highest) / (LARGE - COMPACT))

    def large(self, freq: FloatArray) -> FloatArray:
        """Share of the faces."""
        return 1.0 - self.compact(freq)


@dataclass(frozen=True)
class Radiation:
    """What each mode's acceleration sends to one listener."""

    position: FloatArray
    """(3,) of the listener, m."""
    panels: PressureRows
    """Pa per unit of modal acceleration, row by row; they add up."""
    gains: tuple[Gain, ...]
    """Of each row."""
    bodies: tuple[Body, ...]
    moves: PressureRows | None
    """(n_body, 1, n_mode) mean motion of each body towards the listener, m; None without bodies."""
    band: float
    """Hz, up to which it holds."""
    head: Head | None = None
    """Around the position; None: nothing is there."""
    transfers: tuple[Transfer, ...] = ()
    """Measured ways from some of the parts."""

    def heard(self, body: Body, sent: FloatArray) -> FloatArray:
        """(n,) what is heard of what a body sends in the open."""
        way = next((one for one in self.transfers if one.part == body.part), None)
        sent = sent if way is None else without_lows(sent, RATE, way.gain)
        return sent if self.head is None else self.head.at_ear(sent, RATE, body.centre - self.position)


def radiation(system: System, listener: Listener, metre: float, band: float) -> Radiation:
    """What each mode's acceleration sends to a listener, up to the end of the band, Hz."""
    skin, position = listener.skin, listener.position * metre
    bodies = tuple(b for b in compact_bodies(skin, metre) if np.linalg.norm(position - b.centre) > b.length)
    sent = skin.toward(listener.position)
    alone = np.isin(skin.part, np.array([b.part for b in bodies], dtype=np.int64))
    plain = np.where(alone[:, None], 0.0, sent)
    rows: list[tuple[Gain, FloatArray]] = [(_all, plain.real)]
    if np.abs(plain.imag).max(initial=0.0) > SHARE * np.abs(plain).max(initial=0.0):
        rows.append((_quarter_turn, plain.imag))
    large = [b for b in bodies if b.large(np.array([band]))[0] > 0.0]
    rows += [(b.large, np.where((skin.part == b.part)[:, None], sent.real, 0.0)) for b in large]
    rows = without_wall(listener.rims, _measured(listener, rows))
    rows = [row for row in rows if row[1].any()] or rows[:1]
    if listener.head is not None:
        rows = _around(listener.head, rows, (skin.centres - listener.position) * metre)
    moves = None
    if bodies:
        own = [_towards(system, skin.select(skin.part == b.part), _unit(position - b.centre)) for b in bodies]
        moves = PressureRows(metre * np.stack(own), np.zeros(len(bodies), dtype=np.int64), float(RATE), band)
    known: dict[bytes, tuple[FloatArray, int]] = {}
    panels = [_panels(system, listener, areas, metre, band, known) for _, areas in rows]
    taps = max(w.shape[0] for w, _ in panels)
    filters = np.stack([np.pad(w, ((0, taps - w.shape[0]), (0, 0))) for w, _ in panels])
    start = np.array([start for _, start in panels])
    sheet = PressureRows(filters, start, PER_BAND * band, band)
    return Radiation(
        position, sheet, tuple(gain for gain, _ in rows), bodies, moves, band, listener.head, listener.transfers
    )


def _all(freq: FloatArray) -> FloatArray:
    return np.ones_like(freq)


def _quarter_turn(freq: FloatArray) -> ComplexArray:
    return np.full(freq.shape, 1j)


def _measured(listener: Listener, rows: Sequence[tuple[Gain, FloatArray]]) -> list[tuple[Gain, FloatArray]]:
    """Rows whose parts are heard as they were measured by themselves, behind those of all others."""
    part, found = listener.skin.part[:, None], list(rows)
    for way in listener.transfers:
        own = part == way.part
        apart = [(partial(product, gain, way.gain), np.where(own, areas, 0.0)) for gain, areas in found]
        found = [*((gain, np.where(own, 0.0, areas)) for gain, areas in found), *apart]
    return found


def _around(head: Head, rows: Sequence[tuple[Gain, FloatArray]], offset: FloatArray) -> list[tuple[Gain, FloatArray]]:
    """Each row once for every gain of a head, of facets at offset (n, 3) from its middle."""
    weights = head.weights(offset)
    return [
        (partial(product, gain, own), weight[:, None] * areas)
        for own, weight in zip(head.gains, weights.T, strict=True)
        for gain, areas in rows
    ]


def _panels(
    system: System,
    listener: Listener,
    areas: FloatArray,
    metre: float,
    band: float,
    known: dict[bytes, tuple[FloatArray, int]],
) -> tuple[FloatArray, int]:
    """(n_tap, n_mode) what modal accelerations send to a point by areas (n, 3) of facets, and the first delay.

    Parameters
    ----------
    known : by which facets send, the weights of their nodes and the first delay; those that are made here go there.
    """
    sends = np.abs(areas).max(axis=1, initial=0.0) > 0.0
    if not sends.any():
        return np.zeros((1, system.n)), 0
    nodes, points, each = nodal(listener.skin.select(sends), areas[sends])
    if sends.tobytes() not in known:
        points, position, head = points * metre, listener.position * metre, listener.head
        paths = None if head is None else head.path(points - position)
        known[sends.tobytes()] = pressure_weights(points, position, PER_BAND * band, band, paths=paths)
    weights, start = known[sends.tobytes()]
    # Areas in m^2, motion in m.
    out = sp.csr_array((each.ravel() * metre**3, (np.repeat(np.arange(nodes.size), 3), np.arange(3 * nodes.size))))
    return of_modes(system, weights @ out, node_dofs(nodes, TRANSLATIONS)), start


def _towards(system: System, skin: Skin, direction: FloatArray) -> FloatArray:
    """(1, n_mode) mean motion of facets along a direction, length."""
    size = np.linalg.norm(skin.areas, axis=1)
    nodes, _, share = nodal(skin, (size / size.sum())[:, None] * direction)
    return of_modes(system, share.reshape(1, -1), node_dofs(nodes, TRANSLATIONS))


def nodal(skin: Skin, each: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Nodes (n,), where they are (n, 3), and what they have (n, 3) of a vector of each facet."""
    nodes, row = np.unique(skin.nodes_idx, return_inverse=True)
    points, found = np.zeros((nodes.size, 3)), np.zeros((nodes.size, 3))
    points[row.ravel()] = skin.corners.reshape(-1, 3)
    np.add.at(found, row.ravel(), (skin.shares[:, :, None] * each[:, None]).reshape(-1, 3))
    return nodes, points, found


def record_of(source: Source, groups: Sequence[IntArray], to: Radiation) -> FloatArray:
    """The same with the `lead` before it and what rings on behind it: a record that is not cut."""
    given = source.modes, source.force, RATE, groups
    found = sound_of_forces(*given, to.panels, to.band, to.gains, around=True).sum(axis=0)
    if to.moves is None:
        return found
    accelerations = sound_of_forces(*given, to.moves, to.band, [b.compact for b in to.bodies], around=True)
    for body, every in zip(to.bodies, accelerations, strict=True):
        direction = _unit(to.position - body.centre)
        for own, pressure in zip(every, found, strict=True):
            sent = acceleration_noise(own[:, None] * direction, RATE, body.radius, body.centre, to.position)
            pressure += to.heard(body, sent)
    return found


def compact_bodies(skin: Skin, metre: float) -> tuple[Body, ...]:
    """Parts of solids alone that are about as wide as long, and small beside the longest wavelength that is heard.

    Largest dimension, twice the way from the middle to the farthest corner, below two diameters of the sphere of the
    same volume. While the wavelength is longer than its circumference the shape counts little: that sphere sends what
    the body sends (Koss and Alfredson, J. Sound Vib. 27, 1973; Richards, Westcott and Jeyapalan, J. Sound Vib. 62,
    1979).
    """
    out = []
    for part in np.unique(skin.part[skin.part >= 0]).tolist():
        own = skin.select(skin.part == part)
        areas, centres = own.areas, own.centres
        size = np.linalg.norm(areas, axis=1)
        if not own.solid.all() or np.abs(areas.sum(axis=0)).max() > CLOSED * size.sum():
            continue
        middle = size @ centres / size.sum()
        radius = equivalent_radius(max(float(np.einsum("nx,nx->", areas, centres - middle)), 0.0) / 3.0)
        length = 2.0 * float(np.linalg.norm(own.corners - middle, axis=2).max())
        body = Body(part, radius * metre, middle * metre, length * metre)
        if length <= LONG * 2.0 * radius and body.compact(np.array([LOWEST]))[0] > 0.0:
            out.append(body)
    return tuple(out)


def _unit(x: FloatArray) -> FloatArray:
    return np.asarray(x / np.linalg.norm(x))


@dataclass(frozen=True)
class Faces:
    """Some facets of each part."""

    part: IntArray
    """(k,) row into `Model.parts`."""
    area: FloatArray
    """(k,) m^2 that each stands for."""
    normal: FloatArray
    """(k, n_mode) motion along their normals, m."""


def faces_of_parts(system: System, skin: Skin, metre: float) -> Faces:
    """`SAMPLES` facets of each part, by their first node."""
    size = np.linalg.norm(skin.areas, axis=1)
    looked, weight = np.zeros(skin.count, dtype=bool), np.zeros(skin.count)
    for part in np.unique(skin.part[skin.part >= 0]).tolist():
        own = np.flatnonzero(skin.part == part)
        some = np.unique(own[np.linspace(0, own.size - 1, SAMPLES).astype(np.int64)])
        looked[some], weight[some] = True, size[own].sum() / some.size
    few = skin.select(looked)
    labels, column = np.unique(node_dofs(few.nodes_idx[:, 0], TRANSLATIONS), return_inverse=True)
    normal = (few.areas / np.maximum(size[looked], 1e-300)[:, None]).ravel()
    across = sp.csc_matrix((normal, (np.repeat(np.arange(few.count), 3), column.ravel())), (few.count, labels.size))
    return Faces(few.part, weight[looked] * metre**2, metre * of_modes(system, across, labels))


def moved(source: Source, faces: Faces, skin: Skin) -> BoolArray:
    """(n,) facets of the parts that the forces of a run can move: under forces that grow as e^(2 pi 20 t / s)."""
    reach = np.abs(transfer(source.modes, faces.normal, 2.0 * np.pi * LOWEST)).max(axis=1, initial=0.0)
    return np.isin(skin.part, faces.part[reach > NOTHING * reach.max(initial=0.0)])


def equivalent_levels(source: Source, faces: Faces, band: float, window: tuple[float, float]) -> dict[int, float]:
    """Part -> dB re 1 pW of its mean equivalent radiated power over a window, loudest first; none of parts at rest."""
    if not faces.part.size:
        return {}
    time, velocity = velocity_of_forces(source.modes, source.force, RATE, faces.normal, band)
    inside = in_window(time, window)
    velocity = velocity[inside] if inside.any() else velocity
    powers = {}
    for part in np.unique(faces.part).tolist():
        own = faces.part == part
        powers[part] = float(equivalent_power(faces.area[own], velocity[:, own]).mean())
    order = sorted((p for p in powers if powers[p] > 0.0), key=lambda p: -powers[p])
    return {p: 10.0 * np.log10(powers[p] / REFERENCE) for p in order}
