"""What of a run is counted: the last period of all that drives it together, of many the second half, or the whole run."""

from __future__ import annotations

import math

import numpy as np
import pytest

import creak
from creak.studies.prepare.output_steps import excitation_window
from helpers_decks import two_strips

SHOCK = 'type = "smooth-step", values = [[0, 0], [0.01, 0.6], [0.02, 0]]'
STUDY = """[model]
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
    (folder / "study.toml").write_text(STUDY + driven)
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
    study = study_of(tmp_path, SHOCK, sine(40.0, 1e-4))
    result = creak.run(study, converge=False)
    assert result.found.window == pytest.approx((0.0, 0.2), rel=1e-6)
    places = result.summary["runs"]["reduced"]["places"]
    alone = creak.run(creak.change_study(study, {"excitation.e1.signal.amplitude": 1e-9}), converge=False)
    assert places
    assert places[0]["force"] == pytest.approx(alone.summary["runs"]["reduced"]["places"][0]["force"], rel=0.02)
