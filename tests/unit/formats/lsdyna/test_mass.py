"""Mass of shells with a thickness of their own, of beams and trusses, by closed form."""

from __future__ import annotations

import math

import pytest

from creak.errors import InputError
from creak.formats.lsdyna.reader import read_lsdyna
from helpers_nastran import rigid_mass

NODES = "*NODE\n1,0.,0.,0.\n2,4.,0.,0.\n3,4.,2.,0.\n4,0.,2.,0.\n"
STEEL = "*MAT_ELASTIC\n1,.1,2.1e5,.3\n"


def mass(folder, text):
    path = folder / "deck.k"
    path.write_text(f"*KEYWORD\n{NODES}{text}{STEEL}*END\n", encoding="utf-8")
    return rigid_mass(read_lsdyna(path))[0, 0]


@pytest.mark.parametrize("own", ["2.,2.,2.,2.", "1.,2.,3.,2."])
def test_a_mass_per_area_is_that_of_the_section_whatever_the_thickness(tmp_path, own):
    """(rho t + MAREA) A with the mean thickness 2 of the element, not T1 = 1."""
    text = f"*ELEMENT_SHELL_THICKNESS\n1,1,1,2,3,4\n{own}\n*PART\nplate\n1,1,1\n*SECTION_SHELL\n1,16\n1.,1.,1.,1.,,.3\n"
    assert mass(tmp_path, text) == pytest.approx((0.1 * 2.0 + 0.3) * 8.0)


@pytest.mark.parametrize("option", ["THICKNESS", "BETA", "MCID"])
def test_thicknesses_of_an_element_stand_before_its_angle_or_system(tmp_path, option):
    """The same line with all three options: rho t A with t = 2, not T1 = 1; blank and zero leave the section's."""
    text = f"*ELEMENT_SHELL_{option}\n1,1,1,2,3,4\n2.,2.,2.,2.,0\n*PART\nplate\n1,1,1\n*SECTION_SHELL\n1,16\n1.\n"
    assert mass(tmp_path, text) == pytest.approx(0.1 * 2.0 * 8.0)
    assert mass(tmp_path, text.replace("2.,2.,2.,2.,0", "0.,,,,30")) == pytest.approx(0.1 * 8.0)


def beam(form, size, nsm):
    return f"*ELEMENT_BEAM\n1,1,1,2,3\n*PART\nbar\n1,1,1\n*SECTION_BEAM\n1,{form},,,,,{nsm}\n{size}\n"


@pytest.mark.parametrize(("form", "size", "area"), [(1, "1.5,1.5,2.,2.", 3.0), (2, "3.,1.,1.,1.", 3.0), (3, "3.", 3.0)])
def test_a_mass_per_length_of_beams_and_trusses(tmp_path, form, size, area):
    """(rho A + NSM) L."""
    assert mass(tmp_path, beam(form, size, 0.7)) == pytest.approx((0.1 * area + 0.7) * 4.0)


def test_spot_welds_have_no_mass_per_length(tmp_path):
    """rho pi d^2/4 L, and a note."""
    assert mass(tmp_path, beam(9, "2.,2.", 0.7)) == pytest.approx(0.1 * math.pi * 4.0)
    (note,) = read_lsdyna(tmp_path / "deck.k").unread
    assert (note.keyword, note.changes_answer) == ("*SECTION_BEAM, NSM", False)


def test_a_negative_mass_per_length_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"field 7 of \*SECTION_BEAM is '-1'; expected NSM"):
        mass(tmp_path, beam(3, "3.", -1))
