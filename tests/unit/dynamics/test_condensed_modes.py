"""The condensed step in modes: a System in its own modes is marched as the one in dofs, to round-off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from creak.assembly.damping import Damping
from creak.assembly.part import Rayleigh
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.contact.laws.parameters import Curves, Friction
from creak.dynamics.diagonal import is_modal, modal_matrices
from creak.dynamics.history import ENERGIES, Diverged, History
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.scheme import HHT, Scheme, generalised_alpha
from creak.dynamics.simulate import simulate
from creak.errors import InputError, NumericalError
from creak.linalg.factor import factor
from creak.linalg.modes import modes
from creak.reduction.diagonal import diagonalise
from creak.reduction.modal import support_motion, with_modal_damping
from helpers_core import time_axis
from helpers_gap import N, cantilevers, gaps_between, multisine_base

RECORDED = {"section": "time", "source": "the same in dofs"}

TIP, OTHER = 6 * N + 1, 6 * (2 * N + 1) + 1
OBSERVED = np.array([TIP, TIP - 6, OTHER])
ROUND_OFF = 1e-8
"""Both solve the same equations; those in dofs have a step matrix of condition 1e7 (eps times that, some steps on)."""
HARD = 1e-6
"""Forces of hard contact are a quotient of small numbers, and each blow carries on a multiple of what they differ by."""


def in_dofs(velocity: bool = False, modal: bool = False) -> System:
    """Two beams on a moving base."""
    full = cantilevers(Rayleigh(5.0, 1e-6))
    if velocity:
        full = replace(full, velocity=np.linspace(0.0, 0.3, full.n))
    if modal:
        found = modes(full.K, full.M, count=10)
        full = with_modal_damping(full, found, support_motion(full, factor(full.K)), 0.02)
    return full


def driven() -> System:
    """The same in its own modes."""
    return diagonalise(in_dofs())


def loads_of(end: float = 0.1, step: float = 2e-4) -> Loads:
    """A moving base and a force at a tip."""
    base = multisine_base(time_axis(end, step), 20.0, 400.0, 2e-4)
    force = 0.5 * np.sin(2.0 * np.pi * 70.0 * base.time)
    return replace(base, force=force[:, None], force_labels=(np.array([TIP]),))


def rubbing(gaps: GapOperator, static: float = 3.0, kinetic: float = 2.0, decay: float = 0.0) -> GapOperator:
    """The same channels with friction in the second: along x by the turning of the thick beams, and along z."""
    tangents = []
    for dof, arm in ((5, 0.02), (2, 1.0)):
        T = np.zeros(gaps.G.shape)
        for row, node in enumerate((N // 2, N)):
            T[row, 6 * node + dof], T[row, 6 * (N + 1 + node) + dof] = -arm, 0.7 * arm
        tangents.append(sp.csr_matrix(T))
    friction = Friction(np.array([0.0, static]), np.array([0.0, kinetic]), np.array([0.0, decay]))
    return replace(gaps, tangents=tuple(tangents), friction=friction)


def assert_same(a: History, b: History, tol: float = ROUND_OFF) -> None:
    """All that a run leaves behind, relative to its largest value."""
    np.testing.assert_array_equal(a.time, b.time)
    np.testing.assert_array_equal(a.output_index, b.output_index)
    assert a.contact_steps == b.contact_steps
    for name in ("gap", "force", "displacement", "slip", "tangential", "sliding", "coordinates", "energy"):
        x, y = getattr(a, name), getattr(b, name)
        assert x.shape == y.shape, name
        scale = np.abs(x).max(initial=0.0)
        np.testing.assert_allclose(y, x, rtol=0.0, atol=tol * max(scale, 1e-9), err_msg=name)


def both(
    full: System, gaps: GapOperator, loads: Loads, scheme: Scheme, asked: OutputRequest | None = None, **options: object
) -> tuple[History, History]:
    """In dofs and in modes; all coordinates that are kept are told in dofs."""
    small = diagonalise(full)
    assert is_modal(small)
    request = OutputRequest(OBSERVED) if asked is None else asked
    a, b = (simulate(s, gaps, loads, scheme, request, **options) for s in (full, small))
    support = loads.support[0][request.whole_at * options.get("substeps", 1)].T
    whole, told = small.recover(b.coordinates, support), full.recover(a.coordinates, support)
    return replace(a, coordinates=told), replace(b, coordinates=whole)


# --- the same in dofs and in modes --------------------------------------------------------------------------


@pytest.mark.parametrize(
    "scheme", [HHT(0.0), HHT(-0.05), HHT(1.0 - np.sqrt(2.0)), generalised_alpha(0.9), generalised_alpha(0.2)]
)
def test_a_change_of_basis_changes_nothing(scheme, measured):
    """Contact with dampers, moving base, force and initial velocity."""
    a, b = both(in_dofs(velocity=True), gaps_between(2e-4, 3e4, 0.5), loads_of(), scheme)
    assert 20 < a.contact_steps < 480
    assert_same(a, b)
    measured(
        "condensed step in modes: force, relative difference",
        np.abs(a.force - b.force).max() / a.force.max(),
        at_most=ROUND_OFF,
    )


def test_modal_damping_and_sparse_output():
    gaps, at = gaps_between(2e-4, 3e4), np.array([0, 7, 500])
    a, b = both(in_dofs(modal=True), gaps, loads_of(), HHT(), OutputRequest(OBSERVED, 3, at))
    assert a.contact_steps > 20
    assert a.displacement.shape == (167, 3)
    assert_same(a, b)


@pytest.mark.parametrize("decay", [0.0, 0.05])
def test_friction_and_hard_contact(decay, measured):
    gaps = rubbing(gaps_between(2e-4, np.array([np.inf, 3e4])), decay=decay)
    a, b = both(in_dofs(), gaps, loads_of(0.07), HHT(1.0 - np.sqrt(2.0)))
    slides = np.abs(a.sliding).max(axis=1) > 1e-6
    pressed = a.force[:, 1] > 0.0
    assert 5 < np.count_nonzero(slides) < np.count_nonzero(pressed) - 3
    assert a.energy[-1, ENERGIES.index("friction")] > 0.0
    assert_same(a, b, HARD)
    error = np.abs(a.tangential - b.tangential).max() / np.abs(a.tangential).max()
    measured(
        "condensed step in modes, friction and hard contact: friction force, relative difference", error, at_most=HARD
    )


def test_curves_and_preload():
    points = np.array([[0.0, 0.0], [1e-5, 1.0], [2e-5, 4.0]])
    curves = Curves(np.array([0, -1]), np.array([0.5, 1.0]), (points,))
    gaps = replace(gaps_between(np.array([2e-4, -1e-5]), 3e4), curves=curves, preload=np.array([0.0, 0.3]))
    a, b = both(in_dofs(), gaps, loads_of(), HHT())
    assert a.force.min(axis=0).max() == 0.0
    assert (a.force.max(axis=0) > 0.1).all()
    assert_same(a, b)


@pytest.mark.parametrize("scheme", [HHT(-0.05), generalised_alpha(0.8)])
def test_divided_steps(scheme):
    """Whole steps in free flight, ten parts each near contact."""
    loads = loads_of(0.1, 2e-5)
    a, b = both(in_dofs(), gaps_between(2e-4, 3e5, 0.5), loads, scheme, OutputRequest(OBSERVED, 5), substeps=10)
    steps = np.unique(np.round(np.diff(a.time) / 2e-5))
    np.testing.assert_array_equal(steps, [1.0, 10.0])
    assert_same(a, b)


def test_instants_one_by_one_are_the_output_of_many_chunks(monkeypatch):
    """Parts of steps near contact, output every fourth step, all coordinates at some; a report after every step."""
    asked = OutputRequest(OBSERVED, 4, np.array([0, 4, 48, 97]))
    seen: list[tuple[int, int]] = []
    one, twin = both(in_dofs(), gaps_between(2e-4, 3e5), loads_of(), HHT(), asked, substeps=5)
    monkeypatch.setattr("creak.dynamics.record.recorder.CHUNK", 7)
    many, _ = both(
        in_dofs(),
        gaps_between(2e-4, 3e5),
        loads_of(),
        HHT(),
        asked,
        substeps=5,
        progress=lambda done, total: seen.append((done, total)),
    )
    assert one.contact_steps > 5
    assert one.coordinates.shape[1] == 4
    assert_same(one, many, 1e-14)  # output is turned into motion by products of another size
    assert_same(many, twin, HARD)  # blows carry on a multiple of what they differ by, here too
    assert seen[:100] == [(n, 100) for n in range(1, 101)]


# --- failures -------------------------------------------------------------------------------------------------


def test_what_was_computed_survives_a_divergence():
    loads = loads_of()
    force = loads.force.copy()
    force[300:] = np.inf
    with pytest.raises(Diverged, match=r"t = 0\.06 s: shorten the step") as caught:
        simulate(driven(), gaps_between(), replace(loads, force=force), HHT(), OutputRequest(OBSERVED))
    history = caught.value.history
    assert isinstance(caught.value, NumericalError)
    assert history.time.size == 300
    assert history.displacement.shape == (300, 3)
    assert np.isfinite(history.energy).all()


def test_damping_that_couples_modes_is_told_apart():
    system = driven()
    mixed = replace(system, damping=Damping(0.0, 0.0, None, np.ones((system.n, 1)), np.ones(1)))
    assert not is_modal(mixed)
    with pytest.raises(InputError, match="diagonal"):
        modal_matrices(mixed)


def test_samples_must_be_whole_steps():
    with pytest.raises(InputError, match="multiple of 3"):
        simulate(driven(), gaps_between(), loads_of(), HHT(), OutputRequest(OBSERVED), substeps=3)
