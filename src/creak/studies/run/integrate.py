"""The integrator that a study asks for: exact flow, flights, or a forced step."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypedDict

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.diagonal import is_modal
from creak.dynamics.flight.contact_steps import IN_CONTACT, steps_in_contact
from creak.dynamics.flight.stepper import FlightStepper, simulate_high_order
from creak.dynamics.flow.coupled import MOST, can_couple
from creak.dynamics.flow.march import SAMPLES, simulate_flow
from creak.dynamics.flow.resolution import SETTLED, Resolution, finer
from creak.dynamics.history import History
from creak.dynamics.instant import Keeper
from creak.dynamics.loads import Loads, refined
from creak.dynamics.record.watch import Watched
from creak.dynamics.scheme import HHT, Scheme, generalised_alpha
from creak.dynamics.simulate import CondensedStepper, march, simulate
from creak.reduction.diagonal import in_own_modes
from creak.studies.file.config import TimeTable
from creak.studies.prepare.excitation import sample_loads, time_axis
from creak.studies.prepare.flight_steps import RESOLUTIONS
from creak.studies.prepare.setup import Setup
from creak.studies.run.kernels import needs_solver

Report = Callable[[int, int], None]


class Kept(TypedDict):
    """What each march is asked to keep, to look at and to tell, as its own arguments."""

    observed: IntArray
    output_every: int
    whole_at: IntArray
    watched: Watched | None
    progress: Report | None


def scheme_of(table: TimeTable) -> Scheme:
    """HHT-alpha or generalised-alpha."""
    return generalised_alpha(table.rho_inf) if table.integrator == "generalised-alpha" else HHT(table.alpha)


def integrate(
    setup: Setup,
    system: System,
    gaps: GapOperator,
    *,
    observed: IntArray,
    output_every: int,
    whole_at: IntArray,
    progress: Report | None = None,
    watched: Watched | None = None,
    keeper: Keeper | None = None,
) -> tuple[History, System, str]:
    """March a System through the study's loads; the history, the System as it was marched, and how in a few words.

    Without a forced scheme reduced Systems are marched by exact flow (`flowing`), all others by `_stepped`; with one
    all Systems take its condensed steps.

    Parameters
    ----------
    watched : what is looked at at every step, whatever is kept (`History.extremes`).
    keeper : takes the state of a march that goes instant by instant, or gives one back; compiled ones know none.
    """
    table = setup.study.config.time
    kept: Kept = {
        "observed": observed,
        "output_every": output_every,
        "whole_at": whole_at,
        "watched": watched,
        "progress": progress,
    }
    if table.exact:
        flows, why_not = flowing(system)
        if flows is not None:
            return _flown(setup, flows, gaps, kept)
        history, system, how = _stepped(setup, system, gaps, kept, keeper)
        return history, system, f"{how}{why_not}"
    stepper = CondensedStepper(system, gaps, setup.loads, scheme_of(table), table.substeps)
    history = march(stepper, **kept, keeper=keeper)
    name = "generalised-alpha" if table.integrator == "generalised-alpha" else "HHT-alpha"
    return history, system, name if table.substeps == 1 else f"{name}, {table.substeps} substeps near contact"


def flowing(system: System) -> tuple[System | None, str]:
    """A System in the modes that exact flow needs, or None and, of a reduced one, why not, in a few words.

    Damping that couples the modes (materials with their own, dashpots, point masses) is carried by complex modes. An
    unreduced System is left to a scheme of another kind, as what verifies should be.
    """
    if is_modal(system):
        return system, ""
    if not _is_reduced(system):
        return None, ""
    if system.n > MOST:
        return None, f"; no exact flow: damping couples {system.n} modes (at most {MOST})"
    modal = in_own_modes(system)
    if not can_couple(modal):
        return None, "; no exact flow: damping couples modes, and some coordinates have no mass"
    return modal, ""


def _flown(
    setup: Setup,
    system: System,
    gaps: GapOperator,
    kept: Kept,
) -> tuple[History, System, str]:
    history = simulate_flow(
        system,
        gaps,
        setup.loads,
        resolution=resolution_of(setup),
        **kept,
    )
    return history, system, f"exact flow, steps near contact from {shortest_step(history):.2g} s"


def resolution_of(setup: Setup) -> Resolution:
    """How finely contact is resolved."""
    return finer(RESOLUTIONS[setup.study.config.time.accuracy], setup.refined)


def shortest_step(history: History) -> float:
    """s between two instants of a history."""
    return float(np.diff(history.time).min(initial=np.inf))


def _stepped(
    setup: Setup,
    system: System,
    gaps: GapOperator,
    kept: Kept,
    keeper: Keeper | None,
) -> tuple[History, System, str]:
    parts, springs = steps_in_contact(system, gaps, setup.study.config.time.step, resolution_of(setup).stepped)
    like = None if keeper is None or keeper.saved is None else keeper.saved.stepper
    stepper = FlightStepper(system, springs, divided_loads(setup, parts), IN_CONTACT, parts, like=like)
    history = march(stepper, **kept, keeper=keeper)
    h = stepper.loads.step
    how = f"flights of order {stepper.rule.order} of {stepper.stride * h:.2g} s{stepper.because}"
    return history, system, f"{how}, generalised-alpha of {h:.2g} s in contact"


def simulate_settled(
    system: System,
    gaps: GapOperator,
    loads: Loads,
    *,
    observed: IntArray,
    output_every: int = 1,
    progress: Report | None = None,
) -> History:
    """A System through sampled loads at the default accuracy; a step of the loads is a flight step."""
    flows, _ = flowing(system)
    if flows is not None:
        return simulate_flow(
            flows, gaps, refined(loads, SAMPLES), observed=observed, output_every=output_every, progress=progress
        )
    parts, springs = steps_in_contact(system, gaps, loads.step, SETTLED.stepped)
    return simulate_high_order(
        system,
        springs,
        refined(loads, parts),
        IN_CONTACT,
        observed=observed,
        output_every=output_every,
        substeps=parts,
        progress=progress,
    )


def linear_run(setup: Setup, system: System, scheme: Scheme, progress: Report | None) -> History:
    """Of the contacts' channels without any force, on a small System; only gaps are kept."""
    silent, nothing = setup.contacts.without_force(), np.zeros(0, dtype=np.int64)
    table = setup.study.config.time
    every = setup.loads.n_step // table.substeps
    flows = flowing(system)[0] if table.exact else None
    if flows is not None:
        return simulate_flow(
            flows,
            silent,
            setup.loads,
            observed=nothing,
            output_every=every,
            progress=progress,
            solver=needs_solver(setup),
        )
    return simulate(
        system,
        silent,
        setup.loads,
        scheme,
        observed=nothing,
        output_every=every,
        substeps=table.substeps,
        progress=progress,
    )


def _is_reduced(system: System) -> bool:
    return not sp.issparse(system.M) or bool(np.any(system.coordinates < 0))


def divided_loads(setup: Setup, parts: int) -> Loads:
    """The loads with `parts` samples a step."""
    if parts == setup.study.config.time.substeps:
        return setup.loads
    return sample_loads(setup.model, setup.study.driving, time_axis(setup.study.driving, setup.study.course, parts))


def output_times(setup: Setup) -> FloatArray:
    """(n_step + 1,) ends of the whole steps."""
    return np.asarray(setup.loads.time[:: setup.study.config.time.substeps])
