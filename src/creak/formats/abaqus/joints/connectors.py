"""*CONNECTOR SECTION and *CONNECTOR BEHAVIOR -> bushings and rigid joints, whose components become constraints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError, suggest
from creak.formats.abaqus.mesh.elements import Elements
from creak.formats.abaqus.sections.orientations import Orientations, find_orientation
from creak.formats.abaqus.sections.own_data import Geometry
from creak.formats.abaqus.text.fields import Registry, floats, to_int
from creak.formats.abaqus.text.lexer import Block
from creak.formats.abaqus.text.outline import Outline, Scope
from creak.model.constraints import Constraint, Equation, KinematicCoupling
from creak.model.elasticity import symmetric
from creak.model.materials import AxialSpring, Bushing
from creak.model.mesh import COMMON, Own


@dataclass(frozen=True, eq=False)
class Connector:
    """One element with rigid components."""

    name: str
    nodes_idx: tuple[int, int]
    axes: FloatArray
    """(3, 3)"""
    rigid: frozenset[int]
    location: float
    along: bool
    """LINK: only the distance of the nodes is kept."""
    where: str


def joint_constraints(connectors: tuple[Connector, ...], coords: FloatArray) -> list[Constraint]:
    """Rigid components as constraints between the nodes; node b (the second) is eliminated.

    e_k . (u_b - u_a + ...) = 0 at the point between the nodes that `Bushing` measures at, e_k . (theta_b -
    theta_a) = 0; all of JOIN (and ALIGN) is a kinematic coupling.
    """
    result: list[Constraint] = []
    for c in connectors:
        a, b = c.nodes_idx
        if c.along:
            result.append(_link(c, coords))
        held = set(c.rigid)
        if {1, 2, 3} <= held and c.location == 1.0:
            dofs = (1, 2, 3, 4, 5, 6) if {4, 5, 6} <= held else (1, 2, 3)
            result.append(KinematicCoupling(c.name, a, np.array([b], dtype=np.int64), dofs, c.where))
            held -= set(dofs)
        result += [_component(c, k, coords) for k in sorted(held)]
    return result


def _link(c: Connector, coords: FloatArray) -> Equation:
    a, b = c.nodes_idx
    line = coords[b] - coords[a]
    length = float(np.linalg.norm(line))
    if not length > 0.0:
        raise InputError("a LINK joins coincident nodes", where=c.where, fix="Use JOIN.")
    return _equation(
        [(b, k + 1, float(v)) for k, v in enumerate(line / length)],
        [(a, k + 1, float(-v)) for k, v in enumerate(line / length)],
        c.where,
    )


def _component(c: Connector, k: int, coords: FloatArray) -> Equation:
    a, b = c.nodes_idx
    axis = c.axes[(k - 1) % 3]
    if k > 3:
        turn = [(n, j + 4, s * float(v)) for n, s in ((b, 1.0), (a, -1.0)) for j, v in enumerate(axis)]
        return _equation(turn[:3], turn[3:], c.where)
    point = coords[a] + c.location * (coords[b] - coords[a])
    terms: list[list[tuple[int, int, float]]] = []
    for n, s in ((b, 1.0), (a, -1.0)):
        lever = s * np.cross(point - coords[n], axis)
        terms.append([(n, j + 1, s * float(v)) for j, v in enumerate(axis)])
        terms[-1] += [(n, j + 4, float(v)) for j, v in enumerate(lever)]
    return _equation(terms[0][:3], terms[0][3:] + terms[1], c.where)


def _equation(first: list[tuple[int, int, float]], rest: list[tuple[int, int, float]], where: str) -> Equation:
    """The equation with the largest of its `first` terms in front: that dof is eliminated."""
    ordered = sorted(first, key=lambda t: -abs(t[2])) + rest
    kept = [t for t in ordered if abs(t[2]) > 1e-14]
    nodes, dofs, factors = (np.array(column) for column in zip(*kept, strict=True))
    return Equation(nodes.astype(np.int64), dofs.astype(np.int64), factors.astype(np.float64), where)


_FREE: frozenset[int] = frozenset()
TRANSLATIONAL: Mapping[str, tuple[frozenset[int], float]] = {
    "JOIN": (frozenset({1, 2, 3}), 1.0),
    "CARTESIAN": (_FREE, 1.0),
    "PROJECTION CARTESIAN": (_FREE, 0.5),
    "SLOT": (frozenset({2, 3}), 1.0),
    "SLIDE-PLANE": (frozenset({1}), 1.0),
    "AXIAL": (_FREE, 1.0),
    "LINK": (_FREE, 1.0),
}
"""Kind -> components that are rigid, and where between the nodes the relative displacement is taken: axes that turn
with node a see it at node b (1), axes that turn with both see it half-way (0.5)."""
ROTATIONAL: Mapping[str, frozenset[int]] = {
    "ALIGN": frozenset({4, 5, 6}),
    "REVOLUTE": frozenset({5, 6}),
    "UNIVERSAL": frozenset({5}),
    "CARDAN": _FREE,
    "EULER": _FREE,
    "ROTATION": _FREE,
    "FLEXION-TORSION": _FREE,
    "PROJECTION FLEXION-TORSION": _FREE,
}
ASSEMBLED = {
    "BEAM": ("JOIN", "ALIGN"),
    "WELD": ("JOIN", "ALIGN"),
    "HINGE": ("JOIN", "REVOLUTE"),
    "UJOINT": ("JOIN", "UNIVERSAL"),
    "CYLINDRICAL": ("SLOT", "REVOLUTE"),
    "TRANSLATOR": ("SLOT", "ALIGN"),
    "PLANAR": ("SLIDE-PLANE", "REVOLUTE"),
    "BUSHING": ("PROJECTION CARTESIAN", "PROJECTION FLEXION-TORSION"),
}


@dataclass(frozen=True, eq=False)
class Behaviour:
    """Linear behaviour of a connector in its six components."""

    stiffness: FloatArray
    damping: FloatArray
    rigid: frozenset[int]


NOTHING = Behaviour(np.zeros((6, 6)), np.zeros((6, 6)), _FREE)


@dataclass(frozen=True, eq=False)
class Made:
    """Connectors of one *CONNECTOR SECTION."""

    block: Block
    rows: IntArray
    """Rows of the element table, ascending."""
    section: Bushing | AxialSpring
    own: Own


@dataclass(frozen=True)
class Connectors:
    """Everything that *CONNECTOR SECTION lines describe."""

    sections: tuple[Made, ...]
    rigid: tuple[Connector, ...]


def read_connectors(deck: Outline, elements: Elements, names: Registry, geometry: Geometry) -> Connectors:
    """All connectors, linear about the undeformed state.

    Raises
    ------
    InputError : unknown set, kind, behaviour or orientation; a set of other elements.
    """
    behaviours = read_behaviours(deck)
    made: list[Made] = []
    rigid: list[Connector] = []
    # No element of the deck is in the element sets that Abaqus makes for fasteners.
    of_fasteners = {block.get("ELSET").upper() for _, block in deck.blocks("FASTENER") if block.get("ELSET")}
    for scope, block in deck.blocks("CONNECTOR SECTION"):
        if block.need("ELSET").upper() in of_fasteners:
            continue
        rows = np.sort(names.find(block.need("ELSET"), scope.name, block.where))
        other = [elements.of(int(r)).name for r in rows if elements.of(int(r)).name != "CONN3D2"]
        if other:
            raise block.error(
                f"*CONNECTOR SECTION, ELSET={block.get('ELSET')} holds an element of type {other[0]}",
                expected="CONN3D2",
                fix="Leave it out of the set.",
            )
        nodes = elements.nodes_idx[rows, :2]
        section, own, joints = described(deck, scope, block, nodes, behaviours, geometry)
        made.append(Made(block, rows, section, own))
        rigid += joints
    return Connectors(tuple(made), tuple(rigid))


def described(
    deck: Outline,
    scope: Scope,
    block: Block,
    nodes: IntArray,
    behaviours: Mapping[str, Behaviour],
    geometry: Geometry,
    default: FloatArray | None = None,
) -> tuple[Bushing | AxialSpring, Own, list[Connector]]:
    """Springs and rigid components of a *CONNECTOR SECTION between nodes (n, 2).

    Parameters
    ----------
    default : (n, 3, 3) axes where the section names none; None: those of a rotated instance, or global ones.
    """
    lines = list(block.rows(blanks=True))
    if not lines or not lines[0][0]:
        raise block.error(
            "*CONNECTOR SECTION names no connection type",
            expected="BUSHING, CARTESIAN, CARDAN, BEAM, ...",
            fix="Name it on the data line.",
        )
    translation, rotation = _kinds(*lines[0])
    if translation == "AXIAL" and rotation:
        raise InputError(
            f"connector {block.get('ELSET')!r} combines AXIAL with {rotation}",
            where=lines[0][1],
            expected="AXIAL alone",
            fix="Make two connectors of it.",
        )
    named = default is None or (len(lines) > 1 and lines[1][0] and lines[1][0][0])
    at = geometry.coords[nodes[:, 0]]
    axes = _axes(deck, scope, block, lines[1:], geometry.orientations, at) if named else default
    behaviour = _behaviour(block, behaviours)
    held = behaviour.rigid | ROTATIONAL.get(rotation, _FREE) | TRANSLATIONAL.get(translation, (_FREE, 1.0))[0]
    section, own = _springs(block, translation, rotation, behaviour, held, axes)
    location, link = TRANSLATIONAL.get(translation, (_FREE, 1.0))[1], translation == "LINK"
    frames = np.broadcast_to(np.eye(3), (len(nodes), 3, 3)) if axes is None else axes
    joints = [
        Connector(block.get("ELSET"), (int(a), int(b)), np.array(frame), held, location, link, block.where)
        for (a, b), frame in zip(nodes, frames, strict=True)
        if held or link
    ]
    return section, own, joints


def _axes(
    deck: Outline,
    scope: Scope,
    block: Block,
    lines: list[tuple[list[str], str]],
    orientations: Orientations,
    points: FloatArray,
) -> FloatArray | None:
    """(n, 3, 3) axes at the first nodes: the orientation on the second line, or those of a rotated instance."""
    names = lines[0][0] if lines else []
    if not names or not names[0]:
        return np.broadcast_to(scope.rotation.T, (len(points), 3, 3)) if scope.rotated else None
    if len(names) > 1 and names[1].upper() != names[0].upper():
        why = "creak takes the axes of the first node; those of the second change nothing in small motion"
        deck.note(block, why, changes=False, what="*CONNECTOR SECTION, second orientation")
    return find_orientation(names[0], orientations, scope, deck, lines[0][1]).axes(points)


def _springs(
    block: Block,
    translation: str,
    rotation: str,
    behaviour: Behaviour,
    held: frozenset[int],
    axes: FloatArray | None,
) -> tuple[Bushing | AxialSpring, Own]:
    """Springs and dashpots in the components that are free to move."""
    name = block.get("ELSET")
    if translation == "AXIAL":
        k, c = (float(m[0, 0]) for m in (behaviour.stiffness, behaviour.damping))
        return AxialSpring(name, k, c), COMMON
    active = _active(translation, rotation) - held
    mask = np.array([k in active for k in range(1, 7)], dtype=float)
    both, location = np.outer(mask, mask), TRANSLATIONAL.get(translation, (_FREE, 1.0))[1]
    section = Bushing(name, behaviour.stiffness * both, behaviour.damping * both, location)
    return section, COMMON if axes is None else Own(axis1=axes[:, 0], axis2=axes[:, 1])


def _active(translation: str, rotation: str) -> frozenset[int]:
    """Components that may have springs."""
    own = {1, 2, 3} if translation not in ("", "LINK") else set()
    return frozenset(own | ({4, 5, 6} if rotation else set()))


def _kinds(fields: list[str], where: str) -> tuple[str, str]:
    """Translational and rotational kind, "" for none."""
    words = [" ".join(f.upper().split()) for f in fields if f]
    if len(words) == 1 and words[0] in ASSEMBLED:
        return ASSEMBLED[words[0]]
    translation = [w for w in words if w in TRANSLATIONAL]
    rotation = [w for w in words if w in ROTATIONAL]
    if len(words) != len(translation) + len(rotation) or len(translation) > 1 or len(rotation) > 1:
        known = [*ASSEMBLED, *TRANSLATIONAL, *ROTATIONAL]
        unknown = next((w for w in words if w not in known), ", ".join(words))
        raise InputError(
            f"connection type {unknown!r} is not supported",
            where=where,
            expected=f"one of {', '.join(known)}, or one of each kind",
            fix=suggest(unknown, known),
        )
    return (translation or [""])[0], (rotation or [""])[0]


def _behaviour(block: Block, behaviours: Mapping[str, Behaviour]) -> Behaviour:
    name = block.get("BEHAVIOR")
    if not name:
        return NOTHING
    if name.upper() not in behaviours:
        raise block.error(f"unknown connector behavior {name!r}", fix=suggest(name, behaviours))
    return behaviours[name.upper()]


def read_behaviours(deck: Outline) -> dict[str, Behaviour]:
    """*CONNECTOR BEHAVIOR by name, upper case."""
    result: dict[str, Behaviour] = {}
    for _, block in deck.blocks("CONNECTOR BEHAVIOR"):
        stiffness, damping, rigid = np.zeros((6, 6)), np.zeros((6, 6)), set[int]()
        for option in block.options:
            if option.name == "CONNECTOR ELASTICITY":
                if option.has("RIGID"):
                    rigid |= _rigid_components(option)
                else:
                    _fill(deck, option, stiffness)
            elif option.name == "CONNECTOR DAMPING":
                if option.option("TYPE", "VISCOUS") != "VISCOUS":
                    deck.note(option, "creak reads viscous connector damping", changes=True)
                else:
                    _fill(deck, option, damping)
            elif any(f for fields, _ in option.rows() for f in fields):
                deck.note(option, "creak takes connectors as free of force in the undeformed state", changes=True)
        result[block.need("NAME").upper()] = Behaviour(stiffness, damping, frozenset(rigid))
    return result


def _rigid_components(option: Block) -> set[int]:
    listed = [to_int(f, where, "component") for fields, where in option.rows() for f in fields if f]
    if option.has("COMPONENT"):
        listed.append(to_int(option.get("COMPONENT"), option.where, "component"))
    return set(listed) if listed else {1, 2, 3, 4, 5, 6}


def _fill(deck: Outline, option: Block, matrix: FloatArray) -> None:
    """COMPONENT=k: a number; without COMPONENT the columns of the upper triangle (21 numbers, 8 a line)."""
    rows = list(option.rows())
    if not rows:
        raise option.error(f"*{option.name} has no data line", fix="Add its values.")
    if not option.has("COMPONENT"):
        values = [v for fields, where in rows[:3] for v in floats(fields, where, "connector term", 8)][:21]
        matrix[:] = symmetric([*values, *[0.0] * (21 - len(values))], 6)
        return
    k = to_int(option.get("COMPONENT"), option.where, "component")
    if not 1 <= k <= 6:
        raise option.error(f"connector component {k}", expected="1 to 6", fix="Correct it.")
    if option.has("NONLINEAR"):
        matrix[k - 1, k - 1] = _slope(rows, option)
        why = "creak takes the slope at zero of the curve"
        deck.note(option, why, changes=True, what=f"*{option.name}, NONLINEAR")
    else:
        matrix[k - 1, k - 1] = floats(*rows[0], "connector term", 1)[0]


def _slope(rows: list[tuple[list[str], str]], option: Block) -> float:
    """Slope at zero of a curve of lines: force, relative displacement (or velocity)."""
    points = np.array([floats(fields, where, "point of the curve", 2) for fields, where in rows])
    force, at = points[:, 0], points[:, 1]
    if len(points) < 2 or (np.diff(at) <= 0.0).any():
        raise option.error(
            f"*{option.name}, NONLINEAR is no curve",
            expected="two lines or more, displacements ascending",
            fix="Correct the lines.",
        )
    k = int(np.clip(np.searchsorted(at, 0.0, side="right") - 1, 0, len(at) - 2))
    return float((force[k + 1] - force[k]) / (at[k + 1] - at[k]))
