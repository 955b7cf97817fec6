"""Files of a program that builds on creak: whole or not at all, and known when they were changed.

Numbers of a Python program: those of NumPy count as plain ones, what is no number is refused with what is expected.
"""

from __future__ import annotations

import inspect
import math
from functools import cache

import numpy as np
import pytest
import scipy.sparse as sp

import creak
from creak.api.robust import DRAWS
from creak.cli import robust as command
from helpers_core import time_axis
from helpers_refusal import refusal


def test_json_comes_back_and_a_changed_one_is_known(tmp_path):
    path = tmp_path / "cases" / "one.json"
    creak.write_json(path, {"name": "D8", "found": [1.5, math.inf], "loads": {"A4": None}})
    assert creak.read_json(path) == {"name": "D8", "found": [1.5, math.inf], "loads": {"A4": None}}
    path.write_text(path.read_text(encoding="utf-8").replace("1.5", "1.6"), encoding="utf-8")
    assert "checksum does not fit" in str(refusal(creak.read_json, path))


@pytest.mark.parametrize("content", [None, "{}", "no json", "[1]"])
def test_what_write_json_did_not_write_is_refused(tmp_path, content):
    path = tmp_path / "one.json"
    if content is not None:
        path.write_text(content, encoding="utf-8")
    assert "one.json" in str(refusal(creak.read_json, path))


def test_data_that_json_cannot_hold_leave_the_file_as_it_was(tmp_path):
    path = tmp_path / "one.json"
    creak.write_json(path, {"a": 1})
    assert "not JSON serializable" in str(refusal(creak.write_json, path, {"a": object()}))
    assert creak.read_json(path) == {"a": 1}


def test_text_is_written_as_it_is(tmp_path):
    creak.write_text(str(tmp_path / "page.html"), "länge\n")
    assert (tmp_path / "page.html").read_bytes() == "länge\n".encode()
    assert "folder" in str(refusal(creak.write_text, tmp_path, "text"))


RATE = 32_000
TONE = 0.02 * np.sin(2.0 * np.pi * 1000.0 * np.arange(RATE // 10) / RATE)
MASS = creak.system_from_matrices([[1e4]], [[100.0]], velocity=[1.0])
STOP = creak.gap_channels([[-1.0]], 0.0, 1e6)
LOADS = creak.make_loads(MASS, time_axis(0.01, 2e-3))
DRIVEN = creak.couple(creak.system_from_matrices(np.eye(2), np.eye(2)), driven={"b": [0]})
SINE = creak.Sine(20.0, 1.0)
UNEVEN = [[1.0], [2.0, 3.0]]
DECK = {"model": {"deck": "d.inp"}}
KINDS = (np.float32, np.float64, np.array, lambda x: np.array(x, dtype=np.float32))


@cache
def history() -> creak.History:
    return creak.simulate(MASS, STOP, LOADS)


def events() -> list[creak.Event]:
    return creak.find_events(history(), STOP)


def test_the_field_of_a_loudness_may_be_the_third_argument():
    diffuse = creak.loudness(TONE, RATE, "diffuse")
    assert diffuse.n_max == creak.loudness(TONE, RATE, field="diffuse").n_max != creak.loudness(TONE, RATE).n_max
    assert creak.steady_loudness(TONE, RATE, "diffuse", skip=0.01).total > 0.0


@pytest.mark.parametrize("kind", [*KINDS, np.int64, np.int32])
def test_a_sampling_rate_of_any_type(kind):
    assert creak.loudness(TONE, kind(RATE)).n_max == creak.loudness(TONE, RATE).n_max


@pytest.mark.parametrize("rate", ["32000", None, [32_000.0], 32_000j])
def test_a_sampling_rate_that_is_no_number_is_refused(rate):
    assert "sampling rate = " in refusal(creak.loudness, TONE, rate).what


@pytest.mark.parametrize("kind", KINDS)
def test_friction_of_any_type(kind):
    """One number is static and kinetic."""
    for friction in (kind(0.25), (kind(0.25), kind(0.25))):
        found = creak.gap_channels(np.eye(1, 2), 0.0, 1.0, tangents=[np.eye(1, 2)], friction=friction).friction
        assert (found.static.tolist(), found.kinetic.tolist()) == ([0.25], [0.25])
    assert creak.gap_channels(np.eye(1, 2), 0.0, 1.0, friction=np.int64(0)).friction is None


def test_tangents_as_an_array_of_matrices():
    one = np.ones((2, 1, 2))
    found = creak.gap_channels(np.eye(1, 2), 0.0, 1.0, tangents=one, friction=0.5).friction
    assert found.static.tolist() == [0.5]


def rubs(**options):
    return creak.gap_channels(np.eye(2), 0.0, 1.0, **options)


def loads(**options):
    return creak.make_loads(MASS, LOADS.time, **options)


WRONG = {
    "one tangent": (lambda: rubs(tangents=np.eye(2)), r"tangents is a matrix of shape \(2, 2\); .*tangents=\[T\]"),
    "a sparse one": (lambda: rubs(tangents=sp.eye_array(2).tocsr()), r"tangents is a matrix .*tangents=\[T\]"),
    "four frictions": (lambda: rubs(friction=(0.1, 0.1, 0.1, 0.1)), "friction of 4 numbers; .* decay speed"),
    "one in a list": (lambda: rubs(friction=[0.1]), "friction of 1 numbers"),
    "a word": (lambda: rubs(friction="much"), "friction = 'much'; expected a number"),
    "f_max 0": (lambda: creak.find_events(history(), STOP, f_max=0), "f_max = 0; expected a positive number"),
    "f_max -1": (lambda: creak.find_events(history(), STOP, f_max=-1.0), "f_max = -1; expected a positive number"),
    "f_max nan": (lambda: creak.find_events(history(), STOP, f_max=np.nan), "f_max = nan; expected a positive number"),
    "merge": (lambda: creak.find_events(history(), STOP, merge=-1e-3), "merge = -0.001; expected seconds"),
    "slips": (lambda: creak.find_slips(history(), STOP, f_max=0), "f_max = 0; expected a positive number"),
    "no draws": (lambda: creak.robust("none.toml", 0), "n = 0; expected a whole number, 4 to 1,000,000"),
    "fewer": (lambda: creak.robust("none.toml", n=-5), "n = -5; expected a whole number, 4 to"),
    "half a draw": (lambda: creak.robust("none.toml", n=2.5), "n = 2.5; expected a whole number, 4 to"),
    "threads": (lambda: creak.robust("none.toml", threads=-3), "threads = -3; expected a whole number, 1 or more"),
    "threads in words": (lambda: creak.robust("none.toml", threads="a"), "threads = 'a'; expected a whole number"),
    "half an output": (
        lambda: creak.simulate(MASS, STOP, LOADS, output_every=2.5),
        "output_every = 2.5; expected a whol",
    ),
    "half a substep": (
        lambda: creak.simulate(MASS, STOP, LOADS, creak.HHT(), substeps=1.5),
        "substeps = 1.5; expected",
    ),
    "a scheme's name": (lambda: creak.simulate(MASS, STOP, LOADS, scheme="hht"), "'hht', .* creak.HHT.alpha"),
    "not called": (lambda: creak.simulate(MASS, STOP, LOADS, creak.HHT), "scheme = HHT, .* creak.generalised_alpha"),
    "the class": (lambda: creak.simulate(MASS, STOP, LOADS, creak.Scheme), "scheme = Scheme, which is no scheme"),
    "no result": (lambda: creak.compare(None, "b"), "the first of the two is None; .* creak.run"),
    "no second": (lambda: creak.compare("a", 3), "the second of the two is of type int"),
    "half a mode": (lambda: creak.modes(np.eye(3), np.eye(3), count=2.5), "count = 2.5; expected a whole number"),
    "mode in words": (lambda: creak.modes(np.eye(3), np.eye(3), f_max="all"), "f_max = 'all'; expected a number"),
    "no run": (lambda: creak.run(None), "the study is None; expected a Study, or the path"),
    "a run of tables": (lambda: creak.run({"model": {}}), "the study is of type dict; .* creak.make_study"),
    "no study": (lambda: creak.read_study(None), "the study is None; expected the path of a study file"),
    "draws of tables": (lambda: creak.robust({}), "the study is of type dict"),
    "no tables": (lambda: creak.make_study(None), "tables is None; expected a mapping"),
    "a change as the command has it": (
        lambda: creak.change_study(creak.make_study(DECK), "time.end=1"),
        "changes is of type str; expected a mapping",
    ),
    "a folder": (lambda: creak.run("s.toml", superelements=5), "superelements is of type int; expected a folder"),
    "a keyword": (lambda: creak.run("s.toml", ignore="PLASTIC"), r"ignore = 'PLASTIC'; .* ignore=\['PLASTIC'\]"),
    "of modes": (lambda: creak.deck_modes("d.inp", ignore="PLASTIC"), "ignore = 'PLASTIC'; expected a list"),
    "one parameter": (lambda: creak.update_study("s.toml", "t.unv", "a.b"), r"parameters=\['a.b'\]"),
    "all changes": (lambda: creak.run_setup(None, changes="all"), "changes = 'all'; expected 'none' or 'predicted'"),
    "converge": (lambda: creak.run_setup(None, converge="no"), "converge = 'no'; expected True or False or None"),
    "a matrix": (lambda: creak.simulate(np.eye(1), STOP, LOADS), "system is of type ndarray; .* creak.system_from"),
    "no gaps": (lambda: creak.simulate(MASS, None, LOADS), "gaps is None; expected channels of .* linear motion"),
    "no channels": (lambda: creak.simulate(MASS, [np.eye(1)], LOADS), "one of the gaps is of type ndarray"),
    "no loads": (lambda: creak.simulate(MASS, STOP, None), "loads is None; .* creak.make_loads"),
    "forces by label": (lambda: loads(forces={0: SINE}), "forces = {0: .* a list of pairs"),
    "one force": (lambda: loads(forces=([0], SINE)), r"forces = \(\[0\], Sine.* a list of pairs"),
    "a force of no kind": (lambda: loads(forces=SINE), "forces = Sine.* a list of pairs"),
    "a signal's name": (lambda: loads(forces=[([0], "sine")]), "a force is 'sine'; expected a signal"),
    "a motion as a number": (
        lambda: creak.make_loads(DRIVEN, LOADS.time, motion={"b": 1.0}),
        "motion 'b' is of type float; expected a signal",
    ),
    "a table that falls": (
        lambda: creak.Table([0.0, 0.2, 0.1], np.zeros(3)),
        "Table: the time 0.1 after 0.2; expected",
    ),
    "a table of other values": (lambda: creak.Table([0.0, 0.2], np.zeros(3)), "Table: 3 values at 2 times"),
    "a record that is uneven": (lambda: creak.Record([0.0, 1.0, 3.0], np.zeros(3), 0.1), "a record with uneven times"),
    "a record of one sample": (lambda: creak.Record([0.0], [0.0], 0.1), "Record: time is of shape .* 2 or more finite"),
    "no lines": (
        lambda: creak.Multisine(1.0, 0.5, 1.0),
        "a multisine without a line from 1 to 0.5 Hz",
    ),
    "events the wrong way round": (lambda: creak.find_events(STOP, history()), "history is of type GapOperator"),
    "events of other gaps": (
        lambda: creak.find_events(history(), creak.gap_channels([[-1.0], [-1.0]], 0.0, 1e6)),
        "a history of 1 channels and gaps with 2",
    ),
    "slips of other gaps": (
        lambda: creak.find_slips(history(), creak.gap_channels([[-1.0], [-1.0]], 0.0, 1e6)),
        "a history of 1 channels and gaps with 2",
    ),
    "a sine in words": (lambda: creak.Sine("a", 1), "Sine: frequency = 'a'; expected a number"),
    "a sine of no frequency": (lambda: creak.Sine(-1.0, 1.0), "Sine: frequency = -1; expected a positive number"),
    "a step of nothing": (lambda: creak.Step(np.nan), "Step: amplitude = nan; expected a finite number"),
    "no period": (lambda: creak.Multisine(1.0, 9.0, 1.0, period=0), "Multisine: period = 0; expected a positive"),
    "a seed in words": (lambda: creak.Multisine(1.0, 9.0, 1.0, seed="a"), "seed = 'a'; expected a whole number"),
    "a table of words": (lambda: creak.Table("a", [0.0]), "Table: time = 'a'; expected a number or more"),
    "rounding": (lambda: creak.Table([0.0, 1.0], [0.0, 1.0], -1.0), "rounding = -1.0; expected a number from 0 to"),
    "no cut": (lambda: creak.Record(np.arange(9.0), np.zeros(9), None), "Record: high_pass = None; expected a number"),
    "motion of no signal": (lambda: creak.displacement_motion(1.0, LOADS.time), "signal is of type float; .* a signal"),
    "motion at no times": (lambda: creak.acceleration_motion(SINE, "a"), "t = 'a'; expected a number or more"),
    "motion of nan": (
        lambda: creak.make_loads(DRIVEN, LOADS.time, motion={"b": creak.Motion(*[LOADS.time * np.nan] * 3)}),
        "motion 'b' holds nan; expected a row of finite numbers",
    ),
    "alpha in words": (lambda: creak.HHT("a"), "HHT alpha = 'a'; expected a number"),
    "no radius": (lambda: creak.generalised_alpha(None), "rho_inf = None; expected a number"),
    "no step": (lambda: creak.integrate_twice(np.zeros(9), 0.0, 1.0), "step = 0; expected a positive number"),
    "no matrix": (lambda: creak.gap_channels(None, 0.0, 1.0), "G = None; expected a matrix"),
    "a clearance in words": (lambda: rubs(damping="a"), "damping = 'a'; expected a number or more"),
    "endless damping": (lambda: rubs(damping=np.inf), "damping = inf; expected a finite number"),
    "tangents as a number": (lambda: rubs(tangents=1.0), "tangents is of type float; expected a list of one or two"),
    "one name": (lambda: rubs(names="ab"), "names = 'ab'; expected a list of texts"),
    "no operators": (lambda: creak.join_gaps("a"), "one of the gaps is of type str; expected channels"),
    "no system": (lambda: creak.guyan(None, [0]), "system is None; expected a System"),
    "no system to load": (lambda: creak.make_loads(None, LOADS.time), "system is None; expected a System"),
    "damping in words": (lambda: creak.system_from_matrices(np.eye(2), np.eye(2), alpha="a"), "alpha = 'a'; expected"),
    "no equations": (lambda: creak.couple(MASS, equations=5), r"equations = 5; .* \[\(labels, coefficients\), ...\]"),
    "driven by no name": (lambda: creak.couple(MASS, driven=[0]), "driven is of type list; expected a mapping"),
    "shapes of others": (lambda: creak.mac_matrix(np.eye(3), np.eye(2)), r"shapes \(3, 3\) and \(2, 2\)"),
    "no deck": (lambda: creak.read_deck(None), "path is None; expected the path of a deck"),
    "no folder": (lambda: creak.open_result(None), "folder is None; expected a path"),
    "half retained": (lambda: creak.craig_bampton(MASS, [0], count=0.5), "count = 0.5; expected a whole number"),
    "rows of other lengths": (
        lambda: creak.Sine(UNEVEN, 1.0),
        r"frequency = \[\[1.0\], \[2.0, 3.0\]\]; expected a number",
    ),
    "such labels": (lambda: creak.guyan(MASS, UNEVEN), "labels of type object; expected integers"),
    "such channels": (lambda: creak.gap_channels(UNEVEN, 0.0, 1.0), "G is no matrix"),
    "a matrix of nothing": (lambda: creak.gap_channels([None], 0.0, 1.0), "G is no matrix: it holds objects"),
    "events of none": (
        lambda: creak.match_events(None, events(), 1e-3, (0.0, 1.0)),
        "reference is None; expected a list",
    ),
    "events in words": (lambda: creak.match_events(events(), "ab", 1e-3, (0.0, 1.0)), "one of reduced is of type str"),
    "below no tolerance": (
        lambda: creak.match_events(events(), events(), -1.0, (0.0, 1.0)),
        "tolerance = -1; expected sec",
    ),
    "a window of one": (
        lambda: creak.match_events(events(), events(), 1.0, (0.0,)),
        r"window = \(0.0,\); expected \(begin, end",
    ),
    "a window backwards": (lambda: creak.match_events(events(), events(), 1.0, (1.0, 0.0)), "expected .begin, end., s"),
    "spectra of nothing": (lambda: creak.nrmse_fit([], []), "reference is empty; expected one number"),
    "spectra of nan": (
        lambda: creak.nrmse_fit([1.0, np.nan], [1.0, 2.0]),
        r"reference = \[1.0, nan\]; expected finite",
    ),
    "spectra of others": (
        lambda: creak.nrmse_fit(np.ones(3), 1.0),
        r"x is of shape \(\); expected \(3,\), as the other",
    ),
    "spectra of two axes": (lambda: creak.nrmse_by_axis(np.ones((4, 3, 2)), 1.0), r"expected \(n_freq, n_pair, 3\)"),
    "near nothing": (lambda: creak.near_elements(None, [0], 1.0), "model is None; expected a Model"),
    "a setup of none": (lambda: creak.run_setup(None), "setup is None; expected what creak.set_up made"),
    "other units": (lambda: creak.set_up("a.inp", units="inch"), "units = 'inch'; expected '"),
    "a keyword's number": (lambda: creak.run("s.toml", ignore=[1]), r"ignore = \[1\]; expected a list of texts"),
    "progress in words": (
        lambda: creak.robust("s.toml", progress="bar"),
        "progress is of type str; expected a function",
    ),
    "steps in words": (lambda: creak.simulate(MASS, STOP, LOADS, progress="bar"), r"a function of \(done, total\)"),
    "draws into a number": (lambda: creak.robust("s.toml", out=5), "out is of type int; expected a folder"),
    "skip in words": (lambda: creak.steady_loudness(TONE, RATE, skip="a"), "skip = 'a'; expected a number"),
    "skip back": (lambda: creak.steady_loudness(TONE, RATE, skip=-1), "skip = -1; expected seconds, zero or more"),
    "fields": (lambda: creak.loudness(TONE, RATE, np.zeros(2)), "sound field = array.* expected 'free' or 'diffuse'"),
    "all changes at once": (lambda: creak.run_setup(None, changes=np.zeros(2)), "changes = array"),
    "a link of no kind": (
        lambda: creak.RigidLink("hinge", 0, 1),
        "RigidLink: kind = 'hinge'; expected 'beam' or 'tie' or",
    ),
    "a link to no node": (lambda: creak.RigidLink("beam", -1, 1), "dependent_idx = -1; expected a whole number, 0 or"),
    "a scheme of words": (lambda: creak.Scheme("a", 0.0, 0.25, 0.5), "Scheme: alpha_m = 'a'; expected a number"),
    "events by number": (lambda: creak.Events([1], ["1"], "mm-t-s"), "one of events is of type int; .* list of Event"),
    "recordings by name": (
        lambda: creak.compare_sounds(".", "a.wav"),
        "one of recordings is of type str; .*read_record",
    ),
    "a door's play": (lambda: creak.write_door(".", hook_play="a"), "hook_play = 'a'; expected a number"),
    "a door's load": (lambda: creak.write_door(".", load=[]), "load is of type list; expected a text: A1 to A4"),
    "a door's merging": (
        lambda: creak.write_door(".", coarsen=[1]),
        r"coarsen = \[1\]; expected a whole number, 1 to 3",
    ),
    "no data": (lambda: creak.write_json("a.json", [1]), "data is of type list; expected a mapping"),
    "nothing integrated": (lambda: creak.integrate_twice([], 1.0, 1.0), "1 or more finite numbers"),
    "motions by number": (
        lambda: creak.make_loads(DRIVEN, LOADS.time, motion=1),
        "motion is of type int; .* a mapping",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_no_such_number_is_refused(case):
    call, text = WRONG[case]
    with pytest.raises(creak.InputError, match=text):
        call()


def test_draws_are_bounded_alike_by_the_command():
    option = inspect.signature(command.robust).parameters["n"].default
    assert (option.min, option.max) == DRAWS


def test_whole_numbers_of_numpy_count():
    few = creak.modes(np.diag([1.0, 2.0, 3.0]), np.eye(3), count=np.int64(2))
    assert few.omega2 == pytest.approx([1.0, 2.0])
