"""What the draws of a study say: odds of rattle, spreads, causes, needed gaps and the load that is borne."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from creak.arrays import BoolArray, FloatArray, IntArray
from creak.studies.robust.changes import drawn_setup
from creak.studies.robust.draws import Cause, Draw, whole_power
from creak.studies.robust.further import NOW, depth, forecast
from creak.studies.robust.job import Draws
from creak.studies.robust.linear import FACTORS
from creak.studies.robust.shared_model import CREATED, FAILED, FIGURES, FORETOLD, LEFT_OUT
from creak.studies.warned import Warned, warnings_of
from creak.verify.odds import Index, Odds, counted, ends, odds, shift_needed, sobol_index, spread, with_forecast
from creak.verify.reliability import CONTACT_BAR, ENERGY_BAR, UNRELIABLE
from creak.words import listed, percent

SHOWN = ("rattle", "events", "impulse", "force")
"""Figures of which causes are told: whether it rattles anywhere, then sums, and the largest force."""
ENOUGH, FEW, MORE = 10, 0.1, 64
"""Draws that rattle, below which Sobol indices are left out, and more draws advised where at most this share has to be
marched, and how many times as many."""
LARGEST = 1_000_000_000
"""Bytes of all draws that are asked for so."""
NO_DRAWS = odds(0, 0)
OF_GAPS = ("contact.", "connector.", "clip.")
"""What the gaps of channels depend on."""
EVEN = 1e-9
"""Spread of the gaps of a place up to which they are one number."""
QUARTERS = (0.25, 0.75)
"""Of what is drawn of a number: gaps that differ between them move with it."""


@dataclass(frozen=True)
class PlaceFindings:
    """Of one contact or connector."""

    name: str
    rattle: Odds
    events: Mapping[str, float]
    impulse: Mapping[str, float]
    force: Mapping[str, float]
    """Spreads over the draws (`verify.odds.spread`)."""
    need: Need | None
    fragility: tuple[Odds, ...] | None
    """Odds of contact with the load times each of `FACTORS`; None: channels press from the start."""
    before: Odds = NO_DRAWS
    """That it touches before the window."""
    before_alone: Odds = NO_DRAWS
    """That it does, and not in the window."""


@dataclass(frozen=True)
class Robustness:
    """What `creak robust` found."""

    draws: Draws
    rattle: Odds
    """Anywhere."""
    places: tuple[PlaceFindings, ...]
    node_odds: FloatArray
    """(n_channel,) share of draws in which each channel touches."""
    node_impulse: FloatArray
    """(n_channel,) mean impulse."""
    indices: Mapping[str, Mapping[str, Index]]
    """Figure -> cause -> its Sobol indices; a figure that does not vary is not there."""
    tornado: Mapping[str, Mapping[str, tuple[float, float]]]
    """Figure -> cause -> mean over the draws with the lowest and the highest quarter of its values."""
    notes: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """Plain data: what robust.json holds."""
        d = self.draws
        gaps, nodes = d.channels, d.setup.model.nodes
        return {
            "title": d.setup.study.config.title,
            "units": d.setup.study.config.model.units,
            "draws": d.design.n,
            "runs": d.design.total,
            "marched": d.marched,
            "taken_from_before": d.taken,
            "failed": int(np.count_nonzero(_states(d) == FAILED)),
            "unreliable": int(np.count_nonzero((_states(d) == CREATED) | (_states(d) == LEFT_OUT))),
            "seed": d.design.seed,
            "reduced_again": list(d.reduced_again),
            "causes": [{"key": c.key, "type": c.of.type, "nominal": _known(c.nominal)} for c in d.design.causes],
            "window": list(d.setup.marching.window),
            "rattle": asdict(self.rattle),
            "places": [_place(p) for p in self.places],
            "factors": list(FACTORS),
            "nodes": [
                {
                    "channel": gaps.names[k],
                    "node": nodes.label(int(gaps.nodes_idx[k])),
                    "probability": float(self.node_odds[k]),
                    "impulse_mean": float(self.node_impulse[k]),
                }
                for k in range(gaps.m)
            ],
            "indices": {f: {key: asdict(i) for key, i in of.items()} for f, of in self.indices.items()},
            "tornado": {f: {key: list(pair) for key, pair in of.items()} for f, of in self.tornado.items()},
            "warnings": warnings_of(self.notes),
        }


def find(draws: Draws) -> Robustness:
    """Sum up all draws; those that failed count nowhere, and are told."""
    n, design = draws.design.n, draws.design
    well = draws.state[:n] != FAILED
    impulse = draws.impulse[:n][well]
    totals = _totals(draws)
    gaps = own_gaps(draws)
    places = tuple(_of_place(draws, k, well, gaps) for k in range(len(draws.places)))
    indices: dict[str, Mapping[str, Index]] = {}
    like = _forecasts(draws)
    for name, column in totals.items() if design.indices else ():
        of = {c.key: _index(draws, k, column, like.get(name)) for k, c in enumerate(design.causes)}
        if all(index is not None for index in of.values()):
            indices[name] = {key: index for key, index in of.items() if index is not None}
    values = draws.drawn.means()
    ordered = {c.key: values[c.key][:n][well] for c in design.causes if c.of.type != "seed"}
    indices, few = _valid(indices, totals["rattle"][:n][well])
    tornado = {
        name: {key: ends(cause, column[:n][well]) for key, cause in ordered.items()} for name, column in totals.items()
    }
    rattle = _rattle(draws, totals["rattle"][:n] > 0.0, well, None)
    return Robustness(
        draws,
        rattle,
        places,
        (impulse > 0.0).mean(axis=0) if len(impulse) else np.zeros(draws.channels.m),
        impulse.mean(axis=0) if len(impulse) else np.zeros(draws.channels.m),
        indices,
        tornado if well.any() else {},
        (*draws.notes, *_notes(draws), *_unlike(places), *_built_up(places, draws), *few, *_more(rattle, draws)),
    )


def _forecasts(draws: Draws) -> dict[str, tuple[FloatArray, FloatArray]]:
    """What is like each of `SHOWN` without contact, of the draws and of the further ones: whether gaps close, and how
    far they would. Nothing where it is not known of each."""
    if draws.further is None or not np.isfinite(draws.slack[draws.state != FAILED]).all():
        return {}
    deep = depth(draws.slack), depth(draws.further.slack)
    closes = (deep[0] > 0.0).astype(float), (deep[1] > 0.0).astype(float)
    return {name: closes if name == "rattle" else deep for name in SHOWN}


def _index(draws: Draws, cause: int, column: FloatArray, like: tuple[FloatArray, FloatArray] | None) -> Index | None:
    """Of a figure (total,), by what is like it of the same draws and of the further ones."""
    own = draws.design.blocks(column, cause)
    if draws.further is None or like is None:
        return sobol_index(own)
    here, many = like
    return sobol_index(own, draws.design.blocks(here, cause), draws.further.design.blocks(many, cause))


def _valid(
    indices: Mapping[str, Mapping[str, Index]], rattle: FloatArray
) -> tuple[dict[str, Mapping[str, Index]], list[str]]:
    """Indices whose bounds hold (`verify.odds.sobol_index`), and a note on those that are left out.

    Parameters
    ----------
    rattle : (n,) 1 of each draw that rattles, else 0. Where few do, all figures hang on these few.
    """
    n, hits = rattle.size, int(np.count_nonzero(rattle))
    few = {name: min(hits, n - hits) if name == "rattle" else hits for name in indices}
    left_out = [name for name, count in few.items() if count < ENOUGH]
    if not left_out:
        return dict(indices), []
    more = whole_power(2 * ENOUGH * n // max(few[left_out[0]], 1))
    note = (
        f"Sobol indices of {listed(left_out)} are left out: {hits} of {n} draws rattle, and the bounds of the indices "
        f"hold where {ENOUGH} do"
        + (f" and {ENOUGH} do not" if "rattle" in left_out else "")
        + f". --n {more} should be enough"
    )
    return {name: of for name, of in indices.items() if name not in left_out}, [note]


def _totals(draws: Draws) -> dict[str, FloatArray]:
    """(total,) each of `SHOWN`."""
    at = {name: draws.figures[:, :, k] for k, name in enumerate(FIGURES)}
    events = at["events"].sum(axis=1)
    rattle = np.where(np.isfinite(events), events > 0.0, np.nan)
    columns = (rattle, events, at["impulse"].sum(axis=1), at["force"].max(axis=1))
    return dict(zip(SHOWN, columns, strict=True))


def _of_place(draws: Draws, k: int, well: BoolArray, gaps: OwnGaps) -> PlaceFindings:
    n, name = draws.design.n, draws.places[k]
    figures, slack = draws.figures[:n][well][:, k], draws.slack[:n][well][:, k]
    spreads = {f: spread(figures[:, j]) for j, f in enumerate(FIGURES)}
    before, inside = figures[:, FIGURES.index("before")] > 0.0, figures[:, FIGURES.index("events")] > 0.0
    need, fragility = None, None
    if slack.size and np.isfinite(slack).all():
        slack = slack if draws.further is None else draws.further.slack[: draws.further.design.n, k]
        target = draws.setup.study.config.scatter.target
        need = gaps.need(draws.channels.of_groups({name}), slack[:, NOW], target)
        fragility = tuple(counted(slack[:, j] < 0.0) for j in range(len(FACTORS)))
    rattle = _rattle(draws, draws.figures[:n, k, 0] > 0.0, well, k)
    early = counted(before), counted(before & ~inside)
    return PlaceFindings(name, rattle, spreads["events"], spreads["impulse"], spreads["force"], need, fragility, *early)


def _rattle(draws: Draws, hit: BoolArray, well: BoolArray, place: int | None) -> Odds:
    """Odds that a place rattles, or any (None), by what the draws came to and the forecast of further ones."""
    n, slack, further = len(hit), draws.slack[: len(hit)][well], draws.further
    if further is None or further.events is None or not np.isfinite(slack).all():
        return counted(hit[well])
    here = forecast(draws.state[:n][well] != FORETOLD, slack, place)
    events = further.events.sum(axis=1) if place is None else further.events[:, place]
    done = np.isfinite(events)
    return with_forecast(hit[well], here, further.forecast(place), further.rows[done], events[done] > 0.0)


def _notes(draws: Draws) -> list[str]:
    """What went wrong in runs, those of further draws among them."""
    states = _states(draws)
    failed, left, created = (int(np.count_nonzero(states == which)) for which in (FAILED, LEFT_OUT, CREATED))
    notes: list[str] = []
    if failed:
        notes.append(Warned(f"{failed} of {states.size} runs did not reach their end and count nowhere"))
    if left:
        notes.append(
            Warned(
                f"in {left} of {states.size} runs a channel closed that the pre-check had left out: raise [precheck] "
                "margin, or set its enabled = false"
            )
        )
    if created:
        notes.append(
            Warned(
                f"{created} of {states.size} runs are {UNRELIABLE}: the time integration created more energy than "
                f"{percent(ENERGY_BAR)} of the work of the loads or {percent(CONTACT_BAR)} of what contact took up. "
                "They count, as they touch, but their impulses and forces are worth nothing: soften the contact or "
                "dissipate more"
            )
        )
    return notes


def _states(draws: Draws) -> FloatArray:
    """(n,) of all runs."""
    more = None if draws.further is None else draws.further.state
    return draws.state if more is None else np.concatenate([draws.state, more])


def _unlike(places: Sequence[PlaceFindings]) -> list[str]:
    """Places that hit more often, or less, than the motion without contact in the window reaches them."""
    apart = [(p, p.fragility[NOW]) for p in places if p.fragility is not None]
    return [
        Warned(
            f"{p.name} rattles in {percent(p.rattle.p)} of the draws; its motion without contact in the window alone "
            f"reaches it in {percent(linear.p)}: what hits before, or elsewhere, changes the motion. Gap and curve "
            "leave that out: run the study with the gap that is told"
        )
        for p, linear in apart
        if not p.rattle.low <= linear.p <= p.rattle.high
    ]


def _built_up(places: Sequence[PlaceFindings], draws: Draws) -> list[str]:
    """Places whose odds lie above their bounds with the draws that touch before the window alone."""
    start = draws.setup.marching.window[0]
    return [
        Warned(
            f"{p.name} is hit before {start:.4g} s, as the motion builds up, in {percent(p.before.p)} of all draws, in "
            f"{percent(p.before_alone.p)} of all then alone: the odds leave these out, as what touches later counts. "
            "If the build-up matters, too, look at the events of a run"
        )
        for p in places
        if p.rattle.p + p.before_alone.p > p.rattle.high
    ]


def _more(rattle: Odds, draws: Draws) -> list[str]:
    """Where few draws rattle and most need no march, more of them cost little."""
    kept = draws.slack[0].size + draws.figures[0].size + draws.impulse[0].size
    n = min(MORE * rattle.n, whole_power(LARGEST // (16 * kept)))
    known = rattle.foretold and rattle.high - rattle.low <= rattle.p
    if rattle.hits >= ENOUGH or known or draws.marched > FEW * draws.design.total or n < 2 * rattle.n:
        return []
    return [
        f"{rattle.hits} of {rattle.n} draws rattle, which tells little of the odds. Nearly all others cannot touch and "
        f"cost next to nothing: --n {n} --no-indices tells more"
    ]


def _place(p: PlaceFindings) -> dict[str, Any]:
    need = None
    if p.need is not None:
        numbers = {key: _known(value) for key, value in asdict(p.need).items() if key != "numbers"}
        need = {**numbers, "numbers": dict(p.need.numbers)}
    return {
        "name": p.name,
        "rattle": asdict(p.rattle),
        "before": asdict(p.before),
        "before_alone": asdict(p.before_alone),
        "events": dict(p.events),
        "impulse": dict(p.impulse),
        "force": dict(p.force),
        "need": need,
        "fragility": None if p.fragility is None else [asdict(o) for o in p.fragility],
    }


def _known(value: float | None) -> float | None:
    return value if value is not None and np.isfinite(value) else None


@dataclass(frozen=True)
class Need:
    """What the gap of a place has to be for a probability at most."""

    target: float
    shift: float
    """Added to every gap that is drawn: each distribution moves as a whole."""
    low: float
    high: float
    """Bounds of 95 %; infinite where the draws are too few."""
    gap: float | None
    """That of the study's own number (the mean of a distribution that gives one) with the shift. None: the place has
    more than one gap, or the number does more than move its distribution: uniform, lognormal, relative."""
    numbers: Mapping[str, float] = field(default_factory=dict)
    """Key -> number that the study has to say: its own (or `mean`) and `low` and `high` of a truncated or uniform
    distribution. The shift is taken off where a gap grows as the number falls: `lower` of a stop."""


@dataclass(frozen=True)
class OwnGaps:
    """Gaps of all channels by the numbers about which they scatter, and what moves them."""

    gaps: FloatArray
    """(m,)"""
    moved: tuple[tuple[Cause, IntArray], ...]
    """Causes, and (m,) 1 or -1 where the gap of a channel grows or shrinks as the cause does, else 0."""

    def need(self, own: BoolArray, slack: FloatArray, target: float) -> Need:
        """That of a place with the channels `own` (m,), from its slack (n,) without contact.

        Its gaps all grow by the shift s with P(slack + s < 0) = target (`verify.odds.shift_needed`).
        """
        shift, low, high = shift_needed(slack, target)
        gaps, causes = self.gaps[own], [(cause, signs[own]) for cause, signs in self.moved if signs[own].any()]
        one = gaps.size and np.ptp(gaps) <= EVEN * abs(float(gaps.max())) and all(c.moves_whole for c, _ in causes)
        numbers = dict[str, float]()
        for cause, signs in causes if np.isfinite(shift) else ():
            if np.unique(signs[signs != 0]).size == 1:
                numbers |= _shifted(cause, float(signs[signs != 0][0]) * shift)
        return Need(target, shift, low, high, float(gaps.mean()) + shift if one else None, numbers)


def _shifted(cause: Cause, by: float) -> dict[str, float]:
    """Key -> number of a distribution that is moved as a whole, as the study has it."""
    of = cause.of
    if of.relative:
        return {}
    own = {f"{cause.key}.mean": of.mean} if of.mean is not None else {cause.key: cause.nominal}
    told = {**(own if cause.moves_whole else {}), f"{cause.key}.low": of.low, f"{cause.key}.high": of.high}
    return {key: x + by for key, x in told.items() if x is not None and np.isfinite(x)}


def own_gaps(draws: Draws) -> OwnGaps:
    """Of the study that was drawn."""
    values, fields, of_numbers = dict[str, Any](), dict[str, FloatArray](), list[Cause]()
    moved = list[tuple[Cause, IntArray]]()
    for cause in draws.design.causes:
        if cause.mean is not None:
            fields[cause.contact] = cause.mean
            moved.append((cause, draws.channels.of_groups({cause.contact}).astype(np.int64)))
        elif cause.key.startswith(OF_GAPS) and cause.key not in draws.reduced_again and not cause.is_factor:
            values[cause.key] = cause.number(cause.about)
            of_numbers.append(cause)
    for cause in of_numbers:
        low, high = (_gaps(draws, {**values, cause.key: cause.number(cause.at(q))}, fields) for q in QUARTERS)
        moved.append((cause, np.sign(high - low).astype(np.int64)))
    return OwnGaps(_gaps(draws, values, fields), tuple(moved))


def _gaps(draws: Draws, values: dict[str, Any], fields: dict[str, FloatArray]) -> FloatArray:
    setup = drawn_setup(draws.setup, Draw(0, values, fields))
    return np.concatenate([setup.contacts.gap0, setup.connectors.gap0])
