"""Two cantilevers that collide softly: measured modes of each, and what collisions make of a resonance.

The models are made of the drawing (`helpers_vibeams`). Where they disagree with the test, the limits are what was found.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from creak.studies.file.reader import read_study
from creak.studies.models.deck_modes import deck_modes
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import run_study
from helpers_decks import write_study
from helpers_vibeams import FITTED, GAP, LEFT, LOOSE, RIGHT, Right, both_deck, left_deck, right_deck

RECORDED = {"section": "measured"}

SOURCE = "doi 10.25518/2684-6500.180"


def modes(folder, deck, count):
    path = folder / "beam.inp"
    path.write_text(deck, encoding="utf-8")
    return np.array(deck_modes(path, count=count).frequencies)


def test_linear_modes_of_the_left_beam_from_its_drawing(tmp_path, measured):
    """One figure is not the drawing's: how much of one section the bolts make of beam and plate."""
    found = modes(tmp_path, left_deck(), 4)
    measured("left cantilever: mode {}", found, LEFT, rel=0.018, unit="Hz", source=SOURCE)
    theirs = LEFT * (1.0 + np.array([-0.0001, 0.015, 0.007, 0.004]))
    measured(
        "left cantilever, beside the authors' own beam model: mode {}",
        found,
        theirs,
        rel=0.004,
        unit="Hz",
        source=SOURCE,
    )


def test_linear_modes_of_the_right_beam_from_its_drawing(tmp_path, measured):
    """The bolted stack of its clamping section is one section at most, and plates that slide on each other at least."""
    stiff, loose = (modes(tmp_path, right_deck(Right(**made)), 5) for made in ({}, {"clamp": LOOSE}))
    for name, found in (("stack as one section", stiff), ("stack of loose plates", loose)):
        measured(f"right cantilever, {name}: mode {{}}", found, RIGHT, rel=0.05, unit="Hz", source=SOURCE)
    # The third is that of the spring plate; the first hangs on the clamp, which the stack does not change.
    assert (loose[3:] < RIGHT[3:]).all()
    assert (RIGHT[3:] < stiff[3:]).all()
    for k in (0, 1, 2):
        assert max(loose[k], stiff[k]) < RIGHT[k]
    fitted = modes(tmp_path, right_deck(FITTED), 5)
    measured("right cantilever, the authors' three factors: mode {}", fitted, RIGHT, rel=0.04, unit="Hz", source=SOURCE)


LOW, HIGH, LASTS, DAMPING = 28.1, 29.3, 40.0, 0.0023
"""Sweep of the base, Hz and s; share of critical damping, the one figure that is set: so that the largest level gives
the largest response measured."""


@dataclass(frozen=True)
class Peak:
    """Of the response of the right beam's tip to a sweep."""

    frequency: float
    """Hz"""
    gaps: float
    """Amplitude of the fundamental, in gaps."""
    force: float
    """Largest at the nut, N."""


def swept(folder, level):
    """The resonance of both beams on a base that is shaken by so much, mm/s^2."""
    study_path = write_study(
        folder,
        f"""[model]
deck = "both.inp"
[[connector]]
type = "play"
name = "nut"
nodes = ["NUT", "SPRING"]
dof = "z"
lower = {-GAP}
stiffness = 2000.0
[excitation.base]
node_set = "BASE"
dof = "z"
kind = "acceleration"
signal = {{ type = "sweep", f_start = {LOW}, f_end = {HIGH}, amplitude = {level}, duration = {LASTS} }}
[damping]
modal = {DAMPING}
[reduction]
f_max = 1500
[reference]
run = false
[time]
accuracy = "quick"
end = {LASTS}
[output]
nodes = ["TIP", "BASE"]
interval = 2e-3
[verification]
f_max = 200
""",
        {"both.inp": both_deck(FITTED)},
    )
    setup = set_up(read_study(study_path))
    history = run_study(setup, lambda *_: None).runs["reduced"].history
    rows = {name: setup.model.node_sets[name] for name in ("TIP", "BASE")}
    column = {row: k for k, row in enumerate(setup.watch.nodes.tolist())}
    tip, base = (history.displacement[:, 6 * column[int(rows[name][-1])] + 2] for name in ("TIP", "BASE"))
    time = history.time[history.output_index]
    frequency = LOW + (HIGH - LOW) / LASTS * time
    turned = (tip - base) * np.exp(-2j * np.pi * (LOW * time + 0.5 * (HIGH - LOW) / LASTS * time**2))
    window = np.hanning(round(0.7 / (time[1] - time[0])))
    amplitude = 2.0 * np.abs(np.convolve(turned, window / window.sum(), "valid"))
    at, shift = int(amplitude.argmax()), window.size // 2
    return Peak(float(frequency[at + shift]), float(amplitude[at]) / GAP, float(history.force.max(initial=0.0)))


@pytest.fixture(scope="module")
def peaks(tmp_path_factory):
    """At 4 mm/s^2 nothing touches: the same sweep of the linear system, with the lag that a sweep has."""
    folder = tmp_path_factory.mktemp("beams")
    return {level: swept(folder, level) for level in (4.0, 20.0, 28.0, 30.5)}


def test_collisions_raise_the_resonance(peaks, measured):
    """Measured: by 1 to 3 % at responses of 1 to 1.7 gaps, the base shaken at 20, 28 and 30.5 mm/s^2."""
    assert peaks[4.0].force == 0.0
    shifts = {level: peak.frequency / peaks[4.0].frequency - 1.0 for level, peak in peaks.items()}
    for level in (28.0, 30.5):
        measured(
            f"colliding cantilevers at {level:g} mm/s2: resonance raised by (test: 1 to 3 %)",
            100.0 * shifts[level],
            between=(1.0, 3.0),
            unit="%",
            source=SOURCE,
        )
    for level in (20.0, 28.0, 30.5):
        measured(
            f"colliding cantilevers at {level:g} mm/s2: response in gaps (test: 1 to 1.7)",
            peaks[level].gaps,
            between=(1.0, 1.7),
            source=SOURCE,
        )
    # At the onset of contact it has hardly begun to rise.
    assert 0.0 < shifts[20.0] < 0.005
    assert shifts[20.0] < shifts[28.0] < shifts[30.5]
