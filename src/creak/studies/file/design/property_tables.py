"""Tables of materials and sections of the deck that the study changes."""

from __future__ import annotations

from pydantic import model_validator

from creak.studies.file.table import Positive, Table


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
