"""From the modes of a run to a listener: panels by Rayleigh's integral, compact bodies by their acceleration noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray
from creak.assembly.system import System
from creak.model.dofs import TRANSLATIONS, node_dofs
from creak.model.skin import Skin
from creak.sound.acceleration_noise import acceleration_noise, equivalent_radius
from creak.sound.forced import sound_of_forces
from creak.sound.rayleigh import AIR, PressureRows, pressure_weights
from creak.sound.zwicker_tables import RATE
from creak.studies.sound.listeners import Listener
from creak.studies.sound.source import Source, of_modes

PER_BAND = 4.0
"""Samples per second of a listener's rows over the band: few, as each costs a back-substitution in every part."""
PER_WAVE = 6.0
"""A compact body is smaller than the shortest wavelength over this."""
LONG = 2.0
"""Its largest dimension over the diameter of the sphere of its volume, at most."""
CLOSED = 1e-6
"""Share of its area by which its faces may fail to close."""


@dataclass(frozen=True)
class Body:
    """A compact solid part, heard as the sphere of its volume."""

    part: int
    radius: float
    """m"""
    centre: FloatArray
    """(3,) m"""
    length: float
    """m, its largest dimension."""


@dataclass(frozen=True)
class Radiation:
    """What each mode's acceleration sends to one listener."""

    position: FloatArray
    """(3,) of the listener, m."""
    panels: PressureRows
    """Pa per unit of modal acceleration."""
    bodies: tuple[Body, ...]
    moves: PressureRows | None
    """(n_body, 1, n_mode) mean motion of each body towards the listener, m; None without bodies."""
    band: float
    """Hz, up to which it holds."""


@dataclass(frozen=True)
class Ear:
    """A listener, and the end of the band in which it hears."""

    listener: Listener
    band: float
    """Hz"""
    metre: float
    """Of the model's length."""
    known: dict[int, tuple[System, Radiation]] = field(default_factory=dict, compare=False, repr=False)
    """By the System's id: what was made before."""

    def hears(self, system: System) -> Radiation:
        """What it hears of the modes of a System; made once for each."""
        if id(system) not in self.known:
            self.known[id(system)] = system, radiation(system, self.listener, self.metre, self.band)
        return self.known[id(system)][1]


def radiation(system: System, listener: Listener, metre: float, band: float) -> Radiation:
    """What each mode's acceleration sends to a listener, up to the end of the band, Hz."""
    skin, position = listener.skin, listener.position * metre
    every = compact_bodies(skin, metre, band)
    bodies = tuple(b for b in every if np.linalg.norm(position - b.centre) > b.length)
    panels = skin.select(~np.isin(skin.part, [b.part for b in bodies]))
    moves = None
    if bodies:
        own = [_towards(system, skin.select(skin.part == b.part), _unit(position - b.centre)) for b in bodies]
        moves = PressureRows(metre * np.stack(own), np.zeros(len(bodies), dtype=np.int64), float(RATE), band)
    return Radiation(position, _panels(system, panels, listener.position, metre, band), bodies, moves, band)


def _panels(system: System, skin: Skin, position: FloatArray, metre: float, band: float) -> PressureRows:
    rate = PER_BAND * band
    if not skin.count:
        return PressureRows(np.zeros((1, 1, system.n)), np.zeros(1, dtype=np.int64), rate, band)
    nodes, points, areas = _nodal(skin, skin.toward(position))
    weights, start = pressure_weights(points * metre, position * metre, rate, band)
    # Areas in m^2, motion in m.
    out = sp.csr_array((areas.ravel() * metre**3, (np.repeat(np.arange(nodes.size), 3), np.arange(3 * nodes.size))))
    return PressureRows(
        of_modes(system, weights @ out, node_dofs(nodes, TRANSLATIONS))[None], np.array([start]), rate, band
    )


def _towards(system: System, skin: Skin, direction: FloatArray) -> FloatArray:
    """(1, n_mode) mean motion of facets along a direction, length."""
    size = np.linalg.norm(skin.areas, axis=1)
    nodes, _, share = _nodal(skin, (size / size.sum())[:, None] * direction)
    return of_modes(system, share.reshape(1, -1), node_dofs(nodes, TRANSLATIONS))


def _nodal(skin: Skin, each: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Nodes (n,), where they are (n, 3), and what they have (n, 3) of a vector of each facet."""
    nodes, row = np.unique(skin.nodes_idx, return_inverse=True)
    points, found = np.zeros((nodes.size, 3)), np.zeros((nodes.size, 3))
    points[row.ravel()] = skin.corners.reshape(-1, 3)
    np.add.at(found, row.ravel(), (skin.shares[:, :, None] * each[:, None]).reshape(-1, 3))
    return nodes, points, found


def pressure_of(source: Source, groups: Sequence[IntArray], to: Radiation) -> FloatArray:
    """Pressure (n_group, n) in Pa at 48 kHz that each group of forces makes by itself at a listener."""
    found = sound_of_forces(source.modes, source.force, RATE, groups, to.panels, to.band)[0]
    if to.moves is None:
        return found
    accelerations = sound_of_forces(source.modes, source.force, RATE, groups, to.moves, to.band)
    for body, every in zip(to.bodies, accelerations, strict=True):
        direction = _unit(to.position - body.centre)
        for own, pressure in zip(every, found, strict=True):
            pressure += acceleration_noise(own[:, None] * direction, RATE, body.radius, body.centre, to.position)
    return found


def compact_bodies(skin: Skin, metre: float, band: float) -> tuple[Body, ...]:
    """Parts of solids alone that are small beside the shortest wavelength, and about as wide as long.

    Largest dimension, twice the way from the middle to the farthest corner, below a sixth of the wavelength in air at
    the band's end (ka < .5), and below two diameters of the sphere of the same volume. The shape counts little then:
    that sphere sends what the body sends (Koss and Alfredson, J. Sound Vib. 27, 1973; Richards, Westcott and
    Jeyapalan, J. Sound Vib. 62, 1979).
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
        if length <= min(AIR.speed / (PER_WAVE * band * metre), LONG * 2.0 * radius):
            out.append(Body(part, radius * metre, middle * metre, length * metre))
    return tuple(out)


def _unit(x: FloatArray) -> FloatArray:
    return np.asarray(x / np.linalg.norm(x))
