"""The unreduced model near an event alone: exact where the reduced one is, else as near to all of it as it says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import creak
from creak.studies.converge.settling import LEAST
from creak.studies.models import of_parts
from creak.studies.models.reduced import FACTOR
from creak.studies.spots import choose, handover
from creak.studies.spots.check import check_spots
from creak.studies.spots.handover import handed_over
from creak.studies.spots.march import Checker
from creak.studies.spots.nearby import Nearby, checker_of, price_of
from creak.verify.matching import FIGURES, TIMES
from helpers_decks import STUDY, two_strips, write_strips

SHORT = STUDY.replace("step = 5e-4", 'accuracy = "quick"').replace("periods = 2", "end = 0.09")


def checked(result, monkeypatch, dofs):
    """Spots with so many dofs that move by themselves; None: all."""
    monkeypatch.setattr(handover, "NEARBY", dofs or result.reference.free_dof)
    of, why = handed_over(result.band, result.reference)
    assert of.nearby == dofs, why
    monkeypatch.setattr(choose, "STEPS", 10)  # a third: what steps leave is the same of both
    few = replace(of, fewest=of.fewest // 4, budget=0.0)
    return of, check_spots(result.band, few, lambda *_: None).spots


DASHPOT = "*ELEMENT, TYPE=DASHPOT1, ELSET=DASHPOT\n9001, 13\n*DASHPOT, ELSET=DASHPOT\n3\n1e-6\n*BOUNDARY"


@pytest.mark.parametrize(
    ("damping", "dashpot", "within"),
    [("", "*BOUNDARY", 2e-3), ("[damping]\nmodal = 0.03\n", "*BOUNDARY", 0.02), ("", DASHPOT, 2e-3)],
)
def test_beside_a_reduced_model_with_all_modes_some_dofs_are_as_good_as_all(
    tmp_path, monkeypatch, damping, dashpot, within
):
    """What lies beyond moves as in the unreduced model then, and nothing is left but the shapes that it is made of; with
    modal damping also what modes beyond the known ones are damped by, in proportion to their stiffness. A dashpot
    couples the modes."""
    deck = two_strips().replace("*BOUNDARY", dashpot)
    study = creak.read_study(write_strips(tmp_path, deck=deck, study=SHORT + damping))
    result = creak.run(creak.change_study(study, {"reduction.f_max": 1e7}), converge=False, record=False).found
    assert result.reduced.complete
    _, whole = checked(result, monkeypatch, None)
    of, some = checked(result, monkeypatch, 60)
    assert len(whole) == len(some) > 1
    for a, b in zip(whole, some, strict=True):
        assert a.event is b.event
        assert b.unreduced == pytest.approx(a.unreduced, rel=within)
        assert 0.0 < max(b.border.values()) < within
    assert (of.low.beta is not None) == bool(damping)


PLATE = """[model]
deck = "strips.inp"
units = "m-kg-s"
[[connector]]
type = "play"
nodes = "MIDDLE"
dof = "z"
upper = 2e-5
stiffness = 1e6
[excitation.edges]
node_set = "EDGES"
dof = "z"
kind = "acceleration"
signal = { type = "multisine", f_min = 20, f_max = 150, amplitude = 20, period = 0.1, seed = 3 }
[reduction]
f_max = 700
[time]
end = 0.1
[verification]
f_max = 1000
"""


def plate(nx=30, ny=20, size=0.01):
    """Held at two edges, that shake; 1 mm of steel."""
    nodes = [f"{1 + i + 100 * j}, {i * size}, {j * size}, 0." for j in range(ny + 1) for i in range(nx + 1)]
    shells = [
        f"{1 + i + 100 * j}, {1 + i + 100 * j}, {2 + i + 100 * j}, {102 + i + 100 * j}, {101 + i + 100 * j}"
        for j in range(ny)
        for i in range(nx)
    ]
    edges = [str(1 + i + 100 * j) for j in range(ny + 1) for i in (0, nx)]
    return "\n".join(
        [
            "*NODE",
            *nodes,
            "*ELEMENT, TYPE=S4, ELSET=PLATE",
            *shells,
            "*MATERIAL, NAME=STEEL",
            "*ELASTIC",
            "2.1e11, .3",
            "*DENSITY",
            "7850.",
            "*DAMPING, ALPHA=20., BETA=1e-6",
            "*SHELL SECTION, ELSET=PLATE, MATERIAL=STEEL",
            ".001,",
            "*NSET, NSET=EDGES",
            *edges,
            "*NSET, NSET=MIDDLE",
            str(1 + nx // 2 - 2 + 100 * (ny // 2)),
            "*BOUNDARY",
            "EDGES, 1, 2",
            "EDGES, 4, 6",
            "",
        ]
    )


def test_what_the_border_changes_is_told(tmp_path, monkeypatch):
    """A plate that hits a stop, reduced to too few modes: its middle alone finds what all of it does, within what a
    border half as far away changes."""
    study = creak.read_study(write_strips(tmp_path, deck=plate(), study=PLATE))
    result = creak.run(study, converge=False, record=False).found
    assert not result.reduced.complete
    _, whole = checked(result, monkeypatch, None)
    _, some = checked(result, monkeypatch, 800)
    assert len(whole) == len(some) > 2
    both = [(a, b) for a in whole for b in some if a.event is b.event]
    for a, b in both:
        for name in FIGURES:
            lasts = a.event.t_end - a.event.t_start if name in TIMES else 1.0
            assert abs(a.difference(name)) <= b.error(name) + LEAST[name] * lasts, name
    off = [b.unreduced["impulse"] / a.unreduced["impulse"] - 1.0 for a, b in both]
    assert np.median(np.abs(off)) < 5e-3  # the reduced model itself is .4 to 1 % off


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """Two strips, run as the study says."""
    study = creak.read_study(write_strips(tmp_path_factory.mktemp("short"), study=SHORT))
    return study, creak.run(study, converge=False, record=False).found


def test_it_is_taken_for_large_models_alone(short):
    _, result = short
    of, _ = handed_over(result.band, result.reference)
    assert of.nearby is None
    assert isinstance(checker_of(of, 8, np.arange(2)), Checker)
    assert isinstance(checker_of(replace(of, nearby=60), 8, np.arange(2)), Nearby)


def test_without_a_factor_of_the_whole_events_are_checked_all_the_same(short, monkeypatch):
    """Parts alone in memory: the unreduced matrices near an event are those of before, and so is what they say."""
    study, whole = short
    _, expected = checked(whole, monkeypatch, 100)
    monkeypatch.setattr(of_parts, "only_parts_fit", lambda *_: True)
    parts = creak.run(study, converge=False, record=False).found
    assert parts.reference.of_parts == whole.reference.free_dof
    of, why = handed_over(parts.band, parts.reference)
    assert of.nearby is not None, why
    held = price_of(replace(of, by_parts=False), 2)
    assert price_of(of, 2) == replace(held, span=held.span + FACTOR)  # the parts' factors are made for each check
    _, found = checked(parts, monkeypatch, 100)
    assert len(found) == len(expected) > 1
    for a, b in zip(expected, found, strict=True):
        assert a.event.t_start == pytest.approx(b.event.t_start, rel=1e-6)
        assert a.unreduced == pytest.approx(b.unreduced, rel=1e-3)
