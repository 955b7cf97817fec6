"""Plates by their statistical energy against modal sums and Rayleigh integrals of plates of random sides."""

from __future__ import annotations

import numpy as np
import pytest

from creak.sound.plates import Plate, in_decibel, radiation_efficiency, relative_variance
from creak.sound.rayleigh import AIR

RECORDED = {"section": "sound"}

E, NU, RHO, ETA = 2.1e11, 0.3, 7850.0, 0.04
WIDTH = 10.0**0.05 - 10.0**-0.05
COUNT = 50


def steel(thick: float, a: float, b: float) -> Plate:
    return Plate(E * thick**3 / (12 * (1 - NU**2)), RHO * thick, a * b, 2 * (a + b))


def modes(plate: Plate, a: float, b: float, high: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Numbers of half waves and rad/s of all modes of a simply supported plate up to `high` Hz."""
    i, j = (k.ravel() for k in np.meshgrid(np.arange(1, 120), np.arange(1, 120), indexing="ij"))
    omega = np.sqrt(plate.bending / plate.mass) * ((i * np.pi / a) ** 2 + (j * np.pi / b) ** 2)
    low = omega < 2 * np.pi * high
    return i[low], j[low], omega[low]


def struck(thick: float, area: float, freq: float, ear: float, rng) -> tuple[float, float, float]:
    """Mean over a third octave of Re Y, of <v^2> and of p^2 at a point `ear` m from the middle, per N^2."""
    aspect = rng.uniform(1.1, 1.9)
    area = area * rng.uniform(0.9, 1.1)
    a, b = np.sqrt(area * aspect), np.sqrt(area / aspect)
    plate = steel(thick, a, b)
    i, j, omega = modes(plate, a, b, 1.6 * freq)
    x, y = rng.uniform(0.1, 0.9, 2) * (a, b)
    phi, M = np.sin(i * np.pi * x / a) * np.sin(j * np.pi * y / b), plate.mass * a * b / 4
    s = 2 * np.pi * np.arange(freq * 10**-0.05, freq * 10**0.05, freq * ETA / 4)
    H = phi / (M * (omega**2 * (1 + 1j * ETA) - s[:, None] ** 2))
    polar, around = np.arccos(rng.uniform(0.5, 1.0)), rng.uniform(0.0, 2 * np.pi)
    at = ear * np.array([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)])
    n = 60
    X, Y = (np.arange(n) + 0.5) * a / n, (np.arange(n) + 0.5) * b / n
    r = np.sqrt((X[:, None] - a / 2 - at[0]) ** 2 + (Y - b / 2 - at[1]) ** 2 + at[2] ** 2)
    left = np.sin(np.outer(np.arange(1, i.max() + 1), X) * np.pi / a)
    right = np.sin(np.outer(np.arange(1, j.max() + 1), Y) * np.pi / b)
    p2 = 0.0
    for w, row in zip(s, -(s[:, None] ** 2) * H, strict=True):
        green = np.exp(-1j * w / AIR.speed * r) / r * (a * b / n**2) * AIR.density / (2 * np.pi)
        p2 += abs(row @ (left @ green @ right.T)[i - 1, j - 1]) ** 2 / s.size
    velocity = 1j * s[:, None] * H
    return (
        float((velocity @ phi).real.mean()),
        float((np.abs(velocity) ** 2).sum(axis=1).mean()) * M / (plate.mass * a * b),
        float(p2),
    )


@pytest.mark.parametrize(("thick", "freq"), [(1e-3, 500.0), (1e-3, 2000.0), (4e-3, 1000.0)])
def test_means_and_scatter_of_fifty_plates(thick, freq, measured):
    """Re Y, energy and sound of 50 random plates struck at random points: means within 1 dB, scatter as told."""
    rng, ear, area = np.random.default_rng(3), 2.5, 0.4
    Y, v2, p2 = np.array([struck(thick, area, freq, ear, rng) for _ in range(COUNT)]).T
    plate = steel(thick, np.sqrt(1.5 * area), np.sqrt(area / 1.5))
    energy = plate.mobility / (2 * np.pi * freq * ETA * plate.mass * area)
    sigma = radiation_efficiency(plate, np.array([freq]))[0]
    sound = (AIR.density * AIR.speed) ** 2 * area * sigma * energy / (2 * np.pi * ear**2)
    sound += (plate.direct / ear * (1 - (freq / plate.coincidence) ** 2)) ** 2
    of = f"{1e3 * thick:g} mm at {freq:.0f} Hz"
    for name, found, true in (("Re Y", plate.mobility, Y), ("energy", energy, v2), ("sound", sound, p2)):
        off = 10 * np.log10(found / true.mean())
        measured(f"statistical {name} of a plate, {of}: dB off the mean of 50", off, 0.0, abs=1.0, unit="dB")
    overlap, bandwidth = np.array([freq * ETA * plate.density]), np.array([WIDTH / ETA])
    for name, true, at_a_point in (("energy", v2, False), ("sound", p2, True)):
        told = in_decibel(relative_variance(overlap, bandwidth, at_a_point=at_a_point))[0]
        seen = np.std(10 * np.log10(true))
        measured(f"scatter of the {name} of 50 plates, {of}", told, seen, abs=1.0, unit="dB")


def by_integral(plate: Plate, a: float, b: float, freq: float) -> float:
    """Mean efficiency of the modes in a third octave: Rayleigh's integral of each over its plate, by wavenumbers.

    P = rho omega / (8 pi^2) int |V(kx, ky)|^2 / sqrt(k^2 - kx^2 - ky^2) over what radiates.
    """
    i, j, omega = modes(plate, a, b, 1.2 * freq)
    here = np.abs(np.log10(omega / (2 * np.pi * freq))) < 0.05
    polar, around = (np.arange(160) + 0.5) / 160 * np.pi / 2, (np.arange(160) + 0.5) / 160 * np.pi / 2
    found = []
    for m, n, w in zip(i[here], j[here], omega[here], strict=True):
        k = w / AIR.speed
        kx, ky = k * np.outer(np.sin(polar), np.cos(around)), k * np.outer(np.sin(polar), np.sin(around))

        def line(q: np.ndarray, count: int, side: float) -> np.ndarray:
            p = count * np.pi / side
            with np.errstate(invalid="ignore", divide="ignore"):
                return p**2 * 2 * (1 - (-1) ** count * np.cos(q * side)) / (p**2 - q**2) ** 2

        V2 = line(kx, m, a) * line(ky, n, b)
        # d kx d ky / kz = k sin(polar) d polar d around; a quarter of all directions.
        power = AIR.density * w / (8 * np.pi**2) * 4 * k * (V2 * np.sin(polar)[:, None]).mean() * (np.pi / 2) ** 2
        found.append(power / (AIR.density * AIR.speed * a * b / 8))
    return float(np.mean(found))


@pytest.mark.parametrize(
    ("thick", "freq", "within"), [(4e-3, 500.0, 2.0), (4e-3, 1000.0, 2.0), (4e-3, 2800.0, 3.0), (4e-3, 6000.0, 1.0)]
)
def test_radiation_efficiency_against_rayleigh_integrals_of_modes(thick, freq, within, measured):
    """Coincidence lies at 3 kHz: 2 dB below, 3 dB at it, 1 dB above."""
    a, b = 0.9, 0.6
    plate = steel(thick, a, b)
    true = by_integral(plate, a, b, freq)
    off = 10 * np.log10(radiation_efficiency(plate, np.array([freq]))[0] / true)
    measured(
        f"radiation efficiency of a plate at {freq / plate.coincidence:.2f} of coincidence: dB off its modes",
        off,
        0.0,
        abs=within,
        unit="dB",
        source="integral over wavenumbers",
    )


def sent_by_an_edge(share: float, *, supported: bool) -> float:
    """Power that an edge sends, over rho c <v^2> / k_b, by waves of all directions on half a plate, set in a wall.

    Each wave, what it is turned back as and what stays near the edge, by wavenumbers across the edge.
    """
    k = np.sqrt(share)  # of air, over that of bending
    steep = np.arcsin(k) * (np.arange(300) + 0.5) / 300  # others send nothing
    found = 0.0
    for along in np.sin(steep):
        to, near = 1j * np.sqrt(1 - along**2), -np.sqrt(1 + along**2)

        def moment(s: complex, a: float = along) -> complex:
            return s**2 - NU * a**2

        def shear(s: complex, a: float = along) -> complex:
            return s**3 - (2 - NU) * a**2 * s

        back = np.array([-1.0, 0.0])
        if not supported:
            rows = np.array([[f(to), f(near)] for f in (moment, shear)])
            back = np.linalg.solve(rows, [-moment(-to), -shear(-to)])
        K = np.sqrt(k**2 - along**2) * np.cos((np.arange(60) + 0.5) / 60 * np.pi)
        shape = 1 / (1j * K + to) + back[0] / (1j * K - to) + back[1] / (1j * K - near)
        found += k / 4 * (np.abs(shape) ** 2).mean() * steep[-1] / steep.size * 2 / np.pi
    return found


@pytest.mark.parametrize("share", [0.02, 0.1, 0.3, 0.6])
def test_edges_of_half_a_plate(share, measured):
    """Supported and free ones, by waves that come from all directions; so long that corners are nothing."""
    wave, long, area = 50.0, 400.0, 1e4
    coincidence = wave * AIR.speed / (2 * np.pi) / np.sqrt(share)
    mass = (2 * np.pi * coincidence / AIR.speed**2) ** 2
    freq = np.array([share * coincidence])
    for supported in (True, False):
        plate = Plate(1.0, mass, area, *((long, 0.0) if supported else (0.0, long)))
        assert plate.wavenumber(freq)[0] == pytest.approx(wave)
        kind = "supported" if supported else "free"
        measured(
            f"what a {kind} edge sends at {share:g} of its coincidence, over rho c <v^2> / k_b",
            radiation_efficiency(plate, freq)[0] * area * wave / long,
            sent_by_an_edge(share, supported=supported),
            rel=0.1,
            source="waves of all directions on half a plate",
        )


def test_coincidence_of_steel_and_plates_below_their_first_mode():
    assert steel(1e-3, 1.0, 1.0).coincidence == pytest.approx(12_000.0, rel=0.02)  # 12 m/s^2 over thickness
    plate = steel(1e-3, 0.5, 0.5)
    low = radiation_efficiency(plate, np.array([1.0, 2.0]))
    assert low[1] / low[0] == pytest.approx(4.0, rel=1e-6)  # a piston
    thick = radiation_efficiency(steel(0.2, 0.5, 0.4), np.geomspace(20.0, 5000.0, 30))  # all modes above coincidence
    assert (np.diff(thick[:10]) > 0.0).all()
    assert thick[-1] == pytest.approx(1.0, abs=0.01)
