"""Equivalent radiated power of each part: the fast measure of what radiates, without listener and direction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.assembly.system import System
from creak.model.dofs import TRANSLATIONS, node_dofs
from creak.model.skin import Skin
from creak.sound.forced import LOWEST, velocity_of_forces
from creak.sound.rayleigh import equivalent_power
from creak.sound.zwicker_tables import RATE
from creak.studies.sound.source import Source, of_modes

SAMPLES = 24
"""Facets of each part that stand for all of it: its level within 1 dB or so."""
REFERENCE = 1e-12
"""W of 0 dB."""

NOTHING = 1e-9
"""Of the motion of the part that moves most, what round-off leaves of one that nothing joins to the contacts."""


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
    modes, s = source.modes, 2.0 * np.pi * LOWEST
    reach = np.abs(faces.normal / ((modes.m * s + modes.c) * s + modes.k) @ modes.push.T).max(axis=1, initial=0.0)
    return np.isin(skin.part, faces.part[reach > NOTHING * reach.max(initial=0.0)])


def equivalent_levels(source: Source, faces: Faces, band: float, window: tuple[float, float]) -> dict[int, float]:
    """Part -> dB re 1 pW of its mean equivalent radiated power over a window, loudest first; none of parts at rest."""
    if not faces.part.size:
        return {}
    time, velocity = velocity_of_forces(source.modes, source.force, RATE, faces.normal, band)
    inside = (time >= window[0]) & (time <= window[1])
    velocity = velocity[inside] if inside.any() else velocity
    powers = {}
    for part in np.unique(faces.part).tolist():
        own = faces.part == part
        powers[part] = float(equivalent_power(faces.area[own], velocity[:, own]).mean())
    order = sorted((p for p in powers if powers[p] > 0.0), key=lambda p: -powers[p])
    return {p: 10.0 * np.log10(powers[p] / REFERENCE) for p in order}
