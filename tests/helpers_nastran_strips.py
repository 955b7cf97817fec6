"""The two strips of `helpers_decks` as a Nastran deck."""

from __future__ import annotations


def _strip(first: int, pid: int, z: float, n: int = 12, length: float = 120.0) -> list[str]:
    grids = [f"GRID,{first + j * (n + 1) + i},,{length * i / n},{10.0 * j},{z}" for j in range(3) for i in range(n + 1)]
    quads = []
    for j in range(2):
        for i in range(n):
            a = first + j * (n + 1) + i
            quads.append(f"CQUAD4,{first + j * n + i},{pid},{a},{a + 1},{a + n + 2},{a + n + 1}")
    return grids + quads


def strips(gap: float = 0.5, extra: str = "") -> str:
    """An upper strip (1 mm, moving root: grids 1, 14, 27) above a lower one (1.5 mm), mass COUPMASS."""
    lines = [
        "SOL 112",
        "CEND",
        "SPC = 1",
        "SET 1 = 1, 14, 27",
        "SET 2 = 1039, 39, 1013, 13",
        "BEGIN BULK",
        *_strip(1, 1, gap + 1.25),
        *_strip(1001, 2, 0.0),
        "MAT1,1,210000.,,.3,7.85-9",
        "PSHELL,1,1,1.,1,,1",
        "PSHELL,2,1,1.5,1,,1",
        "PARAM,ALPHA1,5.",
        "PARAM,ALPHA2,2.-6",
        "SPC1,1,123456,1001,1014,1027",
        "SPC1,1,12456,1,14,27",
        "PARAM,COUPMASS,1",
        extra,
        "ENDDATA",
    ]
    return "\n".join(lines) + "\n"


STUDY = {
    'deck = "strips.inp"': 'deck = "strips.bdf"',
    '"UNDER"': '"PID_1.SNEG"',
    '"OVER"': '"PID_2.SPOS"',
    '"ROOT_UPPER"': '"SET_1"',
    '"PAIRS"': '"SET_2"',
}
"""What changes in the study file."""
