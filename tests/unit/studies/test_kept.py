"""What a run leaves beside its superelements is taken where nothing that it depends on has changed, and only there."""

from __future__ import annotations

import shutil
import sys

import numpy as np
import pytest

from creak.contact import surface_to_surface
from creak.dynamics.flow.march import FlowRun
from creak.dynamics.record.recorder import OutputRequest
from creak.errors import InputError
from creak.formats.stored.superelement import read_superelement_file
from creak.later import is_made
from creak.studies.file.changes import with_changes
from creak.studies.file.reader import read_study
from creak.studies.models.reduced import reduce_model
from creak.studies.models.reference import build_reference, in_modes
from creak.studies.models.saved import Store
from creak.studies.models.superelements import save_superelement
from creak.studies.prepare import structure
from creak.studies.prepare.setup import set_up
from creak.studies.run.integrate import linear_gaps
from creak.studies.run.one_run import march_run
from creak.studies.run.precheck import ready, with_linear_gaps
from helpers_decks import STUDY, two_strips, write_strips


def silent(*_):
    """No progress."""


def outcome(study, store):
    """All motion and forces of a run, what it told, and the model that it marched."""
    setup, reference, gaps, notes = ready(set_up(study, store=store), silent, store)
    reduced = reduce_model(setup.reduction, reference, gaps, silent, Store(store))
    history = march_run("reduced", setup.marching, setup.observed(gaps), reduced, gaps, silent).history
    assert history.force.any()
    arrays = [history.time, history.gap, history.force, history.displacement, history.energy, reference.modes.omega2]
    return [np.ascontiguousarray(a).tobytes() for a in arrays], [*setup.notes, *notes, *reduced.notes], reduced


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A study with an include, its superelements, and what a first run has left there."""
    here = tmp_path_factory.mktemp("kept")
    deck = two_strips()
    cut = deck.index("*SURFACE, NAME=UNDER")
    (here / "surfaces.inc").write_text(deck[cut:], encoding="utf-8")
    text = f"{STUDY}\n[reference]\nrun = false\n[precheck]\nmargin = 0.5\n"
    text = text.replace("step = 5e-4\nperiods = 2", 'end = 0.06\naccuracy = "quick"')
    study = read_study(write_strips(here, f"{deck[:cut]}*INCLUDE, INPUT=surfaces.inc\n", text))
    store = here / "superelements"
    store.mkdir()
    setup = set_up(study)
    for reduced in outcome(study, None)[2].superelements:
        save_superelement(store, reduced, setup.model, {})
    outcome(study, store)
    outcome(with_changes(study, {"damping.modal": 0.02}), store)
    return here


@pytest.fixture
def here(folder, tmp_path):
    """A copy that a test may change."""
    return shutil.copytree(folder, tmp_path / "study")


def of_nothing(here):
    """The same store without what runs have left there."""
    bare = here / "bare"
    shutil.copytree(here / "superelements", bare, ignore=shutil.ignore_patterns("solved"), dirs_exist_ok=True)
    shutil.rmtree(bare / "solved", ignore_errors=True)
    return bare


CHANGES: tuple[dict[str, float], ...] = (
    {},
    {"contact.tip.clearance": 0.45},
    {"contact.tip.stiffness": 50.0},
    {"damping.modal": 0.03},
    {"excitation.root.signal.amplitude": 0.06},
)


def test_a_second_run_steps_before_it_assembles(here, monkeypatch):
    study, store = read_study(here / "study.toml"), here / "superelements"
    monkeypatch.setattr(structure, "part_system", lambda *a, **k: pytest.fail("assembled"))
    monkeypatch.setattr(surface_to_surface, "_searched", lambda *a: pytest.fail("searched"))
    for change in CHANGES:
        setup, reference, gaps, _ = ready(set_up(with_changes(study, change), store=store), silent, store)
        reduced = reduce_model(setup.reduction, reference, gaps, silent, Store(store))
        run = FlowRun(reduced.system, gaps, setup.loads, OutputRequest(setup.watch.nodes), setup.marching.resolution)
        assert run.model.rows.shape[0] == gaps.m > 0
        assert not any(is_made(part) for part in reference.parts), change
        assert not is_made(reference.system)
        assert not any(is_made(r.basis.fixed) for r in reduced.superelements)


@pytest.mark.parametrize("change", [{}, {"damping.modal": 0.03}])
def test_the_pre_check_is_that_of_the_whole_with_its_damping(here, change):
    setup = set_up(with_changes(read_study(here / "study.toml"), change))
    whole = build_reference(setup.structure, setup.band, silent)
    system = in_modes(whole, setup.reduction)
    direct = linear_gaps(setup.marching, setup.contacts, system).lowest
    np.testing.assert_allclose(
        with_linear_gaps(setup.study.config.precheck, setup.reduction, setup.marching, whole, silent).linear_gaps,
        direct,
        rtol=1e-9,
    )


@pytest.mark.parametrize("change", CHANGES[1::2])
def test_a_second_run_answers_to_the_last_bit(here, change):
    changed = with_changes(read_study(here / "study.toml"), change)
    kept, told, reduced = outcome(changed, here / "superelements")
    made, also_told, _ = outcome(changed, of_nothing(here))
    assert all(r.reused for r in reduced.superelements)
    assert kept == made
    assert told == also_told


EDITS = {
    "place": ("strips.inp", "120.000000, 0.000000, 0.000000", "120.500000, 0.000000, 0.000000"),
    "include": ("surfaces.inc", "ROOT_LOWER, 1, 6", "ROOT_LOWER, 1, 5"),
}


@pytest.mark.parametrize("what", EDITS)
def test_an_edited_deck_is_answered_as_if_nothing_were_there(here, what):
    name, before, after = EDITS[what]
    text = (here / name).read_text(encoding="utf-8")
    assert before in text
    (here / name).write_text(text.replace(before, after), encoding="utf-8")
    study = read_study(here / "study.toml")
    kept, told, _ = outcome(study, here / "superelements")
    made, also_told, _ = outcome(study, of_nothing(here))
    assert kept == made
    assert told == also_told


@pytest.mark.skipif(sys.platform == "win32", reason="there a file that is open cannot be replaced")
def test_modes_are_those_of_the_run_though_the_superelement_is_replaced_meanwhile(here):
    study, store = read_study(here / "study.toml"), here / "superelements"
    _, _, reduced = outcome(study, store)
    assert not any(is_made(r.basis.fixed) for r in reduced.superelements)
    before = [read_superelement_file(path).modes for path in sorted(store.glob("*.h5"))]
    first, second = sorted(store.glob("*.h5"))
    first.unlink()
    other = here / "other"
    other.write_bytes(b"of another run")
    other.replace(second)
    found = {r.system.name: r.basis.fixed.shapes for r in reduced.superelements}
    assert found.keys() == {"UPPER", "LOWER"}
    for name, modes in zip(sorted(found), before, strict=True):
        np.testing.assert_array_equal(found[name], modes[:, : found[name].shape[1]])


def test_a_superelement_that_was_touched_is_looked_at_again(here):
    study, store = read_study(here / "study.toml"), here / "superelements"
    path = min(store.glob("*.h5"))
    whole = path.read_bytes()
    path.write_bytes(whole[:-9] + bytes([whole[-9] ^ 1]) + whole[-8:])
    with pytest.raises(InputError, match="damaged"):
        outcome(study, store)
    path.write_bytes(whole)
    kept, told, _ = outcome(study, store)
    (boundary,) = (store / "solved").glob(f"boundary_{path.stem}.*")
    found = boundary.read_bytes()
    boundary.write_bytes(found[:-9] + bytes([found[-9] ^ 1]) + found[-8:])
    assert outcome(study, store)[:2] == (kept, told)
    assert outcome(study, of_nothing(here))[:2] == (kept, told)
