"""Sections -> property cards, and which elements each holds."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from creak.arrays import FloatArray
from creak.formats.deck.refusals import unwritable
from creak.formats.nastran.mesh.solids import NETWORKS
from creak.formats.nastran.write.equivalent import by_plies, is_rod
from creak.formats.nastran.write.fields import Field, card
from creak.formats.nastran.write.materials import SAME, Materials
from creak.formats.written_deck import inverted
from creak.model.materials import (
    AxialSpring,
    BeamSection,
    Bushing,
    GeneralShell,
    ShellSection,
    SolidSection,
    TrussSection,
)
from creak.model.mesh import ElementBlock, Model

_NAME = re.compile(r"(?:PSHELL|PCOMPG?|PSOLID|PBARL?|PBEAML?|PROD|PTUBE|PBUSH|PVISC) (\d+)")


@dataclass
class Properties:
    """Ids of properties, and their elements as (row of block, row of element)."""

    model: Model
    materials: Materials
    ids: dict[tuple[object, ...], int] = field(default_factory=dict)
    members: dict[int, list[tuple[int, int]]] = field(default_factory=dict)
    cards: dict[int, list[str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Ids of `PID_n` sets are for the properties that hold the same elements and no other."""
        self.sets = {
            name: set(map(tuple, rows.tolist()))
            for name, rows in self.model.element_sets.items()
            if name.startswith("PID_")
        }
        wanted: dict[int, dict[tuple[object, ...], set[tuple[int, int]]]] = {}
        for b, block in enumerate(self.model.blocks):
            match = _NAME.fullmatch(block.section.name)
            if match and has_property(block):
                rows = {(b, k) for k in range(block.ids.size)}
                wanted.setdefault(int(match.group(1)), {}).setdefault((id(block.section),), set()).update(rows)
        self.kept = {
            key: n
            for n, keys in wanted.items()
            if len(keys) == 1
            for key, rows in keys.items()
            if self.sets.get(f"PID_{n}", rows) == rows
        }
        self.reserved = {int(n[4:]) for n in self.sets if n[4:].isdigit()} | set(self.kept.values())

    def put(self, b: int, rows: list[int], key: object = None, axes: int = 0) -> int:
        """Id of the property of some elements of a block; `key` and `axes` (PSOLID: CORDM) tell several apart."""
        section = self.model.blocks[b].section
        full = (id(section), key)
        if full not in self.ids:
            kept = self.kept.pop((id(section),), 0)
            identifier = kept or max(self.reserved, default=0) + 1
            self.reserved.add(identifier)
            self.ids[full] = identifier
            self.cards[identifier] = list(self._lines(self.model.blocks[b], identifier, axes))
        identifier = self.ids[full]
        self.members.setdefault(identifier, []).extend((b, k) for k in rows)
        return identifier

    def _lines(self, block: ElementBlock, pid: int, axes: int) -> Iterator[str]:
        name, fields = _fields(block, self.materials, axes)
        yield from card(name, [pid, *fields])


def has_property(block: ElementBlock) -> bool:
    """Whether its elements refer to a property card."""
    section = block.section
    kinds = ShellSection | GeneralShell | BeamSection | TrussSection | SolidSection | Bushing | AxialSpring
    return isinstance(section, kinds)


def _fields(block: ElementBlock, materials: Materials, axes: int) -> tuple[str, list[Field]]:
    section = block.section
    if isinstance(section, ShellSection):
        mid = materials.sheet_id(section.material)
        return "PSHELL", [mid, section.thickness, mid, None, mid, None, section.area_mass or None]
    if isinstance(section, GeneralShell):
        if by_plies(block):
            return "PCOMP", _plies(section, materials)
        return "PSHELL", _by_matrices(section, materials)
    if isinstance(section, SolidSection):
        points, scheme = NETWORKS.get(block.kind) or (None, None)
        return "PSOLID", [materials.id_of(section.material), axes, points, None, scheme]
    if isinstance(section, TrussSection):
        return "PROD", [materials.id_of(section.material), section.area, 0.0]
    if isinstance(section, BeamSection):
        return _beam(section, materials)
    if isinstance(section, AxialSpring):
        return "PVISC", [section.damping]
    assert isinstance(section, Bushing)
    return "PBUSH", _bushing(section, materials)


def _plies(section: GeneralShell, materials: Materials) -> list[Field]:
    total = sum(p.thickness for p in section.plies)
    bottom = None if section.bottom == -0.5 * total else section.bottom
    heat = section.expansion
    reference, loss = heat.reference if heat else None, materials.damping.loss(section.beta)
    fields: list[Field] = [bottom, section.area_mass or None, None, None, reference, loss, None]
    for p in section.plies:
        degrees = inverted(math.radians, p.angle, math.degrees(p.angle))
        fields += [materials.sheet_id(p.material), p.thickness, degrees, None]
    return fields


def _by_matrices(section: GeneralShell, materials: Materials) -> list[Field]:
    """MAT2 each: N = T G1 e - T^2 G4 k, M = -T^2 G4 e + T^3/12 G2 k, Q = T G3 gamma, k = de/dz."""
    t = section.thickness
    rotary = section.rotary_inertia * 12.0 / t**3
    if section.offset or abs(section.first_moment) > SAME * section.mass * t:
        why = "PSHELL has no offset; its middle surface lies beside the nodes, and no plies say how"
        raise unwritable(f"shell section {section.name!r}", why)
    if abs(section.mass - rotary * t) > SAME * section.mass:
        raise unwritable(f"shell section {section.name!r}", "its rotary inertia is not that of its mass")
    mids: list[Field] = [
        materials.matrix_id(section.A / t, rotary, section),
        t,
        materials.matrix_id(section.D * 12.0 / t**3, rotary, section),
        None,
        materials.matrix_id(section.S / t, rotary, section),
        1.0,
        section.area_mass or None,
        None,
        None,
    ]
    coupled = np.abs(section.B).max() > SAME * math.sqrt(np.abs(section.A).max() * np.abs(section.D).max())
    return [*mids, materials.matrix_id(-section.B / t**2, rotary, section)] if coupled else mids


def _beam(section: BeamSection, materials: Materials) -> tuple[str, list[Field]]:
    """PBAR has no inertia about its axis, PBEAM rho (I1 + I2), as creak reads them."""
    mid, a = materials.id_of(section.material), section.area
    i1, i2, j, nsm = section.i22, section.i11, section.torsion, section.line_mass or None
    if is_rod(section):
        return "PROD", [mid, a, j, None, nsm]
    k1, k2 = (_factor(k, a) for k in (section.shear_area1, section.shear_area2))
    blank: list[Field] = [None] * 8
    if section.twist_inertia == 0.0:
        return "PBAR", [mid, a, i1, i2, j, nsm, None, *blank, k1, k2]
    if section.twist_inertia is not None:
        why = f"its inertia about the axis is {section.twist_inertia:g}; PBAR has none, PBEAM RHO (I1 + I2)"
        raise unwritable(f"beam section {section.name!r}", why)
    return "PBEAM", [mid, a, i1, i2, None, j, nsm, *blank, "YES", 1.0, *blank[:6], *blank, k1, k2]


def _factor(shear_area: float, area: float) -> float:
    return inverted(lambda k: k * area, shear_area, shear_area / area) if shear_area else 0.0


def _bushing(section: Bushing, materials: Materials) -> list[Field]:
    fields: list[Field] = []
    for letter, matrix in (("K", section.stiffness), ("B", section.damping)):
        values: FloatArray = np.diag(matrix)
        if np.any(matrix != np.diag(values)):
            raise unwritable(f"bushing {section.name!r}", "its axes are coupled; PBUSH has one value for each")
        if values.any():
            fields += [letter, *(float(v) or None for v in values), None]
    loss = materials.damping.loss(section.beta)
    return [*fields, "GE", loss] if loss else fields or ["K"]
