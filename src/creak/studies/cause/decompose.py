"""What moves a place at its peak: every mode under every excitation and every contact's own forces.

The reduced model is linear between its channels, so its motion is the sum of what each excitation makes of it alone and
of what each contact's forces make of it alone, mode by mode. Both are marched, or summed from impulse responses, by
themselves; the gap of the run is their sum. Modes and parts are told beyond what the supports carry along: the static
response q_s = -K^-1 K_qs s to where they are, which no mode has swung to.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from creak.arrays import ComplexArray, FloatArray, IntArray, to_dense
from creak.assembly.system import System
from creak.contact.gap_operator import GapOperator
from creak.dynamics.channels import ChannelMatrices, channel_matrices
from creak.dynamics.flow.march import SAMPLES, flows, form_of
from creak.dynamics.flow.resolution import Resolution, flow_steps
from creak.dynamics.history import History
from creak.dynamics.loads import Loads
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.state import LinearTerms
from creak.model.dofs import nodes_of
from creak.model.mesh import Model
from creak.signals.spectra import cell_means
from creak.studies.findings.places import Place
from creak.studies.prepare.marching import Marching
from creak.studies.prepare.reduction import Reduction
from creak.studies.run.integrate import integrate
from creak.studies.run.one_run import Run

EXCITATION, CONTACT, START, REST = "excitation", "contact", "start", "rest"
"""Kinds of sources: `START` is an initial velocity, `REST` what the record of the forces does not tell apart."""
Columns = dict[str, tuple[list[int], ...]]
"""Name of an excitation -> its columns of the loads' supports, and of their forces."""
CELL = 1e-5
"""s between the impulses that stand for a contact's forces."""
ROOT = 32
BLOCK = ROOT**2
"""Of them worked on at a time."""
FOLLOWS = 0.5
"""omega CELL from which a mode follows its force as a spring."""
STANDS = 1e-3
"""rad/s that a mode at rest counts as."""
UNHELD, ADRIFT = 1.5e-7, 0.1
"""Share of the highest omega, and rad/s, up to which that of a mode is round-off: no support holds it."""
CARRIED = "carried by the supports"
"""Beside the parts: what none of them moves."""


@dataclass(frozen=True)
class Source:
    """What one thing alone does to the gap at that instant, length."""

    kind: str
    name: str
    """Of the excitation, contact or connector."""
    modes: FloatArray
    """(n,) through each mode, beyond what the supports carry along."""
    direct: float = 0.0
    """Carried along by the supports: their own motion and the structure's static response to it."""

    @property
    def total(self) -> float:
        return float(self.modes.sum()) + self.direct


@dataclass(frozen=True)
class Cause:
    """The gap of the hardest hit channel of a place at the end of a flight step, pressed where there is such an end."""

    place: int
    """Its number."""
    channel: int
    time: float
    gap0: float
    """At rest."""
    gap: float
    """Of the run, then."""
    frequencies: FloatArray
    """(n,) of the modes, Hz; 0 of those that no support holds."""
    damping: FloatArray
    """(n,) share of critical; nan for rigid ones."""
    sources: tuple[Source, ...]
    parts: tuple[tuple[str, float], ...]
    """What the motion of each part beyond what the supports carry along does to the gap, by all sources together; last
    what they do carry along (`CARRIED`)."""

    @property
    def modes(self) -> FloatArray:
        """(n,) what each mode does to the gap, by all sources together."""
        return np.asarray(np.sum([s.modes for s in self.sources], axis=0))

    @property
    def total(self) -> float:
        """gap - gap0."""
        return sum(s.total for s in self.sources)


def find_causes(
    marching: Marching, reduction: Reduction, run: Run | None, places: Sequence[Place]
) -> tuple[Cause, ...] | str:
    """The cause of the hardest event of each place of the reduced run that shows one, or why none can be told.

    Parameters
    ----------
    run : None: it ended early.
    """
    if not places:
        return "nothing touches in the window"
    if run is None:
        return "the run ended early"
    if run.name != "reduced":
        return "only a reduced model has few enough modes"
    if not marching.table.exact:
        return "a scheme is forced"
    gaps, system, loads = run.gaps, run.system, marching.loads
    if not flows(system) or not np.all(np.asarray(system.M.diagonal()) > 0.0):
        return "the reduced model is too large for its modes, or some coordinates have no mass"
    flights = loads.time[::SAMPLES]
    chosen = [_instant(run.history, gaps, place, flights) for place in places]
    if not any(chosen):
        return (
            "at no end of a flight step in a contact was its gap narrower than at rest: it was over within a step, or "
            "pressed less than at rest"
        )
    steps = np.unique([step for _, step in filter(None, chosen)])
    seen = _Seen(loads, marching.resolution, system, gaps)
    march = partial(marched, marching, steps=steps)
    history, coordinates = _motion_at(run, steps, lambda: march(system, gaps, loads))
    columns = excitation_columns(reduction.structure.driven.names, list(reduction.driving.forcing))
    q = dict(zip(steps.tolist(), coordinates.T, strict=True))
    alone = _alone(march, loads, columns, system, gaps.without_force(), steps)
    groups = _touched_groups(gaps, run.history)
    found = []
    for place, instant in zip(places, chosen, strict=True):
        if instant is None:
            continue
        channel, step = instant
        row = int(_rows(history, flights[[step]])[0])
        own = {name: at_steps[step] for name, at_steps in alone.items()}
        sources = _sources(seen, own, groups, history, row, q[step], channel)
        support = loads.support[0, SAMPLES * step]
        found.append(
            Cause(
                place=place.number,
                channel=channel,
                time=float(history.time[row]),
                gap0=float(gaps.gap0[channel]),
                gap=float(history.gap[row, channel]),
                frequencies=seen.frequencies,
                damping=seen.damping,
                sources=_with_supports(columns, seen, sources, support, channel),
                parts=seen.of_parts(reduction.structure.model, channel, q[step], support),
            )
        )
    return tuple(found)


def _motion_at(run: Run, steps: IntArray, again: Callable[[], History]) -> tuple[History, FloatArray]:
    """The run's history and its coordinates (n, k) at whole steps, of the run itself where it has kept them."""
    kept = run.at_contact
    if kept is not None and np.isin(steps, kept.steps).all():
        return run.history, kept.coordinates[:, np.searchsorted(kept.steps, steps)]
    history = again()
    return history, history.coordinates


def _instant(history: History, gaps: GapOperator, place: Place, flights: FloatArray) -> tuple[int, int] | None:
    """A channel of a place and the flight step at whose end its motion is told; None where no such end shows a closing.

    It is the hardest pressed channel of the hardest event, and of the ends inside the event at which it presses the one
    nearest to its peak; where it presses at none, of the ends in and around the event that with the smallest gap. Where
    the gap is wider there than at rest, as before a channel under preload closes again, it is the next hardest event.
    """
    for event in sorted(place.events, key=lambda e: -e.force_place):
        # The hardest pressed channel of a place in an event, and when.
        rows = np.flatnonzero((history.time >= event.t_start) & (history.time <= event.t_end))
        force = history.force[np.ix_(rows, place.channels)]
        row, column = np.unravel_index(int(force.argmax()), force.shape)
        channel, peak = int(place.channels[column]), float(history.time[rows[row]])
        inside = np.flatnonzero((flights >= event.t_start) & (flights <= event.t_end))
        inside = inside[history.force[_rows(history, flights[inside]), channel] > 0.0]
        first = max(0, int(np.searchsorted(flights, event.t_start, side="right")) - 1)
        around = np.arange(first, min(int(np.searchsorted(flights, event.t_end)) + 1, flights.size))
        around = around[np.argsort(history.gap[_rows(history, flights[around]), channel], kind="stable")]
        for step in [*inside[np.argsort(np.abs(flights[inside] - peak))].tolist(), *around.tolist()]:
            if history.gap[_rows(history, flights[[step]])[0], channel] <= gaps.gap0[channel]:
                return channel, step
    return None


def _rows(history: History, times: FloatArray) -> IntArray:
    """Rows of the history nearest to some times."""
    after = np.clip(np.searchsorted(history.time, times), 1, history.time.size - 1)
    return after - (times - history.time[after - 1] < history.time[after] - times)


def marched(marching: Marching, system: System, gaps: GapOperator, loads: Loads, steps: IntArray) -> History:
    """A run through some loads with the coordinates at the ends of these flight steps."""
    none, every = np.zeros(0, dtype=np.int64), max(1, loads.n_step // SAMPLES)
    return integrate(replace(marching, loads=loads), system, gaps, OutputRequest(none, every, steps))[0]


def _alone(
    march: Callable[[System, GapOperator, Loads], History],
    loads: Loads,
    columns: Columns,
    system: System,
    silent: GapOperator,
    steps: IntArray,
) -> dict[tuple[str, str], dict[int, FloatArray]]:
    """(kind, name) -> coordinates at the steps, of each excitation alone and of the initial velocity."""
    still = replace(system, velocity=np.zeros(system.n)) if system.velocity.any() else system

    def of(what: System, some: Loads) -> dict[int, FloatArray]:
        found = march(what, silent, some).coordinates.T
        return dict(zip(steps.tolist(), found, strict=True))

    zero = replace(loads, support=np.zeros_like(loads.support), force=np.zeros_like(loads.force))
    out = {}
    for name, (supports, forces) in columns.items():
        support, force = zero.support.copy(), zero.force.copy()
        support[:, :, supports], force[:, forces] = loads.support[:, :, supports], loads.force[:, forces]
        out[EXCITATION, name] = of(still, replace(loads, support=support, force=force))
    if system.velocity.any():
        out[START, "initial velocity"] = of(system, zero)
    return out


def excitation_columns(moved: Sequence[str], forces: Sequence[str]) -> Columns:
    """Name -> columns of the loads' supports and forces, given the names of either in their order."""
    every = dict.fromkeys([*moved, *forces])
    return {name: tuple([j for j, n in enumerate(some) if n == name] for some in (moved, forces)) for name in every}


def _touched_groups(gaps: GapOperator, history: History) -> dict[str, IntArray]:
    """Contact or connector that pressed at all -> its channels."""
    pressed = (history.force > 0.0).any(axis=0)
    group = np.array(gaps.group, dtype=object)
    return {name: np.flatnonzero(group == name) for name in dict.fromkeys(group[pressed].tolist())}


class _Seen:
    """The channels as the march sees them, and the modes."""

    def __init__(self, loads: Loads, resolution: Resolution, system: System, gaps: GapOperator) -> None:
        self.system, self.gaps = system, gaps
        m, self.k = (np.asarray(A.diagonal(), dtype=float) for A in (system.M, system.K))
        on: ChannelMatrices = channel_matrices(system, gaps)
        form = form_of(system, on, LinearTerms(system, loads), gaps)
        steps = flow_steps(form, gaps.laws, SAMPLES * loads.step, resolution)
        self.filter = steps.mollifier
        every = to_dense(on.rows)
        self.rows = every * self.filter
        omega = np.sqrt(self.k / m)
        held = omega > np.minimum(ADRIFT, UNHELD * omega.max(initial=0.0))
        self.ride = np.zeros((omega.size, system.supports.count))
        self.ride[held] = -to_dense(system.supports.K_qs)[held] / self.k[held, None]
        self.rows_s = on.G_s + every[: gaps.m] @ self.ride  # what is filtered is carried, too: `flow.model.filtered`
        self.frequencies = np.where(held, omega, 0.0) / (2.0 * np.pi)
        with np.errstate(divide="ignore", invalid="ignore"):
            self.damping = np.where(held, form.damping / (2.0 * omega), np.nan)
        self._pairs, self._mass, zero = form.pairs, m, np.zeros_like(m)
        single = [zero, zero + 1.0, -(omega**2), -form.damping]
        self.blocks = np.stack(single) if form.pairs is None else form.pairs.blocks
        """(4, n) z' = B z of pairs; of single modes (q, q')"""

    def pushed(self, channels: IntArray) -> Sequence[FloatArray]:
        """(k, n) what unit forces on channels add to the rates of both members of each pair."""
        X = self.rows[channels]
        return (0.0 * X, X / self._mass) if self._pairs is None else np.hsplit(X @ self._pairs.push.T, 2)

    def coordinates(self, z: FloatArray) -> FloatArray:
        """(n,) of pairs z (2, n)."""
        return z[0] if self._pairs is None else np.asarray(self._pairs.basis @ z.ravel())

    def of_parts(self, model: Model, channel: int, q: FloatArray, s: FloatArray) -> tuple[tuple[str, float], ...]:
        """What the motion of each part does to a gap beyond what the supports carry along, and that."""
        row = self.gaps.G[[channel]].tocoo()
        labels, value = self.gaps.labels[row.col], row.data
        each = value * (to_dense(self.system.rows(labels)[0]) @ (self.filter * (q - self.ride @ s)))
        node, found = nodes_of(labels), {}
        for i, part in enumerate(model.parts):
            mine = np.isin(node, part.nodes_idx)
            if mine.any():
                found[model.parts[i].name] = float(each[mine].sum())
                each = np.where(mine, 0.0, each)
        if each.any():
            found["no part"] = float(each.sum())
        if self.rows_s[channel].any():
            found[CARRIED] = float(self.rows_s[channel] @ s)
        return tuple(found.items())


def _sources(
    seen: _Seen,
    alone: dict[tuple[str, str], FloatArray],
    groups: dict[str, IntArray],
    history: History,
    row: int,
    q: FloatArray,
    channel: int,
) -> list[Source]:
    X = seen.rows[channel]
    found = [Source(kind, name, X * own) for (kind, name), own in alone.items()]
    of_contact = q - np.sum([*alone.values(), np.zeros_like(q)], axis=0)
    if len(groups) == 1:
        return [*found, Source(CONTACT, next(iter(groups)), X * of_contact)]
    for name, channels in groups.items():
        own = _pushed(seen, history, row, channels)
        of_contact = of_contact - own
        found.append(Source(CONTACT, name, X * own))
    return [*found, Source(REST, "not told apart", X * of_contact)]


def _pushed(seen: _Seen, history: History, row: int, channels: IntArray) -> FloatArray:
    """(n,) coordinates that forces of these channels alone have brought about at a row: a sum of impulse responses.

    The forces act as impulses every `CELL`, which keep theirs; modes too fast for that follow them as springs.
    """
    gaps, time = seen.gaps, history.time[: row + 1]
    rubs = np.zeros(0, dtype=np.int64) if gaps.friction is None else gaps.friction.channels
    along = np.flatnonzero(np.repeat(np.isin(rubs, channels), 2))
    columns = np.concatenate([channels, gaps.m + along]).astype(np.int64)
    count = math.ceil((time[-1] - time[0]) / CELL)
    at = np.maximum(time[-1] - CELL * np.arange(count, -1, -1), time[0])
    force = np.hstack([history.force[: row + 1, channels], history.tangential[: row + 1, along]])
    force = cell_means(time, force, at) - gaps.resting[columns]
    pushed = seen.pushed(columns)
    a, b, c, d = seen.blocks
    h = 0.5 * (a + d)
    # exp(B t) is half the sum of e^((h + r) t) (1 + (B - h) / r) and of the same with -r for r: its conjugate where r
    # is imaginary.
    root = np.sqrt((h**2 - a * d + b * c).astype(complex))
    root[np.abs(root) < STANDS] = STANDS
    turns = root.real == 0.0
    z = np.zeros((2, h.size))
    for r, own in ((root, np.full_like(turns, True)), (-root, ~turns)):
        share, r, mean = np.where(turns[own], 1.0, 0.5), r[own], h[own]
        first, second = (_grown(force, X[:, own], mean + r) for X in pushed)
        z[0, own] += share * (first + ((a[own] - mean) * first + b[own] * second) / r).real
        z[1, own] += share * (second + (c[own] * first + (d[own] - mean) * second) / r).real
    return seen.coordinates(z)


def _grown(force: FloatArray, X: FloatArray, pole: ComplexArray) -> ComplexArray:
    """(n,) what forces at the cells have brought about of x' = pole x + X' f; what is fast follows the last of them."""
    if not X.any():
        return np.zeros(pole.size, dtype=complex)
    slow = np.abs(pole) * CELL <= FOLLOWS
    found = (force[-1] @ X) / -np.where(slow, 1.0, pole)
    halved = force.copy()
    halved[[0, -1]] *= 0.5  # half a cell
    found[slow] = CELL * _summed(halved, X[:, slow], pole[slow])
    return np.asarray(found)


def _summed(force: FloatArray, X: FloatArray, pole: ComplexArray) -> ComplexArray:
    """(n,) sum over the cells of X' f(t) exp(pole (end - t)), block by block."""
    few, many = (np.exp(np.outer(CELL * step * np.arange(ROOT), pole)) for step in (1, ROOT))
    within = (many[:, None] * few).reshape(BLOCK, -1)[::-1]
    parts = within.real.copy(), within.imag.copy()
    over, found = np.exp(BLOCK * CELL * pole), np.zeros(pole.size, dtype=complex)
    padded = np.vstack([np.zeros((-force.shape[0] % BLOCK, force.shape[1])), force])
    for block in padded.reshape(-1, BLOCK, force.shape[1]):
        found *= over
        acts = np.flatnonzero(block.any(axis=1))
        if acts.size:
            those = slice(acts[0], acts[-1] + 1)
            real, imag = (((block[those].T @ of[those]) * X).sum(axis=0) for of in parts)
            found += real + 1j * imag
    return found


def _with_supports(
    columns: Columns, seen: _Seen, sources: list[Source], support: FloatArray, channel: int
) -> tuple[Source, ...]:
    """Each excitation with the share that its supports carry along, which its modes then have not."""

    def of(source: Source) -> Source:
        if source.kind != EXCITATION:
            return source
        own = columns[source.name][0]
        carried, ride = seen.rows_s[channel, own] @ support[own], seen.ride[:, own] @ support[own]
        return replace(source, modes=source.modes - seen.rows[channel] * ride, direct=float(carried))

    return tuple(of(source) for source in sources)
