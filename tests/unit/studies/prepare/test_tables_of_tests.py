"""Tables of time histories as spreadsheets of other countries write them, against the numbers that were written."""

from __future__ import annotations

import re

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.measured.csv_rows import number, separator_of
from creak.formats.measured.unit_words import name_and_unit
from creak.signals.sources import Record, acceleration_motion
from creak.studies.file.reader import read_study
from creak.studies.file.tables import read_signal, read_table
from creak.studies.prepare.measurements import record_channels
from creak.studies.prepare.setup import set_up
from helpers_decks import STUDY, write_strips

TIME = np.linspace(-0.012, 0.02, 41)
MOTION, GAP = 0.3 * np.sin(300.0 * TIME), 150.0 + 1e3 * TIME


def write(path, separator, comma=False, heads=("time [ms]", "1 Z [mm]", "tip gap [um]"), encoding="utf-8"):
    lines = [separator.join(heads)]
    for row in zip(1e3 * TIME, MOTION, GAP, strict=True):
        cells = [f"{x:.10g}" for x in row]
        lines.append(separator.join(cell.replace(".", ",") if comma else cell for cell in cells))
    path.write_text("\n".join(lines), encoding=encoding)
    return path


@pytest.mark.parametrize(("separator", "comma"), [(",", False), (";", False), (";", True), ("\t", False), ("\t", True)])
def test_the_separator_is_that_of_the_head(tmp_path, separator, comma):
    path = write(tmp_path / "drive.csv", separator, comma)
    motion, gap = record_channels(path)
    assert (motion.name, motion.unit, gap.name, gap.unit) == ("1 z", "mm", "tip gap", "um")
    assert motion.start == pytest.approx(TIME[0])
    for channel, values in ((motion, MOTION), (gap, GAP)):
        assert channel.time == pytest.approx(TIME, abs=1e-12)
        assert channel.values == pytest.approx(values, rel=1e-9, abs=1e-9)
    read = read_signal(path, "1 Z [mm]", "")
    time, values = read.time, read.value
    assert time == pytest.approx(TIME)
    assert values == pytest.approx(MOTION, abs=1e-9)


def test_a_test_between_semicolons_is_over_the_run(tmp_path):
    """It was left out without a word."""
    write(tmp_path / "drive.csv", ";", comma=True)
    study = write_strips(tmp_path, study=STUDY + '[test.drive]\nfile = "drive.csv"\n')
    (test,) = set_up(read_study(study)).tests
    assert [c.name for c in test.channels] == ["1 z", "tip gap"]


@pytest.mark.parametrize("text", ["", "\n\n", "abc\n1\n2\n", "time 1Z gap\n0 1 2\n"])
def test_a_file_that_holds_nothing_is_refused(tmp_path, text):
    (tmp_path / "drive.csv").write_text(text, encoding="utf-8")
    study = write_strips(tmp_path, study=STUDY + '[test.drive]\nfile = "drive.csv"\n')
    got = text.strip().partition("\n")[0].lower() or "nothing"
    for read in (lambda: set_up(read_study(study)), lambda: list(record_channels(tmp_path / "drive.csv"))):
        with pytest.raises(InputError, match=f"starts with {got}: no time history") as refused:
            read()
        assert "drive.csv" in str(refused.value)
        assert "semicolons" in str(refused.value)


def test_units_stand_in_either_bracket(tmp_path):
    """A word that is no unit belongs to the name."""
    path = write(tmp_path / "drive.csv", ";", heads=("time (ms)", "1 Z (um)", "tip gap (left)"))
    motion, gap = record_channels(path)
    assert (motion.name, motion.unit, gap.name, gap.unit) == ("1 z", "um", "tip gap (left)", "")
    assert motion.time == pytest.approx(TIME, abs=1e-12)
    heads = {"13 Z (m/s^2)": "m/s^2", "13 Z ((m/s**2))": "(m/s**2)", "13 Z [g]": "g", "13 Z": "", "13 Z (Pa) ": "Pa"}
    assert {head: name_and_unit(head) for head in heads} == {head: ("13 Z", unit) for head, unit in heads.items()}
    assert name_and_unit("13 Z (left) [g]") == ("13 Z (left)", "g")
    assert name_and_unit("13 Z (left) (g)") == ("13 Z (left)", "g")
    text = '[test.drive]\nfile = "drive.csv"\nchannels = { "1 Z (um)" = "2 Z", "tip gap (left)" = "tip gap" }\n'
    (test,) = set_up(read_study(write_strips(tmp_path, study=STUDY + text))).tests
    assert [c.name for c in test.channels] == ["2 Z", "tip gap"]


def test_tables_of_two_columns_take_semicolons(tmp_path):
    (tmp_path / "x.csv").write_text("time;value\n0;0,5\n1,5;-2\n", encoding="utf-8")
    time, values = read_table(tmp_path / "x.csv", "")
    assert (time.tolist(), values.tolist()) == ([0.0, 1.5], [0.5, -2.0])


def test_cells_and_heads():
    assert separator_of('time,"a;b;c"') == ","
    assert separator_of("time;Kanal 1, Z;Kanal 2, Z") == ";"
    assert separator_of("alone") == ","
    assert number(" −1,5e3") == -1500.0
    assert np.isnan(number("1.234,5"))


@pytest.mark.parametrize(("rate", "decimals"), [(2048, 5), (2048, 6), (2048, 9), (25_600, 6), (3000, 12)])
def test_rows_whose_times_are_rounded_are_even(tmp_path, rate, decimals):
    """A record has the rate that its whole span gives, and a test its own samples; less a row the record is refused,
    and the row after the gap is named."""
    values = np.arange(4000) % 5.0
    rows = [f"{k / rate:.{decimals}f},{value:g}" for k, value in enumerate(values)]
    path = tmp_path / "push.csv"
    path.write_text("\n".join(["time,value", *rows]), encoding="utf-8")
    record = 'signal = { type = "record", file = "push.csv", high_pass = 7 }'
    text = re.sub(r"signal = .*", record, STUDY).replace("periods = 2", "end = 0.15")
    study = read_study(write_strips(tmp_path, study=text))
    loads = set_up(study).loads
    whole = acceleration_motion(Record(np.arange(4000) / rate, values, 7.0), loads.time)
    assert loads.support[2, :, 0] == pytest.approx(whole.acceleration, abs=0.02)
    (channel,) = record_channels(path)
    assert channel.values.tolist() == values.tolist()
    assert channel.step == pytest.approx(1.0 / rate, rel=1e-5)
    path.write_text("\n".join(["time,value", *rows[:3990], *rows[3991:]]), encoding="utf-8")
    with pytest.raises(InputError, match=r"push\.csv:3992: the time"):
        set_up(study)
