"""What creak can tell of a study before it is run: load, channels, sizes, times."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from creak.arrays import FloatArray
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator, join
from creak.linalg.pencil import Pencil
from creak.model.faces import FACES, SHELL_FACETS
from creak.model.mesh import Model
from creak.model.skin import skin_of
from creak.model.units import METRES
from creak.reduction.health.free import error_bound
from creak.reduction.modal import one_share
from creak.studies.advise.contact import (
    Bounce,
    StepAdvice,
    bounces,
    numerical_damping,
    period_error,
    rounded_step,
)
from creak.studies.advise.evidence import Measured, measured, rule_of_thumb, step_evidence, steps
from creak.studies.advise.memory import Memory, memory, runs_of
from creak.studies.advise.size import (
    Counted,
    Sizes,
    UnreducedCost,
    assembly_modes_s,
    eigen_cube_s,
    sizes,
    sturm_counts,
    superelements_s,
    unreduced_cost,
)
from creak.studies.file.case import Course
from creak.studies.file.config import InterfaceTable, PrecheckTable, ReductionTable
from creak.studies.models.of_parts import reference_that_fits
from creak.studies.models.reduced import WHOLE, solves_for
from creak.studies.prepare.excitation import Excitation, excitation_of
from creak.studies.prepare.marching import output_every
from creak.studies.prepare.setup import Setup
from creak.studies.run.foretold import step_s
from creak.studies.run.precheck import with_linear_gaps
from creak.studies.sound.band import PER_MODE, finer_mesh, mesh_band
from creak.studies.sound.beyond import MOST_FORCES, SHARE, BeyondCost, beyond_cost

MULTIPLES = (5.0, 8.0, 11.0, 15.0)
"""f_max of fixed-interface modes over the excitation that are looked at."""
ASSEMBLY_MULTIPLES = (3.0, 7.0, 11.0)
"""The same for modes of the assembly."""

Progress = Callable[[str, int, int], None]
Bounces = Callable[[float], tuple[Bounce | None, Bounce | None]]
"""What contact does with a step, s: with automatic stiffness, and with that given in numbers."""


@dataclass(frozen=True)
class Channels:
    """Gap channels and the linear pre-check."""

    contacts: int
    kept: int
    closing: int | None
    """Contact channels whose gap falls to 0 in the linear run; None: the pre-check could not be made."""
    connectors: int
    smallest: float | None
    """Smallest gap of the linear run, length."""


@dataclass(frozen=True)
class Option:
    """One way to reduce."""

    method: str
    f_max: float
    multiple: float
    """Of the excitation's highest frequency."""
    retained: int
    modes: int
    unknowns: int
    offline_s: float
    step_s: float
    bound: float
    """No relative frequency error at the excitation's highest frequency is above (fixed-interface modes; 0: exact)."""
    rule: float
    """The rule of thumb for it (fixed-interface modes)."""
    door: Measured | None
    """What this multiple left on the door."""
    possible: bool = True
    """False: the retained dofs of some part do not hold it."""


@dataclass(frozen=True)
class ReducedStep:
    """What a step of the reduced model is made of beside its unknowns."""

    rows: int
    """Channel rows of the contact."""
    observed: float
    """Dofs written down, in the mean."""

    def seconds(self, unknowns: int) -> float:
        """What it takes with so many unknowns."""
        return step_s(unknowns, self.rows, self.observed)


@dataclass(frozen=True)
class SoundCost:
    """What it takes that sound is believed up to the end of a band."""

    band: float
    """Hz"""
    option: Option
    """Craig-Bampton with modes to twice the band, on the mesh as it is."""
    mesh: float
    """Hz up to which that mesh is fine enough."""
    finer: float
    """How many times shorter elements the band takes; 1: they are short enough."""
    solid: float
    """Share of the dofs that is in solids."""
    modes: float
    """Hz up to which the study's own modes are believed."""
    beyond: BeyondCost | None
    """What it takes that the unreduced model goes on from there; None: memory does not hold that, or it need not."""

    @property
    def dof_times(self) -> float:
        """How many times the dofs a mesh of such elements has: shells by the square, solids by the cube."""
        return (1.0 - self.solid) * self.finer**2 + self.solid * self.finer**3


@dataclass(frozen=True)
class Facts:
    """Everything that the advice rests on."""

    excitation: Excitation
    channels: Channels
    sizes: Sizes
    options: tuple[Option, ...]
    unreduced: UnreducedCost | None
    """None: memory does not hold a factor of the whole model."""
    steps: tuple[StepAdvice, ...]
    """Longest first."""
    end: float
    """s, length of the run."""
    gaps: GapOperator
    """Channels kept, connectors after contacts."""
    memory: Memory
    sound: SoundCost | None = None
    """Of the band that was asked for."""


def gather(setup: Setup, progress: Progress, band: float | None = None) -> Facts:
    """Assemble, find the assembly's modes, pre-check, count, time.

    Cost: that of the pre-check, four indefinite factorisations a part, three of the assembly, and for each step
    length two factorisations and a back-substitution per channel. No fixed-interface mode is computed.

    Parameters
    ----------
    band : Hz up to which sound is to be believed; None: that is not looked at.

    Raises
    ------
    InputError : anything wrong in the study or the deck.
    OutOfMemory : memory holds neither a factor of the whole model nor those of its parts, or the study needs the whole.
    """
    c = setup.study.config
    setup = setup.with_tables(precheck=c.precheck.model_copy(update={"enabled": True}))
    excitation = excitation_of(setup.study.driving, setup.loads, c.verification.mac_f_max)
    by_parts = setup.with_tables(reduction=_without_the_whole(c.reduction)).unproven
    reference = reference_that_fits(by_parts.reduction, by_parts.takes_whole, progress)
    setup = setup if reference.of_parts is None else by_parts
    c, reduction, course = setup.study.config, setup.reduction, setup.study.course
    marching, f = setup.marching, excitation.frequency
    reference = with_linear_gaps(c.precheck, reduction, marching, reference, progress)
    gaps, channels = _channels(setup.contacts, setup.connectors, c.precheck, reference.linear_gaps)
    reference.release()
    fixed = sorted({*(m * f for m in MULTIPLES), reduction.band.f_max})
    heard = [] if band is None else [PER_MODE * band]
    found = sizes(reduction, reference, gaps, sorted({*fixed, *heard}), progress)
    counted, cost = None, None
    if reference.of_parts is None:
        # from the second multiple on no lower than the verification's spectra
        low, *others = (m * f for m in ASSEMBLY_MULTIPLES)
        own = [reduction.band.f_max] if c.reduction.method == WHOLE else []
        wanted = sorted({low, *(max(x, c.verification.f_max) for x in others), *own})
        counted = _assembly(reference.system, wanted, progress)
        cost = unreduced_cost(reference.system, marching.scheme, c.time.step, gaps.m)
    step = ReducedStep(gaps.m + 2 * gaps.rubbing, 6.0 * setup.watch.nodes.size / output_every(course))
    options = _options(found, counted, fixed, f, step)
    bounce: Bounces | None = None
    if gaps.m and cost is not None and not c.time.exact:
        bounce = partial(bounces, reference.system, gaps, setup.model.nodes.coords[gaps.nodes_idx], marching.scheme)
    end = float(setup.loads.time[-1])
    steps = _steps(course, end, f, max(o.step_s for o in options), cost, bounce, progress)
    unknowns = found.unknowns(reduction.band.f_max)
    runs = runs_of(marching, setup.watch.nodes.size, step.rows, unreduced=c.runs_unreduced)
    taken = memory(reduction, reference, counted, found.parts, unknowns, runs)
    sound = None
    if band is not None:
        option = _by_parts(found, PER_MODE * band, f, step, eigen_cube_s())
        modes_end, beyond = reduction.band.f_max / PER_MODE, None
        if reference.of_parts is None and modes_end < band:
            kept = _by_parts(found, reduction.band.f_max, f, step, eigen_cube_s())
            columns = min(step.rows, MOST_FORCES) + max(1, len(c.listener))
            most = SHARE * solves_for(kept.retained, kept.modes)
            beyond = beyond_cost(reference.system, one_share(setup.structure.modal), columns, (modes_end, band), most)
        sound = _sound(setup.model, METRES[c.model.units], band, option, modes_end, beyond)
    return Facts(
        excitation=excitation,
        channels=channels,
        sizes=found,
        options=options,
        unreduced=cost,
        steps=steps,
        end=end,
        gaps=gaps,
        memory=taken,
        sound=sound,
    )


def _without_the_whole(table: ReductionTable) -> ReductionTable:
    """[reduction] without what takes a factor of the whole model and advice may change (`choice`)."""
    changed: dict[str, Any] = {"method": "craig-bampton"} if table.method in ("none", WHOLE) else {}
    if table.interface.type == "participation":
        changed["interface"] = InterfaceTable(type="full")
    return table.model_copy(update=changed)


def _channels(
    contacts: GapOperator, connectors: GapOperator, table: PrecheckTable, smallest: FloatArray | None
) -> tuple[GapOperator, Channels]:
    """Those that the gaps (m,) of a linear run let close; None: there was no such run."""
    if smallest is None:
        return join([contacts, connectors]), Channels(contacts.m, contacts.m, None, connectors.m, None)
    keep = np.flatnonzero(smallest <= table.near(contacts.gap0))
    closing = int(np.count_nonzero(smallest <= 0.0))
    found = Channels(contacts.m, int(keep.size), closing, connectors.m, float(smallest.min()))
    return join([contacts.select(keep), connectors]), found


def _assembly(system: System, frequencies: list[float], progress: Progress) -> Counted:
    """Modes of the whole model below each f_max that is looked at."""
    what = "count modes of the assembly"
    progress(what, 0, 1)
    counted = sturm_counts(Pencil(system.K, system.M), frequencies)
    progress(what, 1, 1)
    return counted


def _options(
    found: Sizes, counted: Counted | None, fixed: list[float], f: float, step: ReducedStep
) -> tuple[Option, ...]:
    """Ways to reduce; those that take modes of the whole where these were counted."""
    rows, cube = step.rows, eigen_cube_s()
    out = [_by_parts(found, f_max, f, step, cube) for f_max in fixed]
    if counted is None:
        return tuple(out)
    for f_max, modes in counted.below.items():
        out.append(
            Option(
                method=WHOLE,
                f_max=f_max,
                multiple=f_max / f,
                retained=rows,
                modes=modes,
                unknowns=modes + rows,
                offline_s=assembly_modes_s(counted, f_max, rows),
                step_s=step.seconds(modes + rows),
                bound=0.0,
                rule=0.0,
                door=measured(WHOLE, f_max / f),
            )
        )
    return tuple(out)


def _by_parts(found: Sizes, f_max: float, f: float, step: ReducedStep, cube: float) -> Option:
    n = found.unknowns(f_max)
    return Option(
        method="craig-bampton",
        f_max=f_max,
        multiple=f_max / f,
        retained=sum(p.boundary for p in found.parts),
        modes=sum(p.modes.below[f_max] for p in found.parts),
        unknowns=n,
        offline_s=superelements_s(found.parts, f_max, n, cube),
        step_s=step.seconds(n),
        bound=float(error_bound(np.array([f]), f_max)[0]),
        rule=rule_of_thumb(f_max / f),
        door=measured("craig-bampton", f_max / f),
        possible=all(p.held for p in found.parts),
    )


def _sound(model: Model, metre: float, band: float, option: Option, own: float, beyond: BeyondCost | None) -> SoundCost:
    """What a band that ends at `band` (Hz) takes, reduced by `option`; metre : units of length in one."""
    skin = skin_of(model)
    finer, solid = finer_mesh(model, skin, metre, band), _solid_share(model)
    return SoundCost(band, option, mesh_band(model, skin, metre), finer, solid, own, beyond)


def _solid_share(model: Model) -> float:
    """Of the nodes of elements, those of solids alone."""
    solid = [b.nodes_idx.ravel() for b in model.blocks if b.kind in FACES]
    shell = [b.nodes_idx.ravel() for b in model.blocks if b.kind in SHELL_FACETS]
    none = np.zeros(0, dtype=np.int64)
    solids, shells = np.unique(np.concatenate([none, *solid])), np.unique(np.concatenate([none, *shell]))
    alone = np.setdiff1d(solids, shells).size
    return alone / (alone + shells.size) if alone else 0.0


def _steps(
    course: Course,
    end: float,
    f: float,
    step_s: float,
    cost: UnreducedCost | None,
    bounce: Bounces | None,
    progress: Progress,
) -> tuple[StepAdvice, ...]:
    """Forced steps up to `end` (s), of which a reduced one takes at most `step_s`."""
    wanted = {float(f"{h:.9g}") for h in (course.time.step, *(step_for(course, s.per_period * f) for s in steps()))}
    scheme, out = course.time.scheme, []
    for k, h in enumerate(sorted(wanted, reverse=True)):
        progress("contact against the step", k, len(wanted))
        auto, given = (None, None) if bounce is None else bounce(h)
        n, angle = round(end / h), 2.0 * np.pi * f * h
        evidence = step_evidence(1.0 / (f * h))
        words = "coarser than any measured" if evidence is None else evidence.hht
        out.append(
            StepAdvice(
                step=h,
                steps=n,
                per_period=1.0 / (f * h),
                period_error=period_error(scheme, angle),
                damping=numerical_damping(scheme, angle),
                automatic=auto,
                fixed=given,
                reduced_s=n * step_s,
                unreduced_s=np.inf if cost is None else cost.run_s(n),
                hht=words,
            )
        )
    progress("contact against the step", len(wanted), len(wanted))
    return tuple(out)


def step_for(course: Course, rate: float) -> float:
    """A round step no longer than 1 / rate (s) that divides the study's output intervals."""
    table, own = course.output, course.time.step
    intervals = [x for x in (table.interval, table.field_interval) if x is not None]
    if not intervals:
        return rounded_step(1.0 / rate)
    shortest = min(intervals)
    if len(intervals) == 2:
        shortest = own * output_every(course) if table.interval == shortest else own
    return float(shortest / np.ceil(shortest * rate * (1.0 - 1e-9)))
