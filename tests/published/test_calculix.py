"""The same decks in CalculiX 2.20: shells with middle nodes, beams and solids of second order.

CalculiX expands shells and beams to solids of one element through the thickness, so only what that does not change is
held: free or clamped edges, no rotation held alone. Its S8 and S6 lock on coarse meshes; S8R and fine S6 do not. It
integrates the mass of C3D20R, C3D10 and C3D15 with fewer points than are exact: hence .1 % of distorted ones.
"""

from __future__ import annotations

import shutil

import numpy as np
import pytest

from creak.arrays import to_dense
from creak.formats.decks import read_model
from creak.studies.models.deck_modes import deck_modes
from helpers_ccx import (
    BEAM,
    SOLID,
    bow,
    brick,
    ccx,
    half_roof,
    modes_deck,
    panel,
    plate,
    shell,
    static_deck,
    straight_beam,
)
from helpers_core import assembled
from helpers_fem import Mesh

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


@pytest.mark.parametrize("name", STATIC)
def test_displacements_are_those_of_calculix(name, tmp_path, measured):
    make, expected, dof, rel = STATIC[name]
    measured(name, displacement_of(make(), dof, tmp_path), expected, rel=rel, unit="mm")


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_stored_figures_are_what_calculix_finds(tmp_path):
    """One deck of each kind; all of them took 10 s."""
    make, expected, _ = MODES["clamped panel, S8R"]
    assert ccx(make(), tmp_path)[: len(expected)] == pytest.approx(expected, rel=1e-4)
    make, deflection, dof, _ = STATIC["clamped roof, force at a corner, S8R"]
    assert ccx(make(), tmp_path)[dof - 1] == pytest.approx(deflection, rel=1e-4)
