"""Recordings of a microphone as pressure: WAV files whose calibration is in them, given, or that of a calibrator."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.wav import REFERENCE, Sound, read_wav

SHORTEST = 0.2
"""s below which there is no loudness to speak of."""
SLOWEST, FASTEST = 8_000, 10_000_000
"""Hz: slower sampling has lost what a rattle sounds like."""
WHOLE = 32_000
"""Hz of sampling that holds all bands up to 12.5 kHz but for the upper half of the last."""
FULL = 1.0 - 1e-4
"""Of full scale, from which a sample may be one that did not fit."""
IN_A_ROW = 3
"""Such samples one after the other are clipped."""
STEADY = 0.5
"""dB by which halves of a calibrator's record may differ."""
PURE = 0.9
"""Of a calibrator's energy that is in its tone."""
NEAR = 0.05
"""Of its frequency, to either side."""


@dataclass(frozen=True)
class Recording:
    """One channel."""

    name: str
    pressure: FloatArray
    """(n,) Pa, without its mean."""
    rate: float
    """Hz"""
    warnings: tuple[str, ...] = ()
    """What is wrong with it."""


def read_recordings(
    path: str | Path, calibration: float | None = None, calibrator: str | Path | None = None, level: float | None = None
) -> tuple[Recording, ...]:
    """The channels of a WAV file in Pa.

    Parameters
    ----------
    calibration : Pa of full scale, or `calibrator`, a recording with the same gain of a tone of `level` dB re 20 uPa
        (RMS). Neither is needed, or taken, of files that tell their full scale themselves, as those of creak do.

    Raises
    ------
    InputError : as `read_wav`; no calibration, or two; a record that is silent or shorter than .2 s, samples that are
        no finite numbers, a sampling rate outside 8 kHz to 10 MHz; as `calibration_of`.
    """
    name, sound = Path(path).name, read_wav(path)
    given = any(x is not None for x in (calibration, calibrator, level))
    if sound.full_scale is None and not given:
        raise InputError(
            f"{path} has no calibration: nothing says what pressure its samples are",
            expected="the pressure of full scale, or the recording of a calibrator made with the same gain",
            fix="Give --calibration PA_PER_FULL_SCALE, or --calibrator cal.wav --level 94.",
        )
    if sound.full_scale is not None and given:
        raise InputError(
            f"two calibrations of {path}: its comment says that full scale is {sound.full_scale:.4g} Pa",
            fix="Leave the other one out.",
        )
    scale = 1.0 if sound.full_scale is not None else _scale(calibration, calibrator, level)
    _check(sound, path)
    channels = sound.samples.reshape(sound.samples.shape[0], -1).T
    names = [name] if len(channels) == 1 else [f"{name} channel {k + 1}" for k in range(len(channels))]
    return tuple(_recording(n, x, sound, scale) for n, x in zip(names, channels, strict=True))


def calibration_of(path: str | Path, level: float) -> float:
    """Pa of full scale, of the recording of a calibrator whose tone has `level` dB re 20 uPa (94 is 1 Pa RMS).

    Raises
    ------
    InputError : as `read_wav`; a level outside 60 to 140 dB; more than one channel, silence, a clipped record, one that
        is no steady tone.
    """
    if not 60.0 <= level <= 140.0:
        raise InputError(f"a calibrator of {level:g} dB", expected="60 to 140 dB re 20 uPa; most have 94 or 114")
    sound = read_wav(path)
    _check(sound, path)
    if sound.samples.ndim != 1:
        raise InputError(f"{path}, the calibrator, has {sound.samples.shape[1]} channels", expected="one")
    # A file with a full scale of its own has pascals: its level is another matter, and its samples are asked for.
    x = sound.samples / (sound.full_scale or 1.0)
    x = x - x.mean()
    if _clipped(x):
        raise InputError(f"{path}, the calibrator, is clipped", fix="Record it again with less gain.")
    halves = [10.0 * np.log10(np.mean(h**2) + 1e-300) for h in np.array_split(x, 2)]
    power = np.abs(np.fft.rfft(x * np.hanning(x.size))) ** 2
    freq = np.fft.rfftfreq(x.size, 1.0 / sound.rate)
    tone = freq[int(power.argmax())]
    share = float(power[np.abs(freq - tone) <= max(NEAR * tone, 4.0 * sound.rate / x.size)].sum() / power.sum())
    if share < PURE or abs(halves[0] - halves[1]) > STEADY:
        raise InputError(
            f"{path} is no steady tone: {100 * share:.0f} % of its energy is at {tone:.0f} Hz, and its halves differ "
            f"by {abs(halves[0] - halves[1]):.1f} dB",
            expected=f"a calibrator's tone alone, {100 * PURE:.0f} % and {STEADY:g} dB",
            fix="Cut the file to where the tone is steady.",
        )
    return float(REFERENCE * 10.0 ** (0.05 * level) / np.sqrt(np.mean(x**2)))


def _scale(calibration: float | None, calibrator: str | Path | None, level: float | None) -> float:
    if calibration is not None and calibrator is not None:
        raise InputError("a calibration and a calibrator were both given", expected="one of them")
    if calibrator is not None:
        if level is None:
            raise InputError("the calibrator's level is not given", expected="its dB re 20 uPa", fix="Give --level 94.")
        return calibration_of(calibrator, level)
    if level is not None:
        raise InputError(f"a level of {level:g} dB without a calibrator", fix="Give --calibrator cal.wav, too.")
    if calibration is None or not (np.isfinite(calibration) and calibration > 0.0):
        raise InputError(f"a calibration of {calibration:g} Pa of full scale", expected="more than 0")
    return float(calibration)


def _check(sound: Sound, path: str | Path) -> None:
    """Raise InputError where a file's samples cannot be heard."""
    x = sound.samples
    if not SLOWEST <= sound.rate <= FASTEST:
        raise InputError(
            f"{path} is sampled at {sound.rate:,} Hz",
            expected=f"{SLOWEST:,} Hz to {FASTEST // 10**6} MHz, which is resampled to 48 kHz",
            fix="Slower sampling has lost what a rattle sounds like: record it again.",
        )
    if x.shape[0] < SHORTEST * sound.rate:
        raise InputError(f"{path} has {x.shape[0] / sound.rate:.3g} s", expected=f"{SHORTEST:g} s or more")
    if not np.isfinite(x).all():
        raise InputError(f"{path} has samples that are no finite numbers")
    still = np.flatnonzero(np.ptp(x.reshape(x.shape[0], -1), axis=0) == 0.0)
    if still.size:
        which = f"channel {still[0] + 1} of " if x.ndim > 1 else ""
        raise InputError(f"{which}{path} is silent: all its samples are equal", expected="a sound")


def _recording(name: str, x: FloatArray, sound: Sound, scale: float) -> Recording:
    warnings = []
    if _clipped(x / (sound.full_scale or 1.0)):
        warnings.append(f"{name} is clipped: its peaks were higher, and all its figures are off")
    if sound.rate < WHOLE:
        warnings.append(f"{name} is sampled at {sound.rate:,} Hz: it has nothing above {sound.rate // 2:,} Hz")
    return Recording(name, scale * (x - x.mean()), float(sound.rate), tuple(warnings))


def _clipped(x: FloatArray) -> bool:
    """Whether samples, 1 is full scale, stay at it."""
    for full in (x >= FULL, x <= -FULL):
        if np.convolve(full, np.ones(IN_A_ROW), "valid").max(initial=0.0) > IN_A_ROW - 0.5:
            return True
    return False
