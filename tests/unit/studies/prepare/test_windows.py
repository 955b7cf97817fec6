"""What of a run is counted: the last period of all that drives it together, of many the second half, or the whole run.

Where a run ends beside the time that the study gives.
What the start of a run says of a model: elements without a mass of their own.
"""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import creak
from creak.studies.file.case import Touching
from creak.studies.file.config import PrecheckTable
from creak.studies.file.places import Places
from creak.studies.file.reader import read_study
from creak.studies.prepare.marching import excitation_window
from creak.studies.prepare.setup import Setup, set_up
from creak.studies.prepare.start_check import start_warnings
from helpers_decks import STUDY, two_strips, write_strips
from helpers_nastran import read

SHOCK = 'type = "smooth-step", values = [[0, 0], [0.01, 0.6], [0.02, 0]]'
PLAIN = """[model]
deck = "strips.inp"
[contact.tip]
secondary = "UNDER"
main = "OVER"
clearance = 0.3
[time]
end = 0.2
[reference]
run = false
"""


DRIVEN = (
    '[excitation.e0]\nnode_set = "ROOT_UPPER"\ndof = "z"\nsignal = {{ {} }}\n',
    '[excitation.e1]\nnode_set = "TIP_LOWER"\ndof = "z"\nkind = "force"\nsignal = {{ {} }}\n',
)


def study_of(folder, *signals):
    """Displacement of one strip's root, force at the other's tip."""
    (folder / "strips.inp").write_text(two_strips())
    driven = "".join(text.format(signal) for text, signal in zip(DRIVEN, signals, strict=False))
    (folder / "study.toml").write_text(PLAIN + driven)
    return creak.read_study(folder / "study.toml")


def sine(frequency, amplitude=1.0):
    return f'type = "sine", frequency = {frequency}, amplitude = {amplitude}'


@pytest.mark.parametrize(
    ("signals", "longest", "together"),
    [
        ([sine(10.0), sine(10.5)], 0.1, 2.0),
        ([sine(40.0), sine(20.0)], 0.05, 0.05),
        ([sine(30.0), sine(31.7)], 1.0 / 30.0, 10.0),
        ([sine(10.0), sine(10.0 * math.pi)], 0.1, None),
        ([sine(10.0), SHOCK], 0.1, None),
        ([SHOCK], None, None),
    ],
)
def test_all_begin_again_together(tmp_path, signals, longest, together):
    course = study_of(tmp_path, *signals).course
    assert course.period == pytest.approx(longest)
    assert course.repeats == pytest.approx(together)


@pytest.mark.parametrize(("end", "start"), [(0.5, 0.4), (1.0, 0.9), (1.1, 0.6), (3.04, 1.54)])
def test_of_many_periods_the_second_half_counts(tmp_path, end, start):
    """Contact that comes back in every third period is in it."""
    study = creak.change_study(study_of(tmp_path, sine(10.0)), {"time.end": end})
    assert excitation_window(study.course, np.array([0.0, end])) == pytest.approx((start, end))


def test_a_shock_beside_a_hum_is_counted(tmp_path):
    """What hit in the first hundredth of a second is what rattles, however small a sine goes on beside it."""
    study = creak.change_study(study_of(tmp_path, SHOCK, sine(40.0, 1e-4)), {"time.end": 0.1})
    result = creak.run(study, converge=False)
    assert result.found.window == pytest.approx((0.0, 0.1), rel=1e-6)
    places = result.summary["runs"]["reduced"]["places"]
    alone = creak.run(creak.change_study(study, {"excitation.e1.signal.amplitude": 1e-9}), converge=False)
    assert places
    assert places[0]["force"] == pytest.approx(alone.summary["runs"]["reduced"]["places"][0]["force"], rel=0.02)


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


PLATE = "GRID,1,,0.,0.,0.\nGRID,2,,40.,0.,0.\nGRID,3,,40.,20.,0.\nGRID,4,,0.,20.,0.\nCQUAD4,1,1,1,2,3,4\n"


@pytest.mark.parametrize(("rho", "nsm", "told"), [("", "", 1), ("7.85-9", "", 0), ("", "3.-9", 0)])
def test_elements_without_density_are_told_where_no_mass_per_area_is_theirs(tmp_path, rho, nsm, told):
    model = read(tmp_path, f"{PLATE}PSHELL,1,1,1.,1,,1,,{nsm}\nMAT1,1,210000.,,.3,{rho}\n")
    touching = Touching({}, (), (), None, False, "mm-t-s", Places(tmp_path / "study.toml"))
    said = start_warnings(model, touching, PrecheckTable())
    assert len([words for words in said if "no mass of their own" in words]) == told
