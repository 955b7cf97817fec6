"""A loaded step before the modes: whether its stress would change them."""

from __future__ import annotations

import pytest

from creak.formats.abaqus.reader import read_deck
from helpers_ties import cut_plate

MODES = "*FREQUENCY\n4\n*END STEP\n"
LOAD = "*STATIC\n*CLOAD\n100001, 1, 5.\n*END STEP\n"


def found(tmp_path, steps):
    path = tmp_path / "deck.inp"
    path.write_text(cut_plate((2, 2), (2, 2), steps), encoding="utf-8")
    return {u.keyword: u for u in read_deck(path).unread if u.keyword != "*STEP"}


@pytest.mark.parametrize(
    ("steps", "changes", "words"),
    [
        ("*STEP, NLGEOM\n" + LOAD + "*STEP\n" + MODES, True, "stiffens the structure"),
        ("*STEP, NLGEO=YES\n" + LOAD + "*STEP\n" + MODES, True, "stiffens the structure"),
        ("*STEP, NLGEOM=YES\n" + LOAD + "*STEP, NLGEOM=NO, PERTURBATION\n" + MODES, True, "stiffens the structure"),
        ("*STEP\n" + LOAD + "*STEP, PERTURBATION\n" + MODES, True, "CalculiX takes the stress"),
        ("*STEP\n" + LOAD + "*STEP, NLGEOM=NO, PERTURBATION\n" + MODES, False, "is linear"),
        ("*STEP, NLGEOM=NO\n" + LOAD + "*STEP, PERTURBATION\n" + MODES, False, "is linear"),
        ("*STEP\n" + LOAD + "*STEP\n" + MODES, False, "is linear"),
        ("*STEP, NLGEOM\n*STATIC\n*BOUNDARY\n1, 1, 6\n*END STEP\n*STEP\n" + MODES, False, "has no load"),
        (
            "*STEP, NLGEOM\n*STATIC\n*BOUNDARY\n1, 1, 1, .2\n*END STEP\n*STEP\n" + MODES,
            True,
            "stiffens the structure",
        ),
    ],
)
def test_what_a_step_before_the_modes_leaves(tmp_path, steps, changes, words):
    note = found(tmp_path, steps)["*STATIC"]
    assert note.changes_answer == changes
    assert words in note.why


@pytest.mark.parametrize(
    ("block", "changes"),
    [
        ("*MODEL CHANGE, REMOVE\nLEFT\n", True),
        ("*MODEL CHANGE, ACTIVATE\n", False),
        ("*CONNECTOR MOTION\nLEFT, 1\n", True),
        ("*RESTART, WRITE\n", None),
    ],
)
def test_elements_that_a_step_takes_out_change_the_modes(tmp_path, block, changes):
    """Up to the step of the modes; in a step after it they do not."""
    keyword, end = block.split(",")[0].strip().split("\n")[0], "*END STEP\n"
    before = found(tmp_path, "*STEP\n*STATIC\n" + block + end + "*STEP\n" + MODES)
    assert (before[keyword].changes_answer if keyword in before else None) == changes
    assert keyword not in found(tmp_path, "*STEP\n" + MODES + "*STEP\n*STATIC\n" + block + end)


def test_the_state_of_a_restart_is_not_read(tmp_path):
    assert found(tmp_path, "*RESTART, READ, STEP=1\n*STEP\n" + MODES)["*RESTART, READ"].changes_answer


@pytest.mark.parametrize("steps", ["*STEP, NLGEOM\n" + LOAD, "*STEP\n" + MODES + "*STEP, NLGEOM\n" + LOAD])
def test_a_step_that_is_not_before_the_modes_is_the_studys(tmp_path, steps):
    assert "*STATIC" not in found(tmp_path, steps)


def test_supports_of_the_step_of_the_modes_hold(tmp_path):
    """Supports add up from step to step until the modes; those of later steps are not theirs."""
    steps = "*STEP\n*STATIC\n*BOUNDARY\n1, 1, 1\n*END STEP\n*STEP\n*BOUNDARY\n2, 2, 3\n" + MODES
    steps += "*STEP\n*STATIC\n*BOUNDARY\n3, 1, 6\n*END STEP\n"
    path = tmp_path / "deck.inp"
    path.write_text(cut_plate((2, 2), (2, 2), steps), encoding="utf-8")
    model = read_deck(path)
    held = {(int(model.nodes.ids[n]), dof) for f in model.fixed for n in f.nodes_idx for dof in f.dofs}
    assert held == {(1, 1), (2, 2), (2, 3)}


@pytest.mark.parametrize(
    ("before", "own", "expected"),
    [
        ("*STEP\n*STATIC\n*BOUNDARY\n3, 1, 6\n*END STEP\n", "*BOUNDARY, OP=NEW\n2, 2, 2\n", {(2, 2)}),
        ("*STEP\n*STATIC\n*BOUNDARY, OP=NEW\n3, 1, 1\n*END STEP\n", "", {(3, 1)}),
        ("*STEP, PERTURBATION\n*STATIC\n*BOUNDARY\n3, 1, 6\n*END STEP\n", "", {(1, 1)}),
        ("*STEP\n*BUCKLE\n4\n*BOUNDARY\n3, 1, 6\n*END STEP\n", "*BOUNDARY\n2, 2, 2\n", {(1, 1), (2, 2)}),
    ],
)
def test_supports_go_on_until_a_step_with_op_new_and_not_from_a_perturbation(tmp_path, before, own, expected):
    """As in Abaqus; the model data hold node 1 along x."""
    path = tmp_path / "deck.inp"
    steps = "*BOUNDARY\n1, 1, 1\n" + before + "*STEP, PERTURBATION\n" + own + MODES
    path.write_text(cut_plate((2, 2), (2, 2), steps), encoding="utf-8")
    model = read_deck(path)
    held = {(int(model.nodes.ids[n]), dof) for f in model.fixed for n in f.nodes_idx for dof in f.dofs}
    assert held == expected


@pytest.mark.parametrize(
    ("steps", "keyword"),
    [
        ("*STEP\n*BOUNDRY\n1, 1, 3\n" + MODES, "*BOUNDRY"),
        ("*STEP\n*BOUNDARY\n1, 1, 3\n" + MODES + "*STEP, NAME=FREE\n" + MODES, "*STEP FREE"),
        ("*STEP\n*BOUNDARY\n1, 1, 3\n" + MODES + "*STEP\n*BOUNDARY\n1, 1, 3\n" + MODES, None),
        (
            "*BOUNDARY\n1, 1, 3\n*STEP\n"
            + MODES
            + "*STEP\n*STEADY STATE DYNAMICS\n1., 9.\n*BOUNDARY\n1, 1, 1\n*END STEP\n",
            None,
        ),
    ],
)
def test_other_supports_of_modes_are_told(tmp_path, steps, keyword):
    """A misspelled *BOUNDARY, and modes of a later step with other supports."""
    assert [u.keyword for u in found(tmp_path, steps).values() if u.changes_answer] == [keyword] * (keyword is not None)


@pytest.mark.parametrize(
    "steps",
    [
        "*STEP\n*FREQUENCY\n4\n*BOUNDARY\n1, 3, 3, .5\n*END STEP\n",
        "*STEP\n*STATIC\n*BOUNDARY\n1, 3, 3, .5\n*END STEP\n*STEP\n" + MODES,
    ],
)
def test_a_prescribed_displacement_fixes_its_dof_in_the_modes(tmp_path, steps):
    """Of the step of the modes and of a linear one before it; a *DYNAMIC step leaves it to the study."""
    path = tmp_path / "deck.inp"
    fixed = []
    for text in (steps, steps.replace(", .5", ""), steps.replace("*FREQUENCY\n4", "*DYNAMIC\n1., 1.")):
        path.write_text(cut_plate((2, 2), (2, 2), text), encoding="utf-8")
        fixed.append([(f.nodes_idx.tolist(), f.dofs) for f in read_deck(path).fixed])
    assert fixed[0] == fixed[1]
    assert len(fixed[2]) == len(fixed[0]) - 1
