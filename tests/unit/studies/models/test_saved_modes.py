"""A superelement of the default accuracy, saved with its modes beyond f_max, is read again."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from creak.formats.stored import superelement as superelement_file
from creak.progress import silent
from creak.studies.file.reader import read_study
from creak.studies.models import superelements
from creak.studies.models.reduced import reduce_model
from creak.studies.models.reference import build_reference
from creak.studies.models.saved import Store
from creak.studies.models.superelements import Reduced, save_superelement, with_modes_of_file
from creak.studies.prepare.setup import set_up
from helpers_decks import STUDY, write_strips


def test_modes_beyond_f_max_are_saved_and_read(tmp_path):
    text = STUDY.replace("step = 5e-4\n", "").replace("f_max = 3000", "f_max = 2000")
    setup = set_up(read_study(write_strips(tmp_path, None, text)))
    reference = build_reference(setup.structure, setup.band, silent)
    gaps = setup.contacts.select(np.arange(2))
    made = reduce_model(setup.reduction, reference, gaps, silent)
    assert any(r.basis.fixed.omega2.size > r.system.stats.modes for r in made.superelements)
    for reduced in made.superelements:
        save_superelement(tmp_path / "store", reduced, setup.model, {})
    again = reduce_model(setup.reduction, reference, gaps, silent, Store(tmp_path / "store"))
    assert all(r.reused for r in again.superelements)
    assert again.modes == made.modes
    assert abs(again.system.K.d - made.system.K.d).max() <= 1e-9 * made.system.K.d.max()


@pytest.mark.skipif(sys.platform == "win32", reason="there a file that is mapped cannot be replaced")
def test_many_modes_of_a_saved_part_are_read_where_they_are_used(tmp_path, monkeypatch):
    """The coupled model and the motion inside are those of modes in memory."""
    setup = set_up(read_study(write_strips(tmp_path)))
    reference = build_reference(setup.structure, setup.band, silent)
    gaps, store = setup.contacts.select(np.arange(2)), tmp_path / "store"
    held = reduce_model(setup.reduction, reference, gaps, silent)
    for module in (superelement_file, superelements):
        monkeypatch.setattr(module, "MAPPED", 0)

    def saved(reduced: Reduced) -> Reduced:
        return with_modes_of_file(setup.band, reduced, save_superelement(store, reduced, setup.model, {}))

    fresh, taken = (
        reduce_model(setup.reduction, reference, gaps, silent, Store(store), saved),
        reduce_model(setup.reduction, reference, gaps, silent, Store(store)),
    )
    q = np.random.default_rng(4).standard_normal((held.system.n, 3))
    still = np.zeros((held.system.supports.count, 3))
    for model in (fresh, taken):
        assert all(isinstance(r.basis.fixed.shapes, np.memmap) for r in model.superelements)
        np.testing.assert_allclose(model.system.K.d, held.system.K.d, rtol=1e-12)
        expected = held.system.recover(q, still)
        np.testing.assert_allclose(model.system.recover(q, still), expected, atol=1e-10 * np.abs(expected).max())
