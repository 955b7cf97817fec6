"""GAPUNI elements of Abaqus decks: stops of a study and of the deck's own step, one millimetre wide."""

from __future__ import annotations

import math

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.decks import format_of, read_model
from creak.progress import silent
from creak.studies.file.reader import read_study
from creak.studies.models.deck_modes import deck_modes
from creak.studies.prepare.deck_step import set_up_deck
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import run_study

MASS = (
    "*NODE\n1, 0., 0., 0.\n2, 0., 0., -20.\n3, 4., 0., -20.\n*NSET, NSET=BALL\n1\n"
    "*ELEMENT, TYPE=MASS, ELSET=M\n1, 1\n*MASS, ELSET=M\n100.,\n*ELEMENT, TYPE=SPRING1, ELSET=K\n2, 1\n"
    "*SPRING, ELSET=K\n3\n1.E4\n*BOUNDARY\nBALL, 1, 2\n2, 1, 3\n3, 1, 3\n"
    "*INITIAL CONDITIONS, TYPE=VELOCITY\nBALL, 3, -1.\n"
)
ELEMENT = "*ELEMENT, TYPE={}, ELSET=BUMP\n3, 2, 1\n"
STEP = "*STEP\n*DYNAMIC, DIRECT, ALPHA=0.\n2.E-5, 0.04\n*NODE OUTPUT, NSET=BALL\nU\n*END STEP\n"
LINEAR = "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n5.E5\n"


def gap_deck(tmp_path, gap="*GAP, ELSET=BUMP\n0.001, 0., 0., 1., 2.\n" + LINEAR, kind="GAPUNI", elements=""):
    path = tmp_path / "gap.inp"
    path.write_text(MASS + (elements or ELEMENT.format(kind)) + gap + STEP)
    return path


def stops(path):
    return {
        s.name: (s.dof, s.lower, s.upper, s.stiffness, s.direction, s.friction)
        for s in format_of(path).read(path).stops
    }


def test_a_deck_runs_with_its_gap(tmp_path):
    """100 kg on 1e4 N/m meets 5e5 N/m^3 times 2 m^2 after 1 mm: y'' = -w^2 (y + s) of the depth y, w^2 = 1.01e6 / 100
    and s = 1e4 gap / 1.01e6, so it presses for 2 atan(v / (s w)) / w. Both springs together turn the momentum m v.
    """
    (event,) = run_study(set_up_deck(gap_deck(tmp_path), units="m-kg-s"), silent).runs["reference"].events
    w, gap = math.sqrt(1.01e6 / 100.0), 0.001
    speed = math.sqrt(1.0 - 100.0 * gap**2)
    lasts = 2.0 * math.atan2(speed, 1e4 * gap / 1.01e6 * w) / w
    # HHT's period error (w h)^2 / 12 is below 4e-7 of it; where the press begins and ends is found between steps
    assert event.t_start == pytest.approx(math.asin(10.0 * gap) / 10.0, rel=1e-5)
    assert event.t_end - event.t_start == pytest.approx(lasts, rel=1e-5)
    assert event.impulse == pytest.approx((2.0 * 100.0 * speed - 1e4 * gap * lasts) / 1.01, rel=1e-5)


def test_a_study_names_the_gap_and_presses_with_it(tmp_path):
    path = gap_deck(tmp_path)
    model = read_model(path)
    (found,) = [u for u in model.unread if u.keyword == "*GAP"]
    assert 'nodes = ["GAP_BUMP.A", "GAP_BUMP.B"], dof = "z", lower = -0.001, stiffness = 1e+06' in found.why
    assert (model.node_sets["GAP_BUMP.A"].tolist(), model.node_sets["GAP_BUMP.B"].tolist()) == ([1], [0])
    assert sorted(block.kind for block in model.blocks) == ["mass", "spring1"], "a gap is no structure"
    assert "BUMP" not in model.element_sets
    study = tmp_path / "study.toml"
    study.write_text(
        '[model]\ndeck = "gap.inp"\nunits = "m-kg-s"\n[damping]\nmodal = 0.0\n[reduction]\nmethod = "none"\n[time]\n'
        'end = 0.04\naccuracy = "fine"\n[[connector]]\ntype = "play"\nname = "GAP_BUMP"\n'
        'nodes = ["GAP_BUMP.A", "GAP_BUMP.B"]\ndof = "z"\nlower = -0.001\nstiffness = "hard"\n'
    )
    (event,) = run_study(set_up(read_study(study)), silent).runs["reference"].events
    # A hard stop gives a mass its momentum twice
    assert event.impulse == pytest.approx(2.0 * 100.0 * math.sqrt(1.0 - 100.0 * 1e-6), rel=1e-3)


@pytest.mark.parametrize(("opening", "stops_it"), [("0.001", False), ("0.", True), ("-0.1", True)])
def test_open_gaps_do_not_act_in_modes(tmp_path, opening, stops_it):
    """sqrt(1e4 / 100) / 2 pi; what is closed as drawn would hold the mass."""
    path = gap_deck(tmp_path, f"*GAP, ELSET=BUMP\n{opening}, 0., 0., 1.\n")
    if stops_it:
        with pytest.raises(InputError, match=r"\*GAP is not read"):
            deck_modes(path, count=1)
    else:
        assert deck_modes(path, count=1).frequencies[0] == pytest.approx(10.0 / (2.0 * math.pi))


def test_values_and_directions_of_a_gap(tmp_path):
    """Without a direction from the first node to the second; hard without a law; friction of the *GAP alone."""
    other = "*SURFACE INTERACTION, NAME=S\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n7.\n*FRICTION\n0.9\n"
    path = gap_deck(tmp_path, "*GAP, ELSET=BUMP\n0.001\n*FRICTION\n0.3\n" + other)
    assert stops(path) == {"GAP_BUMP": (3, -0.001, None, np.inf, None, (0.3, 0.3, 0.0))}
    assert stops(gap_deck(tmp_path, "*GAP, ELSET=BUMP\n-0.5, 0., 0., -2.\n")) == {
        "GAP_BUMP": (3, None, -0.5, np.inf, None, (0.0, 0.0, 0.0))
    }
    two = "*ELEMENT, TYPE=GAPUNI, ELSET=BUMP\n3, 2, 1\n4, 3, 1\n"
    found = stops(gap_deck(tmp_path, "*GAP, ELSET=BUMP\n", elements=two))
    assert found["GAP_BUMP_1"][:3] == (3, 0.0, None)
    assert found["GAP_BUMP_2"][4] == pytest.approx((-4.0 / math.sqrt(416.0), 0.0, 20.0 / math.sqrt(416.0)))


@pytest.mark.parametrize(
    ("gap", "kind", "words"),
    [
        ("*GAP, ELSET=BUMP\n0.5\n", "GAPCYL", "GAPCYL keeps its nodes at a distance in all directions"),
        ("*GAP, ELSET=BUMP\n0.5\n", "GAPSPHER", "GAPSPHER keeps its nodes"),
        (
            "*GAP, ELSET=BUMP\n0.5\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR\n0.,0.\n1.,1.\n",
            "GAPUNI",
            "HARD and LINEAR",
        ),
        (
            "*GAP, ELSET=BUMP\n0.5\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=EXPONENTIAL\n1.,1.\n",
            "GAPUNI",
            "PRESSURE-OVERCLOSURE=EXPONENTIAL",
        ),
    ],
)
def test_gaps_that_are_no_stops_are_named(tmp_path, gap, kind, words):
    """The deck reads; the run stops at them."""
    path = gap_deck(tmp_path, gap, kind)
    model = read_model(path)
    assert not model.stops
    (found,) = [u for u in model.unread if u.changes_answer]
    assert found.keyword == "*GAP"
    assert words in found.why
    with pytest.raises(InputError, match=r"\*GAP is not read"):
        set_up_deck(path)


@pytest.mark.parametrize(
    ("gap", "elements", "words"),
    [
        ("", "", "1 element of type GAPUNI has no section"),
        ("*GAP, ELSET=BUMP\n0.5\n", "*NODE\n4, 0., 0., 0.\n" + ELEMENT.format("GAPUNI").replace("2", "4"), "coincide"),
        ("*GAP, ELSET=M\n0.5\n", "", "holds element 1 of type MASS"),
        ("*GAP, ELSET=BUMP\n0.5, 0., 0., 1., 0.\n", "", "contact area is 0."),
        ("*GAP, ELSET=BUMP\nwide\n", "", "clearance or direction of the gap is 'wide'"),
    ],
)
def test_mistakes_are_named(tmp_path, gap, elements, words):
    with pytest.raises(InputError, match=words):
        read_model(gap_deck(tmp_path, gap, elements=elements))
