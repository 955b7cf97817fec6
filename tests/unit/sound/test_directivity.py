"""The share of a point in what a plate radiates: against double sums over its cells, its mean over all directions, and
the angle at which waves leave it above coincidence."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import j0

from creak.sound.directivity import FlatSheet, flat_sheet
from creak.sound.rayleigh import AIR
from helpers_core import plate

RECORDED = {"section": "sound"}

SIDES = (0.5, 0.4)


def sheet(
    sides: tuple[float, float] = SIDES,
    n: tuple[int, int] = (10, 8),
    shortest: float = 0.03,
    turn: np.ndarray | None = None,
    kind: str = "quad4",
) -> FlatSheet:
    coords, elements = plate(*n, sides, kind=kind)
    coords = coords if turn is None else coords @ turn.T
    corners = coords[elements if kind == "quad4" else elements[:, [0, 1, 2, 2]]]
    found = flat_sheet(corners, shortest)
    assert found is not None
    return found


def test_its_cells_hold_its_area_and_its_middle():
    for kind in ("quad4", "tri3"):
        found = sheet(kind=kind)
        assert found.area.sum() == pytest.approx(0.2)
        middle = np.einsum("xy,xyc->c", found.area, found.offset) / 0.2
        assert middle == pytest.approx([0.25, 0.2, 0.0], abs=1e-4)


def test_a_share_is_that_of_double_sums_over_the_cells(measured, monkeypatch):
    monkeypatch.setattr("creak.sound.directivity.PER_THIRD", 1)
    found, point, freq, k_b = sheet(shortest=0.1), np.array([0.1, -0.2, 0.5]), 900.0, 30.0
    used = found.area > 0
    x = np.stack(np.broadcast_arrays(found.x[:, None], found.y), axis=-1)[used]
    area, r = found.area[used], np.linalg.norm(found.offset[used] - point, axis=1)
    apart = np.linalg.norm(x[:, None] - x, axis=2)
    k = 2 * np.pi * freq / AIR.speed
    sent = area * np.exp(-1j * k * r) / r
    A = float((sent @ j0(k_b * apart) @ sent.conj()).real)
    B = float(area @ (j0(k_b * apart) * np.sinc(k * apart / np.pi)) @ area)
    exact = A / (B * float(area @ r**-2) / area.sum())
    measured("share of a point in a plate's sound", found.share(point, freq, k_b), exact, rel=1e-9)


@pytest.mark.parametrize(("freq", "k_b"), [(500.0, 40.0), (2000.0, 60.0), (4000.0, 60.0)])
def test_its_mean_over_all_directions_is_one(freq, k_b, measured):
    """Below, near and above coincidence; far away, where the power is what passes a hemisphere."""
    found = sheet()
    rng = np.random.default_rng(3)
    cosine, turn = (np.arange(40) + 0.5) / 40, 2 * np.pi * rng.random(40)
    sine = np.sqrt(1 - cosine**2)
    points = [0.25, 0.2, 0.0] + 50.0 * np.stack([sine * np.cos(turn), sine * np.sin(turn), cosine], axis=1)
    shares = [found.share(p, freq, k_b) for p in points]
    measured(f"plate at {freq:g} Hz: mean share over a hemisphere", float(np.mean(shares)), 1.0, abs=0.12, unit="")


def test_above_coincidence_it_sends_at_its_angle_and_just_above_little_to_the_front():
    found, far = sheet((1.5, 1.5), (10, 10)), 50.0
    k = 2 * np.pi * 4000.0 / AIR.speed

    def at(angle: float, k_b: float) -> float:
        a = np.radians(angle)
        return found.share(np.array([0.75 + far * np.sin(a), 0.75, far * np.cos(a)]), 4000.0, k_b)

    shares = [at(angle, 0.5 * k) for angle in (0.0, 15.0, 30.0, 45.0, 60.0)]
    assert np.argmax(shares) == 2  # asin(.5)
    assert shares[2] > 3.0
    assert shares[0] < 0.1
    assert at(0.0, 0.95 * k) < 0.05


def test_what_is_small_sends_alike_to_all_sides_and_where_it_lies_counts_for_nothing():
    small = sheet((0.01, 0.01), (2, 2))
    for point in ([0.0, 0.0, 0.5], [0.4, 0.1, 0.2]):
        assert small.share(np.array(point), 300.0, 20.0) == pytest.approx(1.0, abs=0.01)
    rng = np.random.default_rng(1)
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    point = np.array([0.1, 0.5, 0.6])
    assert sheet(turn=turn).share(turn @ point, 3000.0, 70.0) == pytest.approx(
        sheet().share(point, 3000.0, 70.0), rel=0.05
    )
    assert sheet(n=(25, 20)).share(point, 3000.0, 70.0) == pytest.approx(sheet().share(point, 3000.0, 70.0), rel=0.04)


def test_a_bent_sheet_and_two_that_face_each_other_are_none():
    coords, elements = plate(8, 8, (0.4, 0.4))
    bent = coords.copy()
    bent[:, 2] = np.abs(coords[:, 0] - 0.2) * 2.0
    assert flat_sheet(bent[elements], 0.03) is None
    apart = np.vstack([coords[elements], coords[elements] + [0.0, 0.0, 0.2]])
    assert flat_sheet(apart, 0.03) is None
    crowned = coords.copy()
    crowned[:, 2] = -0.3 * ((coords[:, 0] - 0.2) ** 2 + (coords[:, 1] - 0.2) ** 2)
    assert flat_sheet(crowned[elements], 0.03) is not None
