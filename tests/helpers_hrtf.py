"""A rigid sphere by its exact series, measured in a laboratory: the SOFA file of its ears."""

from __future__ import annotations

import h5py
import numpy as np
from scipy.special import eval_legendre, spherical_jn, spherical_yn

from creak.sound.head import RADIUS
from creak.sound.rayleigh import AIR

RATE, N = 44_100, 256
LATE = 60
"""Samples of a response before sound would come to the middle of the head."""


def exact(freq, cosine) -> np.ndarray:
    """(n, f) pressure on a rigid sphere of a plane wave over that in the middle without it.

    p = sum (2n+1) i^(n+1) P_n(cos) / ((ka)^2 h_n'(ka)) with time as e^(-i omega t), conjugated (Morse and Ingard, 8.2).
    """
    ka = 2 * np.pi * freq * RADIUS / AIR.speed
    out = np.zeros((cosine.size, freq.size), dtype=complex)
    for n in range(60):
        with np.errstate(all="ignore"):
            slope = spherical_jn(n, ka, derivative=True) + 1j * spherical_yn(n, ka, derivative=True)
            term = (2 * n + 1) * (-1j) ** (n - 1) / (ka**2 * slope)
        out += np.where(np.isfinite(term), term, 0.0) * eval_legendre(n, cosine)[:, None]
    return out.conj()


def grid(step: float = 10.0) -> np.ndarray:
    """(m, 2) azimuth and elevation, degrees, from 50 below on: laboratories have no loudspeaker under the chair."""
    rings = [(a, e) for e in np.arange(-50.0, 90.0, step) for a in np.arange(0.0, 360.0, step)]
    return np.array([*rings, (0.0, 90.0)])


def unit(angles) -> np.ndarray:
    a, e = np.radians(angles).T
    return np.stack([np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)], axis=1)


def responses(directions) -> np.ndarray:
    """(m, 2, n) impulse responses of both ears, LATE samples late."""
    freq = np.fft.rfftfreq(4 * N, 1 / RATE)[1:]
    out = []
    for side in (1.0, -1.0):
        h = exact(freq, side * directions[:, 1]) * np.exp(-2j * np.pi * freq * LATE / RATE)
        out.append(np.fft.irfft(np.hstack([np.ones((len(h), 1)), h]), 4 * N)[:, :N])
    return np.stack(out, axis=1)


def write_sofa(path, angles, ir, **changes) -> None:
    """As SimpleFreeFieldHRIR has it, in what a test changes of it."""
    data = {
        "Data.IR": ir,
        "Data.SamplingRate": np.array([float(RATE)]),
        "Data.Delay": np.zeros((1, 2)),
        "SourcePosition": np.hstack([angles, np.full((len(angles), 1), 1.5)]),
    }
    attributes = {"Conventions": "SOFA", "SOFAConventions": "SimpleFreeFieldHRIR", "DataType": "FIR"}
    kinds = {"SourcePosition": "spherical"} | changes.pop("kinds", {})
    attributes |= changes.pop("attributes", {})
    units = changes.pop("units", {})
    data |= {key.replace("_", "."): value for key, value in changes.items()}
    with h5py.File(path, "w") as file:
        file.attrs.update(attributes)
        for name, value in data.items():
            if value is not None:
                file[name] = value
        for name, kind in kinds.items():
            file[name].attrs["Type"] = kind
        for name, unit in units.items():
            file[name].attrs["Units"] = unit
