"""*DLOAD and *DSLOAD: gravity, and pressure on shells and faces of solids."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.mesh.elements import Elements
from creak.formats.abaqus.mesh.sets import IS_SHELL, RawSurface, faces_named, facets_of
from creak.formats.abaqus.text.fields import Registry, to_float
from creak.formats.abaqus.text.lexer import Block
from creak.formats.deck.pressure import Pressed, nodal_forces, point_loads
from creak.model.faces import shapes_of
from creak.model.steps import PointLoad

_FACES = {f"P{k}": f"S{k}" for k in range(1, 7)}


@dataclass(frozen=True)
class Bodies:
    """What gravity and pressure act on."""

    coords: FloatArray
    elements: Elements
    names: Registry
    """Elements and their sets."""
    surfaces: Mapping[str, RawSurface]

    @property
    def count(self) -> int:
        return int(self.elements.ids.size)


Gravity = dict[str, tuple[IntArray, FloatArray, str]]
"""Set -> its elements, their acceleration (3,), and where it stands; later ones of a set replace those before."""


def gravity_of(block: Block, bodies: Bodies) -> Gravity:
    """What the GRAV lines of a *DLOAD give; lines of one set add up.

    Raises
    ------
    InputError : without magnitude or direction.
    """
    found: Gravity = {}
    for fields, where in block.rows():
        if _label(fields) != "GRAV":
            continue
        name = fields[0].strip().upper()
        numbers = [to_float(f, where, "gravity") for f in fields[2:6]]
        if len(numbers) < 4 or not any(numbers[1:]):
            raise InputError(
                "gravity without magnitude and direction", expected="magnitude, x, y, z", where=where, fix="Add them."
            )
        direction = np.array(numbers[1:])
        rows = bodies.names.find(name, "", where) if name else np.arange(bodies.count)
        before = found[name][1] if name in found else np.zeros(3)
        found[name] = rows, before + numbers[0] * direction / np.linalg.norm(direction), where
    return found


def together(gravity: Gravity, bodies: Bodies) -> FloatArray:
    """(3,) acceleration of all elements that have mass.

    Raises
    ------
    InputError : it is not the same on all of them.
    """
    each, heavy = np.zeros((bodies.count, 3)), bodies.elements.heavy
    for rows, acceleration, _ in gravity.values():
        each[rows] += acceleration
    first = each[heavy][0] if heavy.any() else np.zeros(3)
    other = np.flatnonzero(heavy & ~np.isclose(each, first, rtol=1e-9, atol=0.0).all(axis=1))
    if other.size:
        name, (_, _, where) = next((n, one) for n, one in gravity.items() if n)
        raise InputError(
            f"gravity on {name} alone, which are not all elements: element {bodies.elements.ids[other[0]]} has another",
            expected="the same gravity on all elements, in one line or set by set",
            where=where,
            fix="Leave the set out.",
        )
    return np.asarray(first)


def pressures_of(block: Block, bodies: Bodies) -> dict[tuple[str, str], list[PointLoad]]:
    """Forces of each line of pressure under its set (surface) and label: P along the normal of shells, P1 to P6 into
    faces of solids; of *DSLOAD P, onto the side of the surface.

    Raises
    ------
    InputError : another load, an unknown set or surface, elements that do not have it, a shell surface without a side.
    """
    found: dict[tuple[str, str], list[PointLoad]] = {}
    for fields, where in block.rows():
        label, name = _label(fields), fields[0].strip().upper()
        if label == "GRAV" and block.name == "DLOAD":
            continue
        if label != "P" and (label not in _FACES or block.name == "DSLOAD"):
            raise InputError(
                f"*{block.name} with {fields[1].strip() if len(fields) > 1 else 'nothing'}",
                expected="GRAV, P, or P1 to P6" if block.name == "DLOAD" else "P",
                where=where,
                fix="creak reads gravity and pressure: write others as forces at nodes.",
            )
        value = to_float(fields[2] if len(fields) > 2 else "", where, "pressure")
        corners, sign = _on_surface(name, bodies, where) if block.name == "DSLOAD" else _on(name, label, bodies, where)
        faces = shapes_of(corners, bodies.elements.with_facets)
        pressure = np.repeat(sign[:, None] * value, faces.nodes.shape[1], axis=1)
        pressed = Pressed(faces, pressure, np.full((len(corners), 3), np.nan))
        loads = point_loads(*nodal_forces(pressed, bodies.coords), f"{name} {label}", where)
        found.setdefault((name, label), []).extend(loads)
    return found


def _label(fields: list[str]) -> str:
    return fields[1].strip().upper() if len(fields) > 1 else ""


def _on(name: str, label: str, bodies: Bodies, where: str) -> tuple[IntArray, FloatArray]:
    rows = bodies.names.find(name, "", where)
    if label in _FACES:
        chosen = faces_named(rows, _FACES[label], where, bodies.elements)
        return facets_of(bodies.elements, chosen[:, 0], chosen[:, 1])[2], -np.ones(len(chosen))
    shell = IS_SHELL[bodies.elements.type_idx[rows]]
    if not shell.all():
        row = int(rows[int(np.argmin(shell))])
        raise InputError(
            f"*DLOAD P on element {bodies.elements.ids[row]} ({bodies.elements.of(row).name}), which is no shell",
            expected="shells; P1 to P6 on solids",
            where=where,
            fix="Correct the label.",
        )
    corners = facets_of(bodies.elements, rows, np.zeros_like(rows))[2]
    return corners, np.ones(len(corners))


def _on_surface(name: str, bodies: Bodies, where: str) -> tuple[IntArray, FloatArray]:
    surface = bodies.surfaces.get(name)
    if surface is None or not surface.element_rows.size:
        raise InputError(
            f"*DSLOAD on unknown surface {name!r}" if surface is None else f"*DSLOAD on {name!r}, which has no facets",
            expected="a surface of shells or faces of solids",
            where=where,
            fix=suggest(name, bodies.surfaces),
        )
    shell = IS_SHELL[bodies.elements.type_idx[surface.element_rows]]
    if (shell & (surface.side == 0)).any():
        raise InputError(
            f"*DSLOAD on surface {name!r}, whose shells have no side",
            expected="SPOS or SNEG",
            where=where,
            fix="Name the side in *SURFACE.",
        )
    return surface.corners, np.where(shell, -surface.side, -1.0)
