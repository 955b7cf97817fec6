"""Tables that name nodes and hold them."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from creak.studies.file.table import Dof, Finite, Positive, Table


def _label(value: Any) -> Any:
    return str(value) if isinstance(value, int) and not isinstance(value, bool) else value


Label = Annotated[str, BeforeValidator(_label), WithJsonSchema({"anyOf": [{"type": "integer"}, {"type": "string"}]})]
"""17, or "FRAME-1.17" in a deck with instances."""


class NodesTable(Table):
    """[nodes.NAME]: a node set of the study, for every key that names one; give labels or near."""

    labels: Annotated[list[Label], Field(min_length=1)] | None = None
    """Labels of nodes, 17, or "FRAME-1.17" in a deck with instances."""
    near: Annotated[list[tuple[Finite, Finite, Finite]], Field(min_length=1)] | None = None
    """[[x, y, z], ...], length: the node nearest to each point."""
    within: Positive | None = None
    """length: how far the node of a point may lie from it; default: 1/100 of the model's size."""
    part: str | None = None
    """Part that near looks in; default: all."""

    @model_validator(mode="after")
    def _one_of(self) -> NodesTable:
        if (self.labels is None) == (self.near is None):
            raise ValueError("give either labels or near")
        if self.labels is not None and (self.within is not None or self.part is not None):
            raise ValueError("within and part belong to near")
        return self


class SupportTable(Table):
    """[support.NAME]: nodes held otherwise than the deck says. A support that is shaken is freed here and moved by an
    [excitation]."""

    nodes: str
    """Node set; "*": all nodes that the deck holds in a dof named in free."""
    free: list[Dof] = []
    """Dofs that the deck holds and the study lets go."""
    hold: list[Dof] = []
    """Dofs held at zero."""

    @model_validator(mode="after")
    def _says_something(self) -> SupportTable:
        both = [dof for dof in self.free if dof in self.hold]
        if both:
            raise ValueError(f"{both[0]} is both freed and held")
        if not self.free and not self.hold:
            raise ValueError("frees and holds nothing: give free or hold")
        if self.nodes == "*" and self.hold:
            raise ValueError('"*" names nodes to free; name those to hold')
        return self
