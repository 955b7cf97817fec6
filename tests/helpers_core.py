"""Systems, gap channels and small models built by hand, for tests of the numerical core."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

from creak.assembly.coupling import Driven, couple
from creak.assembly.damping import Damping
from creak.assembly.part import Rayleigh, common_rayleigh, loose_system, part_system
from creak.assembly.system import System, no_supports
from creak.contact.gap_operator import ChannelRows, GapOperator, join
from creak.dynamics.history import ENERGIES, History
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import march, simulate
from creak.model.constraints import Constraint, Fixed
from creak.model.materials import BeamSection, Material, PointMass, Section, ShellSection, Spring
from creak.model.mesh import ElementBlock, Model, Nodes, Part, Surface
from creak_thesis.measure import PlainNewton

NO_DAMPING = Rayleigh(0.0, 0.0)
NONE = Driven({})
NO_CHANNELS = join([])


def system_of(
    M: np.ndarray,
    K: np.ndarray,
    *,
    alpha: float = 0.0,
    beta: float = 0.0,
    extra: np.ndarray | None = None,
    velocity: np.ndarray | None = None,
    sparse: bool = True,
) -> System:
    """A System straight from matrices; the physical dof labels are 0..n-1."""
    n = M.shape[0]

    def rows(labels: np.ndarray) -> tuple[sp.csr_matrix, np.ndarray]:
        pick = sp.csr_matrix((np.ones(labels.size), (np.arange(labels.size), labels)), shape=(labels.size, n))
        return pick, np.zeros((labels.size, 0))

    def kind(A: np.ndarray | None) -> object:
        return A if A is None or not sparse else sp.csr_matrix(A)

    return System(
        "by hand",
        kind(M),
        kind(K),
        Damping(alpha, beta, kind(extra)),
        rows,
        no_supports(n),
        np.arange(n, dtype=np.int64),
        np.zeros(n) if velocity is None else np.asarray(velocity, float),
        labels=np.arange(n, dtype=np.int64),
    )


def channels(
    G: np.ndarray,
    gap0: np.ndarray | float,
    stiffness: np.ndarray | float,
    damping: np.ndarray | float = 0.0,
    group: str = "stop",
) -> GapOperator:
    """Channels g = gap0 + G u over the labels 0..n-1; G is (m, n) dense."""
    G = np.atleast_2d(np.asarray(G, dtype=float))
    m = G.shape[0]
    channel, label = (a.ravel() for a in np.indices(G.shape))
    zero = np.zeros(G.size)

    def each(x: np.ndarray | float) -> np.ndarray:
        return np.broadcast_to(np.asarray(x, dtype=float), (m,)).copy()

    return GapOperator(
        **ChannelRows(channel, label, G.ravel(), zero, zero).motion(m),
        gap0=each(gap0),
        stiffness=each(stiffness),
        damping=each(damping),
        step_limited=np.zeros(m, dtype=bool),
        area=np.zeros(m),
        names=tuple(f"{group}:{j}" for j in range(m)),
        nodes_idx=np.arange(m, dtype=np.int64),
        group=(group,) * m,
    )


def time_axis(end: float, step: float) -> np.ndarray:
    return step * np.arange(round(end / step) + 1)


def forces_on(time: np.ndarray, labels: Sequence[int], values: np.ndarray) -> Loads:
    """One force history (n_time,) or (n_time, k) on each label."""
    values = np.asarray(values, dtype=float).reshape(time.size, -1)
    return Loads(time, np.zeros((3, time.size, 0)), values, tuple(np.array([x], dtype=np.int64) for x in labels))


def free_run(system: System, gaps: GapOperator, end: float, step: float, alpha: float = -0.05) -> History:
    """Motion from the initial velocity alone; every dof label 0..n-1 is observed."""
    loads = Loads(time_axis(end, step), np.zeros((3, round(end / step) + 1, 0)), np.zeros((round(end / step) + 1, 0)))
    return simulate(system, gaps, loads, HHT(alpha), OutputRequest(np.arange(system.n)))


def bar(n: int, length: float, rigidity: float, mass_per_length: float) -> tuple[np.ndarray, np.ndarray]:
    """M (consistent) and K of a free bar of n linear elements."""
    dx = length / n
    M, K = np.zeros((n + 1, n + 1)), np.zeros((n + 1, n + 1))
    for e in range(n):
        K[e : e + 2, e : e + 2] += rigidity / dx * np.array([[1.0, -1.0], [-1.0, 1.0]])
        M[e : e + 2, e : e + 2] += mass_per_length * dx / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
    return M, K


def chain(n: int, mass: float = 1.0, stiffness: float = 1e4) -> tuple[np.ndarray, np.ndarray]:
    """M and K of n masses in a row, the first tied to ground."""
    K = stiffness * (2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    K[-1, -1] = stiffness
    return mass * np.eye(n), K


# --- models ---------------------------------------------------------------------------------------------

STEEL = Material("STEEL", 2.1e11, 0.3, 7850.0)


def block(kind: str, nodes: np.ndarray, section: Section, part: int = 0, first: int = 1) -> ElementBlock:
    nodes = np.atleast_2d(np.asarray(nodes, dtype=np.int64))
    return ElementBlock(kind, np.arange(first, first + nodes.shape[0]), nodes, section, part, "test.inp:1")


def nodes_of(coords: np.ndarray) -> Nodes:
    """Nodes of which the labels are row + 1."""
    return Nodes(np.arange(1, len(coords) + 1), np.asarray(coords, dtype=float))


def model_of(
    coords: np.ndarray,
    blocks: Sequence[ElementBlock],
    parts: Sequence[tuple[str, Sequence[int]]] | None = None,
    *,
    constraints: Sequence[Constraint] = (),
    fixed: Sequence[Fixed] = (),
    node_sets: dict[str, Sequence[int]] | None = None,
    element_sets: dict[str, np.ndarray] | None = None,
    surfaces: Sequence[Surface] = (),
    initial_velocity: Sequence[tuple[int, int, float]] = (),
) -> Model:
    """A Model; node labels are row + 1, one part with all nodes unless `parts` says otherwise."""
    coords = np.asarray(coords, dtype=float)
    n = coords.shape[0]
    parts = parts if parts is not None else [("PART", range(n))]
    return Model(
        source="test.inp",
        nodes=nodes_of(coords),
        blocks=tuple(blocks),
        parts=tuple(Part(name, np.array(list(rows), dtype=np.int64)) for name, rows in parts),
        node_sets={k: np.array(list(v), dtype=np.int64) for k, v in (node_sets or {}).items()},
        element_sets=element_sets or {},
        surfaces={s.name: s for s in surfaces},
        constraints=tuple(constraints),
        fixed=tuple(fixed),
        initial_velocity=tuple(initial_velocity),
    )


def assembled(model: Model, driven: Driven = NONE, rayleigh: Rayleigh | None = None) -> System:
    """Parts and loose nodes of a model joined into one unreduced System."""
    rayleigh = rayleigh or common_rayleigh(model)
    systems = [part_system(model, i, rayleigh) for i in range(len(model.parts))]
    loose = loose_system(model, rayleigh)
    return couple([*systems, loose] if loose is not None else systems, model, driven, rayleigh)


def beam_section(area: float = 1e-4, i: float = 1e-9, material: Material = STEEL) -> BeamSection:
    return BeamSection("B", material, area, i, i, 2.0 * i)


def straight_beam(n: int, length: float, y: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n + 1, 3) along x and elements (n, 2)."""
    x = np.linspace(0.0, length, n + 1)
    coords = np.column_stack([x, np.full(n + 1, y), np.zeros(n + 1)])
    return coords, np.column_stack([np.arange(n), np.arange(1, n + 1)])


def spring(stiffness: float, dof: int = 1, damping: float = 0.0) -> Spring:
    return Spring("SPRING", dof, dof, stiffness, damping)


def point_mass(mass: float, alpha: float = 0.0) -> PointMass:
    return PointMass("MASS", mass, alpha=alpha)


def plate(
    n_x: int, n_y: int, size: tuple[float, float] = (1.0, 1.0), z: float = 0.0, kind: str = "quad4"
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and elements of a rectangle in the plane z, normals along +z."""
    x, y = np.meshgrid(np.linspace(0.0, size[0], n_x + 1), np.linspace(0.0, size[1], n_y + 1), indexing="ij")
    coords = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, z)])
    first = (np.arange(n_x)[:, None] * (n_y + 1) + np.arange(n_y)).ravel()
    quads = np.column_stack([first, first + n_y + 1, first + n_y + 2, first + 1])
    if kind == "tri3":
        return coords, quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    return coords, quads


def whole_block(row: int, count: int, side: int = 0, name: str = "S") -> Surface:
    """A surface of all `count` elements of one block."""
    facets = np.column_stack([np.full(count, row), np.arange(count)]).astype(np.int64)
    return Surface(name, facets, np.full(count, side, dtype=np.int64), np.zeros(0, dtype=np.int64))


def shell(thickness: float, material: Material = STEEL) -> ShellSection:
    return ShellSection("SHELL", material, thickness)


def history_of(time: Any, gap: Any, force: Any = None, *, stiffness: float = 1e3, **more: Any) -> History:
    """A history of given gaps and forces (n_time,) or (n_time, m); without forces those of a penalty."""
    gap = np.asarray(gap, dtype=float).reshape(time.size, -1)
    force = stiffness * np.maximum(0.0, -gap) if force is None else np.asarray(force, dtype=float).reshape(gap.shape)
    none, energy = np.zeros((time.size, 0)), np.zeros((time.size, len(ENERGIES)))
    return History(time, gap, force, np.zeros_like(gap), np.arange(time.size), none, energy, 0, 0.0, **more)


def simulate_plain_newton(system, gaps, loads, scheme, asked):
    """As `simulate`, by plain Newton."""
    return march(PlainNewton(system, gaps, loads, scheme), asked)
