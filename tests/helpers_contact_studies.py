"""Small decks in SI whose contact has a closed form, studies without a step, and a reference that is not creak's."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import scipy.linalg as sla

from creak.studies.converge.auto_band import settle
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import StudyResult, run_study
from helpers_decks import write_study


def solved(folder: Path, deck: str, tables: str, end: float, more: str = "") -> StudyResult:
    """Run a deck of [time] end alone, reduced; `more` follows after [time]."""
    path = write_study(
        folder,
        f'[model]\ndeck = "deck.inp"\nunits = "m-kg-s"\n{tables}[reference]\nrun = false\n[time]\nend = {end}\n{more}',
        {"deck.inp": deck},
    )
    return run_study(set_up(read_study(path)), lambda *_: None, settle=settle)


def points(
    mass: Sequence[float],
    to_ground: Sequence[float] = (),
    between: Sequence[float] = (),
    velocity: Sequence[float] = (),
    free: str = "x",
) -> str:
    """Point masses in a row (sets P1, P2, ...) that move along the axes `free`, with springs along the first of them."""
    n, axes, along = len(mass), [k + 1 for k, axis in enumerate("xyz") if axis not in free], "xyz".index(free[0]) + 1
    lines = ["*NODE", *(f"{i + 1}, {0.1 * i}, 0., 0." for i in range(n))]
    for i in range(n):
        lines += [f"*NSET, NSET=P{i + 1}", f"{i + 1}", f"*ELEMENT, TYPE=MASS, ELSET=M{i + 1}", f"{i + 1}, {i + 1}"]
        lines += [f"*MASS, ELSET=M{i + 1}", f"{mass[i]}"]
    for i, k in enumerate(to_ground):
        lines += [f"*ELEMENT, TYPE=SPRING1, ELSET=K{i + 1}", f"{101 + i}, {i + 1}"]
        lines += [f"*SPRING, ELSET=K{i + 1}", f"{along}", f"{k}"]
    for i, k in enumerate(between):
        lines += [f"*ELEMENT, TYPE=SPRING2, ELSET=J{i + 1}", f"{201 + i}, {i + 1}, {i + 2}"]
        lines += [f"*SPRING, ELSET=J{i + 1}", f"{along}, {along}", f"{k}"]
    for i in range(n):
        lines += ["*BOUNDARY", *(f"P{i + 1}, {axis}" for axis in axes), f"P{i + 1}, 4, 6"]
    if velocity:
        lines += ["*INITIAL CONDITIONS, TYPE=VELOCITY"]
        lines += [f"P{j // 3 + 1}, {j % 3 + 1}, {v}" for j, v in enumerate(velocity) if v]
    return "\n".join(lines) + "\n"


def rods(
    lengths: Sequence[float], counts: Sequence[int], speeds: Sequence[float], E: float, rho: float, area: float
) -> str:
    """Free rods of trusses along x, side by side (sets A, B: nodes; A_FOOT, A_HEAD: ends), each with a speed."""
    lines, first = [], 0
    for name, L, n, v in zip("AB", lengths, counts, speeds, strict=False):
        nodes = [first + i + 1 for i in range(n + 1)]
        lines += [f"*NODE, NSET={name}", *(f"{a}, {L * i / n:.12g}, 0., 0." for i, a in enumerate(nodes))]
        lines += [f"*ELEMENT, TYPE=T3D2, ELSET=ROD_{name}", *(f"{a}, {a}, {a + 1}" for a in nodes[:-1])]
        lines += [f"*SOLID SECTION, ELSET=ROD_{name}, MATERIAL=ROD", f"{area}"]
        lines += [f"*NSET, NSET={name}_FOOT", f"{nodes[0]}", f"*NSET, NSET={name}_HEAD", f"{nodes[-1]}"]
        lines += [f"*NSET, NSET={name}_INSIDE, GENERATE", f"{nodes[1]}, {nodes[-2]}"]
        lines += ["*BOUNDARY", f"{name}, 2, 6"]
        lines += ["*INITIAL CONDITIONS, TYPE=VELOCITY", f"{name}, 1, {v}"] if v else []
        first = nodes[-1]
    return "\n".join([*lines, "*MATERIAL, NAME=ROD", "*ELASTIC", f"{E}, 0.", "*DENSITY", f"{rho},"]) + "\n"


def beam(n: int, length: float, side: float, young: float, density: float, alpha: float) -> str:
    """A square beam without shear along x, simply supported in z; sets QUARTER, MIDDLE."""
    return (
        "*NODE, NSET=ALL\n"
        + "".join(f"{i + 1}, {length * i / n:.12g}, 0., 0.\n" for i in range(n + 1))
        + "*ELEMENT, TYPE=B33, ELSET=BEAM\n"
        + "".join(f"{i}, {i}, {i + 1}\n" for i in range(1, n + 1))
        + f"*NSET, NSET=QUARTER\n{n // 4 + 1}\n*NSET, NSET=MIDDLE\n{n // 2 + 1}\n*NSET, NSET=ENDS\n1, {n + 1}\n"
        + f"*MATERIAL, NAME=STEEL\n*ELASTIC\n{young}, 0.3\n*DENSITY\n{density},\n*DAMPING, ALPHA={alpha}\n"
        + f"*BEAM SECTION, SECTION=RECT, ELSET=BEAM, MATERIAL=STEEL\n{side}, {side}\n0., 1., 0.\n"
        + "*BOUNDARY\nENDS, 3, 3\nALL, 1, 2\nALL, 4, 4\nALL, 6, 6\n"
    )


def floor(size: float, free: str = "") -> str:
    """A stiff plate in z = 0 (set FLOOR, surface TABLE) that moves along the axes `free` alone."""
    axes = [k + 1 for k, axis in enumerate("xyz") if axis not in free]
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    return (
        "*NODE, NSET=FLOOR\n"
        + "".join(f"{9001 + j}, {size * a}, {size * b}, 0.\n" for j, (a, b) in enumerate(corners))
        + "*ELEMENT, TYPE=S4, ELSET=PLATE\n9001, 9001, 9002, 9003, 9004\n"
        + "*MATERIAL, NAME=PLATE\n*ELASTIC\n2.1E11, 0.3\n*DENSITY\n7850.,\n"
        + "*SHELL SECTION, ELSET=PLATE, MATERIAL=PLATE\n1.E-3,\n*SURFACE, NAME=TABLE\nPLATE, SPOS\n*BOUNDARY\n"
        + "".join(f"FLOOR, {axis}\n" for axis in axes)
        + "FLOOR, 4, 6\n"
    )


def play(nodes: str, stiffness: float, limits: str, dof: str = "x", more: str = "") -> str:
    return (
        f'[[connector]]\ntype = "play"\nname = "{nodes.replace(", ", "_").lower()}"\n'
        f'nodes = [{", ".join(repr(n) for n in nodes.split(", "))}]\ndof = "{dof}"\nstiffness = {stiffness}\n{limits}\n{more}'
    )


def push(nodes: str, signal: str, dof: str = "x", kind: str = "force") -> str:
    name = f"{nodes}_{dof}_{kind}".lower()
    return f'[excitation.{name}]\nnode_set = "{nodes}"\ndof = "{dof}"\nkind = "{kind}"\nsignal = {{ {signal} }}\n'


def step(amplitude: float) -> str:
    return f'type = "step", amplitude = {amplitude}'


def _steps(powers: list[np.ndarray], pushed: np.ndarray, x: np.ndarray) -> np.ndarray:
    """States after each of some steps x -> F x + pushed; `powers` of F to 1, 2, 4, ... are added as they are needed."""
    y = pushed.copy()
    y[0] += powers[0] @ x
    for level in range((len(y) - 1).bit_length()):
        if level == len(powers):
            powers.append(powers[-1] @ powers[-1])
        y[1 << level :] += y[: -(1 << level)] @ powers[level].T  # the right side is taken before the left one changes
    return y


def switched(
    M: np.ndarray,
    C: np.ndarray,
    K: np.ndarray,
    stops: Sequence[tuple[np.ndarray, float, float]],
    force: Callable[[np.ndarray], np.ndarray],
    v0: np.ndarray,
    h: float,
    end: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """time, gaps, forces (n_time, m) of M u'' + C u' + K u = force(t) (n_time, n) + stops, by matrix exponentials.

    A stop (G, gap0, k) presses with k times -(gap0 + G u) where that is positive. A step h takes the springs that press
    at its beginning; loads are linear in it. Where a gap changes sign the step is taken in two, with the crossing of
    its chord between them: exact but for O(h^2).
    """
    n, m = M.shape[0], len(stops)
    G, gap0, k = (np.array(x, dtype=float) for x in zip(*stops, strict=True))
    inverse = np.linalg.inv(M)
    time = h * np.arange(round(end / h) + 1)
    loads = force(time)

    def flow(closed: tuple[bool, ...], by: float) -> np.ndarray:
        """(2 n, 2 n + 3 n): from u, v, load, its slope and a constant load of the springs."""
        on = np.array(closed) * k
        A = np.zeros((4 * n + 1, 4 * n + 1))
        A[:n, n : 2 * n] = np.eye(n)
        A[n : 2 * n, :n], A[n : 2 * n, n : 2 * n] = -inverse @ (K + (G.T * on) @ G), -inverse @ C
        A[n : 2 * n, 2 * n : 3 * n], A[2 * n : 3 * n, 3 * n : 4 * n] = inverse, np.eye(n)
        A[n : 2 * n, -1] = -inverse @ (G.T @ (on * gap0))
        return np.asarray(sla.expm(by * A)[: 2 * n])

    loaded = np.hstack([loads[:-1], np.diff(loads, axis=0) / h, np.ones((time.size - 1, 1))])
    known: dict[tuple[bool, ...], tuple[list[np.ndarray], np.ndarray]] = {}
    x = np.concatenate([np.zeros(n), v0])
    gaps = np.zeros((time.size, m))
    gaps[0] = gap0
    j, at_once = 0, 1
    while j < time.size - 1:
        closed = tuple(bool(b) for b in (gaps[j] < 0.0) | ((gaps[j] == 0.0) & (G @ x[n:] < 0.0)))
        if closed not in known:
            own = flow(closed, h)
            known[closed] = [own[:, : 2 * n]], loaded @ own[:, 2 * n :].T
        powers, pushed = known[closed]
        y = _steps(powers, pushed[j : j + at_once], x)
        g = gap0 + y[:, :n] @ G.T
        changed = ((g < 0.0) != closed).any(axis=1)
        held = int(changed.argmax()) if changed.any() else len(y)
        gaps[j + 1 : j + 1 + held] = g[:held]
        at_once = min(2 * at_once, 512)
        if held:
            x, j = y[held - 1], j + held
        if held < len(y):
            other = tuple(bool(b) for b in g[held] < 0.0)
            share = min(
                float(np.clip(gaps[j, i] / (gaps[j, i] - g[held, i]), 0.0, 1.0))
                for i in range(m)
                if other[i] != closed[i]
            )
            middle = flow(closed, share * h) @ np.concatenate([x, loaded[j]])
            later = loaded[j].copy()
            later[:n] += share * h * later[n : 2 * n]
            x = flow(other, (1.0 - share) * h) @ np.concatenate([middle, later])
            j, at_once = j + 1, 1
            gaps[j] = gap0 + G @ x[:n]
    return time, gaps, np.maximum(-k * gaps, 0.0)


def blows(time: np.ndarray, gap: np.ndarray, force: np.ndarray) -> np.ndarray:
    """(n, 3) start, duration and impulse of every stretch in which one channel presses and that ends."""
    closed = np.concatenate([[False], force > 0.0])
    on, off = (np.flatnonzero(np.diff(closed.astype(int)) == s) for s in (1, -1))
    found = []
    for a, b in zip(on, off, strict=False):
        if a == 0:
            continue
        start = time[a - 1] + (time[a] - time[a - 1]) * gap[a - 1] / (gap[a - 1] - gap[a])
        ends = time[b - 1] + (time[b] - time[b - 1]) * gap[b - 1] / (gap[b - 1] - gap[b])
        found.append((start, ends - start, float(np.trapezoid(force[a - 1 : b + 1], time[a - 1 : b + 1]))))
    return np.array(found).reshape(-1, 3)
