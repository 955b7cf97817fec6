"""Mistakes of a first study: each leads to a warning in the command, or to status 2."""

from __future__ import annotations

import json
import re

import pytest

from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.studies.warned import warnings_of
from helpers_decks import STUDY, two_strips, write_strips
from helpers_dynamic_decks import STEP, stop_deck
from helpers_nastran_strips import strips as nastran_strips

pytestmark = pytest.mark.usefixtures("no_page")

SHORT = STUDY.replace("periods = 2", "end = 0.02").replace("[reduction]\n", '[reduction]\nmethod = "none"\n')
SI = two_strips().replace("210000., 0.3", "2.1e11, 0.3").replace("7.85e-9", "7850.")


def second_material(modulus, density):
    """The strips with a material of its own for the lower one."""
    deck = two_strips()
    section = re.search(r"\*SHELL SECTION, ELSET=\w+, MATERIAL=STEEL\n1.0,", deck)[0]
    own = f"*MATERIAL, NAME=SECOND\n*ELASTIC\n{modulus}, 0.3\n*DENSITY\n{density},\n"
    return deck.replace(section, own + section.replace("STEEL", "SECOND"))


def run(creak, folder, deck=None, study=SHORT, *more):
    """What the command says, and the warnings in its summary."""
    said = creak("run", write_strips(folder, deck, study), "--out", folder / "out", *more).done()
    return said, json.loads((folder / "out" / "summary.json").read_text())["warnings"]


def test_a_sound_study_warns_of_no_unit_and_no_support(creak, tmp_path):
    said, warnings = run(creak, tmp_path)
    assert not any(word in text for text in warnings for word in ("mm-t-s", "margin =", "holds", "start closed"))
    assert [line for line in said.err.splitlines() if line.startswith("warning: ")] == [
        f"warning: {w}" for w in warnings
    ]


def refused(creak, folder, deck=None, study=SHORT, *more):
    """The one message of a study that is not run, and that nothing was written."""
    said = creak("run", write_strips(folder, deck, study), "--out", folder / "out", *more)
    assert said.status == 2
    assert not (folder / "out").exists()
    assert not (folder / "superelements").exists()
    return said.err


def test_metres_taken_for_millimetres(creak, tmp_path):
    """Refused before anything is assembled, also where nothing but what is wrong is told."""
    said = refused(creak, tmp_path, SI)
    assert (
        "study.toml:3 [model.units]: the study is in mm-t-s, but material STEEL (E = 2.1e+11, density = 7850)" in said
    )
    assert "is in m-kg-s: 100 % of the model's volume, its elements from" in said
    assert "strips.inp:44 on; expected one system of units; in mm-t-s E lies between 0.01 and 2e+06 MPa" in said
    assert (
        "These figures fit m-kg-s: the lengths are in mm-t-s, so give STEEL E = 210000 and density = 7.85e-09" in said
    )
    assert refused(creak, tmp_path, SI, SHORT, "--quiet") == said
    assert "is in m-kg-s" in creak("info", tmp_path / "strips.inp", "--units", "mm-t-s").err
    assert "is in m-kg-s" not in creak("info", tmp_path / "strips.inp", "--units", "m-kg-s").err


@pytest.mark.parametrize(
    ("deck", "study", "words"),
    [
        (None, SHORT.replace("[model]", '[model]\nunits = "m-kg-s"'), 'set [model] units = "mm-t-s"'),
        # Only 60 % of the strips' volume: one of 1 mm on one of 1.5 mm, both 120 mm long and 20 mm wide.
        (second_material("2.1e11", "7850."), SHORT, "40 % of the model's volume"),
    ],
)
def test_two_systems_of_units_are_refused(creak, tmp_path, deck, study, words):
    assert words in refused(creak, tmp_path, deck, study)


@pytest.mark.parametrize(
    ("modulus", "density", "words"),
    [
        ("210.", "7.85e-6", "give SECOND E = 210000 and density = 7.85e-09"),
        ("2.1e8", "7.85e-6", "is in mm-kg-s"),
    ],
)
def test_units_that_no_study_can_name_are_warned_of(creak, tmp_path, modulus, density, words):
    """They may be meant: a body whose mass was scaled, or a model without dimensions."""
    study = write_strips(tmp_path, second_material(modulus, density), SHORT)
    said = creak("run", study, "--quick", "--out", tmp_path / "out").done()
    assert words in said.err


@pytest.mark.parametrize(
    ("modulus", "density"),
    [
        ("1.0", "1.1e-9"),  # rubber
        ("0.01", "5e-12"),  # foam
        ("1e9", "1e-15"),  # stiff and all but massless
        ("1e15", "1e-20"),
        ("210000.", "1e-12"),  # massless
        ("1e-3", "1e-15"),  # filler
        ("500.", "1.2e-9"),  # glue
        ("4.1e5", "1.93e-8"),  # tungsten
    ],
)
def test_odd_materials_that_may_be_meant_are_run(tmp_path, modulus, density):
    """Half of the elements: of figures of no solid is warned."""
    found = warned(tmp_path, deck=second_material(modulus, density))
    assert all("is of no solid in mm-t-s" in text or "would carry sound" in text for text in found)


def test_a_small_helper_in_other_units_is_run(tmp_path):
    """A skin of a micrometre: 0.04 % of the volume, but half of the elements."""
    deck = second_material("2.1e11", "7850.").replace("SECOND\n1.0,", "SECOND\n0.001,")
    assert any("SECOND (E = 2.1e+11, density = 7850) is in m-kg-s" in text for text in warned(tmp_path, deck=deck))


def test_masses_in_kg(creak, tmp_path):
    mass = "*ELEMENT, TYPE=MASS, ELSET=M\n9001, 13\n*MASS, ELSET=M\n5.0,\n*BOUNDARY\n"
    _, warnings = run(creak, tmp_path, two_strips().replace("*BOUNDARY\n", mass))
    assert any("a mass of 5 t, 5 of it point masses" in w for w in warnings)


def test_a_study_without_contact_is_told_first_of_all(creak, tmp_path):
    bare = re.sub(r"\[contact.tip\]\n(?:[^\[]*\n)*", "", SHORT)
    said, warnings = run(creak, tmp_path, None, bare)
    first = said.err.splitlines()[0]
    assert first == f"warning: {warnings[0]}"
    assert "the study has no contact and no connector, so nothing can rattle" in first
    assert said.out.splitlines()[-1].startswith("verdict: unsettled (the study has no contact")
    assert "settled." not in said.out


def test_nothing_comes_near(creak, tmp_path):
    """The root moves by 12 sines of 0.05 mm; 5 mm stay open."""
    said, warnings = run(creak, tmp_path, two_strips(gap=5.0))
    text = next(w for w in warnings if "no contact comes within the pre-check's margin of 15 % of its gap" in w)
    assert "which starts 5 mm open" in text
    assert "closest approach is" in text
    assert text in said.err


def test_nothing_touches_without_a_precheck(creak, tmp_path):
    study = SHORT + "\n[precheck]\nenabled = false\n"
    _, warnings = run(creak, tmp_path, two_strips(gap=5.0), study)
    text = next(w for w in warnings if "nothing touched in the run" in w)
    assert 4.0 < float(re.search(r"approach was ([\d.]+) mm at", text)[1]) < 5.0


def test_parts_that_overlap_at_the_start(creak, tmp_path):
    _, warnings = run(creak, tmp_path, two_strips(gap=-0.2), SHORT.replace("step = 5e-4", "step = 1e-4"))
    assert any("39 channel(s) start closed, by up to 0.2 mm at node" in w for w in warnings)


def test_parts_deep_inside_each_other_are_refused(creak, tmp_path):
    """A strip of 1 mm whose middle is 0.75 mm below the other's: the sides that should face look apart."""
    said = creak("run", write_strips(tmp_path, two_strips(gap=-2.0), SHORT), "--out", tmp_path / "out")
    said.refuses("surfaces 'UNDER' and 'OVER' never face each other")


def in_metres(deck):
    """The deck of the strips in m, kg and s."""
    nodes = re.compile(r"^(\d+), (-?\d+\.\d+), (-?\d+\.\d+), (-?\d+\.\d+)$", re.MULTILINE)
    small = nodes.sub(
        lambda found: ", ".join([found[1], *(f"{1e-3 * float(x):.9f}" for x in found.groups()[1:])]), deck
    )
    thin = small.replace("STEEL\n1.0,", "STEEL\n1.0e-3,").replace("STEEL\n1.5,", "STEEL\n1.5e-3,")
    return thin.replace("210000., 0.3", "2.1e11, 0.3").replace("7.85e-9", "7850.")


@pytest.mark.parametrize("amplitude", [2.0, 3.0])
def test_the_precheck_keeps_the_same_in_any_units(creak, tmp_path, amplitude):
    """Channels that come near, not all of them; the margin was .5 of whatever length the deck had, as in 0.5 m."""
    counts = []
    for name, deck, units, unit in (
        ("mm", two_strips(), "mm-t-s", 1.0),
        ("m", in_metres(two_strips()), "m-kg-s", 1e-3),
    ):
        (tmp_path / name).mkdir()
        study = SHORT.replace("[model]", f'[model]\nunits = "{units}"').replace("0.05,", f"{amplitude * unit:g},")
        _, warnings = run(creak, tmp_path / name, deck, study)
        assert not any("margin" in w for w in warnings), warnings
        counts.append(json.loads((tmp_path / name / "out" / "summary.json").read_text())["precheck"]["kept"])
    assert counts[0] == counts[1]
    assert 0 < counts[0] < 39


def test_margin_as_large_as_the_model(creak, tmp_path):
    study = SHORT.replace("[time]", "[precheck]\nmargin = 50\n[time]")
    _, warnings = run(creak, tmp_path, None, study)
    assert any("margin = 50 mm is 41 % of the model's size" in w and "leave it out" in w for w in warnings)


def test_part_that_nothing_holds_is_named_with_its_motions(creak, tmp_path):
    deck = two_strips().replace("ROOT_LOWER, 1, 6\n", "ROOT_LOWER, 1, 3\n")
    said = creak("run", write_strips(tmp_path, deck, SHORT))
    said.refuses("nothing holds part(s) LOWER (about y)")
    info = creak("info", tmp_path / "strips.inp").done()
    assert "warning: the deck's supports leave rigid-body motion of UPPER (along z), LOWER (about y)" in info.err
    told = json.loads(creak("info", tmp_path / "strips.inp", "--json").out)
    assert told["free_parts"] == {"UPPER": ["along z"], "LOWER": ["about y"]}


def test_nodes_held_along_axes_of_their_own_are_counted(creak, tmp_path):
    """A node held along x + y only."""
    (tmp_path / "strips.inp").write_text(two_strips())
    before = json.loads(creak("info", tmp_path / "strips.inp", "--json").out)["held_nodes"]
    free = "*NSET, NSET=TURNED\n 3\n*TRANSFORM, NSET=TURNED\n 1., 1., 0., -1., 1., 0.\n*BOUNDARY\n 3, 1\n"
    (tmp_path / "strips.inp").write_text(two_strips() + free)
    assert f"held nodes: {before + 1}" in creak("info", tmp_path / "strips.inp").out
    assert creak("new", tmp_path / "strips.inp", "--out", tmp_path / "first.toml").status == 0
    assert f"the deck holds {before + 1} node(s)" in (tmp_path / "first.toml").read_text()


@pytest.mark.parametrize("name", ["model.odb", "part.stl"])
def test_results_and_geometry_are_no_study(creak, tmp_path, name):
    (tmp_path / name).write_bytes(b"\x00\x01 of another program")
    said = creak("run", tmp_path / name)
    said.refuses(f"{name} is neither a study nor a deck")


def test_typo_in_a_set_name(creak, tmp_path):
    said = creak("run", write_strips(tmp_path, study=SHORT.replace("ROOT_UPPER", "ROOT_UPER")))
    said.refuses("Did you mean 'ROOT_UPPER'")


def test_a_deck_by_itself_gets_the_same_warnings(creak, tmp_path):
    """Units, and a part that nothing holds."""
    deck = tmp_path / "stop.inp"
    deck.write_text(stop_deck(step=STEP.replace("1.E-5", "1.E-4")).replace("WALL_NODES, ENCASTRE", "WALL_NODES, 1, 2"))
    said = creak("run", deck, "--quiet", "--out", tmp_path / "out", "--units", "mm-t-s")
    said.refuses("is in m-kg-s: 100 % of the model's volume", "--units m-kg-s")
    deck.write_text(stop_deck(step=STEP.replace("1.E-5", "1.E-4")))
    said = creak("run", deck, "--quiet", "--out", tmp_path / "out")
    assert (said.status, "m-kg-s" in said.err) == (0, False)


SIGNAL = 'type = "multisine", f_min = 5, f_max = 60, amplitude = 0.05, period = 0.2, seed = 3'


def warned(folder, study=SHORT, deck=None):
    """What setting up a study warns of."""
    return warnings_of(set_up(read_study(write_strips(folder, deck, study))).notes)


def test_a_sound_study_warns_of_nothing_when_set_up(tmp_path):
    assert warned(tmp_path) == []


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("amplitude = 0.05", "amplitude = 0.0", "[excitation.root] is zero throughout the run"),
        (
            SIGNAL,
            'type = "table", values = [[0, 0], [0.4, 0], [0.6, 0], [0.8, 0], [1, 0], [1.5, 1]]',
            "[excitation.root] is zero throughout the run",
        ),
        (
            SIGNAL,
            'type = "table", values = [[0, 0], [5, 1], [20, 0]]',
            "reaches to 20 s, the run to 0.02 s: are its times in s",
        ),
        (
            "[time]",
            '[[connector]]\ntype = "play"\nnodes = ["TIP_LOWER", "TIP_UPPER"]\ndof = "z"\nlower = 0.1\nstiffness = 10\n[time]',
            "connector 1 is squeezed by 0.1 mm where the model is at rest, as 0 lies outside its limits: it presses with 1 N at once",
        ),
        (
            "step = 5e-4",
            "step = 5e-3",
            "is 3.3 steps in a period of the highest excitation frequency, 60 Hz: the periods",
        ),
        ("[time]", "[damping]\nmodal = 0.5\n[time]", "modal = 0.5 is 50 % of critical; 0.005 is 0.5 %"),
        (
            "[time]",
            "[damping.rayleigh]\nalpha = 2e-6\nbeta = 5.0\n[time]",
            "is 9.4e+02 times critical at 60 Hz: are the two",
        ),
    ],
)
def test_what_a_study_can_hardly_mean(tmp_path, old, new, words):
    """At 60 Hz beta = 5 s is pi 60 5 = 942 times critical; a step of 5 ms is 1 / (60 0.005) of a period."""
    assert old in SHORT
    found = warned(tmp_path, SHORT.replace(old, new))
    assert len(found) == 1
    assert words in found[0]


def test_a_force_of_zero_is_told_by_its_own_name(tmp_path):
    force = '[excitation.push]\nnode_set = "TIP_UPPER"\ndof = "z"\nkind = "force"\n'
    found = warned(tmp_path, f"{SHORT}\n{force}signal = {{ type = 'step', amplitude = 0 }}\n")
    assert found == ["[excitation.push] is zero throughout the run: look at its amplitude and times"]


def test_a_force_on_what_is_held_or_driven_is_told(tmp_path):
    force = (
        '[excitation.push]\nnode_set = "{}"\ndof = "z"\nkind = "force"\nsignal = {{ type = "step", amplitude = 1 }}\n'
    )
    for nodes in ("ROOT_UPPER", "ROOT_LOWER"):
        (found,) = warned(tmp_path, f"{SHORT}\n{force.format(nodes)}")
        assert found.startswith("[excitation.push] is a force where the model is held or its motion prescribed")
    assert warned(tmp_path, f"{SHORT}\n{force.format('TIP_LOWER')}") == []


def test_nothing_drives(tmp_path):
    deck = two_strips().replace("ROOT_UPPER, 1, 2\n", "ROOT_UPPER, 1, 3\n")
    study = SHORT[: SHORT.index("[excitation")] + SHORT[SHORT.index("[reduction]") :]
    assert warned(tmp_path, study, deck) == ["nothing drives the model: the study has no [excitation]"]


def test_ten_steps_in_a_period_and_the_usual_damping_are_no_mistake(tmp_path):
    study = SHORT.replace("step = 5e-4", "step = 1e-3").replace("f_max = 60", "f_max = 100")
    assert warned(tmp_path, study + "\n[damping]\nmodal = 0.2\n") == []


def test_a_strongly_warped_shell_is_named(tmp_path):
    """A decimal point one place off: one corner of four squares of 10 mm is 15.75 mm too high.

    Their mean planes lean, with normals (0.526, 0.526, 0.668): 15.75 0.668 / 4 = 2.63 mm off, of 12.2 mm, is 21.5 %.
    """
    deck = two_strips().replace("15, 10.000000, 10.000000, 1.750000", "15, 10.000000, 10.000000, 17.500000")
    (found,) = (w for w in warned(tmp_path, deck=deck) if "warped" in w)
    assert "its corners lie 22 % of its size off their mean plane" in found
    # The node belongs to four shells.
    assert found.startswith("4 four-node shell(s) are strongly warped")


def test_modulus_in_gpa(tmp_path):
    found = warned(tmp_path, deck=two_strips().replace("210000., 0.3", "210., 0.3"))
    assert found[0].startswith("material STEEL (E = 210, density = 7.85e-09) would carry sound at 164 m/s in mm-t-s")


def test_a_first_look_at_forced_steps_and_at_a_deck(creak, tmp_path):
    """--quick changes what there is to change: neither steps that the study forces, nor a deck's own."""
    _, warnings = run(creak, tmp_path, None, SHORT, "--quick")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert list(summary["runs"]) == ["reference"]
    assert summary["changes"] == {"reference.run": "none"}
    assert not any("accuracy" in w for w in warnings)
    deck = tmp_path / "own.inp"
    deck.write_text(stop_deck(step=STEP.replace("1.E-5", "1.E-4")), encoding="utf-8")
    assert creak("run", deck, "--quick", "--out", tmp_path / "own").status == 0


def test_a_deck_with_the_ending_of_another_format_is_told_its_name(creak, tmp_path):
    (tmp_path / "strips.bdf").write_text(two_strips())
    said = creak("info", tmp_path / "strips.bdf")
    said.refuses("begins with *HEADING, as an Abaqus deck does", "Rename it to strips.inp")
    (tmp_path / "plate.inp").write_text(nastran_strips())
    said = creak("new", tmp_path / "plate.inp")
    said.refuses("as a Nastran deck does", "Rename it to plate.bdf")


def test_a_name_that_is_nearly_right(creak, tmp_path):
    study = write_strips(tmp_path)
    assert "Did you mean 'study.toml'?" in creak("run", study.with_name("stdy.toml")).err
    assert "Check the path." in creak("run", study.with_name("other.toml")).err
    said = creak("new", tmp_path / "strips.inp", "--units", "mm").words
    assert "Invalid value for '--units': 'mm' is not one of 'mm-t-s', 'm-kg-s'" in said


def test_a_study_is_no_deck(creak, tmp_path):
    said = creak("info", write_strips(tmp_path))
    said.refuses("is a study; expected a deck")


def test_a_deck_without_a_step_is_told_of_creak_new(creak, tmp_path):
    write_strips(tmp_path)
    said = creak("run", tmp_path / "strips.inp")
    said.refuses("`creak new DECK`")
