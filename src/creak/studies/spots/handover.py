"""What the unreduced model takes over from the run of the reduced one: what both share, and states at some instants."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.flight.contact_steps import fewest_parts
from creak.dynamics.flow.march import SAMPLES, FlowStates, flow_states
from creak.dynamics.history import History
from creak.dynamics.loads import Loads
from creak.studies.findings.places import find_places
from creak.studies.models.alike import damped_alike, recovered_on
from creak.studies.models.reference import ReferenceModel
from creak.studies.prepare.flight_steps import RESOLUTIONS
from creak.studies.prepare.marching import Marching
from creak.studies.run.integrate import flowing
from creak.studies.run.job import ReducedRun
from creak.studies.spots.choose import BLOCKED, FEWEST, SHARE, STEP, chosen
from creak.verify.events import Event
from creak.verify.sides import sides

SEED = 1
"""Of what is drawn."""


@dataclass(frozen=True)
class Handover:
    """What the unreduced model needs of the reduced one's run."""

    unreduced: System
    reduced: System
    """As it was marched."""
    gaps: GapOperator
    """All channels of the run."""
    loads: Loads
    """`SAMPLES` of each flight step."""
    history: History
    """Of the reduced run."""
    merge: float | None
    f_max: float
    """Of the verification."""
    fewest: int
    """Contact steps in a flight step by default."""
    budget: float
    """Back-substitutions that the checks of events may take, and those of rubbing as many again."""

    @property
    def ends(self) -> FloatArray:
        """(n_step + 1,) of the flight steps, s."""
        return np.asarray(self.loads.time[::SAMPLES])

    @cached_property
    def sides(self) -> list[set[tuple[str, str]]]:
        """Contact and channel of each side: those that are left of some channels may be numbered otherwise."""
        return [{(self.gaps.group[j], self.gaps.names[j]) for j in own.tolist()} for own in sides(self.gaps)]


def handed_over(found: ReducedRun, reference: ReferenceModel) -> tuple[Handover | None, str]:
    """What the marches need, or why there are none."""
    setup, run, reduced = found.setup, found.run, found.reduced
    c = setup.study.config
    if not c.time.exact:
        return None, "a scheme was forced, which the unreduced model does not share"
    if run.stopped is not None:
        return None, "the run was stopped"
    if reference.of_parts is not None:
        return None, "memory does not hold a factor of the whole model"
    system, why = flowing(reduced.system)
    if system is None:
        return None, f"the reduced model was not marched by exact flow{why}"
    v = c.verification
    if np.any(reference.system.coordinates < 0):
        return None, "parts of the model are superelements from files, whose inside is not there"
    unreduced = damped_alike(setup.modal, setup.raised > 0, reference, reduced)
    fewest = fewest_parts(RESOLUTIONS[c.time.accuracy].stepped)
    budget = max(FEWEST / (unreduced.n + STEP), SHARE * BLOCKED * reduced.solves)
    handover = Handover(unreduced, system, found.gaps, setup.loads, run.history, v.merge, v.f_max, fewest, budget)
    return handover, ""


def ordered(found: ReducedRun, of: Handover) -> list[tuple[Event, str]]:
    """Events of each place of the reduced run in the order in which they are looked at."""
    return chosen(found.run.events, find_places(found, found.run), of.gaps, SEED)


def states_at(marching: Marching, of: Handover, at: list[int]) -> FlowStates:
    """States of the reduced run at the ends of some flight steps, by marching it again up to there."""
    return flow_states(of.reduced, of.gaps, of.loads, at, resolution=marching.resolution, solver=marching.solver)


def states_of(of: Handover, states: FlowStates, k: int, first: int) -> tuple[FloatArray, FloatArray]:
    """Displacement and velocity (n,) of the unreduced model at the k-th state, at the end of flight step `first`."""
    s = of.loads.support[:, SAMPLES * first]
    both = np.stack([states.coordinates[:, k], states.velocities[:, k]], axis=1)
    u, v = recovered_on(of.unreduced, of.reduced, both, s[:2].T).T
    return np.ascontiguousarray(u), np.ascontiguousarray(v)
