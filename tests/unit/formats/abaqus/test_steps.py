"""What is read of a deck's own *DYNAMIC step, and what is not."""

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.abaqus.reader import read_deck, read_deck_run
from helpers_dynamic_decks import FLUSH, LINEAR, PAIR, cantilever_deck, stop_deck
from helpers_refusal import refusal


@pytest.fixture
def read(tmp_path):
    def reader(text):
        path = tmp_path / "deck.inp"
        path.write_text(text)
        return read_deck_run(path)

    return reader


@pytest.fixture
def error(read):
    return lambda text: refusal(read, text)


def step(lines="", dynamic="*DYNAMIC, DIRECT\n1.E-3, 0.1\n", head="*STEP\n"):
    return f"{head}{dynamic}{lines}*END STEP\n"


def moved(read, lines, amplitudes="", head="*STEP\n", **deck):
    return read(cantilever_deck(step(lines, head=head), amplitudes, **deck))[1].step.moved


def line_of(text, start):
    return next(i for i, line in enumerate(text.splitlines(), start=1) if line.startswith(start))


RAMP = "*AMPLITUDE, NAME=RAMP\n0., 0., 0.1, 1.\n"


def test_the_dynamic_step(read):
    s = read(stop_deck())[1].step
    assert (s.name, s.increment, s.period, s.alpha, s.direct, s.application) == ("HIT", 1e-5, 0.04, 0.0, True, "")
    assert s.output_sets == ("BALL",)
    assert not s.moved
    assert not s.loads


@pytest.mark.parametrize(
    ("params", "application", "alpha"),
    [
        ("", "", None),
        (", APPLICATION=MODERATE DISSIPATION", "MODERATE DISSIPATION", None),
        (", TIME INTEGRATOR=HHT-TF", "TRANSIENT FIDELITY", None),
        (", APPLICATION=TRANSIENT FIDELITY, ALPHA=-0.2", "TRANSIENT FIDELITY", -0.2),
    ],
)
def test_scheme(read, params, application, alpha):
    s = read(cantilever_deck(step(dynamic=f"*DYNAMIC{params}\n1.E-3, 0.1\n")))[1].step
    assert (s.application, s.alpha, s.direct) == (application, alpha, False)


def held_dofs(model):
    return sorted({(int(n), d) for f in model.fixed for n in f.nodes_idx for d in f.dofs})


def test_model_boundaries_hold_in_the_step(read):
    model, _ = read(cantilever_deck(step("*BOUNDARY\nTIP, 2\n")))
    assert held_dofs(model) == [(0, 1), (0, 2), (0, 4), (0, 5), (0, 6), (8, 2)]


def test_op_new_releases_them(read):
    model, _ = read(cantilever_deck(step("*BOUNDARY, OP=NEW\nROOT, 1, 2\nTIP, 2\n")))
    assert held_dofs(model) == [(0, 1), (0, 2), (8, 2)]
    assert not any("OP=NEW" in u.keyword for u in model.unread)


def test_op_new_of_a_step_that_a_study_defines_releases_them_too(tmp_path):
    """Each block of the step says so; all of them hold."""
    path = tmp_path / "deck.inp"
    new = step("*BOUNDARY, OP=NEW\nROOT, 1, 2\n*BOUNDARY, OP=NEW\nTIP, 2\n").replace("*DYNAMIC", "*FREQUENCY\n4\n**")
    path.write_text(cantilever_deck(new))
    model = read_deck(path)
    assert held_dofs(model) == [(0, 1), (0, 2), (8, 2)]
    assert not any(u.changes_answer for u in model.unread)


def test_a_moved_dof_is_not_held(read):
    model, run = read(cantilever_deck(step("*BOUNDARY, AMPLITUDE=RAMP\nROOT, 3, 3, 0.01\n"), RAMP, "ROOT, ENCASTRE\n"))
    assert (0, 3) not in held_dofs(model)
    assert [(m.dof, m.kind, m.value, m.nodes_idx.tolist()) for m in run.step.moved] == [(3, "displacement", 0.01, [0])]


def test_the_last_line_for_a_dof_counts(read):
    found = moved(read, "*BOUNDARY, AMPLITUDE=RAMP\nROOT, 3, 3, 1.\n*BOUNDARY, TYPE=VELOCITY\n1, 3, 3, 2.\n", RAMP)
    assert [(m.kind, m.value, m.amplitude) for m in found] == [("velocity", 2.0, "")]


def test_dofs_of_a_node_are_held_together(read):
    """One entry for all that a line still holds; ENCASTRE less the moved dof."""
    model, _ = read(cantilever_deck(step("*BOUNDARY, AMPLITUDE=RAMP\nROOT, 3, 3, 0.01\n"), RAMP, "ROOT, ENCASTRE\n"))
    assert [f.dofs for f in model.fixed] == [(1, 2, 4, 5, 6)]


def test_held_along_axes_of_a_transform(read):
    """Axis 1 of the node is (0, 0.6, 0.8): one equation."""
    turned = "*TRANSFORM, NSET=TIP\n0., 0.6, 0.8, 0., -0.8, 0.6\n"
    model, _ = read(cantilever_deck(step("*BOUNDARY\nTIP, 1\n"), turned))
    (equation,) = model.constraints
    assert dict(zip(equation.dofs.tolist(), equation.coefficients.tolist(), strict=True)) == {
        2: pytest.approx(0.6),
        3: pytest.approx(0.8),
    }


def test_fixed_holds_whatever_the_value(read):
    model, run = read(cantilever_deck(step("*BOUNDARY, FIXED\nTIP, 2, 2, 5.\n")))
    assert (8, 2) in held_dofs(model)
    assert not run.step.moved


def test_boundaries_of_a_frequency_step_do_not_go_on(read):
    before = "*STEP\n*FREQUENCY, EIGENSOLVER=LANCZOS\n10, 1., 100.\n*BOUNDARY\nTIP, 2\n*END STEP\n"
    model, run = read(cantilever_deck(before + step()))
    assert (8, 2) not in held_dofs(model)
    assert [b.split(",")[0] for b in run.before] == ["1 (*FREQUENCY"]


def test_later_steps_are_named(read):
    _, run = read(cantilever_deck(step() + step(head="*STEP, NAME=MORE\n")))
    assert run.after[0].startswith("MORE (*DYNAMIC")


@pytest.mark.parametrize(
    ("after", "keyword"),
    [
        (step(head="*STEP, NAME=MORE\n"), "*STEP MORE"),
        ("*STEP\n*STATIC\n1., 1.\n*END STEP\n", "*STEP 2"),
        ("*STEP\n*FREQUENCY\n5,\n*END STEP\n", None),
        ("*STEP, PERTURBATION\n*STATIC\n*END STEP\n", None),
    ],
)
def test_steps_in_which_the_run_goes_on_are_no_matter_of_course(read, after, keyword):
    """creak runs the first *DYNAMIC step: what Abaqus goes on with changes the answer, a perturbation does not."""
    model, _ = read(cantilever_deck(step() + after))
    assert [u.keyword for u in model.unread if u.changes_answer] == ([] if keyword is None else [keyword])


@pytest.mark.parametrize(
    ("data", "keyword"),
    [("*RESTART, READ, STEP=1\n", "*RESTART, READ"), ("*MATERIAL, NAME=P\n*PLASTIC\n9., 0.\n", "*PLASTIC")],
)
def test_what_bears_on_a_run_alone_is_told_there(read, data, keyword):
    model, _ = read(cantilever_deck(step(), data))
    assert [u.keyword for u in model.unread if u.changes_answer] == [keyword]


def test_a_look_at_the_deck_tells_what_its_own_step_asks_for(tmp_path):
    """Of a material that yields; without such a step nothing asks."""
    data = "*MATERIAL, NAME=P\n*PLASTIC\n9., 0.\n"
    for steps, asks in ((step(), True), ("", False)):
        path = tmp_path / "deck.inp"
        path.write_text(cantilever_deck(steps, data))
        (law,) = [u for u in read_deck(path).unread if u.keyword == "*PLASTIC"]
        assert not law.changes_answer
        assert ("own *DYNAMIC step asks for --ignore 'PLASTIC'" in law.why) is asks


def test_total_time_begins_with_the_static_step(read):
    before = "*STEP\n*STATIC\n1., 1.\n*CLOAD\nTIP, 3, 1.\n*END STEP\n"
    late = RAMP.replace("NAME=RAMP", "NAME=RAMP, TIME=TOTAL TIME")
    assert read(cantilever_deck(before + step(), late))[1].static is not None  # nothing follows it
    with pytest.raises(InputError, match="TOTAL TIME, which begins with the \\*STATIC step"):
        read(cantilever_deck(before + step("*CLOAD, AMPLITUDE=Ramp\nTIP, 3, 5.\n"), late))


def test_loads_add_up(read):
    _, run = read(cantilever_deck(step("*CLOAD, AMPLITUDE=RAMP\nTIP, 3, 5.\n9, 3, 2.\n*CLOAD\nTIP, 2, 1.\n"), RAMP))
    assert [(p.dof, p.value, p.amplitude) for p in run.step.loads] == [(3, 5.0, "RAMP"), (3, 2.0, "RAMP"), (2, 1.0, "")]


def test_contact_pairs(read):
    run = read(stop_deck())[1]
    (pair,) = run.pairs
    assert (pair.secondary, pair.main, pair.method) == ("POINT", "TABLE", "node-to-surface")
    assert (pair.small_sliding, pair.clearance) == (True, 0.0)
    assert run.interactions[pair.interaction].stiffness == 1e6


def interaction(read, lines):
    return read(stop_deck(PAIR + "*SURFACE INTERACTION, NAME=STOP\n" + lines))[1].interactions["STOP"]


@pytest.mark.parametrize(
    ("lines", "law"),
    [
        ("", "default"),
        ("*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=HARD\n", "default"),
        ("*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=HARD, DIRECT\n", "hard"),
        ("*SURFACE BEHAVIOR, PENALTY\n", "penalty"),
        ("*SURFACE BEHAVIOR, PENALTY=LINEAR\n2.E5\n", "linear"),
    ],
)
def test_laws(read, lines, law):
    assert interaction(read, lines).law == law


def test_linear_law_of_calculix_has_a_tension_and_a_clearance(read):
    """Of K = 100, sigma = .05 CalculiX 2.20 closes nodes by .010496 under p = 1, (p + sigma) / K, and faces by p / K."""
    lines = "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n100., 0.05, 0.5\n"
    model, run = read(stop_deck(PAIR + "*SURFACE INTERACTION, NAME=STOP\n" + lines))
    found = run.interactions["STOP"]
    assert (found.law, found.stiffness) == ("linear", 100.0)
    (said,) = [u for u in model.unread if u.keyword == "*SURFACE BEHAVIOR, second value"]
    assert (said.changes_answer, "up to a pressure of 0.05" in said.why) == (False, True)


@pytest.mark.parametrize(
    ("law", "data", "words"),
    [
        ("LINEAR", "100., -1.", "tension or clearance is -1"),
        ("LINEAR", "100., 1., 1., 1.", "with 4 values"),
        ("EXPONENTIAL", "0.05, 0.1", "different exponential laws"),
        ("TABULAR", "0., -0.1\n1., 0.1", "starts at 0, -0.1"),
    ],
)
def test_laws_that_creak_has_not_are_refused(read, law, data, words):
    with pytest.raises(InputError, match=words):
        interaction(read, f"*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE={law}\n{data}\n")


def test_tabular_law_gives_overclosure_first(read):
    found = interaction(read, "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR\n0., 0.\n5., 0.1\n20., 0.2\n")
    assert found.curve == ((0.0, 0.0), (0.1, 5.0), (0.2, 20.0))


def test_friction_and_damping(read):
    found = interaction(read, "*FRICTION, EXPONENTIAL DECAY\n0.5, 0.3, 4.\n*CONTACT DAMPING\n7.\n")
    assert found.friction == (0.5, 0.3, 0.25)  # speed 1 / d_c
    assert found.damping == 7.0
    assert interaction(read, "*FRICTION\n0.4\n").friction == (0.4, 0.4, 0.0)


def test_clearance_by_pair_set(read):
    pair = PAIR.replace("*CONTACT PAIR", "*CONTACT PAIR, CPSET=A")
    run = read(stop_deck(pair + LINEAR + "*CLEARANCE, CPSET=A, VALUE=0.25\n"))[1]
    assert run.pairs[0].clearance == 0.25


def test_what_changes_the_answer_is_listed(read):
    head = "*STEP, NLGEOM=YES\n"
    model, _ = read(cantilever_deck(step("*DLOAD\nBEAM, GRAV, 9.81, 0., 0., -1.\n*NODE PRINT\nU\n", head=head)))
    listed = {u.keyword: u.changes_answer for u in model.unread}
    assert {name: listed.get(name) for name in ("*DLOAD", "*STEP, NLGEOM", "*NODE PRINT")} == {
        "*DLOAD": True,
        "*STEP, NLGEOM": True,
        "*NODE PRINT": False,
    }


def test_gravity_of_a_step_is_said_to_be_that_of_static_in_a_study(tmp_path):
    path = tmp_path / "deck.inp"
    path.write_text(cantilever_deck(step("*DLOAD\nBEAM, GRAV, 9.81, 0., 0., -1.\n")))
    listed = {u.keyword: u.why for u in read_deck(path).unread}
    assert "gravity acts in a study only as the study's [[static]] gravity" in listed["*STEP"]
    own = {u.keyword: u.why for u in read_deck_run(path)[0].unread}
    assert "gravity that a *STATIC step before it begins" in own["*DLOAD"]


def test_contact_that_is_not_read_is_listed(read):
    lines = "*CONTACT CONTROLS, STABILIZE\n" + PAIR.replace("SMALL", "ADJUST=0.1, SMALL") + LINEAR
    model, _ = read(stop_deck(lines + "*CLEARANCE, CPSET=A, TABULAR\n"))
    changing = {u.keyword for u in model.unread if u.changes_answer}
    assert changing == {"*CONTACT CONTROLS", "*CONTACT PAIR, ADJUST", "*CLEARANCE, TABULAR"}


def test_what_is_used_is_not_listed(read):
    model, _ = read(stop_deck())
    ours = ("CONTACT", "SURFACE", "CLEAR", "STEP", "AMPLITUDE", "DYNAMIC", "NODE OUTPUT")
    assert [u.keyword for u in model.unread if u.keyword.startswith(tuple(f"*{o}" for o in ours))] == ["*NODE OUTPUT"]


def test_node_surface_with_areas_is_listed(read):
    text = stop_deck().replace("TYPE=NODE\nBALL\n", "TYPE=NODE\nBALL, 2.5\n")
    assert [u.keyword for u in read(text)[0].unread if u.changes_answer] == ["*SURFACE, TYPE=NODE with areas"]


def test_edges_under_pressure_are_listed(read):
    edge = "*SURFACE, NAME=RIM\nWALL, E1\n"
    pair = "*CONTACT PAIR, INTERACTION=STOP\nRIM, TABLE\n"
    changing = {
        law: [u.keyword for u in read(stop_deck(edge + pair + law))[0].unread if u.changes_answer]
        for law in (LINEAR, "*SURFACE INTERACTION, NAME=STOP\n")
    }
    assert list(changing.values()) == [["*SURFACE of edges"], []]


def test_for_a_study_all_of_it_stays_unused(tmp_path):
    path = tmp_path / "deck.inp"
    path.write_text(stop_deck())
    model = read_deck(path)
    assert not any(u.changes_answer for u in model.unread)
    listed = {u.keyword: u.why for u in model.unread}
    assert listed["*CONTACT PAIR"].startswith("a run has the contact of its study")
    assert listed["*STEP"].startswith("the study file defines the step")
    assert model.initial_velocity == ((0, 3, -1.0),)


WRONG = {
    "*BOUNDARY, AMPLITUDE=RAMPE": (step("*BOUNDARY, AMPLITUDE=RAMPE\nROOT, 3, 3, 1.\n"), "unknown amplitude"),
    "*CLOAD, AMPLITUDE=NONE": (step("*CLOAD, AMPLITUDE=NONE\nTIP, 3, 1.\n"), "unknown amplitude"),
    "*DYNAMIC, EXPLICIT": (step(dynamic="*DYNAMIC, EXPLICIT\n, 0.1\n"), "EXPLICIT"),
    "*DYNAMIC, APPLICATION": (
        step(dynamic="*DYNAMIC, APPLICATION=QUASI-STATIC\n1.E-3, 0.1\n"),
        "APPLICATION=QUASI-STATIC",
    ),
    "*DYNAMIC, ALPHA=-0.7": (step(dynamic="*DYNAMIC, ALPHA=-0.7\n1.E-3, 0.1\n"), "ALPHA=-0.7"),
    "-1.E-3, 0.1": (step(dynamic="*DYNAMIC\n-1.E-3, 0.1\n"), "time increment is -1.E-3"),
    "1.E-3": (step(dynamic="*DYNAMIC\n1.E-3\n"), "period of the step is missing"),
    "0.1, 0.1": (step(dynamic="*DYNAMIC\n0.1, 0.1\n"), "increments of 0.1 s in a step of 0.1 s"),
    "1.E-30, 0.1": (step(dynamic="*DYNAMIC\n1.E-30, 0.1\n"), "increments of 1e-30 s in a step of 0.1 s"),
    "*FREQUENCY": ("*STEP\n*FREQUENCY\n10\n*END STEP\n", "no *DYNAMIC or *MODAL DYNAMIC step, only *FREQUENCY"),
    "*RANDOM RESPONSE": (
        "*STEP\n*FREQUENCY\n10\n*END STEP\n*STEP\n*RANDOM RESPONSE\n1., 100.\n*END STEP\n",
        "no *DYNAMIC or *MODAL DYNAMIC step, only *FREQUENCY and *RANDOM RESPONSE",
    ),
    "*VISCO": ("*STEP\n*VISCO\n*END STEP\n" + step(), "a *VISCO step comes before"),
    "*STEP": ("*STEP\n*CLOAD\nTIP, 3, 1.\n*END STEP\n", "no procedure"),
    "ROOT, 3, 3, 0.5": (step("*BOUNDARY\nROOT, 3, 3, 0.5\n"), "moves ROOT by 0.5 at once"),
    "*BOUNDARY, TYPE": (step("*BOUNDARY, TYPE=JERK\nROOT, 3, 3, 0.5\n"), "TYPE=JERK"),
    "TIPP, 3": (step("*CLOAD\nTIPP, 3, 1.\n"), "unknown node set 'TIPP'"),
    "TIP, 7": (step("*CLOAD\nTIP, 7, 1.\n"), "degree of freedom is 7"),
    "*NODE OUTPUT": (step("*NODE OUTPUT, NSET=TOP\nU\n"), "unknown node set 'TOP'"),
    "*STEP, PERTURBATION": (step(head="*STEP, PERTURBATION\n"), "PERTURBATION"),
}


@pytest.mark.parametrize("start", WRONG)
def test_wrong_steps(error, start):
    text = cantilever_deck(WRONG[start][0])
    caught = error(text)
    assert WRONG[start][1] in caught.what
    assert caught.where.endswith(f"deck.inp:{line_of(text, start)}")
    assert caught.fix


WRONG_CONTACT = {
    "POIN, TABLE": (PAIR.replace("POINT,", "POIN,") + LINEAR, "unknown surface 'POIN'"),
    "*CONTACT PAIR, INTERACTION=GO": (PAIR.replace("STOP", "GO") + LINEAR, "unknown surface interaction 'GO'"),
    "*CONTACT PAIR, INTERACTION": (PAIR.replace("NODE TO", "EDGE TO") + LINEAR, "TYPE=EDGE TO SURFACE"),
    "TABLE": (PAIR.replace("POINT, ", "") + LINEAR, "names one surface"),
    "TABLE, TABLE": (PAIR.replace("POINT", "TABLE") + LINEAR, "touches itself"),
    "0.": (PAIR + LINEAR.replace("1.E6", "0."), "contact stiffness is 0."),
    "*SURFACE BEHAVIOR": (PAIR + LINEAR.replace("LINEAR\n1.E6", "EXPONENTIAL\n1., 2."), "EXPONENTIAL"),
    "5., 0.1": (PAIR + LINEAR.replace("LINEAR\n1.E6", "TABULAR\n5., 0.1"), "starts at 5, 0.1"),
    "*FRICTION": ("*FRICTION\n0.3\n" + PAIR + LINEAR, "without *SURFACE INTERACTION"),
    "-0.3": (PAIR + LINEAR + "*FRICTION\n-0.3\n", "coefficient of friction is -0.3"),
    "*CLEARANCE": (PAIR + LINEAR + FLUSH.replace("SLAVE=POINT", "SLAVE=TABLE"), "a contact pair that the deck"),
    "*CLEARANCE, MASTER": (PAIR + LINEAR + FLUSH.replace("=0.", "=-1."), "clearance of -1"),
}


@pytest.mark.parametrize("start", WRONG_CONTACT)
def test_wrong_contact(error, start):
    text = stop_deck(WRONG_CONTACT[start][0])
    caught = error(text)
    assert WRONG_CONTACT[start][1] in caught.what
    assert caught.where.endswith(f"deck.inp:{line_of(text, start)}")


def test_no_step(error):
    caught = error(stop_deck(step=""))
    assert "no *STEP" in caught.what
    assert "study" in caught.fix


def test_frequency_alone_points_to_creak_modes(error):
    assert "creak modes" in error(stop_deck(step="*STEP\n*FREQUENCY\n3\n*END STEP\n")).fix


def test_many_nodes_share_an_entry(read):
    """A set is one prescribed motion, in the order of the deck."""
    found = moved(read, "*BOUNDARY, AMPLITUDE=RAMP\nALL, 3, 3, 1.\n", "*NSET, NSET=ALL\n3, 5, 7\n" + RAMP)
    assert np.array_equal(found[0].nodes_idx, [2, 4, 6])
