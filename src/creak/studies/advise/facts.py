"""What creak can tell of a study before it is run: load, channels, sizes, times."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from creak.contact.gap_operator import GapOperator, join
from creak.dynamics.scheme import Scheme
from creak.linalg.pencil import Pencil
from creak.model.mesh import Model
from creak.model.shell_facets import SHELL_FACETS
from creak.model.skin import skin_of
from creak.model.solid_faces import FACES
from creak.model.units import METRES
from creak.reduction.health.estimate import error_bound
from creak.studies.advise.contact import (
    StepAdvice,
    bounces,
    numerical_damping,
    period_error,
    rounded_step,
)
from creak.studies.advise.cost import (
    UnreducedCost,
    assembly_modes_s,
    eigen_cube_s,
    reduced_step_s,
    superelements_s,
    unreduced_cost,
)
from creak.studies.advise.evidence import Measured, measured, rule_of_thumb, step_evidence, steps
from creak.studies.advise.memory import Memory, memory
from creak.studies.advise.size import Counted, Sizes, sizes, sturm_counts
from creak.studies.file.config import InterfaceTable
from creak.studies.models.of_parts import reference_that_fits
from creak.studies.models.outlines import assembled
from creak.studies.models.reduced import WHOLE
from creak.studies.models.reference import ReferenceModel
from creak.studies.prepare.excitation import Excitation, excitation_of
from creak.studies.prepare.output_steps import output_every
from creak.studies.prepare.setup import Setup
from creak.studies.run.integrate import scheme_of
from creak.studies.run.precheck import linear_gaps
from creak.studies.sound.band import PER_MODE, finer_mesh, mesh_band

MULTIPLES = (5.0, 8.0, 11.0, 15.0)
"""f_max of fixed-interface modes over the excitation that are looked at."""
ASSEMBLY_MULTIPLES = (3.0, 7.0, 11.0)
"""The same for modes of the assembly."""

Progress = Callable[[str, int, int], None]


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
    setup = setup.with_tables(precheck=setup.study.config.precheck.model_copy(update={"enabled": True}))
    excitation = excitation_of(setup.study.driving, setup.loads, setup.study.config.verification.mac_f_max)
    by_parts = _without_the_whole(setup)
    reference = reference_that_fits(by_parts, assembled(setup.structure, progress), progress)
    setup = setup if reference.of_parts is None else by_parts
    scheme = scheme_of(setup.study.config.time)
    gaps, channels = _channels(setup, reference, scheme, progress)
    reference.release()
    f, c = excitation.frequency, setup.study.config
    fixed = sorted({*(m * f for m in MULTIPLES), setup.f_max})
    heard = [] if band is None else [PER_MODE * band]
    found = sizes(setup, reference, gaps, sorted({*fixed, *heard}), progress)
    counted = None if reference.of_parts else _assembly(setup, reference, f, progress)
    options = _options(setup, found, counted, fixed, f, gaps)
    cost = None if reference.of_parts else unreduced_cost(reference.system, scheme, c.time.step, gaps.m)
    steps = _steps(setup, reference, gaps, scheme, f, options, cost, progress)
    taken = memory(setup, reference, counted, found.parts, found.unknowns(setup.f_max), gaps.m + 2 * gaps.rubbing)
    end = float(setup.loads.time[-1])
    sound = None if band is None else _sound(setup, found, band, f, gaps)
    return Facts(excitation, channels, found, options, cost, steps, end, gaps, taken, sound)


def _without_the_whole(setup: Setup) -> Setup:
    """The study without what takes a factor of the whole model and advice may change (`choice`)."""
    c = setup.study.config
    table: dict[str, Any] = {"method": "craig-bampton"} if c.reduction.method in ("none", WHOLE) else {}
    if c.reduction.interface.type == "participation":
        table["interface"] = InterfaceTable(type="full")
    return setup.with_tables(
        reduction=c.reduction.model_copy(update=table), reference=c.reference.model_copy(update={"run": "none"})
    )


def _channels(
    setup: Setup, reference: ReferenceModel, scheme: Scheme, progress: Progress
) -> tuple[GapOperator, Channels]:
    contacts = setup.contacts
    others = setup.connectors.m
    if contacts.m == 0 or reference.stiffness is None:
        return join([contacts, setup.connectors]), Channels(contacts.m, contacts.m, None, others, None)
    smallest = linear_gaps(setup, reference, scheme, progress)
    keep = np.flatnonzero(smallest <= setup.study.config.precheck.near(contacts.gap0))
    closing = int(np.count_nonzero(smallest <= 0.0))
    found = Channels(contacts.m, int(keep.size), closing, others, float(smallest.min()))
    return join([contacts.select(keep), setup.connectors]), found


def _assembly(setup: Setup, reference: ReferenceModel, f: float, progress: Progress) -> Counted:
    """Modes of the whole model below each f_max that is looked at."""
    what = "count modes of the assembly"
    progress(what, 0, 1)
    counted = sturm_counts(Pencil(reference.system.K, reference.system.M), _whole_frequencies(setup, f))
    progress(what, 1, 1)
    return counted


def _whole_frequencies(setup: Setup, f: float) -> list[float]:
    """f_max for modes of the assembly: the multiples, from the second on no lower than the verification's spectra."""
    c = setup.study.config
    low, *others = (m * f for m in ASSEMBLY_MULTIPLES)
    own = [setup.f_max] if c.reduction.method == WHOLE else []
    return sorted({low, *(max(x, c.verification.f_max) for x in others), *own})


def _options(
    setup: Setup, found: Sizes, counted: Counted | None, fixed: list[float], f: float, gaps: GapOperator
) -> tuple[Option, ...]:
    """Ways to reduce; those that take modes of the whole where these were counted."""
    rows, cube = gaps.m + 2 * gaps.rubbing, eigen_cube_s()
    observed = 6.0 * setup.watched.size / output_every(setup.study.course)
    out = [_by_parts(found, f_max, f, rows, cube, observed) for f_max in fixed]
    if counted is None:
        return tuple(out)
    for f_max, modes in counted.below.items():
        out.append(
            Option(
                WHOLE,
                f_max,
                f_max / f,
                rows,
                modes,
                modes + rows,
                assembly_modes_s(counted, f_max, rows),
                reduced_step_s(modes + rows, rows, observed),
                0.0,
                0.0,
                measured(WHOLE, f_max / f),
            )
        )
    return tuple(out)


def _by_parts(found: Sizes, f_max: float, f: float, rows: int, cube: float, observed: float) -> Option:
    n = found.unknowns(f_max)
    return Option(
        "craig-bampton",
        f_max,
        f_max / f,
        sum(p.boundary for p in found.parts),
        sum(p.modes.below[f_max] for p in found.parts),
        n,
        superelements_s(found.parts, f_max, n, cube),
        reduced_step_s(n, rows, observed),
        float(error_bound(np.array([f]), f_max)[0]),
        rule_of_thumb(f_max / f),
        measured("craig-bampton", f_max / f),
        all(p.held for p in found.parts),
    )


def _sound(setup: Setup, found: Sizes, band: float, f: float, gaps: GapOperator) -> SoundCost:
    """What a band that ends at `band` (Hz) takes."""
    rows, observed = gaps.m + 2 * gaps.rubbing, 6.0 * setup.watched.size / output_every(setup.study.course)
    model, metre = setup.model, METRES[setup.study.config.model.units]
    skin = skin_of(model)
    option = _by_parts(found, PER_MODE * band, f, rows, eigen_cube_s(), observed)
    finer, solid = finer_mesh(model, skin, metre, band), _solid_share(model)
    return SoundCost(band, option, mesh_band(model, skin, metre), finer, solid)


def _solid_share(model: Model) -> float:
    """Of the nodes of elements, those of solids alone."""
    solid = [b.nodes_idx.ravel() for b in model.blocks if b.kind in FACES]
    shell = [b.nodes_idx.ravel() for b in model.blocks if b.kind in SHELL_FACETS]
    none = np.zeros(0, dtype=np.int64)
    solids, shells = np.unique(np.concatenate([none, *solid])), np.unique(np.concatenate([none, *shell]))
    alone = np.setdiff1d(solids, shells).size
    return alone / (alone + shells.size) if alone else 0.0


def _steps(
    setup: Setup,
    reference: ReferenceModel,
    gaps: GapOperator,
    scheme: Scheme,
    f: float,
    options: tuple[Option, ...],
    cost: UnreducedCost | None,
    progress: Progress,
) -> tuple[StepAdvice, ...]:
    own = setup.study.config.time.step
    wanted = {float(f"{h:.9g}") for h in (own, *(step_for(setup, s.per_period * f) for s in steps()))}
    largest, end = max(options, key=lambda o: o.step_s), float(setup.loads.time[-1])
    positions, out = setup.model.nodes.coords[gaps.nodes_idx], []
    for k, h in enumerate(sorted(wanted, reverse=True)):
        progress("contact against the step", k, len(wanted))
        some = gaps.m and cost is not None and not setup.study.config.time.exact
        auto, given = bounces(reference.system, gaps, positions, scheme, h) if some else (None, None)
        n, angle = round(end / h), 2.0 * np.pi * f * h
        evidence = step_evidence(1.0 / (f * h))
        words = "coarser than any measured" if evidence is None else evidence.hht
        out.append(
            StepAdvice(
                h,
                n,
                1.0 / (f * h),
                period_error(scheme, angle),
                numerical_damping(scheme, angle),
                auto,
                given,
                n * largest.step_s,
                np.inf if cost is None else cost.run_s(n),
                words,
            )
        )
    progress("contact against the step", len(wanted), len(wanted))
    return tuple(out)


def step_for(setup: Setup, rate: float) -> float:
    """A round step no longer than 1 / rate (s) that divides the study's output intervals."""
    table, own = setup.study.config.output, setup.study.config.time.step
    intervals = [x for x in (table.interval, table.field_interval) if x is not None]
    if not intervals:
        return rounded_step(1.0 / rate)
    shortest = min(intervals)
    if len(intervals) == 2:
        shortest = own * output_every(setup.study.course) if table.interval == shortest else own
    return float(shortest / np.ceil(shortest * rate * (1.0 - 1e-9)))
