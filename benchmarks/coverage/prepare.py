"""Random models made ready: so much excitation that what would touch does."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.coverage.full import Full, full_model
from benchmarks.coverage.models import Case, write_case
from creak.studies.file.reader import read_study
from creak.studies.prepare.setup import Setup, set_up

BEYOND = (1.3, 4.0)
"""Times the gap that the parts would close without contact."""


def prepared(seed: int, folder: Path) -> tuple[Case, Setup, Full]:
    """The model of a seed, its files and all modes of its full matrices."""
    rng = np.random.default_rng([35, seed])
    case = write_case(seed, folder)
    setup = set_up(read_study(case.study))
    full = full_model(setup, case.fastest)
    stiffness = None
    if setup.contacts.m:
        area = np.where(setup.contacts.area > 0.0, setup.contacts.area, 1.0)
        by_area = setup.study.config.contact["touch"].method == "surface-to-surface"
        stiffness = float(np.median(setup.contacts.stiffness / (area if by_area else 1.0)))
    run = full.silent()
    closing = (full.modes.gap0 - run.gap.min(axis=0)) / full.modes.gap0
    amplitude = float(rng.uniform(*BEYOND) / closing.max())
    case = write_case(seed, folder, amplitude, stiffness)
    setup = set_up(read_study(case.study))
    return case, setup, full_model(setup, case.fastest)
