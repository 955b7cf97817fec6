"""*INITIAL_VELOCITY of LS-DYNA decks: rigid motion, momentum and energy by closed forms; what is not read is named."""

from __future__ import annotations

import math

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.lsdyna.reader import read_lsdyna
from creak.progress import silent
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import run_study
from helpers_core import assembled
from helpers_decks import write_study

RHO, T = 7.8e-9, 2.0
PLATE = (
    "*KEYWORD\n*NODE\n1,0.,0.,0.\n2,30.,0.,0.\n3,60.,0.,0.\n4,0.,20.,0.\n5,30.,20.,0.\n6,60.,20.,0.\n"
    "*ELEMENT_SHELL\n1,1,1,2,5,4\n2,2,2,3,6,5\n*PART\none\n1,1,1\n*PART\ntwo\n2,1,1\n"
    f"*SECTION_SHELL\n1,16\n{T}\n*MAT_ELASTIC\n1,{RHO},2.1e5,.3\n"
    "*SET_NODE_LIST\n4\n3,6\n*SET_PART_LIST\n5\n1,2\n"
    "*DEFINE_COORDINATE_VECTOR\n9,0.,1.,0.,-1.,0.,0.\n"
)
"""60 x 20 x 2 in two parts; axis x of system 9 is y, its y is -x."""


def read(folder, text):
    path = folder / "deck.k"
    path.write_text(f"{PLATE}{text}*END\n", encoding="utf-8")
    return read_lsdyna(path)


def speeds(model):
    """(n_node, 6)"""
    out = np.zeros((model.nodes.count, 6))
    for row, dof, value in model.initial_velocity:
        out[row, dof - 1] = value
    return out


@pytest.mark.parametrize("who", ["0,0", "5,1"], ids=["everything", "a part set"])
def test_a_body_thrown_and_turned_has_the_energy_of_a_rigid_one(tmp_path, who):
    """T = m V^2 / 2 + omega' J omega / 2, V of the centre at (30, 10, 0), axis through (5, 1, 2) along (1, 2, 2)."""
    model = read(tmp_path, f"*INITIAL_VELOCITY_GENERATION\n{who},6.,40.,0.,-7.\n5.,1.,2.,1.,2.,2.\n")
    system = assembled(model)
    m, omega = RHO * 60.0 * 20.0 * T, 6.0 * np.array([1.0, 2.0, 2.0]) / 3.0
    V = np.array([40.0, 0.0, -7.0]) + np.cross(omega, [25.0, 9.0, -2.0])
    J = m / 12.0 * np.diag([20.0**2 + T**2, 60.0**2 + T**2, 60.0**2 + 20.0**2])
    energy = 0.5 * system.velocity @ (system.M @ system.velocity)
    assert energy == pytest.approx(0.5 * m * V @ V + 0.5 * omega @ J @ omega, rel=1e-4)
    moving = system.rows(6 * np.arange(6) + 2)[0] @ system.velocity
    assert moving == pytest.approx(
        -7.0 + omega[0] * (model.nodes.coords[:, 1] - 1.0) - omega[1] * (model.nodes.coords[:, 0] - 5.0)
    )


STOP = """[model]
deck = "deck.k"
units = "m-kg-s"
[damping]
modal = 0.0
[reduction]
method = "none"
[time]
end = 0.04
accuracy = "fine"
[[connector]]
type = "play"
nodes = ["SET_NODE_1"]
dof = "x"
lower = -0.001
stiffness = "hard"
"""


@pytest.mark.parametrize(
    "start",
    [
        "*INITIAL_VELOCITY_NODE\n2,-1.\n",
        "*INITIAL_VELOCITY\n\n-1.\n",
        "*INITIAL_VELOCITY_GENERATION\n1,3,2.\n2.,-.5,0.,0.,0.,1.\n",
    ],
)
def test_a_run_starts_with_it(tmp_path, start):
    """A mass m on a spring (w = 10 /s) meets a hard stop at d: it leaves 2 m (v^2 - w^2 d^2)^(1/2) there."""
    deck = (
        "*KEYWORD\n*NODE\n1,0.,0.,0.,7,7\n2,2.,0.,0.,5,7\n*ELEMENT_MASS\n5,2,100.\n*ELEMENT_DISCRETE\n7,3,1,2\n"
        "*PART\nspring\n3,3,3\n*SECTION_DISCRETE\n3\n0.\n*MAT_SPRING_ELASTIC\n3,1.e4\n*SET_NODE_LIST\n1\n2\n"
    )
    study = write_study(tmp_path, STOP, {"deck.k": f"{deck}{start}*END\n"})
    (event,) = run_study(set_up(read_study(study)), silent).runs["reference"].events
    assert event.impulse == pytest.approx(2.0 * 100.0 * math.sqrt(1.0 - 100.0 * 1e-6), rel=1e-3)


@pytest.mark.parametrize(
    ("start", "expected"),
    [
        ("*INITIAL_VELOCITY_NODE\n2,1.,2.,3.,4.,5.,6.,9\n", {2: [-2, 1, 3, -5, 4, 6]}),
        ("*INITIAL_VELOCITY\n4,,,,9\n1.\n", {3: [0, 1, 0], 6: [0, 1, 0]}),
        (
            "*INITIAL_VELOCITY\n,4\n1.\n,2.\n",
            {1: [1], 2: [1], 3: [0, 2], 4: [1], 5: [1], 6: [0, 2]},
        ),
        ("*INITIAL_VELOCITY\n4\n1.\n*INITIAL_VELOCITY\n4\n,,8.\n", {3: [0, 0, 8], 6: [0, 0, 8]}),
        ("*INITIAL_VELOCITY_GENERATION\n4,3,,1.,,,,9\n\n", {3: [0, 1, 0], 6: [0, 1, 0]}),
        (
            "*INITIAL_VELOCITY_GENERATION\n4,3,2.\n60.,0.,0.,-999.,4.,1.\n",
            {3: [0, 0, 0, 0, -2, 0], 6: [0, 0, 0, 0, -2, 0]},
        ),
        (
            "*INITIAL_VELOCITY_GENERATION\n1,2,,5.\n\n2,2,,,6.\n\n",
            {1: [5], 4: [5], 2: [0, 6], 3: [0, 6], 5: [0, 6], 6: [0, 6]},
        ),
        ("*INITIAL_VELOCITY_NODE\n2,0.\n", {}),
    ],
)
def test_whose_velocity_it_is(tmp_path, start, expected):
    """In systems of their own; of a node that is named twice the later one counts."""
    found = speeds(read(tmp_path, start))
    for node in range(1, 7):
        given = expected.get(node, [])
        assert found[node - 1] == pytest.approx([*given, *[0] * (6 - len(given))])


def test_a_velocity_after_dynamic_relaxation_is_one_at_the_start_and_says_so(tmp_path):
    model = read(tmp_path, "*INITIAL_VELOCITY_GENERATION\n4,3,,1.\n,,,,,,1\n")
    assert speeds(model)[2] == pytest.approx([1, 0, 0, 0, 0, 0])
    (found,) = model.unread
    assert (found.changes_answer, "after dynamic relaxation" in found.why) == (False, True)


def test_nodes_without_a_velocity_rest_where_they_are_tied_to_moving_ones(tmp_path):
    """v = 9 (1 - x/30) on the first half of a rigid plate: V = 9/4 at its middle, slope -2700 / J, J = 5 (60^2 + t^2)."""
    body = "*SET_NODE_LIST\n7\n1,2,3,4,5,6\n*CONSTRAINED_NODAL_RIGID_BODY\n1,,7\n*SET_NODE_LIST\n8\n1,4\n"
    model = read(tmp_path, body + "*INITIAL_VELOCITY\n8\n,,9.\n")
    system = assembled(model)
    v = system.rows(6 * np.arange(6) + 2)[0] @ system.velocity
    assert v == pytest.approx(2.25 - 540.0 / (3600.0 + T**2) * (model.nodes.coords[:6, 0] - 30.0), rel=1e-5)


@pytest.mark.parametrize(
    ("start", "words"),
    [
        ("*INITIAL_VELOCITY\n,,3\n1.\n", "without BOXID and IRIGID"),
        ("*INITIAL_VELOCITY\n4,,,1\n1.\n", "without BOXID and IRIGID"),
        ("*INITIAL_VELOCITY_GENERATION\n4,3,,1.\n\n*INITIAL_VELOCITY_NODE\n2,1.\n", "has no other"),
        ("*INITIAL_VELOCITY\n4\n1.\n*INITIAL_VELOCITY_NODE\n3,2.\n", "node 3 has another one"),
        ("*INITIAL_VELOCITY_RIGID_BODY\n1,2.\n", "_NODE and _GENERATION"),
        ("*INITIAL_VELOCITY_GENERATION_START_TIME\n1,2.\n", "_NODE and _GENERATION"),
    ],
)
def test_what_is_not_read_is_listed(tmp_path, start, words):
    (found,) = read(tmp_path, start).unread
    assert (found.changes_answer, words in found.why) == (True, True)


@pytest.mark.parametrize(
    ("start", "words"),
    [
        ("*INITIAL_VELOCITY_GENERATION\n1,2,3.\n\n", "OMEGA and no axis"),
        ("*INITIAL_VELOCITY_GENERATION\n1,2,3.\n", "1 data lines"),
        ("*INITIAL_VELOCITY_GENERATION\n7,2\n\n", "part 7, which has no elements"),
        ("*INITIAL_VELOCITY_GENERATION\n7,5\n\n", "STYP 1"),
        ("*INITIAL_VELOCITY\n4,4\n1.\n", "2 data lines"),
        ("*INITIAL_VELOCITY\n44\n1.\n", "node set 44"),
        ("*INITIAL_VELOCITY_NODE\n99,1.\n", "node 99"),
        ("*INITIAL_VELOCITY_NODE\n1,1.,,,,,,8\n", "coordinate system 8"),
    ],
)
def test_what_is_wrong_is_refused(tmp_path, start, words):
    with pytest.raises(InputError, match=words):
        read(tmp_path, start)


def test_velocities_of_a_file_that_is_moved_are_listed(tmp_path):
    (tmp_path / "part.k").write_text("*KEYWORD\n*INITIAL_VELOCITY_NODE\n2,1.\n*END\n")
    moved = "*DEFINE_TRANSFORMATION\n3\nTRANSL,1.\n*INCLUDE_TRANSFORM\npart.k\n0\n0\n1.,1.,1.,,1\n3\n"
    model = read(tmp_path, moved)
    assert [(u.keyword, u.changes_answer) for u in model.unread] == [("*INITIAL_VELOCITY_NODE", True)]
    assert model.initial_velocity == ()
