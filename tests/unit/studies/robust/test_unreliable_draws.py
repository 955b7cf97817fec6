"""Draws whose march creates energy are marked by the rule of a run, against the work of their own forces."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from benchmarks.odds import DECK, STOPPED_BEAM

import creak
from creak.dynamics.history import ENERGIES
from creak.report.tables.robust import write_draws
from creak.studies.robust import shared_model
from creak.studies.robust.shared_model import CREATED, FORETOLD
from creak.verify import reliability
from helpers_decks import write_study

VARY = '[scatter.vary]\n"connector.0.upper" = { type = "normal", sigma = 1.5 }\n'


def beam(folder: Path) -> Path:
    return write_study(folder, STOPPED_BEAM + VARY, {"beam.inp": DECK})


def created(history) -> float:
    """Largest energy beyond the work of the loads, as a share of the largest of that: what bodies, springs and dampers
    hold and have lost, less what went in and what was there."""
    e = dict(zip(ENERGIES, history.energy.T, strict=True))
    held = sum(e[k] for k in ENERGIES if k not in ("external", "scheme"))
    beyond = held - held[0] - e["external"]
    return float(max(beyond.max(), 0.0) / np.abs(e["external"]).max())


def test_draws_that_create_energy_are_marked_and_told(tmp_path, monkeypatch):
    """The bar lies in the middle of what the draws create: those above it are marked, kept, counted and told."""
    path, shares, look = beam(tmp_path), {}, shared_model.find_events

    def seen(history, gaps, *args):
        shares[round(float(gaps.gap0[0]), 9)] = created(history)
        return look(history, gaps, *args)

    monkeypatch.setattr(shared_model, "find_events", seen)
    creak.robust(path, 16, indices=False, threads=1)
    bar = float(np.median([share for share in shares.values() if share > 0.0]))
    monkeypatch.setattr(reliability, "ENERGY_BAR", bar)
    monkeypatch.setattr(reliability, "CONTACT_BAR", np.inf)
    found = creak.robust(path, 16, out=tmp_path / "out", indices=False, threads=1)
    draws, gaps = found.draws, found.draws.drawn.means()["connector.0.upper"]
    marched = draws.state != FORETOLD
    above = np.array([shares.get(round(float(gap), 9), 0.0) > bar for gap in gaps])
    assert 0 < above.sum() < marched.sum()
    assert np.array_equal(draws.state == CREATED, above)
    every = [share > bar for share in shares.values()]
    runs = 16 + draws.further.rows.size
    assert found.as_dict()["unreliable"] == sum(every)
    assert any(w.startswith(f"{sum(every)} of {runs} runs are unreliable: ") for w in found.as_dict()["warnings"])
    write_draws(found, tmp_path / "draws.csv")
    with open(tmp_path / "draws.csv", encoding="utf-8") as file:
        assert [row["unreliable"] == "1" for row in csv.DictReader(file)] == above.tolist()
    again = creak.robust(path, 16, out=tmp_path / "out", indices=False, threads=1)
    assert again.draws.taken == 16
    assert again.as_dict()["unreliable"] == sum(every)


def test_draws_of_another_edition_are_not_taken(tmp_path, monkeypatch):
    """What they keep means something else."""
    path = beam(tmp_path)
    monkeypatch.setattr("creak.studies.robust.job.edition", lambda: "0.0")
    creak.robust(path, 4, out=tmp_path, indices=False, threads=1)
    monkeypatch.undo()
    assert creak.robust(path, 4, out=tmp_path, indices=False, threads=1).draws.taken == 0


@pytest.mark.parametrize("out", [None, "out"])
def test_sound_draws_need_no_word(tmp_path, out):
    found = creak.robust(beam(tmp_path), 8, out=out and tmp_path / out, indices=False, threads=1)
    assert found.as_dict()["unreliable"] == 0
    assert found.as_dict()["failed"] == 0
    assert not any("unreliable" in note for note in found.notes)
