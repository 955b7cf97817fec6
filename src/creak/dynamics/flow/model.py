"""A System as exact flow sees it: single coordinates or pairs of them that move by themselves between contacts.

The state z (2 n) holds n pairs. In a diagonal System a pair is displacement and velocity of a mode; in one whose
damping couples modes it belongs to a pair of complex modes (`flow.coupled`). Compiled code sees both through rows on
slices of z: `rows` give gaps from z[u0:u1], `rates` their rates from z[v0:v1], and forces act on z[p0:p1] by `push`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray, to_dense
from creak.contact.gap_operator import GapOperator
from creak.dynamics.books import SIZE
from creak.dynamics.channels import ChannelMatrices
from creak.dynamics.flow.propagator import SINGLE, UV, in_kicks, propagator
from creak.dynamics.loads import Loads
from creak.dynamics.state import LinearTerms
from creak.linalg.complex_modes import ComplexModes

ACCELERATION, VELOCITY, DISPLACEMENT, FORCE, CONSTANT = 2, 1, 0, 3, 4
"""What drives a load column."""
DONE, NOT_FINITE = 0, -1
"""How a chunk of steps ends; other codes are those of the contact solver."""


class FlowModel(NamedTuple):
    """Arrays of a System for compiled code."""

    u0: int
    u1: int
    v0: int
    v1: int
    p0: int
    p1: int
    rows: FloatArray
    """(m + 2 f, u1 - u0)"""
    rates: FloatArray
    """(m + 2 f, v1 - v0)"""
    push: FloatArray
    """(m + 2 f, p1 - p0) of kicks"""
    lean: FloatArray
    """(m + 2 f, p1 - p0) of forces that go on"""
    thrown: FloatArray
    """(m + 2 f, p1 - p0) of z in the middle of kicks that do not change, beyond that under forces that go on"""
    rows_s: FloatArray
    """(m + 2 f, n_support) of displacements"""
    rates_s: FloatArray
    """(m + 2 f, n_support) of rates; so kicks push the supports"""
    lean_s: FloatArray
    """(m + 2 f, n_support) what forces that go on push of the supports"""
    give: FloatArray
    """(2 f,) compliance by which a channel that sticks takes up a change of its force (`along.GIVE`)"""
    gap0: FloatArray
    preload: FloatArray
    presses: bool
    damped: bool
    load: FloatArray
    """(n_x, p1 - p0) what each load column of amplitude 1 does."""
    load_u: FloatArray
    load_v: FloatArray
    """(n_x, u1 - u0), (n_x, v1 - v0): displacement and velocity that the loads work on."""
    order: IntArray
    """(n_x,) what drives a load column: a derivative of the supports, a force, or nothing (constant)."""
    column: IntArray
    """(n_x,) which support or force."""
    M_ss: FloatArray
    C_ss: FloatArray
    K_ss: FloatArray
    support: FloatArray
    """(3, n_instant, n_support) samples."""
    force: FloatArray
    """(n_instant, n_force)"""
    m: FloatArray
    c: FloatArray
    k: FloatArray
    """(n,) of single modes; 1, 0 and 0 for pairs."""
    slow: FloatArray
    """(n,) 1 / omega^2 of each pair, 0 where it does not oscillate."""
    massless: IntArray
    """Single modes whose m is 0."""
    still: FloatArray
    """(4, n) z at rest under loads, pair by pair, of loads on the pair; empty for single modes."""


class FlowState(NamedTuple):
    """Everything that is known at one instant."""

    x: FloatArray
    """(2, n): z"""
    F: FloatArray
    """(p1 - p0,) channel forces on the coordinates."""
    force: FloatArray
    """(m + 2 f,)"""
    weighed: FloatArray
    """(m + 2 f,) times the shares of half a kick."""
    mean: FloatArray
    """(m + 2 f,) over both halves of the kick, with their shares: what is written, and keeps the impulse."""
    gap: FloatArray
    rate: FloatArray
    """(m + 2 f,) of gaps and along the rubbing channels; after `press` that in the middle of the kick."""
    drift: FloatArray
    """(m,) what the motion between the last two kicks changed of the rates of closed gaps."""
    before: FloatArray
    """(m,) gaps one step near contact before; infinite after any other step."""
    sliding: FloatArray
    """(2 f,) slip velocity."""
    place: FloatArray
    """(2 f,) where what presses and rubs is to be a step near contact later; infinite after any other step."""
    slip: FloatArray
    slid: FloatArray
    """(2 f,) how far it slides in that step, and did in the step before, as `place` was found."""
    stuck: BoolArray
    support: FloatArray
    """(3, n_support)"""
    amplitude: FloatArray
    dots: FloatArray
    """(2, n_x) load columns times displacement; those of accelerations times velocity."""
    energy: FloatArray
    """The book (`books`)."""


@dataclass(frozen=True)
class FlowForm:
    """A System for exact flow, before its channels are filtered."""

    model: FlowModel
    rows: FloatArray
    """(m + 2 f, n) of all channels on the coordinates of the System: its modes without damping."""
    omega: FloatArray
    """(n,) speed of each pair, rad/s: bound of |z'| / |z|; 0 where motion is a polynomial of time."""
    omega2: FloatArray
    """(n,) squares of the frequencies of the modes."""
    damping: FloatArray
    """(n,) of each mode by itself over its mass, 1 / time."""
    root: FloatArray
    """(n,) 1 / sqrt(mass) of each mode, 0 where it has none: mobility of the channels W = (rows root) (rows root)'."""
    flow: Callable[[float], FloatArray]
    """Propagator of a step: (15, n) as `propagator`, or (40, n) of pairs: exponential, then four integrals of it, and
    the mean of all five over the step."""
    start: Callable[[FloatArray, FloatArray], FloatArray]
    """z (2, n) of coordinates and their velocities."""
    follow: FloatArray
    """(n, n_support) of the modes where they follow the supports at rest."""
    pairs: ComplexModes | None = None
    """Where these are no single modes."""

    def motion(self, x: FlowState) -> tuple[FloatArray, FloatArray]:
        """(n,) coordinates of the System at an instant, and their velocities."""
        z = x.x.ravel()
        if self.pairs is None:
            return x.x[0].copy(), x.x[1].copy()
        return np.asarray(self.pairs.basis @ z), np.asarray(self.pairs.speeds @ z)

    def ways(self, rows: FloatArray) -> FloatArray:
        """(k, n) how far a pair of energy 1/2 moves what is seen by these rows (k, n) on the modes."""
        moves = self.omega > 0.0
        if self.pairs is None:
            return np.asarray(
                np.abs(rows) * np.where(moves, self.root / np.sqrt(np.where(moves, self.omega2, 1.0)), 0.0)
            )
        return np.asarray(np.hypot(*np.hsplit(rows @ self.pairs.basis, 2)) * moves)

    def rates(self, rows: FloatArray) -> FloatArray:
        """(k, n) how fast it does."""
        if self.pairs is None:
            return np.asarray(np.abs(rows) * self.root)
        return np.asarray(np.hypot(*np.hsplit(rows @ self.pairs.speeds, 2)))


Shared = dict[str, Any]
"""Fields of a FlowModel that are the same whatever its pairs are."""
Three = tuple[FloatArray, FloatArray, FloatArray]


def single_modes(
    m: FloatArray, c: FloatArray, k: FloatArray, on: ChannelMatrices, terms: LinearTerms, gaps: GapOperator
) -> FlowForm:
    """A diagonal System."""
    rows, loads, shared = driven(on, terms, gaps)
    n, heavy = m.size, m > 0.0
    mass = np.where(heavy, m, 1.0)
    omega, own = np.sqrt(np.where(heavy, k / mass, 0.0)), np.where(heavy, c / mass, 0.0)
    speed = np.where(omega > 0.0, np.hypot(omega, 0.5 * own) + 0.5 * own, 0.0)
    slices = ((0, n), (n, 2 * n), (n, 2 * n))
    model = flow_model(shared, slices, (rows,) * 3, (loads,) * 3, (m, c, k), speed, np.zeros((0, 0)))
    root = np.where(heavy, 1.0 / np.sqrt(mass), 0.0)

    def start(u: FloatArray, v: FloatArray) -> FloatArray:
        return np.stack([u, v])

    flow = partial(propagator, m, c, k)
    return FlowForm(model, rows, speed, omega**2, own, root, flow, start, following(terms))


def following(terms: LinearTerms) -> FloatArray:
    """(n, n_support) modal coordinates that follow the supports at rest, -K_qs / K; 0 where nothing holds them."""
    k = np.asarray(terms.system.K.diagonal(), dtype=np.float64)
    held = k > 0.0
    return np.asarray(np.where(held, -1.0 / np.where(held, k, 1.0), 0.0)[:, None] * terms.on_all(terms.K_qs))


def driven(on: ChannelMatrices, terms: LinearTerms, gaps: GapOperator) -> tuple[FloatArray, FloatArray, Shared]:
    """Rows (m + 2 f, n) of all channels, load columns (n_x, n) without those that are zero, and what is shared."""
    sup, preload = terms.system.supports, np.zeros(gaps.m) if gaps.preload is None else gaps.preload
    blocks = [
        (ACCELERATION, terms.on_all(-terms.M_qs)),
        (VELOCITY, terms.on_all(-terms.C_qs)),
        (DISPLACEMENT, terms.on_all(-terms.K_qs)),
        (FORCE, terms.on_all(terms.B)),
        (CONSTANT, -np.column_stack([np.asarray(on.G.T @ preload), np.asarray(on.T.T @ gaps.resting[gaps.m :])])),
    ]
    columns = [(order, j, A[:, j]) for order, A in blocks for j in range(A.shape[1]) if A[:, j].any()]
    loads = np.array([x for _, _, x in columns]) if columns else np.zeros((0, terms.system.n))
    rows = np.ascontiguousarray(np.vstack([to_dense(on.G), to_dense(on.T)]), dtype=np.float64)
    sampled = {
        "M_ss": sup.M_ss,
        "C_ss": terms.C_ss,
        "K_ss": sup.K_ss,
        "support": terms.loads.support,
        "force": terms.loads.force,
    }
    rows_s = np.ascontiguousarray(np.vstack([on.G_s, on.T_s]))
    shared = {name: np.ascontiguousarray(A, dtype=float) for name, A in sampled.items()} | {
        "rows_s": rows_s,
        "rates_s": rows_s,
        "lean_s": rows_s,
        "give": np.zeros(rows.shape[0] - gaps.m),
        "gap0": gaps.gap0.astype(float),
        "preload": preload,
        "presses": bool(gaps.presses),
        "damped": bool(gaps.damping.any()),
        "order": np.array([o for o, _, _ in columns], dtype=np.int64),
        "column": np.array([j for _, j, _ in columns], dtype=np.int64),
    }
    return rows, loads, shared


def flow_model(
    shared: Shared,
    slices: tuple[tuple[int, int], tuple[int, int], tuple[int, int]],
    rows: Three,
    loads: Three,
    single: Three,
    omega: FloatArray,
    still: FloatArray,
) -> FlowModel:
    """The model from what is shared, slices, rows and load columns (u, v, push; push, u, v), m, c, k, speeds."""
    (u0, u1), (v0, v1), (p0, p1) = slices
    arrays = zip(
        ("rows", "rates", "push", "lean", "thrown", "load", "load_u", "load_v", "still"),
        (*rows, rows[2], 0.0 * rows[2], *loads, still),
        strict=True,
    )
    own: Shared = {name: np.ascontiguousarray(A) for name, A in arrays}
    own |= {name: np.ascontiguousarray(A, dtype=float) for name, A in zip("mck", single, strict=True)}
    own |= {"slow": np.where(omega > 0.0, 1.0 / np.where(omega > 0.0, omega, 1.0) ** 2, 0.0)}
    return FlowModel(
        u0=u0, u1=u1, v0=v0, v1=v1, p0=p0, p1=p1, massless=np.flatnonzero(single[0] <= 0.0), **own, **shared
    )


def filtered(form: FlowForm, mollifier: FloatArray, h: float, rest: FloatArray) -> FlowModel:
    """The model whose channels see and push the pairs through the filter (n,), as does what balances them at rest.

    A kick works h v on a pair of speed v; the springs see half of its way from the kick before to the kick after,
    v sin(omega h) / omega. So a pair is pushed by sin(omega h) / (omega h) less than it is seen, and gets what the
    springs give; else it would get (omega h)^2 / 6 more, out of nothing. Kicks that do not change hold it, at their
    instants, by `in_kicks` of what they push away from where they do not act: by that share it is pushed by
    forces that go on, so that long steps and kicks rest at the same place. Of damping what each mode has by itself
    counts.

    Of what the filter takes off a gap, the modes have a part in common with the supports that carry them: where these
    move slowly beside the modes that are filtered, these follow them at rest (`FlowForm.follow`). That part is given to
    the supports, which take its share of the force as well. Else a stop on the support that the part stands on would
    open and close with the way of both, and what sticks on a part that is carried along would creep: of a speed that
    no kick makes, sin(omega h) / (omega h) is missing as well. Modes that damping couples are filtered one by one as
    well, before they are seen in pairs: a kick on half of an overdamped mode would move it backwards.

    Parameters
    ----------
    h : step near contact, s. rest : (m + 2 f,) channel forces at rest.

    Friction does not push coordinates without mass: they follow the others and the loads at once, and the sides that
    rub follow them. Left out is what they give to friction alone, as the rotation of a shell's node whose neighbours
    are retained too: some .3 / (E t), a part of what the node itself gives in plane.
    """
    model, x = form.model, np.sqrt(form.omega2) * h
    seen = form.rows * mollifier
    sees = mollifier > 0.0
    still, throw = np.ones(x.size), np.zeros(x.size)
    still[sees], throw[sees] = in_kicks(form.damping[sees], form.omega2[sees], h)
    slow = seen * np.sinc(x / np.pi)
    going, thrown = slow * still, slow * throw * form.root**2
    on_modes = {"rows_s": seen, "rates_s": slow, "lean_s": going.copy()}
    rows, rates, push, lean = seen, slow, slow.copy(), going
    if form.pairs is not None:
        to_z = form.pairs.push.T
        rows, rates, push, lean = seen @ form.pairs.basis, slow @ form.pairs.speeds, slow @ to_z, going @ to_z
        thrown = slow * throw @ to_z
    m, constant = model.gap0.size, model.order == CONSTANT
    push[m:, model.massless] = lean[m:, model.massless] = 0.0
    load, load_u, load_v = model.load.copy(), model.load_u.copy(), model.load_v.copy()
    for j in np.flatnonzero(constant):
        those = slice(0, m) if model.column[j] == 0 else slice(m, rest.size)
        load[j], load_u[j], load_v[j] = (
            -rest[those] @ lean[those],
            -rest[those] @ rows[those],
            -rest[those] @ rates[those],
        )
    of_z = {"rows": rows, "rates": rates, "push": push, "lean": lean, "thrown": thrown}
    of_supports = {name: model.rows_s + (form.rows - A) @ form.follow for name, A in on_modes.items()}
    own: Shared = {name: np.ascontiguousarray(A) for name, A in (of_z | of_supports).items()}
    return model._replace(load=load, load_u=load_u, load_v=load_v, **own)


def moved_by(P: FloatArray, pushes: FloatArray) -> FloatArray:
    """(k, u1 - u0) of z at the end of a step, propagator P, that begins with changes (k, p1 - p0) of z."""
    if P.shape[0] == SINGLE:
        return np.asarray(P[UV] * pushes)
    first, second = np.hsplit(pushes, 2)
    return np.hstack([P[0] * first + P[1] * second, P[2] * first + P[3] * second])


def amplitudes(model: FlowModel, rows: slice) -> FloatArray:
    """(n_x, k) of each load column at samples of the loads."""
    found = np.ones((model.order.size, rows.stop - rows.start))
    for j, (order, column) in enumerate(zip(model.order.tolist(), model.column.tolist(), strict=True)):
        if order == FORCE:
            found[j] = model.force[rows, column]
        elif order != CONSTANT:
            found[j] = model.support[order, rows, column]
    return found


def at_start(form: FlowForm, model: FlowModel, terms: LinearTerms) -> FloatArray:
    """z (2, n) with the System's initial velocity; coordinates without mass follow their load at once."""
    z, light = form.start(terms.inside_at_rest(0), terms.system.velocity + terms.inside_at_rest(1)), model.massless
    if light.size:
        z[1, light] = 0.0
        z[0, light] = (model.load.T @ amplitudes(model, slice(0, 1))[:, 0])[light] / model.k[light]
    return z


def resting(model: FlowModel, loads: Loads) -> FlowState:
    """An instant at rest without supports' motion."""
    n, channels, m = model.m.size, model.rows.shape[0], model.gap0.size
    n_s, n_x, f2 = loads.support.shape[2], model.order.size, channels - m
    return FlowState(
        np.zeros((2, n)),
        np.zeros(model.p1 - model.p0),
        np.zeros(channels),
        np.zeros(channels),
        np.zeros(channels),
        np.zeros(m),
        np.zeros(channels),
        np.zeros(m),
        np.full(m, np.inf),
        np.zeros(f2),
        np.full(f2, np.inf),
        np.zeros(f2),
        np.zeros(f2),
        np.ones(f2 // 2, dtype=np.bool_),
        np.zeros((3, n_s)),
        np.zeros(n_x),
        np.zeros((2, n_x)),
        np.zeros(SIZE),
    )
