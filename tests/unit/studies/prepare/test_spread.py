"""What happens within less than a step keeps its impulse, wherever the samples fall."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

import creak
from creak.signals.sources import Table
from creak.signals.vibration import HalfSine
from creak.studies.file.reader import read_study
from creak.studies.prepare.spread import resolved
from helpers_decks import write_study

RECORDED = {"section": "time"}

T = np.arange(3001) * 1e-5
"""A thousand steps of 3e-5 s."""
WIDTHS = [1e-8, 1e-6, 3e-6, 1e-5, 3e-5, 1e-4]


def told(a):
    """What accelerations at the samples make of the velocity, by cubics."""
    return 0.375e-5 * (a[0:-1:3] + 3.0 * a[1::3] + 3.0 * a[2::3] + a[3::3]).sum()


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("start", [0.0, 1e-3, 1.0003e-3, 1.0007e-3, 1.001e-3])
def test_a_rise_of_velocity_has_its_impulse(start, width):
    table = Table(np.array([-1.0, start, start + width, 1.0]), np.array([0.0, 0.0, 100.0, 100.0]))
    motion = resolved(partial(table.motion, order=1), T)
    assert motion.velocity[[0, -1]] == pytest.approx([0.0, 100.0], abs=2.0)
    assert told(motion.acceleration) == pytest.approx(100.0, rel=0.02)
    assert motion.displacement[-1] == pytest.approx(100.0 * (T[-1] - start - 0.5 * width), abs=100.0 * 3e-5 * 1.01)
    slope = np.gradient(motion.displacement, T)[1:-1]
    assert np.abs(slope - motion.velocity[1:-1]).max() < 0.09 * 100.0  # a corner between two samples: a h / 4


@pytest.mark.parametrize("width", WIDTHS[1:])
@pytest.mark.parametrize("start", [1e-3, 1.0004e-3])
def test_a_shock_has_its_impulse(start, width):
    shock = HalfSine(2e5, width, start)
    motion = resolved(partial(shock.motion, order=2), T)
    assert told(motion.acceleration) == pytest.approx(2e5 * 2.0 * width / np.pi, rel=0.02)


def test_what_the_samples_follow_stays_as_it_is():
    table = Table(np.array([0.0, 0.005, 0.01, 0.02]), np.array([0.0, 3.0, -5.0, 1.0]), 0.2)
    for motion_of in (partial(table.motion, order=1), partial(HalfSine(1.0, 5e-3, 1e-3).motion, order=2)):
        assert np.array_equal(resolved(motion_of, T).acceleration, motion_of(T).acceleration)


DECK = """*NODE
1,0.,0.,0.
2,10.,0.,0.
3,0.,0.,1.
*NSET,NSET=B
1
*ELEMENT,TYPE=MASS,ELSET=M
1,2
*MASS,ELSET=M
2.
*ELEMENT,TYPE=ROTARYI,ELSET=R
2,2
*ROTARY INERTIA,ELSET=R
100.,100.,100.
*MPC
BEAM,2,1
*ELEMENT,TYPE=SPRING1,ELSET=S
3,1
*SPRING,ELSET=S
5
4.E6
*BOUNDARY
1,1,2
1,4
1,6
3,1,6
"""
STUDY = """[model]
deck = "arm.inp"
units = "mm-t-s"
[damping]
modal = 0
[excitation.b]
node_set = "B"
dof = "z"
kind = "velocity"
signal = {{ type = "table", values = [[0, 0], [{start}, 0], [{end}, 100], [1, 100]] }}
[[connector]]
type = "play"
nodes = ["BASE", "END"]
dof = "z"
lower = -0.65
stiffness = 1000.0
[nodes.BASE]
labels = [1]
[nodes.END]
labels = [2]
[time]
end = 0.04
[output]
nodes = ["B"]
"""


@pytest.mark.parametrize(("start", "width"), [(1e-3, 3e-5), (1.0005e-3, 3e-5), (1e-3, 3e-6), (1.003e-3, 1e-8)])
def test_an_arm_on_a_base_that_is_set_going_swings_as_far(tmp_path, measured, start, width):
    """A mass of 2 t on an arm of 10 mm, I = 300 t mm2 about the base, k = 4e6 N mm: theta = m L v / sqrt(k I)."""
    study_path = write_study(tmp_path, STUDY.format(start=start, end=start + width), {"arm.inp": DECK})
    found = creak.run(read_study(study_path), converge=False)
    measured(
        f"arm on a base that is set going within {width:g} s, from {start:g} s on: swing",
        0.65 - float(found.main.history.gap.min()),
        expected=10.0 * 2.0 * 10.0 * 100.0 / np.sqrt(4e6 * 300.0),
        rel=2e-3,
        unit="mm",
        source="closed form",
    )
