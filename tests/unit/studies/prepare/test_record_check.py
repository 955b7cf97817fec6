"""Records against the run that they move: when they begin and end, and how well displacement is known from them."""

from __future__ import annotations

import re

import numpy as np
import pytest

from creak.errors import InputError
from creak.progress import silent
from creak.signals import sources
from creak.signals.between_samples import evened
from creak.signals.faults import cut_off, dropouts, reaches_top, spikes
from creak.signals.sources import Record
from creak.studies.file import tables
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import run_study
from creak.studies.warned import Warned
from helpers_decks import STUDY, write_strips

STEP, HIGH_PASS = 1e-3, 8.0
LINES = ((12.0, 3000.0, 0.3), (20.0, -4000.0, 1.1), (33.0, 9000.0, 2.0), (47.0, 5000.0, 0.7))


def tones(n):
    """Acceleration of some lines, and the displacement that it is of."""
    t = STEP * np.arange(n)
    each = [(A * np.cos(2.0 * np.pi * f * t + p), (2.0 * np.pi * f) ** 2) for f, A, p in LINES]
    return sum(a for a, _ in each), -sum(a / w2 for a, w2 in each)


@pytest.mark.parametrize("n", [2000, 2048, 1010, 5033, 10017])
def test_how_far_off_displacements_are_is_told(n):
    """Two seconds are a whole period of all lines; of other lengths the figure is right within a factor of three."""
    a, u = tones(n)
    middle = slice(n // 4, n - n // 4)
    record = Record(STEP * np.arange(n), a, HIGH_PASS)
    off = np.linalg.norm((record.integrals[0] - u)[middle]) / np.linalg.norm(u[middle])
    told = record.wrapped
    if n == 2000:
        assert told == 0.0
        assert off < 1e-9
    else:
        assert off / 3.0 < told < 3.0 * off


@pytest.mark.parametrize(
    ("begin", "count", "said"),
    [
        (0.0, 2000, ()),
        (0.0, 2048, ("is off by some 3.6 % in its middle", "Take a longer record, or one of whole periods")),
        (0.3, 2000, ("begins at 0.3 s: nothing moves before",)),
        (-1.0, 2000, ("ends at 0.999 s, the run at 1.9 s",)),
        (100.0, 2000, ("is zero throughout the run: its record holds 100 to 102 s, the run 0 to 1.9 s",)),
    ],
)
def test_records_that_do_not_fit_the_run_are_told(tmp_path, begin, count, said):
    a, _ = tones(count)
    told = told_of(tmp_path, begin + STEP * np.arange(count), a)
    assert len(told) == bool(said)
    assert all(words in told[0] for words in said)


def told_of(tmp_path, time, a, signal='type = "record", high_pass = 8', end=1.9):
    """What a study whose record this is says of it."""
    rows = np.stack([time, a], axis=1)
    np.savetxt(tmp_path / "road.csv", rows, delimiter=",", header="time,acc", comments="", fmt="%.9g")
    record = f'signal = {{ file = "road.csv", channel = "acc", {signal} }}'
    study = re.sub(r"signal = .*", record, STUDY).replace('"displacement"', '"acceleration"')
    study = study.replace("step = 5e-4\nperiods = 2", f"end = {end}")
    return [note for note in set_up(read_study(write_strips(tmp_path, study=study))).notes if "record" in note]


@pytest.mark.parametrize(
    ("begin", "value", "said"),
    [
        (0.0, [0.0, 5.0, -3.0], "ends at 1 s with a force of -3, which acts on until the run ends at 1.9 s"),
        (0.5, [2.0, 5.0, 0.0], "begins at 0.5 s with a force of 2, which acts from 0 on"),
        (0.0, [0.0, 5.0, 0.0], ""),
        (0.95, [0.0, 5.0, 4.0], ""),
    ],
)
def test_a_force_that_acts_outside_its_record_is_told(tmp_path, begin, value, said):
    time = begin + 0.01 * np.arange(101)
    course = np.interp(time - begin, [0.0, 0.5, 1.0], value)
    np.savetxt(tmp_path / "road.csv", np.stack([time, course], axis=1), delimiter=",", header="time,N", comments="")
    signal = 'signal = { file = "road.csv", type = "record", high_pass = 8 }'
    on_lower = '[excitation.push]\nnode_set = "TIP_LOWER"\ndof = "z"\nkind = "force"\n' + signal
    study = STUDY.replace("step = 5e-4\nperiods = 2", "end = 1.9") + on_lower
    told = [n for n in set_up(read_study(write_strips(tmp_path, study=study))).notes if "[excitation.push] " in n]
    assert len(told) == bool(said)
    assert all(said in text for text in told)


def changed(a, where, by):
    a = a.copy()
    a[where] = by
    return a


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (lambda a: changed(a, slice(900, 930), 0.0), "stands still once, at 0 from 0.9 to 0.929 s, and jumps there"),
        (lambda a: changed(a, slice(900, 1100), a[900]), "from 0.9 to 1.099 s, and jumps there"),
        (lambda a: np.clip(a, -6000.0, 9000.0), "times, longest at -6000 from"),
        (lambda a: changed(a, [700, 1400], 1e6), "has 2 samples far beyond all others, the first 1e+06 at 0.7 s"),
        (
            lambda a: np.random.default_rng(1).normal(0.0 * a, 4000.0),
            "reaches up to the 500 Hz that samples 0.001 s apart can hold",
        ),
        (lambda a: a / 9806.65, "A record in g takes factor = 9806.65"),
        (lambda a: 0.0 * a + 9810.0, "moves nothing: it is 9810 throughout"),
        (lambda a: a + 9810.0, ""),
        (lambda a: 1000.0 * np.round(a / 1000.0), ""),
        (lambda a: a * np.exp(-((np.arange(2000) - 1000.0) ** 2) / 1e5), ""),
    ],
)
def test_samples_that_no_road_made_are_told(tmp_path, wrong, said):
    a = wrong(tones(2000)[0])
    told = told_of(tmp_path, STEP * np.arange(2000), a)
    assert len(told) == bool(said)
    assert all(said in text for text in told)


def test_a_measured_acceleration_given_as_a_table_carries_its_supports_away(tmp_path):
    """The offset of its sensor, 1 g, is 18 m in 1.9 s; what moves to a place and stops is as meant."""
    t, table = STEP * np.arange(2000), 'type = "table"'
    (told,) = told_of(tmp_path, t, tones(2000)[0] + 9810.0, table)
    assert re.search(r'carries its nodes 1.76e\+04 mm away, .* A measured one is a type = "record", with', told)
    assert not told_of(tmp_path, t, 100.0 * np.sin(np.pi * t), table, end=2.0)


def test_pulses_with_pauses_and_coarse_tones_are_not_told_as_faults():
    """Half-sine pulses rest at their lowest value, and rounded tones stand at their peaks: both are as they were made."""
    i = np.arange(4000)
    pulses = np.where(i % 1000 < 20, np.sin(np.pi * (i % 1000) / 20.0), 0.0)
    for x in (pulses, 5.0 * np.round(20.0 * np.sin(2.0 * np.pi * 5.0 * STEP * i))):
        assert not any(found(x).size for found in (dropouts, cut_off, spikes))
        assert not reaches_top(x)


def test_records_are_read_and_integrated_once_as_long_as_their_files_stay(tmp_path, monkeypatch):
    """Steps, loads and checks ask for them, and so does each case of a sweep."""
    read, integrated = [], []
    lines, integrals = tables.read_lines, sources.integrate_twice
    monkeypatch.setattr(tables, "read_lines", lambda *at: read.append(at) or lines(*at))
    monkeypatch.setattr(sources, "integrate_twice", lambda *of: integrated.append(of) or integrals(*of))
    t = STEP * np.arange(2000)
    for _ in range(2):
        told_of(tmp_path, t, tones(2000)[0])
        set_up(read_study(tmp_path / "study.toml"))
    assert len(integrated) == len(read) == 2


@pytest.mark.parametrize(
    ("head", "row", "said"),
    [
        ("time,acc", "0,001,3,2", "4 values; expected 2, as the head has names: time,acc. Write decimals with a point"),
        ("time,acc", "s,mm/s2", "Drop the row: units stand in the head, as in acc [m/s2]."),
        (
            "road 12\n\nDate;12.03.2026\nt [s];a [g]",
            "0,5;1,5",
            "road.csv:1: the heads of the columns stand in line 4: t [s], ",
        ),
        ("# by hand\ntime,acc", "0,1", "Delete the lines before line 2."),
        ("time acc", "0 1", "with commas, semicolons or tabs between the names, and nothing before it."),
        ("time;acc;", "0,5;1,5;", ""),
    ],
)
def test_tables_as_loggers_write_them_are_read_or_refused_with_what_to_do(tmp_path, head, row, said):
    path = tmp_path / "road.csv"
    path.write_text("\n".join([head, row, row.replace("0", "1", 1), ""]))
    if not said:
        assert tables.read_signal(path, None, "").value.tolist() == [1.5, 1.5]
        return
    with pytest.raises(InputError, match=re.escape(said)):
        tables.read_signal(path, None, "")


def test_a_record_of_another_kind_of_file_is_no_text(tmp_path):
    (tmp_path / "road.wav").write_bytes(b"RIFF\x00\x10WAVEfmt ")
    with pytest.raises(InputError, match=r"is no text; expected a table in CSV\. Export it as CSV"):
        tables.read_signal(tmp_path / "road.wav", None, "")


@pytest.mark.parametrize(("jitter", "limit"), [(0.1, 0.01), (0.45, 0.02)])
def test_uneven_times_are_made_even_within_what_is_told(jitter, limit):
    """Of tones up to a twentieth of the sampling rate; the error that is told covers that against their closed form."""
    rng = np.random.default_rng(5)
    time = STEP * (np.arange(2000) + 0.5 * jitter * rng.uniform(-1.0, 1.0, 2000))

    def exact(t):
        return sum(A * np.cos(2.0 * np.pi * f * t + p) for f, A, p in LINES)

    even, value, told = evened(time, exact(time))
    assert np.ptp(np.diff(even)) < 1e-9 * STEP
    off = np.sqrt(np.mean((value - exact(even)) ** 2)) / np.std(exact(even))
    assert off < told < 30.0 * off
    assert told < limit


def test_a_missing_sample_is_no_jitter():
    time = np.delete(STEP * np.arange(100), 50)
    assert evened(time, np.sin(time)) is None


def test_an_uneven_record_runs_with_a_note_and_one_that_holds_too_much_with_a_warning(tmp_path):
    rng = np.random.default_rng(5)
    time = STEP * (np.arange(2000) + 0.2 * rng.uniform(-1.0, 1.0, 2000))
    time[0] = 0.0
    slow, fast = (sum(np.sin(2.0 * np.pi * f * time + f) for f in of) for of in ((20.0, 40.0), (180.0, 230.0)))
    for value, warned in ((slow, False), (fast, True)):
        (told,) = [note for note in told_of(tmp_path, time, value) if "uneven times" in note]
        assert isinstance(told, Warned) == warned
        assert "has uneven times and was put on even ones 0.00" in told


@pytest.mark.parametrize(("factor", "answered"), [(1.0, False), (9806.65, True)])
def test_a_record_in_g_that_is_taken_as_mm_per_s2_is_no_quiet_answer(tmp_path, factor, answered):
    """Two tenths of a g move hardly anything as 0.2 mm/s2: that nothing touches then says nothing."""
    time = STEP * np.arange(2000)
    record = f'type = "record", high_pass = 8, factor = {factor}'
    told_of(tmp_path, time, 0.2 * np.sin(2.0 * np.pi * 20.0 * time), record, end=0.2)
    result = run_study(set_up(read_study(tmp_path / "study.toml")), silent)
    assert (result.unanswered is None) is answered
    assert answered or "of a record in g factor = 9806.65" in result.unanswered
