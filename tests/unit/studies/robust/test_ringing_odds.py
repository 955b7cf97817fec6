"""Odds of what rings far faster than the steps: a mass of 4 kHz under a load that is there at once, gaps that scatter."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

import creak

MASS, LOAD, ZETA = 1e-5, 500.0, 0.1
STIFFNESS = MASS * (2.0 * np.pi * 4e3) ** 2
CLOSES = LOAD / STIFFNESS * (1.0 + np.exp(-np.pi * ZETA / np.sqrt(1.0 - ZETA**2)))
"""Of a gap: the first swing of an oscillator that is pushed at once."""
SIGMA = 0.05 * CLOSES
DECK = f"""*NODE
2, 0., 0., 1.
*ELEMENT, TYPE=MASS, ELSET=M1
11, 2
*MASS, ELSET=M1
{MASS}
*ELEMENT, TYPE=SPRING1, ELSET=W
21, 2
*SPRING, ELSET=W
3
{float(STIFFNESS)}
*ELEMENT, TYPE=DASHPOT1, ELSET=D
22, 2
*DASHPOT, ELSET=D
3
{float(2.0 * ZETA * np.sqrt(STIFFNESS * MASS))}
*NSET, NSET=P2
2,
*BOUNDARY
P2, 1, 2
P2, 4, 6
"""
STUDY = """[model]
deck = "deck.inp"
[[connector]]
type = "play"
name = "stop"
nodes = ["P2"]
dof = "z"
upper = {gap!r}
stiffness = {stop!r}
[excitation.push]
node_set = "P2"
dof = "z"
kind = "force"
signal = {{ type = "step", amplitude = {load!r} }}
[time]
end = 0.05
[scatter]
seed = 1
[scatter.vary]
"connector.0.upper" = {{ type = "normal", sigma = {sigma!r}, low = 1e-4 }}
"""


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.95, 1.05])
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_odds_and_needed_gap_are_those_of_the_closed_form(share, tmp_path):
    gap = float(share * CLOSES)
    (tmp_path / "deck.inp").write_text(DECK)
    text = STUDY.format(gap=gap, stop=float(3.0 * STIFFNESS), load=LOAD, sigma=float(SIGMA))
    (tmp_path / "study.toml").write_text(text)
    found = creak.robust(tmp_path / "study.toml", n=64, indices=False, threads=1).as_dict()
    exact, odds = norm.cdf((1.0 - share) / 0.05), found["rattle"]
    assert odds["low"] <= exact <= odds["high"]
    assert odds["p"] == pytest.approx(exact, abs=0.02)
    assert found["places"][0]["need"]["gap"] == pytest.approx(CLOSES + norm.isf(0.05) * SIGMA, rel=5e-3)
