"""Tables that name nodes and hold them, and of materials and sections of the deck that the study changes."""

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


class PropertyTable(Table):
    """Numbers in place of those of the deck."""

    @property
    def given(self) -> tuple[str, ...]:
        """Keys that have a number."""
        return tuple(sorted(key for key, value in self if value is not None))


class MaterialTable(PropertyTable):
    """[material.NAME]: a material of the deck with other numbers, wherever the deck uses it."""

    youngs_modulus: Positive | None = None
    """force/length^2; of an isotropic material. Poisson's ratio stays, and G follows, also a G of MAT1 of its own."""
    density: Positive | None = None
    """mass/length^3."""

    @model_validator(mode="after")
    def _says_something(self) -> MaterialTable:
        if not self.given:
            raise ValueError("changes nothing: give youngs_modulus or density")
        return self


class SectionTable(PropertyTable):
    """[section.NAME]: a section, property or spring of the deck with another number. NAME may also be that of an
    element set of all its elements, as the title of an LS-DYNA part, or of several."""

    thickness: Positive | None = None
    """length; of a homogeneous shell. Where elements have thicknesses of their own, these grow by the same factor.
    OFFSET of Abaqus is a share of it and follows; Z0 of PCOMP and a transverse shear stiffness of the deck stay."""
    stiffness: Positive | None = None
    """force/length, or moment/rad; of springs."""
    stiffness_factor: Positive | None = None
    """Of a bushing, a connector, a matrix or a laminate, and of springs of one name whose stiffnesses differ: by how
    much it is multiplied."""
    mass: Positive | None = None
    """mass; of each point mass."""

    @model_validator(mode="after")
    def _says_one_thing(self) -> SectionTable:
        if not self.given:
            raise ValueError("changes nothing: give thickness, stiffness, stiffness_factor or mass")
        if len(self.given) > 1:
            first, second, *_ = self.given
            raise ValueError(f"no section has both {first} and {second}")
        return self
