"""Ties to faces with middle nodes: motion of second degree is followed exactly, and so is rigid motion of bowed ones."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from creak.formats.abaqus.reader import read_deck
from creak.model.constraints import Tie
from creak.model.mesh import Model
from creak.model.solid_faces import FACES, face_numbers
from helpers_nastran import read
from helpers_solids import solid_mesh

SIZE = (3.0, 2.0, 1.0)
TYPES = {"hex20": "C3D20", "tet10": "C3D10", "wedge15": "C3D15"}
CARDS = {"hex20": "CHEXA", "tet10": "CTETRA", "wedge15": "CPENTA"}
MIDDLE_ORDER = {"hex20": [*range(12), *range(16, 20), *range(12, 16)], "wedge15": [*range(9), 12, 13, 14, 9, 10, 11]}


def two_blocks(kind: str, bow: float) -> tuple[np.ndarray, list[np.ndarray]]:
    """Nodes and elements of a fine block on a coarse one, whose upper middle nodes are off by `bow`."""
    (x, low), (y, high) = solid_mesh((2, 1, 1), SIZE, kind), solid_mesh((3, 4, 1), SIZE, kind)
    middles = low[:, {"hex20": 8, "tet10": 4, "wedge15": 6}[kind] :]
    upper = np.intersect1d(middles, np.flatnonzero(np.isclose(x[:, 2], SIZE[2])))
    x[upper] += bow * np.random.default_rng(5).uniform(-1.0, 1.0, (upper.size, 3))
    return np.concatenate([x, y + [0.0, 0.0, SIZE[2]]]), [low, high + len(x)]


def faces_at(kind: str, coords: np.ndarray, elements: np.ndarray, z: float) -> list[tuple[int, int]]:
    facets, number = np.array(FACES[kind]), face_numbers(kind)
    return [
        (k, int(face))
        for k, nodes in enumerate(elements)
        for face in np.unique(number)
        if np.isclose(coords[nodes[facets[number == face][:, 0]]][:, 2], z, atol=0.1).all()
        and np.isclose(coords[nodes[facets[number == face]]][..., 2], z, atol=0.1).all()
    ]


def abaqus(
    folder: Path, kind: str, bow: float, tie: str = "*TIE, NAME=T, POSITION TOLERANCE=0.2", gap: float = 0.0
) -> Model:
    coords, blocks = two_blocks(kind, bow)
    coords[blocks[1].min() :, 2] += gap
    lines = ["*NODE", *(f"{k + 1}, {x:.12g}, {y:.12g}, {z:.12g}" for k, (x, y, z) in enumerate(coords))]
    for name, start, elements in zip(("LOW", "TOP"), (1, 1001), blocks, strict=True):
        lines.append(f"*ELEMENT, TYPE={TYPES[kind]}, ELSET={name}")
        for k, nodes in enumerate(elements):
            fields = [str(k + start), *(str(n + 1) for n in nodes)]
            lines.append(", ".join(fields[:16]) + (",\n" + ", ".join(fields[16:]) if fields[16:] else ""))
        lines += [f"*SOLID SECTION, ELSET={name}, MATERIAL=M", f"*SURFACE, NAME=S_{name}"]
        lines += [f"{k + start}, S{face}" for k, face in faces_at(kind, coords, elements, SIZE[2])]
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", "2000., 0.3", "*DENSITY", "1e-9"]
    lines += [tie, "S_TOP, S_LOW"]
    (folder / "a.inp").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return read_deck(folder / "a.inp")


def nastran(folder: Path, kind: str, bow: float) -> Model:
    coords, blocks = two_blocks(kind, bow)
    lines = [f"GRID,{k + 1},,{x:.12g},{y:.12g},{z:.12g}" for k, (x, y, z) in enumerate(coords)]
    for start, elements in zip((1, 1001), blocks, strict=True):
        for k, nodes in enumerate(elements):
            order = MIDDLE_ORDER.get(kind, range(len(nodes)))
            fields = [str(k + start), "1", *(str(n + 1) for n in nodes[order])]
            lines.append(CARDS[kind] + "\n".join("," + ",".join(fields[i : i + 8]) for i in range(0, len(fields), 8)))
    lines += [
        f"BSURF,{i},{start},THRU,{start + len(b) - 1}" for i, start, b in zip((1, 2), (1, 1001), blocks, strict=True)
    ]
    lines += ["BGSET,5,1,2,0.2", "PSOLID,1,1", "MAT1,1,2000.,,.3,1.-9"]
    return read(folder, "\n".join(lines), "BGSET = 5\n")


Motion = Callable[[np.ndarray], np.ndarray]


def second_degree(x: np.ndarray) -> np.ndarray:
    a, b = x[:, 0], x[:, 1]
    return np.column_stack([1 + a - 2 * b + a * a, a * b - 0.5 * b * b, 3 * a * a + b * b - a * b + b])


def turned(x: np.ndarray) -> np.ndarray:
    return np.cross([0.3, -0.7, 0.5], x)


@pytest.mark.parametrize("kind", list(TYPES))
@pytest.mark.parametrize("deck", [abaqus, nastran])
@pytest.mark.parametrize(("bow", "motion"), [(0.0, second_degree), (0.04, turned)])
def test_tied_nodes_follow(tmp_path, kind, deck, bow, motion: Motion):
    model = deck(tmp_path, kind, bow)
    x = model.nodes.coords
    u = np.pad(motion(x), ((0, 0), (0, 3)))
    equations = [e for c in model.constraints for e in (c.equations(x) if hasattr(c, "equations") else [c])]
    assert len(equations) >= 3 * 30
    left = [e.coefficients @ u[e.nodes_idx, e.dofs - 1] for e in equations]
    assert np.abs(left).max() < 1e-9 * np.abs(u).max()


@pytest.mark.parametrize("kind", list(TYPES))
def test_the_default_tolerance_is_of_whole_faces(tmp_path, kind):
    """5 % of edges between 1.5 and 2.5 long, which middle nodes do not halve: a gap of .07 is closed."""
    closed, at = (abaqus(tmp_path, kind, 0.0, "*TIE, NAME=T", gap).constraints for gap in (0.07, 0.0))
    tied, met = ({c.node_idx if isinstance(c, Tie) else int(c.nodes_idx[0]) for c in found} for found in (closed, at))
    assert tied == met != set()
