"""A model's frequencies know neither its place and direction in space nor the labels in its deck."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from creak.assembly.part import Rayleigh, part_system
from creak.formats.abaqus.reader import read_deck

RECORDED = {"section": "models"}

MATERIALS = """\
*MATERIAL, NAME=STEEL
*ELASTIC
 210000., 0.3
*DENSITY
 7.85e-9
*MATERIAL, NAME=CARBON
*ELASTIC, TYPE=LAMINA
 140000., 10000., 0.3, 5000., 5000., 3500.
*DENSITY
 1.6e-9
*MATERIAL, NAME=WOOD
*ELASTIC, TYPE=ENGINEERING CONSTANTS
 12000., 900., 500., 0.3, 0.4, 0.3, 700., 600.
 50.
*DENSITY
 5.e-10
*CONNECTOR BEHAVIOR, NAME=RUBBER
*CONNECTOR ELASTICITY, COMPONENT=1
 100.
*CONNECTOR ELASTICITY, COMPONENT=2
 200.
*CONNECTOR ELASTICITY, COMPONENT=3
 300.
*CONNECTOR ELASTICITY, COMPONENT=4
 9000.
*CONNECTOR ELASTICITY, COMPONENT=5
 8000.
*CONNECTOR ELASTICITY, COMPONENT=6
 7000.
"""

POINTS = {
    1: (0, 0, 0),
    2: (30, 0, 2),
    3: (28, 25, 0),
    4: (-2, 22, 3),
    5: (15, 40, 8),
    6: (50, -5, 10),
    7: (48, 20, 12),
    8: (70, 3, 12),
    9: (40, 0, 30),
    10: (60, 0, 30),
    11: (42, 22, 31),
    12: (45, 6, 50),
    13: (80, 20, 15),
}
MIDDLES = ((9, 10), (10, 11), (11, 9), (9, 12), (10, 12), (11, 12))
ELEMENTS = {
    "Q, S4R": [(1, 2, 3, 4)],
    "T, S3": [(4, 3, 5)],
    "R, B31": [(2, 6), (6, 8)],
    "E, B33": [(3, 7)],
    "K, T3D2": [(7, 13)],
    "S, C3D10": [(9, 10, 11, 12, 21, 22, 23, 24, 25, 26)],
    "C, CONN3D2": [(6, 9), (7, 11), (8, 10)],
    "M, MASS": [(13,)],
    "A, SPRINGA": [(13, 8), (13, 3)],
    "J, ROTARYI": [(8,)],
}
SECTIONS = """\
*SHELL SECTION, ELSET=Q, COMPOSITE, ORIENTATION=O, OFFSET=0.3
 0.8, 3, CARBON, 20.
 0.5, 3, STEEL
*SHELL SECTION, ELSET=T, MATERIAL=STEEL, OFFSET=SNEG
 1.1
*BEAM SECTION, ELSET=R, MATERIAL=STEEL, SECTION=I
 0., 6., 4., 3., 0.5, 0.6, 0.4
 {across}
*BEAM GENERAL SECTION, ELSET=E, DENSITY=7.e-9, SECTION=GENERAL
 10., 30., 5., 20., 15.
 {across}
 2.e5, 8.e4
*CENTROID
 0.4, -0.3
*SOLID SECTION, ELSET=K, MATERIAL=STEEL
 2.
*SOLID SECTION, ELSET=S, MATERIAL=WOOD, ORIENTATION=O
*CONNECTOR SECTION, ELSET=C, BEHAVIOR=RUBBER
 BUSHING,
 O,
*MASS, ELSET=M
 2.e-6
*SPRING, ELSET=A

 50.
*ROTARY INERTIA, ELSET=J
 1.e-5, 2.e-5, 2.5e-5, 2.e-6
*NONSTRUCTURAL MASS, ELSET=Q, UNITS=TOTAL MASS
 1.e-6
"""


def deck(name: Callable[[int], int], order: np.random.Generator | None = None) -> str:
    """The model as one part with its nodes under other labels and, when asked, in another order."""
    points = {k: np.array(p, dtype=float) for k, p in POINTS.items()}
    points |= {21 + k: (points[a] + points[b]) / 2 for k, (a, b) in enumerate(MIDDLES)}
    nodes = [f" {name(k)}, {x:.17g}, {y:.17g}, {z:.17g}" for k, (x, y, z) in points.items()]
    blocks, label = [], 0
    for head, table in ELEMENTS.items():
        elset, kind = head.split(", ")
        lines = []
        for row in table:
            label += 1
            lines.append(f" {name(100 + label)}, " + ", ".join(str(name(k)) for k in row))
        blocks.append(f"*ELEMENT, TYPE={kind}, ELSET={elset}\n" + "\n".join(lines))
    if order is not None:
        order.shuffle(nodes)
        order.shuffle(blocks)
    axes = "*ORIENTATION, NAME=O\n 1., 0.2, 0.3, 0., 1., 0.1\n 3, 10.\n"
    return "\n".join(["*NODE", *nodes, *blocks, axes + SECTIONS.format(across="0.1, 0.2, 1.")])


def placed(body: str, lines: str = "") -> str:
    place = f"*INSTANCE, NAME=I, PART=P\n{lines}*END INSTANCE\n"
    return f"*PART, NAME=P\n{body}*END PART\n*ASSEMBLY, NAME=A\n{place}*END ASSEMBLY\n{MATERIALS}"


def spectrum(path: Path, text: str) -> np.ndarray:
    """Squares of all angular frequencies of the free body, rad^2/s^2."""
    path.write_text(text)
    model = read_deck(path)
    assert not [u for u in model.unread if u.changes_answer]
    assert [p.name for p in model.parts] == ["I"]
    system = part_system(model, 0, Rayleigh(0.0, 0.0))
    M, K = system.M.toarray(), system.K.toarray()
    loaded = np.flatnonzero(M.diagonal() > 0)
    massless = np.setdiff1d(np.arange(len(M)), loaded)
    K = (
        K[np.ix_(loaded, loaded)]
        - K[np.ix_(loaded, massless)]
        @ np.linalg.pinv(K[np.ix_(massless, massless)], rcond=1e-12)
        @ K[np.ix_(massless, loaded)]
    )
    return scipy.linalg.eigvalsh(K, M[np.ix_(loaded, loaded)])


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, np.ndarray]:
    path = tmp_path_factory.mktemp("invariance") / "deck.inp"
    return path, spectrum(path, placed(deck(int)))


def same(found: np.ndarray, expected: np.ndarray) -> None:
    """Six rigid-body modes, and frequencies to 1e-9 (eigenvalues to 2e-9, or round-off of the largest)."""
    assert np.abs(found[:6]).max() < 1e-10 * expected[-1]
    assert expected[6] > 1e3 * np.abs(expected[:6]).max()
    np.testing.assert_allclose(found[6:], expected[6:], rtol=2e-9, atol=1e-13 * expected[-1])


def record(measured, how: str, found: np.ndarray, expected: np.ndarray) -> None:
    measured(
        f"all elements in one part, {how}: omega^2, worst mode",
        found[6:],
        expected[6:],
        rel=2e-9,
        abs=1e-13 * expected[-1],
        unit="rad2/s2",
        source="the model itself",
    )


@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    axis=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda a: np.linalg.norm(a) > 0.1),
    angle=st.floats(-180, 180),
    shift=st.tuples(*[st.floats(-300, 300)] * 3),
)
def test_place_and_direction_do_not_matter(measured, home, axis, angle, shift):
    path, expected = home
    lines = " " + ", ".join(f"{x:.17g}" for x in shift) + "\n 0., 0., 0., "
    lines += ", ".join(f"{x:.17g}" for x in (*axis, angle)) + "\n"
    found = spectrum(path, placed(deck(int), lines))
    same(found, expected)
    record(measured, "moved and turned", found, expected)


@settings(max_examples=5, deadline=None)
@given(gap=st.integers(2, 9999), start=st.integers(0, 10**7), seed=st.integers(0, 2**31))
def test_labels_and_their_order_do_not_matter(measured, home, gap, start, seed):
    path, expected = home
    text = placed(deck(lambda k: start + gap * ((k * 37) % 211 + 1), np.random.default_rng(seed)))
    found = spectrum(path, text)
    same(found, expected)
    record(measured, "relabelled", found, expected)
