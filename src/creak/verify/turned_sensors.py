"""Sensors of a test that do not lie as its file says: which turns of their axes make its shapes those of the model."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field, replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.verify.mac import BAND, mac_matrix, pair_measured

RISE = 0.1
"""By how much turned axes must raise the mean MAC of all modes: a turn makes modes of a square plate of others."""
MEANT = 0.8
"""Mean MAC from which shapes are those of the model: of others no choice of signs makes so much, from 3 modes on."""
AGREE = 0.8
"""Cosine of a channel's measured motion over all modes and the model's turned about, from which it is reversed."""
DOUBTED, FOUND = 0.8, 0.95
"""Cosine of a sensor's measured motion over all modes and the model's: below the one it may lie otherwise, from the
other on a way to lie is right."""
MOVES = 0.1
"""Of the mean motion of all: a sensor that moves less tells nothing."""
FEW = 3
"""Modes, and figures of a sensor more than these, without which nothing is said."""
TURNS = sorted(
    (
        np.diag(signs)[list(order)]
        for order in itertools.permutations(range(3))
        for signs in itertools.product((1, -1), repeat=3)
    ),
    key=lambda turn: int((turn != np.eye(3)).sum()),
)
"""All 48 ways in which axes can be exchanged and reversed, those that change least first."""


@dataclass(frozen=True)
class Channels:
    """What a test measured, and how its points move in the model."""

    test: FloatArray
    """(n_channel, n_test) real shapes."""
    motion: FloatArray
    """(n_channel, 3, n_model) along x, y and z at the node of each."""
    directions: FloatArray
    """(n_channel, 3)"""
    sensors: tuple[str, ...]
    """(n_channel,) name of each; channels of one name turn together."""
    freq_test: FloatArray
    """(n_test,) Hz"""
    freq_model: FloatArray
    """(n_model,) Hz"""

    @property
    def model(self) -> FloatArray:
        """(n_channel, n_model) along the directions."""
        return np.asarray(np.einsum("ci,cim->cm", self.directions, self.motion))

    @property
    def rows(self) -> dict[str, IntArray]:
        """Sensor -> its channels."""
        found: dict[str, list[int]] = {}
        for k, name in enumerate(self.sensors):
            found.setdefault(name, []).append(k)
        return {name: np.array(channels) for name, channels in found.items()}

    def partners(self, mac: FloatArray) -> IntArray:
        """(n_test,)"""
        return pair_measured(mac, self.freq_test, self.freq_model)

    @property
    def mean_mac(self) -> float:
        """Over all measured modes, 0 of those without a partner."""
        mac = mac_matrix(self.test, self.model)
        partner = self.partners(mac)
        return float(np.where(partner >= 0, mac[np.arange(partner.size), partner], 0.0).mean())

    @property
    def fits(self) -> int:
        """Measured modes whose partner has a MAC of `MEANT` and a frequency within `BAND`."""
        mac = mac_matrix(self.test, self.model)
        partner = self.partners(mac)
        k = np.flatnonzero(partner >= 0)
        near = np.abs(self.freq_model[partner[k]] / self.freq_test[k] - 1.0) <= BAND
        return int((near & (mac[k, partner[k]] >= MEANT)).sum())

    def turned(self, turn: IntArray, rows: IntArray | slice = slice(None)) -> Channels:
        """Some of them along other axes."""
        directions = self.directions.copy()
        directions[rows] = directions[rows] @ turn.T
        return replace(self, directions=directions)


@dataclass(frozen=True)
class TurnedSensors:
    """How the sensors would have to lie for the test to be one of the model."""

    before: float
    """Mean MAC of all measured modes as the file says it."""
    after: float
    axes: IntArray | None = None
    """Turn of all sensors: column i is the axis of the model along which lies what the file calls axis i."""
    reversed: tuple[int, ...] = ()
    """Channels."""
    turned: dict[str, IntArray] = field(default_factory=dict)
    """Sensor -> its own turn."""
    exchanged: tuple[tuple[str, str], ...] = ()


def find_turned(found: Channels) -> TurnedSensors | None:
    """Which sensors do not lie as the file of a test says; None: nothing of the kind would make it a better one.

    Looked for in turn: axes of all sensors exchanged or reversed; single channels reversed; single sensors turned, or
    exchanged with another. Signs of channels come from the modes paired by the sizes of their motion: s that maximises
    sum_k (sum_c s_c x_ck y_ck)^2 is that of the leading left singular vector of x_ck y_ck. Of fewer than `FEW` modes,
    and of models that differ from the structure too much (`MEANT`), nothing is told.
    """
    before = found.mean_mac
    if found.freq_test.size < FEW:
        return None
    # The turn of all sensors that makes the mean MAC largest.
    means = [found.turned(turn).mean_mac for turn in TURNS]
    k = int(np.argmax(np.round(means, 3)))
    axes, now = (TURNS[k], found.turned(TURNS[k])) if means[k] >= before + RISE else (None, found)
    reversed_ = _reversed(now)
    now = now.turned(-np.eye(3, dtype=np.int64), np.array(reversed_, dtype=np.int64))
    turned, exchanged, now = _single(now)
    after = now.mean_mac
    if after < MEANT or after <= before or (axes is None and not reversed_ and not turned and not exchanged):
        return None
    return TurnedSensors(before, after, axes, reversed_, turned, exchanged)


def _reversed(found: Channels) -> tuple[int, ...]:
    """Channels whose sign is the other one in nearly all that they move, where they move less than the others."""
    model = found.model
    partner = found.partners(mac_matrix(np.abs(found.test), np.abs(model)))
    if (partner >= 0).sum() < FEW:
        return ()
    x, y = _of_size_one(found.test[:, partner >= 0]), _of_size_one(model[:, partner[partner >= 0]])
    signs = np.sign(np.sign(np.linalg.svd(x * y, full_matrices=False)[0][:, 0]) @ (x * y))
    size = np.linalg.norm(x, axis=1) * np.linalg.norm(y, axis=1)
    cosine = np.divide((x * y) @ signs, size, out=np.zeros(size.size), where=size > 0.0)
    cosine *= 1.0 if size @ np.sign(cosine) >= 0.0 else -1.0
    return tuple(np.flatnonzero((cosine <= -AGREE) & (size >= MOVES * size.mean())).tolist())


def _single(found: Channels) -> tuple[dict[str, IntArray], tuple[tuple[str, str], ...], Channels]:
    """Sensors that are turned by themselves, pairs that are exchanged, and all of them as they would be right."""
    partner = found.partners(mac_matrix(found.test, found.model))
    columns = partner[partner >= 0]
    if columns.size < FEW:
        return {}, (), found
    x, model = _of_size_one(found.test[:, partner >= 0]), found.model[:, columns]
    motion = found.motion[:, :, columns] * (np.sign((x * model).sum(axis=0)) / np.linalg.norm(model, axis=0))
    rows = found.rows
    least = MOVES * columns.size / len(rows)

    def cosine(name: str, turn: IntArray, node_of: str) -> float:
        """Of what a sensor measured over all modes, and what the model does there along turned directions."""
        a = x[rows[name]]
        b = np.einsum("ci,cim->cm", found.directions[rows[name]] @ turn.T, motion[rows[node_of]])
        size = np.sqrt((a**2).sum() * (b**2).sum())
        return float((a * b).sum() / size) if size > 0.0 and (a**2).sum() >= least and a.size > FEW else np.nan

    doubted = [name for name in rows if cosine(name, TURNS[0], name) < DOUBTED]
    exchanged: dict[str, str] = {}
    for a, b in itertools.combinations(doubted, 2):
        is_new = rows[a].size == rows[b].size and not {a, b} & {*exchanged, *exchanged.values()}
        if is_new and min(cosine(a, TURNS[0], b), cosine(b, TURNS[0], a)) >= FOUND:
            exchanged[a] = b
    turned: dict[str, IntArray] = {}
    for name in doubted:
        fits = [cosine(name, turn, name) for turn in TURNS]
        if name not in {*exchanged, *exchanged.values()} and max(fits) >= FOUND:
            turned[name] = TURNS[int(np.argmax(np.round(fits, 3)))]
    right = found.motion.copy()
    for a, b in exchanged.items():
        right[rows[a]], right[rows[b]] = found.motion[rows[b]], found.motion[rows[a]]
    now = replace(found, motion=right)
    for name, turn in turned.items():
        now = now.turned(turn, rows[name])
    return turned, tuple(exchanged.items()), now


def _of_size_one(shapes: FloatArray) -> FloatArray:
    """Each column divided by its length, 0 where it has none."""
    size = np.linalg.norm(shapes, axis=0)
    return np.divide(shapes, size, out=np.zeros_like(shapes), where=size > 0.0)
