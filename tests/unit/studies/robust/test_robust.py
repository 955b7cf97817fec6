"""`creak robust`: odds and causes of a stopped beam against quadrature, draws against single runs, resuming, refusals."""

from __future__ import annotations

import json
import pickle
import re
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from benchmarks.odds import DECK, STOPPED_BEAM, reach
from scipy.stats import norm

import creak
from creak.dynamics.chunks import march_chunks
from creak.dynamics.flow import batch
from creak.dynamics.flow.march import simulate_flow
from creak.dynamics.record.recorder import OutputRequest
from creak.errors import InputError, NumericalError
from creak.formats.stored.record_log import read_records, record_log
from creak.linalg.modes import modes
from creak.reduction import craig_bampton
from creak.report.tables import robust as rows
from creak.studies.file.changes import with_changes
from creak.studies.file.reader import read_study
from creak.studies.models import of_parts
from creak.studies.models.reference import build_reference
from creak.studies.models.saved import NO_STORE
from creak.studies.prepare.setup import set_up
from creak.studies.prepare.varied import varied
from creak.studies.robust import job
from creak.studies.robust import shared_model as shared_model_room
from creak.studies.robust.batches import batches
from creak.studies.robust.changes import TABLES, at_start, drawn_setup
from creak.studies.robust.draws import Draw, field_shapes
from creak.studies.robust.linear import FACTORS, Linear, closes, multiple, plain_of
from creak.studies.robust.shared_model import FORETOLD, lowest_of, shared_model, variant_of
from creak.studies.run.precheck import WITHOUT_WHOLE, with_linear_gaps
from creak.studies.run.static_start import started
from creak.studies.warned import Warned
from creak.verify.odds import Index, odds
from helpers_cli import say
from helpers_decks import STUDY, write_strips, write_study

MEAN, SIGMA, LOW, HIGH = 10.0, 1.5, 0.4, 1.0
STOPPED = f"""{STOPPED_BEAM}[scatter.vary]
"connector.0.upper" = {{ type = "normal", sigma = {SIGMA} }}
"excitation.tip.signal.amplitude" = {{ type = "uniform", low = {LOW}, high = {HIGH} }}
"""


def stopped(folder: Path, text: str = STOPPED) -> Path:
    return write_study(folder, text, {"beam.inp": DECK})


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    path = stopped(tmp_path_factory.mktemp("stopped"))
    return creak.robust(path, 64, threads=1), reach(path)


def quadrature(most: float) -> tuple[float, dict[str, tuple[float, float]]]:
    """Probability that most * amplitude passes the gap, and first and total index of both causes."""
    x, w = np.polynomial.legendre.leggauss(200)
    amplitude, w = LOW + (HIGH - LOW) * 0.5 * (1.0 + x), 0.5 * w
    by_amplitude = norm.cdf((most * amplitude - MEAN) / SIGMA)
    p = float(w @ by_amplitude)
    gap = MEAN + SIGMA * norm.ppf((np.arange(20_000) + 0.5) / 20_000)
    by_gap = np.clip((HIGH - gap / most) / (HIGH - LOW), 0.0, 1.0)
    whole = p * (1.0 - p)
    of_amplitude, of_gap = (float(w @ by_amplitude**2) - p**2) / whole, float(by_gap.var()) / whole
    return p, {
        "connector.0.upper": (of_gap, 1.0 - of_amplitude),
        "excitation.tip.signal.amplitude": (of_amplitude, 1.0 - of_gap),
    }


def test_odds_and_causes_against_quadrature(found):
    """Sobol points are far more even than independent draws, so the odds come within a third of their bounds."""
    robustness, most = found
    p, indices = quadrature(most)
    assert 0.2 < p < 0.8
    assert robustness.rattle.low < p < robustness.rattle.high
    assert abs(robustness.rattle.p - p) < (robustness.rattle.high - robustness.rattle.low) / 6.0
    for key, (first, total) in indices.items():
        index = robustness.indices["rattle"][key]
        assert index.first_bounds[0] <= first <= index.first_bounds[1]
        assert index.total_bounds[0] <= total <= index.total_bounds[1]
        assert index.total == pytest.approx(total, abs=0.15)


def test_further_draws_make_the_odds_narrower(found):
    """By motion without contact, as if by many times as many draws; a few of them are marched."""
    robustness, most = found
    p, _ = quadrature(most)
    for known in (robustness.rattle, robustness.places[0].rattle):
        alone = odds(known.hits, known.n)
        assert (known.n, known.foretold) == (64, 4096)
        assert known.low < p < known.high
        assert known.high - known.low < 0.45 * (alone.high - alone.low)
    marched = robustness.draws.further.rows.size
    assert 0 < marched < 100
    said = f"4096 more that motion without contact foretells ({marched} of these were marched to see how well)"
    assert f"of 64 draws and {said}" in rows.sentence(robustness)
    assert robustness.as_dict()["rattle"]["foretold"] == 4096


def test_further_draws_are_kept_beside_the_others(tmp_path, monkeypatch):
    """The same odds without a model, and no better than counted where their file is gone."""
    path, out = stopped(tmp_path), tmp_path / "out"
    whole = creak.robust(path, 16, out=out, indices=False, threads=1)
    monkeypatch.setattr(job, "shared_model", None)
    again = creak.robust(path, 16, out=out, indices=False, threads=1)
    assert whole.rattle == again.rattle
    assert again.rattle.foretold == 1024
    assert again.draws.taken == 16
    (kept,) = out.glob("further-*.bin")
    kept.write_bytes(kept.read_bytes()[:-1])
    counted_ones = creak.robust(path, 16, out=out, indices=False, threads=1).rattle
    assert counted_ones == odds(whole.rattle.hits, 16)


def test_no_further_draws_where_they_leave_what_a_study_may_say(tmp_path):
    """One of 400 stiffnesses is negative: among 16 none is."""
    text = STOPPED + '"connector.0.stiffness" = { type = "normal", sigma = 18.0 }\n'
    assert creak.robust(stopped(tmp_path, text), 16, indices=False, threads=1).rattle.foretold == 0


def test_a_leading_cause_is_named_where_the_bounds_tell_it(found):
    robustness, _ = found
    gap, load = robustness.draws.design.causes

    def sentence(high: float) -> str:
        of = {gap.key: Index(0.7, (0.6, 0.8), 0.8, (0.7, 0.9)), load.key: Index(0.2, (0.1, 0.3), 0.3, (0.1, high))}
        return rows.sentence(replace(robustness, indices={"force": of}))

    assert f"most of the scatter comes from {gap.key};" in sentence(0.5)
    assert f"comes from {gap.key} or {load.key}, alike within their bounds;" in sentence(0.71)
    assert rows.index_rows(robustness)[1][0] == f"{gap.key}, alone"


def test_needed_gap_and_fragility_against_quadrature(found):
    """P(most A f > gap + shift), A uniform: from the distribution of most A - gap."""
    robustness, most = found
    place = robustness.places[0]
    x = (np.arange(4000) + 0.5) / 4000
    slack = (MEAN + SIGMA * norm.ppf(x))[:, None] - most * (LOW + (HIGH - LOW) * x)
    assert place.need.low <= -np.quantile(slack, 0.05) <= place.need.high
    assert place.need.gap == pytest.approx(MEAN + place.need.shift)
    gap = MEAN + SIGMA * norm.ppf(x)
    for factor, bound in zip(FACTORS, place.fragility, strict=True):
        closed = float(np.clip((HIGH - gap / (factor * most)) / (HIGH - LOW), 0.0, 1.0).mean())
        assert bound.low - 1e-9 <= closed <= bound.high + 1e-9


def test_draws_are_single_runs(found):
    """Side by side or alone: the same to the last digit."""
    draws = found[0].draws
    study = draws.setup.study
    keys = [c.key for c in draws.design.causes]
    numbers = [draws.drawn.draw(k) for k in (3, 40, 60)]
    assert all([*draw.values] == keys for draw in numbers)
    bench = shared_model(draws.setup, numbers, lambda *_: None)
    for draw in numbers:
        setup = set_up(with_changes(study, draw.values))
        variant = variant_of(bench, draw)
        assert np.array_equal(variant.gaps.gap0, setup.connectors.gap0)
        assert np.array_equal(variant.loads.force, setup.loads.force)
        alone = simulate_flow(
            bench.system,
            variant.gaps,
            setup.loads,
            OutputRequest(np.zeros(0, dtype=int)),
            resolution=setup.marching.resolution,
        )
        shared = march_chunks(bench.base.again(variant.gaps, variant.loads), None)
        assert np.array_equal(alone.time, shared.time)
        assert np.array_equal(alone.force, shared.force)
        kept = shared.force.copy()
        again = march_chunks(bench.base.again(variant.gaps, variant.loads), None)
        assert np.array_equal(again.force, kept)
        assert np.array_equal(shared.force, kept)  # runs that share a model write to tables of their own
        impulse = alone.weights @ alone.force
        assert draws.impulse[draw.number] == pytest.approx(impulse, rel=1e-10, abs=0.0)


def test_every_number_that_keeps_the_model_changes_it_as_the_study_does(tmp_path):
    """Channels and loads of a changed set-up are those of the changed study, read anew."""
    text = STUDY.replace("step = 5e-4\n", "").replace(
        'method = "surface-to-surface"', "clearance = 0.5\nfriction = 0.2\nstiffness = 30.0\ndamping = 0.001"
    )
    setup = set_up(read_study(write_strips(tmp_path, None, text)))
    changes = {
        "contact.tip.clearance": 0.7,
        "contact.tip.friction": 0.3,
        "contact.tip.stiffness": 45.0,
        "contact.tip.damping": 0.002,
        "excitation.root.signal.amplitude": 0.07,
        "excitation.root.signal.seed": 11,
    }
    study = with_changes(setup.study, changes)
    again, made = varied(setup, study.tables(TABLES)), set_up(study)
    assert again.contacts.names == made.contacts.names
    for key in ("gap0", "stiffness", "damping"):
        assert getattr(again.contacts, key) == pytest.approx(getattr(made.contacts, key), rel=1e-14)
    assert np.array_equal(again.contacts.friction.static, made.contacts.friction.static)
    assert np.array_equal(again.loads.support, made.loads.support)
    assert abs(again.contacts.G - made.contacts.G).max() == 0.0
    field = np.linspace(0.1, 0.9, setup.contacts.m)
    assert np.array_equal(varied(setup, {}, {"tip": field}).contacts.gap0, field)
    stiffer = varied(setup, {}, {}, {"tip": 1.5}).contacts
    assert stiffer.stiffness == pytest.approx(1.5 * setup.contacts.stiffness)


def test_friction_that_a_draw_alone_has_acts_on_the_sides_as_in_its_study(tmp_path):
    """Without friction no channel takes the rotations of its nodes."""
    setup = set_up(read_study(write_strips(tmp_path, None, STUDY)))
    study = with_changes(setup.study, {"contact.tip.friction": 0.3})
    again, made = varied(setup, study.tables(TABLES)).contacts, set_up(study).contacts
    assert again.names == made.names
    assert np.array_equal(again.labels, made.labels)
    assert again.labels.size > setup.contacts.labels.size
    for one, other in zip(again.tangents, made.tangents, strict=True):
        assert abs(one - other).max() == 0.0
    assert np.array_equal(again.friction.static, made.friction.static)


def test_a_stiffness_of_the_elements_scatters_by_a_factor(tmp_path):
    """Neither study nor deck has a number for it: each channel's own is multiplied."""
    text = STUDY.replace("step = 5e-4\nperiods = 2", "end = 0.02").replace("amplitude = 0.05", "amplitude = 3") + (
        '[scatter.vary]\n"contact.tip.stiffness" = { type = "uniform", low = 0.5, high = 2, relative = true }\n'
    )
    found = creak.robust(write_strips(tmp_path, None, text), 4, indices=False, threads=1).draws
    values = found.drawn.numbers[0]
    assert 0.5 <= values.min() < values.max() <= 2.0
    assert found.design.causes[0].is_factor
    draw = found.drawn.draw(2)
    assert draw.factors == {"tip": values[2]}
    assert not draw.values
    assert not found.reduced_again


def test_what_is_finished_is_not_run_again(tmp_path, monkeypatch):
    """Stopped after some draws: the rest is marched, the first ones are kept, a cut record is not."""
    monkeypatch.setattr("creak.studies.robust.further.TIMES", 0)
    path, out = stopped(tmp_path), tmp_path / "out"
    whole = creak.robust(path, 8, indices=False, threads=1).draws
    real = job.march_draws

    def stops(*args):
        for k, found in enumerate(real(*args)):
            if k == 3:
                raise KeyboardInterrupt
            yield found

    monkeypatch.setattr(job, "march_draws", stops)
    with pytest.raises(KeyboardInterrupt):
        creak.robust(path, 8, out=out, indices=False, threads=1)
    (log,) = out.glob("draws-*.bin")
    log.write_bytes(log.read_bytes()[:-5])
    monkeypatch.setattr(job, "march_draws", real)
    again = creak.robust(path, 8, out=out, indices=False, threads=1).draws
    settled = whole.design.total - whole.marched
    assert again.taken == settled + 2 < 8
    assert np.array_equal(again.impulse, whole.impulse)
    assert creak.robust(path, 8, out=out, indices=False).draws.taken == 8
    path.write_text(STOPPED.replace("upper = 10.0", "upper = 10.5"), encoding="utf-8")
    assert creak.robust(path, 4, out=out, indices=False).draws.taken == 0
    path.write_text(STOPPED.replace("[scatter.vary]", "# as measured\n[scatter.vary]"), encoding="utf-8")
    assert creak.robust(path, 8, out=out, indices=False).draws.taken == 8
    assert len(list(out.glob("draws-*.bin"))) == 2


def elsewhere(tasks):
    """As workers on other machines do: what goes there and comes back is bytes."""
    for task in tasks:
        yield task.name, pickle.loads(pickle.dumps(pickle.loads(pickle.dumps(task)).run()))


def test_batches_on_other_machines_are_the_same_draws(tmp_path, monkeypatch):
    """To the last digit; what a batch brought is kept when the command ends before the others."""
    monkeypatch.setattr("creak.studies.robust.batches.SIZE", 3)
    monkeypatch.setattr("creak.studies.robust.further.TIMES", 0)
    path, out = stopped(tmp_path), tmp_path / "out"
    whole = creak.robust(path, 8, indices=False, threads=1).draws

    def stops(tasks):
        yield next(elsewhere(tasks))
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        creak.robust(path, 8, out=out, indices=False, runner=stops)
    again = creak.robust(path, 8, out=out, indices=False, runner=elsewhere).draws
    assert again.taken == whole.design.total - whole.marched + 3
    for name in ("state", "figures", "slack", "impulse"):
        assert np.array_equal(getattr(again, name), getattr(whole, name), equal_nan=True)


def test_batches_of_models_of_their_own(tmp_path, monkeypatch):
    monkeypatch.setattr("creak.studies.robust.further.TIMES", 0)
    text = STOPPED.replace('"excitation.tip.signal.amplitude"', '"reduction.f_max"').replace(
        f"low = {LOW}, high = {HIGH}", "low = 15000, high = 20000"
    )
    path = stopped(tmp_path, text)
    here = creak.robust(path, 4, indices=False, threads=1).draws
    there = creak.robust(path, 4, indices=False, runner=elsewhere).draws
    assert np.array_equal(there.impulse, here.impulse)


def test_models_of_their_own_warn_once_of_what_they_leave_out(tmp_path):
    static = STUDY.replace("step = 5e-4\nperiods = 2", "end = 0.05").replace("f_max = 3000", 'method = "guyan"')
    vary = '[scatter.vary]\n"damping.rayleigh.alpha" = { type = "uniform", low = 1.0, high = 1.001 }\n'
    path = write_strips(tmp_path, study=f"{static}[damping.rayleigh]\nalpha = 1.0\n{vary}")
    for way in ({"threads": 1}, {"runner": elsewhere}):
        found = creak.robust(path, 4, indices=False, **way)
        assert found.draws.reduced_again
        (said,) = (note for note in found.notes if note.startswith("a Guyan reduction keeps no modes"))
        assert isinstance(said, Warned)


def test_a_batch_that_fails_is_told_after_the_others(tmp_path, monkeypatch):
    """Another deck there than here; the worker of another batch is lost."""
    monkeypatch.setattr("creak.studies.robust.batches.SIZE", 2)
    monkeypatch.setattr("creak.studies.robust.further.TIMES", 0)
    path, out = stopped(tmp_path), tmp_path / "out"

    def troubled(tasks):
        first, second, third = tasks
        yield first.name, first.lost("its worker process died every time", 0.0)
        yield second.name, replace(second, id="another", files=("", "")).run()
        yield third.name, third.run()

    with pytest.raises(NumericalError, match="2 of 3 batches of draws have failed: its worker process died every time"):
        creak.robust(path, 8, out=out, indices=False, runner=troubled)
    again = creak.robust(path, 8, out=out, indices=False, threads=1).draws
    assert again.marched == 6
    assert again.taken == 2 + 2
    batch = batches(read_study(path), 0, [Draw(0, {}, {})], np.zeros(0), NO_STORE)[0]
    assert "does not see the deck" in replace(batch, files=("", "")).run().error
    assert "were made with 0.0" in replace(batch, id="old", creak="0.0").run().error


def test_a_number_that_changes_the_model_is_drawn_too(tmp_path):
    text = STOPPED.replace('"excitation.tip.signal.amplitude"', '"reduction.f_max"').replace(
        f"low = {LOW}, high = {HIGH}", "low = 15000, high = 20000"
    )
    robustness = creak.robust(stopped(tmp_path, text), 4, indices=False, threads=1)
    assert robustness.draws.reduced_again == ("reduction.f_max",)
    assert any(note.startswith("reduction.f_max changes the model: it is set up 4 times") for note in robustness.notes)
    assert np.isfinite(robustness.draws.figures).all()


@pytest.mark.parametrize(
    ("key", "changed", "place"),
    [
        ("damping.rayleigh.alpha", 1, "kept"),
        ("section.UPPER.thickness", 4, "not kept"),
        ("section.UPPER.thickness", 4, "workers"),
    ],
)
def test_parts_that_draws_leave_as_they_are_are_reduced_once(tmp_path, monkeypatch, key, changed, place):
    made = []

    def basis(inside, *rest, **options):
        made.append(inside.name)
        return craig_bampton.fixed_interface_basis(inside, *rest, **options)

    solved = []
    monkeypatch.setattr("creak.studies.models.superelements.fixed_interface_basis", basis)
    monkeypatch.setattr(
        "creak.studies.models.reference.modes", lambda *given, **options: solved.append(1) or modes(*given, **options)
    )
    vary = (
        f'[section.UPPER]\nthickness = 1.0\n[scatter.vary]\n"{key}" = {{ type = "uniform", low = 1.0, high = 1.001 }}\n'
    )
    path = write_strips(tmp_path, study=STUDY.replace("step = 5e-4", "").replace("periods = 2", "end = 0.01") + vary)
    out, runner = None if place == "not kept" else tmp_path / "out", elsewhere if place == "workers" else None
    draws = creak.robust(path, 4, out=out, indices=False, threads=1, runner=runner).draws
    assert draws.reduced_again == (key,)
    assert sorted(made) == ["LOWER"] + changed * ["UPPER"]
    assert len(solved) == changed  # the unreduced model's


def test_draws_of_a_model_whose_whole_memory_does_not_hold(tmp_path, monkeypatch):
    """They are those of the whole, but for modes that are cut off where its parts are joined."""
    monkeypatch.setattr("creak.studies.robust.further.TIMES", 0)
    vary = '[scatter.vary]\n"contact.tip.clearance" = { type = "uniform", low = 0.1, high = 0.3 }\n'
    path = write_strips(tmp_path, study=STUDY.replace("step = 5e-4", "").replace("periods = 2", "end = 0.05") + vary)
    whole = creak.robust(path, 4, indices=False, threads=1).draws
    monkeypatch.setattr(of_parts, "only_parts_fit", lambda *_: True)
    monkeypatch.setattr(of_parts, "joined_reference", lambda *_: pytest.fail("the whole"))
    parts = creak.robust(path, 4, indices=False, threads=1).draws
    assert WITHOUT_WHOLE in parts.notes
    assert parts.marched > 0
    np.testing.assert_allclose(parts.impulse, whole.impulse, rtol=1e-6, atol=1e-9 * whole.impulse.max())
    assert whole.impulse.max() > 0.0


def test_draws_have_the_modes_that_the_run_of_the_study_ends_with(tmp_path):
    """f_max = "auto", twice: their model is that of `creak run`, and not the one that this begins with."""
    given = re.sub(r"f_max = \S+", 'f_max = "auto"', STOPPED[STOPPED.index("[reduction]") :], count=1)
    study = stopped(tmp_path, STOPPED[: STOPPED.index("[reduction]")] + given)
    robustness = creak.robust(study, 4, indices=False, threads=1)
    run = creak.run(study, converge=False, record=False)
    assert run.found.setup.raised > 0
    assert robustness.draws.setup.raised == run.found.setup.raised
    assert any('where f_max = "auto" ends in the run of the study itself' in note for note in robustness.notes)


def test_what_the_reduction_of_the_draws_leaves_out_is_told(tmp_path):
    """No draw is repeated with more modes: as a single run, these say that a static reduction keeps none."""
    static = re.sub(r"f_max = \S+", 'method = "guyan"', STOPPED[STOPPED.index("[reduction]") :], count=1)
    study = stopped(tmp_path, STOPPED[: STOPPED.index("[reduction]")] + static)
    notes = creak.robust(study, 4, indices=False, threads=1).notes
    (said,) = (note for note in notes if note.startswith("a Guyan reduction keeps no modes: what it leaves out was"))
    assert isinstance(said, Warned)


def test_the_run_of_the_study_and_its_draws_share_the_unreduced_model(tmp_path, monkeypatch):
    solved = []
    monkeypatch.setattr(
        "creak.studies.models.reference.modes", lambda *given, **options: solved.append(1) or modes(*given, **options)
    )
    given = re.sub(r"f_max = \S+", 'f_max = "auto"', STOPPED[STOPPED.index("[reduction]") :], count=1)
    before = re.sub(r"modal = \S+", "rayleigh = { alpha = 10.0, beta = 1e-6 }", STOPPED[: STOPPED.index("[reduction]")])
    study = stopped(tmp_path, before + given)
    assert creak.robust(study, 4, out=tmp_path / "out", indices=False, threads=1).draws.setup.raised > 0
    assert len(solved) == 1


def test_bad_input_leaves_no_folder(tmp_path):
    text = re.sub(r"f_max = \S+", 'method = "none"', STOPPED)
    with pytest.raises(InputError, match="draws are marched by exact flow on the reduced model"):
        creak.robust(stopped(tmp_path, text), 4, out=tmp_path / "made" / "out", indices=False, threads=1)
    assert not (tmp_path / "made").exists()


def test_modes_of_a_run_that_touches_nothing_are_told_of(tmp_path, monkeypatch):
    monkeypatch.setattr("creak.studies.converge.auto_band.SMALL", 0.0)  # as for large models, not all modes at once
    monkeypatch.setattr("creak.studies.converge.auto_band.WORTH", 0.0)
    text = re.sub(r"f_max = \S+", 'f_max = "auto"', STOPPED[STOPPED.index("[reduction]") :], count=1)
    text = STOPPED[: STOPPED.index("[reduction]")] + text
    study = stopped(tmp_path, re.sub(r"upper = \S+", "upper = 1e3", text, count=1))
    notes = creak.robust(study, 4, indices=False, threads=1).notes
    assert any("nothing touches in it, so set f_max" in note for note in notes)


def test_a_field_of_gaps_has_its_spread_and_correlation():
    x = np.linspace(0.0, 500.0, 60)
    shapes = field_shapes(np.column_stack([x, 0 * x, 0 * x]), 120.0)
    correlation = shapes @ shapes.T
    assert np.diag(correlation) == pytest.approx(1.0)
    exact = np.exp(-(((x[:, None] - x) / 120.0) ** 2))
    assert np.abs(correlation - exact).max() < 0.05
    assert shapes.shape[1] < 12


REFUSED = {
    "no scatter": ("", "nothing scatters"),
    "unknown key": ('"connector.0.uper" = { type = "normal", sigma = 1, mean = 1 }', "unknown key"),
    "unknown key that needs a mean": ('"connector.0.uper" = { type = "normal", sigma = 1 }', "unknown key"),
    "no such row": (
        '"connector.3.upper" = { type = "normal", sigma = 1, mean = 1 }',
        r"the study has 1 \[\[connector\]\]",
    ),
    "other name of a row": (
        '"connector.00.upper" = { type = "normal", sigma = 1, mean = 10 }',
        r"the study has 1 \[\[connector\]\]; expected connector.0",
    ),
    "no number": ('"connector.0.name" = { type = "normal", sigma = 1 }', "no number to scatter about"),
    "number of the deck": (
        '"section.BEAM.thickness" = { type = "normal", sigma = 1, mean = 9 }',
        r"Give the deck's value in the study, in \[section.BEAM\]",
    ),
    "of a run": ('"time.end" = { type = "uniform", low = 0.1, high = 1 }', "time.end says how a run is made"),
    "no friction there": (
        '"connector.0.friction" = { type = "uniform", low = 0.1, high = 0.2 }',
        "connector.0.friction is not given in the study: without it nothing rubs there",
    ),
    "unknown type": ('"connector.0.upper" = { type = "gauss", sigma = 1 }', "scatter.vary.connector.0.upper.type"),
    "no sigma": ('"connector.0.upper" = { type = "normal" }', "give either sigma or tolerance"),
    "low above high": ('"connector.0.upper" = { type = "uniform", low = 2, high = 1 }', "low = 2 is not below high"),
    "no field": ('"connector.0.upper" = { type = "field", tolerance = 1, length = 9 }', "is no field of gaps"),
    "foreign": ('"connector.0.upper" = { type = "uniform", low = 1, high = 2, sigma = 1 }', "has no sigma"),
    "not a seed": ('"connector.0.upper" = { type = "seed" }', "is no seed"),
    "leaves its range": (
        '"connector.0.stiffness" = { type = "normal", sigma = 60 }',
        r"\[scatter.vary.connector.0.stiffness\]: draws may reach connector.0.stiffness = -",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_drawn_is_refused(tmp_path, case):
    line, match = REFUSED[case]
    path = stopped(tmp_path, STOPPED.partition("[scatter.vary]")[0] + f"[scatter.vary]\n{line}\n")
    with pytest.raises(InputError, match=match):
        creak.robust(path, 64)


def test_negative_gaps_are_refused_on_the_command_line(tmp_path):
    text = STUDY.replace("step = 5e-4\n", "") + (
        '[scatter.vary]\n"contact.tip.clearance" = { type = "field", mean = 0.3, tolerance = 0.5, length = 40 }\n'
    )
    path = write_strips(tmp_path, None, text)
    say("robust", path).refuses("this distribution has negative gaps: -0.2 at three standard deviations")
    assert not (tmp_path / "robust").exists()


def test_the_command_writes_what_python_finds(tmp_path):
    path = stopped(tmp_path)
    told = json.loads(say("robust", path, "--n", "8", "--threads", "1", "--json").done().out)
    stored = json.loads((tmp_path / "robust" / "robust.json").read_text(encoding="utf-8"))
    assert told["rattle"] == stored["rattle"]
    assert stored["runs"] == 16
    page = (tmp_path / "robust" / "robust.html").read_text(encoding="utf-8")
    assert page.count("<svg") == 3
    assert len((tmp_path / "robust" / "draws.csv").read_text(encoding="utf-8").splitlines()) == 17


def test_records_survive_and_damage_is_seen(tmp_path):
    path, made = tmp_path / "log.bin", {"study": "a"}
    with record_log(path, made, 3, 0) as log:
        for k in range(4):
            log.add(k, np.full(3, float(k)))
    found, used = read_records(path, made, 3)
    assert sorted(found) == [0, 1, 2, 3]
    assert read_records(path, {"study": "b"}, 3) == ({}, 0)
    data = bytearray(path.read_bytes())
    data[used - 40] ^= 1  # in the third record
    path.write_bytes(bytes(data))
    found, used = read_records(path, made, 3)
    assert sorted(found) == [0, 1]
    with record_log(path, made, 3, used) as log:
        log.add(9, np.zeros(3))
    assert sorted(read_records(path, made, 3)[0]) == [0, 1, 9]


@pytest.mark.parametrize("seeds", [False, True])
def test_draws_that_cannot_touch_are_not_marched(tmp_path, monkeypatch, seeds):
    """What the motion without contact settles is what the march finds; seeds of their own have to be marched."""
    low, high = (0.05, 0.12) if seeds else (0.3, 0.7)
    text = STOPPED.replace(f"low = {LOW}, high = {HIGH}", f"low = {low}, high = {high}")
    if seeds:
        course = 'type = "multisine", amplitude = 0.1, f_min = 20, f_max = 200'
        text = text.replace('type = "step", amplitude = 0.7', course)
        text += '"excitation.tip.signal.seed" = { type = "seed" }\n'
    path, marched = stopped(tmp_path, text), []
    monkeypatch.setattr("creak.studies.robust.further.TIMES", 0)
    march = batch.march_chunks
    monkeypatch.setattr(batch, "march_chunks", lambda run, progress: marched.append(run) or march(run, progress))
    few = creak.robust(path, 32, indices=False, threads=1).draws
    hits, count = int(few.figures[:, :, 0].any(axis=1).sum()), len(marched)
    monkeypatch.setattr(job, "foretold", lambda *_: iter(()))
    monkeypatch.setattr(shared_model_room, "_foretold", lambda *_: None)
    every = creak.robust(path, 32, indices=False, threads=1).draws
    assert len(marched) - count == 32
    assert 0 < hits < 16
    assert count == 32 if seeds else hits <= count < 20
    np.testing.assert_array_equal(few.figures, every.figures)
    np.testing.assert_array_equal(few.impulse, every.impulse)
    np.testing.assert_array_equal(np.where(few.state == FORETOLD, 0.0, few.state), every.state)
    assert few.marched == count
    np.testing.assert_allclose(few.slack, every.slack, atol=1e-8 * MEAN)


TWO = STUDY.replace("step = 5e-4\nperiods = 2", "end = 0.04").replace(
    'method = "surface-to-surface"', 'method = "node-to-surface"'
)
SCATTERED = """[scatter.vary]
"contact.tip.clearance" = { type = "field", tolerance = 0.9, length = 40, mean = 1.0 }
"contact.tip.stiffness" = { type = "uniform", low = 0.5, high = 2, relative = true }
"excitation.root.signal.amplitude" = { type = "uniform", low = 0.04, high = 0.09 }
"""


@pytest.mark.parametrize("case", ["field, load", "numbers", "static load"])
def test_gaps_and_loads_of_all_draws_at_once_are_those_of_each(tmp_path, monkeypatch, case):
    monkeypatch.setattr("creak.studies.robust.further.TIMES", 0)
    text = TWO + SCATTERED
    if case == "numbers":
        text = text.replace("tolerance = 0.9, length = 40, mean = 1.0", "X").replace(
            '{ type = "field", X }', '{ type = "uniform", low = 0.3, high = 2 }'
        )
    if case == "static load":
        text += '[[static]]\nnode_set = "PAIRS"\ndof = "z"\nforce = 0.01\n'
        text += "[[static]]\ngravity = [0, 0, -9810]\n"
        text = text.replace("end = 0.04", "end = 0.02").replace(  # they press all the time
            '"excitation.root', '"static.0.force" = { type = "uniform", low = 0, high = 0.02 }\n"excitation.root'
        )
    setup = set_up(read_study(write_strips(tmp_path, None, text)))
    found = creak.robust(setup.study, 10, indices=False, threads=1).draws
    bench = shared_model(setup, found.drawn, lambda *_: None)
    assert bench.plain is not None
    gaps, factors = bench.plain.gaps(slice(3, 10)), bench.plain.factors(slice(3, 10))
    whole = replace(bench, gaps=found.channels)
    for k in range(3, 10):
        variant = variant_of(whole, found.drawn.draw(k))
        if gaps[k - 3].min() > 0.0:  # else static loads close a gap
            np.testing.assert_allclose(gaps[k - 3], variant.gaps.gap0, atol=1e-9)
        assert factors[k - 3] == pytest.approx(multiple(variant.loads, bench.base.loads), rel=1e-12)
    one_by_one = lowest_of(setup, bench.reference, [found.drawn.draw(k) for k in range(10)])
    if case != "static load":  # how far a drawn static load opens gaps that scatter, one by one does not count
        assert (bench.lowest <= one_by_one + 1e-9).all()  # which looks at the loads of eight draws alone
    for k in range(0, 10, 3):
        own = started(drawn_setup(setup, found.drawn.draw(k)), bench.reference, lambda *_: None)
        left = with_linear_gaps(
            own.study.config.precheck, own.reduction, own.marching, bench.reference, lambda *_: None
        ).linear_gaps
        assert (bench.lowest <= left - bench.reference.linear_gaps + 1e-9).all()
    assert bench.lowest.min() >= one_by_one.min() - 0.5


def test_few_that_rattle_among_draws_that_cost_nothing_ask_for_more(tmp_path):
    text = STOPPED.replace(f"low = {LOW}, high = {HIGH}", "low = 0.2, high = 0.35")
    found = creak.robust(stopped(tmp_path, text), 256, indices=False, threads=1)
    assert found.draws.marched < 20
    (note,) = (n for n in found.notes if "rattle" in n)
    assert f"{found.rattle.hits} of 256 draws rattle" in note
    assert "--n 16384 --no-indices" in note
    more = creak.robust(tmp_path / "study.toml", 16384, indices=False, threads=1)
    assert more.rattle.hits >= 10
    assert not any("rattle" in n for n in more.notes)


def test_draws_that_differ_in_more_are_not_foretold(tmp_path):
    """Damping, a course of their own, loads that are no multiple, gaps that start by pressing."""
    path = stopped(tmp_path)

    def plain(*changes: tuple[str, str]):
        text = STOPPED
        for before, after in changes:
            text = text.replace(before, after)
        path.write_text(text, encoding="utf-8")
        setup = set_up(read_study(path))
        found = creak.robust(setup.study, 4, indices=False, threads=1).draws
        reference = build_reference(setup.structure, setup.band, lambda *_: None)
        return plain_of(partial(at_start, setup, reference), found.drawn)

    key = '"connector.0.upper" = { type = "normal", sigma = 1.5 }'
    assert plain() is not None
    assert plain((key, '"damping.modal" = { type = "uniform", low = 0.01, high = 0.03 }')) is None
    both = '[excitation.root]\nnode_set = "TIP"\ndof = "y"\nkind = "force"\n'
    both += 'signal = { type = "step", amplitude = 0.1 }\n[reduction]'
    assert plain(("[reduction]", both)) is None


def test_only_multiples_of_the_loads_are_foretold(tmp_path):
    """Another course, another number of loads and a load turned round are not the study's own, whatever its size."""
    base = set_up(read_study(stopped(tmp_path))).loads
    assert multiple(replace(base, force=0.7 * base.force), base) == pytest.approx(0.7, rel=1e-15)
    assert multiple(replace(base, force=-base.force), base) is None
    assert (
        multiple(replace(base, force=base.force * (1.0 + 1e-9 * np.linspace(0.0, 1.0, len(base.force))[:, None])), base)
        is None
    )
    assert multiple(replace(base, force_labels=tuple(k + 1 for k in base.force_labels)), base) is None
    assert multiple(replace(base, force=np.hstack([base.force, base.force])), base) is None
    assert multiple(base, replace(base, force=0.0 * base.force)) is None


def test_a_dropped_channel_that_a_larger_load_would_close_is_looked_at():
    """Twice the load closes what the pre-check let stay open: nothing is settled, and it is told."""
    linear = Linear(np.array([-0.2]), np.array([-0.2]), np.array([[1.0], [-0.6]]))
    assert linear.clear_of(np.ones((3, 1)), np.array([1.0, 1.63, 2.0])).tolist() == [True, False, False]  # 1.63: margin
    assert [closes(linear.times(factor).dropped) for factor in (1.0, 1.63, 2.0)] == [False, False, True]


def test_a_load_that_closes_nothing_is_an_answer(tmp_path):
    """No draw has an event, and the figures say so; the closest channel is marched for its slack."""
    text = STUDY.replace("step = 5e-4\nperiods = 2", "end = 0.02") + (
        '[scatter.vary]\n"contact.tip.clearance" = { type = "uniform", low = 0.4, high = 0.6 }\n'
    )
    found = creak.robust(write_strips(tmp_path, None, text), 4, indices=False, threads=1).draws
    assert found.figures.shape[0] == 4
    assert not found.figures.any()
    assert any("0 of 39 channels can close" in note for note in found.notes)
