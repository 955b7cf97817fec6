"""Tables of what may touch: contacts and connectors."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import Discriminator, Tag, model_validator

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
