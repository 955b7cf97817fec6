"""A screening looks at the whole run, from rest."""

from __future__ import annotations

from creak.progress import silent
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.studies.run.screen import screen
from helpers_decks import STUDY, two_strips, write_strips


def test_screening_sees_what_closes_before_the_window(tmp_path):
    """The window of four periods is the last one; of the same run the first two have a peak of their own."""
    found = {}
    for periods in (2, 3, 4):
        folder = tmp_path / str(periods)
        folder.mkdir()
        study = write_strips(folder, two_strips(0.3), STUDY.replace("periods = 2", f"periods = {periods}"))
        found[periods] = screen(set_up(read_study(study)), silent).linear.closing
    tolerance = 1e-9 * found[4].max()
    assert (found[3] >= found[2] - tolerance).all()
    assert (found[4] >= found[3] - tolerance).all()
