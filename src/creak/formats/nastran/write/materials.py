"""Materials -> MAT1, MAT2, MAT8, MAT9, and damping -> PARAM."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from creak.arrays import FloatArray
from creak.formats.deck.refusals import unwritable
from creak.formats.nastran.write.fields import Field, card
from creak.model.elasticity import lamina, plane_stress, sheet_matrices
from creak.model.materials import (
    AnisotropicMaterial,
    AnyMaterial,
    GeneralShell,
    Material,
    SheetMaterial,
    has_mass,
    has_stiffness,
    rayleigh,
)
from creak.model.mesh import Model

_NAME = re.compile(r"MAT[1289] (\d+)")
SAME = 1e-12
"""Share by which constants may differ from those of a simpler material."""


@dataclass(frozen=True)
class Damping:
    """C = alpha M + beta K of the whole; with `by_element` each material, spring and bushing has a beta of its own,
    GE / W4 with W4 = 1 rad/s, and `beta` is zero."""

    alpha: float
    beta: float
    by_element: bool

    def loss(self, beta: float) -> float | None:
        """GE of what is damped so."""
        return beta if self.by_element and beta else None

    def lines(self) -> Iterator[str]:
        values = {"ALPHA1": self.alpha, "ALPHA2": self.beta, "W4": 1.0 if self.by_element else 0.0}
        for name, value in values.items():
            if value:
                yield from card("PARAM", [name, value])


def damping_of(model: Model) -> Damping:
    """One alpha for all that has mass; one beta for all that has stiffness, or one for each.

    Raises
    ------
    InputError : alphas that differ: Nastran has one for the whole model.
    """
    alphas, betas = set[float](), set[float]()
    for section in (b.section for b in model.blocks):
        alpha, beta = rayleigh(section)
        if has_mass(section):
            alphas.add(alpha)
        if has_stiffness(section):
            betas.add(beta)
        if isinstance(section, GeneralShell):
            alphas |= {p.material.alpha for p in section.plies}
            betas |= {p.material.beta for p in section.plies}
    alphas, betas = alphas or {0.0}, betas or {0.0}
    if max(alphas) - min(alphas) > SAME * max(alphas):
        raise unwritable(
            "the mass-proportional damping",
            "Nastran has one factor (PARAM,ALPHA1) for all materials and masses, and here they "
            f"differ ({min(alphas):g} to {max(alphas):g} 1/s); give [damping] in the study instead",
        )
    one = max(betas) - min(betas) <= SAME * max(betas)
    return Damping(max(alphas), max(betas) if one else 0.0, not one)


@dataclass
class Materials:
    """Materials under the ids they are written by; each is written once."""

    damping: Damping
    ids: dict[tuple[object, ...], int] = field(default_factory=dict)
    """Name and fields of a card -> id."""

    def id_of(self, material: AnyMaterial) -> int:
        """Of a material of bars and solids.

        Raises
        ------
        InputError : the material is none that a MAT card can say.
        """
        name, fields = _card_of(material)
        return self._put(name, [*fields, *_expansion(name, material)], material)

    def sheet_id(self, material: AnyMaterial) -> int:
        """Of a material of shells, in plane stress."""
        name, fields = _card_of(_as_sheet(material) if isinstance(material, AnisotropicMaterial) else material)
        return self._put(name, [*fields, *_expansion(name, material)], material)

    def matrix_id(self, matrix: FloatArray, density: float, like: GeneralShell) -> int:
        """Of a MAT2 with a given (3, 3) matrix, or a (2, 2) matrix of transverse shear, damped as `like`."""
        m = matrix
        values = [m[0, 0], m[0, 1], m[0, 2] if len(m) == 3 else None, m[1, 1]]
        values += [m[1, 2], m[2, 2]] if len(m) == 3 else [None, None]
        fields: list[Field] = [None if v is None else float(v) for v in values]
        owner = Material(like.name, 1.0, 0.0, density, like.alpha, like.beta)
        return self._put("MAT2", [*fields, density], owner)

    def _put(self, name: str, fields: Sequence[Field], material: AnyMaterial) -> int:
        loss, at = self.damping.loss(material.beta), {"MAT1": 7, "MAT2": 12, "MAT8": 16, "MAT9": 30}[name]
        if loss is not None:
            fields = [*fields, *[None] * (at - 1 - len(fields)), loss]
        key = (name, *fields)
        if key not in self.ids:
            match, used = _NAME.fullmatch(material.name), set(self.ids.values())
            wanted = int(match.group(1)) if match else 0
            self.ids[key] = wanted if wanted and wanted not in used else max(used, default=0) + 1
        return self.ids[key]

    def lines(self) -> Iterator[str]:
        for (name, *fields), identifier in self.ids.items():
            yield from card(str(name), [identifier, *fields])  # type: ignore[list-item]


def _card_of(material: AnyMaterial) -> tuple[str, list[Field]]:
    """Name and fields after the id, up to the density."""
    rho = float(material.density)
    if isinstance(material, Material):
        if not -1.0 < material.poisson_ratio < 0.5:
            why = f"E and G of {material.youngs_modulus:g} and {material.shear_modulus:g} are those of no isotropic one"
            raise unwritable(f"material {material.name!r}", why)
        return "MAT1", [material.youngs_modulus, None, material.poisson_ratio, rho]
    if isinstance(material, AnisotropicMaterial):
        return "MAT9", [*_upper(material.elasticity), rho]
    if material.constants:
        return "MAT8", [*(float(c) for c in material.constants), rho]
    own_shear = _with_own_shear(material)
    if own_shear:
        return "MAT1", [*own_shear, rho]
    if not _close(material.shear, material.in_plane[:2, :2]):
        why = "its transverse shear is neither that of MAT1, of MAT8 nor of MAT2"
        raise unwritable(f"material {material.name!r}", why)
    return "MAT2", [*_upper(material.in_plane), rho]


_STRAINS = {"MAT1": (0,), "MAT2": (0, 1, 3), "MAT8": (0, 1), "MAT9": (0, 1, 2, 3, 4, 5)}
"""Which strains of `Expansion` follow the density on a card, before TREF."""


def _expansion(name: str, material: AnyMaterial) -> list[Field]:
    """A, A1, ... and TREF; nothing for an expansion that depends on temperature, or of a MAT1 that is not the same in
    all directions."""
    heat = material.expansion
    if heat is None or heat.flaw or (name == "MAT1" and len(set(heat.strain[:3])) > 1):
        return []
    return [*(heat.strain[i] for i in _STRAINS[name]), heat.reference]


def _upper(matrix: FloatArray) -> Iterable[float]:
    return [float(v) for v in matrix[np.triu_indices(len(matrix))]]


def _with_own_shear(material: SheetMaterial) -> list[Field]:
    """E, G and NU of a sheet that is isotropic but for its shear modulus; empty where it is not."""
    m, G = material.in_plane, float(material.in_plane[2, 2])
    nu = float(m[0, 1] / m[0, 0])
    if not 0.0 <= abs(nu) < 0.5:
        return []
    E = float(m[0, 0]) * (1.0 - nu * nu)
    same = plane_stress(Material("", E, nu, 0.0))
    same[2, 2] = G
    return [E, G, nu] if _close(m, same) and _close(material.shear, G * np.eye(2)) else []


def _close(a: FloatArray, b: FloatArray) -> bool:
    return bool(np.abs(a - b).max() <= SAME * np.abs(b).max(initial=0.0))


def _as_sheet(material: AnisotropicMaterial) -> SheetMaterial:
    """In plane stress; orthotropic in its own axes with constants."""
    in_plane, shear = sheet_matrices(material)
    sheet = SheetMaterial(material.name, in_plane, shear, material.density, material.alpha, material.beta)
    flexible = np.linalg.inv(in_plane)
    E1, E2 = 1.0 / flexible[0, 0], 1.0 / flexible[1, 1]
    constants = (E1, E2, -flexible[0, 1] * E1, 1.0 / flexible[2, 2], shear[0, 0], shear[1, 1])
    again = lamina(*(float(c) for c in constants))
    fits = _close(in_plane, again[0]) and _close(shear, again[1])
    return replace(sheet, constants=tuple(float(c) for c in constants)) if fits else sheet
