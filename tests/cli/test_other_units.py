"""Decks in systems of units that no study can name: what is told in N, Pa and sone is not."""

from __future__ import annotations

import json

import pytest

from helpers_decks import STUDY, two_strips, write_strips

HEARD = STUDY.replace("periods = 2", "end = 0.1") + "\n[listener.driver]\nposition = [60.0, 10.0, 500.0]\n"


pytestmark = pytest.mark.usefixtures("no_page")


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ((("210000., 0.3", "2.1e8, 0.3"), ("7.85e-9", "7.85e-6")), "mm-kg-s"),
        ((("210000., 0.3", "210., 0.3"), ("7.85e-9", "7.85e-6")), "mm-kg-ms"),
    ],
)
def test_a_deck_all_in_units_that_no_study_can_name_has_no_loudness(creak, tmp_path, changes, name):
    deck = two_strips()
    for old, new in changes:
        deck = deck.replace(old, new)
    said = creak("run", write_strips(tmp_path, deck, HEARD), "--quick", "--out", tmp_path / "out").done()
    odd = f"the deck looks to be in {name}, not in mm-t-s as the study says"
    assert f"warning: no sound: none: {odd}" in said.err
    text = " ".join((said.out + said.err).split())
    assert f"AMBER: T{odd[1:]}, so no figure is in the unit beside it. " in text
    assert "sone" not in text.replace("nothing in N or sone", "")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["other_units"] == odd
    assert summary["sound"] == {"missing": f"none: {odd}, so nothing is known in Pa"}


def test_a_deck_in_the_units_of_its_study_is_heard(creak, tmp_path):
    assert creak("run", write_strips(tmp_path, None, HEARD), "--quick", "--out", tmp_path / "out").status == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["other_units"] is None
    assert "missing" not in summary["sound"]
