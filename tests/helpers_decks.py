"""Small decks and studies for tests of the whole way."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

STEEL = "*MATERIAL, NAME=STEEL\n*ELASTIC\n210000., 0.3\n*DENSITY\n7.85e-9,\n*DAMPING, ALPHA=5.0, BETA=2.0e-6\n"


Vector = tuple[float, float, float]


def patch(
    first: int,
    elset: str,
    corner: Vector,
    u: Vector,
    v: Vector,
    cells: tuple[int, int] = (4, 4),
    elements: int | None = None,
    nodes: str = "*NODE",
    digits: int = 6,
) -> str:
    """Quads that span u and v from a corner on, nodes numbered from `first` on, elements from `elements` or there too."""
    (nu, nv), begin = cells, first if elements is None else elements
    lines = [nodes]
    for j in range(nv + 1):
        for i in range(nu + 1):
            x = (f"{corner[k] + u[k] * i / nu + v[k] * j / nv:.{digits}f}" for k in range(3))
            lines.append(f"{first + j * (nu + 1) + i}, {', '.join(x)}")
    lines.append(f"*ELEMENT, TYPE=S4, ELSET={elset}")
    for j in range(nv):
        for i in range(nu):
            a = first + j * (nu + 1) + i
            lines.append(f"{begin + j * nu + i}, {a}, {a + 1}, {a + nu + 2}, {a + nu + 1}")
    return "\n".join(lines) + "\n"


def strip(first_node: int, first_element: int, elset: str, z: float, n: int = 12, length: float = 120.0) -> str:
    """A clamped strip, n x 2 quads of 10 mm width, along x at height z; node set ROOT_<elset>."""
    sides = (length, 0.0, 0.0), (0.0, 20.0, 0.0)
    quads = patch(first_node, elset, (0.0, 0.0, z), *sides, (n, 2), first_element)
    roots = ", ".join(str(first_node + j * (n + 1)) for j in range(3))
    tips = ", ".join(str(first_node + j * (n + 1) + n) for j in range(3))
    return f"{quads}*NSET, NSET=ROOT_{elset}\n{roots}\n*NSET, NSET=TIP_{elset}\n{tips}\n"


def two_strips(gap: float = 0.5) -> str:
    """An upper strip (1 mm, on a moving root) above a lower, longer-rooted one (1.5 mm), `gap` between them."""
    middle = gap + 0.5 * (1.0 + 1.5)
    return (
        "*HEADING\ntwo strips\n"
        + strip(1, 1, "UPPER", middle)
        + strip(1001, 1001, "LOWER", 0.0)
        + STEEL
        + "*SHELL SECTION, ELSET=UPPER, MATERIAL=STEEL\n1.0,\n*SHELL SECTION, ELSET=LOWER, MATERIAL=STEEL\n1.5,\n"
        + "*SURFACE, NAME=UNDER\nUPPER, SNEG\n*SURFACE, NAME=OVER\nLOWER, SPOS\n"
        + "*NSET, NSET=PAIRS, UNSORTED\n1039, 39, 1013, 13\n"
        + "*BOUNDARY\nROOT_LOWER, 1, 6\nROOT_UPPER, 1, 2\nROOT_UPPER, 4, 6\n"
    )


STUDY = """title = "Two strips"

[model]
deck = "strips.inp"

[contact.tip]
secondary = "UNDER"
main = "OVER"
method = "surface-to-surface"

[excitation.root]
node_set = "ROOT_UPPER"
dof = "z"
kind = "displacement"
signal = { type = "multisine", f_min = 5, f_max = 60, amplitude = 0.05, period = 0.2, seed = 3 }

[reduction]
f_max = 3000

[time]
step = 5e-4
periods = 2

[verification]
pairs = "PAIRS"
mac_f_max = 500
"""


def write_study(folder: Path, study: str, files: Mapping[str, str]) -> Path:
    """Write study.toml and the files that it reads, by their names; returns the study's path."""
    for name, text in {**files, "study.toml": study}.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder / "study.toml"


def write_strips(folder: Path, deck: str | None = None, study: str = STUDY) -> Path:
    """Write strips.inp and study.toml; returns the study's path."""
    return write_study(folder, study, {"strips.inp": two_strips() if deck is None else deck})


STOP = """*NODE
1, 0., 0., 0.
*ELEMENT, TYPE=MASS, ELSET=M
1, 1
*MASS, ELSET=M
100.
*ELEMENT, TYPE=SPRING1, ELSET=K
2, 1
*SPRING, ELSET=K
1
10000.
*NSET, NSET=TIP
1
*INITIAL CONDITIONS, TYPE=VELOCITY
TIP, 1, 1.0
"""
"""A mass of 100 on a spring of 1e4, moving at 1 along x."""


def stop_study(step: float, end: float, method: str = "none") -> str:
    """It meets a stop of stiffness 1e6 at once, and goes through forced steps without numerical damping."""
    return f"""[model]
deck = "strips.inp"
units = "m-kg-s"
[[connector]]
type = "play"
nodes = "TIP"
dof = "x"
upper = 0.0
stiffness = 1e6
[reduction]
method = "{method}"
[time]
step = {step}
end = {end}
alpha = 0.0
"""
