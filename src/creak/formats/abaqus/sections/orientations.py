"""*ORIENTATION: axes of materials, connectors and couplings; *DISTRIBUTION: values element by element, for them and for
shell thickness."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.mesh.directions import LocalSystem, turned_about
from creak.formats.abaqus.text.fields import Registry, floats, lookup, qualified, to_float, to_int
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, Scope

WIDTH = {"COORD3D": 3, "LENGTH": 1, "RATIO": 1, "ANGLE": 1, "AREA": 1, "DENSITY": 1, "MODULUS": 1}
"""Numbers of each word of a *DISTRIBUTION TABLE."""


@dataclass(frozen=True, eq=False)
class Distribution:
    """Values of elements."""

    values: FloatArray
    """(n_elem, k) rows as the element table; the default where the deck gives none."""
    words: tuple[str, ...]
    """What the k numbers are: COORD3D, LENGTH, ..."""
    where: str


Distributions = dict[str, Distribution | InputError]
"""Qualified name -> distribution, or what is wrong with it: only those that something uses must be right."""


def read_distributions(deck: Outline, elements: Registry, n_elem: int) -> Distributions:
    """Distributions over elements by qualified name: a default on the first data line, then element or set, values."""
    tables = {
        qualified(scope.name, block.need("NAME")): (block, tuple(" ".join(f.upper().split()) for f in fields))
        for scope, block in deck.blocks("DISTRIBUTION TABLE")
        for fields, _ in [next(iter(block.rows()), ([], ""))]
    }
    found: Distributions = {}
    for scope, block in deck.blocks("DISTRIBUTION"):
        try:
            one: Distribution | InputError = _distribution(deck, scope, block, tables, elements, n_elem)
        except InputError as error:
            one = error
        found[qualified(scope.name, block.need("NAME"))] = one
    return found


def find_distribution(
    name: str, known: Distributions, scope: Scope, deck: Outline, words: tuple[str, ...], where: str
) -> Distribution | None:
    """The distribution of a name, None where there is none of it.

    Raises
    ------
    InputError : its lines are wrong, or it is of other quantities than `words`.
    """
    found = lookup(known, name, scope.name, deck.assembly)
    if isinstance(found, InputError):
        raise found
    if found is not None and found.words != words:
        raise InputError(
            f"distribution {name!r} is of {', '.join(found.words) or 'nothing'}",
            expected=", ".join(words),
            where=where,
            fix="Name another distribution, or correct its *DISTRIBUTION TABLE.",
        )
    return found


def _distribution(
    deck: Outline,
    scope: Scope,
    block: Block,
    tables: dict[str, tuple[Block, tuple[str, ...]]],
    elements: Registry,
    n_elem: int,
) -> Distribution:
    entry = lookup(tables, block.need("TABLE"), scope.name, deck.assembly)
    if entry is None:
        raise block.error(
            f"unknown *DISTRIBUTION TABLE {block.get('TABLE')!r}", fix=suggest(block.get("TABLE"), tables)
        )
    words = entry[1]
    if block.option("LOCATION", "ELEMENT") != "ELEMENT" or not words or any(w not in WIDTH for w in words):
        raise block.error(
            f"*DISTRIBUTION, LOCATION={block.option('LOCATION', 'ELEMENT')} of {', '.join(words) or 'nothing'}",
            expected=f"LOCATION=ELEMENT, and a table of {', '.join(WIDTH)}",
            fix="Give thickness at nodes by *NODAL THICKNESS.",
        )
    n = sum(WIDTH[w] for w in words)
    values = np.full((n_elem, n), np.nan)
    for fields, where in block.rows():
        numbers = floats(fields[1:], where, "value of the distribution", n)
        rows = elements.find(fields[0], scope.name, where) if fields[0] else slice(None)
        values[rows] = numbers
    return Distribution(values, words, block.where)


_KINDS = {"RECTANGULAR": "R", "CYLINDRICAL": "C", "SPHERICAL": "S", "Z RECTANGULAR": "Z"}


@dataclass(frozen=True, eq=False)
class Orientation:
    """A local system and a further turn about one of its axes."""

    system: LocalSystem
    about: int = 1
    """Axis of the further rotation; of shells, the one next to the normal."""
    degrees: float = 0.0

    frames: FloatArray | None = None
    """(n_elem, 3, 3) axes of each element of the deck, where a *DISTRIBUTION gives them."""

    def axes(self, points: FloatArray) -> FloatArray:
        """(n, 3, 3): rows are axes 1, 2, 3 at points (n, 3), in global components.

        Raises
        ------
        InputError : the axes are those of elements (`of_elements`).
        """
        if self.frames is not None:
            raise InputError(
                "an orientation by a *DISTRIBUTION where there are no elements of a section",
                expected="an orientation by points",
                where=self.system.where,
                fix="Write the axes by their points.",
            )
        return turned_about(self.system.axes(points), self.about, self.degrees)

    def of_elements(self, rows: IntArray, points: FloatArray) -> FloatArray:
        """(n, 3, 3) of elements, rows of the element table, with their middles at `points`."""
        if self.frames is None:
            return self.axes(points)
        if np.isnan(self.frames[rows]).any():
            raise InputError(
                "a *DISTRIBUTION gives no axes to some elements of a section",
                expected="a default on its first data line, or a line for each element",
                where=self.system.where,
                fix="Add the elements.",
            )
        return turned_about(self.frames[rows], self.about, self.degrees)

    def shell_axis1(self, rows: IntArray, points: FloatArray) -> FloatArray:
        """(n, 3): what is projected on a shell to give its material direction 1: the axis after `about`, cyclic."""
        return self.of_elements(rows, points)[:, self.about % 3]


Orientations = dict[str, Orientation | InputError]
"""Qualified name -> orientation, or what is wrong with it: only those that something uses must be right."""


def read_orientations(
    deck: Outline, nodes: Registry, coords: FloatArray, distributions: Distributions | None = None
) -> Orientations:
    """Orientations by qualified name; those of a part turn and move with each instance.

    SYSTEM=RECTANGULAR: a point on axis 1, one in the 1-2 plane and the origin; Z RECTANGULAR: one on axis 3, one in
    the 1-3 plane; CYLINDRICAL: two points of the polar axis; SPHERICAL: centre and a point of the polar axis. The
    points are coordinates or (DEFINITION=NODES) nodes, or the name of a *DISTRIBUTION of the first two of them.
    Second line: axis of a further rotation, degrees.

    Raises
    ------
    InputError : a name used twice.
    """
    result: Orientations = {}
    for scope, block in deck.blocks("ORIENTATION"):
        key = qualified(scope.name, block.need("NAME"))
        if key in result:
            raise block.error(f"orientation {key!r} is defined twice", fix="Rename one of them.")
        try:
            given = _distributed(deck, scope, block, distributions or {})
            result[key] = _orientation(scope, block, nodes, coords) if given is None else given
        except InputError as error:
            result[key] = error
    return result


def _distributed(deck: Outline, scope: Scope, block: Block, known: Distributions) -> Orientation | None:
    """Axes element by element, where the first data line names a distribution of two points each."""
    rows = list(block.rows())
    if not rows or len(rows[0][0]) != 1 or block.option("DEFINITION", "COORDINATES") != "COORDINATES":
        return None
    found = find_distribution(rows[0][0][0], known, scope, deck, ("COORD3D", "COORD3D"), block.where)
    if found is None:
        return None
    kind = block.option("SYSTEM", "RECTANGULAR")
    if kind not in ("RECTANGULAR", "Z RECTANGULAR"):
        raise block.error(
            f"*ORIENTATION, SYSTEM={kind} by a distribution",
            expected="SYSTEM=RECTANGULAR",
            fix="Write the axes as rectangular systems.",
        )
    first, second = found.values[:, :3], found.values[:, 3:]
    third = np.cross(first, second)
    length = np.linalg.norm(third, axis=1)
    if (length <= 1e-12 * np.linalg.norm(first, axis=1) * np.linalg.norm(second, axis=1)).any():
        raise InputError("axes of a distribution are parallel or zero", where=found.where, fix="Correct its lines.")
    one = first / np.linalg.norm(first, axis=1)[:, None]
    three = third / length[:, None]
    frames = np.stack([one, np.cross(three, one), three], axis=1)
    if kind == "Z RECTANGULAR":
        frames = np.stack([frames[:, 1], frames[:, 2], frames[:, 0]], axis=1)
    about, degrees = _further_turn(rows)
    fixed = LocalSystem("R", np.eye(3)[0], np.eye(3)[1], block.where)
    return Orientation(fixed, about, degrees, frames @ scope.rotation.T)


def find_orientation(name: str, known: Orientations, scope: Scope, deck: Outline, where: str) -> Orientation:
    """The orientation of a name.

    Raises
    ------
    InputError : there is none, or it is of another system or definition, or its points define no system.
    """
    found = lookup(known, name, scope.name, deck.assembly)
    if found is None:
        raise InputError(f"unknown orientation {name!r}", where=where, fix=suggest(name, known))
    if isinstance(found, InputError):
        raise found
    return found


def constant_axes(
    deck: Outline, scope: Scope, block: Block, known: Orientations, fix: str = "Use a rectangular system."
) -> FloatArray | None:
    """(3, 3) axes of all that a keyword makes: ORIENTATION= or a rotated instance; None for global ones.

    Raises
    ------
    InputError : an orientation that is none, or not rectangular.
    """
    if not block.get("ORIENTATION"):
        return scope.rotation.T if scope.rotated else None
    orientation = find_orientation(block.get("ORIENTATION"), known, scope, deck, block.where)
    if orientation.system.kind != "R":
        raise block.error(
            f"*{block.name} with an orientation that is not rectangular", expected="SYSTEM=RECTANGULAR", fix=fix
        )
    return orientation.axes(np.zeros((1, 3)))[0]


def _orientation(scope: Scope, block: Block, nodes: Registry, coords: FloatArray) -> Orientation:
    kind = _KINDS.get(block.option("SYSTEM", "RECTANGULAR"))
    definition = block.option("DEFINITION", "COORDINATES")
    rows = list(block.rows(blanks=True))
    if kind is None or definition not in ("COORDINATES", "NODES") or not rows:
        raise block.error(
            f"*ORIENTATION, SYSTEM={block.option('SYSTEM', 'RECTANGULAR')}, DEFINITION={definition} is not supported",
            expected=f"SYSTEM={', '.join(_KINDS)}; DEFINITION=COORDINATES or NODES; a data line",
            fix="Write the system by the coordinates of its points.",
        )
    fields, where = rows[0]
    if definition == "NODES":
        found = [nodes.find(f, scope.name, where) for f in fields[:3]]
        points = [coords[int(r[0])] for r in found]
        points += [np.zeros(3)] * (3 - len(points))
    else:
        points = list(np.array(floats(fields, where, "point of the orientation", 9)).reshape(3, 3))
    a, b, origin = points
    if kind in ("R", "Z"):
        a, b = a - origin, b - origin
    system = _z_first(a, b, where) if kind == "Z" else LocalSystem(kind, a, b, where)
    if definition != "NODES":
        system = system.moved(scope.rotation, scope.origin)
    about, degrees = _further_turn(rows)
    return Orientation(system, about, degrees)


def _z_first(a: FloatArray, b: FloatArray, where: str) -> LocalSystem:
    """Axis 3 along a, axis 1 in the plane of a and b."""
    frame = LocalSystem("R", a, b, where).axes(np.zeros((1, 3)))[0]
    return LocalSystem("R", frame[1], frame[2], where)


def _further_turn(rows: list[tuple[list[str], str]]) -> tuple[int, float]:
    if len(rows) < 2 or not rows[1][0]:
        return 1, 0.0
    fields, where = rows[1]
    about = to_int(fields[0], where, "axis of the additional rotation") if fields[0] else 1
    if about not in (1, 2, 3):
        raise InputError(
            f"additional rotation about axis {about}", expected="1, 2 or 3", where=where, fix="Correct the line."
        )
    return about, to_float(fields[1] if len(fields) > 1 else "", where, "additional rotation")
