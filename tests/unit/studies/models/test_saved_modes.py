"""A superelement of the default accuracy, saved with its modes beyond f_max, is read again."""

from __future__ import annotations

import numpy as np

from creak.studies.file.reader import read_study
from creak.studies.models.reduced import reduce_model
from creak.studies.models.reference import build_reference
from creak.studies.models.superelements import save_superelement
from creak.studies.prepare.setup import set_up
from helpers_decks import STUDY, write_strips


def quiet(stage: str, done: int, total: int) -> None:
    """No progress."""


def test_modes_beyond_f_max_are_saved_and_read(tmp_path):
    text = STUDY.replace("step = 5e-4\n", "").replace("f_max = 3000", "f_max = 2000")
    setup = set_up(read_study(write_strips(tmp_path, None, text)))
    reference = build_reference(setup, quiet)
    gaps = setup.contacts.select(np.arange(2))
    made = reduce_model(setup, reference, gaps, quiet)
    assert any(r.basis.fixed.omega2.size > r.system.stats.modes for r in made.superelements)
    for reduced in made.superelements:
        save_superelement(tmp_path / "store", reduced, setup.model, {})
    again = reduce_model(setup, reference, gaps, quiet, tmp_path / "store")
    assert all(r.reused for r in again.superelements)
    assert again.modes == made.modes
    assert abs(again.system.K.d - made.system.K.d).max() <= 1e-9 * made.system.K.d.max()
