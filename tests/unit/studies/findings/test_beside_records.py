"""Time histories of a test over those of a run: what is the run's own, shifted, scaled or turned, is found again."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import creak
from creak.errors import InputError
from creak.formats.measured.histories import Histories, read_histories, write_universal
from creak.formats.measured.modes import Channel
from creak.formats.measured.uff import DISPLACEMENT, REACTION_FORCE, Function, write_functions
from creak.formats.stored.results import LineRecord
from creak.studies.file.reader import read_study
from creak.studies.findings.beside_records import fit_records
from creak.studies.prepare.measurements import record_channels
from creak.verify.events import contact_stretches
from creak.verify.records import Course, fitted, shift_between
from helpers_decks import STUDY, write_strips
from helpers_refusal import refusal

LATE = 0.73123
"""s by which the clock of the test is ahead: no whole number of steps."""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("records")
    creak.run(read_study(write_strips(folder, study=f"{STUDY}[reference]\nrun = false\n")), converge=False).save(
        folder / "out"
    )
    return folder / "out"


@pytest.fixture(scope="module")
def run(results):
    return read_histories(results / "results.h5")


def table(path, time, **columns):
    rows = [",".join(["time", *columns])] + [
        ",".join(f"{x:.9g}" for x in row) for row in zip(time, *columns.values(), strict=True)
    ]
    path.write_text("\n".join(rows), encoding="utf-8")
    return path


def hardest(h):
    return h.channels[int(h.normal_force.max(axis=0).argmax())]


def columns(h):
    name = h.node_names[0]
    return {
        f"{name} Z [mm]": h.displacement[:, 0, 2],
        "tip force [N]": h.normal_force.sum(axis=1),
        "tip gap [mm]": h.gap.min(axis=1),
        f"{hardest(h)} normal force [N]": h.normal_force[:, h.channels.index(hardest(h))],
    }


def test_the_run_itself_is_found_at_its_shift(results, run, tmp_path):
    test = table(tmp_path / "test.csv", run.time[70:700] + LATE, **{k: v[70:700] for k, v in columns(run).items()})
    found = creak.compare_records(results, test)
    assert isinstance(found, creak.RecordComparison)
    assert found.shift == pytest.approx(-LATE, abs=0.01 * (run.time[1] - run.time[0]))
    assert [p.name for p in found.pairs] == [
        f"{run.node_names[0]} Z",
        "tip force",
        "tip gap",
        f"{hardest(run)} normal force",
    ]
    assert [p.unit for p in found.pairs] == ["mm", "N", "mm", "N"]
    for p in found.pairs:
        assert p.fit.fit > 0.99
        assert p.fit.correlation == pytest.approx(1.0, abs=1e-5)
        assert p.fit.rms[0] == pytest.approx(p.fit.rms[1], rel=5e-3)
    events = found.pairs[1].fit.events
    assert len(events[0]) == len(events[1]) > 5
    assert found.pairs[0].fit.events is None


def test_units_and_signs_are_those_of_the_file(results, run, tmp_path):
    """-Z in m, force in kN, of a universal file."""
    name, label = run.node_names[0], int(run.node_ids[0])
    write_functions(
        tmp_path / "test.unv",
        [
            Function("NONE", label, -3, DISPLACEMENT, "", "m", run.time, -1e-3 * run.displacement[:, 0, 2]),
            Function("tip force", 0, 0, REACTION_FORCE, "", "kN", run.time, 1e-3 * run.normal_force.sum(axis=1)),
        ],
    )
    found = creak.compare_records(results, tmp_path / "test.unv")
    assert [p.name for p in found.pairs] == [f"{name} Z", "tip force"]
    assert found.shift == pytest.approx(0.0, abs=1e-9)
    assert [p.fit.fit for p in found.pairs] == pytest.approx([1.0, 1.0], abs=1e-9)


@pytest.mark.parametrize(("factor", "words"), [(1e-3, "1000 times"), (25.4, "1/25.4 times"), (3.0, "")])
def test_a_level_that_units_make_is_asked_about(results, run, tmp_path, factor, words):
    test = table(tmp_path / "test.csv", run.time, **{f"{run.node_names[0]} Z": factor * run.displacement[:, 0, 2]})
    told = [note for note in creak.compare_records(results, test).notes if "mixed up" in note]
    assert [f"Z of the run is {words} that of the test" in note for note in told] == ([True] if words else [])


def test_a_sensor_that_is_turned_round_is_asked_about_and_no_shift_is_told_as_none(results, run, tmp_path):
    turned = {k: -v if " Z" in k else v for k, v in columns(run).items()}
    found = creak.compare_records(results, table(tmp_path / "test.csv", run.time, **turned))
    assert found.pairs[0].fit.correlation == pytest.approx(-1.0)
    assert [note for note in found.notes if "turned round" in note] == [
        f"{run.node_names[0]} Z of the test is that of the run with the other sign: is its sensor turned round?"
    ]
    assert found.notes[0].startswith("the test's times are the run's, where the mean correlation is")


@pytest.mark.parametrize("unit", ["", "mm/s^2"])
def test_the_kind_of_a_function_tells_what_it_is(results, run, tmp_path, unit):
    """An acceleration without a unit is one in lengths of the run; a velocity is told, and so is a kind against its unit."""
    u, n = run.displacement[:, 0, 2], run.time.size
    omega = 2.0 * np.pi * np.fft.rfftfreq(n, run.time[1] - run.time[0])
    a, label = np.fft.irfft(-(omega**2) * np.fft.rfft(u), n), int(run.node_ids[0])

    def written(kind, unit, values):
        write_functions(tmp_path / "t.unv", [Function("NONE", label, 3, DISPLACEMENT, "", unit, run.time, values)])
        text = re.sub(r"    -1\n   164\n.*?    -1\n", "", (tmp_path / "t.unv").read_text(), flags=re.DOTALL)
        (tmp_path / "test.unv").write_text(text.replace(f"\n{DISPLACEMENT:10d}    1", f"\n{kind:10d}    1"))

    written(12, unit, a)
    (pair,) = creak.compare_records(results, tmp_path / "test.unv").pairs
    assert pair.fit.fit > 0.999
    for kind, label_of, words in (
        (11, "", "is in length/s; expected a length or an acceleration"),
        (12, "mm", "a function of kind 12 in mm; expected a kind and a unit of one quantity"),
        (8, "m/s^2", "a function of kind 8 in m/s\\^2; expected a kind and a unit of one quantity"),
    ):
        written(kind, label_of, u)
        with pytest.raises(InputError, match=words):
            creak.compare_records(results, tmp_path / "test.unv")


def test_what_creak_wrote_of_the_run_is_the_run(results, run, tmp_path):
    """Displacements and normal forces come back; the relative motion of a line is no motion of its node."""
    ids = run.node_ids[:1]
    line = LineRecord(run.time[9:], np.ones((run.time.size - 9, 1, 3)), (f"tip:{run.node_names[0]}",), ids)
    own = replace(run, elines=line)
    write_universal(own, tmp_path / "own.unv")
    found = creak.compare_records(results, tmp_path / "own.unv")
    names = [f"{name} {axis}" for name in run.node_names for axis in "XYZ"]
    assert [p.name for p in found.pairs] == names + [f"{name} normal force" for name in run.channels]
    assert found.shift == pytest.approx(0.0, abs=1e-9)
    assert [p.fit.fit for p in found.pairs] == pytest.approx([1.0] * len(found.pairs), abs=1e-9)
    (left_out,) = (note for note in found.notes if "left out" in note)
    line_names = ", ".join(f"'tip:{run.node_names[0]} relative {axis}'" for axis in "xyz")
    assert (
        left_out == f"channels {line_names} are left out: motion of one side of an E-line against the other is not "
        "compared"
    )


def test_an_acceleration_is_compared_as_displacement(results, run, tmp_path):
    """That of the run, differentiated in the frequency domain: what splines lose of its highest frequencies is left."""
    u, n = run.displacement[:, 0, 2], run.time.size
    freq = np.fft.rfftfreq(n, run.time[1] - run.time[0])
    a = np.fft.irfft(-((2.0 * np.pi * freq) ** 2) * np.fft.rfft(u), n)
    test = table(tmp_path / "test.csv", run.time, **{f"{run.node_names[0]} z [m/s^2]": 1e-3 * a})
    (pair,) = creak.compare_records(results, test).pairs
    assert pair.fit.fit > 0.999
    assert np.abs(pair.fit.test).max() > 0.3 * np.abs(u).max()


@pytest.mark.parametrize(("starts", "ends"), [(0.0, 0.5), (0.0, 0.47), (0.0, 0.4), (0.02, 0.45), (0.0, 5.0)])
def test_an_acceleration_of_any_length_lies_over_the_motion(run, starts, ends):
    """A sine whose periods are whole in neither record, an offset of the sensor and another clock: cells of time lose
    less than 1e-3 of it. Of shifts that whole periods tell apart the smallest is taken."""
    w, size, late = 2.0 * np.pi * 11.0, 0.05, 0.013
    time, at = np.linspace(0.0, 0.5, 1002), np.arange(starts, ends, 1e-4)
    moved = np.zeros((time.size, 1, 6))
    moved[:, 0, 0] = size * np.sin(w * time)
    none = np.zeros((time.size, 0))
    own = Histories("reduced", "mm-t-s", time, np.array([95]), ("95",), moved, (), np.array([]), none, none, none)
    a = Channel("95 X", "m/s^2", starts + late, 1e-4, -1e-3 * size * w**2 * np.sin(w * at) + 0.01)
    found = fit_records(own, [a], Path("test.csv"), 500.0)
    assert found.shift == pytest.approx(-late, abs=1e-3 / 11.0)
    assert found.pairs[0].fit.fit > 0.999


def test_what_disagrees_is_measured(results, run, tmp_path):
    """90 % of the force: a fit of 1 - .1 |F| / |F - mean|, all events; another signal does not fit."""
    force = run.normal_force.sum(axis=1)
    test = table(tmp_path / "test.csv", run.time, **{"tip force": force / 0.9})
    (pair,) = creak.compare_records(results, test).pairs
    x = force / 0.9
    assert pair.fit.fit == pytest.approx(1.0 - np.linalg.norm(x - force) / np.linalg.norm(x - x.mean()), rel=1e-5)
    assert len(pair.fit.events[0]) == len(pair.fit.events[1])
    noise = np.random.default_rng(4).normal(size=force.size)
    odd = creak.compare_records(results, table(tmp_path / "odd.csv", run.time, **{"tip force": noise}))
    assert odd.pairs[0].fit.fit < 0.2
    assert any("hardly alike" in note for note in odd.notes)


@pytest.mark.parametrize("step", [2e-4, 1e-3, 3.3e-3])
def test_courses_of_other_steps_are_aligned(step):
    """A pulse, sampled finer and coarser than the model."""

    def pulse(t):
        return np.exp(-(((t - 0.6) / 0.02) ** 2))

    model, time = Course(np.arange(0.0, 2.0, 1e-3), pulse(np.arange(0.0, 2.0, 1e-3))), np.arange(5.2, 6.4, step)
    test = Course(time, pulse(time - 5.0))
    shift = shift_between([(test, model), (test, model)])
    assert shift == pytest.approx(-5.0, abs=2e-4)
    assert fitted(test, model, shift, kind="motion", f_max=500.0).fit > 0.96
    assert fitted(test, model, 50.0, kind="motion", f_max=500.0) is None


def test_spectrum_is_the_amplitude_of_a_line():
    t = np.arange(1000) * 1e-3
    test, model = Course(t, 3.0 * np.sin(2.0 * np.pi * 50.0 * t)), Course(t, np.sin(2.0 * np.pi * 50.0 * t))
    fit = fitted(test, model, 0.0, kind="motion", f_max=500.0)
    at = int(np.abs(fit.freq - 50.0).argmin())
    assert [s[at] for s in fit.spectra] == pytest.approx([3.0, 1.0], rel=1e-2)


def test_contacts_are_merged_as_events_of_a_run():
    """Less than half a period of f_max apart: one blow; one that rests from the start is none."""
    t = np.arange(20) * 1.0
    pressing = np.isin(t, [0.0, 4.0, 6.0, 15.0])
    assert contact_stretches(t, pressing, 0.2) == ((4.0, 6.0), (15.0, 15.0))
    assert contact_stretches(t, pressing, 10.0) == ((4.0, 4.0), (6.0, 6.0), (15.0, 15.0))


def test_a_channel_that_never_moves_has_no_correlation(results, run, tmp_path):
    still = dict.fromkeys(["tip force", "tip gap"], np.zeros(run.time.size))
    found = creak.compare_records(results, table(tmp_path / "test.csv", run.time, **still))
    assert np.isnan([p.fit.correlation for p in found.pairs]).all()
    assert any("hardly alike" in note for note in found.notes)


@pytest.mark.parametrize("short", [1e-7, 1e-13])
def test_one_short_interval_asks_for_no_more_memory(results, run, tmp_path, short):
    """A row that stands twice but for a digit; 74 GiB would be its even samples by the shortest interval."""
    twice = np.insert(run.time, 10, run.time[9] + short), *(np.insert(v, 10, v[9]) for v in columns(run).values())
    rows = "\n".join(",".join(f"{x:.15g}" for x in row) for row in zip(*twice, strict=True))
    (tmp_path / "test.csv").write_text("\n".join([",".join(["time", *columns(run)]), rows]), encoding="utf-8")
    assert max(c.values.size for c in record_channels(tmp_path / "test.csv")) <= 10 * run.time.size + 1
    found = creak.compare_records(results, tmp_path / "test.csv")
    assert found.shift == pytest.approx(0.0, abs=1e-5)
    assert min(p.fit.fit for p in found.pairs) > 0.97


@pytest.mark.parametrize(("head", "scale"), [("time [ms]", 1e3), ("t (µs)", 1e6), ("time [min]", 1 / 60), ("t [s]", 1)])
def test_times_are_in_the_unit_of_their_head(results, run, tmp_path, head, scale):
    test = table(tmp_path / "test.csv", scale * run.time, **columns(run))
    test.write_text(test.read_text(encoding="utf-8").replace("time", head, 1), encoding="utf-8")
    found = creak.compare_records(results, test)
    assert found.shift == pytest.approx(0.0, abs=1e-6)
    assert min(p.fit.fit for p in found.pairs) > 0.999


def test_a_contact_that_the_pre_check_dropped_is_named(run):
    none = np.zeros((run.time.size, 0))
    dropped = replace(run, channels=(), channel_nodes=np.array([]), gap=none, normal_force=none, peak_force=none)
    gap, z = (
        Channel(name, "mm", 0.0, 1e-3, np.sin(np.arange(900.0))) for name in ("tip gap", f"{run.node_names[0]} Z")
    )
    (note,) = (n for n in fit_records(dropped, [gap, z], Path("test.csv"), 500.0).notes if "left out" in n)
    assert "dropped by the pre-check" in note
    still = replace(dropped, node_ids=np.array([]), node_names=(), displacement=np.zeros((run.time.size, 0, 6)))
    words = str(refusal(fit_records, still, [gap], Path("test.csv"), 500.0))
    assert "expected a run of watched nodes or contacts" in words
    assert "dropped by the pre-check: name the file in a [test.NAME]" in words


WRONG = {
    "no channel of the run": ("time,tip foce\n0,1\n1,2\n", "none of its 1 channels is one that the run computed"),
    "a force in mm": ("time,tip force [mm]\n0,1\n1,2\n", "'tip force' is in mm; expected a force"),
    "a gap in m/s^2": ("time,tip gap [m/s^2]\n0,1\n1,2\n", "'tip gap' is in m/s\\^2; expected a length"),
    "a word": ("time,tip force\n0,1\n1,much\n", "test.csv:3"),
    "times that fall": ("time,tip force\n1,1\n0,2\n", "does not increase"),
    "times in weeks": (
        "time [weeks],tip force\n0,1\n1,2\n",
        "the times are in weeks; expected one of s, ms, us, min, h",
    ),
    "one row": ("time,tip force\n1,1\n", "two or more"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_files(results, tmp_path, name):
    text, words = WRONG[name]
    (tmp_path / "test.csv").write_text(text)
    with pytest.raises(InputError, match=words):
        creak.compare_records(results, tmp_path / "test.csv")
