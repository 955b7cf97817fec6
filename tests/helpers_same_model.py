"""One small model written twice: as an Abaqus deck and as a Nastran deck.

Two plates (steel quadrilaterals and triangles; orthotropic quadrilaterals turned 30 degrees), stiffening beams that lie
beside the plate, a rod, springs, a mass with rotary inertia, a kinematic and a distributing coupling, and supports. Labels
have gaps and come in any order.
"""

from __future__ import annotations

import random
from dataclasses import dataclass

NX, NY = 4, 3
BEAM_HEIGHT = 4.0
AREA, I1, I2, J, K1, K2 = 8.0, 10.0, 3.0, 7.0, 0.8, 0.6
"""Of the beams: I1 bends in the plane of axis 1 and the tangent, K1 is the shear factor along axis 1."""
E_STEEL, NU_STEEL, RHO_STEEL = 210000.0, 0.3, 7.85e-9
ORTHOTROPIC = (9000.0, 3000.0, 0.28, 1500.0, 1100.0, 800.0)
"""E1, E2, nu12, G12, G13, G23"""
RHO_SHEET, ANGLE = 1.3e-9, 30.0


@dataclass(frozen=True)
class Mesh:
    """Labels and places of the nodes by name, and the elements by kind."""

    nodes: dict[str, tuple[int, tuple[float, float, float]]]
    quads: list[tuple[str, ...]]
    triangles: list[tuple[str, ...]]
    sheet: list[tuple[str, ...]]
    beams: list[tuple[str, ...]]

    def label(self, name: str) -> int:
        return self.nodes[name][0]


def mesh() -> Mesh:
    """Plate a at z = 0, sheet b at z = 30, points p and q; labels drawn at random."""
    places = {
        f"a{i}{j}": (10.0 * i + 1.5 * (j == 1), 8.0 * j, 0.3 * i * j) for i in range(NX + 1) for j in range(NY + 1)
    }
    places |= {f"b{i}{j}": (5.0 + 9.0 * i, 2.0 + 7.0 * j + i, 30.0) for i in range(3) for j in range(3)}
    places |= {"p": (-6.0, 12.0, 3.0), "q": (14.0, 10.0, 36.0)}
    labels = random.Random(5).sample(range(3, 4000), len(places))
    nodes = {name: (label, xyz) for (name, xyz), label in zip(places.items(), labels, strict=True)}
    cells = [(f"a{i}{j}", f"a{i + 1}{j}", f"a{i + 1}{j + 1}", f"a{i}{j + 1}") for i in range(NX) for j in range(NY)]
    quads, rest = cells[: 3 * NY], cells[3 * NY :]
    triangles = [t for a, b, c, d in rest for t in ((a, b, c), (a, c, d))]
    sheet = [(f"b{i}{j}", f"b{i + 1}{j}", f"b{i + 1}{j + 1}", f"b{i}{j + 1}") for i in range(2) for j in range(2)]
    return Mesh(nodes, quads, triangles, sheet, [(f"a{NX}{j}", f"a{NX}{j + 1}") for j in range(NY)])


def _numbered(start: int, step: int, rows: list[tuple[str, ...]], m: Mesh) -> list[list[int]]:
    """Elements with labels that fall, in shuffled order."""
    out = [[start - step * k, *(m.label(n) for n in row)] for k, row in enumerate(rows)]
    random.Random(len(rows)).shuffle(out)
    return out


def abaqus_deck(m: Mesh, *, held: bool = True) -> str:
    """The model as .inp; the beams' own nodes hang on those of the plate by *MPC BEAM."""
    names = list(m.nodes)
    random.Random(1).shuffle(names)
    lines = ["*HEADING", "same model", "*NODE", *(f"{m.label(n)}, {_csv(m.nodes[n][1])}" for n in names)]
    own = {name: 10000 + k for k, name in enumerate(dict.fromkeys(n for row in m.beams for n in row))}
    for name, label in own.items():
        x, y, z = m.nodes[name][1]
        lines.append(f"{label}, {_csv((x, y, z + BEAM_HEIGHT))}")
    for kind, name, start, rows in (
        ("S4", "PLATE", 900, m.quads),
        ("S3", "PLATE", 600, m.triangles),
        ("S4", "SHEET", 300, m.sheet),
    ):
        lines += [f"*ELEMENT, TYPE={kind}, ELSET={name}", *(_csv(r) for r in _numbered(start, 7, rows, m))]
    lines += ["*ELEMENT, TYPE=B31, ELSET=BEAM"]
    lines += [f"{101 + 2 * k}, {own[a]}, {own[b]}" for k, (a, b) in enumerate(m.beams)]
    lines += ["*ELEMENT, TYPE=T3D2, ELSET=ROD", f"77, {m.label('a00')}, {m.label('b00')}"]
    lines += ["*ELEMENT, TYPE=MASS, ELSET=BALLAST", f"71, {m.label('p')}"]
    lines += ["*ELEMENT, TYPE=ROTARYI, ELSET=TURN", f"72, {m.label('p')}"]
    lines += ["*ELEMENT, TYPE=SPRING2, ELSET=CLIP", f"61, {m.label('a22')}, {m.label('b11')}"]
    lines += ["*ELEMENT, TYPE=SPRING1, ELSET=GROUND", f"62, {m.label('b22')}"]
    lines += ["*ELEMENT, TYPE=MASS, ELSET=LAMP", f"73, {m.label('q')}"]
    lines += [
        "*SHELL SECTION, ELSET=PLATE, MATERIAL=STEEL",
        "0.8",
        "*ORIENTATION, NAME=GRAIN",
        "1., 0., 0., 0., 1., 0.",
        f"3, {ANGLE}",
        "*SHELL SECTION, ELSET=SHEET, MATERIAL=SHEET, ORIENTATION=GRAIN",
        "1.5",
        "*SOLID SECTION, ELSET=ROD, MATERIAL=STEEL",
        "2.5",
    ]
    G = E_STEEL / (2.0 * (1.0 + NU_STEEL))
    lines += [
        f"*BEAM GENERAL SECTION, ELSET=BEAM, DENSITY={RHO_STEEL!r}",
        _csv((AREA, I2, 0.0, I1, J)),
        "1., 0., 0.",
        _csv((E_STEEL, G)),
        "*TRANSVERSE SHEAR STIFFNESS",
        _csv((K2 * AREA * G, K1 * AREA * G)),
    ]
    lines += [
        *("*MASS, ELSET=BALLAST", "2.e-6", "*ROTARY INERTIA, ELSET=TURN"),
        *("4.e-5, 5.e-5, 6.e-5, 1.e-6, 2.e-6, 3.e-6", "*MASS, ELSET=LAMP", "5.e-7", "*SPRING, ELSET=CLIP"),
        *("3, 2", "45.", "*SPRING, ELSET=GROUND", "1", "80."),
    ]
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", _csv((E_STEEL, NU_STEEL)), "*DENSITY", repr(RHO_STEEL)]
    lines += ["*MATERIAL, NAME=SHEET", "*ELASTIC, TYPE=LAMINA", _csv(ORTHOTROPIC), "*DENSITY", repr(RHO_SHEET)]
    lines += ["*SURFACE, NAME=HUB, TYPE=NODE", *(str(m.label(n)) for n in HUB)]
    lines += ["*SURFACE, NAME=SEAT, TYPE=NODE", *(str(m.label(n)) for n in SEAT)]
    lines += [f"*COUPLING, CONSTRAINT NAME=C1, REF NODE={m.label('p')}, SURFACE=HUB", "*KINEMATIC"]
    lines += [f"*COUPLING, CONSTRAINT NAME=C2, REF NODE={m.label('q')}, SURFACE=SEAT", "*DISTRIBUTING"]
    lines += ["*MPC", *(f"BEAM, {label}, {m.label(name)}" for name, label in own.items())]
    if held:
        lines += ["*BOUNDARY", *(f"{m.label(n)}, 1, 6" for n in HELD), f"{m.label('a40')}, 2, 3"]
    return "\n".join(lines) + "\n"


HUB, SEAT, HELD = ("a01", "a02"), ("b01", "b02", "b12", "b21"), ("a00", "a20", "b20")


def nastran_deck(m: Mesh, *, held: bool = True, parameters: str = "PARAM,COUPMASS,1") -> str:
    """The model as .bdf; CBEAM with offsets, PCOMP with one ply of MAT8."""
    lines = ["SOL 103", "CEND", *(["SPC = 4"] if held else []), "BEGIN BULK", parameters]
    for kind, pid, start, rows, more in (
        ("CTRIA3", 1, 600, m.triangles, ""),
        ("CQUAD4", 2, 300, m.sheet, ",50"),
        ("CQUAD4", 1, 900, m.quads, ""),
    ):
        lines += [f"{kind},{r[0]},{pid},{_plain(r[1:])}{more}" for r in _numbered(start, 7, rows, m)]
    names = list(m.nodes)
    random.Random(2).shuffle(names)
    lines += [f"GRID,{m.label(n)},,{_plain(m.nodes[n][1])}" for n in names]
    c, s = 0.8660254037844387, 0.5
    lines += ["CORD2R,50,,0.,0.,0.,0.,0.,1.", f",{c!r},{s!r},0."]
    lines += ["PSHELL,1,1,.8,1,,1", "PCOMP,2,,,,,,,", ",8,1.5,0."]
    lines += [f"MAT1,1,{E_STEEL!r},,{NU_STEEL!r},{RHO_STEEL!r}"]
    E1, E2, nu12, G12, G13, G23 = ORTHOTROPIC
    lines += [f"MAT8,8,{_plain((E1, E2, nu12, G12, G13, G23))},{RHO_SHEET!r}"]
    for k, (a, b) in enumerate(m.beams):
        lines += [
            f"CBEAM,{101 + 2 * k},3,{m.label(a)},{m.label(b)},1.,0.,0.",
            f",,,0.,0.,{BEAM_HEIGHT},0.,0.,{BEAM_HEIGHT}",
        ]
    lines += [f"PBEAM,3,1,{_plain((AREA, I1, I2))},,{J}", ",,,,,,,,", ",YES,1.", ",,,,,,,,", f",{K1},{K2}"]
    lines += [f"CROD,77,5,{m.label('a00')},{m.label('b00')}", "PROD,5,1,2.5,0."]
    lines += [f"CONM2,71,{m.label('p')},,2.-6", ",4.-5,-1.-6,5.-5,-2.-6,-3.-6,6.-5"]
    lines += [f"CONM2,73,{m.label('q')},,5.-7"]
    lines += [f"CELAS2,61,45.,{m.label('a22')},3,{m.label('b11')},2", f"CELAS2,62,80.,{m.label('b22')},1"]
    lines += [f"RBE2,81,{m.label('p')},123456,{_plain([m.label(n) for n in HUB])}"]
    lines += [
        f"RBE3,82,,{m.label('q')},123456,1.,123,{_plain([m.label(n) for n in SEAT[:2]])}",
        f",{_plain([m.label(n) for n in SEAT[2:]])}",
    ]
    if held:
        lines += [f"SPC1,4,123456,{_plain([m.label(n) for n in HELD])}", f"SPC1,4,23,{m.label('a40')}"]
    return "\n".join(lines) + "\nENDDATA\n"


def _csv(values: object) -> str:
    return ", ".join(repr(v) for v in values)  # type: ignore[attr-defined]


def _plain(values: object) -> str:
    return ",".join(repr(v) for v in values)  # type: ignore[attr-defined]
