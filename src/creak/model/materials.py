"""Materials and sections."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.model.expansion import Expansion, ShellExpansion

WEAK = 1e-5
"""Bending as a share of that of a sheet, below which a shell is a membrane; readers leave membranes a millionth."""


@dataclass(frozen=True)
class Material:
    """Isotropic linear elastic material with Rayleigh damping."""

    name: str
    youngs_modulus: float
    """force / length^2"""
    poisson_ratio: float
    density: float
    """mass / length^3"""
    alpha: float = 0.0
    """Mass-proportional damping, 1/s: C = alpha M + beta K."""
    beta: float = 0.0
    """Stiffness-proportional damping, s."""
    expansion: Expansion | None = None
    """None: heat does not strain it."""

    @property
    def shear_modulus(self) -> float:
        return self.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))


@dataclass(frozen=True, eq=False)
class AnisotropicMaterial:
    """Linear elastic solid without symmetry; see `model.elasticity.orthotropic`."""

    name: str
    elasticity: FloatArray
    """(6, 6), force / length^2: stresses xx, yy, zz, xy, yz, zx from exx, eyy, ezz, 2 exy, 2 eyz, 2 ezx, in the
    material axes of the element."""
    density: float
    alpha: float = 0.0
    """Mass-proportional damping, 1/s."""
    beta: float = 0.0
    """Stiffness-proportional damping, s."""
    expansion: Expansion | None = None


@dataclass(frozen=True)
class Isotropic:
    """What a sheet was made of whose shear modulus is its own, or that is in plane strain."""

    material: Material
    shear_factor: float = 1.0
    """G over E / (2 (1 + nu))."""
    strained: bool = False
    """Whether it is held along its normal."""


@dataclass(frozen=True, eq=False)
class SheetMaterial:
    """Linear elastic sheet in plane stress; see `model.elasticity.lamina` and `isotropic_sheet`."""

    name: str
    in_plane: FloatArray
    """(3, 3), force / length^2: s11, s22, s12 from e11, e22, 2 e12."""
    shear: FloatArray
    """(2, 2), force / length^2: s13, s23 from 2 e13, 2 e23."""
    density: float
    alpha: float = 0.0
    """Mass-proportional damping, 1/s."""
    beta: float = 0.0
    """Stiffness-proportional damping, s."""
    constants: tuple[float, ...] = ()
    """E1, E2, nu12, G12, G13, G23 that the matrices were made of, for writers; empty: not known."""
    expansion: Expansion | None = None
    isotropic: Isotropic | None = None
    """What all of it follows from; None: from no isotropic material."""


AnyMaterial = Material | AnisotropicMaterial | SheetMaterial


@dataclass(frozen=True)
class Ply:
    """One layer of a laminate."""

    material: AnyMaterial
    thickness: float
    angle: float = 0.0
    """From the material axis 1 of the element to that of the ply, about the normal, radian."""


@dataclass(frozen=True)
class Layup:
    """Plies that a general shell is made of."""

    plies: tuple[Ply, ...]
    """From the bottom up."""
    bottom: float | None = None
    """Height z of the first ply's lower face; None: `offset` says it."""
    offset: float = 0.0
    """Height of the middle surface over the thickness."""
    left: str = ""
    """What is left of the stiffness, as LAM of PCOMP: MEM, BEND or SMEAR; empty: all."""
    beta: float | None = None
    """Stiffness-proportional damping in place of the plies', s."""

    @property
    def materials(self) -> tuple[AnyMaterial, ...]:
        return tuple(p.material for p in self.plies)

    @property
    def single_thickness(self) -> float | None:
        """None: each ply has its own."""
        return self.plies[0].thickness if len(self.plies) == 1 else None


@dataclass(frozen=True)
class Moduli:
    """Materials that the membrane, bending, transverse shear and coupling of a general shell are made of.

    A = t a Q1, D = t^3/12 d Q2, S = s t G3, B = -t^2 Q4, with factors a, d, s, in-plane matrices Q and the transverse
    shear matrix G.
    """

    thickness: float
    base: AnyMaterial
    """Of mass and damping."""
    membrane: tuple[float, AnyMaterial]
    """a and the material of Q1. It expands where a is 1."""
    bending: tuple[float, AnyMaterial]
    """d and the material of Q2."""
    shear: tuple[float, AnyMaterial]
    """s and the material of G3."""
    coupling: AnyMaterial | None = None
    """Of Q4; None: B = 0."""
    turns: bool = True
    """Whether it has the rotary inertia rho t^3/12."""

    @property
    def materials(self) -> tuple[AnyMaterial, ...]:
        coupling = () if self.coupling is None else (self.coupling,)
        return (self.base, self.membrane[1], self.bending[1], self.shear[1], *coupling)

    @property
    def single_thickness(self) -> float:
        return self.thickness


@dataclass(frozen=True)
class ShellSection:
    """Homogeneous isotropic shell, mid-surface at the nodes."""

    name: str
    material: Material
    thickness: float
    area_mass: float = 0.0
    """Further mass per area, through the thickness as the material is; elements with a thickness of their own have no
    more of it."""


@dataclass(frozen=True, eq=False)
class GeneralShell:
    """Shell by its resultants about the surface of the nodes, in the material axes of the element.

    N = A e + B k,   M = B e + D k,   Q = S gamma, with e (e11, e22, 2 e12) and k = de/dz, z along the normal.
    `model.laminates` makes it of plies, of a homogeneous sheet beside the nodes, or of separate moduli.
    """

    name: str
    A: FloatArray
    """(3, 3) membrane, force / length."""
    B: FloatArray
    """(3, 3) coupling, force."""
    D: FloatArray
    """(3, 3) bending, force length."""
    S: FloatArray
    """(2, 2) transverse shear, force / length: Q13, Q23 from the mean 2 e13, 2 e23."""
    mass: float
    """integral of rho dz, mass / length^2."""
    first_moment: float = 0.0
    """integral of rho z dz, mass / length."""
    rotary_inertia: float = 0.0
    """integral of rho z^2 dz, mass."""
    thickness: float = 0.0
    """For contact."""
    offset: float = 0.0
    """Height z of the middle surface, for contact and `area_mass`."""
    alpha: float = 0.0
    """Mass-proportional damping, 1/s."""
    beta: float = 0.0
    """Stiffness-proportional damping, s."""
    plies: tuple[Ply, ...] = ()
    """What the section was made of, from the bottom up, for writers; empty: not known."""
    bottom: float = 0.0
    """Height z of the first ply's lower face."""
    rigid: bool = False
    """Of elements of a rigid body, which have neither mass nor strain: its stiffness is for contact alone."""
    expansion: ShellExpansion | None = None
    """None: heat does not strain it."""
    area_mass: float = 0.0
    """Further mass per area on the middle surface; elements with a thickness of their own have no more of it."""
    made_of: Layup | Moduli | None = None
    """What `model.laminates.remade` makes it again from; None: it was given by its matrices."""
    own_shear: bool = False
    """Whether S is not that of `made_of`."""
    added_density: float = 0.0
    """Mass per volume in `mass` and its moments beside that of `made_of`."""

    @property
    def is_membrane(self) -> bool:
        """Whether its rotations have no stiffness to speak of, and so no mass either."""
        return float(np.trace(self.D)) <= WEAK * float(np.trace(self.A)) * self.thickness**2 / 12.0

    def __post_init__(self) -> None:
        if not all(np.isfinite(m).all() for m in (self.A, self.B, self.D, self.S, self.rotary_inertia)):
            raise InputError(f"shell {self.name!r} is too thick or too stiff to compute with", fix="Check its section.")
        if self.first_moment * self.first_moment > self.mass * self.rotary_inertia * (1.0 + 1e-9):
            raise InputError(
                f"shell {self.name!r}: mass, first moment and rotary inertia are those of no body",
                fix="Check its thickness, offset and density.",
            )


@dataclass(frozen=True)
class BeamSection:
    """Prismatic beam: area, second moments about local axes 1 and 2, torsion constant, direction of axis 1.

    i11 and i22 are about the centroid and principal axes, which lie at `angle` from axes 1 and 2.
    """

    name: str
    material: Material
    area: float
    i11: float
    i22: float
    torsion: float
    axis1: tuple[float, float, float] = (0.0, 0.0, -1.0)
    radius: float = 0.0
    """From the axis to the surface, for contact: radius of circle and pipe, half the smaller side of a rectangle; 0:
    not known."""
    shear_area1: float = 0.0
    """Area over which a shear force along principal axis 1 spreads, k A; 0: rigid in shear (Euler-Bernoulli)."""
    shear_area2: float = 0.0
    """The same along principal axis 2."""
    angle: float = 0.0
    """From axis 1 to principal axis 1 about the tangent, radian."""
    centroid: tuple[float, float] = (0.0, 0.0)
    """Where the centroid lies from the line of the nodes, along axes 1 and 2."""
    shear_centre: tuple[float, float] = (0.0, 0.0)
    """Where the shear centre lies, along axes 1 and 2."""
    line_mass: float = 0.0
    """Further mass per length on the centroid line."""
    twist_inertia: float | None = None
    """Mass moment of inertia per length about the axis; None: rho (i11 + i22)."""
    profile: str = ""
    """Shape that the properties were made of, for writers: RECT, CIRC, ..., GENERAL; empty: not known."""
    dimensions: tuple[float, ...] = ()
    """Its dimensions; of GENERAL area, I11, I12, I22, J."""

    @property
    def polar_inertia(self) -> float:
        """Mass moment of inertia per length about the axis."""
        if self.twist_inertia is not None:
            return self.twist_inertia
        return self.material.density * (self.i11 + self.i22)


@dataclass(frozen=True)
class TrussSection:
    """Bar that carries axial force only."""

    name: str
    material: Material
    area: float


@dataclass(frozen=True)
class SolidSection:
    """Homogeneous solid."""

    name: str
    material: Material | AnisotropicMaterial


@dataclass(frozen=True)
class PointMass:
    """Concentrated mass (translations), or rotary inertia Ixx, Iyy, Izz, Ixy, Ixz, Iyz in global axes."""

    name: str
    mass: float = 0.0
    inertia: tuple[float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    alpha: float = 0.0
    """Mass-proportional damping, 1/s."""
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """From the node to the centre of mass, global axes; the inertia is about that centre."""


@dataclass(frozen=True)
class Spring:
    """Spring and dashpot between dof `dof1` of node 1 and `dof2` of node 2 (or ground)."""

    name: str
    dof1: int
    dof2: int = 0
    stiffness: float = 0.0
    damping: float = 0.0
    beta: float = 0.0
    """Stiffness-proportional damping beside the dashpot, s."""


@dataclass(frozen=True)
class AxialSpring:
    """Spring and dashpot along the line between two nodes."""

    name: str
    stiffness: float = 0.0
    damping: float = 0.0
    beta: float = 0.0
    """As of `Spring`."""


@dataclass(frozen=True, eq=False)
class Bushing:
    """Springs and dashpots in all six relative motions of two nodes (or of one and ground).

    The relative motion is that of rigid arms from both nodes to the point a + location (b - a), in the axes
    `Own.axis1`, `Own.axis2` of the element, or in global axes.
    """

    name: str
    stiffness: FloatArray
    """(6, 6): forces 1, 2, 3 and moments 1, 2, 3 from relative displacements and rotations."""
    damping: FloatArray
    """(6, 6)"""
    location: float = 1.0
    beta: float = 0.0
    """As of `Spring`."""
    made_of: Material | None = None
    """Material to whose moduli the stiffness is proportional, as of a weld; None: it was given."""


@dataclass(frozen=True, eq=False)
class NodalMatrices:
    """Matrices of any size as they are, on (ux, uy, uz, rx, ry, rz) of the nodes in global axes."""

    name: str
    stiffness: FloatArray
    """(d, d)"""
    mass: FloatArray
    """(d, d)"""
    damping: FloatArray
    """(d, d)"""
    alpha: float = 0.0
    """Mass-proportional damping beside the matrix, 1/s."""
    beta: float = 0.0
    """As of `Spring`."""


Structural = ShellSection | GeneralShell | BeamSection | TrussSection | SolidSection
Discrete = Spring | AxialSpring | Bushing | NodalMatrices
Section = Structural | PointMass | Discrete


def rayleigh(section: Section) -> tuple[float, float]:
    """alpha (1/s) and beta (s) of the section's material, or its own: C = alpha M + beta K (+ its dashpot)."""
    if isinstance(section, PointMass):
        return section.alpha, 0.0
    if isinstance(section, Spring | AxialSpring | Bushing):
        return 0.0, section.beta
    source = section if isinstance(section, GeneralShell | NodalMatrices) else section.material
    return source.alpha, source.beta


def has_dashpot(section: Discrete) -> bool:
    """Whether it damps by itself."""
    if isinstance(section, Spring | AxialSpring):
        return section.damping != 0.0
    return bool(section.damping.any())


def has_stiffness(section: Section) -> bool:
    """Whether it resists displacement."""
    if isinstance(section, Spring | AxialSpring):
        return section.stiffness != 0.0
    if isinstance(section, Bushing | NodalMatrices):
        return bool(section.stiffness.any())
    return not isinstance(section, PointMass)


def has_mass(section: Section) -> bool:
    """Whether it resists acceleration."""
    return bool(section.mass.any()) if isinstance(section, NodalMatrices) else not isinstance(section, Discrete)
