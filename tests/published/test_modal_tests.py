"""Modal test of a real structure beside a model made of its dimensions: a bolted frame.

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
from creak.studies.prepare.sensors import locate
from helpers_flat_decks import frequencies
from helpers_frame import SPRINGS, STUDY, frame_deck, write_test

RECORDED = {"section": "measured", "source": "shell model, permas4edu"}

F_MAX = 2600.0
"""Hz: all partners of the thirteen measured modes and some more."""


@pytest.fixture(scope="module")
def welded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("welded")
    (folder / "frame.inp").write_text(frame_deck(), encoding="utf-8")
    test = read_measured_modes(write_test(folder / "frame.csv"))
    found = deck_modes(folder / "frame.inp", f_max=F_MAX)
    return correlate(found, test, locate(found.model, test))


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
    measured("bolted frame, welded corners: measured modes with a partner", len(welded.pairs), 13, source=source)
    measured("bolted frame, welded corners: lowest MAC", min(p.mac for p in welded.pairs), at_least=0.97, source=source)
    measured(
        "bolted frame, welded corners: highest frequency over the test",
        1.0 + off.max(),
        between=(1.14, 1.16),
        source=source,
    )
    measured(
        "bolted frame, welded corners: rms of the frequency differences",
        rms(off),
        between=(0.055, 0.063),
        source=source,
    )


def test_the_shell_model_of_the_source_is_found_again(welded, measured):
    """Its frequencies, welded too, from a mesh of its own."""
    found = [p.frequency_model for p in welded.pairs]
    measured("bolted frame, welded corners: mode {}", found, SHELL_MODEL, rel=0.008, unit="Hz")


def test_triangles_find_the_shell_model_of_the_source_too(tmp_path, measured):
    """Plates 15 thicknesses wide: 4 % of their torsion hang on the layers at their edges, of a third of a thickness."""
    found = frequencies(tmp_path, frame_deck(kind="S3"), 6 + len(SHELL_MODEL))[6:]
    measured("bolted frame, welded corners, S3: mode {}", found, SHELL_MODEL, rel=0.012, unit="Hz")


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
        "bolted frame, softened corners: stiffness, 1e7 N mm/rad",
        SPRINGS * spring.value / 1e7,
        between=(3.0, 3.6),
        source="least squares",
    )
    measured("bolted frame, softened corners: rms of the frequency differences", rms(off), at_most=0.028, source=source)
    measured(
        "bolted frame, softened corners: largest frequency difference", np.abs(off).max(), at_most=0.058, source=source
    )
    measured(
        "bolted frame, softened corners: lowest MAC", min(p.mac for p in found.pairs), at_least=0.97, source=source
    )
    assert rms(off) < 0.5 * rms(np.array([p.difference for p in welded.pairs]))
    assert np.argsort(np.abs(off))[-2:].tolist() == [0, 2]
    assert 2.5 < softened.fit.scatter < 3.0
    assert any("something else differs too" in note for note in update_notes(softened))
    assert spring.low < spring.value / 1.3
    assert spring.high > spring.value * 1.3
