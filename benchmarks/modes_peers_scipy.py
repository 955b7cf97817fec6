"""Modes of a deck by SciPy: `python -m benchmarks.modes_peers_scipy DECK COUNT`, a peer of `benchmarks.modes_peers`.

creak reads and assembles, so K and M are its own; ARPACK (`scipy.sparse.linalg.eigsh`) finds the modes by shift-invert
with SuperLU, as whoever has two matrices and SciPy would do it. Prints the frequencies (Hz) as JSON.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import eigsh

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.formats.decks import read_model
from creak.studies.models.deck_modes import undamped_system

SHIFT = -1.0
"""(rad/s)^2: below all modes, rigid-body ones too, so that K - shift M is regular."""


def frequencies(system: System, count: int) -> FloatArray:
    """(count,) Hz, rising."""
    K, M = sp.csc_matrix(system.K), sp.csc_matrix(system.M)
    found, _ = eigsh(K, count, M, sigma=SHIFT, which="LM")
    return np.sqrt(np.sort(np.maximum(found, 0.0))) / (2.0 * np.pi)


def main() -> None:
    """Print them."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.modes_peers_scipy")
    parser.add_argument("deck", type=Path)
    parser.add_argument("count", type=int)
    given = parser.parse_args()
    json.dump(frequencies(undamped_system(read_model(given.deck)), given.count).tolist(), sys.stdout)


if __name__ == "__main__":
    main()
