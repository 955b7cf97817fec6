"""Small decks with a *DYNAMIC step of their own."""

from __future__ import annotations

STEEL = "*MATERIAL, NAME=STEEL\n*ELASTIC\n2.1E11, 0.\n*DENSITY\n7850.\n"
WALL = (
    "*NODE\n9001, -1., -1., 0.\n9002, 1., -1., 0.\n9003, 1., 1., 0.\n9004, -1., 1., 0.\n"
    "*ELEMENT, TYPE=S4, ELSET=WALL\n9001, 9001, 9002, 9003, 9004\n*NSET, NSET=WALL_NODES\n9001, 9002, 9003, 9004\n"
    "*SHELL SECTION, ELSET=WALL, MATERIAL=STEEL\n1.E-3,\n*SURFACE, NAME=TABLE\nWALL, SPOS\n"
)
LINEAR = "*SURFACE INTERACTION, NAME=STOP\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n1.E6\n"
FLUSH = "*CLEARANCE, MASTER=TABLE, SLAVE=POINT, VALUE=0.\n"
STEP = "*STEP, NAME=HIT, INC=100000\n*DYNAMIC, DIRECT, ALPHA=0.\n1.E-5, 0.04\n*NODE OUTPUT, NSET=BALL\nU\n*END STEP\n"
PAIR = "*CONTACT PAIR, INTERACTION=STOP, SMALL SLIDING, TYPE=NODE TO SURFACE\nPOINT, TABLE\n"


def stop_deck(contact: str = PAIR + LINEAR + FLUSH, step: str = STEP) -> str:
    """100 kg on a spring of 1e4 N/m that moves with 1 m/s against a stop of 1e6 N/m."""
    return (
        "*HEADING\nmass on a penalty stop\n*NODE\n1, 0., 0., 0.\n*ELEMENT, TYPE=MASS, ELSET=M\n1, 1\n*MASS, ELSET=M\n"
        "100.,\n*ELEMENT, TYPE=SPRING1, ELSET=K\n2, 1\n*SPRING, ELSET=K\n3\n1.E4\n*NSET, NSET=BALL\n1\n"
        + STEEL
        + WALL
        + "*SURFACE, NAME=POINT, TYPE=NODE\nBALL\n*BOUNDARY\nWALL_NODES, ENCASTRE\nBALL, 1, 2\n"
        "*INITIAL CONDITIONS, TYPE=VELOCITY\nBALL, 3, -1.\n" + contact + step
    )


def column(n: int, side: float, length: float, bottom: float = 0.0) -> str:
    """A column of n bricks along z, element set BAR, nodes BAR_NODES, its lower face as surface END_FACE."""
    corners = ((0, 0), (1, 0), (1, 1), (0, 1))
    lines = ["*NODE, NSET=BAR_NODES"]
    for k in range(n + 1):
        z = bottom + length * k / n
        lines += [f"{4 * k + j + 1}, {side * x:.9g}, {side * y:.9g}, {z:.9g}" for j, (x, y) in enumerate(corners)]
    lines.append("*ELEMENT, TYPE=C3D8, ELSET=BAR")
    lines += [f"{k + 1}, " + ", ".join(str(4 * k + j) for j in range(1, 9)) for k in range(n)]
    lines += ["*SOLID SECTION, ELSET=BAR, MATERIAL=STEEL", "*ELSET, ELSET=FIRST", "1", "*SURFACE, NAME=END_FACE"]
    return "\n".join([*lines, "FIRST, S1"]) + "\n"


def bar_deck(contact: str, increment: float, period: float, n: int = 40, bottom: float = 0.0) -> str:
    """A free bar, 1 m long and 0.1 m wide, that flies with 1 m/s against a rigid wall."""
    return (
        "*HEADING\nbar on a rigid wall\n"
        + STEEL
        + column(n, 0.1, 1.0, bottom)
        + WALL
        + "*BOUNDARY\nWALL_NODES, ENCASTRE\nBAR_NODES, 1, 2\n*INITIAL CONDITIONS, TYPE=VELOCITY\nBAR_NODES, 3, -1.\n"
        + contact
        + f"*STEP\n*DYNAMIC, DIRECT, ALPHA=-0.05\n{increment:.9g}, {period:.9g}\n"
        + "*NODE OUTPUT, NSET=BAR_NODES\nU\n*END STEP\n"
    )


def cantilever_deck(step: str, amplitudes: str = "", held: str = "ROOT, 1, 2\nROOT, 4, 6\n") -> str:
    """A clamped beam of 8 elements along x, 0.4 m long; ROOT is its clamped node, TIP its other end."""
    nodes = "\n".join(f"{i + 1}, {0.05 * i:.6g}, 0., 0." for i in range(9))
    elements = "\n".join(f"{i}, {i}, {i + 1}" for i in range(1, 9))
    return (
        f"*HEADING\ncantilever\n*NODE\n{nodes}\n*ELEMENT, TYPE=B31, ELSET=BEAM\n{elements}\n"
        + STEEL
        + "*DAMPING, ALPHA=20.\n*BEAM SECTION, ELSET=BEAM, MATERIAL=STEEL, SECTION=RECT\n0.02, 0.01\n0., 1., 0.\n"
        + f"*NSET, NSET=ROOT\n1\n*NSET, NSET=TIP\n9\n*BOUNDARY\n{held}"
        + amplitudes
        + step
    )
