"""Modes of a deck beside measured ones: sensors on nodes, MAC, pairs, and what has no partner."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Protocol

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.formats.measured.modes import Measured, MeasuredModes
from creak.model.mesh import Model
from creak.reduction.modal import ModalDamping, shares_at
from creak.studies.models.deck_modes import DeckModes
from creak.studies.prepare.measured_damping import PairedShapes, pair_shapes
from creak.studies.prepare.sensors import BY_LABEL, BY_MAP, BY_PLACE, Sensors
from creak.studies.prepare.unit_check import across, likely_units
from creak.verify.mac import mac_matrix
from creak.verify.mode_fit import ModeFit, ModePair

REAL = 0.9
"""Phase collinearity below which a mode is told to be complex."""
EXACT = 1e-5
"""Share of the model's size up to which a sensor is at its node: files have six digits."""
OWN = 0.99
"""Of a mode in what stands for it, up to which others of its frequency are told to be in it."""
TWINS = 0.9
"""MAC between two modes of one set from which the sensors cannot tell them apart."""


class WithModes(Protocol):
    """A linear structure and its modes."""

    @property
    def model(self) -> Model: ...
    @property
    def system(self) -> System:
        """Undamped, or damped as the run is."""

    @property
    def damped(self) -> System | None:
        """With its damping; None: it has none."""

    @property
    def frequencies(self) -> Sequence[float]:
        """Hz, rigid ones first."""

    @property
    def rigid(self) -> int: ...
    @property
    def shapes(self) -> FloatArray:
        """(n, n_mode) in the coordinates of `system`, mass-normalised."""


@dataclass(frozen=True)
class Correlation(ModeFit):
    """A deck's modes against a test's, at the sensors of the test, with the shapes."""

    measured: MeasuredModes
    found: DeckModes
    sensors: Sensors
    test_shapes: FloatArray
    """(n_channel, n_test) real"""
    model_shapes: FloatArray
    """(n_channel, n_model) along the directions of the sensors, mass-normalised."""
    auto_mac_model: FloatArray

    def as_dict(self) -> dict[str, Any]:
        """As plain numbers, for JSON; modes count from 1."""
        test = self.measured
        sensors = [
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
        ]
        told = {"test": test.path.name, "sensors": sensors, "auto_mac_model": self.auto_mac_model.tolist()}
        return told | super().as_dict()


def correlate(found: DeckModes, measured: MeasuredModes, sensors: Sensors) -> Correlation:
    """Compare the modes of a deck with measured ones, at the sensors and along their directions.

    Raises
    ------
    InputError : the modes are complex through and through, or none has a partner.
    """
    fit, both = fit_modes(found, measured, sensors)
    if (turned := (both.turn != np.eye(len(both.turn))).any(axis=0)).any():
        shapes = found.shapes.copy()
        shapes[:, turned] = shapes[:, turned] @ both.turn[np.ix_(turned, turned)]
        found = replace(found, shapes=shapes)
    auto = mac_matrix(both.model[:, found.rigid :], both.model[:, found.rigid :])
    return Correlation(
        **{f.name: getattr(fit, f.name) for f in fields(fit)},
        measured=measured,
        found=found,
        sensors=sensors,
        test_shapes=both.test,
        model_shapes=both.model,
        auto_mac_model=auto,
    )


def fit_modes(
    found: WithModes, measured: MeasuredModes, sensors: Sensors, modal: ModalDamping | None = None
) -> tuple[ModeFit, PairedShapes]:
    """The agreement, and both shapes at the sensors; raises as `pair_shapes`.

    Parameters
    ----------
    modal : share of critical damping of every mode; None: that of `found.damped`.
    """
    freq = np.array(found.frequencies)
    both = pair_shapes(measured, sensors, found.system, found.shapes, freq)
    auto = mac_matrix(both.test, both.test)
    damping = model_damping(found) if modal is None else shares_at(modal, (2.0 * np.pi * freq) ** 2)
    pairs = tuple(_pair(measured, both, freq, damping, k, j) for k, j in enumerate(both.partner.tolist()) if j >= 0)
    told = sensor_notes(found.model, measured, sensors), _shape_notes(measured, both, auto, freq)
    notes = (*both.doubts, *measured.notes, *told[0], *told[1])
    figures = measured.frequencies, measured.damping, freq, found.rigid, both.mac, auto, both.collinearity
    return ModeFit(*figures, pairs, notes), both


def model_damping(found: WithModes) -> FloatArray:
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


def sensor_notes(model: Model, measured: Measured, sensors: Sensors) -> Iterator[str]:
    first = {s: k for k, s in reversed(list(enumerate(measured.sensors)))}
    by = [sensors.how[k] for k in first.values()]
    ways = [
        f"{by.count(how)} {word}"
        for how, word in ((BY_LABEL, "by label"), (BY_PLACE, "by the nearest node"), (BY_MAP, "by the map"))
        if how in by
    ]
    yield f"{len(first)} sensors, {len(measured.sensors)} channels: {', '.join(ways)}"
    worst = int(sensors.distance.argmax())
    if sensors.distance[worst] > EXACT * across(model):
        node, unit = model.nodes.label(int(sensors.nodes_idx[worst])), likely_units(model, sensors.units).words[0]
        yield (
            f"sensor {measured.sensors[worst]} is farthest from its node: {sensors.distance[worst]:.3g} {unit} from "
            f"{node} (mean of all {sensors.distance.mean():.3g} {unit})"
        )
    if not math.isclose(sensors.scale, 1.0):
        yield f"lengths of the test are taken times {sensors.scale:.6g}"


def _shape_notes(measured: MeasuredModes, both: PairedShapes, auto: FloatArray, freq: FloatArray) -> Iterator[str]:
    for k in np.flatnonzero(both.collinearity < REAL).tolist():
        yield f"mode at {measured.frequencies[k]:g} Hz is complex: phase collinearity {both.collinearity[k]:.2f}"
    turned = np.flatnonzero(np.abs(both.turn.diagonal()) < OWN)
    if turned.size:
        yield (
            f"modes {', '.join(str(k + 1) for k in turned.tolist())} of the model, near {freq[turned[0]]:.6g} Hz, are "
            "combined as the test has them: modes of one frequency have no shapes of their own"
        )
    twins = np.argwhere(np.triu(auto, 1) >= TWINS)
    if len(twins):
        i, j = twins[0].tolist()
        more = len(twins) - 1
        others = f" (and {more} other pair{'s' if more > 1 else ''})" if more else ""
        yield (
            f"the sensors cannot tell the measured modes at {measured.frequencies[i]:g} and "
            f"{measured.frequencies[j]:g} Hz apart: MAC {auto[i, j]:.2f}{others}"
        )
