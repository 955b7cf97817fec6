"""Records against the run that they move: when they begin and end, and how well displacement is known from them."""

from __future__ import annotations

import re

import numpy as np
import pytest

from creak.signals.omega_arithmetic import integrate_twice, wrapped_share
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from helpers_decks import STUDY, write_strips

STEP, HIGH_PASS = 1e-3, 8.0
LINES = ((12.0, 3000.0, 0.3), (20.0, -4000.0, 1.1), (33.0, 9000.0, 2.0), (47.0, 5000.0, 0.7))


def tones(n):
    """Acceleration of some lines, and the displacement that it is of."""
    t = STEP * np.arange(n)
    each = [(A * np.cos(2.0 * np.pi * f * t + p), (2.0 * np.pi * f) ** 2) for f, A, p in LINES]
    return sum(a for a, _ in each), -sum(a / w2 for a, w2 in each)


@pytest.mark.parametrize("n", [2000, 2048, 1010, 5033, 10017])
def test_how_far_off_displacements_are_is_told(n):
    """Two seconds are a whole period of all lines; of other lengths the figure is right within a factor of three."""
    a, u = tones(n)
    middle = slice(n // 4, n - n // 4)
    off = np.linalg.norm((integrate_twice(a, STEP, HIGH_PASS)[0] - u)[middle]) / np.linalg.norm(u[middle])
    told = wrapped_share(a, STEP, HIGH_PASS)
    if n == 2000:
        assert told == 0.0
        assert off < 1e-9
    else:
        assert off / 3.0 < told < 3.0 * off


@pytest.mark.parametrize(
    ("begin", "count", "said"),
    [
        (0.0, 2000, ()),
        (0.0, 2048, ("is off by some 3.6 % in its middle", "Take a longer record, or one of whole periods")),
        (0.3, 2000, ("begins at 0.3 s: nothing moves before",)),
        (-1.0, 2000, ("ends at 0.999 s, the run at 1.9 s",)),
        (100.0, 2000, ("is zero throughout the run: its record holds 100 to 102 s, the run 0 to 1.9 s",)),
    ],
)
def test_records_that_do_not_fit_the_run_are_told(tmp_path, begin, count, said):
    a, _ = tones(count)
    rows = np.stack([begin + STEP * np.arange(count), a], axis=1)
    np.savetxt(tmp_path / "road.csv", rows, delimiter=",", header="time,acc", comments="", fmt="%.9g")
    record = 'signal = { type = "record", file = "road.csv", channel = "acc", high_pass = 8 }'
    study = re.sub(r"signal = .*", record, STUDY).replace('"displacement"', '"acceleration"')
    study = study.replace("step = 5e-4\nperiods = 2", "end = 1.9")
    told = [note for note in set_up(read_study(write_strips(tmp_path, study=study))).notes if "record" in note]
    assert len(told) == bool(said)
    assert all(words in told[0] for words in said)
