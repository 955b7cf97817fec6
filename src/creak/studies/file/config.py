"""The study file: what a TOML may say, with units and defaults."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, Tag, field_validator, model_validator

from creak.model.magnitude import LARGEST, SMALLEST


def _of_size(value: float) -> float:
    if abs(value) > LARGEST or 0.0 < abs(value) < SMALLEST:
        raise ValueError(f"is not between {SMALLEST:g} and {LARGEST:g} in size")
    return value


Size = AfterValidator(_of_size)
Finite = Annotated[float, Field(allow_inf_nan=False), Size]
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False), Size]
NonNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False), Size]
Dof = Literal["x", "y", "z", "rx", "ry", "rz"]
DOFS: tuple[Dof, ...] = ("x", "y", "z", "rx", "ry", "rz")


class Table(BaseModel):
    """A table of the study; unknown keys are errors. The texts below the keys are the descriptions of its schema."""

    model_config = ConfigDict(extra="forbid", frozen=True, str_strip_whitespace=True, use_attribute_docstrings=True)

    @field_validator("*")
    @classmethod
    def _no_zero_bytes(cls, value: Any) -> Any:
        """No file that creak writes can keep them."""
        texts = [value] if isinstance(value, str) else value if isinstance(value, dict | list) else []
        if any(isinstance(text, str) and "\0" in text for text in texts):
            raise ValueError("holds a zero byte (\\u0000)")
        return value


class ModelTable(Table):
    """[model]"""

    deck: str
    """Abaqus .inp or Nastran .bdf, .dat, .nas, relative to the study file."""
    units: Literal["mm-t-s", "m-kg-s"] = "mm-t-s"
    """Units of the deck and the study: length, mass, time. They label results; nothing is converted."""


class RayleighTable(Table):
    """C = alpha M + beta K."""

    alpha: NonNegative = 0.0
    """1/s"""
    beta: NonNegative = 0.0
    """s"""


class DampingTable(Table):
    """[damping]: replaces the deck's *DAMPING."""

    modal: Annotated[float, Field(ge=0.0, lt=1.0, allow_inf_nan=False)] | None = None
    """Fraction of critical of every mode of the reduced model; acts on the motion relative to the supports. The
    unreduced model has it up to the reduction's f_max (above 40,000 dofs the verification's), and from there on in
    proportion to its stiffness."""
    rayleigh: RayleighTable | None = None
    """C = alpha M + beta K of all parts."""

    @model_validator(mode="after")
    def _one_of(self) -> DampingTable:
        if self.modal is not None and self.rayleigh is not None:
            raise ValueError("give either modal or rayleigh, not both")
        return self


class FrictionTable(Table):
    """Coulomb friction that falls with the sliding speed: kinetic + (static - kinetic) exp(-v / decay)."""

    static: NonNegative
    """Coefficient while it sticks."""
    kinetic: NonNegative
    """Coefficient while it slides fast; not above the static one."""
    decay: NonNegative = 0.0
    """length/time; 0: kinetic as soon as it slides."""

    @model_validator(mode="after")
    def _falls(self) -> FrictionTable:
        if self.kinetic > self.static:
            raise ValueError(f"kinetic = {self.kinetic} is above static = {self.static}")
        return self


FrictionValue = Annotated[
    Annotated[NonNegative, Tag("number")] | Annotated[FrictionTable, Tag("table")],
    Discriminator(lambda value: "table" if isinstance(value, dict | FrictionTable) else "number"),
]


class ContactTable(Table):
    """[contact.NAME]"""

    secondary: str
    """Surface or element set of shells and solids whose nodes become the gap channels; node-to-surface also a node
    set or an element set of beams."""
    main: str
    """Surface or element set of shells and solids that it can touch; of a set of solids all free faces."""
    method: Literal["surface-to-surface", "node-to-surface"] = "surface-to-surface"
    """Gaps averaged over the facets round each secondary node, or at the nodes themselves."""
    stiffness: Literal["auto", "hard"] | Positive = "auto"
    """force/length^3 (surface-to-surface) or force/length (node-to-surface); "auto": 10 times the softer parent
    element's (with a forced step no stiffer than it resolves); "hard": no penetration to speak of."""
    overclosure: list[tuple[NonNegative, NonNegative]] | None = None
    """Tabular law instead of a stiffness: [[overclosure, pressure], ...] from [0, 0] on, both rising
    (node-to-surface: force); the last slope goes on."""
    damping: NonNegative = 0.0
    """Acts while closed: force time/length^3 (surface-to-surface) or force time/length (node-to-surface); not with
    "hard"."""
    per_area: bool = False
    """node-to-surface: stiffness, overclosure and damping as surface-to-surface takes them, times the area of the
    secondary surface that belongs to each node."""
    clearance: Finite | str | None = None
    """length; replaces the geometric gap. A string names a CSV file, header node,clearance."""
    normal: tuple[Finite, Finite, Finite] | None = None
    """Direction from the main to the secondary surface, instead of the surfaces' own."""
    friction: FrictionValue = 0.0
    """Coefficient of Coulomb friction, or a table with static, kinetic and decay."""


class ConnectorTable(Table):
    """[[connector]]"""

    type: Literal["play"]
    """Free within limits, then stiff; it never pulls."""
    nodes: list[str] | str
    """Two node sets (relative motion, second minus first), or one: against ground."""
    dof: Dof
    """Direction of the relative motion."""
    lower: Finite | None = None
    """length or rad"""
    upper: Finite | None = None
    """length or rad; one of both limits may be left out."""
    stiffness: Positive
    """force/length"""
    damping: NonNegative = 0.0
    """force time/length, acts while the play is used up."""
    preload: NonNegative = 0.0
    """force with which a one-sided stop (one limit) presses at rest; the limit is then where it presses so."""
    name: str | None = None
    """For channels and events."""

    @property
    def node_sets(self) -> tuple[str, ...]:
        return (self.nodes,) if isinstance(self.nodes, str) else tuple(self.nodes)

    @model_validator(mode="after")
    def _one_or_two(self) -> ConnectorTable:
        if len(self.node_sets) not in (1, 2):
            raise ValueError(f"nodes names {len(self.node_sets)} sets, expected one (to ground) or two")
        return self


class MultisineTable(Table):
    """Random-phase multisine: every line between f_min and f_max with the same amplitude."""

    type: Literal["multisine"]
    f_min: NonNegative = 1.0
    """Hz"""
    f_max: Positive
    """Hz"""
    amplitude: Finite
    """Of each line."""
    period: Positive = 1.0
    """s"""
    seed: Annotated[int, Field(ge=0)] = 1
    """Of the random phases."""

    @model_validator(mode="after")
    def _has_lines(self) -> MultisineTable:
        if self.f_min > self.f_max:
            raise ValueError(f"f_min = {self.f_min:g} Hz is above f_max = {self.f_max:g} Hz")
        if int(self.f_max * self.period + 1e-9) < max(1.0, self.f_min * self.period - 1e-9):
            raise ValueError(
                f"period = {self.period:g} s gives lines at whole multiples of {1.0 / self.period:g} Hz, none of them "
                f"between f_min = {self.f_min:g} and f_max = {self.f_max:g} Hz"
            )
        return self


class SineTable(Table):
    """A sin(2 pi f t)."""

    type: Literal["sine"]
    frequency: Positive
    """Hz"""
    amplitude: Finite
    """A, in the unit of the excitation's kind."""


class StepTable(Table):
    """Constant from t = 0."""

    type: Literal["step"]
    amplitude: Finite
    """In the unit of the excitation's kind."""


Points = Annotated[list[tuple[Finite, Finite]], Field(min_length=1)]
"""[[time, value], ...], s, times that increase."""
CLOSEST = 1e-12
"""s between two points of a signal."""


def _increase(points: list[tuple[float, float]]) -> None:
    for before, after in pairwise(points):
        if after[0] < before[0] + CLOSEST:
            raise ValueError(f"the time {after[0]:g} s does not come {CLOSEST:g} s or more after {before[0]:g} s")


class TableTable(Table):
    """A CSV file with the header time,value, or the points themselves."""

    type: Literal["table"]
    file: str | None = None
    """Path relative to the study file."""
    values: Points | None = None
    """[[time, value], ...], s and the unit of the excitation's kind."""
    rounding: Annotated[float, Field(ge=0.0, le=0.5, allow_inf_nan=False)] | None = None
    """For displacement and velocity: straight lines whose corners are rounded over this share of the shorter interval
    beside them; default: displacement follows splines, velocity straight lines."""

    @model_validator(mode="after")
    def _one_of(self) -> TableTable:
        if (self.file is None) == (self.values is None):
            raise ValueError("give either file or values")
        _increase(self.values or [])
        return self


class SmoothStepTable(Table):
    """From point to point by a polynomial of degree five that starts and ends with zero slope and curvature."""

    type: Literal["smooth-step"]
    values: Annotated[Points, Field(min_length=2)]
    """[[time, value], ...], s and the unit of the excitation's kind."""

    @model_validator(mode="after")
    def _rises(self) -> SmoothStepTable:
        _increase(self.values)
        return self


class PeriodicTable(Table):
    """mean + sum_n cosine_n cos(2 pi n f (t - start)) + sine_n sin(2 pi n f (t - start)); the mean before start."""

    type: Literal["periodic"]
    frequency: Positive
    """Hz"""
    cosine: list[Finite] = []
    """Coefficients of the cosines, n = 1, 2, ..."""
    sine: list[Finite] = []
    """Coefficients of the sines, n = 1, 2, ..."""
    mean: Finite = 0.0
    """In the unit of the excitation's kind."""
    start: Finite = 0.0
    """s"""


class RecordTable(Table):
    """A measured acceleration (CSV, header time,value), integrated by omega arithmetic."""

    type: Literal["record"]
    file: str
    """Path relative to the study file."""
    high_pass: Positive
    """Hz; below it the record counts as drift."""


SignalTable = Annotated[
    MultisineTable | SineTable | StepTable | TableTable | RecordTable | SmoothStepTable | PeriodicTable,
    Field(discriminator="type"),
]


class ExcitationTable(Table):
    """[excitation.NAME]"""

    node_set: str
    """All nodes of this set get the same signal."""
    dof: Dof
    """Direction of the motion or force."""
    kind: Literal["displacement", "velocity", "acceleration", "force"] = "displacement"
    """length, length/time, length/time^2, or force on each node."""
    signal: SignalTable
    """The course in time."""


class StaticTable(Table):
    """[[static]]: a load that acts before the run and goes on through it; give one of gravity, force, displacement and
    press_fit. The run starts from the equilibrium under all of them, with contact."""

    gravity: tuple[Finite, Finite, Finite] | None = None
    """length/time^2: acceleration of gravity on all mass, [0, 0, -9810] in mm and s where z is up."""
    force: Finite | None = None
    """force (moment for rx, ry, rz) on each node of node_set along dof."""
    displacement: Finite | None = None
    """length or rad: the nodes of node_set are moved by so much along dof and held there; nodes that an excitation
    moves move about this place."""
    press_fit: Literal[True] | None = None
    """true: surfaces that overlap (in the deck, or by a negative clearance) press each other apart; without it their
    gap is set to 0 without strain."""
    node_set: str | None = None
    """Nodes of a force or displacement."""
    dof: Dof | None = None
    """Its direction."""

    @model_validator(mode="after")
    def _one_load(self) -> StaticTable:
        given = [k for k in ("gravity", "force", "displacement", "press_fit") if getattr(self, k) is not None]
        if len(given) != 1:
            raise ValueError(
                f"gives {' and '.join(given) or 'no load'}: give one of gravity, force, displacement and "
                "press_fit, the others in [[static]] tables of their own"
            )
        at_nodes = given[0] in ("force", "displacement")
        if at_nodes and (self.node_set is None or self.dof is None):
            raise ValueError(f"{given[0]} needs node_set and dof")
        if not at_nodes and (self.node_set is not None or self.dof is not None):
            raise ValueError(f"{given[0]} acts on the whole model: leave out node_set and dof")
        zero = self.force == 0.0 or (self.gravity is not None and not any(self.gravity))
        if zero:
            raise ValueError(f"{given[0]} is zero: it loads nothing")
        return self


class InterfaceTable(Table):
    """How the interface is thinned out: where substructures meet unreduced elements, or else the contact nodes."""

    type: Literal["full", "spacing", "participation", "interpolation", "characteristic", "coarse-mesh"] = "full"
    """Every dof, or one of the ways to keep fewer."""
    n: Annotated[int, Field(ge=1)] | None = None
    """spacing, interpolation: every n-th node; characteristic: number of modes; coarse-mesh: most shapes kept."""
    eta: Annotated[float, Field(ge=0.0, le=1.0)] | None = None
    """participation: share of the 95th percentile up to which a dof is dropped (thesis, equation 3.3)."""
    level: Literal["local", "system"] = "system"
    """characteristic: modes of each substructure's own interface, or of the assembled one."""
    deck: str | None = None
    """coarse-mesh: a deck of the same structure with a coarser mesh, relative to the study file."""

    @model_validator(mode="after")
    def _complete(self) -> InterfaceTable:
        needed = {
            "spacing": "n",
            "interpolation": "n",
            "characteristic": "n",
            "participation": "eta",
            "coarse-mesh": "deck",
        }.get(self.type)
        if needed is not None and getattr(self, needed) is None:
            raise ValueError(f"type = {self.type!r} needs {needed}")
        return self


class ReductionTable(Table):
    """[reduction]"""

    method: Literal["craig-bampton", "guyan", "gap-modes", "massless-boundary", "none"] = "craig-bampton"
    """craig-bampton, guyan: part by part; gap-modes, massless-boundary: the whole assembly; none: unreduced only."""
    f_max: Positive = 1500.0
    """Fixed-interface modes (gap-modes, massless-boundary: modes of the assembly) up to this frequency are kept, Hz;
    it must lie above the excitation."""
    keep_out: NonNegative = 0.0
    """length; elements with all nodes within this distance of the contact stay unreduced."""
    interface: InterfaceTable = InterfaceTable()
    """How the interface between substructures is thinned out."""
    substructures: list[str] = []
    """Element sets that become substructures of their own; the other elements stay with their part."""
    unreduced: list[str] = []
    """Element sets that stay unreduced, besides what keep_out leaves."""
    retain: list[str] | str = []
    """Node sets that are retained besides what couplings, supports, loads, contact and outputs need."""

    @property
    def retained_sets(self) -> tuple[str, ...]:
        return (self.retain,) if isinstance(self.retain, str) else tuple(self.retain)

    @model_validator(mode="after")
    def _applies(self) -> ReductionTable:
        if self.method in ("gap-modes", "massless-boundary") and (
            self.keep_out or self.substructures or self.unreduced or self.interface.type != "full"
        ):
            raise ValueError(
                f"method = {self.method!r} reduces the whole assembly: it knows no keep_out, substructures, unreduced "
                "or interface"
            )
        return self


class SuperelementTable(Table):
    """[superelement.NAME]: a part given by its matrices."""

    file: str
    """Matrices: .op4, .mtx (Abaqus or MatrixMarket), .sti (CalculiX), .npz, DMIG; relative to the study file."""
    map: str | None = None
    """Nodes and dofs of the rows where the file does not tell them (.asm for .op4)."""


class PrecheckTable(Table):
    """[precheck]"""

    enabled: bool = True
    """Keep contact only where a linear run closes the gap."""
    margin: NonNegative = 0.5
    """length: contact is kept where the gap of the linear run falls to this or below."""


class TimeTable(Table):
    """[time]: how long, and how accurate; a scheme and its step only for those who insist."""

    periods: Positive | None = None
    """Of the excitation's longest period; 5 where neither periods nor end is given."""
    end: Positive | None = None
    """s"""
    accuracy: Literal["settled", "quick", "fine"] = "settled"
    """settled: each event's impulse and force within some 5 %, start and duration within 0.1 ms; quick: rougher and
    cheaper; fine: four times finer. Steps follow from it: nothing else need be given."""
    step: Positive = 1e-3
    """s; a forced step, of the integrator hht where none is named."""
    integrator: Literal["exact", "hht", "generalised-alpha", "massless-boundary"] = "exact"
    """exact: exact motion between contacts, contact resolved in its own time scale, as accuracy says. The others take
    the step as it is. massless-boundary needs the reduction of that name."""
    alpha: Annotated[float, Field(ge=-0.5, le=0.0, allow_inf_nan=False)] = -0.05
    """hht: numerical damping; 0 is none."""
    rho_inf: Annotated[float, Field(ge=0.0, le=1.0, allow_inf_nan=False)] = 0.9
    """generalised-alpha: what is left of the highest frequencies after a step."""
    substeps: Annotated[int, Field(ge=1)] = 1
    """Steps into which a forced step near contact is divided; output stays at step. massless-boundary takes more by
    itself where its springs need them."""

    @property
    def exact(self) -> bool:
        """No scheme is forced: accuracy says all."""
        return self.integrator == "exact"

    @model_validator(mode="before")
    @classmethod
    def _forced(cls, data: Any) -> Any:
        """A step, alpha or substeps alone ask for HHT, which they belong to; rho_inf for its own scheme."""
        if not isinstance(data, dict) or "integrator" in data:
            return data
        if "rho_inf" in data:
            return {**data, "integrator": "generalised-alpha"}
        return {**data, "integrator": "hht"} if FORCED & data.keys() else data

    @model_validator(mode="after")
    def _one_of(self) -> TimeTable:
        if self.periods is not None and self.end is not None:
            raise ValueError("give either periods or end, not both")
        return self


FORCED = {"step", "alpha", "substeps"}
"""Keys of [time] that ask for HHT."""


class ReferenceTable(Table):
    """[reference]"""

    run: bool = True
    """Also run the unreduced model."""
    until: Positive | None = None
    """s; the unreduced run, which starts from rest like the other, ends here, and the two are compared up to here.
    Default: it covers the whole run."""


class OutputTable(Table):
    """[output]"""

    nodes: list[str] | str = []
    """Node sets whose motion is kept besides the verification nodes."""
    interval: Positive | None = None
    """s; default: 1 ms, less for short runs and fast excitations; with a forced step every step."""
    field_interval: Positive | None = None
    """s; the motion of all nodes is recovered this often and written to results.h5; default: not at all."""
    field_start: NonNegative = 0.0
    """s; from here on."""

    @property
    def node_sets(self) -> tuple[str, ...]:
        return (self.nodes,) if isinstance(self.nodes, str) else tuple(self.nodes)


class VerificationTable(Table):
    """[verification]"""

    pairs: str | list[str] | None = None
    """One node set with main and secondary nodes in turn, a name with sets NAME_MAIN and NAME_SECONDARY,
    or two set names."""
    f_max: Positive = 500.0
    """Hz, spectra and low-pass of forces."""
    mac_f_max: Positive = 100.0
    """Hz, mode shapes that are compared."""
    event_tolerance: Positive = 0.010
    """s; events of both runs this close are the same."""
    merge: NonNegative | None = None
    """s; contact of one side lost for less is one event. Default: the contact's own time scale, the length of its
    blows, and never more than 5 ms."""


class StudyConfig(Table):
    """The whole study file."""

    title: str = ""
    """For the report."""
    model: ModelTable
    """The deck and its units."""
    damping: DampingTable = DampingTable()
    """Replaces the deck's *DAMPING."""
    contact: dict[str, ContactTable] = {}
    """[contact.NAME]: two surfaces that may touch."""
    connector: list[ConnectorTable] = []
    """[[connector]]: a clip or hook with play."""
    excitation: dict[str, ExcitationTable] = {}
    """[excitation.NAME]: prescribed motion or forces."""
    static: list[StaticTable] = []
    """[[static]]: gravity and other loads that the run starts in equilibrium with."""
    reduction: ReductionTable = ReductionTable()
    """How the model is reduced."""
    superelement: dict[str, SuperelementTable] = {}
    """[superelement.NAME]: a part given by its matrices."""
    precheck: PrecheckTable = PrecheckTable()
    """Which contact channels are worth keeping."""
    time: TimeTable = TimeTable()
    """Steps of the time integration."""
    reference: ReferenceTable = ReferenceTable()
    """The unreduced run."""
    output: OutputTable = OutputTable()
    """What is kept of the motion."""
    verification: VerificationTable = VerificationTable()
    """What reduced and unreduced run are compared by."""
