"""Write the cockpit's deck and study."""

from __future__ import annotations

import math
from pathlib import Path

from creak import InputError, write_text
from creak_thesis.cockpit.deck import deck_text
from creak_thesis.cockpit.study import background_text, study_text

FILES = ("cockpit.inp", "cockpit.toml", "cabin.csv")
SIZES = (4.0, 20.0)
"""Smallest and largest size of the elements, mm."""
LOADS = (0.01, 10.0)
"""Factors on the acceleration."""


def write_cockpit(mesh_size: float, out: Path, load: float = 1.0, seed: int = 1) -> list[Path]:
    """Write `FILES` into a folder and return their paths.

    Parameters
    ----------
    mesh_size : length of the elements' sides, mm, 4 to 20, rounded to 20 mm over a whole number; 10 for a first run.
    out : the folder; it is made if missing.
    load : factor on the road's acceleration, 0.01 to 10.
    seed : of its random phases.

    Raises
    ------
    InputError : a size or load out of range, a negative seed, or `out` is a file; nothing is written.
    """
    if out.exists() and not out.is_dir():
        raise InputError("this is a file", expected="a folder", where=out, fix="Give another folder.")
    for what, value, (low, high) in (("mesh size", mesh_size, SIZES), ("load", load, LOADS)):
        if not (math.isfinite(value) and low <= value <= high):
            raise InputError(
                f"{what} {value:g}", expected=f"a number from {low:g} to {high:g}", where=f"{what} of the cockpit"
            )
    if seed < 0:
        raise InputError(f"seed {seed}", expected="a whole number, 0 or more", where="seed of the cockpit")
    study = f"# written by creak example cockpit\n{study_text(load, seed)}"
    texts = dict(zip(FILES, (deck_text(mesh_size), study, background_text()), strict=True))
    out.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        write_text(out / name, text)
    return [out / name for name in texts]
