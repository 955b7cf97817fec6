"""Blank lines are cards of defaults, also at the end of a keyword; beyond its records they are nothing."""

from __future__ import annotations

import pytest

from creak.errors import InputError
from creak.formats.lsdyna.reader import read_lsdyna
from helpers_nastran import rigid_mass

NODES = "*NODE\n1,0.,0.,0.\n2,4.,0.,0.\n3,4.,2.,0.\n4,0.,2.,0.\n5,9.,0.,0.\n"
PLATE = "*ELEMENT_SHELL\n1,1,1,2,3,4\n*PART\nplate\n1,1,1\n*SECTION_SHELL\n1,16\n1.5\n*MAT_ELASTIC\n1,.1,2.1e5,.3\n"
SPRING = "*ELEMENT_DISCRETE\n1,2,2,5\n*PART\nclip\n2,2,2\n*SECTION_DISCRETE\n2\n\n*MAT_SPRING_ELASTIC\n2,10.\n"
THICKNESS = PLATE.replace("SHELL\n1,1,1,2,3,4\n", "SHELL_THICKNESS\n1,1,1,2,3,4\n\n", 1)
RIGID = PLATE.replace("MAT_ELASTIC\n1,.1,2.1e5,.3\n", "MAT_RIGID\n1,.1,2.1e5,.3\n\n\n7,.1,2.1e5,.3\n\n\n")
CONTACT = PLATE.replace("*PART\nplate\n1,1,1\n", "*PART_CONTACT\nplate\n1,1,1\n\n")
BODY = PLATE + "*CONSTRAINED_NODAL_RIGID_BODY_SPC\n9,,5\n\n*SET_NODE_LIST\n5\n3,4\n"
SPARE = PLATE.replace("*", "\n  \n*").lstrip()


def read(folder, text):
    path = folder / "deck.k"
    path.write_text(f"*KEYWORD\n{NODES}{text}*END\n", encoding="utf-8")
    return read_lsdyna(path)


@pytest.mark.parametrize("text", [THICKNESS, RIGID, CONTACT, BODY, SPARE, f"{PLATE}{SPRING}"])
def test_a_blank_last_card_is_one_of_defaults(tmp_path, text):
    """rho t A of the shell whose card is blank, or stands beside such a card."""
    model = read(tmp_path, text)
    assert rigid_mass(model)[0, 0] == pytest.approx(0.1 * 1.5 * 8.0)
    assert model.unread == ()


def test_a_missing_card_is_still_missing(tmp_path):
    with pytest.raises(InputError, match=r"\*SECTION_DISCRETE has 1 data lines; expected 2 lines"):
        read(tmp_path, PLATE + SPRING.replace("2\n\n*MAT", "2\n*MAT"))
    with pytest.raises(InputError, match=r"\*MAT_RIGID has 5 data lines; expected 3 lines"):
        read(tmp_path, RIGID[:-1])
