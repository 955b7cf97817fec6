"""Systems of units: labels and sizes agree with each other."""

from __future__ import annotations

import pytest

from creak.model.units import METRES, UNITS
from creak.studies.file.config import ModelTable
from creak.studies.prepare.unit_check import SYSTEMS

SIZES = {"mm": 1e-3, "m": 1.0, "t": 1000.0, "kg": 1.0, "mJ": 1e-3, "J": 1.0, "MPa": 1e6, "Pa": 1.0}


@pytest.mark.parametrize("name", UNITS)
def test_labels_are_those_of_the_sizes(name):
    """force = mass length / time^2 is the newton in both; energy and stress follow from it."""
    u = UNITS[name]
    assert METRES[name] == SIZES[u.length]
    assert u.to_kg == SIZES[u.mass]
    assert u.to_kg * METRES[name] == 1.0
    assert METRES[name] == SIZES[u.energy]
    assert u.per_metre**2 == SIZES[u.stress]
    assert u.density.split("/") == [u.mass, f"{u.length}^3"]


def test_a_study_can_name_each_and_no_other():
    assert ModelTable.model_json_schema()["properties"]["units"]["enum"] == [*UNITS] == [*SYSTEMS]


def test_checks_of_a_deck_use_the_same_sizes():
    assert [(s.length, s.stress, s.density, s.mass) for s in SYSTEMS.values()] == [
        (1e-3, 1e6, 1e12, pytest.approx(1000.0, rel=1e-15)),
        (1.0, 1.0, 1.0, 1.0),
    ]
