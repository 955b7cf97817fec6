"""E-lines: points between two parts, of every contact by themselves and where the study draws them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray
from creak.contact.facets import facets_of
from creak.contact.gap_operator import ChannelRows, GapOperator, join
from creak.contact.node_to_surface import node_to_surface, nodes_of
from creak.contact.pair import ContactPair, tangents_of
from creak.errors import InputError, suggest
from creak.model.contact_law import ContactLaw
from creak.model.dofs import TRANSLATIONS, node_dofs
from creak.model.mesh import Model
from creak.model.units import UNITS
from creak.studies.design.named_nodes import REACH
from creak.studies.file.case import Lines
from creak.studies.file.eline_tables import ElineTable, MaterialPairTable
from creak.studies.file.material_pairs import material_pairs
from creak.studies.file.places import Places
from creak.studies.prepare.eline_points import FIX_POINT, Pairs, pairs_of, places_or_pairs
from creak.studies.prepare.pairs import sides_meant
from creak.studies.prepare.tolerances import point_tolerances, points_of


@dataclass(frozen=True)
class Eline:
    """What holds for the points of a line."""

    name: str
    contact: bool
    """Its points are the channels of the contact of that name."""
    tolerance: str
    """The table that its points have their tolerances from, and which side of it; empty: one number holds for all."""
    material: str | None
    """Name of the material pair."""
    pair: MaterialPairTable | None


@dataclass(frozen=True)
class Elines:
    """All lines with their points, those of contacts first."""

    lines: tuple[Eline, ...]
    points: GapOperator
    """p channels without force; `group` is the line, `tangents` are x and y of the frame."""
    frames: FloatArray
    """(p, 3, 3) rows x, y, z: z across the gap, from main to secondary; x along the line (first principal axis of its
    points, in the plane)."""
    positions: FloatArray
    """(p, 3) of the points' nodes."""
    tolerance: FloatArray
    """(p,) what scatter may take of each gap, length."""
    percentile: float
    """Of the peaks of motion that is told beside the largest."""
    notes: tuple[str, ...] = ()
    """What to tell of their tolerances."""
    static: tuple[FloatArray, FloatArray] | None = None
    """(p, 3) relative motion under the static loads along x, y, z, with contact and without; None: there are none."""

    @property
    def line_of(self) -> IntArray:
        """(p,) row in `lines` of each point."""
        row = {line.name: k for k, line in enumerate(self.lines)}
        return np.array([row[g] for g in self.points.group], dtype=np.int64)


AROUND = 9
"""A node and those of the four facets round it: how far nodes are apart there."""
NO_ELINES = Elines((), join([]), np.zeros((0, 3, 3)), np.zeros((0, 3)), np.zeros(0), 100.0)


def make_elines(model: Model, given: Lines, contacts: GapOperator) -> Elines:
    """The lines of a study.

    Parameters
    ----------
    contacts : all channels of its contacts.

    Raises
    ------
    InputError : an [eline] with unknown sets, with a name that is no contact and no points, of a material pair that
        there is not; sides that do not face each other; a file of points or of tolerances that cannot be used.
    """
    known = material_pairs(given)
    lines = [_line(given, name, True, known) for name in dict.fromkeys(contacts.group)]
    operators, notes = [contacts.without_force()] if contacts.m else [], list[str]()
    for name, table in given.elines.items():
        if not table.drawn:
            _check_contact(given, name)
        elif name in given.contacts:
            raise InputError(
                f"[eline.{name}] draws a line and has the name of a contact",
                where=given.places.where("eline", name),
                fix="Give it another name, or leave out main, secondary and points.",
            )
        else:
            lines.append(_line(given, name, False, known))
            where, sides = given.places.where("eline", name), (table.secondary or "", table.main or "")
            own, said = sides_meant(model, *sides, "node-to-surface", where)
            notes += said
            operators.append(_drawn(own, given, name).without_force())
    if not operators:
        return NO_ELINES
    points, frames = _with_frames(model, join(operators))
    at = model.nodes.coords[points.nodes_idx]
    found = point_tolerances(given, points_of(points, model))
    told = tuple(replace(line, tolerance=dict(found.source).get(line.name, "")) for line in lines)
    return Elines(told, points, frames, at, found.below, given.percentile, (*notes, *found.notes))


def _line(given: Lines, name: str, contact: bool, known: dict[str, MaterialPairTable]) -> Eline:
    table = given.elines.get(name, ElineTable())
    if table.material is not None and table.material not in known:
        raise InputError(
            f"unknown material pair {table.material!r}",
            where=given.places.where("eline", name, "material"),
            expected="a [material-pair.NAME]",
            fix=suggest(table.material, known),
        )
    return Eline(name, contact, "", table.material, known.get(table.material or ""))


def _check_contact(given: Lines, name: str) -> None:
    if name not in given.contacts:
        raise InputError(
            f"[eline.{name}] says nothing of where its points are, and there is no contact of that name",
            where=given.places.where("eline", name),
            expected="main and secondary, points, or the name of a contact",
            fix=suggest(name, given.contacts) if given.contacts else "Give main and secondary.",
        )


def _drawn(model: Model, given: Lines, name: str) -> GapOperator:
    """Points of a line that the study draws."""
    from scipy.spatial import cKDTree  # see `signals.spectra.low_pass`

    t, at, unit = given.elines[name], given.places, UNITS[given.units].length
    places = None if t.points is None else places_or_pairs(model, t, name, given)
    if isinstance(places, Pairs):
        return _between(model, t, name, at, places, unit)
    assert t.main is not None
    assert t.secondary is not None
    where = at.where("eline", name)
    secondary = nodes_of(model, t.secondary, where=f"{where} secondary").rows
    if places is not None:
        _require_near(model, t, places, secondary, where, unit)
        tree = cKDTree(model.nodes.coords[secondary])
        secondary = secondary[np.array(list(dict.fromkeys(tree.query(places)[1].tolist())), dtype=np.int64)]
    if _has_facets(model, t.main):
        return _faced(model, t, name, at, secondary, unit)
    main = nodes_of(model, t.main, where=f"{where} main").rows
    nearest = cKDTree(model.nodes.coords[main]).query(model.nodes.coords[secondary])[1]
    return _between(model, t, name, at, pairs_of(model, t, main[nearest], secondary, at.where("eline", name)), unit)


def _require_near(model: Model, t: ElineTable, places: FloatArray, secondary: IntArray, where: str, unit: str) -> None:
    """Refuse a place that does not lie between both sides: off the way from its secondary node to the nearest main one,
    farther than `REACH` and the nodes are apart there."""
    from scipy.spatial import cKDTree  # see `signals.spectra.low_pass`

    X, reach = model.nodes.coords, REACH * float(np.linalg.norm(np.ptp(model.nodes.coords, axis=0)))
    main = nodes_of(model, t.main or "", where=f"{where} main").rows
    trees = [cKDTree(X[rows]) for rows in (main, secondary)]
    ends = [X[secondary[trees[1].query(places)[1]]]]
    ends.append(X[main[trees[0].query(ends[0])[1]]])
    apart = sum(
        tree.query(at, k=min(AROUND, tree.n))[0][:, -1]
        for tree, at in zip(trees, ends[::-1], strict=True)
        if tree.n > 1
    )
    way = ends[1] - ends[0]
    length = np.maximum(np.einsum("nx,nx->n", way, way), np.finfo(float).tiny)
    share = np.clip(np.einsum("nx,nx->n", places - ends[0], way) / length, 0.0, 1.0)
    off = np.linalg.norm(places - ends[0] - share[:, None] * way, axis=1)
    k = int((off - apart).argmax())
    if (off - apart)[k] > reach:
        raise InputError(
            f"({', '.join(f'{x:g}' for x in places[k])}) does not lie between {t.main!r} and {t.secondary!r}: the way "
            f"between the nearest nodes is {off[k]:.4g} {unit} off",
            where=f"{where} points",
            expected=f"places between both sides, in the deck's axes and units, to {reach:.3g} {unit} (1/100 of the "
            "model's size) and the distance of the nodes there",
            fix=FIX_POINT[0],
        )


def _has_facets(model: Model, name: str) -> bool:
    surface = model.surfaces.get(name.upper())
    return not surface.is_node_based if surface is not None else name.upper() in model.element_sets


def _faced(model: Model, t: ElineTable, name: str, at: Places, nodes: IntArray, unit: str) -> GapOperator:
    """Points at those of the nodes that face the main surface, with shell thickness counted."""
    where = at.where("eline", name)
    assert t.main is not None
    assert t.secondary is not None
    facets_of(model, t.main, where=f"{where} main")
    law = ContactLaw(1.0, where=where)
    pair = ContactPair(
        name, t.secondary, t.main, "node-to-surface", t.clearance, t.normal, law=law, table="eline", unit=unit
    )
    try:
        every, _ = node_to_surface(model, pair)
    except InputError as error:
        raise InputError(error.what, expected=error.expected, where=where, fix=error.fix) from error
    keep = np.flatnonzero(np.isin(every.nodes_idx, nodes))
    if not keep.size:
        raise InputError(
            f"no node of {t.secondary!r} near the points faces {t.main!r}",
            where=at.where("eline", name, "points"),
            expected="points between both sides",
            fix="Check the coordinates.",
        )
    return every.select(keep)


def _between(model: Model, t: ElineTable, name: str, at: Places, pairs: Pairs, unit: str) -> GapOperator:
    """Points between pairs of nodes: z along the line between them, or as it is given."""
    X = model.nodes.coords
    main, secondary = pairs.main, pairs.secondary
    apart = X[secondary] - X[main]
    length = np.linalg.norm(apart, axis=1)
    free = np.isnan(pairs.normals[:, 0])
    same = np.flatnonzero(free & (length <= 0.0))
    if same.size:
        two = [model.nodes.label(int(rows[same[0]])) for rows in (main, secondary)]
        raise InputError(
            f"nodes {' and '.join(two)} lie in one place: there is no direction across the gap",
            where=pairs.where[int(same[0])],
            fix="Give normal, from the main to the secondary side.",
        )
    z = np.where(free[:, None], apart / np.where(length > 0.0, length, 1.0)[:, None], pairs.normals)
    across = np.einsum("nx,nx->n", apart, z)
    z, across = np.where((pairs.axes & (across < 0.0))[:, None], -z, z), np.where(pairs.axes, np.abs(across), across)
    behind = np.flatnonzero(across < -1e-9 * length)
    if behind.size:
        worst = int(behind[np.argmin(across[behind])])
        raise InputError(
            f"node {model.nodes.label(int(secondary[worst]))} lies {-across[worst]:.4g} {unit} behind its main node "
            f"along the normal {z[worst].tolist()}",
            where=at.where("eline", name, "normal") if t.normal is not None else pairs.where[worst],
            expected="a direction from the main to the secondary side",
            fix="Turn it round, or exchange main and secondary.",
        )
    gap = across if t.clearance is None else np.full(main.size, t.clearance)
    label = node_dofs(np.column_stack([secondary, main]).ravel(), TRANSLATIONS)
    vectors = [np.concatenate([v, -v], axis=1).ravel() for v in (z, *tangents_of(z))]
    m, none = main.size, np.zeros(main.size)
    return GapOperator(
        **ChannelRows(np.repeat(np.arange(m), 6), label, *vectors).motion(m),
        gap0=gap,
        stiffness=none,
        damping=none,
        step_limited=np.zeros(m, dtype=np.bool_),
        area=none,
        names=tuple(f"{name}:{point}" for point in pairs.names),
        nodes_idx=secondary,
        group=(name,) * m,
    )


def _with_frames(model: Model, points: GapOperator) -> tuple[GapOperator, FloatArray]:
    """The points with x and y of their frames as tangents, and the frames."""
    z, t1 = (_vectors(points, A) for A in (points.G, points.tangents[0]))
    z /= np.linalg.norm(z, axis=1)[:, None]
    t1 -= np.einsum("nx,nx->n", t1, z)[:, None] * z
    t1 /= np.linalg.norm(t1, axis=1)[:, None]
    t2 = np.cross(z, t1)
    along = _directions(model.nodes.coords[points.nodes_idx], np.array(points.group, dtype=object))
    c, s = (np.einsum("nx,nx->n", along, t) for t in (t1, t2))
    size = np.hypot(c, s)
    far = size > 1e-6
    c, s = np.where(far, c / np.where(far, size, 1.0), 1.0), np.where(far, s / np.where(far, size, 1.0), 0.0)
    T1, T2 = points.tangents
    X = sp.csr_matrix(sp.diags(c) @ T1 + sp.diags(s) @ T2)
    Y = sp.csr_matrix(sp.diags(c) @ T2 - sp.diags(s) @ T1)
    x = c[:, None] * t1 + s[:, None] * t2
    return replace(points, tangents=(X, Y)), np.stack([x, np.cross(z, x), z], axis=1)


def _vectors(points: GapOperator, A: sp.csr_matrix) -> FloatArray:
    """(p, 3) what a row says at the point's own secondary node: a positive multiple of its direction."""
    rows = np.repeat(np.arange(points.m), 3)
    label = node_dofs(points.nodes_idx, TRANSLATIONS)
    column = np.minimum(np.searchsorted(points.labels, label), points.labels.size - 1)
    values = np.asarray(A[rows, column]).ravel() * (points.labels[column] == label)
    return np.asarray(values, dtype=np.float64).reshape(-1, 3)


def _directions(xyz: FloatArray, group: np.ndarray[tuple[int], np.dtype[np.object_]]) -> FloatArray:
    """(p, 3) unit first principal axis of the line's points, that of its largest component positive."""
    out = np.zeros_like(xyz)
    for name in dict.fromkeys(group):
        mine = group == name
        about = xyz[mine] - xyz[mine].mean(axis=0)
        axis = np.linalg.svd(about.T @ about)[0][:, 0] if np.ptp(xyz[mine], axis=0).any() else np.zeros(3)
        out[mine] = axis * (np.sign(axis[np.abs(axis).argmax()]) or 1.0)
    return out
