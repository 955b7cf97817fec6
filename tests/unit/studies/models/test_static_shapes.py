"""Static shapes of forces need a structure that is held without contact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.errors import InputError
from creak.progress import silent
from creak.studies.file.reader import read_study
from creak.studies.models.reference import build_reference, static_shapes
from creak.studies.prepare.setup import set_up
from helpers_decks import STUDY, two_strips, write_strips


def test_a_structure_that_only_contact_holds_has_none(tmp_path):
    text = STUDY.replace('node_set = "ROOT_UPPER"', 'node_set = "PAIRS"').replace(
        'kind = "displacement"', 'kind = "force"'
    )
    deck = two_strips().replace("ROOT_UPPER, 1, 2", "ROOT_UPPER, 1, 3")
    path = write_strips(tmp_path, deck, text.replace("f_max = 3000", 'method = "gap-modes"'))
    setup = set_up(read_study(path))
    reference = build_reference(setup.structure, setup.band, silent)
    shapes = static_shapes(reference, setup.reduction)
    assert shapes.shape == (reference.system.n, 1)
    pushed = np.asarray(reference.system.K @ shapes[:, 0])
    assert np.abs(pushed).sum() == pytest.approx(4.0, rel=1e-6)  # one on each of four nodes
    with pytest.raises(InputError, match="only contact holds the structure"):
        static_shapes(replace(reference, stiffness=None), setup.reduction)
