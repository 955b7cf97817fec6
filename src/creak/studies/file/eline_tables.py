"""Tables of the study for E-lines, the materials that rub there, and what the user allows."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from creak.sound.zwicker_tables import ThirdOctave
from creak.studies.file.quantities import (
    DecibelText,
    Force,
    Length,
    LevelText,
    LoudnessText,
    RoughnessText,
    SharpnessText,
    Time,
)
from creak.studies.file.scatter_tables import Tolerance
from creak.studies.file.table import Finite, NonNegative, Positive, Table

PointColumn = (
    Literal["id", "main", "secondary", "x1", "y1", "z1", "x2", "y2", "z2", "x", "y", "z"]
    | Literal["direction", "normal_x", "normal_y", "normal_z"]
)
"""Columns of a file of points."""


class ElineTable(Table):
    """[eline.NAME]: a line of points between two parts. With the NAME of a contact: what holds for its points, which
    are E-lines by themselves."""

    main: str | None = None
    """Surface, element set or node set of one side."""
    secondary: str | None = None
    """The same of the other side; each of its nodes that faces the main side is a point."""
    points: str | Annotated[list[tuple[Finite, Finite, Finite]], Field(min_length=1)] | None = None
    """Coordinates [[x, y, z], ...] along the line: the nearest nodes of both sides are taken. A string names a CSV
    file with the columns x,y,z, or with pairs: main,secondary (labels of nodes, without the keys main and secondary)
    or x1,y1,z1,x2,y2,z2. Separators, units, other names of the columns and lines above them are understood."""
    columns: dict[PointColumn, Annotated[str, Field(min_length=1)]] = {}
    """What the file of points calls its columns, where it calls them otherwise: { main = "Node A" }."""
    clearance: Finite | None = None
    """length; replaces the geometric gap."""
    normal: tuple[Finite, Finite, Finite] | None = None
    """Direction z across the gap, from the main to the secondary side, instead of the main surface's own or the line
    between two nodes."""
    tolerance: Tolerance | None = None
    """What scatter may take of the gap, instead of that of [limit]: "0.5 mm", or the name of a CSV file with the
    columns point (or x,y,z), nominal, plus, minus, sigma. { file = "gaps.csv", columns = { point = "Feature" } }:
    where the file calls them otherwise."""
    material: str | None = None
    """NAME of a [material-pair.NAME]."""

    @property
    def drawn(self) -> bool:
        """It says where its points are."""
        return self.main is not None or self.secondary is not None or self.points is not None

    @model_validator(mode="after")
    def _sides(self) -> ElineTable:
        if (self.main is None) != (self.secondary is None):
            raise ValueError("give both main and secondary, or neither")
        if isinstance(self.points, list) and self.main is None:
            raise ValueError("points need main and secondary, the sides that they lie between")
        if self.columns and not isinstance(self.points, str):
            raise ValueError("columns are those of a file of points: give points the name of one")
        if not self.drawn and (self.clearance is not None or self.normal is not None):
            raise ValueError("clearance and normal are for lines with main and secondary; a contact has its own")
        return self


class LimitTable(Table):
    """[limit]: what the user allows, each figure with its unit; no limit is built in."""

    tolerance: Tolerance | None = None
    """What scatter may take of every gap: margin = gap - tolerance - displacement. "0.3 mm", or a CSV file as [eline]
    takes it. Default: none."""
    in_plane: Length | None = None
    """In-plane peak-to-peak from which a line counts as one that may squeak, where it has no material pair; of points
    that can touch."""
    percentile: Annotated[float, Field(gt=0.0, le=100.0, allow_inf_nan=False)] = 95.0
    """Percentile of the peaks that is given beside the largest, %."""
    n5: LoudnessText | None = None
    """Loudness exceeded in 5 % of the verification window by the contact of any place alone, as "2 sone"; beside a
    [background] the loudness that it adds to it. This and the other limits of sound hold at every listener."""
    n_max: LoudnessText | None = None
    """The same of the largest loudness."""
    n10: LoudnessText | None = None
    """Loudness exceeded in 10 % of the window by the contact of any place alone; a background is not taken off it."""
    sharpness: SharpnessText | None = None
    """Sharpness (DIN 45692) of any place alone, as "2 acum": that exceeded in 5 % of the time in which it is heard."""
    sharpness_above: SharpnessText = "2 acum"
    """Sharpness from which time counts as sharp."""
    sharp_time: Time | None = None
    """How long of the window any place alone may be sharper than that, as "0.2 s"."""
    roughness: RoughnessText | None = None
    """Roughness (Daniel and Weber 1997) of any place alone, as "0.5 asper": that exceeded in 5 % of the time in which
    it is heard."""
    prominence: NonNegative | None = None
    """Prominence P of the most impulsive onset of any place alone (NT ACOU 112), a number: below 5 none is heard as an
    impulse, some 15 is the most."""
    impulse_adjustment: DecibelText | None = None
    """Its adjustment K_I = 1.8 (P - 5), as "5 dB"."""
    third_octaves: dict[ThirdOctave, DecibelText] = {}
    """Level of any place alone in third octaves by their nominal frequency in Hz, as { 1000 = "40 dB" }."""
    level: LevelText | None = None
    """Equivalent continuous level of any place alone over the window, as "40 dB(A)"."""
    force: Force | None = None
    """Worst low-passed force of any place, as "5 N"."""


class MaterialPairTable(Table):
    """[material-pair.NAME]: the user's own measurement of two materials. Its units are the same in every study."""

    source: Annotated[str, Field(min_length=1)]
    """Where the figures come from: rig, specimens, report, date."""
    impulse_rate_min: Positive
    """1/mm; fewest stick-slip impulses per mm of travel that were measured."""
    impulse_rate_max: Positive
    """1/mm; most of them."""
    friction_static: NonNegative | None = None
    """Coefficient while it sticks."""
    friction_kinetic: NonNegative | None = None
    """Coefficient while it slides fast."""
    friction_decay: NonNegative | None = None
    """mm/s; speed over which the coefficient falls."""
    normal_force: Positive | None = None
    """N; of the measurement."""
    speed: Positive | None = None
    """mm/s; of the measurement."""
    temperature: Annotated[float, Field(ge=-273.15, allow_inf_nan=False)] | None = None
    """degrees Celsius; of the measurement."""
    humidity: Annotated[float, Field(ge=0.0, le=100.0, allow_inf_nan=False)] | None = None
    """% relative; of the measurement."""

    @model_validator(mode="after")
    def _ordered(self) -> MaterialPairTable:
        if self.impulse_rate_min > self.impulse_rate_max:
            raise ValueError(f"impulse_rate_min = {self.impulse_rate_min:g} is above impulse_rate_max")
        if None not in (a := (self.friction_kinetic, self.friction_static)) and a[0] > a[1]:  # type: ignore[operator]
            raise ValueError(f"friction_kinetic = {a[0]:g} is above friction_static")
        return self
