"""Numbers of a Python program: those of NumPy count as plain ones, what is no number is refused with what is expected."""

from __future__ import annotations

import inspect

import numpy as np
import pytest
import scipy.sparse as sp

import creak
from creak.api.robust import DRAWS
from creak.cli import robust as command
from helpers_core import time_axis
from helpers_refusal import refusal

RATE = 32_000
TONE = 0.02 * np.sin(2.0 * np.pi * 1000.0 * np.arange(RATE // 10) / RATE)
MASS = creak.system_from_matrices([[1e4]], [[100.0]], velocity=[1.0])
STOP = creak.gap_channels([[-1.0]], 0.0, 1e6)
LOADS = creak.make_loads(MASS, time_axis(0.05, 2e-4))
HISTORY = creak.simulate(MASS, STOP, LOADS)
DRIVEN = creak.couple(creak.system_from_matrices(np.eye(2), np.eye(2)), driven={"b": [0]})
SINE = creak.Sine(20.0, 1.0)
FALLING = creak.Table(np.array([0.0, 0.2, 0.1]), np.array([0.0, 1.0, 2.0]))
DECK = {"model": {"deck": "d.inp"}}
KINDS = (np.float32, np.float64, np.array, lambda x: np.array(x, dtype=np.float32))


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
    "f_max 0": (lambda: creak.find_events(HISTORY, STOP, f_max=0), "f_max = 0; expected a positive number"),
    "f_max -1": (lambda: creak.find_events(HISTORY, STOP, f_max=-1.0), "f_max = -1; expected a positive number"),
    "f_max nan": (lambda: creak.find_events(HISTORY, STOP, f_max=np.nan), "f_max = nan; expected a positive number"),
    "merge": (lambda: creak.find_events(HISTORY, STOP, merge=-1e-3), "merge = -0.001; expected seconds"),
    "slips": (lambda: creak.find_slips(HISTORY, STOP, f_max=0), "f_max = 0; expected a positive number"),
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
    "a table that falls": (lambda: loads(forces=[(0, FALLING)]), "a force: times that do not rise"),
    "a motion that falls": (
        lambda: creak.make_loads(DRIVEN, LOADS.time, motion={"b": FALLING}),
        "motion 'b': times that do not rise",
    ),
    "a record that is uneven": (
        lambda: loads(forces=[(0, creak.Record(np.array([0.0, 1.0, 3.0]), np.zeros(3), 0.1))]),
        "a force: a record with uneven times; expected two or more samples, evenly spaced",
    ),
    "a record of one sample": (
        lambda: loads(forces=[(0, creak.Record(np.zeros(1), np.zeros(1), 0.1))]),
        "a force: a record with 1 sample",
    ),
    "no lines": (
        lambda: loads(forces=[(0, creak.Multisine(1.0, 0.5, 1.0))]),
        "a multisine without a line from 1 to 0.5 Hz",
    ),
    "events the wrong way round": (lambda: creak.find_events(STOP, HISTORY), "history is of type GapOperator"),
    "events of other gaps": (
        lambda: creak.find_events(HISTORY, creak.gap_channels([[-1.0], [-1.0]], 0.0, 1e6)),
        "a history of 1 channels and gaps with 2",
    ),
    "slips of other gaps": (
        lambda: creak.find_slips(HISTORY, creak.gap_channels([[-1.0], [-1.0]], 0.0, 1e6)),
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
