"""What a deck's own analysis step asks for: motion, loads, contact and time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError
from creak.model.constraints import Fixed
from creak.model.dofs import node_dofs

EVERY_NODE = "ALL NODES"
"""In `DynamicStep.output_sets`: all nodes of the structure, which no set of the deck is called."""

BASE = "BASE"
"""Name of all supports where they move together."""


@dataclass(frozen=True)
class Amplitude:
    """A function of time that scales boundary values and loads.

    tabular: linear between `points`, constant before and after. smooth step: between two points
    a_1 + (a_2 - a_1) x^3 (10 - 15 x + 6 x^2). periodic: mean + sum_n A_n cos(2 pi n f (t - start)) +
    B_n sin(2 pi n f (t - start)) from `start` on, the mean before.
    """

    name: str
    kind: str
    """tabular, smooth step or periodic."""
    points: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    """(k, 2) time, s, and value."""
    rounding: float = 0.25
    """tabular: share of the shorter interval at a point over which a corner of prescribed displacement or velocity
    becomes a parabola."""
    absolute: bool = False
    """Whether the values are the magnitudes themselves instead of factors on them."""
    frequency: float = 0.0
    """Hz"""
    start: float = 0.0
    """s"""
    mean: float = 0.0
    cosine: tuple[float, ...] = ()
    sine: tuple[float, ...] = ()
    where: str = ""


@dataclass(frozen=True)
class Prescribed:
    """Motion of one dof of some nodes: value times amplitude; the value is 1 where the amplitude is absolute."""

    nodes_idx: IntArray
    dof: int
    """1..6"""
    kind: str
    """displacement, velocity or acceleration."""
    value: float
    amplitude: str
    """Name in `DeckRun.amplitudes`; empty: none."""
    name: str
    """As the deck names the nodes."""
    where: str

    @property
    def labels(self) -> IntArray:
        return node_dofs(self.nodes_idx, (self.dof,))


@dataclass(frozen=True)
class PointLoad:
    """Force (moment) on one dof of each of some nodes: value times amplitude, as in `Prescribed`."""

    nodes_idx: IntArray
    dof: int
    value: float
    amplitude: str
    name: str
    where: str
    spread: bool = False
    """Whether it is a share of a pressure, which may act on held dofs too."""


@dataclass(frozen=True)
class StaticStep:
    """A linear static step before the modes, whose stress stiffens the structure."""

    keyword: str
    """As `Model.unread` lists it."""
    loads: tuple[PointLoad, ...]
    """Forces that keep their direction."""
    moved: tuple[Prescribed, ...]
    where: str


@dataclass(frozen=True)
class Interaction:
    """How the surfaces of a contact pair press and rub."""

    name: str
    law: str = "default"
    """default (hard, enforced as the kind of contact has it), hard, penalty, linear or tabular."""
    stiffness: float = 0.0
    """linear: pressure / length."""
    curve: tuple[tuple[float, float], ...] = ()
    """tabular: (overclosure, pressure), from (0, 0) on."""
    friction: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Static and kinetic coefficient, decay speed (length / time, 0: none)."""
    damping: float = 0.0
    """pressure time / length, while closed."""
    where: str = ""


@dataclass(frozen=True)
class SurfacePair:
    """Two surfaces that may touch."""

    secondary: str
    main: str
    interaction: str
    method: str
    """node-to-surface or surface-to-surface."""
    small_sliding: bool
    clearance: float | Mapping[int, float] | None = None
    """Instead of the geometric gap, length: of all nodes, or by row of a node."""
    where: str = ""


@dataclass(frozen=True)
class DeckContact:
    """What a deck says of contact, whichever step it acts in: for a study that is proposed."""

    interactions: Mapping[str, Interaction]
    pairs: tuple[SurfacePair, ...]
    everywhere: str = ""
    """Interaction of all that may touch (general contact); empty: none."""
    flaws: tuple[str, ...] = ()
    """What of it creak cannot use, and why."""
    apart: tuple[tuple[str, str], ...] = ()
    """Two surfaces that it keeps out of contact each; an empty name stands for all that there is."""


@dataclass(frozen=True)
class Stop:
    """One-sided stops between pairs of nodes: r = u_b - u_a along one line stays above `lower`, or below `upper`."""

    name: str
    first: IntArray
    """(n,) node rows a."""
    second: IntArray
    """(n,) node rows b."""
    dof: int
    """1..6"""
    lower: float | None
    upper: float | None
    stiffness: float
    """force / length, acts beyond the limit; inf: hard."""
    where: str = ""
    direction: tuple[float, float, float] | None = None
    """Unit vector of r, which then replaces `dof`."""
    friction: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """As of `Interaction`."""

    @property
    def closed(self) -> bool:
        """Whether it presses as the deck is drawn, or is about to."""
        return (self.lower is not None and self.lower >= 0.0) or (self.upper is not None and self.upper <= 0.0)

    @property
    def node_sets(self) -> dict[str, IntArray]:
        """Its two sides under the names that a study has them by."""
        return {f"{self.name}.A": self.first, f"{self.name}.B": self.second}


@dataclass(frozen=True)
class InModes:
    """What a step in modes (*MODAL DYNAMIC) says of them."""

    by_number: tuple[tuple[int, int, float], ...] = ()
    """First and last mode, from 1 on, and their share of critical damping; empty: the step gives none."""
    by_frequency: tuple[tuple[float, float], ...] = ()
    """Hz, rising, and share of critical damping of modes there: straight lines between, beyond them as at the ends."""
    rayleigh: tuple[float, float] | None = None
    """alpha, 1/s, and beta, s, instead of a share; None: the step gives none."""


@dataclass(frozen=True)
class DynamicStep:
    """A transient step: M a + C v + K u + contact = f from rest or from the initial velocity."""

    name: str
    where: str
    increment: float
    """s"""
    period: float
    """s"""
    direct: bool
    """Whether the deck asks for increments of constant size."""
    alpha: float | None
    """Of HHT; None: the deck gives none."""
    application: str
    """TRANSIENT FIDELITY, MODERATE DISSIPATION, or empty."""
    ramped: bool = False
    """Whether what has no amplitude grows linearly over the step."""
    fixed: tuple[Fixed, ...] = ()
    """All dofs held at zero in the step, those of the model data included."""
    moved: tuple[Prescribed, ...] = ()
    loads: tuple[PointLoad, ...] = ()
    output_sets: tuple[str, ...] = ()
    """Node sets whose motion the deck asks for."""
    places: Mapping[str, str] = field(default_factory=dict)
    """file:line of the data line, under `time`."""
    modes: InModes | None = None
    """Of a step in modes, which has no scheme and no increment of its own; None: it is implicit."""


@dataclass(frozen=True, eq=False)
class NodeTemperatures:
    """Temperatures of some nodes."""

    nodes_idx: IntArray
    """(k,)"""
    value: FloatArray
    """(k,)"""


@dataclass(frozen=True)
class StaticLoads:
    """What acts before the step and goes on through it: the run starts from the equilibrium under it."""

    gravity: tuple[float, float, float]
    """length / time^2, on all mass."""
    forces: tuple[PointLoad, ...]
    where: str
    temperature: NodeTemperatures | None = None
    """None: no heat acts."""
    moved: tuple[Prescribed, ...] = ()
    """Displacements of dofs that are held there."""
    flaw: InputError | None = None
    """Why creak cannot use these loads, raised where they are used."""


@dataclass(frozen=True)
class DeckRun:
    """The step of a deck that creak runs, with all that it refers to."""

    step: DynamicStep
    amplitudes: Mapping[str, Amplitude]
    """By name, upper case."""
    interactions: Mapping[str, Interaction]
    pairs: tuple[SurfacePair, ...]
    before: tuple[str, ...] = ()
    """Steps before it, none of which changes the state."""
    after: tuple[str, ...] = ()
    """Steps after it, which are not run."""
    stops: tuple[Stop, ...] = ()
    static: StaticLoads | None = None
    """None: the run starts without strain."""
