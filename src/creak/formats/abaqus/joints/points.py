"""*MASS, *ROTARY INERTIA, *SPRING and *DASHPOT."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.abaqus.sections.materials import RawMaterial
from creak.formats.abaqus.text.fields import floats, to_dof, to_float
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Scope
from creak.model.materials import NodalMatrices, PointMass, Spring


def read_mass(scope: Scope, block: Block, materials: dict[str, RawMaterial]) -> PointMass | NodalMatrices:
    """*MASS: one mass, or (TYPE=ANISOTROPIC) one for each of the axes 1, 2, 3 of its ORIENTATION.

    Raises
    ------
    InputError : negative or missing mass, unknown type.
    """
    kind = block.option("TYPE", "ISOTROPIC")
    if kind not in ("ISOTROPIC", "ANISOTROPIC"):
        raise block.error(f"*MASS, TYPE={kind}", expected="TYPE=ISOTROPIC or ANISOTROPIC", fix="Correct the type.")
    fields, where = _row(block, 0, "the mass")
    if kind == "ANISOTROPIC":
        if _alpha(block):
            raise block.error(
                "*MASS, TYPE=ANISOTROPIC with ALPHA",
                expected="no damping of its own",
                fix="Remove ALPHA, or give one mass for all directions.",
            )
        masses = [_not_negative(f, where, "mass") for f in [*fields, "", ""][:3]]
        none = np.zeros((6, 6))
        return NodalMatrices(block.get("ELSET"), none, np.diag([*masses, 0.0, 0.0, 0.0]), none)
    mass = _not_negative(fields[0], where, "mass")
    return PointMass(block.get("ELSET"), mass=mass, alpha=_alpha(block))


def read_rotary_inertia(scope: Scope, block: Block, materials: dict[str, RawMaterial]) -> PointMass:
    """*ROTARY INERTIA: I11, I22, I33, I12, I13, I23, the entries of the inertia tensor.

    In a rotated instance the tensor turns with the instance, I = R I_part R'; with ORIENTATION= it is left in those
    axes, see `turned_point`.

    Raises
    ------
    InputError : a tensor that is not positive semidefinite.
    """
    fields, where = _row(block, 0, "I11, I22, I33, I12, I13, I23")
    i11, i22, i33, i12, i13, i23 = floats(fields, where, "rotary inertia", 6)
    tensor = np.array([[i11, i12, i13], [i12, i22, i23], [i13, i23, i33]])
    turned = tensor if block.get("ORIENTATION") else scope.rotation @ tensor @ scope.rotation.T
    size = float(np.abs(turned).max())
    if not np.isfinite(turned).all() or (size > 0.0 and np.linalg.eigvalsh(turned / size)[0] < -1e-9):
        raise InputError(
            "the rotary inertia is not that of any body (it has a negative principal value)",
            expected="I11, I22, I33, I12, I13, I23 of a positive tensor",
            where=where,
            fix="Correct the values.",
        )
    return PointMass(block.get("ELSET"), inertia=_six(turned), alpha=_alpha(block))


def _six(tensor: FloatArray) -> tuple[float, float, float, float, float, float]:
    t = [[float(v) for v in row] for row in tensor]
    return t[0][0], t[1][1], t[2][2], t[0][1], t[0][2], t[1][2]


def turned_point(section: PointMass | NodalMatrices, frame: FloatArray) -> PointMass | NodalMatrices:
    """A mass given along the rows of `frame` (3, 3), in global axes."""
    if isinstance(section, PointMass):
        ixx, iyy, izz, ixy, ixz, iyz = section.inertia
        tensor = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
        return replace(section, inertia=_six(frame.T @ tensor @ frame))
    both = np.kron(np.eye(2), frame)
    return replace(section, mass=both.T @ section.mass @ both)


def read_spring(scope: Scope, block: Block, materials: dict[str, RawMaterial]) -> Spring:
    """*SPRING: a line with dof 1 (and dof 2), blank for SPRINGA, then a line with the stiffness."""
    dof1, dof2, value = _dofs_and_value(block, "stiffness")
    return Spring(block.get("ELSET"), dof1, dof2, stiffness=value)


def read_dashpot(scope: Scope, block: Block, materials: dict[str, RawMaterial]) -> Spring:
    """*DASHPOT: a line with dof 1 (and dof 2), blank for DASHPOTA, then a line with the damping coefficient."""
    dof1, dof2, value = _dofs_and_value(block, "damping coefficient")
    return Spring(block.get("ELSET"), dof1, dof2, damping=value)


def turned_spring(spring: Spring, frame: FloatArray, n_node: int) -> NodalMatrices:
    """A spring or dashpot whose dofs are along the rows of `frame` (3, 3), between two nodes or to ground."""
    g = np.zeros((n_node, 2, 3))
    ends = ((spring.dof1, 1.0),) if n_node == 1 else ((spring.dof1, -1.0), (spring.dof2, 1.0))
    for node, (dof, sign) in enumerate(ends):
        g[node, (dof - 1) // 3] = sign * frame[(dof - 1) % 3]
    pattern = np.outer(g.ravel(), g.ravel())
    return NodalMatrices(spring.name, spring.stiffness * pattern, 0.0 * pattern, spring.damping * pattern)


def _dofs_and_value(block: Block, what: str) -> tuple[int, int, float]:
    for param in ("NONLINEAR", "COMPLEX STIFFNESS"):
        if block.has(param):
            raise block.error(
                f"*{block.name} with {param}",
                expected=f"a constant {what}",
                fix="Describe it as a [[connector]] in the study.",
            )
    if block.lines and not block.lines[0]:
        fields, where = _row(block, 0, f"the {what}")
        return 0, 0, to_float(fields[0], where, what)
    fields, where = _row(block, 0, "the degree of freedom")
    dof1 = to_dof(fields[0], where)
    dof2 = to_dof(fields[1], where) if len(fields) > 1 else dof1
    fields, where = _row(block, 1, f"the {what}")
    if len(list(block.rows())) > 2:
        raise InputError(
            f"*{block.name} has more than one {what}",
            expected=f"a line with dofs and a line with the {what}",
            where=list(block.rows())[2][1],
            fix="Keep the one to be analysed.",
        )
    return dof1, dof2, to_float(fields[0], where, what)


def _row(block: Block, number: int, what: str) -> tuple[list[str], str]:
    rows = list(block.rows())
    if len(rows) <= number:
        raise block.error(
            f"*{block.name} has no line with {what}", expected=f"{number + 1} data line(s)", fix="Add it."
        )
    return rows[number]


def _not_negative(field: str, where: str, what: str) -> float:
    value = to_float(field, where, what)
    if value < 0.0 or not field:
        raise InputError(f"{what} is {field or 'missing'}", expected="zero or more", where=where, fix="Correct it.")
    return value


def _alpha(block: Block) -> float:
    return _not_negative(block.get("ALPHA", "0"), block.where, "ALPHA")
