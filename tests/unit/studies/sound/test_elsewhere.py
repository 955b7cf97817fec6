"""A knocking cube sounds as it does whatever else is in the model: a plate far away, its mesh, more modes."""

from __future__ import annotations

import numpy as np
import pytest

import creak
from creak.studies.sound.heard import Sound
from helpers_decks import STEEL, write_study
from helpers_solids import solid_mesh

RECORDED = {"section": "sound"}

SIDE = 40.0
STUDY = """title = "Cube"
[model]
deck = "cube.inp"
[contact.knock]
secondary = "UNDER"
main = "OVER"
method = "surface-to-surface"
stiffness = 20
[excitation.root]
node_set = "NSTOP"
dof = "z"
kind = "displacement"
signal = { type = "multisine", f_min = 5, f_max = 60, amplitude = 0.15, period = 0.2, seed = 3 }
[reduction]
f_max = 20000
[time]
end = 0.1
[reference]
run = false
[damping]
modal = 0.02
[listener.ear]
position = [20, 20, 700]
"""


def block_lines(name: str, first: int, size: tuple[float, float, float], n: tuple[int, int, int], z: float):
    coords, hexes = solid_mesh(n, size)
    coords = coords + np.array([0.0, 0.0, z])
    lines = ["*NODE", *(f"{first + i}, {x:.9g}, {y:.9g}, {z:.9g}" for i, (x, y, z) in enumerate(coords))]
    lines += [f"*ELEMENT, TYPE=C3D8, ELSET={name}"]
    lines += [f"{first + i}, " + ", ".join(str(first + k) for k in h) for i, h in enumerate(hexes.tolist())]
    lines += [f"*NSET, NSET=N{name}, GENERATE", f"{first}, {first + len(coords) - 1}, 1"]
    return [*lines, f"*SOLID SECTION, ELSET={name}, MATERIAL=STEEL", ""], coords


def plate_lines(first: int, m: int, side: float) -> list[str]:
    """m x m shells of 1 mm, 3 m away, held along an edge."""
    at, row = np.linspace(0.0, side, m + 1), np.arange((m + 1) ** 2).reshape(m + 1, m + 1) + first
    lines = ["*NODE"]
    lines += [f"{row[i, j]}, {3000.0 + at[i]:.9g}, {at[j]:.9g}, 0." for i in range(m + 1) for j in range(m + 1)]
    lines += ["*ELEMENT, TYPE=S4, ELSET=PLATE"]
    for i in range(m):
        lines += [f"{row[i, j]}, {row[i, j]}, {row[i + 1, j]}, {row[i + 1, j + 1]}, {row[i, j + 1]}" for j in range(m)]
    return [*lines, "*NSET, NSET=EDGE", *map(str, row[0]), "*SHELL SECTION, ELSET=PLATE, MATERIAL=STEEL", "1.0,"]


def cube_deck(plate: int | None) -> str:
    """A cube on springs above a driven block; a plate of so many elements along its side."""
    lines, coords = block_lines("CUBE", 1, (SIDE, SIDE, SIDE), (2, 2, 2), 0.5)
    lines += block_lines("STOP", 1001, (SIDE, SIDE, 8.0), (1, 1, 1), -8.0)[0]
    lines += [] if plate is None else plate_lines(2001, plate, 400.0)
    lines += [STEEL.split("*DAMPING")[0].strip()]
    corners = np.flatnonzero(np.isin(coords - [0.0, 0.0, 0.5], (0.0, SIDE)).all(axis=1)) + 1
    for dof in (1, 2, 3):
        lines += [
            f"*ELEMENT, TYPE=SPRING1, ELSET=K{dof}",
            *(f"{30_000 + 100 * dof + c}, {c}" for c in corners.tolist()),
        ]
        lines += [f"*SPRING, ELSET=K{dof}", f"{dof}", "50."]
    lines += ["*SURFACE, NAME=UNDER, TYPE=ELEMENT", "CUBE,", "*SURFACE, NAME=OVER, TYPE=ELEMENT", "STOP,"]
    lines += ["*BOUNDARY", "NSTOP, 1, 2", *([] if plate is None else ["EDGE, 1, 6"])]
    return "\n".join(lines) + "\n"


@pytest.fixture(scope="module")
def knock(tmp_path_factory):
    def heard(plate: int | None = None, f_max: float = 20_000.0) -> Sound:
        folder = tmp_path_factory.mktemp("cube")
        study_path = write_study(folder, STUDY.replace("20000", f"{f_max:g}"), {"cube.inp": cube_deck(plate)})
        result = creak.run(creak.read_study(study_path), converge=False, record=False)
        assert isinstance(result.sound, Sound), result.sound
        return result.sound

    return heard


@pytest.mark.slow
def test_a_cube_sounds_alike_whatever_is_elsewhere(knock, measured):
    """.1 dB: the run itself is the same to 1e-3 dB."""
    alone = knock()
    level = alone.heard[0][-1].level
    assert level > 50.0
    assert "CUBE" in alone.compact[0]
    for name, other in (("coarse", knock(4)), ("fine", knock(10)), ("f_max", knock(f_max=30_000.0))):
        assert other.band.mesh == alone.band.mesh
        measured(
            f"level of a knocking cube, {name} elsewhere: change",
            abs(other.heard[0][-1].level - level),
            at_most=0.1,
            unit="dB(A)",
            source="the cube alone",
        )
