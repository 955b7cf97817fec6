"""The same decks in CalculiX 2.20: shells with middle nodes, beams and solids of second order.

CalculiX expands shells and beams to solids of one element through the thickness, so only what that does not change is
held: free or clamped edges, no rotation held alone. Its S8 and S6 lock on coarse meshes, and S8R where they are
distorted and thin; regular S8R and fine S6 do not. It integrates the mass of C3D20R, C3D10 and C3D15 with fewer points
than are exact: hence .1 % of distorted ones.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from creak.arrays import to_dense
from creak.elements.registry import FORMULATIONS, TET10, WEDGE15
from creak.elements.solids.common import consistent_mass
from creak.elements.solids.hex20 import EIGHT
from creak.errors import InputError
from creak.formats.decks import read_model
from creak.studies.models.deck_modes import deck_modes
from helpers_core import assembled
from helpers_fem import Mesh, grid, rectangle
from helpers_solids import block

STEEL = "*MATERIAL, NAME=M\n*ELASTIC\n2.1E5, 0.3\n*DENSITY\n7.8E-9\n"
Supports = Sequence[tuple[np.ndarray, str]]
"""Nodes and `first, last` dof that they are held in."""


def modes_deck(mesh: Mesh, element: str, section: str, supports: Supports = (), count: int = 10) -> str:
    """A frequency step for `count` modes."""
    return _model(mesh, element, section, supports) + f"*STEP, PERTURBATION\n*FREQUENCY\n{count}\n*END STEP\n"


def static_deck(mesh: Mesh, element: str, section: str, supports: Supports, node: int, dof: int) -> str:
    """A unit force at a node, of which the displacement is printed."""
    step = f"*STEP\n*STATIC\n*CLOAD\n{node + 1}, {dof}, 1.\n*NODE PRINT, NSET=LOADED\nU\n*END STEP\n"
    return _model(mesh, element, section, supports) + f"*NSET, NSET=LOADED\n{node + 1},\n" + step


def _model(mesh: Mesh, element: str, section: str, supports: Supports) -> str:
    lines = ["*NODE", *(f"{n}, {x:.10g}, {y:.10g}, {z:.10g}" for n, (x, y, z) in enumerate(mesh.coords, 1))]
    lines.append(f"*ELEMENT, TYPE={element}, ELSET=E")
    for label, nodes in enumerate((mesh.elements + 1).tolist(), 1):
        words = [str(w) for w in (label, *nodes)]
        lines += [", ".join(words[:10]) + "," * (len(words) > 10), *([", ".join(words[10:])] if words[10:] else [])]
    for at, dofs in supports:
        lines += ["*BOUNDARY", *(f"{n + 1}, {dofs}" for n in at.tolist())]
    return "\n".join([*lines, section + STEEL])


def shell(thickness: float) -> str:
    return f"*SHELL SECTION, ELSET=E, MATERIAL=M\n{thickness}\n"


SOLID = "*SOLID SECTION, ELSET=E, MATERIAL=M\n"
BEAM = "*BEAM SECTION, ELSET=E, MATERIAL=M, SECTION=RECT\n6., 4.\n0., 1., 0.\n"


def plate(kind: str, n: int, m: int) -> Mesh:
    return rectangle(n, m, 100.0, 60.0, kind)


def panel(kind: str, n: int, m: int) -> Mesh:
    """80 degrees of a cylinder of radius 60, 100 long in x."""

    def shape(xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
        angle = np.deg2rad(80.0) * (eta - 0.5)
        return np.column_stack([100 * xi, 60 * np.sin(angle), 60 * np.cos(angle)])

    return grid(n, m, shape, kind)


def half_roof(kind: str, n: int) -> Mesh:
    """40 degrees from the crown (y = 0), radius 250, 250 long in x."""

    def shape(xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
        angle = np.deg2rad(40.0) * eta
        return np.column_stack([250 * xi, 250 * np.sin(angle), 250 * np.cos(angle)])

    return grid(n, n, shape, kind)


def bow(kind: str, n: int, m: int) -> Mesh:
    """A quarter of a circle of radius 100 from the root at x = 0, 20 wide in z."""

    def shape(xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
        angle = np.pi / 2 * xi
        return np.column_stack([100 * np.sin(angle), 100 * (1 - np.cos(angle)), 20 * eta])

    return grid(n, m, shape, kind)


def brick(kind: str) -> Mesh:
    """40 x 12 x 10, cells moved by up to a fifth of their size."""
    return block((4, 2, 2), (40.0, 12.0, 10.0), kind, 0.2)


def segment(kind: str) -> Mesh:
    """60 degrees of a ring from radius 30 to 40, 12 high, of 2 x 3 x 2 elements, middle nodes on the arcs."""
    mesh = block((2, 3, 2), (1.0, 1.0, 1.0), kind)
    r, angle = 30 + 10 * mesh.coords[:, 0], np.pi / 3 * mesh.coords[:, 1]
    mesh.coords[:] = np.column_stack([r * np.cos(angle), r * np.sin(angle), 12 * mesh.coords[:, 2]])
    return mesh


def straight_beam(n: int) -> Mesh:
    """n beams of three nodes, 120 long in x."""
    coords = np.zeros((2 * n + 1, 3))
    coords[:, 0] = np.linspace(0.0, 120.0, 2 * n + 1)
    return Mesh(coords, 2 * np.arange(n)[:, None] + np.arange(3), None)


def ccx(deck: str, folder: Path) -> np.ndarray:
    """Frequencies, Hz, or the displacement (3,) of the loaded node."""
    (folder / "job.inp").write_text(deck)
    subprocess.run(["ccx", "-i", "job"], cwd=folder, check=True, capture_output=True, timeout=600)
    rows = [line.split() for line in (folder / "job.dat").read_text().split("P A R T I C I P")[0].splitlines()]
    width, columns = (5, slice(3, 4)) if "*FREQUENCY" in deck else (4, slice(1, 4))
    found = [[float(w) for w in row[columns]] for row in rows if len(row) == width and row[0].isdigit()]
    return np.array(found).ravel()


RECORDED = {"section": "models", "source": "CalculiX 2.20"}


def low(mesh: Mesh) -> np.ndarray:
    return np.flatnonzero(mesh.coords[:, 0] < 1e-9)


def clamped(mesh: Mesh, element: str, section: str, dofs: str = "1, 6") -> str:
    return modes_deck(mesh, element, section, [(low(mesh), dofs)])


MODES = {
    "free plate, S8R": (
        lambda: modes_deck(plate("quad8", 12, 8), "S8R", shell(1.0)),
        [535.73, 553.635, 1251.51, 1476.19],
        0.005,
    ),
    "free plate, S6": (
        lambda: modes_deck(plate("tri6", 16, 10), "S6", shell(1.0)),
        [536.136, 555.052, 1259.47, 1480.72],
        0.005,
    ),
    "free plate, S4": (
        lambda: modes_deck(plate("quad", 24, 15), "S4", shell(1.0)),
        [536.413, 556.383, 1261.57, 1483.09],
        0.01,
    ),
    "free thick plate, S8R": (
        lambda: modes_deck(plate("quad8", 12, 8), "S8R", shell(8.0)),
        [4192.74, 4197.67, 9286.55, 11104.4],
        0.01,
    ),
    "clamped panel, S8R": (
        lambda: clamped(panel("quad8", 8, 10), "S8R", shell(1.0)),
        [438.18, 734.354, 1337.57, 1676.19, 1763.28, 2257.61],
        0.005,
    ),
    "cantilever, B32R": (
        lambda: clamped(straight_beam(24), "B32R", BEAM),
        [233.643, 349.632, 1457.57, 2168.68, 4051.99],
        0.01,
    ),
    "round cantilever, B32R": (
        lambda: clamped(straight_beam(24), "B32R", BEAM.replace("RECT\n6., 4.", "CIRC\n6., 6.")),
        [305.561, 305.561, 1899.68, 1899.68, 5252.89, 5252.89],
        0.02,
    ),
    "elliptic cantilever, B32R": (
        lambda: clamped(straight_beam(24), "B32R", BEAM.replace("RECT\n6., 4.", "CIRC\n6., 4.")),
        [203.641, 306.787, 1271.61, 1907.38, 3540.19, 5274.49],
        0.02,
    ),
    "brick, C3D20": (
        lambda: clamped(brick("hex20"), "C3D20", SOLID, "1, 3"),
        [5136.82, 6040.48, 18595.3, 26182.4, 28924.1, 32802.4],
        1e-4,
    ),
    "brick, C3D20R": (
        lambda: clamped(brick("hex20r"), "C3D20R", SOLID, "1, 3"),
        [5108.02, 6003.74, 18508.3, 26018.2, 28761.5, 32726.0],
        0.001,
    ),
    "brick, C3D10": (
        lambda: clamped(brick("tet10"), "C3D10", SOLID, "1, 3"),
        [5147.96, 6050.08, 18805.1, 26355.7, 29065.3, 32823.2],
        0.001,
    ),
    "brick, C3D15": (
        lambda: clamped(brick("wedge15"), "C3D15", SOLID, "1, 3"),
        [5120.74, 6031.83, 18599.8, 26096.9, 29034.8, 32774.2],
        0.001,
    ),
}
"""Deck, CalculiX's frequencies in Hz, tolerance."""


def arc_deck(dof: int) -> str:
    mesh = bow("quad8", 8, 2)
    tip = int(np.abs(mesh.coords - [100.0, 100.0, 10.0]).sum(axis=1).argmin())
    return static_deck(mesh, "S8R", shell(2.0), [(low(mesh), "1, 6")], tip, dof)


def roof_deck(symmetric: bool) -> str:
    mesh = half_roof("quad8", 6)
    x, y = mesh.coords[:, 0], mesh.coords[:, 1]
    held = [(np.flatnonzero(x > 250 - 1e-9), "1, 6")]
    crown = np.flatnonzero(y < 1e-9)
    held += [(crown, d) for d in ("2, 2", "4, 4", "6, 6")] if symmetric else []
    return static_deck(mesh, "S8R", shell(2.5), held, int(np.flatnonzero((x < 1e-9) & (y > y.max() - 1e-9))[0]), 3)


def turned_deck() -> str:
    """A moment about y on a rigid end, by the displacement of its rotational node."""
    mesh = brick("hex20")
    n, end = len(mesh.coords), np.flatnonzero(mesh.coords[:, 0] > 40 - 1e-9)
    body = f"*NSET, NSET=END\n{''.join(f'{k + 1},' + chr(10) for k in end)}"
    body += f"*RIGID BODY, NSET=END, REF NODE={n + 1}, ROT NODE={n + 2}\n"
    coords = np.concatenate([mesh.coords, [[45.0, 2.0, 1.0]] * 2])
    held = [(low(mesh), "1, 3")]
    return static_deck(Mesh(coords, mesh.elements, None), "C3D20", body + SOLID, held, n + 1, 2)


STATIC = {
    "bow, in its plane, S8R": (lambda: arc_deck(1), 0.273254, 1, 0.02),
    "bow, out of its plane, S8R": (lambda: arc_deck(3), 0.0767549, 3, 0.02),
    "clamped roof, force at a corner, S8R": (lambda: roof_deck(False), 0.0175453, 3, 0.005),
    "the same, symmetric, S8R": (lambda: roof_deck(True), 0.0145418, 3, 0.005),
}
"""Deck, CalculiX's displacement along the force, its dof, tolerance."""


def modes_of(deck: str, count: int, tmp_path) -> np.ndarray:
    (tmp_path / "deck.inp").write_text(deck)
    found = deck_modes(tmp_path / "deck.inp", count=count + 6)
    return np.array(found.frequencies)[found.rigid :][:count]


def displacement_of(deck: str, dof: int, tmp_path) -> float:
    (tmp_path / "deck.inp").write_text(deck)
    model = read_model(tmp_path / "deck.inp")
    loaded = int(deck.split("*CLOAD\n")[1].split(",")[0]) - 1
    system = assembled(model)
    f = to_dense(system.rows(np.array([6 * loaded + dof - 1]))[0]).ravel()
    return float(f @ np.linalg.solve(to_dense(system.K), f))


@pytest.mark.parametrize("name", MODES)
def test_modes_are_those_of_calculix(name, tmp_path, measured):
    make, expected, rel = MODES[name]
    measured(f"{name}: worst mode", modes_of(make(), len(expected), tmp_path), expected, rel=rel, unit="Hz")


@pytest.mark.parametrize(
    ("element", "kind", "rule", "theirs"),
    [
        ("C3D20R", "hex20r", EIGHT, [32302.37, 38061.12, 39708.92, 72707.16]),
        ("C3D10", "tet10", TET10[0], [32764.59, 38509.68, 41057.91, 72661.67]),
        ("C3D15", "wedge15", WEDGE15[0], [32775.18, 38132.52, 40246.56, 72681.86]),
    ],
)
def test_only_the_rule_of_mass_is_another_than_calculixs(element, kind, rule, theirs, tmp_path, monkeypatch):
    """A coarse curved piece: CalculiX's modes by its rule, nearer ones to those of 4 x 12 x 5 C3D20 by creak's own."""
    deck = modes_deck(segment(kind), element, SOLID)
    converged = np.array([31820.18, 37581.64, 39444.93, 70291.76])  # CalculiX 2.20
    own = modes_of(deck, 4, tmp_path)
    assert (converged < own).all()
    assert (own < theirs).all()
    mass = partial(consistent_mass, reference=rule)
    monkeypatch.setitem(FORMULATIONS, kind, replace(FORMULATIONS[kind], mass=mass))
    assert modes_of(deck, 4, tmp_path) == pytest.approx(theirs, rel=2e-5)


@pytest.mark.parametrize("name", STATIC)
def test_displacements_are_those_of_calculix(name, tmp_path, measured):
    make, expected, dof, rel = STATIC[name]
    measured(name, displacement_of(make(), dof, tmp_path), expected, rel=rel, unit="mm")


def test_a_rotational_node_turns_its_body_as_in_calculix(tmp_path):
    """Rotation by a unit moment, rad, and the modes of a body that cannot turn about y."""
    assert displacement_of(turned_deck(), 2, tmp_path) == pytest.approx(1.853016e-7, rel=1e-6)
    held = turned_deck().split("*STEP")[0] + "*BOUNDARY\n143, 2, 2\n*STEP\n*FREQUENCY\n3\n*END STEP\n"
    assert modes_of(held, 3, tmp_path) == pytest.approx([6040.54, 7855.86, 18599.58], rel=1e-6)  # Hz


def test_a_rotational_node_is_a_node_of_its_own(tmp_path):
    (tmp_path / "deck.inp").write_text(turned_deck().replace("ROT NODE=143", "ROTNODE=142"))
    with pytest.raises(InputError, match=r"ROT NODE=142 of \*RIGID BODY is the reference node"):
        read_model(tmp_path / "deck.inp")


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_stored_figures_are_what_calculix_finds(tmp_path):
    """One deck of each kind; all of them took 10 s."""
    make, expected, _ = MODES["clamped panel, S8R"]
    assert ccx(make(), tmp_path)[: len(expected)] == pytest.approx(expected, rel=1e-4)
    make, deflection, dof, _ = STATIC["clamped roof, force at a corner, S8R"]
    assert ccx(make(), tmp_path)[dof - 1] == pytest.approx(deflection, rel=1e-4)
