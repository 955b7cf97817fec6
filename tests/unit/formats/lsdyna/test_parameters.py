"""*PARAMETER: values by name in the fields of cards, of a deck and of what it includes."""

from __future__ import annotations

import re

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.lsdyna.reader import read_lsdyna

HEAD = """*KEYWORD
*PARAMETER
R width   2.0       I eid     7         Rlow      -.5
$ comments stay out
*PARAMETER_EXPRESSION
Rheight   &width*3/
          2 + max(low, 0)
I half    eid/2
I whole   nint(&eid/2.0)
R half_r  7/2.0
"""
PLATE = """*NODE
&half   ,0.,0.,0.
2,&width,0.,0.
&whole,&Width,&height,0.
5,0.,&height,-&low
*ELEMENT_SHELL
    &eid       1 &half         2  &whole       5
*PART
plate
1,1,1
*SECTION_SHELL
1,2
&half_r
*MAT_ELASTIC
1,7.8e-9,2.1e5,.3
"""


def read(folder, text, **more):
    for name, other in more.items():
        (folder / f"{name}.k").write_text(other)
    path = folder / "deck.k"
    path.write_text(text)
    return read_lsdyna(path)


def test_names_stand_for_their_values(tmp_path):
    """7/2 is 3 of integers, 2.0*3/2 is 3; fields are cut before the names give way to longer numbers."""
    model = read(tmp_path, HEAD + PLATE)
    assert not model.unread
    assert model.nodes.ids.tolist() == [3, 2, 4, 5]
    np.testing.assert_array_equal(model.nodes.coords[2:], [[2.0, 3.0, 0.0], [0.0, 3.0, 0.5]])
    (block,) = model.blocks
    assert block.ids.tolist() == [7]
    assert block.section.thickness == 3.5


def test_included_files_are_shifted_by_names_and_keep_local_ones(tmp_path):
    """Each file has its own `width`; the one of the deck is known in both."""
    own = "*PARAMETER_LOCAL\nR  z,{z}\n*NODE\n1,&z,&width\n"
    moved = "*INCLUDE_TRANSFORM\n{name}.k\n&{by}\n"
    text = (
        HEAD + "*PARAMETER\nI one,100,I two,200\n" + moved.format(name="a", by="one") + moved.format(name="b", by="two")
    )
    model = read(tmp_path, text + PLATE, a=own.format(z=8.0), b=own.format(z=9.0))
    at = dict(zip(model.nodes.ids.tolist(), model.nodes.coords.tolist(), strict=True))
    assert at[101] == [8.0, 2.0, 0.0]
    assert at[201] == [9.0, 2.0, 0.0]


def test_local_names_are_known_below_their_file_and_integers_stay_integers(tmp_path):
    """The section of an included file has the local value; 2**3/3 and mod(7,4)/2 are 2 and 1 of integers."""
    head = "*PARAMETER\nR half_r  1.0\n*PARAMETER_LOCAL\nR half_r  5.0\n*PARAMETER_EXPRESSION\nI a       2**3/3\nI b       mod(7,4)/2\n"
    section = "*SECTION_SHELL\n1,2\n&half_r\n"
    plate = PLATE.replace(section, "*INCLUDE\nsub.k\n")
    assert plate != PLATE
    text = HEAD.replace("R half_r  7/2.0\n", "") + head + plate + "*NODE\n50,&a,&b,0.\n"
    model = read(tmp_path, text, sub=section)
    assert model.blocks[0].section.thickness == 5.0
    assert model.nodes.coords[model.nodes.ids.tolist().index(50)].tolist() == [2.0, 1.0, 0.0]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("    &eid       1", "   &eidd       1", "&eidd has no value"),
        ("R width ", "  width ", "has 'width' for the name of a parameter; expected R, I or C, and a name"),
        ("Rlow      -.5", "Rlow      abc", "&low = 'abc': key error; expected numbers, names of parameters above"),
        ("I half    eid/2", "I half    &eid/2.0", "&half = &eid/2.0 is 3.5; expected a whole number"),
        ("I half    eid/2", "I width   1", "&width has two values, 2.0 and 1"),
        ("max(low, 0)", "__import__(low)", "key error"),
        ("max(low, 0)", "1/0", "zerodivision error"),
        ("R half_r  7/2.0", "R half_r", "syntax error"),
    ],
)
def test_what_is_wrong_is_told_with_its_line(tmp_path, old, new, said):
    text = (HEAD + PLATE).replace(old, new, 1)
    assert new in text
    line = next(i for i, row in enumerate(text.split("\n"), start=1) if new in row)
    start = f"{tmp_path / 'deck.k'}:{line if 'max' not in old else line - 1}:"
    with pytest.raises(InputError, match=f"^{re.escape(start)}.*{re.escape(said)}"):
        read(tmp_path, text)
