"""A steel bar that flies at a wall, and what closed forms say of its blow."""

from __future__ import annotations

import numpy as np

from creak.studies.file.reader import read_study
from helpers_contact_studies import rods
from helpers_decks import write_study

YOUNG, DENSITY, AREA, LENGTH, SPEED = 2.1e11, 7850.0, 4e-4, 0.2, 100.0
"""A steel bar that flies at a wall: contact for 2 L / c, force rho c A v, impulse 2 m v."""
WAVE = float(np.sqrt(YOUNG / DENSITY))
LASTS, IMPULSE = 2.0 * LENGTH / WAVE, 2.0 * DENSITY * AREA * LENGTH * SPEED
FIRST = WAVE / (4.0 * LENGTH)
"""Hz, of the bar that is held at its foot: the others lie at 3, 5, 7 .. times that."""


def bar(folder, reduction="", n=100, time="end = 2e-4"):
    """The study with a hard stop, a hundredth of a millimetre from the bar's foot per element."""
    study_path = write_study(
        folder,
        '[model]\ndeck = "deck.inp"\nunits = "m-kg-s"\n[[connector]]\ntype = "play"\nnodes = "A_FOOT"\ndof = "x"\n'
        f"lower = -1e-3\nstiffness = {10.0 * YOUNG * AREA * n / LENGTH!r}\n"
        f"[reduction]\n{reduction}\n[time]\n{time}\n",
        {"deck.inp": rods([LENGTH], [n], [-SPEED], YOUNG, DENSITY, AREA)},
    )
    return read_study(study_path)
