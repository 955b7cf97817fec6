"""Sliding beyond the facet and rotations beyond small ones are told whatever motion is written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.studies.prepare.watched import TURN, _turns, turn_warnings
from creak.studies.run.job import StudyResult, run_study
from creak.studies.warned import warnings_of
from helpers_contact import stacked
from helpers_decks import STEEL, strip, write_strips

DECK = (
    "*HEADING\nan upper strip that is pushed aside\n"
    + strip(1, 1, "UPPER", 1.5, n=6)
    + strip(1001, 1001, "LOWER", 0.0, n=6)
    + STEEL
    + "*SHELL SECTION, ELSET=UPPER, MATERIAL=STEEL\n1.0,\n*SHELL SECTION, ELSET=LOWER, MATERIAL=STEEL\n1.0,\n"
    + "*SURFACE, NAME=UNDER\nUPPER, SNEG\n*SURFACE, NAME=OVER\nLOWER, SPOS\n"
    + "*BOUNDARY\nROOT_LOWER, 1, 6\nROOT_UPPER, 2, 2\nROOT_UPPER, 4, 6\n"
)
STUDY = """
[model]
deck = "strips.inp"

[contact.tip]
secondary = "UNDER"
main = "OVER"

[excitation.down]
node_set = "ROOT_UPPER"
dof = "z"
kind = "displacement"
signal = { type = "table", values = [[0, 0], [0.004, -0.52], [0.006, -0.52], [0.010, 0], [0.06, 0]] }

[excitation.aside]
node_set = "ROOT_UPPER"
dof = "x"
kind = "displacement"
signal = { type = "table", values = [[0, 0], [0.005, 12], [0.010, 0], [0.06, 0]] }

[reduction]
f_max = 1500

[time]
end = 0.06

[reference]
run = false

[output]
interval = 0.03
"""
"""Down and 12 mm aside within 10 ms, then at rest: at 0, 30 and 60 ms, where motion is written, there is no slip."""


def run(folder: Path, study: str) -> StudyResult:
    return run_study(set_up(read_study(write_strips(folder, DECK, study))), lambda *_: None)


@pytest.mark.parametrize("forced", ["", '\nintegrator = "hht"\nstep = 5e-4'])
def test_slip_between_two_outputs_is_told_with_place_size_and_time(tmp_path, forced):
    result = run(tmp_path, STUDY.replace("end = 0.06", "end = 0.06" + forced))
    history = result.runs["reduced"].history
    assert history.slip.shape[0] == 3
    assert history.force.max() > 0.0
    (told,) = [w for w in warnings_of(result.notes) if "slip by more than half an element" in w]
    assert "reduced run: [contact.tip]" in told
    worst = int(history.extremes.slip.argmax())
    assert f"{result.gaps.names[worst]} slips farthest, by {history.extremes.slip[worst]:.3g} mm at t = 0.00" in told
    assert 5.0 < history.extremes.slip[worst] <= 12.5


def test_rotation_between_two_outputs_is_told(tmp_path):
    """The upper strip's root is turned by .3 rad within 10 ms."""
    study = STUDY.replace('dof = "x"', 'dof = "ry"').replace("[0.005, 12]", "[0.005, -0.3]")
    deck = DECK.replace("ROOT_UPPER, 4, 6", "ROOT_UPPER, 4, 4\nROOT_UPPER, 6, 6").replace(
        "ROOT_UPPER, 2, 2", "ROOT_UPPER, 1, 2"
    )
    result = run_study(set_up(read_study(write_strips(tmp_path, deck, study))), lambda *_: None)
    (told,) = [w for w in warnings_of(result.notes) if "degrees" in w]
    assert "creak takes rotations as small" in told
    seen = result.runs["reduced"].history.extremes
    k = seen.turn_names.index("part UPPER")
    assert seen.turn[k] > 0.17
    assert 0.0 < seen.turn_at[k] < 0.03


def test_a_rotation_is_told_from_its_bar_on():
    at = np.array([0.1, 0.2])
    assert turn_warnings(("part A", "node 3"), np.array([0.99 * TURN, 0.0]), at) == []
    (told,) = turn_warnings(("part A", "node 3"), np.array([1.1 * TURN, 0.5]), at)
    assert told.startswith(
        "node 3 and 1 more parts or nodes turn by more than 10 degrees, farthest by 28.6 at t = 0.2 s"
    )


def test_a_rigid_rotation_is_found_at_parts_and_nodes():
    model, turn = stacked(), np.array([0.02, -0.03, 0.05])
    turns, labels, names = _turns(model, np.array([3]))
    u = np.zeros((model.nodes.count, 6))
    u[:, :3], u[:, 3:] = np.cross(turn, model.nodes.coords) + [1.0, -2.0, 3.0], turn
    assert names == ("part LOW", "part TOP", "node 4")
    np.testing.assert_allclose((turns @ u.ravel()[labels]).reshape(-1, 3), [turn] * 3, atol=1e-12)


def test_a_motion_that_begins_with_a_jump_is_told(tmp_path):
    begins = STUDY.replace("[[0, 0], [0.005, 12]", "[[0, 6], [0.005, 12]")
    for text, count in ((STUDY, 0), (begins, 1)):
        (tmp_path / "study.toml").write_text(text, encoding="utf-8")
        (tmp_path / "strips.inp").write_text(DECK, encoding="utf-8")
        notes = warnings_of(set_up(read_study(tmp_path / "study.toml")).notes)
        assert [n.startswith("aside is 6 at the start") for n in notes if "jumps" in n] == [True] * count
