"""Materials and sections."""

from __future__ import annotations

from dataclasses import dataclass


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

    @property
    def shear_modulus(self) -> float:
        return self.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))


@dataclass(frozen=True)
class ShellSection:
    """Homogeneous shell, mid-surface at the nodes."""

    name: str
    material: Material
    thickness: float


@dataclass(frozen=True)
class BeamSection:
    """Prismatic beam: area, second moments about local axes 1 and 2, torsion constant, direction of axis 1."""

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
    material: Material


@dataclass(frozen=True)
class PointMass:
    """Concentrated mass (translations), or rotary inertia Ixx, Iyy, Izz, Ixy, Ixz, Iyz in global axes."""

    name: str
    mass: float = 0.0
    inertia: tuple[float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    alpha: float = 0.0
    """Mass-proportional damping, 1/s."""


@dataclass(frozen=True)
class Spring:
    """Spring and dashpot between dof `dof1` of node 1 and `dof2` of node 2 (or ground)."""

    name: str
    dof1: int
    dof2: int = 0
    stiffness: float = 0.0
    damping: float = 0.0


Section = ShellSection | BeamSection | TrussSection | SolidSection | PointMass | Spring
