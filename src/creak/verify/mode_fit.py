"""How far the modes of a model and of a test agree: frequencies, MAC, pairs, what has no partner."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from creak.arrays import FloatArray

ALIKE = 1e-9
"""Round-off of MAC."""
GOOD_MAC, GOOD_HZ = 0.9, 0.05
"""What fits: MAC from here on, and frequencies no farther apart than this share."""


@dataclass(frozen=True)
class ModePair:
    """A measured mode with its partner in the model."""

    test: int
    """Row of the measured mode."""
    model: int
    """Row of the model's mode, rigid ones counted."""
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

    @property
    def fits(self) -> bool:
        """Whether shape and frequency do."""
        return does_fit(self.mac, self.frequency_test, self.frequency_model)


def does_fit(mac: float, frequency_test: float, frequency_model: float) -> bool:
    """Whether shape and frequency of a pair are alike."""
    return mac >= GOOD_MAC and abs(frequency_model / frequency_test - 1.0) <= GOOD_HZ


@dataclass(frozen=True)
class ModeFit:
    """A model's modes against a test's, without their shapes."""

    frequencies_test: FloatArray
    """(n_test,) Hz"""
    damping_test: FloatArray
    """(n_test,) share of critical; nan where it is not known."""
    frequencies_model: FloatArray
    """(n_model,) Hz, rigid ones first."""
    rigid: int
    """Modes of the model that are rigid."""
    mac: FloatArray
    """(n_test, n_model)"""
    auto_mac_test: FloatArray
    """(n_test, n_test)"""
    collinearity: FloatArray
    """(n_test,) modal phase collinearity, 1: real."""
    pairs: tuple[ModePair, ...]
    notes: tuple[str, ...]

    @property
    def of_one_channel(self) -> bool:
        """Whether all shapes that move are alike at the sensors, as at a single one: MAC is 1 of any two of them."""
        model, test = (np.isclose(mac, 1.0, rtol=0.0, atol=ALIKE) for mac in (self.mac, self.auto_mac_test))
        return bool(test.all() and model.sum() > 1 and (model | (self.mac == 0.0)).all())

    @property
    def alone_test(self) -> list[int]:
        """Measured modes without partner."""
        return sorted(set(range(self.frequencies_test.size)) - {p.test for p in self.pairs})

    @property
    def alone_model(self) -> list[int]:
        """Elastic modes of the model without partner, up to the highest measured frequency."""
        top, paired = float(self.frequencies_test.max()), {p.model for p in self.pairs}
        f = self.frequencies_model
        return [k for k in range(self.rigid, f.size) if k not in paired and f[k] <= top]

    def as_dict(self) -> dict[str, Any]:
        """As plain numbers, for JSON; modes count from 1."""
        f = self.frequencies_model
        test = zip(self.frequencies_test, self.damping_test, self.collinearity, strict=True)
        return {
            "test_modes": [
                {"frequency": float(hz), "damping": float(zeta), "phase_collinearity": float(mpc)}
                for hz, zeta, mpc in test
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
            "test_without_partner": [
                {"mode": k + 1, "frequency": float(self.frequencies_test[k])} for k in self.alone_test
            ],
            "model_without_partner": [{"mode": k + 1, "frequency": float(f[k])} for k in self.alone_model],
            "mac": self.mac.tolist(),
            "auto_mac_test": self.auto_mac_test.tolist(),
            "notes": list(self.notes),
        }
