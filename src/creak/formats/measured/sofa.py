"""Head-related impulse responses in SOFA files (AES69), as laboratories measure and publish them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.stored.sealed_hdf5 import Damaged, unsealed_hdf5

CONVENTION = "a SOFA file of impulse responses at two ears, as SimpleFreeFieldHRIR has them"
AHEAD, UP = np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 1.0]])
"""Where a listener looks, and its top, in files that do not tell."""
KINDS = ("cartesian", "spherical")
"""Of coordinates: m; degrees of azimuth and elevation, and m."""


@dataclass(frozen=True)
class HeadResponses:
    """What was measured at the ears of a head."""

    directions: FloatArray
    """(m, 3) of length 1, where sound came from: ahead, left and up of the head."""
    responses: FloatArray
    """(m, 2, n), left and right ear."""
    rate: float
    """Hz"""
    delay: FloatArray
    """(m, 2) s that a response begins later than its first sample."""


def head_responses(path: Path, where: str) -> HeadResponses:
    """Read a SOFA file. where: of its name, for messages.

    Raises
    ------
    InputError : no such file, or no SOFA file; not two ears, not impulse responses; numbers that are not finite;
        directions that are none.
    """
    try:
        with unsealed_hdf5(path) as file:
            return _read(file, path)
    except FileNotFoundError as error:
        raise InputError(f"no such file: {path}", where=where, fix="Check the path.") from error
    except (OSError, Damaged) as error:
        known = isinstance(error, PermissionError | Damaged) or h5py.is_hdf5(path)
        what = f"cannot be read: {error}" if known else "is no HDF5 file, as SOFA files are"
        raise _wrong(path, what) from error


def _wrong(path: Path, what: str, fix: str = "Export or download it again.") -> InputError:
    return InputError(f"{path.name} {what}", where=path, expected=CONVENTION, fix=fix)


def _read(file: h5py.File, path: Path) -> HeadResponses:
    if _text(file.attrs.get("Conventions", "")) != "SOFA":
        raise _wrong(path, "is no SOFA file: its attribute Conventions is not SOFA")
    kind, named = _text(file.attrs.get("DataType", "")), _text(file.attrs.get("SOFAConventions", "?"))
    if kind != "FIR":
        raise _wrong(path, f"holds {named} with data of type {kind or '?'}", "Export impulse responses (FIR).")
    responses = _numbers(file, path, "Data.IR")
    if responses.ndim != 3 or responses.shape[1] != 2 or not responses.shape[2]:
        raise _wrong(path, f"has Data.IR of shape {responses.shape}, directions by ears by samples", "Give two ears.")
    if not np.abs(responses).any(axis=2).all():
        raise _wrong(path, "has a response that is all zero")
    m, rate = len(responses), _numbers(file, path, "Data.SamplingRate").ravel()
    if rate.size not in (1, m) or rate.min() <= 0.0 or np.ptp(rate) > 0.0:
        raise _wrong(path, f"has sampling rates of {rate.min():g} to {rate.max():g} Hz", "Give one, above 0.")
    late = _numbers(file, path, "Data.Delay") if "Data.Delay" in file else np.zeros((1, 2))
    if late.ndim != 2 or late.shape[0] not in (1, m) or late.shape[1] not in (1, 2):
        raise _wrong(path, f"has Data.Delay of shape {late.shape}")
    source = _positions(file, path, "SourcePosition", m)
    if "ListenerPosition" in file:
        source = source - _positions(file, path, "ListenerPosition", m)
    looks = _unit(_positions(file, path, "ListenerView", m) if "ListenerView" in file else AHEAD)
    up = _unit(_positions(file, path, "ListenerUp", m) if "ListenerUp" in file else UP)
    left = _unit(np.cross(up, looks))
    axes = [np.broadcast_to(a, (m, 3)) for a in (looks, left, np.cross(looks, left))]
    found = _unit(np.stack([np.einsum("mx,mx->m", source, a) for a in axes], axis=1))
    if not np.isfinite(found).all():
        raise _wrong(path, "has a source in the middle of the head, or a head that looks along its own top")
    if "ReceiverPosition" in file and _right_first(file, path):
        responses, late = responses[:, ::-1], late[:, ::-1]
    return HeadResponses(found, responses, float(rate[0]), np.broadcast_to(late, (m, 2)) / float(rate[0]))


def _right_first(file: h5py.File, path: Path) -> bool:
    """Whether the first ear is the right one, by where the ears are on the head, left being +y."""
    ears = _numbers(file, path, "ReceiverPosition")
    ears = ears.reshape(ears.shape[0], 3, -1)[:, :, 0] if ears.ndim in (2, 3) and ears.shape[1] == 3 else ears
    if ears.shape != (2, 3):
        raise _wrong(path, f"has ReceiverPosition of shape {ears.shape}, ears by coordinates", "Give two ears.")
    y = _cartesian(ears, _kind(file, path, "ReceiverPosition"))[:, 1]
    return bool(y[0] < y[1])


def _positions(file: h5py.File, path: Path, name: str, m: int) -> FloatArray:
    """(m, 3) or (1, 3) m."""
    given = _numbers(file, path, name)
    if given.ndim != 2 or given.shape[1] != 3 or given.shape[0] not in (1, m):
        raise _wrong(path, f"has {name} of shape {given.shape}, expected {(m, 3)}")
    return _cartesian(given, _kind(file, path, name))


def _kind(file: h5py.File, path: Path, name: str) -> str:
    kind = _text(file[name].attrs.get("Type", KINDS[0])).lower()
    if kind not in KINDS:
        raise _wrong(path, f"has {name} in {kind!r} coordinates", f"Give them {' or '.join(KINDS)}.")
    return kind


def _cartesian(given: FloatArray, kind: str) -> FloatArray:
    if kind == KINDS[0]:
        return given
    azimuth, elevation = np.radians(given[:, 0]), np.radians(given[:, 1])
    flat = given[:, 2] * np.cos(elevation)
    return np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), given[:, 2] * np.sin(elevation)], axis=1)


def _unit(x: FloatArray) -> FloatArray:
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(x / np.linalg.norm(x, axis=1, keepdims=True))


def _numbers(file: h5py.File, path: Path, name: str) -> FloatArray:
    item = file.get(name)
    if not isinstance(item, h5py.Dataset) or item.dtype.kind not in "iuf" or not item.size:
        raise _wrong(path, f"has no numbers {name}")
    found = np.asarray(item[()], dtype=float)
    if not np.isfinite(found).all():
        raise _wrong(path, f"has {name} with what is no number")
    return found


def _text(value: object) -> str:
    if isinstance(value, np.ndarray):
        value = value.ravel()[0] if value.size else ""
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)
