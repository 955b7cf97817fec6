"""What is read of files of measured modes, and what damaged ones end in.

Units as files of tests spell them.
Histories in punch and universal files where several points are at one node, and names that are no plain text.
"""

from __future__ import annotations

import random
from dataclasses import replace

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.measured.histories import Histories, write_punch, write_universal
from creak.formats.measured.mode_files import read_measured_modes
from creak.formats.measured.unit_words import plain_unit
from creak.formats.stored.results import LineRecord
from helpers_modal import (
    Test,
    complex_mode,
    csv_text,
    data_set,
    every_mode,
    frames_2420,
    normal_mode,
    points_15,
    units_164,
)
from helpers_punch import punched
from helpers_uff import data_sets

WRITTEN_BY_PYUFF = """\
    -1
  2411
         4         1         1         1
   3.0000000000000000e+01   0.0000000000000000e+00  -5.0000000000000000e-01
    -1
    -1
    55
a
b
c
d
e
         1         3         2         8         5         6
         2         6         1         1
 -3.71523e+00  3.69333e+02  1.00000e+00  0.00000e+00  1.00000e+00  0.00000e+00
         4
  1.00000e+00 -2.00000e+00  0.00000e+00  0.00000e+00 -4.31574e+01  2.00000e+00
    -1
"""
"""As pyuff 2.5.8 (MIT) writes a point and a complex mode: small letters, values at a node counted twice."""


@pytest.fixture(scope="module")
def t():
    rng = np.random.default_rng(3)
    shapes = rng.normal(size=(3, 5, 3))
    return Test(
        [1, 2, 3, 4, 9],
        100.0 * rng.normal(size=(5, 3)),
        shapes,
        np.array([50.0, 75.5, 120.0]),
        np.array([0.01, 0.02, 0.005]),
    )


def read(tmp_path, text, ending="unv"):
    path = tmp_path / f"test.{ending}"
    path.write_text(text, encoding="utf-8", newline="")
    return read_measured_modes(path)


def test_every_field_of_a_universal_file(t, tmp_path):
    lines = data_set(82, f"{1:10d}{6:10d}{7:10d}", "LINE", "".join(f"{n:10d}" for n in (1, 2, 3, 0, 4, 9)))
    found = read(tmp_path, units_164(1000.0) + points_15(t) + lines + every_mode(t))
    assert found.frequencies.tolist() == t.frequencies.tolist()
    np.testing.assert_allclose(found.damping, t.damping)
    assert found.sensors == tuple(str(n) for n in t.labels for _ in "xyz")
    np.testing.assert_allclose(found.points, np.repeat(t.points, 3, axis=0), rtol=6e-6)
    np.testing.assert_array_equal(found.directions, np.tile(np.eye(3), (5, 1)))
    np.testing.assert_allclose(found.shapes, t.shapes.reshape(3, 15).T, rtol=6e-6)
    assert found.per_metre == 1000.0
    assert found.lines == (("1", "2"), ("2", "3"), ("4", "9"))
    assert found.notes == ()


def test_a_file_of_another_program(tmp_path):
    found = read(tmp_path, WRITTEN_BY_PYUFF)
    size = np.hypot(3.71523, 369.333)
    assert found.frequencies[0] == pytest.approx(size / (2.0 * np.pi))
    assert found.damping[0] == pytest.approx(3.71523 / size)
    assert found.shapes[:, 0].tolist() == [1.0 - 2.0j, -43.1574 + 2.0j]
    np.testing.assert_array_equal(found.points, [[30.0, 0.0, -0.5]] * 2)
    np.testing.assert_array_equal(found.directions, [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    assert found.notes == ("no point has values in y, which counts as not measured",)


def phased(t):
    return replace(t, shapes=t.shapes * np.exp(1j * np.random.default_rng(5).normal(size=t.shapes.shape)))


def test_a_mode_stands_in_the_file_by_either_eigenvalue(t, tmp_path):
    """Both of the first, the upper one of the second, the lower one of the third: three modes, however they lie."""
    t = phased(t)
    uppers = [complex_mode(t, k) for k in (0, 1)]
    lowers = [complex_mode(t, k, np.conj(t.shapes[k]), sign=-1.0) for k in (0, 2)]
    for order in (uppers + lowers, lowers + uppers, lowers[::-1] + uppers[::-1]):
        found = read(tmp_path, points_15(t) + "".join(order))
        np.testing.assert_allclose(found.frequencies, t.frequencies, rtol=1e-5)
        np.testing.assert_allclose(found.damping, t.damping, rtol=1e-3)
        np.testing.assert_allclose(found.shapes, t.shapes.reshape(3, 15).T, rtol=1e-5)
        assert found.notes == (
            "1 conjugate modes are left out",
            "1 modes stand with their lower eigenvalue alone: their conjugates are taken",
        )


def test_a_lower_eigenvalue_of_another_shape_is_another_mode(t, tmp_path):
    """Two modes of one frequency, as a disk has them, one of which is told by its lower eigenvalue."""
    t = phased(replace(t, frequencies=np.array([50.0, 50.0, 120.0]), damping=np.full(3, 0.01)))
    text = complex_mode(t, 0) + complex_mode(t, 1, np.conj(t.shapes[1]), sign=-1.0) + complex_mode(t, 2)
    found = read(tmp_path, points_15(t) + text)
    np.testing.assert_allclose(found.shapes, t.shapes.reshape(3, 15).T, rtol=1e-5)


def test_points_are_where_their_frame_has_them(t, tmp_path):
    """Radius, degrees and height, by sines and cosines; a frame that is not in the file is asked for, or told."""
    origin, axes = np.array([1.0, 2.0, 3.0]), np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    polar = np.array([[100.0, 30.0, 5.0], [100.0, 120.0, 5.0], [0.0, 77.0, 1.0], [40.0, -90.0, 0.0], [7.0, 400.0, 2.0]])
    there = frames_2420(replace(t, frames={7: np.vstack([axes, origin])}, kinds={7: 1}))
    found = read(tmp_path, there + points_15(t, defined=7, points=polar) + every_mode(t))
    for got, (r, degrees, z) in zip(found.points[::3], polar, strict=True):
        a = np.pi * degrees / 180.0
        np.testing.assert_allclose(got, [1.0 - r * np.sin(a), 2.0 + r * np.cos(a), 3.0 + z], atol=1e-9)
    assert found.notes == ("angles of points in cylindrical frames are taken in degrees",)
    with pytest.raises(InputError, match=r"frame 8 is not in the file.*there are 7"):
        read(tmp_path, there + points_15(t, defined=8) + every_mode(t))
    alone = read(tmp_path, points_15(t, defined=8) + every_mode(t))
    np.testing.assert_allclose(alone.points[::3], t.points, rtol=6e-6)
    assert alone.notes == ("the file has no frames: points are taken in global axes",)


def test_data_sets_that_contradict_each_other_are_refused(t, tmp_path):
    """Nodes and units told twice alike are read once."""
    rest = every_mode(t)
    told = units_164(1000.0) + points_15(t)
    assert np.isfinite(read(tmp_path, told + told + rest).points).all()
    with pytest.raises(InputError, match=r"factors 1 and 1 for length and force, after 1000 and 1"):
        read(tmp_path, told + units_164(1.0) + rest)
    with pytest.raises(InputError, match=rf"node {t.labels[0]} is at .*, and again at"):
        read(tmp_path, told + points_15(t, points=2.0 * t.points + 1.0) + rest)


def test_damping_that_is_not_told_is_not_zero(t, tmp_path):
    found = read(tmp_path, points_15(t) + every_mode(replace(t, damping=np.zeros(3))))
    assert np.isnan(found.damping).all()


def test_an_unstable_mode_is_told(t, tmp_path):
    found = read(tmp_path, points_15(t) + "".join(complex_mode(replace(t, damping=-t.damping), k) for k in range(3)))
    np.testing.assert_allclose(found.damping, t.damping, rtol=1e-4)
    assert "eigenvalues with a positive real part" in found.notes[0]


def test_points_and_axes_that_were_not_measured_are_told(t, tmp_path):
    shapes = t.shapes * np.array([1.0, 0.0, 1.0])
    shapes[:, 2] = 0.0
    shapes[:, 3, 0] = 0.0
    found = read(tmp_path, points_15(t) + every_mode(replace(t, shapes=shapes)))
    assert found.sensors == ("1", "1", "2", "2", "4", "9", "9")
    assert found.notes == (
        "1 of 5 points are zero in every mode and are left out",
        "1 of 4 points have no values in x, which count as not measured",
        "no point has values in y, which counts as not measured",
    )


def test_deflections_and_stresses_beside_modes_are_left_out_and_told(t, tmp_path):
    other = normal_mode(t, 0).replace(f"{1:10d}{2:10d}{2:10d}", f"{1:10d}{5:10d}{2:10d}")
    found = read(tmp_path, points_15(t) + other + every_mode(t))
    assert found.frequencies.size == 3
    assert found.notes == ("data of analysis type 5 are no modes and are left out",)


def test_every_field_of_a_table(t, tmp_path):
    found = read(tmp_path, csv_text(t, ("x", "0 -3 4")), "csv")
    assert found.sensors == tuple(str(n) for n in t.labels for _ in range(2))
    np.testing.assert_allclose(found.directions, np.tile([[1.0, 0.0, 0.0], [0.0, -0.6, 0.8]], (5, 1)))
    np.testing.assert_allclose(found.points, np.repeat(t.points, 2, axis=0), rtol=1e-8)
    expected = np.stack([t.shapes[..., 0], t.shapes @ [0.0, -0.6, 0.8]], axis=2).reshape(3, 10).T
    np.testing.assert_allclose(found.shapes, expected, rtol=1e-8)
    np.testing.assert_allclose(found.damping, t.damping)
    assert found.per_metre is None


def test_real_and_imaginary_columns(tmp_path):
    text = "frequency_hz,sensor,direction,real,imag\n10,A,x,1,-2\n10,B,x,3,4\n20.5,A,x,5,6\n20.5,B,x,7,8\n"
    found = read(tmp_path, text, "csv")
    assert found.shapes.tolist() == [[1.0 - 2.0j, 5.0 + 6.0j], [3.0 + 4.0j, 7.0 + 8.0j]]
    assert np.isnan(found.points).all()
    assert np.isnan(found.damping).all()


def test_units_in_the_head_of_a_table_are_read_or_refused(tmp_path):
    row = "\n10,1.5,A,1,2,3,x,1\n"
    head = "frequency_hz (Hz),damping_percent [%],sensor,x [mm],y [mm],z [mm],direction,value [m/s^2]"
    found = read(tmp_path, head + row, "csv")
    assert (found.per_metre, found.damping.tolist()) == (1000.0, [0.015])
    for old, new, words in (
        ("x [mm],y [mm],z [mm]", "x [cm],y [cm],z [cm]", "the column x is in cm; expected one of mm, m, in"),
        ("frequency_hz (Hz)", "frequency_hz [kHz]", "the column frequency_hz is in kHz; expected hz"),
        ("damping_percent [%]", "damping [%]", "the column damping is in %.*Call it damping_percent"),
    ):
        with pytest.raises(InputError, match=words.replace("[", r"\[")):
            read(tmp_path, head.replace(old, new) + row, "csv")


def test_high_damping_is_told(tmp_path):
    found = read(tmp_path, "frequency_hz,damping,sensor,direction,value\n10,.439,A,x,1\n", "csv")
    assert found.notes == ("damping of 44 % of critical: is it per cent that the file has?",)


@pytest.mark.parametrize("form", ["universal", "table"])
def test_a_file_that_is_cut_anywhere_ends_in_a_message_or_in_whole_modes(t, tmp_path, form):
    text = csv_text(t) if form == "table" else points_15(t) + every_mode(t)
    messages = []
    for cut in range(0, len(text), 37):
        try:
            found = read(tmp_path, text[:cut], "csv" if form == "table" else "unv")
        except InputError as error:
            messages.append(str(error))
        else:
            assert found.frequencies.size < 3 or cut > 0.98 * len(text)
    assert len(messages) > 0.9 * len(text) / 37
    assert all("test." in message for message in messages)


@pytest.mark.parametrize("seed", range(40))
def test_a_damaged_file_ends_in_modes_or_in_a_message(t, tmp_path, seed):
    rng = random.Random(seed)
    text = [*(csv_text(t) if seed % 2 else points_15(t) + every_mode(t))]
    for _ in range(3):
        at = rng.randrange(len(text))
        text[at : at + rng.choice((1, 1, 13, 60))] = rng.choice(
            ("", "nan", "1E999", "    -1\n", "\0", "é", "x", "9" * 30)
        )
    try:
        found = read(tmp_path, "".join(text), "csv" if seed % 2 else "unv")
    except InputError:
        return
    assert np.isfinite(found.shapes).all()
    assert np.isfinite(found.frequencies).all()


@pytest.mark.parametrize(
    ("unit", "plain"),
    [
        ("m.s^-2", "m/s^2"),
        ("m s-2", "m/s^2"),
        ("m·s⁻²/N", "m/s^2/n"),
        ("(m/sec**2)/N", "m/s^2/n"),
        ("mm*s**-1", "mm/s"),
        ("m/s/s", "m/s^2"),
        ("milliseconds", "ms"),
        ("NONE", ""),
    ],
)
def test_spellings(unit, plain):
    assert plain_unit(unit) == plain


TIME = np.linspace(0.0, 0.3, 4)
MOTION = np.random.default_rng(5).standard_normal((2, 3, 3)).astype(np.float32)
LINES = LineRecord(TIME[2:], MOTION, ("lid:7", "lid:9", "Tür\nlinks:7"), np.array([7, 9, 7]))


@pytest.fixture
def histories():
    force = np.arange(8.0).reshape(4, 2)
    nodes = np.array([3]), ("LID.3",), np.ones((4, 1, 6))
    return Histories(
        "reduced", "m-kg-s", TIME, *nodes, ("a:9", "b:8"), np.array([9, 8]), force, force, force, "two\nlines", LINES
    )


def test_points_at_one_node_are_numbered_and_named(histories, tmp_path):
    assert histories.renumbered == ("E-line points",)
    write_punch(histories, tmp_path / "h.pch")
    node, *lines, a, b = punched(tmp_path / "h.pch")
    assert node.after("$TITLE   =") == "two lines"
    assert node.after("$SUBTITLE=") == "written by creak: m, N, s"
    assert [x.after("$POINT ID =").split()[0] for x in lines] == ["1", "2", "3"]
    assert [x.after("$LABEL   =").split(" of ")[1] for x in lines] == ["lid:7", "lid:9", "T?r links:7"]
    for k, line in enumerate(lines):
        np.testing.assert_allclose([*line.rows], TIME[2:], rtol=5.1e-7)
        np.testing.assert_allclose(np.array([*line.rows.values()])[:, :3], MOTION[:, k], rtol=5.1e-7)
    assert [x.after("$POINT ID =").split()[0] for x in (a, b)] == ["9", "8"]
    assert np.array([*b.rows.values()])[:, 2].tolist() == [1.0, 3.0, 5.0, 7.0]


def test_the_line_is_the_entity_of_a_universal_function(histories, tmp_path):
    write_universal(histories, tmp_path / "h.unv")
    units, *functions = data_sets(tmp_path / "h.unv")
    assert float(units[1][1][:25].replace("D", "E")) == 1.0
    of = [(lines[5][30:40].strip(), int(lines[5][41:51]), int(lines[5][51:55])) for _, lines in functions]
    assert of[:3] == [("NONE", 3, 1), ("NONE", 3, 2), ("NONE", 3, 3)]
    assert of[3:6] == [("lid", 7, 1), ("lid", 7, 2), ("lid", 7, 3)]
    assert of[9:12] == [("T?r links", 7, 1), ("T?r links", 7, 2), ("T?r links", 7, 3)]
    assert of[12:] == [("NONE", 9, 0), ("NONE", 8, 0)]
    label, unit = functions[4][1][8][26:46].strip(), functions[4][1][8][47:67].strip()
    assert (label, unit) == ("Relative motion", "m")
