"""A deck's own *DYNAMIC step: against closed form, and against the same thing as a study."""

import math
import re

import numpy as np
import pytest

from creak.errors import InputError
from creak.progress import silent
from creak.studies.file.reader import read_study
from creak.studies.prepare.amount_check import jump_warnings
from creak.studies.prepare.deck_step import set_up_deck
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import run_study
from helpers_dynamic_decks import FLUSH, LINEAR, PAIR, STEP, bar_deck, cantilever_deck, stop_deck

RECORDED = {"section": "decks", "source": "closed form"}


@pytest.fixture
def deck(tmp_path):
    def write(text):
        path = tmp_path / "deck.inp"
        path.write_text(text)
        return path

    return write


@pytest.fixture
def run(deck):
    def go(text):
        result = run_study(set_up_deck(deck(text)), silent)
        return result, result.runs["reference"]

    return go


def step(lines="", increment="2.E-4", head="*STEP\n", dynamic="*DYNAMIC, DIRECT"):
    return f"{head}{dynamic}\n{increment}, 0.1\n{lines}*NODE OUTPUT, NSET=TIP\nU\n*END STEP\n"


def test_mass_on_a_penalty_stop(run, measured):
    """w^2 = (1e4 + 1e6) / 100: force 1e6 v / w, contact pi / w, impulse 1e6 2 v / w^2; step 2e-5 has an error of
    (w h)^2 / 12 < 1e-6."""
    result, found = run(stop_deck(step=STEP.replace("1.E-5", "2.E-5")))
    (event,) = found.events
    w = math.sqrt(1.01e6 / 100.0)
    measured("*DYNAMIC, mass on a penalty stop: peak force", event.force_peak, 9950.3719, rel=1e-6, unit="N")
    measured(
        "*DYNAMIC, mass on a penalty stop: duration", event.t_end - event.t_start, 0.0312600153, rel=1e-6, unit="s"
    )
    measured("*DYNAMIC, mass on a penalty stop: impulse", event.impulse, 2.0e6 / w**2, rel=1e-6, unit="N s")
    velocity = np.gradient(found.history.displacement[:, 2], found.history.time)[-1]
    after = 0.04 - math.pi / w
    assert velocity == pytest.approx(math.cos(10.0 * after), rel=1e-4)  # then on the spring alone
    assert set(result.runs) == {"reference"}


ALONG_Z = "*CONTACT PAIR, INTERACTION=S, TYPE={kind}, SMALL SLIDING\nEND_FACE, TABLE\n*SURFACE INTERACTION, NAME=S\n"
RIGID = "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n1.E13\n"
C = math.sqrt(2.1e11 / 7850.0)


def test_bar_on_a_rigid_wall(run, measured):
    """Contact lasts 2 L / c with rho c A v, the bar leaves as fast as it came: impulse 2 m v.

    The bar starts 0.1 ms before the wall; half the wall's thickness counts.
    """
    duration, start = 2.0 / C, 1.0e-4
    contact = ALONG_Z.format(kind="SURFACE TO SURFACE") + RIGID
    _, found = run(bar_deck(contact, duration / 800, 1.35 * duration, 80, 0.5e-3 + start))
    (event,) = found.events
    force, time = found.history.force.sum(axis=1), found.history.time
    assert event.t_start == pytest.approx(start, abs=time[1])
    inside = (time > start + 0.2 * duration) & (time < start + 0.8 * duration)
    # two elements of 80 and the penalty
    measured("*DYNAMIC, bar on a wall: duration", event.t_end - event.t_start, duration, rel=0.02, unit="s")
    measured("*DYNAMIC, bar on a wall: impulse", force.sum() * time[1], 2.0 * 78.5, rel=0.005, unit="N s")
    measured("*DYNAMIC, bar on a wall: force", force[inside].mean(), 7850.0 * C * 0.01, rel=0.005, unit="N")


def test_node_to_surface_takes_pressure_times_area(deck):
    """The same linear law gives both kinds of contact the same total stiffness, that of the face."""
    for kind in ("SURFACE TO SURFACE", "NODE TO SURFACE"):
        setup = set_up_deck(
            deck(bar_deck(ALONG_Z.format(kind=kind) + RIGID + "*CONTACT DAMPING\n1.E6\n", 1e-6, 1e-4, 4))
        )
        assert setup.contacts.stiffness.sum() == pytest.approx(1e13 * 0.01)
        assert setup.contacts.damping.sum() == pytest.approx(1e6 * 0.01)


STUDY = """
[model]
units = "m-kg-s"
deck = "deck.inp"
[excitation.root]
node_set = "ROOT"
dof = "z"
kind = "{kind}"
signal = {{ type = "sine", frequency = 25.0, amplitude = {amplitude} }}
[reduction]
method = "none"
[time]
step = 2e-4
end = 0.1
alpha = -0.05
[output]
nodes = "TIP"
"""
SINE = f"*AMPLITUDE, NAME=SINE, DEFINITION=PERIODIC\n1, {50.0 * math.pi:.17g}, 0., 0.\n0., 1.\n"


@pytest.mark.parametrize(("kind", "amplitude"), [("displacement", 0.001), ("acceleration", 25.0)])
def test_sine_base_motion_as_the_study_has_it(run, tmp_path, kind, amplitude, measured):
    lines = f"*BOUNDARY, TYPE={kind.upper()}, AMPLITUDE=SINE\nROOT, 3, 3, {amplitude}\n"
    _, found = run(cantilever_deck(step(lines), SINE))
    (tmp_path / "study.toml").write_text(STUDY.format(kind=kind, amplitude=amplitude))
    other = run_study(set_up(read_study(tmp_path / "study.toml")), silent).runs["reference"].history.displacement
    largest = np.abs(other).max()
    assert largest > 0.5 * 0.001
    error = np.abs(found.history.displacement - other).max() / largest
    measured(f"*DYNAMIC, base moved by {kind}: relative difference", error, at_most=1e-12, source="the same as a study")


def tip(found):
    return found.history.displacement[:, 2]


def test_velocity_is_the_derivative_of_displacement(run):
    """Sine displacement, or its cosine velocity: the same motion, by another formula."""
    cosine = SINE.replace("0., 1.\n", "1., 0.\n")
    moved = "*BOUNDARY, TYPE={}, AMPLITUDE=SINE\nROOT, 3, 3, {:.17g}\n"
    _, one = run(cantilever_deck(step(moved.format("DISPLACEMENT", 0.001)), SINE))
    _, two = run(cantilever_deck(step(moved.format("VELOCITY", 0.05 * math.pi)), cosine))
    # Newmark's rule for the supports divides by h^2: round-off of the samples grows by (500 steps)^2 or so.
    assert np.abs(tip(one) - tip(two)).max() < 1e-9 * np.abs(tip(one)).max()


def test_loads_add_up_and_are_linear(run):
    """Two loads on one node are their sum; without amplitude a load acts from the start, with RAMP it grows."""
    _, parts = run(cantilever_deck(step("*CLOAD\nTIP, 3, 3.\n9, 3, 4.\n"), held="ROOT, ENCASTRE\n"))
    _, whole = run(cantilever_deck(step("*CLOAD\nTIP, 3, 7.\n"), held="ROOT, ENCASTRE\n"))
    assert tip(parts) == pytest.approx(tip(whole), rel=1e-12, abs=1e-18)
    curve = "*AMPLITUDE, NAME=LINE\n0., 0., 0.1, 1.\n"
    _, ramp = run(
        cantilever_deck(step("*CLOAD\nTIP, 3, 7.\n", head="*STEP, AMPLITUDE=RAMP\n"), held="ROOT, ENCASTRE\n")
    )
    _, line = run(cantilever_deck(step("*CLOAD, AMPLITUDE=LINE\nTIP, 3, 7.\n"), curve, "ROOT, ENCASTRE\n"))
    assert tip(ramp) == pytest.approx(tip(line), rel=1e-12, abs=1e-18)
    # F L^3 / (3 E I) with I = 0.02 0.01^3 / 12 about y (the beam is 0.01 high along z); slow against 50 Hz
    static = 7.0 * 0.4**3 / (3.0 * 2.1e11 * 0.02 * 0.01**3 / 12.0)
    assert abs(tip(ramp)[-1]) == pytest.approx(static, rel=0.2)


def test_absolute_values_replace_the_magnitude(run):
    curve = "*AMPLITUDE, NAME=LINE, VALUE={}\n0., 0., 0.1, {}\n"
    text = step("*CLOAD, AMPLITUDE=LINE\nTIP, 3, 7.\n")
    _, absolute = run(cantilever_deck(text, curve.format("ABSOLUTE", 14), "ROOT, ENCASTRE\n"))
    _, relative = run(cantilever_deck(text, curve.format("RELATIVE", 2), "ROOT, ENCASTRE\n"))
    assert tip(absolute) == pytest.approx(tip(relative), rel=1e-12, abs=1e-18)
    assert np.abs(tip(absolute)).max() > 0.0


def test_smooth_step_moves_the_root(run):
    curve = "*AMPLITUDE, NAME=S, DEFINITION=SMOOTH STEP\n0., 0., 0.05, 1.\n"
    text = step("*BOUNDARY, AMPLITUDE=S\nROOT, 3, 3, 0.01\n*NODE OUTPUT, NSET=ROOT\nU\n")
    _, found = run(cantilever_deck(text, curve))
    root = found.history.displacement[:, 2 if np.ptp(found.history.displacement[250:, 2]) < 1e-15 else 8]
    x = np.minimum(found.history.time / 0.05, 1.0)
    assert root == pytest.approx(0.01 * x**3 * (10.0 - 15.0 * x + 6.0 * x**2), abs=1e-15)


@pytest.mark.parametrize(
    ("words", "points", "told"), [("", 3, True), (", SMOOTH=0.1", 3, True), (", SMOOTH=0.", 3, False), ("", 2, False)]
)
def test_rounded_corners_of_a_motion_are_told(deck, words, points, told):
    """CalculiX moves supports along the lines of the table themselves."""
    curve = f"*AMPLITUDE, NAME=S{words}\n" + ", ".join(["0., 0.", "0.02, 1.", "0.05, 0."][:points]) + "\n"
    setup = set_up_deck(deck(cantilever_deck(step("*BOUNDARY, AMPLITUDE=S\nROOT, 3, 3, 0.01\n"), curve)))
    assert any("corners of the tables that move supports are rounded" in note for note in setup.notes) == told


def test_zero_boundary_in_the_step_adds_a_support(run):
    _, found = run(cantilever_deck(step("*BOUNDARY\nTIP, 3\n*CLOAD\n5, 3, 100.\n"), held="ROOT, ENCASTRE\n"))
    assert np.array_equal(tip(found), np.zeros_like(tip(found)))


@pytest.mark.parametrize(
    ("dynamic", "contact", "alpha"),
    [
        ("*DYNAMIC, DIRECT", True, -0.41421),
        ("*DYNAMIC, DIRECT", False, -0.05),
        ("*DYNAMIC, DIRECT, ALPHA=-0.1", True, -0.1),
        ("*DYNAMIC, DIRECT, APPLICATION=TRANSIENT FIDELITY", True, -0.05),
        ("*DYNAMIC, DIRECT, APPLICATION=MODERATE DISSIPATION", False, -0.41421),
    ],
)
def test_alpha(deck, dynamic, contact, alpha):
    text = stop_deck(PAIR + LINEAR + FLUSH if contact else "", STEP.replace("*DYNAMIC, DIRECT, ALPHA=0.", dynamic))
    setup = set_up_deck(deck(text))
    assert setup.study.config.time.alpha == alpha
    assert any("moderate" in n for n in setup.notes) == (contact and dynamic == "*DYNAMIC, DIRECT")


@pytest.mark.parametrize(
    ("kind", "law", "stiffness"),
    [
        ("NODE TO SURFACE, SMALL SLIDING", "", "hard"),
        ("SURFACE TO SURFACE, SMALL SLIDING", "", "hard"),
        ("SURFACE TO SURFACE", "", "auto"),
        ("SURFACE TO SURFACE", "*SURFACE BEHAVIOR, DIRECT\n", "hard"),
        ("NODE TO SURFACE", "*SURFACE BEHAVIOR, PENALTY\n", "auto"),
    ],
)
def test_enforcement(deck, kind, law, stiffness):
    pair = f"*CONTACT PAIR, INTERACTION=STOP, TYPE={kind}\nEND_FACE, TABLE\n*SURFACE INTERACTION, NAME=STOP\n"
    setup = set_up_deck(deck(bar_deck(pair + law, 1e-6, 1e-4, 4)))
    assert setup.study.config.contact["END_FACE-TABLE"].stiffness == stiffness
    assert any("small" in n for n in setup.notes) == ("SMALL" not in kind)


def test_notes_of_time(deck):
    setup = set_up_deck(deck(cantilever_deck(step(increment="3.E-3", dynamic="*DYNAMIC"))))
    assert setup.loads.time[-1] == pytest.approx(0.102)
    assert any("no multiple of the increment" in n and "0.102" in n for n in setup.notes)
    assert any("no automatic increments" in n for n in setup.notes)
    whole = set_up_deck(deck(cantilever_deck(step(), held="ROOT, ENCASTRE\n")), units="m-kg-s")
    assert whole.loads.n_step == 500
    assert not whole.notes


@pytest.mark.parametrize(
    ("text", "what", "start"),
    [
        (
            cantilever_deck(step("*BOUNDARY, AMPLITUDE=SINE\nROOT, 3, 3, 1.\n"), SINE.replace("157.", "99157.")),
            "cannot follow an excitation",
            "2.E-4",
        ),
        (cantilever_deck(step(head="*STEP, NLGEOM\n")), "*STEP, NLGEOM is not read", "*STEP"),
        (cantilever_deck(step("*DSLOAD\nS, P, 1.\n")), "*DSLOAD is not read", "*DSLOAD"),
        (stop_deck().replace("1, 0., 0., 0.", "1, 0., 0., 50."), "never face each other", "POINT, TABLE"),
    ],
)
def test_wrong_decks(deck, text, what, start):
    with pytest.raises(InputError, match=re.escape(what)) as caught:
        set_up_deck(deck(text))
    line = next(i for i, row in enumerate(text.splitlines(), 1) if row.startswith(start))
    assert caught.value.where.endswith(f"deck.inp:{line}")


def test_ignore_goes_on(deck):
    setup = set_up_deck(deck(cantilever_deck(step(head="*STEP, NLGEOM\n"))), ["STEP, NLGEOM"])
    assert setup.loads.n_step == 500


def test_initial_velocity_beside_an_acceleration(deck):
    text = cantilever_deck(
        step("*BOUNDARY, TYPE=ACCELERATION\nROOT, 3, 3, 1.\n"), "*INITIAL CONDITIONS, TYPE=VELOCITY\nROOT, 3, 1.\n"
    )
    with pytest.raises(InputError, match="node 1 has an initial velocity and a prescribed acceleration"):
        set_up_deck(deck(text))


@pytest.mark.parametrize(
    ("signal", "wrong"),
    [
        ('{ type = "table" }', "either file or values"),
        ('{ type = "table", file = "a.csv", values = [[0, 1]] }', "either file or values"),
        ('{ type = "table", values = [[0, 1], [0, 2]] }', "0 s does not come 1e-12 s or more after 0 s"),
        ('{ type = "smooth-step", values = [[0, 1]] }', "at least 2"),
        ('{ type = "periodic" }', "frequency' is missing"),
    ],
)
def test_wrong_signals_of_a_study(tmp_path, signal, wrong):
    text = STUDY.format(kind="velocity", amplitude=1.0)
    old = next(line for line in text.splitlines() if line.startswith("signal"))
    (tmp_path / "study.toml").write_text(text.replace(old, f"signal = {signal}"))
    with pytest.raises(InputError, match=re.escape(wrong)) as caught:
        read_study(tmp_path / "study.toml")
    assert f"study.toml:{text.splitlines().index(old) + 1}" in caught.value.where


TURNED = "*TRANSFORM, NSET=TIP\n0., 0.6, 0.8, 0., -0.8, 0.6\n"


def test_loads_on_turned_nodes(deck):
    """A load of 10 along the node's axis 1, (0, 0.6, 0.8)."""
    setup = set_up_deck(deck(cantilever_deck(step("*CLOAD\nTIP, 1, 10.\n"), TURNED, "ROOT, ENCASTRE\n")))
    loads = {t.dof: t.signal.amplitude for t in setup.study.config.excitation.values()}
    assert loads == pytest.approx({"y": 6.0, "z": 8.0})


def test_motion_of_turned_nodes_is_an_error(deck):
    lines = "*BOUNDARY, TYPE=VELOCITY\nTIP, 1, 1, 10.\n"
    with pytest.raises(InputError, match=r"moves TIP, which has a \*TRANSFORM"):
        set_up_deck(deck(cantilever_deck(step(lines), TURNED)))


def test_a_jump_at_the_start_is_noted(deck):
    curve = "*AMPLITUDE, NAME=C\n0., 2., 0.1, 2.\n"
    setup = set_up_deck(deck(cantilever_deck(step("*BOUNDARY, AMPLITUDE=C\nROOT, 3, 3, 0.1\n"), curve)))
    assert any("ROOT z displacement is 0.2 at the start" in n for n in setup.notes)


def test_a_node_surface_touches_by_its_nodes(deck):
    setup = set_up_deck(deck(stop_deck(PAIR.replace("NODE TO", "SURFACE TO") + LINEAR + FLUSH)))
    assert setup.study.config.contact["POINT-TABLE"].method == "node-to-surface"
    assert setup.contacts.stiffness.tolist() == [1e6]
    assert any("POINT is a surface of nodes" in n for n in setup.notes)


def test_friction_of_the_deck(deck):
    for lines, friction in (("", None), ("*FRICTION, EXPONENTIAL DECAY\n0.5, 0.3, 4.\n", (0.5, 0.3, 0.25))):
        contacts = set_up_deck(deck(stop_deck(PAIR + LINEAR + lines + FLUSH))).contacts
        found = contacts.friction
        assert (found is None) == (friction is None)
        if found is not None:
            assert (found.static[0], found.kinetic[0], found.decay[0]) == friction


def test_instances_and_assembly_names(run):
    """Step data name sets of instances and of the assembly."""
    part = (
        "*PART, NAME=ROD\n*NODE\n1, 0., 0., 0.\n2, 0.1, 0., 0.\n3, 0.2, 0., 0.\n*ELEMENT, TYPE=B31, ELSET=ALL\n"
        "1, 1, 2\n2, 2, 3\n*NSET, NSET=BASE\n1\n*NSET, NSET=TIP\n3\n"
        "*BEAM SECTION, ELSET=ALL, MATERIAL=STEEL, SECTION=RECT\n0.02, 0.01\n0., 1., 0.\n*END PART\n"
    )
    assembly = (
        "*ASSEMBLY, NAME=A\n*INSTANCE, NAME=ROD-1, PART=ROD\n*END INSTANCE\n"
        "*INSTANCE, NAME=ROD-2, PART=ROD\n0., 1., 0.\n*END INSTANCE\n"
        "*NSET, NSET=TIP, INSTANCE=ROD-2\n3\n*END ASSEMBLY\n"
        "*MATERIAL, NAME=STEEL\n*ELASTIC\n2.1E11, 0.\n*DENSITY\n7850.\n"
        "*BOUNDARY\nROD-1.BASE, ENCASTRE\nROD-2.BASE, ENCASTRE\n"
    )
    _, found = run(part + assembly + step("*CLOAD\nROD-2.3, 3, 5.\nA.TIP, 3, 5.\n*NODE OUTPUT, NSET=ROD-1.TIP\nU\n"))
    ends = found.history.displacement[:, [2, 8]]
    assert (np.ptp(ends, axis=0) == 0.0).tolist() == [True, False]
    # mean of the free vibration: the static value 10 L^3 / (3 E I); here over many periods of 0.2 m
    static = 10.0 * 0.2**3 / (3.0 * 2.1e11 * 0.02 * 0.01**3 / 12.0)
    assert ends[:, 1].mean() == pytest.approx(static, rel=0.1)


def test_a_start_of_round_off_is_no_jump():
    motion = np.array([[3e-17, 0.2, 0.0], [1.0, 0.5, 0.0]])
    (told,) = jump_warnings(["a", "b", "c"], motion)
    assert told.startswith("b is 0.2 at the start, where the structure is at rest: it jumps, and what that closes")
