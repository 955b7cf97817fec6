"""The study file: what a TOML may say, with units and defaults."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, ConfigDict, Field, StrictBool, model_validator
from pydantic_core import PydanticCustomError

from creak.arrays import FloatArray
from creak.dynamics.scheme import HHT, Scheme, generalised_alpha
from creak.model.units import UnitsName
from creak.studies.file.contact_tables import ClipTable, ConnectorTable, ContactTable
from creak.studies.file.eline_tables import ElineTable, LimitTable, MaterialPairTable
from creak.studies.file.excitation_tables import ExcitationTable, MeasuredTable, StaticTable
from creak.studies.file.model_tables import MaterialTable, NodesTable, SectionTable, SupportTable
from creak.studies.file.scatter_tables import ScatterTable
from creak.studies.file.sound_tables import BackgroundTable, ListenerTable, RoomTable
from creak.studies.file.table import NonNegative, Positive, Table
from creak.words import percent

GONE = "not_needed"
"""Type of the error of a word that creak knows and does not take."""
LEFT = 0.15
"""Share of its gap at rest that the linear run may leave of a channel that the pre-check keeps."""


def _no_massless_boundary(value: Any) -> Any:
    if value == "massless-boundary":
        raise PydanticCustomError(GONE, "creak has no massless boundary, as hard contact needs none")
    return value


class ModelTable(Table):
    """[model]"""

    deck: str
    """Abaqus .inp, Nastran .bdf, .dat, .nas, .fem or LS-DYNA .k, .key, .dyn, relative to the study file."""
    units: UnitsName = "mm-t-s"
    """Units of the deck and the study: length, mass (of in-lbf-s: force) and time. They label results; nothing is
    converted. Materials in another of them are refused."""


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
    from_test: str | None = None
    """File of measured modes with damping (.unv, .uff, .csv), relative to the study file. Modes of the model, contact
    left out, take the damping of their partners by MAC, all others the mean of these; else as modal."""

    @model_validator(mode="after")
    def _one_of(self) -> DampingTable:
        given = [name for name in ("modal", "rayleigh", "from_test") if getattr(self, name) is not None]
        if len(given) > 1:
            raise ValueError(f"give either {given[0]} or {given[1]}, not both")
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

    method: Annotated[
        Literal["craig-bampton", "guyan", "gap-modes", "none"], BeforeValidator(_no_massless_boundary)
    ] = "craig-bampton"
    """craig-bampton, guyan: part by part; gap-modes: the whole assembly; none: unreduced only."""
    f_max: Positive | Literal["auto"] = "auto"
    """Fixed-interface modes (gap-modes: modes of the assembly) up to this frequency are kept, Hz; it
    must lie above the excitation. "auto": 11 times the excitation's highest frequency, and half as much again and
    again until neither more modes nor the unreduced model change an event by more than the verdict allows, or the next
    stage would cost too much.
    With accuracy "quick" it stays where it begins."""
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
        if self.method == "gap-modes" and (
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
    instance: str | None = None
    """Instance whose nodes it joins, where several have the same labels and the file does not say where they lie."""


class PrecheckTable(Table):
    """[precheck]"""

    enabled: bool = True
    """Keep contact only where a linear run closes the gap."""
    margin: NonNegative | Literal["auto"] = "auto"
    """length: contact is kept where the gap of the linear run falls to this or below. "auto": where that run closes the
    gap, or all but 15 % of it."""

    def near(self, gap0: FloatArray) -> FloatArray:
        """(m,) gap of the linear run to which channels must fall to be kept; gap0: (m,) their gaps at rest."""
        return np.maximum(LEFT * gap0, 0.0) if self.margin == "auto" else np.full(gap0.shape, self.margin)

    def words(self, unit: str = "") -> str:
        """The margin as a sentence has it, in this unit."""
        return f"{percent(LEFT)} of its gap at rest" if self.margin == "auto" else f"{self.margin:g} {unit}".rstrip()


class TimeTable(Table):
    """[time]: how long, and how accurate; a scheme and its step only for those who insist."""

    periods: Positive | None = None
    """Of the excitation's longest period; 5 where neither periods nor end is given."""
    end: Positive | None = None
    """s"""
    accuracy: Literal["settled", "quick", "fine"] = "settled"
    """settled: each event's impulse and force within some 5 %, start and duration within a third of its duration, and
    the run says how far it is from that; quick: rougher and cheaper; fine: four times finer. Steps follow from it:
    nothing else need be given."""
    step: Positive = 1e-3
    """s; a forced step, of the integrator hht where none is named."""
    integrator: Annotated[Literal["exact", "hht", "generalised-alpha"], BeforeValidator(_no_massless_boundary)] = (
        "exact"
    )
    """exact: exact motion between contacts, contact resolved in its own time scale, as accuracy says. The others take
    the step as it is."""
    alpha: Annotated[float, Field(ge=-0.5, le=0.0, allow_inf_nan=False)] = -0.05
    """hht: numerical damping; 0 is none."""
    rho_inf: Annotated[float, Field(ge=0.0, le=1.0, allow_inf_nan=False)] = 0.9
    """generalised-alpha: what is left of the highest frequencies after a step."""
    substeps: Annotated[int, Field(ge=1)] = 1
    """Steps into which a forced step near contact is divided; output stays at step."""

    @property
    def exact(self) -> bool:
        """No scheme is forced: accuracy says all."""
        return self.integrator == "exact"

    @property
    def scheme(self) -> Scheme:
        """Of a forced step."""
        return generalised_alpha(self.rho_inf) if self.integrator == "generalised-alpha" else HHT(self.alpha)

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


Proof = Literal["spots", "whole", "none"]


class ReferenceTable(Table):
    """[reference]"""

    run: StrictBool | Proof | None = None
    """What the unreduced model proves. "spots": it marches through some events of the reduced run, from its state, at a
    fifth of the cost of the reduction. "whole" (or `true`): it is run from rest as well, and compared event by event.
    "none" (or `false`): nothing, and no run with events is "settled", unless all modes there are were kept; one in
    which nothing touches may be. Default: "spots"; "whole" with a forced step or `until`."""
    until: Positive | None = None
    """s; the unreduced model is run from rest up to here, and the two are compared up to here. Beside another `run`
    than "whole" it is refused. Default with "whole": to the end."""


class OutputTable(Table):
    """[output]"""

    nodes: list[str] | str = []
    """Node sets whose motion is kept besides the verification nodes."""
    interval: Positive | None = None
    """s; default: half a period of the verification's f_max (1 ms of 500 Hz), less for short runs and fast excitations;
    with a forced step every step."""
    field_interval: Positive | None = None
    """s; the motion of all nodes is recovered this often and written to results.h5; default: around the hardest event
    alone."""
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
    """Hz, spectra and low-pass of forces. Default: 500; more where the run is shorter than ten periods of it, less
    where the solids at a contact are too coarse for it, which a note tells."""
    mac_f_max: Positive = 100.0
    """Hz, mode shapes that are compared."""
    event_tolerance: Positive = 0.010
    """s; events of both runs this close are the same. Default: five periods of f_max."""
    merge: NonNegative | None = None
    """s; contact of one side lost for less is one event. Default: the contact's own time scale, the length of its
    blows, and never more than two and a half periods of f_max."""

    @model_validator(mode="before")
    @classmethod
    def _by_the_band(cls, data: Any) -> Any:
        """Another band moves the default tolerance with it."""
        f_max = data.get("f_max") if isinstance(data, dict) else None
        if not isinstance(f_max, int | float) or not 0.0 < f_max < float("inf"):
            return data
        return {"event_tolerance": PERIODS / f_max, **data}


PERIODS = 5.0
"""Of the verification's f_max, in which events of two runs count as the same."""


class StudyConfig(Table):
    """The whole study file."""

    model_config = ConfigDict(populate_by_name=True)

    title: str = ""
    """For the report."""
    material_pairs: str | None = None
    """TOML or CSV file, relative to the study file, with material pairs beside those of the study: [material-pair.NAME]
    tables, or a row for each pair with the columns name and the keys of such a table."""
    model: ModelTable
    """The deck and its units."""
    material: dict[str, MaterialTable] = {}
    """[material.NAME]: materials of the deck with other numbers."""
    section: dict[str, SectionTable] = {}
    """[section.NAME]: sections and springs of the deck with another number. NAME may be that of a set of all elements
    of one section or more."""
    nodes: dict[str, NodesTable] = {}
    """[nodes.NAME]: node sets by labels or coordinates."""
    support: dict[str, SupportTable] = {}
    """[support.NAME]: nodes held otherwise than the deck says."""
    damping: DampingTable = DampingTable()
    """Replaces the deck's *DAMPING."""
    contact: dict[str, ContactTable] = {}
    """[contact.NAME]: two surfaces that may touch."""
    connector: list[ConnectorTable] = []
    """[[connector]]: a clip or hook with play."""
    clip: list[ClipTable] = []
    """[[clip]]: clips, bushings, stops and foam."""
    clips: str | None = None
    """TOML file, relative to the study file, with [clip.NAME] tables that [[clip]] can use beside those of creak."""
    scatter: ScatterTable = ScatterTable()
    """What is known by its distribution alone; `creak robust` draws it."""
    eline: dict[str, ElineTable] = {}
    """[eline.NAME]: points between two parts whose relative motion is looked at."""
    material_pair: Annotated[dict[str, MaterialPairTable], Field(alias="material-pair")] = {}
    """[material-pair.NAME]: what was measured of two materials that rub."""
    limit: LimitTable = LimitTable()
    """What the user allows; no limit is built in."""
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
    """What the unreduced model proves of the answer."""
    output: OutputTable = OutputTable()
    """What is kept of the motion."""
    verification: VerificationTable = VerificationTable()
    """What reduced and unreduced run are compared by."""
    listener: dict[str, ListenerTable] = {}
    """[listener.NAME]: where the sound of the contacts is heard."""
    test: dict[str, MeasuredTable] = {}
    """[test.NAME]: what was measured, beside what the run computes."""
    background: BackgroundTable | None = None
    """The steady sound that the contacts are heard beside."""
    room: RoomTable | None = None
    """The cabin around all listeners."""

    @model_validator(mode="after")
    def _one_room(self) -> Self:
        measured = next((name for name, one in self.listener.items() if one.transfer), None)
        if self.room is not None and measured is not None:
            raise ValueError(f"room and listener.{measured}.transfer are both given: a measured way has the room in it")
        return self

    @property
    def highest(self) -> float:
        """Highest frequency that the tables of the excitations name, Hz; 0: none does."""
        return max((table.signal.highest for table in self.excitation.values()), default=0.0)

    @property
    def runs_unreduced(self) -> bool:
        """Whether the unreduced model is run from rest."""
        return self.proof == "whole" or self.reduction.method == "none"

    @property
    def proof(self) -> Proof:
        """What the unreduced model proves, in one word whatever the study says."""
        asked = self.reference.run
        if asked is None:
            return "whole" if self.reference.until is not None or not self.time.exact else "spots"
        if isinstance(asked, bool):
            return "whole" if asked else "none"
        return asked
