"""RPC III files, functions of universal files and columns of CSV files as courses in time."""

from __future__ import annotations

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.measured.files import chosen_channel, read_channels
from creak.formats.measured.uff import DISPLACEMENT, Function, write_functions
from creak.studies.file.reader import read_study
from creak.studies.file.tables import read_signal
from creak.studies.prepare.measurements import record_channels
from creak.studies.prepare.setup import set_up
from helpers_decks import STUDY, write_strips
from helpers_frfs import function, units
from helpers_rpc3 import COURSES, POINTS, TIME, rpc3


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("kind", ["SHORT_INTEGER", "FLOATING_POINT"])
def test_channels_of_rpc3(tmp_path, order, kind):
    path = tmp_path / "road.rsp"
    path.write_bytes(rpc3(order, kind))
    found = read_channels(path)
    assert [c.name for c in found] == [*COURSES]
    for channel, course in zip(found, COURSES.values(), strict=True):
        assert channel.unit == "g"
        assert channel.time == pytest.approx(TIME)
        assert np.abs(channel.values - course).max() <= (2.1 / 32752.0 if kind == "SHORT_INTEGER" else 1e-6)


def uff(path, precision: int = 4):
    functions = [Function(n, 17, 3, DISPLACEMENT, "Displacement", "mm", TIME, v) for n, v in COURSES.items()]
    write_functions(path, functions)
    if precision == 2:  # as single precision writes it: six numbers of 13 to a line
        lines = path.read_text().replace("\r", "").splitlines()
        rows = iter(lines)
        out = []
        for line in rows:
            out.append(line)
            if line.startswith(f"{4:10d}{POINTS:10d}{1:10d}"):
                out[-1] = f"{2:10d}{line[10:]}"
                out += [next(rows) for _ in range(4)]
                values = []
                while len(values) < POINTS:
                    row = next(rows)
                    values += [float(row[a : a + 20]) for a in range(0, len(row), 20)]
                out += ["".join(f"{v:13.5E}" for v in values[k : k + 6]) for k in range(0, POINTS, 6)]
        path.write_text("\n".join(out) + "\n")


@pytest.mark.parametrize("precision", [4, 2])
def test_functions_of_universal_files(tmp_path, precision):
    path = tmp_path / "road.unv"
    uff(path, precision)
    for name, course in COURSES.items():
        found = chosen_channel(path, name.lower(), "study")
        assert found.unit == "mm"
        assert found.time == pytest.approx(TIME)
        assert found.values == pytest.approx(course, abs=2e-5 if precision == 2 else 1e-11)
    assert chosen_channel(path, 2, "study").name == "Acc_Z"


SECONDS = {"s": 1.0, "Sec": 1.0, "seconds": 1.0, "NONE": 1.0, "": 1.0, "ms": 1e3, "msec": 1e3, "us": 1e6, "min": 1 / 60}
"""Label -> numbers that 1 s is."""


def course(path, values, unit="NONE", direction=3, title="NONE", head="", kind=12, label="m/s^2", late=0.25) -> None:
    """One function of time at node 17, 1 ms apart."""
    time, axis = SECONDS.get(unit, 1.0) * (late + 1e-3 * np.arange(values.size)), {"abscissa": 17, "over_unit": unit}
    told = {"kind": 1, "data": 4, "quantity": kind, "over": 0, "labels": (label, "NONE")}
    one = function(values, (17, direction), (0, 0), freq=time, **told, **axis)
    path.write_bytes(head.encode() + one.replace(b"NONE\n", title.encode() + b"\n", 1))


@pytest.mark.parametrize("unit", SECONDS)
def test_a_sine_of_10_hz_has_10_hz_in_whatever_unit_its_times_are(tmp_path, unit):
    values = np.sin(2 * np.pi * 10.0 * 1e-3 * np.arange(1000))
    course(tmp_path / "road.unv", values, unit)
    read = read_signal(tmp_path / "road.unv", None, "study")
    time, found = read.time, read.value
    assert time[0] == pytest.approx(0.25, rel=1e-5)
    assert found == pytest.approx(np.sin(2 * np.pi * 10.0 * (time - time[0])), abs=1e-3)
    (channel,) = record_channels(tmp_path / "road.unv")
    assert channel.time == pytest.approx(time)


def test_times_in_an_unknown_unit_are_refused(tmp_path):
    course(tmp_path / "road.unv", np.arange(9.0), "fortnight")
    words = r"the times of the function 17 Z are in fortnight; expected one of s, ms, us, min, h.*without one it is s"
    with pytest.raises(InputError, match=words) as told:
        read_signal(tmp_path / "road.unv", None, "study")
    assert "road.unv:10" in str(told.value)


@pytest.mark.parametrize("title", ["NONE", "acc"])
@pytest.mark.parametrize("sign", [1, -1])
def test_drive_and_test_have_what_lies_along_the_positive_axis(tmp_path, title, sign):
    values = np.sin(np.arange(50.0))
    course(tmp_path / "road.unv", sign * values, direction=3 * sign, title=title)
    drive = read_signal(tmp_path / "road.unv", None, "study").value
    (test,) = record_channels(tmp_path / "road.unv")
    assert test.name == "17 Z"
    for found in (drive, test.values, chosen_channel(tmp_path / "road.unv", 1, "study").values):
        assert found == pytest.approx(values, abs=1e-11)


UNLABELLED = {
    (12, 1000.0, 1.0): "mm/s^2",
    (8, 1.0, 1.0): "m",
    (11, 1.0 / 0.0254, 1.0): "in/s",
    (12, 3.0, 1.0): "0.333333 m/s^2",
    (9, 1000.0, 1.0): "n",
    (13, 1.0, 1.0 / 4.4482216152605): "lbf",
    (0, 1000.0, 1.0): "NONE",
}


@pytest.mark.parametrize(("kind", "length", "force"), UNLABELLED)
def test_a_course_without_a_unit_is_in_those_of_data_set_164(tmp_path, kind, length, force):
    course(tmp_path / "road.unv", np.arange(9.0), kind=kind, label="NONE", head=units(length, force))
    (found,) = read_channels(tmp_path / "road.unv")
    assert found.unit == UNLABELLED[kind, length, force]
    own = {11: "cm/s", 12: "cm/s^2"}.get(kind, "cm")
    course(tmp_path / "road.unv", np.arange(9.0), kind=kind, label=own, head=units(length, force))
    assert read_channels(tmp_path / "road.unv")[0].unit == own


def test_a_record_is_the_same_from_every_file(tmp_path):
    """CSV with free columns, RPC III, universal file: the same excitation of the study; the factor acts."""
    path, columns = tmp_path / "road.csv", ["t", *COURSES]
    rows = [",".join(f"{x:.9g}" for x in row) for row in zip(TIME, *COURSES.values(), strict=True)]
    path.write_text("\n".join([",".join(columns), *rows]), encoding="utf-8")
    uff(tmp_path / "road.unv")
    (tmp_path / "road.rsp").write_bytes(rpc3())
    before, rest = STUDY.partition('kind = "displacement"')[0], STUDY.partition("seed = 3 }")[2]
    motions = []
    for name, channel, factor in (("road.csv", "acc_z", 2.0), ("road.unv", "Acc_Z", 2.0), ("road.rsp", 2, 2.0)):
        signal = f'file = "{name}", channel = "{channel}", factor = {factor}, high_pass = 2'
        text = f'{before}kind = "acceleration"\nsignal = {{ type = "record", {signal} }}{rest}'
        text = text.replace("step = 5e-4\nperiods = 2", "end = 0.5")
        motions.append(set_up(read_study(write_strips(tmp_path, None, text))).loads.support[2, :, 0])
    assert motions[1] == pytest.approx(motions[0], abs=1e-6)
    assert motions[2] == pytest.approx(motions[0], abs=2e-3)
    assert 4.0 < np.abs(motions[0]).max() < 9.0  # twice 3, with what the high-pass does at the ends


REFUSED = {
    "cut": (rpc3()[:-10], 2, "cut short"),
    "cut head": (rpc3()[:1500], 2, "cut short"),
    "no rpc": (b"time,value\n0,1\n", 2, "not a file of RPC III"),
    "no such number": (
        rpc3(),
        3,
        "has 2 channels, none of them 3; expected channel = one of Acc_X, Acc_Z, or its number, from 1",
    ),
    "no such name": (rpc3(), "Acc_Q", "has 2 channels, none of them 'Acc_Q'"),
    "not named": (rpc3(), None, "has 2 channels; expected channel = one of Acc_X, Acc_Z"),
    "histogram": (rpc3(FILE_TYPE="HISTOGRAM"), 1, "HISTOGRAM"),
    "no step": (rpc3(DELTA_T="soon"), 1, "DELTA_T of the RPC III file is 'soon'"),
    "no scale": (rpc3(**{"SCALE.CHAN_2": ""}), 1, "SCALE.CHAN_2"),
    "no frames": (rpc3(FRAMES="-1"), 1, "without samples"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_read_is_refused(tmp_path, case):
    data, channel, match = REFUSED[case]
    path = tmp_path / "road.rsp"
    path.write_bytes(data)
    with pytest.raises(InputError, match=match):
        read_signal(path, None if channel is None else str(channel), "study.toml:3")


def test_universal_files_that_cannot_be_read(tmp_path):
    path = tmp_path / "road.unv"
    uff(path)
    text = path.read_text()
    for broken, match in (
        (text[: len(text) // 3], "cut short"),
        (text.replace("\n    58", "\n   58b"), "binary"),
        (text.replace(f"{4:10d}{POINTS:10d}{1:10d}", f"{4:10d}{POINTS:10d}{0:10d}"), "unevenly sampled"),
        (text.replace(f"{POINTS:10d}", f"{POINTS + 9:10d}"), "cut short"),
        (text[:-200] + text[-200:].replace("E", "F"), "is no number"),
        ("    -1\n   164\n    -1\n", "no function of time"),
    ):
        path.write_text(broken)
        with pytest.raises(InputError, match=match):
            read_channels(path)
    with pytest.raises(InputError, match="no such file"):
        read_signal(tmp_path / "other.uff", None, "study")


def test_a_column_that_is_not_there(tmp_path):
    path = tmp_path / "road.csv"
    path.write_text("time,front,rear\n0,1,2\n1,1,2\n2,1\n")
    with pytest.raises(InputError, match=r"no column 'read'.*rear"):
        read_signal(path, "read", "study")
    with pytest.raises(InputError, match=r"road.csv:4"):
        read_signal(path, "rear", "study")
    read = read_signal(path, "front", "study")
    time, value = read.time, read.value
    assert (time.tolist(), value.tolist()) == ([0.0, 1.0, 2.0], [1.0, 1.0, 1.0])
