"""A model of shells, springs and rigid bodies as a deck for CalculiX and as one for MYSTRAN."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.errors import InputError
from creak.formats.abaqus.write.names import vector
from creak.formats.abaqus.writer import deck_lines, runs
from creak.model.constraints import Constraint, KinematicCoupling, RigidLink
from creak.model.materials import NodalMatrices, ShellSection, Spring
from creak.model.mesh import ElementBlock, Model, Nodes

ALL = (1, 2, 3, 4, 5, 6)
K6ROT = 100.0
"""Nastran's usual stiffness of the rotation about the normal, for shells that do not lie in one plane."""
CARDS = {"quad4": "CQUAD4", "tri3": "CTRIA3"}


@dataclass(frozen=True)
class RigidBody:
    """Nodes that follow the first of them."""

    leader: int
    others: IntArray


def rigid_bodies(model: Model) -> list[list[int]]:
    """Node rows of the bodies that kinematic couplings and rigid links make up, those that share nodes being one.

    Raises
    ------
    InputError : another constraint, or one that leaves some of the six dofs free.
    """
    body_of: dict[int, list[int]] = {}
    for c in model.constraints:
        joined = _joined(c)
        for body in [body_of[node] for node in joined if node in body_of]:
            joined = list(dict.fromkeys([*joined, *body]))
        body_of.update(dict.fromkeys(joined, joined))
    return list({id(body): body for body in body_of.values()}.values())


def _joined(c: Constraint) -> list[int]:
    if isinstance(c, KinematicCoupling) and set(c.dofs) == set(ALL):
        return [c.ref_idx, *c.nodes_idx.tolist()]
    if isinstance(c, RigidLink) and c.kind == "beam":
        return [c.independent_idx, c.dependent_idx]
    raise InputError(f"a {type(c).__name__} is no rigid body", where=c.where)


def held(model: Model) -> dict[int, set[int]]:
    """Node row -> its dofs that are held."""
    dofs: dict[int, set[int]] = {}
    for fixed in model.fixed:
        for node in fixed.nodes_idx.tolist():
            dofs.setdefault(node, set()).update(fixed.dofs)
    return dofs


def moving_bodies(model: Model) -> tuple[list[RigidBody], dict[int, set[int]]]:
    """Rigid bodies led by the node that is held, if any, and what is held; a body held whole is held node by node.

    Raises
    ------
    InputError : two nodes of one body are held.
    """
    supports, bodies = held(model), []
    for nodes in rigid_bodies(model):
        ends = [node for node in nodes if node in supports]
        if len(ends) > 1:
            raise InputError("two nodes of a rigid body are held")
        if ends and supports[ends[0]] == set(ALL):
            supports.update((node, set(ALL)) for node in nodes)
        else:
            leader = (ends or nodes)[0]
            bodies.append(RigidBody(leader, np.array([node for node in nodes if node != leader])))
    return bodies, supports


def calculix_deck(model: Model, count: int) -> str:
    """creak's own Abaqus deck of nodes, shells and springs, with CalculiX's rigid bodies and a frequency step.

    Labels have no holes, as CalculiX makes room for every label below the last. A rigid body's rotations are those of
    a further node, dofs 1 to 3. Mass is consistent: CalculiX knows no other.

    Raises
    ------
    InputError : what neither creak's writer nor CalculiX says.
    """
    bodies, supports = moving_bodies(model)
    plain = _numbered(
        replace(
            model,
            blocks=_with_springs(model),
            node_sets={},
            element_sets={},
            surfaces={},
            constraints=(),
            fixed=(),
            initial_velocity=(),
            mass_form="consistent",
        )
    )
    lines, conditions, rotation = deck_lines(plain), [], plain.nodes.count
    shells = np.unique(np.concatenate([b.nodes_idx.ravel() for b in plain.blocks]))
    for body in bodies:
        rotation += 1
        lines += ["*NODE", f"{rotation}, {vector(model.nodes.coords[body.leader])}"]
        members = np.intersect1d(body.others, shells)
        lines += [f"*NSET, NSET=BODY-{rotation}", *(f"{node + 1}," for node in members.tolist())]
        lines.append(f"*RIGID BODY, NSET=BODY-{rotation}, REF NODE={body.leader + 1}, ROT NODE={rotation}")
        dofs = supports.pop(body.leader, set())
        conditions += [f"{body.leader + 1}, {a}, {b}" for a, b in runs(tuple(d for d in dofs if d <= 3))]
        conditions += [f"{rotation}, {a}, {b}" for a, b in runs(tuple(d - 3 for d in dofs if d > 3))]
    conditions += [f"{node + 1}, {a}, {b}" for node, dofs in supports.items() for a, b in runs(tuple(dofs))]
    boundary = ["*BOUNDARY", *conditions] if conditions else []
    return "\n".join([*lines, *boundary, "*STEP", "*FREQUENCY", f"{count}", "*END STEP", ""])


def _numbered(model: Model) -> Model:
    """The same with labels 1, 2, ... of nodes and elements."""
    nodes = Nodes(np.arange(1, model.nodes.count + 1), model.nodes.coords)
    starts = np.cumsum([1, *(b.ids.size for b in model.blocks)])
    numbered = zip(starts.tolist(), model.blocks, strict=False)
    blocks = [replace(b, ids=start + np.arange(b.ids.size)) for start, b in numbered]
    return replace(model, nodes=nodes, blocks=tuple(blocks))


def _with_springs(model: Model) -> tuple[ElementBlock, ...]:
    """Blocks with the matrices between two nodes, added up, as springs along global axes."""
    kept: list[ElementBlock] = []
    between: dict[tuple[int, ...], FloatArray] = {}
    for block in model.blocks:
        if not isinstance(block.section, NodalMatrices) or block.nodes_idx.shape[1] != 2:
            kept.append(block)
            continue
        for nodes in block.nodes_idx.tolist():
            between[tuple(nodes)] = between.get(tuple(nodes), np.zeros((12, 12))) + block.section.stiffness
    return (*kept, *(spring for nodes, K in between.items() for spring in _springs(nodes, K)))


def _springs(nodes: tuple[int, ...], K: FloatArray) -> Iterator[ElementBlock]:
    k = np.diag(K)[:6]
    if not np.allclose(K, np.kron([[1.0, -1.0], [-1.0, 1.0]], np.diag(k)), atol=1e-9 * k.max()):
        raise InputError(f"the springs between nodes {nodes} do not add up to springs along global axes")
    for dof in np.flatnonzero(k) + 1:
        section = Spring(f"SPRING-{nodes[0]}-{dof}", int(dof), int(dof), float(k[dof - 1]))
        yield ElementBlock("spring2", np.zeros(1, dtype=np.int64), np.array([nodes]), section, -1)


def mystran_deck(model: Model, count: int) -> str:
    """A Nastran deck (SOL 103) of a model of isotropic shells and rigid bodies.

    Raises
    ------
    InputError : something else.
    """
    bodies, supports = moving_bodies(model)
    lines = ["SOL 103", "CEND", "TITLE = MODES", "ECHO = NONE", "SUBCASE 1", "  SPC = 1", "  METHOD = 1", "BEGIN BULK"]
    lines += [_card("EIGRL", 1, "", "", count), _card("PARAM", "AUTOSPC", "YES"), _card("PARAM", "K6ROT", K6ROT)]
    for label, x in enumerate(model.nodes.coords.tolist(), start=1):
        lines += [f"{'GRID*':8}{label:16}{'':16}{x[0]:#16.9g}{x[1]:#16.9g}", f"{'*':8}{x[2]:#16.9g}"]
    element = 0
    for number, block in enumerate(model.blocks, start=1):
        lines += _shell_property(block, number)
        for nodes in (block.nodes_idx + 1).tolist():
            element += 1
            lines.append(_card(CARDS[block.kind], element, number, *nodes))
    for body in bodies:
        element += 1
        lines.append(_card("RBE2", element, body.leader + 1, "123456", *(body.others + 1).tolist()))
    lines += [_card("SPC1", 1, "".join(map(str, sorted(dofs))), node + 1) for node, dofs in supports.items()]
    return "\n".join([*lines, "ENDDATA", ""])


def _shell_property(block: ElementBlock, number: int) -> list[str]:
    section = block.section
    if block.kind not in CARDS or not isinstance(section, ShellSection) or block.own.thickness is not None:
        raise InputError(f"elements of kind {block.kind} with a {type(section).__name__}", where=block.where)
    m = section.material
    return [
        _card("PSHELL", number, number, section.thickness, number, "", number),
        _card("MAT1", number, m.youngs_modulus, "", m.poisson_ratio, m.density),
    ]


def _card(name: str, *fields: float | str) -> str:
    """A card in fields of eight columns, eight to a line."""
    words = [f"{_real(f) if isinstance(f, float) else f:<8}" for f in fields]
    lines = ["".join(words[start : start + 8]) for start in range(0, len(words), 8)]
    return "\n".join(f"{name if not k else '+':8}{line}" for k, line in enumerate(lines))


def _real(value: float) -> str:
    """Eight characters of a number, with a decimal point."""
    for digits in range(7, 0, -1):
        text = f"{value:#.{digits}g}".replace("e-0", "e-").replace("e+0", "e+").replace("e", "")
        if len(text) <= 8:
            return text
    raise ValueError(value)
