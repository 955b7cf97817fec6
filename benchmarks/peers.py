"""creak's Craig-Bampton reduction beside what a Python user would pick instead.

The frame of the door, its free-free K and M, the same boundary (supports A to G with six dofs each and the
translations of 20 nodes of the flange) and the same number of fixed-interface modes for all:

- creak: `creak.reduction.craig_bampton`.
- SciPy: SuperLU, ARPACK and a dense basis, as one writes it by hand.
- Exudyn: `FEMinterface.ComputeHurtyCraigBamptonModes` with every boundary node kept. It counts three dofs to a
  node and reads nothing else from the nodes, so six of a shell node are passed as two of its nodes.
- SDynPy: `System.reduce_craig_bampton`, on dense matrices (it takes no others).

The clock runs from the sparse K and M to the reduced K and M. Every run has a process of its own, with limits on
time and address space; imports, compilation and a small first reduction come before the clock. The answer is
judged by the lowest elastic frequencies of the free reduced part against creak's.
"""

from __future__ import annotations

import argparse
import importlib.util
import multiprocessing
import os
import resource
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
import scipy.linalg as sla
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from creak.arrays import FloatArray, IntArray, Matrix, to_dense
from creak.assembly.damping import Damping
from creak.assembly.part import common_rayleigh, part_system
from creak.assembly.system import System, no_supports
from creak.formats.abaqus.reader import read_deck
from creak.model.dofs import node_dofs
from creak.model.mesh import Model
from creak.reduction.craig_bampton import craig_bampton
from creak_thesis.door import write_door

Row = tuple[str, str, str]

MESH_SIZES = (35.0, 19.0, 10.0)
"""mm; the frame then has 10,662, 31,068 and 99,792 dofs."""
MODES = 100
FLANGE_NODES = 20
SUPPORTS = "ABCDEFG"
RIGID, ELASTIC = 6, 20
AGREE = 1e-4
"""Relative difference of a frequency above which an answer is called wrong; round-off of the dense eigenproblem,
eps omega_max^2 / omega^2 with omega_max / omega about 1e4 to 1e5, stays below 1e-5."""
LIMIT_S, LIMIT_GB = 600.0, 20.0
RUNS, BRIEF_S = 3, 30.0
"""The best of so many runs is reported, as long as the earlier ones together took no longer."""
PREPARE_S = 300.0
"""Time allowed for imports, loading and the first small reduction."""


@dataclass(frozen=True)
class Problem:
    """What is to be reduced."""

    K: Matrix
    M: Matrix
    boundary: IntArray
    count: int
    """Fixed-interface modes to keep."""


Reduction = Callable[[Problem], tuple[FloatArray, FloatArray]]
"""Problem -> reduced M and K."""


@dataclass(frozen=True)
class Peer:
    """A package and the function that loads it and gives its reduction."""

    name: str
    package: str
    load: Callable[[], Reduction]


@dataclass(frozen=True)
class Outcome:
    """What a run left; `failed` says why there is no answer."""

    failed: str = ""
    wall_s: float = np.nan
    peak_gb: float = np.nan
    frequencies: FloatArray | None = None


def load_creak() -> Reduction:
    """creak's reduction."""

    def reduce(problem: Problem) -> tuple[FloatArray, FloatArray]:
        n = problem.K.shape[0]
        labels = np.arange(n)

        def rows(wanted: IntArray) -> tuple[Matrix, Matrix]:
            return sp.identity(n, format="csr")[wanted], np.zeros((wanted.size, 0))

        part = System(
            "FRAME", problem.M, problem.K, Damping(0.0, 0.0), rows, no_supports(n), labels, np.zeros(n), labels=labels
        )
        reduced = craig_bampton(part, problem.boundary, count=problem.count)
        return to_dense(reduced.M), to_dense(reduced.K)

    return reduce


def load_scipy() -> Reduction:
    """The textbook on SciPy: one SuperLU factor of K_ii serves ARPACK and the constraint modes."""

    def reduce(problem: Problem) -> tuple[FloatArray, FloatArray]:
        K, M, b = sp.csc_matrix(problem.K), sp.csc_matrix(problem.M), problem.boundary
        n, n_b = K.shape[0], b.size
        i = np.setdiff1d(np.arange(n), b)
        K_ii, M_ii = K[i][:, i].tocsc(), M[i][:, i].tocsc()
        lu = spla.splu(K_ii, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        inverse = spla.LinearOperator(K_ii.shape, matvec=lu.solve, dtype=np.float64)
        _, Phi = spla.eigsh(K_ii, problem.count, M_ii, sigma=0.0, OPinv=inverse)
        V = np.zeros((n, n_b + problem.count))
        V[b, np.arange(n_b)] = 1.0
        V[i, :n_b] = -lu.solve(K[i][:, b].toarray())
        V[i, n_b:] = Phi
        return V.T @ (M @ V), V.T @ (K @ V)

    return reduce


def load_exudyn() -> Reduction:
    """Exudyn's Hurty-Craig-Bampton modes; the projection is that of its ObjectFFRFreducedOrderInterface."""
    from exudyn.FEM import FEMinterface, HCBstaticModeSelection

    def reduce(problem: Problem) -> tuple[FloatArray, FloatArray]:
        n, b = problem.K.shape[0], problem.boundary
        order = np.concatenate([b, np.setdiff1d(np.arange(n), b)])
        fem = FEMinterface()
        fem.nodes = {"Position": np.zeros((n // 3, 3))}
        fem.massMatrix = sp.csr_matrix(problem.M)[order][:, order]
        fem.stiffnessMatrix = sp.csr_matrix(problem.K)[order][:, order]
        fem.ComputeHurtyCraigBamptonModes(
            [list(range(b.size // 3))],
            problem.count,
            useSparseSolver=True,
            computationMode=HCBstaticModeSelection.allBoundaryNodes,
            timerTreshold=10**9,
        )
        V = fem.modeBasis["matrix"]
        return V.T @ fem.massMatrix @ V, V.T @ fem.stiffnessMatrix @ V

    return reduce


def load_sdynpy() -> Reduction:
    """SDynPy's reduction, without its symmetry check, which costs time and memory."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")  # its import starts Qt
    import sdynpy

    def reduce(problem: Problem) -> tuple[FloatArray, FloatArray]:
        labels = sdynpy.coordinate_array(np.arange(1, problem.K.shape[0] + 1), 1)
        full = sdynpy.System(labels, problem.M.toarray(), problem.K.toarray(), enforce_symmetry=False)
        reduced = full.reduce_craig_bampton(problem.boundary, problem.count)
        return reduced.M, reduced.K

    return reduce


CREAK = Peer("creak", "creak", load_creak)
PEERS = (
    Peer("SciPy", "scipy", load_scipy),
    Peer("Exudyn", "exudyn", load_exudyn),
    Peer("SDynPy", "sdynpy", load_sdynpy),
)


def frame(mesh_size: float, flange_nodes: int = FLANGE_NODES) -> Problem:
    """The door's frame, free in space, and its boundary."""
    with tempfile.TemporaryDirectory() as folder:
        model = read_deck(write_door(mesh_size, Path(folder))[0])
    part = next(k for k, p in enumerate(model.parts) if p.name == "FRAME")
    system = part_system(model, part, common_rayleigh(model))
    supports = node_dofs(np.concatenate([model.node_set(name) for name in SUPPORTS]))
    kept = np.concatenate([supports, node_dofs(_flange_nodes(model, system, flange_nodes), (1, 2, 3))])
    return Problem(system.K, system.M, np.flatnonzero(np.isin(system.coordinates, kept)), MODES)


def _flange_nodes(model: Model, system: System, count: int) -> IntArray:
    """Nodes evenly through the flange, none that follows a coupling."""
    facets = model.surfaces["FRAME_FLANGE"].facets
    used = [model.blocks[k].nodes_idx[facets[facets[:, 0] == k, 1]].ravel() for k in np.unique(facets[:, 0])]
    nodes = np.unique(np.concatenate(used))
    free = nodes[np.isin(node_dofs(nodes, (1,)), system.coordinates)]
    return free[np.unique(np.linspace(0, free.size - 1, count).astype(np.int64))]


def measure(
    peers: Sequence[Peer], mesh_sizes: Sequence[float], limit_s: float, limit_gb: float, flange_nodes: int
) -> Iterator[Row]:
    """One row per mesh size and package, creak first; who ran out of time is not asked for more."""
    late: set[str] = set()
    for mesh_size in mesh_sizes:
        problem = frame(mesh_size, flange_nodes)
        title = f"frame, {problem.K.shape[0]:,} dofs, {problem.boundary.size} kept"
        with tempfile.TemporaryDirectory() as folder:
            _save(problem, Path(folder))
            creak = _run(CREAK, Path(folder), limit_s, limit_gb)
            yield f"{title}: creak", _measured(creak, None), "-"
            for peer in peers:
                outcome = _run(peer, Path(folder), limit_s, limit_gb) if peer.name not in late else _not_run()
                if outcome.failed.startswith("over"):
                    late.add(peer.name)
                yield f"{title}: {peer.name}", _measured(outcome, creak.frequencies), _against(outcome, creak)


def peers(
    limit_s: float = LIMIT_S,
    limit_gb: float = LIMIT_GB,
    mesh_sizes: Sequence[float] = MESH_SIZES,
    flange_nodes: int = FLANGE_NODES,
) -> list[Row]:
    """Rows of the table: time and peak memory, answer, and both over creak's.

    Parameters
    ----------
    limit_s : wall-clock seconds allowed for one reduction. limit_gb : address space of its process, 1e9 bytes.
    flange_nodes : nodes of the flange whose translations are kept, besides the 42 dofs of the supports.
    """
    return list(measure(PEERS, mesh_sizes, limit_s, limit_gb, flange_nodes))


def _not_run() -> Outcome:
    return Outcome(failed="not run: over the time limit on the smaller one")


def _measured(outcome: Outcome, reference: FloatArray | None) -> str:
    if outcome.failed:
        peak = "" if np.isnan(outcome.peak_gb) else f" ({outcome.peak_gb:.1f} GB by then)"
        return outcome.failed + peak
    text = f"{outcome.wall_s:.1f} s, {outcome.peak_gb:.2f} GB"
    if reference is None or outcome.frequencies is None:
        return text
    worst = float(np.max(np.abs(outcome.frequencies / reference - 1.0)))
    return f"{text}, {'same' if worst <= AGREE else 'WRONG'} answer ({worst:.0e})"


def _against(outcome: Outcome, creak: Outcome) -> str:
    """Time and memory over creak's; a run cut off at the time limit gives a lower bound."""
    more = ">" if outcome.failed.startswith("over") else ""
    wall, peak = outcome.wall_s / creak.wall_s, outcome.peak_gb / creak.peak_gb
    if creak.failed or np.isnan(wall):
        return "-"
    return f"{more}{wall:.1f} x time, {more}{peak:.1f} x memory"


def _save(problem: Problem, folder: Path) -> None:
    sp.save_npz(folder / "K.npz", sp.csr_matrix(problem.K), compressed=False)
    sp.save_npz(folder / "M.npz", sp.csr_matrix(problem.M), compressed=False)
    np.savez(folder / "rest.npz", boundary=problem.boundary, count=problem.count)


def _load(folder: Path) -> Problem:
    with np.load(folder / "rest.npz") as rest:
        boundary, count = rest["boundary"], int(rest["count"])
    return Problem(sp.load_npz(folder / "K.npz"), sp.load_npz(folder / "M.npz"), boundary, count)


def _run(peer: Peer, folder: Path, limit_s: float, limit_gb: float) -> Outcome:
    """One reduction in a process of its own."""
    if importlib.util.find_spec(peer.package) is None:
        return Outcome(failed="not installed")
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_child, args=(peer, folder, limit_gb, theirs), daemon=True)
    process.start()
    theirs.close()
    try:
        return _wait(ours, process.pid, limit_s)
    except EOFError:
        process.join()
        return Outcome(failed=f"process died ({_died(process.exitcode)})")
    finally:
        process.kill()
        process.join()


def _wait(pipe: Connection, pid: int | None, limit_s: float) -> Outcome:
    """The child's outcome: it says None when it is ready and after its first reduction, or why it failed."""
    if not pipe.poll(PREPARE_S):
        return Outcome(failed=f"not ready after {PREPARE_S:.0f} s")
    said: Outcome | None = pipe.recv()
    if said is None and not pipe.poll(limit_s):
        return Outcome(f"over {limit_s:.0f} s", limit_s, _peak_gb(pid))
    while said is None:
        said = pipe.recv()
    return said


def _died(code: int | None) -> str:
    return f"signal {-code}" if code is not None and code < 0 else f"status {code}"


def _child(peer: Peer, folder: Path, limit_gb: float, pipe: Connection) -> None:
    limit = int(limit_gb * 1e9)
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    try:
        reduce = peer.load()
        problem = _load(folder)
        reduce(_chain())
        walls: list[float] = []
        while len(walls) < RUNS and sum(walls) < BRIEF_S:
            pipe.send(None)
            started = time.perf_counter()
            M, K = reduce(problem)
            walls.append(time.perf_counter() - started)
        pipe.send(None)
        peak = _peak_gb(None)
        pipe.send(Outcome("", min(walls), peak, _elastic_frequencies(M, K)))
    except MemoryError:
        pipe.send(Outcome(failed=f"out of memory (limit {limit_gb:.0f} GB)", peak_gb=_peak_gb(None)))
    except Exception as error:
        pipe.send(Outcome(failed=f"{type(error).__name__}: {error}", peak_gb=_peak_gb(None)))


def _chain() -> Problem:
    """Springs and masses in a row: a small problem to load all libraries with."""
    n = 900
    K = sp.diags_array([-np.ones(n - 1), 2.0 * np.ones(n), -np.ones(n - 1)], offsets=[-1, 0, 1], format="csr")
    return Problem(sp.csr_matrix(K), sp.identity(n, format="csr"), np.arange(6), 8)


def _elastic_frequencies(M: FloatArray, K: FloatArray) -> FloatArray:
    """(ELASTIC,) lowest frequencies above those of the rigid body, Hz."""
    omega2 = sla.eigh(0.5 * (K + K.T), 0.5 * (M + M.T), eigvals_only=True, subset_by_index=[0, RIGID + ELASTIC - 1])
    return np.asarray(np.sqrt(np.maximum(omega2[RIGID:], 0.0)) / (2.0 * np.pi))


def _peak_gb(pid: int | None) -> float:
    """Largest resident memory of a process so far, 1e9 bytes (Linux)."""
    lines = Path(f"/proc/{pid or 'self'}/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM")) * 1024e-9


def main() -> None:
    """Measure and print a row as soon as it is there."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.peers")
    parser.add_argument("--mesh-sizes", type=float, nargs="+", default=MESH_SIZES, help="mm")
    parser.add_argument("--limit", type=float, default=LIMIT_S, help="s for one reduction")
    parser.add_argument("--memory", type=float, default=LIMIT_GB, help="GB of address space of one process")
    parser.add_argument("--flange-nodes", type=int, default=FLANGE_NODES, help="nodes of the flange to keep")
    parser.add_argument("--only", nargs="+", default=[p.package for p in PEERS], choices=[p.package for p in PEERS])
    given = parser.parse_args()
    chosen = [p for p in PEERS if p.package in given.only]
    rows = measure(chosen, given.mesh_sizes, given.limit, given.memory, given.flange_nodes)
    for what, measured, against in rows:
        print(f"{what:<42} {measured:<48} {against}", flush=True)


if __name__ == "__main__":
    main()
