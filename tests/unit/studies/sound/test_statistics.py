"""Statistical energy beyond the mesh: one plate by a mesh to 3.5 kHz and by one that ends at 500 Hz."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import channel_matrices
from creak.dynamics.diagonal import modal_matrices
from creak.model.materials import SolidSection
from creak.model.skin import skin_of
from creak.reduction.band_modes import Losses
from creak.sound.answering import Modes
from creak.sound.forced import lead, sound_of_forces
from creak.sound.plates import EDGE
from creak.sound.rayleigh import AIR
from creak.sound.room import Room
from creak.sound.third_octave import third_octave_levels
from creak.sound.zwicker_tables import BANDS
from creak.studies.sound.band import mesh_band
from creak.studies.sound.cabin import Cabin
from creak.studies.sound.ear import Ear, Records, records_of
from creak.studies.sound.listeners import Listener
from creak.studies.sound.loud import Heard, heard_of, with_bar
from creak.studies.sound.plates_heard import plate_heard
from creak.studies.sound.radiation import Source
from creak.studies.sound.sheets import pushes, sheets_of
from creak.studies.sound.statistics import END, Statistics, _straight, _strongest, statistical, statistics_of
from helpers_core import STEEL, assembled, block, channels, model_of, shell
from helpers_plate import SIDES, THICK, ZETA, kept, own_modes, own_rows, supported_plate
from helpers_solids import solid_mesh

RECORDED = {"section": "sound"}

RATE = 48_000
FINE, COARSE = (40, 32), (15, 12)
EAR = np.array([0.35, 0.1, 0.6])
WINDOW = (0.0, 0.3)
STRUCK = [(0.1667, 0.2667), (0.3333, 0.1333), (0.4, 0.3), (0.1, 0.1)]
"""m, nodes of both meshes or nearly so."""


def blows() -> np.ndarray:
    """(n, 1) N: six half sines of .2 ms, 20 N the hardest."""
    t, force = np.arange(14_400) / RATE, np.zeros(14_400)
    for k, at in enumerate((0.02, 0.06, 0.11, 0.15, 0.2, 0.25)):
        here = (t > at) & (t < at + 2e-4)
        force[here] += 20.0 * (1.0 - 0.1 * k) * np.sin(np.pi * (t[here] - at) / 2e-4)
    return force[:, None]


def across(model, at: tuple[float, float]) -> GapOperator:
    """A channel across the plate at the node nearest to a point."""
    node = int(np.linalg.norm(model.nodes.coords[:, :2] - at, axis=1).argmin())
    G = np.zeros((1, 6 * len(model.nodes.coords)))
    G[0, 6 * node + 2] = 1.0
    return channels(G, 0.0, 1.0)


class Struck:
    """The plate by one mesh, as far as that carries, and its statistics beyond."""

    def __init__(self, n: tuple[int, int], end: float | None = None) -> None:
        self.model = supported_plate(n)
        self.skin = skin_of(self.model)
        self.band = mesh_band(self.model, self.skin, 1.0) if end is None else end
        self.small = kept(assembled(self.model), 2.0 * self.band)

    def node(self, at: tuple[float, float]) -> tuple[float, float]:
        """Where the node nearest to a point is."""
        flat = self.model.nodes.coords[:, :2]
        x, y = flat[int(np.linalg.norm(flat - at, axis=1).argmin())].tolist()
        return x, y

    def heard(self, at: tuple[float, float]) -> tuple[Heard, Records]:
        gaps = across(self.model, at)
        source = Source(
            Modes(*modal_matrices(self.small), np.asarray(channel_matrices(self.small, gaps).rows)),
            blows(),
            np.array([0]),
            np.array([0]),
            gaps,
        )
        known = statistics_of(self.model, self.skin, gaps, source.row, Losses(zeta=ZETA), (self.band, END), 1.0)
        assert isinstance(known, Statistics)
        ear = Ear(Listener("ear", EAR, self.skin, ("PART",), True), self.band, 1.0, statistics=known)
        records = records_of(source, [np.array([0])], ear, self.small)
        found = heard_of(records.whole[0], WINDOW, None, ear.start, END)
        ends = records.fainter[0], records.louder[0]
        return with_bar(found, records.computed[0], ends, records.ties[0], WINDOW, ear.start), records


@pytest.fixture(scope="module")
def fine():
    return Struck(FINE)


@pytest.fixture(scope="module")
def coarse():
    return Struck(COARSE)


@pytest.fixture(scope="module")
def heard(fine, coarse):
    """Of each point, by both meshes."""
    return {at: (fine.heard(at)[0], coarse.heard(at)[0]) for at in STRUCK}


def test_a_head_shades_what_statistics_send_as_it_shades_all_else(coarse):
    """Levels of both ears in the third octaves beyond the mesh, at the side of the plate."""
    gaps = across(coarse.model, STRUCK[0])
    rows = np.asarray(channel_matrices(coarse.small, gaps).rows)
    source = Source(Modes(*modal_matrices(coarse.small), rows), blows(), np.array([0]), np.array([0]), gaps)
    known = statistics_of(coarse.model, coarse.skin, gaps, source.row, Losses(zeta=ZETA), (coarse.band, END), 1.0)
    looks, left = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, -1.0])
    two = Listener("ear", EAR, coarse.skin, ("PART",), True, looks, left).ears
    computed = np.zeros((1, 4 * RATE))
    records = [statistical(known, source, [np.array([0])], one, computed, 2_000).mean[0] for one in two]
    levels = [third_octave_levels(x, RATE) for x in records]
    offset = np.array([[SIDES[0] / 2, SIDES[1] / 2, 0.0]]) - EAR
    for band in range(16, 25):
        f = BANDS[band : band + 1]
        gains = [one.head.gain(f, offset[0]) for one in two]
        # Filters of a third octave let some of the next one through.
        assert levels[0][band] - levels[1][band] == pytest.approx(
            20 * np.log10(np.abs(gains[0] / gains[1]))[0], abs=0.6
        )
    lag = np.argmax(np.correlate(records[0][1000:30_000], records[1][1050:29_950], "valid")) - 50
    late = (two[1].head.path(offset) - two[0].head.path(offset))[0] / AIR.speed * RATE
    assert -lag == pytest.approx(late, abs=1.0)


def exact(at: tuple[float, float]) -> Heard:
    """By Kirchhoff's modes and Rayleigh's integral to 10 kHz, no mesh and no statistics."""
    rows = own_rows(2 * END, tuple(EAR), float(RATE))
    pressure = sound_of_forces(own_modes(2 * END, at), blows(), RATE, [np.array([0])], rows, END, around=True)[0, 0]
    return heard_of(pressure, WINDOW, None, lead(RATE, END), END)


def test_meshes_that_end_early_tell_the_n5_of_all_modes_within_their_bar(fine, coarse, heard, measured):
    """Four points struck: what the coarse mesh computes to 490 Hz is a quarter of it, with its statistics it is right."""
    assert fine.band > 3000.0
    assert coarse.band < 500.0
    inside = 0
    for at, (finely, coarsely) in heard.items():
        for one, found, rel, end, tied in ((fine, finely, 0.08, "3.5 kHz", 6), (coarse, coarsely, 0.3, "490 Hz", 4)):
            true = exact(one.node(at))
            inside += found.n5_bar[0] <= true.n5 <= found.n5_bar[1]
            assert found.tie is not None
            assert found.tie.bands == tied
            measured(
                f"plate struck at {at[0]:g}, {at[1]:g} m: N5 of a mesh to {end} with statistical energy beyond",
                found.n5,
                true.n5,
                rel=rel,
                unit="sone",
                source="Kirchhoff's modes and Rayleigh's integral to 10 kHz",
            )
        assert found.n5_computed < 0.4 * true.n5
        assert found.n5_bar[1] / found.n5 - 1.0 < 0.6  # a bar that says something
    assert inside >= 7  # of 8: bars are two standard deviations


def test_statistical_third_octaves_against_those_of_the_fine_mesh(heard, measured):
    """Mean over four points and the eight bands from 500 Hz that both have."""
    bands = np.flatnonzero((BANDS > 550.0) & (BANDS < 2700.0))
    apart = [coarsely.third_octaves[bands] - finely.third_octaves[bands] for finely, coarsely in heard.values()]
    measured(
        "struck plate: statistical less computed third octaves, 630 Hz to 2.5 kHz, mean over four points",
        float(np.mean(apart)),
        0.0,
        abs=2.5,
        unit="dB",
        source="mesh to 3.5 kHz",
    )
    assert np.std(apart) < 4.0


def test_in_front_of_a_plate_little_is_heard_near_coincidence_and_a_room_is_fed_with_all(coarse):
    """A steel plate of 2 mm, 6 kHz: against the same power sent alike to all sides."""
    gaps = across(coarse.model, STRUCK[0])
    rows = np.asarray(channel_matrices(coarse.small, gaps).rows)
    source = Source(Modes(*modal_matrices(coarse.small), rows), blows(), np.array([0]), np.array([0]), gaps)
    known = statistics_of(coarse.model, coarse.skin, gaps, source.row, Losses(zeta=ZETA), (coarse.band, END), 1.0)
    ear = Ear(Listener("ear", EAR, coarse.skin, ("PART",), True), coarse.band, 1.0, statistics=known)
    both = [records_of(source, [np.array([0])], ear, coarse.small, alike=alike) for alike in (False, True)]
    apart = np.subtract(*(third_octave_levels(r.whole[0] - r.computed[0], RATE) - r.ties[0].offset for r in both))
    near = (BANDS > 4500.0) & (BANDS < 8500.0)
    assert (apart[near] < -4.0).all()
    assert np.abs(apart[(BANDS > 800.0) & (BANDS < 2000.0)]).max() < 3.0
    room = Room(3.0, np.full(28, 0.1))
    cabin = Cabin(room, 2.0, known.noise)
    heard = records_of(source, [np.array([0])], replace(ear, cabin=cabin), coarse.small)
    fed = cabin.adds(both[1].whole)
    np.testing.assert_allclose(heard.whole, both[0].whole + fed, atol=1e-9 * np.abs(fed).max())


def test_nothing_changes_below_and_nothing_is_above_its_end(coarse):
    _, records = coarse.heard(STRUCK[0])
    more = records.whole[0] - records.computed[0]
    spectrum, freq = np.abs(np.fft.rfft(more)), np.fft.rfftfreq(more.size, 1.0 / RATE)
    assert spectrum[freq < 0.69 * coarse.band].max() < 1e-3 * spectrum.max()
    assert spectrum[freq > 1.05 * END].max() < 1e-3 * spectrum.max()
    again = coarse.heard(STRUCK[0])[1]
    np.testing.assert_array_equal(again.whole, records.whole)  # the seed is kept


def test_what_forces_push(coarse):
    """Across a plate, at its middle or its edge, held or free; along it nothing bends."""
    model = coarse.model
    sheets = sheets_of(model, coarse.skin, 1.0)
    (inside,) = pushes(sheets, across(model, (0.2667, 0.2)), np.array([0]))
    (held,) = pushes(sheets, across(model, (0.5, 0.2)), np.array([0]))
    (edge,) = pushes(sheets_of(replace(model, fixed=()), coarse.skin, 1.0), across(model, (0.5, 0.2)), np.array([0]))
    part = inside.part
    rigidity = STEEL.youngs_modulus * THICK**3 / (12 * (1 - STEEL.poisson_ratio**2))
    assert abs(inside.across[0]) == pytest.approx(1.0)
    assert inside.mobility[0] == pytest.approx(1.0 / (8.0 * np.sqrt(rigidity * STEEL.density * THICK)))
    assert edge.mobility[0] == pytest.approx(EDGE * inside.mobility[0])
    assert held.mobility[0] == pytest.approx(inside.mobility[0])
    assert part.mass == pytest.approx(STEEL.density * THICK * SIDES[0] * SIDES[1])
    assert part.plates[0].perimeter == pytest.approx(2.0 * sum(SIDES))
    assert part.density == pytest.approx(0.5 * 0.2 * np.sqrt(STEEL.density * THICK / rigidity))
    G = np.zeros((1, 6 * len(model.nodes.coords)))
    G[0, 6 * 40] = 1.0  # along x
    assert pushes(sheets, channels(G, 0.0, 1.0), np.array([0])) == []


def test_a_contact_pushes_two_plates_apart(coarse):
    """What its two forces send by themselves is of opposite signs; that of the heavier plate is the fainter."""
    one = coarse.model
    n = one.nodes.count
    quads, coords = one.blocks[0].nodes_idx, np.vstack([one.nodes.coords, one.nodes.coords - [0.0, 0.0, 0.002]])
    blocks = [block("quad4", quads, shell(THICK)), block("quad4", quads + n, shell(3 * THICK), part=1, first=1001)]
    model = model_of(coords, blocks, [("A", range(n)), ("B", range(n, 2 * n))])
    skin, node = skin_of(model), 100
    G = np.zeros((2, 12 * n))
    G[:, 6 * node + 2] = 1.0
    G[1, 6 * (node + n) + 2] = -1.0
    found = pushes(sheets_of(model, skin, 1.0), channels(G, [0.0, 0.0], [1.0, 1.0]), np.array([0, 1]))
    ear = Listener("ear", coords[node] + [0.0, 0.0, 0.5], skin, ("A", "B"), True)
    alone, both = _straight([plate_heard(p, ear, 1.0) for p in found], 2, 100.0)[:, 0]
    own = AIR.density / (2 * np.pi * STEEL.density * THICK)
    assert abs(alone) == pytest.approx(own / 0.5)
    assert abs(both) == pytest.approx(own / 0.5 - own / 3 / 0.502, rel=1e-3)
    near, far = (np.angle(_straight([plate_heard(found[0], ear, 1.0)], 2, f)[0, 0]) for f in (100.0, 200.0))
    assert (near - far) % (2 * np.pi) == pytest.approx(2 * np.pi * 100.0 * 0.5 / AIR.speed)  # half a metre later


def test_lengths_in_millimetres_change_nothing(coarse):
    """The same plate in mm, t and s."""
    model = coarse.model
    other = replace(STEEL, youngs_modulus=STEEL.youngs_modulus * 1e-6, density=STEEL.density * 1e-12)
    section = replace(shell(1e3 * THICK), material=other)
    small = model_of(1e3 * model.nodes.coords, [block("quad4", model.blocks[0].nodes_idx, section)])
    one, two = sheets_of(model, coarse.skin, 1.0).parts[0], sheets_of(small, skin_of(small), 1e-3).parts[0]
    assert two.plates[0].coincidence == pytest.approx(one.plates[0].coincidence)
    assert two.density == pytest.approx(one.density)
    assert two.plates[0].area == pytest.approx(one.plates[0].area)
    # Its mass is in tonnes, as its forces are in N = 1e-3 t m/s^2.
    assert 1e-3 * two.plates[0].mobility == pytest.approx(one.plates[0].mobility)
    assert two.mass == pytest.approx(1e-3 * one.mass)


@pytest.mark.parametrize(
    ("losses", "ends", "says"),
    [
        (Losses(zeta=0.02), (9500.0, END), "contact forces are not known there"),
        (Losses(), (500.0, END), "nothing is damped"),
        (Losses(zeta=0.02), (60.0, END), "bend no part that has a mode in each third octave there"),
    ],
)
def test_why_there_are_none(coarse, losses, ends, says):
    gaps = across(coarse.model, STRUCK[0])
    found = statistics_of(coarse.model, coarse.skin, gaps, np.array([0]), losses, ends, 1.0)
    assert isinstance(found, str)
    assert says in found


def test_a_solid_is_no_plate():
    coords, elements = solid_mesh((2, 2, 1), (0.2, 0.2, 0.1))
    model = model_of(coords, [block("hex8", elements, SolidSection("STEEL", STEEL))])
    gaps = across(model, (0.1, 0.1))
    found = statistics_of(model, skin_of(model), gaps, np.array([0]), Losses(zeta=0.02), (500.0, END), 1.0)
    assert isinstance(found, str)
    assert "bend no part" in found


def test_of_many_forces_those_that_change_count():
    """A hundred channels that press alike, and one that hits: it is looked at alone."""
    force = np.full((1000, 100), 7.0)
    force[500:503, 40] = 50.0
    kept, share = _strongest(force, np.arange(20, 100))
    assert kept.tolist() == [40]
    assert share == pytest.approx(1.0)
    hits = np.random.default_rng(0).standard_normal((1000, 100))
    kept, share = _strongest(hits, np.arange(100))
    assert kept.size == 64
    assert (np.diff(kept) > 0).all()
    assert 0.64 < share < 0.75
    assert _strongest(np.full((1000, 3), 7.0), np.arange(3))[0].size == 0
