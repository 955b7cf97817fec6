"""One study on a bench: what it runs is what `creak.run` runs, and what cannot be is refused."""

from dataclasses import replace

import numpy as np
import pytest

import creak
from helpers_decks import STUDY, write_strips
from helpers_refusal import refusal

AMPLITUDE = "excitation.root.signal.amplitude"
TABLE = {"f_max": 3000.0}
SHORT = STUDY.replace("periods = 2", "end = 0.2\nintegrator = 'hht'") + "\n[precheck]\nmargin = 0.5\n"


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    return creak.read_study(write_strips(tmp_path_factory.mktemp("bench"), study=SHORT))


@pytest.fixture(scope="module")
def bench(study):
    return creak.make_bench(study)


@pytest.fixture(scope="module")
def reduced(bench):
    return bench.reduced(TABLE)


def same_motion(one, two):
    assert np.abs(one.gap).max() > 0.0
    np.testing.assert_allclose(one.gap, two.gap, rtol=0.0, atol=1e-9 * np.abs(one.gap).max())
    np.testing.assert_allclose(one.force, two.force, rtol=0.0, atol=1e-6 * max(np.abs(one.force).max(), 1.0))


def test_both_models_run_as_a_study_runs_them(bench, reduced, study):
    whole = creak.run(study, converge=False)
    same_motion(whole.runs["reference"].history, bench.run().history)
    same_motion(whole.runs["reduced"].history, reduced.run().history)
    assert whole.runs["reduced"].history.force.any()
    match = whole.agreement
    again = creak.match_events(bench.run().events, reduced.run().events, 0.01, bench.window)
    assert len(again.pairs) == len(match.pairs) > 0


def test_another_load_is_the_study_with_that_signal(reduced, study):
    other = creak.run(creak.change_study(study, {AMPLITUDE: 0.1, "reference.run": False}), converge=False)
    same_motion(other.history, reduced.under({AMPLITUDE: 0.1}).run().history)


def test_loads_add_up_and_leave_the_reduction(reduced):
    both = reduced.under({AMPLITUDE: 0.1}).under({"excitation.root.signal.seed": 5})
    signal = both.setup.study.config.excitation["root"].signal
    assert (signal.amplitude, signal.seed) == (0.1, 5)
    guyan = reduced.reduced({"method": "guyan"}).under({AMPLITUDE: 0.1})
    assert guyan.setup.study.config.reduction.method == "guyan"
    assert guyan.gaps is reduced.gaps


def test_a_faster_load_brings_its_own_step(tmp_path):
    """Without a forced step the flight step follows from the highest frequency."""
    text = STUDY.replace("step = 5e-4\n", "").replace("periods = 2", "end = 0.1")
    bench = creak.make_bench(write_strips(tmp_path, study=text))
    faster = bench.under({"excitation.root.signal.f_max": 1200.0})
    tenth = 0.1 / 1200.0 * (1.0 + 1e-9)
    assert faster.setup.study.config.time.step <= tenth < bench.setup.study.config.time.step
    said = str(refusal(bench.reduced({"f_max": 300.0}).under, {"excitation.root.signal.f_max": 400.0}))
    assert "f_max = 300 Hz" in said


def test_more_modes_come_nearer_to_the_unreduced_model(study):
    """Contact at two nodes only, so that there is an inside to reduce."""
    tip = creak.make_bench(study)
    few = creak.make_bench(study, at=tip.positions[:2])
    errors = []
    for table in ({"method": "guyan", "f_max": 3000.0}, TABLE):
        found = few.reduced(table).modes()
        n = found.freq_reference.size
        errors.append(np.abs(found.freq_reduced[:n] / found.freq_reference - 1.0).max())
        np.testing.assert_allclose(few.frequencies[:n], found.freq_reference)
    assert errors[1] < 0.01 < errors[0]
    assert few.modes() is None


def test_spectra_are_those_of_the_pairs_in_the_window(bench, reduced):
    freq, motion = reduced.spectra(reduced.run())
    reference = bench.spectra(bench.run())[1]
    assert motion.shape == (freq.size, 2, 3) == reference.shape
    assert creak.nrmse_by_axis(reference, motion)["z"] > 0.9
    lone = replace(
        bench, setup=replace(bench.setup, watch=replace(bench.setup.watch, pairs=np.zeros((0, 2), dtype=np.int64)))
    )
    assert "names no pairs" in str(refusal(lone.spectra, bench.run()))


def test_a_kept_run_is_not_made_again(bench, tmp_path, monkeypatch):
    file = tmp_path / "runs" / "whole.npz"
    first = bench.run(keep=file)
    monkeypatch.setattr("creak.studies.sweep.case.march_run", lambda *_: pytest.fail("made again"))
    same_motion(first.history, bench.run(keep=file).history)


def test_channels_of_another_bench_are_taken_over(bench, study):
    some = bench.positions[[2, 5]]
    narrow = creak.make_bench(study, at=some)
    assert narrow.gaps.m == 2
    np.testing.assert_allclose(narrow.positions, some)
    assert creak.make_bench(study, at=np.zeros((0, 3))).gaps.m == 0


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda b, r: b.under({"reduction.f_max": 700.0}), "reduction.f_max is no key of a signal"),
        (lambda b, r: b.under({"excitation.root.dof": "x"}), "is no key of a signal"),
        (lambda b, r: b.under({AMPLITUDE: "much"}), "amplitude"),
        (lambda b, r: b.under({"excitation.hinge.signal.amplitude": 1.0}), "no [excitation.hinge]"),
        (lambda b, r: b.reduced({"fmax": 700.0}), "fmax"),
        (lambda b, r: b.reduced({"f_max": 10.0}), "not above the excitation"),
        (lambda b, r: b.reduced({"unreduced": ["NOWHERE"]}), "NOWHERE"),
        (lambda b, r: r.run(keep="there.npz"), "would keep a reduced run"),
        (lambda b, r: creak.make_bench(b.setup.study, at=[1.0, 2.0]), "at has shape (2,)"),
        (lambda b, r: creak.make_bench(b.setup.study, at=[[1e3, 2e3, 3e3]]), "no contact channel"),
    ],
)
def test_what_cannot_be_is_refused(bench, reduced, call, words):
    assert words in str(refusal(call, bench, reduced))


def test_a_load_that_closes_what_was_dropped_is_refused(tmp_path):
    """The pre-check is that of the load that the bench was made with."""
    text = STUDY.replace("step = 5e-4\n", "").replace("periods = 2", "end = 0.1").replace("0.05,", "0.06,")
    bench = creak.make_bench(write_strips(tmp_path, study=text))
    assert 0 < bench.gaps.m < 39
    assert "closed that the pre-check has dropped" in str(
        refusal(bench.reduced(TABLE).under({AMPLITUDE: 20.0}).run, "reduced")
    )
