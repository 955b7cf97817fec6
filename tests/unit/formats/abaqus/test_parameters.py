"""*PARAMETER: values by name in data lines and keyword lines."""

from __future__ import annotations

import pytest

from creak.errors import InputError
from creak.formats.decks import read_model

DECK = """*PARAMETER
# sizes
t = 2.0
side = 10*t/2   # mm
E = 7.0e4
nu = 1/3.
last = int(side/2.5)
name = 'P'
{}
*NODE
1, 0, 0, 0
2, <side>, 0, 0
3, < side >, <side>, 0
<last>, 0, <side>, 0
*ELEMENT, TYPE=S4, ELSET=<name>
1, 1, 2, 3, <last>
*SHELL SECTION, ELSET=P, MATERIAL=M
<t>,
*MATERIAL, NAME=M
*ELASTIC
<E>, <nu>
*DENSITY
2.7e-9
"""


def read(folder, line="", deck=DECK):
    (folder / "a.inp").write_text(deck.format(line))
    return read_model(folder / "a.inp")


def test_values_are_filled_in(tmp_path):
    model = read(tmp_path)
    section = model.blocks[0].section
    assert model.nodes.ids.tolist() == [1, 2, 3, 4]
    assert model.nodes.coords.max() == 10.0
    assert (section.thickness, section.material.youngs_modulus) == (2.0, 7e4)
    assert section.material.poisson_ratio == 1.0 / 3.0
    assert set(model.element_sets) == {"P"}
    assert not model.unread


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("x = __import__('os')", "expected numbers"),
        ("x = (1).__class__", "expected numbers"),
        ("x = [9] * 9", "expected numbers"),
        ("x = 9 ** 9 ** 9 ** 9", "expected numbers"),
        ("x = 1 / 0", "zerodivision error"),
        ("x = missing + 1", "expected numbers"),
        ("x = " + "(" * 300, "expected numbers"),
        ("x = 'a' * 1000000", "expected numbers"),
        ("no assignment", "name = expression"),
    ],
)
def test_what_is_no_expression_of_numbers_is_refused(tmp_path, line, text):
    with pytest.raises(InputError, match=r"a\.inp:9.*" + text):
        read(tmp_path, line)


def test_a_name_without_value_is_told_where_it_stands(tmp_path):
    with pytest.raises(InputError, match=r"a\.inp:18: <thick> is no \*PARAMETER"):
        read(tmp_path, deck=DECK.replace("<t>", "<thick>"))
