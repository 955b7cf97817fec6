"""[contact.NAME] of the study file as contact pairs; tables of clearances."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.decks import read_model
from creak.studies.file.config import StudyConfig
from creak.studies.file.places import Places
from creak.studies.file.reader import Study
from creak.studies.prepare.pairs import contact_channels, contact_pair, plays_of
from helpers_decks import STUDY, write_strips


def study(tmp_path: Path, lines: str = "", table: str | None = None) -> Study:
    """The two strips with further lines in [contact.tip]; checked by the configuration alone."""
    text = STUDY.replace('method = "surface-to-surface"\n', 'method = "surface-to-surface"\n' + lines)
    path = write_strips(tmp_path, study=text)
    if table is not None:
        (tmp_path / "gaps.csv").write_text(table, encoding="utf-8")
    return Study(StudyConfig.model_validate(tomllib.loads(text)), text, Places(path, text))


def pair_of(tmp_path: Path, lines: str, table: str | None = None):
    s = study(tmp_path, lines, table)
    return contact_pair(read_model(s.places.sibling("strips.inp")), s.touching, "tip")


def test_defaults(tmp_path):
    pair = pair_of(tmp_path, "")
    assert (pair.law.stiffness, pair.clearance, pair.normal, pair.law.curve) == (None, None, None, None)
    assert (pair.law.damping, pair.law.friction) == (0.0, (0.0, 0.0, 0.0))


def test_laws_are_passed_on(tmp_path):
    pair = pair_of(tmp_path, 'stiffness = "hard"\nnormal = [0, 0, 1]\nfriction = 0.2\nclearance = 3\n')
    assert (pair.law.stiffness, pair.clearance, pair.normal, pair.law.friction) == (
        np.inf,
        3.0,
        (0, 0, 1),
        (0.2, 0.2, 0.0),
    )
    pair = pair_of(
        tmp_path, "overclosure = [[0, 0], [0.1, 2]]\nfriction = { static = 0.3, kinetic = 0.2, decay = 4 }\n"
    )
    assert pair.law.friction == (0.3, 0.2, 4.0)
    np.testing.assert_array_equal(pair.law.curve, [[0, 0], [0.1, 2]])
    with pytest.raises(InputError, match=r"study.toml:\d+ .*both stiffness = 5.0 and an overclosure curve"):
        pair_of(tmp_path, "overclosure = [[0, 0], [0.1, 2]]\nstiffness = 5\n")


def test_clearances_of_a_table_reach_the_channels(tmp_path):
    s = study(tmp_path, 'clearance = "gaps.csv"\n', "node,clearance,tolerance\n35,0.25,0.1\n\n37, 0.5 ,0.1\n")
    model = read_model(s.places.sibling("strips.inp"))
    gaps, notes = contact_channels(model, s.touching)
    at = {model.nodes.label(int(i)): g for i, g in zip(gaps.nodes_idx, gaps.gap0, strict=True)}
    assert (at["35"], at["37"]) == (0.25, 0.5)
    plain, _ = contact_channels(model, study(tmp_path).touching)
    other = [k for k, i in enumerate(gaps.nodes_idx) if model.nodes.label(int(i)) not in ("35", "37")]
    np.testing.assert_array_equal(gaps.gap0[other], plain.gap0[other])
    assert "have no row in the table of clearances and keep their geometric gap" in notes[0]


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (None, r"study.toml:\d+ .*no such table of clearances: .*gaps.csv"),
        ("", "gaps.csv:1: the table starts with nothing; expected the header node,clearance"),
        ("node,gap\n", "gaps.csv:1: the table starts with node,gap"),
        ("node,clearance\n", "gaps.csv: the table has no rows"),
        ("node,clearance\n35,1\n99999,1\n", "gaps.csv:3: unknown node 99999"),
        ("node,clearance\n1001,1\n", "gaps.csv:2: node 1001 is not on 'UNDER'"),
        ("node,clearance\n\n,1\n", "gaps.csv:3: a row without a node"),
        ("node,clearance\n35,\n", "gaps.csv:2: the clearance of node 35 is ''; expected a finite number"),
        ("node,clearance\n35\n", "gaps.csv:2: the clearance of node 35 is ''"),
        ("node,clearance\n35,nan\n", "gaps.csv:2: the clearance of node 35 is 'nan'"),
        ("node,clearance\n35,1 mm\n", "gaps.csv:2: the clearance of node 35 is '1 mm'"),
        ("node,clearance\n35,1\n35,2\n", "gaps.csv:3: node 35 has a second row"),
    ],
)
def test_wrong_tables_are_refused_with_file_and_line(tmp_path, table, message):
    with pytest.raises(InputError, match=message):
        pair_of(tmp_path, 'clearance = "gaps.csv"\n', table)


def test_preload_of_a_connector_reaches_the_play(tmp_path):
    s = study(tmp_path)
    text = (
        s.text + '\n[[connector]]\ntype = "play"\nnodes = "PAIRS"\ndof = "z"\nupper = 0\nstiffness = 10\npreload = 2\n'
    )
    ((play, _),) = plays_of(Study(StudyConfig.model_validate(tomllib.loads(text)), text, Places(s.path, text)).touching)
    assert (play.upper, play.lower, play.law.preload) == (0.0, None, 2.0)


def channels_with(tmp_path: Path, more: str):
    """Gaps and notes of the strips' contact and a second one, [contact.again]."""
    s = study(tmp_path)
    text = s.text + f"\n[contact.again]\n{more}"
    s = Study(StudyConfig.model_validate(tomllib.loads(text)), text, Places(s.path, text))
    return contact_channels(read_model(s.places.sibling("strips.inp")), s.touching)


BESIDE = 'secondary = "UNDER"\nmain = "OVER"\nmethod = "surface-to-surface"\n'


def test_a_contact_given_twice_is_refused(tmp_path):
    """It would press with twice its stiffness; from another gap on it is a second spring, which is meant."""
    with pytest.raises(
        InputError, match=r"study.toml:\d+ .*contact again is the same as contact tip: both would press"
    ):
        channels_with(tmp_path, BESIDE)
    gaps, notes = channels_with(tmp_path, BESIDE + "clearance = 7.0\n")
    assert gaps.m == 2 * (gaps.gap0 == 7.0).sum()
    assert not any("both press" in str(note) for note in notes)


def test_a_contact_given_both_ways_round_is_told(tmp_path):
    _, notes = channels_with(tmp_path, 'secondary = "OVER"\nmain = "UNDER"\n')
    assert any("contacts tip and again are of the same surfaces" in str(note) for note in notes)
