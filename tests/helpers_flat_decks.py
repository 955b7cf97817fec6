"""A flat strip as an Abaqus or a Nastran deck, of any shell: fixed at one end, its drilling rotations held or free."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import scipy.linalg as sla

from creak.studies.models.deck_modes import deck_modes

LENGTH, WIDTH, THICKNESS = 1.0, 0.1, 0.01
E, NU, RHO = 210e9, 0.3, 7850.0
ABAQUS = ("S3", "S4", "S4R", "STRI65", "S8R")
NASTRAN = ("CTRIA3", "CTRIAR", "CQUAD4", "CQUADR", "CTRIA6", "CQUAD8")
SHELLS = (*ABAQUS, *NASTRAN)
QUADRATIC = ("STRI65", "S8R", "CTRIA6", "CQUAD8")
TRIANGLES = ("S3", "STRI65", "M3D3", "CTRIA3", "CTRIAR", "CTRIA6")


def timoshenko(rotary: bool = True) -> float:
    """First frequency of the strip in its plane as a cantilever, Hz.

    GA k (w' - p)' + m W w = 0, EI p'' + GA k (w' - p) + r W p = 0 with W = omega^2, k = 5/6: roots of the determinant of
    w(0), p(0), p'(L), w'(L) - p(L). (Timoshenko, Phil. Mag. 41 (1921) 744.)
    """
    area, inertia = WIDTH * THICKNESS, THICKNESS * WIDTH**3 / 12.0
    EI, GA = E * inertia, 5.0 / 6.0 * E / (2.0 * (1.0 + NU)) * area

    def determinant(f: float) -> float:
        W = (2.0 * np.pi * f) ** 2
        A = np.array(
            [[0, 1, 0, 1 / GA], [0, 0, 1 / EI, 0], [0, -rotary * RHO * inertia * W, 0, -1], [-RHO * area * W, 0, 0, 0]]
        )
        end = sla.expm(A * LENGTH)  # of (w, p, moment, shear force)
        return float(np.linalg.det(end[2:, 2:]))

    low, high = 50.0, 120.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if determinant(low) * determinant(middle) > 0.0 else (low, middle)
    return low


def mesh(kind: str, nx: int, ny: int) -> tuple[np.ndarray, list[list[int]]]:
    """Places (n, 2) of nodes 1, 2, ... and the nodes of the elements."""
    m = 2 if kind in QUADRATIC else 1
    numbers: dict[tuple[int, int], int] = {}

    def at(i: int, j: int) -> int:
        return numbers.setdefault((i, j), len(numbers) + 1)

    elements = []
    for i in range(0, m * nx, m):
        for j in range(0, m * ny, m):
            a, b, c, d = (i, j), (i + m, j), (i + m, j + m), (i, j + m)
            for corners in ((a, b, c), (a, c, d)) if kind in TRIANGLES else ((a, b, c, d),):
                nodes = list(corners)
                if m == 2:
                    after = (*corners[1:], corners[0])
                    nodes += [((p[0] + q[0]) // 2, (p[1] + q[1]) // 2) for p, q in zip(corners, after, strict=True)]
                elements.append([at(*node) for node in nodes])
    xy = np.array(list(numbers), dtype=float) * [LENGTH / (m * nx), WIDTH / (m * ny)]
    return xy, elements


def strip(kind: str, nx: int, ny: int, *, held: bool, axes: np.ndarray | None = None, more: str = "") -> str:
    """The deck. `axes` (3, 3): rows are the directions along, across and normal to it, with a frame of their own (CD)
    in Nastran; default: global ones."""
    xy, elements = mesh(kind, nx, ny)
    R = np.eye(3) if axes is None else axes
    root = np.flatnonzero(xy[:, 0] < 1e-9) + 1
    text = _abaqus if kind not in NASTRAN else _nastran
    return text(kind, xy @ R[:2], elements, root.tolist(), held, None if axes is None else R, more)


def _abaqus(kind, xyz, elements, root, held, axes, more) -> str:
    lines = ["*NODE", *(f"{k}, {x!r}, {y!r}, {z!r}" for k, (x, y, z) in enumerate(xyz.tolist(), 1))]
    lines += [f"*ELEMENT, TYPE={kind}, ELSET=ALL", *(", ".join(map(str, [k, *e])) for k, e in enumerate(elements, 1))]
    lines += ["*NSET, NSET=ALL, GENERATE", f"1, {len(xyz)}", "*NSET, NSET=ROOT", *map(str, root)]
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", f"{E}, {NU}", "*DENSITY", f"{RHO}"]
    lines += [f"*{'MEMBRANE' if kind.startswith('M3D') else 'SHELL'} SECTION, ELSET=ALL, MATERIAL=M", f"{THICKNESS}"]
    if axes is not None:
        lines += ["*TRANSFORM, NSET=ALL", ", ".join(repr(v) for v in axes[:2].ravel().tolist())]
    lines += [more] if more else []
    return "\n".join([*lines, "*BOUNDARY", f"ALL, 3, {6 if held else 5}", "ROOT, 1, 2", "ROOT, 6, 6", ""])


def _nastran(kind, xyz, elements, root, held, axes, more) -> str:
    lines = ["SOL 103", "CEND", "METHOD=1", "SPC=1", "BEGIN BULK", "EIGRL,1,,,6"]
    lines += [f"MAT1,1,{E:.6E},,{NU},{RHO}", f"PSHELL,1,1,{THICKNESS},1,,1"]
    frame = ""
    if axes is not None:
        frame = "5"
        lines += ["CORD2R,5,,0.,0.,0.,{:.9f},{:.9f},{:.9f}".format(*axes[2]), "+,{:.9f},{:.9f},{:.9f}".format(*axes[0])]
    ps = 3456 if held else 345
    lines += [f"GRID,{k},,{x:.12f},{y:.12f},{z:.12f},{frame},{ps}" for k, (x, y, z) in enumerate(xyz.tolist(), 1)]
    for k, nodes in enumerate(elements, 1):
        fields = [kind, str(k), "1", *map(str, nodes)]
        lines.append(",".join(fields[:9]) + (",+\n+," + ",".join(fields[9:]) if len(fields) > 9 else ""))
    lines += [f"SPC1,1,126,{k}" for k in root]
    return "\n".join([*lines, *([more] if more else []), "ENDDATA", ""])


def frequencies(folder: Path, text: str, count: int = 3) -> list[float]:
    """Hz."""
    path = folder / ("flat.bdf" if text.startswith("SOL") else "flat.inp")
    path.write_text(text, encoding="utf-8")
    return deck_modes(path, count=count).frequencies
