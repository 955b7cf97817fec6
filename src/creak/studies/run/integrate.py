"""The integrator that a study asks for: exact flow, flights, or a forced step and what that can carry."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.condensed import step_limited_stiffness
from creak.dynamics.diagonal import is_modal
from creak.dynamics.flight.contact_steps import IN_CONTACT, steps_in_contact
from creak.dynamics.flight.stepper import FlightStepper
from creak.dynamics.flow.coupled import MOST
from creak.dynamics.flow.march import SAMPLES, simulate_flow, with_springs
from creak.dynamics.flow.resolution import SETTLED
from creak.dynamics.flow.unhindered import Silent, gaps_without_contact
from creak.dynamics.history import History
from creak.dynamics.instant import Keeper
from creak.dynamics.loads import Loads, refined
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.simulate import CondensedStepper, march, simulate
from creak.linalg.diagonal import Diagonal
from creak.reduction.diagonal import diagonalise
from creak.signals.spectra import largest
from creak.studies.prepare.marching import Marching
from creak.verify.events import Event

Report = Callable[[int, int], None]
SHARE = 0.1
"""Longest step as a share of the shortest event."""


def integrate(
    marching: Marching,
    system: System,
    gaps: GapOperator,
    asked: OutputRequest,
    progress: Report | None = None,
    keeper: Keeper | None = None,
) -> tuple[History, System, str]:
    """March a System through the study's loads; the history, the System as it was marched, and how in a few words.

    Without a forced scheme reduced Systems are marched by exact flow (`flowing`), all others by `_stepped`; with one
    all Systems take its condensed steps.

    Parameters
    ----------
    keeper : takes the state of a march that goes instant by instant, or gives one back; compiled ones know none.
    """
    table = marching.table
    if table.exact:
        flows, why_not = flowing(system)
        if flows is not None:
            history = simulate_flow(
                flows, gaps, marching.loads, asked, resolution=marching.resolution, progress=progress
            )
            return history, flows, f"exact flow, steps near contact from {shortest_step(history):.2g} s"
        history, system, how = _stepped(marching, system, gaps, asked, progress, keeper)
        return history, system, f"{how}{why_not}"
    stepper = CondensedStepper(system, gaps, marching.loads, marching.scheme, table.substeps)
    history = march(stepper, asked, progress, keeper)
    name = "generalised-alpha" if table.integrator == "generalised-alpha" else "HHT-alpha"
    return history, system, name if table.substeps == 1 else f"{name}, {table.substeps} substeps near contact"


def flowing(system: System) -> tuple[System | None, str]:
    """A System in the modes that exact flow needs, or None and, of a reduced one, why not, in a few words.

    Damping that couples the modes (materials with their own, dashpots, point masses) is carried by complex modes. An
    unreduced System is left to a scheme of another kind, as what verifies should be.
    """
    if is_modal(system):
        return system, ""
    if sp.issparse(system.M) and not np.any(system.coordinates < 0):
        return None, ""
    diagonal = isinstance(system.M, Diagonal)
    count = system.coupled if diagonal else system.n
    if count > MOST:
        return None, f"; no exact flow: damping couples {count} modes (at most {MOST})"
    modal = system if diagonal else diagonalise(system)
    if np.any(modal.M.diagonal() <= 0.0):
        return None, "; no exact flow: damping couples modes, and some coordinates have no mass"
    return modal, ""


def sprung(marching: Marching, system: System, gaps: GapOperator) -> GapOperator:
    """Hard channels with the springs of a reduced System's march, so that an unreduced one meets the same contact."""
    flows = flowing(system)[0] if marching.table.exact else None
    return gaps if flows is None else with_springs(flows, gaps, marching.loads, marching.resolution)


def shortest_step(history: History) -> float:
    """s between two instants of a history."""
    return float(np.diff(history.time).min(initial=np.inf))


def _stepped(
    marching: Marching,
    system: System,
    gaps: GapOperator,
    asked: OutputRequest,
    progress: Report | None,
    keeper: Keeper | None,
) -> tuple[History, System, str]:
    parts, springs = steps_in_contact(system, gaps, marching.table.step, marching.resolution)
    like = None if keeper is None or keeper.saved is None else keeper.saved.stepper
    stepper = FlightStepper(system, springs, marching.divided(parts), IN_CONTACT, parts, like=like)
    history = march(stepper, asked, progress, keeper)
    h = stepper.loads.step
    how = f"flights of order {stepper.rule.order} of {stepper.stride * h:.2g} s{stepper.because}"
    return history, system, f"{how}, generalised-alpha of {h:.2g} s in contact"


def simulate_settled(
    system: System,
    gaps: GapOperator,
    loads: Loads,
    asked: OutputRequest,
    progress: Report | None = None,
) -> History:
    """A System through sampled loads at the default accuracy; a step of the loads is a flight step."""
    flows, _ = flowing(system)
    if flows is not None:
        return simulate_flow(flows, gaps, refined(loads, SAMPLES), asked, progress=progress)
    parts, springs = steps_in_contact(system, gaps, loads.step, SETTLED)
    return march(FlightStepper(system, springs, refined(loads, parts), IN_CONTACT, parts), asked, progress)


def linear_gaps(marching: Marching, contacts: GapOperator, system: System, progress: Report | None = None) -> Silent:
    """Gaps of the contacts' channels without any force, on a small System."""
    silent, nothing = contacts.without_force(), np.zeros(0, dtype=np.int64)
    table, loads = marching.table, marching.loads
    every = loads.n_step // table.substeps
    flows = flowing(system)[0] if table.exact else None
    if flows is not None:
        return gaps_without_contact(flows, silent, loads, progress)
    gap = simulate(
        system,
        silent,
        loads,
        marching.scheme,
        OutputRequest(nothing, every),
        substeps=table.substeps,
        progress=progress,
    ).gap
    lowest = -largest(-gap)
    return Silent(gap, lowest, lowest)


def limited(
    marching: Marching, coords: FloatArray, system: System, unit: str, gaps: GapOperator
) -> tuple[GapOperator, list[str]]:
    """Channels with automatic penalties lowered to what a forced step resolves, and a note of it.

    Parameters
    ----------
    coords : (n_node, 3). system : of the unreduced model. unit : of stiffness.
    """
    if marching.table.exact:
        return gaps, []
    positions, step = coords[gaps.nodes_idx], marching.loads.step
    stiffness = step_limited_stiffness(system, gaps, positions, marching.scheme, step)
    return gaps.with_stiffness(stiffness), _note_of_limit(gaps, stiffness, step, unit)


def _note_of_limit(gaps: GapOperator, stiffness: FloatArray, step: float, unit: str) -> list[str]:
    lowered = np.flatnonzero(stiffness < gaps.stiffness)
    if not lowered.size:
        return []
    before, after = (float(np.median(k[lowered])) for k in (gaps.stiffness, stiffness))
    return [
        f"automatic contact stiffness: {lowered.size} of {gaps.m} channels lowered to what a step of {step:g} s "
        f"resolves (median {before:.3g} to {after:.3g} {unit}); a shorter step gives harder contact and less "
        "penetration"
    ]


def step_warnings(marching: Marching, events: Sequence[Event]) -> list[str]:
    """A step longer than a tenth of the shortest contact event cannot follow its force."""
    step = marching.loads.step
    if marching.table.exact:
        return []
    short = min(events, key=lambda e: e.t_end - e.t_start, default=None)
    if short is None or step <= SHARE * (short.t_end - short.t_start):
        return []
    return [
        f"the step near contact, {step:g} s, is longer than a tenth of the shortest event "
        f"({short.t_end - short.t_start:.3g} s at {short.channel}, t = {short.t_start:.4g} s): its force is not "
        f"resolved; set [time] substeps, or compare with `creak run --converge`"
    ]
