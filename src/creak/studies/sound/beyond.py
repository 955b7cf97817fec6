"""Beyond the modes of the reduction: what the unreduced model sends to the listeners of the same contact forces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from creak.arrays import ComplexArray, FloatArray
from creak.assembly.damping import Damping
from creak.assembly.system import System, project
from creak.dynamics.channels import channel_matrices
from creak.errors import NumericalError
from creak.linalg.diagonal import Diagonal
from creak.linalg.memory import OutOfMemory
from creak.model.dofs import TRANSLATIONS, node_dofs
from creak.reduction.band_modes import BandModes, Losses, band_modes, count_for, reach
from creak.sound.forced import FADE, Gain
from creak.sound.rayleigh import AIR
from creak.studies.models.reduced import FACTOR
from creak.studies.models.reference import ReferenceModel
from creak.studies.sound.listeners import Listener
from creak.studies.sound.radiation import Source, nodal
from creak.studies.sound.rims import without_wall

WORTH = 1.1
"""End of the band over that of the modes from which on the unreduced model is asked."""
SHARE = 0.5
"""Of the back-substitutions that the reduction is worth, those that this may take."""
SMALL, FLOOR = 10_000, 24
"""Dofs up to which so many frequencies are looked at whatever the reduction cost: they take a second or two."""
COMPLEX = 2.0
"""Real back-substitutions, or factors, that a complex one takes as long as; measured 1.2 to 2.4."""
MOST_FORCES = 12
"""Combinations of contact forces that are followed; the others are heard through the listeners' side alone."""
FAINT = 1e-3
"""Share of the strongest combination below which one is left out."""


@dataclass(frozen=True)
class Beyond:
    """A System whose modes tell what listeners hear of contact forces, from where those of the reduction end."""

    system: System
    """Diagonal."""
    found: BandModes
    solves: float
    """Real back-substitutions that it took, factors among them."""

    @property
    def high(self) -> float:
        """Hz, where it ends."""
        return self.found.high


@dataclass(frozen=True)
class BeyondCost:
    """What it takes to go on from the end of the modes to that of a band."""

    frequencies: int
    """At which the unreduced model is solved; a few more where it is not as smooth as its damping says."""
    solves: float
    """Real back-substitutions, factors among them."""
    share: float
    """Of which it may take so many."""


def beyond_cost(system: System, zeta: float | None, columns: int, band: tuple[float, float], most: float) -> BeyondCost:
    """From the end of the modes' band to that of another one, Hz; no frequency where nothing is damped.

    Parameters
    ----------
    columns : forces and listeners. most : real back-substitutions that are its share.
    """
    losses, low, each = losses_of(system.damping, zeta), FADE * band[0], frequency_cost(columns)
    damped = losses.width(np.array([low]))[0] > 0.0
    count = count_for(losses, low, band[1]) if damped and band[1] > low else 0
    return BeyondCost(count, count * each, max(most, FLOOR * each) if system.n <= SMALL else most)


def beyond_modes(
    reference: ReferenceModel,
    zeta: float | None,
    source: Source,
    listeners: Sequence[Listener],
    metre: float,
    band: tuple[float, float],
    most: float,
) -> Beyond | str:
    """From the end of the modes' band to that of the mesh and step, Hz, or as far as the budget goes; or why not.

    Parameters
    ----------
    zeta : share of critical of all modes; None: damping is that of the model.
    most : real back-substitutions it may take.
    """
    if reference.of_parts is not None:
        return "memory does not hold the unreduced model"
    system, low = reference.system, FADE * band[0]
    rows = channel_matrices(system, source.gaps).rows[source.row]
    push = np.asarray(rows.T @ _strongest(source.force))
    columns = push.shape[1] + len(listeners)
    cost, losses = beyond_cost(system, zeta, columns, band, most), losses_of(system.damping, zeta)
    if not cost.frequencies:
        return "nothing is damped"
    count = int(cost.share / frequency_cost(columns))
    too_much = (
        f"to {band[1]:.0f} Hz it would take {cost.frequencies} frequencies, {cost.solves:.0f} back-substitutions, "
        f"and {cost.share:.0f} are its share"
    )
    if reach(losses, (low, band[1]), count) < WORTH * band[0]:
        return too_much
    ears = [hearing(system, listener, metre) for listener in listeners]

    def weights(freq: float) -> ComplexArray:
        return np.stack([ear(freq) for ear in ears], axis=1)

    try:
        found = band_modes(system.K, system.M, losses, push, weights, (low, band[1]), count)
    except OutOfMemory:
        return "memory does not hold it"
    except NumericalError as error:
        return str(error)
    if found is None or found.high < WORTH * band[0]:
        return too_much
    return Beyond(_as_system(system, losses, found), found, found.freq.size * frequency_cost(columns))


def frequency_cost(columns: int) -> float:
    """Real back-substitutions that a frequency takes: its factor, and two solves of each column."""
    return COMPLEX * (FACTOR + 2.0 * columns)


def losses_of(damping: Damping, zeta: float | None) -> Losses:
    """Damping as the reduced model has it: of every mode alike, or Rayleigh's."""
    return Losses(damping.alpha, damping.beta) if zeta is None else Losses(zeta=zeta)


def _as_system(system: System, losses: Losses, found: BandModes) -> System:
    omega, r = np.sqrt(found.omega2), found.omega2.size
    damping = Damping(losses.alpha, losses.beta)
    if losses.zeta:
        damping = replace(damping, modal_shapes=np.eye(r), modal_values=2.0 * losses.zeta * omega)
    plain = replace(system, velocity=np.zeros(system.n), damping=Damping(system.damping.alpha, system.damping.beta))
    known = Diagonal(np.ones(r)), Diagonal(found.omega2)
    small = project(plain, found.shapes, name=f"{system.name}, {r} shapes of its sound", known=known)
    return replace(small, M=known[0], K=known[1], damping=damping)


def _strongest(force: FloatArray) -> FloatArray:
    """(n_force, k) combinations of forces, each channel counted alike: those that hit, by how fast they change."""
    change = np.diff(force, axis=0, prepend=0.0)
    change = change / np.maximum(np.linalg.norm(change, axis=0), np.finfo(float).tiny)
    size, vectors = np.linalg.eigh(change.T @ change)
    keep = np.flatnonzero(size > FAINT**2 * size.max(initial=0.0))[::-1][:MOST_FORCES]
    return np.asarray(vectors[:, keep] * np.sqrt(size[keep]))


def hearing(system: System, listener: Listener, metre: float) -> Callable[[float], ComplexArray]:
    """Of a frequency, Hz: (n,) pressure at a listener per acceleration of each coordinate of an unreduced System.

    Rayleigh's integral, but for a delay that all share; compact bodies count with their faces. Parts whose way was
    measured are heard by it, panels that stand free around their edges.
    """
    sent, part = listener.skin.toward(listener.position), listener.skin.part[:, None]
    open_air = np.where(np.isin(part, [way.part for way in listener.transfers]), 0.0, sent)
    own = ((way.gain, np.where(part == way.part, sent, 0.0)) for way in listener.transfers)
    rows: list[tuple[Gain, Any]] = [(np.ones_like, open_air), *own]
    gains, ways = zip(*without_wall(listener.rims, rows), strict=True)
    nodes, points, _ = nodal(listener.skin, sent.real)
    volumes = [metre**3 * (nodal(listener.skin, own.real)[2] + 1j * nodal(listener.skin, own.imag)[2]) for own in ways]
    r = metre * np.linalg.norm(points - listener.position, axis=1)
    labels = node_dofs(nodes, TRANSLATIONS)
    moves = np.isin(labels, system.labels)
    R = system.rows(labels[moves])[0].T

    def at(freq: float) -> ComplexArray:
        turned = AIR.density / (2.0 * np.pi * r) * np.exp(-2j * np.pi * freq / AIR.speed * (r - r.min()))
        volume = sum(gain(np.array([freq]))[0] * own for gain, own in zip(gains, volumes, strict=True))
        return np.asarray(R @ (turned[:, None] * volume).ravel()[moves])

    return at
