"""Element blocks -> element cards, coordinate systems and the matrices that no element says."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from creak.arrays import FloatArray
from creak.formats.deck.refusals import unwritable
from creak.formats.nastran.mesh.solids import CARD_OF, NETWORKS, ORDER
from creak.formats.nastran.write.equivalent import is_rod
from creak.formats.nastran.write.fields import Field, card
from creak.formats.nastran.write.properties import Properties
from creak.model.faces import N_CORNER, unit, vector_areas
from creak.model.materials import (
    AnisotropicMaterial,
    AxialSpring,
    BeamSection,
    Bushing,
    GeneralShell,
    NodalMatrices,
    PointMass,
    SolidSection,
    Spring,
)
from creak.model.mesh import ElementBlock, Model

_SHELLS = {"quad4": "CQUAD4", "tri3": "CTRIA3", "quad8": "CQUAD8", "tri6": "CTRIA6"}
NORMAL = 1e-9
"""Share by which arms may differ from ones along the normal, and directions from ones in the surface."""


@dataclass
class Systems:
    """CORD2R cards under their ids."""

    ids: dict[tuple[float, ...], int] = field(default_factory=dict)

    def id_of(self, first: FloatArray, second: FloatArray | None = None) -> int:
        """Of the system whose x axis is `first` and whose xy-plane holds `second`; 0: the basic one."""
        x = first / np.linalg.norm(first)
        z = np.cross(x, np.eye(3)[int(np.argmin(np.abs(x)))] if second is None else second)
        z /= np.linalg.norm(z)
        key = (*(z + 0.0).tolist(), *(x + 0.0).tolist())
        if np.array_equal(x, [1.0, 0.0, 0.0]) and (second is None or np.array_equal(z, [0.0, 0.0, 1.0])):
            return 0
        return self.ids.setdefault(key, len(self.ids) + 1)

    def lines(self) -> Iterator[str]:
        for key, identifier in self.ids.items():
            yield from card("CORD2R", [identifier, 0, 0.0, 0.0, 0.0, *key])


def element_lines(model: Model, properties: Properties, systems: Systems) -> Iterator[str]:
    """Cards of all elements but those that only DMIG says, block by block.

    Raises
    ------
    InputError : an element that no card says.
    """
    for b, block in enumerate(model.blocks):
        section = block.section
        if block.kind in _SHELLS:
            yield from _shells(model, b, properties, systems)
        elif block.kind in CARD_OF:
            yield from _solids(model, b, properties, systems)
        elif block.kind in ("beam2", "truss2"):
            yield from _bars(model, b, properties)
        elif isinstance(section, Bushing):
            yield from _bushings(model, b, properties, systems)
        elif isinstance(section, AxialSpring):
            pid = properties.put(b, _all(block))
            yield from _each(model, block, "CVISC", pid)
        elif isinstance(section, Spring):
            yield from _springs(model, block, section, properties.materials.damping.loss(section.beta))
        elif isinstance(section, PointMass):
            for identifier, (row,) in zip(block.ids.tolist(), block.nodes_idx.tolist(), strict=True):
                yield from card("CONM2", [identifier, _grid(model, row), 0, *_mass(section)])
        elif is_conm1(block):
            assert isinstance(section, NodalMatrices)
            lower = section.mass[np.tril_indices(6)].tolist()
            for identifier, (row,) in zip(block.ids.tolist(), block.nodes_idx.tolist(), strict=True):
                yield from card("CONM1", [identifier, _grid(model, row), 0, *lower])
        elif not isinstance(section, NodalMatrices):
            raise unwritable(f"{block.title} of kind {block.kind}", "no card says them")


def is_conm1(block: ElementBlock) -> bool:
    """Whether it is a mass matrix of single nodes."""
    s = block.section
    return isinstance(s, NodalMatrices) and s.mass.shape == (6, 6) and not (s.stiffness.any() or s.damping.any())


def is_matrix(block: ElementBlock) -> bool:
    """Whether its elements are written as matrices on nodes: no card says them."""
    return isinstance(block.section, NodalMatrices) and not is_conm1(block)


def _grid(model: Model, row: int) -> int:
    return int(model.nodes.ids[row])


def _all(block: ElementBlock) -> list[int]:
    return list(range(block.ids.size))


def _each(model: Model, block: ElementBlock, name: str, pid: int) -> Iterator[str]:
    labels = model.nodes.ids[block.nodes_idx]
    for identifier, row in zip(block.ids.tolist(), labels.tolist(), strict=True):
        yield from card(name, [identifier, pid, *row])


def _shells(model: Model, b: int, properties: Properties, systems: Systems) -> Iterator[str]:
    block = model.blocks[b]
    n = N_CORNER[block.kind]
    x = model.nodes.coords[block.nodes_idx[:, :n]]
    general = isinstance(block.section, GeneralShell)
    pid = properties.put(b, _all(block), general and block.own.thickness is not None)
    normal = unit(vector_areas(x))
    directions = _directions(block, x, normal, systems)
    heights = _heights(block, normal)
    base = getattr(block.section, "thickness", 0.0)
    labels = model.nodes.ids[block.nodes_idx].tolist()
    for k, identifier in enumerate(block.ids.tolist()):
        t: list[Field] = [None] * n
        if block.own.thickness is not None:
            t = [_thickness(share, base) for share in _corner_shares(block, n)[k]]
        place: list[Field] = [directions[k], heights[k]]
        fields: list[Field] = [identifier, pid, *labels[k]]
        if block.nodes_idx.shape[1] == n:
            fields += place if t[0] is None else [*place, *[None] * (6 - n), *t]
        else:
            fields += [*t, *place] if n == 4 else [*place, *t]
        yield from card(_SHELLS[block.kind], fields)


def _corner_shares(block: ElementBlock, n: int) -> list[list[float]]:
    """Shares of the thickness at the corners; those at middle nodes must be the means between."""
    assert block.own.thickness is not None
    corner, middle = block.own.thickness[:, :n], block.own.thickness[:, n:]
    if middle.size and np.abs(middle - 0.5 * (corner + np.roll(corner, -1, axis=1))).max() > NORMAL * corner.max():
        raise unwritable(block.title, "T1 to T4 give no thickness at their middle nodes")
    return list(corner.tolist())


def _thickness(share: float, base: float) -> float:
    """T with T / base == share to the last bit where there is one."""
    guess = share * base
    return next((t for t in (guess, np.nextafter(guess, 0.0), np.nextafter(guess, np.inf)) if t / base == share), guess)


def _directions(block: ElementBlock, x: FloatArray, normal: FloatArray, systems: Systems) -> list[Field]:
    """MCID where the block has one direction or they leave the surface, THETA in degrees where they lie in it."""
    axis = block.own.axis1
    if axis is None:
        return [None] * len(x)
    unit = axis / np.linalg.norm(axis, axis=1)[:, None]
    if not np.ptp(unit, axis=0).any():
        return [systems.id_of(unit[0])] * len(x)
    side = x[:, 1] - x[:, 0]
    side = side - np.einsum("ni,ni->n", side, normal)[:, None] * normal
    angle = np.arctan2(np.einsum("ni,ni->n", np.cross(side, unit), normal), np.einsum("ni,ni->n", side, unit))
    inside = np.abs(np.einsum("ni,ni->n", unit, normal)) <= NORMAL
    return [float(np.degrees(angle[k])) if inside[k] else systems.id_of(unit[k]) for k in range(len(x))]


def _heights(block: ElementBlock, normal: FloatArray) -> list[Field]:
    """ZOFFS of arms along the normal."""
    arms = block.own.arms
    if arms is None:
        return [None] * len(normal)
    height = np.einsum("ni,ni->n", arms[:, 0], normal)
    if np.abs(arms - (height[:, None] * normal)[:, None]).max() > NORMAL * max(np.abs(arms).max(), 1e-300):
        raise unwritable(block.title, "their rigid arms are not along the normal (ZOFFS)")
    return [float(h) for h in height]


def _solids(model: Model, b: int, properties: Properties, systems: Systems) -> Iterator[str]:
    block, groups = model.blocks[b], dict[int, list[int]]()
    directed = isinstance(block.section, SolidSection) and isinstance(block.section.material, AnisotropicMaterial)
    if directed:
        assert block.own.axis1 is not None
        assert block.own.axis2 is not None
        for k, (first, second) in enumerate(zip(block.own.axis1, block.own.axis2, strict=True)):
            groups.setdefault(systems.id_of(first, second), []).append(k)
    else:
        groups[0] = _all(block)
    network = NETWORKS.get(block.kind)
    pid = {k: properties.put(b, rows, (axes, network), axes) for axes, rows in groups.items() for k in rows}
    nodes = block.nodes_idx[:, ORDER[block.kind]] if block.kind in ORDER else block.nodes_idx
    labels = model.nodes.ids[nodes].tolist()
    for k, identifier in enumerate(block.ids.tolist()):
        yield from card(CARD_OF[block.kind], [identifier, pid[k], *labels[k]])


def _bars(model: Model, b: int, properties: Properties) -> Iterator[str]:
    block, section = model.blocks[b], model.blocks[b].section
    pid = properties.put(b, _all(block))
    if not isinstance(section, BeamSection) or (is_rod(section) and block.own.arms is None):
        yield from _each(model, block, "CROD", pid)
        return
    name = "CBAR" if section.twist_inertia == 0.0 else "CBEAM"
    labels, arms = model.nodes.ids[block.nodes_idx].tolist(), block.own.arms
    assert block.own.axis1 is not None
    for k, identifier in enumerate(block.ids.tolist()):
        fields: list[Field] = [identifier, pid, *labels[k], *block.own.axis1[k].tolist()]
        if arms is not None and arms[k].any():
            fields += [None, None, None, *(float(v) or None for v in arms[k].ravel())]
        yield from card(name, fields)


def _bushings(model: Model, b: int, properties: Properties, systems: Systems) -> Iterator[str]:
    block, section = model.blocks[b], model.blocks[b].section
    assert isinstance(section, Bushing)
    pid, own = properties.put(b, _all(block)), block.own
    labels, x = model.nodes.ids[block.nodes_idx].tolist(), model.nodes.coords[block.nodes_idx]
    for k, identifier in enumerate(block.ids.tolist()):
        ends = [*labels[k], None][:2]
        line = x[k, -1] - x[k, 0]
        place = section.location if section.location != 0.5 else None
        if own.axis1 is None:
            yield from card("CBUSH", [identifier, pid, *ends, None, None, None, 0, place])
        elif own.axis2 is not None and not np.cross(line, own.axis1[k]).any() and line.any():
            yield from card("CBUSH", [identifier, pid, *ends, *own.axis2[k].tolist(), None, place])
        else:
            cid = systems.id_of(own.axis1[k], None if own.axis2 is None else own.axis2[k])
            yield from card("CBUSH", [identifier, pid, *ends, None, None, None, cid, place])


def _springs(model: Model, block: ElementBlock, section: Spring, loss: float | None) -> Iterator[str]:
    if section.stiffness and section.damping:
        raise unwritable(f"spring {section.name!r}", "it damps as well; Nastran has an element for each")
    name, value = ("CDAMP2", section.damping) if section.damping else ("CELAS2", section.stiffness)
    for identifier, rows in zip(block.ids.tolist(), block.nodes_idx.tolist(), strict=True):
        dofs = (section.dof1, section.dof2 or section.dof1)
        ends = [v for row, dof in zip(rows, dofs, strict=False) for v in (_grid(model, row), dof)]
        fields: list[Field] = [identifier, value, *ends]
        yield from card(name, [*fields, *[None] * (6 - len(fields)), loss] if loss and section.stiffness else fields)


def _mass(section: PointMass) -> list[Field]:
    """M, X1 to X3, I11, I21, I22, I31, I32, I33."""
    xx, yy, zz, xy, xz, yz = section.inertia
    values: list[Field] = [section.mass, *(float(v) or None for v in section.offset), None]
    inertia = (xx, -xy, yy, -xz, -yz, zz)
    return [*values, *(float(v) or None for v in inertia)]
