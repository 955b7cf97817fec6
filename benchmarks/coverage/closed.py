"""Closed forms of contact through deck and study with nothing numerical said: `python -m benchmarks.coverage.closed`.

For each figure: exact, the independent march of the full matrices, creak, its error, its bar, and the study's verdict.
Studies give the model, what touches, what drives and how long: no f_max, no step, no stiffness but of spring stops.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.signal import butter, sosfiltfilt

import creak
from benchmarks.coverage.full import OF_CONTACT, full_model
from benchmarks.stamp import stamp
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.verify.events import Event

WITHIN = 0.05
"""Share of a figure that an answer may be off."""


@dataclass(frozen=True)
class Figure:
    """One number of a case with its exact value."""

    name: str
    exact: float | Callable[[float], float]
    """Its value, or what it is of a force that is low-passed at so many Hz."""
    of: Callable[[Mapping[str, Any]], float | None]
    """The reduced run of summary.json -> the figure."""
    bar: Callable[[Mapping[str, Any]], float | None]
    """The same -> its bar, in the unit of the figure; None: there is none."""
    own: Callable[[Sequence[Event]], float | None] | None = None
    """Events of the independent march -> the figure."""


@dataclass(frozen=True)
class Closed:
    """A deck, a study and its exact answers."""

    name: str
    deck: str
    study: str
    figures: tuple[Figure, ...]
    fastest: float
    """Hz, of what drives it: about one over the run's length where nothing does."""

    def run(self, folder: Path) -> dict[str, Any]:
        """The summary's reduced run, and the march's events where the case starts without static loads."""
        (folder / "deck.inp").write_text(self.deck, encoding="utf-8")
        path = folder / "study.toml"
        path.write_text(f'[model]\ndeck = "deck.inp"\nunits = "m-kg-s"\n{self.study}', encoding="utf-8")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            summary = creak.run(path).summary
        own, setup = None, set_up(read_study(path))
        if "[[static]]" not in self.study:
            full, v = full_model(setup, self.fastest), setup.study.config.verification
            own = full.events(full.run(OF_CONTACT), v.merge, v.f_max)
        return {"run": summary["runs"]["reduced"], "own": own, "f_max": setup.study.config.verification.f_max}


# --- figures of summary.json ----------------------------------------------------------------------------------------


def event(name: str, exact: float, key: str, number: int = 0) -> Figure:
    """`t_start`, `duration`, `impulse`, `force_peak` or `closing_speed` of an event."""

    def value(run: Mapping[str, Any]) -> float | None:
        if number >= len(run["events"]):
            return None
        e = run["events"][number]
        return float(e["t_end"] - e["t_start"] if key == "duration" else e[key])

    def bar(run: Mapping[str, Any]) -> float | None:
        told = run["events"][number]["settled_to"].get(key) if number < len(run["events"]) else None
        found = value(run)
        if told is None or found is None:
            return None
        return float(told if key in ("t_start", "duration") else told * abs(found))

    def own(events: Sequence[Event]) -> float:
        e = events[number]
        return float(e.t_end - e.t_start if key == "duration" else getattr(e, key))

    return Figure(name, exact, value, bar, None if key == "force_peak" else own)  # the march keeps means of forces


def blow(name: str, exact: float, key: str, begin: float = 0.0, end: float = np.inf) -> Figure:
    """`duration` from the first start to the last end, or `impulse`, of all events that start in a time: an undamped
    mesh re-opens within one blow of theory."""

    def value(found: Sequence[tuple[float, float, float]]) -> float | None:
        some = [e for e in found if begin <= e[0] < end]
        if not some:
            return None
        return some[-1][1] - some[0][0] if key == "duration" else sum(e[2] for e in some)

    def of(run: Mapping[str, Any]) -> float | None:
        return value([(e["t_start"], e["t_end"], e["impulse"]) for e in run["events"]])

    return Figure(name, exact, of, lambda _: None, lambda e: value([(x.t_start, x.t_end, x.impulse) for x in e]))


def largest(begin: float, end: float, first: float, last: float) -> Figure:
    """Force of the place, low-passed: of a blow whose force goes from one value to another, N.

    A step has no largest force of its own: what the low-pass of the study makes of the exact one is compared.
    """

    def exact(f_max: float) -> float:
        h = min(1.0 / (64.0 * f_max), 0.01 * (end - begin))
        time = np.arange(begin - 5.0 / f_max, end + 5.0 / f_max, h)
        force = np.where((time >= begin) & (time <= end), first + (last - first) * (time - begin) / (end - begin), 0.0)
        return float(sosfiltfilt(butter(4, f_max, fs=1.0 / h, output="sos"), force).max())

    def told(run: Mapping[str, Any], of: Callable[[Mapping[str, Any]], float]) -> float | None:
        some = [e for e in run["events"] if e["t_start"] < end and e["t_end"] > begin]
        return max(map(of, some)) if some else None

    def bar(run: Mapping[str, Any]) -> float | None:
        bars = [e["settled_to"].get("force") for e in run["events"][:1]]
        return None if not bars or bars[0] is None else bars[0] * float(run["events"][0]["force_place"])

    return Figure("largest force, N", exact, lambda run: told(run, lambda e: float(e["force_place"])), bar)


def period(exact: float) -> Figure:
    """From one event to the next."""

    def value(run: Mapping[str, Any]) -> float | None:
        starts = [e["t_start"] for e in run["events"]]
        return float(np.diff(starts).mean()) if len(starts) > 1 else None

    return Figure("period, s", exact, value, lambda _: None, lambda e: float(np.diff([x.t_start for x in e]).mean()))


def count(exact: int) -> Figure:
    """Number of events."""
    return Figure("events", exact, lambda run: float(len(run["events"])), lambda _: None, lambda e: float(len(e)))


def slid(name: str, exact: float, key: str, by: float = 1.0) -> Figure:
    """`slip_time`, `slip_path` or `friction_energy` of the one place that rubs: it slides once, from the start on."""

    def value(run: Mapping[str, Any]) -> float | None:
        return by * float(run["places"][0][key]) if run["places"] else None

    def bar(run: Mapping[str, Any]) -> float | None:
        told = run["places"][0]["settled_to"].get(key) if run["places"] else None
        found = value(run)
        return None if told is None or found is None else float(told * found)

    return Figure(name, exact, value, bar)


def slips(name: str, exact: float, of: Callable[[Sequence[Mapping[str, Any]]], float]) -> Figure:
    """Of all stick-slip events but the first, which starts from rest, and the last, which the end may cut."""

    def value(run: Mapping[str, Any]) -> float | None:
        some = run["slip_events"][1:-1]
        return of(some) if len(some) > 1 else None

    return Figure(name, exact, value, lambda _: None)


# --- decks ----------------------------------------------------------------------------------------------------------


def masses(mass: float, spring: float = 0.0, velocity: str = "", free: str = "x") -> str:
    """A point mass (set P1) on a spring along x, free along `free`."""
    lines = ["*NODE", "1, 0., 0., 0.", "*NSET, NSET=P1", "1", "*ELEMENT, TYPE=MASS, ELSET=M1", "1, 1"]
    lines += ["*MASS, ELSET=M1", f"{mass}"]
    if spring:
        lines += ["*ELEMENT, TYPE=SPRING1, ELSET=K1", "101, 1", "*SPRING, ELSET=K1", "1", f"{spring}"]
    if "z" in free:  # a static load asks for something that holds
        lines += ["*ELEMENT, TYPE=SPRING1, ELSET=WEAK", "301, 1", "*SPRING, ELSET=WEAK", "3", "1."]
    lines += ["*BOUNDARY", *(f"P1, {k + 1}" for k, axis in enumerate("xyz") if axis not in free), "P1, 4, 6"]
    return "\n".join([*lines, *(["*INITIAL CONDITIONS, TYPE=VELOCITY", velocity] if velocity else [])]) + "\n"


def weak(name: str, node: int, label: int, stiffness: float) -> list[str]:
    """A spring along x that holds a part as good as not at all, since a study asks for something that does."""
    return [f"*ELEMENT, TYPE=SPRING1, ELSET=W_{name}", f"{9000 + label}, {node}"] + [
        f"*SPRING, ELSET=W_{name}",
        "1",
        f"{stiffness}",
    ]


def plate(size: float, axes: str, free: str = "", thickness: float = 1e-3) -> str:
    """A steel plate of one element about the origin (set FLOOR, surface TABLE), which moves along `free`."""
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    at = {"xy": "{0}, {1}, 0.", "yz": "0., {0}, {1}"}[axes]
    held = [f"FLOOR, {k + 1}" for k, axis in enumerate("xyz") if axis not in free]
    lines = ["*NODE, NSET=FLOOR"]
    lines += [f"{9001 + j}, " + at.format(size * a, size * b) for j, (a, b) in enumerate(corners)]
    lines += ["*ELEMENT, TYPE=S4, ELSET=PLATE", "9001, 9001, 9002, 9003, 9004"]
    lines += ["*MATERIAL, NAME=PLATE", "*ELASTIC", "2.1E11, 0.3", "*DENSITY", "7850."]
    lines += ["*SHELL SECTION, ELSET=PLATE, MATERIAL=PLATE", f"{thickness}", "*SURFACE, NAME=TABLE", "PLATE, SPOS"]
    lines += weak("FLOOR", 9001, 400, 0.02) if free else []
    return "\n".join([*lines, "*BOUNDARY", *held, "FLOOR, 4, 6"]) + "\n"


def bars(
    lengths: Sequence[float], gap: float, speeds: Sequence[float], E: float, rho: float, side: float, n: int
) -> str:
    """Square bars of solids along x, one behind the other from x = `gap` on, n elements in the longest (sets A, B)."""
    lines, x0, first = [], gap, 0
    for name, L, v in zip("AB", lengths, speeds, strict=False):
        k = max(1, round(n * L / max(lengths)))
        x = x0 + L * np.arange(k + 1) / k
        corners = [(y, z) for y, z in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))]
        lines.append(f"*NODE, NSET={name}")
        lines += [
            f"{first + 4 * i + j + 1}, {a:.12g}, {side * y:.12g}, {side * z:.12g}"
            for i, a in enumerate(x)
            for j, (y, z) in enumerate(corners)
        ]
        lines.append(f"*ELEMENT, TYPE=C3D8, ELSET=BAR_{name}")
        lines += [", ".join(str(first + m) for m in (4 * i + 1, *range(4 * i + 1, 4 * i + 9))) for i in range(k)]
        lines += [f"*SOLID SECTION, ELSET=BAR_{name}, MATERIAL=BAR", f"*NSET, NSET={name}_ENDS"]
        lines += [f"{first + j}," for j in (1, 2, 3, 4, *range(4 * k + 1, 4 * k + 5))]
        lines += [f"*NSET, NSET={name}_INSIDE", *(f"{first + j}," for j in range(5, 4 * k + 1))]
        lines += weak(name, first + 1, 500 + first, 1e-7 * E * side**2 * k / L)
        lines += ["*BOUNDARY", f"{name}, 2, 3"]
        lines += ["*INITIAL CONDITIONS, TYPE=VELOCITY", f"{name}, 1, {v}"] if v else []
        first, x0 = first + 4 * (k + 1), x0 + L + gap
    return "\n".join([*lines, "*MATERIAL, NAME=BAR", "*ELASTIC", f"{E}, 0.", "*DENSITY", f"{rho},"]) + "\n"


def stop(stiffness: float, limit: str) -> str:
    """A spring that the mass runs against."""
    return f'[[connector]]\ntype = "play"\nname = "stop"\nnodes = "P1"\ndof = "x"\nstiffness = {stiffness}\n{limit}\n'


def contact(secondary: str, main: str, more: str) -> str:
    """A contact table."""
    return f'[contact.touch]\nsecondary = "{secondary}"\nmain = "{main}"\n{more}\n'


def push(node_set: str, value: float) -> str:
    """A constant force from t = 0 on along x."""
    signal = f'{{ type = "step", amplitude = {value} }}'
    name = node_set.lower()
    return f'[excitation.{name}]\nnode_set = "{node_set}"\ndof = "x"\nkind = "force"\nsignal = {signal}\n'


def load(value: float) -> str:
    """The mass pressed down before the run."""
    return f'[[static]]\nforce = {-value}\nnode_set = "P1"\ndof = "z"\n'


def end(value: float) -> str:
    """Of the run."""
    return f"[time]\nend = {value!r}\n"


def cases() -> list[Closed]:
    """All of them; sources: theory of waves in bars, Doyen, Ern, Piperno (2011), Coulomb's law."""
    hard, wall, small = 'stiffness = "hard"', plate(1.0, "yz"), plate(0.015, "yz", thickness=0.02)
    rubs = 'method = "node-to-surface"\nclearance = 0.0\nfriction = '
    found = []
    for how in ("hard", "auto"):
        # from 1 mm away; the wall begins half its thickness before its nodes
        found.append(
            Closed(
                f"bar on a rigid wall, 100 m/s, {how}",
                bars([0.2], 0.011, [-100.0], 2e11, 8000.0, 0.02, 40) + small,
                contact("BAR_A", "TABLE", f'stiffness = "{how}"') + end(2e-4),
                (
                    event("start, s", 1e-5, "t_start"),
                    event("contact, s", 8e-5, "duration"),
                    event("impulse, N s", 128.0, "impulse"),
                    largest(1e-5, 9e-5, 1.6e6, 1.6e6),
                    event("closing speed", 100.0, "closing_speed"),
                ),
                1e4,
            )
        )
    slow = [[10.0], 0.5, [-10.0], 900.0, 1.0, 1.0, 40]
    found.append(
        Closed(
            "bar on a rigid wall, c = 30",
            bars(*slow) + wall,
            contact("BAR_A", "TABLE", hard + "\nclearance = 5.0") + end(1.4),
            (
                event("start, s", 0.5, "t_start"),
                blow("contact, s", 2.0 / 3.0, "duration"),
                blow("impulse, N s", 200.0, "impulse"),
                largest(0.5, 0.5 + 2.0 / 3.0, 300.0, 300.0),
            ),
            1.0,
        )
    )
    slow[2] = [0.0]
    weight = -10.0 * 10.0 / 40 / 4
    found.append(
        Closed(
            "bouncing bar (Doyen et al.)",
            bars(*slow) + wall,
            contact("BAR_A", "TABLE", hard + "\nclearance = 5.0")
            + push("A_INSIDE", weight)
            + push("A_ENDS", 0.5 * weight)
            + end(4.6),
            (
                event("start, s", 1.0, "t_start"),
                blow("contact, s", 2.0 / 3.0, "duration", 0.0, 2.5),
                blow("impulse, N s", 800.0 / 3.0, "impulse", 0.0, 2.5),
                largest(1.0, 5.0 / 3.0, 300.0, 500.0),
                blow("second contact, s", 2.0 / 3.0, "duration", 2.5),
                blow("second impulse, N s", 800.0 / 3.0, "impulse", 2.5),
            ),
            1.0,
        )
    )
    found.append(
        Closed(
            "two bars",
            bars([5.0, 10.0], 0.2, [10.0, 0.0], 900.0, 1.0, 1.0, 40),
            contact("BAR_A", "BAR_B", hard + "\nclearance = 1.0") + end(0.8),
            (
                event("start, s", 0.1, "t_start"),
                blow("contact, s", 1.0 / 3.0, "duration", 0.0, 0.1 + 1.0 / 3.0),
                blow("impulse, N s", 50.0, "impulse", 0.0, 0.1 + 1.0 / 3.0),
                largest(0.1, 0.1 + 1.0 / 3.0, 150.0, 150.0),
            ),
            1.0,
        )
    )
    found.append(
        Closed(
            "mass on a spring stop",
            masses(100.0, 1e4, "P1, 1, 1."),
            stop(1e6, "upper = 0.0") + end(0.05),
            (
                event("contact, s", 0.0312600153, "duration"),
                event("impulse, N s", 198.01980, "impulse"),
                event("largest force, N", 9950.3719, "force_peak"),
            ),
            10.0,
        )
    )
    found.append(
        Closed(
            "mass with its weight on a spring stop",
            masses(1.0, velocity="P1, 1, -1."),
            stop(1e4, "lower = 0.0") + push("P1", -9.81) + end(0.06),
            (event("contact, s", 0.0333717, "duration"), event("largest force, N", 110.290, "force_peak")),
            10.0,
        )
    )
    m, k, k_stop = 2.0, 800.0, 7200.0
    period_s = float(np.pi * (np.sqrt(m / k) + np.sqrt(m / (k + k_stop))))
    found.append(
        Closed(
            "bilinear oscillator",
            masses(m, k, "P1, 1, -1."),
            stop(k_stop, "upper = 0.0") + end(4.5 * period_s),
            (count(4), period(period_s)),
            4.0,
        )
    )
    found.append(
        Closed(
            "Coulomb decay",
            masses(1.0, 1e4, free="xz") + plate(0.05, "xy"),
            contact("P1", "TABLE", rubs + "0.5") + load(2.0) + push("P1", -1e4 * 0.85e-3) + end(0.16),
            (slid("slides for, s", 0.1256637, "slip_time"),),
            10.0,
        )
    )
    belt = '[excitation.belt]\nnode_set = "FLOOR"\ndof = "x"\n'
    belt += 'signal = { type = "table", values = [[0.0, 0.0], [0.6, 0.006]] }\n'
    found.append(
        Closed(
            "belt squeak",
            masses(1.0, 1e4, free="xz") + plate(0.05, "xy", free="x"),
            contact("P1", "TABLE", rubs + "{ static = 0.5, kinetic = 0.3 }") + load(10.0) + belt + end(0.6),
            (
                slips("cycle, s", 1.0 / 12.3932817, lambda s: float(np.diff([x["t_start"] for x in s]).mean())),
                slips("slip, s", 0.04068888, lambda s: float(np.mean([x["t_end"] - x["t_start"] for x in s]))),
                slips("slip, mm", 0.80688788, lambda s: 1e3 * float(np.mean([x["slip_length"] for x in s]))),
            ),
            10.0,
        )
    )
    one, other, mu, pressed, v0 = 0.05, 7850.0 * 0.1 * 0.1 * 1e-3, 0.2, 1.0, 0.5
    until = v0 / (mu * pressed * (1.0 / one + 1.0 / other))
    found.append(
        Closed(
            "two masses, from slip to stick",
            masses(one, 0.02, free="xz", velocity=f"P1, 1, {v0}") + plate(0.05, "xy", free="x"),
            contact("P1", "TABLE", rubs + f"{mu}") + load(pressed) + end(2.0 * until),
            (
                slid("slides for, s", until, "slip_time"),
                slid("slip, mm", 500.0 * v0 * until, "slip_path", 1e3),
                slid("work, mJ", 500.0 * mu * pressed * v0 * until, "friction_energy", 1e3),
            ),
            10.0,
        )
    )
    return found


def rows(case: Closed, folder: Path) -> list[dict[str, Any]]:
    """Of each figure; of a case that fails, why."""
    try:
        found = case.run(folder)
    except creak.CreakError as error:
        return [{"case": case.name, "failed": f"{type(error).__name__}: {error}"}]
    out = []
    for f in case.figures:
        value, bar = f.of(found["run"]), f.bar(found["run"])
        exact = f.exact(found["f_max"]) if callable(f.exact) else f.exact
        try:
            own = None if found["own"] is None or f.own is None else f.own(found["own"])
        except IndexError:
            own = None
        error = None if value is None else value / exact - 1.0
        out.append(
            {
                "case": case.name,
                "figure": f.name,
                "exact": exact,
                "march": own,
                "creak": value,
                "error": error,
                "bar": bar,
                "covered": None if bar is None or value is None else abs(value - exact) <= bar,
                "verdict": found["run"].get("verdict"),
                "good": error is not None and abs(error) <= WITHIN and found["run"].get("verdict") == "settled",
            }
        )
    return out


def main() -> None:
    """Print the table and write it."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.coverage.closed")
    options.add_argument("--only", help="cases whose name has this in it")
    options.add_argument("--out", type=Path, default=Path("build/coverage"))
    given = options.parse_args()
    table = Table("case", "figure", "exact", "march", "creak", "error", "bar", "verdict", title="Closed forms")
    found = []
    for case in cases():
        if given.only and given.only not in case.name:
            continue
        with tempfile.TemporaryDirectory() as folder:
            began = time.process_time()
            some = rows(case, Path(folder))
            told = [r.get("failed") or f"{r['figure']} {r['exact']:.6g} -> {r['creak']}" for r in some]
            print(f"{case.name}, {time.process_time() - began:.1f} s CPU: {'; '.join(told)}", flush=True)
        found += some
        for r in some:
            if "failed" in r:
                table.add_row(case.name, r["failed"])
                continue
            numbers = [f"{r['exact']:.6g}", *("-" if r[x] is None else f"{r[x]:.6g}" for x in ("march", "creak"))]
            error = "-" if r["error"] is None else f"{r['error']:+.2%}"
            table.add_row(
                case.name, r["figure"], *numbers, error, "-" if r["bar"] is None else f"{r['bar']:.2g}", r["verdict"]
            )
        table.add_section()
    Console(width=150).print(table)
    good = sum(r.get("good", False) for r in found)
    print(f"{good} of {len(found)} figures within {WITHIN:.0%} and settled")
    if given.only is None:
        given.out.mkdir(parents=True, exist_ok=True)
        (given.out / "closed.json").write_text(json.dumps({"made": stamp(), "rows": found}, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
