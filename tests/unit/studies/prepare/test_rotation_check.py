"""Moments, rotations and stops in rotation where nodes have none; static displacements given twice."""

from __future__ import annotations

import pytest

from creak.errors import InputError
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from helpers_decks import STOP

HEAD = '[model]\ndeck = "m.inp"\nunits = "m-kg-s"\n[damping]\nmodal = 0.02\n[time]\nend = 0.1\n'
SINE = 'signal = { type = "sine", frequency = 10.0, amplitude = 1.0 }\n'
MOMENT = f'[excitation.m]\nnode_set = "TIP"\ndof = "rx"\nkind = "force"\n{SINE}'
INERTIA = STOP.replace(
    "*INITIAL", "*ELEMENT, TYPE=ROTARYI, ELSET=R\n9, 1\n*ROTARY INERTIA, ELSET=R\n1., 1., 1.\n*INITIAL"
)


def made(folder, tables, deck=STOP):
    (folder / "m.inp").write_text(deck)
    (folder / "s.toml").write_text(HEAD + tables)
    return set_up(read_study(folder / "s.toml"))


@pytest.mark.parametrize(
    ("tables", "says"),
    [
        (MOMENT, r"s.toml:10.*a moment acts on rx of node 1, which has no rotations"),
        (MOMENT.replace('"force"', '"displacement"'), "a prescribed rotation acts on rx of node 1"),
        ('[[static]]\nforce = 3.0\nnode_set = "TIP"\ndof = "ry"\n', "a static moment acts on ry of node 1"),
        ('[[static]]\ndisplacement = 0.1\nnode_set = "TIP"\ndof = "rz"\n', "a static rotation acts on rz of node 1"),
        (
            '[[connector]]\ntype = "play"\nnodes = ["TIP"]\ndof = "ry"\nlower = -0.1\nstiffness = 1e3\n',
            "a connector acts on ry of node 1",
        ),
        (
            2 * '[[static]]\ndisplacement = 0.1\nnode_set = "TIP"\ndof = "y"\n',
            "two static displacements move node 1 y",
        ),
    ],
)
def test_what_would_be_lost_is_refused(tmp_path, tables, says):
    with pytest.raises(InputError, match=says):
        made(tmp_path, tables)


def test_an_inertia_turns(tmp_path):
    assert made(tmp_path, MOMENT, INERTIA).loads.force.any()
