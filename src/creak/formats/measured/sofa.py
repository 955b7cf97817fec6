"""Head-related impulse responses in SOFA files (AES69), as laboratories measure and publish them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.stored.sealed import Damaged, unsealed_hdf5

CONVENTION = "a SOFA file of impulse responses at two ears, as SimpleFreeFieldHRIR has them"
AHEAD, UP = np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 1.0]])
"""Where a listener looks, and its top, in files that do not tell."""
CARTESIAN = "cartesian"
KINDS = {CARTESIAN: ("metre",), "spherical": ("degree", "degree", "metre")}
"""Of coordinates, with their units: m; degrees of azimuth and elevation, and m."""
UNITS = {"metre": "metre", "meter": "metre", "m": "metre", "degree": "degree", "deg": "degree"}
"""As files write them, some with an s."""
RATES = ("", "hertz", "hz")
UP_OFF = 0.1
"""Least sine of the angle between where a head looks and its top, which are to be at a right angle."""


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
    if (unit := _text(file["Data.SamplingRate"].attrs.get("Units", "")).strip().lower()) not in RATES:
        raise _wrong(path, f"has a sampling rate in {unit}", "Give it in hertz.")
    late = _numbers(file, path, "Data.Delay") if "Data.Delay" in file else np.zeros((1, 2))
    if late.ndim != 2 or late.shape[0] not in (1, m) or late.shape[1] not in (1, 2):
        raise _wrong(path, f"has Data.Delay of shape {late.shape}")
    source = _positions(file, path, "SourcePosition", m)
    if "ListenerPosition" in file:
        source = source - _positions(file, path, "ListenerPosition", m)
    looks = _unit(_positions(file, path, "ListenerView", m) if "ListenerView" in file else AHEAD)
    up = _unit(_positions(file, path, "ListenerUp", m, like="ListenerView") if "ListenerUp" in file else UP)
    left = np.cross(up, looks)
    if np.linalg.norm(left, axis=1).min() < UP_OFF:
        raise _wrong(path, "has a head that looks along its own top", "Correct ListenerView or ListenerUp, or Type.")
    left = _unit(left)
    axes = [np.broadcast_to(a, (m, 3)) for a in (looks, left, np.cross(looks, left))]
    found = _unit(np.stack([np.einsum("mx,mx->m", source, a) for a in axes], axis=1))
    if not np.isfinite(found).all():
        raise _wrong(path, "has a source in the middle of the head, or a head that looks nowhere")
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


def _positions(file: h5py.File, path: Path, name: str, m: int, *, like: str | None = None) -> FloatArray:
    """(m, 3) or (1, 3) m.

    Parameters
    ----------
    like : name of the variable whose Type and Units hold where this one has none of its own.
    """
    given = _numbers(file, path, name)
    if given.ndim != 2 or given.shape[1] != 3 or given.shape[0] not in (1, m):
        raise _wrong(path, f"has {name} of shape {given.shape}, expected {(m, 3)}")
    is_own = like is None or like not in file or {"Type", "Units"} & set(file[name].attrs)
    return _cartesian(given, _kind(file, path, name if like is None or is_own else like))


def _kind(file: h5py.File, path: Path, name: str) -> str:
    attributes = file[name].attrs
    kind = _text(attributes.get("Type", CARTESIAN)).strip().lower()
    if kind not in KINDS:
        raise _wrong(path, f"has {name} in {kind!r} coordinates", f"Give them {' or '.join(KINDS)}.")
    units = _text(attributes.get("Units", ""))
    words = [UNITS.get(word.rstrip("s"), word) for word in re.split(r"[\s,]+", units.strip().lower()) if word]
    if tuple(words) not in ((), KINDS[kind], KINDS[kind] * (3 // len(KINDS[kind]))):
        raise _wrong(path, f"has {name} in {units}, {kind}", f"Give it in {', '.join(KINDS[kind])}.")
    return kind


def _cartesian(given: FloatArray, kind: str) -> FloatArray:
    if kind == CARTESIAN:
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
