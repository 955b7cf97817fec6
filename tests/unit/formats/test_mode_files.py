"""Mode shapes in VTU and UFF files, read back field by field.

Recordings as pressure: calibration given, in the file or of a calibrator; what cannot be heard is refused.
"""

from __future__ import annotations

import struct

import numpy as np
import pytest

import creak
from creak.errors import InputError
from creak.formats.abaqus.reader import read_deck
from creak.formats.measured.punch import write_mode_punch
from creak.formats.measured.uff import write_uff
from creak.formats.vtu import write_vtu
from creak.formats.wav import write_wav
from helpers_punch import punched
from helpers_uff import data_sets, fields
from helpers_vtu import arrays

RECORDED = {"section": "decks", "source": "themselves"}

DECK = """\
*NODE
 10, 0., 0., 0.
 20, 1., 0., 0.
 30, 1., 1., 0.
 40, 0., 1., 0.
 50, 0., 0., 1.
 61, .5, 0., 0.
 62, .5, .5, 0.
 63, 0., .5, 0.
 64, 0., 0., .5
 65, .5, 0., .5
 66, 0., .5, .5
 70, 2., 0., -1.5
 80, 9., 9., 9.
*ELEMENT, TYPE=S4, ELSET=Q
 3, 10, 20, 30, 40
*ELEMENT, TYPE=C3D10, ELSET=T
 5, 10, 20, 40, 50, 61, 62, 63, 64, 65, 66
*ELEMENT, TYPE=B31, ELSET=B
 7, 20, 70
*ELEMENT, TYPE=MASS, ELSET=M
 9, 70
*MASS, ELSET=M
 1.
*MATERIAL, NAME=S
*ELASTIC
 210000., .3
*DENSITY
 7.85e-9
*SHELL SECTION, ELSET=Q, MATERIAL=S
 1.,
*SOLID SECTION, ELSET=T, MATERIAL=S
*BEAM SECTION, ELSET=B, MATERIAL=S, SECTION=CIRC
 .1
 0., 1., 0.
"""
FREQUENCIES = [0.0, 123.456789]


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "deck.inp"
    path.write_text(DECK)
    return read_deck(path)


@pytest.fixture
def shapes(model):
    return np.random.default_rng(3).standard_normal((2, model.nodes.count, 3)) * [[[1.0]], [[1e-120]]]


def test_vtu(model, shapes, tmp_path, measured):
    write_vtu(tmp_path / "m.vtu", model, FREQUENCIES, iter(shapes))
    found = arrays(tmp_path / "m.vtu")
    np.testing.assert_array_equal(found["Points"], model.nodes.coords)
    np.testing.assert_array_equal(found["node"], model.nodes.ids)
    np.testing.assert_allclose(found["mode_001_0_Hz"], shapes[0], rtol=1e-7)
    measured(
        "shapes in a VTU file, relative error",
        np.abs(found["mode_001_0_Hz"] / np.where(shapes[0], shapes[0], 1.0) - (shapes[0] != 0.0)).max(),
        at_most=1e-7,
    )
    assert found["mode_002_123.457_Hz"].shape == (13, 3)
    np.testing.assert_array_equal(found["frequency"], FREQUENCIES)
    cells = np.split(found["connectivity"], found["offsets"][:-1])
    kinds = {
        int(k): (int(t), model.nodes.ids[c].tolist())
        for k, t, c in zip(found["element"], found["types"], cells, strict=True)
    }
    assert kinds[3] == (9, [10, 20, 30, 40])
    assert kinds[5] == (24, [10, 20, 40, 50, 61, 62, 63, 64, 65, 66])
    assert kinds[7] == (3, [20, 70])
    assert kinds[9] == (1, [70])


def test_vtu_is_complete_or_absent(model, shapes, tmp_path):
    with pytest.raises(ValueError, match="shorter"):
        write_vtu(tmp_path / "m.vtu", model, FREQUENCIES, iter(shapes[:1]))
    assert not list(tmp_path.glob("*m.vtu*"))


def test_uff(model, shapes, tmp_path, measured):
    write_uff(tmp_path / "m.unv", model, FREQUENCIES, iter(shapes), "m-kg-s", title="a title " * 20)
    sets = data_sets(tmp_path / "m.unv")
    assert [number for number, _ in sets] == [164, 15, 2412, 82, 55, 55]
    units, nodes, elements, lines, _, mode = (content for _, content in sets)
    assert [float(x.replace("D", "E")) for x in fields(units[1], 25)] == [1.0, 1.0, 1.0]
    for line, label, x in zip(nodes, model.nodes.ids, model.nodes.coords, strict=True):
        assert int(line[:10]) == label
        assert [float(v) for v in fields(line[40:], 13)] == pytest.approx(x.tolist(), rel=1e-5)
    read = {}
    for head, *rest in (elements[:2], elements[2:]):
        number, descriptor, _, _, _, n = (int(v) for v in fields(head, 10))
        read[number, descriptor] = [int(v) for row in rest for v in fields(row, 10)]
        assert len(read[number, descriptor]) == n
    # A parabolic tetrahedron: corners 10, 20, 40, 50; each mid-side node between its corners.
    assert read == {(3, 94): [10, 20, 30, 40], (5, 118): [10, 61, 20, 62, 40, 63, 64, 65, 66, 50]}
    assert [int(v) for v in fields(lines[0], 10)][:2] == [1, 2]
    assert [int(v) for v in fields(lines[2], 10)] == [20, 70]
    assert [int(v) for v in fields(mode[5], 10)] == [1, 2, 2, 8, 2, 3]
    assert [int(v) for v in fields(mode[6], 10)] == [2, 4, 1, 2]
    assert [float(v) for v in fields(mode[7], 13)] == [123.457, 1.0, 0.0, 0.0]
    assert not any(float(v) for row in mode[9::2] for v in fields(row, 13))  # 1e-120 does not fit E13.5
    first = sets[4][1]
    assert [int(v) for v in first[8::2]] == model.nodes.ids.tolist()
    got = [[float(v) for v in fields(row, 13)] for row in first[9::2]]
    np.testing.assert_allclose(got, shapes[0], rtol=1e-5)
    measured(
        "shapes in a universal file, relative error",
        np.abs(got / np.where(shapes[0], shapes[0], 1.0) - (shapes[0] != 0.0)).max(),
        at_most=1e-5,
    )


def test_uff_numbers_the_nodes_where_instances_repeat_labels(model, shapes, tmp_path):
    ids = model.nodes.ids.copy()
    ids[:] = 1
    object.__setattr__(model.nodes, "ids", ids)
    write_uff(tmp_path / "m.unv", model, FREQUENCIES, iter(shapes))
    sets = dict(data_sets(tmp_path / "m.unv"))
    assert [int(line[:10]) for line in sets[15]] == list(range(1, 14))
    assert [int(v) for v in sets[55][8::2]] == list(range(1, 14))
    assert float(sets[164][1][:25].replace("D", "E")) == 1000.0


def test_punch(model, tmp_path, measured):
    motions = np.random.default_rng(4).standard_normal((2, model.nodes.count, 6)) * [[[1e-7]], [[1e-120]]]
    write_mode_punch(tmp_path / "m.pch", model, FREQUENCIES, iter(motions), title="a title " * 20)
    first, second = punched(tmp_path / "m.pch")
    assert first.head[3:6] == ["$EIGENVECTOR", "$REAL OUTPUT", "$SUBCASE ID =           1"]
    assert second.after("$LABEL   =") == "mode 2, 123.457 Hz"
    value, number = second.after("$EIGENVALUE =").split("MODE =")
    assert float(value) == pytest.approx((2.0 * np.pi * 123.456789) ** 2, rel=1e-7)
    assert int(number) == 2
    assert list(first.rows) == model.nodes.ids.tolist()
    got = np.array([*first.rows.values()])
    measured("shapes in a punch file, relative error", np.abs(got / motions[0] - 1.0).max(), at_most=5.1e-7)
    assert not np.array([*second.rows.values()]).any()  # 1e-120 does not fit 1PE18.6 of two digits


def test_punch_numbers_the_nodes_where_instances_repeat_labels(model, tmp_path):
    object.__setattr__(model.nodes, "ids", np.ones_like(model.nodes.ids))
    write_mode_punch(tmp_path / "m.pch", model, [1.0], iter([np.ones((13, 6))]))
    (only,) = punched(tmp_path / "m.pch")
    assert list(only.rows) == list(range(1, 14))


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
