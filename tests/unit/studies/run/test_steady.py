"""A quiet run under an excitation that repeats: has its motion come to repeat as well? The response of a mass on a
spring from rest at resonance is known: A (1 - exp(-zeta omega t)) cos(omega t), A = p / (2 zeta k)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.dynamics.flow.march import SAMPLES, simulate_flow
from creak.dynamics.history import History
from creak.dynamics.record.recorder import OutputRequest
from creak.reduction.diagonal import diagonalise
from creak.studies.file.signals.tables import MultisineTable, RecordTable, SineTable
from creak.studies.file.signals.vibration import PsdTable
from creak.studies.run.steady import faded_in, may_still_close
from helpers_core import channels, forces_on, system_of

OMEGA, ZETA = 2.0 * np.pi * 10.0, 0.02
FINAL = 1.0 / (2.0 * ZETA * OMEGA**2)


def told(periods: int, gap: float, period: float | None = 0.1, pushed: float = np.inf) -> tuple[str, float]:
    """The sentence, and how far the motion has come, over what it comes to.

    Parameters
    ----------
    pushed : s after which nothing drives the mass any more.
    """
    time = np.linspace(0.0, 0.1 * periods, SAMPLES * 40 * periods + 1)
    loads = forces_on(time, [0], np.sin(OMEGA * time) * (time < pushed))
    mass = system_of(np.eye(1), np.array([[OMEGA**2]]), alpha=2.0 * ZETA * OMEGA)
    gaps = channels([[-1.0]], gap, 1e3 * OMEGA**2)
    history = simulate_flow(diagonalise(mass), gaps, loads, OutputRequest(np.array([0])))
    return may_still_close(history, gaps, period, "mm"), (gap - history.gap.min()) / FINAL


def test_motion_that_grows_towards_the_gap_is_told():
    """At the last peak on that side, after 4.5 periods, it is at 1 - exp(-9 pi zeta) = 43 % of where it ends."""
    said, reached = told(5, 0.7 * FINAL)
    assert reached == pytest.approx(1.0 - np.exp(-9.0 * np.pi * ZETA), rel=0.02)
    assert said.startswith("the motion does not repeat yet: gap")
    # 5 % of what is left: ln 20 / (2 pi zeta) = 24 periods.
    assert said.count(" mm in the ") == 2
    assert said.endswith("make it 24 periods longer")


@pytest.mark.parametrize(("periods", "gap"), [(5, 1.1), (60, 1.02), (60, 2.0)])
def test_motion_that_stays_below_the_gap_is_quiet(periods, gap):
    said, reached = told(periods, gap * FINAL)
    assert reached < 1.0
    assert said == ""


def test_motion_that_dies_away_is_quiet():
    """Its first swing is its largest: pi / 2 p / k = pi zeta A by a push of half a sine of its own period."""
    said, reached = told(5, 0.065 * FINAL, pushed=0.05)
    assert reached == pytest.approx(np.pi * ZETA, rel=0.05)
    assert said == ""


def test_where_nothing_repeats_or_something_pressed_nothing_is_said():
    assert told(5, 0.7 * FINAL, period=None)[0] == ""
    assert told(2, 0.7 * FINAL)[0] == ""
    said, reached = told(12, 0.7 * FINAL)
    assert reached > 0.7
    assert said == ""


@pytest.mark.parametrize(("fade", "told"), [(0.0, False), (0.1, False), (0.26, True), (1.0, True)])
def test_a_quiet_run_that_is_mostly_fade_is_told(fade, told):
    """Half of a run of .5 s is to have the level that is asked for."""
    time = np.linspace(0.0, 0.5, 11)
    none = np.zeros((time.size, 1))
    quiet = History(time, none + 1.0, none, none, np.arange(11), none, np.zeros((11, 8)), 0, 0.0)
    assert bool(faded_in(quiet, fade)) == told
    assert not faded_in(replace(quiet, force=none + 1.0), fade)


def test_signals_say_how_long_motion_fades_in():
    sine = {"type": "sine", "frequency": 5.0, "amplitude": 1.0}
    psd = {"type": "psd", "unit": "g2/Hz", "values": [[10.0, 1.0], [20.0, 1.0]], "seed": 1}
    multisine = {"type": "multisine", "f_min": 5.0, "f_max": 20.0, "amplitude": 1.0, "period": 2.0, "seed": 1}
    record = {"type": "record", "file": "x.csv", "high_pass": 4.0}
    tables = [SineTable(**sine), PsdTable(**psd, duration=3.0), MultisineTable(**multisine), RecordTable(**record)]
    assert [t.fade for t in tables] == [0.0, pytest.approx(0.3), pytest.approx(0.2), 0.25]
