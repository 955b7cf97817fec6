"""Small models written three times: as an Abaqus, a Nastran and an LS-DYNA deck; and how they are read and compared."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from creak.assembly.coupling import Driven
from creak.formats.decks import read_model
from creak.model.mesh import Model
from creak.studies.models.deck_modes import model_modes

E, NU, RHO = 210000.0, 0.3, 7.85e-9
Places = dict[int, tuple[float, float, float]]
Elements = dict[int, tuple[int, ...]]
STEEL = {
    "inp": f"*MATERIAL, NAME=STEEL\n*ELASTIC\n{E}, {NU}\n*DENSITY\n{RHO!r}\n",
    "bdf": f"MAT1,1,{E},,{NU},{RHO!r}\n",
    "k": f"*MAT_ELASTIC\n1,{RHO!r},{E},{NU}\n",
}


@dataclass(frozen=True)
class Twin:
    """The same model in three formats."""

    inp: str
    bdf: str
    k: str


def nodes(places: Places) -> Twin:
    rows = [(i, *xyz) for i, xyz in places.items()]
    return Twin(
        "*NODE\n" + "".join(_csv(r) for r in rows),
        "".join(f"GRID,{i},,{x!r},{y!r},{z!r}\n" for i, x, y, z in rows),
        "*NODE\n" + "".join(f"{i:8d}{x:16.9E}{y:16.9E}{z:16.9E}\n" for i, x, y, z in rows),
    )


def fixed_width(*values: object, width: int = 10) -> str:
    """One card of an LS-DYNA deck."""
    return "".join(f"{v if v is not None else '':>{width}}" for v in values) + "\n"


def plate(nx: int, ny: int, size: float, first: int = 1, z: float = 0.0, x: float = 0.0) -> tuple[Places, Elements]:
    """Nodes and quadrilaterals, a little distorted."""
    at = {(i, j): first + j * (nx + 1) + i for i in range(nx + 1) for j in range(ny + 1)}
    places = {n: (x + size * i + 0.1 * size * (j % 2) * (0 < i < nx), 0.8 * size * j, z) for (i, j), n in at.items()}
    cells = [(i, j) for j in range(ny) for i in range(nx)]
    return places, {
        first + k: (at[i, j], at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]) for k, (i, j) in enumerate(cells)
    }


def block(nx: int, ny: int, nz: int, size: float, first: int = 1) -> tuple[Places, Elements]:
    """Nodes and hexahedra."""
    at = {
        (i, j, k): first + (k * (ny + 1) + j) * (nx + 1) + i
        for i in range(nx + 1)
        for j in range(ny + 1)
        for k in range(nz + 1)
    }
    places = {n: (size * i, 0.9 * size * j, 0.7 * size * k + 0.05 * size * i * (k == 1)) for (i, j, k), n in at.items()}
    corners = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
    cells = [(i, j, k) for k in range(nz) for j in range(ny) for i in range(nx)]
    return places, {
        first + e: tuple(at[i + a, j + b, k + c] for a, b, c in corners) for e, (i, j, k) in enumerate(cells)
    }


def halves(quads: Elements) -> Elements:
    """Triangles of quadrilaterals."""
    return {10 * e + s: t for e, (a, b, c, d) in quads.items() for s, t in ((0, (a, b, c)), (1, (a, c, d)))}


def shells(elements: Elements, thickness: float, pid: int = 1, name: str = "PLATE") -> Twin:
    """Quadrilaterals or triangles of one part and one thickness; its Nastran property has the id of the part."""
    n = len(next(iter(elements.values())))
    rows = [(e, *row) for e, row in elements.items()]
    return Twin(
        f"*ELEMENT, TYPE=S{n}, ELSET={name}\n"
        + "".join(_csv(r) for r in rows)
        + f"*SHELL SECTION, ELSET={name}, MATERIAL=STEEL\n{thickness!r}\n",
        "".join(f"{'CQUAD4' if n == 4 else 'CTRIA3'},{e},{pid},{_plain(row)}\n" for e, *row in rows)
        + f"PSHELL,{pid},1,{thickness!r},1,,1\n",
        "*ELEMENT_SHELL\n"
        + "".join(fixed_width(e, pid, *row, *row[-1:] * (4 - n), width=8) for e, *row in rows)
        + part(pid, name, pid)
        + f"*SECTION_SHELL\n{fixed_width(pid, 16, 0.8333, 5)}{fixed_width(*[thickness] * 4)}",
    )


def part(pid: int, title: str, section: int, material: int = 1) -> str:
    return f"*PART\n{title}\n{fixed_width(pid, section, material)}"


def held(ids: Iterable[int], dofs: str = "123456") -> Twin:
    listed = list(ids)
    flags = [int(str(d) in dofs) for d in range(1, 7)]
    return Twin(
        "*BOUNDARY\n" + "".join(f"{i}, {d}, {d}\n" for i in listed for d in dofs),
        "".join(f"SPC1,1,{dofs},{i}\n" for i in listed),
        "*BOUNDARY_SPC_NODE\n" + "".join(fixed_width(i, 0, *flags) for i in listed),
    )


def only(inp: str = "", bdf: str = "", k: str = "") -> Twin:
    return Twin(inp, bdf, k)


def steel() -> Twin:
    return Twin(**STEEL)


def read_all(folder: Path, pieces: Sequence[Twin]) -> dict[str, Model]:
    """The three decks of pieces, read; mass consistent in each."""
    bulk = "".join(p.bdf for p in pieces)
    glued = "BCONTACT = 1\n" if "BCTABLE" in bulk else ""
    bodies = {
        "inp": "*HEADING\ntwin\n" + "".join(p.inp for p in pieces),
        "bdf": f"SOL 103\nCEND\nSPC = 1\n{glued}BEGIN BULK\n{bulk}ENDDATA\n",
        "k": "*KEYWORD\n*TITLE\ntwin\n$ a comment\n" + "".join(p.k for p in pieces) + "*END\n",
    }
    found = {}
    for ending, text in bodies.items():
        path = folder / f"twin.{ending}"
        path.write_text(text, encoding="utf-8")
        found[ending] = replace(read_model(path), mass_form="consistent")
    return found


def frequencies(model: Model, count: int = 10) -> np.ndarray:
    assert not [u for u in model.unread if u.changes_answer]
    return model_modes(model, Driven({}), count=count)[1].frequencies


def disagreement(folder: Path, pieces: Sequence[Twin], count: int = 10) -> float:
    """Largest relative difference between the frequencies of the LS-DYNA deck and those of the other two."""
    found = {ending: frequencies(model, count) for ending, model in read_all(folder, pieces).items()}
    assert found["k"].size >= count
    assert found["k"][0] > 0.0
    return max(float(np.abs(found[other] / found["k"] - 1.0).max()) for other in ("inp", "bdf"))


def clamped_assembly() -> str:
    """A deck in free format with one of nearly every keyword, on the corners of a cube."""
    return """*KEYWORD
*NODE
1,0.,0.,0.,7,7
2,1.,0.,0.
3,1.,1.,0.
4,0.,1.,0.
5,0.,0.,1.
6,1.,0.,1.
7,1.,1.,1.
8,0.,1.,1.
*ELEMENT_SHELL_THICKNESS
1,1,1,2,3,4
.1,.1,.1,.1
*ELEMENT_SOLID
9,2,1,2,3,4,5,6,7,8
*ELEMENT_BEAM
4,4,1,2,3
*ELEMENT_DISCRETE
5,3,1,2,4
*ELEMENT_MASS
6,7,1.e-3
*PART
plate
1,1,1
body
2,2,1
clip
3,3,3
rod
4,4,2
*SECTION_SHELL
1,2
0.1
*SECTION_SOLID
2,1
*SECTION_DISCRETE
3,0
0.
*SECTION_BEAM
4,1,,,0
.1,.1,.2,.2
*MAT_ELASTIC
1,7.8e-9,2.1e5,.3
*MAT_PIECEWISE_LINEAR_PLASTICITY_TITLE
steel
2,7.8e-9,2.1e5,.3,300.



*MAT_SPRING_ELASTIC
3,10.
*DEFINE_SD_ORIENTATION
4,0,0.,0.,1.
*DEFINE_COORDINATE_SYSTEM
7,0.,0.,0.,1.,1.,0.
0.,1.,0.
*SET_NODE_LIST
5
5,6
*SET_NODE_GENERATE
6
1,4
*SET_PART
8
1,2
*SET_SEGMENT
9
1,2,3,4
*BOUNDARY_SPC_SET
6,7,1,0,1
*CONSTRAINED_NODAL_RIGID_BODY
9,,5
*CONSTRAINED_SPOTWELD
7,8
*CONTACT_TIED_NODES_TO_SURFACE
5,9,4,0

,,-2.
*DEFINE_TRANSFORMATION
3
ROTATE,0.,0.,1.,0.,0.,0.,30.
*END
"""


def _csv(values: Iterable[object]) -> str:
    return ", ".join(repr(v) for v in values) + "\n"


def _plain(values: Iterable[object]) -> str:
    return ",".join(repr(v) for v in values)
