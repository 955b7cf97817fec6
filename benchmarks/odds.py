"""Do bounds of rare odds hold, and what do they cost? `python -m benchmarks.odds [--repeats N]`.

A beam with a stop under a step load, whose gap and load scatter in three ways. The odds that it touches are known by
quadrature: the largest motion of the tip, from the eigenvalues of the unreduced matrices by SciPy, times the load
against the gap. Each case is drawn again and again with other seeds.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq
from scipy.stats import norm

import creak
from benchmarks.stamp import stamp
from creak.arrays import to_dense
from creak.studies.models.reference import build_reference
from creak.studies.prepare.setup import set_up

LENGTH, SIDE, MODULUS, ZETA, END = 200.0, 2.0, 210000.0, 0.02, 0.03
DECK = f"""*NODE
1, 0., 0., 0.
2, {LENGTH / 2}, 0., 0.
3, {LENGTH}, 0., 0.
*ELEMENT, TYPE=B31, ELSET=BEAM
1, 1, 2
2, 2, 3
*NSET, NSET=TIP
3
*NSET, NSET=ROOT
1
*MATERIAL, NAME=STEEL
*ELASTIC
{MODULUS}, 0.3
*DENSITY
7.85e-9,
*BEAM SECTION, SECTION=RECT, ELSET=BEAM, MATERIAL=STEEL
{SIDE}, {SIDE}
0., 1., 0.
*BOUNDARY
ROOT, 1, 6
"""
STOPPED_BEAM = f"""[model]
deck = "beam.inp"
[damping]
modal = {ZETA}
[[connector]]
name = "stop"
type = "play"
nodes = "TIP"
dof = "z"
upper = 10.0
stiffness = 50.0
[excitation.tip]
node_set = "TIP"
dof = "z"
kind = "force"
signal = {{ type = "step", amplitude = 0.7 }}
[reduction]
f_max = 20000
[time]
end = {END}
[precheck]
margin = 20.0
"""
STUDY = f"""{STOPPED_BEAM}[scatter]
seed = SEED
[scatter.vary]
"connector.0.upper" = GAP
"excitation.tip.signal.amplitude" = LOAD
"""
X = norm.ppf((np.arange(200_000) + 0.5) / 200_000)
"""Middles of even shares of a normal distribution."""
Odds = Callable[[float, float], float]


def _normal(gap: float, most: float) -> float:
    """Gap normal, load even between .4 and 1."""
    return float(np.clip((1.0 - (gap + 0.1 * gap * X) / most) / 0.6, 0.0, 1.0).mean())


def _lognormal(gap: float, most: float) -> float:
    """Gap lognormal, load normal."""
    return float(norm.sf((gap * np.exp(0.2 * X) / most - 0.7) / 0.1).mean())


def _even(gap: float, most: float) -> float:
    """Gap even between .8 and 1.2 of its middle, load lognormal."""
    u = gap * (0.8 + 0.4 * (np.arange(200_000) + 0.5) / 200_000)
    return float(norm.sf(np.log(u / most / 0.7) / 0.15).mean())


CASES: tuple[tuple[float, int, Odds, str, str], ...] = (
    (
        0.3,
        256,
        _normal,
        '{ type = "normal", mean = MIDDLE, sigma = SIGMA }',
        '{ type = "uniform", low = 0.4, high = 1.0 }',
    ),
    (
        0.01,
        256,
        _lognormal,
        '{ type = "lognormal", median = MIDDLE, sigma = 0.2 }',
        '{ type = "normal", mean = 0.7, sigma = 0.1 }',
    ),
    (
        1e-4,
        256,
        _even,
        '{ type = "uniform", low = LOW, high = HIGH }',
        '{ type = "lognormal", median = 0.7, sigma = 0.15 }',
    ),
)
"""Odds, draws, what they are by quadrature of a middle gap and the tip's motion, distributions of gap and load."""


def reach(path: Path) -> float:
    """Largest motion of the tip under a unit step, from the modes of the unreduced matrices."""
    setup = set_up(creak.read_study(path))
    system = build_reference(setup.structure, setup.band, lambda *_: None).system
    tip = int(np.flatnonzero(system.coordinates == 6 * 2 + 2)[0])
    values, shapes = eigh(to_dense(system.K), to_dense(system.M))
    omega, t = np.sqrt(values), np.linspace(0.0, END, 20_001)[:, None]
    damped = omega * np.sqrt(1.0 - ZETA**2)
    rest = np.exp(-ZETA * omega * t) * (np.cos(damped * t) + ZETA * omega / damped * np.sin(damped * t))
    return float(((1.0 - rest) @ (shapes[tip] ** 2 / omega**2)).max())


def measured(
    folder: Path, most: float, odds: float, n: int, known: Odds, forms: tuple[str, str], repeats: int
) -> dict[str, Any]:
    """Coverage and cost of one case."""
    middle = float(brentq(lambda gap: known(gap, most) - odds, 0.2 * most, 5.0 * most, xtol=1e-9 * most))
    words = {"MIDDLE": middle, "SIGMA": 0.1 * middle, "LOW": 0.8 * middle, "HIGH": 1.2 * middle}
    gap, load = forms
    for word, value in words.items():
        gap = gap.replace(word, repr(value))
    path, found_p, covered, marched, cpu, wide = folder / "study.toml", 0.0, 0, 0, 0.0, 0.0
    for seed in range(repeats):
        path.write_text(STUDY.replace("SEED", str(seed)).replace("GAP", gap).replace("LOAD", load))
        start = time.process_time()
        found = creak.robust(path, n, indices=False, threads=1)
        cpu += time.process_time() - start
        covered += found.rattle.low <= odds <= found.rattle.high
        further = found.draws.further
        found_p, marched = found_p + found.rattle.p, marched + found.draws.marched
        marched += 0 if further is None else further.rows.size
        wide += 0.5 * (found.rattle.high - found.rattle.low)
    return {
        "odds": odds,
        "draws": n,
        "found": found_p / repeats,
        "half": wide / repeats,
        "plain": plain_draws(odds, wide / repeats),
        "covered": covered / repeats,
        "marched": marched / repeats,
        "cpu_s": cpu / repeats,
    }


def plain_draws(p: float, half: float) -> float:
    """Independent draws, all marched, whose bounds of 95 % are as wide."""
    return float((norm.ppf(0.975) / half) ** 2 * p * (1.0 - p))


def march_s(path: Path) -> float:
    """CPU time of a draw that is marched."""
    text = STUDY.replace("SEED", "1").replace("GAP", '{ type = "normal", mean = 5.0, sigma = 0.5 }')
    path.write_text(text.replace("LOAD", '{ type = "uniform", low = 0.4, high = 1.0 }'))
    creak.robust(path, 4, indices=False, threads=1)
    start = time.process_time()
    found = creak.robust(path, 256, indices=False, threads=1)
    return (time.process_time() - start) / found.draws.marched


def main() -> None:
    """Measure and print."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.odds")
    options.add_argument("--repeats", type=int, default=200)
    options.add_argument("--out", type=Path, help="JSON of the table")
    given = options.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "beam.inp").write_text(DECK)
        each = march_s(folder / "study.toml")
        most = reach(folder / "study.toml")
        rows = [measured(folder, most, p, n, known, forms, given.repeats) for p, n, known, *forms in CASES]
    print("  odds   draws   found      bounds +-   bounds hold  marched     CPU    as many marched   all of them")
    for r in rows:
        held, took = f"{100 * r['covered']:.1f} %", f"{r['cpu_s']:.2f} s"
        print(
            f"{r['odds']:6g} {r['draws']:7d}   {r['found']:<10.3g} {r['half']:<9.2g} {held:>12} {r['marched']:9.1f} "
            f"{took:>8} {r['plain']:14.0f} {each * r['plain']:11.1f} s"
        )
    if given.out is not None:
        given.out.write_text(json.dumps({"made": stamp(), "march_s": each, "rows": rows}, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
