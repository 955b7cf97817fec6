"""Sound as a WAV file whose metadata say what full scale is in pascal; written, and read back."""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.complete_file import complete_file, write_bytes
from creak.formats.deck.command_files import plain_file

RATE = 48_000
"""Hz, written unless another rate is given."""
KINDS = {"16": (1, 16), "24": (1, 24), "float": (3, 32)}
"""Samples as they are asked for -> format tag, bits."""
EXTENSIBLE = 0xFFFE
REFERENCE = 2e-5
"""Pa, 0 dB."""
CALIBRATION = re.compile(r"full scale (?P<pascal>[-+.\deE]+) Pa")
LARGEST = 2**32 - 1
"""Bytes that the format can count."""
FMT_SIZE = 16
CHUNK_HEAD = 8


@dataclass(frozen=True)
class Sound:
    """What a WAV file holds."""

    samples: FloatArray
    """(n,) or (n, channels); Pa where `full_scale` is known, else 1 is full scale."""
    rate: int
    """Hz."""
    full_scale: float | None
    """Pa of the largest sample; None: the file does not say."""


def full_scale_for(pressure: FloatArray) -> float:
    """Pa: the least full scale that holds the pressure, whose sine has a whole number of dB; 0 dB for silence."""
    peak = float(np.abs(pressure).max(initial=0.0))
    return scale_of(max(0, math.ceil(full_scale_level(peak) - 1e-9))) if peak > 0.0 else scale_of(0)


def full_scale_level(full_scale: float) -> float:
    """dB re 20 uPa of a sine with this peak, Pa."""
    return 20.0 * math.log10(full_scale / (math.sqrt(2.0) * REFERENCE))


def scale_of(level: float) -> float:
    """Peak in Pa of a sine of `level` dB re 20 uPa."""
    return float(math.sqrt(2.0) * REFERENCE * 10.0 ** (level / 20.0))


def write_wav(
    path: str | Path, pressure: FloatArray, rate: float = RATE, *, samples: str = "24", full_scale: float | None = None
) -> float:
    """Write pressure as a WAV file; returns its full scale in Pa, which the file tells in the comment of its INFO list.

    Parameters
    ----------
    pressure : (n,) or (n, channels) Pa, already at `rate`. rate : whole Hz.
    samples : "16", "24" bits, or "float" of 32.
    full_scale : Pa of the largest sample; `full_scale_for` unless given. Files to be compared by ear take the same.

    Raises
    ------
    InputError : no finite numbers, a pressure above full scale, an unknown kind of samples, a rate that is not whole, a
        file beyond 4 GB, a path that cannot be written. WriteError : the disk is full, or fails.
    """
    x = np.asarray(pressure, dtype=np.float64)
    if samples not in KINDS:
        raise InputError(f"samples {samples!r} of a WAV file", expected='"16", "24" or "float"')
    if x.ndim not in (1, 2) or x.size == 0 or not np.isfinite(x).all():
        raise InputError(
            f"pressure of shape {x.shape} for {path}", expected="finite samples (n,) or (n, channels), in Pa"
        )
    if not (1 <= rate <= LARGEST and float(rate).is_integer()):
        raise InputError(f"a WAV file at {rate:g} Hz", expected="a whole number of Hz")
    peak = float(np.abs(x).max())
    scale = full_scale_for(x) if full_scale is None else float(full_scale)
    if not (math.isfinite(scale) and scale > 0.0 and peak <= scale * (1.0 + 1e-12)):
        raise InputError(
            f"a full scale of {scale:g} Pa for {path}, where the pressure reaches {peak:g} Pa",
            expected=f"at least {peak:g} Pa",
        )
    tag, bits = KINDS[samples]
    data = _packed(x / scale, bits, tag).tobytes()
    channels = 1 if x.ndim == 1 else x.shape[1]
    width = channels * bits // 8
    head = [(b"fmt ", struct.pack("<HHIIHH", tag, channels, int(rate), int(rate) * width, width, bits))]
    if tag != 1:
        head = [(b"fmt ", head[0][1] + struct.pack("<H", 0)), (b"fact", struct.pack("<I", x.shape[0]))]
    body = b"WAVE" + b"".join(_chunk(*c) for c in [*head, (b"LIST", _info(scale)), (b"data", data)])
    if len(body) > LARGEST:
        raise InputError(
            f"{len(body) / 1e9:.1f} GB of sound for {path}", expected="less than 4.3 GB, which WAV can hold"
        )
    with complete_file(Path(path)) as partial:
        write_bytes(partial, b"RIFF" + struct.pack("<I", len(body)) + body)
    return scale


def read_wav(path: str | Path) -> Sound:
    """Read a WAV file of 16, 24 or 32 bit integers or 32 bit floats; in Pa if its comment tells the full scale.

    Raises
    ------
    InputError : it cannot be read, is no WAV file, is cut off, or holds other samples.
    """
    try:
        data = plain_file(Path(path)).read_bytes()
    except OSError as error:
        raise InputError(f"cannot read {path}: {(error.strerror or str(error)).lower()}") from error
    if data[:4] != b"RIFF" or data[8:12] != b"WAVE":
        raise InputError(f"{path} is no WAV file", expected="RIFF and WAVE at its start")
    chunks = dict(_chunks(data, path))
    if b"fmt " not in chunks or b"data" not in chunks or len(chunks[b"fmt "]) < FMT_SIZE:
        raise InputError(f"{path} is no whole WAV file: it has no format or no data")
    tag, channels, rate, _, _, bits = struct.unpack_from("<HHIIHH", chunks[b"fmt "])
    if tag == EXTENSIBLE and len(chunks[b"fmt "]) >= FMT_SIZE + 10:
        (tag,) = struct.unpack_from("<H", chunks[b"fmt "], FMT_SIZE + 8)
    if (tag, bits) not in (*KINDS.values(), (1, 32)) or channels == 0:
        raise InputError(
            f"{path} has samples of format {tag} with {bits} bits in {channels} channels",
            expected="integers of 16, 24 or 32 bits, or floats of 32",
        )
    x = _unpacked(chunks[b"data"], bits, tag, channels)
    found = CALIBRATION.search(chunks.get(b"LIST", b"").decode("latin-1"))
    scale = _number(found["pascal"]) if found else None
    return Sound(x if scale is None else x * scale, rate, scale)


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and value > 0.0 else None


def _chunk(name: bytes, data: bytes) -> bytes:
    return name + struct.pack("<I", len(data)) + data + b"\0" * (len(data) % 2)


def _info(scale: float) -> bytes:
    """The INFO list: comment with the calibration, and the program."""
    said = f"full scale {scale!r} Pa; a full-scale sine is {full_scale_level(scale):.2f} dB re 20 uPa"
    return b"INFO" + _chunk(b"ICMT", said.encode("ascii") + b"\0") + _chunk(b"ISFT", b"creak\0")


def _chunks(data: bytes, path: str | Path) -> Iterator[tuple[bytes, bytes]]:
    """Name and content of every chunk, the last of a name at the end; of LIST chunks only INFO."""
    at = 12
    while at + CHUNK_HEAD <= len(data):
        name, size = data[at : at + 4], struct.unpack_from("<I", data, at + 4)[0]
        content = data[at + CHUNK_HEAD : at + CHUNK_HEAD + size]
        if len(content) < size:
            raise InputError(
                f"{path} is cut off: {name.decode('latin-1').strip()} has {len(content):,} of {size:,} bytes"
            )
        if name != b"LIST" or content[:4] == b"INFO":
            yield name, content
        at += CHUNK_HEAD + size + size % 2


def _packed(x: FloatArray, bits: int, tag: int) -> NDArray[np.generic]:
    """Samples within -1 to 1 as they are stored."""
    if tag != 1:
        return x.astype("<f4")
    half = 2 ** (bits - 1)
    whole = np.clip(np.rint(x * half), -half, half - 1).astype("<i4")
    if bits == 16:
        return whole.astype("<i2")
    return np.ascontiguousarray(np.ascontiguousarray(whole).view(np.uint8).reshape(-1, 4)[:, :3])


def _unpacked(data: bytes, bits: int, tag: int, channels: int) -> FloatArray:
    """Samples (n,) or (n, channels) between -1 and 1; an unfinished last frame is left out."""
    frame = channels * bits // 8
    raw = np.frombuffer(data[: len(data) // frame * frame], np.uint8)
    if tag != 1:
        x = raw.view("<f4").astype(np.float64)
    elif bits == 24:
        whole = np.zeros((raw.size // 3, 4), np.uint8)
        whole[:, 1:] = raw.reshape(-1, 3)
        x = whole.view("<i4")[:, 0] / 2.0**31
    else:
        x = raw.view(f"<i{bits // 8}") / 2.0 ** (bits - 1)
    return np.asarray(x if channels == 1 else x.reshape(-1, channels), dtype=np.float64)
