"""Where it rattles: gap channels that touch beside each other are one place, the hardest hit place comes first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from creak.arrays import FloatArray, IntArray
from creak.contact.gap_operator import GapOperator
from creak.dynamics.history import History
from creak.model.plain_mesh import Mesh
from creak.studies.prepare.marching import Scope
from creak.studies.run.one_run import Run
from creak.verify.events import Event, counted_instants, events_in, find_events
from creak.verify.rubbing import NOTHING, SELDOM, Rub, rub_of
from creak.verify.slips import SlipEvent

NEAR = 0.02
"""Share of the model's diagonal up to which channels that touch are neighbours; those of one element always are."""


@dataclass(frozen=True)
class Place:
    """A patch of neighbouring channels of one contact, and what happened there in the verification window."""

    number: int
    """From 1, by what is heard (`ranked`), where nothing is by worst force; 0: it rests."""
    contact: str
    channels: IntArray
    """Columns of the run's gaps and forces."""
    nodes_idx: IntArray
    """Rows of their secondary nodes."""
    node_idx: int
    """Row of the node that was hit hardest, where none was of that which rubs or presses most."""
    events: tuple[Event, ...]
    """Events of these channels alone, micro-contacts merged as everywhere; none where the place only squeaks."""
    slips: tuple[SlipEvent, ...] = ()
    """Stick-slip events there, with those of their slips that begin in the window."""
    rub: Rub = NOTHING
    """Friction, and the force of lasting contact."""

    @property
    def rests(self) -> bool:
        """Whether it has pressed since the start of the run without a hit or a slip, and hardly slides."""
        friction = self.rub.friction
        return not (self.events or self.slips or (friction is not None and friction.share >= SELDOM))

    @property
    def force(self) -> float:
        """Worst low-passed force of its channels together."""
        return max((e.force_place for e in self.events), default=0.0)

    @property
    def slip_count(self) -> int:
        """Slips that begin in the window, of its channels as one."""
        return 0 if self.rub.friction is None else len(self.rub.friction.slips)

    @property
    def speed(self) -> float:
        """Highest closing speed."""
        return max((e.closing_speed for e in self.events), default=0.0)

    @property
    def impulse(self) -> float:
        """Sum over the events."""
        return sum(e.impulse for e in self.events)

    @property
    def irregularity(self) -> float | None:
        """Standard deviation of the times between beginnings of its events over their mean: 0 as regular as a clock, 1
        as rain; None below three events."""
        between = np.diff(sorted(e.t_start for e in self.events))
        return float(between.std() / between.mean()) if between.size > 1 and between.mean() > 0.0 else None


def find_places(scope: Scope, run: Run) -> tuple[Place, ...]:
    """The places that touch in the verification window, by worst force, and those that only squeak or scrape.

    Touched channels of one contact belong together where their nodes share an element or lie within `NEAR` of the
    model's size, and so on from neighbour to neighbour. They are looked for once for each run.
    """
    return tuple(p for p in _known(scope, run) if p.number)


def resting_places(scope: Scope, run: Run) -> tuple[Place, ...]:
    """Patches that have pressed since the start without a hit or a slip: no places, but what they carry is told."""
    return tuple(p for p in _known(scope, run) if not p.number)


def _known(scope: Scope, run: Run) -> tuple[Place, ...]:
    if scope.window not in run.places_known:
        run.places_known[scope.window] = _find(scope, run)
    found: tuple[Place, ...] = run.places_known[scope.window]
    return found


def _find(scope: Scope, run: Run) -> tuple[Place, ...]:
    h, gaps, window = run.history, run.gaps, scope.window
    inside = counted_instants(h.time, run.events, window)
    touched = np.flatnonzero((h.force[inside] > 0.0).any(axis=0)).astype(np.int64)
    if not touched.size:
        return ()
    model = scope.model
    group = np.unique(np.array(gaps.group, dtype=object)[touched].astype(str), return_inverse=True)[1]
    nodes = gaps.nodes_idx[touched]
    pairs = np.concatenate([_close(model.nodes.coords[nodes], near(model)), _of_one_element(model, nodes)])
    pairs = pairs[group[pairs[:, 0]] == group[pairs[:, 1]]]
    n = touched.size
    graph = sp.coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    patch = np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)
    every = [touched[patch == p] for p in np.unique(patch).tolist()]
    slips, places = _slips(run, window, touched, patch), []
    at_each = events_at(every, scope, gaps, h)
    for channels, p, own in zip(every, np.unique(patch).tolist(), at_each, strict=True):
        contact, rows, slid = gaps.group[int(channels[0])], np.unique(gaps.nodes_idx[channels]), slips.get(p, ())
        if own:
            node = max(own, key=lambda e: e.force_peak_filtered).node_idx
        elif slid:
            node = max(slid, key=lambda e: e.friction_work).node_idx
        else:
            node = int(gaps.nodes_idx[channels[np.argmax(h.weights @ h.force[:, channels])]])
        rub = rub_of(h, gaps, channels, window, scope.verification.f_max)
        if len(own) > 1:  # those are judged one by one
            rub = replace(rub, force=None)
        places.append(Place(0, contact, channels, rows, node, tuple(own), tuple(slid), rub))
    places.sort(key=lambda place: (place.rests, -place.force))
    return tuple(replace(place, number=0 if place.rests else k) for k, place in enumerate(places, start=1))


def events_at(groups: Sequence[IntArray], scope: Scope, gaps: GapOperator, history: History) -> list[list[Event]]:
    """Events of each group of channels by itself that count in the window (`events_in`)."""
    every = np.concatenate([*groups, np.zeros(0, dtype=np.int64)])
    if not every.size:
        return [[] for _ in groups]
    names = [f"{k}" for k, channels in enumerate(groups) for _ in channels]
    only = replace(gaps.select(every), group=tuple(names))
    pressing = history.preload[every] if history.preload.size else history.preload
    own = replace(history, gap=history.gap[:, every], force=history.force[:, every], preload=pressing)
    v = scope.verification
    events = events_in(find_events(own, only, v.merge, v.f_max), scope.window)
    return [[e for e in events if e.group == f"{k}"] for k in range(len(groups))]


def channels_at(places: Sequence[Place], model: Mesh, gaps: GapOperator, history: History) -> list[IntArray]:
    """Channels that touch at each place in another run: of its contact, at its nodes or beside them."""
    from scipy.spatial import cKDTree  # see `signals.spectra.low_pass`

    touched = np.flatnonzero((history.force > 0.0).any(axis=0)).astype(np.int64)
    at, place = model.nodes.coords, np.full(gaps.m, -1)
    for contact in {p.contact for p in places}:
        here = touched[gaps.of_groups({contact})[touched]]
        own = [(k, p) for k, p in enumerate(places) if p.contact == contact]
        number = np.concatenate([np.full(p.nodes_idx.size, k) for k, p in own])
        away, nearest = cKDTree(at[np.concatenate([p.nodes_idx for _, p in own])]).query(at[gaps.nodes_idx[here]])
        place[here] = np.where(away <= near(model), number[nearest], -1)
    return [np.flatnonzero(place == k).astype(np.int64) for k in range(len(places))]


def _slips(run: Run, window: tuple[float, float], touched: IntArray, patch: IntArray) -> dict[int, list[SlipEvent]]:
    """Patch -> stick-slip events of its nodes, with those of their slips that begin in the window."""
    nodes, group = run.gaps.nodes_idx, run.gaps.group
    own: dict[int, list[SlipEvent]] = {}
    for slip in run.slips:
        here = np.flatnonzero(nodes[touched] == slip.node_idx)
        mine = [k for k in here.tolist() if group[int(touched[k])] == slip.group]
        begun = tuple(s for s in slip.slips if window[0] <= s[0] <= window[1])
        if mine and begun:
            own.setdefault(int(patch[mine[0]]), []).append(replace(slip, slips=begun))
    return own


def ranked(places: tuple[Place, ...], order: Sequence[int]) -> tuple[Place, ...]:
    """The same places in another order, numbered anew."""
    return tuple(replace(places[i], number=k) for k, i in enumerate(order, start=1))


def place_of(places: tuple[Place, ...], event: Event) -> Place | None:
    """The place at which the hardest channel of an event lies."""
    return next((p for p in places if p.contact == event.group and event.node_idx in p.nodes_idx), None)


def near(model: Mesh) -> float:
    """Distance up to which touched channels are neighbours, length."""
    return NEAR * float(np.linalg.norm(np.ptp(model.nodes.coords, axis=0)))


def _close(xyz: FloatArray, distance: float) -> IntArray:
    """(k, 2) pairs of points no further apart; points in one place included."""
    from scipy.spatial import cKDTree  # see `signals.spectra.low_pass`

    return cKDTree(xyz).query_pairs(distance * (1.0 + 1e-9), output_type="ndarray").astype(np.int64).reshape(-1, 2)


def _of_one_element(model: Mesh, nodes: IntArray) -> IntArray:
    """(k, 2) pairs of places in `nodes` whose nodes belong to one element."""
    row = np.full(model.nodes.count, -1, dtype=np.int64)
    row[nodes] = np.arange(nodes.size)
    pairs = [np.zeros((0, 2), dtype=np.int64)]
    for block in model.blocks:
        at = row[block.nodes_idx]
        for shift in range(1, at.shape[1]):
            both = np.stack([at, np.roll(at, shift, axis=1)], axis=-1)
            pairs.append(both[(both >= 0).all(axis=-1)])
    return np.concatenate(pairs)
