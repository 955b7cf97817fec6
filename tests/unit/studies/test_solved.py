"""Modes that were found once are found again where nothing that they hang on has changed, and only there."""

from __future__ import annotations

import copy
import shutil
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest

from creak.digest import digest
from creak.studies import solved
from creak.studies.file.changes import with_changes
from creak.studies.file.reader import read_study
from creak.studies.models import health, reference
from creak.studies.models.reduced import reduce_model
from creak.studies.models.reference import build_reference
from creak.studies.prepare.setup import set_up
from creak.studies.run import precheck
from creak.studies.run.precheck import ready
from helpers_decks import STUDY, write_strips


def silent(*_):
    """No progress."""


class Maker:
    """Counts how often it was asked."""

    def __init__(self) -> None:
        self.times = 0

    def __call__(self):
        self.times += 1
        return {"a": np.asfortranarray(np.arange(6.0).reshape(2, 3)), "told": np.array([np.nan, np.inf])}


@pytest.fixture
def store(tmp_path):
    folder = tmp_path / "superelements"
    folder.mkdir()
    return folder


def test_taken_where_all_is_the_same_and_made_where_anything_is_other(store, monkeypatch):
    make = Maker()
    first = solved.solved(store, "assembly", ["K", "M"], make)
    again = solved.solved(store, "assembly", ["K", "M"], make)
    assert make.times == 1
    for name, array in first.items():
        np.testing.assert_array_equal(again[name], array)
        assert again[name].strides == array.strides  # products sum in the same order: a second run is the first
    solved.solved(store, "coupled", ["K", "M"], make)
    solved.solved(store, "assembly", ["K2", "M"], make)
    solved.solved(store, "assembly", ["K", "M2"], make)
    assert make.times == 4
    monkeypatch.setattr(solved, "edition", lambda: "0.0")
    solved.solved(store, "assembly", ["K", "M"], make)
    assert make.times == 5


def test_a_file_that_is_damaged_or_of_something_else_is_made_anew(store):
    make = Maker()
    solved.solved(store, "assembly", ["K"], make)
    (path,) = (store / "solved").iterdir()
    whole = path.read_bytes()
    path.write_bytes(whole[:-20] + bytes([whole[-20] ^ 1]) + whole[-19:])
    solved.solved(store, "assembly", ["K"], make)
    assert make.times == 2
    assert path.read_bytes()[:512] == whole[:512]  # and is whole again
    solved.solved(store, "assembly", ["other"], make)
    (other,) = set((store / "solved").iterdir()) - {path}
    shutil.copy(path, other)
    solved.solved(store, "assembly", ["other"], make)
    assert make.times == 4


def test_nothing_is_kept_without_a_folder_and_not_more_than_a_few(store, tmp_path, monkeypatch):
    make = Maker()
    for where in (None, tmp_path / "none"):
        solved.solved(where, "assembly", ["K"], make)
    assert not (tmp_path / "none").exists()
    for k in range(solved.KEPT + 2):
        solved.solved(store, "assembly", [str(k)], make)
    assert len(list((store / "solved").iterdir())) == solved.KEPT
    monkeypatch.setattr(solved, "LARGEST", 8)
    solved.solved(store, "large", ["K"], make)
    assert not list((store / "solved").glob("large.*"))


def _built(study, store):
    setup = set_up(study)
    return build_reference(setup.structure, setup.band, silent, store)


def test_a_second_run_finds_the_modes_of_the_assembly(tmp_path, store, monkeypatch):
    """Neither modes nor factor are made again for another gap; another band or mass makes them."""
    study = read_study(write_strips(tmp_path, study=STUDY))
    first = _built(study, store)
    made = []
    real = reference.modes
    monkeypatch.setattr(reference, "modes", lambda *a, **k: made.append(1) or real(*a, **k))
    second = _built(with_changes(study, {"contact.tip.clearance": 0.4}), store)
    assert not made
    assert second.modes.frequencies == pytest.approx(first.modes.frequencies, rel=1e-14)
    np.testing.assert_array_equal(second.modes.shapes, first.modes.shapes)
    np.testing.assert_array_equal(second.support_shapes, first.support_shapes)
    assert second.modes.next_omega2 == first.modes.next_omega2
    b = np.linspace(1.0, 2.0, second.system.n)
    np.testing.assert_allclose(second.stiffness.solve(b), first.stiffness.solve(b), rtol=1e-9)
    changes = {"damping.modal": 0.02}, {"verification.mac_f_max": 3000.0}
    for change in changes:
        _built(with_changes(study, change), store)
    assert len(made) == len(changes)
    deck = tmp_path / study.config.model.deck
    deck.write_text(deck.read_text(encoding="utf-8").replace("7.85e-9", "7.86e-9"), encoding="utf-8")
    _built(study, store)
    assert len(made) == len(changes) + 1


def test_the_linear_run_is_that_of_another_gap_and_of_nothing_else(tmp_path, store, monkeypatch):
    study = read_study(write_strips(tmp_path, study=STUDY.replace("periods = 2", "end = 0.1")))
    made, real = [], precheck.linear_gaps
    monkeypatch.setattr(precheck, "linear_gaps", lambda *a: made.append(1) or real(*a))

    def gaps(changes, folder=store):
        setup = set_up(with_changes(study, changes))
        built = build_reference(setup.structure, setup.band, silent, folder)
        return precheck.with_linear_gaps(
            setup.study.config.precheck, setup.reduction, setup.marching, built, silent
        ).linear_gaps

    gaps({})
    wider = gaps({"contact.tip.clearance": 0.4})
    assert len(made) == 1
    np.testing.assert_allclose(wider, gaps({"contact.tip.clearance": 0.4}, None), rtol=1e-12)
    others = [
        {"excitation.root.signal.seed": 4},
        {"damping.modal": 0.03},
        {"time.alpha": -0.1},
        {"contact.tip.method": "node-to-surface"},
    ]
    for change in others:
        made.clear()
        gaps(change)
        assert len(made) == 1, change


def test_what_was_checked_is_told_again_of_the_same_superelement_only(tmp_path, store, monkeypatch):
    study = read_study(write_strips(tmp_path, study=STUDY.replace("periods = 2", "end = 0.1")))
    made, real = [], health.check
    monkeypatch.setattr(health, "check", lambda *a, **k: made.append(1) or real(*a, **k))

    def found(changes, folder=store):
        setup, built, gaps, _ = ready(set_up(with_changes(study, changes)), silent)
        reduced = reduce_model(setup.reduction, built, gaps, silent)
        return health.checked(reduced.superelements, setup.model.nodes, setup.band, silent, folder)

    first = found({})
    parts = len(first)
    assert len(made) == parts > 1
    assert found({"contact.tip.stiffness": 3.0}) == first  # to the last digit, and of the same types
    assert len(made) == parts
    assert found({}, None) == first
    for change in ({"reduction.f_max": 9000.0}, {"excitation.root.signal.f_max": 50.0}):
        made.clear()
        found(change)
        assert len(made) == parts, change
    deck = tmp_path / study.config.model.deck
    deck.write_text(deck.read_text(encoding="utf-8").replace("7.85e-9", "7.86e-9"), encoding="utf-8")
    made.clear()
    assert found({}) != first
    assert len(made) == parts


def others(value):
    """Values that differ in one thing from `value`."""
    if isinstance(value, np.ndarray):
        if value.size:
            one = value.copy()
            one.flat[0] = not one.flat[0] if one.dtype == bool else one.flat[0] + 1
            yield one
        yield value[..., None]
        yield value.astype(np.float32)
    elif is_dataclass(value):
        for f in fields(value):
            if f.name != "where":
                yield from (replace(value, **{f.name: x}) for x in others(getattr(value, f.name)))
    elif isinstance(value, dict):
        yield {**value, "ANOTHER": 1.0}
        for key, one in value.items():
            yield from ({**value, key: x} for x in others(one))
    elif isinstance(value, tuple):
        yield (*value, 1.0)
        for k, one in enumerate(value):
            yield from ((*value[:k], x, *value[k + 1 :]) for x in others(one))
    else:
        yield 1.25 if value is None or isinstance(value, str | bool) else value + 1


def test_a_digest_tells_whatever_is_other_in_a_model(tmp_path):
    model = set_up(read_study(write_strips(tmp_path, study=STUDY))).model
    own, found = digest(model), set()
    assert own == digest(copy.deepcopy(model))
    changed = list(others(model))
    assert len(changed) > 100
    found = {digest(x) for x in changed}
    assert own not in found
    assert len(found) > 0.9 * len(changed)
    moved = replace(model, blocks=tuple(replace(b, where="elsewhere:7") for b in model.blocks))
    assert digest(moved) == own
    with pytest.raises(TypeError, match="no digest of a function"):
        digest([others])
