"""Struck plates, heard to 10 kHz by coarse meshes and by their own modes: `python -m benchmarks.plates [--plates N]`.

Simply supported plates of steel and aluminium with random sides, thickness, damping, place struck and listener. The
reference is written here alone: Kirchhoff's modes to 20 kHz, Rayleigh's integral over a grid, frequency by frequency.
creak has them by meshes of 20 and 10 mm: computed as far as the mesh carries, statistical energy beyond.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from benchmarks.stamp import stamp
from creak.arrays import FloatArray
from creak.assembly.coupling import Driven, couple
from creak.assembly.damping import Damping
from creak.assembly.part import Rayleigh, part_system
from creak.assembly.system import System, project
from creak.contact.gap_operator import ChannelRows, GapOperator
from creak.dynamics.channels import channel_matrices
from creak.dynamics.diagonal import modal_matrices
from creak.linalg.diagonal import Diagonal
from creak.linalg.modes import modes
from creak.model.constraints import Fixed
from creak.model.materials import Material, ShellSection
from creak.model.mesh import ElementBlock, Model, Nodes, Part
from creak.model.skin import skin_of
from creak.reduction.band_modes import Losses
from creak.sound.answering import Modes
from creak.sound.forced import high_end, without_lows
from creak.studies.sound.band import mesh_band
from creak.studies.sound.ear import Ear, records_of
from creak.studies.sound.listeners import Listener
from creak.studies.sound.loud import Heard, heard_of, with_bar
from creak.studies.sound.radiation import Source
from creak.studies.sound.statistics import END, Statistics, statistics_of

RATE, SECONDS, WINDOW = 48_000, 2.0, (0.0, 0.3)
BLOWS, LASTS = (0.02, 0.06, 0.11, 0.15, 0.2, 0.25), 1.5e-4
"""s"""
MESHES = (0.02, 0.01)
"""m"""
GRID = 0.004
"""m between the points of Rayleigh's integral: eight or more to the shortest wave."""
BASE = Material("STEEL", 2.1e11, 0.3, 7850.0)
DENSITY, SPEED = 1.204, 343.2


@dataclass(frozen=True)
class Plate:
    """One of them, in m."""

    sides: tuple[float, float]
    thickness: float
    material: Material
    zeta: float
    struck: tuple[float, float]
    ear: FloatArray


def drawn(seed: int) -> Plate:
    """A plate; struck at a node of both meshes."""
    rng = np.random.default_rng(seed)
    sides = tuple((0.02 * rng.integers(15, 36, 2)).tolist())
    struck = tuple(0.02 * int(rng.integers(2, round(s / 0.02) - 1)) for s in sides)
    steel = BASE if rng.random() < 0.6 else Material("ALUMINIUM", 7.0e10, 0.33, 2700.0)
    ear = np.array([*(rng.uniform(-0.2, 1.2, 2) * sides), rng.uniform(0.4, 1.0)])
    thickness = float(rng.choice([0.8, 1.0, 1.5, 2.0, 3.0])) * 1e-3
    return Plate(sides, thickness, steel, float(rng.uniform(0.01, 0.04)), struck, ear)


def force() -> FloatArray:
    """(n,) N: half sines, 20 N the hardest."""
    t, found = np.arange(int(SECONDS * RATE)) / RATE, np.zeros(int(SECONDS * RATE))
    for k, at in enumerate(BLOWS):
        here = (t > at) & (t < at + LASTS)
        found[here] += 20.0 * (1.0 - 0.1 * k) * np.sin(np.pi * (t[here] - at) / LASTS)
    return found


def own_pressure(plate: Plate) -> FloatArray:
    """(n,) Pa at 48 kHz by Kirchhoff's modes and Rayleigh's integral, to 10 kHz."""
    (a, b), h, of = plate.sides, plate.thickness, plate.material
    rigidity = of.youngs_modulus * h**3 / (12.0 * (1.0 - of.poisson_ratio**2))
    areal = of.density * h
    most = int(max(plate.sides) / np.pi * (areal / rigidity) ** 0.25 * np.sqrt(2.0 * np.pi * 20_000.0)) + 1
    i, j = (k.ravel() for k in np.meshgrid(np.arange(1, most), np.arange(1, most), indexing="ij"))
    omega = np.sqrt(rigidity / areal) * ((i * np.pi / a) ** 2 + (j * np.pi / b) ** 2)
    low = omega < 2.0 * np.pi * 20_000.0
    i, j, omega = i[low], j[low], omega[low]
    x, y = (np.arange(n) + 0.5 for n in (round(a / GRID), round(b / GRID)))
    x, y = x * a / x.size, y * b / y.size
    r = np.sqrt((x[:, None] - plate.ear[0]) ** 2 + (y - plate.ear[1]) ** 2 + plate.ear[2] ** 2)
    along, across = np.sin(np.outer(i, x) * np.pi / a), np.sin(np.outer(j, y) * np.pi / b)
    coarse = np.arange(0.0, END + 41.0, 20.0)
    # What a mode sends, but for the delay to the nearest point: smooth in frequency.
    sent = np.empty((coarse.size, omega.size), dtype=complex)
    area = a * b / r.size
    for k, f in enumerate(coarse):
        way = DENSITY * area / (2.0 * np.pi * r) * np.exp(-2j * np.pi * f / SPEED * (r - r.min()))
        sent[k] = np.einsum("mx,mx->m", along, across @ way.T)
    x0, y0 = plate.struck
    push = np.sin(i * np.pi * x0 / a) * np.sin(j * np.pi * y0 / b) / (areal * a * b / 4.0)
    n = int(SECONDS * RATE)
    freq = np.arange(n // 2 + 1) / SECONDS
    P, F = np.zeros(freq.size, dtype=complex), np.fft.rfft(force())
    used = np.flatnonzero((freq > 10.0) & (freq <= END))
    smooth = CubicSpline(coarse, sent)
    for part in np.array_split(used, max(1, used.size * omega.size // 2_000_000)):
        w = 2.0 * np.pi * freq[part]
        motion = -(w[:, None] ** 2) * push / (omega**2 - w[:, None] ** 2 + 2j * plate.zeta * omega * w[:, None])
        P[part] = (smooth(freq[part]) * motion).sum(axis=1)
    return np.fft.irfft(P * F * np.exp(-2j * np.pi * freq * r.min() / SPEED), n)


def supported_plate(sides: tuple[float, float], thickness: float, material: Material, n: tuple[int, int]) -> Model:
    """Its mesh of n elements along its sides, held at its edges."""
    x, y = (k.ravel() for k in np.meshgrid(*map(np.linspace, (0.0, 0.0), sides, np.add(n, 1)), indexing="ij"))
    first = (np.arange(n[0])[:, None] * (n[1] + 1) + np.arange(n[1])).ravel()
    quads = np.column_stack([first, first + n[1] + 1, first + n[1] + 2, first + 1]).astype(np.int64)
    section, rows = ShellSection("PLATE", material, thickness), np.arange(x.size)
    at_x, at_y = (x < 1e-9) | (x > sides[0] - 1e-9), (y < 1e-9) | (y > sides[1] - 1e-9)
    held = [(rows, (1, 2, 6)), (np.flatnonzero(at_x), (3, 4)), (np.flatnonzero(at_y), (3, 5))]
    return Model(
        source="plate",
        nodes=Nodes(rows + 1, np.column_stack([x, y, 0.0 * x])),
        blocks=(ElementBlock("quad4", np.arange(1, len(quads) + 1), quads, section, 0, "plate"),),
        parts=(Part("PLATE", rows),),
        node_sets={},
        element_sets={},
        surfaces={},
        constraints=(),
        fixed=tuple(Fixed(*one) for one in held),
        initial_velocity=(),
    )


def kept(system: System, zeta: float, f_max: float) -> System:
    """Its lowest modes, damped alike."""
    found = modes(system.K, system.M, f_max=f_max)
    one, k = Diagonal(np.ones(found.omega2.size)), Diagonal(found.omega2)
    damping = Damping(0.0, 0.0, None, np.eye(found.omega2.size), 2.0 * zeta * np.sqrt(found.omega2))
    small = project(replace(system, damping=Damping()), found.shapes, known=(one, k))
    return replace(small, M=one, K=k, damping=damping)


def heard(plate: Plate, size: float) -> tuple[Heard, float]:
    """What creak tells of it, and Hz to which that is computed."""
    n_x, n_y = (round(s / size) for s in plate.sides)
    model, none = supported_plate(plate.sides, plate.thickness, plate.material, (n_x, n_y)), Rayleigh(0.0, 0.0)
    skin = skin_of(model)
    band = mesh_band(model, skin, 1.0)
    whole = couple([part_system(model, 0, none)], model, Driven({}), none)
    small = kept(whole, plate.zeta, 2.0 * band)
    node = int(np.linalg.norm(model.nodes.coords[:, :2] - plate.struck, axis=1).argmin())
    one, zero = np.ones(1), np.zeros(1)
    triplets = ChannelRows(np.array([0]), np.array([6 * node + 2]), one, zero, zero)
    gaps = GapOperator(
        **triplets.motion(1),
        gap0=zero,
        stiffness=one,
        damping=zero,
        step_limited=np.zeros(1, dtype=np.bool_),
        area=one,
        names=("at",),
        nodes_idx=np.array([node]),
        group=("at",),
    )
    rows = np.asarray(channel_matrices(small, gaps).rows)
    source = Source(
        Modes(*modal_matrices(small), rows), force()[: int(0.3 * RATE), None], np.array([0]), np.array([0]), gaps
    )
    known = statistics_of(model, skin, gaps, source.row, Losses(zeta=plate.zeta), (band, END), 1.0)
    if not isinstance(known, Statistics):
        raise SystemExit(known)
    ear = Ear(Listener("ear", plate.ear, skin, ("PLATE",), True), band, 1.0, statistics=known)
    records = records_of(source, [np.array([0])], ear, small)
    found = heard_of(records.whole[0], WINDOW, None, ear.start, END)
    ends = records.fainter[0], records.louder[0]
    return with_bar(found, records.computed[0], ends, records.ties[0], WINDOW, ear.start), band


def row_of(seed: int) -> dict[str, Any]:
    """A plate by its own modes and by both meshes."""
    plate = drawn(seed)
    pressure = own_pressure(plate)
    true = heard_of(pressure, WINDOW, None, 0, END)
    row: dict[str, Any] = {"seed": seed, "n5": true.n5, "level": true.level}
    for size in MESHES:
        found, band = heard(plate, size)
        there = without_lows(pressure, RATE, partial(high_end, band=band))
        low = heard_of(there, WINDOW, None, 0, band)
        row[f"{1000 * size:g} mm"] = {
            "band": band,
            "n5": found.n5,
            "n5_bar": list(found.n5_bar),
            "level": found.level,
            "n5_computed": found.n5_computed,
            "n5_true_there": low.n5,
        }
    return row


def main() -> None:
    """Measure and print."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.plates")
    options.add_argument("--plates", type=int, default=30)
    options.add_argument("--out", type=Path, help="JSON of the rows")
    given = options.parse_args()
    rows = []
    for seed in range(1, given.plates + 1):
        rows.append(row := row_of(seed))
        each = ", ".join(
            f"{name}: {x['n5']:.3g} ({x['n5_bar'][0]:.3g} to {x['n5_bar'][1]:.3g}) "
            f"{x['level'] - row['level']:+.1f} dB(A); {x['n5_computed']:.3g} of {x['n5_true_there']:.3g} "
            f"to {x['band']:.0f} Hz"
            for name, x in row.items()
            if isinstance(x, dict)
        )
        print(f"{seed:3d} N5 {row['n5']:.3g} sone; {each}", flush=True)
    for name in (f"{1000 * size:g} mm" for size in MESHES):
        of = [(row, row[name]) for row in rows]
        inside = np.mean([x["n5_bar"][0] <= row["n5"] <= x["n5_bar"][1] for row, x in of])
        off = np.array([x["n5"] / row["n5"] - 1.0 for row, x in of])
        level = np.array([x["level"] - row["level"] for row, x in of])
        there = np.array([x["n5_computed"] / x["n5_true_there"] - 1.0 for _, x in of])
        width = np.array([x["n5_bar"][1] / x["n5"] - 1.0 for _, x in of])
        print(
            f"{name}: N5 in the bar for {100 * inside:.0f} %, off by {100 * np.median(np.abs(off)):.0f} % (half), "
            f"{100 * np.quantile(np.abs(off), 0.95):.0f} % (95 %), mean {100 * off.mean():+.0f} %; the bar is "
            f"{100 * np.median(width):.0f} %; dB(A) {level.mean():+.1f} +- {level.std():.1f}; the computed "
            f"part alone off by {100 * np.median(np.abs(there)):.1f} % (half), {100 * np.abs(there).max():.1f} % (all)"
        )
    if given.out is not None:
        given.out.write_text(json.dumps({"made": stamp(), "rows": rows}, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
