"""Two masses on springs and dashpots, their frequency response functions in closed form, and universal files of these."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from helpers_modal import data_set, e13

M1, M2 = 2e-3, 1e-3
"""t"""
K1, K2, C1, C2 = 40.0, 25.0, 2e-3, 5e-3
"""N/mm, N s/mm"""
FREQ = np.arange(1.0, 50.5, 0.5)
"""Hz; resonances at 14 and 31."""
NODES = {1: 0.0, 2: 100.0, 3: 220.0}
"""Label -> x in mm; node 1 is held."""


def masses_deck(folder: Path) -> Path:
    """In mm-t-s, moving along x alone."""
    path = folder / "masses.bdf"
    grids = "".join(f"GRID,{n},,{x:.1f},0.0,0.0,,{'123456' if n == 1 else '23456'}\n" for n, x in NODES.items())
    springs = f"CELAS2,11,{K1},1,1,2,1\nCELAS2,12,{K2},2,1,3,1\n"
    dashpots = f"CDAMP2,21,{C1},1,1,2,1\nCDAMP2,22,{C2},2,1,3,1\n"
    points = f"CONM2,31,2,,{M1}\nCONM2,32,3,,{M2}\n"
    path.write_text(f"SOL 103\nCEND\nBEGIN BULK\n{grids}{springs}{dashpots}{points}ENDDATA\n", encoding="utf-8")
    return path


def receptance(response: int, reference: int, freq=FREQ, damped: bool = True) -> np.ndarray:
    """x at one of the nodes 2 and 3 over a force along x at another, m/N."""
    s = 2j * np.pi * freq
    k1, k2 = (k + damped * s * c for k, c in ((K1, C1), (K2, C2)))
    a, b, d = k1 + k2 + s**2 * M1, -k2, k2 + s**2 * M2
    inverse = {(2, 2): d, (3, 3): a, (2, 3): -b, (3, 2): -b}[response, reference]
    return 1e-3 * inverse / (a * d - b * b)


def accelerance(response: int, reference: int, freq=FREQ) -> np.ndarray:
    """m/s^2/N"""
    return (2j * np.pi * freq) ** 2 * receptance(response, reference, freq)


def points(scale: float = 1.0, frame: int = 0) -> str:
    rows = [f"{n:10d}{0:10d}{frame:10d}{8:10d}{e13([x * scale, 0.0, 0.0])}" for n, x in NODES.items()]
    return data_set(15, *rows)


def units(length: float, force: float = 1.0) -> str:
    """Units of length in 1 m, of force in 1 N."""
    line = "".join(f"{v:25.17E}" for v in (length, force, 1.0)).replace("E", "D")
    return data_set(164, f"{9:10d}{'units':<20}{2:10d}", line, f"{273.15:25.17E}".replace("E", "D"))


def function(
    values,
    response=(3, 1),
    reference=(2, 1),
    *,
    freq=FREQ,
    kind: int = 4,
    data: int = 6,
    even: bool = True,
    quantity: int = 12,
    over: int = 13,
    labels=("NONE", "NONE"),
    abscissa: int = 18,
    over_unit: str = "NONE",
    binary: str = "",
    wide_abscissa: bool = False,
) -> bytes:
    """A data set 58, or 58b in the byte order `binary`; `freq` and its unit are the abscissa, whatever it counts."""

    def axis(what: int, label: str = "NONE") -> str:
        return f"{what:10d}{0:5d}{0:5d}{0:5d} {'NONE':<20} {label:<20}"

    start, step = (freq[0], freq[1] - freq[0]) if even else (0.0, 0.0)
    head = [
        *["NONE"] * 5,
        f"{kind:5d}{1:10d}{0:5d}{0:10d} {'NONE':<10}{response[0]:10d}{response[1]:4d} {'NONE':<10}"
        f"{reference[0]:10d}{reference[1]:4d}",
        f"{data:10d}{len(freq):10d}{int(even):10d}{start:13.5E}{step:13.5E}{0.0:13.5E}",
        axis(abscissa, over_unit),
        axis(quantity, labels[0]),
        axis(over, labels[1]),
        axis(0),
    ]
    is_double, is_complex = data in (4, 6), data in (5, 6)
    rows = np.column_stack([values.real, values.imag] if is_complex else [np.real(values)])
    if binary:
        letter = "d" if is_double else "f"
        form = f"{binary}{'' if even else letter if wide_abscissa else 'f'}{letter * rows.shape[1]}"
        parts = [struct.pack(form, *(() if even else (x,)), *row) for x, row in zip(freq, rows, strict=True)]
        body = b"".join(parts)
        sizes = f"{1 if binary == '<' else 2:6d}{2:6d}{11:12d}{len(body):12d}{0:6d}{0:6d}{0:12d}{0:12d}"
        text = "\n".join(["    -1", f"    58b{sizes}", *head]) + "\n"
        return text.encode() + body + b"\n    -1\n"
    width = 20 if is_double else 13
    cells = [
        [*([] if even else [f"{x:13.5E}"]), *(f"{v:{width}.{12 if is_double else 5}E}" for v in row)]
        for x, row in zip(freq, rows, strict=True)
    ]
    flat, per_line = [c for row in cells for c in row], 80 // sum(map(len, cells[0])) * len(cells[0])
    per_line = per_line if not even else 80 // width
    lines = ["".join(flat[k : k + per_line]) for k in range(0, len(flat), per_line)]
    return data_set(58, *head, *lines).encode()
