"""Recordings as pressure: calibration given, in the file or of a calibrator; what cannot be heard is refused."""

from __future__ import annotations

import struct

import numpy as np
import pytest

import creak
from creak.errors import InputError
from creak.formats.wav import write_wav

RATE = 48_000
PASCAL = 20.0
"""Of full scale, in these tests."""


def tone(level: float, freq: float = 1000.0, seconds: float = 0.5, rate: int = RATE) -> np.ndarray:
    """Pa."""
    return 2e-5 * 2**0.5 * 10 ** (level / 20) * np.sin(2 * np.pi * freq * np.arange(int(seconds * rate)) / rate)


def plain_wav(path, fractions: np.ndarray, rate: int = RATE) -> None:
    """16 bits without a word on full scale; fractions (n,) or (n, channels) of it."""
    x = np.clip(np.rint(fractions * 32768), -32768, 32767).astype("<i2")
    channels = 1 if x.ndim == 1 else x.shape[1]
    head = struct.pack("<HHIIHH", 1, channels, rate, 2 * channels * rate, 2 * channels, 16)
    body = b"WAVEfmt " + struct.pack("<I", 16) + head + b"data" + struct.pack("<I", x.nbytes) + x.tobytes()
    path.write_bytes(b"RIFF" + struct.pack("<I", len(body)) + body)


@pytest.fixture
def wav(tmp_path):
    def write(fractions, name="car.wav", rate=RATE):
        plain_wav(tmp_path / name, fractions, rate)
        return tmp_path / name

    return write


def level(x: np.ndarray) -> float:
    return 20 * np.log10(x.std() / 2e-5)


def test_calibration_is_the_pressure_of_full_scale(wav):
    (found,) = creak.read_recordings(wav(tone(80) / PASCAL + 0.01), calibration=PASCAL)
    assert level(found.pressure) == pytest.approx(80.0, abs=0.01)
    assert found.pressure.mean() == pytest.approx(0.0, abs=1e-12)
    assert (found.name, found.rate, found.warnings) == ("car.wav", RATE, ())


def test_a_calibrator_of_the_same_gain_makes_pascals(wav):
    """A tone of 94 dB at half of full scale: full scale is 2 sqrt(2) Pa."""
    calibrator = wav(0.5 * tone(94.0) / tone(94.0).max(), "cal.wav")
    (found,) = creak.read_recordings(wav(0.05 * np.sin(np.arange(RATE) / 9)), calibrator=calibrator, level=93.979)
    assert np.abs(found.pressure).max() == pytest.approx(0.1 * 2**0.5, rel=2e-3)


def test_files_of_creak_tell_their_own(tmp_path):
    write_wav(tmp_path / "own.wav", tone(70))
    (found,) = creak.read_recordings(tmp_path / "own.wav")
    assert level(found.pressure) == pytest.approx(70.0, abs=0.01)
    with pytest.raises(InputError, match="two calibrations"):
        creak.read_recordings(tmp_path / "own.wav", calibration=1.0)


def test_channels_are_recordings_of_their_own(wav):
    both = np.stack([tone(80), tone(60)], axis=1) / PASCAL
    found = creak.read_recordings(wav(both), calibration=PASCAL)
    assert [r.name for r in found] == ["car.wav channel 1", "car.wav channel 2"]
    assert [level(r.pressure) for r in found] == pytest.approx([80.0, 60.0], abs=0.1)


def test_clipped_samples_and_slow_sampling_are_told(wav):
    (clipped,) = creak.read_recordings(wav(np.clip(1.2 * np.sin(np.arange(RATE) / 20), -1, 1)), calibration=PASCAL)
    assert "clipped" in clipped.warnings[0]
    (whole,) = creak.read_recordings(wav(0.999 * np.sin(np.arange(RATE) / 20)), calibration=PASCAL)
    assert whole.warnings == ()
    (slow,) = creak.read_recordings(wav(tone(80, rate=16_000) / PASCAL, rate=16_000), calibration=PASCAL)
    assert "nothing above 8,000 Hz" in slow.warnings[0]


NOISE = 0.1 * np.random.default_rng(4).standard_normal(RATE)
STEPS = np.concatenate([np.full(RATE, 0.1), np.full(RATE, 0.5)]) * np.sin(np.arange(2 * RATE) / 7)


@pytest.mark.parametrize(
    ("fractions", "rate", "given", "message"),
    [
        (NOISE, RATE, {}, "has no calibration"),
        (NOISE, RATE, {"calibration": 0.0}, "a calibration of 0 Pa"),
        (NOISE, RATE, {"calibration": float("nan")}, "a calibration of nan Pa"),
        (NOISE, RATE, {"calibration": 1.0, "calibrator": "cal.wav", "level": 94.0}, "both given"),
        (NOISE, RATE, {"calibrator": "cal.wav"}, "level is not given"),
        (NOISE, RATE, {"calibration": 1.0, "level": 94.0}, "without a calibrator"),
        (np.full(RATE, 0.2), RATE, {"calibration": 1.0}, "is silent"),
        (np.stack([NOISE, 0 * NOISE], axis=1), RATE, {"calibration": 1.0}, "channel 2 of .* is silent"),
        (NOISE[:9000], RATE, {"calibration": 1.0}, "has 0.188 s"),
        (NOISE, 4000, {"calibration": 1.0}, "sampled at 4,000 Hz"),
    ],
)
def test_what_cannot_be_heard_gets_one_clear_message(wav, fractions, rate, given, message):
    with pytest.raises(InputError, match=message):
        creak.read_recordings(wav(fractions, rate=rate), **given)


@pytest.mark.parametrize(
    ("fractions", "level", "message"),
    [
        (NOISE, 94.0, "no steady tone"),
        (STEPS, 94.0, "no steady tone"),
        (np.clip(2 * np.sin(np.arange(RATE) / 7), -1, 1), 94.0, "is clipped"),
        (np.stack([NOISE, NOISE], axis=1), 94.0, "has 2 channels"),
        (0.5 * np.sin(np.arange(RATE) / 7), 9.4, "a calibrator of 9.4 dB"),
    ],
)
def test_a_calibrator_must_be_its_tone_alone(wav, fractions, level, message):
    calibrator = wav(fractions, "cal.wav")
    with pytest.raises(InputError, match=message):
        creak.read_recordings(wav(NOISE), calibrator=calibrator, level=level)
