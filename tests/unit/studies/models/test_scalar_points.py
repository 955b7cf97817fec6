"""Scalar points have mass and no direction: rigid motion, weight and effective mass leave them out, as in Nastran."""

from __future__ import annotations

import numpy as np
import pytest

from creak.studies.file.reader import read_study
from creak.studies.models.deck_modes import deck_modes
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import run_study

CARRIED, INNER, SPRING, TIE, GRAVITY = 1e-3, 5e-3, 100.0, 40.0, 9810.0
BULK = (
    "GRID,1,,0.,0.,0.\nGRID,2,,10.,4.,0.\nSPOINT,50\nSPC1,1,123456,1\nSPC1,1,23456,2\n"
    f"CONM2,5,2,,{CARRIED}\nCELAS2,6,{SPRING},1,1,2,1\nCELAS2,7,{TIE},2,1,50\nCMASS2,8,{INNER},50\n"
)
STUDY = f"""\
[model]
deck = "deck.bdf"
units = "mm-t-s"
[damping]
modal = 0.05
[[static]]
gravity = [{GRAVITY}, 0.0, 0.0]
[nodes.P]
labels = [2]
[excitation.f]
node_set = "P"
dof = "x"
kind = "force"
signal = {{ type = "sine", frequency = 10, amplitude = 1e-9 }}
[time]
end = 0.02
[output]
nodes = ["P"]
"""


@pytest.fixture
def deck(tmp_path):
    path = tmp_path / "deck.bdf"
    path.write_text(f"SOL 103\nCEND\nSPC = 1\nBEGIN BULK\n{BULK}ENDDATA\n", encoding="utf-8")
    return path


def test_a_scalar_point_has_no_rigid_motion(deck):
    """L = phi' M R with the mass of the grid alone; its two modes share it as the 2 x 2 problem says."""
    found = deck_modes(deck)
    M, K = np.diag([CARRIED, INNER]), np.array([[SPRING + TIE, -TIE], [-TIE, TIE]])
    root = np.sqrt(np.diag(M))
    omega2, shapes = np.linalg.eigh(K / np.outer(root, root))
    assert found.frequencies == pytest.approx(np.sqrt(omega2) / (2.0 * np.pi), rel=1e-9)
    assert found.effective.effective[:, 0] == pytest.approx((root[0] * shapes[0]) ** 2, rel=1e-9)
    assert found.mass == pytest.approx(CARRIED, rel=1e-12)
    x, y = 10.0, 4.0
    J = [y * y, x * x, x * x + y * y]
    assert np.diag(found.effective.rigid_mass)[3:] == pytest.approx(CARRIED * np.array(J), rel=1e-12)


def test_gravity_does_not_pull_on_a_scalar_point(deck):
    """u = m g / k of the mass at the grid, with which the scalar point goes along."""
    study = deck.with_suffix(".toml")
    study.write_text(STUDY, encoding="utf-8")
    setup = set_up(read_study(study))
    result = run_study(setup, lambda *_: None)
    assert result.setup.static.displacement[6] == pytest.approx(CARRIED * GRAVITY / SPRING, rel=1e-9)
    assert result.reference.system.stats.mass == pytest.approx(CARRIED, rel=1e-12)
