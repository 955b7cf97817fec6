"""Modal test of a real structure beside a model made of its dimensions: a bolted frame.

What one stiffness of the corners can do for the frame is found by least squares, with the closed-form sensitivities
d omega^2 / dp = phi' dK/dp phi of mass-normalised modes (Fox and Kapoor, AIAA J. 6, 1968). What it cannot do stays in
the limits: they are what was found.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from creak.formats.measured.mode_files import read_measured_modes
from creak.studies.models.correlation import Correlation, correlate
from creak.studies.models.deck_modes import deck_modes
from helpers_flat_decks import frequencies
from helpers_frame import corner_nodes, frame_deck, write_test

F_MAX = 2600.0
"""Hz: all partners of the thirteen measured modes and some more."""


class Frame:
    """The frame's modes beside the test, for corners of any stiffness."""

    def __init__(self, folder) -> None:
        self.known: dict[float, tuple[np.ndarray, np.ndarray, Correlation]] = {}
        self.folder, self.measured = folder, read_measured_modes(write_test(folder / "frame.csv"))

    def at(self, corner: float | None) -> Correlation:
        path = self.folder / "frame.inp"
        path.write_text(frame_deck(corner), encoding="utf-8")
        return correlate(deck_modes(path, f_max=F_MAX), self.measured)

    def step(self, p: float) -> tuple[np.ndarray, np.ndarray, Correlation]:
        """ln(f_model / f_test) of the pairs for corners of 10^p N mm/rad, and its slope over p."""
        if p not in self.known:
            self.known[p] = self._step(p)
        return self.known[p]

    def _step(self, p: float) -> tuple[np.ndarray, np.ndarray, Correlation]:
        found = self.at(10.0**p)
        rows = {int(label): k for k, label in enumerate(found.found.model.nodes.ids.tolist())}
        about_y = [u[:, 4] for u in found.found.motion()]
        slopes = []
        for pair in found.pairs:
            turn, omega2 = about_y[pair.model], (2.0 * np.pi * pair.frequency_model) ** 2
            of_k = sum(share * (turn[rows[a]] - turn[rows[b]]) ** 2 for a, b, share in corner_nodes())
            slopes.append(of_k * 10.0**p * np.log(10.0) / (2.0 * omega2))
        return np.log1p([pair.difference for pair in found.pairs]), np.array(slopes)[:, None], found


@pytest.fixture(scope="module")
def frame(tmp_path_factory):
    return Frame(tmp_path_factory.mktemp("frame"))


@pytest.fixture(scope="module")
def welded(frame):
    return frame.at(None)


@pytest.fixture(scope="module")
def best(frame):
    """log10 of the stiffness that brings the frequencies together, between bounds that the start is amid."""
    found = least_squares(
        lambda x: frame.step(float(x[0]))[0],
        [7.0],
        jac=lambda x: frame.step(float(x[0]))[1],
        bounds=([5.0], [9.0]),
    )
    assert found.success
    return float(found.x[0])


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
def test_sensitivity_to_the_corners_is_that_of_differences(frame):
    h = 1e-3
    slope = (frame.step(7.5 + h)[0] - frame.step(7.5 - h)[0]) / (2.0 * h)
    np.testing.assert_allclose(frame.step(7.5)[1][:, 0], slope, atol=2e-6)  # h^2 of the central difference


@pytest.mark.slow
def test_one_stiffness_of_the_corners_brings_the_frequencies_together(frame, welded, best, measured):
    """From 5.9 to 2.7 % rms. The first mode stays high and the third low: one spring is not all that a bolted corner
    does."""
    source = "impact test, permas4edu"
    off, _, found = frame.step(best)
    off = np.expm1(off)
    assert [p.test for p in found.pairs] == list(range(13))
    measured(
        "measured",
        "bolted frame, softened corners: stiffness, 1e7 N mm/rad",
        10.0**best / 1e7,
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
        at_most=0.055,
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
