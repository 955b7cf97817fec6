"""E-lines under static loads: what these close of a gap is missing from it, whether or not contact is there."""

from __future__ import annotations

import pytest

from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import run_study
from creak.studies.run.screen import screen
from helpers_decks import STUDY, two_strips, write_strips

LENGTH, WIDTH, THICK, YOUNG = 120.0, 20.0, 1.0, 210e3
"""Of the upper strip, mm and MPa."""
FORCE = 0.2
"""N on each of three nodes of its tip, down."""
LOADED = f'\n[[static]]\nnode_set = "TIP_UPPER"\ndof = "z"\nforce = {-FORCE}\n'
LINE = '\n[eline.end]\nmain = "TIP_LOWER"\nsecondary = "TIP_UPPER"\n'
EXACT = STUDY.replace("step = 5e-4\n", 'accuracy = "quick"\n').replace("[time]", "[reference]\nrun = false\n\n[time]")


def quiet(*_):
    """No progress."""


def made(folder, study, gap=5.0):
    folder.mkdir()
    return set_up(read_study(write_strips(folder, two_strips(gap), study + LINE)))


def closing(found, measures):
    """Largest at the nodes of the tip."""
    own = found.line_of == [line.name for line in found.lines].index("end")
    return float(getattr(found, measures).closing[own].max())


@pytest.fixture(scope="module")
def bent(tmp_path_factory):
    """The tip's deflection by beam theory, and the closing with and without the load: screened, and of a run."""
    folder, kept = tmp_path_factory.mktemp("loaded"), EXACT.replace("[time]", "[precheck]\nenabled = false\n\n[time]")
    plain, loaded = (
        (screen(made(folder / f"s{k}", EXACT + more), quiet), run_study(made(folder / f"r{k}", kept + more), quiet))
        for k, more in enumerate(("", LOADED))
    )
    return plain, loaded


def test_a_screened_line_has_the_static_share(bent):
    (plain, _), (loaded, _) = bent
    deflection = 3.0 * FORCE * LENGTH**3 / (3.0 * YOUNG * WIDTH * THICK**3 / 12.0)
    assert deflection > 0.3
    assert closing(loaded, "linear") - closing(plain, "linear") == pytest.approx(deflection, rel=0.03)


def test_so_have_both_runs(bent):
    (_, plain), (_, loaded) = bent
    deflection = 3.0 * FORCE * LENGTH**3 / (3.0 * YOUNG * WIDTH * THICK**3 / 12.0)
    for measures in ("linear", "contact"):
        more = closing(loaded.elines, measures) - closing(plain.elines, measures)
        assert more == pytest.approx(deflection, rel=0.03)
    lowest = loaded.runs["reduced"].line_motion.motion[..., 2].min()
    assert -lowest == pytest.approx(loaded.elines.contact.closing.max(), rel=0.05)
