"""Geometric stiffness against closed forms: element by element, then modes of decks with a static step before them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from creak.elements.registry import FORMULATIONS
from creak.elements.solids import hex8 as solid_hex8
from creak.elements.solids import hex20 as solid_hex20
from creak.elements.solids.tetrahedra import EDGES
from creak.errors import InputError, NumericalError
from creak.model.faces import MIDDLES
from creak.model.materials import Material, SolidSection, TrussSection
from creak.model.mesh import Own
from creak.studies.models.deck_modes import deck_modes
from helpers_fem import random_rotation, shell_section

RECORDED = {"section": "beams and solids"}

E, NU = 2e5, 0.3
STEEL = Material("M", E, NU, 7.85e-9)
TET = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
WEDGE = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]])


def middled(corners: np.ndarray, edges: tuple[tuple[int, int], ...]) -> np.ndarray:
    return np.concatenate([corners, corners[np.array(edges)].mean(axis=1)])


SOLIDS = {
    "tet4": TET,
    "tet10": middled(TET, EDGES),
    "wedge6": WEDGE,
    "wedge15": middled(WEDGE, MIDDLES["wedge15"]),
    "pyramid5": np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [0, 0, 1]]),
    "hex8": solid_hex8.CORNERS,
    **dict.fromkeys(("hex20", "hex20r", "hex20s"), solid_hex20.NODES),
}
VOLUME = {"t": 1 / 6, "w": 1 / 2, "p": 4 / 3, "h": 8.0}


@pytest.mark.parametrize("kind", SOLIDS)
def test_solids_under_constant_stress(kind):
    """u = A x, w = B x: energy sigma : B' B times the volume, in any position."""
    rng, Q = np.random.default_rng(3), random_rotation(4)
    A, B = 1e-3 * rng.standard_normal((3, 3)), rng.standard_normal((3, 3))
    strain = 0.5 * (A + A.T)
    stress = E / (1 + NU) * (strain + NU / (1 - 2 * NU) * np.trace(strain) * np.eye(3))
    x = SOLIDS[kind] @ (np.eye(3) + 0.1 * rng.standard_normal((3, 3))).T
    volume = VOLUME[kind[0]] * abs(np.linalg.det(np.linalg.lstsq(SOLIDS[kind], x, rcond=None)[0]))
    u, w = (np.concatenate([x @ M.T @ Q.T, np.zeros_like(x)], axis=1) for M in (A, B))
    K = FORMULATIONS[kind].geometric((x @ Q.T)[None], SolidSection("S", STEEL), Own(), u[None])[0]
    assert w.ravel() @ K @ w.ravel() == pytest.approx(volume * np.trace(B @ stress @ B.T), rel=1e-9)


@pytest.mark.parametrize("kind", ["quad4", "tri3"])
def test_shells_under_constant_membrane_force(kind):
    corners = np.array([[0.0, 0, 0], [2, 0.1, 0], [2.2, 1.5, 0], [-0.1, 1, 0]])[: 4 if kind == "quad4" else 3]
    e1, e2, g12 = 1e-3, -3e-4, 5e-4
    N = E * 0.5 / (1 - NU**2) * np.array([[e1 + NU * e2, 0.35 * g12], [0.35 * g12, e2 + NU * e1]])
    u, w, Q = np.zeros((len(corners), 6)), np.zeros((len(corners), 6)), random_rotation(5)
    u[:, :2] = corners[:, :2] @ np.array([[e1, 0.5 * g12], [0.5 * g12, e2]])
    slope = np.array([0.3, 0.7])
    w[:, 2] = corners[:, :2] @ slope
    turned = np.kron(np.eye(2), Q)
    u, w = u @ turned.T, w @ turned.T
    K = FORMULATIONS[kind].geometric((corners @ Q.T)[None], shell_section(0.5, E, NU), Own(), u[None])[0]
    x, y = corners[:, 0], corners[:, 1]
    area = 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    assert w.ravel() @ K @ w.ravel() == pytest.approx(area * slope @ N @ slope, rel=1e-9)


def test_a_truss_in_tension_is_a_string():
    line, u = np.array([[[0.0, 0, 0], [0, 30.0, 40.0]]]), np.zeros((1, 2, 6))
    u[0, 1, 2] = 0.1
    K = FORMULATIONS["truss2"].geometric(line, TrussSection("T", STEEL, 2.0), Own(), u)[0]
    force = E * 2.0 * 0.1 * 0.8 / 50.0
    assert K[6, 6] == pytest.approx(force / 50.0)
    along = np.zeros(12)
    along[7:9] = 0.6, 0.8
    assert np.abs(K @ along).max() < 1e-9 * force


def deck(tmp_path, mesh: str, step: str, nlgeom: str = ", NLGEOM=YES", modes: str = "*STEP"):
    path = tmp_path / "deck.inp"
    static = f"*STEP{nlgeom}\n*STATIC\n1., 1.\n{step}*END STEP\n" if step else ""
    material = "*MATERIAL, NAME=M\n*ELASTIC\n2e5, .3\n*DENSITY\n7.85e-9\n"
    path.write_text(f"*NODE, NSET=ALL\n{mesh}{material}{static}{modes}\n*FREQUENCY\n4\n*END STEP\n", encoding="utf-8")
    return path


LENGTH, N = 1000.0, 10
COLUMN = (
    "".join(f"{i + 1}, {LENGTH * i / N}\n" for i in range(N + 1))
    + "*ELEMENT, TYPE=B33, ELSET=E\n"
    + "".join(f"{i + 1}, {i + 1}, {i + 2}\n" for i in range(N))
    + "*BEAM SECTION, ELSET=E, MATERIAL=M, SECTION=RECT\n10., 20.\n0., 0., 1.\n"
    + f"*BOUNDARY\n1, 1, 4\n{N + 1}, 2, 4\n"
)
"""Simply supported; weak about global z: 20 x 10^3/12."""
CRITICAL = math.pi**2 * E * (20.0 * 10.0**3 / 12.0) / LENGTH**2


PUSH = f"*CLOAD\n{N + 1}, 1, -1.\n"


@pytest.mark.parametrize("load", [0.9, 0.5, -2.0])
def test_a_column_slows_down_as_it_nears_buckling(tmp_path, load, measured):
    """omega^2 = omega_0^2 (1 - P/P_c)."""
    stressed = deck_modes(deck(tmp_path, COLUMN, f"*CLOAD\n{N + 1}, 1, {-load * CRITICAL}\n"), count=1)
    free = deck_modes(deck(tmp_path, COLUMN, ""), count=1)
    found, wanted = stressed.frequencies[0], free.frequencies[0] * math.sqrt(1.0 - load)
    row = f"column under {load:g} of its critical load: first frequency"
    measured(row, found, wanted, rel=1e-3, unit="Hz", source="omega_0 sqrt(1 - P/P_c)")
    note = {u.keyword: u for u in stressed.model.unread}["*STATIC"]
    assert not note.changes_answer
    assert "stiffens the structure in these modes" in note.why
    assert stressed.prestress is not None
    assert free.prestress is None


def test_beyond_the_critical_load_there_are_no_modes(tmp_path):
    with pytest.raises(NumericalError, match="buckles"):
        deck_modes(deck(tmp_path, COLUMN, f"*CLOAD\n{N + 1}, 1, {-1.1 * CRITICAL}\n"), count=1)


def plate(kind: str, n: int = 8, side: float = 100.0) -> str:
    nodes = "".join(
        f"{i * (n + 1) + j + 1}, {side * i / n}, {side * j / n}\n" for i in range(n + 1) for j in range(n + 1)
    )
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n) + 1).ravel()
    quads = np.column_stack([a, a + n + 1, a + n + 2, a + 1])
    rows = quads if kind == "S4" else quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    elements = "".join(f"{k}, {', '.join(map(str, row))}\n" for k, row in enumerate(rows, start=1))
    ends = [f"*NSET, NSET=X{e}, GENERATE\n{first}, {first + n}\n" for e, first in ((0, 1), (1, n * (n + 1) + 1))]
    sides = [f"*NSET, NSET=Y{e}, GENERATE\n{1 + e * n}, {n * (n + 1) + 1 + e * n}, {n + 1}\n" for e in (0, 1)]
    held = "*BOUNDARY\nX0, 1, 1\nX0, 3, 4\nX1, 3, 4\nY0, 3, 3\nY0, 5, 5\nY1, 3, 3\nY1, 5, 5\n1, 2, 2\n"
    return (
        f"{nodes}*ELEMENT, TYPE={kind}, ELSET=E\n{elements}{''.join(ends + sides)}"
        f"*SHELL SECTION, ELSET=E, MATERIAL=M\n1.\n{held}"
    )


@pytest.mark.parametrize(("kind", "limit"), [("S4", 0.01), ("S3", 0.01)])
def test_a_plate_in_tension(tmp_path, kind, limit, measured):
    """Simply supported and stretched by u: omega^2 rho t = D (2 pi^2/a^2)^2 + N (pi/a)^2, N = E t u/a."""
    side, pull = 100.0, 0.2
    found = deck_modes(deck(tmp_path, plate(kind), f"*BOUNDARY\nX1, 1, 1, {pull}\n"), count=1).frequencies[0]
    D, force = E / (12 * (1 - NU**2)), E * pull / side
    wanted = math.sqrt((4 * D * (math.pi / side) ** 4 + force * (math.pi / side) ** 2) / 7.85e-9) / (2 * math.pi)
    measured(
        f"plate in tension, {kind}: first frequency",
        found,
        wanted,
        rel=limit,
        unit="Hz",
        source="Navier",
        section="shell modes",
    )


@pytest.mark.parametrize(
    ("mesh", "step", "nlgeom", "words"),
    [
        (COLUMN + "*CONTACT\n*CONTACT INCLUSIONS, ALL EXTERIOR\n", PUSH, ", NLGEOM", "would change the answer"),
        (COLUMN + "*MATERIAL, NAME=X\n*ELASTIC\n1.\n*PLASTIC\n1., 0.\n", PUSH, ", NLGEOM", "would change the answer"),
        (COLUMN, "*DLOAD\nE, GRAV, 9810., 0., 0., -1.\n", ", NLGEOM", "would change the answer"),
        (COLUMN, f"*CLOAD\n{N + 1}, 5, 1.\n", ", NLGEOM", "would change the answer"),
        (COLUMN, f"*CLOAD, FOLLOWER\n{N + 1}, 1, 1.\n", ", NLGEOM", "would change the answer"),
        (
            COLUMN + "*ELEMENT, TYPE=SPRINGA, ELSET=K\n90, 3, 5\n*SPRING, ELSET=K\n\n5.\n",
            PUSH,
            ", NLGEOM",
            r"stiffens element 90 \(axial2\) in a way that creak does not know",
        ),
        (COLUMN + "*MPC\nBEAM, 3, 5\n", PUSH, ", NLGEOM", "RigidLink"),
    ],
)
def test_what_creak_cannot_follow_stops(tmp_path, mesh, step, nlgeom, words):
    with pytest.raises(InputError, match=words):
        deck_modes(deck(tmp_path, mesh, step, nlgeom), count=1)


def test_without_nlgeom_and_with_ignore_there_is_no_stress(tmp_path):
    load = f"*CLOAD\n{N + 1}, 1, {-0.9 * CRITICAL}\n"
    free = deck_modes(deck(tmp_path, COLUMN, ""), count=1).frequencies
    assert deck_modes(deck(tmp_path, COLUMN, load, ""), count=1).frequencies == free
    assert deck_modes(deck(tmp_path, COLUMN, load), count=1, ignore=["STATIC"]).frequencies == free
