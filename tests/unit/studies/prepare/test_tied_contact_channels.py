"""Contact between faces that a tie joins: channels that can neither open nor close are left out, and nothing else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from creak.contact.node_to_surface import node_to_surface
from creak.contact.pair import ContactPair, tied_channels
from creak.formats.decks import read_model
from creak.model.mesh import Model
from creak.studies.file.reader import read_study
from creak.studies.prepare.pairs import contact_channels
from creak.studies.warned import Warned
from helpers_ties import sections, sheet

METHODS = ("surface-to-surface", "node-to-surface")
STUDY = """[model]
deck = "lap.inp"
units = "mm-t-s"
[contact.lap]
secondary = "{0}"
main = "{1}"
method = "{2}"
"""


def lap(folder: Path, tie: str) -> Model:
    """A sheet of 2 mm on another one, `tie` between them; TOP is a third sheet 4 mm above the second."""
    (folder / "lap.inp").write_text(
        "*HEADING\nlap\n"
        + sheet("LOWER", 1, (4, 4), (0.0, 0.0, 0.0), (40.0, 40.0))
        + sheet("UPPER", 10_001, (3, 3), (5.0, 5.0, 2.0), (30.0, 30.0))
        + sheet("TOP", 20_001, (4, 4), (0.0, 0.0, 8.0), (40.0, 40.0))
        + sections("LOWER", "UPPER", "TOP", thickness=2.0)
        + "*NSET, NSET=SOME\n10001, 10002, 10003, 10004\n"
        + tie
        + "*BOUNDARY\nLOWER_NODES, 1, 6\nTOP_NODES, 1, 6\n",
        encoding="utf-8",
    )
    return read_model(folder / "lap.inp")


def channels(folder: Path, model: Model, first: str, second: str, method: str):
    (folder / "study.toml").write_text(STUDY.format(first, second, method), encoding="utf-8")
    return contact_channels(model, read_study(folder / "study.toml").touching)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("sides", [("UPPER_FACE", "LOWER_FACE"), ("LOWER_FACE", "UPPER_FACE")])
def test_a_contact_of_tied_faces_has_no_channel(tmp_path, method, sides):
    model = lap(tmp_path, "*TIE, NAME=T\nUPPER_FACE, LOWER_FACE\n")
    without, _ = channels(tmp_path, lap(tmp_path, ""), *sides, method)
    assert without.m >= 9
    gaps, notes = channels(tmp_path, model, *sides, method)
    assert gaps.m == 0
    assert any(f"{without.m} of {without.m} channels are left out: a tie holds both sides" in n for n in notes)


def test_what_is_left_out_cannot_move(tmp_path):
    """G u of the ties' own motion: u_s = sum_k w_k (u_k + theta_k x arm), any u_k and theta_k."""
    model = lap(tmp_path, "*TIE, NAME=T, TIED NSET=SOME\nUPPER_FACE, LOWER_FACE\n")
    pair = ContactPair("lap", "UPPER_FACE", "LOWER_FACE", "node-to-surface")
    operator, _ = node_to_surface(model, pair)
    stuck = tied_channels(model, pair, operator)
    assert (stuck.sum(), operator.m) == (4, 16)
    u = np.random.default_rng(3).normal(size=(model.nodes.count, 6))
    for c in model.constraints:
        arm = np.cross(u[c.nodes_idx, 3:], c.arm)
        u[c.node_idx, :3] = c.weights @ (u[c.nodes_idx, :3] + arm)
    moved = operator.G @ u.ravel()[operator.labels]
    assert np.abs(moved[stuck]).max() < 1e-12
    assert np.abs(moved[~stuck]).min() > 1e-3


@pytest.mark.parametrize("method", METHODS)
def test_tied_nodes_keep_their_contact_with_a_third_part(tmp_path, method):
    model = lap(tmp_path, "*TIE, NAME=T\nUPPER_FACE, LOWER_FACE\n")
    gaps, notes = channels(tmp_path, model, "UPPER_FACE", "TOP_FACE", method)
    assert gaps.m == 16
    assert not any("left out" in note for note in notes)


@pytest.mark.parametrize(("shift", "count", "warns"), [(15.0, 10, False), (25.0, 15, True)])
def test_overhang_is_told_and_warned_of_where_most_nodes_face_nothing(tmp_path, shift, count, warns):
    (tmp_path / "lap.inp").write_text(
        "*HEADING\nlap\n"
        + sheet("LOWER", 1, (4, 4), (0.0, 0.0, 0.0), (40.0, 40.0))
        + sheet("UPPER", 10_001, (4, 4), (shift, 0.0, 3.0), (40.0, 40.0))
        + sections("LOWER", "UPPER", thickness=2.0),
        encoding="utf-8",
    )
    _, notes = channels(tmp_path, read_model(tmp_path / "lap.inp"), "LOWER_FACE", "UPPER_FACE", "node-to-surface")
    (note,) = [n for n in notes if "face no facet" in n]
    assert f"{count} of 25 nodes of 'LOWER_FACE' face no facet of 'UPPER_FACE'" in note
    assert isinstance(note, Warned) is warns
