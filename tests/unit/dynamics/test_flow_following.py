"""Exact flow where modes that the filter takes off the gaps follow what the supports do."""

from __future__ import annotations

import numpy as np
import pytest

import creak
from creak.dynamics.diagonal import is_modal
from creak.dynamics.flow.march import SAMPLES, simulate_flow
from creak.dynamics.record.recorder import OutputRequest
from creak.reduction.diagonal import in_own_modes


@pytest.mark.parametrize("dashpot", [0.0, 1e-4], ids=["single", "coupled"])
def test_a_stiff_part_and_the_support_it_stands_on_keep_their_gap(dashpot, measured):
    """A grain of 1e-7 on a spring of 1e5 (160 kHz) on a base that goes 60 to and fro; beside it a mass of 70 Hz. The
    stop stands on the base as well: their gap changes by s'' / omega^2, 1e-8 of the way. The filter of what contact cannot
    resolve takes the grain's motion off the gap; what it has in common with the base must stay."""
    K = np.array([[1e5 + 200.0, -200.0, -1e5], [-200.0, 200.0, 0.0], [-1e5, 0.0, 1e5]])
    C = dashpot * np.array([[2.0, -1.0, -1.0], [-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
    free = creak.system_from_matrices(K, np.diag([1.0, 1e-3, 1e-7]), C=C if dashpot else None, alpha=1.0)
    system = in_own_modes(creak.couple(free, driven={"base": [0]}))
    assert is_modal(system) is (dashpot == 0.0)
    stop = creak.gap_channels([[-1.0, 0.0, 1.0]], 0.05, 200.0)
    time = np.linspace(0.0, 0.5, 1500 * SAMPLES + 1)
    way = creak.Table(time, 30.0 * (1.0 - np.cos(4.0 * np.pi * time)))
    loads = creak.make_loads(system, time, motion={"base": way})
    history = simulate_flow(system, stop, loads, OutputRequest(np.array([1])))
    measured(
        "time",
        f"gap of a stiff part and the support it stands on, {'coupled' if dashpot else 'single'} modes: share of the way",
        np.abs(history.gap[:, 0] - 0.05).max() / 60.0,
        at_most=1e-6,
        source="s'' / omega^2",
    )
