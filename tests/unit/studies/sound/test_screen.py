"""Panels that stand free: a disc by its closed form, a half plane, and a plate that a listener hears three ways."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from creak.dynamics.diagonal import modal_matrices
from creak.errors import InputError
from creak.model.dofs import node_dofs
from creak.model.skin import skin_of
from creak.sound.answering import Modes
from creak.sound.rayleigh import AIR
from creak.sound.zwicker_tables import RATE
from creak.studies.file.places import Places
from creak.studies.file.sound_tables import ListenerTable
from creak.studies.sound.beyond import hearing
from creak.studies.sound.listeners import listeners_of
from creak.studies.sound.plates_heard import plate_heard
from creak.studies.sound.radiation import Source, radiation, record_of
from creak.studies.sound.rims import around_edges, half_plane, rims_of, without_wall
from creak.studies.sound.sheets import pushes, sheets_of
from helpers_core import assembled, channels
from helpers_plate import SIDES, ZETA, kept, supported_plate

RECORDED = {"section": "sound"}

N = (20, 16)
RADIUS = 0.3


def disc(ka: float, away: float) -> tuple[float, float]:
    """Pressure on the axis of a stiff disc that moves, over rho omega v: without a wall and in one."""
    s = (np.arange(4000) + 0.5) / 4000 * RADIUS
    k, r, ring = ka / RADIUS, np.hypot(away, s), s * RADIUS / 4000
    freq = np.array(k * AIR.speed / (2 * np.pi))
    green = ring / r * np.exp(-1j * k * r)
    return float(abs((green * around_edges(freq, RADIUS - s, RADIUS, away, 1.0)).sum())), float(abs(green.sum()))


@pytest.mark.parametrize("ka", [0.02, 0.1, 0.3])
def test_a_disc_without_a_wall(ka, measured):
    """Far from it 4 ka / (3 pi) of that in a wall (Lamb, section 108); close, the potential of a disc in a stream."""
    far, wall = disc(ka, 300.0 * RADIUS)
    name = f"disc without a wall, ka = {ka:g}"
    measured(f"{name}: dB far away", 20 * np.log10(far / wall / (4 * ka / (3 * np.pi))), 0.0, abs=3.0)
    near, _ = disc(ka, 2.0 * RADIUS)
    exact = 2 / np.pi * (RADIUS - 2 * RADIUS * np.arctan(0.5))
    measured(f"{name}: dB close to it", 20 * np.log10(near / exact), 0.0, abs=4.0)


def test_a_large_disc_needs_no_wall():
    for ka in (3.0, 6.0, 10.0):
        free, wall = disc(ka, 10.0 * RADIUS)
        assert 20 * np.log10(free / wall) == pytest.approx(0.0, abs=2.5)


def test_half_a_plane(measured):
    """Sommerfeld's integral by its own quadrature."""
    for x in (1e-4, 0.3, 2.0, 30.0):
        t = np.linspace(0.0, np.sqrt(x), 200_001)
        y = np.exp(-1j * t**2)
        own = 2 / np.sqrt(np.pi) * np.exp(0.25j * np.pi) * np.trapezoid(y, t)
        measured(f"pressure {x:g} / k from the edge of half a plane", abs(half_plane(np.array(x)) - own), at_most=1e-6)
    assert abs(half_plane(np.array(1e6)) - 1.0) < 1e-3


def blow() -> np.ndarray:
    """(n, 1) N: a half sine of .2 ms in .2 s."""
    t = np.arange(9600) / RATE
    return np.where((t > 0.02) & (t < 0.0202), 10.0 * np.sin(np.pi * (t - 0.02) / 2e-4), 0.0)[:, None]


def heard(model, **keys):
    table = ListenerTable(position=(0.3, 0.1, 0.7), **keys)
    (one,) = listeners_of(model, {"ear": table}, Places(Path("study.toml")), 1.0)
    return one


@pytest.fixture(scope="module")
def plate():
    return supported_plate(N)


def test_the_rim_of_a_plate(plate):
    (rim,) = heard(plate, wall=False).rims
    assert rim.half_width == pytest.approx(SIDES[1] / 2, rel=0.1)
    centres = skin_of(plate).centres
    edge = np.minimum(centres[:, :2], SIDES - centres[:, :2]).min(axis=1)
    np.testing.assert_allclose(rim.to_edge, edge, atol=0.3 * SIDES[0] / N[0])
    assert heard(plate).rims == ()
    weights = sum(weight for _, weight in rim.classes(skin_of(plate).count))
    np.testing.assert_allclose(weights, 1.0)


def test_a_part_of_a_panel_has_the_panels_edges(plate):
    skin = skin_of(plate)
    some = skin.centres[:, 0] < 0.5 * SIDES[0]
    whole, half = (rims_of(skin, which, np.array([0.3, 0.1, 0.7]), 1.0)[0] for which in (some | True, some))
    np.testing.assert_array_equal(half.to_edge, whole.to_edge[some])
    assert (half.half_width, half.away, half.cosine) == (whole.half_width, whole.away, whole.cosine)


def test_modes_and_reciprocity_hear_the_same(plate, measured):
    """A plate moved up and down as a whole, in a wall and without one, at three frequencies."""
    system = assembled(replace(plate, fixed=()))
    up = np.zeros((system.n, 1))
    up[system.labels % 6 == 2] = 1.0
    for wall in (True, False):
        ear = heard(plate, wall=wall)
        skin = ear.skin
        ((gain, areas), *more) = without_wall(ear.rims, [(np.ones_like, skin.areas)])
        every = [(gain, areas), *more]
        for freq in (80.0, 300.0, 1500.0):
            r = np.linalg.norm(skin.centres - ear.position, axis=1)
            k = 2 * np.pi * freq / AIR.speed
            own = sum(
                g(np.array([freq]))[0] * (AIR.density / (2 * np.pi * r) * np.exp(-1j * k * (r - r.min())) @ a[:, 2])
                for g, a in every
            )
            found = (hearing(system, ear, 1.0)(freq) @ up)[0]
            measured(f"plate, wall {wall}, {freq:g} Hz: two ways", abs(found) / abs(own), 1.0, rel=0.02)
    low = [abs((hearing(system, heard(plate, wall=w), 1.0)(60.0) @ up)[0]) for w in (True, False)]
    assert 20 * np.log10(low[0] / low[1]) > 8.0


def test_the_record_of_modes_is_what_reciprocity_tells(plate, measured):
    """A blow, heard by modes: what the missing wall takes at four frequencies, beside the weights of each node."""
    full = assembled(plate)
    small = kept(full, 1600.0)
    row = node_dofs(np.array([int(np.linalg.norm(plate.nodes.coords[:, :2] - (0.2, 0.15), axis=1).argmin())]), (3,))
    push = np.asarray(small.rows(row)[0])
    source = Source(Modes(*modal_matrices(small), push), blow(), np.array([0]), np.array([0]))
    both = [heard(plate, wall=wall) for wall in (True, False)]
    records = [record_of(source, [np.array([0])], radiation(small, ear, 1.0, 800.0))[0] for ear in both]
    lines, freq = np.fft.rfft(records), np.fft.rfftfreq(records[0].size, 1 / RATE)
    shapes = np.asarray(small.rows(full.labels)[0]) if small.n != full.n else np.eye(full.n)
    omega, zeta = np.sqrt(small.K.diagonal()), ZETA
    for at in (60.0, 150.0, 330.0, 600.0):
        k = int(np.abs(freq - at).argmin())
        w = 2 * np.pi * freq[k]
        q = push[0] / (omega**2 - w**2 + 2j * zeta * omega * w)
        x = np.linalg.lstsq(np.asarray(full.rows(full.labels)[0].todense()), shapes @ q, rcond=None)[0]
        own = [hearing(full, ear, 1.0)(freq[k]) @ x for ear in both]
        apart = (lines[1, k] / lines[0, k]) / (own[1] / own[0])
        measured(f"without a wall, {at:g} Hz: modes over reciprocity", abs(apart), 1.0, rel=0.03)


def test_statistics_lose_what_flows_around(plate):
    """A force near the edge, one in the middle: at low frequency little is left of either, above nothing is lost."""
    coords = plate.nodes.coords[:, :2]
    nodes = [int(np.linalg.norm(coords - p, axis=1).argmin()) for p in ((0.02, 0.2), (0.25, 0.2))]
    G = np.zeros((2, 6 * plate.nodes.count))
    G[[0, 1], [6 * k + 2 for k in nodes]] = 1.0
    (push,) = pushes(sheets_of(plate, skin_of(plate), 1.0), channels(G, [0.0, 0.0], [1.0, 1.0]), np.array([0, 1]))
    free = plate_heard(push, heard(plate, wall=False), 1.0)
    low, high = np.abs(free.around(100.0)), np.abs(free.around(8000.0))
    assert low[0] < low[1] < 0.6
    assert high[1] == pytest.approx(1.0, abs=0.3)
    assert free.at_edges(200.0, 0.01) < 0.1
    walled = plate_heard(push, heard(plate), 1.0)
    np.testing.assert_array_equal(walled.around(100.0), 1.0)
    assert walled.at_edges(200.0, 0.01) == 1.0
    assert free.of(np.array([1])).at_rim == free.at_rim[1:]


def test_a_measured_way_has_its_surroundings_in_it(plate, tmp_path):
    (tmp_path / "way.csv").write_text("frequency,amplitude\n10,1\n1000,1\n")
    table = ListenerTable(position=(0.3, 0.1, 0.7), wall=False, transfer={"PLATE": {"file": "way.csv"}})
    with pytest.raises(InputError, match=r"wall = false.*Leave wall out"):
        listeners_of(plate, {"ear": table}, Places(tmp_path / "study.toml"), 1.0)
