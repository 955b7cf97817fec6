"""Draws that are hit while the motion builds up, before the window of which the odds are, against own matrices."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lsim
from scipy.stats import norm

import creak
from creak.report.robust_page import write_robust
from creak.report.tables.robust import place_rows
from creak.studies.robust.findings import _built_up
from creak.verify.odds import odds
from helpers_decks import write_study

M, K, DASHPOT, FREQUENCY, AMPLITUDE = 1e-4, (20.0, 10.0), (50.0, 1e-5), 20.0, 0.2
MEAN, SIGMA = 0.09, 0.01
DECK = f"""*NODE
1, 0., 0., 0.
2, 10., 0., 0.
3, 20., 0., 0.
*NSET, NSET=B
1
*NSET, NSET=A
2
*NSET, NSET=E
3
*ELEMENT, TYPE=SPRING2, ELSET=S1
1, 1, 2
*SPRING, ELSET=S1
1, 1
{K[0]}
*ELEMENT, TYPE=SPRING2, ELSET=S2
2, 2, 3
*SPRING, ELSET=S2
1, 1
{K[1]}
*ELEMENT, TYPE=MASS, ELSET=MASSES
11, 2
12, 3
*MASS, ELSET=MASSES
{M}
*BOUNDARY
1, 2, 6
2, 2, 3
3, 2, 3
"""
STUDY = f"""[model]
deck = "chain.inp"
[damping.rayleigh]
alpha = {DASHPOT[0]}
beta = {DASHPOT[1]}
[[connector]]
name = "stop"
type = "play"
nodes = ["A", "E"]
dof = "x"
upper = {MEAN}
stiffness = 200.0
[excitation.b]
node_set = "B"
dof = "x"
kind = "displacement"
signal = {{ type = "sine", amplitude = {AMPLITUDE}, frequency = {FREQUENCY} }}
[time]
end = 0.2
[scatter]
seed = 3
[scatter.vary]
"connector.0.upper" = {{ type = "normal", sigma = {SIGMA} }}
"""


def most() -> tuple[float, float]:
    """Largest motion of E from A before .15 s and from then on, of two masses on a base that moves as a sine."""
    k1, k2 = K
    stiffness, pull = np.array([[k1 + k2, -k2], [-k2, k2]]), np.array([[k1], [0.0]])
    damping = DASHPOT[0] * M * np.eye(2) + DASHPOT[1] * stiffness
    a = np.block([[np.zeros((2, 2)), np.eye(2)], [-stiffness / M, -damping / M]])
    b = np.vstack([np.zeros((2, 2)), np.hstack([pull, DASHPOT[1] * pull]) / M])
    t, w = np.linspace(0.0, 0.2, 40_001), 2.0 * np.pi * FREQUENCY
    base = AMPLITUDE * np.stack([np.sin(w * t), w * np.cos(w * t)], axis=1)
    x = lsim((a, b, [[-1.0, 1.0, 0.0, 0.0]], np.zeros((1, 2))), base, t, X0=[0.0, 0.0, 0.0, 0.0])[1]
    return float(x[t < 0.15].max()), float(x[t >= 0.15].max())


def test_hits_of_the_build_up_are_told(tmp_path):
    """The gap is normal: so many draws are hit before the last period, and none in it."""
    found = creak.robust(write_study(tmp_path, STUDY, {"chain.inp": DECK}), 32, indices=False, threads=1)
    (place,), (before, later) = found.places, most()
    assert norm.cdf((later - MEAN) / SIGMA) < 1e-3
    assert place.rattle.hits == 0
    assert place.before.hits == pytest.approx(32 * norm.cdf((before - MEAN) / SIGMA), abs=1.5)
    assert place.before_alone == place.before
    row = place_rows(found)[1]
    assert row[1].endswith(f", and before the window in {100.0 * place.before.p:.3g} % more")
    assert row[-1] == "–" or row[-1].endswith(", in the window alone")
    (told,) = found.as_dict()["warnings"]
    share = f"{100.0 * place.before.p:.0f} %"
    assert told.startswith(f"stop is hit before 0.15 s, as the motion builds up, in {share} of all draws, in {share}")
    assert found.as_dict()["places"][0]["before_alone"]["hits"] == place.before.hits
    write_robust(found, tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert 0 < page.index("as the motion builds up") < page.index('id="places"')
    inside = replace(place, rattle=odds(30, 32), before_alone=odds(0, 32))
    few = replace(place, rattle=odds(30, 32), before_alone=odds(1, 32))
    assert _built_up([inside, few], found.draws) == []


def test_a_run_of_which_all_counts_has_no_build_up(tmp_path):
    study_path = write_study(tmp_path, STUDY.replace("end = 0.2", "end = 0.04"), {"chain.inp": DECK})
    found = creak.robust(study_path, 4, indices=False, threads=1)
    assert found.as_dict()["window"][0] == 0.0
    assert found.places[0].before.hits == 0
    assert not found.as_dict()["warnings"]
