"""A deck's own *MODAL DYNAMIC step against closed form: one mass, 1 kg on 400 N/m, w = 20 rad/s, zeta = .05."""

from __future__ import annotations

import math

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.abaqus.reader import read_deck_run
from creak.progress import silent
from creak.studies.prepare.deck_step import set_up_deck
from creak.studies.run.job import run_study

W, ZETA = 20.0, 0.05
WD = W * math.sqrt(1.0 - ZETA**2)
MODEL = (
    "*NODE\n1, 0., 0., 0.\n2, 0., 0., -1.\n*NSET, NSET=TOP\n1\n*ELEMENT, TYPE=MASS, ELSET=M\n1, 1\n"
    "*MASS, ELSET=M\n1.,\n*ELEMENT, TYPE=SPRING2, ELSET=K\n2, 2, 1\n*SPRING, ELSET=K\n3, 3\n400.\n*BOUNDARY\nTOP, 1, 2\n"
    "*AMPLITUDE, NAME=SINE, DEFINITION=PERIODIC\n1, 12., 0., 0.\n0., 1.\n"
)
MODES = "*STEP, NAME=MODES, PERTURBATION\n*FREQUENCY\n1\n*BOUNDARY\n2, 1, 3\n*END STEP\n"
SHARE = "*MODAL DAMPING\n1, 1, 0.05\n"


def step(lines, damping=SHARE, head="*MODAL DYNAMIC"):
    return (
        f"*STEP, NAME=SHAKE, PERTURBATION\n{head}\n0.01, 1.\n*SELECT EIGENMODES, GENERATE\n1, 1, 1\n{damping}{lines}"
        "*NODE OUTPUT, NSET=TOP\nU\n*END STEP\n"
    )


@pytest.fixture
def deck(tmp_path):
    def write(steps, model=MODEL):
        path = tmp_path / "modal.inp"
        path.write_text(model + steps)
        return path

    return write


@pytest.fixture
def motion(deck):
    """Time, displacement of the mass along z, and the run's notes."""

    def go(steps, model=MODEL):
        setup = set_up_deck(deck(steps, model), units="m-kg-s")
        history = run_study(setup, silent).runs["reduced"].history
        return history.time, history.displacement[:, 2], " ".join(map(str, setup.notes))

    return go


def under_sine(t, force, w=12.0):
    """u'' + 2 zeta W u' + W^2 u = force sin(w t) from rest."""
    a, b = W * W - w * w, 2.0 * ZETA * W * w
    s, c = force * a / (a * a + b * b), -force * b / (a * a + b * b)
    free = np.exp(-ZETA * W * t) * (-c * np.cos(WD * t) - (w * s + ZETA * W * c) / WD * np.sin(WD * t))
    return s * np.sin(w * t) + c * np.cos(w * t) + free


def test_a_step_load_with_modal_damping(motion):
    """u = F/k (1 - exp(-zeta w t) (cos w_d t + zeta w / w_d sin w_d t)); the supports are those of *FREQUENCY."""
    t, u, said = motion(MODES + step("*CLOAD\nTOP, 3, 4.\n"))
    exact = 0.01 * (1.0 - np.exp(-ZETA * W * t) * (np.cos(WD * t) + ZETA * W / WD * np.sin(WD * t)))
    # Motion between contacts is exact; what is left is round-off of the modes
    np.testing.assert_allclose(u, exact, atol=1e-9 * 0.02)
    assert "in as many modes as the answer takes" in said


def test_a_sine_load_with_its_amplitude(motion):
    t, u, _ = motion(MODES + step("*CLOAD, AMPLITUDE=SINE\nTOP, 3, 4.\n"))
    # A sine is followed within a hundred-millionth of itself
    np.testing.assert_allclose(u, under_sine(t, 4.0), atol=1e-7 * np.abs(u).max())


def test_the_base_moves(motion):
    """z'' = 4 sin 12 t of the base: the mass moves against it as under the force -m z'', here told in space."""
    t, u, said = motion(MODES + step("*BASE MOTION, DOF=3, AMPLITUDE=SINE, SCALE=4.\n"))
    base = 4.0 * (t / 12.0 - np.sin(12.0 * t) / 144.0)
    np.testing.assert_allclose(u, base + under_sine(t, -4.0), atol=1e-7 * np.abs(base).max())
    assert "in space (TU of Abaqus)" in said


@pytest.mark.parametrize("kind", ["", ", TYPE=ACCELERATION"])
def test_a_base_motion_without_type_is_told_to_be_an_acceleration(deck, kind):
    """In CalculiX it is a displacement."""
    model, _ = read_deck_run(deck(MODES + step(f"*BASE MOTION, DOF=3, AMPLITUDE=SINE{kind}\n")))
    told = [u.why for u in model.unread if u.keyword == "*BASE MOTION"]
    assert ("acceleration, as in Abaqus" in " ".join(told)) == (not kind)


@pytest.mark.parametrize(
    "damping",
    [
        "*MODAL DAMPING, RAYLEIGH\n1, 1, 2., 0.\n",
        "*MODAL DAMPING, VISCOUS=RAYLEIGH\n1, 1, 1., 0.0025\n",
        "*MODAL DAMPING, VISCOUS=FRACTION OF CRITICAL DAMPING\n1,, 0.05\n",
        "*MODAL DAMPING, DEFINITION=FREQUENCY RANGE\n0., 0.05\n100., 0.05\n",
        "*MODAL DAMPING, DEFINITION=FREQUENCY RANGE\n0., 0.\n6.366197723675814, 0.1\n",
        "*MODAL DAMPING, DEFINITION=FREQUENCY RANGE\n100., 0.05\n200., 0.5\n",
    ],
)
def test_other_words_for_the_same_damping(motion, damping):
    """2 zeta w = alpha + beta w^2 = 2 1/s; over the frequency .05 half-way to .1 at 20 Hz / pi, and before .05."""
    t, u, _ = motion(MODES + step("*CLOAD, AMPLITUDE=SINE\nTOP, 3, 4.\n", damping))
    np.testing.assert_allclose(u, under_sine(t, 4.0), atol=1e-7 * np.abs(u).max())


def test_damping_that_differs_from_mode_to_mode(motion):
    """Another mass on 100 N/m makes the first mode: it has .3 of critical, that of the mass looked at .05."""
    other = MODEL.replace("*BOUNDARY\nTOP, 1, 2\n", "") + (
        "*NODE\n3, 5., 0., 0.\n4, 5., 0., -1.\n*ELEMENT, TYPE=MASS, ELSET=M\n3, 3\n*ELEMENT, TYPE=SPRING2, ELSET=L\n4, 4, 3\n"
        "*SPRING, ELSET=L\n3, 3\n100.\n*BOUNDARY\nTOP, 1, 2\n3, 1, 2\n4, 1, 3\n"
    )
    load = "*CLOAD, AMPLITUDE=SINE\nTOP, 3, 4.\n3, 3, 4.\n"
    t, u, _ = motion(MODES + step(load, "*MODAL DAMPING\n1, 1, 0.3\n2, 2, 0.05\n"), other)
    np.testing.assert_allclose(u, under_sine(t, 4.0), atol=1e-7 * np.abs(u).max())


def test_gaps_of_the_deck_act_in_it(deck):
    """4 N sin 12 t moves the mass by up to 17 mm: a gap 5 mm wide closes."""
    gap = "*NODE\n5, 0., 0., 1.\n*BOUNDARY\n5, 1, 3\n*ELEMENT, TYPE=GAPUNI, ELSET=G\n9, 1, 5\n*GAP, ELSET=G\n0.005\n"
    path = deck(MODES + step("*CLOAD, AMPLITUDE=SINE\nTOP, 3, 4.\n"), MODEL + gap)
    events = run_study(set_up_deck(path, units="m-kg-s"), silent).runs["reduced"].events
    assert events
    assert {e.channel for e in events} == {"GAP_G:lower"}


def changing(path):
    """What the run stops at, one after the other."""
    found = []
    while True:
        try:
            set_up_deck(path, found, units="m-kg-s")
        except InputError as error:
            found.append(error.what.split(" is not read")[0])
        else:
            return found


@pytest.mark.parametrize(
    ("steps", "named"),
    [
        (MODES + step("*CLOAD\nTOP, 3, 4.\n", head="*MODAL DYNAMIC, CONTINUE=YES"), ["*MODAL DYNAMIC, CONTINUE"]),
        (MODES + step("*CLOAD\nTOP, 3, 4.\n", "*MODAL DAMPING, VISCOUS=COMPOSITE\n"), ["*MODAL DAMPING"]),
        (MODES + step("*CLOAD\nTOP, 3, 4.\n", "*MODAL DAMPING, STRUCTURAL\n1, 1, 0.1\n"), ["*MODAL DAMPING"]),
        (MODES + step("*BASE MOTION, DOF=4, AMPLITUDE=SINE\n"), ["*BASE MOTION"]),
        (MODES + step("*BASE MOTION, DOF=3, AMPLITUDE=SINE, BASE NAME=B\n"), ["*BASE MOTION"]),
        (MODES + step("*CLOAD\nTOP, 3, 4.\n").replace("1, 1, 1\n", "2, 3, 1\n"), ["*SELECT EIGENMODES"]),
        (MODES + step("*DLOAD\nM, GRAV, 9.81, 0., 0., -1.\n"), ["*DLOAD"]),
        (MODES + step("*CLOAD\nTOP, 3, 4.\n", ""), []),
        (MODES + step("*CLOAD\nTOP, 3, 4.\n", head="*MODAL DYNAMIC, DIRECT=NO, DELTMX=0.01"), []),
        (MODES + step("*CLOAD\nTOP, 3, 4.\n", head="*MODAL DYNAMIC, STEADY STATE"), ["*MODAL DYNAMIC, STEADY STATE"]),
    ],
)
def test_what_is_not_followed_is_named(deck, steps, named):
    assert changing(deck(steps)) == named


@pytest.mark.parametrize(
    ("steps", "words"),
    [
        (MODES + step("*CLOAD\nTOP, 3, 4.\n", "*MODAL DAMPING\n1, 1, 5.\n"), "5 of critical damping.*2 % .* is 0.02"),
        (MODES + step("*BASE MOTION, DOF=3\n"), "has no AMPLITUDE="),
        (MODES + step("*BASE MOTION, DOF=3, AMPLITUDE=SINE, TYPE=JERK\n"), "TYPE=JERK"),
        (MODES.replace("2, 1, 3", "2, 1, 2") + step("*BASE MOTION, DOF=3, AMPLITUDE=SINE\n"), "holds no node"),
        (MODES + step("").replace("0.01, 1.\n", ""), r"\*MODAL DYNAMIC without a data line"),
        ("*STEP\n*VISCO\n*END STEP\n" + MODES + step(""), "a \\*VISCO step comes before"),
    ],
)
def test_mistakes_are_named(deck, steps, words):
    with pytest.raises(InputError, match=words):
        set_up_deck(deck(steps))


def test_plastic_materials_do_not_stop_a_step_in_modes(deck):
    steel = "*MATERIAL, NAME=STEEL\n*ELASTIC\n2.1E11, 0.3\n*PLASTIC\n2.5E8, 0.\n"
    path = deck(MODES + step("*CLOAD\nTOP, 3, 4.\n"), MODEL + steel)
    assert changing(path) == []
    assert [u.why for u in set_up_deck(path).model.unread if u.keyword == "*PLASTIC"] == ["a step in modes is elastic"]


def test_a_dynamic_step_comes_first(deck):
    """Where the deck has both, the run is that of *DYNAMIC, which changes the state."""
    dynamic = "*STEP, NAME=LATER\n*DYNAMIC\n0.01, 1.\n*BOUNDARY\n2, 1, 3\n*END STEP\n"
    assert set_up_deck(deck(MODES + step("") + dynamic), units="m-kg-s").study.config.time.integrator == "hht"
