"""Decks with supports along skew axes, bushings and lumped mass, against closed forms and against themselves turned."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from creak.assembly.coupling import Driven
from creak.assembly.partition import cut
from creak.assembly.rigid import unheld_parts
from creak.formats.abaqus.reader import read_deck
from creak.model.mesh import Model
from creak.studies.models.deck_modes import model_modes

RECORDED = {"section": "models"}

NONE = Driven({})
STEEL = "*MATERIAL, NAME=STEEL\n*ELASTIC\n 210000., 0.3\n*DENSITY\n 7.85e-9\n"


@pytest.fixture
def read(tmp_path: Path) -> Callable[[str], Model]:
    def reader(text: str) -> Model:
        (tmp_path / "deck.inp").write_text(text)
        model = read_deck(tmp_path / "deck.inp")
        assert not [u for u in model.unread if u.changes_answer]
        return model

    return reader


def plate(n: int = 6) -> str:
    label = lambda i, j: 1 + i * (n + 1) + j  # noqa: E731
    nodes = "".join(f" {label(i, j)}, {100 * i / n}, {80 * j / n}, 0.\n" for i in range(n + 1) for j in range(n + 1))
    quads = [(label(i, j), label(i + 1, j), label(i + 1, j + 1), label(i, j + 1)) for i in range(n) for j in range(n)]
    lines = "".join(f" {k + 1}, {a}, {b}, {c}, {d}\n" for k, (a, b, c, d) in enumerate(quads))
    edge = ", ".join(str(label(0, j)) for j in range(n + 1))
    section = "*SHELL SECTION, ELSET=P, MATERIAL=STEEL, OFFSET=SPOS\n 1.5\n"
    sets = f"*NSET, NSET=EDGE\n {edge}\n*NSET, NSET=CORNER\n {label(n, 0)}\n"
    return f"*NODE\n{nodes}*ELEMENT, TYPE=S4, ELSET=P\n{lines}{sets}{section}"


def assembled(lines: str, axes: str) -> str:
    """The plate placed by `lines`, its edge held along x, z and about y of `axes`, a corner along y."""
    held = f"*TRANSFORM, NSET=I.EDGE\n{axes}*TRANSFORM, NSET=I.CORNER\n{axes}" if axes else ""
    instance = f"*INSTANCE, NAME=I, PART=Q\n{lines}*END INSTANCE\n{held}"
    bc = "*BOUNDARY\n I.EDGE, 1\n I.EDGE, 3\n I.EDGE, 5\n I.CORNER, 2, 3\n"
    return f"*PART, NAME=Q\n{plate()}*END PART\n*ASSEMBLY, NAME=A\n{instance}*END ASSEMBLY\n{STEEL}{bc}"


def test_supports_along_the_axes_of_a_turned_plate(read, measured) -> None:
    """Turned by 40 degrees about (1, 2, 3), with supports in axes that turn alike: the same frequencies."""
    straight = read(assembled("", ""))
    angle, axis = np.radians(40.0), np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
    cross = np.cross(np.eye(3), axis)
    R = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    axes = " " + ", ".join(f"{v:.17g}" for v in (*R[:, 0], *R[:, 1])) + "\n"
    turned = read(assembled(" 10., 20., 30.\n 0., 0., 0., 1., 2., 3., 40.\n", axes))
    assert not unheld_parts(straight, NONE)
    assert not unheld_parts(turned, NONE)
    expected = model_modes(straight, NONE, count=8)[1].frequencies
    found = model_modes(turned, NONE, count=8)[1].frequencies
    assert expected[0] > 1.0
    measured(
        "plate with supports along skew axes: ratio of frequencies, worst",
        found / expected,
        1.0,
        rel=1e-7,
        source="the plate not turned",
    )


BUSHING = """\
*NODE
 1, 0., 0., 0.
 2, 0., 0., 0.
*ELEMENT, TYPE=MASS, ELSET=M
 1, 2
*ELEMENT, TYPE=ROTARYI, ELSET=J
 2, 2
*ELEMENT, TYPE=CONN3D2, ELSET=C
 3, 1, 2
*MASS, ELSET=M
 2.
*ROTARY INERTIA, ELSET=J
 3., 3., 3.
*ORIENTATION, NAME=O
 1., 1., 0., -1., 1., 0.
*CONNECTOR SECTION, ELSET=C, BEHAVIOR=B
 BUSHING,
 O,
*CONNECTOR BEHAVIOR, NAME=B
*CONNECTOR ELASTICITY
 100., 30., 200., 0., 0., 400., 0., 0.
 0., 500., 0., 0., 0., 0., 600., 0.
 0., 0., 0., 0., 700.
*BOUNDARY
 1, ENCASTRE
"""


def test_mass_on_a_bushing(read, measured) -> None:
    """Six modes: eigenvalues of [[100, 30], [30, 200]]/2, 400/2 and 500, 600, 700 over 3, whatever the axes."""
    model = read(BUSHING)
    found = (2 * np.pi * model_modes(model, NONE, count=6)[1].frequencies) ** 2
    squares = [*np.linalg.eigvalsh([[100.0, 30.0], [30.0, 200.0]]) / 2, 200.0, 500 / 3, 200.0, 700 / 3]
    measured(
        "mass on a bushing: omega^2, mode {}", found, sorted(squares), rel=1e-9, unit="rad2/s2", source="closed form"
    )


def test_a_bushing_holds_a_part(read) -> None:
    """A connector to a point of another part, which is clamped."""
    more = "*NODE\n 990, 0., 0., 5.\n 991, 9., 0., 5.\n*ELEMENT, TYPE=B31, ELSET=R\n 900, 990, 991\n"
    more += "*BEAM SECTION, ELSET=R, MATERIAL=STEEL, SECTION=CIRC\n 1.\n 0., 1., 0.\n*BOUNDARY\n 991, ENCASTRE\n"
    more += "*ELEMENT, TYPE=CONN3D2, ELSET=C\n 901, 990, 1\n"
    more += BUSHING[BUSHING.index("*ORIENTATION") : BUSHING.index("*BOUNDARY")]
    flat = f"{plate(2)}{STEEL}{more}"
    assert not unheld_parts(read(flat), NONE)
    soft = flat.replace("100., 30., 200.", "0., 0., 200.")
    assert unheld_parts(read(soft), NONE) == ["P"]


def test_lumped_mass_is_an_option_of_the_model(read) -> None:
    """Six elements along a side: the first frequency falls by the order of (k h)^2/12, 4 %; the mass does not, and no rotation has any."""
    text = assembled("", "").replace(", OFFSET=SPOS", "")
    model = read(text)
    consistent, c = model_modes(model, NONE, count=3)
    lumped, found = model_modes(replace(model, mass_form="lumped"), NONE, count=3)
    assert lumped.stats.mass == pytest.approx(consistent.stats.mass, rel=1e-12)
    assert np.count_nonzero(lumped.M.diagonal()) < 0.6 * lumped.n
    assert found.frequencies[0] == pytest.approx(c.frequencies[0], rel=0.06)
    assert (found.frequencies < c.frequencies).all()


def test_a_part_cut_in_two_keeps_the_directions_of_its_elements(read) -> None:
    """A laminate with cylindrical axes, cut into two parts that share nodes: the same frequencies."""
    carbon = (
        "*MATERIAL, NAME=CARBON\n*ELASTIC, TYPE=LAMINA\n 140000., 10000., 0.3, 5000., 5000., 3500.\n*DENSITY\n 1.6e-9\n"
    )
    axes = "*ORIENTATION, NAME=O, SYSTEM=CYLINDRICAL\n -20., -10., 0., -20., -10., 1.\n 3, 15.\n"
    section = "*SHELL SECTION, ELSET=P, COMPOSITE, ORIENTATION=O\n 0.5, 3, CARBON, 0.\n 0.3, 3, CARBON, 60.\n"
    text = plate().split("*SHELL SECTION")[0] + section + axes + carbon + "*BOUNDARY\n EDGE, ENCASTRE\n"
    model = read(text)
    group = (np.arange(36) % 3 == 0).astype(np.int64)
    pieces = cut(model, [group], ["CUT"]).model
    assert [b.ids.size for b in pieces.blocks] == [24, 12]
    expected = model_modes(model, NONE, count=5)[1].frequencies
    assert model_modes(pieces, NONE, count=5)[1].frequencies == pytest.approx(expected, rel=1e-7)
