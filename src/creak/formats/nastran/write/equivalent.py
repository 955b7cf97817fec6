"""A model in the terms of bulk data: the same structure, of the elements and constraints that cards can say."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray
from creak.formats.deck.equations import ZERO
from creak.formats.deck.refusals import unwritable
from creak.formats.nastran.sections.shells import is_directed
from creak.formats.nastran.write.materials import SAME
from creak.model.constraints import Constraint, DistributingCoupling, Equation, KinematicCoupling, RigidLink
from creak.model.faces import SHELL_FACETS, vector_areas
from creak.model.laminates import laminate
from creak.model.materials import (
    AnisotropicMaterial,
    AxialSpring,
    BeamSection,
    Bushing,
    GeneralShell,
    Section,
    ShellSection,
    SolidSection,
    Spring,
)
from creak.model.mesh import ElementBlock, Model, Own

ALONG_X = 1.7e-3
"""Sine of the angle to x below which a normal leaves no direction of x in the surface (0.1 degree)."""


def equivalent(model: Model) -> Model:
    """The model as it is read back from its bulk data, up to rounding and parts.

    Shells of directed sections get the material direction that they have by default; beams whose principal axes or
    centroid are off get turned axes and rigid arms; springs along a line become bushings; ties, and links that are not
    rigid bodies, become equations, whose first coefficient is 1; sets lose nodes that are there twice.

    Raises
    ------
    InputError : a beam whose shear centre is not its centroid.
    """
    made: dict[tuple[object, ...], Section] = {}
    blocks = tuple(_shared(b, _block(b, model.nodes.coords[b.nodes_idx]), made) for b in model.blocks)
    sets = {
        name: np.array(list(dict.fromkeys(rows.tolist())), dtype=np.int64) for name, rows in model.node_sets.items()
    }
    taken = {int(i) for b in blocks for i in b.ids}
    constraints = _named([c for old in model.constraints for c in _constraints(old, model.nodes.coords)], taken)
    return replace(
        model,
        blocks=blocks,
        node_sets={n: rows for n, rows in sets.items() if rows.size},
        constraints=constraints,
        element_sets={name: rows for name, rows in model.element_sets.items() if len(rows)},
        initial_velocity=_by_node(model.initial_velocity),
    )


def _shared(old: ElementBlock, new: ElementBlock, made: dict[tuple[object, ...], Section]) -> ElementBlock:
    """Blocks that shared a section go on to share one."""
    kind = "shell" if new.kind in SHELL_FACETS else new.kind[:4]
    return replace(new, section=made.setdefault((id(old.section), kind, old.own.thickness is None), new.section))


def _block(block: ElementBlock, x: FloatArray) -> ElementBlock:
    section, own = block.section, block.own
    if isinstance(section, ShellSection | GeneralShell):
        axis = _shell_axis(own, x) if is_directed(section) else None
        if isinstance(section, GeneralShell):
            block = _general_shell(block, section if section.thickness else replace(section, thickness=1.0))
        return replace(block, own=Own(axis, None, own.thickness, own.arms))
    if isinstance(section, BeamSection):
        return _beam(block, section, x if own.arms is None else x + own.arms)
    if isinstance(section, SolidSection) and isinstance(section.material, AnisotropicMaterial):
        return replace(block, own=_frames(own, len(x)))
    if isinstance(section, AxialSpring) and section.stiffness:
        first = np.diag([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
        bushing = Bushing(section.name, section.stiffness * first, section.damping * first, 0.5, section.beta)
        line = x[:, 1] - x[:, 0]
        across = np.eye(3)[np.argmin(np.abs(line), axis=1)]
        return replace(block, kind="bush2", section=bushing, own=Own(axis1=line, axis2=across))
    if isinstance(section, Bushing) and own.axis1 is not None:
        if block.kind == "bush2" and _along(own.axis1, x):
            return block
        own, basic = _frames(own, len(x)), _frames(Own(), len(x))
        same = all(np.array_equal(getattr(own, key), getattr(basic, key)) for key in ("axis1", "axis2"))
        return replace(block, own=Own() if same else own)
    if block.kind == "rotary":
        return replace(block, kind="mass")
    if isinstance(section, Spring) and block.kind == "spring1":
        return replace(block, section=replace(section, dof2=0))
    return block


def _general_shell(block: ElementBlock, section: GeneralShell) -> ElementBlock:
    """Of PSHELL the rotary inertia is that of its mass; of membranes none counts, and NSM has none."""
    block, t = replace(block, section=section), section.thickness
    if by_plies(block) or section.offset:
        return block
    if section.is_membrane:
        return replace(block, section=replace(section, rotary_inertia=section.mass * t**2 / 12.0))
    mass = section.rotary_inertia * 12.0 / t**2
    rest = section.mass - mass
    if rest <= SAME * section.mass or block.own.thickness is not None:
        return block
    return replace(block, section=replace(section, mass=mass, area_mass=section.area_mass + rest))


def by_plies(block: ElementBlock) -> bool:
    """Whether plies say all of a general shell, as on PCOMP; else it is written by its matrices."""
    section = block.section
    assert isinstance(section, GeneralShell)
    if not section.plies or block.own.thickness is not None:
        return False
    return _same(section, laminate("", section.plies, section.bottom))


def _same(a: GeneralShell, b: GeneralShell) -> bool:
    matrices = [(a.A, b.A), (a.B, b.B), (a.D, b.D), (a.S, b.S)]
    sizes = [np.abs(a.A).max(), math.sqrt(np.abs(a.A).max() * np.abs(a.D).max()), np.abs(a.D).max(), np.abs(a.S).max()]
    mass = [(a.mass, b.mass), (a.first_moment, b.first_moment), (a.rotary_inertia, b.rotary_inertia)]
    scales = [a.mass, a.mass * a.thickness, a.mass * a.thickness**2]
    return all(np.abs(x - y).max() <= SAME * s for (x, y), s in zip(matrices, sizes, strict=True)) and all(
        abs(x - y) <= SAME * s for (x, y), s in zip(mass, scales, strict=True)
    )


def _shell_axis(own: Own, x: FloatArray) -> FloatArray:
    """The direction given, else global x, or z where x is normal to the element."""
    if own.axis1 is not None:
        return own.axis1
    normal = vector_areas(x)
    across = np.linalg.norm(normal[:, 1:], axis=1) < ALONG_X * np.linalg.norm(normal, axis=1)
    return np.where(across[:, None], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])


def _beam(block: ElementBlock, section: BeamSection, x: FloatArray) -> ElementBlock:
    """Principal axes as axes, the centroid on the line, by rigid arms."""
    if is_rod(section):
        across = np.eye(3)[np.argmin(np.abs(x[:, 1] - x[:, 0]), axis=1)]
        return replace(block, own=replace(block.own, axis1=across))
    if section.centroid != section.shear_centre:
        raise unwritable(f"beam section {section.name!r}", "its shear centre is not its centroid")
    given = np.tile(section.axis1, (len(x), 1)) if block.own.axis1 is None else block.own.axis1
    own = replace(block.own, axis1=given / np.linalg.norm(given, axis=1)[:, None])
    if not section.angle and not any(section.centroid):
        return replace(block, own=own)
    line = x[:, 1] - x[:, 0]
    t = line / np.linalg.norm(line, axis=1)[:, None]
    n2 = np.cross(t, given)
    n2 /= np.linalg.norm(n2, axis=1)[:, None]
    n1 = np.cross(n2, t)
    if any(section.centroid):
        arm = section.centroid[0] * n1 + section.centroid[1] * n2
        own = replace(own, arms=np.repeat(arm[:, None], 2, axis=1) + (0.0 if own.arms is None else own.arms))
    if section.angle:
        own = replace(own, axis1=np.cos(section.angle) * n1 + np.sin(section.angle) * n2)
    plain = replace(section, angle=0.0, centroid=(0.0, 0.0), shear_centre=(0.0, 0.0))
    return replace(block, section=plain, own=own)


def is_rod(section: BeamSection) -> bool:
    """Whether it carries axial force and torque only, as CROD does."""
    bending = section.i11 or section.i22 or section.shear_area1 or section.shear_area2
    return not bending and section.twist_inertia == 0.0 and not any((*section.centroid, *section.shear_centre))


def _frames(own: Own, n: int) -> Own:
    """Axes 1 and 2, perpendicular and of length one; global axes where there are none."""
    if own.axis1 is None:
        return replace(own, axis1=np.tile([1.0, 0.0, 0.0], (n, 1)), axis2=np.tile([0.0, 1.0, 0.0], (n, 1)))
    first = own.axis1 / np.linalg.norm(own.axis1, axis=1)[:, None]
    second = np.eye(3)[np.argmin(np.abs(first), axis=1)] if own.axis2 is None else own.axis2
    third = np.cross(first, second)
    third /= np.linalg.norm(third, axis=1)[:, None]
    return replace(own, axis1=first, axis2=np.cross(third, first))


def _along(axis: FloatArray, x: FloatArray) -> bool:
    """Whether axis 1 of every bushing runs from its first node to its second."""
    line = x[:, -1] - x[:, 0]
    return bool((np.einsum("ni,ni->n", line, axis) > 0.0).all()) and not np.cross(line, axis).any()


def _constraints(c: Constraint, coords: FloatArray) -> Iterator[Constraint]:
    """Rigid bodies and weighted means as they are, all else as equations."""
    if isinstance(c, KinematicCoupling | DistributingCoupling) or (isinstance(c, RigidLink) and c.kind == "beam"):
        yield c
    else:
        yield from (_equation(e) for e in c.equations(coords))


def _equation(e: Equation) -> Equation:
    """Terms of one dof added up, the first coefficient 1, coefficients that are rounding left out."""
    sums: dict[tuple[int, int], float] = {}
    for node, dof, c in zip(e.nodes_idx.tolist(), e.dofs.tolist(), e.coefficients.tolist(), strict=True):
        sums[node, dof] = sums.get((node, dof), 0.0) + c
    names, values = list(sums), np.array(list(sums.values()))
    values = values / values[0] if values[0] else values
    keep = np.flatnonzero(np.abs(values) > ZERO * np.abs(values).max()).tolist()
    nodes, dofs = (np.array([names[k][i] for k in keep], dtype=np.int64) for i in (0, 1))
    return Equation(nodes, dofs, values[keep], e.where)


def _named(constraints: list[Constraint], taken: set[int]) -> tuple[Constraint, ...]:
    """Couplings under the names of their cards: the id they had as a card where it is free, else the next one."""
    kinds = {KinematicCoupling: "RBE2", DistributingCoupling: "RBE3"}
    used, after = set[int](), max(taken, default=0)
    wanted = [re.fullmatch(r"RBE[23] (\d+)", getattr(c, "name", "")) for c in constraints]
    after = max([after, *(int(m.group(1)) for m in wanted if m)])
    out: list[Constraint] = []
    for c, match in zip(constraints, wanted, strict=True):
        if isinstance(c, KinematicCoupling | DistributingCoupling):
            identifier = int(match.group(1)) if match else 0
            if not match or identifier in taken | used:
                after += 1
                identifier = after
            used.add(identifier)
            c = replace(c, name=f"{kinds[type(c)]} {identifier}")
        out.append(c)
    return tuple(out)


def _by_node(velocity: Sequence[tuple[int, int, float]]) -> tuple[tuple[int, int, float], ...]:
    first = {node: k for k, (node, _, _) in reversed(list(enumerate(velocity)))}
    return tuple(sorted((v for v in velocity if v[2]), key=lambda v: (first[v[0]], v[1])))
