"""Tables of what drives the model, excitations and their signals, and of measurements beside which its run is put."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from creak.studies.file.signals.tables import RecordTable, SignalTable
from creak.studies.file.table import Dof, Finite, Positive, Table

Kind = Literal["displacement", "velocity", "acceleration", "force"]


class ExcitationTable(Table):
    """[excitation.NAME]"""

    node_set: str
    """All nodes of this set get the same signal."""
    dof: Dof
    """Direction of the motion or force."""
    kind: Kind = "displacement"
    """length, length/time, length/time^2, or force on each node."""
    signal: SignalTable
    """The course in time."""

    @property
    def values_of(self) -> Kind:
        """What the values of the signal count: `kind`, but a record of motion is one of acceleration."""
        return "acceleration" if isinstance(self.signal, RecordTable) and self.kind != "force" else self.kind

    @model_validator(mode="after")
    def _fits(self) -> ExcitationTable:
        self.signal.check(self.kind, self.dof)
        return self


LOADS = ("gravity", "force", "displacement", "temperature", "deck_loads", "press_fit")
"""Of which a [[static]] table has one."""


class StaticTable(Table):
    """[[static]]: a load that acts before the run and goes on through it; give one of gravity, force, displacement,
    temperature and press_fit. The run starts from the equilibrium under all of them, with contact."""

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
    temperature: Finite | str | None = None
    """degrees: of all nodes, or those of part or node_set; or a CSV file with the header node,temperature, relative to
    the study file. A later table replaces earlier ones on its nodes; nodes of none stay as they are."""
    reference: Finite | None = None
    """degrees without strain; default: those of the deck (TREF, *INITIAL CONDITIONS)."""
    part: str | None = None
    """Part that has the temperature."""
    deck_loads: Annotated[int, Field(ge=1)] | str | None = None
    """A set of loads of a Nastran deck: GRAV, FORCE, MOMENT, LOAD, SPCD, TEMP and TEMPD cards of that number."""
    node_set: str | None = None
    """Nodes of a force, displacement or temperature."""
    dof: Dof | None = None
    """Direction of a force or displacement."""

    @model_validator(mode="after")
    def _one_load(self) -> StaticTable:
        given = [k for k in LOADS if getattr(self, k) is not None]
        if len(given) != 1:
            raise ValueError(
                f"gives {' and '.join(given) or 'no load'}: give one of {', '.join(LOADS[:-1])} and {LOADS[-1]}, the "
                "others in [[static]] tables of their own"
            )
        at_nodes, heat = given[0] in ("force", "displacement"), given[0] == "temperature"
        if at_nodes and (self.node_set is None or self.dof is None):
            raise ValueError(f"{given[0]} needs node_set and dof")
        if not heat and (self.reference is not None or self.part is not None):
            raise ValueError(f"{given[0]} knows neither reference nor part, which belong to a temperature")
        if not at_nodes and not heat and (self.node_set is not None or self.dof is not None):
            raise ValueError(f"{given[0]} acts on the whole model: leave out node_set and dof")
        if heat:
            self._check_heat()
        zero = self.force == 0.0 or (self.gravity is not None and not any(self.gravity))
        if zero:
            raise ValueError(f"{given[0]} is zero: it loads nothing")
        return self

    def _check_heat(self) -> None:
        if self.dof is not None:
            raise ValueError("a temperature has no dof: leave it out")
        places = [k for k in ("part", "node_set") if getattr(self, k) is not None]
        if len(places) > 1 or (places and isinstance(self.temperature, str)):
            raise ValueError("give one of part, node_set and a file with the temperature of each node")


class MeasuredTable(Table):
    """A file of a test: modes, frequency response functions or time histories."""

    file: str
    """Universal file (.unv, .uff), CSV, RPC III (.rsp, .drv) or WAV, relative to the study file."""
    sensors: str | None = None
    """CSV file with the header sensor,node. Default: sensors are at the nodes with their labels, else the nearest."""
    channels: dict[str, str] = {}
    """Name of a time history in the file -> what the run calls it, as "1017 Z", "flange gap", "flange force"."""
    full_scale: Positive | None = None
    """Of a WAV file that does not tell it: what full scale is, in `unit`."""
    unit: str | None = None
    """Of a WAV file: unit of its samples, as "m/s^2"."""

    @model_validator(mode="after")
    def _of_a_wav_file(self) -> MeasuredTable:
        if (self.full_scale is None) != (self.unit is None):
            raise ValueError("give both full_scale and unit, or neither")
        if self.unit is not None and not self.file.lower().endswith(".wav"):
            raise ValueError("full_scale and unit belong to WAV files; other files tell their units themselves")
        return self
