"""*DISTRIBUTION: axes and thickness element by element; LAYUP and STACK DIRECTION."""

from __future__ import annotations

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.decks import read_model

SHELLS = """*NODE
1, 0, 0, 0
2, 10, 0, 0
3, 10, 10, 0
4, 0, 10, 0
5, 20, 0, 0
6, 20, 10, 0
*ELEMENT, TYPE=S4, ELSET=P
1, 1, 2, 3, 4
2, 2, 5, 6, 3
*MATERIAL, NAME=M
*ELASTIC, TYPE=LAMINA
1e5, 1e4, 0.3, 5e3, 5e3, 5e3
*DENSITY
1.5e-9
"""
SECTION = "*SHELL SECTION, ELSET=P, MATERIAL=M{}\n2.,\n"
AXES = """*DISTRIBUTION TABLE, NAME=T
COORD3D, COORD3D
*DISTRIBUTION, NAME=D, LOCATION=ELEMENT, TABLE=T
, 1., 0., 0., 0., 1., 0.
2, 0., 1., 0., -1., 0., 0.
*ORIENTATION, NAME=O{}
D
3, {}
"""
THICK = """*DISTRIBUTION TABLE, NAME=T
LENGTH
*DISTRIBUTION, NAME=D, LOCATION=ELEMENT, TABLE=T
, 2.
2, 3.
"""


@pytest.fixture
def read(tmp_path):
    def one(text):
        (tmp_path / "a.inp").write_text(SHELLS + text)
        return read_model(tmp_path / "a.inp")

    return one


@pytest.mark.parametrize("degrees", [0.0, 30.0])
def test_axes(read, degrees):
    model = read(SECTION.format(", ORIENTATION=O") + AXES.format("", degrees))
    (block,) = model.blocks
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    assert block.own.axis1 == pytest.approx(np.array([[c, s, 0.0], [-s, c, 0.0]]), abs=1e-15)
    assert not model.unread


@pytest.mark.parametrize("data", ["2.,\n", ""])
def test_thickness(read, data):
    model = read(SECTION.format(", SHELL THICKNESS=D").replace("2.,\n", data) + THICK)
    (block,) = model.blocks
    assert block.own.thickness * block.section.thickness == pytest.approx(np.array([[2.0] * 4, [3.0] * 4]))
    assert not model.unread


def test_plies_scale_with_it(read):
    text = "*SHELL SECTION, ELSET=P, COMPOSITE, LAYUP=L, SHELL THICKNESS=D\n1., 3, M, 0., Ply-1\n1., 3, M, 90., Ply-2\n"
    (block,) = read(text + THICK).blocks
    assert [p.angle for p in block.section.plies] == pytest.approx([0.0, np.pi / 2])
    assert block.own.thickness[:, 0] == pytest.approx([1.0, 1.5])


def test_a_layup_and_its_stack_direction(read):
    text = "*SHELL SECTION, ELSET=P, COMPOSITE, LAYUP=L, SYMMETRIC, STACK DIRECTION=3\n1., 3, M, 0., Ply-1\n"
    model = read(text)
    assert model.blocks[0].section.thickness == 2.0
    assert not model.unread


def test_a_distribution_in_an_instance_turns_with_it(tmp_path):
    part = SHELLS.split("*MATERIAL")[0] + SECTION.format(", ORIENTATION=O") + AXES.format("", 0.0)
    text = (
        f"*PART, NAME=A\n{part}*END PART\n*ASSEMBLY, NAME=X\n*INSTANCE, NAME=I, PART=A\n0, 0, 0\n"
        "0, 0, 0, 1, 0, 0, 90.\n*END INSTANCE\n*END ASSEMBLY\n*MATERIAL" + SHELLS.split("*MATERIAL")[1]
    )
    (tmp_path / "a.inp").write_text(text)
    (block,) = read_model(tmp_path / "a.inp").blocks
    assert block.own.axis1 == pytest.approx(np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), abs=1e-15)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (SECTION.format(", SHELL THICKNESS=E") + THICK, "SHELL THICKNESS=E of .* is no .DISTRIBUTION.*There are: D"),
        (
            SECTION.format(", SHELL THICKNESS=D") + THICK.replace("2, 3.", "2, -3."),
            "gives 1 shell.s. of .* no thickness",
        ),
        (SECTION.format(", SHELL THICKNESS=D") + THICK.replace(", 2.\n", ""), "gives 1 shell.s. of .* no thickness"),
        (SECTION.format(", SHELL THICKNESS=D") + THICK.replace("LENGTH", "RATIO"), "is of RATIO; expected LENGTH"),
        (SECTION.format(", SHELL THICKNESS=D") + THICK.replace("ELEMENT", "NODE"), "LOCATION=NODE of LENGTH"),
        (
            SECTION.format(", SHELL THICKNESS=D") + THICK.replace("TABLE=T", "TABLE=U"),
            "unknown .DISTRIBUTION TABLE 'U'",
        ),
        (SECTION.format(", ORIENTATION=O") + AXES.format(", SYSTEM=CYLINDRICAL", 0), "SYSTEM=CYLINDRICAL by a dist"),
        (
            SECTION.format(", ORIENTATION=O") + AXES.format("", 0).replace("-1., 0., 0.", "0., 2., 0."),
            "parallel or zero",
        ),
        (
            SECTION.format(", ORIENTATION=O") + AXES.format("", 0).replace(", 1., 0., 0., 0., 1., 0.\n", ""),
            "gives no axes to some elements",
        ),
        (
            SECTION.format("")
            + AXES.format("", 0)
            + "*NODE\n9, 0, 0, 5\n*ELEMENT, TYPE=SPRING1, ELSET=S\n9, 9\n*SPRING, ELSET=S, ORIENTATION=O\n1\n5.\n",
            "where there are no elements of a section",
        ),
    ],
)
def test_mistakes(read, text, told):
    with pytest.raises(InputError, match=told):
        read(text)


def test_a_distribution_that_nothing_uses_is_not_checked(read):
    assert read(SECTION.format("") + THICK.replace("LENGTH", "NONSENSE")).n_elements == 2
