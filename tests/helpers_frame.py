"""A bolted aluminium frame and its impact test: an inverted U of three plates, free in space.

Facts and figures of a published measurement: repository permas4edu/permas4edu, ema/examples/007 (data of SVIBS, mode
estimates by RFP-Z). The deck is made of its dimensions.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

HEIGHT, DEPTH, WIDTH, THICKNESS = 300.0, 150.0, 120.0, 10.0
"""mm; the height is the outer one, the width that between the middle surfaces of the legs."""
ALONG, UP, ACROSS = 10, 20, 8
"""Elements of a plate along the depth, of a leg along its height, of the top along the width."""
SENSORS = {
    "6": (0, 0, -300),
    "3": (0, -150, -300),
    "5": (0, 0, -150),
    "2": (0, -150, -150),
    "12": (120, 0, -300),
    "9": (120, -150, -300),
    "11": (120, 0, -150),
    "8": (120, -150, -150),
}
"""Points, mm; all measure along x."""
MEASURED = """\
62.154 1.919 3.002 2.947 1.250 1.287 -2.947 -3.011 -1.238 -1.236
167.017 .439 -3.322 3.475 -3.045 3.091 -3.388 3.221 -3.046 2.919
223.505 .968 -2.325 -2.689 .636 .436 -2.495 -2.237 .389 .673
352.621 .412 -8.815 8.210 -5.329 5.647 8.164 -9.033 5.684 -5.326
465.512 .304 4.975 3.761 -3.323 -3.763 -4.085 -5.195 4.003 3.555
506.172 .488 4.301 -5.114 1.927 -1.335 4.888 -4.301 1.213 -1.809
631.239 .615 2.438 2.605 -2.188 -2.165 2.375 2.146 -2.003 -1.978
1137.46 .314 7.735 -7.425 -5.740 5.083 -7.885 8.521 5.942 -6.275
1224.71 .377 7.166 -6.832 -5.734 5.166 5.925 -6.457 -4.940 5.122
1397.63 .285 6.091 6.322 -.937 -2.350 -6.558 -5.993 1.795 1.016
1600.80 .349 -4.896 -5.489 -.713 .656 -4.708 -4.346 -.040 -.765
2185.29 .913 2.322 -2.185 -.798 .998 -2.571 2.640 .944 -.800
2294.72 1.038 -2.406 2.424 .619 -.742 -2.132 1.618 .253 -.510
"""
"""Hz, % of critical damping, and the imaginary parts at the sensors."""
MATERIAL = "*MATERIAL, NAME=ALU\n*ELASTIC\n70000., 0.33\n*DENSITY\n2.745e-9,\n"


def write_test(path: Path) -> Path:
    """The measured modes as CSV."""
    rows = ["frequency_hz,damping_percent,sensor,x,y,z,direction,value"]
    for line in MEASURED.splitlines():
        frequency, damping, *values = line.split()
        for (sensor, place), value in zip(SENSORS.items(), values, strict=True):
            rows.append(f"{frequency},{damping},{sensor},{','.join(map(str, place))},x,{value}")
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


STUDY = """[model]
deck = "frame.inp"

[[clip]]
name = "corners"
type = "bushing"
nodes = ["LEGS", "TOPS"]
stiffness = [0, 0, 0, 0, 1e6, 0]
"""
"""Both corners turn about y on one spring for each pair of nodes, N mm/rad."""
SPRINGS = ALONG + 1
"""Of a corner."""


def corner_nodes() -> list[tuple[int, int]]:
    """Node of a leg and node of the top, along both corners."""
    ends = ((1, 20_001), (10_001, 20_001 + ACROSS * (ALONG + 1)))
    return [(leg + UP * (ALONG + 1) + j, top + j) for leg, top in ends for j in range(ALONG + 1)]


def frame_deck(hinged: bool = False, kind: str = "S4") -> str:
    """Three plates of S4, or of two S3 in the place of each.

    Parameters
    ----------
    hinged : at the corners they turn freely against each other about y, and LEGS and TOPS are the nodes; else welded.
    """
    nodes, elements = [], []
    pieces = ([0, 1, 2, 3],) if kind == "S4" else ([0, 1, 2], [0, 2, 3])
    top = -0.5 * THICKNESS
    heights = [*np.linspace(-HEIGHT, -0.5 * HEIGHT, UP // 2 + 1), *np.linspace(-0.5 * HEIGHT, top, UP // 2 + 1)[1:]]

    def plate(first: int, lines: list[tuple[float, float]]) -> None:
        for i, (x, z) in enumerate(lines):
            for j in range(ALONG + 1):
                nodes.append(f"{first + i * (ALONG + 1) + j}, {x:.9g}, {-DEPTH * j / ALONG:.9g}, {z:.9g}")
        for i in range(len(lines) - 1):
            for j in range(ALONG):
                a = first + i * (ALONG + 1) + j
                corners = (a, a + ALONG + 1, a + ALONG + 2, a + 1)
                for piece in pieces:
                    elements.append(", ".join(str(x) for x in (len(elements) + 1, *(corners[i] for i in piece))))

    plate(1, [(0.0, z) for z in heights])
    plate(10_001, [(WIDTH, z) for z in heights])
    plate(20_001, [(x, top) for x in np.linspace(0.0, WIDTH, ACROSS + 1)])
    joined = []
    for leg, over in corner_nodes():
        for dof in (1, 2, 3, 4, 6, *(() if hinged else (5,))):
            joined.append(f"*EQUATION\n2\n{leg}, {dof}, 1., {over}, {dof}, -1.")
    for name, ends in zip(("LEGS", "TOPS"), zip(*corner_nodes(), strict=True), strict=True):
        joined += [f"*NSET, NSET={name}, UNSORTED", *(f"{node}," for node in ends)]
    lines = ["*NODE", *nodes, f"*ELEMENT, TYPE={kind}, ELSET=ALL", *elements, *joined]
    return "\n".join(lines) + "\n" + MATERIAL + f"*SHELL SECTION, ELSET=ALL, MATERIAL=ALU\n{THICKNESS},\n"
