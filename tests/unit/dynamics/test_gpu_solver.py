"""Unreduced runs with factors on a GPU, a stand-in here, against those of the cores; where the cores take over."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from creak.assembly.part import Rayleigh
from creak.dynamics.cuda import solver
from creak.dynamics.cuda.solver import Solver, check_solver
from creak.dynamics.flight.contact_steps import IN_CONTACT, steps_in_contact
from creak.dynamics.flight.stepper import FlightStepper
from creak.dynamics.history import History
from creak.dynamics.loads import refined
from creak.dynamics.scheme import HHT
from creak.dynamics.simulate import march, simulate
from creak.dynamics.step_matrix import PencilFactor, on_cores
from creak.errors import NumericalError
from creak.linalg.cudss import no_cudss
from creak.linalg.modes import modes
from creak.reduction.modal import with_modal_damping
from helpers_core import chain, system_of, time_axis
from helpers_cudss import stand_in
from helpers_gap import cantilevers, gaps_between, multisine_base
from helpers_refusal import refusal

STEP, END = 5e-4, 0.1
GAPS = gaps_between(0.02, 1e5)
FACTORS = 8
"""Four that tell the length of contact steps, that of contact steps, a real and two complex ones of flights."""


@pytest.fixture
def gpu(monkeypatch):
    yield from stand_in(monkeypatch)


@pytest.fixture(scope="module")
def beams():
    return cantilevers(Rayleigh(5.0, 1e-6))


def flown(system, maker=on_cores) -> History:
    """As a study runs it."""
    parts, springs = steps_in_contact(system, GAPS, STEP, 0.1, maker)
    loads = multisine_base(time_axis(END, STEP), 5.0, 60.0, 0.05)
    stepper = FlightStepper(system, springs, refined(loads, parts), IN_CONTACT, parts, maker=maker)
    return march(stepper, np.array([49, 103]))


@pytest.fixture(scope="module")
def on_the_cores(beams):
    history = flown(beams)
    assert history.contact_steps > 20
    return history


def assert_same(found: History, expected: History) -> None:
    for name in ("displacement", "gap", "force"):
        a, b = getattr(found, name), getattr(expected, name)
        np.testing.assert_allclose(a, b, atol=1e-8 * np.abs(b).max(), rtol=0.0, err_msg=name)


def test_flights_and_contact_are_those_of_the_cores(beams, on_the_cores, gpu):
    made = Solver("gpu")
    found = flown(beams, made)
    assert_same(found, on_the_cores)
    assert found.residual < 1e-8
    assert made.told() == (f"factors on the GPU: {FACTORS} (a stand-in)",)
    assert gpu.kinds == [("SPD", "float64")] * 6 + [("SYMMETRIC", "complex128")] * 2
    assert gpu.solves >= found.time.size
    # Those that told the length of the steps are not there any more, nor are all at the end.
    assert gpu.held == 0.0
    assert gpu.most > 0.0


def test_modal_damping_and_a_forced_scheme(beams, gpu):
    """Blocks of columns, one factor of whole steps and one of divided ones."""
    found = modes(beams.K, beams.M, count=4)
    damped = with_modal_damping(cantilevers(Rayleigh(0.0, 0.0)), found, np.zeros((beams.n, 1)), 0.02)
    loads = multisine_base(time_axis(END, 1e-4), 5.0, 60.0, 0.05)
    made, everything = Solver("gpu"), np.arange(103)
    there, here = (
        simulate(damped, GAPS, loads, HHT(), observed=everything, substeps=5, **more) for more in ({"maker": made}, {})
    )
    assert here.force.any()
    assert_same(there, here)
    assert made.told() == ("factors on the GPU: 2 (a stand-in)",)


def test_what_the_device_does_not_hold_stays_on_the_cores(beams, on_the_cores, gpu):
    flown(beams, Solver("gpu"))
    gpu.room, gpu.most = 0.7 * gpu.most, 0.0  # of the four that a run keeps two fit
    made = Solver("gpu")
    assert_same(flown(beams, made), on_the_cores)
    assert made.told() == (
        f"factors on the GPU: {FACTORS - 2} (a stand-in)",
        "factors on the cores: 2 (its memory is too small)",
    )
    assert 0.0 < gpu.most <= gpu.room


def test_a_device_that_is_lost_in_the_run_leaves_it_to_the_cores(beams, on_the_cores, gpu):
    gpu.fails_after = 200
    made = Solver("gpu")
    assert_same(flown(beams, made), on_the_cores)
    there, here = made.told()
    assert there == f"factors on the GPU: {FACTORS} (a stand-in)"
    assert here.startswith("factors on the cores: ")
    assert here.endswith("(the GPU failed in the run, EXECUTION_FAILED (5))")


def test_a_singular_matrix_is_refused_as_the_cores_refuse_it(gpu):
    M, K = np.diag([1.0, 0.0]), np.diag([100.0, 0.0])
    said = []
    for maker in (on_cores, Solver("gpu")):
        with pytest.raises(NumericalError, match=r"row 1|singular") as error:
            PencilFactor(system_of(M, K), 1.0, 0.1, 0.01, maker)
        said.append((type(error.value), str(error.value)))
    assert said[0] == said[1]
    assert gpu.held == 0.0


def test_by_itself_large_matrices_alone_go_there(gpu, monkeypatch):
    system = system_of(*chain(40))
    b = np.ones(40)
    for least, told in ((41, ()), (40, ("factors on the GPU: 1 (a stand-in)",))):
        monkeypatch.setattr(solver, "LARGE", least)
        made = Solver("auto")
        np.testing.assert_allclose(
            PencilFactor(system, 1.0, 0.1, 0.01, made).solve(b),
            PencilFactor(system, 1.0, 0.1, 0.01).solve(b),
            rtol=1e-12,
        )
        assert made.told() == told
    none = Solver("cpu")
    PencilFactor(system, 1.0, 0.1, 0.01, none)
    assert none.told() == ()


def test_dense_matrices_stay_on_the_cores(gpu):
    made = Solver("gpu")
    PencilFactor(system_of(*chain(40), sparse=False), 1.0, 0.1, 0.01, made)
    assert (made.told(), gpu.kinds) == ((), [])


@pytest.fixture
def no_device(gpu, monkeypatch):
    """nvmath-python is installed, and there is nothing that it could use."""

    def none(*_, **__):
        raise RuntimeError('"cuda" is an NVIDIA driver library and can only be found via system search.')

    monkeypatch.setattr(sys.modules["nvmath.sparse.advanced"], "DirectSolver", none)
    no_cudss.cache_clear()


def test_without_a_device_the_cores_solve_and_a_note_says_why(no_device, monkeypatch):
    monkeypatch.setattr(solver, "LARGE", 40)
    made = Solver("auto")
    PencilFactor(system_of(*chain(40)), 1.0, 0.1, 0.01, made)
    (said,) = made.told()
    assert said.startswith('factors on the cores: 1 (cuDSS cannot be used: "cuda" is an NVIDIA driver library')


def test_without_the_package_nothing_is_told(monkeypatch):
    monkeypatch.setattr(solver, "LARGE", 40)
    monkeypatch.setattr(solver, "no_cudss", lambda: "nvmath-python is not installed")
    made = Solver("auto")
    PencilFactor(system_of(*chain(40)), 1.0, 0.1, 0.01, made)
    assert made.told() == ()


def test_a_gpu_that_is_asked_for_and_not_there_is_refused(no_device):
    check_solver("auto")
    check_solver("cpu")
    told = str(refusal(check_solver, "gpu"))
    assert told.startswith('device gpu: cuDSS cannot be used: "cuda" is an NVIDIA driver library')
    assert "creak[gpu]" in told
    assert told.endswith("Or: cpu.")
