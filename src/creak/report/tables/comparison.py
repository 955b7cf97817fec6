"""Two results side by side: settings, figures of the whole run, places, events, relative motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from creak.errors import InputError
from creak.model.units import UNITS, Units
from creak.studies.findings.summary import summary_of
from creak.studies.findings.tree import Findings
from creak.studies.run.compared import main_of
from creak.studies.sweep.figures import OF_A_PLACE, friction_of
from creak.verify.events import Event
from creak.verify.matching import EventMatch, match_events

NOT_SETTINGS = ("title", "output")
"""Tables of a study that change no answer."""
CONTENT = {"content of the deck": "deck_sha256", "content of the other files": "files_sha256"}
"""What a study names but does not hold -> its digest in the identity of a run."""
DIGITS = 12
"""Of a digest that is shown."""
AXES = "xyz"
Value = float | str | None


@dataclass(frozen=True)
class Side:
    """One of the two results."""

    name: str
    found: Findings

    @cached_property
    def summary(self) -> Mapping[str, Any]:
        """Of what was found."""
        return summary_of(self.found)

    @property
    def run(self) -> Mapping[str, Any]:
        """Of the summary: the reduced run, or the only one."""
        return main_of(self.summary)

    @property
    def events(self) -> list[Event]:
        return [] if self.found.main is None else self.found.main.events


@dataclass(frozen=True)
class Setting:
    """A key of the study, or the content of its files, that the two do not share; None: it is absent."""

    key: str
    a: Any
    b: Any


@dataclass(frozen=True)
class Figure:
    """One number of both, or what friction does, a word; None: it is not known."""

    name: str
    unit: str
    a: Value
    b: Value

    @property
    def change(self) -> float | None:
        """b / a - 1; None where that is no number."""
        if not isinstance(self.a, int | float) or not isinstance(self.b, int | float) or self.a == 0.0:
            return None
        return self.b / self.a - 1.0


@dataclass(frozen=True)
class PlacePair:
    """A place of the first result, the second, or both: places of a contact that share nodes are one."""

    name: str
    contact: str
    figures: tuple[Figure, ...]


@dataclass(frozen=True)
class Comparison:
    """What two results have in common, and what not."""

    a: Side
    b: Side
    units: Units
    settings: tuple[Setting, ...]
    figures: tuple[Figure, ...]
    places: tuple[PlacePair, ...]
    events: EventMatch
    """Those of `a` are the reference, those of `b` its partners."""
    tolerance: float
    """s within which events that start are the same."""

    def as_dict(self) -> dict[str, Any]:
        """As plain numbers, for JSON."""
        return {
            "a": _side(self.a),
            "b": _side(self.b),
            "settings": [{"key": s.key, "a": s.a, "b": s.b} for s in self.settings],
            "figures": {f.name: _figure(f) for f in self.figures},
            "places": [
                {"name": p.name, "contact": p.contact, "figures": {f.name: _figure(f) for f in p.figures}}
                for p in self.places
            ],
            "events": {
                "both": len(self.events.pairs),
                "only_a": len(self.events.missed),
                "only_b": len(self.events.extra),
                "force_ratio_mean": self.events.amplitude_ratio_mean,
                "impulse_ratio_mean": self.events.impulse_ratio_mean,
            },
        }


def compare_results(a: Side, b: Side) -> Comparison:
    """Put two results side by side.

    Raises
    ------
    InputError : they are in different units, or one of them ended before it had a run.
    """
    for side in (a, b):
        if side.found.main is None:
            raise InputError(f"{side.name} holds no run", fix="Run the study again.")
    one, other = (s.found.setup.study.config.model.units for s in (a, b))
    if one != other:
        raise InputError(
            f"{a.name} is in {one}, {b.name} in {other}", expected="results in the same units", where="[model] units"
        )
    units = UNITS[one]
    tolerance = a.found.setup.study.config.verification.event_tolerance
    return Comparison(
        a,
        b,
        units,
        tuple(_settings(a.found, b.found)),
        (*_whole(a, b, units), *_motion(a, b, units)),
        tuple(_places(a, b, units)),
        match_events(a.events, b.events, tolerance, (0.0, math.inf)),
        tolerance,
    )


def _settings(a: Findings, b: Findings) -> Iterator[Setting]:
    tables = [s.setup.study.config.model_dump(mode="json") for s in (a, b)]
    one, other = (dict(_flat({k: v for k, v in t.items() if k not in NOT_SETTINGS})) for t in tables)
    for key in dict.fromkeys([*one, *other]):
        if one.get(key) != other.get(key):
            yield Setting(key, one.get(key), other.get(key))
    for name, field in CONTENT.items():
        first, second = (getattr(s.identity, field) for s in (a, b))
        if first != second:
            yield Setting(name, *(f"SHA-256 {x[:DIGITS]}" if x else None for x in (first, second)))


def _flat(value: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    rows = isinstance(value, list) and all(isinstance(row, Mapping) for row in value)  # as [[clip]]
    if rows or (isinstance(value, Mapping) and value):
        for name, inner in enumerate(value) if rows else value.items():
            yield from _flat(inner, f"{key}.{name}" if key else str(name))
    else:
        yield key, value


def _whole(a: Side, b: Side, units: Units) -> Iterator[Figure]:
    """Of the whole run."""
    values: list[tuple[str, str, Callable[[Side], float | None]]] = [
        ("simulated time", "s", lambda s: s.run.get("end")),
        ("events", "", lambda s: float(len(s.events))),
        ("events per second", "1/s", lambda s: len(s.events) / s.run["end"] if s.run.get("end") else None),
        ("impulse", units.impulse, lambda s: s.run.get("impulse_total")),
        ("largest force of a place", units.force, lambda s: max((e.force_place for e in s.events), default=0.0)),
        ("median force of a place", units.force, lambda s: _median(e.force_place for e in s.events)),
        ("median impulse of an event", units.impulse, lambda s: _median(e.impulse for e in s.events)),
        ("highest closing speed", units.speed, lambda s: max((e.closing_speed for e in s.events), default=0.0)),
    ]
    for name, unit, of in values:
        yield Figure(name, unit, of(a), of(b))
    yield from _friction(a, b, units)
    contacts = dict.fromkeys([*a.found.contacts, *b.found.contacts])
    for contact in contacts:
        yield Figure(f"smallest gap, {contact}", units.length, _closest(a, contact), _closest(b, contact))


def _friction(a: Side, b: Side, units: Units) -> Iterator[Figure]:
    """Of the place or resting patch that rubs most, and of the whole run; nothing where neither rubs."""
    names = {
        "rubbing_place": ("hardest rub", ""),
        "friction": ("friction there", ""),
        "slips": ("slips there", ""),
        "slip_rate": ("slip rate there", "1/s"),
        "slip_path": ("slip path there", units.length),
        "friction_energy": ("friction energy there", units.energy),
        "stick_slip_events": ("stick-slip events", ""),
        "friction_energy_total": ("friction energy", units.energy),
    }
    one, other = friction_of(a.run), friction_of(b.run)
    for key, (name, unit) in names.items():
        if one[key] is not None or other[key] is not None:
            yield Figure(name, unit, _value(one[key]), _value(other[key]))


def _value(x: Any) -> Value:
    return x if x is None or isinstance(x, str) else float(x)


def _closest(side: Side, contact: str) -> float | None:
    run = side.found.main
    if run is None or contact not in side.found.contacts or not run.closest.size:
        return None
    return float(run.closest[:, side.found.contacts.index(contact)].min())


def _motion(a: Side, b: Side, units: Units) -> Iterator[Figure]:
    """Relative motion of the verification pairs, rms of the pair that moves most, below [verification] f_max."""
    for i, axis in enumerate(AXES):
        one, other = _rms(a.found, i), _rms(b.found, i)
        if one is not None or other is not None:
            yield Figure(f"relative motion {axis}, rms", units.length, one, other)


def _rms(found: Findings, axis: int) -> float | None:
    run = found.main
    lines = None if found.spectra is None or run is None else found.spectra.spectra.get(run.name)
    if lines is None or not lines.size:
        return None
    return float(np.sqrt(0.5 * (np.abs(lines[:, :, axis]) ** 2).sum(axis=0)).max())


def _places(a: Side, b: Side, units: Units) -> Iterator[PlacePair]:
    """The places of `a` with their partners, then those that only `b` has; what is no place in one may rest there."""
    left, resting = ([dict(p) for p in b.run.get(key, [])] for key in ("places", "resting"))
    for place in a.run.get("places", []):
        yield _pair(place, _taken(place, left) or _taken(place, resting), units)
    resting = [dict(p) for p in a.run.get("resting", [])]
    for place in left:
        yield _pair(_taken(place, resting), place, units)


def _taken(place: Mapping[str, Any], others: list[dict[str, Any]]) -> dict[str, Any] | None:
    """The one of a contact that shares most nodes with a place, taken out of the others; None: none does."""
    shared = [len(set(place["nodes"]) & set(p["nodes"])) if p["contact"] == place["contact"] else 0 for p in others]
    best = int(np.argmax(shared)) if shared else -1
    return others.pop(best) if best >= 0 and shared[best] else None


def _pair(one: Mapping[str, Any] | None, other: Mapping[str, Any] | None, units: Units) -> PlacePair:
    known = next(p for p in (one, other) if p is not None and "name" in p)
    kinds = {
        "events": "",
        "force": units.force,
        "impulse": units.impulse,
        "closing_speed": units.speed,
        "n5": "sone",
        **dict.fromkeys(OF_A_PLACE, ""),
        "slip_rate": "1/s",
        "slip_path": units.length,
        "friction_energy": units.energy,
    }
    rubs = any(p is not None and p["friction"] is not None for p in (one, other))
    figures = []
    for key, unit in kinds.items():
        if key in OF_A_PLACE and not rubs:
            continue
        values = [(p or {}).get(key, 0.0 if key in ("events", "impulse") else None) for p in (one, other)]
        if key not in ("n5", *OF_A_PLACE) or any(v is not None for v in values):
            figures.append(Figure(key, unit, *map(_value, values)))
    return PlacePair(str(known["name"]), str(known["contact"]), tuple(figures))


def _median(values: Iterator[float]) -> float | None:
    known = list(values)
    return float(np.median(known)) if known else None


def _side(side: Side) -> dict[str, Any]:
    return {
        "name": side.name,
        "title": side.summary.get("title"),
        "run": side.summary.get("run"),
        "verdict": side.run.get("verdict"),
        "reasons": side.run.get("reasons"),
    }


def _figure(f: Figure) -> dict[str, Value]:
    return {"a": _known(f.a), "b": _known(f.b), "change": _known(f.change)}


def _known(x: Value) -> Value:
    return x if isinstance(x, str) or (x is not None and math.isfinite(x)) else None
