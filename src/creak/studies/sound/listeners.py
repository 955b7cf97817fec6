"""Who listens, and to which parts: as the study says, or an occupant's ear off the loudest panel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from creak.arrays import BoolArray, FloatArray
from creak.contact.facets import facets_of
from creak.errors import InputError, suggest
from creak.formats.measured.sofa import head_responses
from creak.model.mesh import Model
from creak.model.skin import Skin, skin_of
from creak.model.units import METRES
from creak.sound.directivity import plane_of
from creak.sound.head import RADIUS, Ears, Head, Sphere, surrounding
from creak.sound.third_octave import UPPER_EDGES
from creak.studies.file.places import Places
from creak.studies.file.sound_tables import UNNAMED, ListenerTable
from creak.studies.sound.rims import Rim, rims_of
from creak.studies.sound.transfers import Transfer, transfer_of

EAR = 0.6
"""m between the loudest panel and the listener where none is given."""
UP = (0.0, 0.0, 1.0)
"""Direction of the top of a head, where none is given."""
ALONG = 1e-3
"""Sine of an angle between two directions that are one."""
OFF = 1.0
"""Longest sides of a facet that a listener must keep from its nodes."""


@dataclass(frozen=True)
class Listener:
    """A point in the air, and what it hears."""

    name: str
    position: FloatArray
    """(3,) in the deck's axes, length."""
    skin: Skin
    """What radiates to it."""
    parts: tuple[str, ...]
    """Names of those parts."""
    given: bool
    """By the study."""
    looks: FloatArray | None = None
    """(3,) direction in which its head looks, of length 1; None: it has none."""
    left: FloatArray | None = None
    """(3,) direction of its left ear."""
    side: int = 0
    """1: only its left ear listens, -1: its right one; 0: neither, or there is no head."""
    transfers: tuple[Transfer, ...] = ()
    """Measured ways to it from some of the parts."""
    measured: Ears | None = None
    """Of its head; None: that is a sphere."""
    hrtf: str = ""
    """File of them."""
    rims: tuple[Rim, ...] = ()
    """Panels that it hears without a wall; all others count as set in one."""

    @property
    def head(self) -> Head | None:
        """Around `position`, with the ear that listens; None: nothing is there."""
        if self.looks is None or self.left is None or not self.side:
            return None
        if self.measured is None:
            return Sphere(self.side * self.left)
        return self.measured.head(self.looks, self.left, self.side)

    def way(self, part: int) -> Transfer | None:
        """What was measured from a part; None: nothing, it is heard as in the open."""
        return next((one for one in self.transfers if one.part == part), None)

    @property
    def ear(self) -> str:
        """Of the one that listens."""
        return {1: "left", -1: "right"}.get(self.side, "")

    @property
    def ears(self) -> tuple[Listener, ...]:
        """Left and right ear by themselves; without a head itself alone."""
        return (self,) if self.left is None else (replace(self, side=1), replace(self, side=-1))


def listeners_of(
    model: Model, tables: Mapping[str, ListenerTable], places: Places, metre: float
) -> tuple[Listener, ...]:
    """Those that the study gives; none where it gives none. metre: m of the deck's length.

    Raises
    ------
    InputError : an unknown part, no part that radiates, a listener on the structure or inside it, a head that touches
        it or that looks along its own top; as `transfer_of`.
    """
    if not tables:
        return ()
    skin = skin_of(model)

    def made(name: str, table: ListenerTable) -> Listener:
        plain = _listener(model, skin, name, table, metre, places)
        measured = tuple(_measured(model, plain, part, table, metre, places) for part in table.transfer)
        if measured and not table.wall:
            raise InputError(
                f"listener {name!r} has transfer functions, and wall = false",
                where=places.where("listener", name, "wall"),
                expected="one of both",
                fix="Leave wall out: what was measured has all around the part in it.",
            )
        twice = [one.part for one in measured]
        if len(set(twice)) < len(twice):
            raise InputError(
                f"listener {name!r} has two transfer functions from one part",
                where=places.where("listener", name, "transfer"),
                expected="one",
                fix="Leave one out.",
            )
        return replace(_with_head(model, skin, plain, table, metre, places), transfers=measured)

    return tuple(made(name, table) for name, table in tables.items())


def _measured(
    model: Model, listener: Listener, part: str, table: ListenerTable, metre: float, places: Places
) -> Transfer:
    """What was measured from a part that radiates to a listener."""
    where, skin = places.where("listener", listener.name, "transfer", part), listener.skin
    rows = _rows_of_parts(model)
    if part.upper() not in rows:
        raise InputError(
            f"listener {listener.name!r}: unknown part {part!r}",
            where=where,
            fix=suggest(part, [p.name for p in model.parts]),
        )
    own = skin.select(skin.part == rows[part.upper()])
    if not own.count:
        raise InputError(
            f"listener {listener.name!r} does not hear part {part!r}",
            where=where,
            expected=f"one of {', '.join(listener.parts)}",
            fix="Name it in parts, too, or leave its transfer function out.",
        )
    size = np.linalg.norm(own.areas, axis=1)
    away = metre * float(np.linalg.norm(size @ own.centres / size.sum() - listener.position))
    given = table.transfer[part]
    return transfer_of(given, places.sibling(given.file), rows[part.upper()], away, where)


def _with_head(
    model: Model, skin: Skin, listener: Listener, table: ListenerTable, metre: float, places: Places
) -> Listener:
    """With the head that its table gives it."""
    if table.faces is None:
        return listener
    looks, up = _unit(table.faces), _unit(table.up or UP)
    left, name = np.cross(up, looks), listener.name
    if np.linalg.norm(left) < ALONG:
        raise InputError(
            f"listener {name!r} faces {list(table.faces)}, along the top of its head {list(table.up or UP)}",
            where=places.where("listener", name, "faces"),
            expected="two directions that are not parallel",
            fix="Give up, the direction of the top of its head." if table.up is None else "Change one of them.",
        )
    away = np.linalg.norm(skin.corners - listener.position, axis=2).min(axis=1) * metre
    nearest = int(away.argmin())
    if away[nearest] <= RADIUS:
        node = model.nodes.label(int(skin.nodes_idx[nearest, 0]))
        raise InputError(
            f"the head of listener {name!r} touches the structure, at node {node}",
            where=places.where("listener", name, "position"),
            expected=f"more than {RADIUS:.4g} m to the middle of the head",
            fix="Move it off, or leave faces out: it is then a point.",
        )
    with_head = replace(listener, looks=looks, left=left / np.linalg.norm(left))
    if table.hrtf is None:
        return with_head
    path = places.sibling(table.hrtf)
    return replace(with_head, measured=_ears(path, places.where("listener", name, "hrtf")), hrtf=path.name)


def _ears(path: Path, where: str) -> Ears:
    """As a SOFA file has them."""
    found = head_responses(path, where)
    if 0.5 * found.rate < UPPER_EDGES[-1]:
        raise InputError(
            f"{path.name} is sampled at {found.rate:g} Hz",
            where=path,
            expected=f"{2.0 * UPPER_EDGES[-1]:.0f} Hz or more: the highest third octave of hearing is in it then",
            fix="Take one that was measured at a higher rate.",
        )
    around = surrounding(found.directions)
    if around is None:
        raise InputError(
            f"the {len(found.directions)} directions in {path.name} do not go around the head",
            where=path,
            expected="directions on all sides, above and below, too",
            fix="Take a file that has them, or leave hrtf out: the head is a sphere then.",
        )
    return Ears(around, found.responses, found.rate, found.delay)


def _unit(direction: Sequence[float]) -> FloatArray:
    given = np.array(direction)
    return np.asarray(given / np.linalg.norm(given))


def _listener(model: Model, skin: Skin, name: str, table: ListenerTable, metre: float, places: Places) -> Listener:
    chosen = _of_names(model, skin, table.part_names, name, places.where("listener", name, "parts"))
    heard = skin.select(chosen)
    if not heard.count:
        wanted = f"of {', '.join(table.part_names)} " if table.part_names else ""
        raise InputError(
            f"listener {name!r} hears nothing: no shell and no solid {wanted}radiates".replace("  ", " "),
            where=places.where("listener", name),
            expected="a part with shells or solids",
            fix="Name such parts, or leave the listener out.",
        )
    position, where = np.array(table.position), places.where("listener", name, "position")
    if skin.holds(position):
        raise InputError(
            f"listener {name!r} at {list(table.position)} is inside the structure",
            where=where,
            expected="a point in the air",
            fix="Move it out.",
        )
    away = np.linalg.norm(skin.corners - position, axis=2).min(axis=1) / skin.size
    nearest = int(away.argmin())
    if away[nearest] < OFF:
        node = model.nodes.label(int(skin.nodes_idx[nearest, 0]))
        raise InputError(
            f"listener {name!r} at {list(table.position)} is on the structure, at node {node}",
            where=where,
            expected=f"{metre * OFF * skin.size[nearest]:.4g} m or more away, the size of the element there",
            fix="Move it off.",
        )
    found = Listener(name, position, heard, _names(model, heard), True)
    return found if table.wall else replace(found, rims=rims_of(skin, chosen, position, metre))


def _rows_of_parts(model: Model) -> dict[str, int]:
    """Row into `Model.parts` by each of their names."""
    return {alias.upper(): i for i, p in enumerate(model.parts) for alias in (p.name, *p.aliases)}


def _of_names(model: Model, skin: Skin, wanted: Sequence[str], name: str, where: str) -> BoolArray:
    """Facets of the parts, surfaces and element sets that a listener names; of all where it names none.

    Raises
    ------
    InputError : no such name; a set or surface has no facets, or none that the outside sees.
    """
    rows = _rows_of_parts(model)
    others = [*(key for key, s in model.surfaces.items() if not s.is_node_based), *model.element_sets]
    heard = np.zeros(skin.count, dtype=bool) if wanted else np.ones(skin.count, dtype=bool)
    for one in wanted:
        if one.upper() in rows:
            heard |= skin.part == rows[one.upper()]
            continue
        if one.upper() not in others:
            bare = one.upper() in model.surfaces or one.upper() in model.node_sets
            what = f"{one!r} is a set of nodes, without faces" if bare else f"unknown part {one!r}"
            raise InputError(
                f"listener {name!r}: {what}",
                where=where,
                expected="a part, a surface or an element set of the deck",
                fix=suggest(one, [*(p.name for p in model.parts), *others]),
            )
        mine = skin.has(facets_of(model, one, where=where).nodes)
        if not mine.any():
            raise InputError(
                f"listener {name!r}: no face of {one!r} looks outside",
                where=where,
                expected="shells, or faces of solids that no other solid covers",
                fix="Name the part, or a surface on its outside.",
            )
        heard |= mine
    return heard


def ear_off(model: Model, skin: Skin, part: int, units: str) -> Listener:
    """An occupant's ear `EAR` off the middle of a part, along its face, away from the rest of the model."""
    panel = skin.select(skin.part == part)
    areas = panel.areas
    size = np.linalg.norm(areas, axis=1)
    middle = size @ panel.centres / size.sum()
    normal = plane_of(areas)[1][:, -1]
    every = np.linalg.norm(skin.areas, axis=1)
    outward = float(normal @ (middle - every @ skin.centres / every.sum()))
    if outward < 0.0 or (outward == 0.0 and normal[np.abs(normal).argmax()] < 0.0):
        normal = -normal
    depth = float((panel.corners @ normal).max() - middle @ normal)
    position = middle + (depth + EAR / METRES[units]) * normal
    return Listener(UNNAMED, position, skin, _names(model, skin), False)


def _names(model: Model, skin: Skin) -> tuple[str, ...]:
    return tuple(model.parts[i].name for i in np.unique(skin.part).tolist() if i >= 0)
