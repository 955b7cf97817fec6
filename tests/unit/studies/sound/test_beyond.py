"""Sound beyond the modes of a reduction: a simply supported plate against its own modes, to convergence."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.dynamics.channels import channel_matrices
from creak.dynamics.diagonal import modal_matrices
from creak.linalg.complex_factor import complex_factor
from creak.linalg.modes import modes
from creak.model.skin import skin_of
from creak.reduction.band_modes import Losses, band_modes, count_for
from creak.sound.forced import Modes, lead, sound_of_forces
from creak.studies.models.reference import ReferenceModel
from creak.studies.sound.band import mesh_band
from creak.studies.sound.beyond import Beyond, beyond_modes, hearing
from creak.studies.sound.ear import Ear, records_of
from creak.studies.sound.listeners import Listener
from creak.studies.sound.loud import heard_of
from creak.studies.sound.source import Source
from helpers_core import assembled, channels
from helpers_plate import SIDES, ZETA, kept, own_modes, supported_plate
from helpers_sound import pressure_rows

RATE = 48_000
N = (40, 32)
AT = (13, 22)
"""Column and row of the node that is struck."""
EAR = np.array([0.35, 0.1, 0.6])
HANDOVER = 500.0


@pytest.fixture(scope="module")
def model():
    return supported_plate(N)


@pytest.fixture(scope="module")
def system(model):
    return assembled(model)


def blow() -> np.ndarray:
    """(n, 1) N: a half sine of .2 ms."""
    t = np.arange(9_600) / RATE
    return np.where((t > 0.05) & (t < 0.0502), 20.0 * np.sin(np.pi * (t - 0.05) / 2e-4), 0.0)[:, None]


def converged(high: float, far: float) -> np.ndarray:
    """Pressure of its own modes up to `far`, with the band's lead before it."""
    own, points, volumes = own_modes(far, (AT[0] * SIDES[0] / N[0], AT[1] * SIDES[1] / N[1]))
    rows = pressure_rows(points, volumes, [EAR], float(RATE))
    return sound_of_forces(own, blow(), RATE, [np.array([0])], rows, high, around=True)[0, 0]


def test_a_struck_plate_to_the_end_of_its_mesh_against_its_own_modes(model, system, measured):
    """Six elements per wavelength at the end; within 1 dB(A) and 5 % of N5."""
    skin = skin_of(model)
    listener = Listener("ear", EAR, skin, ("PART",), True)
    node = AT[0] * (N[1] + 1) + AT[1]
    G = np.zeros((1, 6 * len(model.nodes.coords)))
    G[0, 6 * node + 2] = 1.0
    gaps = channels(G, 0.0, 1.0)
    small, high = kept(system, 2 * HANDOVER), mesh_band(model, skin, 1.0)
    rows = np.asarray(channel_matrices(small, gaps).rows)
    source = Source(Modes(*modal_matrices(small), rows), blow(), np.array([0]), np.array([0]), gaps)
    reference = ReferenceModel((), None, system, modes(system.K, system.M, f_max=100.0), np.zeros((system.n, 0)), None)
    beyond = beyond_modes(reference, ZETA, source, [listener], 1.0, (HANDOVER, high), 1e5)
    assert isinstance(beyond, Beyond)
    assert beyond.high == high
    assert high > 3000.0
    assert beyond.found.freq.size <= count_for(Losses(zeta=ZETA), HANDOVER, high) + 8
    ear = Ear(listener, HANDOVER, 1.0, beyond)
    records = records_of(source, [np.array([0])], ear, small)
    window = (0.0, 0.2)
    found, alone, sooner = (
        heard_of(x[0], window, None, ear.start) for x in (records.whole, records.modes, records.sooner)
    )
    start = lead(RATE, high)
    true = heard_of(converged(high, 4 * high), window, None, start)
    further = heard_of(converged(high, 6 * high), window, None, start)
    assert further.n5 == pytest.approx(true.n5, rel=1e-3)  # converged
    measured("sound", "struck plate to the mesh's end: level", found.level, true.level, abs=1.0, unit="dB(A)")
    measured("sound", "struck plate to the mesh's end: N5", found.n5, true.n5, rel=0.05, unit="sone")
    assert alone.n5 < 0.8 * true.n5  # what the modes alone leave out
    assert sooner.n5 == pytest.approx(found.n5, rel=0.01)
    plain = records_of(source, [np.array([0])], replace(ear, beyond=None), small)
    np.testing.assert_array_equal(records.modes, plain.whole)  # nothing changes below


def test_what_a_listener_hears_of_a_force_and_the_other_way_round(model, system):
    """Both solves tell the same to round-off, and the Galerkin model what a solve says anywhere in its band."""
    at = hearing(system, Listener("ear", EAR, skin_of(model), ("PART",), True), 1.0)
    column = int(np.flatnonzero(system.coordinates == 6 * (AT[0] * (N[1] + 1) + AT[1]) + 2)[0])
    push = np.zeros((system.n, 1))
    push[column] = 1.0

    def weights(freq: float) -> np.ndarray:
        return at(freq)[:, None]

    losses = Losses(alpha=20.0, beta=5e-6)
    found = band_modes(system.K, system.M, losses, push, weights, (500.0, 1500.0), 40)
    assert found.high == 1500.0
    assert found.reciprocity < 1e-9
    for freq in np.random.default_rng(1).uniform(500.0, 1500.0, 5):
        k, m = losses.factors(freq)
        true = complex_factor((k * system.K + m * system.M).tocsr()).solve(push.astype(complex))[:, 0] @ at(freq)
        q = (found.shapes.T @ push)[:, 0] / (k * found.omega2 + m)
        assert abs(at(freq) @ (found.shapes @ q) - true) < 0.05 * abs(true)
    for most in (5, 6, 7):
        less = band_modes(system.K, system.M, losses, push, weights, (500.0, 1500.0), most)
        assert less is None or less.error < 0.05  # the last of them checks
    less = band_modes(system.K, system.M, losses, push, weights, (500.0, 1500.0), 6)
    assert less is not None
    assert 500.0 < less.high < 1500.0  # as far as it goes
    assert band_modes(system.K, system.M, Losses(), push, weights, (500.0, 1500.0), 40) is None
