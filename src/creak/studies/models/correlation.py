"""Modes of a deck beside measured ones: sensors on nodes, MAC, pairs, and what has no partner."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.formats.measured.modes import Measured, MeasuredModes
from creak.studies.models.deck_modes import DeckModes
from creak.studies.prepare.measured_damping import PairedShapes, pair_shapes
from creak.studies.prepare.sensors import BY_LABEL, BY_MAP, BY_PLACE, Sensors, locate
from creak.studies.prepare.unit_check import across
from creak.verify.mac import mac_matrix

REAL = 0.9
"""Phase collinearity below which a mode is told to be complex."""
EXACT = 1e-5
"""Share of the model's size up to which a sensor is at its node: files have six digits."""
TWINS = 0.9
"""MAC between two modes of one set from which the sensors cannot tell them apart."""


@dataclass(frozen=True)
class ModePair:
    """A measured mode with its partner in the model."""

    test: int
    """Row of the measured mode."""
    model: int
    """Row of the deck's mode, rigid ones counted."""
    frequency_test: float
    """Hz"""
    frequency_model: float
    """Hz"""
    mac: float
    damping_test: float
    """Share of critical; nan where it is not known."""
    damping_model: float
    scale: float
    """Least-squares factor of the measured shape: times it, it lies over the mass-normalised one of the model."""

    @property
    def difference(self) -> float:
        """f_model / f_test - 1"""
        return self.frequency_model / self.frequency_test - 1.0


@dataclass(frozen=True)
class Correlation:
    """A model's modes against a test's, at the sensors of the test."""

    measured: MeasuredModes
    found: DeckModes
    sensors: Sensors
    test_shapes: FloatArray
    """(n_channel, n_test) real"""
    model_shapes: FloatArray
    """(n_channel, n_model) along the directions of the sensors, mass-normalised."""
    mac: FloatArray
    """(n_test, n_model)"""
    auto_mac_test: FloatArray
    auto_mac_model: FloatArray
    collinearity: FloatArray
    """(n_test,) modal phase collinearity, 1: real."""
    pairs: tuple[ModePair, ...]
    notes: tuple[str, ...]

    @property
    def alone_test(self) -> list[int]:
        """Measured modes without partner."""
        return sorted(set(range(self.measured.frequencies.size)) - {p.test for p in self.pairs})

    @property
    def alone_model(self) -> list[int]:
        """Elastic modes of the model without partner, up to the highest measured frequency."""
        top, paired = float(self.measured.frequencies.max()), {p.model for p in self.pairs}
        f = self.found.frequencies
        return [k for k in range(self.found.rigid, len(f)) if k not in paired and f[k] <= top]

    def as_dict(self) -> dict[str, Any]:
        """As plain numbers, for JSON; modes count from 1."""
        test, f = self.measured, self.found.frequencies
        return {
            "test": test.path.name,
            "sensors": [
                {
                    "sensor": name,
                    "direction": direction,
                    "node": self.found.model.nodes.label(int(node)),
                    "distance": distance,
                    "by": how,
                }
                for name, direction, node, distance, how in zip(
                    test.sensors,
                    test.directions.tolist(),
                    self.sensors.nodes_idx,
                    self.sensors.distance.tolist(),
                    self.sensors.how,
                    strict=True,
                )
            ],
            "test_modes": [
                {"frequency": hz, "damping": zeta, "phase_collinearity": mpc}
                for hz, zeta, mpc in zip(
                    test.frequencies.tolist(), test.damping.tolist(), self.collinearity.tolist(), strict=True
                )
            ],
            "pairs": [
                {
                    "test": p.test + 1,
                    "model": p.model + 1,
                    "frequency_test": p.frequency_test,
                    "frequency_model": p.frequency_model,
                    "difference": p.difference,
                    "mac": p.mac,
                    "damping_test": p.damping_test,
                    "damping_model": p.damping_model,
                }
                for p in self.pairs
            ],
            "test_without_partner": [{"mode": k + 1, "frequency": float(test.frequencies[k])} for k in self.alone_test],
            "model_without_partner": [{"mode": k + 1, "frequency": f[k]} for k in self.alone_model],
            "mac": self.mac.tolist(),
            "auto_mac_test": self.auto_mac_test.tolist(),
            "auto_mac_model": self.auto_mac_model.tolist(),
            "notes": list(self.notes),
        }


def correlate(
    found: DeckModes,
    measured: MeasuredModes,
    *,
    units: str = "mm-t-s",
    test_units: str | None = None,
    mapped: Mapping[str, int] | None = None,
) -> Correlation:
    """Compare the modes of a deck with measured ones, at the sensors and along their directions.

    Parameters
    ----------
    units, test_units, mapped : as `sensors.locate`.

    Raises
    ------
    InputError : the sensors are not on the model, the modes are complex through and through, or none has a partner.
    """
    sensors = locate(found.model, measured, units, test_units, mapped or {})
    freq = np.array(found.frequencies)
    both = pair_shapes(measured, sensors, found.system, found.shapes, freq)
    test, model, matrix, collinearity = both.test, both.model, both.mac, both.collinearity
    damping = model_damping(found)
    pairs = tuple(_pair(measured, both, freq, damping, k, j) for k, j in enumerate(both.partner.tolist()) if j >= 0)
    autos = mac_matrix(test, test), mac_matrix(model[:, found.rigid :], model[:, found.rigid :])
    notes = (*measured.notes, *sensor_notes(found, measured, sensors), *_shape_notes(measured, collinearity, autos[0]))
    return Correlation(measured, found, sensors, test, model, matrix, *autos, collinearity, pairs, notes)


def model_damping(found: DeckModes) -> FloatArray:
    """(n_mode,) phi' C phi / (2 omega) of the damping that the deck tells, share of critical; nan without, and of rigid
    modes."""
    nothing, system = np.full(len(found.frequencies), np.nan), found.damped
    if system is None:
        return nothing
    omega = 2.0 * np.pi * np.array(found.frequencies)
    C = system.damping
    other = np.asarray(C.other(found.shapes)) * np.ones_like(found.shapes)
    damped = C.alpha + C.beta * omega**2 + (found.shapes * other).sum(axis=0)
    return np.divide(damped, 2.0 * omega, out=nothing, where=omega > 0.0)


def _pair(measured: MeasuredModes, both: PairedShapes, f: FloatArray, damping: FloatArray, k: int, j: int) -> ModePair:
    x, y = both.test[:, k], both.model[:, j]
    return ModePair(
        k,
        j,
        float(measured.frequencies[k]),
        float(f[j]),
        float(both.mac[k, j]),
        float(measured.damping[k]),
        float(damping[j]),
        float(x @ y / (x @ x)),
    )


def sensor_notes(found: DeckModes, measured: Measured, sensors: Sensors) -> Iterator[str]:
    first = {s: k for k, s in reversed(list(enumerate(measured.sensors)))}
    by = [sensors.how[k] for k in first.values()]
    ways = [
        f"{by.count(how)} {word}"
        for how, word in ((BY_LABEL, "by label"), (BY_PLACE, "by the nearest node"), (BY_MAP, "by the map"))
        if how in by
    ]
    yield f"{len(first)} sensors, {len(measured.sensors)} channels: {', '.join(ways)}"
    worst = int(sensors.distance.argmax())
    if sensors.distance[worst] > EXACT * across(found.model):
        node = found.model.nodes.label(int(sensors.nodes_idx[worst]))
        yield (
            f"sensor {measured.sensors[worst]} is farthest from its node: {sensors.distance[worst]:.3g} from {node}"
            f" (mean of all {sensors.distance.mean():.3g})"
        )
    if not math.isclose(sensors.scale, 1.0):
        yield f"lengths of the test are taken times {sensors.scale:.6g}"


def _shape_notes(measured: MeasuredModes, collinearity: FloatArray, auto: FloatArray) -> Iterator[str]:
    for k in np.flatnonzero(collinearity < REAL).tolist():
        yield f"mode at {measured.frequencies[k]:g} Hz is complex: phase collinearity {collinearity[k]:.2f}"
    twins = np.argwhere(np.triu(auto, 1) >= TWINS)
    if len(twins):
        i, j = twins[0].tolist()
        more = len(twins) - 1
        others = f" (and {more} other pair{'s' if more > 1 else ''})" if more else ""
        yield (
            f"the sensors cannot tell the measured modes at {measured.frequencies[i]:g} and "
            f"{measured.frequencies[j]:g} Hz apart: MAC {auto[i, j]:.2f}{others}"
        )
