"""`creak new`: the study that it writes runs as it is, or says what is to be filled in."""

from __future__ import annotations

import json
import re
import tomllib

import pytest

from creak.contact import surface_to_surface
from creak.formats import decks
from creak.formats.decks import read_model
from creak.studies.file.reader import read_study
from creak.studies.prepare import setup as preparing
from creak.studies.prepare.setup import set_up
from creak.studies.propose.proposal import propose
from creak_thesis.door import write_door
from helpers_decks import strip, two_strips
from helpers_nastran_strips import strips
from helpers_ties import sections, sheet

pytestmark = pytest.mark.usefixtures("no_page")


def new(creak, folder, deck, *more, name="strips.inp"):
    """What is told for machines, and the study as tables."""
    (folder / name).write_text(deck)
    said = creak("new", folder / name, "--json", *more).done()
    told = json.loads(said.out)
    return told, tomllib.loads((folder / "strips.toml").read_text())


def test_structural_damping_of_the_deck_gets_a_damping_of_the_study(creak, tmp_path):
    told, study = new(creak, tmp_path, two_strips().replace("*DENSITY", "*DAMPING, STRUCTURAL=.04\n*DENSITY"))
    assert told["ready"] is True
    assert study["damping"] == {"modal": 0.02}
    assert "creak does not read *DAMPING, STRUCTURAL of the deck" in (tmp_path / "strips.toml").read_text()


def test_two_strips(creak, tmp_path):
    """Everything is in the deck: surfaces 0.5 mm apart, a root held but in z, pairs of nodes in turn."""
    told, study = new(creak, tmp_path, two_strips())
    assert told["ready"] is True
    assert told["units"] == study["model"]["units"] == "mm-t-s"
    (contact,) = told["contacts"]
    assert (contact["secondary"], contact["main"], contact["channels"]) == ("UNDER", "OVER", 39)
    assert contact["gap"] == pytest.approx(0.5, abs=1e-9)
    assert contact["start"] == pytest.approx(0.5, abs=1e-9)
    assert study["contact"]["upper-lower"]["secondary"] == "UNDER"
    assert told["excitation"]["node_set"] == study["excitation"]["road"]["node_set"] == "ROOT_UPPER"
    assert (study["excitation"]["road"]["dof"], study["excitation"]["road"]["kind"]) == ("z", "displacement")
    assert study["verification"]["pairs"] == "PAIRS"
    assert study["reduction"]["f_max"] == "auto"
    assert (study["time"]["accuracy"], study["reference"]["run"]) == ("settled", "spots")
    setup = set_up(read_study(tmp_path / "strips.toml"))
    assert setup.contacts.m == 39


def test_two_names_of_the_same_nodes_are_one_output_and_a_node_without_elements_is_no_place_to_push(creak, tmp_path):
    more = "*NSET, NSET=TIP\n13,\n*NSET, NSET=END\n13,\n*NODE, NSET=LOOSE\n9001, 0., 0., 50.\n"
    told, study = new(creak, tmp_path, two_strips() + more)
    assert [name for name in study["output"]["nodes"] if name in ("TIP", "END", "LOOSE")] == ["END"]
    assert "LOOSE" not in (tmp_path / "strips.toml").read_text()
    assert told["ready"] is True


def test_a_contact_is_searched_once_and_the_deck_is_read_once(creak, tmp_path, monkeypatch):
    """The check of the study that is written takes what the proposal has found."""
    done = []
    for home, name in ((surface_to_surface, "_searched"), (preparing, "read_model"), (decks, "read_model")):
        real = getattr(home, name)
        monkeypatch.setattr(home, name, lambda *x, real=real: done.append(real.__name__) or real(*x))
    new(creak, tmp_path, two_strips())
    assert sorted(done) == ["_searched", "read_model"]


def test_comments_explain_it_the_schema_lies_beside_it_and_it_runs_as_it_is(creak, tmp_path):
    new(creak, tmp_path, two_strips())
    path = tmp_path / "strips.toml"
    text = path.read_text()
    assert text.startswith("#:schema ./creak-study.schema.json\n")
    for words in (
        "# UNDER and OVER: 0.5 mm apart at node",
        "# 39 gap channels, open by 0.5 mm or more",
        "nearer than 1.22 mm",
        "ROOT_LOWER: x y z rx ry rz",
        "leaves z free",
        "# Hz",
    ):
        assert words in text
    assert "creak convert OUT/results.h5 motion.pvd" in text
    path.write_text(text.replace("periods = 5", "end = 0.03").replace("spots", "none"))
    assert creak("run", path, "--quiet", "--out", tmp_path / "out").status == 0
    jsonschema = pytest.importorskip("jsonschema", reason="pip install jsonschema")
    schema = json.loads((tmp_path / "creak-study.schema.json").read_text())
    jsonschema.validate(tomllib.loads(text), schema)


def without_contact(creak, folder, deck, *more):
    """What is to be filled in where no contact of the study is live: it is nothing to run next."""
    told, study = new(creak, folder, deck, *more)
    assert "contact" not in study
    assert told["ready"] is False
    said = creak("new", folder / "strips.inp", "--overwrite", *more).out
    assert "next:" not in said
    assert f"to be filled in before it runs: {told['to_fill_in']}" in " ".join(said.split())
    assert "# To be filled in before it runs: no contact" in (folder / "strips.toml").read_text()
    return told["to_fill_in"]


def test_a_study_without_contact_is_nothing_to_run_next(creak, tmp_path):
    text = without_contact(creak, tmp_path, two_strips(gap=4.0))
    assert text.startswith(
        "no contact: no surfaces of two parts come within 1.22 mm of each other; fill in a [contact."
    )
    text = (tmp_path / "strips.toml").read_text()
    assert "The nearest nodes are those of UPPER and LOWER: 5.25 mm" in text  # 4 mm and half of both thicknesses


def test_a_part_between_two_others_keeps_them_apart(creak, tmp_path):
    """A third strip lies on the upper one, nearer to the lower one than the distance."""
    third = strip(2001, 2001, "TOP", 3.0) + "*SHELL SECTION, ELSET=TOP, MATERIAL=STEEL\n1.0,\n"
    deck = two_strips().replace("*BOUNDARY\n", f"{third}*BOUNDARY\nROOT_TOP, 1, 6\n", 1)
    told, _ = new(creak, tmp_path, deck, "--distance", 5)
    assert {frozenset(c["name"].split("-")) for c in told["contacts"]} == {
        frozenset(("lower", "upper")),
        frozenset(("upper", "top")),
    }


def test_distance_decides_what_is_near(creak, tmp_path):
    told, _ = new(creak, tmp_path, two_strips(gap=4.0), "--distance", 5)
    assert [c["channels"] for c in told["contacts"]] == [39]
    assert told["contacts"][0]["gap"] == pytest.approx(4.0, abs=1e-9)


SCREWS = "*ELEMENT, TYPE=B31, ELSET=SCREWS\n5001, 13, 1013\n5002, 39, 1039\n"
ROUND = "*BEAM SECTION, SECTION=CIRC, ELSET=SCREWS, MATERIAL=STEEL\n1.\n0., 1., 0.\n"
SECTIONS = "*SHELL SECTION, ELSET=UPPER, MATERIAL=STEEL\n1.0,\n*SHELL SECTION, ELSET=LOWER, MATERIAL=STEEL\n1.5,\n"
ONE = "*ELSET, ELSET=BOTH\nUPPER, LOWER\n*SHELL SECTION, ELSET=BOTH, MATERIAL=STEEL\n1.25,\n"


@pytest.mark.parametrize("sections", [SECTIONS, ONE])
def test_plates_that_beams_alone_join_may_hit_each_other(creak, tmp_path, sections):
    """They are one part of the deck, of one section or of two."""
    deck = two_strips().replace(SECTIONS, f"{sections}{SCREWS}{ROUND}")
    told, study = new(creak, tmp_path, deck)
    (contact,) = told["contacts"]
    assert (contact["secondary"], contact["main"], contact["channels"]) == ("UNDER", "OVER", 39)
    assert contact["gap"] == pytest.approx(0.5, abs=1e-9)
    assert list(study["contact"]) == ["upper-lower"]
    assert told["joints"] == ["2 beam element(s) between LOWER and UPPER, first at nodes 1013 and 13"]
    assert set_up(read_study(tmp_path / "strips.toml")).contacts.m == 39


SURFACES = "*SURFACE, NAME=UNDER\nUPPER, SNEG\n*SURFACE, NAME=OVER\nLOWER, SPOS\n"
AWAY = "*SURFACE, NAME=ABOVE\nUPPER, SPOS\n*SURFACE, NAME=BELOW\nLOWER, SNEG\n"


@pytest.mark.parametrize(("surfaces", "named"), [(AWAY + SURFACES, "UNDER OVER"), (AWAY, "UPPER LOWER")])
def test_surfaces_that_look_away_are_passed_over(creak, tmp_path, surfaces, named):
    """The first surfaces of the deck are the backs of both strips; the element sets touch with either side."""
    told, _ = new(creak, tmp_path, two_strips().replace(SURFACES, surfaces))
    assert [f"{c['secondary']} {c['main']}" for c in told["contacts"]] == [named]
    assert told["ready"]
    assert told["contacts"][0]["start"] == pytest.approx(0.5, abs=1e-9)


def test_a_study_whose_only_contact_is_commented_out_is_nothing_to_run_next(creak, tmp_path):
    """Both surfaces look away from each other, and nothing else has a name."""
    deck = re.sub("ELSET=(UPPER|LOWER)", "ELSET=ALL", two_strips())
    first, second = [m.start() for m in re.finditer(r"\*SHELL SECTION", deck)]
    own = "*ELSET, ELSET=_U, GENERATE\n1, 24, 1\n*ELSET, ELSET=_L, GENERATE\n1001, 1024, 1\n"
    away = AWAY.replace("UPPER", "_U").replace("LOWER", "_L")
    deck = (deck[:first] + deck[second:]).replace(SURFACES, own + away)
    text = without_contact(creak, tmp_path, deck)
    assert "is left out, because surfaces 'ABOVE' and 'BELOW'" in text


def test_near_parts_without_names_of_their_own_are_not_called_far(creak, tmp_path):
    deck = re.sub("ELSET=(UPPER|LOWER)", "ELSET=ALL", two_strips())
    deck = deck.replace(SURFACES, "")
    first, second = [m.start() for m in re.finditer(r"\*SHELL SECTION", deck)]
    text = without_contact(creak, tmp_path, deck[:first] + deck[second:])
    assert "the deck has no surface or element set of PART-1 and PART-2 alone" in text
    study = (tmp_path / "strips.toml").read_text()
    assert "PART-1 and PART-2: 0.25 mm apart at node" in study  # both are as thick as the lower strip
    assert "No surfaces" not in study


def test_parts_that_overlap_are_told(creak, tmp_path):
    told, _ = new(creak, tmp_path, two_strips(gap=-0.2))
    assert told["contacts"][0]["gap"] == pytest.approx(-0.2, abs=1e-9)
    assert "0.2 mm inside each other" in (tmp_path / "strips.toml").read_text()
    assert any("start closed" in w for w in told["warnings"])


def test_without_surfaces_the_element_sets_are_named(creak, tmp_path):
    deck = two_strips().replace(SURFACES, "")
    told, _ = new(creak, tmp_path, deck)
    assert (told["contacts"][0]["secondary"], told["contacts"][0]["main"]) == ("UPPER", "LOWER")
    assert told["ready"]


def test_the_set_that_fits_best_is_named(creak, tmp_path):
    """The rooted half of the upper strip stands high above the lower one: the set of the other half fits better."""
    deck = two_strips().replace(SURFACES, "")
    far = deck.replace(
        "*NSET, NSET=PAIRS", "*ELSET, ELSET=NEAR\n7, 8, 9, 10, 11, 12, 19, 20, 21, 22, 23, 24\n*NSET, NSET=PAIRS"
    )
    lines = far.splitlines()
    for i, line in enumerate(lines):
        cells = line.split(", ")
        if len(cells) == 4 and cells[3] == "1.750000" and float(cells[1]) < 60.0:
            lines[i] = ", ".join([*cells[:3], "21.75"])
    told, _ = new(creak, tmp_path, "\n".join(lines) + "\n")
    assert [{c["secondary"], c["main"]} for c in told["contacts"]] == [{"NEAR", "LOWER"}]


def test_a_part_that_floats_is_to_be_held(creak, tmp_path):
    told, _ = new(creak, tmp_path, two_strips().replace("ROOT_LOWER, 1, 6\n", ""))
    assert told["ready"] is False
    assert "nothing holds part(s) LOWER" in told["to_fill_in"]
    assert "# To be filled in before it runs: " in (tmp_path / "strips.toml").read_text()
    said = creak("new", tmp_path / "strips.inp", "--overwrite")
    assert "to be filled in before it runs: " in said.out


def test_a_deck_without_supports(creak, tmp_path):
    deck = two_strips().partition("*BOUNDARY")[0]
    told, _ = new(creak, tmp_path, deck)
    assert not told["ready"]
    assert "the deck holds nothing" in (tmp_path / "strips.toml").read_text()


def test_all_supports_are_shaken_though_a_set_is_free(creak, tmp_path):
    """The road comes in at supports; a force on the free set is told beside."""
    told, study = new(creak, tmp_path, two_strips() + "ROOT_UPPER, 3\n")
    assert told["ready"]
    assert study["excitation"]["road"]["kind"] == "displacement"
    assert study["support"]["road"]["free"] == ["z"]
    text = (tmp_path / "strips.toml").read_text(encoding="utf-8")
    assert re.search(r"# As well: TIP_(UPPER|LOWER), by a force\.", text)


def test_what_stands_on_springs_is_shaken_by_the_ground_below_them(creak, tmp_path):
    """Moving the free end of a spring to ground would leave the spring nothing to do."""
    ground = "*NODE, NSET=GROUND\n9001, 0., 0., 50.\n9014, 0., 10., 50.\n9027, 0., 20., 50.\n"
    springs = (
        "*ELEMENT, TYPE=SPRINGA, ELSET=FEET\n9101, 1, 9001\n9102, 14, 9014\n9103, 27, 9027\n*SPRING, ELSET=FEET\n\n5.\n"
    )
    deck = two_strips().replace("*BOUNDARY\n", f"{ground}{springs}*BOUNDARY\nGROUND, 1, 6\n", 1)
    told, study = new(creak, tmp_path, deck)
    road = study["excitation"]["road"]
    moved = study.get("nodes", {}).get(road["node_set"], {}).get("labels", [])
    assert {9001, 9014, 9027} <= {int(label) for label in moved} or road["node_set"] == "GROUND"
    assert road["kind"] == "displacement"
    assert told["ready"]


def test_a_deck_that_names_nothing_is_shaken_by_all_that_it_holds(creak, tmp_path):
    """Clamped everywhere, as most decks are: the study lets go the normal of the contact and moves all supports."""
    deck = re.sub(r"\*NSET[^\n]*\n[^*]*", "", two_strips() + "ROOT_UPPER, 3\n")
    deck = deck.replace("ROOT_LOWER", "1001").replace("ROOT_UPPER", "1")
    told, study = new(creak, tmp_path, deck)
    assert told["ready"], told["to_fill_in"]
    assert study["nodes"]["SHAKEN"]["labels"] == ["1", "1001"]
    assert study["support"]["road"] == {"nodes": "SHAKEN", "free": ["z"]}
    road = study["excitation"]["road"]
    assert (road["node_set"], road["dof"], road["kind"]) == ("SHAKEN", "z", "displacement")
    setup = set_up(read_study(tmp_path / "strips.toml"))
    assert any("2 dofs of the deck freed" in note for note in setup.notes)
    assert "next:" in creak("new", tmp_path / "strips.inp", "--overwrite").out


def test_a_deck_that_holds_nothing_leaves_the_excitation_open(creak, tmp_path):
    deck = re.sub(r"\*NSET[^\n]*\n[^*]*", "", two_strips()).partition("*BOUNDARY")[0]
    told, study = new(creak, tmp_path, deck)
    assert told["excitation"] is None
    assert "excitation" not in study
    assert "to be filled in" in (tmp_path / "strips.toml").read_text()
    assert not told["ready"], "a study without excitation is nothing to run next"
    assert told["no_excitation"].startswith("the deck has no node set of at most 100 nodes")
    assert "next:" not in creak("new", tmp_path / "strips.inp", "--overwrite").out


def without_sets(deck: str) -> str:
    return re.sub(r"SET \d = [^\n]*\n", "", deck)


def test_a_nastran_deck_without_sets_is_driven_where_its_spc_leaves_a_direction(creak, tmp_path):
    told, study = new(creak, tmp_path, without_sets(strips()), name="strips.bdf")
    assert told["ready"], told["to_fill_in"]
    road = study["excitation"]["road"]
    assert (road["node_set"], road["dof"], road["kind"]) == ("SPC_1.12456", "z", "displacement")
    sets = read_model(tmp_path / "strips.bdf").node_sets
    assert {name: rows.size for name, rows in sets.items()} == {"SPC_1": 6, "SPC_1.123456": 3, "SPC_1.12456": 3}


def test_a_question_tells_the_direction_of_the_shaker_where_no_contact_does(tmp_path):
    """Two sheets in one plane, 1 mm apart: what shakes across z closes nothing."""
    lines = ["*NODE"]
    for first, x0 in ((1, 0.0), (101, 41.0)):
        lines += [f"{first + i + 10 * j}, {x0 + 10.0 * i}, {10.0 * j}, 0." for j in range(2) for i in range(5)]
    for first, name in ((1, "LEFT"), (101, "RIGHT")):
        lines += [f"*ELEMENT, TYPE=S4, ELSET={name}"]
        lines += [f"{n}, {n}, {n + 1}, {n + 11}, {n + 10}" for n in range(first, first + 4)]
        lines += [f"*SHELL SECTION, ELSET={name}, MATERIAL=STEEL", "1."]
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", "210000., .3", "*DENSITY", "7.85e-9"]
    lines += ["*NSET, NSET=HELD", "1, 11, 105, 115", "*BOUNDARY", "HELD, 1, 6", ""]
    (tmp_path / "sheets.inp").write_text("\n".join(lines))
    found = propose(read_model(tmp_path / "sheets.inp"), 3.0, None, lambda *_: None)
    assert found.drive is not None
    assert not any(c.live for c in found.contacts)
    assert found.drive.dof == "x"


def test_a_nastran_deck_that_holds_all_is_shaken_by_its_spc(creak, tmp_path):
    deck = without_sets(strips()).replace("SPC1,1,12456,1", "SPC1,1,123456,1")
    told, study = new(creak, tmp_path, deck, name="strips.bdf")
    assert told["ready"], told["to_fill_in"]
    assert study["support"]["road"] == {"nodes": "SPC_1", "free": ["z"]}
    assert study["excitation"]["road"]["node_set"] == "SPC_1"
    assert told["excitation"]["freed"]


def test_units_are_guessed(creak, tmp_path):
    told, _ = new(creak, tmp_path, two_strips().replace("210000., 0.3", "210., 0.3").replace("7.85e-9", "7.85e-6"))
    assert "mm-kg-ms" in told["units_guess"]
    assert "convert" in told["units_guess"]
    told, _ = new(creak, tmp_path, two_strips(), "--units", "m-kg-s", "--overwrite")
    assert told["units"] == "m-kg-s"
    assert not told["ready"]
    assert 'These figures fit mm-t-s: set [model] units = "mm-t-s"' in told["to_fill_in"]


def test_what_was_not_read_is_told(creak, tmp_path):
    deck = two_strips() + "*EMBEDDED ELEMENT\nUPPER\n"
    told, _ = new(creak, tmp_path, deck)
    assert "--ignore" in told["to_fill_in"]
    assert "*EMBEDDED ELEMENT (" in (tmp_path / "strips.toml").read_text()
    assert new(creak, tmp_path, deck, "--overwrite", "--ignore", "EMBEDDED ELEMENT")[0]["ready"]


def test_a_nastran_deck(creak, tmp_path):
    told, study = new(creak, tmp_path, strips(), name="strips.bdf")
    assert study["model"]["deck"] == "strips.bdf"
    (contact,) = told["contacts"]
    assert contact["channels"] == 39


def test_an_existing_study_is_kept(creak, tmp_path):
    (tmp_path / "strips.inp").write_text(two_strips())
    (tmp_path / "strips.toml").write_text("mine")
    said = creak("new", tmp_path / "strips.inp")
    said.refuses("--overwrite")
    assert (tmp_path / "strips.toml").read_text() == "mine"


@pytest.mark.parametrize(
    ("options", "words"),
    [(["--out", "study.txt"], ".toml"), (["--distance", "0"], "greater than zero"), (["--distance", "nan"], "greater")],
)
def test_wrong_options(creak, tmp_path, options, words):
    (tmp_path / "strips.inp").write_text(two_strips())
    said = creak("new", tmp_path / "strips.inp", *options)
    said.refuses(words)


def test_the_deck_is_named_from_where_the_study_lies(creak, tmp_path):
    (tmp_path / "strips.inp").write_text(two_strips())
    path = tmp_path / "mine" / "first.toml"
    assert creak("new", tmp_path / "strips.inp", "--out", path, "--quiet").status == 0
    assert tomllib.loads(path.read_text())["model"]["deck"] == "../strips.inp"
    assert read_study(path).places.sibling("../strips.inp") == tmp_path / "strips.inp"


def test_the_door_is_found_out(tmp_path):
    """Panel edge against flange, by the names that the door's own study uses."""
    write_door(40.0, tmp_path)
    found = propose(read_model(tmp_path / "door.inp"), 6.0, None, lambda *_: None)
    assert [{c.secondary, c.main} for c in found.contacts] == [{"PANEL_EDGE", "FRAME_FLANGE"}]
    assert (found.pairs, found.units.name, found.n_held) == ("PAIRS", "mm-t-s", 7)
    assert (found.drive.node_set, found.drive.dof, found.drive.kind) == ("C", "z", "displacement")


def test_faces_that_a_tie_joins_are_no_contact(creak, tmp_path):
    sheets = sheet("LOWER", 1, (4, 4), (0.0, 0.0, 0.0), (40.0, 40.0))
    sheets += sheet("UPPER", 10_001, (3, 3), (5.0, 5.0, 2.0), (30.0, 30.0)) + sections("LOWER", "UPPER", thickness=2.0)
    held = "*BOUNDARY\nLOWER_NODES, 1, 6\n"
    assert len(new(creak, tmp_path, sheets + held)[0]["contacts"]) == 1
    (tmp_path / "strips.toml").unlink()
    told, _ = new(creak, tmp_path, sheets + "*TIE, NAME=T\nUPPER_FACE, LOWER_FACE\n" + held)
    assert told["contacts"] == []
    assert any("16 tied node(s)" in joint for joint in told["joints"])
