"""Modal tests of real structures beside models made of their dimensions: a bolted frame and a cantilever.

What one stiffness of the corners can do for the frame is found as `creak update` finds it. What it cannot do stays in the
limits: they are what was found.
"""

from __future__ import annotations

import numpy as np
import pytest

from creak.formats.measured.mode_files import read_measured_modes
from creak.report.words.update import update_notes
from creak.studies.file.reader import read_study
from creak.studies.models.correlation import correlate
from creak.studies.models.deck_modes import deck_modes
from creak.studies.models.update import update, update_case
from helpers_flat_decks import frequencies
from helpers_frame import SPRINGS, STUDY, frame_deck, write_test

F_MAX = 2600.0
"""Hz: all partners of the thirteen measured modes and some more."""


@pytest.fixture(scope="module")
def welded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("welded")
    (folder / "frame.inp").write_text(frame_deck(), encoding="utf-8")
    test = read_measured_modes(write_test(folder / "frame.csv"))
    return correlate(deck_modes(folder / "frame.inp", f_max=F_MAX), test)


@pytest.fixture(scope="module")
def softened(tmp_path_factory):
    """The frame with hinges, whose springs begin a third as stiff as they will be found."""
    folder = tmp_path_factory.mktemp("hinged")
    (folder / "frame.inp").write_text(frame_deck(hinged=True), encoding="utf-8")
    (folder / "frame.toml").write_text(STUDY, encoding="utf-8")
    case = update_case(read_study(folder / "frame.toml"), write_test(folder / "frame.csv"))
    return update(case, ["clip.0.stiffness.4"])


SHELL_MODEL = [71.6, 165.8, 232.2, 366.8, 487.2, 516.0, 687.8, 1187, 1291, 1390, 1675, 2206, 2380]
"""Hz, welded, by the source of the measurement."""


def rms(x: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(x))))


def test_thirteen_pairs_of_the_welded_frame(welded, measured):
    """All measured modes find their partners in the right order, those that bend the corners too high."""
    source = "impact test, permas4edu"
    assert [p.test for p in welded.pairs] == list(range(13))
    assert np.all(np.diff([p.model for p in welded.pairs]) > 0)
    off = np.array([p.difference for p in welded.pairs])
    measured(
        "measured", "bolted frame, welded corners: measured modes with a partner", len(welded.pairs), 13, source=source
    )
    measured(
        "measured",
        "bolted frame, welded corners: lowest MAC",
        min(p.mac for p in welded.pairs),
        at_least=0.97,
        source=source,
    )
    measured(
        "measured",
        "bolted frame, welded corners: highest frequency over the test",
        1.0 + off.max(),
        between=(1.14, 1.16),
        source=source,
    )
    measured(
        "measured",
        "bolted frame, welded corners: rms of the frequency differences",
        rms(off),
        between=(0.055, 0.063),
        source=source,
    )


def test_the_shell_model_of_the_source_is_found_again(welded, measured):
    """Its frequencies, welded too, from a mesh of its own."""
    found = [p.frequency_model for p in welded.pairs]
    measured(
        "measured",
        "bolted frame, welded corners: mode {}",
        found,
        SHELL_MODEL,
        rel=0.008,
        unit="Hz",
        source="shell model, permas4edu",
    )


def test_triangles_find_the_shell_model_of_the_source_too(tmp_path, measured):
    """Plates 15 thicknesses wide: 4 % of their torsion hang on the layers at their edges, of a third of a thickness."""
    found = frequencies(tmp_path, frame_deck(kind="S3"), 6 + len(SHELL_MODEL))[6:]
    measured(
        "measured",
        "bolted frame, welded corners, S3: mode {}",
        found,
        SHELL_MODEL,
        rel=0.012,
        unit="Hz",
        source="shell model, permas4edu",
    )


@pytest.mark.slow
def test_one_stiffness_of_the_corners_brings_the_frequencies_together(welded, softened, measured):
    """From 5.9 to 2.7 % rms. The first mode stays high and the third low: one spring is not all that a bolted corner
    does, and the update says so."""
    source = "impact test, permas4edu"
    found, [spring] = softened.after, softened.estimates
    off = np.array([p.difference for p in found.pairs])
    assert [p.test for p in found.pairs] == list(range(13))
    assert softened.lost == softened.gained == []
    measured(
        "measured",
        "bolted frame, softened corners: stiffness, 1e7 N mm/rad",
        SPRINGS * spring.value / 1e7,
        between=(3.0, 3.6),
        source="least squares",
    )
    measured(
        "measured",
        "bolted frame, softened corners: rms of the frequency differences",
        rms(off),
        at_most=0.028,
        source=source,
    )
    measured(
        "measured",
        "bolted frame, softened corners: largest frequency difference",
        np.abs(off).max(),
        at_most=0.058,
        source=source,
    )
    measured(
        "measured",
        "bolted frame, softened corners: lowest MAC",
        min(p.mac for p in found.pairs),
        at_least=0.97,
        source=source,
    )
    assert rms(off) < 0.5 * rms(np.array([p.difference for p in welded.pairs]))
    assert np.argsort(np.abs(off))[-2:].tolist() == [0, 2]
    assert 2.5 < softened.fit.scatter < 3.0
    assert any("something else differs too" in note for note in update_notes(softened))
    assert spring.low < spring.value / 1.3
    assert spring.high > spring.value * 1.3


# --- a cantilever that collides, before it does ---------------------------------------------------------------------

LENGTH, BREADTH, HEIGHT = 392.5, 60.0, 6.0
E, RHO = 210e3, 7.72e-9
PLATE, PLATE_MASS, FROM_TIP = (40.0, 1.0), 42.7e-6, 62.5
"""Length along the beam (as broad) and thickness, mm; mass with its bolts, t; from its end to the tip, mm."""
TIP_MASS, TIP_AT = 13.3e-6, 11.5
BOLTED = 0.75
"""Of the bending stiffness of beam and plate as one section."""


def one_section() -> float:
    """Second moment of area of the beam with the plate on it, mm^4 (parallel axes)."""
    areas = np.array([BREADTH * HEIGHT, PLATE[0] * PLATE[1]])
    heights = np.array([0.0, 0.5 * (HEIGHT + PLATE[1])])
    own = np.array([BREADTH * HEIGHT**3, PLATE[0] * PLATE[1] ** 3]) / 12.0
    return float((own + areas * (heights - areas @ heights / areas.sum()) ** 2).sum())


def cantilever_deck() -> str:
    """B33 that bend about y alone; the plate's mass is spread over its length."""
    start, end = LENGTH - FROM_TIP - PLATE[0], LENGTH - FROM_TIP
    knots = [0.0, start, end, LENGTH - TIP_AT, LENGTH]
    x = np.unique(
        np.concatenate([np.linspace(a, b, n) for a, b, n in zip(knots[:-1], knots[1:], (40, 7, 9, 3), strict=True)])
    )
    area, bending = BREADTH * HEIGHT, BREADTH * HEIGHT**3 / 12.0
    sections = {"BARE": (bending, RHO), "PLATED": (BOLTED * one_section(), RHO + PLATE_MASS / PLATE[0] / area)}
    lines = ["*NODE", *(f"{k}, {v:.9g}, 0., 0." for k, v in enumerate(x.tolist(), start=1))]
    middles = 0.5 * (x[1:] + x[:-1])
    for name, (inertia, density) in sections.items():
        lines.append(f"*ELEMENT, TYPE=B33, ELSET={name}")
        lines += [
            f"{k}, {k}, {k + 1}" for k, m in enumerate(middles, start=1) if (start < m < end) == (name == "PLATED")
        ]
        lines += [
            f"*BEAM GENERAL SECTION, ELSET={name}, SECTION=GENERAL, DENSITY={density:.9g}",
            f"{area}, {inertia:.9g}, 0., {BREADTH**3 * HEIGHT / 12.0}, {4.0 * inertia:.9g}",
            "0., 1., 0.",
            f"{E}, {E / 2.6:.9g}",
        ]
    tip = int(np.abs(x - (LENGTH - TIP_AT)).argmin()) + 1
    lines += [f"*ELEMENT, TYPE=MASS, ELSET=TIP\n9000, {tip}\n*MASS, ELSET=TIP\n{TIP_MASS}"]
    lines += [
        f"*NSET, NSET=ALL, GENERATE\n1, {x.size}, 1",
        "*BOUNDARY",
        "1, 1, 6",
        "ALL, 1, 2",
        "ALL, 4, 4",
        "ALL, 6, 6",
    ]
    return "\n".join(lines) + "\n"


def test_linear_modes_of_a_cantilever_from_its_drawing(tmp_path, measured):
    """NLtest, doi 10.25518/2684-6500.180, left beam: nothing but the drawing goes in."""
    path = tmp_path / "beam.inp"
    path.write_text(cantilever_deck(), encoding="utf-8")
    found = np.array(deck_modes(path, count=4).frequencies)
    test = np.array([30.95, 199.04, 556.82, 1085.93])
    source = "doi 10.25518/2684-6500.180"
    measured("measured", "cantilever of the drawing: mode {}", found, test, rel=0.018, unit="Hz", source=source)
    theirs = test * (1.0 + np.array([-0.0001, 0.015, 0.007, 0.004]))
    measured(
        "measured",
        "cantilever, beside the authors' own beam model: mode {}",
        found,
        theirs,
        rel=0.004,
        unit="Hz",
        source=source,
    )
