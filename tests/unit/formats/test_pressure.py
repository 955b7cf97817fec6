"""Pressure of decks as forces at nodes: PLOAD, PLOAD2, PLOAD4, *DLOAD, *DSLOAD."""

from __future__ import annotations

import numpy as np
import pytest

from creak.errors import InputError
from creak.formats.abaqus.reader import read_deck_run
from creak.formats.deck.pressure import Pressed, nodal_forces, point_loads
from creak.model.faces import shapes_of
from creak.model.steps import StaticLoads
from helpers_nastran import motion, read, row

RECORDED = {"section": "decks"}

STEEL = "MAT1,1,7.+4,,0.,2.7-9"
BOX = "\n".join(
    f"GRID,{k},,{x},{y},{z}"
    for k, (x, y, z) in enumerate(
        ((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (2.0, 3.0, 0.0), (0.0, 3.0, 0.0))
        + ((0.0, 0.0, 4.0), (2.0, 0.0, 4.0), (2.0, 3.0, 4.0), (0.0, 3.0, 4.0)),
        1,
    )
)
HEXA = f"{BOX}\nCHEXA,1,1,1,2,3,4,5,6,+\n+,7,8\nPSOLID,1,1\n{STEEL}"
QUAD = f"{BOX}\nCQUAD4,1,1,1,2,3,4\nPSHELL,1,1,1.,1,,1\n{STEEL}"


def total(loads: StaticLoads) -> np.ndarray:
    """(3,) resultant."""
    if loads.flaw is not None:
        raise loads.flaw
    out = np.zeros(3)
    for f in loads.forces:
        out[f.dof - 1] += f.value * f.nodes_idx.size
    return out


def test_resultant_and_moment_of_a_pressure_on_warped_facets():
    rng = np.random.default_rng(1)
    coords = np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0.3], [0, 1, 0], [3, 0.5, 0.1]]) + 0.1 * rng.standard_normal(
        (5, 3)
    )
    corners = np.array([[0, 1, 2, 3], [1, 4, 2, 2]])
    rows, forces = nodal_forces(Pressed(shapes_of(corners, []), np.full((2, 4), 5.0), np.full((2, 3), np.nan)), coords)
    x = coords[corners]
    assert forces.sum(axis=0) == pytest.approx(2.5 * np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]).sum(axis=0))
    flat = np.array([[0.0, 0, 0], [2, 0, 0], [2, 3, 0], [0, 3, 0]])
    tent = np.array([[0.0, 6.0, 6.0, 0.0]])
    rows, forces = nodal_forces(Pressed(shapes_of(np.array([[0, 1, 2, 3]]), []), tent, np.full((1, 3), np.nan)), flat)
    assert forces[:, 2].sum() == pytest.approx(3.0 * 6.0)
    assert forces[:, 2] @ flat[rows, 0] == pytest.approx(18.0 * 4.0 / 3.0), "a third from the heavy side"
    triangle = Pressed(
        shapes_of(np.array([[0, 1, 2, 2]]), []), np.array([[0.0, 6.0, 0.0, 0.0]]), np.array([[1.0, 0.0, 0.0]])
    )
    rows, forces = nodal_forces(triangle, flat)
    assert forces.sum(axis=0) == pytest.approx([6.0, 0.0, 0.0])
    assert forces[:, 0] @ flat[rows, 0] == pytest.approx(6.0 * (0.25 * 0 + 0.5 * 2 + 0.25 * 2))
    loads = point_loads(rows, forces, "A", "here")
    assert {f.dof for f in loads} == {1}
    assert sum(f.value * f.nodes_idx.size for f in loads) == pytest.approx(6.0)


@pytest.mark.parametrize(
    ("bulk", "card", "exact"),
    [
        (QUAD, "PLOAD2,7,.5,1", (0.0, 0.0, 3.0)),
        (QUAD, "PLOAD2,7,.5,1,THRU,9", (0.0, 0.0, 3.0)),
        (QUAD, "PLOAD,7,.5,1,4,3,2", (0.0, 0.0, -3.0)),
        (QUAD, "PLOAD4,7,1,.5", (0.0, 0.0, 3.0)),
        (QUAD, "PLOAD4,7,1,0.,1.,1.,0.", (0.0, 0.0, 3.0)),
        (QUAD, "PLOAD4,7,1,.5,,,,THRU,1", (0.0, 0.0, 3.0)),
        (QUAD, "PLOAD4,7,1,.5,,,,,,+\n+,,1.,0.,0.", (3.0, 0.0, 0.0)),
        (QUAD, "PLOAD4,5,1,.5\nLOAD,7,2.,3.,5", (0.0, 0.0, 18.0)),
        (HEXA, "PLOAD4,7,1,.5,,,,5,7", (0.0, 0.0, -3.0)),
        (HEXA, "PLOAD4,7,1,.5,,,,1,6", (0.0, 4.0, 0.0)),
    ],
)
def test_resultants_of_nastran_pressures(tmp_path, bulk, card, exact):
    loads = read(tmp_path, f"{bulk}\n{card}").static_loads["7"]
    assert total(loads) == pytest.approx(exact, abs=1e-12)


@pytest.mark.parametrize(
    ("bulk", "card", "told"),
    [
        (QUAD, "PLOAD2,7,.5,9", "presses element 9, which is not there"),
        (HEXA, "PLOAD2,7,.5,1", "without such a surface"),
        (HEXA, "PLOAD4,7,1,.5", "name 0 faces"),
        (HEXA, "PLOAD4,7,1,.5,.6,,,5,7", "varies over the face"),
        (QUAD, "PLOAD4,7,1,.5,,,,,,+\n+,,1.,0.,0.,LINE", "SORL or LDIR"),
        (QUAD, "PLOAD,7,.5,1,2", "with 2 grids"),
    ],
)
def test_pressures_that_cannot_be_read_are_told_where_they_are_used(tmp_path, bulk, card, told):
    model = read(tmp_path, f"{bulk}\n{card}")
    with pytest.raises(InputError, match=told):
        total(model.static_loads["7"])


@pytest.mark.parametrize("kind", ["CQUAD4", "CQUAD8"])
def test_a_strip_under_pressure_sinks_as_beam_theory_says(tmp_path, kind, measured):
    """p b L^4 / (8 E I) at the tip, nu = 0."""
    n, length, width, p = 12, 120.0, 10.0, 1e-4
    wide = n + 1
    lines = [f"GRID,{1 + i + wide * j},,{length * i / n},{0.5 * width * j},0." for j in range(3) for i in range(wide)]
    if kind == "CQUAD4":
        cells = [(a := 1 + i + wide * j, a + 1, a + 1 + wide, a + wide) for j in range(2) for i in range(n)]
        lines += [f"CQUAD4,{k},1,{','.join(map(str, c))}" for k, c in enumerate(cells, 1)]
    else:
        for k, i in enumerate(range(0, n, 2), 1):
            at = [1 + i, 3 + i, 3 + i + 2 * wide, 1 + i + 2 * wide, 2 + i, 3 + i + wide]
            lines.append(f"CQUAD8,{k},1,{','.join(map(str, at))},+")
            lines.append(f"+,{2 + i + 2 * wide},{1 + i + wide}")
        lines = [line for line in lines if not _is_centre(line, wide)]
    roots = [1, 1 + wide, 1 + 2 * wide]
    bulk = "\n".join(
        [
            *lines,
            "PSHELL,1,1,1.,1,,1",
            STEEL,
            f"SPC1,1,123456,{','.join(map(str, roots))}",
            "PLOAD4,7,1,1.-4,,,,THRU,99",
        ]
    )
    model = read(tmp_path, bulk)
    forces: dict[tuple[int, int], float] = {}
    for f in model.static_loads["7"].forces:
        for node in f.nodes_idx.tolist():
            key = (int(model.nodes.ids[node]), f.dof)
            forces[key] = forces.get(key, 0.0) + f.value
    tip = motion(model, forces)[row(model, wide), 2]
    exact = p * width * length**4 / (8 * 7e4 * width / 12)
    measured(f"cantilever of {kind} under PLOAD4, tip", tip, exact, rel=0.01, unit="mm", source="beam theory")


def _is_centre(line: str, wide: int) -> bool:
    """Grid in the middle of an eight-node element."""
    if not line.startswith("GRID"):
        return False
    number = int(line.split(",")[1]) - 1
    return number // wide == 1 and (number % wide) % 2 == 1


DECK = (
    "*NODE\n1,0,0,0\n2,2,0,0\n3,2,3,0\n4,0,3,0\n5,0,0,4\n6,2,0,4\n7,2,3,4\n8,0,3,4\n"
    "*ELEMENT, TYPE={kind}, ELSET=P\n1, {nodes}\n{section}*MATERIAL, NAME=M\n*ELASTIC\n7e4, 0.3\n*DENSITY\n2.7e-9\n"
    "*SURFACE, NAME=TOP\nP, {side}\n*BOUNDARY\n1, 1, 6\n"
    "*STEP\n*STATIC\n1., 1.\n{load}*END STEP\n*STEP\n*DYNAMIC, DIRECT\n1e-3, 0.1\n{more}*END STEP\n"
)
SHELL = {"kind": "S4", "nodes": "1,2,3,4", "section": "*SHELL SECTION, ELSET=P, MATERIAL=M\n1.,\n", "side": "SPOS"}
SOLID = {"kind": "C3D8", "nodes": "1,2,3,4,5,6,7,8", "section": "*SOLID SECTION, ELSET=P, MATERIAL=M\n", "side": "S2"}


def abaqus(tmp_path, how: dict[str, str], load: str, more: str = "") -> StaticLoads:
    (tmp_path / "a.inp").write_text(DECK.format(**how, load=load, more=more))
    static = read_deck_run(tmp_path / "a.inp")[1].static
    assert static is not None
    return static


@pytest.mark.parametrize(
    ("how", "load", "exact"),
    [
        (SHELL, "*DLOAD\nP, P, .5\n", (0.0, 0.0, 3.0)),
        (SHELL, "*DSLOAD\nTOP, P, .5\n", (0.0, 0.0, -3.0)),
        (SHELL, "*DLOAD\nP, P, .5\n*DLOAD\nP, P, .25\n", (0.0, 0.0, 1.5)),
        (SOLID, "*DLOAD\nP, P2, .5\n", (0.0, 0.0, -3.0)),
        (SOLID, "*DLOAD\n1, P3, .5\n", (0.0, 4.0, 0.0)),
        (SOLID, "*DSLOAD\nTOP, P, .5\n", (0.0, 0.0, -3.0)),
    ],
)
def test_resultants_of_abaqus_pressures(tmp_path, how, load, exact):
    assert total(abaqus(tmp_path, how, load)) == pytest.approx(exact, abs=1e-12)


def test_pressure_and_gravity_of_a_step_stand_beside_each_other(tmp_path):
    static = abaqus(tmp_path, SHELL, "*DLOAD\n, GRAV, 9810., 0, 0, -1\n*DLOAD\nP, P, .5\n")
    assert static.gravity == pytest.approx((0.0, 0.0, -9810.0))
    assert total(static) == pytest.approx((0.0, 0.0, 3.0))


@pytest.mark.parametrize(
    ("how", "load", "more", "told"),
    [
        (SOLID, "*DLOAD\nP, P, .5\n", "", r"\*DLOAD P on element 1 \(C3D8\), which is no shell"),
        (SHELL, "*DLOAD\nP, BZ, .5\n", "", r"\*DLOAD with BZ; expected GRAV, P, or P1 to P6"),
        (SHELL, "*DSLOAD\nTOPP, P, .5\n", "", "unknown surface 'TOPP'.*Did you mean 'TOP'"),
        (SHELL | {"side": ""}, "*DSLOAD\nTOP, P, .5\n", "", "whose shells have no side"),
        (SHELL, "*DLOAD\nP, P, .5\n", "*DLOAD, OP=NEW\n", r"\*DLOAD, OP=NEW takes the loads of the \*STATIC step away"),
        (SHELL, "*DLOAD\nP, P, .5\n", "*DLOAD, OP=NEW\n, GRAV, 9., 0., 0., 1.\n", r"\*DLOAD, OP=NEW takes"),
        (SHELL, "*DLOAD\nP, P, .5\n", "*DLOAD\nP, P, .5\n", r"\*DYNAMIC step with pressure"),
    ],
)
def test_abaqus_pressures_that_cannot_be_read_are_told(tmp_path, how, load, more, told):
    with pytest.raises(InputError, match=told):
        abaqus(tmp_path, how, load, more)
