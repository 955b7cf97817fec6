"""Linear constraints between degrees of freedom; dof numbers are 1..6 as in the deck."""

from __future__ import annotations

from dataclasses import dataclass

from creak.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class KinematicCoupling:
    """The coupled nodes follow the reference node as a rigid body in the listed dofs."""

    name: str
    ref_idx: int
    nodes_idx: IntArray
    dofs: tuple[int, ...]
    where: str = ""


@dataclass(frozen=True)
class DistributingCoupling:
    """The reference node follows the weighted mean motion of the coupled nodes (RBE3)."""

    name: str
    ref_idx: int
    nodes_idx: IntArray
    weights: FloatArray
    dofs: tuple[int, ...] = (1, 2, 3, 4, 5, 6)
    where: str = ""


@dataclass(frozen=True)
class RigidLink:
    """Two-node link. `beam`: dependent follows as a rigid body; `tie`: all six dofs equal;
    `pin`: the three translations equal."""

    kind: str
    dependent_idx: int
    independent_idx: int
    where: str = ""


@dataclass(frozen=True)
class Equation:
    """sum_k coefficient_k u(node_k, dof_k) = 0; the first term is eliminated."""

    nodes_idx: IntArray
    dofs: IntArray
    coefficients: FloatArray
    where: str = ""


@dataclass(frozen=True)
class Tie:
    """A node joined to a point of a facet (or edge) between other nodes: u = sum_k w_k (u_k + theta_k x arm)."""

    name: str
    node_idx: int
    """The secondary node; its dofs are eliminated."""
    nodes_idx: IntArray
    """(k,) main nodes."""
    weights: FloatArray
    """(k,) shape functions of the facet at the point; they sum to one."""
    arm: FloatArray
    """(3,) from the point to the secondary node."""
    rotations: bool = True
    """Whether theta = sum_k w_k theta_k as well."""
    where: str = ""


Constraint = KinematicCoupling | DistributingCoupling | RigidLink | Equation | Tie


@dataclass(frozen=True)
class Fixed:
    """Dofs held at zero."""

    nodes_idx: IntArray
    dofs: tuple[int, ...]
    where: str = ""
