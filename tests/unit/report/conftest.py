"""Lets the tests of the report import the small studies, and runs each of those once."""

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import small_study as small

from creak.studies.run.job import StudyResult

CASES = {
    "both runs": (small.study_text(), None),
    "reduced only": (small.study_text(reference=False), None),
    "unreduced only": (small.study_text(method="none"), None),
    "no pairs": (small.study_text(pairs=""), None),
    "no contact, no pairs": (small.study_text(contact="", pairs=""), None),
    "no events": (small.study_text(amplitude=0.001), None),
    "connector only": (small.study_text(contact=small.PLAY), None),
    "contact and connector": (small.study_text(contact=small.CONTACT + small.PLAY), None),
    "no modes": (small.study_text(mac_f_max=1.0), None),
    "nothing moves": (small.study_text(amplitude=0.0), None),
    "mass on a spring": (small.SINGLE_MASS, small.mass_on_spring()),
}


@pytest.fixture(scope="session")
def result_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], StudyResult]:
    """Result of a case by its name."""
    done: dict[str, StudyResult] = {}

    def result(name: str) -> StudyResult:
        if name not in done:
            done[name] = small.run_small(tmp_path_factory.mktemp("study"), *CASES[name])
        return done[name]

    return result
