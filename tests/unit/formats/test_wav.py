"""WAV files: what other programs read of them, and that they come back with their pascals."""

from __future__ import annotations

import shutil
import struct
import subprocess
import wave

import numpy as np
import pytest
from scipy.io import wavfile

from creak.errors import InputError
from creak.formats.wav import full_scale_for, full_scale_level, read_wav, scale_of, write_wav

STEP = {"16": 2.0**-15, "24": 2.0**-23, "float": 2.0**-24}
"""Half of it, of full scale, is the largest error of a sample; a whole one where the peak is full scale itself."""


@pytest.fixture
def pressure():
    return 0.3 * np.sin(0.05 * np.arange(4801)) * np.exp(-np.arange(4801) / 3000)


@pytest.mark.parametrize("samples", STEP)
@pytest.mark.parametrize("channels", [1, 2])
def test_pascals_come_back(tmp_path, pressure, samples, channels):
    given = pressure if channels == 1 else np.column_stack([pressure, -0.5 * pressure])
    scale = write_wav(tmp_path / "a.wav", given, samples=samples)
    found = read_wav(tmp_path / "a.wav")
    assert found.full_scale == scale
    assert found.rate == 48_000
    assert found.samples.shape == given.shape
    assert np.abs(found.samples - given).max() <= 0.51 * STEP[samples] * scale


@pytest.mark.parametrize("samples", ["16", "24"])
def test_the_standard_library_reads_it(tmp_path, pressure, samples):
    scale = write_wav(tmp_path / "a.wav", pressure, samples=samples)
    with wave.open(str(tmp_path / "a.wav")) as file:
        assert file.getparams()[:4] == (1, int(samples) // 8, 48_000, pressure.size)
        raw = np.frombuffer(file.readframes(pressure.size), np.uint8).reshape(pressure.size, -1)
    whole = np.zeros((pressure.size, 4), np.uint8)
    whole[:, 4 - raw.shape[1] :] = raw
    assert whole.view("<i4")[:, 0] / 2.0**31 * scale == pytest.approx(pressure, abs=STEP[samples] * scale)


@pytest.mark.parametrize("samples", STEP)
def test_scipy_reads_it(tmp_path, pressure, samples):
    scale = write_wav(tmp_path / "a.wav", pressure, samples=samples)
    rate, found = wavfile.read(tmp_path / "a.wav")
    full = {"16": 2.0**15, "24": 2.0**31, "float": 1.0}[samples]
    assert rate == 48_000
    assert found.astype(float) / full * scale == pytest.approx(pressure, abs=STEP[samples] * scale)


@pytest.mark.skipif(shutil.which("sox") is None, reason="sox is not installed")
@pytest.mark.parametrize("samples", STEP)
def test_sox_reads_it_with_its_comment(tmp_path, pressure, samples):
    scale = write_wav(tmp_path / "a.wav", pressure, samples=samples)
    said = subprocess.run(["sox", "--info", "a.wav"], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "48000" in said.stdout
    assert f"full scale {scale!r} Pa" in said.stdout
    raw = subprocess.run(
        ["sox", "a.wav", "-t", "raw", "-e", "floating-point", "-b", "64", "-"],
        cwd=tmp_path,
        capture_output=True,
        check=True,
    )
    assert np.frombuffer(raw.stdout) * scale == pytest.approx(pressure, abs=STEP[samples] * scale)


def test_other_programs_files_are_read(tmp_path):
    """32 bit integers, an extensible head, chunks in between, and no calibration."""
    x = np.array([0, 2**30, -(2**31)], dtype="<i4")
    wavfile.write(tmp_path / "a.wav", 44_100, x)
    found = read_wav(tmp_path / "a.wav")
    assert found.full_scale is None
    assert found.rate == 44_100
    assert found.samples.tolist() == [0.0, 0.5, -1.0]
    head = struct.pack("<HHIIHHHHIH14x", 0xFFFE, 1, 8000, 16000, 2, 16, 22, 16, 4, 1)
    body = b"WAVEfmt " + struct.pack("<I", len(head)) + head + b"junk\x01\0\0\0x\0" + b"data\x02\0\0\0\0\x40"
    (tmp_path / "b.wav").write_bytes(b"RIFF" + struct.pack("<I", len(body)) + body)
    assert read_wav(tmp_path / "b.wav").samples.tolist() == [0.5]


def test_full_scale_is_a_whole_number_of_db_that_holds_the_peak():
    assert full_scale_for(np.array([0.0, -1.0])) == pytest.approx(scale_of(91))
    assert full_scale_for(np.array([scale_of(77)])) == pytest.approx(scale_of(77))
    assert full_scale_for(np.zeros(3)) == full_scale_for(np.array([1e-9])) == scale_of(0)
    assert full_scale_level(2 * 2**0.5) == pytest.approx(100.0)


def test_the_same_full_scale_keeps_files_comparable(tmp_path, pressure):
    """The louder one is louder, sample by sample."""
    for name, factor in [("a", 1.0), ("b", 0.25)]:
        write_wav(tmp_path / f"{name}.wav", factor * pressure, samples="float", full_scale=1.0)
    a, b = (wavfile.read(tmp_path / f"{name}.wav")[1] for name in "ab")
    assert 0.25 * a == pytest.approx(b)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"pressure": np.array([0.0, np.nan])}, "finite"),
        ({"pressure": np.zeros(0)}, "shape"),
        ({"full_scale": 0.1}, r"reaches 0\.3"),
        ({"full_scale": float("inf")}, "inf"),
        ({"samples": "8"}, "'8'"),
        ({"rate": 44_100.5}, "whole"),
        ({"path": "missing/a.wav"}, "cannot write"),
    ],
)
def test_what_cannot_be_written(tmp_path, monkeypatch, change, message):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=message):
        write_wav(**{"path": "a.wav", "pressure": np.array([0.3, -0.1]), **change})
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda b: b"", "no WAV"),
        (lambda b: b[:60], "cut off|no whole"),
        (lambda b: b[:-10], "cut off"),
        (lambda b: b[:20] + b"\x07" + b[21:], "format 7"),
        (lambda b: b[:12], "no whole"),
    ],
)
def test_what_cannot_be_read(tmp_path, pressure, spoil, message):
    file = tmp_path / "a.wav"
    write_wav(file, pressure)
    file.write_bytes(spoil(file.read_bytes()))
    with pytest.raises(InputError, match=message):
        read_wav(file)


def test_a_missing_file_says_so(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_wav(tmp_path / "none.wav")
