"""RSSCON: shells clamped to solids."""

from __future__ import annotations

import numpy as np
import pytest

from creak.assembly.constraints import linear_equations
from creak.errors import InputError
from helpers_fem import rigid_modes
from helpers_nastran import motion, read, row

N, LENGTH, P = 8, 80.0, 0.01
BLOCK = {1: (-10, 0, -1), 2: (0, 0, -1), 3: (0, 10, -1), 4: (-10, 10, -1)}
BLOCK |= {k + 4: (x, y, 1) for k, (x, y, _) in BLOCK.items()}


def deck(card: str) -> str:
    """A strip of N quads on the face x = 0 of a stiff block that is held behind."""
    places = BLOCK | {11 + 2 * i + j: (LENGTH * i / N, 10 * j, 0) for i in range(N + 1) for j in range(2)}
    lines = [f"GRID,{k},,{x:.4f},{y:.1f},{z:.1f}" for k, (x, y, z) in places.items()]
    lines += [f"CQUAD4,{i + 1},1,{11 + 2 * i},{13 + 2 * i},{14 + 2 * i},{12 + 2 * i}" for i in range(N)]
    lines += ["CHEXA,99,2,1,2,3,4,5,6,+", "+,7,8", "PSOLID,2,2", "PSHELL,1,1,1.,1,,1"]
    lines += ["MAT1,1,7.+4,,0.,2.7-9", "MAT1,2,7.+9,,0.,2.7-9", "SPC1,1,123,1,4,5,8", card]
    return "\n".join(lines)


GRIDS = "RSSCON,50,GRID,11,2,6,12,3,7"


def test_a_strip_on_a_stiff_block_is_a_cantilever(tmp_path):
    model = read(tmp_path, deck(GRIDS))
    tips = (11 + 2 * N, 12 + 2 * N)
    sunk = motion(model, {(tip, 3): 0.5 * P for tip in tips})[row(model, tips[0])]
    assert sunk[2] == pytest.approx(P * LENGTH**3 / (3 * 7e4 * 10 / 12), rel=5e-3)
    pulled = motion(model, {(tip, 1): 0.5 * P for tip in tips})[row(model, tips[0])]
    assert pulled[0] == pytest.approx(P * LENGTH / (7e4 * 10), rel=1e-3)


def test_rigid_motion_breaks_no_equation_and_a_kink_does(tmp_path):
    model = read(tmp_path, deck(GRIDS))
    equations = [e for c in model.constraints for e in linear_equations(c, model.nodes.coords)]
    assert len(equations) == 2 * 5
    modes = rigid_modes(model.nodes.coords)
    assert max(abs(modes[list(e.labels)].T @ e.coefficients).max() for e in equations) < 1e-12
    kink = np.zeros((model.nodes.count, 6))
    kink[row(model, 11), 4] = 1.0
    assert max(abs(kink.ravel()[list(e.labels)] @ e.coefficients) for e in equations) == pytest.approx(1.0)


def test_what_cannot_be_joined_is_told(tmp_path):
    with pytest.raises(InputError, match="grid 13 of RSSCON 50 does not lie between grids 2 and 6"):
        read(tmp_path, deck("RSSCON,50,GRID,13,2,6"))
    (found,) = [u for u in read(tmp_path, deck("RSSCON,50,ELEM,1,99")).unread if u.changes_answer]
    assert found.keyword == "RSSCON, TYPE = ELEM"
