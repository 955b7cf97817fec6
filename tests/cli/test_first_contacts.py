"""Mistakes of a first contact, of first amounts and sections: each is one message with its cure."""

from __future__ import annotations

import numpy as np
import pytest

from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.studies.warned import warnings_of
from helpers_decks import STUDY, strip, two_strips, write_strips

NODES = STUDY.replace("surface-to-surface", "node-to-surface")
TURNED = two_strips().replace("LOWER, SPOS", "LOWER, SNEG")


def warned(folder, study=STUDY, deck=None):
    """What setting up a study warns of."""
    return warnings_of(set_up(read_study(write_strips(folder, deck, study))).notes)


def refused(creak, folder, study=STUDY, deck=None):
    """The one message of a study that is not run."""
    said = creak("run", write_strips(folder, deck, study), "--out", folder / "out")
    assert said.status == 2
    assert not (folder / "out").exists()
    (line,) = said.err.strip().splitlines()
    return line


@pytest.mark.parametrize(
    ("deck", "study", "cure"),
    [
        (TURNED, STUDY, "the sides (SPOS, SNEG) of the surfaces"),
        (two_strips().replace("UPPER, SNEG", "UPPER, SPOS"), STUDY, "the sides (SPOS, SNEG) of the surfaces"),
        (None, STUDY.replace("[excitation", "normal = [0, 0, -1]\n\n[excitation", 1), "the sense of the normal"),
    ],
)
def test_surfaces_that_look_away_are_refused_with_their_sides(creak, tmp_path, deck, study, cure):
    text = refused(creak, tmp_path, study, deck)
    assert "study.toml:6 [contact.tip]: surfaces 'UNDER' and 'OVER' never face each other" in text
    assert cure in text


def test_a_main_surface_that_looks_away_from_nodes_is_refused(creak, tmp_path):
    """3 mm: the gap of 0.5 mm and the thickness of both strips, 2.5 mm, but the other way."""
    text = refused(creak, tmp_path, NODES, TURNED)
    assert "starts 3 mm inside the main surface" in text
    assert "Does the main surface name the side (SPOS or SNEG) that looks at the secondary one?" in text


def test_a_clearance_does_not_hide_a_main_surface_that_looks_away(tmp_path):
    """The gaps are as given, and grow where the parts come nearer."""
    (text,) = warned(tmp_path, NODES.replace("[excitation", "clearance = 0.2\n\n[excitation", 1), TURNED)
    assert text.startswith("[contact.tip] 39 of 39 nodes lie up to 3 mm behind the main surface")
    assert "holds parts together instead of apart" in text
    assert warned(tmp_path, NODES.replace("[excitation", "clearance = 0.2\n\n[excitation", 1)) == []


def test_a_secondary_side_much_coarser_than_the_main_one_is_told(tmp_path):
    """Elements 10 mm wide over those of 2.5 mm; over those of 5 mm it is left alone."""

    def lower(n):
        own = strip(1001, 1001, "LOWER", 0.0)
        assert own in two_strips()
        deck = two_strips().replace(own, strip(1001, 1001, "LOWER", 0.0, n))
        return deck.replace("1039, 39, 1013, 13", f"{1001 + n}, 13")

    study = STUDY.replace('pairs = "PAIRS"\n', "")
    (text,) = warned(tmp_path, study, lower(48))
    assert text.startswith(
        "[contact.tip] the elements of its secondary side 'UNDER' are 4 times as wide as those of 'O"
    )
    assert 'swap them (secondary = "OVER", main = "UNDER"), or mesh' in text
    swapped = study.replace("UNDER", "X").replace("OVER", "UNDER").replace('"X"', '"OVER"')
    assert warned(tmp_path, swapped, lower(48)) == []
    assert warned(tmp_path, study, lower(24)) == []


def test_a_contact_on_driven_nodes_is_told(tmp_path):
    (text,) = warned(tmp_path, STUDY.replace('"ROOT_UPPER"', '"TIP_UPPER"'))
    assert text.startswith("[excitation.root] moves 3 node(s) of a contact along its normal, the first 13")
    assert "push these by a force" in text


@pytest.mark.parametrize(
    ("clearance", "words"),
    [
        (0.0003, "is less than surfaces are rough: is it in mm, as [model] units = 'mm-t-s' says? 0 says that"),
        (50.0, "clearance = 50 mm is 41 % of the model's size: is it in mm"),
        (0.0, ""),
        (0.3, ""),
    ],
)
def test_clearances_in_other_units_are_told(tmp_path, clearance, words):
    """The strips are 121.7 mm across."""
    found = warned(tmp_path, STUDY.replace("[excitation", f"clearance = {clearance}\n\n[excitation", 1))
    assert [words in text for text in found] == ([True] if words else [])


def test_a_clearance_larger_than_the_model_is_refused(creak, tmp_path):
    text = refused(creak, tmp_path, STUDY.replace("[excitation", "clearance = 300\n\n[excitation", 1))
    assert (
        "study.toml:11 [contact.tip.clearance]: clearance = 300 mm is more than the whole model, 122 mm across" in text
    )


@pytest.mark.parametrize(
    ("kind", "amplitude", "told"),
    [
        ("displacement", 0.05, False),
        ("displacement", 50.0, True),
        ("acceleration", 2000.0, False),
        ("acceleration", 1.0, True),
        ("acceleration", 2e6, True),
    ],
)
def test_vibration_in_other_units_is_told(tmp_path, kind, amplitude, told):
    """12 sines to 60 Hz: of 50 mm they are 7 km/s^2 each at the highest, of 1 mm/s^2 0.012 m/s^2 together at most."""
    study = STUDY.replace('kind = "displacement"', f'kind = "{kind}"').replace("= 0.05,", f"= {amplitude},")
    found = [text for text in warned(tmp_path, study) if "accelerates by" in text]
    assert len(found) == told
    assert all("are its amounts in mm and s, as [model] units = 'mm-t-s' says?" in text for text in found)


@pytest.mark.parametrize(
    ("kind", "signal", "away"),
    [
        ("acceleration", 'type = "sine", frequency = 20.0, amplitude = 5000.0', 5000.0 / (40.0 * np.pi)),
        ("velocity", 'type = "sine", frequency = 20.0, amplitude = 40.0', 2.0 * 40.0 / (40.0 * np.pi)),
        ("acceleration", 'type = "multisine", f_min = 20.0, f_max = 20.0, amplitude = 5000.0, period = 1.0', None),
        ("displacement", 'type = "sine", frequency = 20.0, amplitude = 0.3', None),
    ],
)
def test_a_vibration_that_carries_its_supports_away_is_told(tmp_path, kind, signal, away):
    """From rest the integrals of A sin(w t) go A / w (t - sin(w t) / w) away, and A / w (1 - cos(w t)): at t = 1 s."""
    other = STUDY.replace('kind = "displacement"', f'kind = "{kind}"').replace("periods = 2", "end = 1.0")
    study = "\n".join(f"signal = {{ {signal} }}" if "signal =" in line else line for line in other.splitlines())
    found = [text for text in warned(tmp_path, study) if "carries its nodes" in text]
    assert [text.split(" mm away", 1)[0] for text in found] == (
        [] if away is None else [f"[excitation.root] carries its nodes {away:.3g}"]
    )


def test_a_model_without_damping_is_told(tmp_path):
    bare = two_strips().replace("*DAMPING, ALPHA=5.0, BETA=2.0e-6\n", "")
    (text,) = warned(tmp_path, deck=bare)
    assert text.startswith("nothing is damped")
    assert "damping.modal = 0.02" in text
    assert warned(tmp_path, STUDY + "\n[damping]\nmodal = 0\n", bare) == []


@pytest.mark.parametrize(
    ("thickness", "words"),
    [
        ("", "*SHELL SECTION has no data line; expected a line with the thickness. Add it"),
        ("0.0,", "shell thickness is 0.0; expected a number greater than zero"),
        ("-1.0,", "shell thickness is -1.0; expected a number greater than zero"),
    ],
)
def test_shells_without_thickness_are_refused(creak, tmp_path, thickness, words):
    old = "*SHELL SECTION, ELSET=UPPER, MATERIAL=STEEL\n1.0,\n"
    new = old.replace("1.0,\n", f"{thickness}\n" if thickness else "")
    deck = two_strips().replace(old, new)
    assert deck != two_strips()
    text = refused(creak, tmp_path, STUDY, deck)
    assert words in text
    assert "strips.inp:" in text


def test_elements_without_a_section_are_refused(creak, tmp_path):
    deck = two_strips().replace("*SHELL SECTION, ELSET=UPPER, MATERIAL=STEEL\n1.0,\n", "")
    text = refused(creak, tmp_path, STUDY, deck)
    assert "24 elements of type S4 have no section" in text
    assert "Add *SHELL SECTION for them" in text
