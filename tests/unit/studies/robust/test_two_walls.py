"""`creak robust` of a tongue in a slot: a drawn clearance holds for the nearest wall, as in a run of the study."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import creak
from creak.progress import silent
from creak.studies.file.changes import with_changes
from creak.studies.file.reader import read_study
from creak.studies.models.reference import build_reference
from creak.studies.prepare.setup import Setup, set_up
from creak.studies.robust.changes import drawn_setup
from creak.studies.robust.draws import Draw
from creak.studies.robust.job import fields_of
from creak.studies.robust.shared_model import lowest_of
from helpers_decks import STEEL, patch, write_study

NEAR, FAR = 1.0, 2.0
"""mm between the tongue and the walls."""
SIDE, WIDE = ((0.0, 40.0, 0.0), (0.0, 0.0, 40.0)), ((0.0, 60.0, 0.0), (0.0, 0.0, 60.0))
DECK = (
    patch(1, "TONGUE", (0.0, 0.0, 0.0), *SIDE)
    + patch(101, "WALLP", (NEAR + 1.0, -10.0, -10.0), *WIDE)
    + patch(201, "WALLM", (-FAR - 1.0, -10.0, -10.0), *WIDE)
    + "*ELSET, ELSET=WALLS\nWALLP, WALLM\n*NSET, NSET=ROOT\n1, 2, 3, 4, 5\n*NSET, NSET=TOP\n21, 22, 23, 24, 25\n"
    + "*NSET, NSET=HELD, GENERATE\n101, 125\n201, 225\n"
    + STEEL
    + "".join(f"*SHELL SECTION, ELSET={s}, MATERIAL=STEEL\n1.0\n" for s in ("TONGUE", "WALLP", "WALLM"))
    + "*BOUNDARY\nROOT, 1, 6\nHELD, 1, 6\n"
)
STUDY = """[model]
deck = "slot.inp"
[damping]
modal = 0.02
[contact.slot]
secondary = "TONGUE"
main = "WALLS"
method = "METHOD"
clearance = 1.4
[excitation.top]
node_set = "TOP"
dof = "x"
kind = "force"
signal = { type = "sine", frequency = 100, amplitude = -10.0 }
[reduction]
f_max = 5000
[time]
end = END
[precheck]
margin = 5.0
[scatter.vary]
"contact.slot.clearance" = SCATTER
"""
UNIFORM = '{ type = "uniform", low = 1.3, high = 1.5 }'
METHODS = "node-to-surface", "surface-to-surface"


def slot(folder: Path, method: str, scatter: str = UNIFORM, end: float = 0.0145) -> Setup:
    path = write_study(
        folder, STUDY.replace("METHOD", method).replace("SCATTER", scatter).replace("END", str(end)), {"slot.inp": DECK}
    )
    return set_up(read_study(path))


@pytest.mark.parametrize("method", METHODS)
def test_a_drawn_clearance_holds_for_the_nearest_wall(tmp_path, method):
    setup, draw = slot(tmp_path, method), Draw(0, {"contact.slot.clearance": 1.3}, {})
    gaps = drawn_setup(setup, draw).contacts.gap0
    further = np.array([name.count(":") == 2 for name in setup.contacts.names])
    assert gaps[~further] == pytest.approx(1.3)
    assert gaps[further] == pytest.approx(FAR)
    assert np.array_equal(gaps, set_up(with_changes(setup.study, draw.values)).contacts.gap0)


def test_a_draw_of_a_slot_is_that_of_a_run(tmp_path):
    """The far wall, which a load away from the near one reaches, is where it was."""
    setup = slot(tmp_path, "node-to-surface")
    draws = creak.robust(setup.study, 4, indices=False, threads=1).draws
    for k in (0, 3):
        values = draws.drawn.draw(k).values
        changed = with_changes(setup.study, {**values, "reference.run": False})
        events = creak.run(changed, converge=False, record=False).runs["reduced"].events
        assert draws.figures[k, 0, 0] == len(events) > 0
        assert draws.figures[k, 0, 1] == pytest.approx(sum(event.impulse for event in events), rel=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_the_mean_of_a_field_is_that_of_the_nearest_wall(tmp_path, method):
    """The far gaps scatter about their own, however short the run is."""
    setup = slot(tmp_path, method, '{ type = "field", mean = 0.5, tolerance = 0.3, length = 20 }', end=1e-3)
    (cause,) = creak.robust(setup.study, 4, indices=False, threads=1).draws.design.causes
    further = np.array([name.count(":") == 2 for name in cause.names])
    assert cause.names == fields_of(setup.contacts, setup.model.nodes)["slot"].names
    assert cause.mean[~further] == pytest.approx(0.5)
    assert cause.mean[further] == pytest.approx(FAR)


def test_the_pre_check_counts_the_nearest_wall_alone(tmp_path):
    """A smaller clearance lets only its gaps fall."""
    setup = slot(tmp_path, "node-to-surface")
    reference = build_reference(setup.structure, setup.band, silent)
    lowest = lowest_of(setup, reference, [Draw(0, {"contact.slot.clearance": 1.1}, {})])
    further = np.array([name.count(":") == 2 for name in setup.contacts.names])
    assert lowest[~further] == pytest.approx(-0.3)
    assert not lowest[further].any()
