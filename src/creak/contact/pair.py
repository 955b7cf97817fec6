"""A contact pair of the study turned into gap channels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from creak.arrays import FloatArray, IntArray
from creak.contact.facets import Facets, facets_of
from creak.contact.gap_operator import ChannelRows, GapOperator, gap_operator
from creak.contact.search import Projection
from creak.errors import InputError
from creak.model.mesh import Model

AUTO_FACTOR = 10.0
"""Penalty = 10 x the stiffness of the softer parent element, as Abaqus does."""
REACH = 0.25
"""A partner is looked for within this fraction of the secondary surface's diagonal."""


@dataclass(frozen=True)
class ContactPair:
    """What the study says of one contact."""

    name: str
    secondary: str
    main: str
    method: str = "surface-to-surface"
    stiffness: float | None = None
    """force/length^3 (surface-to-surface) or force/length (node-to-surface); None: from the parent shells."""
    clearance: float | None = None
    """Replaces the geometric gap."""

    @property
    def where(self) -> str:
        return f"[contact.{self.name}]"


def reach(coords: FloatArray) -> float:
    """How far from the secondary surface a main facet may lie."""
    return REACH * float(np.linalg.norm(np.ptp(coords.reshape(-1, 3), axis=0)))


def main_facets(model: Model, pair: ContactPair) -> Facets:
    """Facets of the main surface."""
    return facets_of(model, pair.main, where=f"{pair.where} main")


def never_face(pair: ContactPair, limit: float) -> InputError:
    """The error for surfaces that have no point opposite each other."""
    return InputError(
        f"surfaces {pair.secondary!r} and {pair.main!r} never face each other: no point of the first has a facet "
        f"of the second opposite it within {limit:.4g}",
        where=pair.where, expected="two surfaces that lie opposite each other",
        fix="Check the names, the positions of the parts and the sides (SPOS, SNEG) of the surfaces.",
    )  # fmt: skip


def channels_from_rows(
    model: Model,
    pair: ContactPair,
    rows: ChannelRows,
    nodes_idx: IntArray,
    gap0: FloatArray,
    penalty: FloatArray,
    area: FloatArray,
    thickness: FloatArray,
) -> tuple[GapOperator, list[str]]:
    """Finish the channels of a pair: clearance, initial overclosure, names."""
    notes: list[str] = []
    gap0 = np.full_like(gap0, pair.clearance) if pair.clearance is not None else gap0
    closed = np.flatnonzero(gap0 < 0.0)
    if closed.size:
        worst = closed[np.argmin(gap0[closed] + thickness[closed])]
        node = model.nodes.label(int(nodes_idx[worst]))
        if -gap0[worst] > max(thickness[worst], 1e-12) and pair.clearance is None:
            raise InputError(
                f"node {node} starts {-gap0[worst]:.4g} inside the main surface, more than the shells' thickness",
                where=pair.where, fix="Move the parts apart, or give a clearance.",
            )  # fmt: skip
        notes.append(
            f"{pair.where} {closed.size} channel(s) start closed, by up to {-gap0.min():.3g} at node "
            f"{model.nodes.label(int(nodes_idx[np.argmin(gap0)]))}; their gap is set to 0 without strain"
        )
        gap0 = np.maximum(gap0, 0.0)
    operator = gap_operator(
        rows,
        gap0=gap0,
        stiffness=penalty,
        damping=np.zeros_like(gap0),
        step_limited=pair.stiffness is None,
        area=area,
        names=[f"{pair.name}:{model.nodes.label(int(i))}" for i in nodes_idx],
        nodes_idx=nodes_idx,
        group=pair.name,
    )
    return operator, notes


def gap_normals(projection: Projection, sides: IntArray) -> tuple[FloatArray, FloatArray]:
    """Signed distance between mid-surfaces and the unit normal from main to secondary.

    `distance` runs from the secondary point to the facet along `direction`; a double-sided main surface
    (side 0) faces whichever side the point is on.
    """
    d, direction = projection.distance, projection.direction
    flip = np.where(sides == 0, np.where(d > 0.0, -1.0, 1.0), np.where(sides >= 0, 1.0, -1.0))
    normal = direction * flip[:, None]
    return -d * flip, normal


def tangents_of(normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit tangents for each normal."""
    helper = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    t1 = np.cross(normals, helper)
    t1 /= np.linalg.norm(t1, axis=1)[:, None]
    return t1, np.cross(normals, t1)
