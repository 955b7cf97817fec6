"""E-lines: points between two parts, of every contact by themselves and where the study draws them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from creak.arrays import FloatArray, IntArray
from creak.contact.facets import facets_of, nodes_of
from creak.contact.gap_operator import ChannelRows, GapOperator, gap_operator, join
from creak.contact.node_to_surface import node_to_surface
from creak.contact.pair import ContactPair, tangents_of
from creak.errors import InputError, suggest
from creak.model.contact_law import ContactLaw
from creak.model.dofs import TRANSLATIONS, node_dofs
from creak.model.mesh import Model
from creak.studies.design.named_nodes import node_labels
from creak.studies.file.case import Lines
from creak.studies.file.eline_tables import ElineTable, MaterialPairTable
from creak.studies.file.material_pairs import material_pairs
from creak.studies.file.places import Places
from creak.studies.file.quantities import length_in
from creak.studies.file.tables import Rows, read_one_of

BY_NODES, BY_PLACE = ["main", "secondary"], ["x", "y", "z"]
"""Headers of a file of points."""


@dataclass(frozen=True)
class Eline:
    """What holds for the points of a line."""

    name: str
    contact: bool
    """Its points are the channels of the contact of that name."""
    tolerance: float
    """What scatter may take of the gap, length."""
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

    @property
    def line_of(self) -> IntArray:
        """(p,) row in `lines` of each point."""
        row = {line.name: k for k, line in enumerate(self.lines)}
        return np.array([row[g] for g in self.points.group], dtype=np.int64)


NO_ELINES = Elines((), join([]), np.zeros((0, 3, 3)))


def make_elines(model: Model, given: Lines, contacts: GapOperator) -> Elines:
    """The lines of a study.

    Parameters
    ----------
    contacts : all channels of its contacts.

    Raises
    ------
    InputError : an [eline] with unknown sets, with a name that is no contact and no points, of a material pair that
        there is not; sides that do not face each other; a file of points that cannot be used.
    """
    known = material_pairs(given)
    lines = [_line(given, name, True, known) for name in dict.fromkeys(contacts.group)]
    operators = [contacts.without_force()] if contacts.m else []
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
            operators.append(_drawn(model, given.elines[name], name, given.places).without_force())
    if not operators:
        return NO_ELINES
    points, frames = _with_frames(model, join(operators))
    return Elines(tuple(lines), points, frames)


def _line(given: Lines, name: str, contact: bool, known: dict[str, MaterialPairTable]) -> Eline:
    table = given.elines.get(name, ElineTable())
    words = given.tolerance if table.tolerance is None else table.tolerance
    tolerance = 0.0 if words is None else length_in(words, given.units)
    if table.material is not None and table.material not in known:
        raise InputError(
            f"unknown material pair {table.material!r}",
            where=given.places.where("eline", name, "material"),
            expected="a [material-pair.NAME]",
            fix=suggest(table.material, known),
        )
    return Eline(name, contact, tolerance, table.material, known.get(table.material or ""))


def _check_contact(given: Lines, name: str) -> None:
    if name not in given.contacts:
        raise InputError(
            f"[eline.{name}] says nothing of where its points are, and there is no contact of that name",
            where=given.places.where("eline", name),
            expected="main and secondary, points, or the name of a contact",
            fix=suggest(name, given.contacts) if given.contacts else "Give main and secondary.",
        )


def _drawn(model: Model, t: ElineTable, name: str, at: Places) -> GapOperator:
    """Points of a line that the study draws."""
    from scipy.spatial import cKDTree  # see `signals.spectra.low_pass`

    places = None
    if t.points is not None:
        places = _places(model, t, name, at)
    if t.main is None or t.secondary is None:
        assert isinstance(places, tuple)
        return _node_pairs(model, t, name, at, *places)
    if isinstance(places, tuple):
        raise InputError(
            "the file of points names nodes, and the line has main and secondary too",
            where=at.where("eline", name, "points"),
            fix="Leave out main and secondary, or give x,y,z.",
        )
    where = at.where("eline", name)
    secondary = nodes_of(model, t.secondary, where=f"{where} secondary").rows
    if places is not None:
        tree = cKDTree(model.nodes.coords[secondary])
        secondary = secondary[np.array(list(dict.fromkeys(tree.query(places)[1].tolist())), dtype=np.int64)]
    if _has_facets(model, t.main):
        return _faced(model, t, name, at, secondary)
    main = nodes_of(model, t.main, where=f"{where} main").rows
    nearest = cKDTree(model.nodes.coords[main]).query(model.nodes.coords[secondary])[1]
    return _node_pairs(model, t, name, at, main[nearest], secondary)


def _has_facets(model: Model, name: str) -> bool:
    surface = model.surfaces.get(name.upper())
    return not surface.is_node_based if surface is not None else name.upper() in model.element_sets


def _faced(model: Model, t: ElineTable, name: str, at: Places, nodes: IntArray) -> GapOperator:
    """Points at those of the nodes that face the main surface, with shell thickness counted."""
    where = at.where("eline", name)
    assert t.main is not None
    assert t.secondary is not None
    facets_of(model, t.main, where=f"{where} main")
    law = ContactLaw(1.0, where=where)
    pair = ContactPair(name, t.secondary, t.main, "node-to-surface", t.clearance, t.normal, law=law, table="eline")
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


def _node_pairs(model: Model, t: ElineTable, name: str, at: Places, main: IntArray, secondary: IntArray) -> GapOperator:
    """Points between pairs of nodes: z along the line between them, or the study's normal."""
    X = model.nodes.coords
    apart = X[secondary] - X[main]
    length = np.linalg.norm(apart, axis=1)
    if t.normal is None:
        same = np.flatnonzero(length <= 0.0)
        if same.size:
            two = [model.nodes.label(int(rows[same[0]])) for rows in (main, secondary)]
            raise InputError(
                f"nodes {' and '.join(two)} lie in one place: there is no direction across the gap",
                where=at.where("eline", name),
                fix="Give normal, from the main to the secondary side.",
            )
        z = apart / length[:, None]
    else:
        given = np.array(t.normal)
        if not np.linalg.norm(given) > 0.0:
            raise InputError(f"normal = {list(t.normal)} has no direction", where=at.where("eline", name, "normal"))
        z = np.tile(given / np.linalg.norm(given), (main.size, 1))
        across = np.einsum("nx,nx->n", apart, z)
        worst = int(np.argmin(across))
        if across[worst] < -1e-9 * length[worst]:
            raise InputError(
                f"node {model.nodes.label(int(secondary[worst]))} lies {-across[worst]:.4g} behind its main node along "
                f"the normal {list(t.normal)}",
                where=at.where("eline", name, "normal"),
                expected="a direction from the main to the secondary side",
                fix="Turn it round, or exchange main and secondary.",
            )
    gap = np.einsum("nx,nx->n", apart, z) if t.clearance is None else np.full(main.size, t.clearance)
    label = node_dofs(np.column_stack([secondary, main]).ravel(), TRANSLATIONS)
    vectors = [np.concatenate([v, -v], axis=1).ravel() for v in (z, *tangents_of(z))]
    none = np.zeros(main.size)
    return gap_operator(
        ChannelRows(np.repeat(np.arange(main.size), 6), label, *vectors),
        gap0=gap,
        stiffness=none,
        damping=none,
        area=none,
        names=[f"{name}:{model.nodes.label(int(i))}" for i in secondary],
        nodes_idx=secondary,
        group=name,
    )


def _places(model: Model, t: ElineTable, name: str, at: Places) -> FloatArray | tuple[IntArray, IntArray]:
    """Coordinates (k, 3) of the points that a line lists, or node rows of both its sides."""
    where = at.where("eline", name, "points")
    if not isinstance(t.points, str):
        return np.array(t.points, dtype=np.float64)
    path = at.sibling(t.points)
    header, rows = read_one_of(path, where, "file of points", [BY_PLACE, BY_NODES])
    if not rows:
        raise InputError("the file of points has no rows", where=path, expected=f"{','.join(header)} lines")
    if header == BY_NODES:
        return _nodes_in(model, path, rows)
    if t.main is None:
        raise InputError(
            f"{t.points} has coordinates, and the line no sides that they lie between",
            where=where,
            expected="main and secondary",
            fix="Name both sets.",
        )
    return np.array([_coordinates(path, line, row) for line, row in rows])


def _coordinates(path: Path, line: int, row: list[str]) -> list[float]:
    try:
        values = [float(cell) for cell in row[:3]]
    except ValueError:
        values = []
    if len(values) != 3 or not all(map(math.isfinite, values)):
        raise InputError(
            f"got {','.join(row)!r}",
            where=f"{path}:{line}",
            expected="three finite numbers: x,y,z",
            fix="Repair the row.",
        )
    return values


def _nodes_in(model: Model, path: Path, rows: Rows) -> tuple[IntArray, IntArray]:
    known = node_labels(model, np.arange(model.nodes.count))
    found = []
    for line, row in rows:
        for cell in (*row, "", "")[:2]:
            label = cell.strip().upper()
            if label not in known:
                raise InputError(
                    f"unknown node {cell.strip()!r}",
                    where=f"{path}:{line}",
                    expected="labels of nodes of the deck: main,secondary",
                    fix="Correct the label.",
                )
            found.append(known[label])
    main, secondary = np.array(found, dtype=np.int64).reshape(-1, 2).T
    return main, secondary


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
