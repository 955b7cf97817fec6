"""Where a run ends beside the time that the study gives."""

from __future__ import annotations

import re

import pytest

from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import Setup, set_up
from helpers_decks import STUDY, write_strips


def ready(folder, end: float) -> Setup:
    text = STUDY.replace("step = 5e-4\n", "").replace("periods = 2\n", f"end = {end}\n")
    return set_up(read_study(write_strips(folder, study=text)))


@pytest.mark.parametrize("share", [2.0, 2.06185, 2.00021])
def test_a_run_that_ends_beside_the_time_that_is_given_says_so(tmp_path, share):
    """Steps divide the period of the excitation: two periods are whole ones, a little more is not."""
    period = float(re.search(r"period = ([.\d]+)", STUDY)[1])
    setup = ready(tmp_path, share * period)
    step, last = setup.study.config.time.step, float(setup.loads.time[-1])
    assert period / step == pytest.approx(round(period / step), rel=1e-9)
    assert last == pytest.approx(round(share * period / step) * step, rel=1e-9)
    over = last - share * period
    word = "after" if over > 0.0 else "before"
    expected = [
        f"the run ends at {last:.7g} s, {abs(over):.2g} s {word} [time] end: it is made of whole steps of {step:.4g} s"
    ]
    assert [n for n in setup.notes if "[time] end" in n] == ([] if share == 2.0 else expected)
