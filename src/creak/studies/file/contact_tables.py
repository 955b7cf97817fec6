"""Tables of what may touch and of what holds parts: contacts, connectors, and clips, bushings, stops and foam."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from creak.studies.file.table import Dof, Finite, NonNegative, Positive, Table


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


Axis = tuple[Finite, Finite, Finite]
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
    secondary surface that belongs to each node: of the faces around it, those that look at the main surface."""
    clearance: Finite | str | None = None
    """length; replaces the geometric gap; below zero with [[static]] press_fit alone. A string names a CSV file, header
    node,clearance."""
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
    dof: Dof | None = None
    """Direction of the relative motion; this or axis."""
    axis: Axis | None = None
    """Direction of the relative motion, in the deck's axes; this or dof."""
    lower: Finite | None = None
    """length or rad"""
    upper: Finite | None = None
    """length or rad; one of both limits may be left out."""
    stiffness: Literal["hard"] | Positive
    """force/length; "hard": no penetration to speak of."""
    damping: NonNegative = 0.0
    """force time/length, acts while the play is used up."""
    preload: NonNegative = 0.0
    """force with which a one-sided stop (one limit) presses at rest; the limit is then where it presses so."""
    friction: FrictionValue = 0.0
    """Of what the stop presses with, across its direction: a coefficient, or a table as a contact has it."""
    name: str | None = None
    """For channels and events; default: its node sets, and its number where several have the same."""

    @property
    def node_sets(self) -> tuple[str, ...]:
        return (self.nodes,) if isinstance(self.nodes, str) else tuple(self.nodes)

    @model_validator(mode="after")
    def _one_or_two(self) -> ConnectorTable:
        if len(self.node_sets) not in (1, 2):
            raise ValueError(f"nodes names {len(self.node_sets)} sets, expected one (to ground) or two")
        return self

    @property
    def turns(self) -> bool:
        """Is it a stop of a rotation?"""
        return (self.dof or "").startswith("r")

    @model_validator(mode="after")
    def _directed(self) -> ConnectorTable:
        if (self.dof is None) == (self.axis is None):
            raise ValueError("give either dof (x, y, z, rx, ry, rz) or axis (a direction [x, y, z])")
        if self.axis is not None and not any(self.axis):
            raise ValueError("axis has length zero")
        if self.friction and self.turns:
            raise ValueError(f"friction across a turn about {self.dof}: only stops along a line rub")
        return self


def connector_names(tables: Sequence[ConnectorTable]) -> list[str]:
    """What results call each connector: its name, or `A-B` of its node sets; `A-B.2` where another has the same."""
    plain = ["-".join(t.node_sets) for t in tables]
    times = Counter(name for name, t in zip(plain, tables, strict=True) if not t.name)
    numbered = [name if times[name] == 1 else f"{name}.{k}" for k, name in enumerate(plain, start=1)]
    return [t.name or name for t, name in zip(tables, numbered, strict=True)]


Six = Annotated[list[NonNegative], Field(min_length=6, max_length=6)]

KEYS: dict[str, tuple[str, ...]] = {
    "bushing": ("stiffness", "damping"),
    "play": ("stiffness", "table", "lower", "upper", "damping"),
    "pull-out": ("stiffness", "pull_out", "damping"),
    "stop": ("stiffness", "table", "gap", "damping"),
    "foam": ("table", "gap", "damping"),
}
"""Values that each type takes."""


class ClipValues(Table):
    """[clip.NAME] of a library: how a clip holds."""

    type: Literal["bushing", "play", "pull-out", "stop", "foam"] | None = None
    """bushing: linear in six directions; play: free between lower and upper, then stiff; pull-out: stiff, and from
    pull_out on it holds with that force alone; stop: stiff in one direction once gap is used up; foam: the same with
    a table."""
    stiffness: Positive | Six | None = None
    """force/length along the axis; of a bushing six numbers: force/length along the axis and two across, then
    moment/rad about these."""
    table: Annotated[list[tuple[NonNegative, NonNegative]], Field(min_length=2)] | None = None
    """Instead of a stiffness: [[compression, force], ...] from [0, 0] on, both rising; the last slope goes on."""
    damping: NonNegative | Six | None = None
    """force time/length while it is closed; of a bushing six numbers. With a table it is what makes a hysteresis."""
    lower: Finite | None = None
    """length: play, limit of the motion of the second node against the first along the axis."""
    upper: Finite | None = None
    """length; one of both limits may be left out."""
    gap: Finite | None = None
    """length: stop, foam: motion along the axis before it touches, default 0; below 0: it is squeezed at the deck's
    geometry."""
    pull_out: Positive | None = None
    """force along the axis at which a pull-out clip begins to leave its seat."""
    source: str | None = None
    """Where the values come from."""

    @model_validator(mode="after")
    def _fits(self) -> ClipValues:
        if self.type is None:
            return self
        every = dict.fromkeys(key for keys in KEYS.values() for key in keys)
        foreign = [key for key in every if getattr(self, key) is not None and key not in KEYS[self.type]]
        if foreign:
            raise ValueError(f"a {self.type} clip has no {foreign[0]}: it takes {', '.join(KEYS[self.type])}")
        for key in ("stiffness", "damping"):
            value = getattr(self, key)
            if value is not None and isinstance(value, list) != (self.type == "bushing"):
                raise ValueError(f"{key} of a {self.type} clip is {'six numbers' if self.type == 'bushing' else 'one'}")
        return self


class ClipTable(ClipValues):
    """[[clip]]: a clip, bushing, stop or foam between two places, or one and ground."""

    name: str | None = None
    """For channels and events; default: its type or library name, and its number."""
    use: str | None = None
    """Name of a clip in the library, whose values it has besides those given here."""
    nodes: list[str] | str | None = None
    """Two node sets, node by node; or one: to ground."""
    at: Annotated[list[tuple[Finite, Finite, Finite]], Field(min_length=1)] | None = None
    """Instead of nodes: [[x, y, z], ...], length; a clip at each point, between the nearest nodes of the parts."""
    parts: list[str] | str | None = None
    """Two parts for at, or one: to ground."""
    within: Positive | None = None
    """length: how far nodes may lie from their points; default: 1/100 of the model's size."""
    axis: tuple[Finite, Finite, Finite] | None = None
    """Direction, in the deck's axes; the second node moves along it against the first."""
    lateral: tuple[Finite, Finite, Finite] | None = None
    """Of a bushing whose values across the axis differ: the direction of the first."""
    ageing: Positive = 1.0
    """Share of its stiffness and forces that is left."""

    @property
    def node_sets(self) -> tuple[str, ...]:
        return (self.nodes,) if isinstance(self.nodes, str) else tuple(self.nodes or ())

    @property
    def part_names(self) -> tuple[str, ...]:
        return (self.parts,) if isinstance(self.parts, str) else tuple(self.parts or ())

    @model_validator(mode="after")
    def _placed(self) -> ClipTable:
        if (self.nodes is None) == (self.at is None):
            raise ValueError("give either nodes, or at and parts")
        if (self.at is None) != (self.parts is None):
            raise ValueError("at and parts belong together")
        if self.within is not None and self.at is None:
            raise ValueError("within belongs to at")
        ends = self.node_sets or self.part_names
        if len(ends) not in (1, 2):
            raise ValueError(f"names {len(ends)} ends, expected two, or one (to ground)")
        if any(a is not None and not any(a) for a in (self.axis, self.lateral)):
            raise ValueError("a direction of length zero")
        if self.type is None and self.use is None:
            raise ValueError(f"give type ({', '.join(KEYS)}), or use: the name of a clip in the library")
        return self if self.use is not None else self._complete()

    def _complete(self) -> ClipTable:
        """Raise ValueError where a value is missing."""
        if self.type == "bushing" and self.stiffness is None:
            raise ValueError("a bushing needs stiffness")
        if self.type == "play" and self.lower is None and self.upper is None:
            raise ValueError("a clip with play needs lower, upper or both")
        if self.type == "pull-out" and (self.stiffness is None or self.pull_out is None):
            raise ValueError("a pull-out clip needs stiffness and pull_out")
        if self.type == "foam" and self.table is None:
            raise ValueError("foam needs a table")
        if self.type in ("play", "stop") and (self.stiffness is None) == (self.table is None):
            raise ValueError("give either stiffness or table")
        if self.axis is None and self.type != "bushing":
            raise ValueError(f"a {self.type} clip needs an axis")
        return self
