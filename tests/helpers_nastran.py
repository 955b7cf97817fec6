"""Small Nastran decks for tests: read, load statically, and weigh."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from creak.arrays import to_dense
from creak.assembly.coupling import Driven, couple
from creak.assembly.part import Rayleigh, loose_system, part_system
from creak.assembly.system import System
from creak.formats.nastran.reader import read_nastran
from creak.model.mesh import Model

NO_DAMPING = Rayleigh(0.0, 0.0)


def read(folder: Path, bulk: str, case: str | None = None, name: str = "deck.bdf") -> Model:
    """The model of some bulk data; without case control it is set 1 of SPC and MPC that acts, where there is one."""
    path = folder / name
    if case is None:
        case = "".join(f"{key} = 1\n" for key in ("SPC", "MPC") if f"\n{key}" in f"\n{bulk}")
    path.write_text(f"SOL 103\nCEND\n{case}BEGIN BULK\n{bulk}\nENDDATA\n", encoding="utf-8")
    return read_nastran(path)


def assembled(model: Model) -> System:
    parts = [part_system(model, i, NO_DAMPING) for i in range(len(model.parts))]
    loose = loose_system(model, NO_DAMPING)
    return couple([*parts, loose] if loose else parts, model, Driven({}), NO_DAMPING)


def row(model: Model, grid: int) -> int:
    return model.nodes.ids.tolist().index(grid)


def motion(model: Model, loads: dict[tuple[int, int], float]) -> np.ndarray:
    """(n_node, 6) static displacement under forces on (grid, global dof 1..6)."""
    system = assembled(model)
    R, _ = system.rows(np.arange(6 * model.nodes.count))
    R = to_dense(R)
    f = np.zeros(R.shape[0])
    for (grid, dof), value in loads.items():
        f[6 * row(model, grid) + dof - 1] = value
    return (R @ np.linalg.solve(to_dense(system.K), R.T @ f)).reshape(-1, 6)


def matrix(model: Model, name: str, grid: int) -> np.ndarray:
    """The 6 x 6 block of M, K or C at a grid, in global axes, of the unsupported parts."""
    label = 6 * row(model, grid)
    out = np.zeros((6, 6))
    for i in range(len(model.parts)):
        system = part_system(model, i, NO_DAMPING)
        A = system.damping.extra if name == "C" else getattr(system, name)
        keep = [j for j, c in enumerate(system.coordinates.tolist()) if label <= c < label + 6]
        if keep and A is not None:
            at = system.coordinates[keep] - label
            out[np.ix_(at, at)] += to_dense(A)[np.ix_(keep, keep)]
    return out


def rigid_mass(model: Model) -> np.ndarray:
    """(6, 6) mass of all parts in rigid motion about the origin."""
    total = np.zeros((6, 6))
    motion = np.zeros((model.nodes.count, 6, 6))
    for k, (x, y, z) in enumerate(model.nodes.coords):
        motion[k] = np.eye(6)
        motion[k, :3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    flat = motion.reshape(-1, 6)
    for i in range(len(model.parts)):
        system = part_system(model, i, NO_DAMPING)
        q = flat[system.coordinates]
        total += q.T @ to_dense(system.M) @ q
    return total


def unread(model: Model) -> dict[str, bool]:
    """What was not used -> whether it changes the answer."""
    return {u.keyword: u.changes_answer for u in model.unread}
