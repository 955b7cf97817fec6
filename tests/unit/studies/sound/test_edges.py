"""Edges of shells, and what plates send that are free, or held at points, against their own matrices."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.plates import supported_plate

from creak.linalg.complex_factor import complex_factor
from creak.model.constraints import DistributingCoupling, Fixed, KinematicCoupling
from creak.model.mesh import Model
from creak.model.skin import skin_of
from creak.sound.plates import radiation_efficiency
from creak.sound.rayleigh import AIR
from creak.studies.sound.beyond import hearing
from creak.studies.sound.listeners import Listener
from creak.studies.sound.sheets import Edges, edges_of, sheets_of
from helpers_core import STEEL, assembled, block, model_of, shell

RECORDED = {"section": "sound"}

SIDES, N = (0.8, 0.6), (64, 48)
PLASTIC = replace(STEEL, youngs_modulus=3.5e9, poisson_ratio=0.25, density=830.0)
EARS = np.array([[0.3, 0.2, 0.6], [0.1, 0.4, 0.5], [0.6, 0.1, 0.8]])
LOSS = 0.06


def plate(*held: Fixed, n: tuple[int, int] = N) -> Model:
    """Of plastic, 1.8 mm, that moves across alone."""
    whole = supported_plate(SIDES, 1.8e-3, PLASTIC, n)
    rows = np.arange(whole.nodes.count)
    return replace(whole, fixed=(Fixed(rows, (1, 2, 6)), *held))


def near(model: Model, points: np.ndarray) -> np.ndarray:
    """Nodes nearest to points of the plane."""
    flat = model.nodes.coords[:, :2]
    return np.array([int(np.linalg.norm(flat - p, axis=1).argmin()) for p in points])


def edges(model: Model) -> Edges:
    return edges_of(model, skin_of(model), 1.0)[2][0]


def test_free_and_supported_edges():
    around = 2.0 * sum(SIDES)
    free = edges(plate())
    assert (free.held, free.points) == (0.0, 0)
    assert free.free == pytest.approx(around)
    coords = plate().nodes.coords
    left = np.flatnonzero(coords[:, 0] < 1e-9)
    one = edges(plate(Fixed(left, (3,))))
    assert one.held == pytest.approx(SIDES[1])
    assert one.free == pytest.approx(around - SIDES[1])
    assert edges(plate(Fixed(left, (1, 2, 4)))).held == 0.0  # held along itself alone
    middle = np.flatnonzero(np.abs(coords[:, 0] - 0.4) < 1e-9)
    assert edges(plate(Fixed(middle, (3,)))).held == pytest.approx(2.0 * SIDES[1])  # a line has two sides
    lengths = edges_of(plate(), skin_of(plate()), 1e-3)[2][0]
    assert lengths.free == pytest.approx(1e-3 * around)


def test_what_holds_a_plate_inside():
    """A patch of 3 x 4 elements that moves as one body by its rim; a mean motion as a point."""
    model = plate()
    x, y, _ = model.nodes.coords.T
    size = SIDES[0] / N[0]
    patch = np.flatnonzero((x > 10.5 * size) & (x < 14.5 * size) & (y > 20.5 * size) & (y < 25.5 * size))
    assert patch.size == 20
    rigid = edges(replace(model, constraints=(KinematicCoupling("R", int(patch[0]), patch[1:], (1, 2, 3, 4, 5, 6)),)))
    assert rigid.held == pytest.approx(14.0 * size)
    assert rigid.points == 1
    other = near(model, np.array([[0.7, 0.1]]))
    mean = DistributingCoupling("M", int(patch[0]), patch[1:], np.ones(19))
    both = edges(replace(model, constraints=(mean,), fixed=(*model.fixed, Fixed(other, (3,)))))
    assert (both.held, both.points) == (0.0, 2)


def test_a_box_has_no_edge_and_sends_like_a_square_at_least():
    corners = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]  # turned anyhow
    model = model_of(corners, [block("quad4", faces, shell(1e-3))])
    assert edges(model) == Edges()
    (box,) = sheets_of(model, skin_of(model), 1.0).parts[0].plates
    square = replace(box, perimeter=4.0 * 6.0**0.5)
    freq = np.array([200.0, 1000.0])
    np.testing.assert_allclose(radiation_efficiency(box, freq), radiation_efficiency(square, freq))


@pytest.mark.parametrize("freq", [250.0, 1000.0])
@pytest.mark.parametrize(("name", "within"), [("free", 0.3), ("held at nine points", 1.0), ("supported", 2.0)])
def test_what_plates_send_beside_their_own_matrices(name, within, freq, measured):
    """Mean square at three points of what 16 forces send at 5 frequencies; energies are those of the matrices. Bending
    waves of 250 Hz are twice as long as those of 1 kHz: half as many elements resolve them as well."""
    n = N if freq == 1000.0 else (N[0] // 2, N[1] // 2)
    bare, rng = plate(n=n), np.random.default_rng(5)
    inner = 0.12 + rng.random((25, 2)) * (0.56, 0.36)
    flat = bare.nodes.coords[:, :2]
    edge = np.minimum(flat, SIDES - flat).min(axis=1) < 1e-9
    held = {
        "free": (),
        "held at nine points": (Fixed(near(bare, inner[:9]), (3,)),),
        "supported": (Fixed(np.flatnonzero(edge), (3,)),),
    }[name]
    model = plate(*held, n=n)
    system, skin = assembled(model), skin_of(model)
    sheet = sheets_of(model, skin, 1.0).parts[0].plates[0]
    struck = near(model, inner[9:])
    F = np.asarray(system.rows(6 * struck + 2)[0].todense(), dtype=complex).T
    ears = [hearing(system, Listener("ear", p, skin, ("PLATE",), True), 1.0) for p in EARS]
    energy, square = [], []
    for f in freq * 10.0 ** np.linspace(-0.04, 0.04, 5):
        w = 2.0 * np.pi * f
        u = complex_factor((system.K * (1.0 + 1j * LOSS) - w**2 * system.M).tocsc()).solve(F)
        energy.append(0.5 * w**2 * np.einsum("nk,nk->k", u.conj(), system.M @ u).real.mean())
        square.append([0.5 * w**4 * (np.abs(ear(f) @ u) ** 2).mean() for ear in ears])
    area = np.linalg.norm(skin.areas, axis=1)
    spread = np.array([area @ ((skin.centres - p) ** 2).sum(axis=1) ** -1.0 / area.sum() for p in EARS])
    sigma = radiation_efficiency(sheet, np.array([freq]))[0]
    ringing = (AIR.density * AIR.speed) ** 2 * sigma / (2.0 * np.pi * sheet.mass) * np.mean(energy) * spread
    apart = ((model.nodes.coords[struck][:, None] - EARS) ** 2).sum(axis=2)
    straight = 0.5 * sheet.direct**2 * (1.0 / apart).mean(axis=0)
    told = float((ringing + straight).mean())
    measured(
        f"plate that is {name}, statistical energy over its own matrices at {freq:g} Hz",
        10.0 * np.log10(told / np.mean(square)),
        0.0,
        abs=within,
        unit="dB",
        source="full matrices and Rayleigh's integral",
    )
