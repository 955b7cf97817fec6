"""Pressure on shells and faces with middle nodes: consistent forces, and columns that shorten exactly."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from creak.formats.abaqus.reader import read_deck, read_deck_run
from creak.model.faces import FACES, face_numbers
from creak.model.mesh import Model
from creak.model.steps import StaticLoads
from helpers_nastran import motion, read
from helpers_solids import solid_mesh

E, SIZE, P = 2000.0, (3.0, 2.0, 4.0), 1.5
CARDS = {"hex20": "CHEXA", "tet10": "CTETRA", "wedge15": "CPENTA"}
TYPES = {"hex20": "C3D20", "tet10": "C3D10", "wedge15": "C3D15"}
MIDDLE_ORDER = {"hex20": [*range(12), *range(16, 20), *range(12, 16)], "wedge15": [*range(9), 12, 13, 14, 9, 10, 11]}
"""Nastran has the middle nodes between the faces before those of the second face."""
CORNERS = {"hex20": 8, "tet10": 4, "wedge15": 6}


def forces_of(model: Model, loads: StaticLoads) -> dict[tuple[int, int], float]:
    """Force at (label, dof)."""
    if loads.flaw is not None:
        raise loads.flaw
    out: dict[tuple[int, int], float] = {}
    for f in loads.forces:
        for node in f.nodes_idx.tolist():
            key = (int(model.nodes.ids[node]), f.dof)
            out[key] = out.get(key, 0.0) + f.value
    return out


def top_faces(kind: str, coords: np.ndarray, elements: np.ndarray) -> list[tuple[int, int, list[int]]]:
    """Element, number of the face and its corners, which look outward, at the upper end."""
    facets, number, found = np.array(FACES[kind]), face_numbers(kind), []
    for k, nodes in enumerate(elements):
        for face in np.unique(number):
            mine = nodes[facets[number == face]]
            if np.isclose(coords[mine][..., 2], SIZE[2]).all():
                around = [c for c in dict.fromkeys(mine.ravel().tolist()) if c in nodes[: CORNERS[kind]]]
                found.append((k, int(face), around))
    return found


def nastran(folder: Path, kind: str, card: str) -> tuple[Model, StaticLoads]:
    coords, elements = solid_mesh((2, 1, 2), SIZE, kind)
    lines = [f"GRID,{k + 1},,{x:.12g},{y:.12g},{z:.12g}" for k, (x, y, z) in enumerate(coords)]
    for k, nodes in enumerate(elements):
        fields = [str(k + 1), "1", *(str(n + 1) for n in nodes[MIDDLE_ORDER.get(kind, range(len(nodes)))])]
        lines.append(CARDS[kind] + "\n".join("," + ",".join(fields[i : i + 8]) for i in range(0, len(fields), 8)))
    for k, _, c in top_faces(kind, coords, elements):
        apex = next(n for n in elements[k, : CORNERS[kind]] if n not in c)
        ends = [c[0], apex] if kind == "tet10" else [c[0], c[2]] if len(c) == 4 else [c[0]]
        if card == "PLOAD4":
            lines.append(f"PLOAD4,7,{k + 1},{P},,,,{','.join(str(n + 1) for n in ends)}")
        else:
            lines.append(f"PLOAD,7,{P},{','.join(str(n + 1) for n in c[::-1])}")
    lines += [f"SPC1,1,123,{n + 1}" for n in np.flatnonzero(coords[:, 2] == 0.0)]
    model = read(folder, "\n".join([*lines, "PSOLID,1,1", f"MAT1,1,{E},,0.,1.-9"]))
    return model, model.static_loads["7"]


def abaqus(folder: Path, kind: str, load: str) -> tuple[Model, StaticLoads]:
    coords, elements = solid_mesh((2, 1, 2), SIZE, kind)
    lines = ["*NODE", *(f"{k + 1}, {x:.12g}, {y:.12g}, {z:.12g}" for k, (x, y, z) in enumerate(coords))]
    lines.append(f"*ELEMENT, TYPE={TYPES[kind]}, ELSET=B")
    for k, nodes in enumerate(elements):
        fields = [str(k + 1), *(str(n + 1) for n in nodes)]
        lines.append(", ".join(fields[:16]) + (",\n" + ", ".join(fields[16:]) if fields[16:] else ""))
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", f"{E}, 0.", "*DENSITY", "1e-9", "*SOLID SECTION, ELSET=B, MATERIAL=M"]
    top = top_faces(kind, coords, elements)
    lines += ["*SURFACE, NAME=TOP", *(f"{k + 1}, S{face}" for k, face, _ in top), "*BOUNDARY"]
    lines += [f"{n + 1}, 1, 3" for n in np.flatnonzero(coords[:, 2] == 0.0)]
    lines += ["*STEP", "*STATIC", "1., 1.", f"*{load}"]
    lines += [f"TOP, P, {P}"] if load == "DSLOAD" else [f"{k + 1}, P{face}, {P}" for k, face, _ in top]
    lines += ["*END STEP", "*STEP", "*DYNAMIC, DIRECT", "1e-3, 0.1", "*END STEP"]
    (folder / "a.inp").write_text("\n".join(lines) + "\n", encoding="utf-8")
    static = read_deck_run(folder / "a.inp")[1].static
    assert static is not None
    return read_deck(folder / "a.inp"), static


@pytest.mark.parametrize("kind", list(CARDS))
@pytest.mark.parametrize(
    ("deck", "load"), [(nastran, "PLOAD4"), (nastran, "PLOAD"), (abaqus, "DLOAD"), (abaqus, "DSLOAD")]
)
def test_a_column_shortens_evenly(tmp_path, kind, deck, load):
    """u_z = -p z / E, nu = 0, at every node."""
    model, loads = deck(tmp_path, kind, load)
    u, z = motion(model, forces_of(model, loads)), model.nodes.coords[:, 2]
    exact = np.zeros((len(z), 3))
    exact[:, 2] = -P * z / E
    assert u[:, :3] == pytest.approx(exact, abs=1e-9 * P * SIZE[2] / E)


SHELLS = "PSHELL,1,1,1.,1,,1\nMAT1,1,7.+4,,0.,2.7-9"
QUAD = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 3.0), (0.0, 3.0), (1.0, 0.0), (2.0, 1.5), (1.0, 3.0), (0.0, 1.5)])
TRIANGLE = np.array([(0.0, 0.0), (2.0, 0.0), (0.0, 3.0), (1.0, 0.0), (1.0, 1.5), (0.0, 1.5)])


def shell(folder: Path, x: np.ndarray, load: str) -> dict[tuple[int, int], float]:
    lines = [f"GRID,{k + 1},,{','.join(f'{c:.12g}' for c in row)}" for k, row in enumerate(x)]
    card = "CQUAD8,1,1,1,2,3,4,5,6,+\n+,7,8" if len(x) == 8 else "CTRIA6,1,1,1,2,3,4,5,6"
    model = read(folder, "\n".join([*lines, card, SHELLS, load]))
    return forces_of(model, model.static_loads["7"])


@pytest.mark.parametrize("load", ["PLOAD2,7,.5,1", "PLOAD4,7,1,.5", "PLOAD,7,.5,{}", "PLOAD,7,-.5,{back}"])
@pytest.mark.parametrize(("x", "corner", "middle"), [(QUAD, -1 / 12, 1 / 3), (TRIANGLE, 0.0, 1 / 3)])
def test_consistent_forces_of_shells_with_middle_nodes(tmp_path, x, corner, middle, load):
    """Cook, Malkus, Plesha and Witt, Concepts and Applications of Finite Element Analysis, section 3.11."""
    n, force = len(x) // 2, 0.5 * 6.0 * (1.0 if len(x) == 8 else 0.5)
    around = [str(k) for k in range(1, n + 1)]
    load = load.format(",".join([*around[1:], around[0]]), back=",".join(around[::-1]))
    found = shell(tmp_path, np.column_stack([x, np.zeros(2 * n)]), load)
    values = [found.get((k, 3), 0.0) for k in range(1, 2 * n + 1)]
    assert values == pytest.approx([force * corner] * n + [force * middle] * n, abs=1e-12 * force)


def test_pressure_that_varies_over_a_curved_shell(tmp_path):
    """Against int N p (x_r cross x_s) dr ds with the polynomials of the shape functions, 12 x 12 points."""
    rng = np.random.default_rng(3)
    x = np.column_stack([QUAD, np.zeros(8)]) + 0.15 * rng.standard_normal((8, 3)).round(6)
    given = np.array([1.0, -2.0, 3.5, 0.25])
    found = shell(tmp_path, x, f"PLOAD4,7,1,{','.join(map(str, given))}")
    at = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (0, -1), (1, 0), (0, 1), (-1, 0)], dtype=float)

    def terms(r, s):
        zero, one = np.zeros_like(r), np.ones_like(r)
        value = np.array([one, r, s, r * r, r * s, s * s, r * r * s, r * s * s])
        by_r = np.array([zero, one, zero, 2 * r, s, zero, 2 * r * s, s * s])
        by_s = np.array([zero, zero, one, zero, r, 2 * s, r * r, 2 * r * s])
        return value, by_r, by_s

    coefficients = np.linalg.inv(terms(at[:, 0], at[:, 1])[0].T).T
    points, weights = np.polynomial.legendre.leggauss(12)
    exact = np.zeros((8, 3))
    for r, of_r in zip(points, weights, strict=True):
        for s, of_s in zip(points, weights, strict=True):
            N, by_r, by_s = (coefficients @ t for t in terms(np.array(r), np.array(s)))
            p = 0.25 * ((1 + r * at[:4, 0]) * (1 + s * at[:4, 1])) @ given
            exact += of_r * of_s * p * np.outer(N, np.cross(by_r @ x, by_s @ x))
    forces = np.array([[found.get((k, dof), 0.0) for dof in (1, 2, 3)] for k in range(1, 9)])
    assert forces == pytest.approx(exact, abs=1e-10 * np.abs(exact).max())
