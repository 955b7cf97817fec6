"""Tables of clips, bushings, stops and foam: their values, and where they sit."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from creak.studies.file.table import Finite, NonNegative, Positive, Table

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
